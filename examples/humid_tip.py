"""
A humid AFM tip
===============

A meniscus of water condenses around a silicon tip on glass. At 2 to 95 % humidity it pulls the tip with a force between the limits of a soft
and of a stiff contact.
"""

import math
from itertools import pairwise

import matplotlib.style
from matplotlib.figure import Figure

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

radius = 30e-9
tip = mdr.Paraboloid(radius)
silicon, glass = mdr.Elastic("130 GPa", 0.28), mdr.Elastic("70 GPa", 0.2)

# %%
# The work of adhesion depends on surface tension and contact angle only, the reach of the meniscus on the humidity.
humidities = (0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.95)
ratios, ranges = [], []
for humidity in humidities:
    water = mdr.Capillary(humidity=humidity, contact_angle="30 deg", temperature="25 degC")
    contact = mdr.Contact(tip, silicon, glass, adhesion=water)
    pull = -mdr.pull_off(contact, machine_stiffness=0).normal_force
    ratios.append(pull / (math.pi * radius * water.work))
    ranges.append(1e9 * water.work / water.cohesive_stress)
    print(f"{100 * humidity:3.0f} %: reach {ranges[-1]:.2f} nm, pull-off {1e9 * pull:.2f} nN")
assert all(1.5 < one < two < 2.0 for one, two in pairwise(ratios))

# %%
# Divided by the radius of the tip and the work of adhesion, the pull-off lies between 3/2 and 2 times pi.
figure = Figure(figsize=(6.4, 4.2), layout="constrained")
axes = figure.subplots()
axes.plot([100 * one for one in humidities], ratios, "o-")
for limit, name in ((1.5, "soft"), (2.0, "stiff")):
    axes.axhline(limit, color="0.6", linestyle="--")
    axes.annotate(name, (50, limit), xytext=(0, 3), textcoords="offset points")
axes.set_ylim(1.45, 2.1)
axes.set_xlabel("humidity (%)")
axes.set_ylabel(r"pull-off force / ($\pi R w$)")
figure.savefig("humid_tip.png")
print("figure saved as humid_tip.png")

# %%
# Along a retraction at 50 % humidity the cohesive radius is the radius of the meniscus.
water = mdr.Capillary(humidity=0.5, contact_angle="30 deg", temperature="25 degC")
contact = mdr.Contact(tip, silicon, glass, adhesion=water)
curve = mdr.solve(contact, mdr.indent("0.2 nm", steps=20) >> mdr.indent("-2 nm", steps=60))
assert curve.status is mdr.Status.PULLED_OFF
print(f"meniscus at 0.2 nm: {1e9 * float(curve['cohesive_radius'][19]):.2f} nm")
