"""Claims of a contact with adhesion, and its certificate as a disk."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pymdr.interpretation.certificate import Certificate
from pymdr.interpretation.disks import (
    TOLERANCE,
    ProfileFeatures,
    gap_ratios,
    least_gap,
    profile_features,
    touching_range,
)
from pymdr.interpretation.layers import first_fault
from pymdr.interpretation.theories import theory_of
from pymdr.interpretation.validity import NORMAL_FIELDS, Assumption, BoolArray, Claim, Level
from pymdr.line.adhesion.short_range import jkr_opening
from pymdr.line.curves import ElasticLine, Line
from pymdr.line.layered import LayeredLine
from pymdr.problem.laws import AdhesionLaw
from pymdr.units import FloatArray, metres

_NODES = 33
"""Radii on the curve of equilibria at which the least gap is evaluated before refinement."""
_HALVINGS = 30
_GAIN = 1e-9
"""Rounding error of the loss of a jump, over the energy of the surfaces."""
_SMALL = 1e-6
"""Least radius of the checked states of a jump to or from a free body, over its larger radius."""


@dataclass(frozen=True)
class Visited:
    """The states of a history of an adhesive contact, including those between its rows; radii in m, 0 for a free body."""

    row: np.ndarray
    """Row in which each smooth segment ends."""
    begin: FloatArray
    """Contact radius at its start."""
    end: FloatArray
    """Contact radius at its end."""
    jump_row: np.ndarray
    """Row of each jump."""
    stiffness: FloatArray
    """Stiffness in N/m of the machine equivalent to its control: inf for an indentation, 0 for a force."""
    control: FloatArray
    """Travel (or indentation) in m, or force in N, at the jump."""
    before: FloatArray
    """Contact radius before it."""
    after: FloatArray
    """Contact radius after it."""
    loss: FloatArray
    """Dissipated energy in J."""


def is_always_open(line: Line, law: AdhesionLaw) -> bool:
    """Whether surfaces never touch outside an adhesive contact; laws other than JKR need rising profiles."""
    return isinstance(line, ElasticLine) and (bool(line.equivalent.rises) or theory_of(law).rising)


def certify_stretched_disk(line: Line, visited: Visited, rows: int, law: AdhesionLaw) -> Certificate:
    """
    Check that the surfaces do not touch outside an adhesive contact: gap >= 0 with the stretched edge.

    Pressure is no criterion because tension is legitimate; that the contact has not opened inside is an assumption. The
    least gap is followed along the whole history, over all equilibria between the rows. The states within a jump are not
    equilibria: there the surfaces may touch, but only where they touch after it; and no jump may gain energy. After the
    first state that fails, the history depends on contact on a ring, and nothing is certified.

    Parameters
    ----------
    visited : Visited
        The states of the history.
    """
    disk = np.ones(rows, dtype=bool)
    if isinstance(line, LayeredLine):
        return _certify_layers(line, visited, disk, law)
    assert isinstance(line, ElasticLine)
    fault = None if is_always_open(line, law) else _first_fault(line, visited, law.work)
    if fault is None:
        return Certificate(disk, "")
    row, radius, excess, features = fault
    d = float(line.equivalent.g(np.array([radius]))[0]) + excess
    where = ""
    if features.radii[-1] > radius:
        touch = least_gap(features, radius, excess, loose=False)
        where = f", at r = {metres(touch.radius)}" if touch.value < 0.0 else ""
    return Certificate(
        np.arange(rows) < row,
        f"at d = {metres(d)} the surfaces touch again outside a disk of radius {metres(radius)}{where}, so the adhesive "
        "contact is not a disk; all later rows depend on it",
    )


def _certify_layers(line: LayeredLine, visited: Visited, disk: BoolArray, law: AdhesionLaw) -> Certificate:
    """Certify all rows before the first whose contact is wider than the last disk."""
    ends = (visited.begin, visited.end, visited.before, visited.after)
    widest = max(float(np.max(a, initial=0.0)) for a in ends)
    work = law.work if theory_of(law).opens else 0.0
    fault = first_fault(line, widest, work=work)
    if fault is None:
        return Certificate(disk, "")
    wide = [
        row[np.maximum(*pair) > fault.before]
        for row, pair in (
            (visited.row, (visited.begin, visited.end)),
            (visited.jump_row, (visited.before, visited.after)),
        )
    ]
    first = min(int(np.min(rows, initial=disk.size)) for rows in wide)
    return Certificate(
        np.arange(disk.size) < first,
        f"{fault.description}, so the adhesive contact is not a disk; all later rows depend on it",
    )


def _first_fault(
    line: ElasticLine, visited: Visited, work: float
) -> tuple[int, float, float, ProfileFeatures] | None:
    """Row, contact radius and compression of the edge of the first state whose surfaces touch outside the disk."""
    equivalent = line.equivalent
    jumps = np.stack(
        [visited.stiffness, visited.control, visited.before, visited.after, visited.loss], axis=1
    )
    _, first = np.unique(jumps, axis=0, return_index=True)
    paths = [_JumpPath(line, jumps[i], int(visited.jump_row[i])) for i in np.sort(first)]
    radii = np.concatenate([visited.begin, visited.end])
    radii = np.minimum(radii[radii > 0.0], equivalent.edge)
    if radii.size == 0:
        return None
    ends = np.array([radii.min(), radii.max()])
    stretched = line.depth(ends) - jkr_opening(line, ends, work)
    deepest = max([float(stretched.max()), *(path.deepest for path in paths)])
    widest = max([float(ends[1]), *(path.high for path in paths)])
    top = max(min(widest, equivalent.edge), touching_range(equivalent, deepest))
    features = profile_features(equivalent, top) if top > 0.0 else None
    if features is None:
        return None

    def opening(a: float) -> float:
        return -float(jkr_opening(line, a, work))

    earliest: tuple[int, float, float, ProfileFeatures] | None = None
    low, high = np.minimum(visited.begin, visited.end), np.maximum(visited.begin, visited.end)
    for bottom, peak in _negative(
        lambda a: _margin(features, a, opening(a)), float(ends[0]), float(ends[1]), features
    ):
        hit = np.flatnonzero((low <= peak) & (high >= bottom) & (high < equivalent.edge))
        if hit.size and (earliest is None or visited.row[hit[0]] < earliest[0]):
            a = float(np.clip(visited.begin[hit[0]], bottom, peak))
            earliest = int(visited.row[hit[0]]), a, opening(a), features
    for path in paths:
        if earliest is not None and path.row > earliest[0]:
            break
        if (radius := path.fault(features, work)) is not None:
            return path.row, radius, path.excess(radius), features
    return earliest


class _JumpPath:
    """The states of a jump at constant control, which are not equilibria."""

    def __init__(self, line: ElasticLine, jump: FloatArray, row: int) -> None:
        stiffness, control, before, after, loss = (float(x) for x in jump)
        self.line, self.stiffness, self.control, self.row = line, stiffness, control, row
        self.after, self.loss = after, loss
        self.high = min(max(before, after), line.equivalent.edge)
        self.low = max(min(before, after), _SMALL * self.high)

    def fault(self, features: ProfileFeatures, work: float) -> float | None:
        """A radius in m at which the surfaces touch outside the final disk, or at which energy would be gained."""
        if self.loss < -_GAIN * math.pi * work * self.high**2:
            return self.low
        radii = features.radii
        if not np.any(radii > self.after):
            return None
        g = features.equivalent.g(radii)

        def margin(a: float) -> float:
            excess = self.excess(a)
            outside = radii > a
            d = float(features.equivalent.g(np.array([a]))[0]) + excess
            if excess <= 0.0 and float(np.min(g[outside], initial=math.inf)) >= d:
                return 1.0
            r = radii[outside & (radii > self.after)]
            return float(np.min(gap_ratios(features, a, excess, r), initial=1.0)) + TOLERANCE

        bad = _negative(margin, self.low, self.high, features)
        return bad[0][0] if bad else None

    @property
    def deepest(self) -> float:
        """The largest indentation in m of the states."""
        a = np.linspace(self.low, self.high, _NODES)
        return max(float(self.line.equivalent.g(np.array([x]))[0]) + self.excess(float(x)) for x in a)

    def excess(self, a: float) -> float:
        """Compression d - d0(a) of the edge in m at a radius."""
        line, at = self.line, np.array([a])
        depth, force, stiffness = (float(f(at)[0]) for f in (line.depth, line.force, line.stiffness))
        if math.isinf(self.stiffness):
            return self.control - depth
        if self.stiffness == 0.0:
            return (self.control - force) / stiffness
        return (self.control - depth - force / self.stiffness) / (1.0 + stiffness / self.stiffness)


def _margin(features: ProfileFeatures, a: float, excess: float) -> float:
    """The least gap outside a disk on the curve of equilibria, over its indentation; 1 where g stays above d."""
    g = float(features.equivalent.g(np.array([a]))[0])
    d = g + excess
    beyond = features.radii[features.radii > a]
    if beyond.size == 0 or float(np.min(features.equivalent.g(beyond))) >= min(d, g):
        return 1.0
    return least_gap(features, a, excess, loose=False).value + TOLERANCE


def _negative(
    margin: Callable[[float], float], low: float, high: float, features: ProfileFeatures
) -> list[tuple[float, float]]:
    """
    Intervals between two radii in which a margin, a continuous function of the radius, is negative.

    It is evaluated at the ends of the decreasing intervals of g and between them. Its extremes are refined where its sign
    may change; the ends are bisected.
    """
    marks = [end for each in features.decreasing for end in (each.start, each.stop)]
    a = np.unique(np.concatenate([np.linspace(low, high, _NODES), [x for x in marks if low < x < high]]))
    values = np.array([margin(float(x)) for x in a])
    for i in range(1, a.size - 1):
        left, here, right = values[i - 1 : i + 2]
        turns = (here > 0.0 and left > here < right) or (here < 0.0 and left < here > right)
        # the extreme of a parabola through three points differs from the middle one by at most half of their span
        if turns and 1.5 * abs(here) < 0.5 * max(abs(left), abs(right)):
            x, y = _extreme(margin, a[i - 1], a[i], a[i + 1], here)
            a, values = np.append(a, x), np.append(values, y)
    order = np.argsort(a, kind="stable")
    a, values = a[order], values[order]
    bad = values < 0.0
    ends = [float(a[0])] if bad[0] else []
    for j in np.flatnonzero(bad[1:] != bad[:-1]).tolist():
        left, right = float(a[j]), float(a[j + 1])
        for _ in range(_HALVINGS):
            middle = 0.5 * (left + right)
            left, right = (middle, right) if (margin(middle) < 0.0) == bad[j] else (left, middle)
        ends.append(left if bad[j] else right)
    ends += [float(a[-1])] if bad[-1] else []
    return list(zip(ends[::2], ends[1::2], strict=True))


def _extreme(
    margin: Callable[[float], float], low: float, middle: float, high: float, value: float
) -> tuple[float, float]:
    """The extreme of a margin toward 0 between three radii, up to the first value beyond 0."""
    from scipy.optimize import minimize_scalar

    sign = 1.0 if value > 0.0 else -1.0
    # the tolerance is absolute, so radii are scaled
    result = minimize_scalar(
        lambda fraction: sign * margin(low + float(fraction) * (high - low)),
        bounds=(0.0, 1.0),
        method="bounded",
        options={"maxiter": _HALVINGS},
    )
    if not result.fun < sign * value:
        return middle, value
    return low + float(result.x) * (high - low), sign * float(result.fun)


def adhesive_claims(
    statement: tuple[Level, str, str], names: Sequence[str], disk: BoolArray, why: str
) -> dict[str, Claim]:
    """
    Claims of a contact with adhesion.

    Parameters
    ----------
    statement : tuple
        Level, reason and source of the law.
    disk : ndarray of bool
        Steps at which the disk is certified.
    why : str
        Why it is not certified at the other steps.
    """
    level, reason, source = statement
    if not disk.all():
        reason += f"; not valid at {int((~disk).sum())} of {disk.size} steps: {why}"
    if not disk.any():
        level, reason = Level.NOT_VALID, why
    claim = Claim(level, reason, source, disk)
    return dict.fromkeys((*names, *NORMAL_FIELDS), claim)


_KNOWN_AFTER_TEARING = ("external_work", "jumped", "jump_dissipation", "dissipated_energy")


def without_torn_rows(claims: Mapping[str, Claim], torn: BoolArray) -> dict[str, Claim]:
    """
    Claims without the steps after a dead load has separated the bodies: there is no equilibrium; energies are known.

    Parameters
    ----------
    torn : ndarray of bool
        Steps without a state.
    """
    if not torn.any():
        return dict(claims)
    remark = f"; not valid at {int(torn.sum())} of {torn.size} steps: a dead load has separated the bodies"
    return {
        name: claim
        if name in _KNOWN_AFTER_TEARING
        else replace(claim, where=claim.where & ~torn, reason=f"{claim.reason}{remark}")
        for name, claim in claims.items()
    }


def energy_assumption(residual: float, limit: float = 1e-8) -> Assumption:
    """The residual of the energy balance as an assumption; with memory, dissipation includes that of the bodies."""
    balance = "relative residual; work minus change of energy and dissipation" + " in jumps" * (limit <= 1e-8)
    return Assumption("energy balance", balance, residual, limit)
