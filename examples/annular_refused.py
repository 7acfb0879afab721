"""
A contact that is refused
=========================

A cylinder with a hollow end touches with its edge first. The contact is a ring, and the method is not valid until the hollow is
pressed flat. pymdr states this, gives the loads of the disk, and a rigorous lower bound of the force.
"""

import pymdr as mdr

b, R = 1e-3, 0.5
hollow = mdr.ConcavePunch(radius=b, hollow_radius=R)
contact = mdr.Contact(hollow, mdr.Elastic(young="3 MPa", poisson=0.5))

result = mdr.solve(contact, mdr.indent("1.5 um", steps=3))
print(result.summary())
try:
    result["contact_radius"]
except mdr.NotValidError as refusal:
    print(refusal)
figure = result.plot()
figure.savefig("annular_refused.png")
print("figure saved as annular_refused.png")

# %%
# The bound for an indentation d: 2 E* (d b + b^3 / (3 R)), the load of the full disk (Barber 1974).
modulus = mdr.effective_moduli(contact.body).normal
bound = 2 * modulus * (1.5e-6 * b + b**3 / (3 * R))
assert abs(result["force_lower_bound"].values[-1] / bound - 1) < 1e-12

# %%
# From d = b^2 / R = 2 um on, the end is in full contact and everything is exact.
flat = mdr.solve(contact, mdr.indent("2.5 um"))
assert flat.status is mdr.Status.COMPLETED
