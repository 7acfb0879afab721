"""
Moduli and relaxation time of a gel
===================================

A tip approaches a gel, is held, and retracts. The force relaxes during the hold. The record of the whole history determines the
equilibrium modulus, the modulus of the relaxing branch and its time.
"""

import numpy as np

import pymdr as mdr

gel = mdr.Contact(
    mdr.Paraboloid("5 um"), mdr.Viscoelastic(mdr.StandardSolid("1 kPa", "2 kPa", "0.5 s"), poisson=0.5)
)
time = np.linspace(0.0, 5.0, 101)
depth = np.interp(time, [0.0, 0.5, 1.5, 4.0, 5.0], [-0.5e-6, 0.0, 1e-6, 1e-6, -0.5e-6])
true = mdr.solve(gel, mdr.Path(time=time, indentation=depth))["normal_force"].values

# %%
# The record, with noise of 1 % of the largest force and an unknown baseline.
noise = 0.01 * true.max() * np.random.default_rng(4).normal(size=time.size)
curve = mdr.MeasuredCurve(force=true + noise + 2e-10, indentation=depth, time=time)

# %%
# ``mdr.parameters_of(gel)`` lists the names of the parameters. Depth and contact point were measured.
start = mdr.Contact(
    gel.profile, mdr.Viscoelastic(mdr.StandardSolid("10 kPa", "10 kPa", "0.1 s"), poisson=0.5)
)
free = ["body.shear.equilibrium", "body.shear.modulus", "body.shear.time"]
fit = mdr.fit(start, curve, free, contact_point=0.0)
print(fit)
figure = fit.plot()
figure.savefig("relaxation_of_a_gel.png")
print("figure saved as relaxation_of_a_gel.png")

assert fit["body.shear.time"].low < 0.5 < fit["body.shear.time"].high
assert abs(fit["body.shear.equilibrium"].value / 1e3 - 1) < 0.02

# %%
# The fitted law gives other quantities, such as the storage modulus at 10 Hz.
storage = fit.contact.body.shear.storage(2 * np.pi * 10)
print(storage)
