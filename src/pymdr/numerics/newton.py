"""One step of a safeguarded Newton iteration, for kernels that search a root of a rising function. Loads numba."""

from __future__ import annotations

from pymdr.compiling import compiled


@compiled
def narrowed(low: float, high: float, x: float, excess: float, slope: float) -> tuple[float, float, float]:
    """
    Narrow a bracket by the value at x, and choose the next x.

    Parameters
    ----------
    low, high : float
        Bracket of the root of a rising function.
    x, excess, slope : float
        A point in it, the function there and its slope; 0 to halve the bracket.

    Returns
    -------
    low, high, next : float
        Newton's step where it stays inside the bracket, else the middle, which is an end of a bracket that cannot be
        halved.

    Examples
    --------
    >>> narrowed(0.0, 2.0, 2.0, 2.0, 4.0)
    (0.0, 2.0, 1.5)
    """
    if excess > 0.0:
        high = x
    else:
        low = x
    following = x - excess / slope if slope > 0.0 else low
    if not low < following < high:
        following = 0.5 * (low + high)
    return low, high, following
