"""What compiled steps of springs in the plane and their driver both name. Loads no numba."""

from __future__ import annotations

DEPTH, AT_X, AT_Y, FORCE_X, FORCE_Y, WORK = range(6)
"""What a contact remembers besides its springs: indentation and shift in m, forces in N, slip work in J."""
PER_FORCE, PER_SHIFT = range(2)
"""Factors from normalised forces and shifts to SI units."""
