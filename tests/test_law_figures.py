"""Figures of adhesion and friction show what the results hold."""

import math
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.collections import PolyCollection
from matplotlib.patches import Polygon
from scipy.spatial import cKDTree

import pymdr as mdr
from common import GEL, STEEL
from drawing import examples
from legibility import faults
from pymdr.presentation.plot.shared import ORANGE, thinned_curve
from pymdr.units import to_si

TIP = mdr.Paraboloid("50 um")
THERE_AND_BACK = mdr.indent("1 um", steps=20) >> mdr.indent("-3 um", steps=80)


def labels(figure):
    return [(axes.get_xlabel(), axes.get_ylabel()) for axes in figure.axes]


def drawn(axes, name):
    return next(line for line in axes.lines if line.get_label() == name).get_xydata()


LAWS = [mdr.JKR("2 mJ/m^2"), mdr.MaugisDugdale("2 mJ/m^2", range="100 nm"), mdr.DMT("2 mJ/m^2")]
STIFFNESS = "0.05 N/m"


def units(axes):
    """Of x and y, in SI units."""
    names = [label.rpartition("(")[2].rstrip(")") for label in (axes.get_xlabel(), axes.get_ylabel())]
    return [float(to_si(f"1 {name}", si)) for name, si in zip(names, ("m", "N"), strict=True)]


def enclosed(axes):
    """Area of everything that is shaded, in J."""
    loops = [patch.get_xy() for patch in axes.patches if isinstance(patch, Polygon)]
    areas = [0.5 * abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) for x, y in (xy.T for xy in loops)]
    return sum(areas) * math.prod(units(axes))


def wavy(height=1e-7, wave=5e5):
    return mdr.Function(
        lambda r: r**2 / 2e-3 + height * (1 - np.cos(wave * r)),
        derivative=lambda r: r / 1e-3 + height * wave * np.sin(wave * r),
    )


@pytest.mark.parametrize("law", LAWS)
def test_adhesive_figures(law):
    result = mdr.solve(mdr.Contact(TIP, GEL, adhesion=law), THERE_AND_BACK)
    figures = result.figures()
    assert sorted(figures) == ["fields", "loop", "radius", "section"]
    loop = figures["loop"].axes[0]
    assert labels(figures["loop"]) == [("indentation $d$ (µm)", "normal force $F_N$ (nN)")]
    # the path goes through every row, and between the rows along the stable equilibria
    path = drawn(loop, "path")
    rows = np.stack([result.to("indentation", "um").values, result.to("normal_force", "nN").values], axis=1)
    size = np.ptp(rows, axis=0)
    for row in rows:
        assert np.nanmin(np.abs(path - row) @ (1 / size)) < 1e-12
    stable = drawn(loop, "stable equilibria")
    stable = stable[np.isfinite(stable[:, 0])]
    in_contact = path[path[:, 1] < -1e-6 * size[1]]
    assert len(in_contact) > 500
    near = np.interp(in_contact[:, 0], stable[:, 0], stable[:, 1])
    assert np.max(np.abs(near - in_contact[:, 1])) < 2e-3 * size[1]
    assert len(result.plot().axes) == 5


def test_unstable_equilibria_are_dashed():
    axes = mdr.solve(mdr.Contact(TIP, GEL, adhesion=LAWS[0]), THERE_AND_BACK).figures()["loop"].axes[0]
    dashed = next(line for line in axes.lines if line.get_label() == "unstable equilibria")
    assert dashed.get_linestyle() == "--"
    x, y = dashed.get_xydata()[np.isfinite(dashed.get_xdata())].T
    # from the first touch to the fold, where the slope of d over a is 0
    fold = mdr.pull_off(mdr.Contact(TIP, GEL, adhesion=LAWS[0]))
    np.testing.assert_allclose([x[0], y[0]], 0, atol=1e-12)
    np.testing.assert_allclose(
        [x.min() * 1e-6, y.min() * 1e-9], [fold.indentation, fold.normal_force], rtol=5e-3
    )


