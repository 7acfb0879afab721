"""A comparison as a row of the tables, and the reference values, tests/reference/refs.json, which states how each was computed."""

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import pymdr as mdr

ROOT = Path(__file__).resolve().parents[2]
REFERENCES = {
    entry["id"]: entry
    for entry in json.loads((ROOT / "tests" / "reference" / "refs.json").read_text(encoding="utf-8"))["refs"]
}
UNIT = mdr.Elastic(1.0, 0.0)
"""E* = 1 Pa on a rigid body."""
ROUNDING = 1e-14
"""Below it a difference or an error is called rounding."""


@dataclass(frozen=True)
class Row:
    """One comparison; errors are relative."""

    physics: str
    quantity: str
    source: str
    actual: float
    claimed: str

    def __str__(self) -> str:
        actual = f"{self.actual:.1e}" if self.actual > ROUNDING else "rounding"
        return f"| {self.physics} | {self.quantity} | {self.source} | {self.claimed} | {actual} |"


def difference(value: object, truth: object) -> float:
    """Largest relative difference."""
    values, truths = np.atleast_1d(np.asarray(value, float)), np.atleast_1d(np.asarray(truth, float))
    worst = float(np.max(np.abs(values / truths - 1.0)))
    if not math.isfinite(worst):
        raise ValueError(f"values {values} cannot be compared with {truths}")
    return worst


def claim_of(answer: Any, name: str, rows: object = -1) -> str:
    """Level and largest error of a claim in some rows, in the words of the page."""
    claim = answer.claims[name]
    level = claim.level.name.lower().replace("_", " ")
    if claim.error is None:
        return f"{level}, error not known"
    error = float(np.max(np.atleast_1d(claim.error)[rows]))
    return f"{level}, {error:.1e}" if error > ROUNDING else level


def compared(physics: str, answer: Any, name: str, truth: object, source: str, rows: object = -1) -> Row:
    """One quantity of a result or a study next to its reference."""
    quantity = name.replace("_", " ")
    values = answer[name].values
    values = np.atleast_1d(values)[rows]
    return Row(physics, quantity, source, difference(values, truth), claim_of(answer, name, rows))


def expected(name: str) -> dict:
    return REFERENCES[name]["expected"]


def absent(physics: str, quantity: str, package: str) -> str:
    """The row of a package that this run does not have."""
    return f"| {physics} | {quantity} | {package} | | not installed |"
