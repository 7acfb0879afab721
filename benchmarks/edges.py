"""How often the intervals of fits of soft adhesion hold what made the records: retreats at two speeds under white noise.

``python -m benchmarks.edges --count 80`` fits work, modulus and time of a silicone from two retreats of the page of soft adhesion, each
with noise of its own, from a start within a factor of 1.5. ``--law short`` fits `JKR(work, range=...)` to retreats from a relaxed
contact, which `--made-by` the same law or by the zone. It prints the coverage of the intervals of 68 % and of 95 %, what is off in
standard errors, and the same of the linear estimate from the same noise, which knows the rates at the truth and the noise: its coverage is
right but for the chance of the noise, as many further noises show, so what counts is the difference. The seed is fixed, so that the same
command prints the same.
"""

import argparse
import time
from typing import NamedTuple

import numpy as np

import pymdr as mdr
from pymdr.errors import ProblemError

BODY = mdr.Viscoelastic(mdr.StandardSolid("10 kPa", "30 kPa", "1 s"), poisson=0.5)
WORK, BALL = "50 mJ/m^2", mdr.Paraboloid("1 mm")
ZONE = mdr.Contact(BALL, BODY, adhesion=mdr.MaugisDugdale(WORK, range="5 um"))
SHORT = mdr.Contact(BALL, BODY, adhesion=mdr.JKR(WORK, range="1 um"))
SHORT_ZONE = mdr.Contact(BALL, BODY, adhesion=mdr.MaugisDugdale(WORK, range="1 um"))
TRUTH = {"adhesion.work": 0.05, "body.shear.modulus": 30e3, "body.shear.time": 1.0}
SPEEDS, NOISE, STIFFNESS = (5e-6, 100e-6), 2e-6, 20.0
POINT, BASELINE, SEED = 4e-6, 3e-6, 16
FURTHER = 4000
"""Further noises of the linear estimate."""
STEP, SHIFT = 1e-3, 1e-8
"""Relative steps of numbers and steps of contact points in m, by which rates are computed."""


class Trial(NamedTuple):
    """The contact that is fitted, the one that made the records, and the durations in s of approach and dwell."""

    fitted: mdr.Contact
    maker: mdr.Contact
    approach: float = 2.0
    dwell: float = 5.0

    @property
    def paths(self):
        """Times in s and travels in m of an approach, a dwell and a retreat at every speed in m/s."""
        return [self._pressed(speed) for speed in SPEEDS]

    def _pressed(self, speed):
        legs = (
            (-20e-6, 20e-6, self.approach, 40),
            (20e-6, 20e-6, self.dwell, 10),
            (20e-6, -250e-6, 270e-6 / speed, 80),
        )
        times, travels = [np.zeros(1)], [np.array([-20e-6])]
        for start, stop, duration, count in legs:
            times.append(times[-1][-1] + np.linspace(0.0, duration, count + 1)[1:])
            travels.append(np.linspace(start, stop, count + 1)[1:])
        return np.concatenate(times), np.concatenate(travels)

    def forces(self, contact, shift=0.0, **factors):
        """Forces in N without noise at every speed, from numbers times factors and travels with a shift in m."""
        values = {name: value * factors.get(name, 1.0) for name, value in TRUTH.items()}
        contact = mdr.with_parameters(contact, values)
        paths = (mdr.Path(time=when, travel=travel + shift) for when, travel in self.paths)
        return [
            mdr.solve(contact, path, machine_stiffness=STIFFNESS)["normal_force"].values for path in paths
        ]


TRIALS = {
    ("zone", "zone"): Trial(ZONE, ZONE),
    ("short", "short"): Trial(SHORT, SHORT, 100.0, 1000.0),
    ("short", "zone"): Trial(SHORT, SHORT_ZONE, 100.0, 1000.0),
}
"""By the law that is fitted and the one that made the records."""


