"""
Loop of a joint
===============

A joint vibrates tangentially under constant load. Its edge slips in every cycle, long before the joint slides as a whole. This
partial slip is the source of damping, and it grows with the cube of the amplitude.
"""

import numpy as np

import pymdr as mdr

steel = mdr.Elastic(young="210 GPa", poisson=0.3)
joint = mdr.Contact(mdr.Sphere("10 mm"), steel, steel, friction=mdr.Coulomb(0.3))

result = mdr.solve(joint, mdr.load("50 N") >> mdr.cycle(shift="0.6 um", cycles=2, steps=400))
print(result.summary())
figure = result.figures(step=250)["loop"]
figure.savefig("bolted_joint_loop.png")
print("figure saved as bolted_joint_loop.png")

# %%
# The same over many amplitudes:
study = mdr.friction_loop(joint, np.geomspace(10e-9, 1.2e-6, 40), normal_force="50 N")
print(study.data)

# %%
# The dissipation of the loop above agrees with the study:
followed = result["dissipated_energy"].values
loss = mdr.friction_loop(joint, [0.6e-6], normal_force="50 N")["dissipated_per_cycle"].values[0]
assert abs((followed[-1] - followed[-201]) / loss - 1) < 1e-9
