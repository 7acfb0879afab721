"""Every figure can be read: texts inside the canvas and clear of one another, axes with units, colours told apart."""

import itertools
import math

import matplotlib.style
import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

import pymdr as mdr
from common import GEL, STEEL
from drawing import examples
from legibility import faults
from pymdr.presentation.plot.impacts import restitution_study
from pymdr.presentation.plot.shared import CYCLE, GREY, legend_above, new_figure
from pymdr.presentation.plot.studies import columns_study
from pymdr.quantities import parameter_label

BALL, TIP = mdr.Paraboloid("10 mm"), mdr.Paraboloid("50 um")
SOLID = mdr.Viscoelastic(mdr.StandardSolid("1 MPa", "9 MPa", "1 ms"), poisson=0.5)
COPPER = mdr.Elastic(
    "120 GPa",
    0.34,
    thermal_conductivity="400 W/(m K)",
    thermal_diffusivity="117 mm^2/s",
    resistivity="17 nohm m",
)
GLUED = mdr.Layered([mdr.Layer(GEL, "20 um")], base=mdr.Elastic("1 GPa", 0.3))
JKR, MAUGIS, DMT = (
    mdr.JKR("2 mJ/m^2"),
    mdr.MaugisDugdale("2 mJ/m^2", range="100 nm"),
    mdr.DMT("2 mJ/m^2"),
)
HOLLOW = mdr.FlatPunch("1 mm") + mdr.Function(lambda r: -(r**2), derivative=lambda r: -2 * r)
PRESSED = mdr.indent("1 um", steps=20) >> mdr.indent("-3 um", steps=40)
PULLED = mdr.travel("2 um", steps=20) >> mdr.travel("-20 um", steps=40)
SHEARED = mdr.load("50 N", steps=5) >> mdr.cycle(shift="0.5 um", steps=40)
DEPTHS = np.linspace(0.0, 2e-6, 41)[1:]
CURVE = mdr.ForceCurve(DEPTHS, 1e10 * DEPTHS**1.5, modulus="115 GPa")
RADII = np.linspace(0.0, 1e-3, 41)
SAMPLED = mdr.Sampled(RADII, RADII**2 / 0.02, scatter=2e-5 * RADII)
SLOW = mdr.indent("1 um", steps=10, duration="1 ms") >> mdr.hold("5 ms", steps=10)


def solved(profile, path, *bodies, **given):
    how = {name: given.pop(name) for name in ("machine_stiffness", "solver", "keep") if name in given}
    return mdr.solve(mdr.Contact(profile, *bodies, **given), path, **how)


