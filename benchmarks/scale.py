"""What many contacts and curves cost: CPU, bytes and memory of each, and what a cluster of this machine adds.

``python -m benchmarks.scale`` prints the table of docs/scale.md.
"""

import multiprocessing
import resource
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import xarray as xr

import pymdr as mdr

SAMPLES, PIXELS, CONTACTS = 1000, 64, 100
GEL = mdr.Contact(mdr.Paraboloid("5 um"), mdr.Elastic("10 kPa", 0.5))
STICKY = mdr.Contact(GEL.profile, GEL.body, adhesion=mdr.JKR("0.2 mJ/m^2"))
STEEL = mdr.Elastic("210 GPa", 0.3)
JOINT = mdr.Contact(mdr.Sphere("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(0.3))


def curves_of(contact: mdr.Contact) -> xr.Dataset:
    """Noisy curves of a contact, an image of 64 x 64."""
    depth = np.linspace(-0.2e-6, 1e-6, SAMPLES)
    clean = mdr.solve(contact, mdr.Path(indentation=depth[::-1]))["normal_force"].values[::-1]
    noise = 0.002 * clean.max() * np.random.default_rng(0).standard_normal((PIXELS, PIXELS, SAMPLES))
    force = (("y", "x", "sample"), np.nan_to_num(clean) + noise, {"units": "N"})
    return xr.Dataset({"force": force, "indentation": ("sample", depth, {"units": "m"})})


def cost(what: str, many: int, work: Callable[[Path, int], object]) -> None:
    """
    Print CPU, stored bytes and memory of one of many, which are written into a folder.

    After a run that compiles, a quarter and all of them run in forked processes; the memory of one is the difference between the peaks over
    the difference between the numbers.
    """
    context = multiprocessing.get_context("fork")
    receive, send = context.Pipe(duplex=False)

    def measured(folder: Path, number: int) -> None:
        begin = time.process_time()
        work(folder, number)
        send.send((time.process_time() - begin, 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss))

    few = many // 4
    with tempfile.TemporaryDirectory() as folder:
        work(Path(folder) / "compiled", few)
        peaks = []
        for number in (few, many):
            kept = Path(folder) / f"kept-{number}"
            child = context.Process(target=measured, args=(kept, number))
            child.start()
            taken, peak = receive.recv()
            child.join()
            peaks.append(peak)
        stored = sum(file.stat().st_size for file in kept.rglob("*") if file.is_file())
    print(
        f"{what:40} {1e3 * taken / many:9.3g} ms, {stored / many:9.3g} bytes, "
        f"{(peaks[1] - peaks[0]) / (many - few):9.3g} bytes of memory; peak {peaks[1] / 1e6:.0f} MB",
        flush=True,
    )


def main() -> None:
    """Print the table."""

    def swept(*arguments: object, **options: object) -> Callable[[Path, int], object]:
        def work(folder: Path, number: int) -> object:
            radii = {"profile.radius": np.geomspace(1e-4, 1e-2, number)}
            return mdr.sweep(*arguments, radii, folder=folder, **options)

        return work

    press, pull = (
        mdr.indent("1 um", steps=100),
        mdr.travel("1 um", steps=300) >> mdr.travel("-1 um", steps=300),
    )
    loop = mdr.load("50 N") >> mdr.cycle(shift="0.5 um", cycles=2, steps=200)
    cost("sweep, Hertz, 100 rows", CONTACTS, swept(GEL, press))
    cost("sweep, friction, 401 rows", CONTACTS, swept(JOINT, loop))
    cost("sweep, JKR with a machine, 600 rows", CONTACTS, swept(STICKY, pull, machine_stiffness=0.05))
    rough = mdr.RoughSurface(hurst=0.8, rms="1 um", size="1 mm", shortest="4 um")

    def lines(folder: Path, number: int) -> None:
        folder.mkdir()
        pressed = mdr.press_rough(rough, STEEL, normal_force=[1.0, 10.0], realisations=number, workers=1)
        pressed.save(folder / "lines.nc")

    cost("press_rough, 4000 springs", CONTACTS, lines)
    for name, contact, free in (
        ("Hertz", GEL, ["body.young"]),
        ("JKR", STICKY, ["body.young", "adhesion.work"]),
    ):
        data = curves_of(contact)
        cost(
            f"fit_map, {name}, {SAMPLES} samples",
            PIXELS**2,
            lambda folder, number, c=contact, d=data, f=free: mdr.fit_map(
                c, d.isel(y=slice(number // PIXELS)), f, folder=folder
            ),
        )
    with tempfile.TemporaryDirectory() as folder:
        data.to_zarr(Path(folder) / "curves.zarr", consolidated=False)
        stored = sum(file.stat().st_size for file in Path(folder).rglob("*") if file.is_file())
    print(f"{'a curve in Zarr':40} {stored / PIXELS**2:.0f} bytes", flush=True)
    on_cluster()


def on_cluster() -> None:
    """What a local cluster of two processes adds to a sweep of 400 contacts."""
    from distributed import Client, LocalCluster

    radii = {"profile.radius": np.geomspace(1e-4, 1e-2, 400)}
    pull = mdr.travel("1 um", steps=300) >> mdr.travel("-1 um", steps=300)
    with (
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        for workers, name in ((client, "dask, two processes"), (2, "two processes"), (1, "one process")):
            mdr.sweep(STICKY, pull, radii, machine_stiffness=0.05, workers=workers)
            begin = time.perf_counter()
            mdr.sweep(STICKY, pull, radii, machine_stiffness=0.05, workers=workers)
            print(f"{'the sweep of JKR by ' + name:50} {time.perf_counter() - begin:10.3g} s", flush=True)


if __name__ == "__main__":
    main()
