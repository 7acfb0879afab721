"""
Bouncing on rubber
==================

A ball falls on rubber with a relaxation time of 0.1 ms. In slow impacts the rubber has its rubbery modulus and dissipates little. The loss
grows until the contact time is about the relaxation time. Rubber with a relaxation time of 10 ms is glassy in the same impacts, and faster
impacts lose less.
"""

import math

import matplotlib.style
import numpy as np
from matplotlib.figure import Figure

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

rubber = mdr.Viscoelastic(mdr.StandardSolid("1 MPa", "3 MPa", "0.1 ms"), poisson=0.5)
ball = mdr.Contact(mdr.Paraboloid("5 mm"), rubber)
hit = mdr.impact(ball, mass="1 g", speed="0.3 m/s")
print(hit)

# %%
# A body on springs and a dashpot, in units of its mass, radius, modulus and speed.

fluid = mdr.Contact(mdr.Paraboloid(1.0), mdr.Viscoelastic(mdr.KelvinVoigt(1.0, 0.3), poisson=0.5))
damped = mdr.impact(fluid, mass=1.0, speed=1.0)
assert math.isclose(damped.restitution, 0.4565759764, rel_tol=1e-9)

# %%
# Restitution over five decades of the speed, and the history of the impact above. The ball leaves before the rubber has recovered. The fastest
# impact has a contact of 0.28 radii; above 0.3, where slopes are not small, summary and figure of ``rebounds`` report it.

speeds = np.geomspace(1e-5, 1.5, 500)
rebounds = mdr.restitution(ball, mass="1 g", speeds=speeds)
assert all(assumption.met for assumption in rebounds.assumptions)
glassy = mdr.Viscoelastic(mdr.StandardSolid("1 MPa", "3 MPa", "10 ms"), poisson=0.5)
on_glass = mdr.restitution(mdr.Contact(mdr.Paraboloid("5 mm"), glassy), mass="1 g", speeds=speeds)

figure = Figure(figsize=(9.0, 3.4), layout="constrained")
left, right = figure.subplots(1, 2)
left.semilogx(speeds, rebounds["restitution"], label="relaxes in 0.1 ms")
left.semilogx(speeds, on_glass["restitution"], label="in 10 ms")
left.legend()
left.set(xlabel="speed (m/s)", ylabel="coefficient of restitution", ylim=(0, 1))
right.plot(1e6 * hit["indentation"], hit["normal_force"])
right.set(xlabel="indentation (µm)", ylabel="force (N)")
figure.savefig("bouncing_on_rubber.png")
print("figure saved as bouncing_on_rubber.png")
