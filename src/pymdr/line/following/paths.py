"""Follow a path on a folding curve: jumps, attachment, and their energies."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass
from operator import neg

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pymdr.errors import PathError
from pymdr.line.following.tracks import END, FREE, Index, Track, jump_energies
from pymdr.numerics.roots import roots_of
from pymdr.units import FloatArray

_UP, _DOWN, _TOUCH = range(3)


@dataclass(frozen=True)
class Route:
    """The route of a contact from branch to branch while D increases or decreases.

    Attributes
    ----------
    begin, end : ndarray
        Parameters between which the contact moves smoothly, one pair for every branch of the route.
    branch : int
        The last branch.
    loss : float
        Energy dissipated in the final jump out of contact [J]; 0 without one.
    """

    begin: FloatArray
    end: FloatArray
    branch: int
    loss: float = 0.0

    @property
    def last(self) -> float:
        """Parameter of the last stable state."""
        return float(self.end[-1])


def pressed(track: Track, measure: Callable[[FloatArray], FloatArray], target: float) -> Route:
    """Return the route from the first touch to the first state with measure(s) >= target, as D increases.

    Parameters
    ----------
    track : Track
        The curve, traced.
    measure : callable
        A quantity of the states that rises along the stable branches.
    target : float
        Target value of that quantity.

    Raises
    ------
    PathError
        When the known curve ends before the target.

    Examples
    --------
    >>> import numpy as np
    >>> from pymdr.line.following import Curve, trace
    >>> wave = Curve(lambda s: s + 2 * np.sin(s), lambda s: 1 + 2 * np.cos(s),
    ...              lambda s: 2 * np.sin(s)**2 + 2 - 2 * np.cos(s), start=0.0, stop=12.0)
    >>> route = pressed(trace(wave), lambda s: s, 3.0)
    >>> route.branch, bool(abs(route.last + 2 * np.sin(route.last) - 2 * np.pi / 3 - np.sqrt(3)) < 1e-12)
    (1, True)
    """
    out = track.jumps[_TOUCH]
    branch, s = int(out.to[0]), float(out.after[0])
    begin: list[float] = []
    end: list[float] = []
    while branch != END:
        here, top = np.array([s]), track.top[branch : branch + 1]
        begin.append(s)
        if measure(here)[0] >= target:
            return Route(np.array(begin), np.array([*end, s]), branch)
        if measure(top)[0] >= target:
            s = float(roots_of(lambda x: measure(x) - target, here, top)[0])
            return Route(np.array(begin), np.array([*end, s]), branch)
        end.append(float(top[0]))
        out = track.jumps[_UP]
        branch, s = int(out.to[branch]), float(out.after[branch])
    raise PathError("the known curve ends before the target state; extend the profile")


def pulled(track: Track, branch: int | None, parameter: float) -> Route:
    """Return the route of a contact from a state to its loss, as D decreases.

    Parameters
    ----------
    track : Track
        The curve, traced.
    branch : int or None
        Branch of a stable state; None for an edge that rests until D has fallen to its curve, where it may be unstable.
    parameter : float
        Its parameter.

    Examples
    --------
    >>> import numpy as np
    >>> from pymdr.line.following import Curve, trace
    >>> wave = Curve(lambda s: s + 2 * np.sin(s), lambda s: 1 + 2 * np.cos(s),
    ...              lambda s: 2 * np.sin(s)**2 + 2 - 2 * np.cos(s), start=0.0, stop=12.0)
    >>> route = pulled(trace(wave), 1, 7.0)
    >>> np.allclose(route.end, [4 * np.pi / 3, 0.0]), route.branch
    (True, 0)
    """
    out = track.jumps[_DOWN]
    begin, end = [], []
    if branch is None:
        branch, event = _placed(track, parameter, -np.inf)
        if event is not None:
            begin, end = [parameter], [parameter]
            if branch == FREE:
                return Route(np.array(begin), np.array(end), FREE, float(event.loss[0]))
            parameter = float(event.after[0])
    begin.append(parameter)
    end.append(float(track.bottom[branch]))
    while (to := int(out.to[branch])) != FREE:
        begin.append(float(out.after[branch]))
        end.append(float(track.bottom[to]))
        branch = to
    return Route(np.array(begin), np.array(end), branch, float(out.loss[branch]))


@dataclass(frozen=True)
class Jumps:
    """The jumps of a history in their order.

    Attributes
    ----------
    step : ndarray of int
        Row of the path of each jump.
    control : ndarray
        D of the jump.
    before, after : ndarray
        The parameter before and after; NaN for a free body.
    loss : ndarray
        Energy dissipated [J].
    """

    step: Index
    control: FloatArray
    before: FloatArray
    after: FloatArray
    loss: FloatArray


@dataclass(frozen=True)
class History:
    """The states of a path, one entry per row.

    Attributes
    ----------
    control : ndarray
        D.
    parameter : ndarray
        s of the state; NaN for a free body.
    branch : ndarray of int
        The stable branch; -1 for a free body.
    attached : ndarray of bool
        Whether the bodies are in contact (or in the range of cohesion) at the end of the step.
    jumped : ndarray of bool
        Whether the state jumped inside the step.
    dissipated : ndarray
        Energy dissipated inside the step [J].
    jumps : Jumps
        Every jump.
    initial : float
        The parameter before the first step; NaN for a free body.
    """

    control: FloatArray
    parameter: FloatArray
    branch: Index
    attached: NDArray[np.bool_]
    jumped: NDArray[np.bool_]
    dissipated: FloatArray
    jumps: Jumps
    initial: float


def follow(track: Track, control: ArrayLike, initial: float | None = None) -> History:
    """Follow a path of the control coordinate, straight between its values.

    Parameters
    ----------
    track : Track
        The curve, traced.
    control : array_like
        Values of D, one per step; the first is reached from the state before.
    initial : float, optional
        Parameter of the state before the first step; a free body by default. An unstable one jumps in the
        direction in which the first step leaves it.

    Returns
    -------
    History
        The states; folds and jumps inside steps are located exactly, so that steps may be of any size.

    Raises
    ------
    PathError
        For a path that is empty, not finite, or goes beyond the end of the curve.

    Examples
    --------
    >>> import numpy as np
    >>> from pymdr.line.following import Curve, trace
    >>> wave = Curve(lambda s: s + 2 * np.sin(s), lambda s: 1 + 2 * np.cos(s),
    ...              lambda s: 2 * np.sin(s)**2 + 2 - 2 * np.cos(s), start=0.0, stop=12.0)
    >>> history = follow(trace(wave), [1.0, 4.0, 4.5, 1.0, -0.1])
    >>> history.jumped, history.attached
    (array([False,  True, False,  True, False]), array([ True,  True,  True,  True, False]))
    """
    D = np.array(control, dtype=np.float64)
    if D.ndim != 1 or D.size == 0 or not np.all(np.isfinite(D)):
        raise PathError("a path must be a one-dimensional array of at least one value, all finite")
    state, event = (FREE, None) if initial is None else _placed(track, float(initial), float(D[0]))
    # index -1 is the free body
    lows = [*track.low.tolist(), -np.inf]
    highs = [*track.high.tolist(), float(np.nextafter(track.touch, -np.inf))]
    targets = [transition.to.tolist() for transition in track.jumps]
    first = state
    steps: list[int] = []
    kinds: list[int] = []
    origins: list[int] = []
    states: list[int] = []
    low, high = lows[state], highs[state]
    step, exits = 0, Exits(D)
    while (step := exits.after(step, low, high)) < D.size:
        value = float(D[step])
        while not low <= value <= high:
            kind, origin = (_TOUCH, 0) if state == FREE else (_UP if value > high else _DOWN, state)
            state = targets[kind][origin]
            if state == END:
                raise PathError(
                    f"step {step}: control value {value!r} is beyond the end of the known curve, "
                    f"{track.high.max()!r}; extend the profile or shorten the path"
                )
            low, high = lows[state], highs[state]
            steps.append(step)
            kinds.append(kind)
            origins.append(origin)
            states.append(state)
    jumps = _events(track, steps, kinds, origins, event)
    marks = np.array([0, *steps, D.size], dtype=np.intp)
    branch = np.repeat(np.array([first, *states], dtype=np.intp), np.diff(marks))
    attached = branch >= 0
    parameter = np.full(D.size, np.nan)
    parameter[attached] = track.parameters(branch[attached], D[attached])
    return History(
        D,
        parameter,
        branch,
        attached,
        np.bincount(jumps.step, minlength=D.size) > 0,
        np.bincount(jumps.step, weights=jumps.loss, minlength=D.size).astype(np.float64),
        jumps,
        np.nan if initial is None else float(initial),
    )


class Exits:
    """The rows at which a path leaves an interval, from its monotone runs, each of which may leave only at its end."""

    def __init__(self, values: FloatArray) -> None:
        self.values = values
        self.up = self._directions(values)
        self.ends = np.append(np.flatnonzero(self.up[1:] != self.up[:-1]) + 1, values.size - 1)
        self.levels = values[self.ends]

    @staticmethod
    def _directions(values: FloatArray) -> NDArray[np.bool_]:
        """Whether the path goes up to each next row; a repeated row continues as before, and up at the start."""
        moves = np.diff(values)
        last = np.maximum.accumulate(np.where(moves != 0.0, np.arange(moves.size), 0))
        return np.asarray(moves[last] >= 0.0)

    def turn(self, step: int, *, upward: bool) -> int:
        """Return the index after the rows from `step` on that continue in one direction."""
        # the row itself may be the end, or a first row the start, of a run in the other direction
        if step + 1 == self.values.size or self.up[step] != upward:
            return step + 1
        return int(self.ends[self.ends.searchsorted(step + 1)]) + 1

    def after(self, step: int, low: float, high: float) -> int:
        """Return the first index from `step` on whose value is outside low ... high, or the size."""
        if not low <= self.values[step] <= high:
            return step
        run, block = int(self.ends.searchsorted(step)), 16
        while run < self.ends.size:
            part = self.levels[run : run + block]
            outside = (part < low) | (part > high)
            at = int(outside.argmax())
            if outside[at]:
                first = step if at == 0 and block == 16 else int(self.ends[run + at - 1])
                last = int(self.ends[run + at]) + 1
                if part[at] > high:
                    return bisect_right(self.values, high, first, last)
                return bisect_right(self.values, -low, first, last, key=neg)
            run += block
            block = min(4 * block, 16384)
        return int(self.values.size)


def _placed(track: Track, s: float, value: float) -> tuple[int, Jumps | None]:
    """Return the branch of an initial state, and the jump if the state is unstable."""
    curve = track.curve
    if not curve.start <= s <= curve.stop:
        raise PathError(f"the initial state {s!r} is outside the curve, {curve.start!r} ... {curve.stop!r}")
    here = np.flatnonzero((track.bottom <= s) & (s <= track.top))
    if here.size:
        return int(here[-1]), None
    at = curve.control(np.array([s]))
    if value >= at[0]:
        beyond = np.flatnonzero((track.bottom > s) & (track.high >= at[0]))[:1]
    else:
        beyond = np.flatnonzero((track.top < s) & (track.low <= at[0]))[-1:]
    to = beyond if beyond.size else np.array([END if value >= at[0] else FREE])
    if to[0] == END:
        raise PathError(
            f"the initial state {s!r} grows beyond the end of the known curve; extend the profile"
        )
    after = np.full(1, curve.start)
    if to[0] >= 0:
        after = roots_of(lambda x, D: curve.control(x) - D, track.bottom[to], track.top[to], at)
    before = np.array([s])
    loss = curve.energy(before) - jump_energies(curve, to, at, after)
    shown = after if to[0] >= 0 else np.full(1, np.nan)
    return int(to[0]), Jumps(np.zeros(1, dtype=np.intp), at, before, shown, loss)


def _events(
    track: Track, steps: list[int], kinds: list[int], origins: list[int], event: Jumps | None
) -> Jumps:
    """Return the jumps of a history, without smooth attachment and detachment."""
    kind, origin = np.array(kinds, dtype=np.intp), np.array(origins, dtype=np.intp)
    step = np.array(steps, dtype=np.intp)
    control, before, after, loss = (np.zeros(step.size) for _ in range(4))
    free = np.zeros(step.size, dtype=np.bool_)
    for k, table in enumerate(track.jumps):
        at = kind == k
        control[at], loss[at] = table.control[origin[at]], table.loss[origin[at]]
        before[at], after[at] = table.before[origin[at]], table.after[origin[at]]
        free[at] = table.to[origin[at]] == FREE
    real = (before != after) | (loss != 0.0)
    before[kind == _TOUCH] = np.nan
    after[free] = np.nan
    columns = [x[real] for x in (step, control, before, after, loss)]
    if event is not None:
        first = (event.step, event.control, event.before, event.after, event.loss)
        columns = [np.concatenate(pair) for pair in zip(first, columns, strict=True)]
    return Jumps(*columns)


@dataclass(frozen=True)
class Balance:
    """The energy balance of a history, cumulative, one entry per step.

    Attributes
    ----------
    energy : ndarray
        Potential T of the states [J].
    work : ndarray
        Work of the control, int F dD (under force control -int d dF) [J].
    dissipated : ndarray
        Energy lost in jumps [J].
    """

    energy: FloatArray
    work: FloatArray
    dissipated: FloatArray


def energy_balance(track: Track, history: History) -> Balance:
    """Return the energy, the work of the control and the dissipation along a history.

    Parameters
    ----------
    track : Track
        The curve, traced.
    history : History
        The history by `follow`.

    Returns
    -------
    Balance
        Exact for any number of steps (NaN after pull-off under a dead load): between two jumps the work of the control is
        T(end) - T(begin), so that work = T - T(initial) + dissipation without quadrature.

    Examples
    --------
    >>> import numpy as np
    >>> from pymdr.line.following import Curve, trace
    >>> spring = Curve(lambda s: s, np.ones_like, lambda s: s**2 / 2, start=0.0, stop=5.0)
    >>> track = trace(spring)
    >>> energy_balance(track, follow(track, [2.0, 4.0])).work
    array([2., 8.])
    """
    curve = track.curve
    energy = np.zeros(history.control.size)
    for i in np.flatnonzero(~history.attached):
        energy[i] = curve.free_energy(float(history.control[i]))
    energy[history.attached] = curve.energy(history.parameter[history.attached])
    before = 0.0 if np.isnan(history.initial) else float(curve.energy(np.array([history.initial]))[0])
    dissipated = np.cumsum(history.dissipated)
    return Balance(energy, energy - before + dissipated, dissipated)
