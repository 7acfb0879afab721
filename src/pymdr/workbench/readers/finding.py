"""Formats of files: those of the package, and those that other packages offer by entry points."""

from __future__ import annotations

import io
import stat
import zipfile
import zlib
from collections.abc import Iterator
from dataclasses import replace
from importlib.metadata import entry_points
from pathlib import Path
from tempfile import TemporaryDirectory

from pymdr.errors import CaseError, FileError, ProblemError, PymdrError
from pymdr.units import FloatArray
from pymdr.workbench.inputs import read_bytes
from pymdr.workbench.readers import afm, bruker, nanosurf, optics11
from pymdr.workbench.readers.record import Calibration, ForceFormat, ForceRecord
from pymdr.workbench.spreadsheets import SPREADSHEETS
from pymdr.workbench.tables import read_force_columns

GROUP = "pymdr.readers"
"""Of the entry points by which packages offer a :class:`ForceFormat`."""
TEXT = (".csv", ".tab", ".txt", ".tsv", ".dat")
"""A table with units, or one of a maker."""
_HEAD = 2**16
_BROKEN_ARCHIVE = (zipfile.BadZipFile, zlib.error, OSError, RuntimeError, EOFError, ValueError)
"""Errors of archives: bytes that are no archive or do not decompress, passwords, methods of compression and names."""
_LARGEST_ZIP, _MOST_MEMBERS = 500 * 2**20, 10_000
_POSITIONS = ("indentation", "travel", "height")
_TABLE = "a table with units"


def _bruker(path: Path) -> bool:
    return head_of(path).startswith(bruker.MAGIC)


BUILT_IN = (
    ForceFormat("Optics11", (".txt",), optics11.read, lambda path: optics11.is_one(head_of(path))),
    ForceFormat("Bruker NanoScope", (".spm", ".pfc", ".000"), bruker.read, _bruker),
    ForceFormat("Nanosurf", nanosurf.SUFFIXES, nanosurf.read),
)


def suffixes() -> tuple[str, ...]:
    """Known suffixes, including those of registered formats."""
    own = [suffix for one in (*BUILT_IN, *registered()) for suffix in one.suffixes]
    return tuple(dict.fromkeys((*TEXT, *SPREADSHEETS, *afm.SUFFIXES, *own)))


def registered() -> tuple[ForceFormat, ...]:
    """The formats of other packages."""
    formats = []
    for point in entry_points(group=GROUP):
        try:
            loaded = point.load()
        except Exception as error:
            raise ProblemError(
                f"the reader {point.name!r} of the group {GROUP} ({point.value}) cannot be loaded: {type(error).__name__}: {error}; repair or uninstall "
                "its package"
            ) from error
        if not isinstance(loaded, ForceFormat):
            raise ProblemError(
                f"the reader {point.name!r} of the group {GROUP} ({point.value}) is {type(loaded).__name__}; it must be a ForceFormat"
            )
        formats.append(loaded)
    return tuple(formats)


def format_of(source: Path) -> ForceFormat | None:
    """The built-in format of a file by its name and its first bytes; None if it has none."""
    suffix = source.suffix.lower()
    if _bruker(source):
        return BUILT_IN[1]
    for one in BUILT_IN:
        if suffix in one.suffixes and one.detect(source):
            return one
    return None


def _offered(source: Path) -> ForceFormat | None:
    """The format of another package for a file that no built-in one reads."""
    suffix = source.suffix.lower()
    return next((one for one in registered() if suffix in one.suffixes and one.detect(source)), None)


def records_of(
    source: Path, calibration: Calibration, leave_out_missing: bool
) -> tuple[list[ForceRecord], bool]:
    """The records of a file, and whether it is a table of a user, whose signs are not known."""
    suffix = source.suffix.lower()
    check_file(source)
    known = format_of(source)
    if known is not None:
        return _read(source, known, calibration), False
    if suffix == ".zip" and not _is_workshop(source):
        return _unpacked(source, calibration, leave_out_missing)
    if suffix in afm.SUFFIXES:
        return list(afm.read(source, calibration)), False
    if suffix in TEXT and afm.is_known_text(source, head_of(source)):
        return list(afm.read(source, calibration)), False
    if head_of(source).startswith(bruker.IMAGE_MAGIC):
        raise ProblemError(
            f"{source}: the file of Bruker NanoScope holds images, not force curves; read heights with read_topography"
        )
    if suffix not in (*TEXT, *SPREADSHEETS):
        offered = _offered(source)
        if offered is None:
            raise _unknown(source)
        return _read(source, offered, calibration), False
    try:
        columns = read_force_columns(source, missing=leave_out_missing)
    except CaseError:
        if suffix == ".tab":  # tables of afmformats have their header in a comment
            return list(afm.read(source, calibration)), False
        offered = _offered(source)
        if offered is None:
            raise
        return _read(source, offered, calibration), False
    return [_table(source, columns)], True


def is_user_table(source: Path) -> bool:
    """Whether a file is a table of a user by its name and its first bytes."""
    suffix = source.suffix.lower()
    if suffix not in (*TEXT, *SPREADSHEETS) or suffix == ".tab":
        return False
    return format_of(source) is None and not afm.is_known_text(source, head_of(source))


