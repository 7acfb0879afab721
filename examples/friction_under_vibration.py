"""
Friction lowered by ultrasonic vibration
========================================

A heavy slider is pulled over a rubbing contact that vibrates at 20 kHz, once normal to the surface and once along it. Its mean
friction lies between limits in closed form: normal to the surface that of slow sliding, mu F_N at the least indentation d0 - A, and that of fast
sliding, mu times the mean of F_N; along it (2 / pi) mu F_N arcsin(v / v_max).
"""

import matplotlib.style
import numpy as np
from matplotlib.figure import Figure

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

steel = mdr.Elastic("210 GPa", 0.3)
pad = mdr.Contact(mdr.Paraboloid("10 mm"), steel, steel, friction=mdr.Coulomb(0.3))
depth, frequency, heavy = 1e-6, 20e3, 1e12  # m, Hz, and a mass in kg that friction does not brake
limit = 0.3 * float(mdr.solve(pad, mdr.indent(depth))["normal_force"][0])


def mean_friction(speed, shaker, joint, periods, steps=32):
    """Mean friction in N over the last period, of a slider in m/s."""
    bodies = [mdr.Mass("slider", heavy, velocity=speed), shaker]
    motion = mdr.move(mdr.Machine(bodies, [joint]), periods / frequency, steps=periods * steps, accuracy=1e-3)
    return float(motion["tangential_force"].values[-steps:, 0].mean()) / limit


def normal(speed, amplitude, periods):
    """The contact vibrates normal to the surface, with an amplitude in m."""
    shaker = mdr.Drive("shaker", amplitude=amplitude, frequency=frequency)
    return mean_friction(speed, shaker, mdr.Joint(pad, "shaker", "slider", indentation=depth), periods)


def along(ratio, amplitude=1e-3):
    """The contact vibrates along the surface; speed of the slider over the largest speed of the vibration."""
    shaker = mdr.Drive("shaker", amplitude=amplitude, frequency=frequency)
    joint = mdr.Joint(pad, tangential={"slider": 1, "shaker": 1}, indentation=depth)
    return mean_friction(ratio * 2 * np.pi * frequency * amplitude, shaker, joint, periods=2, steps=400)


amplitudes = depth * np.linspace(0.1, 0.9, 4)
slow = [normal(2e-4, amplitude, periods=120) for amplitude in amplitudes]
fast = [normal(5.0, amplitude, periods=2) for amplitude in amplitudes]
ratios = np.array([0.1, 0.3, 0.6, 0.9, 1.2])
tangential = [along(ratio) for ratio in ratios]

# %%
# The limits, and the motions between them:
fine, phase = np.linspace(0.0, 1.0, 200), np.linspace(0.0, 2.0 * np.pi, 256, endpoint=False)
mean_load = np.mean((1.0 + fine[:, None] * np.sin(phase)) ** 1.5, axis=1)
figure = Figure(figsize=(9.6, 3.6), layout="constrained")
left, right = figure.subplots(1, 2)
left.plot(fine, mean_load, "C1", label="limit of fast sliding")
left.plot(amplitudes / depth, fast, "C1o", label="5 m/s")
left.plot(fine, (1.0 - fine) ** 1.5, "C0", label="limit of slow sliding")
left.plot(amplitudes / depth, slow, "C0s", label="0.2 mm/s")
left.set(xlabel="amplitude normal to the surface / indentation", ylabel=r"mean friction / $\mu F(d_0)$")
left.legend()
speeds = np.linspace(0.0, 1.5, 400)
right.plot(speeds, 2.0 / np.pi * np.arcsin(np.minimum(speeds, 1.0)), "C2", label="limit")
right.plot(ratios, tangential, "C2o", label="motion")
right.set(xlabel="speed / largest speed of the vibration along it", ylabel=r"mean friction / $\mu F(d_0)$")
right.legend()
figure.savefig("friction_under_vibration.png")
print("figure saved as friction_under_vibration.png")

errors = np.abs(np.array(slow) - (1.0 - amplitudes / depth) ** 1.5)
print(f"slow sliding over normal vibration: within {errors.max():.1e} of its limit")
print(
    f"along the surface: {tangential[0]:.4f} at a tenth of the speed, limit {2 / np.pi * np.arcsin(0.1):.4f}"
)
assert abs(tangential[0] / (2.0 / np.pi * np.arcsin(0.1)) - 1.0) < 0.02
