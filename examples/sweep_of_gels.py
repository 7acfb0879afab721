"""
Pull-off of a tip from many gels
================================

The same colloidal tip is pulled off gels of different stiffness and work of adhesion. The largest pull does not depend on the stiffness.
The elongation of the gel at pull-off depends on it.
"""

import numpy as np

import pymdr as mdr

tip = mdr.Contact(mdr.Paraboloid("5 um"), mdr.Elastic("10 kPa", 0.5), adhesion=mdr.JKR("0.2 mJ/m^2"))
path = mdr.travel("1 um", steps=20) >> mdr.travel("-20 um", steps=4000)
gels = mdr.sweep(
    tip,
    path,
    {"body.young": np.geomspace(1e2, 1e5, 7), "adhesion.work": ["0.1 mJ/m^2", "0.2 mJ/m^2", "0.4 mJ/m^2"]},
    machine_stiffness="0.05 N/m",
    quantities=["indentation", "normal_force"],
)
print(gels.summary())
figure = gels.plot()
figure.savefig("sweep_of_gels.png")
print("figure saved as sweep_of_gels.png")

# %%
# The largest pull is that of Johnson, Kendall and Roberts for all stiffnesses, within the resolution of the path:
pull = -gels["normal_force"].min("step") / (1.5 * np.pi * 5e-6 * gels["adhesion.work"])
print(pull.round(4).values)
assert np.all((pull > 0.99) & (pull <= 1.0 + 1e-12))

# %%
# Elongation of the softest gels at pull-off:
drawn = -gels["indentation"].where(gels["normal_force"] < 0.0).min("step")
print((1e6 * drawn).round(3).values)
assert np.all(np.diff(drawn, axis=0) < 0.0)
