"""
A soft pad by its dwell
=======================

A pad of a soft elastomer, as climbing animals and robots use, is pressed on a wall for a while and pulled off. The longer it rests, the
larger is its contact when the retraction begins, and the harder it pulls; how much longer it has to rest, its relaxation time determines.
"""

import pymdr as mdr

elastomer = mdr.Viscoelastic(mdr.StandardSolid("20 kPa", "60 kPa", "0.5 s"), poisson=0.5)
pad = mdr.Contact(mdr.Paraboloid("2 mm"), elastomer, adhesion=mdr.MaugisDugdale("40 mJ/m^2", range="5 um"))

# %%
# One test: pressed by a machine of 50 N/m at 50 µm/s to 0.5 mN, at rest for one second, and retracted at 50 µm/s.
test = mdr.pull_off(pad, preload="0.5 mN", dwell="1 s", speed="50 um/s", machine_stiffness="50 N/m")
print(f"pull-off {1e6 * test.largest_pull:.0f} uN at a radius of {1e6 * test.largest_pull_radius:.0f} um")
print(
    f"effective work {1e3 * test.effective_work:.1f} mJ/m^2, work of the test {1e9 * test.external_work:.1f} nJ"
)
assert test.effective_work > 2.0 * 40e-3

# %%
# Over the dwell the pull rises within a few relaxation times to that of the relaxed contact.
dwells = ["0 s", "0.2 s", "0.5 s", "1 s", "5 s"]
curve = mdr.pull_off_curve(pad, speed="50 um/s", dwell=dwells, preload="0.5 mN", machine_stiffness="50 N/m")
pulls = -curve["largest_pull"].values[0]
print((1e6 * pulls).round().tolist())
figure = curve.plot()
figure.savefig("gecko_pad.png")
print("figure saved as gecko_pad.png")
assert (pulls[1:] > pulls[:-1]).all()
assert abs(pulls[-1] / pulls[0] - 1.352) < 0.01
