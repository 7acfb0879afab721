"""Results as NetCDF files: written whole or not at all, read with care."""

from __future__ import annotations

import contextlib
import json
import os
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any

import numpy as np

from pymdr.errors import FileError, PymdrError
from pymdr.interpretation.validity import SOURCES, Assumption, Claim, Level
from pymdr.problem.codec import decode_case, encode_case
from pymdr.problem.contact import Contact
from pymdr.problem.paths import CHANNELS, History, Leg, LoadingPath, Path, legs
from pymdr.quantities import BAND_ENDS, QUANTITIES

if TYPE_CHECKING:
    import xarray as xr

FORMAT = "pymdr result 1"
_PREFIX = "pymdr_path_"
_ERROR = "pymdr_error_"
_LONG = 100
"""Rows above which a history is kept as an array."""


def write_whole(file: str | os.PathLike[str], write: Callable[[FilePath], object]) -> None:
    """
    Write a file beside its place and rename it, so that it is whole or not there.

    Parameters
    ----------
    file : path
    write : callable
        Writes to the path it is given.

    Raises
    ------
    FileError
        If the folder cannot be written.
    """
    target = FilePath(file)
    try:
        handle, name = tempfile.mkstemp(dir=target.parent, prefix=f".{target.stem}-", suffix=target.suffix)
        os.close(handle)
    except OSError as error:
        raise FileError(
            f"cannot write {target}: {error.strerror or error}; choose a folder that is writable"
        ) from error
    beside = FilePath(name)
    try:
        write(beside)
        beside.chmod(0o666 & ~_umask())
        beside.replace(target)
    except OSError as error:
        raise FileError(f"cannot write {target}: {error.strerror or error}") from error
    finally:
        with contextlib.suppress(OSError):
            beside.unlink(missing_ok=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def pack(
    data: xr.Dataset,
    *,
    contact: Contact,
    path: LoadingPath,
    claims: Mapping[str, Claim],
    assumptions: Sequence[Assumption],
    status: str,
    notes: Sequence[str],
    references: Sequence[str],
    rings: int | None,
    machine_stiffness: float | None,
    starts: Sequence[Mapping[str, float]] | None,
) -> xr.Dataset:
    """Arrays plus everything else as JSON texts in the attributes; long histories and errors stay arrays."""
    short, arrays = _apart(path)
    errors, kept = _errors_apart(claims)
    plain_claims = {
        name: {
            "level": claim.level.name,
            "reason": claim.reason,
            "source": claim.source,
            "where": _runs(claim.where),
            **({"error": errors[name]} if name in errors else {}),
        }
        for name, claim in claims.items()
    }
    plain_assumptions = [
        {"name": a.name, "words": a.words, "measure": a.measure, "limit": a.limit} for a in assumptions
    ]
    return data.assign(arrays | kept).assign_attrs(
        pymdr_format=FORMAT,
        pymdr_case=json.dumps(encode_case("", contact, short)),
        pymdr_claims=json.dumps(plain_claims),
        pymdr_assumptions=json.dumps(plain_assumptions),
        pymdr_status=status,
        pymdr_notes=json.dumps(list(notes)),
        pymdr_references=json.dumps(list(references)),
        pymdr_rings=json.dumps(rings),
        pymdr_machine_stiffness=json.dumps(machine_stiffness),
        pymdr_starts=json.dumps(None if starts is None else [dict(start) for start in starts]),
    )


def _apart(path: LoadingPath) -> tuple[LoadingPath, dict[str, Any]]:
    """The path with its long histories replaced by stand-ins of one row, and these as variables."""
    pieces: list[Leg] = []
    arrays: dict[str, Any] = {}
    for i, leg in enumerate(legs(path)):
        if isinstance(leg, Path) and leg.steps > _LONG:
            named = [name for name in ("time", *CHANNELS) if getattr(leg, name) is not None]
            arrays |= {
                f"{_PREFIX}{i}_{name}": (f"{_PREFIX}{i}", np.asarray(getattr(leg, name))) for name in named
            }
            leg = Path(**{name: [0.0] for name in named})
        pieces.append(leg)
    return (pieces[0] if len(pieces) == 1 else History(tuple(pieces))), arrays


def _together(path: LoadingPath, dataset: xr.Dataset) -> LoadingPath:
    """The inverse of :func:`_apart`."""
    pieces = []
    for i, leg in enumerate(legs(path)):
        start = f"{_PREFIX}{i}_"
        found = {str(n)[len(start) :]: dataset[n].values for n in dataset if str(n).startswith(start)}
        pieces.append(Path(**found) if found else leg)
    return pieces[0] if len(pieces) == 1 else History(tuple(pieces))


def _errors_apart(claims: Mapping[str, Claim]) -> tuple[dict[str, float | str], dict[str, Any]]:
    """For every quantity its one error, or the name of the variable that holds its errors; these variables."""
    named: dict[str, float | str] = {}
    seen: dict[bytes, str] = {}
    for name, claim in claims.items():
        if claim.error is None:
            continue
        error = np.ascontiguousarray(claim.error, dtype=float)
        if error.size and np.all(error == error[0]):
            named[name] = float(error[0])
        else:
            named[name] = seen.setdefault(error.tobytes(), name)
    holders = {name: np.asarray(claims[name].error, dtype=float) for name in seen.values()}
    return named, {f"{_ERROR}{name}": ("step", error) for name, error in holders.items()}


def _error_from(plain: float | str | None, steps: int, dataset: xr.Dataset) -> np.ndarray | None:
    """The errors of a claim; None in files of versions that did not measure them."""
    if plain is None:
        return None
    return np.full(steps, plain) if isinstance(plain, float) else np.array(dataset[f"{_ERROR}{plain}"].values)


def _claim_from(plain: Mapping[str, Any], dataset: xr.Dataset) -> Claim:
    where = _from_runs(plain["where"])
    error = _error_from(plain.get("error"), where.size, dataset)
    return Claim(Level[plain["level"]], plain["reason"], plain["source"], where, error)


def _runs(where: np.ndarray) -> list[int]:
    """Lengths of runs, beginning with a run of True (which may be empty)."""
    changes = np.flatnonzero(np.diff(where.astype(int))) + 1
    lengths = np.diff([0, *changes.tolist(), where.size]).tolist()
    return lengths if where.size == 0 or where[0] else [0, *lengths]


def _from_runs(lengths: Sequence[int]) -> np.ndarray:
    flags = np.arange(len(lengths)) % 2 == 0
    return np.repeat(flags, lengths)


def unpack(dataset: xr.Dataset) -> dict[str, Any]:
    """The inverse of :func:`pack`."""
    attrs = dataset.attrs
    if attrs.get("pymdr_format") != FORMAT:
        raise FileError(
            f"not a pymdr result: its format is {attrs.get('pymdr_format')!r}, {FORMAT!r} is needed; "
            "write it with Result.save"
        )
    try:
        _, contact, path = decode_case(json.loads(attrs["pymdr_case"]))
        path = _together(path, dataset)
        claims = {name: _claim_from(c, dataset) for name, c in json.loads(attrs["pymdr_claims"]).items()}
        dataset = dataset.drop_vars([name for name in dataset if str(name).startswith((_PREFIX, _ERROR))])
        references = tuple(json.loads(attrs["pymdr_references"]))
        parts = {
            "contact": contact,
            "path": path,
            "data": dataset.drop_attrs(deep=False),
            "claims": claims,
            "assumptions": tuple(Assumption(**a) for a in json.loads(attrs["pymdr_assumptions"])),
            "status": attrs["pymdr_status"],
            "notes": tuple(json.loads(attrs["pymdr_notes"])),
            "references": references,
            "rings": json.loads(attrs["pymdr_rings"]),
            "starts": _starts(json.loads(attrs["pymdr_starts"])),
            "machine_stiffness": json.loads(attrs["pymdr_machine_stiffness"]),
        }
    except (KeyError, ValueError, TypeError, AttributeError, PymdrError) as error:
        raise FileError(f"damaged pymdr result: {error}") from error
    _check_whole(dataset, claims, references)
    return parts


def _starts(plain: list[dict[str, float]] | None) -> tuple[dict[str, float], ...] | None:
    return None if plain is None else tuple(plain)


def _check_whole(dataset: xr.Dataset, claims: Mapping[str, Claim], references: Sequence[str]) -> None:
    """Refuse a result whose arrays, claims and references do not belong together."""
    unknown = [key for key in references if key not in SOURCES]
    missing = [
        name
        for name, claim in claims.items()
        if name in QUANTITIES
        and QUANTITIES[name].dims == ("step",)
        and claim.readable
        and name not in dataset
    ]
    unclaimed = [str(name) for name in dataset if name != "time" and _base(str(name)) not in claims]
    steps = dataset.sizes.get("step", 0)
    short = [
        name
        for name, claim in claims.items()
        if claim.where.size != steps or (claim.error is not None and claim.error.shape != (steps,))
    ]
    for what, names in (
        ("unknown references", unknown),
        ("no values of", missing),
        ("no claims of", unclaimed),
        ("another number of steps in the claims of", short),
    ):
        if names:
            raise FileError(f"damaged pymdr result: {what} {', '.join(map(str, names))}")


def _base(name: str) -> str:
    base, _, end = name.rpartition("_")
    return base if end in BAND_ENDS and name not in QUANTITIES else name


def write_dataset(dataset: xr.Dataset, file: str | os.PathLike[str]) -> None:
    """Write a packed dataset as NetCDF."""
    small = {str(name): {"zlib": True} for name in dataset if str(name).startswith(_ERROR)}
    write_whole(file, lambda beside: dataset.to_netcdf(beside, engine="h5netcdf", encoding=small))


def read_dataset(file: str | os.PathLike[str]) -> xr.Dataset:
    """Read a packed dataset."""
    import xarray as xr

    source = FilePath(file)
    if not source.is_file():
        raise FileError(f"cannot read {source}: no such file")
    try:
        return xr.load_dataset(source, engine="h5netcdf")
    except (OSError, ValueError, KeyError, RuntimeError) as error:
        raise FileError(f"cannot read {source}: not a whole NetCDF file ({error})") from error
