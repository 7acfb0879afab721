"""
Creep of a polymer gel
======================

An AFM presses a gel up to a force. A feedback keeps this force constant while the tip penetrates further. The path is the measured
force, and the model gives the indentation.

Run it on your own record with ``python gel_creep.py FILE``, in any format of afmformats (``pip install 'pymdr[afm]'``). Without a
file it generates a similar record with noise.
"""

import sys

import matplotlib.style
import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from scipy.optimize import least_squares

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

file = sys.argv[1] if __name__ == "__main__" and len(sys.argv) > 1 else None

# %%
# The file does not contain the tip. In the approach, the force grows with about the 1.9th power of the depth: a pyramid rather than a
# ball. A pyramid of four sides at 35° to the axis is assumed, and approximated by the cone of the same cross-sections.
tip = mdr.Cone(half_angle=np.arctan(2.0 / np.sqrt(np.pi) * np.tan(np.radians(35.0))))


def contact(equilibrium, modulus, time):
    """Moduli in Pa, time in s."""
    return mdr.Contact(tip, mdr.Viscoelastic(mdr.StandardSolid(equilibrium, modulus, time), poisson=0.5))


def read(file):
    """Approach and hold, and the stiffness of the cantilever in N/m."""
    from afmformats import load_data

    curve = load_data(file)[0]
    names = {"time": "time", "force": "force", "height": "height (measured)", "segment": "segment"}
    record = pd.DataFrame({name: np.asarray(curve[column]) for name, column in names.items()})
    return record[record.segment <= 1].reset_index(drop=True), curve.metadata["spring constant"]


def made(stiffness=0.06):
    """A record of the same form: an approach from afar, a force that overshoots a little and is kept."""
    t = np.arange(1, 3001) / 1000.0
    load = 10e-9 * np.minimum(t / 0.2, 1.0 + 0.08 * np.exp((0.2 - t) / 0.1))
    depth = mdr.solve(contact(1500.0, 500.0, 0.4), mdr.Path(time=t, normal_force=load))["indentation"].values
    afar = np.arange(-1.0, 0.0, 1 / 1000.0)
    motion = np.concatenate([10e-6 * afar, depth])
    force = np.concatenate([np.zeros(afar.size), load])
    noise = np.random.default_rng(0).standard_normal((2, motion.size))
    force = force + 20e-12 * noise[0]
    height = 3e-6 - motion - force / stiffness + 2e-9 * noise[1]
    return pd.DataFrame(
        {"time": np.concatenate([afar, t]) + 1.0, "force": force, "height": height}
    ), stiffness


record, stiffness = read(file) if file else made()
print(file or "no file is given: generated record")

# %%
# The force is relative to its median far away. The position of the tip is its height minus the deflection of the cantilever; the surface is
# unknown, so depths are compared relative to their mean. Rows begin where the force is clearly above the noise, at 2 % of the largest:
# a negative force is refused. Means over 10 ms, longer in the hold, are sufficient.
record["force"] -= record.force[: len(record) // 8].median()
record["tip"] = record.force / stiffness + record.height
near = record[record.time > record.time[record.force > 0.5 * record.force.max()].iloc[0] - 0.3]
since = near.time - near.time.iloc[0]
parts = np.concatenate([np.arange(0.0, 0.6, 0.01), np.geomspace(0.6, since.iloc[-1], 20)])
rows = near.groupby(np.digitize(since, parts)).mean()
touched = rows.time[rows.force < 0.02 * rows.force.max()].iloc[-1]
rows = rows[rows.time > touched]

time, force = rows.time.values - touched, rows.force.values
path = mdr.Path(time=time, normal_force=force)


def depth(logs):
    return mdr.solve(contact(*np.exp(logs)), path)["indentation"].values


def off(logs):
    """What is left in µm when the surface is where it fits best."""
    difference = 1e6 * (depth(logs) + rows.tip.values)
    return difference - difference.mean()


# %%
# Three parameters, by their logarithms, so that they are positive:
fit = least_squares(off, np.log([1e3, 1e3, 1.0]), diff_step=1e-3)
equilibrium, modulus, tau = np.exp(fit.x)
model = depth(fit.x)
print(f"E = {3e-3 * (equilibrium + modulus):.2f} kPa at once, {3e-3 * equilibrium:.2f} kPa in the end")
print(f"it creeps with the time {tau * (1.0 + modulus / equilibrium):.2f} s")

figure = Figure(figsize=(8.0, 3.6), layout="constrained")
left, right = figure.subplots(1, 2, sharey=True)
measured = 1e6 * model - fit.fun
left.plot(time, measured, ".", label="measured" if file else "generated, with noise")
left.plot(time, 1e6 * model, label="fitted")
left.set_xlabel("time since the bodies touch (s)")
left.set_ylabel("indentation (µm)")
left.legend()
right.plot(1e9 * force, measured, ".")
right.plot(1e9 * force, 1e6 * model)
right.set_xlabel("force (nN)")
figure.savefig("gel_creep.png")
print("figure saved as gel_creep.png")

# %%
# The gel in the tests of afmformats (``fmt-jpk-cc_pr14-polymergel-2021.06.30.jpk-force``) is adhesive: the pull in the retraction is as large as
# the load. Adhesion of viscoelastic bodies is not available, so only the approach and the hold are fitted. The gel creeps
# for longer than one relaxation time allows.
misfit = np.sqrt(np.mean(fit.fun**2)) / (1e6 * model.max())
print(f"residual {100 * misfit:.2g} % of the largest indentation")
assert misfit < (0.01 if file else 0.003)
