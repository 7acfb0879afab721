"""
A rubbing ball between floor and table
======================================

A ball that grips flies against the floor, the underside of a table and the floor again, with partial slip in every contact. It comes back from under the
table (Garwin 1969). Every bounce agrees with `impact`, and the balance of energies closes.
"""

import math

import matplotlib.style
import numpy as np
from matplotlib.figure import Figure

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

rubber = mdr.Elastic("10 MPa", 0.49)
grip = mdr.Contact(mdr.Paraboloid("25 mm"), rubber, friction=mdr.Coulomb(2.0))
mass, radius, gap = 0.06, 0.025, 0.01  # kg, m, and the way in m from the floor to the table
normal, along = 2.0, 1.0  # m/s

bodies = [
    mdr.Mass("down", mass, velocity=normal),
    mdr.Mass("along", mass, velocity=along),
    mdr.Rotor("ball", 0.4 * mass * radius**2, radius),
]
links = [
    mdr.Joint(grip, "down", {"along": 1, "ball": 1}, name="floor"),
    mdr.Joint(grip, {"down": -1}, {"along": 1, "ball": -1}, indentation=-gap, name="table"),
]
first = mdr.impact(grip, mass=mass, speed=math.hypot(normal, along), angle=math.atan2(along, normal))
duration = 3.2 * first.contact_time + 2.2 * gap / normal
motion = mdr.move(mdr.Machine(bodies, links), duration, steps=600, accuracy=1e-5)

time, forces = motion["time"].values * 1e3, motion["tangential_force"].values
figure = Figure(figsize=(9.6, 3.6), layout="constrained")
left, right = figure.subplots(1, 2)
left.plot(motion["position"].sel(body="along") * 1e3, -motion["position"].sel(body="down") * 1e3)
left.set(xlabel="position along the floor (mm)", ylabel="height (mm)")
for i, name in enumerate(("floor", "table")):
    right.plot(time, forces[:, i], label=name)
right.set(xlabel="time (ms)", ylabel="tangential force (N)")
right.legend()
figure.savefig("ball_under_a_table.png")
print("figure saved as ball_under_a_table.png")

# %%
# Between the floor and the table the ball moves as after one `impact`; after three bounces it comes back:
free = (motion["normal_force"].values == 0.0).all(axis=1)
bounced = int(np.flatnonzero(free & (motion["velocity"].sel(body="down").values < 0.0))[0])
speed = float(motion["velocity"].sel(body="along")[bounced])
last = float(motion["velocity"].sel(body="along")[-1])
dissipated = float(motion["dissipated_energy"][-1] / motion["kinetic_energy"][0])
print(f"along the floor after the first bounce: {speed:.6f} m/s, impact {first.tangential_speed:.6f} m/s")
print(f"after three bounces: {last:.3f} m/s; slip has dissipated {100 * dissipated:.2f} % of the energy")
assert abs(speed / first.tangential_speed - 1.0) < 1e-4
assert last < 0.0 < speed
