"""Rheologies and viscoelastic bodies against Volterra's identity, Fourier integrals, Laplace inversion and limits."""

import itertools
import json
import math
import pickle

import mpmath
import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.special import erfcx

import pymdr as mdr
from drawing import examples
from pymdr.problem.codec import case_schema, decode_case, encode, tables
from pymdr.problem.spectra import Fractions, Relaxation, in_series, reciprocal
from pymdr.solving.zones import zone_relaxation
from pymdr.workbench.casefile import read_case

EXAMPLES = settings(max_examples=examples(40), deadline=None)
LOGS = st.floats(-3.0, 3.0)


def power(low, high):
    return st.floats(low, high).map(lambda x: 10.0**x)


@st.composite
def series(draw, decades=3.0, most=5, liquid=True):
    n = draw(st.integers(1, most))
    times = draw(st.lists(power(-decades, decades), min_size=n, max_size=n, unique=True))
    moduli = draw(st.lists(power(3.0, 7.0), min_size=n, max_size=n))
    equilibrium = draw(st.one_of(st.just(0.0), power(3.0, 7.0)) if liquid else power(3.0, 7.0))
    return mdr.Prony(equilibrium, moduli, times)


SOLID = mdr.Prony("1 MPa", ["2 MPa", "0.3 MPa", "10 MPa"], ["1 ms", "1 s", "30 s"])
LIQUID = mdr.Prony(0.0, ["2 MPa", "0.3 MPa"], ["0.1 s", "1 s"])
MAXWELL = mdr.Maxwell("1 kPa", "2 s"), mdr.Maxwell("1 kPa", viscosity="3 kPa*s")
STANDARD = mdr.StandardSolid("1 MPa", "3 MPa", "0.4 s")
DASHPOT = mdr.KelvinVoigt("1 MPa", "0.5 MPa*s")
POWER = mdr.PowerLawRheology("1 kPa", "2 s", 0.7)
RHEOLOGIES = [
    SOLID,
    LIQUID,
    *MAXWELL,
    STANDARD,
    DASHPOT,
    mdr.PowerLawRheology("1 kPa", "1 s", 0.2),
    POWER,
]
words = pytest.mark.parametrize("rheology", RHEOLOGIES, ids=lambda r: type(r).__name__)


def test_every_rheology_of_the_package_is_compared_here():
    own = {cls for cls in tables.RHEOLOGIES.values() if cls.__module__.startswith("pymdr.")}
    assert {type(one) for one in RHEOLOGIES} == own


def graded(function, end):
    """The integral from 0 to an end, by Gauss' rule on panels that shrink toward both."""
    nodes, weights = np.polynomial.legendre.leggauss(20)
    edges = np.concatenate([[0.0], 0.5 * np.geomspace(1e-18, 1.0, 61)])
    total = 0.0
    for near, far in itertools.pairwise(edges):
        at = near + (far - near) * 0.5 * (nodes + 1.0)
        total += 0.5 * end * (far - near) * float(weights @ (function(end * at, end * (1.0 - at))))
        total += 0.5 * end * (far - near) * float(weights @ (function(end * (1.0 - at), end * at)))
    return total


# --- one rheology ----------------------------------------------------------------------------------------


def hold_volterra(rheology, t, tolerance):
    dashpot = 0.0 if isinstance(rheology, mdr.PowerLawRheology) else rheology.kernel().viscosity
    result = graded(lambda s, rest: rheology.relaxation(rest) * rheology.creep(s), t)
    assert result + dashpot * float(rheology.creep(t)) == pytest.approx(t, rel=tolerance)


@words
@pytest.mark.parametrize("t", [1e-4, 0.3, 2.0, 50.0])
def test_creep_undoes_relaxation(rheology, t):
    # panels that end at 1e-18 of the span leave (1e-18)^0.3 of a power of 0.7
    rough = isinstance(rheology, mdr.PowerLawRheology)
    hold_volterra(rheology, t, 1e-5 if rough and rheology.exponent > 0.5 else 1e-11)


@EXAMPLES
@given(series(), power(-2.0, 2.0))
def test_creep_undoes_relaxation_of_any_series(rheology, t):
    hold_volterra(rheology, t, 1e-10)


@words
@pytest.mark.parametrize("omega", [0.1, 1.0, 7.0])
def test_storage_and_loss_are_fourier_integrals(rheology, omega):
    if isinstance(rheology, mdr.PowerLawRheology):
        rest, dashpot, b = 0.0, 0.0, rheology.exponent
        factor = omega * rheology.modulus * rheology.time**b
        cosine, sine = (
            # t = u^(1/(1 - b)) takes the singularity away
            factor
            * float(mpmath.quad(lambda u, wave=wave: wave(omega * u ** (1 / (1 - b))) / (1 - b), [0, 1]))
            + factor
            * float(
                mpmath.quadosc(lambda t, wave=wave: t**-b * wave(omega * t), [1, mpmath.inf], omega=omega)
            )
            for wave in (mpmath.cos, mpmath.sin)
        )
    else:
        own = rheology.kernel()
        rest, dashpot = own.equilibrium, own.viscosity
        end = 40.0 * max(own.times, default=1.0)
        nodes, weights = np.polynomial.legendre.leggauss(20)
        edges = np.unique(np.append(np.geomspace(1e-12, end, 200), np.linspace(0.0, end, 5000)))
        width = np.diff(edges)[:, None]
        t = (edges[:-1, None] + width * 0.5 * (nodes + 1.0)).ravel()
        fraction = (0.5 * width * weights).ravel() * (rheology.relaxation(t) - rest)
        cosine, sine = (omega * float(fraction @ wave(omega * t)) for wave in (np.cos, np.sin))
    size = math.hypot(rest + sine, cosine + omega * dashpot)
    assert float(rheology.storage(omega)) == pytest.approx(rest + sine, abs=1e-9 * size)
    assert float(rheology.loss(omega)) == pytest.approx(cosine + omega * dashpot, abs=1e-9 * size)


