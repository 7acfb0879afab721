"""
Cartilage on bone, with adhesion
================================

Cartilage is thin. If the contact is as wide as the layer is thick, the bone carries much of the load, more so for an
incompressible layer. A glass ball of 10 mm is pressed into a layer of 1 mm and pulled off again.
"""

import math

import pymdr as mdr

cartilage = mdr.Elastic("0.6 MPa", 0.48)
bone = mdr.Elastic("1 GPa", 0.3)
joint = mdr.Layered([mdr.Layer(cartilage, "1 mm")], base=bone)
ball = mdr.Contact(mdr.Sphere("10 mm"), joint, adhesion=mdr.JKR("0.1 J/m^2"))

path = mdr.indent("0.1 mm", steps=40) >> mdr.indent("-0.1 mm", steps=120)
result = mdr.solve(ball, path)
print(result.summary())
figure = result.figures()["layers"]
figure.savefig("cartilage_on_bone.png")
print("figure saved as cartilage_on_bone.png")

# %%
# A half-space needs less force for the same depth. As a model of the cartilage it gives a modulus that is too large:
deep = mdr.solve(mdr.Contact(mdr.Sphere("10 mm"), cartilage, adhesion=mdr.JKR("0.1 J/m^2")), path)
factor = float(result["normal_force"][39] / deep["normal_force"][39])
print(f"the layer is {factor:.2f} times as stiff as a half-space at a depth of 0.1 mm")
assert abs(factor / 4.59 - 1) < 2e-3

# %%
# The bone hardly changes the pull-off under a dead load; for a paraboloid on a half-space it is (3/2) pi R w:
pull_off = mdr.pull_off(ball, machine_stiffness=0.0)
print(f"pull-off at {pull_off.normal_force * 1e3:.3f} mN, a = {pull_off.contact_radius * 1e3:.3f} mm")
assert abs(pull_off.normal_force / (-1.5 * math.pi * 10e-3 * 0.1) - 1) < 0.05
