"""
A worn ball
===========

A polymer ball with a flat from wear is pressed against a plate and compared with the original ball. The flat is in contact from
first touch, so the worn ball is stiffer from the beginning. The difference decreases with the load.
"""

import math

import pymdr as mdr

R, b = 10e-3, 1e-3
polymer = mdr.Elastic(young="2 GPa", poisson=0.4)
worn = mdr.Contact(mdr.TruncatedSphere(radius=R, flat_radius=b), polymer)
new = mdr.Contact(mdr.Sphere(radius=R), polymer)

path = mdr.load("1 kN", steps=50)
after, before = mdr.solve(worn, path), mdr.solve(new, path)
print(after.summary())
figure = after.plot()
figure.savefig("worn_sphere.png")
print("figure saved as worn_sphere.png")

# %%
# The force of a worn ball of contact radius a is E* [(R^2 + a^2) artanh(u / c) - u c], u^2 = a^2 - b^2 and
# c^2 = R^2 - b^2; with b = 0 it is that of the sphere.
modulus = mdr.effective_moduli(polymer).normal
a = float(after["contact_radius"][-1])
u, c = math.sqrt(a**2 - b**2), math.sqrt(R**2 - b**2)
force = modulus * ((R**2 + a**2) * math.atanh(u / c) - u * c)
assert abs(force / 1e3 - 1) < 1e-12

# %%
# Its contact is stiffer than that of the original ball: 2.5 times at 20 N, 1.03 times at 1 kN.
ratio = after["normal_stiffness"] / before["normal_stiffness"]
print(ratio.values[[0, -1]])
assert ratio[0] > ratio[-1] > 1.0
