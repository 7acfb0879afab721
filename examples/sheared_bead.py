"""
A sheared bead
==============

A glass bead sticks to a soft gel and is pushed sideways without slip. The shear takes a part of the work of adhesion, so that the contact
shrinks until it jumps to slip. Without any load the bead bears three quarters of the shift that it bears under 1 uN: adhesion holds it.
"""

import math

import pymdr as mdr

bead = mdr.Paraboloid("50 um")
gel = mdr.Elastic("30 kPa", 0.5)
glued = mdr.Contact(bead, gel, adhesion=mdr.JKR("2 mJ/m^2"), friction=mdr.Coulomb(math.inf))

# %%
# The bead is loaded, and then pushed in small steps until it slips.
slips = {}
for load in (0.0, 0.5, 1.0):  # uN
    result = mdr.solve(glued, mdr.load(f"{load} uN") >> mdr.shift("3 um", steps=30))
    assert result.status is mdr.Status.SLIPPED
    a, force = result.to("contact_radius", "um"), result.to("tangential_force", "uN")
    last = int(force.notnull().values.nonzero()[0][-1])
    slips[load] = float(result.to("shift", "um")[last])
    print(
        f"{load:g} uN: a falls from {float(a[0]):.2f} to {float(a[last]):.2f} um, slip at {slips[load]:.1f} um"
    )
figure = result.figures(step=last)["shear"]
figure.savefig("sheared_bead.png")
print("figure saved as sheared_bead.png")

# %%
# The error of the claim is the difference from the view that shear leaves the contact as it is.
claim = result.claims["contact_radius"]
print(f"{claim.level.value}: the views differ by {100 * float(claim.error[last]):.0f} %")
assert 0.1 < float(claim.error[last]) < 0.5

# %%
# The energy that the edge releases is the work of adhesion in every row.
assert abs(float(result["energy_release_rate"][last]) / 2e-3 - 1) < 1e-9
