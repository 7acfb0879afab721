"""Springs with memory under shear, with slip."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pymdr.line.curves import Curve
from pymdr.line.memory.histories import Passage
from pymdr.line.memory.modes import active_springs, modes_of, packed, unpacked
from pymdr.mapping.relaxation import Relaxation
from pymdr.units import FloatArray


@dataclass(frozen=True, eq=False)
class TangentialState:
    """The tangential state of a contact after a row."""

    shift: float
    """u in m."""
    deflection: FloatArray
    """(n,) w_x in m."""
    branches: FloatArray
    """(n, k) forces of the Maxwell branches per length of the line and side in Pa m."""
    free: FloatArray
    """(n,) 1 where a spring is free, 0 in contact."""


class TangentialHistory(NamedTuple):
    """One entry per row that was followed, and the state after the last one; energies are those of the rows, not their sums."""

    shift: FloatArray
    """u in m."""
    force: FloatArray
    """F_x in N."""
    stick_radius: FloatArray
    """c in m, where the springs within it are all stuck and no others are."""
    stored: FloatArray
    """Energy of the springs of all branches in J."""
    dissipated: FloatArray
    """Energy dissipated by the dashpots in a row, in J."""
    slip_work: FloatArray
    """Energy dissipated by friction in a row, in J."""
    work: FloatArray
    """Work of the shift in a row, in J."""
    slid: FloatArray
    """Distance in m by which all springs in contact slip in a row."""
    disk: np.ndarray
    """Whether the springs that stick are those of a disk."""
    state: TangentialState


def unsheared(shift: float = 0.0) -> TangentialState:
    """The state of bodies that have not touched."""
    none = np.zeros(0)
    return TangentialState(shift, none, np.zeros((0, 0)), none)


def shear_springs(
    curve: Curve,
    passage: Passage,
    relaxations: tuple[Relaxation, Relaxation],
    friction: float,
    target: FloatArray,
    forced: bool,
    state: TangentialState,
    *,
    slack: float = 0.0,
) -> TangentialHistory:
    """
    Follow shifts, or tangential forces, of a history whose normal loads are known.

    Every spring bears q_x = int G*(t - s) dw_x(s), ``|q_x|`` <= mu q. A stuck one moves with the shift; one that leaves the contact
    bears nothing and creeps back; one that is touched begins where the shift is then.

    Parameters
    ----------
    curve : Curve
        Per unit modulus.
    passage : Passage
        Rows with the loads of the springs, which go straight between them.
    relaxations : tuple of Relaxation
        E*(t) and G*(t).
    friction : float
        mu, from 0 to inf.
    target : ndarray, shape (m,)
        u in m at every row, straight between them; or F_x in N.
    forced : bool
        Whether forces are prescribed.
    state : TangentialState
        Where to go on.
    slack : float
        By what part of mu F_N a force may be more than friction carries; it is mu F_N then.

    Returns
    -------
    TangentialHistory
        Of fewer rows where a force is more than friction carries. Exact in time while a spring sticks under straight shifts;
        what slips errs as the square of the distance of the rows.

    Notes
    -----
    Popov and Hess (2015), chapters 5 and 7.
    """
    from pymdr.line.memory import kernels as steps
    from pymdr.line.memory import tangential_kernels as kernels

    (normal, tangential), springs = relaxations, passage.springs
    modes, size = modes_of(tangential), springs.position.size
    body = steps.body_of(tangential, modes)
    first = unpacked(state.deflection, state.branches, state.free, size, tangential, modes)
    run = kernels.shear_of(steps.table_of(springs), float(friction), body)
    rows = np.zeros((target.size, kernels.COLUMNS))
    pressed = kernels.Pressed(row_data(curve, passage, normal), passage.notes)
    control, start = (bool(forced), float(slack)), (float(state.shift), active_springs(first))
    states = first, first.copy(), first.copy()
    followed = kernels.shear(run, pressed, np.array(target), control, start, states, rows)
    rows = rows[:followed]
    shifts = rows[:, kernels.SHIFT].copy()
    end = TangentialState(float(shifts[-1]) if followed else state.shift, *packed(first, tangential, modes))
    return TangentialHistory(
        shifts,
        rows[:, kernels.FORCE],
        np.minimum(rows[:, kernels.STICK], passage.contact_radius[:followed]),
        rows[:, kernels.STORED],
        rows[:, kernels.DISSIPATED],
        rows[:, kernels.SLIP],
        rows[:, kernels.WORK],
        rows[:, kernels.SLID],
        rows[:, kernels.DISK] != 0.0,
        end,
    )


def row_data(curve: Curve, passage: Passage, normal: Relaxation) -> FloatArray:
    """The rows of normal contact as arguments of the kernels."""
    from pymdr.line.memory import tangential_kernels as kernels

    waits, moves = np.diff(passage.time), np.diff(passage.indentation)
    given = np.zeros((waits.size, kernels.GIVEN))
    given[:, kernels.TIME], given[:, kernels.MOVE] = waits, moves
    with np.errstate(divide="ignore", invalid="ignore"):
        x = waits[:, None] / normal.times
        means = np.where(x > 0.0, -np.expm1(-x) / x, 1.0)
        given[:, kernels.STIFF] = normal.equilibrium + means @ normal.moduli
        if normal.viscosity > 0.0:
            given[:, kernels.DRAG] = normal.viscosity * np.where(moves == 0.0, 0.0, moves / waits)
    given[:, kernels.NORMAL] = passage.force
    given[:, kernels.AREA] = curve.stiffness(passage.contact_radius)
    return given
