"""
Fretting fatigue of a joint
===========================

A pad is pressed on a bar whose bulk stress cycles in phase with the tangential force. Criteria of fatigue give the place and the plane at which a crack starts.
"""

import numpy as np

import pymdr as mdr

alloy = mdr.Elastic(young="73 GPa", poisson=0.33)
joint = mdr.Contact(mdr.Paraboloid("75 mm"), alloy, alloy, friction=mdr.Coulomb(0.6))
path = mdr.load("400 N") >> mdr.cycle(tangential_force="150 N", cycles=2, steps=48)
result = mdr.solve(joint, path)

# %%
# The bulk stress, 80 MPa at the largest tangential force. The parameter of Smith, Watson and Topper is largest at the trailing edge, on a
# plane at right angles to the surface.

bulk = 80e6 * result["tangential_force"] / 150.0
worst = mdr.fatigue(result, criterion=mdr.SmithWatsonTopper(), superposed={"xx": bulk})
print(worst)
figure = worst.plot()
figure.savefig("fretting_fatigue.png")
print("figure saved as fretting_fatigue.png")
assert abs(abs(worst.x) / float(result["contact_radius"][-1]) - 1) < 1e-3
assert abs(worst.plane[0]) > 0.999

# %%
# Dang Van's criterion with the limits of the alloy, with and without the bulk stress: the joint fails by the bulk stress.

criterion = mdr.DangVan(hydrostatic_slope=0.4, endurance_limit="110 MPa")
for added in (None, {"xx": bulk}):
    print(float(mdr.fatigue(result, criterion=criterion, superposed=added)["fatigue_ratio"]))

# %%
# The damage parameter of Ruiz on the surface: inside the slip annulus, where tension, shear and slip meet.

ruiz = mdr.fatigue(result, criterion=mdr.RuizDamage(), superposed={"xx": bulk})
figure = ruiz.plot()
figure.savefig("fretting_fatigue_2.png")
print("figure saved as fretting_fatigue_2.png")
assert np.hypot(ruiz.x, ruiz.y) < float(result["contact_radius"][-1])
