"""Shared fixtures."""

import json
from pathlib import Path

import pytest

REFERENCES = json.loads((Path(__file__).parent / "reference" / "refs.json").read_text())["refs"]


@pytest.fixture(scope="session")
def references():
    """The independent reference values by id."""
    return {entry["id"]: entry for entry in REFERENCES}
