"""Effective moduli and Dundurs' beta against references, limits and symmetries."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

import pymdr as mdr
from drawing import examples
from pymdr.mapping.moduli import grading_factor, surface_compliances

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


@settings(max_examples=examples(40), deadline=None)
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
    with pytest.raises(ValueError, match=r"^young"):
        mdr.Elastic(young, 0.3)


@pytest.mark.parametrize("poisson", [-1.0, -1.5, 0.5000001, 0.6, math.nan, math.inf, "51 %", None])
def test_bad_poisson_ratios(poisson):
    with pytest.raises(ValueError, match=r"^poisson"):
        mdr.Elastic(1.0, poisson)


@pytest.mark.parametrize("poisson", [-0.999999, 0.0, 0.5, "50 %"])
def test_poisson_ratios_at_their_limits(poisson):
    assert math.isfinite(mdr.effective_moduli(mdr.Elastic(1.0, poisson)).normal)


# --- transversely isotropic bodies -----------------------------------------------------------------------


@pytest.mark.parametrize("name", ["TI_zinc", "TI_apatite_like"])
def test_transversely_isotropic_references(references, name):
    reference = references[name]
    moduli = mdr.effective_moduli(mdr.TransverselyIsotropic(**reference["inputs"]))
    assert moduli.normal == pytest.approx(reference["expected"]["E_star"], rel=1e-12)
    assert moduli.tangential == pytest.approx(reference["expected"]["G_star"], rel=1e-12)
    assert moduli.exponent == 0.0


def stiffness_matrix(c11, c33, c13, c44, c66):
    """Voigt's matrix with the axis 3."""
    c12 = c11 - 2 * c66
    matrix = np.diag([c11, c11, c33, c44, c44, c66])
    matrix[0, 1] = matrix[1, 0] = c12
    matrix[:2, 2] = matrix[2, :2] = c13
    return matrix


def compliance_of_waves(matrix):
    """Displacements by tractions e^(iqx) on the plane z = 0 of a half-space, times q (Stroh, 1962)."""
    voigt = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])
    tensor = matrix[voigt[:, :, None, None], voigt[None, None, :, :]]
    q, r, t = tensor[:, 0, :, 0], tensor[:, 0, :, 2], tensor[:, 2, :, 2]
    inverse = np.linalg.inv(t)
    fundamental = np.block([[-inverse @ r.T, inverse], [r @ inverse @ r.T - q, -r @ inverse]])
    roots, vectors = np.linalg.eig(fundamental)
    decaying = vectors[:, roots.imag > 0]
    assert decaying.shape[1] == 3
    return 1j * decaying[:3] @ np.linalg.inv(decaying[3:])


STIFFNESS = st.floats(0.05, 20.0)


@settings(max_examples=examples(150), deadline=None)
@given(STIFFNESS, STIFFNESS, STIFFNESS, STIFFNESS, st.floats(-0.95, 0.95), st.floats(1e-6, 1e12))
def test_transversely_isotropic_surfaces_against_waves(bulk, c33, c44, c66, fraction, unit):
    c13 = fraction * math.sqrt(bulk * c33)
    values = {"c11": bulk + c66, "c33": c33, "c13": c13, "c44": c44, "c66": c66}
    expected = compliance_of_waves(stiffness_matrix(**values))
    # the eigenvectors are lost where two roots meet, as in isotropic bodies
    again = compliance_of_waves(stiffness_matrix(**{**values, "c44": c44 * (1 + 1e-9)}))
    assume(np.max(np.abs(again - expected)) < 3e-9 * np.max(np.abs(expected)))
    computed = surface_compliances(mdr.TransverselyIsotropic(**{k: v * unit for k, v in values.items()}))
    size = np.max(np.abs(expected))
    assert 2 * unit * computed.normal == pytest.approx(expected[2, 2].real, rel=1e-9, abs=1e-9 * size)
    assert 2 * unit * computed.longitudinal == pytest.approx(expected[0, 0].real, rel=1e-9, abs=1e-9 * size)
    assert 2 * unit * computed.transverse == pytest.approx(expected[1, 1].real, rel=1e-9, abs=1e-9 * size)
    assert unit * computed.coupling == pytest.approx(abs(expected[0, 2]), rel=1e-9, abs=1e-9 * size)


def by_engineering(body):
    return mdr.TransverselyIsotropic(
        young_plane=body.young,
        young_axis=body.young,
        poisson_plane=body.poisson,
        poisson_axis=body.poisson,
        shear_axis=body.shear,
    )


def by_stiffnesses(body):
    c13 = 2 * body.shear * body.poisson / (1 - 2 * body.poisson)
    c11 = c13 + 2 * body.shear
    return mdr.TransverselyIsotropic(c11=c11, c33=c11, c13=c13, c44=body.shear, c66=body.shear)


def assert_same(computed, expected, rel=1e-12):
    assert computed.normal == pytest.approx(expected.normal, rel=rel)
    assert computed.tangential == pytest.approx(expected.tangential, rel=rel)
    assert computed.dundurs_beta == pytest.approx(expected.dundurs_beta, abs=rel)


