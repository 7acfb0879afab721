"""What an installation of the base package downloads and occupies, and the time to the first figure and the first friction loop.

``python -m benchmarks.install`` builds a wheel of this folder, downloads it with all that it needs, installs that into a new environment without a network,
and runs two programs there, each twice: the first run of the second also compiles the kernels of friction. Printed are tables in
Markdown, sizes in MiB, those on the disk in whole blocks as ``du`` counts; nothing of this clone or of the environment of the caller is used.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FIGURE = """
import pymdr as mdr
ball = mdr.Contact(mdr.Sphere("10 mm"), mdr.Elastic("210 GPa", 0.3))
mdr.solve(ball, mdr.load("50 N", steps=50)).plot().savefig("ball.png")
"""
LOOP = """
import pymdr as mdr
steel = mdr.Elastic("210 GPa", 0.3)
joint = mdr.Contact(mdr.Sphere("10 mm"), steel, steel, friction=mdr.Coulomb(0.3))
loop = mdr.solve(joint, mdr.load("50 N") >> mdr.cycle(shift="0.8 um", cycles=2, steps=400))
assert loop["dissipated_energy"][-1] > 0
"""
SIZES = """
import json
from importlib.metadata import distributions
sizes = {}
for one in distributions():
    files = (one.locate_file(file) for file in one.files or ())
    sizes[one.metadata["Name"].lower().replace("_", "-")] = sum(512 * file.stat().st_blocks for file in files if file.is_file())
print(json.dumps(sizes))
"""
LISTED = 8
"""Packages with lines of their own."""


def run(*command: str | Path, cwd: Path) -> tuple[str, float, float]:
    """Output, wall and processor time in seconds of a command in a process of its own."""
    environment = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "VIRTUAL_ENV")}
    before, start = os.times(), time.perf_counter()
    done = subprocess.run(
        [str(part) for part in command],
        cwd=cwd,
        env={**environment, "MPLBACKEND": "agg", "PIP_DISABLE_PIP_VERSION_CHECK": "1"},
        check=True,
        capture_output=True,
        text=True,
    )
    wall, after = time.perf_counter() - start, os.times()
    return (
        done.stdout,
        wall,
        after.children_user + after.children_system - before.children_user - before.children_system,
    )


def normal(name: str) -> str:
    return name.lower().replace("_", "-")


def print_sizes(downloaded: dict[str, int], installed: dict[str, int]) -> None:
    """Print both sizes of the largest packages, of the rest, and of all."""

    def line(name: str, names: Sequence[str]) -> str:
        sums = (sum(sizes.get(one, 0) for one in names) / 2**20 for sizes in (downloaded, installed))
        return f"| {name} | " + " | ".join(f"{size:.1f} MiB" for size in sums) + " |"

    names = sorted((name for name in installed if name != "pip"), key=lambda name: -installed[name])
    print("| package | download | on disk, with bytecode |\n|---|---|---|")
    for name in names[:LISTED]:
        print(line(name, [name]))
    small = [name for name in names[LISTED:] if name != "pymdr"]
    print(line(f"{len(small)} more", small))
    if "pymdr" not in names[:LISTED]:
        print(line("pymdr", ["pymdr"]))
    print(line("all", names))


def main() -> None:
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        wheels, env = folder / "wheels", folder / "env"
        pip = (sys.executable, "-m", "pip", "--quiet")
        run(*pip, "wheel", "--no-deps", "--wheel-dir", wheels, ROOT, cwd=folder)
        (wheel,) = wheels.iterdir()
        run(*pip, "download", "--only-binary", ":all:", "--dest", wheels, wheel, cwd=folder)
        run(sys.executable, "-m", "venv", env, cwd=folder)
        own = env / ("Scripts" if os.name == "nt" else "bin") / "python"
        offline = ("--no-index", "--find-links", wheels, wheel)
        installing = run(own, "-m", "pip", "install", "--quiet", *offline, cwd=folder)[1:]
        times = {"pip install from local wheels": installing}
        installed = {normal(k): v for k, v in json.loads(run(own, "-c", SIZES, cwd=folder)[0]).items()}
        for name, code in (("figure", FIGURE), ("friction loop", LOOP)):
            times[f"first {name}"] = run(own, "-c", code, cwd=folder)[1:]
            times[f"the same {name} again"] = run(own, "-c", code, cwd=folder)[1:]
        downloaded = {normal(file.name.split("-")[0]): file.stat().st_size for file in wheels.iterdir()}
        print_sizes(downloaded, {k: v for k, v in installed.items() if k != "setuptools"})
        print("\n| step, in a process of its own | time | processor time |\n|---|---|---|")
        for name, (wall, work) in times.items():
            print(f"| {name} | {wall:.1f} s | {work:.1f} s |")
        total = [times["pip install from local wheels"][i] + times["first figure"][i] for i in (0, 1)]
        print(f"| from `pip install` to the first figure | {total[0]:.1f} s | {total[1]:.1f} s |")


if __name__ == "__main__":
    main()
