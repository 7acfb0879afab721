"""
Friction in a particle code
===========================

A particle code moves thousands of grains and calls a C function for every contact in every step. The header written here has the memory of
friction too: a stack of turning points in a struct without pointers. A C program throws a glass bead at a plate, at an angle; pymdr
integrates the same motion with `Stepper`, and `impact` solves it as a whole.
"""

import math
import shutil
import subprocess
import tempfile
from pathlib import Path

import matplotlib.style
import numpy as np
from matplotlib.figure import Figure

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

glass, steel = mdr.Elastic("70 GPa", 0.2), mdr.Elastic("210 GPa", 0.3)
bead = mdr.Contact(mdr.Paraboloid("1 mm"), glass, steel, friction=mdr.Coulomb(0.3))
mass, speed, angle = 1e-5, 1.0, math.radians(40.0)
law = mdr.export_law(bead, "10 um", tangential=True)

# %%
# The program, by velocity Verlet; a solid ball has the tangential mass 2/7 m. A struct of zeros is a contact that has not touched:
program = """
#include <stdio.h>
#include "bead.h"

int main(void)
{
    static bead_state s;
    double m = MASS, v = NORMAL, w = TANGENTIAL, d = 0.0, u = 0.0, h = 2e-9;
    do {
        d += h * (v - 0.5 * h * s.normal_force / m);
        u += h * (w - 0.5 * h * s.tangential_force / (2.0 / 7.0 * m));
        v -= 0.5 * h * s.normal_force / m;
        w -= 0.5 * h * s.tangential_force / (2.0 / 7.0 * m);
        if (bead_advance(&s, d, u))
            return 1;
        v -= 0.5 * h * s.normal_force / m;
        w -= 0.5 * h * s.tangential_force / (2.0 / 7.0 * m);
        printf("%.17g %.17g %.17g %.17g\\n", d, u, s.normal_force, s.tangential_force);
    } while (d > 0.0);
    printf("%.17g %.17g 0 0\\n", v, w);
    return 0;
}
"""
for word, value in (
    ("MASS", mass),
    ("NORMAL", speed * math.cos(angle)),
    ("TANGENTIAL", speed * math.sin(angle)),
):
    program = program.replace(word, repr(value))

# %%
# The same steps by `Stepper`:
contact = mdr.Stepper(bead, "10 um")
d = u = normal = tangential = 0.0
v, w, h, rows = speed * math.cos(angle), speed * math.sin(angle), 2e-9, []
while not rows or d > 0.0:
    d += h * (v - 0.5 * h * normal / mass)
    u += h * (w - 0.5 * h * tangential / (2.0 / 7.0 * mass))
    v -= 0.5 * h * normal / mass
    w -= 0.5 * h * tangential / (2.0 / 7.0 * mass)
    normal, tangential = contact.advance(d, u)
    v -= 0.5 * h * normal / mass
    w -= 0.5 * h * tangential / (2.0 / 7.0 * mass)
    rows.append((d, u, normal, tangential))
path = np.array(rows)

# %%
# All three agree: the C program to the stated error of the header, the integration to the square of its steps.
if shutil.which("cc"):
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        law.to_c(folder / "bead.h")
        (folder / "main.c").write_text(program)
        subprocess.run(["cc", "-std=c99", "-O2", folder / "main.c", "-o", folder / "main", "-lm"], check=True)
        lines = subprocess.run([folder / "main"], check=True, capture_output=True, text=True).stdout
    in_c = np.array([line.split() for line in lines.splitlines()], dtype=float)
    assert np.allclose(in_c[:-1], path, atol=1e-5 * np.abs(path).max(axis=0))
    print(f"C: bounces off at {-in_c[-1, 0]:.6f} m/s, the contact point moves on at {in_c[-1, 1]:.6f} m/s")
whole = mdr.impact(bead, mass=mass, speed=speed, angle=angle, radius="1 mm")
print(f"Stepper: {-v:.6f} m/s, {w:.6f} m/s; impact: {whole.contact_point_speed:.6f} m/s")
assert abs(w - whole.contact_point_speed) < 1e-4 * speed

figure = Figure(figsize=(5.6, 3.6), layout="constrained")
axes = figure.subplots()
time = h * np.arange(1, len(rows) + 1) * 1e6
axes.plot(time, path[:, 3], lw=1.2, label="tangential force")
axes.plot(time, 0.3 * path[:, 2], "k--", lw=0.8, label="limit of sliding")
axes.plot(time, -0.3 * path[:, 2], "k--", lw=0.8)
axes.set(xlabel="time (µs)", ylabel="force (N)")
figure.legend(loc="outside upper right", ncols=2)
figure.savefig("friction_in_a_particle_code.png")
print("figure saved as friction_in_a_particle_code.png")
