"""
Same force, other adhesion
==========================

Popov's closure of Argatov's discussion gives every contact without adhesion an equivalent profile with the same force F(d);
tangential contact follows from it. Adhesion does not. Two distant spheres have exactly the F(d) of one sphere of four times the
radius, and exactly its friction, but half of its pull-off force.
"""

import math
from dataclasses import replace

import matplotlib.style
import numpy as np
from matplotlib.figure import Figure

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

body = mdr.Elastic("1 MPa", 0.5)
one = mdr.Contact(mdr.Paraboloid("1 mm"), body)
closure = mdr.Contact(mdr.Paraboloid("4 mm"), body)

# %%
# The force of two spheres is that of the closure, ...
path = mdr.indent("10 um", steps=20)
pair = 2 * mdr.solve(one, path)["normal_force"].values
single = mdr.solve(closure, path)["normal_force"].values
assert np.allclose(pair, single, rtol=1e-13)

# %%
# ... and so is the tangential force of any history in one direction.
rng = np.random.default_rng(1)
history = mdr.Path(
    indentation=1e-5 * rng.uniform(0.2, 1.0, 40), shift=np.cumsum(2e-6 * rng.uniform(-1.0, 1.0, 40))
)
rubbed = [mdr.solve(replace(c, friction=mdr.Coulomb(0.4)), history) for c in (one, closure)]
pair, single = (2 * rubbed[0]["tangential_force"].values, rubbed[1]["tangential_force"].values)
assert np.allclose(pair, single, rtol=0, atol=1e-12 * np.max(np.abs(single)))

# %%
# The pull-off force is not: adhesion depends on area and edge of a contact, which are not in F(d).
law = mdr.JKR("50 mJ/m^2")
sticky, fused = (replace(c, adhesion=law) for c in (one, closure))
for stiffness in (0, math.inf):
    two, four = (mdr.pull_off(c, machine_stiffness=stiffness).normal_force for c in (sticky, fused))
    print(f"two spheres {2 * two:.6g} N, closure {four:.6g} N")
    assert abs(2 * two / four - 0.5) < 1e-12

depths = mdr.indent("10 um") >> mdr.indent("-6 um", steps=200)
figure = Figure(figsize=(6, 3.4), layout="constrained")
axes = figure.subplots()
for contact, times, style, name in ((sticky, 2, "C0", "two spheres"), (fused, 1, "C3--", "closure")):
    result = mdr.solve(contact, depths)
    axes.plot(1e6 * result["indentation"], 1e3 * times * result["normal_force"], style, label=name)
axes.set_xlabel("indentation (µm)")
axes.set_ylabel("normal force (mN)")
axes.legend()
