"""
A ring contact
==============

Boundary elements on rings solve the hollow cylinder that the method refuses. The result has the same form, and its claims
state that the method was not used.
"""

import pymdr as mdr

b, R = 1e-3, 0.5
hollow = mdr.ConcavePunch(radius=b, hollow_radius=R)
contact = mdr.Contact(hollow, mdr.Elastic(young="3 MPa", poisson=0.5))
path = mdr.indent("1.5 um", steps=3)

result = mdr.solve(contact, path, solver=mdr.Rings(n=150))
print(result.summary())
figure = result.plot()
figure.savefig("hollow_punch_by_rings.png")
print("figure saved as hollow_punch_by_rings.png")

# %%
# The true force is above the rigorous bound of the refused solution.
bound = mdr.solve(contact, path)["force_lower_bound"]
assert (result["normal_force"] > bound).all()
assert float(result["inner_contact_radius"][-1]) > 0.4 * b