RESULTS = {
    "plain": lambda: solved(BALL, mdr.load("50 N", steps=5), STEEL, STEEL),
    "jkr": lambda: solved(TIP, PRESSED, GEL, adhesion=JKR),
    "machine": lambda: solved(TIP, PULLED, GEL, adhesion=JKR, machine_stiffness="0.05 N/m"),
    "friction": lambda: solved(BALL, SHEARED, STEEL, STEEL, friction=mdr.Coulomb(0.3)),
    "memory": lambda: solved(BALL, SLOW, SOLID),
    "maugis": lambda: solved(TIP, PULLED, GEL, adhesion=MAUGIS, machine_stiffness="0.05 N/m"),
    "dmt": lambda: solved(TIP, PRESSED, GEL, adhesion=DMT),
    "deep": lambda: solved(TIP, mdr.indent("20 um", steps=20), GEL, adhesion=JKR),
    "lost": lambda: solved(TIP, mdr.load("0 N") >> mdr.load("-1 uN", steps=20), GEL, adhesion=JKR),
    "untouched": lambda: solved(TIP, mdr.indent("-1 um", steps=3), GEL, adhesion=JKR),
    "torsion": lambda: solved(
        BALL, mdr.load("50 N") >> mdr.cycle(twist="1 mrad", steps=40), STEEL, STEEL, friction=mdr.Coulomb(0.3)
    ),
    "single row": lambda: solved(TIP, mdr.indent("1 um"), GEL, adhesion=JKR),
    "flat": lambda: solved(mdr.FlatPunch("10 um"), PRESSED, GEL, adhesion=JKR),
    "cone": lambda: solved(mdr.Cone(slope=0.1), mdr.indent("1 um", steps=3), STEEL),
    "worn": lambda: solved(mdr.TruncatedSphere("1 m", flat_radius="1 mm"), mdr.load("1 kN", steps=5), STEEL),
    "scatter": lambda: solved(SAMPLED, mdr.indent("1 um", steps=10), STEEL),
    "stuck": lambda: solved(BALL, SHEARED, STEEL, STEEL, friction=mdr.Coulomb(math.inf)),
    "kept": lambda: solved(BALL, SHEARED, STEEL, STEEL, friction=mdr.Coulomb(0.3), keep=7),
    "memory and friction": lambda: solved(
        BALL, SLOW >> mdr.shift("1 um", steps=5, duration="1 ms"), SOLID, friction=mdr.Coulomb(0.3)
    ),
    "layers": lambda: solved(TIP, mdr.indent("5 um", steps=4), GLUED),
    "sticky layers": lambda: solved(TIP, PRESSED, GLUED, adhesion=JKR),
    "rings": lambda: solved(BALL, mdr.indent("1 um", steps=3), STEEL, solver=mdr.Rings(n=40)),
    "conduction": lambda: solved(BALL, mdr.load("50 N", steps=5), COPPER, COPPER),
    "ellipse": lambda: solved(mdr.EllipticParaboloid("10 mm", "3 mm"), mdr.load("50 N", steps=3), STEEL),
    "pyramid": lambda: solved(mdr.Pyramid.vickers(), mdr.indent("1 um", steps=3), STEEL),
    "curve": lambda: solved(CURVE, mdr.indent("1 um", steps=3), STEEL, STEEL),
    "sheared curve": lambda: solved(
        CURVE,
        mdr.indent("1 um", steps=3) >> mdr.cycle(shift="0.1 um", steps=40),
        STEEL,
        STEEL,
        friction=mdr.Coulomb(0.3),
    ),
    "refused": lambda: solved(HOLLOW, mdr.indent("0.5 um", steps=4), GEL),
}


@pytest.mark.parametrize("name", RESULTS)
def test_figures_of_results_can_be_read(name):
    result = RESULTS[name]()
    for kind, figure in {"overview": result.plot(), **result.figures()}.items():
        assert not faults(figure), kind


ROAD = mdr.RoughSurface(hurst=0.8, rms="5 um", size="1 mm", shortest="50 um", seed=1)
JOINT = mdr.Contact(BALL, STEEL, STEEL, friction=mdr.Coulomb(0.3))
STICKY = mdr.Contact(TIP, GEL, adhesion=JKR)
WIRE = mdr.Contact(BALL, COPPER, COPPER, friction=mdr.Coulomb(0.5))
PIXELS = (np.arange(64) + 0.5) * 1e-8
BUMP = mdr.Topography(-np.add.outer((PIXELS - 3e-7) ** 2, (PIXELS - 3.4e-7) ** 2) / 2e-6, 6.4e-7)
ROUGH = mdr.Topography(1e-8 * np.cumsum(np.random.default_rng(0).normal(size=(64, 64)), axis=0), "1 um")
TIMES = np.geomspace(1e-3, 1e2, 41)


def measured(seed=0):
    """A noisy approach to a gel."""
    positions = np.linspace(-1e-6, 1e-6, 120)
    force = solved(TIP, mdr.Path(indentation=positions), GEL)["normal_force"].values
    noise = 0.002 * force.max() * np.random.default_rng(seed).normal(size=positions.size)
    return mdr.MeasuredCurve(indentation=positions, force=force + noise)


class DrawnPoint:
    """The contact point of a curve."""

    def __init__(self, curve):
        self.curve = curve

    def plot(self):
        """It is drawn in its curve."""
        return self.curve.contact_point().plot(self.curve)


def pressed():
    pytest.importorskip("ContactMechanics", reason="ContactMechanics, of the extra rough, is missing")
    return mdr.press(BUMP, STEEL, indentation=["1 nm", "2 nm"])


def loop():
    angle = np.linspace(0.0, 20.0, 400)
    record = {"shift": ("step", np.sin(angle)), "tangential_force": ("step", np.sin(angle + 0.1))}
    return mdr.measured_loops(xr.Dataset(record))