@pytest.mark.parametrize("law", LAWS[:2])
@pytest.mark.parametrize("stiffness", [None, STIFFNESS])
@pytest.mark.parametrize("steps", [3, 200])
def test_jumps_are_drawn_where_they_happen(law, stiffness, steps):
    contact = mdr.Contact(TIP, GEL, adhesion=law)
    if stiffness is None:
        path, exact = (
            mdr.indent("1 um", steps=steps) >> mdr.indent("-4 um", steps=steps),
            mdr.pull_off(contact),
        )
    else:
        path = mdr.travel("2 um", steps=steps) >> mdr.travel("-20 um", steps=steps)
        exact = mdr.pull_off(contact, machine_stiffness=stiffness)
    result = mdr.solve(contact, path, machine_stiffness=stiffness)
    axes = result.figures()["loop"].axes[-1]
    scale = units(axes)
    jumps = [line for line in axes.lines if line.get_color() == ORANGE and len(line.get_xdata()) == 2]
    into, out = (line.get_xydata() * scale for line in jumps)
    np.testing.assert_allclose(
        into[1], [exact.jump_in_indentation, exact.jump_in_force], rtol=1e-9, atol=1e-18
    )
    np.testing.assert_allclose(out[0], [exact.indentation, exact.normal_force], rtol=1e-9)
    free = exact.indentation if stiffness is None else exact.travel
    np.testing.assert_allclose(out[1], [free, 0.0], rtol=1e-9, atol=1e-20)


@pytest.mark.parametrize("law", LAWS[:2])
@pytest.mark.parametrize(
    ("path", "stiffness"),
    [
        (mdr.indent("1 um", steps=5) >> mdr.indent("-4 um", steps=5), None),
        (mdr.travel("2 um", steps=5) >> mdr.travel("-20 um", steps=5), STIFFNESS),
        (mdr.indent("1 um", steps=5) >> mdr.load("-0.2 uN", steps=5) >> mdr.indent("-4 um", steps=5), None),
    ],
)
def test_the_shaded_area_is_the_dissipated_energy(law, path, stiffness):
    result = mdr.solve(mdr.Contact(TIP, GEL, adhesion=law), path, machine_stiffness=stiffness)
    dissipated = np.nansum(result["jump_dissipation"].values)
    assert dissipated > 0
    for axes in result.figures()["loop"].axes:
        assert enclosed(axes) == pytest.approx(dissipated, rel=2e-5)


def test_a_body_that_falls_off_shades_no_area():
    """Under a dead load the free body has no depth, so what it loses is no area in the plane of the loop."""
    path = mdr.load("0 N") >> mdr.load("-1 uN", steps=7)
    result = mdr.solve(mdr.Contact(TIP, GEL, adhesion=LAWS[0]), path)
    assert np.nansum(result["jump_dissipation"].values) > 0
    assert not result.figures()["loop"].axes[0].patches


def test_every_wave_is_a_jump_and_all_loss_is_shaded():
    contact = mdr.Contact(wavy(), mdr.Elastic("100 kPa", 0.5), adhesion=mdr.JKR("10 mJ/m^2"))
    result = mdr.solve(contact, mdr.indent("4 um", steps=10) >> mdr.indent("-8 um", steps=20))
    axes = result.figures()["loop"].axes[0]
    dissipated = np.nansum(result["jump_dissipation"].values)
    assert len([p for p in axes.patches if isinstance(p, Polygon)]) > 6
    assert enclosed(axes) == pytest.approx(dissipated, rel=1e-4)


def test_a_singular_edge_leaves_the_picture():
    result = mdr.solve(mdr.Contact(TIP, GEL, adhesion=LAWS[0]), mdr.indent("0.5 um", steps=5))
    axes = result.figures()["fields"].axes[0]
    inside = axes.lines[0].get_xydata()
    a = result.to("contact_radius", "um").values[-1]
    inside = inside[(inside[:, 0] < a) & np.isfinite(inside[:, 1])]
    assert inside[-1, 1] < 10 * axes.get_ylim()[0] < 0
    assert any("infty" in text.get_text() for text in axes.texts)


