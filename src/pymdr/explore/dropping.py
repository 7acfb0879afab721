"""Files that are dropped onto the page: a tip, a force curve to fit, a measured bump, or a case."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path, PurePath
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from pymdr.errors import CaseError, FileError, PymdrError
from pymdr.explore.model import Choice, case_of, fitted_to, of_file, with_path, with_table
from pymdr.explore.seen import Chart, Trace
from pymdr.problem.codec import encode
from pymdr.problem.parameters import parameters_of
from pymdr.solving.azimuth import azimuthal_profile
from pymdr.solving.curves.measured import MeasuredCurve
from pymdr.solving.fits.fitting import fit
from pymdr.units import from_si, good_unit, written
from pymdr.workbench.tables import read_columns, read_curve
from pymdr.workbench.topographies import read_topography

_PRESSED = 0.3
"""Indentation of a measured profile, as a part of its height."""
LARGEST = 16 * 2**20
"""Bytes of a file."""
_FREE = ("body.young", "adhesion.work")
"""Parameters that are fitted unless others are chosen, as far as there are."""


@dataclass(frozen=True)
class Dropped:
    """What a file holds: another choice, or a force curve."""

    choice: Choice
    curve: MeasuredCurve | None
    words: str


@dataclass(frozen=True)
class Fitted:
    """A fit to a dropped force curve."""

    choice: Choice
    chart: Chart
    summary: str


def dropped(name: str, content: bytes, choice: Choice) -> Dropped:
    """
    Read a file by what is in it.

    Parameters
    ----------
    name : str
        Its name; only the suffix is used.
    choice : Choice
        What is chosen: its profile is replaced by a tip or bump, and its machine has the spring constant of curves over travel.
    """
    if len(content) > LARGEST:
        raise FileError(
            f"{name} has {len(content)} bytes (limit {LARGEST}); drop a smaller file, or open it with pymdr on the command line"
        )
    with TemporaryDirectory() as folder:
        file = Path(folder) / f"dropped{_suffix(name)}"
        file.write_bytes(content)
        if file.suffix == ".toml":
            try:
                return Dropped(of_file(file), None, f"{name}: case")
            except PymdrError as error:
                raise CaseError(_without(str(error), file, name)) from error
        faults = []
        for read in (_tip, _curve, _bump):
            try:
                return replace(result := read(file, choice), words=f"{name}: {result.words}")
            except PymdrError as error:
                faults.append(f"as {read.__name__.strip('_')}: {_without(str(error), file, name)}")
    raise FileError(f"{name} cannot be read as a tip, a force curve or a surface. " + "; ".join(faults))


def _suffix(name: str) -> str:
    suffix = PurePath(name.replace("\\", "/")).suffix.lower()
    return suffix if suffix[1:].isalnum() and len(suffix) <= 6 else ".csv"


def _without(message: str, file: Path, name: str) -> str:
    return " ".join(message.replace(str(file), name).replace(file.name, name).split())


def _tip(file: Path, choice: Choice) -> Dropped:
    columns = read_columns(file)
    table: dict[str, Any] = {"kind": "sampled", **{key: values.tolist() for key, values in columns.items()}}
    return _pressed(choice, table, f"tip of {columns['radius'].size} samples")


def _pressed(choice: Choice, table: dict[str, Any], words: str) -> Dropped:
    """A measured profile, pressed to a part of its height: loads of the case before may be beyond its end."""
    depth = _PRESSED * (max(table["height"]) - min(table["height"]))
    leg = {"kind": "indent", "indentation": written(depth, "m", 2), "steps": 40}
    pressed = with_path(with_table(choice, "profile", table), [leg])
    return Dropped(pressed, None, f"{words}; the path is an indentation of {leg['indentation']}")


def _curve(file: Path, choice: Choice) -> Dropped:
    stiffness = choice.tables.get("solve", {}).get("machine_stiffness")
    curve = read_curve(file) if stiffness is None else _over_travel(file, stiffness)
    return Dropped(choice, curve, f"force curve of {curve.force.size} samples; fit parameters to it")


def _over_travel(file: Path, stiffness: Any) -> MeasuredCurve:
    """A curve with the spring constant of the machine; one over indentation needs none."""
    try:
        return read_curve(file, spring_constant=stiffness)
    except CaseError:
        return read_curve(file)


def _bump(file: Path, choice: Choice) -> Dropped:
    bump = azimuthal_profile(read_topography(file))
    return Dropped(
        with_table(choice, "profile", encode(bump.profile)), None, "mean profile of a measured bump"
    )


def free_parameters(choice: Choice) -> tuple[str, ...]:
    """Names of the parameters that can be fitted."""
    try:
        return tuple(p.name for p in parameters_of(case_of(choice).contact))
    except PymdrError:
        return ()


def first_free(choice: Choice) -> tuple[str, ...]:
    """Names of the parameters that are fitted unless others are chosen."""
    known = free_parameters(choice)
    return tuple(name for name in _FREE if name in known)


def fitted(choice: Choice, curve: MeasuredCurve, free: Sequence[str]) -> Fitted:
    """
    Fit parameters of a choice to a force curve by :func:`pymdr.fit`.

    Parameters
    ----------
    choice : Choice
        Its contact; the path is not used.
    free : sequence of str
        Some of :func:`free_parameters`.
    """
    fit_result = fit(case_of(choice).contact, curve, list(free))
    values = {p.name: (p.value, p.unit) for p in parameters_of(fit_result.contact) if p.name in free}
    data = fit_result.data
    x_unit, y_unit = good_unit(data["indentation"].values, "m"), good_unit(data["normal_force"].values, "N")
    x = np.asarray(from_si(data["indentation"].values, "m", x_unit))
    y, model = (np.asarray(from_si(data[n].values, "N", y_unit)) for n in ("normal_force", "model"))
    chart = Chart(
        f"indentation ({x_unit})",
        f"normal force ({y_unit})",
        (Trace("measured", x, y), Trace("fitted", x, model, dashed=True)),
        text="measured and fitted force curve",
    )
    return Fitted(fitted_to(choice, values), chart, fit_result.summary())
