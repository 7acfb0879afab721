"""
How data/rough_curve.csv was made
=================================

Five caps of different height and radius, anywhere on a square, are pressed between two elastic bodies, by boundary elements on
24 x 24 cells. Noise of 0.3 % of the largest force is added. The same cells with friction give the numbers for comparison
in `rough_joint.py`.
"""

from pathlib import Path

import numpy as np

import pymdr as mdr
from pymdr.independent.sliding.following import solve_pressure, solve_tractions
from pymdr.independent.sliding.surface import make_surface

cells, mu = 24, 0.4
body = mdr.Elastic("2 GPa", 0.0)
surface = make_surface(1e-3, cells, body, body)
cell = surface.side**2
x, y = np.meshgrid(surface.x, surface.x, indexing="ij")
rng = np.random.default_rng(3)
gap = np.full(x.shape, np.inf)
for _ in range(5):
    x0, y0 = rng.uniform(-0.6e-3, 0.6e-3, 2)
    height, radius = rng.uniform(0, 1.5e-6), rng.uniform(0.05, 0.2)
    gap = np.minimum(gap, height + ((x - x0) ** 2 + (y - y0) ** 2) / (2 * radius))
gap -= gap.min()

depth, force, pressure = np.linspace(0, 4e-6, 201)[1:], [], np.zeros(gap.shape)
for d in depth:
    pressure = solve_pressure(surface, gap, float(d), pressure)
    force.append(cell * pressure.sum())
noisy = np.array(force) + 3e-3 * force[-1] * rng.standard_normal(depth.size)

# %%
# A shift of 0.3 um at a depth of 2.5 um, there and back:
pressure = solve_pressure(surface, gap, 2.5e-6, np.zeros(gap.shape))
tractions = moved = np.zeros((2, *gap.shape))
tangential_forces = []
for step in (0.3e-6, -0.6e-6):
    wanted = moved + np.array([step, 0.0])[:, None, None]
    tractions = solve_tractions(surface, wanted, mu * pressure, tractions)
    moved = surface.tangential_displacement(tractions)
    tangential_forces.append(cell * tractions[0].sum())
print(
    f"normal force {cell * pressure.sum():.6g} N, tangential forces {tangential_forces[0]:.6g} N and {tangential_forces[1]:.6g} N"
)
assert abs(tangential_forces[0] + tangential_forces[1]) < 1e-6 * tangential_forces[0]

try:
    here = Path(__file__).parent
except NameError:  # run by a documentation builder
    here = Path.cwd()
text = "# five caps on a square: made by make_rough_curve.py\ndepth [um],force [mN]\n"
text += "".join(f"{1e6 * d:.4f},{1e3 * f:.5f}\n" for d, f in zip(depth, noisy, strict=True))
target = here / "data" / "rough_curve.csv"
if not target.exists():
    target.write_text(text)
