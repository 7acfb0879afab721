"""Fits of force curves: maps on all cores against an own loop over solve, single fits, and nanite where it can be imported.

``python -m benchmarks.fits --curves 65536`` times whole maps in a process of their own, from arrays in Zarr into a folder, with the most memory that it
takes; kills one in the middle, goes on, and says whether the numbers are the same. ``--law Hertz`` or ``"JKR, measured tip"`` takes one of them.

nanite (GPL: only held against) may stand in an environment of its own of the same Python, whose packages come after those here:
``NANITE=/path/to/site-packages python -m benchmarks fits``.
"""

import argparse
import os
import pathlib
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator

import numpy as np
import xarray as xr
from scipy.optimize import least_squares

import pymdr as mdr
from benchmarks.records import records
from benchmarks.timing import Ratio, median_times

TIP, SPRING = mdr.Paraboloid("5 um"), 0.05
CORES = os.cpu_count() or 1
_COPIES = 20
_RADII = np.linspace(0.0, 5e-6, 60)
WORN = mdr.Sampled(_RADII, _RADII**2 / 1e-5 + 2e-8 * np.sin(_RADII / 4e-7) ** 2)


MAPS = {
    "Hertz": (TIP, None, ("body.young",)),
    "JKR, measured tip": (WORN, 1e-3, ("body.young", "adhesion.work")),
}
_SIDE, _KINDS, _KIBIBYTE = 256, 16, 1024


def contact(tip, young, work=None):
    return mdr.Contact(tip, mdr.Elastic(young, 0.5), adhesion=None if work is None else mdr.JKR(work))


def recorded(made, curves, samples, machine):
    """Curves of one contact with noise of 1 %."""
    half = samples // 2
    positions = np.concatenate([np.linspace(-1e-6, 1e-6, half), np.linspace(1e-6, -2e-6, samples - half)])
    channel = "indentation" if machine is None else "travel"
    force = mdr.solve(made, mdr.Path(**{channel: positions}), machine_stiffness=machine)[
        "normal_force"
    ].values
    noisy = force + 0.01 * np.ptp(force) * np.random.default_rng(0).normal(size=(curves, samples))
    data = xr.Dataset({"force": (("curve", "sample"), noisy), channel: ("sample", positions)})
    return data if machine is None else data.assign(spring_constant=machine)


def per_curve(made, data, free):
    """Median processor time of a map on one core over the number of its curves."""
    return median_times(lambda: mdr.fit_map(made, data, free))[0] / data.sizes["curve"]


def own_loop(data):
    """What a user writes: least squares over solve."""
    positions, force = data["indentation"].values, data["force"].values[0]

    def residuals(x):
        path = mdr.Path(indentation=positions - 1e-6 * x[1])
        return 1e9 * (mdr.solve(contact(TIP, 1e3 * x[0]), path)["normal_force"].values + 1e-9 * x[2] - force)

    return least_squares(residuals, [10.0, 0.1, 0.0])


def by_nanite(positions, force, contact_point=None):
    """A Hertz fit by nanite, of its contact point too unless it is given; None where nanite cannot be imported."""
    if "NANITE" in os.environ and os.environ["NANITE"] not in sys.path:
        sys.path.append(os.environ["NANITE"])
    try:
        from nanite import Indentation, model
    except ImportError:
        return None
    columns = {
        "force": force,
        "tip position": -positions,
        "height (measured)": -positions,
        "time": 1e-4 * np.arange(positions.size),
    }
    facts = {
        "path": pathlib.Path("curve"),
        "spring constant": SPRING,
        "imaging mode": "force-distance",
        "enum": 0,
    }
    start = model.models_available["hertz_para"].get_parameter_defaults()
    for name, value in (("R", 5e-6), ("nu", 0.5), ("E", 1e4), ("contact_point", 0.0), ("baseline", 0.0)):
        start[name].value = value
    start["baseline"].vary = True
    if contact_point is not None:
        start["contact_point"].value, start["contact_point"].vary = -contact_point, False

    def fit():
        curve = Indentation(
            data={**columns, "segment": np.zeros(positions.size, dtype=np.uint8)}, metadata=facts
        )
        curve.fit_model(model_key="hertz_para", params_initial=start, preprocessing=[], weight_cp=False)
        return curve.fit_properties["params_fitted"]["E"].value

    return fit


