"""
First yield of a bearing ball
=============================

A steel ball of 10 mm is pressed on a steel plate. It yields first below the surface, on the axis, at 0.48 contact radii, when the
largest pressure is 1.61 times the yield strength.
"""

import pymdr as mdr

steel = mdr.Elastic(young="210 GPa", poisson=0.3)
contact = mdr.Contact(mdr.Sphere("5 mm"), steel, steel)
yields = mdr.first_yield(contact, strength="2 GPa")
print(yields)
figure = yields.plot()
figure.savefig("yield_of_a_bearing_ball.png")
print("figure saved as yield_of_a_bearing_ball.png")

# %%
# Hertz and Huber give the same load for a paraboloid; that of the true sphere differs by the square of its slope.

pressure = 2e9 / (2 * 0.3100205019545214)
modulus = 210e9 / (2 * (1 - 0.3**2))
exact = (3.141592653589793 * pressure) ** 3 * 5e-3**2 / (6 * modulus**2)
assert abs(yields.to("normal_force", "N").sel(criterion="von Mises").item() / exact - 1) < 1e-3

# %%
# Twice that load: the region beyond the strength, if the steel stayed elastic.

result = mdr.solve(contact, mdr.load(2 * exact))
print(result.to("largest_mises", "GPa"))
figure = result.plot_stress()
figure.savefig("yield_of_a_bearing_ball_2.png")
print("figure saved as yield_of_a_bearing_ball_2.png")
