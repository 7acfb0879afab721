"""
Springs pressed by hand
=======================

The first lesson of ``pymdr explore`` as a program: springs under a ball, and the three steps of the method. Every step of the force along the line is
the pressure of a flat punch; their sum approaches Hertz' pressure as the square root of the spacing, the force much faster.
"""

import math

import matplotlib.style
import numpy as np
from matplotlib.figure import Figure

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

ball = mdr.Contact(mdr.Paraboloid("10 mm"), mdr.Elastic("1 GPa", 0.3))
depth, half = 5e-6, 0.3e-3
exact = mdr.solve(ball, mdr.indent(depth))


def pressed(n):
    """Positions, forces per length and pressures of n springs on one side of the axis."""
    # step 1 maps f(r) to g(x), step 2 presses the spring at x by d - g(x)
    springs = mdr.foundation(ball, n=2 * n, half_length=half)
    x, q = springs.position[n:], springs.spring_forces(depth)[n:] / springs.spacing
    # step 3: p(r) = sum (q_i - q_(i+1)) / (pi sqrt(x_i^2 - r^2)) with the outer edge x_i of a spring
    square = (x + 0.5 * springs.spacing) ** 2 - x[:, None] ** 2
    punches = np.divide(1 / math.pi, np.sqrt(np.abs(square)), out=np.zeros((n, n)), where=square > 0)
    return x, q, punches @ (q - np.append(q[1:], 0.0))


errors = []
for n in (15, 60, 240):
    x, q, pressure = pressed(n)
    force = 2 * np.sum(q) * (x[1] - x[0]) / float(exact["normal_force"][0])
    i = int(np.argmin(np.abs(x - 1e-4)))
    errors.append(pressure[i] / float(exact.field("pressure", r=x[i]).values[0]) - 1)
    print(f"{n:4} springs: force {force - 1:+.1e}, pressure at r = {x[i] * 1e6:.0f} um {errors[-1]:+.1%}")
assert abs(errors[1] / errors[2] - 2) < 0.1

# %%
# The three steps with springs that can be counted.
x, q, pressure = pressed(15)
figure = Figure(figsize=(9, 3), layout="constrained")
profile, line, field = figure.subplots(1, 3)
radius = np.linspace(0, half, 200)
profile.plot(radius * 1e6, ball.profile.gap(radius) * 1e6, label="profile f(r)")
profile.plot(x * 1e6, mdr.foundation(ball, n=30, half_length=half).profile[15:] * 1e6, ".", label="line g(x)")
profile.set(xlabel="r, x (µm)", ylabel="height (µm)")
line.bar(x * 1e6, q * 1e-3, width=0.8 * (x[1] - x[0]) * 1e6)
line.set(xlabel="x (µm)", ylabel="force per length (N/mm)")
field.plot(x * 1e6, pressure / 1e6, "o", label="springs")
field.plot(x * 1e6, exact.field("pressure", r=x).values / 1e6, label="exact")
field.set(xlabel="r (µm)", ylabel="pressure (MPa)")
for axes in (profile, field):
    axes.legend()
figure.savefig("springs_by_hand.png")
print("figure saved as springs_by_hand.png")
