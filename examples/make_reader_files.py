"""
Make the measured files of the pages for readers
================================================

Three tables as instruments export them, from closed forms and NumPy's default generator with seed 5: a force curve of a colloidal
tip on a gel, the elastic loading of fused silica by a diamond ball, and a frequency sweep of rubber in shear. Formulas and noise are
stated in the code.
"""

from pathlib import Path

import numpy as np

rng = np.random.default_rng(5)

# Hertz on a cantilever: F = 4/3 E* R^(1/2) d^(3/2) and travel = d + F/k; E* = 30 kPa / 0.75, R = 5 um, k = 0.05 N/m
depth = np.linspace(-1e-6, 0.4e-6, 200)
hertz = 4 / 3 * 30e3 / 0.75 * np.sqrt(5e-6) * np.maximum(depth, 0.0) ** 1.5
travel = depth + hertz / 0.05 + 4e-6  # the piezo counts from somewhere
force = hertz + 0.2e-9 * rng.standard_normal(depth.size)
gel = [f"{1e6 * z:.5f},{1e9 * f:.4f}" for z, f in zip(travel, force, strict=True)]

# the same law with R = 10 um, fused silica of 72 GPa and 0.17 under diamond of 1141 GPa and 0.07
modulus = 1 / ((1 - 0.17**2) / 72e9 + (1 - 0.07**2) / 1141e9)
pressed = np.linspace(0.0, 100e-9, 101)
load = 4 / 3 * modulus * np.sqrt(10e-6) * pressed**1.5 + 5e-6 * rng.standard_normal(pressed.size)
silica = [f"{1e9 * d:.2f},{1e3 * f:.5f}" for d, f in zip(pressed, load, strict=True)]

# G* = G + sum of G_i i w t_i / (1 + i w t_i), with 1 % of noise on each modulus
frequency = np.geomspace(0.1, 1e4, 41)
spin = 2j * np.pi * frequency
times, moduli = np.array([10e-3, 1e-3, 0.1e-3]), np.array([2e6, 5e6, 20e6])
complex_modulus = 1e6 + np.sum(moduli * spin[:, None] * times / (1 + spin[:, None] * times), axis=1)
noisy = 1 + 0.01 * rng.standard_normal((2, frequency.size))
rubber = [
    f"{f:.4g},{s / 1e6:.5g},{w / 1e6:.5g}"
    for f, s, w in zip(
        frequency, complex_modulus.real * noisy[0], complex_modulus.imag * noisy[1], strict=True
    )
]

tables = {
    "gel_curve.csv": ("travel [um],force [nN]", gel),
    "silica_loading.csv": ("indentation [nm],force [mN]", silica),
    "rubber_sweep.csv": ("frequency [Hz],G' [MPa],G'' [MPa]", rubber),
}
try:
    here = Path(__file__).parent
except NameError:  # run by a documentation builder
    here = Path.cwd()
for name, (header, rows) in tables.items():
    file = here / "data" / name
    if not file.exists():
        note = "# made by make_reader_files.py, which states formula and noise"
        file.write_text("\n".join([note, header, *rows]) + "\n")
    assert file.read_text().splitlines()[1:] == [header, *rows]
