"""
Steel ball on glass
===================

A bearing-steel ball of 10 mm radius is pressed on a flat of soda-lime glass. This is Hertz' problem with the true sphere instead
of the paraboloid: exact for elastic half-spaces.
"""

import pymdr as mdr

steel = mdr.Elastic(young="210 GPa", poisson=0.30)
glass = mdr.Elastic(young="70 GPa", poisson=0.22)
ball = mdr.Sphere(radius="10 mm")

contact = mdr.Contact(ball, steel, glass)
result = mdr.solve(contact, mdr.load("50 N", steps=50))

print(result.summary())
largest_pressure = result.field("pressure", r=0.0).values[0]
print(f"largest pressure {largest_pressure / 1e6:.1f} MPa")

figure = result.plot()
figure.savefig("ball_on_glass.png")
print("figure saved as ball_on_glass.png")

# %%
# Hertz' formula for the paraboloid, a^3 = 3 F R / (4 E*), differs by (a/R)^2 only.
hertz = (3 * 50.0 * 10e-3 / (4 * mdr.effective_moduli(steel, glass).normal)) ** (1 / 3)
assert abs(result["contact_radius"].values[-1] / hertz - 1) < 2 * (hertz / 10e-3) ** 2
