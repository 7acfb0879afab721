"""Fields and claims of contacts on viscoelastic layers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy

from pymdr.errors import ConvergenceError
from pymdr.interpretation.certificate import certify_disk
from pymdr.interpretation.memory import LineState, MemoryCheck, MemorySurface, displacement, memory_claims
from pymdr.interpretation.validity import BoolArray, Claim, bodies_of
from pymdr.line.curves import Line
from pymdr.line.foundation import states_at_depth
from pymdr.line.layered import LayeredLine
from pymdr.line.layered.coupled import Added, Coupled
from pymdr.line.memory import MemoryState
from pymdr.units import FloatArray


@dataclass(frozen=True)
class LayeredState(LineState):
    """The springs of one row, with their loads on the line of the layers: those of flat punches, superposed."""

    sunk: Coupled | None = None
    """What the layers add to the displacement of half-spaces under the load per modulus of the deflections, which `deflection` holds."""


@dataclass(frozen=True, eq=False)
class LayeredMemorySurface(MemorySurface):
    """
    Surface and line of a contact on viscoelastic layers.

    Notes
    -----
    A spring at the radius a stands for a flat punch of that radius: the deflections w(a) and the loads q(a) of springs, whose history
    is that of the material, superpose punches of the depths -dw and the relaxed depths -dq. On the line a punch of the depth 1 has the load
    q_A(x; a) of (I - K) q_A = 1 on x < a. With the Cholesky factor I - K = L L^T of the equation on the springs, y = L^-1 1, the superposed
    load is L^-T (y q) for all radii at once.
    """

    layers: LayeredLine

    @property
    def curve(self) -> Line:
        """The line per unit modulus."""
        return self.layers

    @cached_property
    def _factors(self) -> dict[tuple[int, float], tuple[FloatArray, FloatArray, FloatArray]]:
        """Widths of the parts of springs, L and y, by the number of springs and the last position."""
        return {}

    def _factor(self, x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        key = x.size, float(x[-1])
        if key not in self._factors:
            h = self.layers.thickness
            signs = (-1.0) ** np.arange(x.size)
            # every spring is in the middle of its part
            ends = 2.0 * signs * np.cumsum(signs * x)
            widths = np.diff(ends, prepend=0.0) / h
            root = np.sqrt(widths)
            matrix = np.eye(x.size) - root[:, None] * self.layers.kernel.pair(x / h, x / h) * root
            try:
                lower: FloatArray = np.asarray(np.linalg.cholesky(matrix), dtype=float)
            except np.linalg.LinAlgError:
                raise ConvergenceError(
                    f"the fields of viscoelastic layers are not resolved with {x.size} springs over {x[-1] / h:.4g} thicknesses of the top "
                    "layer; reduce the load"
                ) from None
            self._factors[key] = widths, lower, scipy.linalg.solve_triangular(lower, root, lower=True)
        return self._factors[key]

    def _read(self, state: MemoryState, step: int) -> LineState:
        springs = super()._read(state, step)
        if springs.position.size == 0:
            return springs
        widths, lower, unit = self._factor(springs.position)
        values = unit[:, None] * np.stack([springs.deflection, springs.load], axis=1)
        loads = scipy.linalg.solve_triangular(lower, values, lower=True, trans="T") / np.sqrt(widths)[:, None]
        deflection, load = loads.T
        h, position = self.layers.thickness, springs.position
        added = Added(self.layers.kernel, h, float(position[-1]), position / h, deflection * widths)
        # beyond the contact the superposed load is 0
        load = np.where(position < springs.radius, load, 0.0)
        return LayeredState(
            position, deflection, load, springs.radius, Coupled(self.layers.equivalent, added)
        )

    def _displacement(self, state: LineState, d: float, r: FloatArray) -> FloatArray:
        u = super()._displacement(state, d, r)
        outside = (r > state.radius) | (state.radius <= 0.0)
        if isinstance(state, LayeredState) and state.sunk is not None and outside.any():
            u[outside] = displacement(state, r[outside]) + state.sunk.sunk(r[outside])
        return u


def layered_memory_claims(
    names: Sequence[str],
    line: Line,
    depth: FloatArray,
    rows: tuple[BoolArray, BoolArray, BoolArray],
    check: tuple[MemoryCheck, str],
) -> dict[str, Claim]:
    """
    Claims of layers of one relaxation function, valid up to the first row whose contact is not a disk.

    Parameters
    ----------
    depth : ndarray
        Indentation of every row in m.
    rows : tuple of ndarray of bool
        Rows whose springs in contact are those of a disk, whose force is prescribed, and whose indentation is.
    check : tuple
        Check of pressures and gaps, and a further condition of the numbers.

    Notes
    -----
    A growing contact of bodies of one relaxation function has the pressure int phi(t - s) dp(s) of elastic contacts, which is not below 0
    where those are disks (Lee and Radok 1960). On a retreat the springs of stiffness dk at the height d0 carry any history, if
    contacts stay disks: their pressure is checked.
    """
    disk, *given = rows
    elastic = certify_disk(line, states_at_depth(line, np.maximum.accumulate(depth)))
    claims = memory_claims(names, disk & elastic.disk, given[0], given[1], *check)
    bodies, source = bodies_of(line)
    whole = (
        f"exact for {bodies} with one relaxation function in frictionless contact on a disk under any "
        "history; elastic contacts are disks up to the largest indentation"
    )
    return {
        name: replace(
            claim,
            reason=claim.reason.replace(
                "exact for viscoelastic half-spaces in frictionless contact on a disk under any history",
                whole,
            )
            + ("" if elastic.disk.all() else f"; later rows are not valid: {elastic.reason}"),
            source=source,
        )
        if claim.where.any()
        else claim
        for name, claim in claims.items()
    }