def test_closed_forms_of_the_standard_solid():
    G, g, tau = 1e6, 3e6, 0.4
    solid = mdr.StandardSolid(G, g, tau)
    t = np.geomspace(1e-6, 1e3, 60)
    later = tau * (G + g) / G
    assert solid.creep(t) == pytest.approx(1 / G - g / (G * (G + g)) * np.exp(-t / later), rel=1e-14)
    assert solid.relaxation(t) == pytest.approx(G + g * np.exp(-t / tau), rel=1e-15)


def test_closed_forms_of_a_liquid_and_of_kelvin_and_voigt():
    t = np.geomspace(1e-6, 1e3, 60)
    assert mdr.Maxwell(2.0, 3.0).creep(t) == pytest.approx(0.5 + t / 6.0, rel=1e-14)
    assert mdr.KelvinVoigt(2.0, 3.0).creep(t) == pytest.approx(-np.expm1(-t * 2.0 / 3.0) / 2.0, rel=1e-14)
    assert mdr.KelvinVoigt(2.0, 3.0).loss(5.0) == pytest.approx(15.0, rel=1e-15)
    assert float(mdr.KelvinVoigt(2.0, 3.0).relaxation(0.0)) == 2.0


@EXAMPLES
@given(series())
def test_limits_of_a_series(rheology):
    end = float(rheology.moduli.sum()) + rheology.equilibrium
    assert float(rheology.creep(0.0)) == pytest.approx(1 / end, rel=1e-13)
    assert float(rheology.storage(1e30)) == pytest.approx(end, rel=1e-13)
    if rheology.equilibrium > 0.0:
        assert float(rheology.creep(1e30)) == pytest.approx(1 / rheology.equilibrium, rel=1e-13)
    else:
        viscosity = float(rheology.moduli @ rheology.times)
        assert rheology.kernel().retardation.fluidity == pytest.approx(1 / viscosity, rel=1e-13)
    t = np.geomspace(1e-5, 1e5, 200)
    assert np.all(np.diff(rheology.creep(t)) >= 0.0)
    assert np.all(np.diff(rheology.relaxation(t)) <= 0.0)


@EXAMPLES
@given(series(), power(-6.0, 6.0), power(-6.0, 6.0))
def test_units_of_time_and_modulus_do_not_matter(rheology, later, stiffer):
    other = mdr.Prony(stiffer * rheology.equilibrium, stiffer * rheology.moduli, later * rheology.times)
    t = np.geomspace(1e-4, 1e4, 30)
    assert stiffer * other.creep(later * t) == pytest.approx(rheology.creep(t), rel=1e-11)


@pytest.mark.parametrize("rheology", [*MAXWELL, STANDARD])
def test_series_of_one_term_are_the_same(rheology):
    t = np.geomspace(1e-3, 1e2, 20)
    same = rheology.prony()
    for ask in ("relaxation", "creep", "storage", "loss"):
        assert getattr(same, ask)(t).tolist() == getattr(rheology, ask)(t).tolist()


def test_quantities_and_shapes():
    solid = mdr.StandardSolid("1 MPa", "3 MPa", "10 ms")
    assert float(solid.relaxation("1 h")) == 1e6
    assert solid.relaxation(["1 ms", 2.0]).shape == (2,)
    assert solid.creep(np.ones((2, 3))).shape == (2, 3)
    assert float(solid.storage("100 rad/s")) == pytest.approx(2.5e6)
    with pytest.raises(mdr.UnitError, match="omega"):
        solid.storage("100 Hz")


# --- reciprocals -----------------------------------------------------------------------------------------


@EXAMPLES
@given(
    st.one_of(st.just(0.0), power(-9.0, 9.0)),
    st.lists(st.tuples(power(-9.0, 9.0), power(-12.0, 12.0)), max_size=12, unique_by=lambda both: both[1]),
    st.one_of(st.just(0.0), power(-9.0, 9.0)),
)
def test_reciprocals_over_24_decades(constant, pairs, slope):
    assume(constant + slope > 0.0 or pairs)
    weights, poles = np.array(pairs).reshape(-1, 2).T
    h = Fractions(constant, weights, poles, slope)
    inverse = reciprocal(h)
    assert np.all(inverse.weights > 0.0)
    assert np.all(inverse.poles > 0.0)

    def value(one, s):
        return one.constant + sum(w * s / (s + p) for w, p in zip(*one[1:3], strict=True)) + one.slope * s

    for s in (*10.0 ** np.linspace(-13.0, 13.0, 27), 1.0j, 1e5j):
        assert abs(value(h, s) * value(inverse, 1.0 / s) - 1.0) < 1e-12


