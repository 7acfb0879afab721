"""How often `compare_laws` finds the law that made a record, and the search of DMT its minimum.

``python -m benchmarks.laws --count 200`` makes records of Hertz, JKR and DMT of random tips, moduli, works, depths, samples and starts, with noise of 1 to 10 % of
the smaller one of pull and largest force. It prints how often the law has the largest weight, how often another law has a weight above 0.95, and how often the fit of the law
itself leaves more noise than the record has (beyond five deviations). ``--machine`` records the travel of a machine 0.1 to 10 times as stiff as the contact. The seeds are fixed.
"""

import argparse
import math
import time
from typing import NamedTuple

import numpy as np

import pymdr as mdr

LAWS = {"Hertz": None, "JKR": mdr.JKR, "DMT": mdr.DMT}
PULLS = {"Hertz": 2.0, "JKR": 1.5, "DMT": 2.0}
"""Pull over pi w R."""


class Record(NamedTuple):
    """A record, the contacts from which the laws start, and its noise in N."""

    curve: mdr.MeasuredCurve
    starts: dict[str, mdr.Contact]
    noise: float


def contact(law, radius, young, work):
    kind = LAWS[law]
    adhesion = {} if kind is None else {"adhesion": kind(work)}
    return mdr.Contact(mdr.Paraboloid(radius), mdr.Elastic(young, 0.5), **adhesion)


def record(law, seed, machine=False):
    """A random record of a law."""
    rng = np.random.default_rng(seed)
    samples, radius, young = (
        int(10 ** rng.uniform(1.8, 2.7)),
        10 ** rng.uniform(-7, -5),
        10 ** rng.uniform(3, 7),
    )
    depth = radius * 10 ** rng.uniform(-1.5, -0.7)
    modulus = young / 0.75
    load = 4.0 / 3.0 * modulus * math.sqrt(radius) * depth**1.5
    pull = load * 10 ** rng.uniform(-1.0, 0.5)
    work = pull / (PULLS[law] * math.pi * radius)
    stiffness = load / depth * 10 ** rng.uniform(-1.0, 1.0)
    lag = 1.0 / stiffness if machine else 0.0
    far = 2.0 * depth + 3.0 * (work**2 * radius / modulus**2) ** (1.0 / 3.0)
    ends = -far, depth + lag * load, -far - 2.0 * lag * pull
    positions = np.concatenate([np.linspace(*ends[:2], samples), np.linspace(*ends[1:], samples)])
    channel = "travel" if machine else "indentation"
    options = {"machine_stiffness": stiffness} if machine else {}
    force = mdr.solve(contact(law, radius, young, work), mdr.Path(**{channel: positions}), **options)
    noise = 10 ** rng.uniform(-2.0, -1.0) * (load if law == "Hertz" else min(load, pull))
    noisy = force["normal_force"].values + noise * rng.normal(size=positions.size) + 0.3 * pull
    curve = mdr.MeasuredCurve(
        force=noisy,
        spring_constant=stiffness if machine else None,
        **{channel: positions + depth * rng.uniform(-1.0, 1.0)},
    )
    begin = young * 10 ** rng.uniform(-2.0, 2.0), work * 10 ** rng.uniform(-1.5, 1.5)
    return Record(curve, {name: contact(name, radius, *begin) for name in LAWS}, noise)


def counted(law, count, machine=False):
    """Records that are right, undecided, wrong with a weight above 0.95, and fitted worse than their noise; CPU seconds of a comparison."""
    right = wrong = poor = 0
    spent = 0.0
    for seed in range(count):
        own = record(law, seed, machine)
        begin = time.process_time()
        weighed = mdr.compare_laws(own.starts, own.curve, ["body.young", "adhesion.work"])
        spent += time.process_time() - begin
        right += weighed.best == law
        wrong += weighed.best != law and weighed.weights[weighed.best] > 0.95
        within = own.noise * (1.0 + 5.0 / math.sqrt(2.0 * own.curve.force.size))
        poor += law not in weighed.fits or weighed[law].noise > within
    return right, wrong, poor, spent / count


def main(words=None):
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--machine", action="store_true")
    parser.add_argument("--only", nargs="+", choices=LAWS, default=list(LAWS))
    given = parser.parse_args(words)
    for law in given.only:
        right, wrong, poor, spent = counted(law, given.count, given.machine)
        print(
            f"{law}: right {right} of {given.count}, another law above 0.95 {wrong}, not fitted to its noise {poor}, "
            f"{spent:.2f} s CPU for a comparison",
            flush=True,
        )


if __name__ == "__main__":
    main()
