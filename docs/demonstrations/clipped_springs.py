"""
Clipped springs are not a ring contact
======================================

Where g does not rise, one might sum only the compressed springs. The sum of these clipped springs is neither the force nor a bound.
For the same body it is far too large at one indentation and too small at another. The best single disk is a rigorous lower bound,
and boundary elements on rings give the force.
"""

import matplotlib.style
import numpy as np
from matplotlib.figure import Figure

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

k, A = 40.0, 15.0
h = A / k**2
profile = mdr.Function(
    lambda r: r**2 / 2 + 2 * h * np.sin(k * r / 2) ** 2,
    derivative=lambda r: r + h * k * np.sin(k * r),
)
contact = mdr.Contact(profile, mdr.Elastic("1 Pa", 0.0))
springs = mdr.foundation(contact, 20001, half_length=0.8)

depths = np.array([0.0125, 0.02, 0.03])
clipped, bound, force = [], [], []
for d in depths:
    clipped.append(springs.normal_force(d))
    bound.append(float(mdr.solve(contact, mdr.indent(d))["force_lower_bound"][0]))
    rings = mdr.solve(contact, mdr.indent(d), solver=mdr.Rings(n=100))
    force.append(float(rings["normal_force"][0]))
clipped, bound = np.array(clipped) / force, np.array(bound) / force
for d, c, b in zip(depths, clipped, bound, strict=True):
    print(f"d = {d:.4f} m: clipped springs {c:.3f}, best disk {b:.3f} of the force")

# %%
# Too large, and too small, by much more than the error of the rings; the bound is never above the force.
assert clipped[0] > 2.5
assert clipped[2] < 0.95
assert np.all(bound < 1 + 1e-5)

figure = Figure(figsize=(6, 3.4), layout="constrained")
axes = figure.subplots()
axes.plot(1e3 * depths, clipped, "o", label="clipped springs")
axes.plot(1e3 * depths, bound, "s", ms=10, mfc="none", label="best disk, a lower bound")
axes.axhline(1.0, color="k", lw=0.8)
axes.set_xlabel("indentation (mm)")
axes.set_ylabel("fraction of the force")
axes.legend()
