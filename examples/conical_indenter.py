"""
Conical indenter in fused quartz
================================

The equivalent cone of a Berkovich tip (half angle 70.3 degrees) is pressed 100 nm into fused quartz and unloaded. The force grows
with the square of the depth. Nanoindentation takes the modulus from the stiffness of the unloading: dF/dd = 2 E* a.
"""

import math

import pymdr as mdr

quartz = mdr.Elastic(young="72 GPa", poisson=0.17)
tip = mdr.Cone(half_angle="70.3 deg")
contact = mdr.Contact(tip, quartz)

result = mdr.solve(contact, mdr.indent("100 nm", steps=40) >> mdr.load(0.0, steps=20))
print(result.summary())
figure = result.plot(step=39)
figure.savefig("conical_indenter.png")
print("figure saved as conical_indenter.png")

# %%
# Sneddon's closed form, F = (2/pi) E* tan(half angle) d^2.
modulus = mdr.effective_moduli(quartz).normal
sneddon = 2 / math.pi * modulus * math.tan(math.radians(70.3)) * 100e-9**2
assert abs(result["normal_force"].values[39] / sneddon - 1) < 1e-12
