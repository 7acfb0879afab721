"""Surfaces as heights on a grid."""

from __future__ import annotations

import numpy as np
import pint
import pytest

import pymdr as mdr
from pymdr.errors import ProblemError, UnitError

HEIGHTS = np.array([[0.0, 1.0, 2.0], [np.nan, 4.0, 5.0]])


@pytest.mark.parametrize(
    "heights",
    [
        lambda: HEIGHTS * 1e-9,
        lambda: (HEIGHTS * 1e-9).tolist(),
        lambda: np.ma.masked_invalid(HEIGHTS * 1e-9),
        lambda: pint.UnitRegistry().Quantity(HEIGHTS, "nm"),
    ],
    ids=["array", "list", "masked", "pint"],
)
def test_heights_in_any_form(heights):
    surface = mdr.Topography(heights(), ["2 um", "3 um"])
    assert surface == mdr.Topography(1e-9 * HEIGHTS, [2e-6, 3e-6])
    assert surface.missing.tolist() == [[False] * 3, [True, False, False]]
    assert surface.spacing == pytest.approx([1e-6, 1e-6], rel=1e-15)
    assert surface.x == pytest.approx([0.5e-6, 1.5e-6], rel=1e-15)
    assert surface.y == pytest.approx([0.5e-6, 1.5e-6, 2.5e-6], rel=1e-15)
    assert not surface.heights.flags.writeable


def test_steps_are_recorded():
    surface = mdr.Topography(HEIGHTS * 1e-9, "2 um", ("read", "levelled"))
    assert surface != mdr.Topography(HEIGHTS * 1e-9, "2 um")
    assert "6 values from 0 m to 5 nm" in surface._repr_html_()
    with pytest.raises(ProblemError, match="a tuple of texts"):
        mdr.Topography(HEIGHTS, "2 um", ["read"])


@pytest.mark.parametrize(
    ("heights", "size", "kind", "words"),
    [
        ([1.0, 2.0], "1 um", ProblemError, "a matrix of at least 2 x 2 heights is needed"),
        ([[1.0, 2.0]], "1 um", ProblemError, "a matrix of at least 2 x 2 heights is needed"),
        (np.full((2, 2), np.nan), "1 um", ProblemError, "all heights are missing"),
        ([[0.0, np.inf], [0.0, 1.0]], "1 um", UnitError, r"heights\[0, 1\] is not finite"),
        ([["1 nm", "2 nm"], ["3 N", "4 nm"]], "1 um", UnitError, "N"),
        (HEIGHTS, "1 N", UnitError, "N"),
        (HEIGHTS, -1.0, ProblemError, "side of a square or a pair of sides, above 0 m"),
        (1e80 * HEIGHTS, 1.0, ProblemError, "at most 1e[+]60 m"),
    ],
)
def test_what_is_no_surface(heights, size, kind, words):
    with pytest.raises(kind, match=words):
        mdr.Topography(heights, size)
