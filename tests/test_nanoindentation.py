"""Area functions as profiles, unloading curves by Oliver and Pharr and by the method, calibration of tips."""

import contextlib
import json
import math
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import pymdr as mdr
from pymdr.solving.nanoindentation import unloading

SILICA, DIAMOND = mdr.Elastic("72 GPa", 0.17), mdr.Elastic("1141 GPa", 0.07)
BERKOVICH = mdr.AreaFunction([24.5, 900.0, 2000.0], unit="1 nm")
FRAME = 0.4e-6


def reduced_modulus(body):
    return 1.0 / sum((1.0 - one.poisson**2) / one.young for one in (body, DIAMOND))


class Indent:
    """An indent whose contact depth, modulus and hardness are known, as a machine would record it."""

    def __init__(self, contact_depth, hardness=9e9, body=SILICA, tip=BERKOVICH, m=1.35):
        self.area = float(tip.area_at(contact_depth))
        self.force, self.m = hardness * self.area, m
        self.stiffness = 2.0 * reduced_modulus(body) * math.sqrt(self.area / math.pi)
        epsilon = unloading.epsilon_of_power(m)
        self.depth = contact_depth + epsilon * self.force / self.stiffness
        self.length = m * self.force / self.stiffness

    def record(self, rng, *, force=1e-6, depth=0.1e-9, hold=60, n=250, frame=FRAME):
        rise = np.linspace(0.0, 1.0, n)
        part = np.concatenate([rise**2, np.ones(hold), rise[::-1]])
        creep = 0.97 + 0.03 * np.linspace(0.0, 1.0, hold)
        down = self.depth - self.length * (1.0 - rise[::-1] ** (1.0 / self.m))
        h = np.concatenate([0.97 * self.depth * rise, creep * self.depth, down])
        noisy = self.force * part + force * rng.normal(size=part.size)
        return mdr.MeasuredCurve(
            force=noisy,
            indentation=h + frame * self.force * part + depth * rng.normal(size=part.size),
        )


def close(calibrated, expected, rtol):
    np.testing.assert_allclose(calibrated, expected, rtol=rtol, atol=0.0)


def covered(study, name, procedure, truth):
    row = study.data.sel(procedure=procedure)
    return (row[f"{name}_low"].values <= truth) & (truth <= row[f"{name}_high"].values)


@pytest.mark.parametrize(
    ("tip", "same"),
    [
        (mdr.AreaFunction([math.pi / 0.36**2]), mdr.Cone(slope=0.36)),
        (
            mdr.AreaFunction([math.pi / 0.36**2, 2e-7 * math.pi]),
            mdr.Hyperboloid(slope=0.36, tip_radius=100e-9),
        ),
        (
            mdr.AreaFunction([-math.pi, 400.0 * math.pi], unit="1 nm", max_depth="190 nm"),
            mdr.Sphere("200 nm"),
        ),
        (mdr.AreaFunction([0.0, 0.0, 3.0], unit="1 nm"), mdr.PowerLaw(4, math.pi**2 / 9 * 1e-9, 1e-9)),
    ],
)
def test_area_functions_are_the_tips_that_they_describe(tip, same):
    results = [mdr.solve(mdr.Contact(one, SILICA), mdr.load(1e-4) >> mdr.load(1e-3)) for one in (tip, same)]
    for name in ("indentation", "contact_radius", "normal_stiffness"):
        np.testing.assert_allclose(results[0][name], results[1][name], rtol=1e-12)
    assert results[0].claims["indentation"].level is mdr.Level.EXACT
    assert (tip.tip_radius is None) == (same.tip_radius is None)
    assert tip.tip_radius is None or math.isclose(tip.tip_radius, same.tip_radius, rel_tol=1e-12)


@given(
    st.lists(st.floats(0.0, 1e4), min_size=0, max_size=8),
    st.floats(1.0, 100.0),
    st.floats(-3.0, 3.0),
)
def test_the_gap_is_the_inverse_of_the_contact_radius(further, first, decade):
    tip = mdr.AreaFunction([first, *further], unit="1 nm")
    depth = 1e-9 * 10.0**decade
    radius = float(tip.radius_at(depth))
    close(float(tip.gap(radius)), depth, 1e-11)
    step = 1e-5 * radius
    slope = float(tip.gap(radius + step) - tip.gap(radius - step)) / (2.0 * step)
    close(float(tip.gap_slope(radius)), slope, 1e-5)
    close(float(tip.area_at(depth)), math.pi * radius**2, 1e-12)


