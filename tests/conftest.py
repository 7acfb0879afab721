"""Shared fixtures."""

import importlib.util
import json
from pathlib import Path

import pytest

FOLDER = Path(__file__).parent / "reference"
REFERENCES = json.loads((FOLDER / "refs.json").read_text())["refs"]


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
