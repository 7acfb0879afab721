"""What compiled steps on the branches of a curve and their maker both name. Loads no numba."""

from __future__ import annotations

BRANCHES, CELLS, CELL_COUNT, TERMS = range(4)
"""Columns of the header: number of branches, row of the first cell, number of cells, terms of a series."""
LOW, HIGH, DOWN_TO, DOWN_LOSS, DOWN_JUMPS, UP_TO, UP_LOSS, UP_JUMPS, FIRST, LAST, BOTTOM, TOP = range(12)
"""Columns of a branch: its ends in D; the branch reached below and above them, the energy lost and whether that is a jump; its segments;
its ends in s. A free body is the last branch."""
SEGMENT_LOW, SEGMENT_HIGH = range(2)
"""Columns of a segment: its ends in D."""
PARAMETER, FORCE, RADIUS, STIFFNESS, OTHER = range(5)
"""Functions of a table; the last three for an edge that rests: its radius and stiffness, and D of its state on the other curve."""
(
    STATE,
    DEPTH,
    AT,
    NORMAL,
    DISSIPATED,
    JUMPED,
    TOUCHED,
    CURVE,
    MOVES,
    ATTACHED,
    PER_DEPTH,
    BASE_DEPTH,
    BASE_FORCE,
    RESTS_FROM,
    RESTS_TO,
    SPENT,
) = range(16)
"""What a contact remembers: its branch, D, s, F, energy lost, whether the last step jumped, whether it ever touched; of an edge that rests the curve on which it
last moved, the direction of the last step, its radius and stiffness, D and F where it came to rest, the range of its rest, and the energy
lost by hysteresis."""
PLAIN = TOUCHED + 1
"""Columns without hysteresis."""
NO_CONTACT, NOWHERE = -1, -3
"""Branches: of a free body, and none that is known to be stable."""
EDGE, PER_AREA, LEAST = range(3)
"""Constants of an edge: its largest parameter, the energy lost per area where it recedes, and the radius at its pull-off."""
COMPLETE, UNSTABLE = range(2)
"""How a step ended: an edge at rest that begins to move may be in an unstable state of its curve."""
