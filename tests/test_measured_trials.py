"""Measured curves as strangers give them: any order of a map's dimensions, rows without anything, changed stores, bad tables."""

from __future__ import annotations

import math
import shutil
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from hypothesis import example, given, settings
from hypothesis import strategies as st

import pymdr as mdr
from drawing import examples
from pymdr.errors import CaseError, FileError, ProblemError
from pymdr.solving.fits.results import Fitted
from pymdr.workbench.tables import read_curve

RADIUS, POISSON = 5e-6, 0.5
BALL = mdr.Contact(mdr.Paraboloid(RADIUS), mdr.Elastic("10 kPa", POISSON))
STICKY = mdr.Contact(mdr.Paraboloid(RADIUS), mdr.Elastic("10 kPa", POISSON), adhesion=mdr.JKR("1 mJ/m^2"))
POSITIONS = np.linspace(-1e-6, 1e-6, 80)


def hertz(young, depth):
    """Hertz' force of the ball."""
    return 4.0 / 3.0 * young / (1.0 - POISSON**2) * np.sqrt(RADIUS) * np.maximum(depth, 0.0) ** 1.5


def on_machine(young, stiffness, travel):
    """The same at travels of a machine, by bisection of its force."""
    low, high = np.zeros_like(travel), np.maximum(stiffness * travel, 0.0)
    for _ in range(60):
        middle = 0.5 * (low + high)
        bears = hertz(young, travel - middle / stiffness) > middle
        low, high = np.where(bears, middle, low), np.where(bears, high, middle)
    return 0.5 * (low + high)


def map_of(young, stiffness, order, springs):
    """A map over y and x whose force and spring constants have their dimensions in any order."""
    force = np.array(
        [
            [on_machine(E, k, POSITIONS) for E, k in zip(*row, strict=True)]
            for row in zip(young, stiffness, strict=True)
        ]
    )
    data = xr.Dataset(
        {
            "force": (("y", "x", "sample"), force, {"units": "N"}),
            "travel": ("sample", POSITIONS, {"units": "m"}),
            "spring_constant": (("y", "x"), stiffness, {"units": "N/m"}),
        }
    )
    return data.assign(
        force=data["force"].transpose(*order), spring_constant=data["spring_constant"].transpose(*springs)
    )


@settings(max_examples=examples(6), deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.permutations(["y", "x", "sample"]),
    st.permutations(["y", "x"]),
    st.sampled_from([(2, 3), (2, 2), (3, 1)]),
)
def test_every_curve_of_a_map_has_its_own_spring_whatever_the_order_of_dimensions(
    seed, order, springs, shape
):
    rng = np.random.default_rng(seed)
    young, stiffness = 10.0 ** rng.uniform(3, 5, shape), 10.0 ** rng.uniform(-2, 0, shape)
    computed = mdr.fit_map(BALL, map_of(young, stiffness, order, springs), ["body.young"])["body.young"]
    assert np.allclose(computed.transpose("y", "x").values, young, rtol=1e-6)


@pytest.mark.parametrize("along", ["y", "x"])
def test_a_spring_for_each_row_or_column_of_a_map_is_that_of_its_curves(along):
    young, own = (
        np.array([[1e3, 2e4, 5e3], [8e3, 4e3, 1e5]]),
        {"y": [0.02, 0.5], "x": [0.02, 0.1, 0.5]}[along],
    )
    wide = np.broadcast_to(np.array(own)[:, None] if along == "y" else np.array(own), young.shape)
    data = map_of(young, wide, ("y", "x", "sample"), ("y", "x"))
    data = data.assign(spring_constant=(along, own, {"units": "N/m"}))
    assert np.allclose(mdr.fit_map(BALL, data, ["body.young"])["body.young"].values, young, rtol=1e-6)


@pytest.mark.parametrize(
    ("name", "given_as", "words"),
    [
        (
            "spring_constant",
            (("other",), np.ones(4)),
            "spring_constant has the dimensions other, which force does not have",
        ),
        ("spring_constant", (("sample",), np.ones(80)), "one number, or one over y, x, is needed"),
        ("spring_constant", ((), 0.0), "spring_constant has 0.0; it must be above 0"),
        ("spring_constant", (("y",), [1.0, -2.0]), "spring_constant has -2.0; it must be above 0"),
        (
            "travel",
            (("y", "x"), np.ones((2, 2))),
            "travel has the dimensions y, x; a column over sample is needed",
        ),
        ("travel", (("depth",), np.ones(80)), "travel has the dimensions depth, which force does not have"),
        ("travel", ((), 1.0), "travel has no dimension; a column over sample is needed"),
        ("force", (("y", "x", "sample"), np.full((2, 2, 80), "a")), "real numbers are needed"),
        ("force", (("y", "x", "sample"), np.full((2, 2, 80), 1j)), "real numbers are needed"),
    ],
)
def test_columns_of_a_map_that_do_not_belong_to_its_curves_are_refused(name, given_as, words):
    data = map_of(np.full((2, 2), 1e4), np.full((2, 2), 0.1), ("y", "x", "sample"), ("y", "x"))
    with pytest.raises(ProblemError, match=words):
        mdr.fit_map(BALL, data.assign({name: given_as}), ["body.young"])


