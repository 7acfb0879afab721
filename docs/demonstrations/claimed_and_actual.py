"""
Claimed and actual errors
=========================

Numerical results are often called exact because they agree with a closed form in one case. This program shows solutions of random
problems of eleven kinds by pymdr next to references that share no code with pymdr. Every point shows the claimed and the actual
error of one quantity of one problem. ``python -m tests.accuracy --quick --count 1100 --folder out`` and
``python -m benchmarks.accuracy --folder out docs/demonstrations/claimed_and_actual.csv`` repeat the study.
"""

from pathlib import Path

import matplotlib.style
import numpy as np
from matplotlib import rcParams
from matplotlib.figure import Figure

matplotlib.style.use("pymdr.figures")

try:
    here = Path(__file__).parent
except NameError:  # run by a documentation builder
    here = Path.cwd()
file = here / "claimed_and_actual.csv"
with file.open(encoding="utf-8") as lines:
    print(next(lines).lstrip("# ").strip())
study = np.genfromtxt(file, delimiter=",", names=True, dtype=None, encoding="utf-8", skip_header=1)

claimed, actual, rounding = study["claimed"], study["actual"], study["rounding"]
outside = actual > 1.01 * (10 * claimed + rounding)  # the table has three digits
print(f"{study.size} values, {outside.sum()} of them above 10 times their claim plus rounding")
assert study.size > 1000
assert not outside.any()
assert np.mean(actual <= claimed + 1e-14) > 0.8

# %%
# Claims below 1e-17 are drawn there, and so are errors. Exact numbers are to the left of 1e-9. A radius may err by more than 1e-14 where the
# depth hardly depends on it, and so may a pressure near the edge of the contact: rounding the depth moves the edge. Outside the profiles
# 1e-9 and the error of the reference are allowed in addition. These points may be above the shaded part.
smallest, largest = 1e-17, 1.0
x, y = np.clip(claimed, smallest, largest), np.clip(actual, smallest, largest)
line = np.geomspace(smallest, largest, 200)

figure = Figure(figsize=(7.2, 4.6), layout="constrained")
axes = figure.subplots()
axes.axvspan(smallest, 1e-9, color="#009E73", alpha=0.08, lw=0)
axes.fill_between(line, smallest, 10 * line + 1e-14, color="0.5", alpha=0.15, lw=0, label="allowed")
names = {"closures": "force curves", "plane": "shifts in the plane"}
kinds = dict.fromkeys(study["kind"].tolist())
colours = rcParams["axes.prop_cycle"].by_key()["color"]
for i, kind in enumerate(kinds):
    some, marker = study["kind"] == kind, "o^"[i // len(colours)]
    style = {"color": colours[(i + 2 * (i // len(colours))) % len(colours)], "ms": 3, "mew": 0, "alpha": 0.7}
    axes.plot(x[some], y[some], marker, label=names.get(kind, kind), **style)
axes.plot(line, line, "k", lw=0.8, label="actual = claimed")
axes.set_xscale("log")
axes.set_yscale("log")
axes.set_xlim(0.5 * smallest, 2.0 * largest)  # markers at the ends are whole
axes.set_ylim(0.5 * smallest, 2.0 * largest)
axes.set_xlabel("claimed relative error")
axes.set_ylabel("actual relative error")
axes.text(1.2e-9, 0.1, "approximate", fontsize=9)
axes.text(0.8e-9, 0.1, "exact", fontsize=9, ha="right", color="#009E73")
axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), markerscale=2)
