"""The contact with friction along a path."""

from __future__ import annotations

from typing import Any


def solve_frictional(*args: Any) -> Any:
    raise NotImplementedError
