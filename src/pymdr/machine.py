"""Resources of the computer."""

from __future__ import annotations

import math
import os
from contextlib import AbstractContextManager, nullcontext


def memory_of_machine() -> float:
    """Bytes of memory of this machine; inf if it is unknown."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE")) * float(os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, OSError, ValueError):
        return math.inf


def one_thread() -> AbstractContextManager[object]:
    """Linear algebra in one thread: threads of several processes wait for each other on the same cores."""
    try:
        from threadpoolctl import threadpool_limits
    except ImportError:
        return nullcontext()
    limits: AbstractContextManager[object] = threadpool_limits(1)
    return limits
