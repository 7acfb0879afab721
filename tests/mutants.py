"""Do the tests notice mistakes? Random small changes of the source, and which of them survive.

``make mutants`` records which test runs which line (`pytest --cov=pymdr --cov-context=test`), then calls
``python -m tests.mutants --count 200``: it draws statements of mapping, line and interpretation, changes an operator, a
comparison, a constant or a condition in one of them, runs the tests that pass there on a copy of the source, and lists
what they let pass. Lines of compiled kernels are not recorded: of them the tests of their folder are asked. ``--seed``
and ``--only`` replay a mutant.
"""

import argparse
import ast
import math
import os
import random
import resource
import secrets
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass
from functools import cache
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
OWN_TESTS = {
    "layer": ("layers", "thickness", "combinations", "verify_layers"),
    "rebound": ("impact_memory",),
    "impact": ("impact", "impact_memory"),
    "collision": ("impact",),
    "memory": ("memory", "viscoelastic", "memory_friction"),
    "relaxation": ("memory", "rheology", "viscoelastic"),
    "rough": ("rough", "rough_sliding"),
    "surfaces": ("read_topography", "topography", "measured_surfaces"),
    "shapes": ("shapes", "verify_shapes"),
    "azimuth": ("shapes", "verify_shapes"),
    "ellipse": ("shapes", "verify_shapes"),
    "patch": ("shapes", "rough"),
    "closure": ("closure",),
    "rolling": ("rolling",),
    "sliding": ("sliding", "sliding_friction"),
    "conduct": ("conductance",),
    "heating": ("conductance",),
    "press": ("press",),
    "theories": ("problem", "result"),
}
"""Tests of what a word in the path of a file is about, which run before those of its folder."""
OPERATORS = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Lt: ast.LtE, ast.LtE: ast.Lt,
    ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.And: ast.Or, ast.Or: ast.And,
    ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd,
}  # fmt: skip
PATIENCE = 600
MOST = 250
"""Tests that are asked of a line that more of them pass."""


@dataclass(frozen=True)
class Mutant:
    """One small change of one file."""

    file: Path
    lines: range
    words: str
    source: str


def changes(tree):
    """Pairs of a node and what may be done to it."""
    for function in ast.walk(tree):
        if not isinstance(function, ast.FunctionDef):
            continue
        for node in (node for part in function.body for node in ast.walk(part)):
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
    lines = range(node.lineno, node.end_lineno + 1)
    after = ast.unparse(ast.fix_missing_locations(node)).splitlines()[0]
    return Mutant(file, lines, f"{first[:90]}  ->  {after[:90]}", ast.unparse(tree))


@cache
def recorded():
    """What the last recording tells: for each file and line the tests that pass it, and how many lines a test passes."""
    from coverage import CoverageData

    data = CoverageData(ROOT / ".coverage")
    data.read()
    passing = {file: data.contexts_by_lineno(file) for file in data.measured_files()}
    breadth = Counter(test for lines in passing.values() for tests in lines.values() for test in tests)
    return passing, breadth


def selected(result):
    """The tests that pass its lines, those with the fewest lines first, every so many of very many; of compiled code those of its folder."""
    passing, breadth = recorded()
    lines = passing.get(str(result.file), {})
    tests = {test for line in result.lines for test in lines.get(line, ()) if test}
    if tests:
        ranked = sorted(tests, key=breadth.__getitem__)
        return [test.rpartition("|")[0] for test in ranked[:: math.ceil(len(ranked) / MOST)]]
    relative = result.file.relative_to(ROOT)
    own = [test for word, tests in OWN_TESTS.items() if word in str(relative) for test in tests]
    files = [f"tests/test_{name}.py" for name in dict.fromkeys([*own, *TESTS[relative.parts[2]]])]
    return sorted(files, key=lambda test: -(ROOT / test).read_text().count(relative.stem))


def survives(result, place):
    """Whether all tests that are asked pass with it, on the copy of the source in `place`; a run without end counts as noticed."""
    relative = result.file.relative_to(ROOT)
    mutated, whole = place / relative, result.file.read_text()
    # kernels whose sources did not change need not be compiled again
    kept = place / ("changed" if "compiled" in whole else "cache")
    mutated.write_text(result.source)
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-n", "0", "-m", "", "-p", "no:cacheprovider"]
    command += ["--rootdir", str(ROOT), "-c", str(ROOT / "pyproject.toml")]
    # doctests of the source itself would import that, and not the copy
    command += [str(place / test) if test.startswith("src/") else test for test in selected(result)]
    environment = {**os.environ, "PYTHONPATH": str(place / "src"), "CI": "1", "NUMBA_CACHE_DIR": str(kept)}
    try:
        ended = subprocess.run(
            command, cwd=ROOT, env=environment, capture_output=True, check=False, preexec_fn=limited
        )
    finally:
        shutil.copy2(result.file, mutated)
        shutil.rmtree(place / "changed", ignore_errors=True)
    if ended.returncode in (pytest.ExitCode.USAGE_ERROR, pytest.ExitCode.NO_TESTS_COLLECTED):
        raise RuntimeError(f"no tests were run: {ended.stdout.strip()} {ended.stderr.strip()}")
    return ended.returncode == 0


def limited():
    """Seconds of the processor that a run may take."""
    resource.setrlimit(resource.RLIMIT_CPU, (PATIENCE, PATIENCE))


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
    chosen = [(i, mutant(random.Random(f"{seed} {i}"))) for i in given.only or range(given.count)]
    words = {
        i: f"{i}: {result.file.relative_to(ROOT)}:{result.lines[0]}  {result.words}" for i, result in chosen
    }
    if given.list:
        print("\n".join(words.values()))
        return
    alive = 0
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        shutil.copytree(ROOT / "src", place / "src", ignore=shutil.ignore_patterns("__pycache__"))
        for done, (i, result) in enumerate(chosen, start=1):
            survived = survives(result, place)
            alive += survived
            print(f"{'survived' if survived else 'noticed '} {words[i]}", flush=True)
            print(f"{done - alive} of {done} noticed", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
