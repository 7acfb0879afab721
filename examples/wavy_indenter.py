"""
Wavy indenter
=============

Waves on a tip increase its adhesion: the edge of the contact jumps over every wave, and each jump dissipates energy. pymdr locates folds and
jumps exactly, so the dissipation does not depend on the number of steps.
"""

import numpy as np

import pymdr as mdr

height, wave = 0.1e-6, 5e5  # amplitude in m and wave number in 1/m of the ripples
tip = mdr.Function(
    lambda r: r**2 / 2e-3 + height * (1 - np.cos(wave * r)),
    derivative=lambda r: r / 1e-3 + height * wave * np.sin(wave * r),
)
gel = mdr.Elastic(young="100 kPa", poisson=0.5)
contact = mdr.Contact(tip, gel, adhesion=mdr.JKR(work="10 mJ/m^2"))
there_and_back = [mdr.indent("4 um", steps=n) >> mdr.indent("-8 um", steps=2 * n) for n in (20, 400)]
coarse, fine = (mdr.solve(contact, path) for path in there_and_back)
figure = fine.figures()["loop"]
figure.savefig("wavy_indenter.png")
print("figure saved as wavy_indenter.png")

jumps = fine["jump_dissipation"].values
print(f"{np.count_nonzero(fine['jumped'].values)} steps jumped and lost {jumps.sum():.4g} J")
smooth = mdr.solve(
    mdr.Contact(mdr.Paraboloid("1 mm"), gel, adhesion=mdr.JKR(work="10 mJ/m^2")), there_and_back[1]
)
without = float(smooth["dissipated_energy"][-1])
print(f"without waves {without:.4g} J are lost")

# %%
# The dissipation is that of the jumps, for any number of steps, and equals the work of the closed loop:
dissipated = float(fine["dissipated_energy"][-1])
assert dissipated > 1.4 * without
assert abs(jumps.sum() / dissipated - 1) < 1e-12
assert abs(float(coarse["dissipated_energy"][-1]) / dissipated - 1) < 1e-9
assert abs(float(fine["external_work"][-1]) / dissipated - 1) < 1e-9
