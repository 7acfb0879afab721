"""Claimed against actual errors of random problems of all kinds, as the table that the documentation draws.

``python -m benchmarks.accuracy --folder out docs/demonstrations/claimed_and_actual.csv`` reads the outcomes that ``python -m tests.accuracy --folder out``
has kept, and writes, for every problem and quantity, the value that came closest to the error that it claims.
"""

import argparse
import json
from pathlib import Path

import numpy as np
from tests import accuracy

HEAD = "kind,quantity,claimed,actual,rounding"


def closest(outcome):
    """Of every quantity of a problem the value whose error is the largest part of what is allowed."""
    results = {}
    for value in outcome.values:
        part = np.nan_to_num(value.miss / value.allowed, nan=np.inf)
        if value.quantity not in results or part > results[value.quantity][0]:
            results[value.quantity] = (part, value)
    return [value for _, value in results.values()]


def table(study):
    """The study as CSV; what it found is a comment."""
    values = sum(len(o.values) for o in study.outcomes)
    solved = sum(bool(o.values) for o in study.outcomes)
    lines = [
        f"# seed {study.seed}: {len(study.outcomes)} problems, {solved} of them solved, {values} values, "
        f"{len(study.violations)} outside their claim",
        HEAD,
    ]
    for outcome in study.outcomes:
        kind = outcome.kind if outcome.kind in accuracy.FAMILIES else "profiles"
        for v in closest(outcome):
            rounding = max(v.allowed - 10.0 * v.claimed, 1e-14)
            lines.append(f"{kind},{v.quantity},{v.claimed:.2e},{v.miss:.2e},{rounding:.2e}")
    return "\n".join(lines) + "\n"


def main():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path, help="CSV file to write")
    parser.add_argument("--folder", type=Path, required=True, help="that of python -m tests.accuracy")
    given = parser.parse_args()
    about = json.loads((given.folder / "about.json").read_text(encoding="utf-8"))
    effort = accuracy.Effort(**about["effort"])
    study = accuracy.study(about["seed"], 0, effort=effort, kinds=about["kinds"], folder=given.folder)
    print(study.table())
    given.file.write_text(table(study), encoding="utf-8")


if __name__ == "__main__":
    main()
