"""The verb `press`: check, press load by load, interpret."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Unpack

import numpy as np

from pymdr.deferred import xr
from pymdr.errors import ProblemError
from pymdr.independent.engines import Engine, find_engine
from pymdr.interpretation.conductance import conduction_of_stiffness
from pymdr.interpretation.press import press_assumptions, press_claims
from pymdr.interpretation.validity import Claim, Level
from pymdr.machine import memory_of_machine
from pymdr.mapping.moduli import effective_moduli
from pymdr.presentation.text import bytes_text
from pymdr.problem.materials import Graded, Material, Rigid, Viscoelastic
from pymdr.problem.options import with_options
from pymdr.problem.rough import RoughSurface
from pymdr.problem.topography import Topography, as_topography
from pymdr.solving.arguments import Loads, positive_loads
from pymdr.solving.press.states import (
    TOLERANCE,
    Grid,
    State,
    as_dataset,
    fingerprint,
    from_dataset,
    rms_slope,
    summit_rise,
)
from pymdr.solving.press.value import PressedSurface
from pymdr.solving.study import over_rows
from pymdr.solving.workers import KeptParts
from pymdr.units import FloatArray, shown

_FEWEST = 8
"""Smallest number of pixels along the shorter side."""
_MAPS, _WORKING = 2, 12
"""Arrays of the size of the grid: per load in memory, and for the solution."""
_FINE, _COARSE = 4, 1
"""Parts of the work of a load."""


@with_options(Loads)
def press(
    surface: Topography | RoughSurface,
    body: Material,
    counterbody: Material | None = None,
    *,
    punch: bool = False,
    engine: str | Engine | None = None,
    keep: str | os.PathLike[str] | None = None,
    progress: Callable[[int, int], None] | None = None,
    **load: Unpack[Loads],
) -> PressedSurface:
    """
    Press a surface of any shape on a half-space by boundary elements, without friction and adhesion.

    Every pixel has a constant pressure; neither pressures nor gaps are below 0. The stiffness k = dF/dd is that of the rigid
    punch on the contact. Each load is also solved on every second pixel; the change is the error in the claims.

    Parameters
    ----------
    surface : Topography or RoughSurface
        Heights without gaps; of a RoughSurface its first realisation, :meth:`~pymdr.RoughSurface.topography`, as a punch.
    body : Elastic or TransverselyIsotropic
        Half-space.
    counterbody : Elastic, TransverselyIsotropic or Rigid, optional
        Rigid by default.
    normal_force, indentation : array_like or quantity
        Forces in N, or depths in m of the highest pixel; exactly one, one row, above 0. They are solved in ascending order.
    punch : bool, optional
        Whether the body ends at the border of the heights. Otherwise a contact at the border is refused.
    engine : str or Engine, optional
        ``"contactmechanics"`` (extra ``rough``, the default), ``"tamaas"`` (AGPL, extra ``tamaas``), ``"aspher"`` (from source), or that
        of an entry point in the group ``pymdr.engines``.
    keep : path, optional
        Folder of solved loads, from which an interrupted run continues. A folder with results of other input is refused.
    progress : callable, optional
        Called as ``progress(done, total)``.

    Returns
    -------
    PressedSurface
        Over the loads: force (N), indentation (m), stiffness (N/m), area (m^2), pressures (Pa), energy (J); maps of pressure and gap.

    Raises
    ------
    ProblemError
        If heights are missing, not one load is given, it is not above 0, a body is graded or viscoelastic, or memory is too small.
    MissingExtraError
        If the package of the engine is not installed.
    FileError
        If the folder has results of other input.
    ConvergenceError
        If the engine did not solve a load.

    See Also
    --------
    press_rough : random surfaces by springs.
    open_pressed_surface : a saved one.

    Notes
    -----
    Kernel of Love (1929), iteration of Polonsky and Keer (1999). Errors for Hertz with 26 and 77 pixels in the contact
    radius: force 7e-5 and 1e-5, stiffness 8e-4 and 2e-4.

    References
    ----------
    - Love (1929), Phil. Trans. R. Soc. A 228, 377-420.
    - Polonsky and Keer (1999), Wear 231, 206-219.

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> x = np.linspace(-0.5, 0.5, 65)[:-1] + 0.5 / 64
    >>> ball = mdr.Topography(-(x[:, None] ** 2 + x**2) * 5e-7, "1 mm")  # of R = 1 m: by Hertz 39.56 mN
    >>> pressed = mdr.press(ball, mdr.Elastic("1 GPa", 0.3), indentation="90 nm")
    >>> round(float(pressed["normal_force"][0]) * 1e3, 2)
    39.61
    """
    modulus = _modulus(body, counterbody)
    name, rows = positive_loads(load)
    solver = find_engine(engine)
    _refuse_too_large(pixels_of(surface), rows.size, solver, keep is not None)
    patch, punch = patch_of(surface, punch)
    numerics = {"modulus": modulus, "engine": solver.version, "tolerance": TOLERANCE}
    identity = {"heights": fingerprint(patch), name: rows.tolist()} | numerics
    parts = None if keep is None else KeptParts(keep, identity)
    states = _followed(patch, modulus, rows, name == "normal_force", solver, parts, progress)
    columns = _columns(patch, states)
    claims = press_claims(columns, name, punch, solver.version)
    lengths = {"": columns["normal_stiffness"] / (2.0 * modulus)}
    conducted = conduction_of_stiffness(body, counterbody or Rigid(), lengths, claims["normal_stiffness"])
    columns, claims = columns | conducted[0], claims | conducted[1]
    grid = {"points": patch.heights.shape, "size": tuple(patch.size.tolist())}
    return PressedSurface(
        data=_labelled(name, columns, claims, numerics | grid),
        surface=patch,
        maps=tuple((state.pressure, state.gap) for state in states),
        claims=claims,
        assumptions=press_assumptions(columns, int(np.argmax(columns["indentation"]))),
    )


def _columns(patch: Topography, states: Sequence[State]) -> dict[str, FloatArray]:
    """The numbers of all loads."""
    columns = {field: np.array([getattr(state, field) for state in states]) for field in State.numbers()}
    columns["rise"] = np.full(len(states), summit_rise(patch.heights))
    columns["peak_pressure"] = np.array([float(state.pressure.max()) for state in states])
    columns["mean_pressure"] = columns["normal_force"] / columns["contact_area"]
    return columns


def bytes_of(
    shape: tuple[int, int], loads: int, engine: str | Engine | None = None, *, kept: bool = False
) -> float:
    """
    Memory of a run.

    Parameters
    ----------
    shape : tuple of int
        Pixels along x and y.
    engine : str or Engine, optional
    kept : bool, optional
        Whether results are also stored in a folder.
    """
    pixels = float(shape[0]) * shape[1]
    return find_engine(engine).bytes_for(shape) * 1.25 + 8.0 * pixels * (_MAPS * loads + _WORKING + 2 * kept)


def pixels_of(surface: Topography | RoughSurface) -> tuple[int, int]:
    """Pixels along x and y of a surface, before heights are generated."""
    if isinstance(surface, RoughSurface):
        return surface.pixels()
    nx, ny = as_topography(surface).heights.shape
    return nx, ny


def patch_of(surface: Topography | RoughSurface, punch: bool = False) -> tuple[Topography, bool]:
    """The heights, and whether the body ends at their border."""
    if not isinstance(punch, bool | np.bool_):
        raise ProblemError(
            f"punch = {shown(punch)}; give True if the body ends at the border of the heights, else False"
        )
    if isinstance(surface, RoughSurface):
        return surface.topography(), True
    missing = int(np.count_nonzero(surface.missing))
    if missing:
        raise ProblemError(
            f"{missing} of {surface.heights.size} heights are missing; fill them, or crop to a complete patch"
        )
    if min(surface.heights.shape) < _FEWEST:
        raise ProblemError(
            f"{surface.heights.shape[0]} x {surface.heights.shape[1]} heights; at least {_FEWEST} x {_FEWEST} are needed"
        )
    return surface, punch


def _refuse_too_large(shape: tuple[int, int], loads: int, engine: Engine, kept: bool) -> None:
    needed = bytes_of(shape, loads, engine, kept=kept)
    if needed > memory_of_machine():
        raise ProblemError(
            f"{shape[0]} x {shape[1]} pixels at {loads} loads need about {bytes_text(round(needed))} (limit "
            f"{bytes_text(round(memory_of_machine()))}, the memory of this machine); use fewer loads, a part of the surface, or a longer shortest wavelength of a RoughSurface"
        )


def _modulus(body: Material, counterbody: Material | None) -> float:
    other = Rigid() if counterbody is None else counterbody
    for one in (body, other):
        if isinstance(one, Graded | Viscoelastic):
            raise ProblemError(
                f"a {type(one).__name__} body: engines solve homogeneous elastic half-spaces; use Elastic or "
                "TransverselyIsotropic (for a viscoelastic body press an elastic one, and give its force_curve() as the profile)"
            )
    return float(effective_moduli(body, other).normal)


def _followed(
    patch: Topography,
    modulus: float,
    rows: FloatArray,
    by_force: bool,
    engine: Engine,
    parts: KeptParts | None,
    progress: Callable[[int, int], None] | None,
) -> list[State]:
    """The states at all loads, each started from the one below it."""
    fine, coarse = (_grid(patch, step, engine) for step in (1, 2))
    longest = math.sqrt(float(patch.size.prod()))
    total = (_FINE + _COARSE) * rows.size
    kept = {} if parts is None else {row: from_dataset(part) for row, part in parts.parts()}
    states: dict[int, State] = {}
    before: State | None = None
    for done, row in enumerate(np.argsort(rows, kind="stable").tolist()):
        state = kept.get(row)
        if state is None:
            load = {"force" if by_force else "indentation": float(rows[row])}
            scale = float(rows[row]) / (modulus * longest) if by_force else float(rows[row])
            start = None if before is None else before.pressure / modulus
            solved, numbers = fine.press(scale, modulus, start=start, **load)
            if progress is not None:
                progress((_FINE + _COARSE) * done + _FINE, total)
            coarse_numbers = _on_coarse(fine, coarse, scale, modulus, load)
            touching = solved.pressure > 0.0
            state = State(
                **numbers,
                pixels=float(np.count_nonzero(touching)),
                touches_border=float(_at_border(touching)),
                rms_slope=rms_slope(patch.heights, patch.spacing, touching),
                **coarse_numbers,
                pressure=solved.pressure * (modulus * scale / fine.width),
                gap=np.where(touching, 0.0, np.maximum(solved.gap, 0.0)) * scale,
            )
            if parts is not None:
                parts.keep(row, as_dataset(state, patch))
        states[row] = before = state
        if progress is not None:
            progress((_FINE + _COARSE) * (done + 1), total)
    return [states[row] for row in range(rows.size)]


def _grid(patch: Topography, step: int, engine: Engine) -> Grid:
    """The grid of every pixel of a surface, or every second one along both sides."""
    heights = np.ascontiguousarray(patch.heights[::step, ::step])
    spacing = patch.spacing * step
    width = math.sqrt(spacing[0] * spacing[1])
    shape = (heights.shape[0], heights.shape[1])
    half_space = engine.half_space(shape, (float(spacing[0] / width), float(spacing[1] / width)))
    return Grid(half_space, heights, spacing)


def _at_border(touching: np.ndarray) -> bool:
    return bool(any(edge.any() for edge in (touching[0], touching[-1], touching[:, 0], touching[:, -1])))


def _on_coarse(
    fine: Grid, coarse: Grid, scale: float, modulus: float, load: dict[str, float]
) -> dict[str, float]:
    """The numbers on every second pixel, with the plane at the same place."""
    lower = float(fine.heights.max() - coarse.heights.max())
    names = ("normal_force", "indentation", "normal_stiffness", "contact_area")
    depth = load.get("indentation")
    if depth is not None:
        if depth <= lower:
            return {f"coarse_{name}": 0.0 for name in names}
        load = {"indentation": depth - lower}
    _, numbers = coarse.press(scale, modulus, start=None, **load)
    numbers["indentation"] += lower
    return {f"coarse_{name}": numbers[name] for name in names}


def _labelled(
    name: str, columns: dict[str, FloatArray], claims: Mapping[str, Claim], attributes: Mapping[str, Any]
) -> xr.Dataset:
    """Columns with units over the given load, NaN where their claims do not hold."""
    valid = {
        other: np.where(claims[other].where, columns[other], np.nan)
        for other in PressedSurface.columns
        if other != name and other in claims and claims[other].level is not Level.NOT_VALID
    }
    return over_rows(name, columns[name], valid, PressedSurface.columns, attributes)
