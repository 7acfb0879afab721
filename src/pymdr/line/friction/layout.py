"""What kernels and their drivers both name: columns of curves and of states, and endings of runs. Loads no numba."""

from __future__ import annotations

from pymdr.numerics.graded.layout import SPARE

MODULUS, EXPONENT, INVERSE, PER_COEFFICIENT, UNIT, FORCE_FACTOR, WORK_FACTOR = range(SPARE, SPARE + 7)
"""E* in Pa; n of a power law, 0 for a table; 1/n; 1/coefficient; unit; F_N over a d; W over F_N d; in spare columns of a graded table."""
DEPTH, SHIFT, SLIP_WORK, CARRY, SLIDE, TOP = range(6)
"""What a run remembers besides its stack from one row to the next; TOP is the index of the top vertex."""
FORCE_SCALE, ENERGY_SCALE, SHIFT_SCALE = range(3)
"""Factors from normalised forces, energies and shifts to SI units."""
COMPLETE, NOT_FINITE, NOT_ATTAINABLE, TOO_DEEP, STACK_FULL = range(5)
"""How a run ended."""