def test_nine_coefficients_make_a_flattened_tip():
    tip = mdr.AreaFunction([24.5, *[300.0] * 8], unit="1 nm")
    result = mdr.solve(mdr.Contact(tip, SILICA), mdr.load("10 mN"))
    a, d, k, force = (
        float(result[name][0])
        for name in ("contact_radius", "indentation", "normal_stiffness", "normal_force")
    )
    # the contact depth of the elastic contact is the depth at which the area function has its area
    edge = d - float(result.field("normal_displacement", r=[a])[0])
    close(float(tip.area_at(edge)), math.pi * a**2, 1e-6)
    close(k, 2.0 * a * 72e9 / (1.0 - 0.17**2), 1e-12)
    assert 0.7 < (d - edge) * k / force < 0.8


def test_tables_are_profiles_and_go_through_case_files(tmp_path):
    depth = np.linspace(5e-9, 1e-6, 150)
    tip = mdr.AreaFunction(depth=depth, area=24.5 * depth**2 + 1e-6 * depth)
    smooth = mdr.AreaFunction([24.5, 1e-6])
    np.testing.assert_allclose(tip.area_at([2e-7, 7.7e-7]), smooth.area_at([2e-7, 7.7e-7]), rtol=1e-6)
    forces = [
        float(mdr.solve(mdr.Contact(one, SILICA), mdr.indent("300 nm"))["normal_force"][0])
        for one in (tip, smooth)
    ]
    close(forces[0], forces[1], 1e-4)
    for one in (tip, smooth, BERKOVICH):
        result = mdr.solve(mdr.Contact(one, SILICA), mdr.load("1 mN"))
        result.save(tmp_path / "tip.nc")
        assert mdr.open_result(tmp_path / "tip.nc").contact.profile == one


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "either coefficients, or both"),
        ({"coefficients": [1.0], "depth": [1.0], "area": [1.0]}, "either coefficients, or both"),
        ({"coefficients": [0.0, 0.0]}, "one of them not 0"),
        ({"coefficients": np.ones(10)}, "1 to 9"),
        ({"coefficients": [1.0], "unit": "0 nm"}, "above 0"),
        ({"depth": [1.0, 2.0, 3.0], "area": [1.0, 2.0, 3.0]}, "at least 4"),
        ({"depth": [1.0, 2.0, 3.0, 3.0], "area": [1.0, 2.0, 3.0, 4.0]}, "rise strictly"),
        ({"depth": [1.0, 2.0, 3.0, 4.0], "area": [1.0, 3.0, 2.0, 4.0]}, "rise strictly"),
        ({"depth": [1.0, 2.0, 3.0, 4.0], "area": [1.0, 2.0, 3.0, 4.0], "max_depth": 2.0}, "last depth"),
    ],
)
def test_bad_area_functions_are_refused(arguments, message):
    with pytest.raises(mdr.ProblemError, match=message):
        mdr.AreaFunction(**arguments)


@pytest.mark.parametrize("coefficients", [[-math.pi, 1.0], [24.5, -100.0], [24.5, 10.0, -5.0]])
def test_an_area_that_does_not_rise_is_no_profile(coefficients):
    tip = mdr.AreaFunction(coefficients, unit="1 nm")
    with pytest.raises(mdr.ProblemError, match="does not rise at depths between"):
        mdr.solve(mdr.Contact(tip, SILICA), mdr.load("1 mN"))
    assert math.isnan(float(tip.area_at("-1 nm")))


@pytest.mark.parametrize("m", [1.05, 1.2, 1.5, 1.8, 2.0])
def test_the_epsilon_of_a_shape_is_that_of_its_power(m):
    shape = np.array([0.0, 1.0, m, 1e-12])
    calibrated = unloading.peak_of(0.0, shape, 1.0, None)
    close(calibrated.epsilon, unloading.epsilon_of_power(m), 1e-8)
    close(calibrated.stiffness, math.e, 1e-9)
    assert unloading.epsilon_of_power(1.0) == 1.0


