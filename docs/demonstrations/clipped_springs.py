"""
Clipped springs are not a ring contact
======================================

Where g does not rise, it is tempting to keep the springs that are pressed and to forget the others. The sum of clipped
springs is neither the force nor a bound of it. The best single disk is a rigorous lower bound, and boundary elements
on rings give the answer.
"""

import numpy as np

import pymdr as mdr

k, A, d = 40.0, 15.0, 0.02
h = A / k**2
profile = mdr.Function(
    lambda r: r**2 / 2 + 2 * h * np.sin(k * r / 2) ** 2, derivative=lambda r: r + h * k * np.sin(k * r)
)
contact = mdr.Contact(profile, mdr.Elastic("1 Pa", 0.0))

clipped = mdr.foundation(contact, 20001, half_length=0.5).normal_force(d)
bound = float(mdr.solve(contact, mdr.indent(d))["force_lower_bound"][0])
rings = mdr.solve(contact, mdr.indent(d), solver=mdr.Rings(n=200))
force = float(rings["normal_force"][0])
print(f"clipped springs {clipped / force:.2f}, best disk {bound / force:.2f} of the force {force:.5f} N")

assert bound < force
assert abs(clipped / force - 1) > 0.02
figure = rings.plot()
