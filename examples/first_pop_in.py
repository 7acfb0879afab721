"""
First pop-in of a tungsten crystal
==================================

A diamond tip with a radius of 400 nm is pressed on tungsten. The contact stays elastic until the first dislocations form and the record jumps.
The shear stress below the tip at this load is the strength of the perfect crystal.
"""

import numpy as np

import pymdr as mdr

tungsten = mdr.Elastic("410 GPa", 0.28)
diamond = mdr.Elastic("1140 GPa", 0.07)
contact = mdr.Contact(mdr.Paraboloid("400 nm"), tungsten, diamond)

# %%
# A record as an instrument writes it: elastic up to 0.6 mN, then 8 nm deeper at once.

force = np.linspace(0.0, 0.9e-3, 451)[1:]
depth = mdr.solve(contact, mdr.Path(normal_force=force))["indentation"].values
depth = depth + np.where(force > 0.6e-3, 8e-9, 0.0) + 1e-10 * np.random.default_rng(1).normal(size=force.size)
record = mdr.MeasuredCurve(indentation=depth, force=force)
pop_in = mdr.first_pop_in(record, contact)
print(pop_in)
figure = pop_in.plot()
figure.savefig("first_pop_in.png")
print("figure saved as first_pop_in.png")

# %%
# The stress at that load, in the crystal and in the tip: the largest shear stress lies on the axis at half a contact radius.

result = mdr.solve(contact, mdr.load("0.6 mN"))
shear = result["largest_shear"]
print(
    f"largest shear stress {float(shear[-1]) / 1e9:.1f} GPa, {float(shear[-1]) / tungsten.shear:.3f} G, at z = {float(shear.z[-1]) * 1e9:.0f} nm"
)
figure = result.plot("stress")
figure.savefig("first_pop_in_2.png")
print("figure saved as first_pop_in_2.png")
# Huber (1904): 0.31 of the largest pressure where nu = 0.3
assert abs(float(shear[-1] / result["peak_pressure"][-1]) - 0.3148) < 2e-4
# the record shows the load at which the jump begins
assert abs(float(pop_in["largest_shear"][0] / shear[-1]) - 1) < 2e-3