@pytest.mark.parametrize("tip", [mdr.Hyperboloid(slope=0.36, tip_radius="200 nm"), mdr.Sphere("2 um")])
def test_the_effective_shape_finds_the_contact_of_an_elastic_tip(tip):
    """Without plasticity the unloading is that of the tip itself, and its contact depth is known."""
    contact = mdr.Contact(tip, SILICA, DIAMOND)
    result = mdr.solve(contact, mdr.load("3 mN", steps=300) >> mdr.load(0.0, steps=300))
    record = mdr.MeasuredCurve(force=result["normal_force"].values, indentation=result["indentation"].values)
    a = float(result["contact_radius"].max())
    depth = np.linspace(1.0, 500.0, 400) * 1e-9
    r = np.linspace(0.0, 2.0 * a, 4001)
    radius = np.interp(depth, tip.gap(r), r, right=math.nan)
    known = np.isfinite(radius)
    area = mdr.AreaFunction(depth=depth[known], area=math.pi * radius[known] ** 2)
    study = mdr.oliver_pharr(record, area, poisson=0.17).data.sel(procedure="effective_shape", indent=1)
    close(float(study["contact_depth"]), float(tip.gap(a)), 2e-3)
    close(float(study["stiffness"]), float(result["normal_stiffness"].max()), 3e-3)
    close(float(study["young_modulus"]), 72e9, 2e-3)
    assert abs(float(study["residual_depth"])) < 0.02 * float(study["max_depth"])


@pytest.mark.parametrize("noise", [{}, {"force": 3e-5, "depth": 0.7e-9}, {"hold": 1}, {"depth": 0.0}])
def test_intervals_cover_the_true_values(noise):
    rng = np.random.default_rng(7)
    count = 200
    indents = [
        Indent(
            rng.uniform(80e-9, 400e-9),
            body=mdr.Elastic(rng.uniform(50e9, 300e9), 0.25),
            m=rng.uniform(1.2, 1.7),
        )
        for _ in range(count)
    ]
    study = mdr.oliver_pharr(
        [one.record(rng, **noise) for one in indents],
        BERKOVICH,
        frame_compliance=FRAME,
        poisson=0.25,
        epsilon=None,
    )
    truths = {
        "stiffness": [one.stiffness for one in indents],
        "hardness": [one.force / one.area for one in indents],
        "reduced_modulus": [one.stiffness * math.sqrt(math.pi / one.area) / 2.0 for one in indents],
    }
    for procedure in ("power_law", "effective_shape"):
        for name, truth in truths.items():
            fraction = covered(study, name, procedure, np.array(truth)).mean()
            assert 0.90 <= fraction <= 0.98, (procedure, name)


def calibration(rng, count=24, **noise):
    indents = [Indent(h) for h in np.geomspace(30e-9, 600e-9, count)]
    return [one.record(rng, **noise) for one in indents]


def test_noise_of_the_depth_near_its_recovery_biases_no_stiffness():
    """Noise of 8 % of the recovery, as small indenters have on hard bodies."""
    indent, errors, inside = Indent(100e-9, m=1.3), [], []
    for seed in range(12):
        record = indent.record(
            np.random.default_rng(seed),
            force=1e-4 * indent.force,
            depth=0.08 * indent.length,
            n=800,
            frame=0.0,
        )
        study = mdr.oliver_pharr(record, BERKOVICH, epsilon=None)
        errors.append(np.log(study["stiffness"].values[0] / indent.stiffness))
        inside += [
            covered(study, "stiffness", name, indent.stiffness)[0] for name in study["procedure"].values
        ]
    assert np.all(np.abs(np.mean(errors, axis=0)) < 0.06)  # of the fit of forces -0.1 and -0.3
    assert np.mean(inside) > 0.8


