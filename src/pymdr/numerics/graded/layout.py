"""Columns of the rows of a graded table.

Row 0 is the header. The segments follow, then the look-up of segments, the panels, and the look-up of the inverse.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from pymdr.units import FloatArray

IntArray: TypeAlias = NDArray[np.int64]

FACTOR, MAX, COUNT, FIRST_MARK, LOOKUP, LOOKUP_LOWEST, LOOKUP_SHIFT, NEAR, INNER_INTEGRAL, FULL_INTEGRAL = (
    range(10)
)
"""Columns of the header: the factor of the integrals, the largest argument, the number of
segments, the first mark, the look-ups, and the
integral up to the innermost panel and up to the largest argument."""
SPARE = 10
"""First of the columns of the header that are free for constants of the reader."""
SEGMENT = 1
"""Row of the first segment."""
ORIGIN, LOWEST, FIRST, PER_INNERMOST = range(4)
"""Columns of a segment: its mark, the key and the row of its lowest graded panel, 1 over the width of the innermost one."""
KIND, CHILD, PARTS = range(3)
"""Columns of a panel that is divided; in a polynomial panel 8 coefficients of f, 9 of its integral and 10 of the second follow."""
POLYNOMIAL, DIVIDED, POWER = range(3)
"""Kinds of panels: polynomials; divided into equal parts; b + c z^q."""
B, C, Q, PER_WIDTH, INTEGRAL, INTEGRAL_B, INTEGRAL_C, SECOND, SECOND_B, SECOND_C = range(1, 11)
"""Columns of a panel with a power."""
TERMS = 8
COLUMNS = 1 + TERMS + (TERMS + 1) + (TERMS + 2)
PER_ROW = 16
"""Entries in a row of a look-up."""
BITS = 3
"""An octave has 2^BITS panels."""
DROPPED, MANTISSA, ONE = 52 - BITS, (1 << 52) - 1, 1023 << 52
"""Bits of a float that its key leaves out; the bits of the mantissa; the bits of 1."""


def key_of(values: FloatArray, bits: int = BITS) -> IntArray:
    """The leading bits of positive floats: each octave in 2^bits equal parts, in order."""
    return values.view(np.int64) >> (52 - bits)


def value_of(key: IntArray, bits: int = BITS) -> FloatArray:
    """The float at which a part of an octave begins."""
    return (key << (52 - bits)).view(np.float64)
