"""Header of the curves for the kernels: constants of friction in the spare columns of a graded table."""

from __future__ import annotations

from pymdr.numerics.graded.layout import SPARE

MODULUS, EXPONENT, INVERSE, PER_COEFFICIENT, UNIT, FORCE_FACTOR, WORK_FACTOR = range(SPARE, SPARE + 7)
"""E* in Pa; n of a power law, 0 for a table; 1/n; 1/coefficient; unit; F_N over a d; W over F_N d."""
