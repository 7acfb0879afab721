"""
AFM tip on a gel
================

A colloidal tip on a soft cantilever approaches a gel, jumps into contact, is pressed and pulled off. The piezo moves the base of
the cantilever: its travel is the indentation plus the force over the stiffness. A soft cantilever loses contact near the
largest pull, -3/2 pi work R; a stiff cantilever loses contact only at -5/6 pi work R.
"""

import math

import pymdr as mdr

tip = mdr.Paraboloid(radius="50 um")
gel = mdr.Elastic(young="30 kPa", poisson=0.5)
contact = mdr.Contact(tip, gel, adhesion=mdr.JKR(work="2 mJ/m^2"))

result = mdr.solve(
    contact,
    mdr.travel("5 um", steps=100) >> mdr.travel("-20 um", steps=500),
    machine_stiffness="0.05 N/m",
)
print(result.summary())
figure = result.figures()["loop"]
figure.savefig("afm_tip_on_gel.png")
print("figure saved as afm_tip_on_gel.png")

# %%
# The exact pull-off for any cantilever, without following a path:
for stiffness in (0.0, "0.05 N/m", "1 N/m", math.inf):
    print(stiffness, mdr.pull_off(contact, machine_stiffness=stiffness), sep="\n")
scale = math.pi * 2e-3 * 50e-6
assert abs(mdr.pull_off(contact, machine_stiffness=0.0).normal_force / scale + 3 / 2) < 1e-12
assert abs(mdr.pull_off(contact).normal_force / scale + 5 / 6) < 1e-12
assert result.status is mdr.Status.PULLED_OFF
