"""
Integrals over the slip of a spring that turns while its limit changes, in closed form. Loads numba.

With q = tan(theta / 2)^2, which falls as exp(-2 tau), the lost part 1 - cos(theta) dtau is -dq / (1 + q), and the limit is a power of q.
On 0 <= q <= 1 a polynomial replaces 1 / (1 + q), to rounding; beyond, 1 / q takes the place of q.
"""

from __future__ import annotations

import math

from numpy.polynomial import Chebyshev, Polynomial

from pymdr.compiling import Fused

_DEGREE = 19
_RATIO = -1.0 / (3.0 + math.sqrt(8.0))
_TERMS = tuple(
    Chebyshev([math.sqrt(2.0) * _RATIO**n * (0.5 if n == 0 else 1.0) for n in range(_DEGREE + 1)], [0, 1])
    .convert(kind=Polynomial)
    .coef.tolist()
)
"""Powers of q in 1 / (1 + q): its Chebyshev series, whose terms fall as _RATIO^n."""
_NEGLIGIBLE = 1e-17

inner = Fused(__file__).inner
_Pair = tuple[float, float]


@inner
def _powers(high: float, at_high: _Pair, low: float, at_low: _Pair, first: _Pair, span: float) -> _Pair:
    """Two sums over j of the terms times (high^j at_high - low^j at_low) / (j + first), of which the second is the first times exp(-span (j + first))."""
    one = two = 0.0
    up = down = 1.0
    for j in range(len(_TERMS)):
        g, h = j + first[0], j + first[1]
        if abs(span * g) > 0.5:
            one += _TERMS[j] * (up * at_high[0] - down * at_low[0]) / g
        else:
            one += _TERMS[j] * down * at_low[0] * (span if g == 0.0 else math.expm1(span * g) / g)
        if abs(span * h) > 0.5:
            two += _TERMS[j] * (up * at_high[1] - down * at_low[1]) / h
        else:
            two += _TERMS[j] * down * at_low[1] * (span if h == 0.0 else math.expm1(span * h) / h)
        up *= high
        down *= low
        if up < _NEGLIGIBLE:
            break
    return one, two


@inner
def slip_integrals(tau: float, near: float, far: float, m: float, alpha: float) -> _Pair:
    """
    Integrals of (1 - cos(theta)) m^k dtau over a slip, for k = 1 and 2.

    `far` over `near` is tan(theta_0 / 2)^2; m grows as exp(alpha tau).
    """
    first = second = 0.0
    start = far / near if far <= near else 1.0
    if far > near:
        inverse = near / far
        span = min(-0.5 * math.log(inverse), tau) if inverse > 0.0 else tau
        later, end = m * math.exp(alpha * span), min(inverse * math.exp(2.0 * span), 1.0)
        first, second = _powers(
            end, (later, later * later), inverse, (m, m * m), (0.5 * alpha, alpha), 2.0 * span
        )
        tau, m = tau - span, later
        if not tau > 0.0:
            return first, second
    later, end = m * math.exp(alpha * tau), start * math.exp(-2.0 * tau)
    one, two = _powers(
        start,
        (start * m, start * m * m),
        end,
        (end * later, end * later * later),
        (1.0 - 0.5 * alpha, 1.0 - alpha),
        2.0 * tau,
    )
    return first + one, second + two
