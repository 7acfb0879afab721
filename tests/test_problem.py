"""Problem values and paths: what is asked, frozen and without behaviour."""

import copy
import inspect
import math
import pickle
import tomllib

import numpy as np
import pint
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pymdr as mdr
from common import STEEL, UNIT
from drawing import examples
from pymdr.problem.codec import decode_case, encode, encode_case
from pymdr.problem.paths import History, Hold, Ramp, legs
from pymdr.problem.profiles import Interpolated, Sum

UREG = pint.LazyRegistry()
ALL_PROFILES = [
    mdr.Sphere("10 mm"),
    mdr.Paraboloid("10 mm"),
    mdr.Cone(slope=0.3),
    mdr.Cone(half_angle="70 deg"),
    mdr.PowerLaw(2.5, "1 um", "1 mm"),
    mdr.FlatPunch("1 mm"),
    mdr.FlatPunch("1 mm") + mdr.Paraboloid("20 mm"),
    Interpolated((0.0,), (0.5,), (1.0,), (1.0,), ((2.0, 0.5),), (0.5, 0.75, 1.0)),
]
ALL_PATHS = [
    mdr.load("50 N", steps=50),
    mdr.indent("1 um", steps=3, duration="2 s"),
    mdr.hold("1 s", steps=2),
    mdr.ramp(indentation="1 um", steps=4),
    mdr.Path(time=[1.0, 2.0], indentation=["1 um", "2 um"]),
    mdr.Path(normal_force=[1.0, 2.0, 0.5]),
    mdr.load("1 N") >> mdr.hold() >> mdr.indent(0.0),
]
VALUES = [*ALL_PROFILES, *ALL_PATHS, STEEL, mdr.Rigid(), mdr.Contact(mdr.Sphere(1.0), STEEL)]


def name_of(value):
    return type(value).__name__


# --- values ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("value", VALUES, ids=name_of)
def test_values_survive_pickling_copying_and_are_hashable(value):
    for other in (pickle.loads(pickle.dumps(value)), copy.deepcopy(value), copy.copy(value)):
        assert other == value
        assert hash(other) == hash(value)
    assert value != 3
    assert name_of(value) in repr(value)
    assert name_of(value) in value._repr_html_()


@pytest.mark.parametrize("value", [v for v in VALUES if not isinstance(v, mdr.Rigid)], ids=name_of)
def test_values_are_frozen(value):
    name = next(iter(type(value).__dataclass_fields__))
    with pytest.raises(AttributeError):
        setattr(value, name, 1.0)


def test_values_that_differ_are_different():
    assert len(set(VALUES)) == len(VALUES)
    assert mdr.Sphere(1.0) != mdr.Paraboloid(1.0)
    assert mdr.Elastic(1.0, 0.3) != mdr.Elastic(1.0, 0.30000000000000004)


def test_text_pint_and_si_are_one_value():
    assert mdr.Sphere("10 mm") == mdr.Sphere(10 * UREG.mm) == mdr.Sphere(0.01) == mdr.Sphere("1 cm")
    assert mdr.Cone(half_angle="70 deg").half_angle == pytest.approx(math.radians(70), rel=1e-15)
    assert mdr.PowerLaw(2, "1 um", "1 mm") == mdr.PowerLaw(2, 1e-6, 1 * UREG.mm)
    assert mdr.load("50 N") == mdr.load(50 * UREG.newton) == mdr.load(50)
    assert mdr.Path(indentation=["1 um", "2 um"]) == mdr.Path(indentation=np.array([1.0, 2.0]) * UREG.um)
    assert mdr.Contact(mdr.Sphere(1.0), STEEL) == mdr.Contact(mdr.Sphere(1.0), STEEL, mdr.Rigid())


def test_negative_zero_is_zero():
    assert mdr.indent(0.0) == mdr.indent(-0.0)
    assert mdr.Path(indentation=[0.0]) == mdr.Path(indentation=[-0.0])


