"""
Errors that are claimed and errors that are made
================================================

Numerical results are often called exact because they agree with a closed form in one case. Here are random profiles,
solved by pymdr and held against quadrature in extended precision that shares no code with it. Every point is a quantity of one
profile: the error that its claim carries, and the one that it has. The study is made anew by
``python -m benchmarks.accuracy docs/demonstrations/claimed_and_actual.csv``.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

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
print(f"{study.size} values, {outside.sum()} of them farther off than 10 times their claim and rounding")
assert not outside.any()

# %%
# Claims of 0 are those of closed forms. What is exact lies to the left of 1e-9. Radii may be off by more than 1e-14 where the
# depth hardly depends on them, so that rounding it moves them.
smallest = 1e-17
x, y = np.maximum(claimed, smallest), np.maximum(actual, smallest)
line = np.geomspace(smallest, max(1e-3, 2 * x.max()), 200)

figure = Figure(figsize=(7.2, 4.6), layout="constrained")
axes = figure.subplots()
axes.axvspan(smallest, 1e-9, color="#009E73", alpha=0.08, lw=0)
axes.fill_between(line, smallest, 10 * line + 1e-14, color="0.5", alpha=0.15, lw=0, label="allowed")
for quantity in dict.fromkeys(study["quantity"].tolist()):
    some = study["quantity"] == quantity
    axes.plot(x[some], y[some], ".", ms=4, alpha=0.6, label=quantity.replace("_", " "))
axes.plot(line, line, "k", lw=0.8, label="actual = claimed")
axes.set_xscale("log")
axes.set_yscale("log")
axes.set_xlim(smallest, line[-1])
axes.set_ylim(smallest, line[-1])
axes.set_xlabel("claimed relative error")
axes.set_ylabel("actual relative error")
axes.text(1.2e-9, 2e-17, "approximate", fontsize=9)
axes.text(0.8e-9, 2e-17, "exact", fontsize=9, ha="right", color="#009E73")
axes.legend(loc="upper left", fontsize=8, frameon=False)
