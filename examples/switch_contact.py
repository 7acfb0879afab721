"""
The resistance of a switch
==========================

A rivet of silver closes a switch. The current squeezes through the spot where the bodies touch, and what it meets there is
the resistance of the disk, (rho1 + rho2)/(4 a): for a round rivet it falls with the cubic root of the force. A current warms
the spot; at some 90 mV silver softens, and the contact grows.
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

# %%
# By hand: a^3 = 3 F R/(4 E*).
modulus = mdr.effective_moduli(silver, silver).normal
force = result["normal_force"].values
by_hand = 15.9e-9 / 2 / np.cbrt(3 * force * 5e-3 / (4 * modulus))
assert np.allclose(result["electrical_resistance"], by_hand, rtol=1e-12)
print(f"{result.to('electrical_resistance', 'mohm')[-1]:.3f} mohm at 1 N")

# %%
# Whatever the shape of the contact, 90 mV make its hottest place about 410 K warm. The current for it grows with the force.
hot = mdr.joule_heating(result, voltage="90 mV", temperature="20 degC")
print(hot)
assert abs(float(hot["largest_temperature"][-1]) - np.hypot(293.15, 0.045 / np.sqrt(2.443e-8))) < 1e-9
assert np.allclose(hot["current"] / hot["current"][-1], np.cbrt(force), rtol=1e-9)

# %%
# Its own friction warms a contact as well: here one that wipes slowly while it closes.
wiping = mdr.Contact(mdr.Paraboloid("5 mm"), silver, silver, friction=mdr.Coulomb(0.5))
rubbed = mdr.frictional_heat(wiping, ["10 mm/s", "50 mm/s"], normal_force="1 N")
print(rubbed)
assert rubbed.assumptions[-1].met