# --- profiles --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("profile", "r", "f"),
    [
        (mdr.Sphere(1.0), 0.6, 0.2),
        (mdr.Sphere(1.0), 1.0, 1.0),
        (mdr.Paraboloid(0.5), 0.6, 0.36),
        (mdr.Cone(slope=0.3), 2.0, 0.6),
        (mdr.Cone(half_angle="45 deg"), 2.0, 2.0),
        (mdr.Cone(half_angle="60 deg"), 3.0, math.sqrt(3.0)),
        (mdr.PowerLaw(3, 0.1, 0.5), 1.0, 0.8),
        (mdr.FlatPunch(1.0), 1.0, 0.0),
        (mdr.FlatPunch(1.0), 1.01, math.inf),
        (mdr.Paraboloid(0.5) + mdr.Cone(slope=0.3), 0.6, 0.54),
        (Interpolated((0.0,), (0.5,), (1.0,), (1.0,), ((2.0,),), (0.5, 1.0, 1.0)), 0.25, 0.0625),
        (Interpolated((0.0,), (0.5,), (1.0,), (1.0,), ((2.0,),), (0.5, 1.0, 1.0)), 0.75, 0.5625),
        (
            Interpolated(
                (0.0, 0.5), (0.25, 0.0), (0.5, 0.5), (1.0, 0.0), ((1.0,), (3.0,)), (0.25, 0.5, 1.0), (0.5,)
            ),
            0.75,
            1.0,
        ),
    ],
)
def test_gaps(profile, r, f):
    assert float(profile.gap(r)) == pytest.approx(f, rel=1e-14)


@pytest.mark.parametrize("profile", ALL_PROFILES[:5], ids=name_of)
@pytest.mark.parametrize("r", [1e-6, 1e-3, 5e-3])
def test_slopes_are_derivatives_of_gaps(profile, r):
    h = 1e-3 * r
    slope = (
        8 * (profile.gap(r + h) - profile.gap(r - h)) - profile.gap(r + 2 * h) + profile.gap(r - 2 * h)
    ) / (12 * h)
    assert float(profile.gap_slope(r)) == pytest.approx(float(slope), rel=1e-9)


def test_a_small_gap_of_a_large_sphere_keeps_its_digits():
    r = np.array([1e-9, 1e-6, 1e-3])
    assert mdr.Sphere(1.0).gap(r) == pytest.approx(r**2 / 2 * (1 + r**2 / 4 + r**4 / 8), rel=1e-15)


def test_beyond_its_radius_a_sphere_is_nan():
    assert math.isnan(mdr.Sphere(1.0).gap(1.1))


def test_sums_are_flat():
    a, b, c = mdr.Sphere(1.0), mdr.Cone(slope=0.1), mdr.FlatPunch(0.5)
    assert ((a + b) + c).parts == (a + (b + c)).parts == (a, b, c)
    assert (a + b + c).edge == 0.5
    assert (a + b).max_radius == 1.0
    assert (mdr.Sphere(1.0) + mdr.Paraboloid(1.0)).curvature_radius == pytest.approx(0.5, rel=1e-15)
    assert (b + c).curvature_radius is None


@pytest.mark.parametrize("other", [3, None, "sphere", STEEL])
def test_only_profiles_add(other):
    with pytest.raises(TypeError):
        mdr.Sphere(1.0) + other


@pytest.mark.parametrize("parts", [(), (3,), (mdr.Sphere(1.0), None)])
def test_bad_sums(parts):
    with pytest.raises(mdr.ProblemError, match=r"Sum\.parts"):
        Sum(parts)


def test_breakpoints_are_sorted_once_each_and_take_units():
    f = mdr.Function(np.square, ["2 mm", 1e-3, "1 mm"])
    assert f.breakpoints == (1e-3, 2e-3)
    assert mdr.Function(np.square, "1 mm").breakpoints == (1e-3,)


def test_the_offset_of_a_function():
    f = mdr.Function(lambda r: 7.0 + r * r)
    assert f.offset == 7.0
    assert f.gap([0.0, 0.5]).tolist() == [0.0, 0.25]


