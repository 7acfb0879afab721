"""
Vibrating contact
=================

Load and shift oscillate together, out of phase. If the load decreases, the stick zone shrinks from outside. If the load increases, new
surface sticks without shear. The state depends on the whole history, and pymdr follows this history exactly.
"""

import matplotlib.style
import numpy as np
from matplotlib.figure import Figure

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

steel = mdr.Elastic(young="210 GPa", poisson=0.3)
joint = mdr.Contact(mdr.Sphere("10 mm"), steel, steel, friction=mdr.Coulomb(0.3))
phase = 2 * np.pi * np.arange(1, 1201) / 300
load = 50.0 * (1 + 0.5 * np.sin(phase))
force = 6.0 * np.sin(phase + 1.0)
result = mdr.solve(joint, mdr.load("50 N") >> mdr.Path(normal_force=load, tangential_force=force))

figure = Figure(figsize=(9.6, 3.6), layout="constrained")
left, right = figure.subplots(1, 2)
left.plot(result.to("shift", "nm"), result["tangential_force"])
left.set(xlabel="tangential displacement (nm)", ylabel="tangential force (N)")
right.plot(result.to("contact_radius", "um"), label="contact radius")
right.plot(result.to("stick_radius", "um"), label="stick radius")
right.set(xlabel="step", ylabel="radius (µm)")
right.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2)
figure.savefig("vibrating_contact.png")
print("figure saved as vibrating_contact.png")

# %%
# Energy balance: work is stored or dissipated by friction. The last two cycles are steady.
dissipated = result["dissipated_energy"].values
print(f"dissipated per cycle: {1e6 * (dissipated[-1] - dissipated[-301]):.3f} µJ")
assert abs((dissipated[-1] - dissipated[-301]) / (dissipated[-301] - dissipated[-601]) - 1) < 1e-9
