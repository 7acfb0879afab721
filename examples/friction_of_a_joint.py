"""
The coefficient of friction in a measured loop
==============================================

A joint is shaken sideways under a known load, by so little that its middle never slips: no plateau of the force shows the coefficient of friction.
It is in the shape of the loop all the same, and a fit finds it, together with the modulus that the slope at every turn tells.
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
# is told neither. The shift at which the ball was pressed on and an offset of the force are looked for too.
steel = mdr.Elastic("210 GPa", 0.3)
start = mdr.Contact(mdr.Sphere("10 mm"), mdr.Elastic("50 GPa", 0.3), steel, friction=mdr.Coulomb(1.0))
found = mdr.fit(start, record, ["friction.coefficient", "body.young"])
print(found)
figure = found.plot()

mu = found["friction.coefficient"]
assert mu.low < 0.3 < mu.high
assert abs(mu.value / 0.3 - 1) < 0.01
assert found["body.young"].low < 210e9 < found["body.young"].high

# %%
# Where the record never slips as a whole, friction is known by its noise, and not by mu F_N: the largest force of the record is a lower bound only.
largest = float(np.abs(record["tangential_force"]).max())
print(f"the largest force is {largest / 50:.2f} of the load")
assert largest < 0.95 * 0.3 * 50

# %%
# A modulus and Poisson's ratio together are too much: the loop determines one stiffness.
try:
    mdr.fit(start, record, ["friction.coefficient", "body.young", "body.poisson"])
except mdr.errors.ProblemError as error:
    print(error)