@pytest.mark.parametrize(
    "make",
    [
        lambda: mdr.Sphere(0.0),
        lambda: mdr.Sphere("-1 mm"),
        lambda: mdr.Sphere(math.nan),
        lambda: mdr.Sphere(math.inf),
        lambda: mdr.Sphere(None),
        lambda: mdr.Paraboloid(0.0),
        lambda: mdr.FlatPunch(-1.0),
        lambda: mdr.Cone(slope=0.0),
        lambda: mdr.Cone(slope=-1.0),
        lambda: mdr.Cone(slope="1 mm"),
        lambda: mdr.Cone(half_angle=0.0),
        lambda: mdr.Cone(half_angle="-10 deg"),
        lambda: mdr.Cone(half_angle="10 mm"),
        lambda: mdr.PowerLaw(-1.0, 1.0, 1.0),
        lambda: mdr.PowerLaw(2.0, 0.0, 1.0),
        lambda: mdr.PowerLaw(2.0, 1.0, 0.0),
        lambda: mdr.PowerLaw("2 m", 1.0, 1.0),
        lambda: mdr.Function(np.square, [0.0]),
        lambda: mdr.Function(np.square, [math.nan]),
        lambda: mdr.Function(np.square, ["1 kg"]),
        lambda: mdr.Function(np.square, max_radius=0.0),
        lambda: mdr.Function(np.square, derivative=3.0),
        lambda: Interpolated(
            (0.0, 0.0), (0.5, 0.2), (1.0, 0.5), (0.0, 0.0), ((1.0,), (1.0,)), (0.5, 1.0, 0.0)
        ),
        lambda: Interpolated((0.0,), (0.5,), (1.0,), (0.0,), (), (0.5, 1.0, 0.0)),
        lambda: Interpolated((), (), (), (), (), (0.5, 1.0, 0.0)),
        lambda: Interpolated((0.0,), (0.5,), (1.0,), (0.0,), ((1.0,),), (0.5, 1.0)),
    ],
)
def test_bad_profiles(make):
    with pytest.raises(ValueError, match=r"\w+") as caught:
        make()
    assert isinstance(caught.value, mdr.PymdrError)


def test_limits_are_named():
    with pytest.raises(mdr.ProblemError, match=r"^radius = '-1 mm': it must be above 0 m"):
        mdr.Sphere("-1 mm")
    with pytest.raises(mdr.ProblemError, match=r"^poisson = 0\.7: it must be above -1 and at most 0\.5"):
        mdr.Elastic(1.0, 0.7)


# --- contacts --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((mdr.Sphere(1.0), mdr.Rigid()), "both bodies are rigid; at least one must be elastic"),
        ((mdr.Sphere(1.0), mdr.Rigid(), mdr.Rigid()), "both bodies are rigid; at least one must be elastic"),
        ((1.0, STEEL), "^profile = 1.0: a profile such as"),
        ((mdr.Sphere(1.0), 210e9), "^body = 210000000000.0: a material such as"),
        ((mdr.Sphere(1.0), STEEL, None), "^counterbody = None: a material such as"),
        ((STEEL, mdr.Sphere(1.0)), "^profile = Elastic"),
        ((mdr.Sphere, STEEL), "^profile = <class .*Sphere"),
    ],
)
def test_bad_contacts(arguments, message):
    with pytest.raises(mdr.ProblemError, match=message):
        mdr.Contact(*arguments)


# --- paths -----------------------------------------------------------------------------------------------


def test_a_path_is_repeated_by_a_number():
    tap = mdr.indent("1 um") >> mdr.indent("0 um")
    assert tap * np.int64(3) == tap >> tap >> tap
    for times in (0, 2.5, True, "3", None):
        with pytest.raises(
            mdr.PathError, match=rf"path \* {times!r}: a whole number of at least 1 is needed"
        ):
            tap * times


def test_legs_in_a_row():
    path = mdr.load(1.0) >> (mdr.hold() >> mdr.indent(0.0))
    assert legs(path) == (mdr.load(1.0), mdr.hold(), mdr.indent(0.0))
    assert legs(mdr.load(1.0)) == (mdr.load(1.0),)
    assert mdr.load(1.0) == Ramp(normal_force=1.0) == mdr.ramp(normal_force=1.0)
    assert mdr.indent(1.0) == Ramp(indentation=1.0)
    assert mdr.hold() == Hold()
    with pytest.raises(TypeError):
        mdr.load(1.0) >> 3


