"""
A connector worn to its limit
=============================

A spring presses a gold-plated pin to a fixed depth, and vibration shifts it to and fro. The ring around the sticking core wears until it carries
no load.
"""

import pymdr as mdr

bronze = mdr.Elastic("110 GPa", 0.34)
pin = mdr.Contact(mdr.Sphere("2 mm"), bronze, bronze, friction=mdr.Coulomb(0.6))
cycle = mdr.indent("0.5 um") >> mdr.cycle(shift="0.15 um")
worn = mdr.wear(pin, cycle, coefficient="2e-5 mm^3/(N m)", cycles=1e6)
print(worn)
figure = worn.plot()
figure.savefig("worn_connector.png")
print("figure saved as worn_connector.png")

# %%
# The load that is left is that of the closed form (Popov 2014).

left = worn.data.attrs["limit_force"]
assert abs(float(worn["normal_force"][-1]) / left - 1) < 1e-3

# %%
# The worn profile is a profile like any other.

half = worn.worn(10)
result = mdr.solve(mdr.Contact(half, bronze, bronze, friction=mdr.Coulomb(0.6)), cycle)
print(result)
