"""
A rubber pad: largest stress in time
====================================

A ball is pressed into a pad of rubber within 10 ms and held there. The stress is largest at the end of the stroke and relaxes with the
force.
"""

import numpy as np

import pymdr as mdr

rubber = mdr.Viscoelastic(mdr.StandardSolid("1 MPa", "3 MPa", "0.2 s"), poisson=0.49)
contact = mdr.Contact(mdr.Sphere("20 mm"), rubber)
path = mdr.indent("0.5 mm", steps=10, duration="10 ms") >> mdr.hold("4 s", steps=40)
result = mdr.solve(contact, path)
mises = result["largest_mises"]
highest = int(np.argmax(mises.values))
print(result.to("largest_mises", "MPa").values.round(3))
print(
    f"largest at t = {float(result['time'][highest]) * 1e3:.0f} ms, z = {float(mises.z[highest]) * 1e3:.2f} mm"
)

# %%
# After many relaxation times the stress is that of an elastic pad with the relaxed modulus.

relaxed = mdr.Contact(mdr.Sphere("20 mm"), mdr.Elastic(2 * (1 + 0.49) * 1e6, 0.49))
slow = mdr.solve(relaxed, mdr.indent("0.5 mm"))["largest_mises"]
assert highest == 9
assert abs(float(mises[-1] / slow[0]) - 1) < 1e-6

# %%
# The stress at the end of the stroke, in section.

figure = result.plot("stress", step=9)
figure.savefig("rubber_pad_under_stress.png")
print("figure saved as rubber_pad_under_stress.png")
