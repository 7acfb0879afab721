"""
A callable as a shape
=====================

Any axisymmetric shape is a callable. Its map is accurate to rounding at every radius, and every number of the result states its
error. The example is a hyperboloid, a tip with a blunt end and straight flanks, with one kink from wear. It is pressed over nine decades of
depth.
"""

import matplotlib.style
import numpy as np
from matplotlib.figure import Figure

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

bluntness, flank, worn = (
    2e-6,
    0.35,
    5e-6,
)  # m, slope of the flanks, radius in m from which the flanks are steeper
steeper = 0.2


def shape(r):
    """Height in m above the tip, in a form that keeps its digits near r = 0."""
    tip = flank * r**2 / (np.hypot(r, bluntness) + bluntness)
    return tip + steeper * np.maximum(r - worn, 0.0)


def slope(r):
    """Its derivative; at the kink it jumps."""
    return flank * r / np.hypot(r, bluntness) + steeper * (r > worn)


tip = mdr.Function(shape, breakpoints=[worn], derivative=slope, max_radius="1 mm")
depths = np.geomspace(1e-14, 1e-5, 91)
result = mdr.solve(mdr.Contact(tip, mdr.Elastic("3 GPa", 0.35)), mdr.Path(indentation=depths))
print(result.claims["normal_force"].error.max())

figure = Figure(figsize=(9, 3.6), layout="constrained")
left, right = figure.subplots(1, 2)
radius = result["contact_radius"].values
left.loglog(depths, result["normal_force"].values)
left.set(xlabel="indentation (m)", ylabel="force (N)")
right.loglog(depths, radius)
right.set(xlabel="indentation (m)", ylabel="contact radius (m)")
figure.savefig("own_shape.png")
print("figure saved as own_shape.png")

# %%
# The depth of a hyperboloid is :math:`d = \theta\, a \arctan(a/c)`, and the kink adds :math:`\vartheta\, a
# \arccos(b/a)`. The claim is correct in all nine decades, and small:
exact = flank * radius * np.arctan(radius / bluntness)
beyond = radius > worn
exact[beyond] += steeper * radius[beyond] * np.arccos(worn / radius[beyond])
assert np.all(abs(exact / depths - 1) < 1e-13)
assert result.claims["normal_force"].level is mdr.Level.EXACT
assert result.claims["normal_force"].error.max() < 1e-12
