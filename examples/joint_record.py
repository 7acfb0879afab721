"""
A measured joint
================

A test rig records load, shift and tangential force. The record determines the dissipation and the damping of each cycle. Its
history of load and shift is also a path, and the theory predicts the force along it.
"""

from pathlib import Path

import matplotlib.style
from matplotlib.figure import Figure

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

try:
    here = Path(__file__).parent
except NameError:  # run by a documentation builder
    here = Path.cwd()
file = here / "data" / "joint_record.csv"

record = mdr.read_record(file)
measured = mdr.measured_loops(record)
print(measured)

# %%
# The same load and shift as a path. The file also has the tangential force, so the prescribed channels are named.
steel = mdr.Elastic(young="210 GPa", poisson=0.3)
joint = mdr.Contact(mdr.Sphere("10 mm"), steel, steel, friction=mdr.Coulomb(0.3))
result = mdr.solve(joint, mdr.read_path(file, channels=["normal_force", "shift"]))

figure = Figure()
axes = figure.subplots()
axes.plot(1e6 * record["shift"], record["tangential_force"], ".", ms=3, label="measured")
axes.plot(result.to("shift", "um"), result["tangential_force"], label="solved")
axes.set_xlabel("shift (µm)")
axes.set_ylabel("tangential force (N)")
axes.legend()
figure.savefig("joint_record.png")
print("figure saved as joint_record.png")

# %%
# Energy per cycle, measured over solved: the noise of 0.05 N causes about 1 %.
solved = mdr.measured_loops(result)
ratio = float(measured["dissipated_per_cycle"].mean() / solved["dissipated_per_cycle"].mean())
print(f"{ratio:.3f}")
assert abs(ratio - 1.0) < 0.02

# %%
# Steady loops follow from the amplitude alone, without a history:
expected = mdr.friction_loop(joint, ["0.6 um"], normal_force="50 N")
assert abs(float(solved["dissipated_per_cycle"][1] / expected["dissipated_per_cycle"][0]) - 1.0) < 2e-3
