"""Steps with the whole memory of friction and of the bodies against laws by hand, which remember one force or none."""

import math
from collections.abc import Callable, Iterator

import numpy as np

import pymdr as mdr
from benchmarks.timing import Ratio, median_times
from pymdr.line.adhesion import jkr_force

STEPS, CONTACTS, TOGETHER = 100_000, 10_000, 100
STEEL = mdr.Elastic("210 GPa", 0.3)
BALL = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(0.3))
DEEPEST = 1e-5
STICKY = mdr.Contact(mdr.Paraboloid("1 mm"), mdr.Elastic("40 kPa", 0.5), adhesion=mdr.JKR("50 mJ/m^2"))
MODULI = mdr.effective_moduli(STEEL, STEEL)
RUBBER = mdr.Viscoelastic(mdr.Prony("1 MPa", ["2 MPa", "0.5 MPa"], ["0.1 s", "2 s"]), 0.5)
PAD, LASTING = mdr.Paraboloid("10 mm"), 0.01
"""A ball on rubber, and the duration in s of its steps."""
MODULUS = 4e4 / 0.75
"""E* of the sticky contact in Pa."""


def walk(size: int) -> tuple[np.ndarray, np.ndarray]:
    """A random walk of indentation and shift, most of it in partial slip."""
    steps = np.random.default_rng(2).normal(0.0, 0.01 * DEEPEST, (2, size))
    depth, shift = np.cumsum(steps, axis=1)
    return np.abs((depth + 0.5 * DEEPEST) % (2 * DEEPEST) - DEEPEST), 0.3 * shift


def hertz_mindlin(depth: list[float], shift: list[float]) -> float:
    """Force increments 2 G* a du, cut at mu F_N."""
    here = force = 0.0
    for d, u in zip(depth, shift, strict=True):
        a = math.sqrt(1e-2 * d) if d > 0.0 else 0.0
        limit = 0.3 * 4.0 / 3.0 * MODULI.normal * a * d
        force = min(max(force + 2.0 * MODULI.tangential * a * (u - here), -limit), limit)
        here = u
    return force


def adhesion() -> Iterator[Ratio]:
    """A contact with JKR that is pressed and torn off: from Python, and many at once."""
    depth = 6.0 * walk(CONTACTS * TOGETHER)[0] - 4.0 * DEEPEST
    one, many = depth[:STEPS].tolist(), depth.reshape(TOGETHER, CONTACTS)
    single, several = mdr.Stepper(STICKY, 2 * DEEPEST), mdr.Stepper(STICKY, 2 * DEEPEST, count=CONTACTS)

    def steps() -> None:
        for d in one:
            single.advance(d)

    def together() -> None:
        for row in many:
            several.advance(row)

    ours, solved = median_times(steps, lambda: mdr.solve(STICKY, mdr.Path(indentation=one)))
    text, note = f"{STEPS:.0e} steps with JKR", f"{ours / STEPS * 1e6:.1f} us a step"
    yield Ratio(text, "solve of the whole path", ours, solved, "no aim", note)
    ours, formula = median_times(together, lambda: [jkr_force(row, 1e-3, MODULUS, 0.05) for row in many])
    text, note = (
        f"{CONTACTS} contacts with JKR by {TOGETHER} steps",
        f"{ours / depth.size * 1e9:.0f} ns a step",
    )
    yield Ratio(text, "JKR's closed form in NumPy, without jumps", ours, formula, "aim 3 times", note)


def hertz_with_dashpot(depth: list[float]) -> float:
    """4/3 E* a d and a dashpot 2 E* tau a d'."""
    here = force = 0.0
    for d in depth:
        a = math.sqrt(1e-2 * d) if d > 0.0 else 0.0
        force = max(4e6 / 0.75 * a * (4.0 / 3.0 * d + 2e-2 * (d - here) / LASTING), 0.0)
        here = d
    return force


def memory(friction: mdr.Coulomb | None, springs: int, count: int) -> Iterator[Ratio]:
    """A ball on bodies with memory, springs of Maxwell bodies, without and with friction."""
    contact = mdr.Contact(PAD, RUBBER, friction=friction)
    depth, shift = walk(count)
    d, u, time = depth.tolist(), shift.tolist(), LASTING * np.arange(1.0, count + 1.0)
    path = mdr.Path(time=time, indentation=depth, **({} if friction is None else {"shift": shift}))
    stepper = mdr.Stepper(contact, 2 * DEEPEST, springs=springs if friction is None else None)
    first = stepper.state

    def steps() -> None:
        stepper.restore(first)
        for depth, shift in zip(d, u, strict=True):
            stepper.advance(depth, shift, LASTING)

    ours, plain, solved = median_times(steps, lambda: hertz_with_dashpot(d), lambda: mdr.solve(contact, path))
    kind = "memory" if friction is None else "memory and friction"
    text, note = f"{count} steps with {kind}, {springs} springs", f"{ours / count * 1e6:.0f} us a step"
    yield Ratio(text, "solve of the whole path, 1000 springs", ours, solved, "no aim", note)
    if friction is None:
        yield Ratio(text, "Hertz with a dashpot in Python, which forgets", ours, plain, "no aim")
        yield from compiled_memory(contact, springs, d, steps)


