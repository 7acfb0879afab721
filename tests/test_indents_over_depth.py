"""Drift, continuous stiffness, films and pop-ins: what records were made of is found, and bad input is refused."""

import json

import numpy as np
import pytest

import pymdr as mdr
from legibility import faults

TIP = mdr.AreaFunction([24.5], unit="1 nm")


def record_of_depth(size=1.0, rows=600):
    """Loading with E_r = 70 GPa and H = 9 GPa over 20 to 300 nm times a size."""
    contact_depth = size * np.linspace(20e-9, 300e-9, rows)
    area = TIP.area_at(contact_depth)
    force, stiffness = 9e9 * area, 2 * 70e9 * np.sqrt(area / np.pi)
    return {
        "indentation": contact_depth + 0.75 * force / stiffness,
        "normal_force": force,
        "harmonic_stiffness": stiffness,
    }


@pytest.mark.parametrize("size", [0.1, 1.0, 1e3])
def test_hardness_and_modulus_are_those_of_the_record(size):
    study = mdr.continuous_stiffness(record_of_depth(size), TIP, poisson=0.17, points=6)
    np.testing.assert_allclose(
        study["hardness"].values, 9e9, rtol=1e-4
    )  # quadratics through rows of up to 30 % of the depth
    np.testing.assert_allclose(
        study["reduced_modulus"].values, 70e9, rtol=1e-4
    )  # quadratics through rows of up to 30 % of the depth


def test_noise_of_the_stiffness_is_within_the_intervals():
    record = record_of_depth()
    noise = np.random.default_rng(3)
    record["harmonic_stiffness"] = record["harmonic_stiffness"] * (1 + 0.01 * noise.normal(size=600))
    study = mdr.continuous_stiffness(record, TIP, poisson=0.17, points=20)
    low, high = (study[f"reduced_modulus_{end}"].values for end in ("low", "high"))
    assert np.mean((low < 70e9) & (high > 70e9)) > 0.8
    assert np.median((high - low) / 70e9) < 0.05
    figure = study.plot().figure if hasattr(study.plot(), "figure") else study.plot()
    assert not faults(figure)


def drifting(rate, noise=0.0, seed=1):
    part = np.concatenate(
        [np.linspace(0, 1, 100), np.linspace(1, 0.1, 90), np.full(200, 0.1), np.linspace(0.1, 0, 10)]
    )
    time = 0.25 * np.arange(400)
    depth = 150e-9 + 50e-9 * part**0.7 + rate * time
    depth[:100] = 200e-9 * np.sqrt(part[:100]) + rate * time[:100]
    depth += noise * np.random.default_rng(seed).normal(size=400)
    return mdr.MeasuredCurve(force=1e-3 * part, indentation=depth, time=time)


@pytest.mark.parametrize("rate", [-0.3e-9, 0.0, 0.1e-9, 2e-9])
def test_the_drift_of_a_hold_is_measured_and_subtracted(rate):
    study = mdr.thermal_drift(drifting(rate))
    assert float(study["rate"][0]) == pytest.approx(rate, rel=1e-9, abs=1e-20)
    noisy = [drifting(rate, 0.2e-9, seed) for seed in range(20)]
    study = mdr.thermal_drift(noisy)
    low, high = (study[f"rate_{end}"].values for end in ("low", "high"))
    assert np.mean((low < rate) & (rate < high)) > 0.8


def jumping(jump, noise, seed):
    force = np.linspace(0, 1e-3, 401)
    depth = 100e-9 * (force / 1e-3) ** (2 / 3) + np.where(force > 0.4e-3, jump, 0.0)
    return mdr.MeasuredCurve(
        force=force, indentation=depth + noise * np.random.default_rng(seed).normal(size=401)
    )


def test_pop_ins_are_detected_and_noise_makes_none():
    study = mdr.first_pop_in([jumping(8e-9, 0.05e-9, seed) for seed in range(10)])
    np.testing.assert_allclose(study["pop_in_force"].values, 0.4e-3, rtol=0.02)
    np.testing.assert_allclose(study["pop_in_jump"].values, 8e-9, rtol=0.05)
    quiet = mdr.first_pop_in([jumping(0.0, 0.05e-9, seed) for seed in range(10)])
    with pytest.raises(mdr.NotValidError, match="no jump above"):
        quiet["pop_in_force"]