def fretted(*amplitudes):
    """Cycles of a joint under a constant load, as a rig records them."""
    path = mdr.load("50 N")
    for amplitude in amplitudes:
        path = path >> mdr.cycle(shift=amplitude, steps=40)
    return mdr.solve(JOINT, path).data[["shift", "tangential_force", "normal_force"]]


STUDIES = {
    "wear": lambda: mdr.wear(
        JOINT, mdr.indent("1 um") >> mdr.cycle(shift="0.2 um"), coefficient="2e-5 mm^3/(N m)", cycles=1e3
    ),
    "running conditions": lambda: mdr.running_conditions(
        JOINT, [10.0, 50.0, 100.0], record=mdr.fretting_log(fretted("0.2 um", "0.4 um"))
    ),
    "one cycle of fretting": lambda: mdr.fretting_log(fretted("0.2 um", "0.4 um")),
    "fretting": lambda: mdr.fretting_log(fretted(*["0.4 um"] * 15)),
    "yield": lambda: mdr.first_yield(mdr.Contact(BALL, STEEL), strength="2 GPa"),
    "torsion by rings": lambda: mdr.verify(
        JOINT, mdr.load("50 N") >> mdr.twist("1 mrad", steps=4), elements=40
    ),
    "impact": lambda: mdr.impact(mdr.Contact(BALL, STEEL), mass="4 g", speed="0.1 m/s"),
    "pull-off": lambda: mdr.pull_off(STICKY),
    "regime": lambda: mdr.adhesion_regime(STICKY, range="200 nm"),
    "loops": lambda: mdr.friction_loop(JOINT, np.geomspace(1e-8, 1e-6, 9), normal_force="50 N"),
    "conditions": lambda: mdr.assess(STICKY, mdr.indent("1 um")),
    "sweep": lambda: mdr.sweep(
        mdr.Contact(TIP, GEL),
        mdr.indent("1 um", steps=4),
        {"body.young": ["1 kPa", "2 kPa"], "profile.radius": ["20 um", "50 um"]},
    ),
    "fit": lambda: mdr.fit(mdr.Contact(TIP, GEL), measured(), ["body.young"]),
    "oblique impact": lambda: mdr.impact(JOINT, mass="4 g", speed="0.1 m/s", angle="30 deg"),
    "restitution": lambda: mdr.restitution(mdr.Contact(BALL, SOLID), mass="4 g", speeds=[0.05, 0.2, 1.0]),
    "loops of coefficients": lambda: mdr.friction_loop(
        JOINT, np.geomspace(1e-8, 1e-6, 9), coefficient=[0.2, 0.3, 0.4], normal_force="50 N"
    ),
    "measured loops": loop,
    "prony": lambda: mdr.fit_prony(
        {"omega": TIMES, "storage": SOLID.shear.storage(TIMES), "loss": SOLID.shear.loss(TIMES)}
    ),
    "bump": lambda: mdr.azimuthal_profile(BUMP),
    "spectrum": lambda: mdr.power_spectrum(ROUGH),
    "rings": lambda: mdr.verify(mdr.Contact(BALL, STEEL), mdr.indent("1 um", steps=2), elements=40),
    "rings in time": lambda: mdr.verify(mdr.Contact(BALL, SOLID), SLOW, elements=40),
    "boundary elements": lambda: mdr.verify(
        mdr.Contact(mdr.EllipticParaboloid("10 mm", "3 mm"), STEEL), mdr.indent("1 um", steps=2), elements=33
    ),
    "sheared grid": lambda: mdr.verify(
        JOINT, mdr.ramp(indentation="2 um", shift="0.4 um", steps=4), elements=12
    ),
    "rolling": lambda: mdr.rolling(JOINT, [-1e-3, 1e-3, 4e-3], normal_force="100 N"),
    "sliding": lambda: mdr.sliding_friction(mdr.Contact(BALL, SOLID), [1e-3, 0.1, 10.0], normal_force="1 N"),
    "road": lambda: mdr.rough_sliding_friction(ROAD, SOLID, [1e-3, 0.1], normal_force="1 N"),
    "joule": lambda: mdr.joule_heating(
        solved(BALL, mdr.load("50 N", steps=5), COPPER, COPPER), voltage="90 mV", temperature="20 degC"
    ),
    "frictional heat": lambda: mdr.frictional_heat(WIRE, ["10 mm/s", "50 mm/s"], normal_force="1 N"),
    "rough": lambda: mdr.press_rough(ROAD, STEEL, normal_force=["1 N", "10 N"], realisations=3),
    "thickness": lambda: mdr.thickness_correction(
        TIP, 0.5, thickness="20 um", indentation=np.geomspace(1e-7, 5e-6, 9)
    ),
    "pressed": lambda: pressed(),
    "law": lambda: mdr.export_law(mdr.Contact(TIP, GEL), "5 um"),
    "sticky law": lambda: mdr.export_law(STICKY, "5 um"),
    "laws": lambda: mdr.compare_laws(
        {"Hertz": mdr.Contact(TIP, GEL), "DMT": mdr.Contact(TIP, GEL, adhesion=DMT)},
        measured(),
        ["body.young"],
    ),
    "map": lambda: mdr.fit_map(
        mdr.Contact(TIP, GEL), [measured(seed) for seed in range(4)], ["body.young"], contact_point="0 m"
    ),
    "contact point": lambda: DrawnPoint(measured()),
}