def rates_at_truth(trial):
    """Rates of the forces over the logarithms of the numbers, then over contact point and baseline of each record."""
    columns = []
    for name in TRUTH:
        ends = [
            np.concatenate(trial.forces(trial.fitted, **{name: np.exp(side * STEP)})) for side in (1.0, -1.0)
        ]
        columns.append((ends[0] - ends[1]) / (2.0 * STEP))
    before, after = (trial.forces(trial.fitted, side * SHIFT) for side in (-1.0, 1.0))
    for i in range(len(SPEEDS)):
        for ends in ((before, after), None):
            parts = [np.zeros(one.size) for one in before]
            parts[i] = np.ones(before[i].size) if ends is None else (ends[0][i] - ends[1][i]) / (2.0 * SHIFT)
            columns.append(np.concatenate(parts))
    return np.column_stack(columns)


def linear_estimate(rates, used, noises):
    """What is off in errors by the linear estimate from the used samples, one column for each noise."""
    scale = np.linalg.norm(rates[used], axis=0)
    inverse = np.linalg.pinv(rates[used] / scale)[: len(TRUTH)]
    return inverse @ noises[used] / (NOISE * np.linalg.norm(inverse, axis=1, keepdims=True))


def one_fit(trial, clean, rates, rng):
    """What is off in errors by a fit and by the linear estimate, whether the intervals of 95 % of the fit hold the truth, and the used samples."""
    noises = [NOISE * rng.normal(size=force.size) for force in clean]
    curves = [
        mdr.MeasuredCurve(
            force=force + noise + BASELINE, travel=travel + POINT, time=when, spring_constant=STIFFNESS
        )
        for (when, travel), force, noise in zip(trial.paths, clean, noises, strict=True)
    ]
    start = {name: value * 1.5 ** rng.uniform(-1.0, 1.0) for name, value in TRUTH.items()}
    fitted = mdr.fit(mdr.with_parameters(trial.fitted, start), curves, list(TRUTH))
    used = fitted.data["used"].values
    linear = linear_estimate(rates, used, np.concatenate(noises)[:, None])[:, 0]
    off = [(fitted[name].value - truth) / fitted[name].error for name, truth in TRUTH.items()]
    holds = [fitted[name].low <= truth <= fitted[name].high for name, truth in TRUTH.items()]
    return np.array(off), linear, np.array(holds), used


def main(words=None):
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=80)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--law", choices=("zone", "short"), default="zone")
    parser.add_argument("--made-by", choices=("zone", "short"))
    given = parser.parse_args(words)
    trial = TRIALS.get((given.law, given.made_by or given.law))
    if trial is None:
        parser.error("records of a short zone are not fitted by the law of a zone")
    clean, rates = trial.forces(trial.maker), rates_at_truth(trial)
    rows = []
    for i in range(given.count):
        begin = time.perf_counter()
        try:
            rows.append(one_fit(trial, clean, rates, np.random.default_rng([given.seed, i])))
        except ProblemError as error:
            print(f"{i}: refused: {error}", flush=True)
            continue
        numbers, linear = (" ".join(f"{x:+.2f}" for x in part) for part in rows[-1][:2])
        passed = time.perf_counter() - begin
        print(f"{i}: {passed:.1f} s, off by {numbers} errors, linear estimate {linear}", flush=True)
    off, linear, holds, used = (np.array(column) for column in zip(*rows, strict=True))
    further = NOISE * np.random.default_rng(given.seed).normal(size=(rates.shape[0], FURTHER))
    others = linear_estimate(rates, used[-1], further)
    for j, name in enumerate(TRUTH):
        for what, part, hits in (
            ("fit", off[:, j], holds[:, j]),
            ("linear", linear[:, j], abs(linear[:, j]) < 1.96),
        ):
            print(
                f"{name}, {what}: 68 % {np.mean(abs(part) < 0.9945):.0%}, 95 % {np.mean(hits):.0%}, off by {part.mean():+.2f} +- {part.std():.2f} errors"
            )
        difference = off[:, j] - linear[:, j]
        print(f"{name}, linear, {FURTHER} further noises: 95 % {np.mean(abs(others[j]) < 1.96):.1%}")
        print(f"{name}: fit less linear {difference.mean():+.2f} +- {difference.std():.2f} errors")


if __name__ == "__main__":
    main()