@pytest.mark.parametrize("steps", [0, -1, 2.0, "3", True, None, math.nan])
@pytest.mark.parametrize("leg", [mdr.load, mdr.indent])
def test_bad_steps(leg, steps):
    with pytest.raises(mdr.PathError, match="whole number of at least 1"):
        leg(1.0, steps=steps)
    with pytest.raises(mdr.PathError, match="whole number of at least 1"):
        mdr.hold(steps=steps)


@pytest.mark.parametrize("duration", [0.0, -1.0, "1 m", math.nan, math.inf])
def test_bad_durations(duration):
    with pytest.raises(ValueError, match="duration"):
        mdr.load(1.0, duration=duration)
    with pytest.raises(ValueError, match="duration"):
        mdr.hold(duration)


@pytest.mark.parametrize(
    "make",
    [
        lambda: mdr.Path(indentation=[]),
        lambda: mdr.Path(normal_force=[]),
        lambda: mdr.Path(),
        lambda: mdr.Path(time=[1.0]),
        lambda: mdr.Path(indentation=[1.0], normal_force=[1.0]),
        lambda: mdr.Path(time=[1.0, 2.0], indentation=[1.0]),
        lambda: mdr.Path(time=[1.0, 1.0], indentation=[1.0, 2.0]),
        lambda: mdr.Path(time=[2.0, 1.0], indentation=[1.0, 2.0]),
        lambda: mdr.Path(indentation=[[1.0]]),
        lambda: mdr.Path(indentation=1.0),
        lambda: mdr.Path(indentation=[1.0, math.nan]),
        lambda: mdr.Path(indentation=["1 um", "1,5 um"]),
        lambda: mdr.Path(indentation=["1 N"]),
        lambda: mdr.Path(time=["1 m"], indentation=[1.0]),
        lambda: History(()),
        lambda: History((3,)),
        lambda: mdr.ramp(steps=3),
        lambda: mdr.ramp(indentation=1.0, normal_force=1.0),
        lambda: mdr.load("5 m"),
        lambda: mdr.load(math.nan),
        lambda: mdr.indent("5 N"),
    ],
)
def test_bad_paths(make):
    with pytest.raises(ValueError, match=r"\w+") as caught:
        make()
    assert isinstance(caught.value, mdr.PymdrError)


def test_the_virgin_state_is_never_a_row():
    contact = mdr.Contact(mdr.Paraboloid(1.0), UNIT)
    for path, channel in (
        (mdr.load(4.0, steps=4), "normal_force"),
        (mdr.indent(4.0, steps=4), "indentation"),
    ):
        result = mdr.solve(contact, path)
        assert result[channel].values.tolist() == pytest.approx([1.0, 2.0, 3.0, 4.0], rel=1e-13)
        assert "time" not in result.data
    assert mdr.solve(contact, mdr.load(4.0))["normal_force"].values.tolist() == pytest.approx(
        [4.0], rel=1e-14
    )


def test_each_leg_starts_where_the_last_ended():
    # F = 4/3 d^1.5 with E* = R = 1
    contact = mdr.Contact(mdr.Paraboloid(1.0), UNIT)
    path = mdr.indent(1.0, steps=2) >> mdr.load(10 / 3, steps=2) >> mdr.indent(0.0, steps=2)
    result = mdr.solve(contact, path)
    top = (2.5) ** (2 / 3)
    d = [0.5, 1.0, (7 / 4) ** (2 / 3), top, top / 2, 0.0]
    assert result["indentation"].values == pytest.approx(d, rel=1e-13)
    assert result["normal_force"].values == pytest.approx([4 / 3 * x**1.5 for x in d], rel=1e-13)


def test_a_hold_keeps_the_channel_that_was_controlled():
    contact = mdr.Contact(mdr.Paraboloid(1.0), UNIT)
    result = mdr.solve(contact, mdr.load(1.0) >> mdr.hold(steps=2) >> mdr.indent(0.1) >> mdr.hold())
    assert result["normal_force"].values[:3].tolist() == pytest.approx([1.0] * 3, rel=1e-14)
    assert result["indentation"].values[3:].tolist() == [0.1, 0.1]
    virgin = mdr.solve(contact, mdr.hold(steps=2))
    assert virgin["indentation"].values.tolist() == virgin["normal_force"].values.tolist() == [0.0, 0.0]


