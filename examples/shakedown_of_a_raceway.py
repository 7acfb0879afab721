"""
Shakedown of a raceway
======================

A ball rolls over a steel raceway again and again. The first passes yield below the surface and leave residual stresses behind. Up to the load
of shakedown these prevent further yield; it is several times the load of first yield, and friction lowers it.
"""

import pymdr as mdr

steel = mdr.Elastic(young="210 GPa", poisson=0.3)
contact = mdr.Contact(mdr.Paraboloid("5 mm"), steel, steel, friction=mdr.Coulomb(0.6))
limits = mdr.shakedown(contact, strength="2 GPa", force_ratio=[0.0, 0.3, 0.6])
print(limits)
figure = limits.plot()
figure.savefig("shakedown_of_a_raceway.png")
print("figure saved as shakedown_of_a_raceway.png")

# %%
# In free rolling the load of shakedown is 4.6 times that of first yield: the peak pressure may reach 4.63 times the yield stress in
# shear. Above a ratio of tangential and normal force of 0.3 the surface limits it. There the traction may reach the yield stress
# in shear, so that the peak pressure is this stress over the ratio.

print(limits["yield_multiple"].values)
assert abs(limits["pressure_ratio"].values[2] * 0.6 - 1) < 1e-4
