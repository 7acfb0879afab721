"""Figures, animations and tables of the stress inside the bodies."""

import csv
import math
import typing

import numpy as np
import pytest

import pymdr as mdr
from common import GEL, STEEL
from legibility import faults
from pymdr.inside import DRAWN
from pymdr.problem.codec.models import case_adapter
from pymdr.solving.verb import solve

ALUMINIUM = mdr.Elastic("70 GPa", 0.33)
BALL, TIP = mdr.Paraboloid("10 mm"), mdr.Paraboloid("50 um")
COAT = mdr.Layered([mdr.Layer(mdr.Elastic("450 GPa", 0.22), "20 um")], base=STEEL)
FILM = mdr.Layered([mdr.Layer(GEL, "20 um")], base=mdr.Rigid())


def solved(profile, path, *bodies, **given):
    return solve(mdr.Contact(profile, *bodies, **given), path)


SHEARED = mdr.load("50 N", steps=2) >> mdr.cycle(shift="0.8 um", steps=8)
RESULTS = {
    "pair": lambda: solved(BALL, mdr.load("50 N", steps=2), STEEL, ALUMINIUM),
    "rigid": lambda: solved(BALL, mdr.load("50 N"), STEEL),
    "counterbody only": lambda: solved(BALL, mdr.load("50 N"), mdr.Rigid(), STEEL),
    "friction": lambda: solved(BALL, SHEARED, STEEL, ALUMINIUM, friction=mdr.Coulomb(0.3)),
    "coat": lambda: solved(BALL, mdr.load("20 N"), COAT, STEEL),
    "film": lambda: solved(TIP, mdr.indent("1 um"), FILM),
    "jkr": lambda: solved(TIP, mdr.indent("1 um"), GEL, adhesion=mdr.JKR("2 mJ/m^2")),
    "maugis": lambda: solved(
        TIP, mdr.indent("1 um"), GEL, adhesion=mdr.MaugisDugdale("2 mJ/m^2", range="100 nm")
    ),
    "cone": lambda: solved(mdr.Cone(slope=0.1), mdr.indent("1 um"), STEEL),
    "punch": lambda: solved(mdr.FlatPunch("1 mm"), mdr.indent("1 um"), STEEL, ALUMINIUM),
}


@pytest.mark.parametrize("name", RESULTS)
def test_figures_of_stress_can_be_read(name):
    assert not faults(RESULTS[name]().plot_stress())


@pytest.mark.parametrize("name", RESULTS)
def test_figures_of_tension_can_be_read(name):
    assert not faults(RESULTS[name]().plot_stress(name="principal_stress"))


def test_every_measure_is_drawn_and_a_superposed_stress_too():
    result = RESULTS["pair"]()
    for measure in DRAWN:
        assert not faults(result.plot_stress(name=measure, superposed={"xx": "300 MPa"})), measure


def texts(figure):
    return [text.get_text() for axes in figure.axes for text in (*axes.texts, axes.title, axes._left_title)]


def test_both_bodies_are_drawn_with_their_largest_values():
    result = RESULTS["pair"]()
    shown = texts(result.plot("stress"))
    assert {"body", "counterbody"} <= set(shown)
    assert sum("MPa" in text for text in shown) == 2
    assert "counterbody" not in texts(result.plot_stress(side="body"))


@pytest.mark.parametrize(
    ("name", "where"), [("jkr", "at the edge"), ("punch", "at the edge"), ("cone", "under the tip")]
)
def test_singular_places_are_named(name, where):
    assert f"the stress is infinite {where}" in texts(RESULTS[name]().plot("stress"))


def test_the_radial_stress_jumps_at_an_interface():
    centre = RESULTS["coat"]().plot_stress(side="body").axes[2]
    z, rr = (np.asarray(v) for v in centre.lines[0].get_data())
    jump = np.flatnonzero(np.diff(z) == 0.0)
    assert jump.size == 1
    assert rr[jump[0]] != rr[jump[0] + 1]


def test_figures_are_chosen_by_name():
    result = RESULTS["friction"]()
    assert result.plot("loop").axes
    assert result.plot("stress", step=3).axes
    for wrong, words in (("sterss", "figures are section, loop"), (3, "write step=3")):
        with pytest.raises(mdr.QuantityError, match=words):
            result.plot(wrong)
    with pytest.raises(mdr.QuantityError, match="drawn as von_mises, tresca"):
        result.plot_stress(name="stress")
    with pytest.raises(mdr.NotValidError, match="DMT does not resolve"):
        solved(TIP, mdr.indent("1 um"), GEL, adhesion=mdr.DMT("2 mJ/m^2")).plot("stress")


