"""
Creep curve of a rolling ball
=============================

A driven ball rolls slightly slower than its surface rotates. Friction transmits a force that depends on this difference, the
creepage. At first the contact sticks nearly everywhere and the force grows with the creepage; then slip spreads from the trailing
edge until the ball slides at Coulomb's limit.
"""

import numpy as np

import pymdr as mdr

steel = mdr.Elastic(young="210 GPa", poisson=0.3)
ball = mdr.Contact(mdr.Paraboloid("10 mm"), steel, steel, friction=mdr.Coulomb(0.3))

creep = mdr.rolling(ball, [1e-3, 2e-3, 4e-3, 8e-3], normal_force="100 N", law="calibrated")
print(creep)
figure = creep.plot()
figure.savefig("creep_curve.png")
print("figure saved as creep_curve.png")

# %%
# Creepage at half of the largest force: the springs of the method are too soft by 45 % and need
# too much; with Kalker's slope it is 20.6 % of the saturation, since :math:`1 - (1 - \xi)^3 = 1/2`.
half = (1 - 0.5 ** (1 / 3)) * float(creep["saturation_creepage"])
at_half = mdr.rolling(ball, half, normal_force="100 N", law="calibrated")["creep_force"]
assert abs(float(at_half[0]) / (0.3 * 100) - 0.5) < 1e-12

# %%
# A suddenly applied brake is fully effective after the contact has rolled its own length:
length = 2 * creep.data.attrs["contact_radius"]
distances = np.linspace(0.05, 1.5, 30) * length
braked = mdr.rolling(ball, np.full(30, -2e-3), normal_force="100 N", path=distances)
print(braked["creep_force"].values / braked["creep_force"].values[-1])
