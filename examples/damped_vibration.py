"""
A vibrating joint, damped by friction
=====================================

A mass rests on a ball contact and is pushed sideways. It swings on the tangential stiffness of the contact, and every cycle loses energy in
the slipping ring at the edge of the contact. The program integrates the motion; `Stepper` gives the force.
"""

import matplotlib.style
import numpy as np
from matplotlib.figure import Figure

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

steel = mdr.Elastic("210 GPa", 0.3)
ball = mdr.Contact(mdr.Sphere("10 mm"), steel, steel, friction=mdr.Coulomb(0.3))
depth = float(mdr.solve(ball, mdr.load("50 N"))["indentation"][-1])

contact = mdr.Stepper(ball, depth)
contact.advance(depth)
mass = 1.0
period = 2.0 * np.pi * np.sqrt(mass / contact.tangential_stiffness)

# %%
# Velocity Verlet from a speed of 4 mm/s, sixty cycles of 400 steps:
step, shift, speed = period / 400.0, 0.0, 4e-3
shifts, forces, energies = [shift], [0.0], [0.5 * mass * speed**2]
for _ in range(60 * 400):
    speed -= 0.5 * step * forces[-1] / mass
    shift += step * speed
    forces.append(contact.advance(depth, shift).tangential)
    speed -= 0.5 * step * forces[-1] / mass
    shifts.append(shift)
    energies.append(0.5 * mass * speed**2 + contact.stored_tangential_energy)

figure = Figure(figsize=(9.6, 3.6), layout="constrained")
left, right = figure.subplots(1, 2)
left.plot(step * np.arange(len(shifts)) * 1e3, np.array(shifts) * 1e6, lw=0.8)
left.set(xlabel="time (ms)", ylabel="shift (µm)")
right.plot(np.array(shifts) * 1e6, forces, lw=0.6)
right.set(xlabel="shift (µm)", ylabel="tangential force (N)")
figure.savefig("damped_vibration.png")
print("figure saved as damped_vibration.png")

# %%
# A late cycle, which hardly shrinks, loses what the closed loop of the same amplitude dissipates:
late = slice(50 * 400, 51 * 400 + 1)
amplitude = 0.5 * (max(shifts[late]) - min(shifts[late]))
loop = mdr.solve(ball, mdr.indent(depth) >> mdr.cycle(shift=amplitude, cycles=2))
dissipated = float(
    loop["dissipated_energy"][-1] - loop["dissipated_energy"][len(loop["dissipated_energy"]) // 2]
)
own = energies[late.start] - energies[late.stop - 1]
print(
    f"lost in the 51st cycle: {own * 1e9:.2f} nJ; in a closed loop of {amplitude * 1e6:.3f} µm: {dissipated * 1e9:.2f} nJ"
)

balance = energies[0] - energies[-1] - contact.dissipated_energy
print(f"energy that the integration lost: {abs(balance) / energies[0]:.1e} of that at the start")
assert abs(own / dissipated - 1) < 0.02
assert abs(balance) < 1e-4 * energies[0]
