"""A slider in motion against velocity Verlet written with Stepper in Python."""

from collections.abc import Iterator

import numpy as np

import pymdr as mdr
from benchmarks.timing import Ratio, median_times
from pymdr.line.motion import follow_motion
from pymdr.solving.machines.assembling import map_contact, system_of

STEPS, FEWER = 1_000_000, 50_000
STEEL = mdr.Elastic("210 GPa", 0.3)
PAD = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(0.3))
STIFFNESS, SPEED, DEPTH, STEP = 2e3, 1e-2, 1e-6, 1e-6


def ratios() -> Iterator[Ratio]:
    """A slider of 1 kg on a driven spring, with stick, partial slip and sliding."""
    machine = mdr.Machine(
        [mdr.Mass("slider", 1.0), mdr.Drive("stage", velocity=SPEED)],
        [mdr.Spring(("stage", "slider"), STIFFNESS), mdr.Joint(PAD, (), "slider", DEPTH)],
    )
    system = system_of(machine, {PAD: map_contact(PAD)}, {PAD: np.inf})

    def verlet() -> None:
        contact = mdr.Stepper(PAD, DEPTH)
        contact.advance(DEPTH)
        x = v = force = 0.0
        for i in range(FEWER):
            v += 0.5 * STEP * force
            x += STEP * v
            pull = contact.advance(DEPTH, x).tangential
            force = STIFFNESS * (SPEED * STEP * (i + 1) - x) - pull
            v += 0.5 * STEP * force

    ours, fewer = median_times(lambda: follow_motion(system, STEP, 1, STEPS), verlet)
    text, against = f"{STEPS:.0e} steps of a slider", "velocity Verlet with Stepper from Python"
    yield Ratio(text, against, ours, fewer * STEPS / FEWER, "aim 2 s")
