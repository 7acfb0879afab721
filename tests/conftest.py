"""Shared fixtures."""

import importlib.util
import json
import os
from pathlib import Path

import pytest
from hypothesis import settings

# before numpy is there: threads of a linear algebra in every worker wait for each other and hold up all of them
for _name in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS", "VECLIB_MAXIMUM_THREADS"):
    os.environ.setdefault(_name, "1")

FOLDER = Path(__file__).parent / "reference"
REFERENCES = json.loads((FOLDER / "refs.json").read_text())["refs"]


_approx = pytest.approx


def approx(expected, rel=None, abs=None, nan_ok=False):
    """As pytest's, but a relative tolerance alone is relative: pytest adds 1e-12, which hides forces of piconewtons."""
    if rel is not None and abs is None:
        abs = 0.0
    return _approx(expected, rel=rel, abs=abs, nan_ok=nan_ok)


pytest.approx = approx


# a run of the tests gives the same answer twice; `make explore` draws its examples anew
settings.register_profile("steady", derandomize=True)
settings.register_profile("explore", derandomize=False, print_blob=True)
settings.load_profile("steady")


LONG = frozenset((Path(__file__).parent / "long.txt").read_text().split("\n")) - {""}
"""Tests that take more than about a second of a quiet core; `make explore` runs them."""


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(session, config, items):
    """Mark what long.txt names, with or without parameters, and refuse names that no test has any more."""
    present = set()
    for item in items:
        names = {item.nodeid, item.nodeid.split("[")[0]}
        present |= names
        if names & LONG:
            item.add_marker(pytest.mark.long)
    whole = not config.option.file_or_dir and not config.option.keyword
    if whole and (gone := LONG - present):
        raise pytest.UsageError(
            f"tests/long.txt names tests that are not there: {', '.join(sorted(gone)[:5])}"
        )


@pytest.fixture(scope="session")
def references():
    """The independent reference values by id."""
    return {entry["id"]: entry for entry in REFERENCES}


@pytest.fixture(scope="session")
def closed_forms():
    """The module of closed forms in extended precision."""
    spec = importlib.util.spec_from_file_location("pymdr_closed_forms", FOLDER / "closed_forms.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def shell(capfd, monkeypatch):
    """Run the command line as the console script does; gives exit status, output and errors."""

    from pymdr.workbench.cli import main

    def run(*arguments):
        monkeypatch.setattr("sys.argv", ["pymdr", *map(str, arguments)])
        try:
            main()
            status = 0
        except SystemExit as stop:
            status = stop.code or 0
        out, err = capfd.readouterr()
        return status, out, err

    return run


@pytest.fixture
def kinds():
    """What a test registers is forgotten after it."""
    from pymdr.problem import codec
    from pymdr.problem.codec.tables import TABLES

    tables = *TABLES.values(), codec.KIND_OF
    before = [dict(table) for table in tables]
    yield
    for table, entries in zip(tables, before, strict=True):
        table.clear()
        table.update(entries)
    codec.forget_models()
