"""Effective moduli and Dundurs' beta against references, limits and symmetries."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pymdr as mdr

MODULUS = st.floats(1e3, 1e13)
POISSON = st.floats(-0.99, 0.5)
materials = st.builds(mdr.Elastic, MODULUS, POISSON)


def test_steel_on_aluminium(references):
    reference = references["moduli_steel_alu"]
    i, e = reference["inputs"], reference["expected"]
    moduli = mdr.effective_moduli(mdr.Elastic(i["E1"], i["nu1"]), mdr.Elastic(i["E2"], i["nu2"]))
    assert moduli.normal == pytest.approx(e["E_star"], rel=1e-12)
    assert moduli.tangential == pytest.approx(e["G_star"], rel=1e-12)
    assert moduli.dundurs_beta == pytest.approx(e["dundurs_beta"], rel=1e-12)


def test_one_body_against_a_rigid_one():
    E, nu = 3.0, 0.2
    for moduli in (
        mdr.effective_moduli(mdr.Elastic(E, nu)),
        mdr.effective_moduli(mdr.Rigid(), mdr.Elastic(E, nu)),
    ):
        assert moduli.normal == pytest.approx(E / (1 - nu**2), rel=1e-15)
        assert moduli.tangential == pytest.approx(2 * E / ((1 + nu) * (2 - nu)), rel=1e-15)
        assert moduli.tangential / moduli.normal == pytest.approx(2 * (1 - nu) / (2 - nu), rel=1e-15)
        assert abs(moduli.dundurs_beta) == pytest.approx((1 - 2 * nu) / (2 * (1 - nu)), rel=1e-15)


def test_incompressible():
    body = mdr.Elastic(3.0, 0.5)
    moduli = mdr.effective_moduli(body)
    assert body.shear == pytest.approx(1.0, rel=1e-15)
    assert moduli.normal == pytest.approx(4.0, rel=1e-15)
    assert moduli.tangential == pytest.approx(8 / 3, rel=1e-15)
    assert moduli.dundurs_beta == 0.0
    assert moduli.similar


def test_equal_bodies_are_half_as_stiff_and_similar():
    body = mdr.Elastic("210 GPa", 0.3)
    alone, pair = mdr.effective_moduli(body), mdr.effective_moduli(body, body)
    assert pair.normal == pytest.approx(alone.normal / 2, rel=1e-15)
    assert pair.tangential == pytest.approx(alone.tangential / 2, rel=1e-15)
    assert pair.dundurs_beta == 0.0
    assert pair.similar
    assert not alone.similar


def test_different_bodies_of_equal_bulk_mismatch_are_similar():
    # (1 - 2 nu)/G is the same for both: nu 0.25, G 1 and nu 0, G 2
    moduli = mdr.effective_moduli(mdr.Elastic(2.5, 0.25), mdr.Elastic(4.0, 0.0))
    assert moduli.dundurs_beta == pytest.approx(0.0, abs=1e-16)
    assert moduli.similar


@settings(max_examples=40, deadline=None)
@given(materials, materials, st.floats(1e-9, 1e9))
def test_symmetries(one, other, factor):
    moduli, swapped = mdr.effective_moduli(one, other), mdr.effective_moduli(other, one)
    assert swapped.normal == pytest.approx(moduli.normal, rel=1e-14)
    assert swapped.tangential == pytest.approx(moduli.tangential, rel=1e-14)
    assert swapped.dundurs_beta == pytest.approx(-moduli.dundurs_beta, rel=1e-12, abs=1e-15)
    compliance = (1 - one.poisson**2) / one.young + (1 - other.poisson**2) / other.young
    assert moduli.normal == pytest.approx(1 / compliance, rel=1e-13)
    scaled = mdr.effective_moduli(
        mdr.Elastic(one.young * factor, one.poisson), mdr.Elastic(other.young * factor, other.poisson)
    )
    assert scaled.normal == pytest.approx(factor * moduli.normal, rel=1e-14)
    assert scaled.dundurs_beta == pytest.approx(moduli.dundurs_beta, rel=1e-9, abs=1e-14)
    if min(one.poisson, other.poisson) >= 0:
        assert abs(moduli.dundurs_beta) <= 0.5 + 1e-15


def test_a_very_stiff_counterbody_is_rigid():
    gel, diamond = mdr.Elastic("10 kPa", 0.45), mdr.Elastic("1e30 Pa", 0.1)
    assert mdr.effective_moduli(gel, diamond).normal == pytest.approx(
        mdr.effective_moduli(gel).normal, rel=1e-15
    )


def test_both_rigid_is_refused():
    with pytest.raises(mdr.ProblemError, match="both bodies are rigid"):
        mdr.effective_moduli(mdr.Rigid(), mdr.Rigid())
    with pytest.raises(mdr.ProblemError, match="both bodies are rigid"):
        mdr.effective_moduli(mdr.Rigid())


@pytest.mark.parametrize("young", [math.nan, math.inf, -math.inf, 0.0, -1.0, "0 Pa", "-3 GPa", "nan Pa"])
def test_bad_youngs_moduli(young):
    with pytest.raises(ValueError, match=r"Elastic\.young"):
        mdr.Elastic(young, 0.3)


@pytest.mark.parametrize("poisson", [-1.0, -1.5, 0.5000001, 0.6, math.nan, math.inf, "51 %", None])
def test_bad_poisson_ratios(poisson):
    with pytest.raises(ValueError, match=r"Elastic\.poisson"):
        mdr.Elastic(1.0, poisson)


@pytest.mark.parametrize("poisson", [-0.999999, 0.0, 0.5, "50 %"])
def test_poisson_ratios_at_their_limits(poisson):
    assert math.isfinite(mdr.effective_moduli(mdr.Elastic(1.0, poisson)).normal)
