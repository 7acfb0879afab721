"""
Modulus of a gel from a force curve
===================================

A colloidal tip on a soft cantilever presses a gel and retracts. Modulus, work of adhesion, contact point and baseline are fitted
together, without a manual choice of the contact point.
"""

import numpy as np

import pymdr as mdr

gel = mdr.Contact(mdr.Paraboloid("5 um"), mdr.Elastic("3 kPa", 0.5), adhesion=mdr.JKR("0.2 mJ/m^2"))
travel = np.concatenate([np.linspace(-2e-6, 2e-6, 300), np.linspace(2e-6, -3e-6, 375)])
true = mdr.solve(gel, mdr.Path(travel=travel), machine_stiffness="0.05 N/m")["normal_force"].values

# %%
# The record: noise of 1 % of the largest force, unknown contact point and baseline.
noise = 2e-10 * np.random.default_rng(1).normal(size=travel.size)
curve = mdr.MeasuredCurve(force=true + noise - 1e-10, travel=travel + 4e-7, spring_constant="0.05 N/m")

# %%
# The fit starts from a modulus and a work of adhesion that are wrong by large factors.
start = mdr.Contact(mdr.Paraboloid("5 um"), mdr.Elastic("1 MPa", 0.5), adhesion=mdr.JKR("10 mJ/m^2"))
fit = mdr.fit(start, curve, ["body.young", "adhesion.work"])
print(fit)
figure = fit.plot()
figure.savefig("modulus_of_a_gel.png")
print("figure saved as modulus_of_a_gel.png")

assert abs(fit["body.young"].value / 3e3 - 1) < 0.01
assert abs(fit["adhesion.work"].value / 0.2e-3 - 1) < 0.02

# %%
# One curve does not determine radius, modulus and work of adhesion together; the fit is refused:
try:
    mdr.fit(start, curve, ["body.young", "adhesion.work", "profile.radius"])
except mdr.ProblemError as refused:
    print(refused)
