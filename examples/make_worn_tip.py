"""
Make the sampled tip of the examples
====================================

A worn indenter tip as an instrument would give it: the azimuthal mean of f(r) = t (sqrt(r^2 + c^2) - c) with
slope t = 0.36 and tip size c = 40 nm, at 61 radii up to 300 nm, with Gaussian noise whose standard deviation
0.15 nm + 1 % of f is given as scatter. The noise is that of NumPy's default generator with seed 7.
"""

from pathlib import Path

import numpy as np

r = np.linspace(0.0, 300.0, 61)  # nm
f = 0.36 * (np.hypot(r, 40.0) - 40.0)
scatter = np.where(r > 0.0, 0.15 + 0.01 * f, 0.0)
noisy = f + scatter * np.random.default_rng(7).standard_normal(r.size) / 4.0

rows = [f"{a:.3f},{b:.5f},{s:.5f}" for a, b, s in zip(r, noisy, scatter, strict=True)]
text = "# worn tip: made by make_worn_tip.py, which states formula and noise\nr [nm],f [nm],scatter [nm]\n"
try:
    here = Path(__file__).parent
except NameError:  # run by a documentation builder
    here = Path.cwd()
target = here / "data" / "worn_tip.csv"
if not target.exists():
    target.write_text(text + "\n".join(rows) + "\n")

assert abs(float(target.read_text().splitlines()[-1].split(",")[1]) / noisy[-1] - 1) < 1e-4