def test_poles_that_agree_to_rounding_are_one():
    h = Fractions(1.0, np.array([1.0, 2.0]), np.array([3.0, 3.0 * (1.0 + 3e-16)]), 0.0)
    assert reciprocal(h).poles.size == 1


def test_a_term_of_next_to_nothing_changes_nothing():
    kernel = Relaxation(1.0, np.array([1e-30, 1.0]), np.array([1.0, 2.0]))
    t = np.geomspace(1e-3, 1e2, 20)
    assert kernel.retardation(t) == pytest.approx(
        Relaxation(1.0, np.array([1.0]), np.array([2.0])).retardation(t), rel=1e-14
    )


# --- powers of time --------------------------------------------------------------------------------------


@EXAMPLES
@given(
    st.floats(0.01, 0.99), power(-6.0, 6.0), st.floats(0.1, 10.0), st.sampled_from([1e-3, 1e-6, 1e-9, 1e-11])
)
def test_a_power_as_a_series(exponent, first, decades, error):
    law = mdr.PowerLawRheology("1 kPa", "1 s", exponent)
    last = first * 10.0**decades
    result = law.prony(first, last, error=error)
    t = np.exp(np.random.default_rng(0).uniform(np.log(first), np.log(last), 300))
    assert np.max(np.abs(result.relaxation(t) / law.relaxation(t) - 1.0)) <= error
    assert result.times.size < 40 + 10 * decades
    kernel = law.kernel((first, last))
    assert 0.0 < kernel.error <= 1e-9


@pytest.mark.parametrize("span", [(0.0, 1.0), (1.0, 1.0), (2.0, 1.0), (-1.0, 1.0), (1e-20, 1e20)])
def test_spans_that_are_none(span):
    with pytest.raises(mdr.ProblemError, match="span from"):
        POWER.prony(*span)


@pytest.mark.parametrize("exponent", [0.05, 0.3, 0.5, 0.9])
def test_modes_of_a_power_over_twelve_decades_creep_as_its_closed_form(exponent):
    law, span = mdr.PowerLawRheology("1 kPa", "1 s", exponent), (1e-9, 1e3)
    kernel = law.softened(span, 1e-6)
    fraction, rate, decay, participation, into, back = kernel.modes
    assert decay[0] == 0.0
    assert (decay[1:] > rate[:-1]).all()
    assert (decay < rate).all()
    assert np.max(np.abs(into @ back - np.eye(rate.size))) < 1e-14
    assert fraction @ back == pytest.approx(participation, rel=1e-13)
    t = np.geomspace(*span, 200)
    x = decay * t[:, None]
    delayed = np.where(x > 0.0, -np.expm1(-x) / np.where(x > 0.0, decay, 1.0), t[:, None]) @ participation**2
    creep = (1.0 + delayed) / kernel.glassy
    assert creep == pytest.approx(kernel.retardation(t), rel=1e-13)
    assert creep == pytest.approx(law.creep(t), rel=kernel.error)
    assert kernel.error < 1e-5


def test_a_power_and_a_spring_relax_by_the_function_of_mittag_leffler():
    body = mdr.Viscoelastic(mdr.PowerLawRheology(0.5, 1.0, 0.5), poisson=0.5)
    pair = mdr.Contact(mdr.Paraboloid(1.0), body, mdr.Elastic(3.0, 0.0))
    kernel, t = zone_relaxation(pair, (1.0, 1e4)), np.geomspace(1.0, 1e4, 60)
    # E* = 2 t^-1/2 and 3 in series: 3 E_1/2(-(3/2) sqrt(t/pi)), with E_1/2(-x) = erfcx(x)
    assert kernel(t) == pytest.approx(3.0 * erfcx(1.5 * np.sqrt(t / math.pi)), rel=2.0 * kernel.error)
    assert kernel.glassy == pytest.approx(3.0, rel=0.1)


def test_a_power_needs_a_span_and_an_error():
    law = POWER
    body = mdr.Viscoelastic(law, poisson=0.5)
    with pytest.raises(mdr.ProblemError, match="span = "):
        mdr.relaxation_of(body)
    with pytest.raises(mdr.ProblemError, match=r"error = 0\.5"):
        law.prony(1.0, 2.0, error=0.5)
    kernel = mdr.relaxation_of(body, span=("1 ms", "10 s"))
    t = np.geomspace(1e-3, 10.0, 50)
    assert kernel(t) == pytest.approx(4.0 * law.relaxation(t), rel=1e-9)


# --- pairs of bodies -------------------------------------------------------------------------------------

