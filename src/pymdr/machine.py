"""Resources of the computer."""

from __future__ import annotations

import math
import os


def memory_of_machine() -> float:
    """Bytes of memory of this machine; inf if it is unknown."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE")) * float(os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, OSError, ValueError):
        return math.inf