def test_of_several_indents_one_may_be_refused(tmp_path, shell):
    rng = np.random.default_rng(3)
    good = [Indent(depth).record(rng) for depth in (150e-9, 250e-9)]
    bad = mdr.MeasuredCurve(force=good[0].force[:250], indentation=good[0].indentation[:250])
    files = []
    for name, one in zip("abc", (good[0], bad, good[1]), strict=True):
        files.append(tmp_path / f"{name}.csv")
        rows = [f"{h * 1e9:.9g},{f * 1e3:.9g}" for h, f in zip(one.indentation, one.force, strict=True)]
        files[-1].write_text("\n".join(["depth [nm],load [mN]", *rows]) + "\n")
    options = {"frame_compliance": FRAME, "poisson": 0.17}
    records = [mdr.read_indents(file)[0] for file in files]
    study = mdr.oliver_pharr(records, BERKOVICH, **options)
    alone = mdr.oliver_pharr([records[0], records[2]], BERKOVICH, **options)
    assert study["record"].values.tolist() == ["a.csv", "b.csv", "c.csv"]
    for name in ("hardness", "young_modulus_low", "contact_depth"):
        assert np.array_equal(study[name].values[[0, 2]], alone[name].values)
        assert np.isnan(study[name].values[1]).all()
    assert study.notes[0].startswith("indent 2 (b.csv): 0 rows of the unloading")
    study.plot()
    with pytest.raises(mdr.ProblemError, match=r"indent 1 \(b\.csv\): 0 rows of the unloading"):
        mdr.oliver_pharr([records[1], records[1]], BERKOVICH, **options)
    command = ["--area", "24.5 900 2000", "--frame-compliance", "0.4 nm/mN", "-o", tmp_path / "out"]
    status, out, _ = shell("nanoindent", *files, *command)
    assert status == 0
    assert "indent 2 (b.csv)" in out
    assert (tmp_path / "out" / "nanoindent.csv").read_text().count("b.csv") == 2


def test_calibrations_cover_the_tip_and_the_frame():
    rng = np.random.default_rng(3)
    truth = np.append(FRAME, BERKOVICH.coefficients)
    inside, areas, moduli = [], [], []
    sample = Indent(200e-9, hardness=4e9, body=mdr.Elastic("200 GPa", 0.3))
    for _ in range(100):
        calibrated = mdr.calibrate_area(calibration(rng), SILICA, epsilon=None)
        low, high = calibrated.intervals.T
        inside.append((low <= truth) & (truth <= high))
        depth = calibrated.data["contact_depth"].values
        true = BERKOVICH.area_at(depth)
        areas.append(
            (calibrated.data["contact_area_low"] <= true) & (true <= calibrated.data["contact_area_high"])
        )
        record = sample.record(rng, force=1e-7, depth=1e-11)
        study = mdr.oliver_pharr(record, calibrated, poisson=0.3, epsilon=None)
        moduli.append(
            [covered(study, "young_modulus", name, 200e9) for name in ("power_law", "effective_shape")]
        )
    shares = np.mean(inside, axis=0)
    assert np.all((shares >= 0.90) & (shares <= 0.98))
    assert 0.90 <= np.mean(areas) <= 0.98
    assert 0.90 <= np.mean(moduli) <= 0.98


def test_a_calibration_brings_its_uncertainty():
    rng = np.random.default_rng(5)
    calibrated = mdr.calibrate_area(calibration(rng), SILICA, epsilon=None)
    close(calibrated.frame_compliance, FRAME, 0.1)
    indent = Indent(200e-9, hardness=4e9, body=mdr.Elastic("200 GPa", 0.3))
    record = indent.record(rng, force=1e-7, depth=1e-11)
    with_it = mdr.oliver_pharr(record, calibrated, poisson=0.3, epsilon=None)
    without = mdr.oliver_pharr(
        record, calibrated.area, frame_compliance=calibrated.frame_compliance, poisson=0.3, epsilon=None
    )
    close(float(with_it["young_modulus"][0, 0]), float(without["young_modulus"][0, 0]), 1e-12)
    widths = [
        float((s.data["young_modulus_high"] - s.data["young_modulus_low"])[0, 0]) for s in (with_it, without)
    ]
    assert widths[0] > 1.2 * widths[1]
    with pytest.raises(mdr.ProblemError, match="leave frame_compliance out"):
        mdr.oliver_pharr(record, calibrated, frame_compliance=0.0)


def indent_file(folder, name, indent, rng):
    record = indent.record(rng)
    rows = (f"{h * 1e9:.5f},{f * 1e3:.7f}\n" for h, f in zip(record.depth, record.force, strict=True))
    (folder / name).write_text("depth [nm],load [mN]\n" + "".join(rows))
    return folder / name


