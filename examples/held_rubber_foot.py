"""
A rubber foot that is pushed and held
=====================================

A rubber foot is pressed on a plate, pushed sideways until it slips near the edge, held, and pushed back. Springs with memory and friction are
followed step by step, as a machine or a particle code moves them. Normal and tangential springs of incompressible rubber relax by the same
function, so that what sticks goes on to stick while both forces fall.
"""

import matplotlib.style
import numpy as np
from matplotlib.figure import Figure

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

solid = mdr.StandardSolid("1 MPa", "3 MPa", "0.5 s")
foot = mdr.Contact(mdr.Paraboloid("10 mm"), mdr.Viscoelastic(solid, poisson=0.5), friction=mdr.Coulomb(0.5))
stepper = mdr.Stepper(foot, "100 um", springs=200)

# %%
# Pressed and pushed at once; a duration of 0 is a sudden step:
stepper.advance(100e-6, duration=0.0)
sudden = stepper.advance(100e-6, shift=25e-6, duration=0.0)

# %%
# Held for three seconds, pushed back in one, and held again:
time, shift = [0.0], [25e-6]
for _ in range(15):
    time.append(time[-1] + 0.2)
    shift.append(shift[-1])
for target in np.linspace(25e-6, -25e-6, 11)[1:]:
    time.append(time[-1] + 0.1)
    shift.append(float(target))
rows = [(*sudden, stepper.stick_radius)]
for duration, u in zip(np.diff(time), shift[1:], strict=True):
    forces = stepper.advance(100e-6, shift=u, duration=float(duration))
    rows.append((*forces, stepper.stick_radius))
normal, tangential, stick = np.array(rows).T

# %%
# Both forces have relaxed by the modulus of the rubber, and the radius that sticks has not changed:
relaxed = solid.relaxation(3.0) / solid.relaxation(0.0)
print(
    f"after 3 s: {tangential[15] / tangential[0]:.6f} of the tangential force, {relaxed:.6f} of the modulus"
)
print(f"dissipated: {stepper.dissipated_energy * 1e6:.3f} µJ")
assert abs(tangential[15] / tangential[0] / relaxed - 1) < 1e-9
assert abs(stick[15] / stick[0] - 1) < 1e-9

figure = Figure(figsize=(5.6, 3.6), layout="constrained")
axes = figure.subplots()
axes.plot(time, tangential, label="tangential force")
axes.plot(time, 0.5 * normal, "k--", lw=0.8, label="limit of sliding")
axes.plot(time, -0.5 * normal, "k--", lw=0.8)
axes.set(xlabel="time (s)", ylabel="force (N)")
figure.legend(loc="outside upper right", ncols=2)
figure.savefig("held_rubber_foot.png")
print("figure saved as held_rubber_foot.png")
