"""
The missing prime of equation (6)
=================================

The mapping rule of Argatov's discussion (its eq. 6) is printed with f(r) instead of f'(r). Then the dimension is wrong: the
right-hand side is an area. Its own example, g = x^2 / R for a paraboloid, needs the prime.
"""

import matplotlib.style
import numpy as np
from matplotlib.figure import Figure

import pymdr as mdr
from pymdr.mapping import abel

matplotlib.style.use("pymdr.figures")

R = 2.0
with_prime = abel.forward(lambda r: r / R, 1.0)
without = abel.forward(lambda r: r**2 / (2 * R), 1.0)
print(f"with f': g(1) = {float(with_prime):.6f}; with f: {float(without):.6f}")
print(f"x^2/R = {1 / R:.6f}")

assert abs(with_prime - 1 / R) < 1e-14
assert abs(without - 1 / R) > 0.3

# %%
# Doubling all lengths must double g. Only the rule with the prime does that.
assert np.isclose(mdr.equivalent_profile(mdr.Paraboloid(2 * R)).g(2.0), 2 * with_prime)

x = np.linspace(0.0, 1.0, 101)[1:]
figure = Figure(figsize=(6, 3.4), layout="constrained")
axes = figure.subplots()
axes.plot(x, x**2 / R, "k", label="x²/R, known from Hertz")
axes.plot(x, abel.forward(lambda r: r / R, x), "--", label="with f'")
axes.plot(x, abel.forward(lambda r: r**2 / (2 * R), x), label="with f, as printed")
axes.set_xlabel("x (m)")
axes.set_ylabel("g (m)")
axes.legend()