SPAN = (1e-12, 1e8)
BODIES = {
    "constant nu": mdr.Viscoelastic(SOLID, poisson=0.3),
    "liquid, constant K": mdr.Viscoelastic(LIQUID, bulk="10 MPa"),
    "soft K": mdr.Viscoelastic(SOLID, bulk="0.1 MPa"),
    "hard K": mdr.Viscoelastic(STANDARD, bulk="1 GPa"),
    "dashpot, K": mdr.Viscoelastic(DASHPOT, bulk="1 MPa"),
    "dashpot, nu": mdr.Viscoelastic(DASHPOT, poisson=0.4),
    "Maxwell": mdr.Viscoelastic(mdr.Maxwell("1 MPa", "1 s"), poisson=0.5),
    "power": mdr.Viscoelastic(mdr.PowerLawRheology("1 MPa", "1 s", 0.3), poisson=0.2),
    "elastic": mdr.Elastic("1 MPa", 0.3),
    "rigid": mdr.Rigid(),
}


def compliance(body):
    """1/E* of one body in the Carson domain, as the mechanics of solids has it."""
    if isinstance(body, mdr.Rigid):
        return lambda s: mpmath.mpf(0)
    if isinstance(body, mdr.Elastic):
        return lambda s: (1 - mpmath.mpf(body.poisson) ** 2) / body.young
    law = body.shear

    def shear(s):
        if isinstance(law, mdr.PowerLawRheology):
            return law.modulus * mpmath.gamma(1 - mpmath.mpf(law.exponent)) * (s * law.time) ** law.exponent
        if isinstance(law, mdr.KelvinVoigt):
            return law.modulus + law.viscosity * s
        own = law.prony()
        terms = zip(own.moduli.tolist(), own.times.tolist(), strict=True)
        return own.equilibrium + sum(g * s * tau / (1 + s * tau) for g, tau in terms)

    if body.bulk is None:
        return lambda s: (1 - mpmath.mpf(body.poisson)) / (2 * shear(s))
    K = body.bulk
    return lambda s: (3 * K + 4 * shear(s)) / (4 * shear(s) * (3 * K + shear(s)))


PAIRS = [(a, b) for i, a in enumerate(BODIES) for b in list(BODIES)[i:] if a not in ("elastic", "rigid")]


@pytest.mark.parametrize(("one", "other"), PAIRS)
def test_pairs_against_laplace_inversion(one, other):
    kernel = mdr.relaxation_of(BODIES[one], BODIES[other], span=SPAN)
    parts = compliance(BODIES[one]), compliance(BODIES[other])
    assert np.all(kernel.moduli > 0.0)
    assert np.all(kernel.times > 0.0)
    for t in (1e-2, 0.7, 9.0):
        with mpmath.workdps(30):
            exact = mpmath.invertlaplace(
                lambda s: 1 / (s * sum(part(s) for part in parts)) - kernel.viscosity, t, method="talbot"
            )
        # the span of a power ends: what is faster has done its work by these times, to that accuracy
        assert float(kernel(t)) == pytest.approx(float(exact), rel=2e-9 if "power" in (one, other) else 1e-11)


@settings(max_examples=examples(15), deadline=None)
@given(power(4.0, 16.0), st.one_of(st.none(), st.floats(1.0, 3.0), power(-14.0, 0.0).map(lambda x: 1.0 + x)))
def test_bodies_that_share_their_times(bulk, stiffer):
    law = SOLID
    body = mdr.Viscoelastic(law, bulk=bulk)
    second = (
        mdr.Viscoelastic(law, poisson=0.5) if stiffer is None else mdr.Viscoelastic(law, bulk=stiffer * bulk)
    )
    kernel = mdr.relaxation_of(body, second)
    with mpmath.workdps(40):
        parts = compliance(body), compliance(second)
        for t in (1e-3, 0.7, 20.0):
            exact = mpmath.invertlaplace(lambda s: 1 / (s * (parts[0](s) + parts[1](s))), t, method="talbot")
            assert float(kernel(t)) == pytest.approx(float(exact), rel=1e-12)


@EXAMPLES
@given(series(), series(), st.floats(-0.9, 0.5), power(3.0, 9.0))
def test_glassy_and_rubbery_pairs_are_elastic(first, second, poisson, bulk):
    def elastic(shear, nu):
        return mdr.Elastic(2.0 * shear * (1.0 + nu), nu)

    def contracted(shear):
        return (3.0 * bulk - 2.0 * shear) / (2.0 * (3.0 * bulk + shear))

    pair = mdr.Viscoelastic(first, poisson=poisson), mdr.Viscoelastic(second, bulk=bulk)
    kernel = mdr.relaxation_of(*pair)
    swapped = mdr.relaxation_of(*pair[::-1])
    hard = [float(law.relaxation(0.0)) for law in (first, second)]
    at_once = mdr.effective_moduli(elastic(hard[0], poisson), elastic(hard[1], contracted(hard[1]))).normal
    assert kernel.glassy == pytest.approx(at_once, rel=1e-11)
    if first.equilibrium > 0.0 and second.equilibrium > 0.0:
        soft = [law.equilibrium for law in (first, second)]
        late = mdr.effective_moduli(elastic(soft[0], poisson), elastic(soft[1], contracted(soft[1]))).normal
        assert kernel.rubbery == pytest.approx(late, rel=1e-11)
    else:
        assert kernel.rubbery == 0.0
    t = np.geomspace(1e-4, 1e4, 40)
    assert swapped(t) == pytest.approx(kernel(t), rel=1e-11, abs=1e-14 * kernel.glassy)
    assert np.all(kernel.moduli > 0.0)
    assert kernel.moduli.size <= first.times.size + 2 * second.times.size


