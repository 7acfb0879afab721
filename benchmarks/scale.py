"""What many contacts and curves cost: CPU and bytes of each, memory, and what a cluster of this machine adds.

``python -m benchmarks.scale`` prints the table of docs/scale.md.
"""

import resource
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import xarray as xr

import pymdr as mdr

SAMPLES, PIXELS = 1000, 64
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


def cost(what: str, many: int, work: Callable[[], object]) -> None:
    """Print the CPU of one of many after one run that compiles, and the largest memory of the process so far."""
    work()
    begin = time.process_time()
    work()
    taken = time.process_time() - begin
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{what:50} {1e3 * taken / many:10.3g} ms each, largest memory {peak:.0f} MB", flush=True)


def bytes_of(folder: Path) -> int:
    """All files of a folder."""
    return sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())


def main() -> None:
    """Print the table."""
    for name, contact, free in (
        ("Hertz", GEL, ["body.young"]),
        ("JKR", STICKY, ["body.young", "adhesion.work"]),
    ):
        data = curves_of(contact)
        cost(
            f"fit_map, {name}, {SAMPLES} samples",
            PIXELS**2,
            lambda c=contact, d=data, f=free: mdr.fit_map(c, d, f),
        )
        with tempfile.TemporaryDirectory() as folder:
            data.to_zarr(Path(folder) / "curves.zarr", consolidated=False)
            mdr.fit_map(contact, str(Path(folder) / "curves.zarr"), free, folder=Path(folder) / "fit.zarr")
            stored, found = (
                bytes_of(Path(folder) / part) / PIXELS**2 for part in ("curves.zarr", "fit.zarr")
            )
        print(f"{'':50} {stored:.0f} bytes a curve, {found:.0f} bytes its fit", flush=True)
    radii = {"profile.radius": np.geomspace(1e-4, 1e-2, 400)}
    press, pull = (
        mdr.indent("1 um", steps=100),
        mdr.travel("1 um", steps=300) >> mdr.travel("-1 um", steps=300),
    )
    loop = mdr.load("50 N") >> mdr.cycle(shift="0.5 um", cycles=2, steps=200)
    cost("sweep, Hertz, 100 rows", 400, lambda: mdr.sweep(GEL, press, radii))
    cost(
        "sweep, JKR with a machine, 600 rows",
        400,
        lambda: mdr.sweep(STICKY, pull, radii, machine_stiffness=0.05),
    )
    cost("sweep, friction, 401 rows", 400, lambda: mdr.sweep(JOINT, loop, radii))
    rough = mdr.RoughSurface(hurst=0.8, rms="1 um", size="1 mm", shortest="4 um")
    cost(
        "press_rough, 4000 springs",
        100,
        lambda: mdr.press_rough(rough, STEEL, normal_force=[1.0, 10.0], workers=1),
    )
    on_cluster(radii)


def on_cluster(radii: dict[str, np.ndarray]) -> None:
    """What a local cluster of two processes adds to a sweep."""
    from distributed import Client, LocalCluster

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