def test_the_command_evaluates_and_calibrates(tmp_path, shell):
    rng = np.random.default_rng(2)
    sample = Indent(200e-9, hardness=4e9, body=mdr.Elastic("100 GPa", 0.3))
    file = indent_file(tmp_path, "indent.csv", sample, rng)
    reference = [
        indent_file(tmp_path, f"silica_{i}.csv", Indent(h), rng)
        for i, h in enumerate(np.geomspace(40e-9, 500e-9, 6))
    ]
    areas = [part for one in reference for part in ("--reference", one)]
    table = tmp_path / "area.csv"
    depths = np.linspace(5.0, 600.0, 200)
    areas_of_table = BERKOVICH.area_at(depths * 1e-9) * 1e18
    rows = (f"{h},{a}\n" for h, a in zip(depths, areas_of_table, strict=True))
    table.write_text("h [nm],A [nm^2]\n" + "".join(rows))
    common = ["--poisson", "0.3", "--epsilon", "0", "--json", "-o", tmp_path / "out"]
    frame = ["--frame-compliance", "0.4 nm/mN"]
    for options in (["--area", "24.5 900, 2000", *frame], ["--area-table", table, *frame], areas):
        status, out, error = shell("nanoindent", file, *options, *common)
        assert (status, error) == (0, "")
        answer = json.loads(out)
        study = answer["study"]
        assert study["procedure"]["values"] == ["power_law", "effective_shape"]
        assert list(answer["preceding_studies"] or ()) == (["area"] if options is areas else [])
        np.testing.assert_allclose(study["young_modulus"]["values"], 100e9, rtol=0.03)
    assert {one.name for one in (tmp_path / "out").iterdir()} == {
        "area.csv",
        "area.png",
        "nanoindent.csv",
        "nanoindent.png",
    }
    status, out, _ = shell("nanoindent", file, "--area", "24.5 900 2000")
    assert status == 0
    assert "pile-up" in out
    for options, message in (
        ([], "give one of --area"),
        (["--area", "24.5", *areas], "give one of --area"),
        (["--area", "24.5 x"], "numbers are needed"),
    ):
        status, _, error = shell("nanoindent", file, *options)
        assert status == 1
        assert message in error


def test_what_is_no_indent_is_refused():
    rng = np.random.default_rng(0)
    good = Indent(200e-9).record(rng)
    approach = mdr.MeasuredCurve(force=good.force[:250], indentation=good.indentation[:250])
    pulled = mdr.MeasuredCurve(force=-np.abs(good.force), indentation=good.indentation)
    shifted = mdr.MeasuredCurve(force=good.force, indentation=good.indentation - 1e-6)
    for record, message in (
        (approach, "give a record with its unloading"),
        (pulled, "no force is above 0 N"),
        (shifted, "must count from the first contact"),
        ("indent.csv", "is not a record"),
        (mdr.measured_loops, "is not a record"),
    ):
        with pytest.raises(mdr.ProblemError, match=message):
            mdr.oliver_pharr([record], BERKOVICH)
    for options, message in (
        ({"frame_compliance": "-1 nm/mN"}, "at least 0 m/N"),
        ({"poisson": 0.6}, "at most 0.5"),
        ({"beta": 3.0}, "beta"),
        ({"epsilon": 1.2}, "epsilon"),
        ({"fit_range": (0.9, 0.2)}, "fit_range"),
        ({"fit_range": 0.5}, "fit_range"),
        ({"tip": mdr.Elastic("1 GPa", 0.3)}, "not below that of the tip alone"),
        ({"tip": "diamond"}, "homogeneous elastic or rigid body"),
    ):
        with pytest.raises(mdr.ProblemError, match=message):
            mdr.oliver_pharr(good, BERKOVICH, **options)
    with pytest.raises(mdr.ProblemError, match="no record is given"):
        mdr.oliver_pharr([], BERKOVICH)
    with pytest.raises(mdr.ProblemError, match="an AreaFunction or"):
        mdr.oliver_pharr(good, mdr.Cone(slope=0.3))
    with pytest.raises(mdr.NotValidError, match="give poisson"):
        mdr.oliver_pharr(good, BERKOVICH, frame_compliance=FRAME)["young_modulus"]
    with pytest.raises(mdr.ProblemError, match=r"20 nm/mN is too large: .* give a smaller frame_comp"):
        mdr.oliver_pharr(good, BERKOVICH, frame_compliance="20 nm/mN")
    with pytest.raises(mdr.ProblemError, match="3 indents for 4 unknowns"):
        mdr.calibrate_area([good] * 3)
    with pytest.raises(mdr.ProblemError, match="from 1 to 9"):
        mdr.calibrate_area([good] * 3, terms=0)