def test_constant_bulk_modulus_of_a_standard_solid_has_the_times_of_the_theory():
    G, g, tau, K = 1e6, 3e6, 0.4, 5e6
    kernel = mdr.relaxation_of(mdr.Viscoelastic(mdr.StandardSolid(G, g, tau), bulk=K))
    late = tau * (3 * K + 4 * G + 4 * g) / (3 * K + 4 * G)
    assert kernel.times == pytest.approx([tau, late], rel=1e-14)


def test_a_body_that_cannot_be_compressed_has_both_forms():
    shear = SOLID
    t = np.geomspace(1e-4, 1e3, 30)
    assert mdr.relaxation_of(mdr.Viscoelastic(shear, bulk=1e20))(t) == pytest.approx(
        mdr.relaxation_of(mdr.Viscoelastic(shear, poisson=0.5))(t), rel=1e-11
    )


def test_two_equal_bodies_are_half_as_stiff():
    body = BODIES["constant nu"]
    t = np.geomspace(1e-4, 1e3, 30)
    pair = mdr.relaxation_of(body, body)
    assert pair.times.size == 3
    assert 2.0 * pair(t) == pytest.approx(mdr.relaxation_of(body)(t), rel=1e-13)


def test_a_stiff_counterbody_is_rigid_and_elastic_pairs_do_not_relax():
    body = BODIES["constant nu"]
    t = np.geomspace(1e-4, 1e3, 30)
    assert mdr.relaxation_of(body, mdr.Elastic(1e30, 0.3))(t) == pytest.approx(
        mdr.relaxation_of(body)(t), rel=1e-13
    )
    zinc = mdr.TransverselyIsotropic(c11=161e9, c33=61e9, c13=50.1e9, c44=38.3e9, c66=63.4e9)
    pair = mdr.Elastic("210 GPa", 0.3), zinc
    kernel = mdr.relaxation_of(*pair)
    assert kernel.moduli.size == 0
    assert kernel.rubbery == pytest.approx(mdr.effective_moduli(*pair).normal, rel=1e-14)


def test_a_crystal_against_rubber():
    zinc = mdr.TransverselyIsotropic(c11=161e9, c33=61e9, c13=50.1e9, c44=38.3e9, c66=63.4e9)
    hard = mdr.Viscoelastic(mdr.StandardSolid("10 GPa", "30 GPa", "1 s"), poisson=0.3)
    same = mdr.Elastic(mdr.effective_moduli(zinc).normal, 0.0)
    t = np.geomspace(1e-3, 1e2, 20)
    assert mdr.relaxation_of(hard, zinc)(t) == pytest.approx(mdr.relaxation_of(hard, same)(t), rel=1e-13)


def test_series_of_dashpots():
    kernel = in_series([Relaxation(viscosity=2.0), Relaxation(viscosity=2.0)])
    assert (kernel.equilibrium, kernel.viscosity, kernel.moduli.size) == (0.0, 1.0, 0)
    with pytest.raises(mdr.ProblemError, match="at least one"):
        in_series([])


def test_a_graded_body_has_no_kernel():
    graded_body = mdr.Graded("1 MPa", "1 mm", 0.2, 0.3)
    with pytest.raises(mdr.ProblemError, match="grading exponents"):
        mdr.relaxation_of(BODIES["Maxwell"], graded_body)
    with pytest.raises(mdr.ProblemError, match="effective_moduli"):
        mdr.relaxation_of(graded_body)
    with pytest.raises(mdr.ProblemError, match="rigid"):
        mdr.relaxation_of(mdr.Rigid())
    with pytest.raises(mdr.ProblemError, match="material such as"):
        mdr.relaxation_of("rubber")


# --- fits ------------------------------------------------------------------------------------------------


@st.composite
def clear_series(draw):
    """Terms at least a decade apart, all of them worth seeing."""
    n = draw(st.integers(1, 3))
    start = draw(st.floats(-2.0, -1.5))
    steps = [draw(st.floats(1.0, 1.5)) for _ in range(n - 1)]
    times = 10.0 ** (start + np.cumsum([0.0, *steps]))
    moduli = [draw(power(5.0, 6.0)) for _ in range(n)]
    return mdr.Prony(draw(power(5.0, 6.0)), moduli, times)


@settings(max_examples=examples(15), deadline=None)
@given(clear_series(), st.booleans())
def test_fits_find_series_without_noise(rheology, sweep):
    x = np.geomspace(1e-4, 1e4, 161)
    if sweep:
        fitted = mdr.Prony.from_dma(x, rheology.storage(x), rheology.loss(x))
    else:
        fitted = mdr.Prony.from_relaxation(x, rheology.relaxation(x))
    assert fitted.times == pytest.approx(rheology.times, rel=1e-6)
    assert fitted.moduli == pytest.approx(rheology.moduli, rel=1e-6)
    assert fitted.equilibrium == pytest.approx(rheology.equilibrium, rel=1e-6)


