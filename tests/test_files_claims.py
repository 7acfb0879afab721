"""Errors of claims in files, summaries, HTML and JSON, and what the notes of measured profiles say."""

import json
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

import pymdr as mdr
from pymdr.errors import FileError
from pymdr.interpretation.accuracy import with_errors
from pymdr.interpretation.validity import EXACT_WITHIN, Claim, normal_claims, total_error
from pymdr.presentation import text
from pymdr.presentation.html import claims_html
from pymdr.solving.bands import shifted
from pymdr.solving.reopening import result_from_dataset
from pymdr.workbench.cli import app

UNIT = mdr.Elastic(0.75, 0.0)
TIP = mdr.Function(lambda r: np.sqrt(1.0 + r**2) - 1.0, derivative=lambda r: r / np.sqrt(1.0 + r**2))
STEPS = 200


@pytest.fixture(scope="module")
def solved():
    """A result whose numbers have measured errors."""
    result = mdr.solve(mdr.Contact(TIP, UNIT), mdr.indent(0.3, steps=STEPS))
    assert result.claims["normal_force"].error is not None
    return result


@pytest.fixture(scope="module")
def rough(solved):
    """The same with errors that are too large to be called exact."""
    bare = {name: replace(solved.claims[name], error=None) for name in ("normal_force", "pressure")}
    claims = {**solved.claims, **bare}
    errors = {"normal_force": np.geomspace(1e-12, 2.5e-7, STEPS), "pressure": np.full(STEPS, 3e-8)}
    return replace(solved, claims=with_errors(claims, errors))


def same_errors(one, other):
    assert one.keys() == other.keys()
    for name, claim in one.items():
        result = other[name].error
        assert (claim.error is None) == (result is None), name
        assert claim.error is None or np.array_equal(claim.error, result), name
        assert (claim.level, claim.reason) == (other[name].level, other[name].reason)


# --- files -----------------------------------------------------------------------------------------------


def test_errors_come_back_from_files(solved, rough, tmp_path):
    for result in (solved, rough):
        result.save(tmp_path / "result.nc")
        again = mdr.open_result(tmp_path / "result.nc")
        same_errors(result.claims, again.claims)
        assert set(again.data) == set(result.data)
        again.save(tmp_path / "again.nc")
        same_errors(result.claims, mdr.open_result(tmp_path / "again.nc").claims)


def test_equal_errors_are_saved_once_and_one_number_as_one(rough):
    packed = rough.to_dataset()
    claims = json.loads(packed.attrs["pymdr_claims"])
    holders = {str(name) for name in packed if str(name).startswith("pymdr_error_")}
    arrays = [claim.error for claim in rough.claims.values() if claim.error is not None]
    changing = {error.tobytes() for error in arrays if np.ptp(error) > 0.0}
    assert len(holders) == len(changing)
    assert claims["pressure"]["error"] == 3e-8
    assert claims["contact_radius"]["error"] == claims["normal_stiffness"]["error"]


def test_closed_forms_save_no_errors():
    result = mdr.solve(mdr.Contact(mdr.Sphere(1.0), UNIT), mdr.indent(0.1, steps=3))
    packed = result.to_dataset()
    assert not any(str(name).startswith("pymdr_error_") for name in packed)
    assert all("error" not in claim for claim in json.loads(packed.attrs["pymdr_claims"]).values())
    same_errors(result.claims, result_from_dataset(packed).claims)


def test_files_without_errors_still_open(solved):
    packed = solved.to_dataset()
    packed = packed.drop_vars([name for name in packed if str(name).startswith("pymdr_error_")])
    claims = json.loads(packed.attrs["pymdr_claims"])
    for claim in claims.values():
        claim.pop("error", None)
    old = result_from_dataset(packed.assign_attrs(pymdr_claims=json.dumps(claims)))
    assert all(not claim.error.any() for claim in old.claims.values())
    assert np.array_equal(old["normal_force"], solved["normal_force"])
    assert old.claims["pressure"].level is solved.claims["pressure"].level