@settings(max_examples=examples(150), deadline=None)
@given(MODULUS, st.one_of(POISSON, st.sampled_from([0.5, 0.4999999, 0.49, 0.0])), materials)
def test_the_isotropic_limit(young, poisson, other):
    isotropic = mdr.Elastic(young, poisson)
    assert_same(
        mdr.effective_moduli(by_engineering(isotropic), other), mdr.effective_moduli(isotropic, other)
    )
    if poisson < 0.49:
        assert_same(
            mdr.effective_moduli(by_stiffnesses(isotropic), other), mdr.effective_moduli(isotropic, other)
        )


def test_a_body_that_keeps_its_volume():
    # muscle: stiffer along its fibres; poisson_plane = 1 - E_p/(2 E_a) and poisson_axis = 1/2
    tissue = {"young_axis": 30e3, "poisson_axis": 0.5, "shear_axis": 8e3}
    kept = mdr.TransverselyIsotropic(young_plane=10e3, poisson_plane=1 - 10 / 60, **tissue)
    nearly = mdr.TransverselyIsotropic(
        young_plane=10e3, poisson_plane=1 - 10 / 60, **{**tissue, "poisson_axis": 0.5 - 1e-9}
    )
    moduli = mdr.effective_moduli(kept)
    assert moduli.similar
    assert_same(moduli, mdr.effective_moduli(nearly), rel=1e-8)


def test_engineering_constants_are_those_of_the_stiffnesses():
    young_plane, young_axis, poisson_plane, poisson_axis, shear_axis = 120e9, 35e9, -0.06, 0.26, 38e9
    compliance = np.diag([1 / young_plane, 1 / young_plane, 1 / young_axis])
    compliance[0, 1] = compliance[1, 0] = -poisson_plane / young_plane
    compliance[:2, 2] = compliance[2, :2] = -poisson_axis / young_axis
    stiffness = np.linalg.inv(compliance)
    body = mdr.TransverselyIsotropic(
        young_plane=young_plane,
        young_axis=young_axis,
        poisson_plane=poisson_plane,
        poisson_axis=poisson_axis,
        shear_axis=shear_axis,
    )
    expected = (stiffness[0, 0], stiffness[2, 2], stiffness[0, 2], shear_axis, young_plane / 2 / 0.94)
    assert body.stiffnesses == pytest.approx(expected, rel=1e-13)
    again = mdr.TransverselyIsotropic(**body.stiffnesses._asdict())
    assert again.axial_modulus == pytest.approx(young_axis, rel=1e-13)
    assert_same(mdr.effective_moduli(again), mdr.effective_moduli(body))


# --- graded bodies ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["hN_0.2_0.3", "hN_0.5_0.25"])
def test_grading_references(references, name):
    reference = references[name]
    result = grading_factor(reference["inputs"]["k"], reference["inputs"]["nu"])
    assert result == pytest.approx(reference["expected"]["h_N"], rel=1e-13)


def compliance_under_waves(k, nu):
    """Displacements by tractions e^(ix) on a half-space with G = z^k, integrated upward from where it is at rest."""
    ratio = nu / (1 - nu)
    spin, turn = np.array([[0, 1], [-ratio, 0]]), np.array([[0, ratio], [-1, 0]])

    def rise(log_depth, y):
        z = math.exp(log_depth)
        shear = z**k
        across, y = y[4], y[:4].reshape(2, 2)
        soft = np.diag([1 / shear, (1 - 2 * nu) / (2 * shear * (1 - nu))])
        stiff = np.diag([2 * shear / (1 - nu), 0])
        plane = soft + spin @ y - y @ turn - y @ stiff @ y
        return z * np.append(plane.ravel(), 1 / shear - shear * across**2)

    top, bottom = math.log(1e-18), math.log(20.0)
    start = [-1.0, 0.0, 0.0, -1.0, -1.0]
    y = -solve_ivp(rise, (bottom, top), start, method="LSODA", rtol=1e-10, atol=1e-12).y[:, -1]
    return y[3], y[0], y[4], abs(y[1])


@pytest.mark.parametrize("k", [-0.4, -0.1, 0.2, 0.5])
@pytest.mark.parametrize("nu", [-0.5, 0.0, 0.3, 0.5])
def test_graded_surfaces_against_the_differential_equations(k, nu):
    normal, longitudinal, transverse, coupling = compliance_under_waves(k, nu)
    result = surface_compliances(mdr.Graded(young=2 * (1 + nu), depth=1.0, exponent=k, poisson=nu))
    wave = math.cos(k * math.pi / 2) * math.gamma((1 - k) / 2) / math.gamma((1 + k) / 2) * 2 ** (1 - k)
    assert wave * result.normal == pytest.approx(normal, rel=1e-6)
    assert wave * result.longitudinal == pytest.approx(longitudinal, rel=1e-6)
    assert wave * result.transverse == pytest.approx(transverse, rel=1e-6)
    assert wave * abs(result.coupling) / 2 == pytest.approx(coupling, rel=1e-6)