def test_steeper_unloading_than_elastic_and_pile_up_are_shown():
    rng = np.random.default_rng(0)
    hard, soft = (
        mdr.oliver_pharr(Indent(200e-9, hardness=h).record(rng), BERKOVICH, frame_compliance=FRAME)
        for h in (9e9, 0.5e9)
    )
    assert {one.name: one.met for one in hard.assumptions}["pile-up"]
    assert not {one.name: one.met for one in soft.assumptions}["pile-up"]
    assert "pile-up" in soft.summary()


def test_studies_are_drawn_written_and_pickled(tmp_path):
    rng = np.random.default_rng(6)
    calibrated = mdr.calibrate_area(calibration(rng, 8), SILICA)
    study = mdr.oliver_pharr([one.record(rng) for one in [Indent(100e-9), Indent(200e-9)]], calibrated)
    for one in (calibrated, study):
        assert one.plot().axes
        one.save(tmp_path / "study.nc")
        one.to_csv(tmp_path / "study.csv", about=True)
        again = pickle.loads(pickle.dumps(one))
        assert again.data.identical(one.data)
        assert again.summary() == one.summary()
    assert np.array_equal(
        mdr.solve(mdr.Contact(calibrated.area, SILICA), mdr.load("1 mN")).claims["normal_force"].where, [True]
    )


RISE = np.linspace(0.0, 1.0, 150)


@pytest.mark.parametrize(
    ("down", "noise"),
    [
        (np.zeros(150), 0.0),
        (0.1e-6 * RISE, 0.0),
        (-0.1e-6 * RISE + 0.05e-6 * np.sin(np.pi * RISE), 0.0),
        (-0.02e-6 * RISE, 0.1e-6),
        (-0.05e-6 * RISE**4, 0.0),
        (-0.05e-6 * RISE**0.2, 0.0),
        (np.zeros(150), 1e-6),
    ],
)
def test_records_that_are_no_unloading_are_refused_or_have_intervals(down, noise):
    rng = np.random.default_rng(8)
    force = 1e-2 * np.concatenate([RISE, RISE[::-1]])
    depth = 0.3e-6 + np.concatenate([RISE * 0.3e-6 - 0.3e-6, down]) + noise * rng.normal(size=300)
    record = mdr.MeasuredCurve(force=force, indentation=depth)
    study = None
    with contextlib.suppress(mdr.ProblemError):
        study = mdr.oliver_pharr(record, BERKOVICH, tip=mdr.Rigid(), poisson=0.2)
    if study is not None:
        assert np.all(study["young_modulus_low"] <= study["young_modulus"])
        assert np.all(study["young_modulus"] <= study["young_modulus_high"])
        assert study.summary()


def test_indents_of_one_depth_determine_no_area_function():
    rng = np.random.default_rng(4)
    same = Indent(200e-9).record(rng)
    with pytest.raises(mdr.ProblemError, match="do not determine 4 unknowns"):
        mdr.calibrate_area([same] * 8)
    alike = [Indent(h).record(rng) for h in np.linspace(199e-9, 201e-9, 8)]
    with pytest.raises(mdr.ProblemError, match="do not determine 4 unknowns"):
        mdr.calibrate_area(alike, epsilon=None)
    low, high = mdr.calibrate_area(alike, terms=1, frame_compliance=FRAME, epsilon=None).intervals.T
    assert low[0] == high[0] == FRAME
    # C0 alone stands for all coefficients at one depth
    area = float(BERKOVICH.area_at("200 nm")) / 200e-9**2
    assert low[1] < area < high[1]


def test_an_indent_whose_rows_run_backward_is_refused():
    depth = np.concatenate([np.linspace(0, 300e-9, 150), np.linspace(300e-9, 180e-9, 150)])
    force = np.where(
        np.arange(300) < 150,
        10e-3 * (depth / 300e-9) ** 2,
        10e-3 * np.maximum(depth / 150e-9 - 1.0, 0.0) ** 1.4,
    )
    forward = mdr.oliver_pharr({"indentation": depth, "normal_force": force}, BERKOVICH)
    assert forward.claims["hardness"].readable
    with pytest.raises(
        mdr.ProblemError, match=r"begins at 180 nm and ends at 0 m, .* run backward; reverse them"
    ):
        mdr.oliver_pharr({"indentation": depth[::-1], "normal_force": force[::-1]}, BERKOVICH)
