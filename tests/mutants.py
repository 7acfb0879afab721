"""Do the tests notice mistakes? Random small changes of the source, and which of them survive.

``python -m tests.mutants --count 200`` draws statements of mapping, line and interpretation, changes an operator, a
comparison, a constant or a condition in one of them, runs the tests of its folder on a copy of the source, and lists
what they let pass. ``--seed`` and ``--only`` replay a mutant.
"""

import argparse
import ast
import os
import random
import secrets
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
TESTS = {
    "mapping": ("moduli", "abel", "equivalent", "panel_map", "callables", "sampled", "fields", "certificate"),
    "line": (
        "foundation", "following", "adhesion_curves", "adhesive_solving", "friction_tables", "friction_stack",
        "frictional_solving", "laws",
    ),
    "interpretation": (
        "validity", "certificate", "fields", "files_claims", "normal_contact", "laws", "law_figures", "frictional_solving",
        "adhesive_solving", "graded_bodies", "viscoelastic",
    ),
}  # fmt: skip
OPERATORS = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Lt: ast.LtE, ast.LtE: ast.Lt,
    ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.And: ast.Or, ast.Or: ast.And,
    ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd,
}  # fmt: skip
PATIENCE = 900.0


@dataclass(frozen=True)
class Mutant:
    """One small change of one file."""

    file: Path
    line: int
    words: str
    source: str


def changes(tree):
    """Pairs of a node and what may be done to it."""
    for function in ast.walk(tree):
        if not isinstance(function, ast.FunctionDef):
            continue
        for node in ast.walk(function):
            if isinstance(node, ast.BinOp | ast.BoolOp) and type(node.op) in OPERATORS:
                yield node, "op"
            elif isinstance(node, ast.Compare) and type(node.ops[0]) in OPERATORS:
                yield node, "comparison"
            elif isinstance(node, ast.Constant) and type(node.value) in (int, float):
                yield node, "constant"
            elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Not):
                yield node, "sign"
            elif isinstance(node, ast.If | ast.IfExp):
                yield node, "condition"


def mutant(rng):
    """Draw one: files by their length, places in them evenly."""
    files = sorted(f for folder in TESTS for f in (ROOT / "src/pymdr" / folder).rglob("*.py"))
    file = rng.choices(files, [f.stat().st_size for f in files])[0]
    tree = ast.parse(file.read_text())
    places = list(changes(tree))
    if not places:
        return mutant(rng)
    node, kind = rng.choice(places)
    before = ast.unparse(node)
    if kind == "op":
        node.op = OPERATORS[type(node.op)]()
    elif kind == "comparison":
        node.ops[0] = OPERATORS[type(node.ops[0])]()
    elif kind == "constant":
        node.value = node.value + 1 if isinstance(node.value, int) else 1.5 * node.value + (node.value == 0)
    elif kind == "sign":
        node.op = ast.UAdd() if isinstance(node.op, ast.USub) else ast.Not()
        if isinstance(node.op, ast.Not):
            node.operand = ast.UnaryOp(ast.Not(), node.operand)
    else:
        node.test = ast.UnaryOp(ast.Not(), node.test)
    first = before.splitlines()[0]
    after = ast.unparse(ast.fix_missing_locations(node)).splitlines()[0]
    return Mutant(file, node.lineno, f"{first[:90]}  ->  {after[:90]}", ast.unparse(tree))


def survives(found):
    """Whether all tests of its folder pass with it; a run without end counts as noticed."""
    folder = found.file.relative_to(ROOT / "src/pymdr").parts[0]
    with tempfile.TemporaryDirectory() as place:
        shutil.copytree(ROOT / "src", Path(place) / "src", ignore=shutil.ignore_patterns("__pycache__"))
        (Path(place) / found.file.relative_to(ROOT)).write_text(found.source)
        asked = [str(ROOT / f"tests/test_{name}.py") for name in TESTS[folder]]
        command = [sys.executable, "-m", "pytest", "-q", "-x", "-n", "0", "-p", "no:cacheprovider", *asked]
        environment = {**os.environ, "PYTHONPATH": f"{place}/src", "CI": "1", "NUMBA_CACHE_DIR": place}
        try:
            ended = subprocess.run(
                command, cwd=ROOT, env=environment, capture_output=True, timeout=PATIENCE, check=False
            )
        except subprocess.TimeoutExpired:
            return False
    if ended.returncode in (pytest.ExitCode.USAGE_ERROR, pytest.ExitCode.NO_TESTS_COLLECTED):
        raise RuntimeError(f"no tests were run: {ended.stdout.strip()} {ended.stderr.strip()}")
    return ended.returncode == 0


def main():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=None, help="a fresh one unless given")
    parser.add_argument("--only", type=int, nargs="+", help="mutants to replay")
    parser.add_argument("--list", action="store_true", help="only say what would be changed")
    given = parser.parse_args()
    seed = secrets.randbits(31) if given.seed is None else given.seed
    print(f"seed {seed}", flush=True)
    alive = 0
    chosen = given.only or range(given.count)
    for done, i in enumerate(chosen, start=1):
        found = mutant(random.Random(f"{seed} {i}"))
        words = f"{i}: {found.file.relative_to(ROOT)}:{found.line}  {found.words}"
        if given.list:
            print(words)
        elif survives(found):
            alive += 1
            print(f"survived {words}", flush=True)
        else:
            print(f"noticed  {words}", flush=True)
        if not given.list:
            print(f"{done - alive} of {done} noticed", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
