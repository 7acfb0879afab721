"""
A solitary wave in a chain of spheres
=====================================

Spheres that just touch have no speed of sound: a blow runs along them as a solitary wave about five spheres long, whose speed grows with the fifth root of
the largest speed of a sphere (Nesterenko 1983).
"""

import math

import matplotlib.style
import numpy as np
from matplotlib.figure import Figure

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

radius, mass, count = 5e-3, 4e-3, 30
steel = mdr.Elastic("210 GPa", 0.3)
touching = mdr.Contact(mdr.Paraboloid(radius / 2), steel, steel)  # 1/R = 1/R1 + 1/R2
spheres = [mdr.Mass(f"{i}", mass, velocity=1.0 if i == 0 else 0.0) for i in range(count)]
links = [mdr.Joint(touching, (f"{i}", f"{i + 1}"), name=f"{i}") for i in range(count - 1)]
motion = mdr.move(mdr.Machine(spheres, links), "0.42 ms", steps=1000)

time, velocity = motion["time"].values, motion["velocity"].values
figure = Figure(figsize=(7.2, 3.6), layout="constrained")
axes = figure.subplots()
for i in range(0, count, 4):
    axes.plot(time * 1e3, velocity[:, i] + 0.05 * i, lw=1.0)
axes.set(xlabel="time (ms)", ylabel="velocity of every fourth sphere (m/s), shifted")
figure.savefig("chain_of_spheres.png")
print("figure saved as chain_of_spheres.png")


# %%
# Arrival at two spheres, against Nesterenko's formula for long waves:
def arrival(i):
    """Time at which a sphere is fastest, by a parabola through three rows."""
    j = int(np.argmax(velocity[:, i]))
    before, at, after = velocity[j - 1 : j + 2, i]
    return time[j] + 0.5 * time[1] * (before - after) / (before - 2 * at + after)


speed = 8 * 2 * radius / (arrival(20) - arrival(12))
stiffness = 4 / 3 * mdr.effective_moduli(steel, steel).normal * math.sqrt(radius / 2)  # F = k d^(3/2)
c = math.sqrt(stiffness * (2 * radius) ** 2.5 / mass)
formula = (16 / 25) ** 0.2 * c**0.8 * velocity[:, 16].max() ** 0.2
print(f"speed of the wave: {speed:.1f} m/s, formula {formula:.1f} m/s")
assert abs(speed / formula - 1) < 0.01
