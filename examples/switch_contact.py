"""
Resistance of a switch
======================

A silver rivet closes a switch. The current narrows in the contact. The resistance of the disk is (rho1 + rho2)/(4 a);
for a round rivet it decreases with the cubic root of the force. The current heats the contact; at about 90 mV silver softens, and
the contact grows.
"""

import numpy as np

import pymdr as mdr

silver = mdr.Elastic(
    "83 GPa",
    0.37,
    resistivity="15.9 nohm m",
    thermal_conductivity="429 W/(m K)",
    thermal_diffusivity="173 mm^2/s",
)
rivet = mdr.Contact(mdr.Paraboloid("5 mm"), silver, silver)

result = mdr.solve(rivet, mdr.load("1 N", steps=20))
print(result.summary())
figure = result.figures()["conductance"]
figure.savefig("switch_contact.png")
print("figure saved as switch_contact.png")

# %%
# Check: a^3 = 3 F R/(4 E*).
modulus = mdr.effective_moduli(silver, silver).normal
force = result["normal_force"].values
by_hand = 15.9e-9 / 2 / np.cbrt(3 * force * 5e-3 / (4 * modulus))
assert np.allclose(result["electrical_resistance"], by_hand, rtol=1e-12)
print(f"{result.to('electrical_resistance', 'mohm')[-1]:.3f} mohm at 1 N")

# %%
# For any shape of the contact, 90 mV give a largest temperature of about 410 K. The current for it grows with the force.
hot = mdr.joule_heating(result, voltage="90 mV", temperature="20 degC")
print(hot)
assert abs(float(hot["largest_temperature"][-1]) - np.hypot(293.15, 0.045 / np.sqrt(2.443e-8))) < 1e-9
assert np.allclose(hot["current"] / hot["current"][-1], np.cbrt(force), rtol=1e-9)

# %%
# Friction also heats a contact: here one that slides slowly while it closes.
wiping = mdr.Contact(mdr.Paraboloid("5 mm"), silver, silver, friction=mdr.Coulomb(0.5))
rubbed = mdr.frictional_heat(wiping, ["10 mm/s", "50 mm/s"], normal_force="1 N")
print(rubbed)
assert rubbed.assumptions[-1].met