def test_a_path_of_arrays_has_one_row_per_sample():
    contact = mdr.Contact(mdr.Paraboloid(1.0), UNIT)
    samples = [0.3, -0.2, 0.7, 0.0, 0.7]
    result = mdr.solve(contact, mdr.Path(indentation=samples))
    assert result["indentation"].values.tolist() == samples
    force = [4 / 3 * max(d, 0.0) ** 1.5 for d in samples]
    assert result["normal_force"].values == pytest.approx(force, rel=1e-13)
    by_force = mdr.solve(contact, mdr.Path(normal_force=force))
    assert by_force["indentation"].values == pytest.approx(np.maximum(samples, 0.0), rel=1e-13)


def test_durations_and_times_add_up():
    contact = mdr.Contact(mdr.Paraboloid(1.0), UNIT)
    path = (
        mdr.load(1.0, steps=2, duration="500 ms")
        >> mdr.hold("1 min")
        >> mdr.Path(time=[61.0], indentation=[0.1])
    )
    assert mdr.solve(contact, path)["time"].values.tolist() == [0.25, 0.5, 60.5, 61.0]
    with pytest.raises(mdr.PathError, match=r"begins at 0\.5 s"):
        mdr.solve(contact, mdr.hold("1 s") >> mdr.Path(time=[0.5], indentation=[0.1]))
    with pytest.raises(mdr.PathError, match="duration"):
        mdr.solve(contact, mdr.hold("1 s") >> mdr.load(1.0))


@pytest.mark.parametrize(
    "path", [mdr.load(-1.0), mdr.load(1.0) >> mdr.load("-1 nN"), mdr.Path(normal_force=[1.0, -1.0])]
)
def test_a_negative_force_is_refused(path):
    with pytest.raises(mdr.PathError, match="below 0 N"):
        mdr.solve(mdr.Contact(mdr.Sphere(1.0), UNIT), path)


@pytest.mark.parametrize(
    "profile",
    [
        mdr.Sphere(1.0),
        mdr.Sphere(1.0) + mdr.FlatPunch(2.0),  # the edge lies beyond the sphere
    ],
)
@pytest.mark.parametrize("depth", [1.0, 1.5, 1e9])
def test_a_sphere_is_not_pressed_in_by_its_radius(profile, depth):
    contact = mdr.Contact(profile, UNIT)
    with pytest.raises(mdr.PathError, match="radius"):
        mdr.solve(contact, mdr.indent(depth))
    with pytest.raises(mdr.PathError, match="radius"):
        mdr.solve(contact, mdr.load(1.5 + depth))


@pytest.mark.parametrize(
    ("profile", "depth", "radius"),
    [
        (mdr.Function(lambda r: 100 * r**2, max_radius=0.1), 0.5, 0.05),
        (mdr.Function(lambda r: 100 * r**2, derivative=lambda r: 200 * r, max_radius=0.1), 0.5, 0.05),
        (mdr.Cone(slope=200.0) + mdr.Sphere(1.0), 1.5, 0.0047746),
    ],
)
def test_a_steep_profile_may_be_pressed_deeper_than_it_is_wide(profile, depth, radius):
    result = mdr.solve(mdr.Contact(profile, UNIT), mdr.indent(depth))
    assert float(result["contact_radius"][0]) == pytest.approx(radius, rel=1e-4)


@pytest.mark.parametrize("path", [mdr.indent(0.05), mdr.load(10.0)])
def test_a_function_is_not_used_beyond_its_largest_radius(path):
    # g(0.1) = 0.02: deeper than that nothing is known
    profile = mdr.Function(lambda r: r**2, derivative=lambda r: 2 * r, max_radius=0.1)
    with pytest.raises((mdr.PathError, mdr.ProblemError), match="pass r = 100 mm"):
        mdr.solve(mdr.Contact(profile, UNIT), path)


