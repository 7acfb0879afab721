"""Maps of the stress under normal and tangential load against a direct double integral and a spectral solver, and largest stresses of long paths."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

import pymdr as mdr
from benchmarks.timing import Ratio, compare
from pymdr.independent.point_loads import stress_of_tractions

STEEL = mdr.Elastic("210 GPa", 0.3)
BALL = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(0.3))
SIDE = 256
PERIOD = 16
"""Period of the spectral solver over the contact radius; a smaller one adds the loads of its neighbours, a larger one coarsens the contact."""
DIRECT = 40
"""Nodes of the direct integral between two radii; points at less than half the contact radius need more."""


def maps() -> Iterator[Ratio]:
    """A map in section through a contact in partial slip."""
    result = mdr.solve(BALL, mdr.load("50 N") >> mdr.shift("0.5 um"))
    a, c = (float(result[name][-1]) for name in ("contact_radius", "stick_radius"))
    x, z = a * np.linspace(-2.0, 2.0, SIDE), a * np.linspace(0.5, 2.0, SIDE)
    sample = np.random.default_rng(0).choice(SIDE * SIDE, 64, replace=False)
    points = np.array([(x[i % SIDE], 0.0, z[i // SIDE]) for i in sample])

    def direct() -> np.ndarray:
        return stress_of_tractions(
            [c, a],
            lambda r: result.field("pressure", r).values,
            lambda r: result.field("shear_traction", r).values,
            points,
            0.3,
            n=DIRECT,
        )

    computed = result.field("stress", x=x, z=z).values.reshape(6, -1)[:, sample]
    error = np.max(np.abs(computed - direct())) / float(result["peak_pressure"][-1])
    ratio = compare(
        f"stress at {SIDE} x {SIDE} points in partial slip",
        lambda: result.field("stress", x=x, z=z),
        f"a direct double integral at {sample.size} of them, times {SIDE * SIDE // sample.size}",
        direct,
        "aim 0.15 s on one core",
        f"largest difference {error:.1e} of the peak pressure",
    )
    yield replace(ratio, other=ratio.other * SIDE * SIDE / sample.size)


def planes() -> Iterator[Ratio]:
    """All components on a plane below a contact in partial slip, by the method and by a spectral solver of the volume."""
    try:
        import tamaas
    except ImportError:
        print(
            "stress on a plane: tamaas is not installed, so its time is not measured; install pymdr[tamaas]"
        )
        return
    tamaas.set_log_level(tamaas.LogLevel.error)
    result = mdr.solve(BALL, mdr.load("50 N") >> mdr.shift("0.5 um"))
    a, peak = float(result["contact_radius"][-1]), float(result["peak_pressure"][-1])
    width = PERIOD * a
    x = (np.arange(SIDE) - SIDE // 2) * width / SIDE
    radius = np.hypot(*np.meshgrid(x, x, indexing="ij"))
    radii, where = np.unique(radius, return_inverse=True)
    traction = np.zeros((SIDE, SIDE, 3))
    for axis, name in ((0, "shear_traction"), (2, "pressure")):
        traction[..., axis] = result.field(name, radii).values[where].reshape(radius.shape)
    model = tamaas.ModelFactory.createModel(tamaas.model_type.volume_2d, [a, width, width], [2, SIDE, SIDE])
    model.E, model.nu = STEEL.young, STEEL.poisson
    tamaas.ModelFactory.registerVolumeOperators(model)
    strain = np.zeros((2, SIDE, SIDE, 6))
    stress = np.zeros_like(strain)

    def spectral() -> None:
        model.operators["boussinesq_gradient"](traction, strain)
        model.operators["hooke"](strain, stress)

    def ours() -> np.ndarray:
        return result.field("stress", x=x, y=x, z=[a]).values[:, 0].transpose(0, 2, 1)

    spectral()
    near = np.abs(x) <= 1.5 * a
    differences = np.abs(ours()[:3] - np.moveaxis(stress[1, ..., :3], -1, 0))[:, near][:, :, near] / peak
    yield compare(
        f"six components at {SIDE} x {SIDE} points of the plane z = a in partial slip",
        ours,
        f"the spectral volume solver of tamaas {tamaas.__version__} with a period of {PERIOD} a, on this and the surface plane",
        spectral,
        "no aim",
        f"tamaas differs by {differences[2].max():.1e} of the peak pressure in zz and by {differences.max():.1e} in all",
    )


def largest() -> Iterator[Ratio]:
    """The largest von Mises stress of a thousand rows."""
    contact = mdr.Contact(mdr.Sphere("10 mm"), STEEL)
    path = mdr.load("50 N", steps=1000)

    def rows() -> object:
        return mdr.solve(contact, path).largest("von_mises")

    result = mdr.solve(contact, path)
    a = float(result["contact_radius"][-1])
    grid = {"r": np.linspace(0.0, 1.5 * a, 100), "z": np.linspace(0.0, 1.5 * a, 100)}
    yield compare(
        "the largest von Mises stress of 1000 rows, to 1e-8",
        rows,
        "that on a grid of 100 x 100 points, to about 1e-4, in 10 rows",
        lambda: [result.field("von_mises", step=i, **grid).max() for i in range(99, 1000, 100)],
        "aim 1 s",
    )


def ratios() -> Iterator[Ratio]:
    yield from maps()
    yield from planes()
    yield from largest()
