"""
Comparison of laws of adhesion for a curve
==========================================

A small tip is pressed on a body and pulled off by a machine that is much stiffer than the contact. Four laws are fitted to the record: Hertz'
contact without adhesion, the short-ranged attraction of Johnson, Kendall and Roberts, the long-ranged attraction of Derjaguin,
Müller and Toporov, and that of Maugis between them. Akaike's weights compare the four.
"""

import numpy as np

import pymdr as mdr

tip, body = mdr.Paraboloid("1 um"), mdr.Elastic("10 MPa", 0.4)
true = mdr.Contact(tip, body, adhesion=mdr.MaugisDugdale("20 mJ/m^2", strength="0.6 MPa"))

# %%
# The record, with noise of 1 % of the largest force.
depth = np.concatenate([np.linspace(-60e-9, 60e-9, 40), np.linspace(60e-9, -80e-9, 50)])
force = mdr.solve(true, mdr.Path(indentation=depth))["normal_force"].values
force = force + 1e-9 * np.random.default_rng(5).normal(size=depth.size)
curve = mdr.MeasuredCurve(force=force, indentation=depth + 30e-9)

# %%
# Every law uses those free parameters that it has.
laws = {
    "Hertz": mdr.Contact(tip, body),
    "JKR": mdr.Contact(tip, body, adhesion=mdr.JKR("1 mJ/m^2")),
    "DMT": mdr.Contact(tip, body, adhesion=mdr.DMT("1 mJ/m^2")),
    "Maugis": mdr.Contact(tip, body, adhesion=mdr.MaugisDugdale("1 mJ/m^2", strength="0.6 MPa")),
}
comparison = mdr.compare_laws(laws, curve, ["body.young", "adhesion.work"])
print(comparison)
figure = comparison.plot()
figure.savefig("which_law.png")
print("figure saved as which_law.png")

assert comparison.best == "Maugis"
assert comparison.weights["Maugis"] > 0.99
assert abs(comparison["Maugis"]["adhesion.work"].value / 20e-3 - 1) < 0.02

# %%
# JKR looks nearly as good, but the interval of its work of adhesion is far from the true value: an error contains
# the noise under a law, not the choice of the law.
print(comparison["JKR"]["adhesion.work"])
assert comparison["JKR"]["adhesion.work"].low > 22e-3