def measured() -> Iterator[Ratio]:
    """Measured approaches with the contact point that pymdr finds, by both: the force curves that are beside the repository."""
    start = contact(TIP, 1e4)
    for name, record in records("approach"):
        curve = mdr.MeasuredCurve(force=record.force, indentation=record.depth)
        point = mdr.fit(start, curve, ["body.young"])["contact_point"].value
        other = by_nanite(record.depth, record.force, point)
        if other is None:
            return
        curves = [curve] * _COPIES

        def ours(curves=curves, point=point):
            return mdr.fit_map(start, curves, ["body.young"], contact_point=point)["body.young"].values[0]

        times = median_times(ours, other)
        difference = abs(other() / ours() - 1.0)
        remark = f"differ by {difference:.0e}" if np.isfinite(difference) else "which finds nothing"
        yield Ratio(
            f"Hertz, the measured {name}, {record.force.size} samples, a curve of a map on one core",
            "nanite with the same contact point",
            times[0] / _COPIES,
            times[1],
            "aim 0.1 %",
            remark,
        )


def attracted(tip, work, young, length="200 nm"):
    """A contact with a cohesive zone."""
    return mdr.Contact(tip, mdr.Elastic(young, 0.5), adhesion=mdr.MaugisDugdale(work, range=length))


def cohesive() -> Iterator[Ratio]:
    """Single fits of Maugis-Dugdale, which solve the width of the cohesive zone anew for each modulus, work and range that they try."""
    free, machines = ["body.young", "adhesion.work"], {"on a machine": SPRING, "over indentation": None}
    starts = {"a measured tip": attracted(WORN, 5e-4, 1e4), "a paraboloid": attracted(TIP, 5e-4, 1e4)}
    for where, machine in machines.items():
        curves = []
        for start in starts.values():
            data = recorded(attracted(start.profile, 1e-3, 3e3), 1, 600, machine)
            channel = "indentation" if machine is None else "travel"
            curves.append(
                mdr.MeasuredCurve(
                    force=data["force"].values[0],
                    spring_constant=machine,
                    **{channel: data[channel].values + 1e-7},
                )
            )
        worn, ball = (
            lambda start=start, curve=curve: mdr.fit(start, curve, free)
            for start, curve in zip(starts.values(), curves, strict=True)
        )
        what = f"Maugis-Dugdale with a measured tip {where}, 600 samples, a single fit"
        yield Ratio(what, "with a paraboloid", *median_times(worn, ball), "aim 1 s")
        if machine is not None:
            what = f"Maugis-Dugdale with a paraboloid {where}, 600 samples, range unknown, a single fit"
            scanned = median_times(
                lambda ball=curves[1]: mdr.fit(starts["a paraboloid"], ball, [*free, "adhesion.range"]), ball
            )
            yield Ratio(what, "range known", *scanned, "it scans the range")


def ratios() -> Iterator[Ratio]:
    approach = recorded(contact(TIP, 3e3), 400, 28000, None).isel(sample=slice(0, 14000))
    hertz = per_curve(contact(TIP, 1e4), approach, ["body.young"])
    what = "Hertz, 14000 samples, a curve of a map on one core"
    curve = mdr.MeasuredCurve(force=approach["force"].values[0], indentation=approach["indentation"].values)
    single = median_times(lambda: mdr.fit(contact(TIP, 1e4), curve, ["body.young"]))[0]
    yield Ratio(what, "a single fit, with claims", hertz, single, "aim 1.4 ms")
    other = by_nanite(approach["indentation"].values, approach["force"].values[0])
    if other is not None:
        ours = float(
            mdr.fit_map(contact(TIP, 1e4), approach.isel(curve=[0]), ["body.young"])["body.young"][0]
        )
        difference = abs(other() / ours - 1.0)
        yield Ratio(
            what,
            "nanite",
            hertz,
            median_times(other)[0],
            "10 times are not reached: 45 % are the spectrum of the noise, which nanite has not",
            f"differ by {difference:.0e}",
        )
    short = recorded(contact(TIP, 3e3), 2000, 500, None)
    yield Ratio(
        "Hertz, 500 samples, a curve of a map on one core",
        "an own least_squares over solve",
        per_curve(contact(TIP, 1e4), short, ["body.young"]),
        median_times(lambda: own_loop(short))[0],
        "",
    )
    times = {}
    for name, tip in (("paraboloid", TIP), ("measured tip", WORN)):
        data = recorded(contact(tip, 3e3, 2e-4), 4000, 500, SPRING)
        times[name] = per_curve(contact(tip, 1e4, 1e-3), data, ["body.young", "adhesion.work"])
    yield Ratio(
        "JKR with a measured tip on a machine, 500 samples, a curve of a map on one core",
        "with a paraboloid",
        times["measured tip"],
        times["paraboloid"],
        "aim 1.4 ms; 65536 curves in 60 s on two cores are 1.8 ms",
    )
    yield from cohesive()
    yield from measured()


