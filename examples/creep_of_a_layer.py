"""
Creep of a gel layer on glass
=============================

A bead of 250 um rests on a gel layer of 50 um. The gel creeps, and the glass below takes a growing part of the load: the layer gives way
less than a deep gel, and the ratio of both depths falls with time.
"""

import matplotlib.style
from matplotlib.figure import Figure

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

gel = mdr.Viscoelastic(mdr.StandardSolid("1 kPa", "3 kPa", "2 s"), poisson=0.5)
path = mdr.load("0.2 uN", duration="0.1 s", steps=10) >> mdr.hold("60 s", steps=100)

layer = mdr.solve(mdr.Contact(mdr.Sphere("250 um"), mdr.Layered([mdr.Layer(gel, "50 um")])), path)
deep = mdr.solve(mdr.Contact(mdr.Sphere("250 um"), gel), path)
print(layer.summary())

# %%
# The depth against time, and the depth that a half-space of the gel would have:
figure = Figure(figsize=(5.6, 4.0), layout="constrained")
axes = figure.subplots()
for result, label in ((layer, "layer of 50 µm on glass"), (deep, "half-space")):
    axes.plot(result["time"], 1e6 * result["indentation"], label=label)
axes.set(xlabel="time (s)", ylabel="indentation (µm)", ylim=(0.0, None))
axes.legend()
figure.savefig("creep_of_a_layer.png")
print("figure saved as creep_of_a_layer.png")

# %%
# At rest the layer is that of an elastic gel of the shear modulus 1 kPa:
elastic = mdr.Layered([mdr.Layer(mdr.Elastic("3 kPa", 0.5), "50 um")])
at_rest = mdr.solve(mdr.Contact(mdr.Sphere("250 um"), elastic), mdr.load("0.2 uN"))
print(
    f"depth after 60 s: {float(layer['indentation'][-1]) * 1e6:.3f} µm, at rest {float(at_rest['indentation'][-1]) * 1e6:.3f} µm"
)
assert abs(float(layer["indentation"][-1] / at_rest["indentation"][-1]) - 1) < 2e-3
