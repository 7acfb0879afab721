"""Claimed against actual errors of random profiles, as the table that the documentation draws.

``python -m benchmarks.accuracy --count 300 docs/demonstrations/claimed_and_actual.csv`` solves random profiles as
``python -m tests.accuracy`` does, holds every number against the reference in extended precision, prints the study and
writes, for every profile and quantity, the value that came closest to the error that it claims.
"""

import argparse
import secrets
from pathlib import Path

import numpy as np
from tests import accuracy

HEAD = "kind,quantity,claimed,actual,rounding"


def closest(outcome):
    """Of every quantity of a profile the value whose error is the largest part of what is allowed."""
    found = {}
    for value in outcome.values:
        part = np.nan_to_num(value.miss / value.allowed, nan=np.inf)
        if value.quantity not in found or part > found[value.quantity][0]:
            found[value.quantity] = (part, value)
    return [value for _, value in found.values()]


def table(study, drawn):
    """The study as CSV, with the rows of its first `drawn` profiles; what it found of all of them is a comment."""
    values = sum(len(o.values) for o in study.outcomes)
    solved = sum(bool(o.values) for o in study.outcomes)
    lines = [
        f"# seed {study.seed}: {len(study.outcomes)} profiles, {solved} of them solved, {values} values, "
        f"{len(study.violations)} outside their claim; EXACT: {study.share_exact():.1%} of smooth profiles, "
        f"{study.share_exact(False):.1%} of the others",
        HEAD,
    ]
    for outcome in study.outcomes[:drawn]:
        for v in closest(outcome):
            rounding = max(v.allowed - 10.0 * v.claimed, 1e-14)
            lines.append(f"{outcome.kind},{v.quantity},{v.claimed:.2e},{v.miss:.2e},{rounding:.2e}")
    return "\n".join(lines) + "\n"


def main():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path, help="CSV file to write")
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--drawn", type=int, default=300, help="profiles whose rows are written")
    parser.add_argument("--seed", type=int, default=None, help="a fresh one unless given")
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument(
        "--quick", action="store_true", help="four depths, one energy and one pressure a profile"
    )
    given = parser.parse_args()
    seed = secrets.randbits(31) if given.seed is None else given.seed
    effort = accuracy.Effort(4, 1, 1) if given.quick else accuracy.Effort()
    study = accuracy.study(seed, given.count, given.processes, progress=True, effort=effort)
    print(study.table())
    given.file.write_text(table(study, given.drawn), encoding="utf-8")


if __name__ == "__main__":
    main()
