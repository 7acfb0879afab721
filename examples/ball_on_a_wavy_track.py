"""
A ball that rolls over a wavy track
===================================

A ball of a bearing is loaded and rolls over waves of 1 mm length. Low waves press it by the formula of a mass on a spring; high waves throw it off
the track, and the spectrum of the normal force, which a sensor of acoustic emission measures, has many more lines.
"""

import math

import matplotlib.style
import numpy as np
from matplotlib.figure import Figure

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

steel = mdr.Elastic("210 GPa", 0.3)
ball = mdr.Contact(mdr.Paraboloid("10 mm"), steel, steel)
mass, load, speed, length = 0.033, 50.0, 2.0, 1e-3  # kg, N, m/s, m
frequency = speed / length
rest = mdr.solve(ball, mdr.load(load))
depth, stiffness = float(rest["indentation"][0]), float(rest["normal_stiffness"][0])


def rolled(height, duration, start=0.0, **accuracy):
    """The motion of the ball over waves of an amplitude in m, from an upward speed in m/s."""
    machine = mdr.Machine(
        bodies=[
            mdr.Mass("ball", mass, depth, start),
            mdr.Drive("track", amplitude=height, frequency=frequency),
        ],
        links=[mdr.Joint(ball, {"ball": 1, "track": 1}, name="contact"), mdr.Force("ball", load)],
    )
    return mdr.move(machine, duration, steps=2000, **accuracy)


# %%
# A start at the speed of the steady motion leaves no free vibration. The force of low waves has the amplitude w k m omega^2 divided by the size of k - m omega^2:
omega = 2.0 * math.pi * frequency
inertia, low = mass * omega**2, 1e-9
gentle = rolled(low, "10 ms", start=-low * omega * stiffness / (stiffness - inertia))
expected = low * stiffness * inertia / abs(stiffness - inertia)
amplitude = float(gentle.spectrum("normal_force", "contact").sel(frequency=frequency))

high = rolled(4e-6, "10 ms", accuracy=0.05)
force = high["normal_force"].values[:, 0]
jumps = int(np.count_nonzero((force[:-1] > 0.0) & (force[1:] == 0.0)))

figure = Figure(figsize=(9.6, 3.6), layout="constrained")
left, right = figure.subplots(1, 2)
left.plot(high["time"] * 1e3, force, label="waves of 4 µm")
left.plot(gentle["time"] * 1e3, gentle["normal_force"].values[:, 0], label="waves of 1 nm")
left.set(xlabel="time (ms)", ylabel="normal force (N)", xlim=(0.0, 5.0), ylim=(-5.0, 210.0))
left.legend(loc="upper right")
for motion, label in ((high, "waves of 4 µm"), (gentle, "waves of 1 nm")):
    lines = motion.spectrum("normal_force", "contact")
    right.semilogy(lines["frequency"] / 1e3, np.maximum(lines, 1e-6), lw=0.8, label=label)
right.set(
    xlabel="frequency (kHz)", ylabel="amplitude of the normal force (N)", xlim=(0.0, 20.0), ylim=(1e-5, None)
)
right.legend()
figure.savefig("ball_on_a_wavy_track.png")
print("figure saved as ball_on_a_wavy_track.png")

print(f"low waves: {amplitude * 1e3:.3f} mN at {frequency / 1e3:g} kHz, formula {expected * 1e3:.3f} mN")
print(
    f"high waves: the ball leaves the track {jumps} times in 10 ms, the largest force is {force.max():.0f} N"
)
assert abs(amplitude / expected - 1.0) < 1e-3
