"""Case files: a problem as TOML."""

from __future__ import annotations

import json
import os
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from pymdr.errors import CaseError, errors_of_case
from pymdr.independent.rings import Rings
from pymdr.presentation.files import named_file
from pymdr.problem.codec import (
    MachineCase,
    PressCase,
    RoughCase,
    decode_case,
    decode_contact,
    decode_machine,
    decode_press,
    decode_rough,
)
from pymdr.problem.codec.outputs import OUTPUTS
from pymdr.problem.contact import Contact
from pymdr.problem.paths import CHANNELS, LoadingPath
from pymdr.problem.rough import RoughSurface
from pymdr.problem.schedule import check_times, is_torsional
from pymdr.problem.topography import Topography
from pymdr.solving.verb import check_tolerance
from pymdr.units import shown, to_si, to_si_array
from pymdr.workbench.inputs import read_text

_LARGEST = 4 * 2**20
Read = TypeVar("Read")


@dataclass(frozen=True)
class Case:
    """The contents of a case file."""

    file: Path
    title: str
    contact: Contact
    path: LoadingPath
    options: dict[str, Any]
    """Keyword arguments of :func:`pymdr.solve`, from the table ``[solve]``."""
    outputs: Mapping[str, Mapping[str, Any]]
    """The tables ``[stress]``, ``[first_yield]``, ``[shakedown]``, ``[pull_off]``, ``[fatigue]`` and ``[wear]``, as far as there are."""


def read_case(file: str | os.PathLike[str]) -> Case:
    """
    Read a case file.

    Parameters
    ----------
    file : path
        A TOML file with the tables ``[profile]``, ``[body]``, optionally ``[counterbody]``,
        ``[adhesion]``, ``[friction]``, ``[solve]``, ``[stress]``, ``[first_yield]``, ``[shakedown]``, ``[pull_off]``, ``[fatigue]`` and ``[wear]``, and one ``[[path]]`` for
        every leg.
    """
    return _decoded(file, lambda plain, source: case_of_tables(_with_tables(plain, source.parent), source))


def case_of_tables(tables: Mapping[str, Any], file: Path = Path()) -> Case:
    """
    A case from the tables of a case file, in which nothing is left to read from other files.

    Parameters
    ----------
    tables : mapping
        As :func:`read_tables` returns them.
    file : path
        Their file, if there is one.

    Examples
    --------
    >>> tables = {"profile": {"kind": "sphere", "radius": "1 mm"}, "body": {"kind": "elastic", "young": "1 GPa", "poisson": 0.3}}
    >>> case_of_tables({**tables, "path": [{"kind": "load", "normal_force": "1 N"}]}).contact.profile
    Sphere(radius=0.001)
    """
    title, contact, path = decode_case(tables)
    check_times(path, needed=contact.is_viscoelastic)
    outputs = {name: tables[name] for name in OUTPUTS if name in tables}
    for name, wanted in outputs.items():
        _check_output(name, wanted, contact, path)
    options = _options(tables.get("solve", {}))
    with errors_of_case("[solve]"):
        check_tolerance(contact, options.get("tolerance"), options.get("solver"))
    return Case(file, title, contact, path, options, outputs)


def read_tables(file: str | os.PathLike[str]) -> dict[str, Any]:
    """Read the tables of a case file as plain values, with the columns of its CSV files in place of their names."""
    return _decoded(file, lambda plain, source: _with_tables(plain, source.parent))


def case_text(tables: Mapping[str, Any]) -> str:
    """
    The TOML text of the tables of a case.

    Parameters
    ----------
    tables : mapping
        Plain values: texts, numbers, arrays, lists and tables of them.

    Returns
    -------
    str
        A case file; :func:`read_tables` is the inverse.

    Examples
    --------
    >>> print(case_text({"title": "Ball", "profile": {"kind": "sphere", "radius": "1 mm"}, "path": [{"kind": "hold"}]}), end="")
    title = "Ball"
    <BLANKLINE>
    [profile]
    kind = "sphere"
    radius = "1 mm"
    <BLANKLINE>
    [[path]]
    kind = "hold"
    """
    single = [f"{name} = {_toml(value)}\n" for name, value in tables.items() if not _is_table(value)]
    for name, value in tables.items():
        if _is_table(value):
            parts = (
                [(f"[{name}]", value)] if isinstance(value, Mapping) else [(f"[[{name}]]", v) for v in value]
            )
            single += [
                f"\n{head}\n" + "".join(f"{key} = {_toml(entry)}\n" for key, entry in part.items())
                for head, part in parts
            ]
    return "".join(single)


