"""What compiled steps of a ball that yields and their maker both name. Loads no numba."""

from __future__ import annotations

DEPTH, LARGEST, FORCE, EDGE, DISSIPATED, JUMPED = range(6)
"""What a contact remembers: d, the largest d, F, and with adhesion its radius, the energy lost by the edge, and whether the last step jumped."""
RADIUS, MODULUS, SHEAR, POISSON, STRENGTH, YIELD_DEPTH, WALLED = range(7)
"""Constants of a ball in SI units."""
