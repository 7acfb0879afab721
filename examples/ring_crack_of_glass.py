"""
Ring crack of glass
===================

A steel ball of 10 mm is pressed on a glass plate. The surface around the contact is in tension. The example gives the load below which the plate
does not crack, and the smaller load if the ball slides.
"""

import pymdr as mdr

glass = mdr.Elastic("70 GPa", 0.22)
steel = mdr.Elastic("210 GPa", 0.3)
ball = mdr.Sphere("5 mm")
contact = mdr.Contact(ball, glass, steel)

# %%
# Flaws of the surface limit its strength to about 400 MPa. The crack starts at the edge of the contact, long before yield.

failure = mdr.first_yield(contact, strength="3.6 GPa", tensile_strength="400 MPa")
print(failure)
ring = failure.data.sel(criterion="largest tension")
# the tension is (1 - 2 nu) p0 / 3 (Johnson 1985, section 3.4); that of the true sphere differs by the square of its slope
assert abs(float(ring["peak_pressure"]) / (3 * 400e6 / (1 - 2 * 0.22)) - 1) < 2e-3

# %%
# The largest principal stress at that load, in section and along the surface.

result = mdr.solve(contact, mdr.load(float(ring["normal_force"])))
figure = result.plot_stress(name="principal_stress", side="body")
figure.savefig("ring_crack_of_glass.png")
print("figure saved as ring_crack_of_glass.png")

# %%
# A ball that slides with a coefficient of friction of 0.1 cracks the glass behind it under a fraction of that load.

sliding = mdr.Contact(ball, glass, steel, friction=mdr.Coulomb(0.1))
dragged = mdr.first_yield(sliding, strength="3.6 GPa", tensile_strength="400 MPa").data.sel(
    criterion="largest tension"
)
print(f"{float(dragged['normal_force'] / ring['normal_force']):.2f} of the load")