def _is_table(value: object) -> bool:
    return isinstance(value, Mapping) or (
        isinstance(value, list) and bool(value) and all(isinstance(entry, Mapping) for entry in value)
    )


def _toml(value: Any) -> str:
    """A value of a key; tables are written on one line."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_toml(entry)}" for key, entry in value.items()) + " }"
    if isinstance(value, list | tuple | np.ndarray):
        return "[" + ", ".join(_toml(entry) for entry in value) + "]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007F")
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value.item() if isinstance(value, np.generic) else value)


def _check_output(name: str, wanted: Mapping[str, Any], contact: Contact, path: LoadingPath) -> None:
    """Refuse a table of :data:`OUTPUTS` whose values are none before anything is solved."""
    with errors_of_case(f"[{name}]:"):
        if name == "stress":
            _check_stress(wanted, contact, path)
        elif name == "fatigue":
            from pymdr.solving.fatigue import criterion_of

            criterion_of(
                wanted["criterion"], **{key: wanted.get(key) for key in ("slope", "yield_strength", "limit")}
            )
        for key in ("strength", "tensile_strength", "bond_strength", "bulk", "bulk_amplitude"):
            values = wanted.get(key, [])
            for value in values if isinstance(values, list) else [values]:
                to_si(value, "Pa", name=key)


def _check_stress(wanted: Mapping[str, Any], contact: Contact, path: LoadingPath) -> None:
    """Refuse points of a table that are none."""
    from pymdr.inside import background_of

    superposed = wanted.get("superposed")
    background_of(superposed)
    for axis in ("r", "x", "z"):
        if axis in wanted:
            values = to_si_array(wanted[axis], "m", name=axis)
            if axis == "z" and not np.all(values >= 0.0):
                raise CaseError(
                    f"z = {shown(wanted[axis])}; depths of at least 0 m are needed, in either body"
                )
    if "r" in wanted and "x" in wanted:
        raise CaseError("r and x are given; give one of them")
    directed = contact.friction is not None and not is_torsional(path)
    if "r" in wanted and (directed or superposed):
        raise CaseError(
            f"r = {shown(wanted['r'])}; with friction or a superposed stress the field is not of revolution; give x instead of r"
        )


def read_contact(file: str | os.PathLike[str]) -> tuple[str, Contact]:
    """Read the title and the contact of a case file; the path is optional."""
    return _decoded(file, lambda plain, source: decode_contact(_with_tables(plain, source.parent)))


def read_rough_case(file: str | os.PathLike[str]) -> RoughCase:
    """
    Read a case file of a rough surface.

    Parameters
    ----------
    file : path
        A TOML file with the tables ``[surface]``, ``[body]`` and optionally ``[counterbody]`` and ``[ball]``.
    """
    return _decoded(file, lambda plain, _: decode_rough(plain))


def read_press_case(file: str | os.PathLike[str]) -> tuple[PressCase, Topography | RoughSurface]:
    """
    Read a case file of a surface pressed by boundary elements.

    Parameters
    ----------
    file : path
        A TOML file with the tables ``[surface]`` (measured or random), ``[body]`` and optionally ``[counterbody]`` and
        ``punch``.

    Returns
    -------
    case : PressCase
    surface : Topography or RoughSurface
    """

    def decode(plain: dict[str, Any], source: Path) -> tuple[PressCase, Topography | RoughSurface]:
        case = decode_press(plain)
        if isinstance(case.surface, RoughSurface):
            return case, case.surface
        keys = dict(case.surface)
        from pymdr.workbench.topographies import read_topography

        return case, read_topography(source.parent / keys.pop("file"), keys.pop("channel", None), **keys)

    return _decoded(file, decode)


def read_machine_case(file: str | os.PathLike[str]) -> MachineCase:
    """
    Read a case file of a machine.

    Parameters
    ----------
    file : path
        A TOML file with the table ``[machine]``, its ``[[machine.bodies]]`` and ``[[machine.links]]``, and the contact of its joints.
    """
    return _decoded(file, lambda plain, source: decode_machine(_with_tables(plain, source.parent)))


def has_table(file: str | os.PathLike[str], name: str) -> bool:
    """Whether a case file has a table, such as ``[machine]`` or ``[surface]``."""
    return name in _tables(named_file(file, "read"))


def _decoded(file: str | os.PathLike[str], decode: Callable[[dict[str, Any], Path], Read]) -> Read:
    """What `decode` makes of the tables of a file and its name; errors name the file."""
    source = named_file(file, "read")
    plain = _tables(source)
    with errors_of_case(f"{source}:"):
        return decode(plain, source)


def _tables(source: Path) -> dict[str, Any]:
    """The tables of a TOML file."""
    text = read_text(source, _LARGEST, "case file")
    try:
        return tomllib.loads(text)
    except RecursionError as error:
        raise CaseError(f"{source}: tables or lists are nested too deeply") from error
    except ValueError as error:
        fault = str(error) if isinstance(error, tomllib.TOMLDecodeError) else "a number has too many digits"
        raise CaseError(f"{source}: not TOML: {fault}") from error


def _options(plain: Mapping[str, Any]) -> dict[str, Any]:
    """The table ``[solve]`` as keyword arguments of :func:`pymdr.solve`."""
    solver = plain.get("solver")
    return {**plain, **({} if solver is None else {"solver": Rings(solver.get("n", 400))})}


def _with_tables(plain: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The case with its CSV files read; file names are relative to the case file."""
    profile, legs = plain.get("profile"), plain.get("path")
    if isinstance(profile, dict):
        profile = _with_samples(profile, folder)
        if isinstance(profile.get("parts"), list):
            parts = [_with_samples(p, folder) if isinstance(p, dict) else p for p in profile["parts"]]
            profile = {**profile, "parts": parts}
        plain = {**plain, "profile": profile}
    for table in ("body", "counterbody"):
        if isinstance(plain.get(table), dict):
            plain = {**plain, table: _with_rheometry(plain[table], folder, table)}
    if isinstance(legs, dict):
        legs = [legs]
    if isinstance(legs, list):
        read = [_with_record(leg, folder, i) if isinstance(leg, dict) else leg for i, leg in enumerate(legs)]
        plain = {**plain, "path": read}
    return plain


