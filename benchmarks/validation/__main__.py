"""Recomputes the tables and figures of docs/validation.md, each number from a solve of this run.

``python -m benchmarks.validation`` prints the tables and writes them into the page; ``--random 0`` omits the random problems.
"""

import argparse
from collections.abc import Iterable, Iterator, Mapping

from tests import accuracy

from benchmarks.validation import figures
from benchmarks.validation.elastic import ELASTIC
from benchmarks.validation.histories import HISTORIES
from benchmarks.validation.programs import measured, programs, solvers
from benchmarks.validation.rows import ROOT
from benchmarks.validation.surfaces import SURFACES

PAGE = ROOT / "docs" / "validation.md"
CLOSED = (*ELASTIC, *SURFACES, *HISTORIES)


def drawn(count: int, seed: int) -> dict[str, list[accuracy.Outcome]]:
    """Random problems of each kind, from the study of tests/accuracy.py."""
    effort = accuracy.Effort(False, 4, 1, 1)
    return {
        kind: accuracy.study(seed, count, effort=effort, kinds=(kind,)).outcomes for kind in accuracy.KINDS
    }


def counts(problems: Mapping[str, list[accuracy.Outcome]]) -> Iterator[str]:
    """Problems, values and violations of each kind."""
    for kind, outcomes in problems.items():
        values = sum(len(outcome.values) for outcome in outcomes)
        violated = sum(any(value.violated for value in outcome.values) for outcome in outcomes)
        failed = sum(bool(outcome.crashes) for outcome in outcomes)
        refused = sum(bool(outcome.refusals) for outcome in outcomes)
        yield f"| {kind} | {len(outcomes)} | {values} | {violated} | {failed} | {refused} |"


CLAIMED = "| physics | quantity | reference | claim | difference |\n|---|---|---|---|---|"
RECORDED = "| record | quantity | reference | difference that is likely | difference |\n|---|---|---|---|---|"
DRAWN = "| kind | problems | values | problems that violate a claim | that fail | with a refusal |\n|---|---|---|---|---|---|"


def write(name: str, head: str, rows: Iterable[object]) -> None:
    """Print a table, and put it between its marks in the page."""
    lines = [head]
    print(head)
    for row in rows:
        lines.append(str(row))
        print(row, flush=True)
    page = PAGE.read_text(encoding="utf-8")
    begin, end = f"<!-- begin {name} -->\n", f"<!-- end {name} -->"
    before, _, rest = page.partition(begin)
    _, _, after = rest.partition(end)
    if not rest:
        raise ValueError(f"{PAGE} has no mark {begin!r}")
    PAGE.write_text(f"{before}{begin}\n" + "\n".join(lines) + f"\n\n{end}{after}", encoding="utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--random", type=int, default=60, help="random problems of each kind")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    write("closed", CLAIMED, (row for part in CLOSED for row in part()))
    write("solvers", CLAIMED, solvers())
    write("programs", CLAIMED, programs())
    write("records", RECORDED, measured())
    figures.curves(ROOT / "docs" / "validation_curves.png")
    if given.random:
        problems = drawn(given.random, given.seed)
        write("random", DRAWN, counts(problems))
        outcomes = [outcome for some in problems.values() for outcome in some]
        figures.claims(ROOT / "docs" / "validation_claims.png", outcomes)


if __name__ == "__main__":
    main()