@settings(max_examples=examples(8), deadline=None)
@given(st.floats(-12.0, 3.0), st.booleans(), st.sampled_from([None, 1e-3, 1.0]))
def test_curves_that_do_not_change_are_no_contact_and_stop_no_map(log_level, is_negative, machine):
    level = (-1.0 if is_negative else 1.0) * 10.0**log_level
    rows = np.array([np.full(80, level), np.zeros(80), np.full(80, math.nan), hertz(1e4, POSITIONS)])
    place = {"indentation": ("sample", POSITIONS, {"units": "m"})}
    if machine is not None:
        rows[3] = on_machine(1e4, machine, POSITIONS)
        place = {
            "travel": ("sample", POSITIONS, {"units": "m"}),
            "spring_constant": ((), machine, {"units": "N/m"}),
        }
    data = xr.Dataset({"force": (("curve", "sample"), rows, {"units": "N"}), **place})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sticky = mdr.fit_map(STICKY, data, ["body.young", "adhesion.work"])
        plain = mdr.fit_map(BALL, data, ["body.young"])
    assert plain["ending"].values.tolist() == [2, 2, 3, 0]
    assert abs(float(plain["body.young"][3]) / 1e4 - 1.0) < 1e-6
    assert sticky["ending"].values[2] == 3
    assert not np.isfinite(sticky["body.young"].values[:3]).any()


@pytest.mark.parametrize("changed", [0, 1, 2])
def test_a_store_of_a_map_is_refused_where_any_curve_has_changed(changed, tmp_path):
    curves = [mdr.MeasuredCurve(force=hertz(E, POSITIONS), indentation=POSITIONS) for E in (1e3, 2e3, 3e3)]
    mdr.fit_map(BALL, curves, ["body.young"], folder=tmp_path / "fits")
    again = mdr.fit_map(BALL, curves, ["body.young"], folder=tmp_path / "fits")
    assert np.allclose(again["body.young"].values, [1e3, 2e3, 3e3], rtol=1e-9)
    curves[changed] = mdr.MeasuredCurve(force=hertz(9e3, POSITIONS), indentation=POSITIONS)
    with pytest.raises(FileError, match="a curve, or the version"):
        mdr.fit_map(BALL, curves, ["body.young"], folder=tmp_path / "fits")


def test_folders_of_another_version_are_refused(tmp_path, monkeypatch):
    curves = [mdr.MeasuredCurve(force=hertz(1e3, POSITIONS), indentation=POSITIONS)]
    swept = {"body.young": ["1 kPa", "2 kPa"]}
    mdr.fit_map(BALL, curves, ["body.young"], folder=tmp_path / "fits")
    mdr.sweep(BALL, mdr.indent("1 um"), swept, folder=tmp_path / "parts")
    for module in ("pymdr.solving.workers", "pymdr.solving.fits.storing"):
        monkeypatch.setattr(f"{module}.__version__", "999")
    with pytest.raises(FileError, match="the version of pymdr"):
        mdr.fit_map(BALL, curves, ["body.young"], folder=tmp_path / "fits")
    with pytest.raises(FileError, match="the version of pymdr"):
        mdr.sweep(BALL, mdr.indent("1 um"), swept, folder=tmp_path / "parts")