def test_a_cohesive_zone_ends_at_its_strength():
    law = mdr.MaugisDugdale("2 mJ/m^2", range="1 um")
    result = mdr.solve(mdr.Contact(TIP, GEL, adhesion=law), mdr.indent("0.5 um", steps=5))
    axes = result.figures()["fields"].axes[0]
    assert min(axes.lines[0].get_ydata()) == pytest.approx(-2.0, rel=1e-12)
    assert axes.get_ylabel() == "pressure $p$ (kPa)"
    # springs of the zone are pulled, and those outside are free
    springs = result.figures()["section"].axes[1].lines
    colours = [line.get_color() for line in springs if len(line.get_xdata()) == 10]
    middles = [line.get_xdata().mean() for line in springs if len(line.get_xdata()) == 10]
    a, c = (result.to(name, "um").values[-1] for name in ("contact_radius", "cohesive_radius"))
    assert {colour == ORANGE for colour, x in zip(colours, middles, strict=True) if a < abs(x) < c} == {True}
    assert {colour == ORANGE for colour, x in zip(colours, middles, strict=True) if abs(x) > c} == {False}


@pytest.mark.long
def test_a_million_rows_with_jumps():
    path = mdr.Path(indentation=2e-6 * np.sin(np.arange(1_000_000) * 0.01))
    result = mdr.solve(mdr.Contact(TIP, GEL, adhesion=LAWS[0]), path)
    axes = result.figures()["loop"].axes[0]
    assert len(drawn(axes, "path")) < 25_000
    assert len([p for p in axes.patches if isinstance(p, Polygon)]) == 2


def test_long_curves_look_the_same():
    t = np.linspace(0, 1, 1_000_000)
    x, y = np.cos(40 * t) * t, np.sin(300 * t)
    seen = np.stack(thinned_curve(x, y), axis=1)
    assert len(seen) < 60_000
    assert np.nanmax(seen[:, 1]) == y.max()
    seen = seen[np.isfinite(seen[:, 0])]
    away, _ = cKDTree(seen).query(np.stack([x, y], axis=1)[::97])
    assert away.max() < 0.01


def test_travel_is_drawn_next_to_the_indentation():
    contact = mdr.Contact(TIP, GEL, adhesion=mdr.JKR("2 mJ/m^2"))
    path = mdr.travel("2 um", steps=10) >> mdr.travel("-20 um", steps=40)
    figure = mdr.solve(contact, path, machine_stiffness="0.05 N/m").figures()["loop"]
    assert [x for x, _ in labels(figure)] == ["travel of the machine $D$ (µm)", "indentation $d$ (µm)"]


@pytest.mark.parametrize("mu", [0.0, 0.3, math.inf])
def test_frictional_figures(mu):
    contact = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(mu))
    result = mdr.solve(contact, mdr.load("50 N", steps=5) >> mdr.cycle(shift="0.5 um", steps=40))
    figures = result.figures()
    assert sorted(figures) == ["energies", "loop", "section", "tractions"]
    loop = figures["loop"].axes[0]
    force, unit = result["tangential_force"].values, loop.get_ylabel().rpartition("(")[2].rstrip(")")
    np.testing.assert_allclose(
        loop.lines[0].get_ydata(), result.to("tangential_force", unit).values, rtol=1e-12, atol=1e-12
    )
    assert force.size == 45
    for figure in (result.plot(), *figures.values()):
        assert not faults(figure)


def test_long_histories_are_thinned_with_their_extremes():
    contact = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(0.3))
    n = 300_000
    path = mdr.Path(indentation=np.full(n, 2e-6), shift=4e-7 * np.sin(np.arange(n) * 0.1))
    result = mdr.solve(contact, path)
    line = result.figures()["loop"].axes[0].lines[0]
    assert line.get_xdata().size < 25_000
    assert max(line.get_ydata()) == result["tangential_force"].values.max()


def test_loop_study():
    contact = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(0.3))
    figure = mdr.friction_loop(contact, np.geomspace(1e-8, 1e-6, 20), normal_force="50 N").plot()
    assert [y for _, y in labels(figure)] == [
        "energy dissipated per cycle (µJ)",
        "damping ratio",
        "secant stiffness (MN/m)",
    ]


def test_saved_results_draw_the_same():
    result = mdr.solve(mdr.Contact(TIP, GEL, adhesion=mdr.JKR("2 mJ/m^2")), THERE_AND_BACK)
    import pickle

    again = pickle.loads(pickle.dumps(result))
    one, other = (drawn(r.figures()["loop"].axes[0], "stable equilibria") for r in (result, again))
    np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("profile", [TIP, mdr.Cone(slope=0.349)])
