"""Waves and roughness: closed solutions, recorded boundary elements, and surfaces pressed by other packages."""

import math
from collections.abc import Iterator
from importlib.metadata import version
from importlib.util import find_spec

import numpy as np
from scipy.special import struve

import pymdr as mdr
from benchmarks.validation.rows import REFERENCES, UNIT, Row, absent, compared
from pymdr.solving.press.value import PressedSurface

_RADIUS, _WAVES, _LENGTH = 1.0, 1e-3, 0.25
"""Of a wavy ball in m: radius, and amplitude and length of its waves."""
_WAVY = mdr.Paraboloid(_RADIUS) + mdr.Waviness(_WAVES, _LENGTH)
_PACKAGES = (("ContactMechanics", "contactmechanics"), ("tamaas", "tamaas"))


def guduru(a: float, work: float = 0.0) -> tuple[float, float]:
    """Indentation and force of a wavy ball with E* = 1 Pa at a contact radius (Guduru 2007)."""
    k = 2 * math.pi / _LENGTH
    first, second = struve(0, k * a), struve(1, k * a)
    d = a * a / _RADIUS + math.pi / 2 * _WAVES * k * a * first
    force = 4 * a**3 / (3 * _RADIUS) + math.pi * _WAVES * k * a * a * (first - second / (k * a))
    return d - math.sqrt(2 * math.pi * a * work), force - math.sqrt(8 * math.pi * work * a**3)


def wavy() -> Iterator[Row]:
    d, force = guduru(0.4)
    result = mdr.solve(mdr.Contact(_WAVY, UNIT), mdr.indent(d))
    yield compared("wavy ball", result, "normal_force", force, "Guduru (2007)")
    d, force = guduru(0.3, work=1e-3)
    sticky = mdr.Contact(_WAVY, UNIT, adhesion=mdr.JKR(1e-3))
    result = mdr.solve(sticky, mdr.indent(0.3, steps=2) >> mdr.indent(d, steps=2))
    yield compared("wavy ball, JKR", result, "normal_force", force, "Guduru (2007)")


def rough() -> Iterator[Row]:
    for name in ("rough_H0.8_N256", "rough_H0.2_N512"):
        entry, cells = REFERENCES[name], int(name[-3:])
        hurst = entry["inputs"]["H"]
        force, stiffness = (np.array(entry["expected"][key]) for key in ("F", "k"))
        # the range of the claim: 0.03 to 0.85 of the stiffness in full contact
        rows = np.flatnonzero((stiffness > 0.03 * 1.1523) & (stiffness < 0.85 * 1.1523))
        surface = mdr.RoughSurface(hurst, 1.0, 1.0, 4.0 / cells)
        result = mdr.press_rough(surface, UNIT, normal_force=force, realisations=300)
        yield compared(
            f"rough surface as springs, H = {hurst:g}",
            result,
            "normal_stiffness",
            stiffness[rows],
            f"boundary elements, {cells} x {cells}, mean of surfaces, recorded",
            rows,
        )
    surface = mdr.RoughSurface(0.7, 1e-6, 1.0, 0.02)
    full = mdr.press_rough(surface, UNIT, indentation=1e-3, realisations=5)
    source = "capacity of the square, Read (1997), five digits"
    yield compared("the same, in full contact", full, "normal_stiffness", math.pi * 0.36679, source)


def pressed() -> Iterator[Row | str]:
    """Surfaces on a grid, by boundary elements of other packages."""
    x = (np.arange(128) + 0.5) / 128 - 0.5
    heights = -_WAVY.gap(np.hypot(x[:, None], x))
    d, force = guduru(0.4)
    # depths are those of the highest pixel
    known = {"indentation": d + heights.max(), "normal_stiffness": 0.8, "contact_area": math.pi * 0.4**2}
    surface, forces = mdr.RoughSurface(0.8, 0.01, 1.0, 1 / 16, seed=1), [1e-4, 1e-3]
    physics, own = "", None
    for package, engine in _PACKAGES:
        if find_spec(package) is None:
            yield absent("wavy ball", "normal stiffness", package)
            continue
        by = f"{package} {version(package)}, 128 x 128"
        result = mdr.press(mdr.Topography(heights, 1.0), UNIT, normal_force=force, engine=engine)
        for name, truth in known.items():
            yield compared(f"wavy ball, {by}", result, name, truth, "Guduru (2007)")
        other, source = _punch(surface, 128, forces, engine), by
        if own is None:
            physics, own = f"rough patch, {by}", other
            other, source = _punch(surface, 512, forces, engine), "512 x 512"
        for name in ("normal_stiffness", "contact_area"):
            yield compared(physics, own, name, other[name].values, source, slice(None))


def _punch(surface: mdr.RoughSurface, points: int, forces: list[float], engine: str) -> PressedSurface:
    """A rough patch that ends at its border."""
    patch = surface.topography(points=points)
    return mdr.press(patch, UNIT, normal_force=forces, punch=True, engine=engine)


SURFACES = (wavy, rough)
