"""The first crossing of a sum of exponentials against dense samples of it."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit

from drawing import examples
from pymdr.compiling import call
from pymdr.numerics.exponentials import CROSSED, NEVER, first_crossing

ADDRESS = first_crossing.address(CROSSED, (0.0, 0.0), np.zeros((1, 3)), 0, 0.0)


@njit
def crossing_by(address, line, terms, begin):
    return call(address, CROSSED, (line, terms, len(terms), begin))


def crossing(line, terms, begin):
    return crossing_by(ADDRESS, line, terms, begin)


def values(line, terms, p):
    decaying, growing, rates = terms.T
    x = rates[:, None] * p
    grown = np.where(x > 0.0, -np.expm1(-x) / np.where(x > 0.0, x, 1.0), 1.0) * p
    return line[0] + line[1] * p + decaying @ np.exp(-x) + growing @ grown


@settings(deadline=None, max_examples=examples(80))
@given(st.integers(0, 5), st.floats(-3.0, 3.0), st.integers(0, 2**32 - 1))
def test_a_sum_crosses_first_where_dense_samples_do(terms, decades, seed):
    rng = np.random.default_rng(seed)
    f = np.zeros((terms, 3))
    f[:, 0], f[:, 1] = rng.normal(size=(2, terms))
    f[:, 2] = 10.0 ** (decades + rng.uniform(-2.0, 2.0, terms)) * (rng.random(terms) < 0.9)
    line = rng.normal(size=2)
    line[0] += max(0.0, 1e-3 - float(values(line, f, np.zeros(1))[0]))
    p = np.concatenate([[0.0], np.geomspace(1e-9, 1.0, 40001)])
    size = abs(line[0]) + np.abs(f[:, 0]).sum()
    below = p[values(line, f, p) < -1e-13 * size]
    result, _ = crossing((line[0], line[1]), f, 0.0)
    if result == NEVER:
        assert below.size == 0
        return
    assert values(line, f, np.array([result]))[0] <= 1e-12 * (size + np.abs(f[:, 1]).sum() + abs(line[1]))
    assert not (below < result * (1.0 - 1e-12)).any()