# --- plain dictionaries ----------------------------------------------------------------------------------


@pytest.mark.parametrize("profile", ALL_PROFILES, ids=name_of)
@pytest.mark.parametrize("path", ALL_PATHS, ids=name_of)
def test_cases_go_there_and_back(profile, path):
    contact = mdr.Contact(profile, STEEL, mdr.Elastic("70 GPa", 0.22))
    title, again, route = decode_case(encode_case("a title", contact, path))
    assert (title, again) == ("a title", contact)
    assert legs(route) == legs(path)


def test_a_callable_is_not_written():
    with pytest.raises(mdr.ProblemError, match="callable"):
        encode(mdr.Function(np.square))


# --- callables in other processes ---------------------------------------------------------------------------


def round_tip(r):
    return r**2 / 2e-2


def round_body(x, y):
    return (x**2 + y**2) / 2e-2


def test_callables_with_a_name_are_pickled():
    for profile in (
        mdr.Function(round_tip),
        mdr.Function2D(round_body),
        mdr.Function(round_tip) + mdr.Cone(0.1),
    ):
        assert pickle.loads(pickle.dumps(profile)) == profile
    line = mdr.equivalent_profile(mdr.Function(round_tip))
    again = pickle.loads(pickle.dumps(line))
    assert float(again.g(np.array([1e-3]))[0]) == float(line.g(np.array([1e-3]))[0])


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda: mdr.Function(lambda r: r**2), "f"),
        (lambda: mdr.Function(derivative=lambda r: r), "derivative"),
        (lambda: mdr.Function2D(lambda x, y: x**2 + y**2), "f"),
        (lambda: mdr.Sphere(1.0) + mdr.Function(lambda r: r**2), "f"),
        (lambda: mdr.Contact(mdr.Function(lambda r: r**2), mdr.Elastic(1.0, 0.0)), "f"),
        (lambda: mdr.equivalent_profile(mdr.Function(lambda r: r**2)), "f"),
        (lambda: mdr.equivalent_profile(mdr.Function(derivative=lambda r: r), 0.3), "derivative"),
        (lambda: mdr.equivalent_profile(mdr.Cone(0.1) + mdr.Function(lambda r: r**2)), "f"),
    ],
)
def test_callables_without_a_name_are_refused_in_words_and_copied(make, field):
    made = make()
    with pytest.raises(
        mdr.ProblemError, match=rf"^{field} = .* cannot be pickled.*def at the top of a module"
    ):
        pickle.dumps(made)
    if isinstance(made, mdr.Contact | mdr.Function | mdr.Function2D):
        assert copy.deepcopy(made) == made
        assert copy.copy(made) == made
    else:
        copy.copy(made)


def unnamed():
    return mdr.Function(lambda r: r**2 / 2e-2)


@pytest.mark.parametrize(
    "ask",
    [
        lambda profile: mdr.impact(
            mdr.Contact(profile, mdr.Elastic("1 GPa", 0.3)), mass="10 g", speed="0.1 m/s"
        ),
        lambda profile: mdr.impact(
            mdr.Contact(profile, mdr.Elastic("1 GPa", 0.3), adhesion=mdr.JKR("1 mJ/m^2")),
            mass="10 g",
            speed="0.1 m/s",
        ),
        lambda profile: mdr.export_law(mdr.Contact(profile, mdr.Elastic("1 GPa", 0.3)), "1 um"),
        lambda profile: mdr.sweep(
            mdr.Contact(profile, mdr.Elastic("1 GPa", 0.3)),
            mdr.indent("1 um"),
            {"body.young": ["1 GPa", "2 GPa"]},
        ),
    ],
)
def test_features_of_callables_are_pickled_with_polynomials(ask):
    result = ask(unnamed())
    again = pickle.loads(pickle.dumps(result))
    assert again.data.identical(result.data)
    assert again.summary() == result.summary()
    r = np.linspace(0.0, 1e-4, 9)
    assert again.contact.profile.gap(r) == pytest.approx(r**2 / 2e-2, rel=1e-9)


