"""
A measured tip
==============

Samples with scatter give the profile of a worn indenter. pymdr maps a smoothing spline through them segment by segment. The
scatter becomes a band on every quantity, and the claim states the meaning of the azimuthal mean for the measured body.
"""

from pathlib import Path

import numpy as np

import pymdr as mdr

try:
    here = Path(__file__).parent
except NameError:  # run by a documentation builder
    here = Path.cwd()
tip = mdr.read_profile(here / "data" / "worn_tip.csv", interpolation=mdr.SmoothingSpline())
contact = mdr.Contact(tip, mdr.Elastic(young="2.4 GPa", poisson=0.37))

result = mdr.solve(contact, mdr.indent("30 nm", steps=30))
print(result.summary())
figure = result.plot()
figure.savefig("worn_tip.png")
print("figure saved as worn_tip.png")

# %%
# The samples were made from a hyperboloid, so the exact answer is known: the smoothed noise causes 1 %.
true = mdr.Function(derivative=lambda r: 0.36 * r / np.hypot(r, 40e-9))
exact = mdr.solve(mdr.Contact(true, contact.body), mdr.indent("30 nm"))["normal_force"].values[-1]
assert abs(result["normal_force"].values[-1] / exact - 1) < 0.01