@pytest.mark.parametrize("name", STUDIES)
def test_figures_of_studies_can_be_read(name):
    assert not faults(STUDIES[name]().plot())


def test_loops_of_a_case_are_drawn_with_their_curve():
    result = mdr.solve(JOINT, mdr.load("50 N") >> mdr.cycle(shift="0.6 um", cycles=3, steps=60))
    figure = mdr.measured_loops(result).plot()
    assert not faults(figure)
    assert [axes.texts[0].get_text() for axes in figure.axes] == [f"({letter})" for letter in "abcdefghi"]
    assert figure.get_figwidth() <= 12.0
    x, y = figure.axes[0].lines[0].get_data()
    assert x == pytest.approx(1e9 * result["shift"].values)
    assert y == pytest.approx(result["tangential_force"].values)


def test_the_largest_value_is_not_cut_where_an_axis_begins_at_zero():
    speeds = xr.Dataset(
        {"restitution": ("speed", [0.371, 0.379]), "contact_time": ("speed", [1e-3, math.inf])},
        coords={"speed": [0.1, 0.3]},
    )
    axes = restitution_study(speeds).axes
    assert axes[0].get_ylim() == (0.0, pytest.approx(1.05 * 0.379))
    assert axes[1].get_ylim() == (0.0, pytest.approx(1.05))


# linear RGB as it is seen without red, green or blue cones (Machado, Oliveira and Fernandes 2009, table 1)
WITHOUT_CONES = {
    "none": np.eye(3),
    "red": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "green": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "blue": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}
TO_XYZ = np.array([[0.4339, 0.3762, 0.1899], [0.2126, 0.7152, 0.0722], [0.0178, 0.1095, 0.8727]])
"""From linear sRGB, relative to its white."""


def lab(colour, missing):
    """CIELAB of a colour as it is seen."""
    rgb = np.array(to_rgb(colour))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    x, y, z = np.cbrt(TO_XYZ @ np.clip(WITHOUT_CONES[missing] @ linear, 1e-3, 1.0))
    return np.array([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)])


def test_figures_of_others_may_have_the_style():
    with matplotlib.style.context("pymdr.figures"), new_figure(3.0, 2.0) as figure:
        assert matplotlib.rcParams["axes.prop_cycle"].by_key()["color"] == list(CYCLE)
        assert figure.dpi == 150


@pytest.mark.parametrize("missing", WITHOUT_CONES)
def test_colours_can_be_distinguished(missing):
    # 2.3 is just noticeable; red and green of most default cycles are 5 apart
    for one, other in itertools.combinations((*CYCLE, GREY), 2):
        assert np.linalg.norm(lab(one, missing) - lab(other, missing)) > 12.0