def _with_samples(profile: dict[str, Any], folder: Path) -> dict[str, Any]:
    kind = profile.get("kind")
    if kind not in ("sampled", "force_curve") or "file" not in profile:
        return profile
    from pymdr.workbench.tables import read_columns, read_curve_columns

    known, content, read = (
        (("radius", "height", "scatter"), "the samples", read_columns)
        if kind == "sampled"
        else (("indentation", "force"), "the points", read_curve_columns)
    )
    _refuse_both(profile, known, "[profile]", content)
    file = _named(profile["file"], folder, "[profile]")
    with errors_of_case("[profile]"):
        columns = read(file)
    return {**{key: value for key, value in profile.items() if key != "file"}, **columns}


def _with_rheometry(body: dict[str, Any], folder: Path, table: str) -> dict[str, Any]:
    if body.get("kind") == "viscoelastic" and "shear" in body and "young" in body:
        raise CaseError(f"[{table}] gives both shear and young; give one of them")
    for key in ("shear", "young"):
        law = body.get(key)
        if not isinstance(law, dict) or law.get("kind") != "prony" or "file" not in law:
            continue
        where = f"[{table}.{key}]"
        _refuse_both(law, ("equilibrium", "moduli", "times"), where, "the series")
        from pymdr.workbench.rheometry import fit_prony

        file = _named(law["file"], folder, where)
        with errors_of_case(where):
            series = fit_prony(file, poisson=body.get("poisson")).series
        rest = {name: value for name, value in law.items() if name != "file"}
        terms = {"equilibrium": series.equilibrium, "moduli": series.moduli, "times": series.times}
        # the fitted series is always in shear
        body = {**{name: value for name, value in body.items() if name != key}, "shear": {**rest, **terms}}
    return body


def _with_record(leg: dict[str, Any], folder: Path, index: int) -> dict[str, Any]:
    where = f"[path {index + 1}]"
    if leg.get("kind") == "path" and "channels" in leg and "file" not in leg:
        raise CaseError(
            f"{where} channels = {leg['channels']!r}: channels are columns of a file; give file, or leave channels out"
        )
    if leg.get("kind") != "path" or "file" not in leg:
        return leg
    from pymdr.workbench.tables import read_path

    _refuse_both(leg, ("time", *CHANNELS), where, "the history")
    file = _named(leg["file"], folder, where)
    with errors_of_case(where):
        read = read_path(file, channels=leg.get("channels"))
    named = ((name, getattr(read, name)) for name in ("time", *CHANNELS))
    columns = {name: values for name, values in named if values is not None}
    rest = {key: value for key, value in leg.items() if key not in ("file", "channels")}
    return {"relative_time": index > 0, **rest, **columns}


def _refuse_both(table: Mapping[str, Any], keys: Sequence[str], where: str, content: str) -> None:
    both = [key for key in keys if key in table]
    if both:
        raise CaseError(f"{where} gives both file and {both[0]}; give {content} once")


def _named(file: object, folder: Path, where: str) -> Path:
    if not isinstance(file, str) or not file:
        raise CaseError(f"{where} file = {file!r}: the name of a CSV file is needed")
    return folder / file
