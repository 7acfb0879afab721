"""
A bead on a cell, and a pyramid on a gel
========================================

A bead of 5 um presses a round cell of 8 um. Near the tip both together act like a sphere of the effective radius. A modulus that does not depend on the range
of the fit supports the model. A second fit uses a four-sided tip on a gel.
"""

import numpy as np

import pymdr as mdr

rng = np.random.default_rng(6)
pair = mdr.SphereOnSphere("5 um", sample_radius="8 um")
cell = mdr.Contact(pair, mdr.Elastic("800 Pa", 0.5))
depth = np.linspace(-0.5e-6, 0.5e-6, 300)
force = mdr.solve(cell, mdr.Path(indentation=depth))["normal_force"].values
curve = mdr.MeasuredCurve(force=force + 2e-12 * rng.normal(size=300), indentation=depth)

# %%
# The modulus over the largest fitted indentation.
start = mdr.Contact(pair, mdr.Elastic("5 kPa", 0.5))
study = mdr.fit_over_indentation(start, curve, ["body.young"], steps=6)
print(study)
figure = study.plot()
figure.savefig("bead_on_a_cell.png")
print("figure saved as bead_on_a_cell.png")

# %%
# A pyramid of four sides, 35 degrees between axis and face.
gel = mdr.Contact(mdr.Pyramid.four_sided_tip("35 deg"), mdr.Elastic("3 kPa", 0.5))
force = mdr.solve(gel, mdr.Path(indentation=depth))["normal_force"].values
pressed = mdr.MeasuredCurve(force=force + 2e-12 * rng.normal(size=300), indentation=depth)
fit = mdr.fit(mdr.Contact(gel.profile, mdr.Elastic("1 kPa", 0.5)), pressed, ["body.young"])
print(fit)

assert abs(float(study["body.young"][-1]) / 800 - 1) < 0.01
assert fit["body.young"].low < 3e3 < fit["body.young"].high
