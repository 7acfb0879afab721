"""
A ball on rubber
================

A ball is pressed into rubber, held, and retracted. The force relaxes during the hold. In the retraction the ball loses contact
before it returns to its first touch, because the rubber recovers more slowly.
"""

import numpy as np
from scipy.special import dawsn

import pymdr as mdr

rubber = mdr.Viscoelastic(mdr.StandardSolid(equilibrium="1 MPa", modulus="3 MPa", time="50 ms"), poisson=0.5)
ball = mdr.Contact(mdr.Paraboloid("5 mm"), rubber)
path = (
    mdr.indent("0.1 mm", rate="2 mm/s", steps=60)
    >> mdr.hold("0.1 s", steps=40)
    >> mdr.indent("0 mm", rate="2 mm/s", steps=60)
)
result = mdr.solve(ball, path)
print(result.summary())
figure = result.plot()
figure.savefig("rubber_indentation.png")
print("figure saved as rubber_indentation.png")

# %%
# In the approach at a constant speed v a standard solid has the force of its spring and of its Maxwell branch,
# F = (16/3) G sqrt(R) d^(3/2) + 8 G1 sqrt(R) v^(3/2) tau [sqrt(t) - sqrt(tau) D(sqrt(t / tau))], with Dawson's function D.
G, G1, tau, v, R, t = 1e6, 3e6, 50e-3, 2e-3, 5e-3, 50e-3
spring = 16 / 3 * G * np.sqrt(R) * (v * t) ** 1.5
branch = 8 * G1 * np.sqrt(R) * v**1.5 * tau * (np.sqrt(t) - np.sqrt(tau) * dawsn(np.sqrt(t / tau)))
assert abs(float(result["normal_force"][59]) / (spring + branch) - 1) < 1e-9

# %%
# The contact is lost in the retraction, while the ball is still below the surface:
separated = np.flatnonzero((result["normal_force"].values == 0) & (result["indentation"].values > 0))
print(f"no contact from {1e6 * float(result['indentation'][separated[0]]):.0f} um on")
assert separated.size > 0
