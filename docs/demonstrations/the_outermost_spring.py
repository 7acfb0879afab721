"""
The outermost spring
====================

Argatov's discussion of the method describes adhesion as a strength of the springs (its eqs. 12 and 13) and adds that the critical
elongation depends on the unknown radius of the contact. That remark is essential. If springs keep the strength of the largest
load, the pull depends on that load. If they take the strength of the radius before the step, the contact survives beyond
equilibrium. Only a strength that is updated after every separated spring gives JKR, at any step.
"""

import math

import matplotlib.style
import numpy as np
from matplotlib.figure import Figure

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

# in units of R, E* and the work of adhesion
contact = mdr.Contact(mdr.Paraboloid(1.0), mdr.Elastic(0.75, 0.5), adhesion=mdr.JKR(1.0))
indented = mdr.pull_off(contact)

n, length, pressed = 4000, 2.4, 1.0
x = (np.arange(n) + 0.5) * length / n
g = x**2
strength = np.sqrt(2 * math.pi * x)
begin = int(np.searchsorted(g - strength, pressed))


def pulled(steps, rule):
    """Depths and forces while springs are pulled from d = 1 to d = -2.5 in equal steps."""
    depths = np.linspace(pressed, -2.5, steps + 1)
    attached, forces = begin, []
    for d in depths:
        before = attached
        while attached and g[attached - 1] - d > strength[rule(before, attached) - 1]:
            attached -= 1
        forces.append(2 * np.sum(d - g[:attached]) * length / n)
    return depths, np.array(forces)


rules = {
    "radius of the present": lambda before, now: now,
    "radius before the step": lambda before, now: before,
    "radius of the largest load": lambda before, now: begin,
}

# %%
# Updated strength: a sharp pull-off at the depth and the largest pull of JKR, for any number of steps.
for steps in (100, 1000):
    depths, forces = pulled(steps, rules["radius of the present"])
    in_contact = depths[forces != 0]
    assert abs(in_contact[-1] - indented.indentation) < 3.5 / steps
    assert abs(forces.min() / (-1.5 * math.pi) - 1) < 2e-3

# %%
# Strength of the radius before the step: contact survives beyond the last equilibrium, longer with coarser steps.
survives = []
for steps in (100, 1000):
    depths, forces = pulled(steps, rules["radius before the step"])
    survives.append(indented.indentation - depths[forces != 0][-1])
print(f"excess depth at pull-off: {survives[0]:.3f} in 100 steps and {survives[1]:.3f} in 1000")
assert survives[0] > 0.15
assert 0.0 < survives[1] < 0.06

# %%
# Strength of the largest load: 40 % more pull than JKR, and no pull-off.
depths, forces = pulled(1000, rules["radius of the largest load"])
print(f"largest pull {-forces.min() / math.pi:.3f} pi R work, JKR 1.5")
assert forces.min() / math.pi < -2.1
assert forces[-1] < 0

figure = Figure(figsize=(6, 3.6), layout="constrained")
axes = figure.subplots()
for (name, rule), style in zip(rules.items(), ("k", "C1--", "C3:"), strict=True):
    depths, forces = pulled(100, rule)
    axes.plot(depths, forces / math.pi, style, label=name)
axes.plot(indented.indentation, indented.normal_force / math.pi, "ko", label="last equilibrium of JKR")
axes.set_xlabel("indentation / $(w^2 R / E^{*2})^{1/3}$")
axes.set_ylabel(r"force / $\pi w R$")
axes.legend(fontsize=9)