def compiled_memory(
    contact: mdr.Contact, springs: int, depths: list[float], steps: Callable[[], None]
) -> Iterator[Ratio]:
    """The compiled step of a body with memory in a loop, against steps from Python."""
    step, body, states = mdr.Stepper(contact, 2 * DEEPEST, springs=springs).compiled()

    def loop() -> None:
        for depth in depths:
            step(body, states, 0, depth, 0.0, LASTING)

    ours, python = median_times(loop, steps)
    text = f"{len(depths)} compiled steps with memory, {springs} springs"
    note = f"{ours / len(depths) * 1e6:.0f} us a step"
    yield Ratio(text, "steps of Stepper.advance", ours, python, "aim 1 time", note)


def ratios() -> Iterator[Ratio]:
    """One contact from Python, and many at once."""
    yield from adhesion()
    yield from memory(None, 100, 10_000)
    yield from memory(mdr.Coulomb(0.3), 1000, 200)
    depth, shift = walk(STEPS)
    d, u = depth.tolist(), shift.tolist()

    def one() -> None:
        stepper = mdr.Stepper(BALL, 2 * DEEPEST)
        for move in zip(d, u, strict=True):
            stepper.advance(*move)

    path = mdr.Path(indentation=depth, shift=shift)
    ours, plain, solved = median_times(one, lambda: hertz_mindlin(d, u), lambda: mdr.solve(BALL, path))
    text, note = f"{STEPS:.0e} steps of one contact", f"{ours / STEPS * 1e6:.1f} us a step"
    yield Ratio(text, "Hertz-Mindlin in Python", ours, plain, "aim 5 times", note)
    yield Ratio(text, "solve of the whole path", ours, solved, "no aim")

    yield from along_a_line()
    yield from in_the_plane()


def own_walks(steps: int) -> np.ndarray:
    """Indentations and shifts, shape (2, steps, contacts), of contacts each along its own part of a walk; across the parts all steps would be wild."""
    return np.ascontiguousarray(
        np.stack(walk(CONTACTS * steps)).reshape(2, CONTACTS, steps).transpose(0, 2, 1)
    )


def along_a_line() -> Iterator[Ratio]:
    """Many contacts with their stacks; 1e7 steps in 2 s on two cores are 400 ns of a processor each."""
    moves = own_walks(TOGETHER)
    stepper = mdr.Stepper(BALL, 2 * DEEPEST, count=CONTACTS, workers=2)

    def many() -> None:
        stepper.advance(-DEEPEST)  # the stacks keep their room, which grows once
        for row in range(TOGETHER):
            stepper.advance(moves[0, row], moves[1, row])

    def vectors() -> None:
        force, here = np.zeros(CONTACTS), np.zeros(CONTACTS)
        for row in range(TOGETHER):
            a = np.sqrt(1e-2 * np.maximum(moves[0, row], 0.0))
            limit = 0.4 * MODULI.normal * a * moves[0, row]
            force = np.clip(force + 2.0 * MODULI.tangential * a * (moves[1, row] - here), -limit, limit)
            here = moves[1, row]

    long = mdr.Path(indentation=moves[0].T.ravel(), shift=moves[1].T.ravel())
    together, numpy, solved = median_times(many, vectors, lambda: mdr.solve(BALL, long))
    text = f"{CONTACTS} contacts along their walks by {TOGETHER} steps"
    note = f"{together / moves[0].size * 1e9:.0f} ns a step"
    yield Ratio(text, "solve of one path of as many rows", together, solved, "aim 400 ns a step", note)
    yield Ratio(text, "Hertz-Mindlin in NumPy, which forgets", together, numpy, "no aim")


def in_the_plane() -> Iterator[Ratio]:
    """Many contacts with springs that carry vectors; 1e7 steps of 32 springs in 5 s on two cores are 31 ns of a processor a spring."""
    springs, steps = 32, 20
    depth, x = own_walks(steps)
    y = np.ascontiguousarray(x[::-1])
    steppers = [
        mdr.Stepper(BALL, 2 * DEEPEST, count=CONTACTS, springs=springs, workers=workers) for workers in (2, 1)
    ]
    first = steppers[0].state

    def moved(stepper: mdr.Stepper) -> None:
        stepper.restore(first)
        for row in range(steps):
            stepper.advance(depth[row], (x[row], y[row]))

    two, one = median_times(*(lambda s=s: moved(s) for s in steppers))
    yield Ratio(
        f"{CONTACTS} contacts of {springs} springs in the plane by {steps} steps, two threads",
        "processor time of one thread",
        two,
        one,
        "aim 31 ns a spring",
        f"{two / (CONTACTS * steps * springs) * 1e9:.0f} ns a spring",
    )
