"""What the kernel of motion and its driver both name. Loads no numba."""

from __future__ import annotations

COMPLETE, TOO_DEEP, STACK_FULL, NOT_CONVERGED = range(4)
"""How a run ended."""
SLIP, DAMPING, DRIVES, FORCES = range(4)
"""Sums over the steps: energy dissipated by slip and in dampers, work of drives and of forces, in J."""
KINETIC, SPRINGS, NORMAL, TANGENTIAL = range(4)
"""Energies of a state in J; in a row they come before the sums."""
DEPTH, SHIFT, FORCE, PULL, RADIUS, STICK = range(6)
"""Columns of one joint in a row: d, u_x, F_N, F_x, a, b in SI units."""
WORK, STORED, SLIPPED = range(3)
"""Energies of one joint after a step: of the indentation, of the shift, and dissipated in the step, in J."""
