"""
Impact of a ball
================

A steel ball hits a steel plate at 40 degrees. Its normal motion is that of Hertz. Tangentially it slips, sticks and slips back,
and it leaves with a spin. Two slow impacts of a soft ball show the effect of adhesion: below the sticking speed it does not
rebound.
"""

import matplotlib.style
import numpy as np
from matplotlib.figure import Figure

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

steel = mdr.Elastic(young="210 GPa", poisson=0.3)
ball = mdr.Contact(mdr.Sphere("10 mm"), steel, steel, friction=mdr.Coulomb(0.3))
hit = mdr.impact(ball, mass="33 g", speed="0.3 m/s", angle="40 deg")
print(hit)
hit.plot()

# %%
# The contact time of a sphere decreases with the fifth root of its speed.

speeds = np.geomspace(0.01, 1.0, 200)
times = mdr.restitution(ball, mass="33 g", speeds=speeds)["contact_time"].values
slope = np.polyfit(np.log(speeds), np.log(times), 1)[0]
assert abs(slope + 0.2) < 1e-3  # the true sphere is not a paraboloid

# %%
# Restitution of a soft ball with adhesion: :math:`e = \sqrt{1 - (v_s / v)^2}`.

gel = mdr.Contact(mdr.Paraboloid("1 mm"), mdr.Elastic("30 kPa", 0.5), adhesion=mdr.JKR("50 mJ/m^2"))
slow = np.geomspace(0.05, 1.0, 60)
rebounds = mdr.restitution(gel, mass="1 mg", speeds=slow)

figure = Figure(figsize=(4.8, 3.4), layout="constrained")
axes = figure.subplots()
axes.semilogx(slow, rebounds["restitution"], "o-", ms=3)
axes.set(xlabel="normal speed (m/s)", ylabel="coefficient of restitution", ylim=(-0.03, 1.03))
figure.savefig("impact_of_a_ball.png")
print("figure saved as impact_of_a_ball.png")
