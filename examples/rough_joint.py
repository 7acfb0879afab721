"""
A rough contact from its force curve
====================================

The shape of this contact is unknown; its force curve was measured with noise. The curve is sufficient for friction, impacts and
creep, in milliseconds. Area and pressures are not in the curve and are refused.
"""

from pathlib import Path

import numpy as np

import pymdr as mdr

try:
    here = Path(__file__).parent
except NameError:  # run by a documentation builder
    here = Path.cwd()

# %%
# The curve was measured between two equal bodies with E* = 1 GPa. The fitted line of springs has a rising stiffness.
curve = mdr.read_force_curve(here / "data" / "rough_curve.csv", modulus="1 GPa")
body = mdr.Elastic("2 GPa", 0.0)
joint = mdr.Contact(curve, body, body, friction=mdr.Coulomb(0.4))
fretting = mdr.solve(joint, mdr.indent("2.5 um") >> mdr.cycle(shift="0.3 um", cycles=2, steps=200))
print(fretting.summary())
figure = fretting.plot()
figure.savefig("rough_joint.png")
print("figure saved as rough_joint.png")

# %%
# Boundary elements with friction on the five caps of the curve (`make_rough_curve.py`) end at 450.883 mN:
peak = float(fretting["tangential_force"].max())
print(f"tangential force {1e3 * peak:.1f} mN, boundary elements 450.883 mN")
assert abs(peak / 0.450883 - 1) < 0.01

# %%
# The same surface on rubber creeps under a load. Forces scale with E*(t) over the E* of the curve. The first depths are within the noise
# of the curve and are left out.
rubber = mdr.Viscoelastic(mdr.StandardSolid(equilibrium="1 MPa", modulus="3 MPa", time="50 ms"), poisson=0.5)
creep = mdr.solve(
    mdr.Contact(curve, rubber), mdr.load("3 mN", steps=10, duration="10 ms") >> mdr.hold("0.3 s", steps=60)
)
depths = creep.to("indentation", "um").values
known = np.isfinite(depths)
assert known[9:].all()
print(f"creep from {depths[9]:.2f} to {depths[-1]:.2f} um")

# %%
# Contact time and largest force of an impact.
hit = mdr.impact(mdr.Contact(curve, body, body), mass="1 g", speed="50 mm/s")
print(hit)
assert hit.restitution == 1.0

# %%
# Quantities that are not integrals over the contact are refused:
try:
    fretting["contact_radius"]
except mdr.NotValidError as refusal:
    print(refusal)
else:
    raise AssertionError("a curve knows no radius")
assert np.all(np.diff(depths[known]) > 0)
