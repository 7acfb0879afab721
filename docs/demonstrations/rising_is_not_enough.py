"""
A rising profile is not enough
==============================

It is often said that the contact is a disk if f(r) rises. The condition is that g rises, or, for one load, that the pressure and
the gap of the disk are not negative. A wavy paraboloid r^2/2R + h (1 - cos kr) has f' >= 0 for h k^2 R < 4.603, but its g rises
only for h k^2 R < 3.186.
"""

import numpy as np

import pymdr as mdr


def wavy(A, k=40.0):
    h = A / k**2
    return mdr.Function(
        lambda r: r**2 / 2 + 2 * h * np.sin(k * r / 2) ** 2, derivative=lambda r: r + h * k * np.sin(k * r)
    )


body = mdr.Elastic("1 Pa", 0.0)
r = np.linspace(0, 0.4, 4001)
assert np.all(wavy(4.5).gap_slope(r) >= 0)

smooth = mdr.solve(mdr.Contact(wavy(3.0), body), mdr.indent(0.05, steps=40))
rough = mdr.solve(mdr.Contact(wavy(4.5), body), mdr.indent(0.05, steps=40))
print(rough.claims["normal_force"].reason)
assert smooth.status is mdr.Status.COMPLETED
assert rough.status is mdr.Status.PARTLY_REFUSED
figure = rough.plot()