@settings(max_examples=examples(25), deadline=None)
@given(st.integers(0, 2**32 - 1))
@example(0)
@example(97)
@example(178)
def test_no_fit_deviates_more_from_the_record_than_the_true_parameters(seed):
    rng = np.random.default_rng(seed)
    young, n, tilt = 10.0 ** rng.uniform(2, 6), int(rng.integers(30, 120)), bool(rng.random() < 0.4)
    positions = np.linspace(-rng.choice([0.0, 0.5]) * 1e-6, 1e-6, n)
    positions = [positions, positions[::-1], np.concatenate([positions, positions[::-1]])][rng.integers(3)]
    softness = rng.choice([None, 10.0 ** rng.uniform(-1.0, 1.5)])
    machine = None if softness is None else softness * float(hertz(young, 1e-6)) / 1e-6
    force = hertz(young, positions) if machine is None else on_machine(young, machine, positions)
    span = force.max()
    force = force + span * rng.normal() + 0.1 * span / 1e-6 * rng.normal() * positions * tilt
    noise = span * 10.0 ** rng.uniform(-3, -2) * rng.normal(size=positions.size)
    place = (
        {"indentation": positions} if machine is None else {"travel": positions, "spring_constant": machine}
    )
    known = {"contact_point": 0.0} if rng.random() < 0.5 else {}
    start = mdr.Contact(BALL.profile, mdr.Elastic(young * 10.0 ** rng.uniform(-4, 4), POISSON))
    fitted = mdr.fit(
        start, mdr.MeasuredCurve(force=force + noise, **place), ["body.young", *["tilt"] * tilt], **known
    )
    assert (fitted.data["residual"].values ** 2).sum() < (1.0 + 1e-6) * (noise**2).sum()


def test_origins_that_a_record_does_not_distinguish_have_infinite_errors():
    punch = mdr.Contact(mdr.FlatPunch("1 um"), mdr.Elastic("1 MPa", POISSON))
    depth = np.linspace(1e-7, 1e-6, 100)
    force = 3.0 * depth + 1e-8 * np.random.default_rng(1).normal(size=100)
    for stretch in (1.0, 1e-3, 1e3):
        record = mdr.MeasuredCurve(force=stretch * force, indentation=stretch * depth)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            fitted = mdr.fit(punch, record, ["body.young"])
        assert fitted["body.young"].low < 3.0 * (1.0 - POISSON**2) / 2e-6 < fitted["body.young"].high


@settings(max_examples=examples(40), deadline=None)
@given(st.floats(-1e3, 1e3), st.floats(-20.0, -1.0))
def test_an_interval_shows_distinct_ends(value, log_width):
    width = max(abs(value) * 10.0**log_width, 1e-12 * abs(value))
    shown = str(Fitted("contact_point", value, width / 4.0, value - width / 2.0, value + width / 2.0, "m"))
    low, high = shown.partition("95 % between ")[2].split(" and ")
    assert width == 0.0 or low != high


@settings(max_examples=examples(10), deadline=None)
@given(st.sets(st.integers(0, 79), max_size=30), st.sampled_from(["nan", "", "inf", " NaN "]))
def test_samples_of_a_table_that_are_no_numbers_are_omitted_on_request(missing, word):
    rows = [f"{1e6 * z},{word if i in missing else i}" for i, z in enumerate(POSITIONS)]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "curve.csv"
        file.write_text("\n".join(["indentation [um],load [nN]", *rows]))
        (result,) = mdr.read_curves(file, leave_out_missing=True)
        if missing:
            with pytest.raises(CaseError, match="finite number"):
                mdr.read_curves(file)
    kept = [i for i in range(80) if i not in missing]
    assert np.allclose(result.force, 1e-9 * np.array(kept), rtol=1e-12)
    assert np.allclose(result.indentation, POSITIONS[kept], rtol=1e-12)
    assert [step.name for step in result.steps] == (["missing"] if missing else [])


def test_a_missing_column_is_named_in_its_own_unit(tmp_path):
    (tmp_path / "curve.csv").write_text("indentation [um],foo [nN]\n1,2\n")
    with pytest.raises(CaseError, match=r"'load \[N\]'"):
        read_curve(tmp_path / "curve.csv")


@pytest.mark.skipif(shutil.which("gcc") is None, reason="there is no compiler")
@pytest.mark.parametrize("contact", [BALL, STICKY], ids=["Hertz", "JKR"])
def test_headers_compile_under_the_warnings_of_strict_codes(contact, tmp_path):
    law = mdr.export_law(contact, "1 um", tolerance=1e-4)
    (tmp_path / "ball.h").write_text(law.c_header("ball"))
    (tmp_path / "ball.c").write_text(
        '#include "ball.h"\n#include "ball.h"\nint main(void) { return !(ball_force(1e-7) == ball_force(1e-7)); }\n'
    )
    strict = [
        "-std=c99",
        "-Wall",
        "-Wextra",
        "-Werror",
        "-pedantic",
        "-Wconversion",
        "-Wdouble-promotion",
        "-Wshadow",
    ]
    subprocess.run(
        ["gcc", *strict, str(tmp_path / "ball.c"), "-o", str(tmp_path / "ball"), "-lm"], check=True
    )
    subprocess.run([str(tmp_path / "ball")], check=True)


def test_points_of_a_map_have_the_numbers_of_its_table():
    curves = [mdr.MeasuredCurve(force=hertz(E, POSITIONS), indentation=POSITIONS) for E in (1e3, 2e3, 3e3)]
    figure = mdr.fit_map(BALL, curves, ["body.young"]).plot()
    assert figure.axes[0].lines[0].get_xdata().tolist() == [0, 1, 2]


