"""
Bouncing on rubber
==================

A ball falls on rubber that relaxes in a tenth of a millisecond. Slow blows meet soft rubber and give back most; the shorter the contact, the more is
lost, until it lasts about as long as the relaxation. Rubber that relaxes in ten milliseconds is a glass for the same blows: the faster, the less is lost.
"""

import math

import numpy as np
from matplotlib.figure import Figure

import pymdr as mdr

rubber = mdr.Viscoelastic(mdr.StandardSolid("1 MPa", "3 MPa", "0.1 ms"), poisson=0.5)
ball = mdr.Contact(mdr.Paraboloid("5 mm"), rubber)
hit = mdr.impact(ball, mass="1 g", speed="0.3 m/s")
print(hit)

# %%
# A body on springs and a dashpot, in units in which its mass, radius, modulus and speed are 1.

fluid = mdr.Contact(mdr.Paraboloid(1.0), mdr.Viscoelastic(mdr.KelvinVoigt(1.0, 0.3), poisson=0.5))
damped = mdr.impact(fluid, mass=1.0, speed=1.0)
assert math.isclose(damped.restitution, 0.4565759764, rel_tol=1e-9)

# %%
# Restitution over five decades of the speed, and the history of the blow above. The ball leaves before the rubber is back. The fastest blow makes a
# contact of 0.28 radii: beyond 0.3, where slopes are no longer small, summary and figure of ``rebounds`` say so.

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
