"""Roots: against those of scipy, bit for bit."""

import numpy as np
import pytest
from scipy.optimize import elementwise

from pymdr.errors import ConvergenceError
from pymdr.numerics.roots import roots_of

FUNCTIONS = {
    "power": lambda x, y, n: np.sign(x) * np.abs(x) ** n - y,
    "saturating": lambda x, y, n: np.tanh(5.0 * x) - np.tanh(y),
    "flat at the root": lambda x, y, n: (x - y) ** 3,
    "jump": lambda x, y, n: np.where(x < y, -1.0, 1e-3 * (x - y)),
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_roots_are_those_of_scipy(name):
    rng = np.random.default_rng(1)
    for size in (1, 2, 40):
        scale = 10.0 ** rng.uniform(-12.0, 3.0, size)
        values, exponents = rng.uniform(-3.0, 3.0, size), rng.uniform(0.2, 6.0, size)

        def function(x, y, n, unit):
            return FUNCTIONS[name](x / unit, y, n)

        low, high, known = -200.0 * scale, 217.3 * scale, (values, exponents, scale)
        expected = elementwise.find_root(function, (low, high), args=known)
        assert expected.success.all()
        assert np.array_equal(roots_of(function, low, high, *known), expected.x)


def test_brackets_without_a_root_are_refused():
    with pytest.raises(ConvergenceError, match=r"no root between 2\.0 and 3\.0"):
        roots_of(lambda x, y: x - y, np.array([0.0, 2.0]), np.array([1.0, 3.0]), np.array([0.5, 1.0]))
    with pytest.raises(ConvergenceError, match="no root"):
        roots_of(lambda x: x * np.nan, np.zeros(1), np.ones(1))
