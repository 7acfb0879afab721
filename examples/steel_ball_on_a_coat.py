"""
A steel ball on a hard coat: what fails first
=============================================

A steel plate has a coat of diamond-like carbon, 5 um thick. A steel ball of 6 mm is pressed on it with 10 N. The coat may crack in
the ring of tension around the contact, the shear at its interface may detach it, or the steel below may yield.
"""

import numpy as np

import pymdr as mdr

steel = mdr.Elastic("210 GPa", 0.3)
carbon = mdr.Elastic("450 GPa", 0.22)
plate = mdr.Layered([mdr.Layer(carbon, "5 um")], base=steel)
contact = mdr.Contact(mdr.Sphere("3 mm"), plate, steel)
result = mdr.solve(contact, mdr.load("10 N"))
a = float(result["contact_radius"][-1])
print(result.summary())

# %%
# The ring of tension at the surface, and the tractions on the interface. A depth that is given twice at an interface is read on
# both sides: the radial stress jumps there, the tractions do not.

r = a * np.linspace(0.0, 2.0, 201)
stress = result.field("stress", r=r, z=["0 um", "5 um", "5 um"])
ring = stress.sel(component="rr").values[0]
shear = abs(stress.sel(component="rz").values[1])
print(f"largest tension at the surface: {ring.max() / 1e6:.0f} MPa at r = {r[ring.argmax()] / a:.2f} a")
print(f"largest shear on the interface: {shear.max() / 1e6:.0f} MPa at r = {r[shear.argmax()] / a:.2f} a")
for name, part in zip(("coat", "steel"), stress.sel(component="rr")[1:], strict=True):
    print(f"radial stress at the interface on the axis, in the {name}: {float(part[0]) / 1e6:.0f} MPa")

# %%
# The interface bears the load, as every plane does.

far = a * np.concatenate([np.linspace(0.0, 2.0, 801), np.geomspace(2.0, 60.0, 800)[1:]])
axial = result.field("stress", r=far, z=["5 um"]).sel(component="zz").values[0]
assert abs(-np.trapezoid(2 * np.pi * far * axial, far) / 10.0 - 1) < 1e-3

# %%
# The whole stress in section, with the largest value and the interface. The ball has the same pressure on its surface.

figure = result.plot("stress")
figure.savefig("steel_ball_on_a_coat.png")
print("figure saved as steel_ball_on_a_coat.png")
print(result.largest("von_mises"), result.largest("von_mises", side="counterbody"))

# %%
# Is it safe? Carbon yields at 15 GPa and cracks under a tension of 3 GPa, this steel yields at 2 GPa and cracks under 4 GPa; the interface
# bears a shear of 300 MPa.
# The table has the load at which each is reached first, and the layer (1 is the steel).

failure = mdr.first_yield(
    contact, strength=["15 GPa", "2 GPa"], tensile_strength=["3 GPa", "4 GPa"], bond_strength="300 MPa"
)
print(failure)
loads = failure.data["normal_force"]
print(
    f"first to fail: {loads['criterion'].values[int(np.argmin(loads.values))]}, at {float(loads.min()):.0f} N"
)
at_yield = mdr.solve(contact, mdr.load(float(loads.sel(criterion="interface shear"))))
assert abs(float(at_yield.largest("interface_shear", -1)) / 300e6 - 1) < 1e-6
