"""
A ring contact
==============

The hollow cylinder that the method refuses, solved by boundary elements on rings: a result of the same kind,
whose claims say that the method was not used.
"""

import pymdr as mdr

b, R = 1e-3, 0.5
hollow = mdr.ConcavePunch(radius=b, hollow_radius=R)
contact = mdr.Contact(hollow, mdr.Elastic(young="3 MPa", poisson=0.5))
path = mdr.indent("1.5 um", steps=3)

result = mdr.solve(contact, path, solver=mdr.Rings(n=150))
print(result.summary())
figure = result.plot()

# %%
# The true force lies above the rigorous bound that the refused solution keeps.
bound = mdr.solve(contact, path)["force_lower_bound"]
assert (result["normal_force"] > bound).all()
assert float(result["inner_contact_radius"][-1]) > 0.4 * b
