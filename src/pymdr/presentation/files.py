"""Results as NetCDF files: written atomically, validated when read."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import re
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from functools import lru_cache
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from pymdr.deferred import xr
from pymdr.errors import FileError, MissingExtraError, PymdrError
from pymdr.interpretation.validity import SOURCES, Assumption, Claim, Level
from pymdr.problem.codec import decode_case, encode_case, import_kinds
from pymdr.problem.contact import Contact
from pymdr.problem.paths import CHANNELS, History, Leg, LoadingPath, Path, legs
from pymdr.quantities import BAND_ENDS, QUANTITIES
from pymdr.units import shown

if TYPE_CHECKING:
    from pydantic import TypeAdapter
    from xarray.backends import H5NetCDFStore

FORMAT = "pymdr result 2"
_PREFIX = "pymdr_path_"
_ERROR = "pymdr_error_"
_CHECKSUM = "pymdr_checksum"
_LONG = 100
"""Rows above which a path is saved as an array."""
_URL = re.compile(r"[a-z][a-z0-9+.-]+:(:[a-z0-9+.-]+:)*/", re.IGNORECASE)
"""The beginning of a URL, of whose two slashes a Path keeps one; a drive of Windows has one letter."""


def named_file(file: object, verb: str) -> FilePath:
    """
    The path of a file named by the user.

    Raises
    ------
    FileError
        If it is not the name of a file on this machine; `verb`, such as "read", appears in the message.

    Examples
    --------
    >>> named_file(None, "read")
    Traceback (most recent call last):
        ...
    pymdr.errors.FileError: cannot read None: give the name of a file as text or pathlib.Path
    """
    name = os.fspath(file) if isinstance(file, os.PathLike) else file
    if not isinstance(name, str) or not name:
        raise FileError(f"cannot {verb} {shown(file)}: give the name of a file as text or pathlib.Path")
    if _URL.match(name):
        raise FileError(
            f"cannot {verb} {name}: only fit_map reads a URL, of a store and as text; give a file or folder of this "
            "machine"
        )
    return FilePath(name)


def write_atomically(file: str | os.PathLike[str], write: Callable[[FilePath], object]) -> None:
    """
    Write a temporary file in the same folder and rename it, so that no file is left half written.

    Raises
    ------
    FileError
        If the file cannot be written.
    """
    target = named_file(file, "write")
    if "\0" in str(target):
        raise FileError(f"cannot write {str(target)!r}: the name contains the character NUL; remove it")
    try:
        handle, name = tempfile.mkstemp(dir=target.parent, prefix=f".{target.stem}-", suffix=target.suffix)
        os.close(handle)
    except OSError as error:
        raise FileError(
            f"cannot write {target}: {error.strerror or error}; choose a writable folder"
        ) from error
    temporary = FilePath(name)
    try:
        write(temporary)
        temporary.chmod(0o666 & ~_umask())
        temporary.replace(target)
    except OSError as error:
        raise FileError(f"cannot write {target}: {error.strerror or error}") from error
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def pack(
    data: xr.Dataset,
    contact: Contact,
    path: LoadingPath,
    claims: Mapping[str, Claim],
    assumptions: Sequence[Assumption],
    *,
    status: str,
    **others: Any,
) -> xr.Dataset:
    """The arrays, with everything else as JSON in the attributes; long paths and errors become arrays too.

    `others` are saved as JSON: notes, references, rings, machine_stiffness and starts.
    """
    short, arrays = _split_path(path)
    errors, error_arrays = _split_errors(claims)
    plain_claims = {
        name: {
            "level": claim.level.name,
            "reason": claim.reason,
            "source": claim.source,
            "where": _runs(claim.where),
            **({"error": errors[name]} if name in errors else {}),
            **({"excluded": claim.excluded} if claim.excluded else {}),
        }
        for name, claim in claims.items()
    }
    return data.assign(arrays | error_arrays).assign_attrs(
        pymdr_format=FORMAT,
        pymdr_case=json.dumps(encode_case("", contact, short)),
        pymdr_claims=json.dumps(plain_claims),
        pymdr_assumptions=json.dumps([asdict(a) for a in assumptions]),
        pymdr_status=status,
        **{f"pymdr_{name}": json.dumps(value) for name, value in others.items()},
    )


def study_json(claims: Mapping[str, Claim], assumptions: Sequence[Assumption], notes: Sequence[str]) -> str:
    """Claims, assumptions and notes of a study as JSON."""
    return json.dumps(
        {
            "claims": {
                name: {
                    "level": claim.level.name,
                    "reason": claim.reason,
                    "source": claim.source,
                    "where": claim.where.tolist(),
                    "error": None if claim.error is None else np.asarray(claim.error).tolist(),
                    **({"excluded": claim.excluded} if claim.excluded else {}),
                }
                for name, claim in claims.items()
            },
            "assumptions": [asdict(a) for a in assumptions],
            "notes": list(notes),
        }
    )


def _split_path(path: LoadingPath) -> tuple[LoadingPath, dict[str, Any]]:
    """The path with each long leg replaced by two rows, and the arrays of these legs."""
    short: list[Leg] = []
    arrays: dict[str, Any] = {}
    for i, leg in enumerate(legs(path)):
        if isinstance(leg, Path) and leg.steps > _LONG:
            named = [name for name in ("time", *CHANNELS) if getattr(leg, name) is not None]
            columns = {name: np.asarray(getattr(leg, name)) for name in named}
            arrays |= {
                f"{_PREFIX}{i}_{name}": ((f"{_PREFIX}{i}", "axis")[: values.ndim], values)
                for name, values in columns.items()
            }
            # two rows of the same shape stand for the array
            rows = {name: np.multiply.outer([0.0, 1.0], np.ones(v.shape[1:])) for name, v in columns.items()}
            leg = Path(**rows, relative_time=leg.relative_time)
        short.append(leg)
    return (short[0] if len(short) == 1 else History(tuple(short))), arrays


def _restored_path(path: LoadingPath, dataset: xr.Dataset) -> LoadingPath:
    """The inverse of :func:`_split_path`."""
    restored: list[Leg] = []
    for i, leg in enumerate(legs(path)):
        start = f"{_PREFIX}{i}_"
        channels = {str(n)[len(start) :]: dataset[n].values for n in dataset if str(n).startswith(start)}
        restored.append(replace(leg, **channels) if channels else leg)
    return restored[0] if len(restored) == 1 else History(tuple(restored))


def _split_errors(claims: Mapping[str, Claim]) -> tuple[dict[str, float | str], dict[str, Any]]:
    """The constant error of every quantity, or the name of the variable of its errors; these variables."""
    errors: dict[str, float | str] = {}
    variables: dict[bytes, str] = {}
    for name, claim in claims.items():
        if claim.error is None or (claim.level is Level.EXACT and not claim.error.any()):
            continue
        error = np.ascontiguousarray(claim.error, dtype=float)
        if error.size and np.all(error == error[0]):
            errors[name] = float(error[0])
        else:
            errors[name] = variables.setdefault(error.tobytes(), name)
    return errors, {
        f"{_ERROR}{name}": ("step", np.asarray(claims[name].error, dtype=float))
        for name in variables.values()
    }


def _error_from(plain: float | str | None, steps: int, dataset: xr.Dataset) -> np.ndarray | None:
    """The saved errors of a claim; None if its level implies them."""
    if plain is None:
        return None
    return np.full(steps, plain) if isinstance(plain, float) else np.array(dataset[f"{_ERROR}{plain}"].values)


def _damaged(fault: object) -> FileError:
    return FileError(f"damaged pymdr result: {fault}; use another copy, or solve again")


def _claim_from(name: str, plain: Mapping[str, Any], dataset: xr.Dataset) -> Claim:
    # checked before expansion: a damaged length may be astronomical
    if sum(plain["where"]) != dataset.sizes.get("step", 0):
        raise _damaged(f"wrong number of steps in the claims of {name}")
    where = np.repeat(np.arange(len(plain["where"])) % 2 == 0, plain["where"])
    error = _error_from(plain.get("error"), where.size, dataset)
    return Claim(Level[plain["level"]], plain["reason"], plain["source"], where, error, plain["excluded"])


def _runs(where: np.ndarray) -> list[int]:
    """Lengths of alternating runs of True and False, the first (possibly empty) of True."""
    changes = np.flatnonzero(np.diff(where.astype(int))) + 1
    lengths = np.diff([0, *changes.tolist(), where.size]).tolist()
    return lengths if where.size == 0 or where[0] else [0, *lengths]


def unpack(dataset: xr.Dataset) -> dict[str, Any]:
    """The inverse of :func:`pack`."""
    attrs = dataset.attrs
    if str(attrs.get("pymdr_format")).startswith("pymdr study"):
        raise FileError("a study of pymdr, not a result: read it with xarray.open_dataset")
    if attrs.get("pymdr_format") != FORMAT:
        raise FileError(
            f"not a pymdr result: its format is {attrs.get('pymdr_format')!r} instead of {FORMAT!r}; "
            "write it with Result.save"
        )
    try:
        case = json.loads(attrs["pymdr_case"])
        if unknown := import_kinds(case):
            raise FileError(
                f"cannot read the result: the kind {unknown[0]!r} is not registered; import the module that "
                "registers it with pymdr.problem.codec.register, or name its file: pymdr --plugin FILE.py"
            )
        _, contact, path = decode_case(case)
        path = _restored_path(path, dataset)
        texts = _parsed_texts(attrs)
        claims = {name: _claim_from(name, claim, dataset) for name, claim in texts["claims"].items()}
        dataset = dataset.drop_vars([name for name in dataset if str(name).startswith((_PREFIX, _ERROR))])
        parts = {
            "contact": contact,
            "path": path,
            "data": dataset.drop_attrs(deep=False),
            "claims": claims,
            "assumptions": tuple(Assumption(**a) for a in texts["assumptions"]),
            "status": attrs["pymdr_status"],
            "notes": tuple(texts["notes"]),
            "references": tuple(texts["references"]),
            "rings": texts["rings"],
            "starts": None if texts["starts"] is None else tuple(texts["starts"]),
            "machine_stiffness": texts["machine_stiffness"],
        }
    except FileError:
        raise
    except (LookupError, ValueError, TypeError, AttributeError, RecursionError, PymdrError) as error:
        raise _damaged(error) from error
    _check_consistent(dataset, claims, parts["references"])
    if contact.friction is not None and len(parts["starts"] or ()) != len(legs(path)):
        raise _damaged("the starts of some legs of the path are missing")
    return parts


@lru_cache(maxsize=1)
def _saved_texts() -> TypeAdapter[Any]:
    """The validator of the JSON texts in the attributes."""
    from pydantic import NonNegativeInt, TypeAdapter, create_model

    level: Any = Literal["EXACT", "APPROXIMATE", "NOT_VALID"]
    claim: Any = create_model(
        "claim",
        level=(level, ...),
        reason=(str, ...),
        source=(str, ...),
        where=(list[NonNegativeInt], ...),
        error=(float | str | None, None),
        excluded=(str, ""),
    )
    assumption: Any = create_model(
        "assumption", name=(str, ...), description=(str, ...), measure=(float, ...), limit=(float, ...)
    )
    return TypeAdapter(
        create_model(
            "texts",
            claims=(dict[str, claim], ...),
            assumptions=(list[assumption], ...),
            notes=(list[str], ...),
            references=(list[str], ...),
            rings=(int | None, ...),
            machine_stiffness=(float | None, ...),
            starts=(list[dict[str, float]] | None, ...),
        )
    )


def _parsed_texts(attrs: Mapping[str, Any]) -> dict[str, Any]:
    """The JSON texts of the attributes, validated."""
    from pydantic import ValidationError

    names = ("claims", "assumptions", "notes", "references", "rings", "machine_stiffness", "starts")
    try:
        parsed = _saved_texts().validate_python({name: json.loads(attrs[f"pymdr_{name}"]) for name in names})
    except ValidationError as error:
        where = ".".join(map(str, error.errors()[0]["loc"]))
        raise _damaged(f"pymdr_{where} is not what Result.save writes") from error
    texts: dict[str, Any] = parsed.model_dump()
    return texts


def _check_consistent(dataset: xr.Dataset, claims: Mapping[str, Claim], references: Sequence[str]) -> None:
    """Refuse a result whose arrays, claims and references are inconsistent."""
    foreign = [
        str(name)
        for name, array in dataset.items()
        if _base(str(name)) not in QUANTITIES
        or array.dims not in (("step",), ("step", "axis"))
        or array.dtype.kind not in "biuf"
    ]
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
    for fault, names in (
        ("no claims of", [] if "pressure" in claims else ["pressure"]),
        ("no numeric column over the steps in", foreign),
        ("unknown references", unknown),
        ("no values of", missing),
        ("no claims of", unclaimed),
        ("wrong number of steps in the claims of", short),
    ):
        if names:
            raise _damaged(f"{fault} {', '.join(map(str, names))}")


def _base(name: str) -> str:
    base, _, end = name.rpartition("_")
    return base if end in BAND_ENDS and name not in QUANTITIES else name


_SUFFIXES = (".nc", ".nc4", ".cdf", ".h5", ".hdf5")


def _store_class() -> type[H5NetCDFStore]:
    """The store of xarray, without its search for arrays of bytes, of which a result has none, and which imports dask.array."""
    from xarray.backends import H5NetCDFStore

    class Store(H5NetCDFStore):
        def encode_variable(self, variable: xr.Variable, name: Any = None) -> xr.Variable:
            return variable

    return Store


def _h5netcdf() -> Any:
    """The library of NetCDF files, which small systems may lack."""
    try:
        import h5netcdf
        import h5py  # noqa: F401
    except ImportError as error:
        raise MissingExtraError(
            f"NetCDF files need h5netcdf and h5py, which cannot be imported ({error}); install them, or write a table with "
            "Result.to_csv('ball.csv')"
        ) from error
    return h5netcdf


def write_dataset(dataset: xr.Dataset, file: str | os.PathLike[str]) -> None:
    """Write a packed dataset as NetCDF and append its checksum."""
    if named_file(file, "write").suffix.lower() not in _SUFFIXES:
        raise FileError(
            f"cannot write {str(file)!r}: results are saved as NetCDF with a name that ends with '.nc'; for a table use "
            "Result.to_csv('ball.csv')"
        )
    h5netcdf = _h5netcdf()
    small = {str(name): {"zlib": True} for name in dataset if str(name).startswith(_ERROR)}

    def write(temporary: FilePath) -> None:
        marked = dataset.assign_attrs(
            {_CHECKSUM: "SHA-256 of the file up to its last 77 bytes, which hold it"}
        )
        # not to_netcdf, which imports dask and its scheduler where they are installed
        with h5netcdf.File(temporary, "w") as netcdf:
            marked.dump_to_store(_store_class()(netcdf), encoding=small)
        seal = _SEAL + _checksum(temporary, temporary.stat().st_size).encode()
        with temporary.open("ab") as opened:
            opened.write(seal)

    write_atomically(file, write)


_SEAL = b"\npymdr sha256 "
_SEALED = len(_SEAL) + 64
"""Bytes appended to the NetCDF file; its readers ignore them."""


def _checksum(file: FilePath, size: int) -> str:
    """The SHA-256 of the first bytes of a file."""
    digest = hashlib.sha256()
    with file.open("rb") as opened:
        while size > 0 and (block := opened.read(min(size, 2**20))):
            digest.update(block)
            size -= len(block)
    return digest.hexdigest()


def _is_sealed(source: FilePath) -> bool:
    """Whether a file has a checksum; a file that contradicts its checksum is refused."""
    size = source.stat().st_size - _SEALED
    if size < 0:
        return False
    with source.open("rb") as opened:
        opened.seek(size)
        seal = opened.read(_SEALED)
    if not seal.startswith(_SEAL):
        return False
    if seal[len(_SEAL) :].decode("ascii", "replace") != _checksum(source, size):
        raise FileError(
            f"cannot read {source}: its checksum differs, so it changed since it was written; use another copy, or "
            "solve again"
        )
    return True


def read_dataset(file: str | os.PathLike[str]) -> xr.Dataset:
    """Read a packed dataset."""
    source = named_file(file, "read")
    try:
        exists, regular = source.exists(), source.is_file()
    except ValueError:
        exists = regular = False
    if not regular:
        reason = "it is a folder, pipe or device" if exists else "no such file"
        raise FileError(f"cannot read {str(source)!r}: {reason}")
    _h5netcdf()
    try:
        sealed = _is_sealed(source)
        dataset = xr.load_dataset(source, engine="h5netcdf")
        if not sealed and _CHECKSUM in dataset.attrs:
            raise FileError(
                f"cannot read {source}: its checksum is missing, so it was truncated or rewritten by another program; use "
                "the file written by Result.save"
            )
        return dataset
    except FileError:
        raise
    except (OSError, ValueError, LookupError, TypeError, AttributeError, RuntimeError) as error:
        raise FileError(
            f"cannot read {source}: not a complete NetCDF file ({error}); use another copy, or solve again"
        ) from error
