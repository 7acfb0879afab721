"""
A graded implant
================

The coating of an implant is soft at its surface and stiffens with depth, E(z) = E0 (z / z0)^k, so that no interface concentrates
stress. Under a ball its pressure is wider and lower than that of a homogeneous body with the same indentation.
"""

import math

import matplotlib.style
import numpy as np
from matplotlib.figure import Figure

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

R, k = 5e-3, 0.3
implant = mdr.Graded(young="20 GPa", depth="1 mm", exponent=k, poisson=0.3)
graded = mdr.Contact(mdr.Paraboloid(R), implant)
result = mdr.solve(graded, mdr.load("50 N", steps=50))
print(result.summary())
figure = result.plot()
figure.savefig("graded_implant.png")
print("figure saved as graded_implant.png")

# %%
# A homogeneous body with the same load and indentation, F = (4/3) E* sqrt(R d^3), has a smaller contact:
depth = float(result["indentation"][-1])
modulus = 0.75 * 50.0 / math.sqrt(R * depth**3)
homogeneous = mdr.solve(mdr.Contact(mdr.Paraboloid(R), mdr.Elastic(modulus, 0.0)), mdr.load("50 N"))
figure = Figure(figsize=(6.4, 3.8), layout="constrained")
axes = figure.subplots()
for words, one in (("graded", result), ("homogeneous", homogeneous)):
    p = one.field("pressure", np.linspace(0.0, 0.3e-3, 301))
    axes.plot(p["r"].values * 1e6, p.values / 1e6, label=words)
axes.set_xlabel("radius (µm)")
axes.set_ylabel("pressure (MPa)")
axes.legend()
figure.savefig("graded_implant_2.png")
print("figure saved as graded_implant_2.png")

# %%
# In the middle of the contact it is 2 c a^(1+k) / (pi R (1+k)^2), where the springs have the stiffness c x^k per length:
c, a = mdr.effective_moduli(implant).normal, float(result["contact_radius"][-1])
peak = 2.0 * c * a ** (1.0 + k) / (math.pi * R * (1.0 + k) ** 2)
assert abs(float(result.field("pressure", 0.0)[0]) / peak - 1) < 1e-12
assert float(homogeneous.field("pressure", 0.0)[0]) > peak

# %%
# With adhesion the pull-off force under a dead load is (3 + k) / 2 pi R work, for any modulus:
sticky = mdr.Contact(mdr.Paraboloid(R), implant, adhesion=mdr.JKR("50 mJ/m^2"))
pull_off = mdr.pull_off(sticky, machine_stiffness=0.0)
assert abs(pull_off.normal_force / (-(3.0 + k) / 2.0 * math.pi * R * 50e-3) - 1) < 1e-12