def test_the_load_of_a_pop_in_is_that_of_its_last_row():
    # a jump spread over a gap of rows fits as well if the gap begins before it
    study = mdr.first_pop_in([jumping(2e-9, 0.1e-9, seed) for seed in range(40)])
    force, low, high = (study[f"pop_in_force{end}"].values for end in ("", "_low", "_high"))
    assert np.count_nonzero((low < 0.4e-3) & (high > 0.4e-3)) >= 39
    np.testing.assert_allclose(force, 0.4e-3, atol=0.25e-5)
    assert np.median(high - low) < 1.5 * 0.25e-5


def test_bad_records_are_refused():
    record = record_of_depth()
    with pytest.raises(mdr.ProblemError, match="harmonic"):
        mdr.continuous_stiffness({k: v for k, v in record.items() if k != "harmonic_stiffness"}, TIP)
    without = {**record, "harmonic_stiffness": np.full(len(record["indentation"]), np.nan)}
    both = mdr.continuous_stiffness([without, record], TIP, poisson=0.3, points=6)
    alone = mdr.continuous_stiffness(record, TIP, poisson=0.3, points=6)
    assert np.isnan(both["hardness"].values[0]).all()
    assert np.array_equal(both["hardness"].values[1], alone["hardness"].values[0])
    assert both.notes[0].startswith("indent 1: ")
    substrate = mdr.Elastic("165 GPa", 0.22)
    films = [mdr.film_modulus(one, "300 nm", substrate) for one in (both, alone)]
    assert films[0]["young_modulus"].values == pytest.approx(films[1]["young_modulus"].values, nan_ok=True)
    part = np.sin(np.linspace(0.0, np.pi, 60))
    without_hold = mdr.MeasuredCurve(force=1e-3 * part, indentation=1e-7 * part, time=np.arange(60.0))
    with pytest.raises(mdr.ProblemError, match="hold"):
        mdr.thermal_drift(without_hold)
    with pytest.raises(mdr.ProblemError, match="at least 20"):
        mdr.first_pop_in(
            mdr.MeasuredCurve(force=np.linspace(0, 1e-3, 9), indentation=np.linspace(0, 1e-7, 9))
        )
    profile = mdr.continuous_stiffness(record, TIP, poisson=0.3, points=6)
    with pytest.raises(mdr.ProblemError, match="thickness"):
        mdr.film_modulus(profile, "-1 um", mdr.Elastic("165 GPa", 0.22))


def test_an_indent_without_a_rate_or_with_too_few_rows_leaves_the_others():
    part = np.sin(np.linspace(0.0, np.pi, 60))
    without_hold = mdr.MeasuredCurve(force=1e-3 * part, indentation=1e-7 * part, time=np.arange(60.0))
    both, alone = (mdr.thermal_drift(one) for one in ([without_hold, drifting(1e-10)], drifting(1e-10)))
    assert float(both["rate"][1]) == float(alone["rate"][0])
    assert np.isnan(both["rate"][0])
    assert both.claims["rate"].where.tolist() == [False, True]
    assert both.notes[0].startswith("indent 1: no hold at constant force")
    # what has no drift rate is not evaluated with its drift
    indents = [mdr.oliver_pharr(one, TIP, poisson=0.3) for one in (both, alone)]
    assert np.isnan(indents[0]["hardness"].values[0]).all()
    assert np.array_equal(indents[0]["hardness"].values[1], indents[1]["hardness"].values[0])
    assert indents[0].notes[0].startswith("indent 1: no hold at constant force")
    with pytest.raises(mdr.ProblemError, match=r"^indent 1: no hold"):
        mdr.calibrate_area(both, mdr.Elastic("72 GPa", 0.17), terms=1, frame_compliance="0 m/N")
    with pytest.raises(mdr.ProblemError, match="indent 1: no hold"):
        mdr.thermal_drift([without_hold, without_hold])
    short = mdr.MeasuredCurve(force=np.linspace(0, 1e-3, 9), indentation=np.linspace(0, 1e-7, 9))
    pops = mdr.first_pop_in([jumping(8e-9, 0.05e-9, 1), short, jumping(0.0, 0.05e-9, 2)])
    assert np.isfinite(pops["pop_in_force"].values).tolist() == [True, False, False]
    assert np.isfinite(pops["smallest_jump"].values).tolist() == [True, False, True]
    assert [note.split(":")[0] for note in pops.notes] == ["indent 2", "no pop-in"]
    assert pops.notes[1] == "no pop-in: indent 3"


