"""
Punch with a domed end
======================

The punch is a cylinder with a slightly domed end, written as a sum of two profiles. Below full contact it acts like a sphere. Above
full contact it acts like a flat punch, and the pressure at its edge becomes singular. pymdr gives the regular part and the amplitude of the singularity.
"""

import pymdr as mdr

rubber = mdr.Elastic(young="3 MPa", poisson=0.5)
punch = mdr.FlatPunch(radius="1 mm") + mdr.Paraboloid(radius="50 mm")
contact = mdr.Contact(punch, rubber)

result = mdr.solve(contact, mdr.indent("60 um", steps=60))
print(result.summary())
figure = result.plot()
figure.savefig("rounded_punch.png")
print("figure saved as rounded_punch.png")

# %%
# Full contact begins at d = b^2 / R = 20 um; from there the stiffness is that of the flat punch, 2 E* b.
stiffness = 2 * mdr.effective_moduli(rubber).normal * 1e-3
assert abs(result["normal_stiffness"].values[-1] / stiffness - 1) < 1e-12
assert float(result["edge_amplitude"][18]) == 0.0 < float(result["edge_amplitude"][-1])
