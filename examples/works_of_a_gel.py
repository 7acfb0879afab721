"""
Both works of a gel from one loop
=================================

A glass bead on a soft cantilever touches a gel and is withdrawn. The edge of the contact advances at one work of adhesion, rests, and recedes at a
larger one. One record with noise determines both, because the fit follows the edge along the whole record.
"""

import numpy as np

import pymdr as mdr

bead, gel = mdr.Paraboloid("50 um"), mdr.Elastic("30 kPa", 0.5)
true = mdr.Contact(bead, gel, adhesion=mdr.JKR("0.5 mJ/m^2", work_receding="2 mJ/m^2"))

# %%
# The record: travels of the piezo, with noise and unknown origins.
travel = np.concatenate([np.linspace(-2e-6, 4e-6, 60), np.linspace(4e-6, -6e-6, 101)[1:]])
force = mdr.solve(true, mdr.Path(travel=travel), machine_stiffness="0.5 N/m")["normal_force"].values
noise = 2e-9 * np.random.default_rng(3).normal(size=travel.size)
record = mdr.MeasuredCurve(force=force + noise + 5e-9, travel=travel + 3e-7, spring_constant="0.5 N/m")

# %%
# The fit starts from other works.
start = mdr.Contact(bead, gel, adhesion=mdr.JKR("0.1 mJ/m^2", work_receding="0.3 mJ/m^2"))
fit = mdr.fit(start, record, ["adhesion.work", "adhesion.work_receding"])
print(fit)
for name, value in (("adhesion.work", 0.5e-3), ("adhesion.work_receding", 2e-3)):
    assert fit[name].low < value < fit[name].high

# %%
# One work cannot describe the loop: the residuals are far above the noise.
single = mdr.fit(mdr.Contact(bead, gel, adhesion=mdr.JKR("1 mJ/m^2")), record, ["adhesion.work"])
print(f"noise with two works {1e9 * fit.noise:.2f} nN, with one {1e9 * single.noise:.1f} nN")
figure = fit.plot()
figure.savefig("works_of_a_gel.png")
print("figure saved as works_of_a_gel.png")
