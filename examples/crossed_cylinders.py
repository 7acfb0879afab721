"""
Crossed cylinders
=================

Two steel wires of different radii cross at a right angle. The contact is an ellipse, which Hertz solved exactly. The example
compares it with the lower bound by the mean over all directions, and with the estimate for any gap.
"""

import pymdr as mdr

steel = mdr.Elastic(young="210 GPa", poisson=0.3)
wires = mdr.EllipticParaboloid(radius_x="2 mm", radius_y="1 mm")
result = mdr.solve(mdr.Contact(wires, steel, steel), mdr.load("10 N", steps=20))
print(result.summary())
figure = result.plot()
figure.savefig("crossed_cylinders.png")
print("figure saved as crossed_cylinders.png")

# %%
# The largest pressure, p = 3 F / (2 pi a b), and the errors of bound and estimate.
area = result["contact_area"][-1]
assert abs(float(result["peak_pressure"][-1] / (1.5 * 10.0 / area)) - 1) < 1e-12
below = 1 - float(result["force_lower_bound"][-1]) / 10.0
above = float(result["force_estimate"][-1]) / 10.0 - 1
assert 0.038 < below < 0.040
assert 1.3e-4 < above < 1.5e-4

# %%
# The same gap as a callable has only bound and estimate. The bound is sharper here, that of the best ellipse.
own = mdr.Function2D(lambda x, y: x**2 / (2 * 2e-3) + y**2 / (2 * 1e-3))
depth = float(result["indentation"][-1])
estimated = mdr.solve(mdr.Contact(own, steel, steel), mdr.indent(depth))
assert abs(float(estimated["normal_force"][0]) / 10.0 - 1) < 2e-4
assert abs(float(estimated["force_lower_bound"][0]) / 10.0 - 1) < 1e-6