def store_of(law, curves, samples, folder):
    """A Zarr store of a map of 16 contacts in turns, each curve with noise of 1 % of its own, written a row of 256 at a time."""
    tip, work, _ = MAPS[law]
    rng = np.random.default_rng(0)
    half = samples // 2
    positions = np.concatenate([np.linspace(-1e-6, 1e-6, half), np.linspace(1e-6, -2e-6, samples - half)])
    path = mdr.Path(travel=positions)
    kinds = np.array(
        [
            mdr.solve(
                contact(tip, young, None if work is None else 7e-8 * young), path, machine_stiffness=SPRING
            )["normal_force"].values
            for young in np.geomspace(1e3, 1e4, _KINDS)
        ]
    )
    for first in range(0, curves, _SIDE):
        force = kinds[np.arange(first, first + _SIDE) % _KINDS]
        force = force + 0.01 * np.ptp(force, axis=1)[:, None] * rng.normal(size=force.shape)
        row = xr.Dataset({"force": (("y", "x", "sample"), force[None], {"units": "N"})})
        if first == 0:
            row = row.assign(
                travel=("sample", positions, {"units": "m"}), spring_constant=((), SPRING, {"units": "N/m"})
            )
            row.to_zarr(
                folder, mode="w", consolidated=False, encoding={"force": {"chunks": (1, _SIDE, samples)}}
            )
        else:
            row.to_zarr(folder, append_dim="y", consolidated=False)


def fit_store(law, curves, folder):
    """Fit a store into a folder and print how many are done as they are, then the seconds, those of all processors, and the most memory in MB."""
    tip, adhesion, free = MAPS[law]
    start = time.perf_counter()
    fitted = mdr.fit_map(
        contact(tip, 1e4, adhesion),
        curves,
        list(free),
        folder=folder,
        workers=CORES,
        progress=lambda done, total: print(f"done {done} of {total}", flush=True),
    )
    seconds, work = time.perf_counter() - start, time.process_time()
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / _KIBIBYTE
    print(
        f"{fitted.counts}, {seconds:.1f} s, {work:.1f} s of all processors, at most {peak:.0f} MB", flush=True
    )


def _process(law, store, folder):
    return subprocess.Popen(
        [sys.executable, "-m", "benchmarks.fits", "--law", law, "--fit", store, folder],
        stdout=subprocess.PIPE,
        text=True,
    )


def whole_map(law, curves, samples, place):
    """Lines that tell how a whole map was fitted, and how one that was killed went on."""
    store, whole, broken = (str(pathlib.Path(place) / name) for name in ("curves", "whole", "broken"))
    store_of(law, curves, samples, store)
    last_line = _process(law, store, whole).communicate()[0].splitlines()[-1]
    yield f"{law}, {curves} curves of {samples} samples on {CORES} cores: {last_line}"
    process = _process(law, store, broken)
    for line in process.stdout:
        if line.startswith("done") and int(line.split()[1]) >= curves // 2:
            process.kill()
            break
    process.communicate()
    done = int((xr.open_zarr(broken, consolidated=False)["ending"] >= 0).sum())
    lines = _process(law, store, broken).communicate()[0].splitlines()
    same = xr.open_zarr(broken, consolidated=False).identical(xr.open_zarr(whole, consolidated=False))
    yield f"{law}, killed after {done} curves, went on from {lines[0]}: {lines[-1]}; {'the same numbers' if same else 'OTHER NUMBERS'}"


def main(words=None):
    """The command line."""
    parser = argparse.ArgumentParser(description="whole maps of force curves")
    parser.add_argument("--curves", type=int, default=65536)
    parser.add_argument("--samples", type=int, default=500)
    parser.add_argument("--law", nargs="+", choices=MAPS, default=list(MAPS))
    parser.add_argument(
        "--fit", nargs=2, metavar=("STORE", "FOLDER"), help="fit one store, as its own process does"
    )
    given = parser.parse_args(words)
    if given.fit:
        fit_store(given.law[0], *given.fit)
        return
    for law in given.law:
        with tempfile.TemporaryDirectory() as place:
            for line in whole_map(law, given.curves, given.samples, place):
                print(line, flush=True)


if __name__ == "__main__":
    main()