def test_laws_are_compared(profile):
    regime = mdr.adhesion_regime(mdr.Contact(profile, GEL, adhesion=LAWS[0]), range="200 nm")
    left, right = regime.plot().axes
    assert labels(regime.plot())[1][1].startswith("pressure $p$ (")
    lowest = [line.get_ydata().min() * units(left)[1] for line in left.lines if line.get_label()[0] != "_"]
    np.testing.assert_allclose(lowest, list(regime.pull_off_force.values()), rtol=1e-12)
    maugis, jkr, _ = (line.get_ydata() for line in right.lines if line.get_label()[0] != "_")
    pull = f"{-1e9 * regime.pull_off_force['DMT']:.4g}"
    assert any(f"and a pull of {pull} nN outside" in str(line.get_label()) for line in right.lines)
    # JKR leaves the picture, Maugis and Dugdale end at the strength work / range
    assert np.nanmin(jkr[np.isfinite(jkr)]) < right.get_ylim()[0] < np.nanmin(maugis)
    kilo = 1e3 if "(kPa)" in right.get_ylabel() else 1.0
    assert np.nanmin(maugis) * kilo == pytest.approx(-2e-3 / 200e-9, rel=1e-9)


def test_rows_are_not_joined_where_others_were_refused():
    contact = mdr.Contact(wavy(4e-7, 2.5e5), mdr.Elastic("1 MPa", 0.5), adhesion=mdr.JKR("10 mJ/m^2"))
    result = mdr.solve(contact, mdr.indent("4 um", steps=100) >> mdr.load("-50 uN", steps=5))
    assert result.status is mdr.Status.ADHESION_PARTLY_REFUSED
    axes = result.figures()["loop"].axes[0]
    path = next(line for line in axes.lines if line.get_label() == "path")
    assert path.get_linestyle() == "None"
    known = np.isfinite(result.data["normal_force"].values)
    np.testing.assert_array_equal(np.isfinite(path.get_ydata()), known)


@settings(max_examples=8, deadline=None)
@given(keep=st.integers(1, 20), cycles=st.integers(1, 4))
def test_rows_that_were_not_kept_are_not_joined(keep, cycles):
    joint = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(0.3))
    path = mdr.load("50 N") >> mdr.cycle(shift="0.3 um", cycles=cycles, steps=40 * cycles)
    result = mdr.solve(joint, path, keep=keep)
    figures = result.figures()
    rows = result["row"].values if "row" in result.data.coords else np.arange(result.data.sizes["step"])
    left_out = np.any(np.diff(rows) > 1)
    zones = next(axes for axes in figures["loop"].axes if axes.get_ylabel().startswith("radius"))
    for axes in (zones, *figures["energies"].axes):
        history = [line for line in axes.lines if not str(line.get_label()).startswith("_")]
        assert history
        assert all((line.get_linestyle() == "None") == left_out for line in history)
    filled = [c for c in zones.collections if isinstance(c, PolyCollection)]
    assert bool(filled) != left_out


JOINT = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(0.3))


def letters(figure):
    return [
        t.get_text() for axes in figure.axes for t in axes.texts if re.fullmatch(r"\([a-h]\)", t.get_text())
    ]


def words(figure):
    return "\n".join(t.get_text() for axes in figure.axes for t in axes.texts)


def test_panels_have_letters():
    slide = mdr.solve(JOINT, mdr.load("50 N") >> mdr.shift("0.5 um", steps=5))
    pulled = mdr.solve(mdr.Contact(TIP, GEL, adhesion=LAWS[0]), THERE_AND_BACK)
    for result in (slide, pulled):
        assert letters(result.plot()) == ["(a)", "(b)", "(c)", "(d)"]
    assert letters(slide.figures()["energies"]) == []
    assert letters(slide.figures()["tractions"]) == ["(a)", "(b)"]


