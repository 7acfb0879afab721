"""
Friction of a slider on wet rubber
==================================

A smooth cap slides over wet rubber, without friction between the surfaces. The cap compresses the rubber at its front, and the rubber
does not recover completely behind the tip. The friction depends on the ratio of passage time and relaxation times.
"""

import numpy as np

import pymdr as mdr

rubber = mdr.Viscoelastic(
    mdr.Prony(equilibrium="1 MPa", moduli=["2 MPa", "5 MPa", "20 MPa"], times=["10 ms", "1 ms", "0.1 ms"]),
    poisson=0.5,
)
slider = mdr.Contact(mdr.Sphere("5 mm"), rubber)
slid = mdr.sliding_friction(slider, np.geomspace(1e-4, 1e2, 31), normal_force="0.5 N")
print(slid)
figure = slid.plot()
figure.savefig("rubber_slider.png")
print("figure saved as rubber_slider.png")

# %%
# Slow sliding is exact: half the friction of the springs, proportional to the speed. For a small
# sphere it is nearly :math:`\tau v / R`, with :math:`\tau = \int (G - G_\infty)\, dt / G_\infty` = 27 ms.
tau = (2 * 10e-3 + 5 * 1e-3 + 20 * 0.1e-3) / 1
assert abs(float(slid["slow_limit"][0]) / (tau * 1e-4 / 5e-3) - 1) < 0.05

# %%
# Friction is largest where the passage time is about the relaxation time.
fastest = float(slid["speed"][slid["friction_coefficient"].values.argmax()])
print(f"largest friction at {fastest:.2g} m/s")