@settings(max_examples=examples(15), deadline=None)
@given(clear_series(), st.sampled_from([1e-4, 1e-3, 1e-2]), st.integers(0, 2**31), st.booleans())
def test_fits_find_series_to_their_noise(rheology, noise, seed, sweep):
    x = np.geomspace(1e-4, 1e4, 161)
    random = np.random.default_rng(seed)

    def noisy(values):
        return values * (1.0 + noise * random.standard_normal(x.size))

    if sweep:
        fit = mdr.fit_prony(
            {"omega": x, "storage": noisy(rheology.storage(x)), "loss": noisy(rheology.loss(x))}
        )
    else:
        fit = mdr.fit_prony({"time": x, "modulus": noisy(rheology.relaxation(x))})
    assert fit.misfit < 1.3 * noise
    assert fit.series.times.size <= rheology.times.size + 2
    assert fit.series.relaxation(x) == pytest.approx(rheology.relaxation(x), rel=5.0 * noise)
    assert np.all(fit.series.moduli > 0.0)


def test_a_power_is_fitted_with_few_terms():
    x = np.geomspace(1e-3, 1e3, 121)
    law = mdr.PowerLawRheology("1 kPa", "1 s", 0.25)
    fitted = mdr.Prony.from_relaxation(x, law.relaxation(x), noise=0.01)
    assert fitted.times.size <= 7
    assert np.sqrt(np.mean((fitted.relaxation(x) / law.relaxation(x) - 1.0) ** 2)) <= 0.01


def test_numbers_of_terms():
    x = np.geomspace(1e-3, 1e3, 121)
    law = mdr.PowerLawRheology("1 kPa", "1 s", 0.25)
    off = []
    for terms in (1, 3, 6):
        fitted = mdr.Prony.from_relaxation(x, law.relaxation(x), terms=terms)
        assert fitted.times.size == terms
        off.append(np.mean((fitted.relaxation(x) / law.relaxation(x) - 1.0) ** 2))
    assert off[0] > off[1] > off[2]
    flat = mdr.Prony.from_relaxation(x, np.full(x.size, 3e5))
    assert (flat.times.size, flat.equilibrium) == (0, pytest.approx(3e5))


X = np.geomspace(0.01, 100.0, 9)
ONES = np.ones(9)


@pytest.mark.parametrize(
    ("call", "match"),
    [
        (lambda: mdr.Prony.from_relaxation(X[::-1], ONES), "sort the rows"),
        (lambda: mdr.Prony.from_relaxation(np.repeat(X, 2), np.ones(18)), "average"),
        (lambda: mdr.Prony.from_relaxation([1e-5, *X[1:]], ONES), r"the gap from 1e-05 .* decades"),
        (
            lambda: mdr.Prony.from_relaxation([0.0, *X[1:]], ONES),
            "row 1 is at 0; .*; leave earlier rows out",
        ),
        (lambda: mdr.Prony.from_relaxation(X[:4], ONES[:4]), "at least 5"),
        (lambda: mdr.Prony.from_relaxation(X, ONES[:4]), "4 moduli for 9 rows"),
        (lambda: mdr.Prony.from_relaxation(X, -ONES), "at least 0 Pa"),
        (lambda: mdr.Prony.from_relaxation(X, 0.0 * ONES), "moduli in row 1 are 0 Pa"),
        (lambda: mdr.Prony.from_relaxation(X - 0.01, ONES), "above 0"),
        (lambda: mdr.Prony.from_relaxation(X, ONES * np.nan), "finite"),
        (lambda: mdr.Prony.from_relaxation(X * np.inf, ONES), "finite"),
        (lambda: mdr.Prony.from_relaxation(X, X, noise=0.01), "the body is not linear"),
        (lambda: mdr.Prony.from_relaxation(X, ONES, terms=0), "terms = 0"),
        (lambda: mdr.Prony.from_relaxation(X, ONES, terms=True), "terms = True"),
        (lambda: mdr.Prony.from_relaxation(X, ONES, noise=2.0), "noise = 2"),
        (lambda: mdr.Prony.from_relaxation(X, ONES, terms=2, noise=0.1), "either terms or noise"),
        (lambda: mdr.Prony.from_dma([1e-7, *X[1:]], ONES, ONES), r"limit 2\)"),
        (lambda: mdr.Prony.from_dma(X, ONES, -ONES), "at least 0 Pa"),
        (lambda: mdr.Prony.from_dma(X, 0.0 * ONES, 0.0 * ONES), "moduli in row 1 are 0 Pa"),
        (lambda: mdr.Prony.from_dma(["1 Hz"] * 9, ONES, ONES), "omega"),
        (lambda: mdr.fit_prony({"time": X}), "time, modulus"),
        (lambda: mdr.fit_prony(3.0), "CSV file"),
    ],
)
def test_measurements_that_are_none(call, match):
    with pytest.raises(mdr.PymdrError, match=match):
        call()


@settings(max_examples=examples(20), deadline=None)
@given(
    st.lists(st.tuples(st.floats(0.01, 1.9), power(-60.0, 60.0)), min_size=5, max_size=20),
    power(-9.0, 9.0),
    st.booleans(),
)
def test_any_rows_are_fitted_or_refused(rows, start, sweep):
    steps, moduli = np.array(rows).T
    along = start * 10.0 ** np.cumsum(steps)
    data = (
        {"omega": along, "storage": moduli, "loss": moduli[::-1]}
        if sweep
        else {"time": along, "modulus": moduli}
    )
    try:
        fit = mdr.fit_prony(data)
    except mdr.PymdrError:
        return
    assert math.isfinite(fit.misfit)
    assert float(fit.series.relaxation(0.0)) > 0.0


