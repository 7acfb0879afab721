"""
A silicone probe at four speeds
===============================

A glass ball rests on a soft silicone and is pulled off at four speeds. A faster retraction pulls harder, because the surface at the
edge of the contact is loaded before it has relaxed.
"""

import matplotlib.style
from matplotlib.figure import Figure

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

ball = mdr.Paraboloid("1 mm")
silicone = mdr.Viscoelastic(mdr.StandardSolid("10 kPa", "30 kPa", "1 s"), poisson=0.5)
surfaces = mdr.MaugisDugdale("50 mJ/m^2", range="5 um")
probe = mdr.Contact(ball, silicone, adhesion=surfaces)

# %%
# The ball is pressed in, and rests until the silicone has relaxed. Forces within a thousandth of the largest are enough for a figure.
press = mdr.indent("20 um", steps=10, duration="2 s") >> mdr.hold("100 s")
pulls = {}
figure = Figure(figsize=(6.4, 4.2), layout="constrained")
axes = figure.subplots()
for speed in (1.0, 10.0, 100.0, 1000.0):  # um/s
    away = mdr.indent("-120 um", steps=140, duration=f"{140.0 / speed} s")
    result = mdr.solve(probe, press >> away, tolerance=1e-3)
    assert result.status is mdr.Status.PULLED_OFF
    pulls[speed] = -float(result["normal_force"].min())
    axes.plot(result.to("indentation", "um"), result.to("normal_force", "uN"), label=f"{speed:g} µm/s")
    print(f"{speed:6g} um/s: {1e6 * pulls[speed]:.0f} uN")
axes.set_xlabel("indentation (µm)")
axes.set_ylabel("normal force (µN)")
axes.legend()
figure.savefig("silicone_probe.png")
print("figure saved as silicone_probe.png")

# %%
# Shortly before the separation at the highest speed the whole contact is pulled; in the zone around it the tension is the cohesive stress.
last = int((result["contact_radius"].values > 0.0).nonzero()[0][-1])
a, c = (float(result[name][last]) for name in ("contact_radius", "cohesive_radius"))
pressure = result.field("pressure", [0.0, 0.5 * (a + c)], last).values
print(f"pressure at the centre: {pressure[0]:.0f} Pa, in the zone: {pressure[1]:.0f} Pa")
assert abs(pressure[1] + 10e3) < 1e-6 * 10e3
assert -10e3 <= pressure[0] < 0.0
figure = result.figures(step=last)["section"]
figure.savefig("silicone_probe_2.png")
print("figure saved as silicone_probe_2.png")

# %%
# The slow limit is the elastic contact of the relaxed modulus; no pull-off is below it.
relaxed = mdr.Elastic("30 kPa", 0.5)
slow = -mdr.pull_off(mdr.Contact(ball, relaxed, adhesion=surfaces)).largest_pull
print(f"relaxed: {1e6 * slow:.0f} uN")
assert slow < pulls[1.0] < pulls[10.0] < pulls[100.0] < pulls[1000.0]

# %%
# Work of adhesion of the same range, seen from a fast probe, is larger by up to the ratio of the moduli, here 4.
assert pulls[1000.0] < 4.0 * slow