def test_faults_are_seen():
    figure = Figure(figsize=(3.0, 2.0))
    axes = figure.add_axes((0.2, 0.2, 0.7, 0.7))
    axes.plot([0.0, 1.0], [0.0, 3e7], label="diagonal")
    axes.legend(loc="center")
    axes.set_xlabel("body.young (Pa)")
    axes.text(0.5, 0.1, "one"), axes.text(0.5, 0.1, "another"), axes.text(0.9, 0.1, "too far to the right")
    noise = figure.add_axes((0.2, 0.2, 0.1, 0.1))
    noise.plot([0.0, 1.0], [1e-15, 2e-15], "o")
    noise.set(ylabel="relative error", ylim=(1e-15, 3e-15))
    seen = "\n".join(faults(figure))
    for words in (
        "'too far to the right' leaves the canvas",
        "'one' overlaps 'another'",
        "covers the line 'diagonal'",
        "has the factor '1e7'",
        "the axis '' has no unit",
        "the panel 'relative error' shows rounding",
        "the axes 'relative error' cut points",
        "'body.young (Pa)' has a name of the program",
    ):
        assert words in seen


@settings(deadline=None, max_examples=examples(9))
@given(st.floats(1e-9, 1e9), st.floats(0.0, 1e-5), st.booleans())
def test_columns_that_hardly_differ_are_not_enlarged(size, spread, negative):
    values = (-size if negative else size) * (1.0 + spread * np.sin(np.arange(5)))
    data = xr.Dataset({"force": ("step", values, {"units": "N"})}, coords={"step": np.arange(5)})
    figure = columns_study(data, {"force": "force"})
    low, high = sorted(figure.axes[0].get_ylim())
    assert low <= 0.0 <= high
    assert not faults(figure)


def test_columns_of_zeros_have_no_scale_and_whole_points():
    data = xr.Dataset({"stick_radius": ("cycle", [0.0], {"units": "m"})}, coords={"cycle": [1]})
    figure = columns_study(data, {"stick_radius": "stick radius"})
    assert list(figure.axes[0].get_yticks()) == [0.0]
    assert not faults(figure)


def test_values_that_differ_little_are_whole_numbers_at_their_axis():
    with new_figure(3.0, 2.0) as figure:
        axes = figure.subplots()
        axes.plot([1.0, 2.0, 3.0], [299.85, 299.99, 300.0])
        axes.set(xlabel="speed (m/s)", ylabel="work (J)")
    assert not faults(figure)
    assert [text.get_text() for text in axes.get_yticklabels()][1].startswith("299.")


@settings(deadline=None, max_examples=examples(9))
@given(st.floats(-2.0, 3.0), st.lists(st.text("abcdefgh", min_size=1, max_size=30), min_size=1, max_size=8))
def test_legends_fit_between_the_sides(log_size, labels):
    with new_figure(8.0, 6.0) as figure:
        for axes in figure.subplots(1, 2):
            for i, label in enumerate(labels):
                axes.plot([0.0, 1.0], [0.0, 10.0**log_size * i], label=label)
            axes.set(xlabel="x (m)", ylabel="y (m)")
            legend_above(axes)
    assert not faults(figure)


def test_labels_of_all_parameters_are_words():
    layered = mdr.Layered([mdr.Layer(GEL, "1 um"), mdr.Layer(STEEL, "1 um")], base=STEEL)
    for contact in (
        mdr.Contact(BALL + mdr.Cone(slope=0.1), layered, adhesion=JKR),
        mdr.Contact(TIP, STEEL, SOLID, friction=mdr.Coulomb(0.3)),
    ):
        names = [one.name for one in mdr.parameters_of(contact)]
        words = [parameter_label(name) for name in names]
        assert len(set(words)) == len(names)
        assert not any(set("._[]") & set(label) for label in words)


@pytest.mark.parametrize(
    ("low", "high", "labels"),
    [
        (2.0, 20.0, {"2", "5", "10", "20"}),
        (20.0, 40.0, {"20", "30", "40"}),
        (3.0, 150.0, {"5", "10", "20", "50", "100"}),
        (1.0, 1e4, None),
        (1e-6, 1e-5, None),
    ],
)
def test_short_logarithmic_axes_have_plain_numbers(low, high, labels):
    with new_figure(4.0, 3.0) as figure:
        axes = figure.subplots()
        axes.semilogx([low, high], [0.0, 1.0])
    figure.canvas.draw()
    inside = [label.get_text() for label in axes.get_xticklabels() if low <= label.get_position()[0] <= high]
    if labels is None:
        assert all("10^" in text for text in inside)
    else:
        assert set(inside) == labels
        assert not any(label.get_text() for label in axes.get_xticklabels(minor=True))
