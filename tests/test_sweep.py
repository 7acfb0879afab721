"""Parameters by name, contacts along paths of their own, and sweeps."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

import pymdr as mdr
from drawing import examples
from pymdr.errors import FileError, ProblemError, PymdrError, QuantityError, UnitError
from pymdr.problem.parameters import parameter_of
from pymdr.solving import batch
from pymdr.workbench.cli import app

CONTACTS = [
    mdr.Contact(mdr.Sphere("1 mm"), mdr.Elastic("1 GPa", 0.3), adhesion=mdr.JKR("1 J/m^2")),
    mdr.Contact(
        mdr.Cone(half_angle="70 deg") + mdr.PowerLaw(4, "1 um", "1 mm"),
        mdr.Viscoelastic(mdr.Prony("1 MPa", ["2 MPa", "3 MPa"], ["1 s", "1 h"]), poisson=0.4),
        friction=mdr.Coulomb(0.3),
    ),
    mdr.Contact(mdr.Paraboloid("1 um"), mdr.Graded("1 GPa", "1 mm", 0.2, 0.3), mdr.Rigid()),
    mdr.Contact(
        mdr.Sampled(np.linspace(0.0, 1.0, 9) * 1e-6, np.linspace(0.0, 1.0, 9) ** 2 * 1e-7),
        mdr.TransverselyIsotropic(
            c11="161 GPa", c33="61 GPa", c13="50.1 GPa", c44="38.3 GPa", c66="63.4 GPa"
        ),
    ),
]
BALL = mdr.Contact(mdr.Paraboloid("1 mm"), mdr.Elastic("1 MPa", 0.5))
PRESS = mdr.indent("1 um", steps=3)


@pytest.mark.parametrize("contact", CONTACTS)
def test_every_parameter_is_read_and_changed_by_its_name(contact):
    assert mdr.parameters_of(contact)
    for name, value, unit in mdr.parameters_of(contact):
        assert mdr.with_parameters(contact, {name: value}) == contact
        changed = mdr.with_parameters(contact, {name: f"{1.01 * value!r} {unit}".strip()})
        assert parameter_of(changed, name).value == pytest.approx(1.01 * value, rel=1e-14)
        others = [p for p in mdr.parameters_of(changed) if p.name != name]
        assert others == [p for p in mdr.parameters_of(contact) if p.name != name]


@settings(max_examples=examples(30), deadline=None)
@given(st.data())
def test_parameters_that_are_changed_at_once_are_those_changed_one_by_one(data):
    contact = data.draw(st.sampled_from(CONTACTS[:2]))
    some = data.draw(st.lists(st.sampled_from(mdr.parameters_of(contact)), unique=True))
    values = {p.name: p.value * data.draw(st.floats(0.99, 1.01)) for p in some}
    one_by_one = contact
    for name, value in values.items():
        one_by_one = mdr.with_parameters(one_by_one, {name: value})
    assert mdr.with_parameters(contact, values) == one_by_one


def test_parts_are_changed_before_what_is_in_them():
    values = {"body": mdr.Elastic("2 GPa", 0.1), "body.poisson": 0.2, "profile.radius": "3 mm"}
    changed = mdr.with_parameters(CONTACTS[0], values)
    assert (changed.body, changed.profile) == (mdr.Elastic("2 GPa", 0.2), mdr.Sphere("3 mm"))


@pytest.mark.parametrize(
    ("name", "value", "kind", "words"),
    [
        ("body.yung", 1.0, ProblemError, "profile.radius, body.young, body.poisson, adhesion.work"),
        ("body", 1.0, ProblemError, "a material such as"),
        ("profile.parts[0].radius", 1.0, ProblemError, "this contact has"),
        ("body young", 1.0, ProblemError, "a dotted name"),
        ("body.young", "1 N", UnitError, "'N' does not fit"),
        ("body.poisson", 0.7, ProblemError, "at most 0.5"),
    ],
)
def test_names_that_are_none(name, value, kind, words):
    with pytest.raises(kind, match=words):
        mdr.with_parameters(CONTACTS[0], {name: value})


def test_entries_beyond_an_array():
    with pytest.raises(ProblemError, match=r"moduli\[2\].*this contact has"):
        mdr.with_parameters(CONTACTS[1], {"body.shear.moduli[2]": 1.0})


@settings(max_examples=examples(15), deadline=None)
@given(
    st.lists(st.floats(3.0, 11.0), min_size=1, max_size=3, unique=True),
    st.lists(st.floats(-9.0, 0.0), min_size=1, max_size=3, unique=True),
    st.sampled_from([None, "JKR", "DMT"]),
)
def test_points_are_what_solve_gives(young, radii, law):
    young, radii = [10.0**x for x in young], [10.0**x for x in radii]
    contact = mdr.Contact(
        mdr.Paraboloid(1.0),
        mdr.Elastic(1.0, 0.3),
        adhesion=None if law is None else getattr(mdr, law)(1e-6 * min(young) * min(radii)),
    )
    path = mdr.indent(1e-4 * min(radii), steps=4) >> mdr.indent(-1e-3 * max(radii), steps=5)
    result = mdr.sweep(contact, path, {"body.young": young, "profile.radius": radii})
    assert result.parameters == ("body.young", "profile.radius")
    for i, modulus in enumerate(young):
        for j, radius in enumerate(radii):
            one = mdr.solve(
                mdr.with_parameters(contact, {"body.young": modulus, "profile.radius": radius}), path
            )
            there = result.data.isel({"body.young": i, "profile.radius": j})
            assert str(there["status"].values) == one.status.name
            for name in one.data:
                assert np.array_equal(there[name], one.data[name], equal_nan=True)


def test_workers_and_paths_change_nothing():
    paths = [mdr.indent(depth, steps=4) for depth in ("1 um", "2 um", "3 um")]
    over = {"path": paths, "profile.radius": ["1 mm", "2 mm"]}
    one, two = (mdr.sweep(BALL, PRESS, over, workers=workers) for workers in (1, 2))
    assert one.data.identical(two.data)
    alone = [mdr.solve(BALL, path)["normal_force"] for path in paths]
    batched = mdr.solve_batch([BALL] * 3, paths, workers=2)
    for i, force in enumerate(alone):
        assert np.array_equal(one["normal_force"][i, 0], force)
        assert np.array_equal(batched[i]["normal_force"], force)
        assert batched[i].path == paths[i]
    with pytest.raises(ProblemError, match="2 paths for 3 contacts"):
        mdr.solve_batch([BALL] * 3, paths[:2])


def test_a_killed_sweep_goes_on_where_it_was(tmp_path, monkeypatch):
    over = {"profile.radius": np.geomspace(1e-4, 1e-2, 5), "body.poisson": [0.3, 0.7, 0.5]}
    solved = []

    def counted(contact, path, **options):
        solved.append(contact)
        return mdr.solve(contact, path, **options)

    def killed(done, total):
        if done == 7:
            raise KeyboardInterrupt

    monkeypatch.setattr(batch, "solve", counted)
    monkeypatch.setattr("pymdr.solving.sweep._BETWEEN_WRITES", 0.0)
    with pytest.raises(KeyboardInterrupt):
        mdr.sweep(BALL, PRESS, over, folder=tmp_path / "parts", progress=killed)
    before = len(solved)
    reports = []
    resumed = mdr.sweep(
        BALL, PRESS, over, folder=tmp_path / "parts", progress=lambda done, total: reports.append(done)
    )
    assert reports == list(range(8, 16))
    assert len(solved) == 10
    assert 0 < before < 10
    whole = mdr.sweep(BALL, PRESS, over)
    assert resumed.data.identical(whole.data)
    assert {n: (c.level, c.reason) for n, c in resumed.claims.items()} == {
        n: (c.level, c.reason) for n, c in whole.claims.items()
    }
    again = mdr.sweep(BALL, PRESS, over, folder=tmp_path / "parts")
    assert again.data.identical(whole.data)
    assert len(solved) == 20
    with pytest.raises(FileError, match="belongs to another computation"):
        mdr.sweep(BALL, mdr.indent("2 um", steps=3), over, folder=tmp_path / "parts")


def test_points_without_a_result_have_a_reason():
    result = mdr.sweep(BALL, PRESS, {"body.poisson": [0.3, 0.7]})
    assert result.failed == 1
    assert "at most 0.5" in str(result["refusal"].values[1])
    assert np.isnan(result["normal_force"][1]).all()
    assert np.isfinite(result["normal_force"][0]).all()
    assert "1 without a result; the first, body.poisson = 0.7: poisson" in str(result)
    assert result.claims["normal_force"].where.tolist() == [True, False]


def test_the_weakest_claim_is_stated():
    shapes = [mdr.Paraboloid("1 mm"), mdr.Waviness("1 um", "0.1 mm")]
    result = mdr.sweep(
        BALL, mdr.indent("1.5 um"), {"profile": shapes, "adhesion": [None, mdr.DMT("1 mJ/m^2")]}
    )
    assert result.claims["normal_force"].level is mdr.Level.APPROXIMATE
    assert "of 4 points" in result.claims["normal_force"].reason
    with pytest.raises(QuantityError, match="no quantity 'shear_traction'"):
        result["shear_traction"]
    assert result.plot() is not None


def test_files_of_a_sweep(tmp_path):
    result = mdr.sweep(
        BALL, PRESS, {"profile.radius": ["1 mm", "4 mm"]}, quantities=["indentation", "normal_force"]
    )
    assert set(map(str, result.data)) == {"indentation", "normal_force", "status", "refusal"}
    result.save(tmp_path / "sweep.nc")
    with xr.open_dataset(tmp_path / "sweep.nc", engine="h5netcdf") as opened:
        assert np.array_equal(opened["normal_force"], result["normal_force"])
        assert json.loads(opened.attrs["pymdr_metadata"])["claims"]["normal_force"]["level"] == "EXACT"
    result.to_csv(tmp_path / "sweep.csv")
    lines = (tmp_path / "sweep.csv").read_text().splitlines()
    assert lines[0] == "profile.radius [m],step,indentation [m],normal_force [N],status,refusal"
    assert len(lines) == 7
    assert result.to("normal_force", "mN").values == pytest.approx(
        1e3 * result["normal_force"].values, rel=1e-15
    )


@pytest.mark.parametrize(
    ("over", "options", "kind", "words"),
    [
        ({}, {}, ProblemError, "parameters with their values are needed"),
        ({"body.young": []}, {}, (ProblemError, UnitError), "body.young"),
        ({"body.young": ["1 MPa", "2 N"]}, {}, UnitError, "'N' does not fit"),
        ({"body.young": [[1.0, 2.0]]}, {}, ProblemError, "one row of values"),
        ({"body.poisson": [0.6, 0.7]}, {}, ProblemError, "none of 2 points can be solved; the first"),
        ({"path": [mdr.Paraboloid(1.0)]}, {}, ProblemError, "not a path"),
        ({"body.young": [1.0]}, {"quantities": ["forces"]}, QuantityError, "no forces; there are"),
        ({"body.young": [1.0]}, {"workers": 0}, ProblemError, "workers = 0"),
        ({"path": [PRESS, mdr.indent("1 um")]}, {}, ProblemError, "paths of one length"),
    ],
)
def test_sweeps_that_are_none(over, options, kind, words):
    with pytest.raises(kind, match=words):
        mdr.sweep(BALL, PRESS, over, **options)


def test_functions_are_not_known_again(tmp_path):
    contact = mdr.Contact(mdr.Function(lambda r: r**2), mdr.Elastic(1.0, 0.3))
    with pytest.raises(ProblemError, match="folder= cannot compare"):
        mdr.sweep(contact, mdr.indent(1e-3), {"body.young": [1.0]}, folder=tmp_path)


def test_more_than_the_memory(monkeypatch):
    monkeypatch.setattr("pymdr.solving.sweep.memory_of_machine", lambda: 100.0)
    with pytest.raises(PymdrError, match="half of the memory"):
        mdr.sweep(BALL, PRESS, {"body.young": [1.0, 2.0]})


def test_sweep_of_a_case(tmp_path):
    case = tmp_path / "case.toml"
    case.write_text(
        "[profile]\nkind = 'paraboloid'\nradius = '1 mm'\n[body]\nkind = 'elastic'\nyoung = '1 MPa'\npoisson = 0.5\n"
        "[[path]]\nkind = 'indent'\nindentation = '1 um'\nsteps = 3\n"
    )
    arguments = [
        "sweep",
        str(case),
        "--over",
        "body.young = 1 MPa, 4 MPa",
        "--points",
        "3",
        "--csv",
        "--json",
    ]
    done = CliRunner().invoke(app, [*arguments, "-o", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    data = json.loads(done.stdout)
    assert data["status"] == "COMPLETED"
    assert data["rows"] == 3
    with xr.open_dataset(tmp_path / "out/sweep.nc", engine="h5netcdf") as opened:
        force = opened["normal_force"].values[:, -1]
    assert force[1:] / force[:-1] == pytest.approx([2.0, 2.0], rel=1e-12)
    assert {file.name for file in (tmp_path / "out").iterdir()} == {
        "sweep.nc",
        "sweep.png",
        "sweep.csv",
        "parts",
    }


@pytest.mark.parametrize(
    "over", ["body.yung = 1, 2", "body.young", "= 1 MPa", "body.young = ,", "body.young = 1 N"]
)
def test_what_is_no_sweep_of_a_case(tmp_path, over):
    case = tmp_path / "case.toml"
    case.write_text(
        "[profile]\nkind = 'paraboloid'\nradius = '1 mm'\n[body]\nkind = 'elastic'\nyoung = '1 MPa'\npoisson = 0.5\n"
        "[[path]]\nkind = 'indent'\nindentation = '1 um'\n"
    )
    done = CliRunner().invoke(app, ["sweep", str(case), "--over", over, "-o", str(tmp_path / "out")])
    assert done.exit_code != 0
    assert isinstance(done.exception, PymdrError | SystemExit)
    assert not (tmp_path / "out").exists()


def test_a_sweep_shows_in_notebooks():
    contact = mdr.Contact(mdr.Paraboloid("1 mm"), mdr.Elastic("1 GPa", 0.3))
    result = mdr.sweep(contact, mdr.indent("1 um"), {"body.young": ["1 GPa", "2 GPa"]})
    assert "2 points over" in result._repr_html_()


@settings(max_examples=examples(15), deadline=None)
@given(st.lists(st.floats(1.0, 9.0), min_size=1, max_size=12, unique=True), st.booleans())
def test_curves_of_a_sweep_are_named(moduli, more):
    contact = mdr.Contact(mdr.Paraboloid("1 mm"), mdr.Elastic("1 GPa", 0.3))
    over = {"body.young": 1e9 * np.array(moduli)} | ({"body.poisson": [0.2, 0.3]} if more else {})
    along = mdr.sweep(contact, mdr.indent("1 um", steps=3), over).plot().axes[0]
    assert along.get_legend().get_title().get_text() == "Young's modulus"
    named = {line.get_label(): line.get_color() for line in along.lines if line.get_label()[0] != "_"}
    assert len(named) <= 8
    assert {text.get_text() for text in along.get_legend().get_texts()} == set(named)
    assert len({tuple(colour) for colour in named.values()}) == min(len(moduli), 8)


def test_errors_of_points_are_those_of_the_sweep(tmp_path):
    contact = mdr.Contact(mdr.Sphere("1 mm"), mdr.Elastic("1 MPa", 0.5), friction=mdr.Coulomb(0.3))
    path = mdr.indent("10 um", steps=2) >> mdr.shift("5 um", steps=3)
    swept = mdr.sweep(contact, path, {"friction.coefficient": [0.2, 0.4]})
    points = [mdr.solve(replace(contact, friction=mdr.Coulomb(mu)), path) for mu in (0.2, 0.4)]
    largest = [np.max(one.claims["tangential_force"].error) for one in points]
    np.testing.assert_array_equal(swept.claims["tangential_force"].error, largest)
    swept.to_csv(tmp_path / "swept.csv")
    columns = np.genfromtxt(tmp_path / "swept.csv", delimiter=",", names=True, deletechars="")
    name = next(n for n in columns.dtype.names if n.startswith("tangential_force_error"))
    np.testing.assert_allclose(columns[name], np.repeat(largest, 5), rtol=1e-12)


def test_paths_in_the_plane(tmp_path):
    contact = mdr.Contact(mdr.Sphere("10 mm"), mdr.Elastic("200 GPa", 0.3), friction=mdr.Coulomb(0.3))
    around = mdr.load("50 N") >> mdr.circle(shift="0.4 um", steps=16)
    over = {"friction.coefficient": [0.2, 0.3]}
    swept = mdr.sweep(contact, around, over, folder=tmp_path / "kept")
    again = mdr.sweep(contact, around, over, folder=tmp_path / "kept")
    assert swept.data.identical(again.data)
    for i, mu in enumerate(over["friction.coefficient"]):
        point = mdr.solve(replace(contact, friction=mdr.Coulomb(mu)), around)
        assert swept["tangential_force"].dims == ("friction.coefficient", "step", "axis")
        np.testing.assert_array_equal(swept["tangential_force"].values[i], point["tangential_force"].values)
    forces = np.hypot(*np.moveaxis(swept["tangential_force"].values, -1, 0))
    assert f"{forces[1].max():.4g} N" in swept.summary()
    swept.to_csv(tmp_path / "swept.csv")
    columns = np.genfromtxt(
        tmp_path / "swept.csv", delimiter=",", names=True, deletechars="", dtype=None, encoding=None
    )
    np.testing.assert_array_equal(columns["shift_y_[m]"], swept["shift"].values[..., 1].ravel())
    assert swept.plot("tangential_force").axes[0].get_ylabel().startswith("magnitude of tangential force")
    straight = mdr.load("50 N") >> mdr.shift("0.4 um", steps=17)
    with pytest.raises(mdr.ProblemError, match="in the plane and others along a line"):
        mdr.sweep(contact, around, {"path": [around, straight]})
