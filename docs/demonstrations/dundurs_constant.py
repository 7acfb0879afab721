"""
Dundurs' constant
=================

The constant named after Dundurs in Argatov's discussion lacks the factor 1/2 and has (1 - 2 nu) in place of (1 - nu) in the
denominator. Both constants vanish together, so the test for elastic similarity is unaffected. Its value is wrong: for steel on aluminium
-0.117 instead of -0.446.
"""

import matplotlib.style
import numpy as np
from matplotlib.figure import Figure

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

steel = mdr.Elastic("210 GPa", 0.30)
aluminium = mdr.Elastic("70 GPa", 0.33)
beta = mdr.effective_moduli(steel, aluminium).dundurs_beta

a, b = ((1 - 2 * m.poisson) / m.shear for m in (steel, aluminium))
printed = (a - b) / (a + b)
print(f"beta = {beta:.3f}, as printed {printed:.3f}")

assert abs(beta + 0.1167) < 1e-4
assert abs(printed + 0.446) < 1e-3
assert mdr.effective_moduli(steel, steel).similar

# %%
# Both vanish at the same Poisson's ratio of the second body, and differ everywhere else.
ratios = np.linspace(0.0, 0.5, 51)
pairs = [(steel, mdr.Elastic("70 GPa", float(nu))) for nu in ratios]
standard = [mdr.effective_moduli(*pair).dundurs_beta for pair in pairs]
as_printed = []
for pair in pairs:
    a, b = ((1 - 2 * m.poisson) / m.shear for m in pair)
    as_printed.append((a - b) / (a + b))

figure = Figure(figsize=(6, 3.4), layout="constrained")
axes = figure.subplots()
axes.plot(ratios, standard, label="Dundurs' beta")
axes.plot(ratios, as_printed, "--", label="as printed")
axes.axhline(0.0, color="k", lw=0.8)
axes.set_xlabel("Poisson's ratio of the second body")
axes.set_ylabel("constant for steel on a 70 GPa body")
axes.legend()
