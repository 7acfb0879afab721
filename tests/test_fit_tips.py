"""Fits of pyramids and beads, ranges of fits, uncertainties of what is known, the quality of curves, and groups."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from typer.testing import CliRunner

import pymdr as mdr
from pymdr.errors import ProblemError
from pymdr.workbench.cli import app

BODY = mdr.Elastic("3 kPa", 0.5)
POSITIONS = np.linspace(-2e-6, 2e-6, 400)


def recorded(profile, noise=0.0, seed=0, constant=0.05, tilt=0.0):
    """A record on a machine, with offsets."""
    contact = mdr.Contact(profile, BODY)
    force = mdr.solve(contact, mdr.Path(travel=POSITIONS), machine_stiffness=constant)["normal_force"].values
    force = force + noise * np.ptp(force) * np.random.default_rng(seed).normal(size=POSITIONS.size)
    return mdr.MeasuredCurve(
        force=force + tilt * POSITIONS - 1e-10, travel=POSITIONS + 4e-7, spring_constant=constant
    )


def start(profile):
    return mdr.Contact(profile, mdr.Elastic("1 MPa", 0.5))


TIPS = {
    "berkovich": mdr.Pyramid.berkovich(),
    "vickers": mdr.Pyramid.vickers(),
    "cube corner": mdr.Pyramid.cube_corner(),
    "cantilever": mdr.Pyramid.four_sided_tip(),
    "many sides": mdr.Pyramid(12, half_angle="60 deg"),
    "ellipse": mdr.EllipticParaboloid("2 um", "3 um"),
    "bead on a cell": mdr.SphereOnSphere("3 um", sample_radius="6 um"),
}


@pytest.mark.parametrize("name", TIPS)
def test_the_modulus_of_a_tip_is_recovered(name):
    tip = TIPS[name]
    computed = mdr.fit(start(tip), recorded(tip), ["body.young"])["body.young"]
    assert computed.value == pytest.approx(3e3, rel=1e-6)
    if isinstance(tip, mdr.Pyramid):  # the interval contains the error of the constant
        error = 2.5e-3 if tip.sides > 8 else 3e-4
        assert computed.high / computed.low - 1.0 > error
    fitted = mdr.fit_map(start(tip), [recorded(tip), recorded(tip)], ["body.young"])
    assert fitted["body.young"].values == pytest.approx(3e3, rel=1e-6)


@pytest.mark.parametrize(("sides", "constant"), [(3, 0.882409), (4, 0.737678)])
def test_pyramids_have_the_constants_of_the_page(sides, constant):
    depth = np.linspace(-1e-6, 1e-6, 201)
    force = constant * 3e3 / 0.75 * np.tan(np.radians(35.0)) * np.maximum(depth, 0.0) ** 2
    curve = mdr.MeasuredCurve(force=force, indentation=depth)
    tip = mdr.Pyramid(sides, half_angle="35 deg")
    assert mdr.fit(start(tip), curve, ["body.young"])["body.young"].value == pytest.approx(3e3, rel=1e-6)


def test_other_shapes_are_refused_with_the_remedy():
    gap = mdr.Function2D(lambda x, y: x * x + y * y)
    with pytest.raises(ProblemError, match="only bounded and estimated"):
        mdr.fit(start(gap), recorded(mdr.Paraboloid("5 um")), ["body.young"])


def test_a_sphere_on_a_sphere_has_the_effective_radius():
    bead, small = mdr.SphereOnSphere("3 um", "6 um"), mdr.indent("1 pm")
    force, effective, parts = (
        float(mdr.solve(mdr.Contact(one, BODY), small)["normal_force"][0])
        for one in (bead, mdr.Paraboloid("2 um"), mdr.Sphere("3 um") + mdr.Sphere("6 um"))
    )
    assert force == pytest.approx(effective, rel=1e-6)
    assert force == pytest.approx(parts, rel=1e-14)
    assert (bead.tip_radius, bead.max_radius) == (pytest.approx(2e-6), 3e-6)
    with pytest.raises(ProblemError, match="above 0 m"):
        mdr.SphereOnSphere("3 um", "0 um")


def test_a_fit_range_is_that_of_the_model_and_is_reported():
    ball = mdr.Paraboloid("5 um")
    curve = recorded(ball, noise=0.01, seed=3)
    for limits in ({"indentation": "500 nm"}, {"force": "2 nN"}, {"indentation": "1 um", "force": "2 nN"}):
        fitted = mdr.fit(start(ball), curve, ["body.young"], fit_range=limits)
        depth, force = fitted.data["indentation"].values, fitted.data["model"].values
        step = np.diff(POSITIONS)[0]  # one sample may enter or leave
        assert depth.max() <= 500e-9 + step if "force" not in limits else force.max() <= 2.2e-9
        assert any(note.startswith("fit range: ") for note in fitted.notes)
    for wrong in ({"depth": 1.0}, {}, {"force": "-1 nN"}):
        with pytest.raises(ProblemError, match="fit_range"):
            mdr.fit(start(ball), curve, ["body.young"], fit_range=wrong)


@pytest.mark.parametrize(
    "limits", [{"indentation": "500 nm"}, {"force": "2 nN"}], ids=["indentation", "force"]
)
def test_intervals_within_a_fit_range_contain_the_modulus(limits):
    ball = mdr.Paraboloid("5 um")
    fits = [
        mdr.fit(start(ball), recorded(ball, noise=0.01, seed=seed), ["body.young"], fit_range=limits)
        for seed in range(40)
    ]
    deviations = [(one["body.young"].value - 3e3) / one["body.young"].error for one in fits]
    # of 40 intervals of 95 % fewer than 34 contain the modulus in 1 of 300 such tests
    assert sum(one["body.young"].low < 3e3 < one["body.young"].high for one in fits) >= 34
    # the mean of 40 and their scatter, to three standard errors
    assert abs(np.mean(deviations)) < 3.0 / 40**0.5
    assert 1.0 - 3.0 / 80**0.5 < np.std(deviations) < 1.0 + 3.0 / 80**0.5


def test_uncertainties_follow_their_scalings():
    ball = mdr.Paraboloid("5 um")
    given = {"spring_constant": "10 %", "profile.radius": "0.25 um", "body.poisson": 0.05}
    fitted = mdr.fit(start(ball), recorded(ball), ["body.young"], uncertainty=given)
    relative = {name: part["body.young"] / 3e3 for name, part in fitted.calibration.items()}
    assert relative["spring_constant"] == pytest.approx(0.1, rel=1e-5)  # force and stiffness scale together
    assert relative["profile.radius"] == pytest.approx(0.025, rel=2e-3)  # E ~ R^(-1/2)
    assert relative["body.poisson"] == pytest.approx((1 - 0.45**2) / 0.75 - 1, rel=1e-5)  # one side
    total = math.sqrt(sum(part**2 for part in relative.values()))
    one = fitted["body.young"]
    assert math.log(one.high / one.low) == pytest.approx(2 * 1.96 * total, rel=1e-3)


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({}, "give standard uncertainties by name"),
        ({"profile.radius": "90 %"}, "limit: 50 %"),
        ({"spring_constant": "-10 %"}, "'-10 %'; a standard uncertainty must be above 0"),
        ({"spring_constant": "0 %"}, "must be above 0"),
        ({"body.young": "1 %"}, "it is fitted"),
        (
            {"profile.height": "1 %"},
            "spring_constant, sensitivity or a parameter .*unknown; .*profile.radius",
        ),
    ],
)
def test_wrong_uncertainties_are_refused(given, text):
    ball = mdr.Paraboloid("5 um")
    with pytest.raises(ProblemError, match=text):
        mdr.fit(start(ball), recorded(ball), ["body.young"], uncertainty=given)


def test_intervals_with_uncertain_calibration_cover():
    ball, inside, rng = mdr.Paraboloid("5 um"), 0, np.random.default_rng(4)
    for seed in range(24):
        true = recorded(ball, noise=0.01, seed=seed)
        factor = 1.0 + 0.1 * rng.normal()  # the constant that the laboratory believes
        believed = mdr.MeasuredCurve(
            force=factor * true.force, travel=true.travel, spring_constant=factor * 0.05
        )
        fitted = mdr.fit(start(ball), believed, ["body.young"], uncertainty={"spring_constant": "10 %"})
        inside += fitted["body.young"].low < 3e3 < fitted["body.young"].high
    assert inside >= 20  # 22.8 expected; 1 in 200 series of 24 has fewer


def test_a_modulus_over_the_fit_range_shows_a_support():
    film = mdr.Layered([mdr.Layer(BODY, "4 um")], mdr.Rigid())
    ball, depth = mdr.Paraboloid("5 um"), np.linspace(-1e-6, 1e-6, 200)
    for body, grows in ((BODY, False), (film, True)):
        path = mdr.Path(indentation=np.maximum(depth, 0.0))
        force = mdr.solve(mdr.Contact(ball, body), path)["normal_force"].values
        curve = mdr.MeasuredCurve(force=force, indentation=depth)
        study = mdr.fit_over_indentation(start(ball), curve, ["body.young"], steps=4)
        young = study["body.young"].values
        assert grows or study["fit_range"].values[-1] == pytest.approx(1e-6, rel=1e-6)
        assert (np.diff(young) > 0.02 * young[0]).all() if grows else young == pytest.approx(3e3, rel=1e-6)
    assert study.plot().axes[1].get_ylabel()
    assert "indentations up to" in study.summary()
    with pytest.raises(ProblemError, match="steps = 1"):
        mdr.fit_over_indentation(start(ball), curve, ["body.young"], steps=1)


def test_a_map_masks_curves_of_poor_quality():
    ball = mdr.Paraboloid("5 um")
    curves = [
        recorded(ball, 0.01),
        recorded(ball, 0.2, seed=1),
        recorded(ball, 0.01, seed=2, tilt=3e-3),
        recorded(ball, 0.01, seed=3),
    ]
    fitted = mdr.fit_map(start(ball), curves, ["body.young"])
    assert fitted.data["good"].values.tolist() == [True, False, False, True]
    assert fitted.mask(relative_residual=1.0, baseline_rise=1.0).values.all() == (fitted["ending"] == 0).all()
    assert not fitted.mask(samples_in_contact=1000).values.any()
    with pytest.raises(ProblemError, match="relative_residual = -1; a limit of 0 or more"):
        fitted.mask(relative_residual=-1.0)
    for wrong in ("small", None, [1.0], math.nan):
        with pytest.raises(ProblemError, match=r"baseline_rise = .*; a limit of 0 or more is needed"):
            fitted.mask(baseline_rise=wrong)
    inside = int((curves[0].travel > fitted["contact_point"].values[0]).sum())
    assert fitted["samples_in_contact"].values[0] == inside
    assert fitted["relative_residual"].values[0] == pytest.approx(0.01, rel=0.15)


def test_groups_count_once_each():
    inside, rng = 0, np.random.default_rng(7)
    for _ in range(300):
        typical = np.exp(0.5 * rng.normal(size=5))
        values = 1e3 * np.repeat(typical, 20) * np.exp(0.2 * rng.normal(size=100))
        study = mdr.summarize_groups(values, np.repeat(list("abcde"), 20))
        inside += float(study["typical_low"]) < 1e3 < float(study["typical_high"])
    assert 0.92 < inside / 300 < 0.98  # one curve for one sample would cover less than half
    assert study["median_low"].values.max() < study["median_high"].values.max()
    one = mdr.summarize_groups(["1 kPa", "2 kPa"], ["a", "a"])
    assert math.isnan(float(one["typical_low"]))
    assert "one group" in one.summary()
    needed = "numbers above 0 Pa are needed"
    wrong = (
        ([1.0], ["a", "b"], "1 values and 2 groups"),
        ([-1.0], ["a"], needed),
        ([math.nan], ["a"], needed),
    )
    for values, groups, message in wrong:
        with pytest.raises(ProblemError, match=message):
            mdr.summarize_groups(values, groups)


def test_medians_of_few_values_have_the_interval_of_log_normal_values_and_a_note():
    study = mdr.summarize_groups(
        [1e3, 2e3, 4e3, 5e3, *np.linspace(1e3, 2e3, 6)], ["a"] * 3 + ["b"] + ["c"] * 6
    )
    # Student's t of 2 degrees of freedom and 97.5 % is sqrt(2) 0.95/sqrt(1 - 0.95^2)
    half = math.sqrt(2.0) * 0.95 / math.sqrt(1.0 - 0.95**2) * math.log(2.0) / math.sqrt(3.0)
    np.testing.assert_allclose(study["median_low"], [2e3 * math.exp(-half), math.nan, 1e3], rtol=1e-9)
    np.testing.assert_allclose(study["median_high"], [2e3 * math.exp(half), math.nan, 2e3], rtol=1e-9)
    assert "fewer than 6 values: a (3): " in study.summary()
    assert "one value: b (1): the median has no interval; measure 6" in study.summary()


def test_the_shell_has_ranges_and_uncertainties(tmp_path):
    case, table = tmp_path / "case.toml", tmp_path / "curve.csv"
    case.write_text(
        '[profile]\nkind = "pyramid"\nsides = 4\nhalf_angle = "35 deg"\n'
        '[body]\nkind = "elastic"\nyoung = "1 MPa"\npoisson = 0.5\n'
    )
    curve = recorded(mdr.Pyramid(4, half_angle="35 deg"), 0.002)
    rows = [f"{1e6 * z},{1e9 * f}" for z, f in zip(curve.travel, curve.force, strict=True)]
    table.write_text("\n".join(["travel [um],load [nN]", *rows]))
    given = ["fit", str(case), str(table), "--free", "body.young", "--json", "-o", str(tmp_path / "out")]
    given += ["--spring-constant", "0.05 N/m +- 10 %", "--max-indentation", "1 um", "--over-indentation", "3"]
    ran = CliRunner().invoke(app, given)
    assert ran.exit_code == 0, ran.output
    fitted = json.loads(ran.stdout)["fit"]
    young = fitted["values"]["body.young"]
    assert young["low"] < 3e3 < young["high"]
    assert fitted["calibration"]["spring_constant"]["body.young"] == pytest.approx(300.0, rel=0.02)
    assert (tmp_path / "out" / "over_indentation.csv").exists()
    wrong = CliRunner().invoke(app, [*given[:5], "--spring-constant", "0.05 N/m", "--uncertainty", "radius"])
    assert wrong.exit_code != 0
    assert "write each name once" in str(wrong.exception)