def test_a_cycle_as_an_animation(tmp_path):
    from PIL import Image

    result = RESULTS["friction"]()
    result.animate_stress(tmp_path / "cycle.gif", step=[2, 4, 6], side="body")
    with Image.open(tmp_path / "cycle.gif") as movie:
        assert movie.n_frames == 3
    with pytest.raises(mdr.FileError, match=r"end its name with \.gif"):
        result.animate_stress(tmp_path / "cycle.mp4")
    separated = solved(TIP, mdr.indent("-1 um", steps=2), GEL)
    with pytest.raises(mdr.NotValidError, match="do not touch"):
        separated.animate_stress(tmp_path / "none.gif")
    assert [file.name for file in tmp_path.iterdir()] == ["cycle.gif"]


CASE = """
[profile]
kind = "sphere"
radius = "10 mm"
[body]
kind = "elastic"
young = "210 GPa"
poisson = 0.3
[friction]
kind = "coulomb"
coefficient = 0.3
[stress]
measure = "principal_stress"
superposed = { xx = "80 MPa" }
animate = true
x = ["-0.1 mm", "0.1 mm"]
z = ["0 um", "50 um"]
[[path]]
kind = "load"
normal_force = "50 N"
[[path]]
kind = "shift"
shift = "0.8 um"
"""
TENSOR = {"xx": "80 MPa", "yy": "-20 MPa", "zz": "1 MPa", "xz": "2 kPa", "xy": "5 bar", "yz": "-3e5 Pa"}


def test_all_six_components_are_superposed_in_a_case(tmp_path, shell):
    six = ", ".join(f'{name} = "{text}"' for name, text in TENSOR.items())
    text = CASE.replace('superposed = { xx = "80 MPa" }', f"superposed = {{ {six} }}")
    (tmp_path / "case.toml").write_text(text)
    assert shell("run", tmp_path / "case.toml", "-q", "--no-figures")[0] == 0
    with (tmp_path / "case" / "stress.csv").open() as file:
        rows = list(csv.DictReader(file))
    result = mdr.open_result(tmp_path / "case" / "result.nc")
    alone = result.field("stress", x=[-1e-4, 1e-4], z=[0.0, 5e-5])
    added = [80e6, -20e6, 1e6, 2e3, 5e5, -3e5]
    for name, value in zip(TENSOR, added, strict=True):
        computed = np.array([float(row[f"stress_{name} [Pa]"]) for row in rows])
        assert computed - alone.sel(component=name).values.ravel() == pytest.approx(value, abs=1e-6)


def test_the_stress_of_a_case(tmp_path, shell):
    (tmp_path / "case.toml").write_text(CASE)
    code, *_ = shell("run", tmp_path / "case.toml", "-q")
    assert code == 0
    made = tmp_path / "case"
    assert {"stress.png", "stress.gif", "stress.csv"} <= {file.name for file in made.iterdir()}
    with (made / "stress.csv").open() as file:
        rows = list(csv.DictReader(file))
    result = mdr.open_result(made / "result.nc")
    field = result.field("stress", x=[-1e-4, 1e-4], z=[0.0, 5e-5], superposed={"xx": "80 MPa"})
    assert len(rows) == 4
    assert [float(row["stress_xx [Pa]"]) for row in rows] == field.sel(component="xx").values.ravel().tolist()
    assert shell("plot", made, "--stress", "--measure", "tresca", "-o", tmp_path / "t.pdf")[0] == 0
    assert (tmp_path / "t.pdf").stat().st_size > 1000
    assert "add --stress" in shell("plot", made, "--animate")[2]


@pytest.mark.parametrize(
    ("key", "words"),
    [
        ('measure = "mises"', "'von_mises', 'tresca', 'principal_stress' or 'hydrostatic' is needed"),
        ('superposed = { rr = "80 MPa" }', "unknown key 'rr'; one of 'xx'"),
        ('superposed = { xx = "80 mm" }', "a unit compatible with 'Pa' is needed"),
        ('superposed = { xx = "1,5 MPa" }', "superposed['xx']"),
        ('superposed = { yz = "nan Pa" }', "superposed['yz']"),
        ("superposed = {}", "components by name are needed"),
        ('superposed = "80 MPa"', "superposed"),
        ("superposed = { xx = true }", "superposed"),
        ('x = ["1 MPa"]', "a unit compatible with 'm' is needed"),
        ('animate = "yes"', "true or false is needed"),
        ('z = ["-1 um"]', "depths of at least 0 m"),
        ('r = ["1 um"]', "give x instead of r"),
        ("animat = true", "did you mean 'animate'"),
    ],
)
def test_what_is_wrong_in_a_case_is_named(tmp_path, shell, key, words):
    head, tail = CASE.split("[stress]")
    (tmp_path / "case.toml").write_text(f"{head}[stress]\n{key}\n{tail[tail.index('[[path]]') :]}")
    code, _, err = shell("run", tmp_path / "case.toml", "-q", "--no-figures")
    assert code == 1
    assert words in err
    if "superposed" in key or key[:1] in "rz":  # refused before anything is solved
        assert shell("check", tmp_path / "case.toml")[0] == 1
        assert not (tmp_path / "case" / "result.nc").exists()


