"""
Make the indent of the examples
===============================

An indent of a Berkovich tip in fused silica, as an instrument would record it: loading, a hold and unloading from the largest force
F = H A(h_c), with hardness H = 9 GPa, contact depth h_c = 200 nm and area A(h) = 24.5 h^2 + 900 nm h. The unloading is the power law
of exponent m = 1.35 whose stiffness at the peak is S = 2 E_r sqrt(A/pi), with 72 GPa and Poisson's ratio 0.17 of the silica and a diamond tip. The
depth contains the deflection of a frame of 0.4 nm/mN. Gaussian noise of 1 uN and 0.1 nm is that of NumPy's default generator with seed 28.
"""

from math import gamma, pi, sqrt
from pathlib import Path

import numpy as np

DEPTH, HARDNESS, EXPONENT, FRAME = 200e-9, 9e9, 1.35, 0.4e-6
area = 24.5 * DEPTH**2 + 900e-9 * DEPTH
reduced = 1.0 / ((1.0 - 0.17**2) / 72e9 + (1.0 - 0.07**2) / 1141e9)
largest, stiffness = HARDNESS * area, 2.0 * reduced * sqrt(area / pi)
# Oliver and Pharr (2004), from the effective shape of the unloading
half = 0.5 / (EXPONENT - 1.0)
epsilon = EXPONENT * (1.0 - 2.0 * gamma(half * EXPONENT) / (sqrt(pi) * gamma(half)) * (EXPONENT - 1.0))
peak = DEPTH + epsilon * largest / stiffness

part = np.concatenate([np.linspace(0.0, 1.0, 150), np.ones(30), np.linspace(1.0, 0.0, 150)])
depth = peak - EXPONENT * largest / stiffness * (1.0 - part ** (1.0 / EXPONENT))
depth[:150] = peak * np.sqrt(part[:150])
rng = np.random.default_rng(28)
force = largest * part + 1e-6 * rng.standard_normal(part.size)
depth += FRAME * largest * part + 1e-10 * rng.standard_normal(part.size)

rows = [f"{1e9 * h:.2f},{1e3 * f:.4f}" for h, f in zip(depth, force, strict=True)]
text = "# indent in fused silica: made by make_silica_indent.py, which states formulas and noise\ndepth [nm],load [mN]\n"
try:
    here = Path(__file__).parent
except NameError:  # run by a documentation builder
    here = Path.cwd()
target = here / "data" / "silica_indent.csv"
if not target.exists():
    target.write_text(text + "\n".join(rows) + "\n")

assert abs(epsilon - 0.765215) < 1e-6
assert abs(float(target.read_text().splitlines()[152].split(",")[1]) / (1e3 * force[150]) - 1) < 1e-4
