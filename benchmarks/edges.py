"""How often the intervals of fits of soft adhesion hold what made the records: retreats at two speeds under white noise.

``python -m benchmarks.edges --count 80`` fits work, modulus and time of a silicone from two retreats of the page of soft adhesion, each
with noise of its own, from a start within a factor of 1.5. It prints the coverage of the intervals of 68 % and of 95 %, what is off in
standard errors, and the distance of the truth in the sum of squares, which has the distribution of chi^2 with as many degrees of freedom as
numbers are free if neither the search nor the model adds errors. The seed is fixed, so that the same command prints the same.
"""

import argparse
import time

import numpy as np
from scipy.stats import chi2

import pymdr as mdr

BODY = mdr.Viscoelastic(mdr.StandardSolid("10 kPa", "30 kPa", "1 s"), poisson=0.5)
PROBE = mdr.Contact(mdr.Paraboloid("1 mm"), BODY, adhesion=mdr.MaugisDugdale("50 mJ/m^2", range="5 um"))
TRUTH = {"adhesion.work": 0.05, "body.shear.modulus": 30e3, "body.shear.time": 1.0}
SPEEDS, NOISE, STIFFNESS = (5e-6, 100e-6), 2e-6, 20.0
POINT, BASELINE, SEED = 4e-6, 3e-6, 16


def pressed(speed):
    """Times in s and travels in m of an approach, a dwell and a retreat at a speed in m/s."""
    legs = ((-20e-6, 20e-6, 2.0, 40), (20e-6, 20e-6, 5.0, 10), (20e-6, -250e-6, 270e-6 / speed, 80))
    times, travels = [np.zeros(1)], [np.array([-20e-6])]
    for start, stop, duration, count in legs:
        times.append(times[-1][-1] + np.linspace(0.0, duration, count + 1)[1:])
        travels.append(np.linspace(start, stop, count + 1)[1:])
    return np.concatenate(times), np.concatenate(travels)


def clean_records():
    """Times in s, travels in m and forces in N without noise at every speed."""
    records = []
    for when, travel in map(pressed, SPEEDS):
        solved = mdr.solve(PROBE, mdr.Path(time=when, travel=travel), machine_stiffness=STIFFNESS)
        records.append((when, travel, solved["normal_force"].values))
    return records


def one_fit(records, rng):
    """A fit of records with noise, and by how many variances of the noise the truth fits worse than its end."""
    noises = [NOISE * rng.normal(size=force.size) for _, _, force in records]
    curves = [
        mdr.MeasuredCurve(
            force=force + noise + BASELINE, travel=travel + POINT, time=when, spring_constant=STIFFNESS
        )
        for (when, travel, force), noise in zip(records, noises, strict=True)
    ]
    start = {name: value * 1.5 ** rng.uniform(-1.0, 1.0) for name, value in TRUTH.items()}
    found = mdr.fit(mdr.with_parameters(PROBE, start), curves, list(TRUTH))
    used = found.data["used"].values
    left = found.data["residual"].values[used]
    noise = np.concatenate(noises)[used]
    return found, float(noise @ noise - left @ left) / NOISE**2


def study(count, seed=SEED, progress=print):
    """Of every number the shares of intervals of 68 and 95 % that hold it and its deviations in errors; and the distances of the truth."""
    records = clean_records()
    inside = {name: np.zeros((count, 2), dtype=bool) for name in TRUTH}
    off = {name: np.zeros(count) for name in TRUTH}
    distances = np.zeros(count)
    for i in range(count):
        begin = time.perf_counter()
        found, distances[i] = one_fit(records, np.random.default_rng([seed, i]))
        for name, truth in TRUTH.items():
            one = found[name]
            off[name][i] = (one.value - truth) / one.error
            inside[name][i] = abs(off[name][i]) < 0.9945, one.low <= truth <= one.high
        numbers = " ".join(f"{off[name][i]:+.2f}" for name in TRUTH)
        progress(
            f"{i}: {time.perf_counter() - begin:.1f} s, off by {numbers} errors, truth {distances[i]:.1f} variances away"
        )
    return inside, off, distances


def main(words=None):
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=80)
    parser.add_argument("--seed", type=int, default=SEED)
    given = parser.parse_args(words)
    inside, off, distances = study(given.count, given.seed, lambda text: print(text, flush=True))
    for name in TRUTH:
        low, high = inside[name].mean(axis=0)
        print(
            f"{name}: {low:.0%} and {high:.0%}, off by {off[name].mean():+.2f} +- {off[name].std():.2f} errors"
        )
    free = len(TRUTH) + 2 * len(SPEEDS)
    beyond = float((distances > chi2.ppf(0.95, free)).mean())
    print(
        f"truth {distances.mean():.1f} variances away (chi^2 of {free} numbers: {free}); {beyond:.0%} beyond its 95 %"
    )


if __name__ == "__main__":
    main()