SYMBOLS = [
    (mdr.Elastic, "E", "young"),
    (mdr.Elastic, "nu", "poisson"),
    (mdr.Sphere, "R", "radius"),
    (mdr.Coulomb, "mu", "coefficient"),
    (mdr.JKR, "gamma", "work"),
    (mdr.Viscoelastic, "G", "shear"),
    (mdr.Viscoelastic, "yuong", "young"),
    (mdr.Path, "Shift", "shift"),
]


@pytest.mark.parametrize(("owner", "symbol", "name"), SYMBOLS)
def test_symbols_are_refused_with_the_name_to_write(owner, symbol, name):
    with pytest.raises(
        TypeError, match=rf"^{owner.__name__}\(\) got .* '{symbol}'; write {name}= \(arguments: "
    ):
        owner(**{symbol: 1.0})
    assert name in inspect.signature(owner).parameters


def test_unknown_arguments_without_a_near_name_list_the_known():
    with pytest.raises(
        TypeError, match=r"^Sphere\(\) got an unexpected keyword argument 'qqq' \(arguments: radius\)$"
    ):
        mdr.Sphere(qqq=1.0)
    assert list(inspect.signature(mdr.Elastic).parameters)[:2] == ["young", "poisson"]


WRONG = {
    ("profile", "radius"): ('"-1 mm"', "[profile] radius = '-1 mm'"),
    ("body", "young"): ('"0 Pa"', "[body] young = '0 Pa'"),
    ("body", "poisson"): ("0.7", "[body] poisson = 0.7"),
    ("body", "nu"): ("0.3", "[body] nu = 0.3: unknown key; did you mean 'poisson'?"),
    ("counterbody", "young"): ('"1 N"', "[counterbody] young: 'N' does not fit"),
    ("counterbody", "E"): ("1.0", "[counterbody] E = 1.0: unknown key; did you mean 'young'?"),
    ("friction", "coefficient"): ("-0.1", "[friction] coefficient = -0.1"),
    ("friction", "mu"): ("0.1", "[friction] mu = 0.1: unknown key; did you mean 'coefficient'?"),
    ("path", "normal_force"): ('"1 m"', "[path 1] normal_force: 'm' does not fit"),
    ("path", "steps"): ("0", "[path 1] steps = 0: it must be at least 1"),
}


@settings(max_examples=examples(40), deadline=None)
@given(st.sets(st.sampled_from(sorted(WRONG)), min_size=1))
def test_all_wrong_values_of_a_case_are_listed(chosen):
    elastic = {"kind": '"elastic"', "young": '"1 GPa"', "poisson": "0.3"}
    tables = {
        "profile": {"kind": '"sphere"', "radius": '"1 mm"'},
        "body": dict(elastic),
        "counterbody": dict(elastic),
        "friction": {"kind": '"coulomb"', "coefficient": "0.3"},
        "path": {"kind": '"load"', "normal_force": '"1 N"'},
    }
    for table, key in chosen:
        tables[table][key] = WRONG[table, key][0]
    lines = [
        f"{'[[path]]' if table == 'path' else f'[{table}]'}\n"
        + "\n".join(f"{key} = {value}" for key, value in keys.items())
        for table, keys in tables.items()
    ]
    with pytest.raises(mdr.CaseError) as refusal:
        decode_case(tomllib.loads("\n".join(lines)))
    for place in chosen:
        assert WRONG[place][1] in str(refusal.value)


def test_mistakes_between_keys_of_several_tables_are_listed():
    case = {
        "profile": {"kind": "cone", "slope": 0.1, "half_angle": 1.0},
        "body": {"kind": "viscoelastic", "poisson": 0.3, "bulk": 1e9, "shear": {"kind": "prony", "equilibrium": 0.0, "moduli": [1.0], "times": [1.0, 2.0]}},
        "path": [{"kind": "ramp"}, {"kind": "load", "normal_force": 1.0, "duration": 1.0, "rate": 1.0}],
    }  # fmt: skip
    with pytest.raises(mdr.CaseError) as refusal:
        decode_case(case)
    for words in ("[profile] ", "[body.shear] ", "[path 1] ", "[path 2] "):
        assert words in str(refusal.value)