def test_the_largest_shear_at_a_pop_in_is_that_of_hertz():
    radius, body = 3e-6, mdr.Elastic("70 GPa", 0.3)
    ball = mdr.Contact(mdr.Paraboloid(radius), body)
    study = mdr.first_pop_in(jumping(8e-9, 0.05e-9, 1), ball, shear_strength="5 GPa")
    peak = (6 * study["pop_in_force"].values * (70e9 / 0.91) ** 2 / np.pi**3 / radius**2) ** (1 / 3)
    np.testing.assert_allclose(study["largest_shear"] / peak, 0.310, atol=5e-4)  # Johnson (1985), section 4.2
    # the largest shear stress rises with the cube root of the load
    load = study["pop_in_force"] * (5e9 / study["largest_shear"]) ** 3
    np.testing.assert_allclose(study["strength_force"], load[0], rtol=1e-6)
    assert study.claims["largest_shear"].level is mdr.Level.EXACT
    with pytest.raises(mdr.NotValidError, match="sharp tip"):
        mdr.first_pop_in(jumping(8e-9, 0.05e-9, 1), mdr.Contact(mdr.Cone(half_angle="70 deg"), body))


UNITS = {"time": "s", "indentation": "m", "normal_force": "N", "harmonic_stiffness": "N/m"}


def written(file, columns):
    header = ", ".join(f"{name.replace('_', ' ')} [{UNITS[name]}]" for name in columns)
    rows = np.column_stack(list(columns.values()))
    file.write_text("\n".join([header, *(", ".join(f"{x:.9g}" for x in row) for row in rows)]))
    return file


@pytest.fixture
def files(tmp_path):
    drifted, jumped = drifting(0.1e-9, 0.05e-9), jumping(8e-9, 0.05e-9, 1)
    return {
        "drift": written(tmp_path / "drift.csv", {"time": drifted.time, "indentation": drifted.indentation, "normal_force": drifted.force}),
        "depth": written(tmp_path / "depth.csv", record_of_depth()),
        "jump": written(tmp_path / "jump.csv", {"indentation": jumped.indentation, "normal_force": jumped.force}),
    }  # fmt: skip


AREA = ("--area", "24.5", "--poisson", "0.17")


@pytest.mark.parametrize(
    ("command", "file", "options", "quantity", "truth", "stems"),
    [
        ("drift", "drift", (), "rate", 0.1e-9, {"drift"}),
        ("nanoindent", "drift", (*AREA, "--drift"), "indent", 1.0, {"drift", "nanoindent"}),
        ("stiffness", "depth", (*AREA, "--points", "6"), "hardness", 9e9, {"continuous_stiffness"}),
        (
            "stiffness", "depth",
            (*AREA, "--points", "6", "--film-thickness", "1 um +- 10 nm", "--substrate", "72.62 GPa, 0.17", "--widths", "0 10"),
            "young_modulus", 72.62e9, {"continuous_stiffness", "film"},
        ),
        ("pop-in", "jump", (), "pop_in_force", 0.4e-3, {"pop_in"}),
    ],
    ids=["drift", "nanoindent", "stiffness", "film", "pop-in"],
)  # fmt: skip
def test_the_shell_gives_the_numbers_of_the_studies(
    files, shell, tmp_path, command, file, options, quantity, truth, stems
):
    folder, page = tmp_path / "out", tmp_path / "page.html"
    status, out, error = shell(command, files[file], *options, "-o", folder, "--report", page, "--json")
    assert status == 0, error
    plain = json.loads(out)
    assert plain["study"][quantity]["values"][0] == pytest.approx(truth, rel=0.03)
    assert plain["claims"]
    assert {one.name for one in folder.iterdir()} == {
        f"{stem}.{end}" for stem in stems for end in ("csv", "png")
    }
    assert "data:image/png" in page.read_text()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("drift", "depth"), "no times"),
        (("drift", "drift", "--hold", "60 s"), "60 s to 90 s"),
        (("stiffness", "drift", "--area", "24.5"), "harmonic"),
        (("stiffness", "depth", "--area", "24,5"), "decimal points"),
        (("stiffness", "depth", "--area", "24.5", "--film-thickness", "1 um"), "needs both"),
        (("stiffness", "depth", "--area", "24.5", "--film-thickness", "1 um", "--substrate", "72"), "165 GPa, 0.22"),
        (("stiffness", "depth", "--area", "x"), "numbers are needed"),
        (("pop-in", "jump", "--radius", "1 um"), "--poisson"),
        (("pop-in", "jump", "--shear-strength", "5 GPa"), "needs a contact"),
        (("nanoindent", "drift", "--area", "24.5", "--hold", "1 s to 2 s"), "--drift"),
    ],
)  # fmt: skip
def test_bad_options_of_indents_are_refused(files, shell, arguments, message):
    command, file, *options = arguments
    status, _, error = shell(command, files[file], *options)
    assert status == 1
    assert message in error
