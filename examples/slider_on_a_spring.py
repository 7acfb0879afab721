"""
Stick and slip of a slider
==========================

A stage pulls a slider by a spring. The contact has one coefficient of friction, so that nothing falls when slip begins. Still the slider stops
once a period: it slides with v (1 - cos(omega t)), and the spring force swings by v sqrt(k m), here as a map over speed and stiffness. Partial slip
of the contact damps the swing.
"""

import math

import matplotlib.style
import numpy as np
from matplotlib.figure import Figure

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

steel = mdr.Elastic("210 GPa", 0.3)
pad = mdr.Contact(mdr.Paraboloid("10 mm"), steel, steel, friction=mdr.Coulomb(0.3))
limit = 0.3 * float(mdr.solve(pad, mdr.indent("1 um"))["normal_force"][0])


def pulled(speed, stiffness):
    """Four periods after the first slip of a slider of 1 kg."""
    machine = mdr.Machine(
        bodies=[mdr.Mass("slider", "1 kg"), mdr.Drive("stage", velocity=speed)],
        links=[
            mdr.Spring(("stage", "slider"), stiffness),
            mdr.Joint(pad, tangential="slider", indentation="1 um"),
        ],
    )
    start, period = limit / (stiffness * speed), 2 * math.pi / math.sqrt(stiffness)
    motion = mdr.move(machine, start + 4 * period, steps=500)
    force = stiffness * (speed * motion["time"].values - motion["position"].values[:, 0])
    return motion, force, motion["time"].values > start + 2 * period


speeds, stiffnesses = np.geomspace(1e-3, 1e-1, 4), np.geomspace(1e3, 1e5, 4)
swing = np.empty((speeds.size, stiffnesses.size))
for i, speed in enumerate(speeds):
    for j, stiffness in enumerate(stiffnesses):
        _, force, late = pulled(float(speed), float(stiffness))
        swing[i, j] = 0.5 * np.ptp(force[late])

motion, force, _ = pulled(2e-3, 2e3)
figure = Figure(figsize=(9.6, 3.6), layout="constrained")
left, right = figure.subplots(1, 2)
left.plot(motion["time"], force, label="spring")
left.plot(motion["time"], motion["tangential_force"].values[:, 0], label="friction")
left.set(xlabel="time (s)", ylabel="force (N)")
left.legend()
shown = right.pcolormesh(stiffnesses, speeds, swing, shading="nearest", norm="log")
right.set(xscale="log", yscale="log", xlabel="stiffness (N/m)", ylabel="speed (m/s)")
figure.colorbar(shown, ax=right, label="swing of the force (N)")
figure.savefig("slider_on_a_spring.png")
print("figure saved as slider_on_a_spring.png")

# %%
# A soft spring swings by v sqrt(k m):
print(
    f"swing of the softest and slowest: {swing[0, 0]:.4f} N, formula {speeds[0] * math.sqrt(stiffnesses[0]):.4f} N"
)
assert abs(swing[0, 0] / (speeds[0] * math.sqrt(stiffnesses[0])) - 1) < 0.02