def check_file(source: Path) -> None:
    """Refuse files that are empty or not regular."""
    try:
        state = source.stat()
    except (OSError, ValueError) as error:
        words = getattr(error, "strerror", None) or error
        raise FileError(f"cannot read {source}: {words}") from error
    if not stat.S_ISREG(state.st_mode):
        raise FileError(
            f"cannot read {source}: force curves are in a regular file, not a folder, pipe or device"
        )
    if state.st_size == 0:
        raise CaseError(f"{source}: the file is empty; copy it again from the instrument")


def head_of(source: Path) -> bytes:
    """The first bytes of a regular file; none where there is no such file."""
    try:
        if not source.is_file():
            return b""
        with source.open("rb") as opened:
            return opened.read(_HEAD)
    except (OSError, ValueError):
        return b""


def _unknown(source: Path) -> FileError:
    makers = [one.name for one in BUILT_IN if source.suffix.lower() in one.suffixes]
    if makers:
        return FileError(
            f"cannot read {source}: not a file of {makers[0]}, as its suffix suggests, or its beginning is damaged; copy it again from the instrument"
        )
    known = ", ".join(suffixes())
    return FileError(
        f"cannot read {source}: no format of force curves ends in {source.suffix.lower()!r}; those that do: {known}"
    )


def _read(source: Path, one: ForceFormat, calibration: Calibration) -> list[ForceRecord]:
    """The records by a reader, whose errors that are not of pymdr are those of a damaged file."""
    try:
        records = list(one.read(source, calibration))
    except PymdrError:
        raise
    except Exception as error:
        raise FileError(
            f"cannot read {source}: a file of {one.name}, according to its suffix, but it is damaged or cut off ({type(error).__name__}: "
            f"{str(error)[:200]}); copy it again from the instrument, or export it as a table with units in its header"
        ) from error
    if not records:
        raise CaseError(f"{source}: a file of {one.name} without a force curve; export the record again")
    return records


def _table(source: Path, columns: dict[str, FloatArray]) -> ForceRecord:
    named = dict(columns)
    if "normal_force" in named:
        named["force"] = named.pop("normal_force")
    positions = [name for name in _POSITIONS if name in named]
    if len(positions) != 1:
        given = " and ".join(positions) or "none"
        raise ProblemError(
            f"{source}: {_TABLE}; give exactly one of indentation, travel and height (in the file: {given})"
        )
    return ForceRecord(_TABLE, named, metadata={"record": 0.0})


def _is_workshop(source: Path) -> bool:
    """Whether an archive has curves of AFM workshop, which afmformats reads as a map."""
    try:
        with zipfile.ZipFile(source) as archive:
            names = [name for name in archive.namelist() if not name.endswith("/")]
            if not names:
                return False
            with archive.open(names[0]) as first:
                return b"Force-Distance Curve" in first.read(4096)
    except _BROKEN_ARCHIVE as error:
        raise _damaged_archive(source, error) from error


def _unpacked(
    source: Path, calibration: Calibration, leave_out_missing: bool
) -> tuple[list[ForceRecord], bool]:
    """The records of all files in an archive, in the order of their names."""
    content = read_bytes(source, _LARGEST_ZIP, "archive")
    records: list[ForceRecord] = []
    tables = False
    with zipfile.ZipFile(io.BytesIO(content)) as archive, TemporaryDirectory() as folder:
        for member in _members(source, archive):
            place = Path(folder) / Path(member.filename).name
            try:
                place.write_bytes(archive.read(member))
            except _BROKEN_ARCHIVE as error:
                raise _damaged_archive(source, error) from error
            try:
                inside, table = records_of(place, calibration, leave_out_missing)
            except PymdrError as error:
                error.args = (str(error).replace(str(place), f"{source}, {member.filename}"),)
                raise
            finally:
                place.unlink()
            tables = tables or table
            for record in inside:
                facts = {**record.metadata, "member": member.filename, "record": float(len(records))}
                records.append(replace(record, metadata=facts))
    if not records:
        raise CaseError(f"{source}: an archive without files; pack the files of the instrument")
    return records, tables


def _damaged_archive(source: Path, error: Exception) -> FileError:
    return FileError(
        f"cannot read {source}: an archive that is damaged, cut off or encrypted ({type(error).__name__}: {str(error)[:200]}); copy it again, or "
        "unpack it"
    )


def _members(source: Path, archive: zipfile.ZipFile) -> Iterator[zipfile.ZipInfo]:
    members = [one for one in archive.infolist() if not one.is_dir()]
    inner = next((one.filename for one in members if one.filename.lower().endswith(".zip")), None)
    if inner is not None:
        raise CaseError(f"{source}: the archive contains another archive, {inner!r}; unpack it")
    size = sum(one.file_size for one in members)
    if len(members) > _MOST_MEMBERS or size > _LARGEST_ZIP:
        raise CaseError(
            f"{source}: an archive of {len(members)} files and {size} bytes unpacked (limits {_MOST_MEMBERS} and {_LARGEST_ZIP}); unpack it"
        )
    yield from sorted(members, key=lambda one: one.filename)