@EXAMPLES
@given(
    st.one_of(st.just(0.0), power(-60.0, 60.0)),
    st.lists(
        st.tuples(power(-60.0, 60.0), power(-60.0, 60.0)), min_size=1, max_size=5, unique_by=lambda x: x[1]
    ),
    power(-60.0, 60.0),
)
def test_sizes_that_nothing_has_overflow_nowhere(equilibrium, terms, bulk):
    moduli, times = np.array(terms).T
    law = mdr.Prony(equilibrium, moduli, times)
    x = np.array([0.0, 1e-60, 1.0, 1e60, 1e200])
    for ask in (law.relaxation, law.creep, law.storage, law.loss):
        assert np.all(np.isfinite(ask(x)))
        assert np.all(ask(x) >= 0.0)
    kernel = mdr.relaxation_of(mdr.Viscoelastic(law, bulk=bulk), mdr.Viscoelastic(law, poisson=0.3))
    assert math.isfinite(kernel.glassy)
    assert kernel.glassy > 0.0
    assert np.all(kernel.moduli > 0.0)


# --- files and figures -----------------------------------------------------------------------------------


def table(file, head, *columns):
    rows = (
        ",".join(f"{value!r}" for value in row) for row in zip(*(c.tolist() for c in columns), strict=True)
    )
    file.write_text("\n".join([head, *rows]), encoding="utf-8")
    return file


@pytest.mark.parametrize("unit", ["frequency [Hz]", "omega [rad/s]"])
def test_a_sweep_from_a_file(tmp_path, unit):
    w = np.geomspace(0.1, 1e3, 41)
    law = STANDARD
    along = w / (2.0 * math.pi) if "Hz" in unit else w
    head = f"{unit}, G' [kPa], G'' [kPa], temperature [degC]"
    file = table(tmp_path / "dma.csv", head, along, law.storage(w) / 1e3, law.loss(w) / 1e3, 20.0 + 0.0 * w)
    result = mdr.fit_prony(file).series
    assert result.times == pytest.approx([0.4], rel=1e-9)
    assert result.equilibrium == pytest.approx(1e6, rel=1e-9)


CASE = """
[profile]
kind = "sphere"
radius = "1 mm"

[body]
kind = "viscoelastic"
poisson = 0.5
shear = {{ kind = "prony", {} }}

[[path]]
kind = "indent"
indentation = "1 um"
"""


def test_a_case_may_name_a_relaxation_test(tmp_path):
    t = np.geomspace(1e-3, 1e2, 41)
    table(tmp_path / "g.csv", "time [ms], G [kPa]", 1e3 * t, STANDARD.relaxation(t) / 1e3)
    case = tmp_path / "case.toml"
    case.write_text(CASE.format('file = "g.csv"'))
    assert read_case(case).contact.body.shear.times == pytest.approx([0.4], rel=1e-9)
    for keys, match in (
        ('file = "g.csv", times = [1]', "give the series once"),
        ("file = 3", "name of a CSV file"),
        ('file = "none.csv"', "cannot read"),
        ('equilibrium = 1, moduli = [1, 2], times = ["1 s"]', r"2 moduli for 1 times"),
        ("equilibrium = 1, moduli = [1], tims = [1]", "did you mean 'times'"),
    ):
        case.write_text(CASE.format(keys))
        with pytest.raises(mdr.PymdrError, match=match) as caught:
            read_case(case)
        assert str(caught.value).count("[body.shear]") + str(caught.value).count("[body shear]") == 1


@pytest.mark.parametrize("kind", ["sampled", "force_curve"])
def test_a_profile_whose_file_cannot_be_read_is_named(tmp_path, kind):
    case = tmp_path / "case.toml"
    for file, match in (('"none.csv"', "cannot read"), ("3", "name of a CSV file")):
        profile = f'[profile]\nkind = "{kind}"\nmodulus = "1 GPa"\nfile = {file}\n'
        case.write_text(profile + '[body]\nkind = "elastic"\nyoung = 1\npoisson = 0.3\n')
        with pytest.raises(mdr.CaseError, match=match) as caught:
            read_case(case)
        assert str(caught.value).count("[profile]") == 1


@pytest.mark.parametrize(
    ("head", "match"),
    [
        ("time [s], G' [kPa]", "a relaxation test needs time and a modulus"),
        ("time [s], frequency [Hz]", "a relaxation test needs"),
        ("frequency [rad/s], G' [kPa]", "frequency"),
        ("a [s], b [kPa]", "is not a header"),
        ("time [s], G [mm]", "column 'G"),
    ],
)
def test_files_that_are_no_measurement(tmp_path, head, match):
    with pytest.raises(mdr.CaseError, match=match):
        mdr.fit_prony(table(tmp_path / "x.csv", head, X, ONES))


