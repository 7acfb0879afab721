"""What the map of numerical profiles promises beyond its accuracy: rows alone, economy, threads, files."""

import itertools
import math
import pickle
import threading

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf

import pymdr as mdr
from common import UNIT
from drawing import examples
from pymdr.line.foundation import ElasticLine, normal_force, states_at_depth, states_at_force
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.mapping.equivalent.panels import PanelLine
from pymdr.mapping.sources import CurveSource
from pymdr.numerics.panels import Place
from pymdr.problem.profiles import Sum

NAMES = ("indentation", "normal_force", "contact_radius", "elastic_energy")


def worst(computed, exact):
    return float(np.max(np.abs(np.asarray(computed) / np.asarray(exact) - 1)))


class Counted:
    """A callable that remembers how often and how far it was asked."""

    def __init__(self, function):
        self.function, self.calls, self.farthest = function, 0, 0.0
        self.lock = threading.Lock()

    def __call__(self, r):
        with self.lock:
            self.calls += 1
            self.farthest = max(self.farthest, float(np.max(r)))
        return self.function(r)


def hyperboloid(size):
    return lambda r: r / np.hypot(r, 0.3 * size)


def hyperboloid_f(size):
    return lambda r: r * r / (np.hypot(r, 0.3 * size) + 0.3 * size)


def quartic(size):
    return lambda r: r / size + 0.4 * (r / size) ** 3


def wavy(size):
    return lambda r: r / size + 0.06 * np.sin(6.0 * r / size)


def root(size):
    return lambda r: 0.3 * (size / r) ** 0.7


def kinked(size):
    return lambda r: np.where(r > 0.4 * size, 1.0, r / size)


SLOPES = {f.__name__: f for f in (hyperboloid, quartic, wavy, root, kinked)}
SIZES = st.floats(-12.0, 6.0).map(lambda decades: 10.0**decades)


def fresh(name, size=1.0, counted=False):
    """A profile that nothing is known of: a callable that was never seen before."""
    slope = SLOPES[name](size)
    function = Counted(slope) if counted else lambda r: slope(r)
    breakpoints = [0.4 * size] if name == "kinked" else ()
    return mdr.Function(derivative=function, breakpoints=breakpoints)


def samples(size=1.0, scatter=False):
    r = np.linspace(0.0, 1.0, 25)
    height = r**2 / 2 + 0.1 * r**4
    return mdr.Sampled(
        r * size, height * size, 1e-3 * r * size if scatter else None, interpolation=mdr.CubicSpline()
    )


@given(SIZES, st.floats(-6.0, 1.0), st.floats(0.5, 3.0))
@settings(max_examples=examples(20), deadline=None)
def test_a_cusp_has_its_slope_on_the_axis(size, log_slope, exponent):
    """g' = (pi/2) f'(0) of what begins as a cone."""
    slope = 10.0**log_slope
    bent = mdr.Function(derivative=lambda r: slope * (1.0 + 0.3 * (r / size) ** exponent))
    result = equivalent_profile(bent).slope(np.array([0.0, 1e-3 * size, 0.0]))
    assert result[[0, 2]] == pytest.approx(0.5 * math.pi * slope, rel=1e-9)
    round_one = equivalent_profile(mdr.Function(lambda r: slope * r**2 / (2.0 * size)))
    assert round_one.slope(np.array([0.0])) == 0.0


@given(SIZES, st.lists(st.floats(-300.0, -1.0), min_size=1, max_size=5), st.sampled_from([0.0, 0.3, 0.6]))
@settings(max_examples=examples(20), deadline=None)
def test_pressures_next_to_a_cusp_are_those_of_its_closed_form(size, decades, k):
    body = mdr.Graded("1 MPa", depth=size, exponent=k, poisson=1.0 / (2.0 + k)) if k else UNIT
    r = 10.0 ** np.array(decades) * size
    results, closed = (
        mdr.solve(mdr.Contact(tip, body), mdr.indent(size)).field("pressure", r=r).values
        for tip in (mdr.Function(derivative=lambda r: 0.1 + 0.0 * r), mdr.Cone(slope=0.1))
    )
    assert results == pytest.approx(closed, rel=1e-10)


PROFILES = st.tuples(st.sampled_from([*SLOPES, "samples"]), SIZES)


def drawn(case):
    name, size = case
    return samples(size) if name == "samples" else fresh(name, size)


# --- a row is what it would be alone ---------------------------------------------------------------------