@pytest.mark.parametrize("k", [-0.4, 0.3])
def test_the_springs_carry_a_flat_punch_on_a_graded_body(k):
    # p = c d (a^2 - r^2)^((k - 1)/2) / pi is what springs c |x|^k under a flat punch stand for; a point load gives
    # A/s^(1 + k), whose transform is that of a wave
    body = mdr.Graded(young=2.6, depth=1.0, exponent=k, poisson=0.3)
    c = mdr.effective_moduli(body).normal
    transform = math.pi * 2 ** (1 - k) * math.gamma((1 - k) / 2) / math.gamma((1 + k) / 2)
    point = compliance_under_waves(k, 0.3)[0] / transform

    def displacement(t):  # at the centre, r = sin t
        return 2 * point * c * math.sin(t) ** -k * math.cos(t) ** k

    assert quad(displacement, 0, math.pi / 2, limit=200)[0] == pytest.approx(1.0, rel=1e-6)


@settings(max_examples=examples(100), deadline=None)
@given(MODULUS, POISSON, st.floats(1e-6, 1e3), st.floats(-0.99, 0.99), st.floats(0.01, 100.0))
def test_a_modulus_may_be_given_at_any_depth(young, poisson, depth, exponent, factor):
    one = mdr.Graded(young, depth, exponent, poisson)
    other = mdr.Graded(young * factor**exponent, depth * factor, exponent, poisson)
    result = mdr.effective_moduli(one)
    assert result.exponent == exponent
    assert_same(mdr.effective_moduli(other), result)
    pair = mdr.effective_moduli(one, other)
    assert pair.normal == pytest.approx(result.normal / 2, rel=1e-12)
    assert pair.similar


@settings(max_examples=examples(100), deadline=None)
@given(MODULUS, POISSON, st.floats(1e-6, 1e3), materials)
def test_the_homogeneous_limit(young, poisson, depth, other):
    elastic, graded = mdr.Elastic(young, poisson), mdr.Graded(young, depth, 0.0, poisson)
    assert_same(mdr.effective_moduli(graded, other), mdr.effective_moduli(elastic, other))
    expected = surface_compliances(elastic)
    for name in ("normal", "longitudinal", "transverse", "coupling"):
        below, above = (
            getattr(surface_compliances(mdr.Graded(young, 1.0, k, poisson)), name) for k in (-1e-9, 1e-9)
        )
        size = getattr(expected, name) if name != "coupling" else expected.normal
        assert (below + above) / 2 == pytest.approx(getattr(expected, name), abs=1e-12 * size)
        assert (
            abs(above - below) < 2e-7 * size
        )  # first order in the exponent; the factor grows toward nu = -1


@settings(max_examples=examples(200), deadline=None)
@given(st.floats(-1, 1, exclude_min=True, exclude_max=True), POISSON)
def test_every_grading_has_springs(exponent, poisson):
    moduli = mdr.effective_moduli(mdr.Graded(1.0, 1.0, exponent, poisson))
    assert 0 < moduli.normal < math.inf
    assert 0 < moduli.tangential < math.inf
    assert math.isfinite(moduli.dundurs_beta)


@pytest.mark.parametrize("exponent", [0.1, 0.5, 0.9])
def test_a_graded_body_alone_is_similar_to_a_rigid_one_at_one_poisson_ratio(exponent):
    assert mdr.effective_moduli(mdr.Graded(1.0, 1.0, exponent, 1 / (2 + exponent))).similar
    assert not mdr.effective_moduli(mdr.Graded(1.0, 1.0, exponent, 0.5)).similar


@pytest.mark.parametrize(
    "other", [mdr.Elastic(1.0, 0.3), mdr.Graded(1.0, 1.0, 0.3, 0.3), by_engineering(mdr.Elastic(1.0, 0.3))]
)
def test_different_exponents_are_refused(other):
    graded = mdr.Graded(1.0, 1.0, 0.2, 0.3)
    for pair in ((graded, other), (other, graded)):
        with pytest.raises(mdr.ProblemError, match=r"exponents, .*0\.2.*, have no common line of springs"):
            mdr.effective_moduli(*pair)


def test_what_is_no_material_is_refused():
    with pytest.raises(mdr.ProblemError, match="'steel': a material such as Elastic"):
        mdr.effective_moduli("steel")


@settings(max_examples=examples(100), deadline=None)
@given(st.floats(-14.0, -1.0), st.sampled_from([-1, 1]))
def test_the_coupling_of_an_incompressible_graded_body_keeps_its_digits(exponent, sign):
    # B^2 = 1 - k^2 there, with the digits of 1 - |k|
    k = sign * (1 - 10**exponent)
    near = 1 - abs(k)
    result = surface_compliances(mdr.Graded(1.0, 1.0, k, 0.5))
    wave = math.sqrt(near * (1 + abs(k)))
    tangents = -sign * math.tan(near * math.pi / 2) / math.tan(wave * math.pi / 2)
    assert result.coupling == pytest.approx(2 * result.normal * (1 + k) / wave * tangents, rel=1e-12)