def test_the_figure_of_a_fit():
    t = np.geomspace(1e-3, 1e2, 41)
    law = STANDARD
    for data in (
        {"time": t, "modulus": law.relaxation(t)},
        {"omega": t, "storage": law.storage(t), "loss": law.loss(t)},
        {"time": t, "modulus": 1e5 + 0.0 * t},
    ):
        fit = mdr.fit_prony(data)
        left, right = fit.plot().axes
        assert len(left.lines) == 2 * (len(data) - 1) + 1
        assert left.lines[0].get_ydata()[0] == pytest.approx(left.lines[1].get_ydata()[0], rel=1e-6)
        assert right.get_xlabel() == "relaxation time (s)"
        assert "root mean square misfit" in str(fit)


@pytest.mark.parametrize("name", [name for name in BODIES if name not in ("elastic", "rigid")])
def test_bodies_go_through_files(name):
    contact = mdr.Contact(mdr.Sphere("1 mm"), BODIES[name], mdr.Elastic("1 GPa", 0.3))
    plain = json.loads(json.dumps(encode(contact)))
    again = decode_case({**plain, "path": [{"kind": "indent", "indentation": "1 um"}]})[1]
    assert again == contact
    assert hash(again) == hash(contact)
    assert pickle.loads(pickle.dumps(contact)) == contact
    assert type(BODIES[name].shear).__name__ in contact._repr_html_()


def test_the_schema_knows_rheologies():
    plain = case_schema()["$defs"]
    assert {"prony", "maxwell", "standard_solid", "kelvin_voigt", "power_law_rheology"} <= set(plain)
    assert plain["prony"]["anyOf"] == [
        {"required": ["equilibrium", "moduli", "times"]},
        {"required": ["file"]},
    ]


# --- bad input -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("make", "match"),
    [
        (lambda: mdr.Prony(-1.0, [1.0], [1.0]), "^equilibrium"),
        (lambda: mdr.Prony(1.0, [-1.0], [1.0]), r"^moduli\[0\] = -1 Pa"),
        (lambda: mdr.Prony(1.0, [1.0, 0.0], [1.0, 2.0]), r"^moduli\[1\] = 0 Pa"),
        (lambda: mdr.Prony(1.0, [1.0], [-2.0]), r"^times\[0\] = -2 s"),
        (lambda: mdr.Prony(1.0, [1.0], ["1 mm"]), "^times"),
        (lambda: mdr.Prony(1.0, [np.nan], [1.0]), "finite"),
        (lambda: mdr.Prony(1.0, [1e99], [1.0]), "at most 1e[+]60 Pa"),
        (lambda: mdr.Prony(1.0, [1.0], [1e-99]), "at least 1e-60 s"),
        (lambda: mdr.Prony(1.0, [1.0, 2.0], [1.0]), "2 moduli for 1 times"),
        (lambda: mdr.Prony(1.0, [1.0, 2.0], [1.0, 1.0]), "occurs twice"),
        (lambda: mdr.Prony(0.0, [], []), "without moduli"),
        (lambda: mdr.Maxwell(1.0), "neither time nor viscosity"),
        (lambda: mdr.Maxwell(1.0, 1.0, 1.0), "both time and viscosity"),
        (lambda: mdr.Maxwell(0.0, 1.0), "^modulus"),
        (lambda: mdr.StandardSolid(0.0, 1.0, 1.0), "^equilibrium"),
        (lambda: mdr.KelvinVoigt(1.0, -1.0), "^viscosity"),
        (lambda: mdr.PowerLawRheology(1.0, 1.0, 1.0), "exponent"),
        (lambda: mdr.PowerLawRheology(1.0, 1.0, 0.0), "exponent"),
        (lambda: mdr.Viscoelastic(SOLID), "neither poisson nor bulk"),
        (lambda: mdr.Viscoelastic(SOLID, poisson=0.5, bulk=1.0), "both poisson and bulk"),
        (lambda: mdr.Viscoelastic(SOLID, poisson=0.6), "^poisson"),
        (lambda: mdr.Viscoelastic(SOLID, bulk=0.0), "^bulk"),
        (lambda: mdr.Viscoelastic("1 MPa", poisson=0.5), "^shear"),
        (lambda: SOLID.relaxation(-1.0), "time = -1 s"),
        (lambda: POWER.storage(-1.0), "omega = -1 rad/s"),
    ],
)
def test_bad_rheologies(make, match):
    with pytest.raises(ValueError, match=match):
        make()


def test_contacts_that_are_not_offered():
    rubber, tip = BODIES["constant nu"], mdr.Sphere("1 mm")
    with pytest.raises(mdr.ProblemError, match="no limit of short range"):
        mdr.Contact(tip, rubber, adhesion=mdr.JKR("1 J/m^2"))
    with pytest.raises(mdr.ProblemError, match="relaxation_of"):
        mdr.effective_moduli(rubber)


def test_results_keep_their_rheology(tmp_path):
    for name in ("soft K", "dashpot, nu", "power"):
        contact = mdr.Contact(mdr.Sphere("1 mm"), BODIES[name])
        result = mdr.solve(contact, mdr.indent("10 um", rate="10 um/s", steps=10))
        result.save(tmp_path / "memory.nc")
        assert mdr.open_result(tmp_path / "memory.nc").contact == contact