def test_points_between_values_that_are_not_two_are_refused(tmp_path):
    case = tmp_path / "ball.toml"
    case.write_text(
        '[profile]\nkind = "paraboloid"\nradius = "5 um"\n[body]\nkind = "elastic"\nyoung = "1 kPa"\npoisson = 0.5\n'
        '[[path]]\nkind = "indent"\nindentation = "1 um"\n'
    )
    for values, status in (("1 kPa, 2 kPa, 3 kPa", 1), ("1 kPa", 1), ("1 kPa, 2 kPa", 0)):
        arguments = ["sweep", str(case), "--over", f"body.young = {values}", "--points", "4"]
        done = subprocess.run([sys.executable, "-m", "pymdr", *arguments], capture_output=True, text=True)
        assert done.returncode == status
        assert ("--points 4" in done.stderr) == bool(status)


@settings(max_examples=examples(30), deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.integers(1, 4),
    st.integers(8, 12),
    st.floats(-9.0, 0.0),
    st.floats(0.0, 9.0),
    st.booleans(),
)
def test_few_samples_in_contact_are_refused_or_lie_in_their_intervals(
    seed, pressed, separation, decades, stiff, machine
):
    """A contact point that lies anywhere between two samples takes any modulus with it."""
    rng = np.random.default_rng(seed)
    size, young = 10.0**decades, 10.0**stiff
    positions = size * (np.arange(-separation, pressed) + rng.uniform(0.05, 0.95)) / (10.0 * pressed)
    force = 16.0 / 9.0 * young * np.sqrt(5.0 * size) * np.maximum(positions, 0.0) ** 1.5
    spring = force.max() / (0.1 * size)
    travel = positions + force / spring
    force += 0.01 * force.max() * rng.normal(size=positions.size)
    ball = mdr.Contact(mdr.Paraboloid(5.0 * size), mdr.Elastic(30.0 * young, 0.5))
    curve = (
        mdr.MeasuredCurve(travel=travel, force=force, spring_constant=spring)
        if machine
        else mdr.MeasuredCurve(indentation=positions, force=force)
    )
    fitted = mdr.fit_map(ball, [curve], ["body.young"])
    for value, error in (
        (float(fitted["body.young"].values[0]), float(fitted["body.young_error"].values[0])),
        one_fit(ball, curve),
    ):
        assert np.isnan(value) or abs(np.log(value / young)) < 8.0 * error / value
    assert pressed > 1 or np.isnan(fitted["body.young"].values[0])


def one_fit(contact, curve):
    try:
        computed = mdr.fit(contact, curve, ["body.young"]).values["body.young"]
    except mdr.ProblemError:
        return np.nan, np.nan
    return computed.value, computed.error


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("law", "--to", "1 um", "--name", ""), "not usable as a C identifier"),
        (("fit", "curve.csv", "--free", "body.young", "--spring-constant", "1 N/m"), "has indentations"),
        (
            ("fit", "curve.csv", "--free", "body.young", "--workers", "0"),
            "'--workers': Input should be greater than or equal to 1",
        ),
    ],
)
def test_options_without_a_meaning_are_refused(arguments, words, tmp_path, shell, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert shell("new", "ball", "-o", "ball.toml")[0] == 0
    rows = "\n".join(f"{i},{0.02 * max(i, 0) ** 1.5}" for i in range(-9, 9))
    Path("curve.csv").write_text(f"indentation [um],force [N]\n{rows}\n")
    status, _, error = shell(arguments[0], "ball.toml", *arguments[1:])
    assert status != 0
    assert words in " ".join(error.replace("│", " ").split())


@settings(max_examples=examples(15), deadline=None)
@given(st.floats(-9.0, 0.0), st.floats(0.0, 9.0), st.floats(0.3, 0.8))
def test_a_spring_that_deflects_more_than_it_travels_is_named(decades, stiff, fraction):
    size, young = 10.0**decades, 10.0**stiff
    depth = size * np.linspace(-0.1, 0.1, 80)
    force = 16.0 / 9.0 * young * np.sqrt(size) * np.maximum(depth, 0.0) ** 1.5
    spring = fraction * force.max() / (0.1 * size)
    ball = mdr.Contact(mdr.Paraboloid(size), mdr.Elastic(young, 0.5))
    with pytest.raises(ProblemError, match="check spring_constant"):
        mdr.fit(ball, mdr.MeasuredCurve(travel=depth, force=force, spring_constant=spring), ["body.young"])
