"""
Torsion of a screwdriver bit
============================

A hardened ball tip is pressed with 50 N and turned to and fro. It slips from the edge inward. The torque tends to a limit without reaching it.
"""

import math

import pymdr as mdr

steel = mdr.Elastic(young="210 GPa", poisson=0.3)
bit = mdr.Contact(mdr.Paraboloid("10 mm"), steel, steel, friction=mdr.Coulomb(0.3))
result = mdr.solve(bit, mdr.load("50 N") >> mdr.cycle(twist="2 mrad", cycles=2, steps=160))
figure = result.plot()
figure.savefig("torsion_of_a_bit.png")
print("figure saved as torsion_of_a_bit.png")

# %%
# Lubkin's sphere: at G phi = 0.98280513 mu p0 the stick radius is a fifth of the contact radius, and the torque 0.99404795 of the largest.

pressure = 1.5 * float(result["mean_pressure"][0])
shear = steel.shear / 2
turned = mdr.solve(bit, mdr.load("50 N") >> mdr.twist(0.9828051327465988 * 0.3 * pressure / shear))
largest = 3 * math.pi / 16 * 0.3 * 50 * float(turned["contact_radius"][-1])
print(turned)
assert abs(float(turned["torque"][-1]) / largest / 0.9940479391686872 - 1) < 1e-12

# %%
# The traction is mu p where it slips.

figure = turned.plot()
figure.savefig("torsion_of_a_bit_2.png")
print("figure saved as torsion_of_a_bit_2.png")
traction, pressure = (
    turned.field(name, r=["60 um", "100 um"]) for name in ("torsional_traction", "pressure")
)
print((traction / pressure).values)

# %%
# The stress in the tip: the tension around the contact, which opens cracks, is that of pressing and the shear of turning together.

figure = turned.plot_stress(name="principal_stress")
figure.savefig("torsion_of_a_bit_3.png")
print("figure saved as torsion_of_a_bit_3.png")
pressed = mdr.solve(bit, mdr.load("50 N"))
rise = float(turned.largest("principal_stress", step=-1) / pressed.largest("principal_stress", step=-1))
print(f"turning multiplies the largest tension by {rise:.3f}")
