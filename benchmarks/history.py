"""Ratios of the benchmarks over versions: a table for each benchmark in ``benchmarks/results``, and what fell by a third."""

import csv
from collections.abc import Iterable
from pathlib import Path

from benchmarks.timing import Ratio

FOLDER = Path(__file__).parent / "results"
FALL = 2.0 / 3.0
"""Of the speed relative to the alternative, below which a benchmark is reported."""
COLUMNS = ("version", "what", "against", "times_faster", "note")


def read(file: Path) -> list[dict[str, str]]:
    """Rows of a table, oldest first; none if there is no file."""
    if not file.exists():
        return []
    with file.open(encoding="utf-8", newline="") as opened:
        return list(csv.DictReader(opened))


def record(name: str, ratios: Iterable[Ratio], version: str, folder: Path = FOLDER) -> list[str]:
    """
    Put the ratios of one benchmark into its table, in place of earlier ones of the same version.

    Returns
    -------
    list of str
        A sentence for each ratio below two thirds of that of the version before.
    """
    file = folder / f"{name}.csv"
    kept = [row for row in read(file) if row["version"] != version]
    before = {(row["what"], row["against"]): row for row in kept}
    fallen, rows = [], []
    for ratio in ratios:
        faster = ratio.other / ratio.ours
        rows.append(
            {
                "version": version,
                "what": ratio.what,
                "against": ratio.against,
                "times_faster": f"{faster:.4g}",
                "note": ratio.note,
            }
        )
        earlier = before.get((ratio.what, ratio.against))
        if earlier is not None and faster < FALL * float(earlier["times_faster"]):
            fallen.append(
                f"{name}, {ratio.what}: {faster:.3g} times as fast as {ratio.against}, {earlier['times_faster']} in {earlier['version']}"
            )
    folder.mkdir(parents=True, exist_ok=True)
    with file.open("w", encoding="utf-8", newline="") as opened:
        writer = csv.DictWriter(opened, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows([*kept, *rows])
    return fallen