@settings(max_examples=examples(10), deadline=None)
@given(st.floats(0.05, 2.0), st.lists(st.floats(0.2, 1.0), min_size=2, max_size=5), st.booleans())
def test_loops_stay_between_the_limits_of_friction(mu, swings, steady):
    contact = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(mu))
    n = len(swings)
    load = np.full(n, 50.0) if steady else 30.0 + 20.0 * np.cos(np.arange(n))
    shift = mu * 4e-6 * np.array(swings) * (-1.0) ** np.arange(n)
    result = mdr.solve(contact, mdr.load("50 N") >> mdr.Path(normal_force=load, shift=shift))
    axes = result.figures()["loop"].axes[0]
    force = axes.lines[0].get_ydata()
    upper, lower = (line for line in axes.lines if line.get_linestyle() == "--")
    assert upper.get_label() == "$\\pm\\mu F_N$"
    for limit in (np.asarray(upper.get_ydata()), -np.asarray(lower.get_ydata())):
        limit = limit if limit.size == force.size else np.full(force.size, limit[0])
        sheared = force != 0.0
        assert np.all(np.abs(force[sheared]) <= limit[sheared] * (1 + 1e-9))
        moved = result["normal_force"].values[sheared] * mu
        assert limit[sheared] / moved == pytest.approx(limit[sheared][0] / moved[0], rel=1e-6)


@settings(max_examples=examples(10), deadline=None)
@given(st.floats(0.03, 0.97))
def test_curves_of_tractions_have_no_corners_where_stick_begins(fraction):
    path = mdr.load("50 N") >> mdr.shift(fraction * 0.3 * 1.2 * 2.194e-6, steps=3)
    result = mdr.solve(JOINT, path)
    axes = result.figures()["tractions"].axes[0]
    line = next(line for line in axes.lines if line.get_label() == "step 3")
    x, y = line.get_xdata() * 1e-6, np.asarray(line.get_ydata())
    assert "(µm)" in axes.get_xlabel()
    a, b = (float(result[name][-1]) for name in ("contact_radius", "stick_radius"))
    fine = np.concatenate([b - b * np.geomspace(1e-5, 0.5, 400), b + (a - b) * np.geomspace(1e-5, 0.9, 400)])
    exact = result.field("shear_traction", r=fine).values
    scale = float(to_si(f"1 {axes.get_ylabel().rpartition('(')[2].rstrip(')')}", "Pa"))
    assert np.max(np.abs(np.interp(fine, x, y) * scale - exact)) < 5e-3 * exact.max()


def test_the_section_shows_where_bodies_stick():
    result = mdr.solve(JOINT, mdr.load("50 N") >> mdr.shift("0.4 um", steps=4))
    upper = result.figures()["section"].axes[0]
    stick = next(p for p in upper.patches if p.get_label() == "stick")
    low, width = stick.get_x(), stick.get_width()
    b = float(result["stick_radius"][-1]) * 1e6
    assert [low, width] == pytest.approx([-b, 2 * b], rel=1e-12)
    assert any(p.get_label() == "slip" for p in upper.patches)


def test_legends_state_the_time():
    t = np.linspace(0.0, 2.0, 21)
    result = mdr.solve(JOINT, mdr.Path(time=t, normal_force=np.full(21, 50.0), shift=4e-7 * np.sin(5 * t)))
    labels = [text.get_text() for text in result.figures()["loop"].axes[0].get_legend().get_texts()]
    assert "step 20, $t$ = 2 s" in labels
    pulled = mdr.solve(mdr.Contact(TIP, GEL, adhesion=LAWS[0]), mdr.Path(time=t, indentation=1e-6 * (1 + t)))
    assert "$t$ = 2 s" in pulled.figures()["fields"].axes[0].get_xlabel()


@pytest.mark.parametrize(("depth", "enlarged"), [("20 um", True), ("1 um", False)])
def test_the_pull_of_a_deep_loop_is_enlarged(depth, enlarged):
    contact = mdr.Contact(TIP, GEL, adhesion=LAWS[0])
    result = mdr.solve(contact, mdr.indent(depth, steps=50) >> mdr.indent("-3 um", steps=50))
    axes = result.figures()["loop"].axes[0]
    assert bool(axes.child_axes) == enlarged
    if enlarged:
        (inset,) = axes.child_axes
        pull_off = mdr.pull_off(contact)
        x, y = np.array([pull_off.indentation, pull_off.normal_force]) / units(axes)
        assert inset.get_xlim()[0] < x < inset.get_xlim()[1]
        assert inset.get_ylim()[0] < y < 0 < inset.get_ylim()[1]
        assert np.ptp(inset.get_ylim()) < np.ptp(axes.get_ylim()) / 6


