"""Graded tables of a positive rising function: relative accuracy at every argument, exact integrals, and the inverse.

The domain is divided at marks, where the function is not smooth. In each segment the offset from its lower mark is graded by
octaves in eight parts, so that the leading bits of the offset are the index of a panel. A panel has a polynomial; the integrals
are its exact integrals, summed over the panels before, so that their derivatives are accurate to rounding. Panels that do not meet the
tolerance are divided into equal parts. The innermost panel of a segment is one polynomial or b + c offset^q.

``reading`` reads tables in compiled kernels; it loads numba and is imported by kernels only.

:mod:`pymdr.numerics.table` has Chebyshev series of many functions with half-integer powers at both ends of their segments, which
are read together by NumPy and accurate relative to their largest values. A graded table has one function, its integrals and
inverse, accurate relative to each value, for kernels that read one value at a time.
"""

from pymdr.numerics.graded.value import GradedTable, graded_table

__all__ = ["GradedTable", "graded_table"]
