"""
Hardness of an indent, with a calibrated tip
============================================

A worn Berkovich tip is calibrated by indents in fused silica, together with the compliance of the frame. An indent in another body is then
evaluated by the power law of Oliver and Pharr and by the effective shape of its unloading.
"""

import numpy as np

import pymdr as mdr

rng = np.random.default_rng(4)
worn = mdr.AreaFunction([24.5, 900.0, 2000.0], unit="1 nm")
diamond = mdr.Elastic("1141 GPa", 0.07)
FRAME, EXPONENT, EPSILON = 0.4e-6, 1.35, 0.765215


def recorded(contact_depth, hardness, body):
    """A record with known contact depth, as of a machine with noise and a compliant frame."""
    area = float(worn.area_at(contact_depth))
    force = hardness * area
    stiffness = 2 * mdr.effective_moduli(body, diamond).normal * np.sqrt(area / np.pi)
    depth = contact_depth + EPSILON * force / stiffness
    part = np.concatenate([np.linspace(0, 1, 250), np.ones(50), np.linspace(1, 0, 250)])
    h = depth - EXPONENT * force / stiffness * (1 - part ** (1 / EXPONENT))
    h[:250] = depth * part[:250] ** 0.5
    return mdr.MeasuredCurve(
        force=force * part + 1e-6 * rng.normal(size=part.size),
        indentation=h + FRAME * force * part + 0.1e-9 * rng.normal(size=part.size),
    )


# %%
# The calibration: frame compliance and area function with correlated intervals.
silica = mdr.Elastic("72 GPa", 0.17)
indents = [recorded(depth, 9e9, silica) for depth in np.geomspace(30e-9, 600e-9, 20)]
calibration = mdr.calibrate_area(indents, silica, epsilon=None)
print(calibration)
figure = calibration.plot()
figure.savefig("hardness_of_an_indent.png")
print("figure saved as hardness_of_an_indent.png")

# %%
# An indent in a steel of 210 GPa and 4 GPa of hardness; the calibration brings its uncertainty.
steel = mdr.Elastic("210 GPa", 0.3)
study = mdr.oliver_pharr(recorded(150e-9, 4e9, steel), calibration, poisson=0.3, epsilon=None)
print(study)
figure = study.plot()
figure.savefig("hardness_of_an_indent_2.png")
print("figure saved as hardness_of_an_indent_2.png")

assert np.all(abs(study["hardness"] / 4e9 - 1) < 0.01)
assert np.all((study["young_modulus_low"] < 210e9) & (study["young_modulus_high"] > 210e9))
