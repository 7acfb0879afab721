"""
Coefficient of friction of a measured loop
==========================================

A joint vibrates tangentially under a known load with so small an amplitude that its middle never slips. The force has no plateau
that shows the coefficient of friction, but the shape of the loop determines it. A fit gives the coefficient, and the modulus from the
slope after each reversal.
"""

from pathlib import Path

import numpy as np

import pymdr as mdr

try:
    here = Path(__file__).parent
except NameError:  # run by a documentation builder
    here = Path.cwd()
record = mdr.read_record(here / "data" / "joint_record.csv")
print(record)

# %%
# The record has time, load, shift and tangential force, with noise of 0.05 N; it was made with a coefficient of 0.3 and steel of 210 GPa. The fit
# starts from other values. The shift at first contact and an offset of the force are fitted too.
steel = mdr.Elastic("210 GPa", 0.3)
start = mdr.Contact(mdr.Sphere("10 mm"), mdr.Elastic("50 GPa", 0.3), steel, friction=mdr.Coulomb(1.0))
fit = mdr.fit(start, record, ["friction.coefficient", "body.young"])
print(fit)
figure = fit.plot()
figure.savefig("friction_of_a_joint.png")
print("figure saved as friction_of_a_joint.png")

mu = fit["friction.coefficient"]
assert mu.low < 0.3 < mu.high
assert abs(mu.value / 0.3 - 1) < 0.01
assert fit["body.young"].low < 210e9 < fit["body.young"].high

# %%
# The record never slips as a whole, so its largest force is only a lower bound of mu F_N.
largest = float(np.abs(record["tangential_force"]).max())
print(f"the largest force is {largest / 50:.2f} of the load")
assert largest < 0.95 * 0.3 * 50

# %%
# A modulus and Poisson's ratio together are refused: the loop determines one stiffness.
try:
    mdr.fit(start, record, ["friction.coefficient", "body.young", "body.poisson"])
except mdr.errors.ProblemError as error:
    print(error)
