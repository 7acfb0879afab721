"""Measured records that stand beside the repository, as those of the tests do."""

from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pymdr as mdr

FOLDER = Path(__file__).parents[2] / "shared/data/afm"


def records(segment: str = "record") -> Iterator[tuple[str, mdr.MeasuredCurve]]:
    """Names and curves, ready for a fit; those of a map one by one. None where afmformats (the extra afm) is not installed."""
    if find_spec("afmformats") is None:
        return
    for file in sorted(FOLDER.glob("*.jpk-force*")):
        name = file.stem.removeprefix("fmt-jpk-")
        curves = mdr.read_prepared_curves(file, segment=segment)
        for i, curve in enumerate(curves):
            yield (f"{name}[{i}]" if len(curves) > 1 else name), curve