def test_the_pressure_of_dmt_names_the_pull_that_is_not_in_it():
    result = mdr.solve(mdr.Contact(TIP, GEL, adhesion=LAWS[2]), THERE_AND_BACK)
    pull = 2 * math.pi * 2e-3 * 50e-6
    assert f"a pull of {pull * 1e9:.4g} nN" in words(result.figures()["fields"])
    other = mdr.solve(mdr.Contact(TIP, GEL, adhesion=LAWS[1]), THERE_AND_BACK)
    assert "a pull of" not in words(other.figures()["fields"])


def test_bands_are_drawn_with_adhesion():
    r = np.linspace(0.0, 20e-6, 41)
    tip = mdr.Sampled(r, r**2 / 100e-6, np.where(r > 0.0, 3e-9, 0.0))
    result = mdr.solve(mdr.Contact(tip, GEL, adhesion=mdr.JKR("0.1 mJ/m^2")), mdr.indent("0.3 um", steps=10))
    figures = result.figures()
    for axes, name in (
        (figures["loop"].axes[0], "normal_force"),
        (figures["radius"].axes[0], "contact_radius"),
    ):
        band = next(c for c in axes.collections if c.get_label() == "band of the scatter")
        scale = float(
            to_si(f"1 {axes.get_ylabel().rpartition('(')[2].rstrip(')')}", result[name].attrs["units"])
        )
        y = band.get_paths()[0].vertices[:, 1] * scale
        ends = np.concatenate(result.bands[name])
        assert [y.min(), y.max()] == pytest.approx([np.nanmin(ends), np.nanmax(ends)], rel=1e-9)


HOLLOW = mdr.FlatPunch("1 mm") + mdr.Function(lambda r: -(r**2), derivative=lambda r: -2 * r)


@pytest.mark.parametrize(
    "contact_and_path",
    [
        (mdr.Contact(HOLLOW, GEL), mdr.indent("0.5 um", steps=4)),
        (mdr.Contact(HOLLOW, GEL), mdr.load("1 uN", steps=4)),
        (mdr.Contact(wavy(1e-6), STEEL, adhesion=mdr.JKR("50 mJ/m^2")), mdr.indent("1 um", steps=4)),
    ],
)
def test_a_refused_contact_shows_its_profile_and_why(contact_and_path):
    result = mdr.solve(*contact_and_path)
    assert result.status.name.endswith("REFUSED")
    axes = result.plot().axes[0]
    label = " ".join(axes.get_xlabel().split())
    assert " ".join(result.claims["pressure"].reason.split()) in label
    x = axes.lines[-1].get_xdata()
    unit = float(to_si(f"1 {axes.get_xlabel().split('(')[1].split(')')[0]}", "m"))
    height = float(to_si(f"1 {axes.get_ylabel().rpartition('(')[2].rstrip(')')}", "m"))
    r = np.abs(x) * unit
    f = contact_and_path[0].profile.gap(r)
    expected = np.where(np.isfinite(f), f - f[np.isfinite(f)].min(), np.nan)
    np.testing.assert_allclose(axes.lines[-1].get_ydata() * height, expected, rtol=1e-9, atol=1e-18)
    for figure in result.figures().values():
        assert not faults(figure)


@settings(max_examples=examples(9), deadline=None)
@given(st.integers(1, 6), st.floats(0.1, 3.0))
def test_every_lower_bound_is_seen(steps, depth):
    """One row is a point, which no dashes show."""
    result = mdr.solve(
        mdr.Contact(HOLLOW, GEL), mdr.Path(indentation=1e-6 * depth * np.linspace(1.0, 2.0, steps))
    )
    lines = [line for axes in result.plot().axes for line in axes.lines]
    bounds = [line for line in lines if str(line.get_label()).startswith("rigorous lower bound")]
    refused = (
        not np.isfinite(result.data["normal_force"].values).all() if "normal_force" in result.data else True
    )
    assert len(bounds) == refused
    assert all(line.get_marker() == "o" for line in bounds)
