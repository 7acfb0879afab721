"""
A law for a particle code
=========================

A particle code evaluates force and stiffness of a contact millions of times. pymdr tabulates the law of a worn grain once with a
stated error and writes it as a C header. A grain that falls on a plate with this law rebounds with its initial energy.
"""

import math
import tempfile
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

import pymdr as mdr

grain = mdr.Contact(
    mdr.TruncatedSphere(radius="1 mm", flat_radius="20 um"),
    mdr.Elastic("70 GPa", 0.2),
    mdr.Elastic("210 GPa", 0.3),
)
law = mdr.export_law(grain, "10 um", tolerance=1e-6)
print(law.summary())
figure = law.plot()
figure.savefig("law_for_a_particle_code.png")
print("figure saved as law_for_a_particle_code.png")

# %%
# The files for another program: a header for C and C++, and a table.
with tempfile.TemporaryDirectory() as folder:
    law.to_c(Path(folder) / "worn_grain.h")
    law.to_csv(Path(folder) / "worn_grain.csv")
    header = (Path(folder) / "worn_grain.h").read_text()
print(header[header.index("#define") : header.index("static")])

# %%
# The stiffness is the derivative of the force, so an integrator conserves energy: the grain rebounds with its initial speed, and the
# contact time is that of the impact of the same contact in pymdr.
mass, speed = 4 / 3 * math.pi * 1e-3**3 * 2500, 1.0


def parting(t, state):
    return state[0]


parting.terminal, parting.direction = True, -1
motion = solve_ivp(
    lambda t, state: [state[1], -law.force(max(state[0], 0.0)) / mass],
    (0.0, 1e-4),
    [0.0, speed],
    method="DOP853",
    events=parting,
    rtol=1e-10,
    atol=[1e-18, 1e-12],
)
left, lasted = -motion.y[1, -1], motion.t[-1]
impact = mdr.impact(grain, mass=mass, speed=speed)
print(f"restitution {left / speed:.9f}, contact time {lasted:.6e} s, by pymdr {impact.contact_time:.6e} s")
assert abs(left / speed - 1.0) < 1e-6
assert np.isclose(lasted, impact.contact_time, rtol=1e-5)
