"""
A flattened copper ball
=======================

A copper ball is pressed on a hard flat, unloaded, and loaded further. It yields almost at once. Unloading is elastic and steep, and leaves a
residual indentation; reloading returns on the same curve.
"""

import math

import pymdr as mdr

copper = mdr.ElasticPlastic("120 GPa", 0.34, yield_strength="200 MPa")
ball = mdr.Contact(mdr.Sphere("1 mm"), copper)
path = (
    mdr.load("30 N", steps=30)
    >> mdr.load("0 N", steps=15)
    >> mdr.load("45 N", steps=45)
    >> mdr.load("0 N", steps=15)
)
result = mdr.solve(ball, path)
print(result)

# %%
# In the full contact the pressure is uniform, so that the force is that pressure times the area of the contact.

d, a = result["indentation"].values[29], result["contact_radius"].values[29]
pressure = 200e6 * (1 + 1.75 * math.exp(-4.4 * d / 1e-3))
assert math.isclose(pressure * math.pi * a**2, 30.0, rel_tol=1e-12)

figure = result.plot()
figure.savefig("flattened_ball.png")
print("figure saved as flattened_ball.png")
