"""The rows that the kernels read: what stands where."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from pymdr.units import FloatArray

IntArray: TypeAlias = NDArray[np.int64]

MODULUS, EXPONENT, INVERSE, PER_COEFFICIENT, UNIT, FORCE_FACTOR, WORK_FACTOR, REACH = range(8)
FIRST_MARK, LOOKUP, LOOKUP_LOWEST, LOOKUP_SHIFT, NEAR, FLOOR_FORCE, FULL_FORCE = range(8, 15)
"""Columns of the first row: for all curves, then for tables."""
SEGMENT = 1
"""Row of the first segment."""
ORIGIN, LOWEST, FIRST, PER_FLOOR = range(4)
"""Columns of a segment: its mark, its lowest piece and that one's row, 1 over the width below it."""
KIND, CHILD, PARTS = range(3)
"""Columns of a row; in a piece 8 coefficients of a, 9 of F_N and 10 of W follow its kind."""
PIECE, PARTED, CLOSED = range(3)
"""Kinds of rows: a, F_N and W as polynomials; cut in equal parts; b + c z^q."""
B, C, Q, PER_WIDTH, FORCE, FORCE_B, FORCE_C, WORK, WORK_B, WORK_C = range(1, 11)
"""Columns of a closed floor."""
TERMS = 8
COLUMNS = 1 + TERMS + (TERMS + 1) + (TERMS + 2)
PER_ROW = 16
"""Entries in a row of the look-up of segments and of depths by force."""
BITS = 3
"""An octave has 2^BITS pieces."""


def key_of(values: FloatArray, bits: int) -> IntArray:
    """The leading bits of floats above 0: each octave in 2^bits equal parts, in order."""
    return values.view(np.int64) >> (52 - bits)


def value_of(key: IntArray, bits: int) -> FloatArray:
    """The float at which a part of an octave begins."""
    return (key << (52 - bits)).view(np.float64)
