"""Files of microscopes that afmformats reads."""

from __future__ import annotations

import logging
import re
import warnings
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pymdr.errors import CaseError, FileError, MissingExtraError, ProblemError
from pymdr.units import FloatArray
from pymdr.workbench.inputs import read_measured_text
from pymdr.workbench.readers.record import Calibration, ForceRecord, check_slope
from pymdr.workbench.tables import refuse_cut_number

SUFFIXES = (".h5", ".ibw", ".jpk-force", ".jpk-force-map", ".jpk-qi-data", ".jpk-qi-series", ".zip")
"""What only afmformats reads."""
_TEXTS, _NUMBERS, _LARGEST = (".csv", ".txt"), "+-0123456789", 500 * 2**20
_DECIMALS = re.compile(r"[.,][0-9]+$", re.ASCII)
_HEIGHTS = ("height (measured)", "height (piezo)")
_WORKSHOP, _CHIARO = b"Force-Distance Curve", b"Chiaro"
_IN_VOLTS = ("sensitivity", "spring constant")
_REMEDIES = {
    "sensitivity": "sensitivity, such as '50 nm/V'",
    "spring constant": "spring_constant, such as '0.1 N/m'",
}


def read(source: Path, calibration: Calibration) -> list[ForceRecord]:
    """The records of a file by afmformats."""
    afmformats = _afmformats(source)
    from afmformats.meta import MetaDataMissingError

    broken = (Exception, afmformats.errors.AFMFileFormatError, MetaDataMissingError)
    maker = maker_of(source)
    if source.suffix.lower() in _TEXTS:
        lines = read_measured_text(source, _LARGEST, "force curve").split("\n")
        rows = [line.rstrip("\r") for line in lines if line[:1] in _NUMBERS]
        refuse_cut_number(source, rows or [""], _DECIMALS)
        if "NT-MDT" in maker:
            _refuse_cut_ramp(source, [line.split("#")[0] for line in lines])
    check_slope(str(source), maker, calibration, "m/A" if "NT-MDT" in maker else "m/V")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            loaded = _loaded(afmformats, source, calibration)
            records = [_record(one, maker) for one in loaded]
    except afmformats.errors.MissingMetaDataError as error:
        keys = [key for key in _IN_VOLTS if key in error.meta_keys] or list(error.meta_keys)
        remedies = " and ".join(_REMEDIES.get(key, key) for key in keys)
        if "NT-MDT" in maker:
            remedies = remedies.replace("nm/V", "nm/nA")
        raise ProblemError(
            f"{source}: {maker}. The file has no {' and '.join(keys)}; give {remedies}"
        ) from error
    except broken as error:
        raise FileError(
            f"cannot read {source}: {maker}, according to its suffix, but afmformats has no such format, or the file is damaged or cut off "
            f"({type(error).__name__}: {str(error)[:200]}); copy it again from the instrument, or export it as a table with units in its header"
        ) from error
    if not records:
        raise CaseError(f"{source}: {maker}. There is no force curve in it; export the record again")
    return records


def maker_of(source: Path) -> str:
    """What afmformats takes a file for, in words."""
    afmformats = _afmformats(source)
    try:
        recipe = afmformats.formats.get_recipe(source)
    except (Exception, afmformats.errors.AFMFileFormatError):  # any error of a recipe: it is not known
        return "a file of a microscope"
    return f"{recipe.maker}, {recipe.descr}"


def is_known_text(source: Path, head: bytes) -> bool:
    """Whether a text is one of a maker: AFM workshop, Optics11, or the bare columns of NT-MDT."""
    if _WORKSHOP in head or (_CHIARO in head and source.suffix.lower() == ".txt"):
        return True
    return source.suffix.lower() == ".txt" and is_bare_table(head)


