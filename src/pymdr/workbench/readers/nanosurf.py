"""Force spectroscopy of Nanosurf (.nid), by NSFopen."""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from pymdr.errors import MissingExtraError, ProblemError
from pymdr.units import FloatArray
from pymdr.workbench.readers.record import Calibration, ForceRecord

SUFFIXES = (".nid",)
_MAKER = "a file of Nanosurf"
_Z = ("Z-Axis Sensor", "Z-Axis")
_FORCES = {"N": "force", "m": "deflection", "V": "signal"}


def read(source: Path, calibration: Calibration) -> list[ForceRecord]:
    """The records of all points of a spectroscopy; position and deflection rise toward the body."""
    try:
        from NSFopen.read import read as load
    except ImportError as error:
        raise MissingExtraError(
            f"{source.name} is {_MAKER}, which needs NSFopen ({error}): pip install 'pymdr[nanosurf]'; or export it as a table with units in "
            "its header"
        ) from error
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        opened = load(str(source))
    data, facts = opened.data, opened.param
    if "Spec" not in data:
        raise ProblemError(f"{source}: {_MAKER}, with images only; it has no force spectroscopy")
    spectra = data["Spec"]
    channels = {(str(direction), str(name)): spectra[direction][name] for direction, name in spectra.index}
    z = next((name for name in _Z if ("Forward", name) in channels), None)
    if z is None or ("Forward", "Deflection") not in channels:
        names = ", ".join(sorted({name for _, name in channels}))
        raise ProblemError(
            f"{source}: {_MAKER}, without the channels Deflection and Z-Axis Sensor (it has {names}); export these channels too"
        )
    kind = _FORCES.get(_unit(facts, "Deflection"))
    if kind is None:
        raise ProblemError(
            f"{source}: {_MAKER}, whose deflection is in {_unit(facts, 'Deflection')!r}; N, m or V is needed"
        )
    constant = _spring_constant(facts)
    directions = [
        direction
        for direction in ("Forward", "Backward")
        if (direction, z) in channels and (direction, "Deflection") in channels
    ]
    records = []
    for k in range(len(channels["Forward", z])):
        place = [np.asarray(channels[direction, z][k], dtype=float) for direction in directions]
        signal = [np.asarray(channels[direction, "Deflection"][k], dtype=float) for direction in directions]
        if len(place) == 2 and abs(place[1][-1] - place[0][-1]) < abs(place[1][0] - place[0][-1]):
            place[1], signal[1] = place[1][::-1], signal[1][::-1]  # stored along the position, not the time
        columns: dict[str, FloatArray] = {kind: np.concatenate(signal), "travel": np.concatenate(place)}
        columns["segment"] = np.repeat(np.arange(len(place), dtype=float), [one.size for one in place])
        time = _times(facts, [one.size for one in place])
        if time is not None:
            columns["time"] = time
        records.append(ForceRecord(_MAKER, columns, constant, None, {"record": float(k)}))
    return records


def _unit(facts: Any, channel: str) -> str:
    """The unit of a channel, as the dump of the header names it."""
    for key in facts.keys():  # noqa: SIM118  - a pandas series
        if key[0] == "HeaderDump" and re.fullmatch(r"DataSet-0:\d+", str(key[1])):
            dump = facts[key]
            if dump.get("Dim2Name") == channel:
                return str(dump.get("Dim2Unit"))
    return ""


def _spring_constant(facts: Any) -> float | None:
    for key in facts.keys():  # noqa: SIM118
        if key == ("Tip", "Prop0"):
            value = facts[key]
            return float(value["Value"]) if value["Unit"] == "N/m" else None
    return None


def _times(facts: Any, sizes: list[int]) -> FloatArray | None:
    """Times of the samples of both ways, if the file has their durations."""
    parts, start = [], 0.0
    for name, size in zip(("modFw", "modBw"), sizes, strict=False):
        if ("Spec", name) not in facts:
            return None
        duration = float(facts["Spec", name]["Value"])
        if not duration > 0.0:
            return None
        parts.append(start + duration / size * np.arange(size))
        start += duration
    return np.concatenate(parts)
