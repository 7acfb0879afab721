"""
Memory in a particle code
=========================

Grains of rubber lose energy because they relax. The header written here follows the springs of a contact with memory, each in contact or
creeping back, in a struct without pointers. A C program drops a bead on a rubber plate at three speeds; `impact` solves the same collisions
as a whole.
"""

import shutil
import subprocess
import tempfile
from pathlib import Path

import matplotlib.style
import numpy as np
from matplotlib.figure import Figure

import pymdr as mdr

matplotlib.style.use("pymdr.figures")

rubber = mdr.Viscoelastic(mdr.Prony("1 MPa", ["2 MPa", "0.5 MPa"], ["0.2 ms", "5 ms"]), poisson=0.5)
bead = mdr.Contact(mdr.Paraboloid("5 mm"), rubber)
mass, speeds = 5e-4, (0.1, 0.3, 1.0)
law = mdr.export_law(bead, "1.5 mm", springs=100)

# %%
# The program, by velocity Verlet; a struct of zeros is a contact that has not touched:
program = """
#include <stdio.h>
#include "bead.h"

int main(void)
{
    const double speeds[] = {SPEEDS}, m = MASS, h = 1e-6;
    int k;
    for (k = 0; k < 3; ++k) {
        static bead_state zeros;
        bead_state s = zeros;
        double v = speeds[k], d = 0.0;
        do {
            v -= 0.5 * h * s.normal_force / m;
            d += h * v;
            if (bead_advance(&s, d, h))
                return 1;
            v -= 0.5 * h * s.normal_force / m;
            printf("%d %.17g %.17g %.17g\\n", k, d, s.normal_force, v);
        } while (s.normal_force > 0.0);
    }
    return 0;
}
""".replace("SPEEDS", ", ".join(map(repr, speeds))).replace("MASS", repr(mass))

# %%
# The restitution of `impact`, and that of the program to the claim of the header:
whole = [mdr.impact(bead, mass=mass, speed=speed) for speed in speeds]
print("impact: restitution", *(f"{each.restitution:.4f}" for each in whole))
if shutil.which("cc"):
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        law.to_c(folder / "bead.h")
        (folder / "main.c").write_text(program)
        subprocess.run(["cc", "-std=c99", "-O2", folder / "main.c", "-o", folder / "main", "-lm"], check=True)
        lines = subprocess.run([folder / "main"], check=True, capture_output=True, text=True).stdout
    rows = np.array([line.split() for line in lines.splitlines()], dtype=float)
    parts = [rows[rows[:, 0] == k] for k in range(3)]
    in_c = [-part[-1, 3] / speed for part, speed in zip(parts, speeds, strict=True)]
    print("C:      restitution", *(f"{each:.4f}" for each in in_c))
    assert np.allclose(in_c, [each.restitution for each in whole], atol=2e-4)
    figure = Figure(figsize=(5.6, 3.6), layout="constrained")
    axes = figure.subplots()
    for part, speed in zip(parts, speeds, strict=True):
        axes.plot(1e3 * part[:, 1], part[:, 2], label=f"{speed:g} m/s")
    axes.set(xlabel="indentation (mm)", ylabel="normal force (N)")
    figure.legend(loc="outside upper right", ncols=3)
    figure.savefig("memory_in_a_particle_code.png")
    print("figure saved as memory_in_a_particle_code.png")