@settings(max_examples=5, deadline=None)
@given(PROFILES, st.lists(st.floats(-7.0, -0.7), min_size=3, max_size=8), st.booleans(), st.randoms())
def test_a_row_is_what_it_would_be_alone(case, decades, by_force, random):
    depths = case[1] * 10.0 ** np.array(decades)
    random.shuffle(depths)
    channel = "indentation"
    if by_force:
        line = ElasticLine(equivalent_profile(drawn(case)), mdr.effective_moduli(UNIT).normal)
        depths, channel = normal_force(line, states_at_depth(line, depths)), "normal_force"
    together = mdr.solve(mdr.Contact(drawn(case), UNIT), mdr.Path(**{channel: depths}))
    for i in {0, len(depths) // 2, len(depths) - 1}:
        alone = mdr.solve(mdr.Contact(drawn(case), UNIT), mdr.Path(**{channel: depths[i : i + 1]}))
        for name in NAMES:
            assert worst(together[name].values[i], alone[name].values[0]) < 1e-12
        a = float(alone["contact_radius"][0])
        r = a * np.array([1e-6, 0.3, 0.9])
        for field in ("pressure", "normal_displacement", "equivalent_profile"):
            one, other = (x.field(field, r=r, step=k).values for x, k in ((together, i), (alone, 0)))
            assert worst(one, other) < 1e-11


@pytest.mark.parametrize("channel", ["indentation", "normal_force"])
@pytest.mark.parametrize("name", [*SLOPES, "samples"])
def test_deep_then_shallow_and_shallow_then_deep(name, channel):
    targets = np.geomspace(1e-9, 0.05, 9)
    up, down = (
        mdr.solve(mdr.Contact(drawn((name, 1.0)), UNIT), mdr.Path(**{channel: t}))
        for t in (targets, targets[::-1])
    )
    for quantity in NAMES:
        assert worst(up[quantity].values, down[quantity].values[::-1]) < 1e-12


@settings(max_examples=examples(12), deadline=None)
@given(
    st.sampled_from(["hyperboloid", "quartic", "wavy", "root"]), SIZES, st.floats(-9.0, -0.1), st.randoms()
)
def test_a_breakpoint_at_which_nothing_happens_changes_nothing(name, size, decades, random):
    slope, needless = SLOPES[name](size), size * 10.0**decades
    plain = equivalent_profile(mdr.Function(derivative=lambda r: slope(r)))
    named = equivalent_profile(mdr.Function(derivative=lambda r: slope(r), breakpoints=[needless]))
    x = np.append(np.geomspace(1e-8, 1.0, 60) * size, needless * (1.0 + np.geomspace(1e-6, 1.0, 20)))
    for one in random.sample(x.tolist(), 3):
        # in several steps, inward and outward
        plain.g(one), named.g(one)
    for curve, least in (("g", 2e-14), ("moment", 2e-14), ("squared", 1e-13), ("slope", 1e-12)):
        assert worst(getattr(named, curve)(x), getattr(plain, curve)(x)) < least


@settings(max_examples=examples(12), deadline=None)
@given(st.floats(1.02, 3.0), st.floats(-10.0, 0.0), st.floats(0.5, 5.0), st.floats(-3.0, 2.0))
def test_what_lies_all_within_the_law_of_the_tip_is_no_surer_than_that(power, decades, offset, place):
    height, x = 10.0**decades, 10.0**place
    try:
        line = equivalent_profile(
            mdr.Function(lambda r: offset + height * (r**power + (r / 1e3) ** (3.0 * power)))
        )
        computed = float(line.g(x))
    except mdr.PymdrError:
        return
    ratio = [math.exp(math.lgamma(p / 2 + 1) - math.lgamma(p / 2 + 0.5)) for p in (power, 3.0 * power)]
    exact = math.sqrt(math.pi) * height * (ratio[0] * x**power + ratio[1] * (x / 1e3) ** (3.0 * power))
    assert worst(computed, exact) <= 8.0 * float(line.error(x)[0]) + 1e-14


# --- a callable is asked where it must be, once ----------------------------------------------------------


@pytest.mark.parametrize("size", [1e-12, 1.0, 1e6])
@pytest.mark.parametrize("name", SLOPES)
def test_a_callable_is_evaluated_hardly_beyond_the_contact(name, size):
    for part in (1e-6, 0.03, 0.8):
        profile = fresh(name, size, counted=True)
        equivalent_profile(profile).g(part * size)
        assert profile.derivative.farthest <= 1.2 * part * size
        depth = float(equivalent_profile(fresh(name, size)).g(part * size))
        for ask in (
            lambda line, d=depth: line.inverse([d, 1e-3 * d]),
            lambda line, d=depth: line.place(np.array([0.3 * d, d])),
        ):
            profile = fresh(name, size, counted=True)
            ask(equivalent_profile(profile))
            assert profile.derivative.farthest <= 1.2 * part * size
        moment = float(equivalent_profile(fresh(name, size)).moment(part * size))
        profile = fresh(name, size, counted=True)
        equivalent_profile(profile).inverse_moment(moment)
        assert profile.derivative.farthest <= 1.2 * part * size


@pytest.mark.parametrize("name", ["hyperboloid", "quartic", "wavy"])
def test_a_callable_is_never_evaluated_beyond_its_largest_radius(name):
    profile = mdr.Function(derivative=Counted(SLOPES[name](1.0)), max_radius=0.7)
    line = equivalent_profile(profile)
    deepest = float(line.g(0.7))
    assert line.inverse([0.5 * deepest, deepest * (1.0 - 1e-9), 2.0 * deepest])[2] == math.inf
    assert np.isnan(line.g(np.array([0.71, 5.0]))).all()
    contact = mdr.Contact(profile, UNIT)
    result = mdr.solve(contact, mdr.indent(0.9 * deepest, steps=3))
    result.field("pressure", step=None)
    result.field("gap")
    with pytest.raises(mdr.PathError, match=r"r = 700 mm.*the largest indentation that it allows is"):
        mdr.solve(contact, mdr.indent(1.01 * deepest))
    assert profile.derivative.farthest <= 0.7


@pytest.mark.parametrize("path", [mdr.indent(1e-4, steps=3), mdr.load(1e-6, steps=3)])
@pytest.mark.parametrize("name", SLOPES)
def test_solve_evaluates_no_radius_beyond_its_claims(name, path):
    profile = fresh(name, counted=True)
    result = mdr.solve(mdr.Contact(profile, UNIT), path)
    largest = float(result["contact_radius"].max())
    stated = 1024.0 * largest
    assert "no other contact exists up to r = " in result.claims["contact_radius"].reason
    assert largest < profile.derivative.farthest <= stated * (1.0 + 1e-9)


@settings(max_examples=4, deadline=None)
@given(st.sampled_from(list(SLOPES)), SIZES)
def test_one_tip_is_mapped_once(name, size):
    profile = fresh(name, size, counted=True)
    function = profile.derivative
    path = mdr.indent(0.1 * size, steps=4)
    first = mdr.solve(mdr.Contact(profile, UNIT), path)
    first.field("pressure")
    once = function.calls
    for body in (UNIT, mdr.Elastic("210 GPa", 0.3), mdr.Elastic("1 kPa", 0.5)):
        again = mdr.solve(mdr.Contact(profile, body), path)
        again.field("pressure")
        assert np.array_equal(again["contact_radius"].values, first["contact_radius"].values)
    # the largest slope in the contact, for the assumption of small slopes, is looked up anew
    assert function.calls - once <= 3 * 12
    line = equivalent_profile(profile)
    assert equivalent_profile(mdr.Function(derivative=function, breakpoints=profile.breakpoints)) is line
    x = float(first["contact_radius"][-1]) * np.geomspace(1e-3, 1.0, 1000)
    line.g(x)
    before = function.calls
    for _ in range(2):
        line.g(x), line.slope(x), line.moment(x), line.squared(x), line.inverse(line.g(x))
    assert function.calls == before


# --- inverses --------------------------------------------------------------------------------------------


@settings(max_examples=examples(12), deadline=None)
@given(PROFILES, st.integers(0, 2**32 - 1))
def test_the_inverse_of_a_thousand_values_is_exact_to_rounding(case, seed):
    line = equivalent_profile(drawn(case))
    x = 0.9 * case[1] * 10.0 ** np.random.default_rng(seed).uniform(-9.0, 0.0, 1000)
    g, moment = line.g(x), line.moment(x)
    for result, value, curve, slope in (
        (line.inverse(g), g, line.g, line.slope(x)),
        (line.inverse_moment(moment), moment, line.moment, x * line.slope(x)),
    ):
        assert np.all(result[np.argsort(value)] == np.sort(result))
        # a rounding of the value moves x by eps value / slope, and x itself is rounded
        condition = value / (x * slope)
        assert np.all(np.abs(result / x - 1) <= 2e-15 * (1.0 + condition))
        assert worst(curve(result), value) < 4e-15 * (1.0 + float(np.max(1.0 / condition)))
    place = line.place(g)
    assert worst(line.g(place), g) < 4e-15
    shuffled = np.random.default_rng(seed).permutation(1000)
    assert np.array_equal(
        line.inverse(g[shuffled].reshape(10, 100)), line.inverse(g)[shuffled].reshape(10, 100)
    )


# --- threads ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [*SLOPES, "samples"])
def test_threads_share_one_profile(name):
    shared = drawn((name, 1.0))
    paths = [mdr.indent(0.05 * 4.0**-k, steps=5) for k in range(4)] + [
        mdr.load(1e-2 * 4.0**-k, steps=5) for k in range(4)
    ]
    computed, failures = [None] * 8, []
    start = threading.Barrier(8)

    def work(i):
        try:
            start.wait(timeout=60)
            result = mdr.solve(mdr.Contact(shared, UNIT), paths[i])
            a = float(result["contact_radius"][-1])
            computed[i] = result, result.field("pressure", r=a * np.array([1e-4, 0.5, 0.99])).values
        except Exception as error:
            failures.append(error)

    threads = [threading.Thread(target=work, args=(i,)) for i in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert failures == []
    for i, path in enumerate(paths):
        alone = mdr.solve(mdr.Contact(drawn((name, 1.0)), UNIT), path)
        for quantity in NAMES:
            assert worst(computed[i][0][quantity].values, alone[quantity].values) < 1e-12
        a = float(alone["contact_radius"][-1])
        assert (
            worst(computed[i][1], alone.field("pressure", r=a * np.array([1e-4, 0.5, 0.99])).values) < 1e-11
        )


# --- files -----------------------------------------------------------------------------------------------

SAVED = {
    "hyperboloid": lambda size: mdr.Function(hyperboloid_f(size), derivative=hyperboloid(size)),
    "power": lambda size: mdr.Function(lambda r: size * (r / size) ** 0.3),
    "kinked": lambda size: mdr.Function(derivative=kinked(size), breakpoints=[0.4 * size]),
    "nested": lambda size: Sum(
        (
            mdr.Cone(slope=0.05),
            Sum((mdr.Function(derivative=quartic(size)), samples(size, scatter=True))),
        )
    ),
}


@pytest.mark.parametrize("size", [1e-9, 1.0])
@pytest.mark.parametrize("name", SAVED)
def test_files_and_pickles_give_the_same_fields(tmp_path, name, size):
    contact = mdr.Contact(SAVED[name](size), UNIT)
    depths = size * np.array([1e-4, 0.1, 0.02]) * (5.0 if name == "power" else 1.0)
    result = mdr.solve(contact, mdr.Path(indentation=depths))
    result.save(tmp_path / "result.nc")
    for again in (mdr.open_result(tmp_path / "result.nc"), pickle.loads(pickle.dumps(result))):
        assert list(again.data) == list(result.data)
        for quantity in result.data:
            assert np.array_equal(again.data[quantity].values, result.data[quantity].values)
        for step in range(3):
            a = float(result["contact_radius"][step])
            r = a * np.array([1e-9, 1e-6, 1e-3, 0.3, 0.9, 0.999, 1.001, 1.2, 1.9])
            for field in ("pressure", "normal_displacement", "gap", "equivalent_profile", "spring_force"):
                one, other = (x.field(field, r=r, step=step).values for x in (result, again))
                touching = one == 0.0
                assert np.all(other[touching] == 0.0)
                assert worst(other[~touching], one[~touching]) < 1e-10
        solved = mdr.solve(again.contact, mdr.Path(indentation=depths))
        for quantity in NAMES:
            assert worst(solved[quantity].values, result[quantity].values) < 1e-12
        if name == "nested":
            assert again.bands.keys() == result.bands.keys() != set()
            for quantity, (low, high) in result.bands.items():
                assert np.array_equal(again.bands[quantity][0], low)
                assert np.array_equal(again.bands[quantity][1], high)
                assert worst(solved.bands[quantity][0], low) < 1e-11


@pytest.mark.parametrize("name", [*SLOPES, "samples"])
def test_a_pickled_line_goes_on(name):
    profile = (
        samples()
        if name == "samples"
        else mdr.Function(derivative=SLOPES[name](1.0), breakpoints=[0.4] if name == "kinked" else ())
    )
    result = mdr.solve(mdr.Contact(profile, UNIT), mdr.indent(1e-3))
    kept = pickle.loads(pickle.dumps(result))
    x = np.geomspace(1e-9, 1.0, 30) * float(result["contact_radius"][0])
    assert worst(equivalent_profile(kept.contact.profile).g(x), equivalent_profile(profile).g(x)) < 1e-12


# --- arrays ----------------------------------------------------------------------------------------------


def test_what_a_result_gives_does_not_change_it():
    contact = mdr.Contact(fresh("wavy"), UNIT, friction=mdr.Coulomb(0.3))
    for path, profile_read in (
        (mdr.indent(0.1, steps=3), mdr.Contact(contact.profile, UNIT)),
        (
            mdr.indent(0.1, steps=3) >> mdr.shift(0.01, steps=3),
            contact,
        ),
    ):
        first = mdr.solve(profile_read, path)
        for result in (first, pickle.loads(pickle.dumps(first))):
            r = np.linspace(0.0, 0.4, 5)
            fields = {name: result.field(name, r=r).values.copy() for name in ("pressure", "gap")}
            rows = {name: result[name].values.copy() for name in result.data}
            for name in rows:
                values = result[name]
                values *= 1e3
                values.values[...] = 7.0
                result.to(name, result[name].attrs["units"] or "1").values[...] = 7.0
                with pytest.raises(ValueError, match="read-only"):
                    result.data[name].values[...] = 7.0
            result.to_xarray()["normal_force"].values[...] = 7.0
            frame = result.to_dataframe()
            frame.loc[:, "normal_force"] = 7.0
            for claim in result.claims.values():
                for kept in (claim.where, claim.error):
                    if kept is not None:
                        with pytest.raises(ValueError, match="read-only"):
                            kept[...] = 0
            for name in fields:
                result.field(name).values[...] = 7.0
                coordinate = result.field(name)["r"].values
                if coordinate.flags.writeable:
                    coordinate[...] = 7.0
            for name, kept in fields.items():
                assert np.array_equal(result.field(name, r=r).values, kept)
            for name, kept in rows.items():
                assert np.array_equal(result[name].values, kept)


@pytest.mark.parametrize("name", [*SLOPES, "samples"])
def test_what_a_line_gives_does_not_change_it(name):
    line = ElasticLine(equivalent_profile(drawn((name, 1.0))), 1.0)
    x = np.geomspace(1e-6, 0.8, 7)
    d = line.equivalent.g(x)
    options = {
        **{
            n: lambda n=n: getattr(line.equivalent, n)(x)
            for n in ("g", "slope", "moment", "squared", "error")
        },
        "inverse": lambda: line.equivalent.inverse(d),
        "offset": lambda: line.equivalent.place(d).offset,
        "base": lambda: line.equivalent.place(d).base,
        "radius": lambda: states_at_depth(line, d).contact_radius,
        "force": lambda: states_at_force(line, d).indentation,
        "pressure": lambda: line.equivalent.pressure_integral(x, 0.8),
    }
    for option in options.values():
        before = option().copy()
        given_ = option()
        if given_.flags.writeable:
            given_[...] = 7.0
        assert np.array_equal(option(), before)


@settings(max_examples=5, deadline=None)
@given(
    st.integers(60, 250), st.floats(0.0, 0.03), st.integers(0, 10**6), st.floats(0.01, 0.99), st.booleans()
)
def test_bunched_panels_lead_back_to_the_surface(count, noise, seed, fraction, shape_preserving):
    """The line leads back to the samples, and its integral over a disk of pressures is the load."""
    r = np.linspace(0.0, 1.0, count)
    f = r**2 / 2 * (1.0 + noise * np.random.default_rng(seed).standard_normal(count))
    interpolation = mdr.ShapePreserving() if shape_preserving else mdr.CubicSpline()
    tip = mdr.Sampled(r, f, interpolation=interpolation)
    line = equivalent_profile(tip)
    at = np.sort(np.random.default_rng(seed + 1).uniform(1e-6, 1.0, 200))
    gap = 2.0 / np.pi * line.gap_integral(at, 0.0)
    ups_and_downs = float(np.abs(np.diff(line.g(np.linspace(0.0, 1.0, 20_001)))).sum())
    allowed = (1e-13 + float(line.slope_error(1.0))) * ups_and_downs
    assert np.max(np.abs(gap - tip.gap(at))) < allowed
    beyond = at[at > fraction]
    parts = line.gap_between(beyond, 0.5 * fraction, fraction) + line.gap_integral(beyond, fraction)
    whole = line.gap_integral(beyond, 0.5 * fraction)
    assert np.max(np.abs(parts - whole), initial=0.0) < 1e-14 * ups_and_downs
    # x = sqrt(r^2 + t^2) leaves g' / x, whose roots behind samples are graded away
    for radius in (1e-3 * fraction, 0.3 * fraction, 0.98 * fraction):
        samples = r[(r > radius) & (r < fraction)]
        edges = np.sqrt(np.append(samples, fraction) ** 2 - radius**2)
        s, w = np.polynomial.legendre.leggauss(24)
        start, width = np.append(0.0, edges[:-1])[:, None], np.diff(edges, prepend=0.0)[:, None]
        u = 0.5 * (s + 1.0)
        x = np.sqrt((start + width * u**2) ** 2 + radius**2)
        value = line.slope(x) / x * width * u * w
        size = np.abs(value).sum()
        computed = float(line.pressure_integral(np.array([radius]), fraction)[0])
        assert abs(computed - value.sum()) < 1e-7 * size


# --- beside breakpoints ----------------------------------------------------------------------------------


@settings(max_examples=examples(12), deadline=None)
@given(
    st.lists(st.floats(-9.0, -0.3), min_size=1, max_size=3),
    st.lists(st.floats(-3.0, 0.0), min_size=4, max_size=4),
    st.lists(st.floats(-11.0, -0.5), min_size=2, max_size=6),
    st.sampled_from(["f", "derivative"]),
    SIZES,
    st.randoms(),
)
def test_cones_that_begin_close_to_one_another(closeness, heights, offsets, given_as, size, random):
    """Depth after depth outward over kinks as close as 1e-9 of their radius: no stretch between them is lost."""
    b, radii = size, [size]
    for decade in closeness:
        b = float(b + b * 10.0**decade)
        radii.append(b)
    slopes = [1.0, *(10.0**h for h in heights[: len(radii)])]
    radii = [0.0, *radii]

    def f(r):
        return sum(s * np.maximum(r - b, 0.0) for s, b in zip(slopes, radii, strict=False))

    def derivative(r):
        return sum(s * (r > b) for s, b in zip(slopes, radii, strict=False))

    profile = mdr.Function(
        f if given_as == "f" else None,
        radii[1:],
        None if given_as == "f" else derivative,
        max_radius=1e3 * size,
    )
    line = equivalent_profile(profile)
    bases = np.repeat(radii[1:], len(offsets))
    delta = np.tile(10.0 ** np.sort(offsets), len(radii) - 1) * size
    order = np.argsort(bases + delta)
    bases, delta = bases[order], delta[order]
    exact = np.zeros(bases.size)
    for s, kink in zip(slopes, radii, strict=False):
        away = np.maximum((bases - kink) + delta, 0.0)
        exact += s * (kink + away) * np.arctan2(np.sqrt(away * (2.0 * kink + away)), kink)
    computed = np.concatenate([line.g(line.place(exact[i : i + 1])) for i in range(exact.size)])
    place = Place(bases, delta)
    claimed = np.maximum(line.error(place)[:, 0], 1e-14)
    assert np.all(np.abs(computed / exact - 1.0) <= 1e-13)
    assert np.all(np.abs(line.g(place) / exact - 1.0) <= 10.0 * claimed)
    random.shuffle(order)
    alone = equivalent_profile(profile)
    again = np.concatenate([alone.g(place.take(slice(i, i + 1))) for i in order])
    assert np.all(np.abs(again / line.g(place.take(order)) - 1.0) <= 10.0 * claimed[order])


@settings(max_examples=examples(20), deadline=None)
@given(
    st.floats(1.1, 12.0),
    SIZES,
    st.lists(st.floats(-17.0, -4.0), min_size=2, max_size=6),
    st.sampled_from(["f", "derivative"]),
)
def test_contact_that_begins_at_a_radius_is_a_power_there(n, size, decades, given_as):
    """f = ((r - b)_+ / b)^n: g = n B(n, 1/2) sqrt(1/2) (delta / b)^(n - 1/2) (1 + O(delta / b)), and back."""
    b = size
    exponent = n if given_as == "derivative" else round(n * 4.0) / 4.0

    def f(r):
        return b * (np.maximum(r - b, 0.0) / b) ** exponent

    def derivative(r):
        return exponent * (np.maximum(r - b, 0.0) / b) ** (exponent - 1.0)

    profile = mdr.Function(
        f if given_as == "f" else None, [b], None if given_as == "f" else derivative, max_radius=10.0 * b
    )
    line = equivalent_profile(profile)
    delta = 10.0 ** np.array(decades)
    lead = (
        exponent
        * math.exp(math.lgamma(exponent) + math.lgamma(0.5) - math.lgamma(exponent + 0.5))
        / math.sqrt(2.0)
    )
    with np.errstate(under="ignore"):
        depth = b * lead * delta ** (exponent - 0.5)
    known = depth > 1e-290
    delta, depth = delta[known], depth[known]
    place = Place(np.full(delta.size, b), b * delta)
    error = 10.0 * np.maximum(line.error(place)[:, 0], 1e-14)
    assert np.all(np.abs(line.g(place) / depth - 1.0) <= error + 2.0 * delta)
    result = line.place(line.g(place))
    # a kink of broken order may have a second panel beside it, whose offsets are as fine
    assert np.all(np.abs(((result.base - b) + result.offset) / (b * delta) - 1.0) <= 1e-13)


@settings(max_examples=examples(15), deadline=None)
@given(
    st.sampled_from([1.0, 1.5, 2.0, 2.5, 3.0]),
    SIZES,
    st.floats(-6.0, 0.0),
    st.floats(-4.0, 1.0),
    st.lists(st.floats(-13.0, -5.0), min_size=1, max_size=3),
    st.booleans(),
    st.booleans(),
)
@example(1.5, 1.0, -2.0, 0.0, [-10.0], True, False)
@example(2.0, 1.0, -4.0, -1.4, [-10.0], False, True)
@example(3.0, 1.0, -1.0, -3.0, [-11.0], True, True)
@example(2.0, 0.9999997255105045, -1.0, 0.0, [-5.0], False, False)
@example(3.0, 10.0**5.515625, -1.0, 0.0, [-6.0], False, False)
@example(
    3.0, 99.6355180451584, 0.0, -1.2312322472707464, [-9.79861003244675, -11.544003071532895], False, True
)
@example(2.0, 99.6355180451584, 0.0, -1.0, [-7.0], False, False)
@example(2.0, 10.0**1.875, 0.0, -1.0, [-5.0], False, False)
def test_contact_that_begins_in_the_rounding_of_an_offset(n, size, height, offset, decades, named, by_force):
    """f = c + h ((r - b)_+ / b)^n: the edge lies where the rounding of f tells nothing, and is claimed as no surer."""
    b, h, c = size, size * 10.0**height, size * 10.0**offset
    profile = mdr.Function(lambda r: c + h * (np.maximum(r - b, 0.0) / b) ** n, [b] if named else ())
    delta = 10.0 ** np.sort(decades)
    lead = n * math.exp(math.lgamma(n) + math.lgamma(0.5) - math.lgamma(n + 0.5)) / math.sqrt(2.0)
    depth = h * lead * delta ** (n - 0.5)
    # all of g rises beside b
    path = mdr.Path(normal_force=2.0 * depth * b) if by_force else mdr.Path(indentation=depth)
    try:
        result = mdr.solve(mdr.Contact(profile, UNIT), path)
    except mdr.ProblemError:
        # only noise
        return
    if "contact_radius" not in result.data:
        return
    computed, claim = result.data["contact_radius"].values, result.claims["contact_radius"]
    valid = np.isfinite(computed)
    off = np.abs(computed / (b * (1.0 + delta)) - 1.0)
    assert np.all(off[valid] <= (10.0 * claim.error + 4.0 * delta**2 + 4e-16)[valid])


@settings(max_examples=examples(15), deadline=None)
@given(SIZES, st.floats(0.0, 1.0), st.floats(0.3, 5.0), st.floats(-6.0, 0.0))
@example(3.3997874937862134e-08, 0.0, 3.5, -4.0)
@example(1.0, 0.0, 1.0, -2.0)
def test_maps_that_begin_at_an_unnamed_kink(b, shift, last, slope):
    """f' = s r / b up to b, s b / r beyond: s(x) by Gauss and Legendre over g = s b y^2 / (1 + w) + s b arcosh y."""
    b, s = b * 2.0**shift, 10.0**slope
    x = b * 10.0**last
    profile = mdr.Function(derivative=lambda r: np.where(r > b, s * b / np.maximum(r, b), s * r / b))

    def g(y):
        away = np.sqrt(np.maximum(y - 1.0, 0.0) * (y + 1.0))
        return s * b * np.where(y > 1.0, y / (y + away) + np.arcsinh(away), y * y)

    # y = cosh(t) is smooth on both sides
    node, weight = np.polynomial.legendre.leggauss(60)
    inner = 0.5 * (node + 1.0)
    total = 0.5 * b * np.sum(weight * (g(x / b) - g(inner)) ** 2)
    ends = np.linspace(0.0, math.acosh(x / b), 9)
    for low, high in itertools.pairwise(ends):
        t = low + (high - low) * inner
        total += 0.5 * (high - low) * b * np.sum(weight * np.sinh(t) * (g(x / b) - g(np.cosh(t))) ** 2)
    line = equivalent_profile(profile)
    at = np.array([x])
    assert abs(line.squared(at)[0] / total - 1.0) <= 10.0 * line.error(at)[0, 3] + 1e-13


class Blind(CurveSource):
    """A slope whose kinks are not looked for."""

    def kinks(self, low, high):
        return []


@settings(max_examples=examples(10), deadline=None)
@given(
    st.sampled_from([1.5, 2.0, 2.5, 3.0]),
    SIZES,
    st.floats(-6.0, 0.0),
    st.lists(st.floats(-11.0, -5.0), min_size=1, max_size=4),
    st.booleans(),
)
@example(2.0, 1.0, -3.0, [-10.0], False)
@example(1.5, 1.0, -3.0, [-6.6], False)
def test_rounded_flats_that_give_f_alone_are_exact_next_to_their_edges(n, b, height, decades, by_force):
    """f = h ((r - b)_+ / b)^n has its digits at every radius: so have results, and claims say so."""
    h = b * 10.0**height
    delta = 10.0 ** np.sort(decades)
    contact = mdr.Contact(mdr.Function(lambda r: h * (np.maximum(r - b, 0.0) / b) ** n, [b]), UNIT)
    lead = n * math.exp(math.lgamma(n) + math.lgamma(0.5) - math.lgamma(n + 0.5)) / math.sqrt(2.0)
    depth = h * lead * delta ** (n - 0.5)
    path = mdr.Path(normal_force=2.0 * depth * b) if by_force else mdr.Path(indentation=depth)
    result = mdr.solve(contact, path)
    # int (d - g)^2 dx over the flat, and a part delta of that
    expected = {"normal_force": 2.0 * depth * b, "indentation": depth, "elastic_energy": depth**2 * b}
    for name, exact in expected.items():
        assert result.claims[name].level is mdr.Level.EXACT
        assert np.all(np.abs(result.data[name].values / exact - 1.0) <= 4.0 * delta + 1e-9)
    assert result.claims["pressure"].level is mdr.Level.EXACT


@settings(max_examples=examples(20), deadline=None)
@given(
    SIZES,
    st.floats(-3.0, 1.0),
    st.sampled_from([0.3, 0.5, 0.8, 1.4]),
    st.floats(0.0, 1.0),
    st.floats(-9.0, 0.3),
)
def test_the_value_at_a_breakpoint_itself_belongs_to_neither_side(b, decades, p, jump, place):
    rise = 10.0**decades

    def beyond(r):
        return jump + rise * (np.maximum(r - b, 0.0) / b) ** p

    sides = [
        lambda r: np.where(r > b, r / b + beyond(r), r / b),
        lambda r: np.where(r >= b, r / b + beyond(r), r / b),
        lambda r: np.where(r == b, np.where(r > 0.0, 40.0, 0.0), np.where(r > b, r / b + beyond(r), r / b)),
    ]
    x = b * np.array([0.5, 1.0 + 10.0**place, 2.5])
    curves = []
    for side in sides:
        line = equivalent_profile(mdr.Function(derivative=side, breakpoints=[b]))
        curves.append(np.concatenate([line.g(x), line.moment(x), line.squared(x), line.slope(x)]))
        # what the power misses within a part 1e-12 of b is not felt beyond
        assert np.max(line.error(x)[:, [0, 2]]) < 1e-12
    assert worst(curves[1], curves[0]) < 1e-12
    assert worst(curves[2], curves[0]) < 1e-12


@settings(max_examples=examples(40), deadline=None)
@given(
    st.sampled_from(["rounded flat", "truncated sphere", "root", "cone"]),
    st.one_of(st.just(0.0), st.floats(-0.9, 0.9)),
    st.floats(0.1, 1.0),
    st.floats(0.5, 3.0),
    st.floats(-6.0, -0.1),
    st.integers(0, 2**32 - 1),
)
def test_the_inverse_next_to_where_a_panel_begins_is_met(kind, k, b, R, decades, seed):
    profile = {
        "rounded flat": lambda: mdr.RoundedFlat(b, R),
        "truncated sphere": lambda: mdr.TruncatedSphere(radius=R + 1.0, flat_radius=b),
        "root": lambda: mdr.Function(
            derivative=lambda r: np.sqrt(np.maximum(r - b, 0.0)) + r / R, breakpoints=[b]
        ),
        "cone": lambda: mdr.Function(derivative=lambda r: r / R + np.where(r > b, 0.3, 0.0), breakpoints=[b]),
    }[kind]()
    line = equivalent_profile(profile, k)
    panels = line.map_to(b * (1.0 + 10.0**decades)).panels
    rng = np.random.default_rng(seed)
    i = rng.integers(0, panels.count, 400)
    offset = panels.low[i] + panels.width[i] * 10.0 ** rng.uniform(-12.0, -2.0, i.size)
    for curve, inverse in ((line.g, line.place), (line.moment, line.place_of_moment)):
        values = curve(Place(panels.base[i], offset))
        values = values[values > 0.0]
        assert worst(curve(inverse(values)), values) < 1e-13


@settings(max_examples=examples(20), deadline=None)
@given(SIZES, st.floats(-6.0, 0.0), st.sampled_from([1.0, 1.5, 2.0, 3.0]))
@example(1.0, 0.0, 2.0)
def test_a_slope_is_a_number_at_the_edge_of_a_flat_end_below_rounding(b, drowned, n):
    """f = c + b ((r - b)_+ / b)^n, lost in c near b: what is left of the rounding there has an infinite power or none."""
    c = b * 10.0**drowned
    line = equivalent_profile(mdr.Function(lambda r: c + b * (np.maximum(r - b, 0.0) / b) ** n, [b]))
    line.map_to(2.0 * b)
    slope = float(line.slope(np.array([b]))[0])
    assert not math.isnan(slope)
    assert slope == math.inf or n > 1.0


@settings(max_examples=8, deadline=None)
@given(SIZES, st.floats(-6.0, 0.0), st.sampled_from([1.5, 2.0, 3.0]), st.floats(-1.0, 1.0))
@example(1.0, 0.0, 2.0, 0.0)
def test_what_pressures_feel_of_errors_here_and_there(b, drowned, n, last):
    """f = c + b ((r - b)_+ / b)^n, lost in c near b: int_r^a |error of g'| K dx over int_r^a |g'| K dx, brute force."""
    c = b * 10.0**drowned
    line = equivalent_profile(mdr.Function(lambda r: c + b * (np.maximum(r - b, 0.0) / b) ** n, [b]))
    a = b * (1.0 + 10.0**last)
    image = line.map_to(a)
    start = image.panels.start
    error = image.error[: int(np.searchsorted(start, a)), 1]
    felt = line.slope_error(np.array([a]))[0]
    node, weight = np.polynomial.legendre.leggauss(20)
    s = 0.5 * (node + 1.0)
    # where errors are felt most, and elsewhere
    for r in (*start[np.argsort(error)[-4:]], *(b + (a - b) * np.array([1e-6, 1e-3, 0.3, 0.9, 0.99]))):
        edges = np.unique(np.concatenate([[r], start[(start > r) & (start < a)], [a]]))
        low, width = edges[:-1, None], np.diff(edges)[:, None]
        x, place = low + width * s * s, Place(np.broadcast_to(low, (low.size, s.size)), width * s * s)
        # the nodes of narrow panels round to their ends
        part = width * s * weight / np.sqrt((low - r + width * s * s) * (x + r)) * np.abs(line.slope(place))
        of = np.searchsorted(start, 0.5 * (edges[1:] + edges[:-1])) - 1
        assert np.sum(error[of, None] * part) <= 1.5 * felt * np.sum(part)


@settings(max_examples=examples(10), deadline=None)
@given(SIZES, st.lists(st.floats(-9.0, 1.0), min_size=1, max_size=4), st.floats(-2.0, 2.0))
def test_an_undetected_jump_affects_radii_far_outside(b, decades, fraction):
    """f' = s r / b + t (r > b): g, g', m and s are no farther off than ten times their errors."""
    t = 10.0**fraction
    profile = mdr.Function(derivative=lambda r: r / b + np.where(r > b, t, 0.0))
    line = PanelLine(Blind(profile))
    x = b * (1.0 + 10.0 ** np.array(decades))
    root = np.sqrt((x - b) * (x + b))
    angle = np.arctan2(root, b)
    exact = (
        x * x / b + t * x * angle,
        2.0 * x / b + t * (angle + b / root),
        2.0 * x**3 / (3.0 * b) + 0.5 * t * (x * x * angle + b * root),
    )
    for k, (computed, true) in enumerate(zip((line.g(x), line.slope(x), line.moment(x)), exact, strict=True)):
        assert np.all(np.abs(computed / true - 1.0) <= 10.0 * line.error(x)[:, k] + 1e-13)
    squared = [_square_of_a_kinked_paraboloid(b, t, at) for at in x]
    assert np.all(np.abs(line.squared(x) / squared - 1.0) <= 10.0 * line.error(x)[:, 3] + 1e-12)


def _square_of_a_kinked_paraboloid(b, t, x):
    """The integral of (g(x) - g(y))^2 from y = 0 to x by Gauss and Legendre, in the root of y - b beyond b."""
    node, weight = np.polynomial.legendre.leggauss(80)
    inner = 0.5 * (node + 1.0)

    def g(y):
        return y * y / b + t * y * np.arctan2(np.sqrt(np.maximum(y - b, 0.0) * (y + b)), b)

    total = 0.5 * b * np.sum(weight * (g(x) - g(b * inner)) ** 2)
    width = x - b
    return total + width * np.sum(weight * inner * (g(x) - g(b + width * inner**2)) ** 2)


@settings(max_examples=examples(10), deadline=None)
@given(SIZES, st.lists(st.floats(-20.0, -1.0), min_size=1, max_size=5))
def test_the_law_outside_replaces_the_rounding_near_the_tip(R, decades):
    """R - sqrt(R^2 - r^2) is 0 to rounding near the tip: depths in any order, each alone or after others."""
    profile = mdr.Function(lambda r: R - np.sqrt(R * R - r * r), max_radius=0.999 * R)
    a = R * 10.0 ** np.array(decades)
    depth = a * np.arctanh(a / R)
    line = equivalent_profile(profile)
    for x, d in zip(a, depth, strict=True):
        place = line.place(np.array([d]))
        claimed = 10.0 * line.error(place)[0, 0] + 1e-14
        assert abs(place.x[0] / x - 1.0) <= claimed
        assert claimed < 1e-7


@settings(max_examples=examples(10), deadline=None)
@given(
    st.floats(1.05, 4.0), SIZES, st.floats(-3.0, 0.0), st.lists(st.floats(0.0, 0.9), min_size=1, max_size=5)
)
def test_pressure_through_a_dead_zone(n, b, last, shares):
    """Contact of ((r - b)_+ / b)^n b: the force under the pressure, and the pressure by Gauss and Jacobi."""
    from scipy.special import roots_jacobi

    profile = mdr.Function(None, [b], lambda r: n * (np.maximum(r - b, 0.0) / b) ** (n - 1.0))
    line = equivalent_profile(profile)
    delta = b * 10.0**last
    line.map_to(b + delta)
    r = b * np.array(shares)
    computed = line.pressure_integral(r, Place(np.array(b), np.array(delta)))
    # g' / offset^(n - 3/2) is smooth beside b; with y = offset / delta the rest is in the weights
    z, w = roots_jacobi(80, 0.0, n - 1.5)
    y, w = (z + 1.0) / 2.0, w / 2.0 ** (n - 0.5)
    place = Place(np.full(y.size, b), delta * y)
    smooth = line.slope(place) / y ** (n - 1.5)
    x = place.x
    exact = [delta * np.sum(w * smooth / np.sqrt((x - q) * (x + q))) for q in r]
    assert worst(computed, exact) < 1e-12


@settings(max_examples=examples(15), deadline=None)
@given(
    st.lists(st.tuples(st.floats(-4.0, 0.0), st.floats(-6.0, 0.0)), min_size=1, max_size=4),
    st.lists(st.tuples(st.booleans(), st.integers(0, 3), st.floats(0.8, 1.0)), min_size=1, max_size=8),
    SIZES,
    st.sampled_from(["f", "f + 1", "derivative"]),
)
@example([(-3.0, -6.0)], [(False, 0, 1.0)], 1.0, "f + 1")
@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_the_order_of_evaluations_changes_nothing(shoulders, first_read, size, given_as):
    """f' = sum of s r / b up to b, s b / r beyond; g = s (x^2 - x sqrt(x^2 - b^2)) / b + s b arcosh(x / b) from there on."""
    terms = [(size * 10.0**b, 10.0**s) for b, s in shoulders]
    # an offset rounds f, so that it is differentiated on panels of its own; one that drowns all of it is refused
    offset = min(size, 1e7 * max(s * b for b, s in terms)) if given_as == "f + 1" else 0.0

    def f(r):
        return offset + sum(
            np.where(r > b, s * b * (0.5 + np.log(np.maximum(r, b) / b)), s * r * r / (2.0 * b))
            for b, s in terms
        )

    def derivative(r):
        return sum(np.where(r > b, s * b / np.maximum(r, b), s * r / b) for b, s in terms)

    def exact(x):
        g = 0.0 * x
        for b, s in terms:
            away = np.sqrt(np.maximum(x - b, 0.0) * (x + b))
            g = g + np.where(x > b, s * (x * b / (x + away) + b * np.arcsinh(away / b)), s * x * x / b)
        return g

    marks = sorted(b for b, _ in terms)
    profile = mdr.Function(
        None if given_as == "derivative" else f,
        marks,
        derivative if given_as == "derivative" else None,
        max_radius=10.0 * size,
    )
    line = equivalent_profile(profile)
    for by_depth, k, fraction in first_read:
        # panels end at breakpoints
        x = np.array([marks[k % len(marks)] * fraction])
        if by_depth:
            line.overlap_radius(float(exact(x)[0]))
        else:
            line.turning_points(float(x[0]))
    x = np.outer(marks, [0.3, 0.81, 0.93, 0.99, 1.0001, 1.1]).ravel()
    for i in np.random.default_rng(len(first_read)).permutation(x.size):
        at = x[i : i + 1]
        assert abs(line.g(at)[0] / exact(at)[0] - 1.0) <= 10.0 * line.error(at)[0, 0] + 1e-13


@settings(max_examples=examples(15), deadline=None)
@given(st.floats(3.0, 9.0), st.floats(0.01, 0.4), st.sampled_from([-1.0, 1.0]), SIZES)
@example(4.644, 0.2, 1.0, 2.6e-15)
@example(6.75, 0.125, -1.0, 1.0)
@example(7.0, 0.125, -1.0, 1.0)
def test_radii_that_lose_their_digits_make_no_kinks(distance, height, sign, size):
    """f' of r^2 / (2 R) + h exp(-(r - m)^2 / (2 w^2)) has stairs where r << m; g = pi f'(0) x / 2 + f''(0) x^2 there."""
    m, w, R = size, size / distance, 1e3 * size
    h = sign * height * w * w / R / (1.0 + 2.0 / distance)

    def derivative(r):
        return r / R - h / w * ((r - m) / w) * np.exp(-0.5 * ((r - m) / w) ** 2)

    far = math.exp(-0.5 * distance**2)
    start = h * m / w**2 * far
    bend = 1.0 / R - h / w**2 * far * (1.0 - distance**2)
    line = equivalent_profile(mdr.Function(derivative=derivative))
    x = size * 10.0 ** np.arange(-15.0, -8.0)
    exact = 0.5 * math.pi * start * x + bend * x * x
    # a negative start is a hollow whose g falls first
    scale = 0.5 * math.pi * abs(start) * x + bend * x * x
    rest = distance**3 * x**3 / (R * size)
    assert np.all(np.abs(line.g(x) - exact) <= 1e-11 * scale + rest)


@settings(max_examples=8, deadline=None)
@given(SIZES, st.floats(-12.0, -8.5), st.floats(-4.0, -1.0))
def test_what_was_mapped_before_a_law_showed_is_mapped_again(R, small, large):
    """A map of rounding alone is no answer any more once larger radii have told the law of the tip."""
    line = equivalent_profile(mdr.Function(lambda r: R - np.sqrt(R * R - r * r), max_radius=0.999 * R))
    x = R * 10.0**small
    line.map_to(x)
    line.source.foresee(R * 10.0**large)
    assert line.g(x) / (x * np.arctanh(x / R)) == pytest.approx(1.0, abs=10.0 * line.error(x)[0] + 1e-14)
    assert line.error(x)[0] < 1e-8


@settings(max_examples=examples(25), deadline=None)
@given(
    exponent=st.floats(0.0, 0.9),
    flat=st.floats(0.01, 0.5),
    kind=st.sampled_from(["truncated sphere", "rounded flat", "hollow"]),
    seed=st.integers(0, 2**32 - 1),
)
def test_the_inverse_next_to_a_breakpoint_is_met(exponent, flat, kind, seed):
    """The place of a depth has that depth, however close to the breakpoint it is."""
    profile = {
        "truncated sphere": lambda: mdr.TruncatedSphere(radius=1.0, flat_radius=0.5 * flat),
        "rounded flat": lambda: mdr.RoundedFlat(flat, 2.0),
        "hollow": lambda: mdr.Function(lambda r: np.maximum(r - flat, 0.0) ** 2, breakpoints=(flat,)),
    }[kind]()
    line = equivalent_profile(profile, exponent)
    depth = np.exp(np.random.default_rng(seed).uniform(math.log(1e-28), math.log(0.01), 2000))
    assert np.max(np.abs(line.g(line.place(depth)) / depth - 1.0)) < 1e-10


@pytest.mark.parametrize("breakpoints", [(), (125.46253820462506,)])
@pytest.mark.parametrize("seed", range(12))
def test_radii_beyond_a_corner_are_mapped_alike_in_any_order(seed, breakpoints):
    """Panels that go on from those of an earlier, smaller radius hold what the first ones of a map hold."""
    b, steep, blunt = 125.46253820462506, 1.8e-3, 3.4e-5

    def derivative(r):
        return steep * np.sqrt(r) + blunt * np.cbrt(np.maximum(r - b, 0.0))

    radii = b * (1.0 + np.array([-0.5, 1e-11, 1e-9, 1e-6, 6e-5, 3e-4, 4e-3, 0.05, 0.6, 3.0]))
    order = np.random.default_rng(seed).permutation(radii.size)[:4]
    line, fresh = (
        equivalent_profile(mdr.Function(derivative=f, breakpoints=breakpoints))
        for f in (derivative, lambda r: derivative(r))
    )
    depths = [fresh.g(radii[[i]]) for i in order]
    moments = np.array([line.moment(line.place(depth))[0] for depth in depths])
    assert worst(moments, [sneddon_moment(b, steep, blunt, radii[i]) for i in order]) < 1e-13


def test_a_fractional_power_beyond_a_corner_is_mapped_alike_from_any_first_radius():
    """The panel that goes on from a narrow first one spanned any ratio of offsets: energies were 6e-13 off."""
    b, n, s = 1.6527642571318548e-05, 2.44200776099583, 5.0814242178898095e-05
    line = equivalent_profile(
        mdr.Function(
            lambda r: s / n * (np.maximum(r - b, 0.0) / s) ** n,
            derivative=lambda r: (np.maximum(r - b, 0.0) / s) ** (n - 1.0),
            breakpoints=[b],
        )
    )
    x = b * (1.0 + np.array([0.02, 0.1, 0.14]))
    exact = [both_images(mpf(b), mpf(n), mpf(s), mpf(place)) for place in x.tolist()]
    line.inverse(np.array([float(exact[-1][0]), 1e-10 * float(exact[-1][0])]))
    assert worst(line.g(x), [float(g) for g, _ in exact]) < 5e-15
    assert worst(line.slope(x), [float(slope) for _, slope in exact]) < 2e-14


def test_curvature_is_no_rounding_of_a_slope():
    """Short straight lines took it for noise, and panels next to a breakpoint were 2e-11 off."""
    b, n = 0.15862021288201267, 2.34454239621662
    profile = mdr.Function(
        lambda r: np.maximum(r - b, 0.0) ** n / n,
        derivative=lambda r: np.maximum(r - b, 0.0) ** (n - 1.0),
        breakpoints=[b],
    )
    x = b * (1.0 + np.geomspace(1e-3, 0.0179, 8))
    slopes = [float(both_images(mpf(b), mpf(n), mpf(1.0), mpf(place))[1]) for place in x.tolist()]
    line = equivalent_profile(profile)
    line.g(x[-1:])
    assert worst(line.slope(x), slopes) < 5e-14


def sneddon_moment(b, steep, blunt, a):
    """int_0^a r^2 f'(r) / sqrt(a^2 - r^2) dr of f' = steep r^(1/2) + blunt (r - b)^(1/3) by tanh-sinh quadrature."""
    with mp.workdps(30):
        a, b = mpf(float(a)), mpf(b)
        disk = mpf(steep) * a ** mpf(2.5) * mp.beta(mpf(7) / 4, mpf(1) / 2) / 2
        if a <= b:
            return float(disk)
        width = a - b

        def ring(t):
            y = width * mp.sin(t) ** 2
            return 2 * mp.sqrt(width) * mp.sin(t) * (b + y) ** 2 * mp.cbrt(y) / mp.sqrt(a + b + y)

        return float(disk + mpf(blunt) * mp.quad(ring, [0, mp.pi / 8, mp.pi / 2]))


def both_images(b, n, s, x):
    """g and g' of f' = ((r - b) / s)^(n - 1) with r = b + (x - b) sin(t)^2, by tanh-sinh quadrature of 30 digits."""
    with mp.workdps(30):
        width = x - b

        def integral(f):
            def integrand(t):
                y = width * mp.sin(t) ** 2
                return 2 * f(y) * mp.sqrt(width) * mp.sin(t) / mp.sqrt(x + b + y)

            return mp.quad(integrand, [0, mp.pi / 8, mp.pi / 2])

        g = x * integral(lambda y: (y / s) ** (n - 1))
        return g, integral(lambda y: (y / s) ** (n - 1) + (b + y) * (n - 1) / s * (y / s) ** (n - 2))
