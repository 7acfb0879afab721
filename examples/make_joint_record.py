"""
Make the measured record of the examples
========================================

What a test rig for joints would record: load, shift and tangential force of a steel ball of 10 mm on steel with friction 0.3
at 50 N, shaken by 0.6 um four times. The force is Mindlin's with Masing's branches, in closed form, and has Gaussian noise
with a standard deviation of 0.05 N, that of NumPy's default generator with seed 11.
"""

from pathlib import Path

import numpy as np

load, friction, radius, young, poisson = 50.0, 0.3, 10e-3, 210e9, 0.3
modulus = young / (1.0 - poisson**2) / 2.0
tangential = young / (2.0 * (1.0 + poisson)) / (2.0 - poisson) * 2.0
depth = (9.0 * load**2 / (16.0 * modulus**2 * radius)) ** (1.0 / 3.0)
slides = friction * modulus / tangential * depth


def first(u):
    """Mindlin's force of the first loading."""
    return friction * load * (1.0 - np.clip(1.0 - u / slides, 0.0, 1.0) ** 1.5)


time = np.arange(401) * 1e-3
phase = 4.0 * time / 0.1
shift = 0.6e-6 * np.sin(0.5 * np.pi * phase)
top = 0.6e-6
down = first(top) - 2.0 * first((top - shift) / 2.0)
up = -first(top) + 2.0 * first((top + shift) / 2.0)
force = np.where(phase <= 1.0, first(shift), np.where((phase - 1.0) % 4.0 <= 2.0, down, up))
noisy = force + 0.05 * np.random.default_rng(11).standard_normal(time.size)

rows = [f"{t:.3f},50.0,{u * 1e6:.6f},{f:.4f}" for t, u, f in zip(time, shift, noisy, strict=True)]
head = "# joint under test: made by make_joint_record.py, which states formula and noise\n"
text = head + "time [s],load [N],shift [um],tangential force [N]\n" + "\n".join(rows) + "\n"
try:
    here = Path(__file__).parent
except NameError:  # run by a documentation builder
    here = Path.cwd()
target = here / "data" / "joint_record.csv"
if not target.exists():
    target.write_text(text)

assert abs(float(target.read_text().splitlines()[-1].split(",")[3]) - noisy[-1]) < 1e-4
