"""Figures begin where data begin, draw springs where they are, and say where a pressure is infinite."""

import itertools
import math

import numpy as np
import pytest
from matplotlib.colors import to_hex

import pymdr as mdr
from drawing import first_of
from pymdr.presentation.plot.shared import BLUE
from pymdr.units import to_si

GEL = mdr.Elastic("1 MPa", 0.5)
SOLID = mdr.Viscoelastic(mdr.StandardSolid("100 kPa", "1 MPa", "1 s"), 0.5)
BALL = mdr.Paraboloid("1 mm")


def unit(label):
    return float(to_si(f"1 {label.split('(')[-1].split(')')[0]}", "m"))


def heads_of(axes):
    """Places and heights of the ends of the springs of a section, in m."""
    across = unit(axes.get_xlabel().splitlines()[0])
    ends = [line.get_xydata()[-1] for line in axes.lines if len(line.get_xdata()) == 10]
    x, up = np.array(ends).T
    return x * across, up * unit(axes.get_ylabel())


def titles(figure):
    return [axes.get_title() for axes in figure.axes]


def words(figure):
    return "\n".join(text.get_text() for axes in figure.axes for text in axes.texts)


@pytest.mark.parametrize("friction", first_of([None, mdr.Coulomb(0.5)]))
@pytest.mark.parametrize("seed", first_of(range(4)))
def test_springs_of_bodies_with_memory_end_below_the_indenter(seed, friction):
    rng = np.random.default_rng(seed)
    n = 8
    time = np.cumsum(
        np.where(np.arange(n) < n // 2, *rng.uniform(((0.1,), (0.01,)), ((0.4,), (0.05,)), (2, n)))
    )
    increasing, decreasing = (
        np.sort(rng.uniform(1e-6, 9e-6, n // 2 - 1)),
        -np.sort(-rng.uniform(4e-6, 7e-6, n // 2)),
    )
    depth = np.concatenate([increasing, [1e-5], decreasing])
    path = mdr.Path(indentation=depth, time=time, **({} if friction is None else {"shift": 1e-7 * time}))
    result = mdr.solve(mdr.Contact(BALL, SOLID, friction=friction), path)
    for step in (n // 2 - 1, n // 2, n - 1):
        x, up = heads_of(result.figures(step)["section"].axes[1])
        tip = result.field("equivalent_profile", np.abs(x)).values - depth[step]
        assert np.all(up <= tip + 2e-3 * depth.max())
        # springs that were pressed come back no faster than they relax
        released = (np.abs(x) > float(result["contact_radius"][step])) & (tip < 0.0)
        assert np.all(up[released] < 0.0)
        assert step == n // 2 or released.any() == (step == n - 1)


@pytest.mark.parametrize("seed", first_of(range(3)))
def test_the_row_of_the_largest_load_is_drawn_and_named(seed):
    rng = np.random.default_rng(seed)
    depth, time = rng.uniform(1e-6, 1e-5, 8), np.cumsum(rng.uniform(0.1, 1.0, 8))
    result = mdr.solve(mdr.Contact(BALL, SOLID), mdr.Path(indentation=depth, time=time))
    row = int(np.argmax(result["normal_force"].values))
    name = f"step {row}, $t$ = "
    assert any(title.startswith(name) for title in titles(result.plot()))
    assert any(title.startswith(name) for title in titles(result.figures()["section"]))
    assert any(title.startswith("step 0, ") for title in titles(result.figures(step=0)["section"]))
    # without memory the last row in which bodies touch says where the path ends
    elastic = mdr.solve(mdr.Contact(BALL, GEL), mdr.Path(indentation=depth))
    assert "step 7" in titles(elastic.plot())


def two_cones(b):
    return mdr.Function(lambda r: 0.1 * r + 0.1 * np.maximum(r - b, 0.0), breakpoints=[b])


SHARP = {
    "cone": (lambda b: mdr.Cone(0.1), False, True),
    "truncated cone": (lambda b: mdr.TruncatedCone(flat_radius=b, slope=0.1), True, False),
    "truncated ball": (lambda b: mdr.TruncatedParaboloid(flat_radius=b, radius="3 mm"), True, False),
    "two cones": (two_cones, True, True),
    "sum": (lambda b: BALL + mdr.TruncatedCone(flat_radius=b, slope=0.1), True, False),
    "ball": (lambda b: BALL, False, False),
    "rounded cone": (lambda b: mdr.RoundedCone(tip_radius="1 mm", slope=0.1), False, False),
    "flat": (lambda b: mdr.FlatPunch("0.1 mm"), False, False),
}
SOLVED = {
    "elastic": (GEL, {}, {}),
    "memory": (SOLID, {}, {}),
    "adhesion": (GEL, {"adhesion": mdr.JKR("1 mJ/m^2")}, {}),
    "rings": (GEL, {}, {"solver": mdr.Rings(n=40)}),
}


@pytest.mark.parametrize("how", first_of(list(SOLVED)))
@pytest.mark.parametrize("shape", list(SHARP))
def test_infinite_pressures_have_a_note(shape, how):
    make, kink, tip = SHARP[shape]
    radius = float(np.random.default_rng(len(shape)).uniform(5e-5, 1e-4))
    body, law, options = SOLVED[how]
    deep = mdr.indent("40 um", duration=1.0)
    result = mdr.solve(mdr.Contact(make(radius), body, **law), deep, **options)
    assert float(result["contact_radius"][-1]) > radius
    figures = result.figures()
    for figure in (figures["section"], figures["fields"]):
        text = words(figure)
        assert ("sharp tip: $p(0) = \\infty$" in text) == tip
        assert (f"kink: $p \\to \\infty$ at $r$ = {1e6 * radius:.4g} µm" in text) == kink
        assert ("kink" in text) == kink


def test_the_line_at_the_last_row_is_whole():
    """At the end of the axis its half outside is drawn too."""
    steel = mdr.Elastic("210 GPa", 0.3)
    joint = mdr.Contact(mdr.Sphere("10 mm"), steel, steel, friction=mdr.Coulomb(0.3))
    loop = mdr.solve(joint, mdr.load("50 N") >> mdr.cycle(shift="0.5 um", cycles=1, steps=40))
    zones = loop.figures()["loop"].axes[1]
    (last,) = [line for line in zones.lines if line.get_linestyle() == ":" and line.get_xdata()[0] == 40]
    assert zones.get_xlim()[1] == 40
    assert not last.get_clip_on()


@pytest.mark.parametrize("shape", ["truncated cone", "two cones", "ball"])
def test_limits_of_friction_and_comparisons_have_the_note_too(shape):
    make, kink, tip = SHARP[shape]
    radius = float(np.random.default_rng(len(shape)).uniform(5e-5, 1e-4))
    loaded = mdr.indent("40 um")
    sheared = mdr.solve(
        mdr.Contact(make(radius), GEL, friction=mdr.Coulomb(0.3)), loaded >> mdr.shift("2 um", steps=3)
    )
    compared = mdr.verify(mdr.Contact(make(radius), GEL), loaded, elements=40)
    for figure in (sheared.figures()["tractions"], compared.plot()):
        text = words(figure)
        assert ("sharp tip: $p(0) = \\infty$" in text) == tip
        assert (f"kink: $p \\to \\infty$ at $r$ = {1e6 * radius:.4g} µm" in text) == kink


@pytest.mark.parametrize("seed", first_of(range(3)))
def test_curves_of_rings_begin_where_rows_begin(seed):
    rng = np.random.default_rng(seed)
    depth = np.sort(rng.uniform(1e-6, 2e-5, 5))
    punch = mdr.ConcavePunch("1 mm", "0.1 m")
    result = mdr.solve(mdr.Contact(punch, GEL), mdr.Path(indentation=depth), solver=mdr.Rings(n=40))
    for axes, name in zip(
        result.figures()["curves"].axes, ("normal_force", "contact_radius", "normal_stiffness"), strict=True
    ):
        (line,) = (line for line in axes.lines if len(line.get_xdata()) > 1)
        assert line.get_marker() == "o"
        x, y = line.get_data()
        np.testing.assert_allclose(x * unit(axes.get_xlabel()), depth, rtol=1e-12)
        np.testing.assert_allclose(y / y[0], result[name].values / result[name].values[0], rtol=1e-12)


def test_forces_of_adhesive_layers_are_drawn_between_the_rows():
    body = mdr.Layered([mdr.Layer(GEL, "20 um")], base=mdr.Elastic("1 GPa", 0.3))
    contact = mdr.Contact(BALL, body, adhesion=mdr.JKR("50 mJ/m^2"))
    result = mdr.solve(contact, mdr.indent("5 um", steps=4))
    axes = result.figures()["layers"].axes[1]
    course = next(line for line in axes.lines if line.get_label() == "layers")
    rows = next(line for line in axes.lines if line.get_marker() == "o")
    assert to_hex(rows.get_color()).upper() == BLUE
    x, y = course.get_data()
    # every newton of the picture is one of the rows, whose unit is theirs
    newton = result["normal_force"].values[-1] / rows.get_ydata()[-1]
    between = mdr.solve(contact, mdr.indent("5 um", steps=23))
    drawn = np.interp(between["indentation"].values, x * unit(axes.get_xlabel()), y * newton)
    force = between["normal_force"].values
    np.testing.assert_allclose(drawn, force, atol=1e-4 * force.max(), rtol=0.0)


def heights_of_zero(figure):
    """Of all scales of one panel, as shares of its height."""
    places = [(axes.get_subplotspec(), axes.get_ylim()) for axes in figure.axes]
    for one, other in itertools.combinations(places, 2):
        if one[0] is not None and one[0] == other[0]:
            yield tuple(-low / (high - low) for low, high in (one[1], other[1]))


TWO_SCALES = {
    "section": lambda R: mdr.solve(mdr.Contact(mdr.Paraboloid(R), GEL), mdr.indent(1e-3 * R)).plot(),
    "pulled": lambda R: mdr.solve(
        mdr.Contact(mdr.Paraboloid(R), GEL, adhesion=mdr.JKR("50 mJ/m^2")),
        mdr.indent(1e-3 * R) >> mdr.indent(0.0),
    ).plot(),
    "impact": lambda R: mdr.impact(mdr.Contact(mdr.Sphere(R), GEL), mass=1e3 * R**3, speed=0.1).plot(),
    "sticky impact": lambda R: mdr.impact(
        mdr.Contact(mdr.Paraboloid(R), GEL, adhesion=mdr.JKR("50 mJ/m^2")), mass=1e3 * R**3, speed=0.1
    ).plot(),
    "fluxes": lambda R: mdr.solve(
        mdr.Contact(
            mdr.Paraboloid(R),
            mdr.Elastic("210 GPa", 0.3, thermal_conductivity=50.0, resistivity=1e-7),
            mdr.Elastic("210 GPa", 0.3, thermal_conductivity=50.0, resistivity=1e-7),
        ),
        mdr.indent(1e-3 * R),
    ).figures()["conductance"],
}


@pytest.mark.parametrize("kind", list(TWO_SCALES))
def test_two_scales_share_their_zero(kind):
    for R in 10.0 ** np.random.default_rng(len(kind)).uniform(-5.0, -1.0, 2):
        pairs = list(heights_of_zero(TWO_SCALES[kind](float(R))))
        assert pairs
        for one, other in pairs:
            assert math.isclose(one, other, abs_tol=1e-9)


@pytest.mark.parametrize("how", list(SOLVED))
def test_truncated_tips_have_a_note_whatever_solves_them(how):
    test_infinite_pressures_have_a_note("truncated cone", how)
