"""CPU of a first use, with an empty cache of compiled kernels, less that of later ones: each a process of its own.

``python -m benchmarks.first_use memory impact`` measures those named; ``--kernels`` lists the CPU of every kernel that they compile.
"""

import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Iterator

from benchmarks.timing import Ratio

REPEATS = 3
_RUBBER = """
rubber = mdr.Viscoelastic(mdr.StandardSolid("1 MPa", "3 MPa", "1 ms"), poisson=0.5)
ball = mdr.Contact(mdr.Paraboloid("5 mm"), rubber)
"""
_GEL = """
gel = mdr.Contact(mdr.Paraboloid("5 um"), mdr.Elastic("10 kPa", 0.5))
way = np.linspace(-1e-6, 1e-6, 200)
force = mdr.solve(gel, mdr.Path(indentation=way))["normal_force"].values
"""
USES = {
    "friction": """
steel = mdr.Elastic("210 GPa", 0.3)
joint = mdr.Contact(mdr.Paraboloid("10 mm"), steel, steel, friction=mdr.Coulomb(0.3))
mdr.solve(joint, mdr.load("50 N") >> mdr.cycle(shift="0.8 um", steps=100))
""",
    "memory": _RUBBER
    + """
mdr.solve(ball, mdr.indent("10 um", steps=50, duration="1 ms") >> mdr.indent("0 um", steps=50, duration="1 ms"))
""",
    "memory under a force": _RUBBER
    + """
mdr.solve(ball, mdr.load("1 mN", steps=50, duration="1 ms") >> mdr.load("0 N", steps=50, duration="1 ms"))
""",
    "memory with friction": _RUBBER
    + """
joint = mdr.Contact(ball.profile, rubber, friction=mdr.Coulomb(0.3))
path = mdr.load("1 mN", steps=10, duration="1 ms") >> mdr.shift("2 um", steps=50, duration="1 ms")
mdr.solve(joint, path)
""",
    "impact": _RUBBER
    + """
mdr.impact(ball, mass="1 g", speed="0.1 m/s")
""",
    "restitution": _RUBBER
    + """
mdr.restitution(ball, mass="1 g", speeds=np.geomspace(1e-2, 1.0, 20))
""",
    "Hertz fit": _GEL
    + """
mdr.fit(gel, mdr.MeasuredCurve(indentation=way, force=force), ["body.young"])
""",
    "fit_map": _GEL
    + """
import xarray as xr
data = xr.Dataset({"force": (("curve", "sample"), np.array([force, 1.1 * force])), "indentation": ("sample", way)})
mdr.fit_map(gel, data, ["body.young"], workers=1)
""",
    "machine": """
steel = mdr.Elastic("210 GPa", 0.3)
pad = mdr.Contact(mdr.Paraboloid("10 mm"), steel, steel, friction=mdr.Coulomb(0.3))
bodies = [mdr.Mass("slider", "1 kg"), mdr.Drive("stage", velocity="2 mm/s")]
links = [mdr.Spring(("stage", "slider"), "2 N/mm"), mdr.Joint(pad, (), "slider", indentation="1 um")]
mdr.move(mdr.Machine(bodies, links), "10 ms", steps=100)
""",
}
_HEAD = "import numpy as np, pymdr as mdr\n"
_LISTENER = """
import time
from numba.core import event
class Listener(event.Listener):
    def __init__(self):
        self.stack, self.rows = [], []
    def on_start(self, e):
        self.stack.append([time.process_time(), 0.0])
    def on_end(self, e):
        begin, inside = self.stack.pop()
        taken = time.process_time() - begin
        if self.stack:
            self.stack[-1][1] += taken
        function = e.data["dispatcher"].py_func
        self.rows.append((taken - inside, taken, f"{function.__module__}.{function.__name__}", str(e.data["args"])))
listener = Listener()
event.register("numba:compile", listener)
"""
_LIST = """
for own, taken, name, arguments in sorted(listener.rows, reverse=True):
    print(f"{own:6.2f} s of its own, {taken:6.2f} s in all, {name}")
print(f"{sum(row[0] for row in listener.rows):6.2f} s in {len(listener.rows)} kernels")
"""


def cpu(code: str, folder: str) -> float:
    """The CPU in s of one process that runs some code, with its kernels in a folder."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    environment = {**os.environ, "NUMBA_CACHE_DIR": folder}
    subprocess.run([sys.executable, "-c", _HEAD + code], check=True, env=environment, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measured(name: str, repeats: int = REPEATS) -> Ratio:
    """Medians of first and of later uses; the note has the difference."""
    first, later = [], []
    for _ in range(repeats):
        with tempfile.TemporaryDirectory() as folder:
            first.append(cpu(USES[name], folder))
            later.append(cpu(USES[name], folder))
    cold, warm = statistics.median(first), statistics.median(later)
    note = f"{cold - warm:.1f} s beyond later ones"
    return Ratio(f"first use of {name}", "a later use", cold, warm, "aim below 5 s beyond", note)


def ratios() -> Iterator[Ratio]:
    """All uses."""
    for name in USES:
        yield measured(name)


def kernels(name: str) -> str:
    """The CPU of every kernel that a first use compiles."""
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "NUMBA_CACHE_DIR": folder}
        code = _HEAD + _LISTENER + USES[name] + _LIST
        done = subprocess.run(
            [sys.executable, "-c", code], check=True, env=environment, capture_output=True, text=True
        )
    return done.stdout


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help=f"of {', '.join(USES)}")
    parser.add_argument("--kernels", action="store_true")
    parser.add_argument("--repeats", type=int, default=REPEATS)
    options = parser.parse_args()
    for use in options.names or USES:
        print(kernels(use) if options.kernels else measured(use, options.repeats), flush=True)
