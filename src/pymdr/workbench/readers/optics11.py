"""Text files of Optics11 indenters (Chiaro, Piuma)."""

from __future__ import annotations

import re
from pathlib import Path

from pymdr.units import FloatArray
from pymdr.workbench.readers.record import Calibration, ForceRecord
from pymdr.workbench.tables import columns_of_lines, lines_of

_COLUMNS = b"Indentation (nm)\tCantilever (nm)\tPiezo (nm)"
_NAMES = {"time": ("time",), "normal_force": ("load",), "travel": ("piezo",)}
_FACTS = (
    ("spring constant", r"^k \(N/m\)\s+(\S+)", 1.0),
    ("tip radius", r"^Tip radius \([^)]*m\)\s+(\S+)", 1e-6),
    ("own effective modulus", r"^E\[eff\] \(Pa\)\s+(\S+)", 1.0),
)


def is_one(head: bytes) -> bool:
    """Whether a text has the columns of these instruments."""
    return _COLUMNS in head


def read(source: Path, calibration: Calibration) -> list[ForceRecord]:
    """
    The record of a file.

    Its own indentation is 0 before the contact that the instrument found, so the travel of the piezo is used and the deflection of the
    cantilever is the force over its spring constant.
    """
    lines = lines_of(source, _NAMES)
    columns: dict[str, FloatArray] = columns_of_lines(
        source, lines, _NAMES, ("normal_force", "travel"), "Time (s), Load (uN), Piezo (nm)"
    )
    columns["force"] = columns.pop("normal_force")
    text = "\n".join(lines[:80])
    facts: dict[str, str | float] = {"position": "Piezo"}
    for name, pattern, factor in _FACTS:
        match = re.search(pattern, text, re.MULTILINE)
        value = None if match is None else _number(match[1])
        if value is not None:
            facts[name] = value * factor
    constant = facts.pop("spring constant", None)
    return [
        ForceRecord(
            "a text of an Optics11 indenter",
            columns,
            None if constant is None else float(constant),
            None,
            facts,
        )
    ]


def _number(text: str) -> float | None:
    try:
        return float(text.replace(",", "."))
    except ValueError:
        return None