def test_a_file_whose_errors_are_gone_is_damaged(rough):
    packed = rough.to_dataset()
    without = packed.drop_vars([name for name in packed if str(name).startswith("pymdr_error_")])
    with pytest.raises(FileError, match="damaged pymdr result"):
        result_from_dataset(without)
    holder = next(name for name in packed if str(name).startswith("pymdr_error_"))
    shorter = packed.drop_vars(holder).assign({holder: ("other", np.zeros(3))})
    with pytest.raises(FileError, match="wrong number of steps in the claims of"):
        result_from_dataset(shorter)


def test_histories_that_go_to_and_fro_keep_their_errors_small(tmp_path):
    depth = 0.1 + 0.05 * np.sin(2.0 * np.pi * np.arange(20_000) / 100.0).round(3)
    result = mdr.solve(mdr.Contact(TIP, UNIT), mdr.Path(indentation=depth))
    result.save(tmp_path / "with.nc")
    bare = {name: replace(claim, error=np.zeros(depth.size)) for name, claim in result.claims.items()}
    replace(result, claims=bare).save(tmp_path / "without.nc")
    added = (tmp_path / "with.nc").stat().st_size - (tmp_path / "without.nc").stat().st_size
    assert added < 0.2 * (tmp_path / "without.nc").stat().st_size


# --- words -----------------------------------------------------------------------------------------------


def test_errors_are_shown_where_a_number_is_not_exact(solved, rough):
    assert "error" not in solved.summary()
    words = rough.summary()
    row = next(line for line in words.splitlines() if line.lstrip().startswith("normal force"))
    assert row.endswith("approximate  error 2.5e-07")
    assert "relative errors of up to: " in words
    assert "normal_force 2.5e-07" in words
    assert "pressure 3.0e-08" in words
    assert "error 2.5e-07" in rough._repr_html_()
    # one group of claims for all that err, not one for every size of the error
    assert words.count(f"relative numerical error above {EXACT_WITHIN:g}") == 1


def test_html_shows_every_error_when_unfolded(rough):
    result = claims_html(rough.claims)
    assert "2.5e-07" in result
    assert "3.0e-08" in result
    assert claims_html({"gap": replace(rough.claims["gap"], error=None)}).count("rounding") == 1


def test_assessments_show_errors(rough):
    assessed = mdr.assess(rough.contact, rough.path)
    assert "normal_force 2.5e-07" in replace(assessed, claims=rough.claims).summary()


def test_errors_outside_a_claim_are_not_shown():
    where = np.array([True, False])
    claims = with_errors(normal_claims(where, "why"), {"gap": np.array([1e-12, 1.0])})
    assert text.largest_error(claims["gap"]) == 1e-12
    assert text.last_error(claims["gap"]) == ""
    assert text.largest_error(claims["pressure"]) == 0.0
    empty = replace(claims["gap"], where=np.zeros(2, dtype=bool))
    assert text.largest_error(empty) == 0.0


def test_json_holds_the_errors(tmp_path):
    r = np.linspace(0.0, 1e-3, 40)
    rows = "\n".join(f"{x!r},{y!r}" for x, y in zip(r.tolist(), (r**2 / 2e-2).tolist(), strict=True))
    (tmp_path / "tip.csv").write_text(f"r [m],f [m]\n{rows}\n")
    (tmp_path / "case.toml").write_text(
        '[profile]\nkind = "sampled"\nfile = "tip.csv"\n[body]\nkind = "elastic"\nyoung = 1e9\npoisson = 0.3\n'
        '[[path]]\nkind = "indent"\nindentation = 1e-6\nsteps = 3\n'
    )
    ran = CliRunner().invoke(app, ["run", str(tmp_path / "case.toml"), "--json", "-o", str(tmp_path / "out")])
    assert ran.exit_code == 0, ran.output
    data = json.loads(ran.output)
    assert 0.0 <= data["claims"]["normal_force"]["error"] < 1e-9
    assert any("the profile is a cubic spline" in note for note in data["notes"])
    ball = CliRunner().invoke(app, ["check", "examples/ball_on_glass.toml", "--json"])
    assert json.loads(ball.output)["claims"]["normal_force"]["error"] == 0.0


