"""How often the intervals of indents hold what made the record: synthetic indents of all sizes with frame, drift, creep and noise.

``python -m benchmarks.indents --count 1000`` evaluates as many indents of random tips, bodies, depths from 10 nm to 100 um, frames, drifts and noises, and
prints the share of the 95 % intervals that hold the truth; 93 to 97 % is the aim. ``--only film`` takes one of the parts. ``--seed`` draws others.
"""

import argparse
import math
import time

import numpy as np

import pymdr as mdr
from pymdr.solving.nanoindentation import films
from pymdr.solving.nanoindentation.unloading import epsilon_of_power

DIAMOND = mdr.Elastic("1141 GPa", 0.07)
POISSON, SEED = 0.25, 28
_PER_NANOMETRE = np.array([1.0, 1e9])
"""Of the coefficients of h^2 and h, which calibrations give for nanometres."""


class Indent:
    """A random indent: tip, contact depth, modulus, hardness, frame, drift and noise."""

    def __init__(self, rng, like=None, part=1.0):
        self.rng = rng
        self.contact_depth = 10.0 ** rng.uniform(-8.0, -4.0)
        blunt = self.contact_depth * 10.0 ** rng.uniform(-2.0, 0.0)
        self.tip = mdr.AreaFunction([24.5, 24.5 * blunt])
        self.young = 10.0 ** rng.uniform(9.0, 11.6)
        if like is not None:
            self.contact_depth, self.tip, self.young = part * like.contact_depth, like.tip, like.young
        compliance = (1.0 - POISSON**2) / self.young + (1.0 - 0.07**2) / 1141e9
        self.reduced = 1.0 / compliance
        self.hardness = self.reduced * rng.uniform(0.01, 0.1)
        self.area = float(self.tip.area_at(self.contact_depth))
        self.force = self.hardness * self.area
        self.stiffness = 2.0 * self.reduced * math.sqrt(self.area / math.pi)
        self.m = rng.uniform(1.2, 1.7)
        self.depth = self.contact_depth + epsilon_of_power(self.m) * self.force / self.stiffness
        self.frame = rng.uniform(0.0, 0.3) / self.stiffness if like is None else like.frame
        self.noise = self.depth * 10.0 ** rng.uniform(-4.0, -2.7)
        self.force_noise = self.force * 10.0 ** rng.uniform(-4.5, -3.0)
        self.drift = self.depth * rng.uniform(-0.05, 0.05) / 100.0

    def parts(self, hold):
        """Parts of the largest force, and depths without frame and drift."""
        rng = self.rng
        n, still = int(10.0 ** rng.uniform(2.3, 3.3)), int(rng.integers(20, 120))
        rise = np.linspace(0.0, 1.0, n)
        down = rise[::-1]
        if hold:
            down = np.concatenate([np.linspace(1.0, 0.1, n), np.full(n, 0.1), np.linspace(0.1, 0.0, n // 10)])
        part = np.concatenate([rise**2, np.ones(still), down])
        creep = self.depth * (0.97 + 0.03 * np.linspace(0.0, 1.0, still))
        length = self.m * self.force / self.stiffness
        return part, np.concatenate(
            [
                0.97 * self.depth * rise,
                creep,
                self.depth - length * (1.0 - down ** (1.0 / self.m)),
            ]
        )

    def record(self, hold):
        """As a machine records it."""
        part, depth = self.parts(hold)
        t = np.linspace(0.0, 100.0, part.size)
        noise, more = self.rng.normal(size=(2, part.size))
        depth = depth + self.frame * self.force * part + self.noise * noise + self.drift * hold * t
        return mdr.MeasuredCurve(force=self.force * part + self.force_noise * more, indentation=depth, time=t)


def tally(table, name, low, high, truth):
    """Count whether an interval holds the truth."""
    table.setdefault(name, []).append(bool(low <= truth <= high))


def unloading(rng, table, hold):
    """One indent by both procedures."""
    one = Indent(rng)
    record = one.record(hold)
    if hold:
        record = mdr.thermal_drift(record)
        tally(table, "drift", float(record["rate_low"][0]), float(record["rate_high"][0]), one.drift)
    study = mdr.oliver_pharr(
        record, one.tip, frame_compliance=one.frame, poisson=POISSON, epsilon=None
    ).data.isel(indent=0)
    for procedure in ("power_law", "effective_shape"):
        row = study.sel(procedure=procedure)
        for name, truth in (
            ("stiffness", one.stiffness),
            ("hardness", one.hardness),
            ("young_modulus", one.young),
        ):
            tally(table, f"{name}, {procedure}", float(row[f"{name}_low"]), float(row[f"{name}_high"]), truth)


def calibration(rng, table, hold):
    """A tip and a frame from 16 indents in a known body; the area is counted at the contact depths of the indents."""
    one = Indent(rng)
    records = [Indent(rng, one, part).record(hold) for part in np.geomspace(0.05, 1.0, 16)]
    if hold:
        records = mdr.thermal_drift(records)
    body = mdr.Elastic(one.young, POISSON)
    study = mdr.calibrate_area(records, reference=body, terms=2, epsilon=None)
    (frame, *coefficients), truth = study.intervals, _PER_NANOMETRE * one.tip.coefficients
    tally(table, "frame compliance", *frame, one.frame)
    for i, (interval, value) in enumerate(zip(coefficients, truth, strict=True)):
        tally(table, f"coefficient {i + 1}", *interval, value)
    data = study.data
    for low, high, depth in zip(
        *(data[f"contact_area{end}"].values for end in ("_low", "_high")),
        data["contact_depth"].values,
        strict=True,
    ):
        tally(table, "area", low, high, float(one.tip.area_at(depth)))


def swept(one, rng, depth_part=0.02, count=1500):
    """Contact depths of a loading with continuous stiffness, with forces of one hardness."""
    contact = one.contact_depth * np.exp(np.linspace(math.log(depth_part), 0.0, count))
    area = one.tip.area_at(contact)
    return contact, area, one.hardness * area


def noisy(one, rng, contact, force, stiffness):
    """A record of a continuous stiffness with frame and noise."""
    n = contact.size
    depth = contact + 0.75 * force / stiffness + one.frame * force + one.noise * 0.1 * rng.normal(size=n)
    compliance = 1.0 / stiffness + one.frame
    return {
        "indentation": depth,
        "normal_force": force + 0.1 * one.force_noise * rng.normal(size=n),
        "harmonic_stiffness": (1.0 + 0.01 * rng.normal(size=n)) / compliance,
    }


def continuous(rng, table, hold):
    """The points of one continuous stiffness."""
    one = Indent(rng)
    contact, area, force = swept(one, rng)
    stiffness = 2.0 * one.reduced * np.sqrt(area / math.pi)
    study = mdr.continuous_stiffness(
        noisy(one, rng, contact, force, stiffness), one.tip, frame_compliance=one.frame, poisson=POISSON
    ).data.isel(indent=0)
    for name, truth in (("hardness", one.hardness), ("young_modulus", one.young)):
        for low, high in zip(study[f"{name}_low"].values, study[f"{name}_high"].values, strict=True):
            tally(table, f"{name} over depth", low, high, truth)


def film(rng, table, hold):
    """A film on a substrate."""
    one = Indent(rng)
    thickness = one.contact_depth * rng.uniform(1.0, 10.0)
    base = mdr.Elastic(one.young * 10.0 ** rng.uniform(-1.0, 1.0), 0.3)
    body = mdr.Layered([mdr.Layer(mdr.Elastic(one.young, POISSON), thickness)], base=base)
    contact, area, force = swept(one, rng)
    stiffness = (
        2.0
        * np.sqrt(area / math.pi)
        * films.reduced_moduli(np.sqrt(area / math.pi), body, (1.0 - 0.07**2) / 1141e9)
    )
    one.frame = rng.uniform(0.0, 0.3) / float(stiffness.max())
    profile = mdr.continuous_stiffness(
        noisy(one, rng, contact, force, stiffness), one.tip, frame_compliance=one.frame, poisson=POISSON
    )
    known = thickness * (1.0 + 0.02 * rng.normal())
    study = mdr.film_modulus(profile, known, base, thickness_error=0.02 * known, widths=(0.0, 10.0))
    tally(table, "film modulus", *study.interval, one.young)


def pop_in(rng, table, hold):
    """A loading curve with a pop-in, or without one."""
    radius, young = 10.0 ** rng.uniform(-7.0, -4.0), 10.0 ** rng.uniform(9.0, 11.6)
    modulus, n = young / (1.0 - POISSON**2), int(10.0 ** rng.uniform(2.3, 3.7))
    depth = radius * 10.0 ** rng.uniform(-3.0, -1.5)
    force = 4.0 / 3.0 * modulus * math.sqrt(radius) * depth**1.5 * np.linspace(0.0, 1.0, n)
    elastic = (0.75 * force / modulus / math.sqrt(radius)) ** (2.0 / 3.0)
    there, place = rng.random() < 0.5, rng.uniform(0.2, 0.8)
    row = int(place * n)
    noise, force_noise = depth * 10.0 ** rng.uniform(-4.0, -2.5), force[-1] * 10.0 ** rng.uniform(-5.0, -3.5)
    jump = there * (12.0 * noise + depth * 10.0 ** rng.uniform(-2.0, -0.7))
    h = elastic + np.where(np.arange(n) > row, jump, 0.0)
    record = mdr.MeasuredCurve(
        force=force + force_noise * rng.normal(size=n), indentation=h + noise * rng.normal(size=n)
    )
    study = mdr.first_pop_in(record).data.isel(indent=0)
    result = bool(np.isfinite(study["pop_in_force"]))
    if not there:
        table.setdefault("no pop-in where none is", []).append(not result)
        return
    table.setdefault("pop-in found", []).append(result)
    if result:
        tally(
            table,
            "pop-in force",
            float(study["pop_in_force_low"]),
            float(study["pop_in_force_high"]),
            force[row],
        )
        tally(table, "pop-in jump", float(study["pop_in_jump_low"]), float(study["pop_in_jump_high"]), jump)


PARTS = {
    "frame": (unloading, False),
    "frame and drift": (unloading, True),
    "calibration": (calibration, False),
    "calibration with drift": (calibration, True),
    "continuous": (continuous, False),
    "film": (film, False),
    "pop-in": (pop_in, False),
}


def main():
    """Print the coverage of every part."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--only", nargs="*", choices=PARTS, default=list(PARTS))
    parser.add_argument("--seed", type=int, default=SEED)
    arguments = parser.parse_args()
    for name in arguments.only:
        table, refused = {}, {}
        start = time.perf_counter()
        for i in range(arguments.count):
            rng = np.random.default_rng([arguments.seed, i])
            try:
                PARTS[name][0](rng, table, PARTS[name][1])
            except mdr.PymdrError as error:
                kind = str(error)[:110]
                refused[kind] = refused.get(kind, 0) + 1
        seconds = time.perf_counter() - start
        print(f"{name}: {arguments.count} records, {sum(refused.values())} refused, {seconds:.0f} s")
        for label, inside in table.items():
            print(f"  {label:<40} {100.0 * np.mean(inside):5.1f} % of {len(inside)}")
        for kind, count in refused.items():
            print(f"  refused {count}: {kind}")


if __name__ == "__main__":
    main()
