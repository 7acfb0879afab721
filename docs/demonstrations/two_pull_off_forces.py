"""
Two pull-off forces
===================

The equation of Argatov's discussion for the radius of an adhesive contact, d = g(a) - dl(a) (its eq. 14), has two roots at
negative depths, without a criterion for the root and for the loss of contact. It is often said that a JKR contact separates at
-3/2 pi work R. This is correct under a dead load. At a prescribed indentation the same contact separates at -5/6 pi work R, and with
a cantilever between the two values. Law and machine together determine the pull-off force.
"""

import math

import matplotlib.style
import numpy as np
from matplotlib.figure import Figure

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

R, work = 50e-6, 2e-3
gel = mdr.Elastic("30 kPa", 0.5)
contact = mdr.Contact(mdr.Paraboloid(R), gel, adhesion=mdr.JKR(work))
unit = math.pi * work * R

dead = mdr.pull_off(contact, machine_stiffness=0)
rigid = mdr.pull_off(contact, machine_stiffness=math.inf)
print(f"dead load {dead.normal_force / unit:.6f}, indentation {rigid.normal_force / unit:.6f} pi work R")
assert abs(dead.normal_force / unit + 3 / 2) < 1e-12
assert abs(rigid.normal_force / unit + 5 / 6) < 1e-12

# %%
# At d = -0.5 um the equation has two roots; a path takes the stable one.
E = mdr.effective_moduli(gel).normal
depth = -0.5e-6
a = np.linspace(1e-9, 15e-6, 200_001)
excess = a**2 / R - np.sqrt(2 * math.pi * a * work / E) - depth
roots = a[1:][np.diff(np.sign(excess)) != 0]
assert roots.size == 2
taken = float(mdr.solve(contact, mdr.indent("1 um") >> mdr.indent(depth))["contact_radius"][-1])
assert abs(taken - roots[1]) < 1e-10

# %%
# Every force between the two is the pull-off force of some machine.
stiffness = np.geomspace(1e-3, 1e3, 41)
forces = np.array([mdr.pull_off(contact, machine_stiffness=float(k)).normal_force for k in stiffness]) / unit
assert np.all(np.diff(forces) > 0)
assert -1.5 < forces[0] < -1.49
assert -0.85 < forces[-1] < -5 / 6

figure = Figure(figsize=(6, 3.4), layout="constrained")
axes = figure.subplots()
axes.semilogx(stiffness, forces)
axes.axhline(-3 / 2, color="k", ls=":", lw=1)
axes.axhline(-5 / 6, color="k", ls=":", lw=1)
axes.text(1.2e-3, -5 / 6 - 0.045, "-5/6, prescribed indentation")
axes.text(12.0, -3 / 2 + 0.02, "-3/2, dead load")
axes.set_xlabel("stiffness of the machine (N/m)")
axes.set_ylabel(r"pull-off force / $\pi w R$")
