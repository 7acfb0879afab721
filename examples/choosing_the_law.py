"""
Choosing the law of adhesion
============================

Small stiff tips attract over a range that is large compared with their deformation (DMT). Large soft tips attract only where they touch
(JKR). The law of Maugis and Dugdale covers both; pymdr gives the error of the simpler laws in the pull-off force.
"""

import matplotlib.style
import numpy as np
from matplotlib.figure import Figure

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

silica = mdr.Elastic(young="70 GPa", poisson=0.17)
radii = np.geomspace(1e-9, 5e-3, 12)
regimes = []
for radius in radii:
    tip = mdr.Contact(mdr.Paraboloid(radius), silica, silica, adhesion=mdr.JKR("100 mJ/m^2"))
    regimes.append(mdr.adhesion_regime(tip, range="0.5 nm"))
print(regimes[0], regimes[-1], sep="\n\n")

figure = Figure(figsize=(6.4, 3.8), layout="constrained")
axes = figure.subplots()
for law in ("JKR", "MaugisDugdale", "DMT"):
    pull = [-regime.pull_off_force[law] / (np.pi * 0.1 * r) for regime, r in zip(regimes, radii, strict=True)]
    axes.semilogx(radii * 1e9, pull, label=law)
axes.set_xlabel("radius of the tip (nm)")
axes.set_ylabel(r"pull-off force / $\pi w R$")
axes.legend()
figure.savefig("choosing_the_law.png")
print("figure saved as choosing_the_law.png")

# %%
# All three laws in the transition: curves of equilibria, and the pressure of the unloaded contact. The tension of JKR is
# infinite at the edge, that of Maugis and Dugdale is constant to the edge of the cohesive zone:
middle = min(regimes, key=lambda regime: abs(np.log(regime.maugis)))
figure = middle.plot()
figure.savefig("choosing_the_law_2.png")
print("figure saved as choosing_the_law_2.png")

# %%
# JKR gives 3/2, DMT 2, and Maugis and Dugdale a value between:
assert abs(regimes[0].pull_off_force["JKR"] / (-1.5 * np.pi * 0.1 * radii[0]) - 1) < 1e-12
assert regimes[0].regime == "DMT"
assert regimes[-1].regime == "JKR"
