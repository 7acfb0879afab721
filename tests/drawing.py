"""How much of a test is run: its random examples, its parameters."""

import pytest
from hypothesis import settings


def first_of(values, count=1):
    """Parameters of a test; all but the first of them are long."""
    return [*values[:count], *(pytest.param(value, marks=pytest.mark.long) for value in values[count:])]


def examples(count):
    """All of them where they are drawn anew; a sixth, and always the same, in the run that everybody waits for."""
    return max(count // 6, 3) if settings().derandomize else count
