"""An exported law in C against the same law in Python, and both against solve."""

import ctypes
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import pymdr as mdr
from benchmarks.timing import Ratio, median_times

DEPTHS = 100_000
TIP = mdr.Contact(mdr.RoundedCone("50 nm", half_angle="65 deg"), mdr.Elastic("70 GPa", 0.2))
SOURCE = """#include "tip.h"
void forces(const double *d, double *f, size_t n);
void forces(const double *d, double *f, size_t n)
{
    size_t i;
    for (i = 0; i < n; ++i)
        f[i] = tip_force(d[i]);
}
"""


def ratios() -> Iterator[Ratio]:
    """Forces at many depths."""
    law = mdr.export_law(TIP, "1 um")
    d = 10.0 ** np.random.default_rng(0).uniform(-10, -6, DEPTHS)
    path = mdr.Path(indentation=d)
    knots = f"{law.table.knots.u.size} knots, which err by {max(law.errors.values()):.1g}"
    python, solved = median_times((lambda: law.force(d), 7), (lambda: mdr.solve(TIP, path), 3))
    yield Ratio(f"{DEPTHS:.0e} forces from {knots}", "solve", python, solved, "aim 10 times faster")
    if shutil.which("cc") is None:
        return
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        law.to_c(folder / "tip.h")
        (folder / "tip.c").write_text(SOURCE)
        library = folder / "tip.so"
        subprocess.run(
            ["cc", "-std=c99", "-O2", "-shared", "-fPIC", folder / "tip.c", "-o", library, "-lm"], check=True
        )
        forces = ctypes.CDLL(str(library)).forces
        pointer = np.ctypeslib.ndpointer(dtype=float, flags="C")
        forces.argtypes = [pointer, pointer, ctypes.c_size_t]
        forces.restype = None
        found = np.empty(DEPTHS)
        in_c, again = median_times((lambda: forces(d, found, DEPTHS), 7), (lambda: mdr.solve(TIP, path), 3))
        assert np.allclose(found, law.force(d), rtol=1e-12)
    yield Ratio(f"{DEPTHS:.0e} forces from the header in C", "solve", in_c, again, "aim 50 times faster")