def test_exact_means_a_small_known_error_and_none_means_not_known():
    where = np.array([True, True, False])
    exact = Claim(mdr.Level.EXACT, "model", "source", where)
    assert np.array_equal(exact.error, np.zeros(3))
    assert replace(exact, error=np.array([1e-9, 0.0, 1.0])).level is mdr.Level.EXACT
    coarse = replace(exact, error=np.array([2e-9, 0.0, 0.0]))
    assert coarse.level is mdr.Level.APPROXIMATE
    assert "relative numerical error above 1e-09" in coarse.reason
    # an approximation is not made exact by its numerics
    assert replace(exact, level=mdr.Level.APPROXIMATE).error is None
    assert replace(exact, level=mdr.Level.APPROXIMATE, error=np.full(3, 1e-14)).error is None
    assert total_error(np.array([0.3]), 0.9, 0.1) == 1.0
    assert total_error(np.array([0.3]), None) is None
    assert (
        text.last_error(replace(exact, level=mdr.Level.APPROXIMATE, where=where[::-1])) == "error not known"
    )


# --- measured profiles -----------------------------------------------------------------------------------


def noisy(scatter=True, **more):
    r = np.linspace(0.0, 1e-7, 61)
    noise = 0.05e-9 * np.random.default_rng(4).standard_normal(61)
    heights = r**2 / 2e-7 + noise
    return mdr.Sampled(r, heights, np.where(r > 0, 0.05e-9, 0.0) if scatter else None, **more)


def test_results_say_which_curve_was_run_through_the_samples():
    for tip, words in (
        (noisy(), "the profile is a smoothing spline by the scatter"),
        (noisy(False, interpolation=mdr.ShapePreserving()), "the profile is a shape-preserving cubic"),
    ):
        for profile in (tip, tip + mdr.Paraboloid("1 um")):
            result = mdr.solve(mdr.Contact(profile, UNIT), mdr.indent(1e-9))
            assert result.notes[0].startswith(words)
    assert mdr.solve(mdr.Contact(mdr.Sphere(1.0), UNIT), mdr.indent(0.1)).notes == ()


def test_a_note_says_that_a_scatter_that_is_an_offset_makes_no_band():
    r = np.linspace(0.0, 1e-7, 61)
    for scatter, words in ((np.full(61, 1e-10), "have zero width"), (1e-3 * r, "a sensitivity")):
        tip = mdr.Sampled(r, r**2 / 2e-7, scatter)
        assert words in mdr.solve(mdr.Contact(tip, UNIT), mdr.indent("1 nm")).notes[-1]


def test_bands_smooth_by_the_scatter_and_map_once():
    tip = noisy()
    low, high = shifted(tip, -1.0), shifted(tip, 1.0)
    assert shifted(noisy(), 1.0) is high
    assert shifted(tip + mdr.Paraboloid("1 um"), 1.0).parts[0] is high
    for moved in (low, high):
        assert moved.interpolation == mdr.SmoothingSpline()
        assert np.array_equal(moved.scatter, tip.scatter)
        assert moved.curve_description.startswith("a smoothing spline by the")
    assert np.allclose(high.height - low.height, 2.0 * tip.scatter, rtol=1e-6, atol=0.0)
    result = mdr.solve(mdr.Contact(tip, UNIT), mdr.indent(2e-9, steps=4))
    below, above = result.bands["normal_force"]
    assert np.all(below <= result["normal_force"])
    assert np.all(result["normal_force"] <= above)


def test_case_files_leave_the_curve_to_the_scatter():
    from pymdr.problem.codec import case_adapter, decode_case

    assert '"cubic_spline"}' not in json.dumps(case_adapter().json_schema().get("default", {}))
    r = np.linspace(0.0, 1.0, 9)
    profile = {"kind": "sampled", "radius": r.tolist(), "height": (r**2).tolist()}
    case = {"body": {"kind": "rigid"}, "path": [{"kind": "indent", "indentation": 0.1}]}
    for more, kind in (
        ({}, mdr.CubicSpline),
        ({"scatter": [0.01] * 9}, mdr.SmoothingSpline),
        ({"scatter": [0.01] * 9, "interpolation": {"kind": "shape_preserving"}}, mdr.ShapePreserving),
    ):
        body = {"kind": "elastic", "young": 1.0, "poisson": 0.3}
        _, contact, _ = decode_case({**case, "profile": {**profile, **more}, "body": body})
        assert isinstance(contact.profile.interpolation, kind)
    schema = json.dumps(case_adapter().json_schema())
    assert '"default": {"kind": "cubic_spline"}' not in schema
