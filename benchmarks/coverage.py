"""How often the intervals of fits hold what made the record: laws, tips and machines, with noise of 1 % and a drift.

``python -m benchmarks.coverage --count 1000`` fits as many records of each law, each with noise of its own on a tilted baseline, and prints the share of the
intervals of 95 % that hold the truth, with the mean and the spread of what is off in standard errors; 93 to 97 % is the aim.
``--only layer memory`` takes some of them. The seed is fixed, so that the same command prints the same.
"""

import argparse
import math
from dataclasses import dataclass
from functools import partial

import numpy as np
import xarray as xr

import pymdr as mdr

TIP = mdr.Paraboloid("5 um")
_RADII = np.linspace(0.0, 5e-6, 60)
WORN = mdr.Sampled(_RADII, _RADII**2 / 1e-5 + 2e-8 * np.sin(_RADII / 4e-7) ** 2)
NOISE, DRIFT, POINT, SEED = 0.01, 0.2, 3e-7, 16
"""The first two in parts of the range of the force."""
WAY = np.concatenate([np.linspace(-1e-6, 1.5e-6, 120), np.linspace(1.5e-6, -2.5e-6, 180)])
TIME = np.linspace(0.0, 4.0, 161)
HELD = np.interp(TIME, [0.0, 0.5, 1.0, 3.0, 4.0], [-0.5e-6, 0.0, 1e-6, 1e-6, -0.5e-6])


@dataclass(frozen=True)
class Study:
    """A contact, from where its numbers are looked for, and along which record."""

    true: mdr.Contact
    start: mdr.Contact
    free: tuple[str, ...]
    machine: float | None = None


def _on(thickness, young):
    return mdr.Layered([mdr.Layer(mdr.Elastic(young, 0.5), thickness)])


def _slow(equilibrium, modulus, time):
    return mdr.Viscoelastic(mdr.StandardSolid(equilibrium, modulus, time), poisson=0.5)


def _sticky(law, tip=TIP, machine=None):
    true = mdr.Contact(tip, mdr.Elastic("3 kPa", 0.5), adhesion=law("0.2 mJ/m^2"))
    start = mdr.Contact(tip, mdr.Elastic("10 kPa", 0.5), adhesion=law("1 mJ/m^2"))
    return Study(true, start, ("body.young", "adhesion.work"), machine)


def _relaxing(machine=None):
    return Study(
        mdr.Contact(TIP, _slow("1 kPa", "2 kPa", "0.5 s")),
        mdr.Contact(TIP, _slow("3 kPa", "3 kPa", "0.2 s")),
        ("body.shear.equilibrium", "body.shear.modulus", "body.shear.time"),
        machine,
    )


STUDIES = {
    "Hertz": Study(
        mdr.Contact(TIP, mdr.Elastic("3 kPa", 0.5)),
        mdr.Contact(TIP, mdr.Elastic("10 kPa", 0.5)),
        ("body.young",),
        0.05,
    ),
    "JKR": _sticky(mdr.JKR, machine=0.05),
    "JKR, measured tip": _sticky(mdr.JKR, WORN, 0.05),
    "DMT": _sticky(mdr.DMT),
    "DMT on a machine": _sticky(mdr.DMT, machine=0.05),
    "Maugis-Dugdale": _sticky(partial(mdr.MaugisDugdale, range="200 nm")),
    "layer": Study(
        mdr.Contact(TIP, _on("3 um", "3 kPa")),
        mdr.Contact(TIP, _on("3 um", "10 kPa")),
        ("body.layers[0].material.young",),
    ),
    "layer and thickness": Study(
        mdr.Contact(TIP, _on("3 um", "3 kPa")),
        mdr.Contact(TIP, _on("5 um", "10 kPa")),
        ("body.layers[0].material.young", "body.layers[0].thickness"),
    ),
    "memory": _relaxing(),
    "memory on a machine": _relaxing(0.05),
}


def tilt_of(force, way):
    """A drift, or a virtual deflection, in N/m."""
    return DRIFT * np.ptp(force) / np.ptp(way)


def records(study, count, seed):
    """Curves of one contact, each with noise of its own, an origin and a baseline that nobody knows."""
    rng = np.random.default_rng(seed)
    slow = study.true.is_viscoelastic
    way = HELD if slow else WAY
    path = mdr.Path(**{"travel" if study.machine else "indentation": way}, **({"time": TIME} if slow else {}))
    force = mdr.solve(study.true, path, machine_stiffness=study.machine)["normal_force"].values
    noisy = (
        force
        + NOISE * np.ptp(force) * rng.normal(size=(count, way.size))
        + 1e-10
        + tilt_of(force, way) * (way - way[0])
    )
    data = xr.Dataset(
        {
            "force": (("curve", "sample"), noisy),
            "travel" if study.machine else "indentation": ("sample", way + POINT),
        }
    )
    if study.machine:
        data = data.assign(spring_constant=study.machine)
    return data.assign(time=("sample", TIME)) if slow else data


def covered(study, count, seed=SEED, workers=1, progress=None):
    """Of every number the share of intervals that hold it, and mean and spread of what is off in standard errors; and the endings."""
    found = mdr.fit_map(
        study.start,
        records(study, count, seed),
        [*study.free, "tilt"],
        workers=workers,
        progress=progress,
    )
    own = {p.name: p.value for p in mdr.parameters_of(study.true)} | {"contact_point": POINT}
    table = {}
    for name in (*study.free, "contact_point"):
        value = own[name]
        off = ((found[name] - value) / found[f"{name}_error"]).values
        off = off[np.isfinite(off)]
        table[name] = float(np.mean(np.abs(off) < 1.96)), float(off.mean()), float(off.std())
    return table, found.counts


def main(words=None):
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--only", nargs="+", choices=STUDIES, default=list(STUDIES))
    given = parser.parse_args(words)
    # three deviations of the count
    slack = 3.0 * math.sqrt(0.05 * 0.95 / given.count)
    print(f"aim 93 to 97 %; the count itself errs by {slack:.1%}")
    for law in given.only:
        table, counts = covered(STUDIES[law], given.count, given.seed, given.workers)
        ended = ", ".join(f"{n} {how}" for how, n in counts.items())
        for name, (share, mean, spread) in table.items():
            print(
                f"{law}: {name} {share:.1%}, off by {mean:+.2f} +- {spread:.2f} errors; {ended}", flush=True
            )


if __name__ == "__main__":
    main()