def test_cases_know_the_measures_of_figures():
    model = case_adapter()._type.model_fields["stress"].annotation
    assert typing.get_args(model.model_fields["measure"].annotation) == DRAWN


def test_traction_at_a_kink_of_the_profile():
    # inside the zone of stick the singularities of the pressures at the kink cancel
    profile = mdr.TruncatedCone("5 um", slope=0.1)
    contact = mdr.Contact(profile, STEEL, friction=mdr.Coulomb(0.3))
    sticking = solve(contact, mdr.indent("1 um") >> mdr.shift("0.05 um"))
    assert float(sticking["stick_radius"][-1]) > 5e-6
    at, near = sticking.field("shear_traction", r=[5e-6, 5e-6 * (1.0 - 1e-7)]).values
    assert at == pytest.approx(near, rel=1e-4)
    sliding = solve(contact, mdr.indent("1 um") >> mdr.shift("5 um"))
    assert sliding.field("shear_traction", r=[5e-6]).values[0] == math.inf


def test_several_criteria_of_first_failure():
    coated = mdr.Contact(BALL, COAT, STEEL)
    yields = mdr.first_yield(
        coated, strength=["15 GPa", "2 GPa"], tensile_strength=["1 GPa", "3 GPa"], bond_strength="300 MPa"
    )
    loads = yields["normal_force"]
    shear = solve(coated, mdr.load(float(loads.sel(criterion="interface shear")))).largest(
        "interface_shear", -1
    )
    assert float(shear) == pytest.approx(300e6, rel=1e-7)
    crack = solve(coated, mdr.load(float(loads.sel(criterion="largest tension"))))
    assert float(crack.largest("principal_stress", -1)) == pytest.approx(1e9, rel=1e-7)
    # ring cracks of glass: (1 - 2 nu) p0 / 3 (Johnson 1985, section 3.4)
    glass = mdr.Contact(BALL, mdr.Elastic("70 GPa", 0.22), STEEL)
    ring = mdr.first_yield(glass, strength="3.6 GPa", tensile_strength="400 MPa").data.sel(
        criterion="largest tension"
    )
    assert float(ring["peak_pressure"]) == pytest.approx(3.0 * 400e6 / 0.56, rel=1e-8)
    assert float(ring["yield_radius"]) == pytest.approx(float(ring["contact_radius"]), rel=1e-4)


@pytest.mark.parametrize(
    ("given", "error", "words"),
    [
        ({"bond_strength": "1 MPa"}, mdr.ProblemError, "for a body of layers"),
        ({"tensile_strength": "-1 GPa"}, mdr.ProblemError, "must be above 0 Pa"),
        (
            {"tensile_strength": ["1 GPa", "2 GPa"]},
            mdr.ProblemError,
            "2 values of tensile_strength for 1 elastic part",
        ),
        ({"tensile_strength": "1 mm"}, mdr.UnitError, "compatible with 'Pa'"),
        ({"tensile_strength": "nan Pa"}, mdr.PymdrError, "tensile_strength"),
    ],
)
def test_strengths_that_make_no_sense(given, error, words):
    with pytest.raises(error, match=words):
        mdr.first_yield(mdr.Contact(BALL, STEEL), strength="1 GPa", **given)


def test_a_body_without_tension_does_not_crack():
    with pytest.raises(mdr.NotValidError, match="no largest tension"):
        mdr.first_yield(
            mdr.Contact(BALL, mdr.Elastic("1 GPa", 0.5)), strength="1 GPa", tensile_strength="1 MPa"
        )


def test_a_pop_in_has_the_shear_stress_of_its_contact():
    contact = mdr.Contact(
        mdr.Paraboloid("400 nm"), mdr.Elastic("410 GPa", 0.28), mdr.Elastic("1140 GPa", 0.07)
    )
    force = np.linspace(0.0, 0.9e-3, 301)[1:]
    depth = solve(contact, mdr.Path(normal_force=force))["indentation"].values
    depth = (
        depth + np.where(force > 0.6e-3, 8e-9, 0.0) + 1e-10 * np.random.default_rng(1).normal(size=force.size)
    )
    pop_in = mdr.first_pop_in(mdr.MeasuredCurve(indentation=depth, force=force), contact)
    at = solve(contact, mdr.load(float(pop_in["pop_in_force"][0])))
    assert float(pop_in["largest_shear"][0]) == pytest.approx(float(at["largest_shear"][-1]), rel=1e-9)