def is_bare_table(head: bytes) -> bool:
    """Whether a text begins with three columns of numbers without a header, as NT-MDT Nova exports them."""
    lines = [line for line in head.decode("latin-1").splitlines()[:6] if line.strip()]
    if len(lines) < 3:
        return False
    try:
        return all(len([float(cell.replace(",", ".")) for cell in line.split()]) == 3 for line in lines[:-1])
    except ValueError:
        return False


def _refuse_cut_ramp(source: Path, lines: Sequence[str]) -> None:
    """Refuse an export of NT-MDT Nova whose heights end before 0: the text states no number of rows, but the ramp ends at height 0."""
    try:
        height = np.array([float(row.split(maxsplit=1)[0].replace(",", ".")) for row in lines if row.strip()])
    except ValueError:  # no numbers: afmformats refuses the file
        return
    if height.size < 2 or not np.isfinite(height).all():  # what has gaps is refused where it is read
        return
    step = float(np.median(np.abs(np.diff(height))))
    if step == 0.0 or abs(height[-1]) <= 0.5 * step:
        return
    count = round(abs(height[-1]) / step) if abs(height[-1]) < abs(height[0]) else 0
    missing = f"{count} further row{'s' if count > 1 else ''}" if count else "further rows"
    raise CaseError(
        f"{source}: exported by NT-MDT Nova. Its heights end at {height[-1]:.6g} nm in steps of {step:.4g} nm, but its ramps end at 0 nm. The file is cut off "
        f"({missing} missing): copy it again from the instrument. If the record is complete, write approach and retraction as a table with units in its header"
    )


def _afmformats(source: Path) -> Any:
    try:
        import afmformats
        import afmformats.errors
    except ImportError as error:
        raise MissingExtraError(
            f"{source.name} needs afmformats, which cannot be imported ({error}): pip install 'pymdr[afm]'; tables with units in their header "
            "(.csv, .tsv) are read without it"
        ) from error
    for name in ("afmformats", "igor2"):  # pymdr's errors name what cannot be read
        logger = logging.getLogger(name)
        if not logger.handlers:
            logger.addHandler(logging.NullHandler())
    return afmformats


def _loaded(afmformats: Any, source: Path, calibration: Calibration) -> Iterable[Any]:
    """The records; constants that the file lacks are those of the user."""
    try:
        return afmformats.load_data(source)  # type: ignore[no-any-return]
    except afmformats.errors.MissingMetaDataError as error:
        given = {"spring constant": calibration.spring_constant, "sensitivity": calibration.sensitivity}
        lacks = [key for key in _IN_VOLTS if key in error.meta_keys]
        override = {key: value for key in lacks if (value := given[key]) is not None}
        if len(override) < len(lacks) or not lacks:
            raise
        return afmformats.load_data(source, meta_override=override)  # type: ignore[no-any-return]


def _record(record: Any, maker: str) -> ForceRecord:
    columns = {name: np.asarray(record[name], dtype=float) for name in record.columns}
    metadata = record.metadata
    facts: dict[str, str | float] = {}
    for name in sorted(metadata):
        value = metadata[name]
        if name != "path":
            facts[name] = float(value) if isinstance(value, int | float | np.number) else str(value)
    facts["record"] = float(facts.pop("enum", 0.0))
    used: dict[str, FloatArray] = {key: columns[key] for key in ("force", "time") if key in columns}
    heights = (
        _HEIGHTS[::-1] if _CHIARO.decode() in maker else _HEIGHTS
    )  # its measured height is an indentation
    name = next((name for name in heights if name in columns), None)
    if name is not None:
        used["height"] = columns[name]
        facts["height"] = name
    elif "tip position" in columns:
        used["indentation"] = -columns["tip position"]
    numbers = columns.get("segment")
    if numbers is not None and np.ptp(numbers) > 0.0:  # a constant index does not divide the record
        used["segment"] = numbers
    constants = {key: facts.pop(key, None) for key in _IN_VOLTS}
    own = {key: float(value) for key, value in constants.items() if value is not None}
    return ForceRecord(maker, used, own.get("spring constant"), own.get("sensitivity"), facts)
