"""Force curves: segments are read, steps are told and undone, and contact points lie where the curve was made to begin."""

from __future__ import annotations

import json
import math
import pickle
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import pymdr as mdr
from drawing import examples
from pymdr.errors import CaseError, FileError, MissingExtraError, ProblemError
from pymdr.problem.facts import Facts
from pymdr.workbench.segments import segments_in
from pymdr.workbench.tables import read_curve

AFM = Path(__file__).parent.parent.parent / "shared" / "data" / "afm"


def made(
    size=1e-6, largest=1e-8, exponent=1.5, free=0.5, samples=800, ratio=300.0, tilt=0.0, offset=0.0, seed=0
):
    """An approach whose contact begins at 0, with noise of the largest force over a ratio."""
    x = np.linspace(-free * size, (1.0 - free) * size, samples)
    force = largest * np.clip(x / x[-1], 0.0, None) ** exponent
    noise = largest / ratio * np.random.default_rng(seed).normal(size=samples)
    return x, force + noise + offset * largest + tilt * largest / size * x


SIZES = st.floats(-9.0, -3.0).map(lambda x: 10.0**x)
FORCES = st.floats(-12.0, 1.0).map(lambda x: 10.0**x)


def test_signs_that_the_maker_defines_are_kept_whatever_the_record_shows():
    pull = -np.exp(-np.linspace(0.0, 30.0, 400)[::-1])
    record = mdr.MeasuredCurve(force=1e-9 * pull, indentation=np.linspace(-1e-6, 0.0, 400))
    jpk = Facts({"format": "JPK Instruments (binary QMap data)"})
    of_jpk = mdr.MeasuredCurve(force=record.force, indentation=record.indentation, metadata=jpk)
    assert record.orient().step.numbers["force"] == -1.0
    assert "as JPK Instruments" in of_jpk.orient().step.description
    for kept in (
        of_jpk.orient(),
        record.orient(keep_signs=True),
        record.prepare(baseline="0 N", contact_point="0 m", keep_signs=True),
    ):
        assert kept.step is not None
        assert np.all(kept.force <= 0.0)
    assert np.all(of_jpk.orient(keep_signs=False).force >= 0.0)
    assert np.all(of_jpk.orient({"force": -1.0, "indentation": 1.0}).force >= 0.0)
    flat = 1e-12 * np.random.default_rng(3).normal(size=400)
    turned = mdr.MeasuredCurve(force=flat, indentation=record.indentation).orient(
        {"force": -1.0, "indentation": 1.0}
    )
    bare = mdr.Contact(mdr.Paraboloid("1 um"), mdr.Elastic("1 kPa", 0.5))
    with pytest.raises(
        ProblemError,
        match="the sign of its force was reversed: if compression was positive, keep it with keep_signs;",
    ):
        mdr.fit(bare, turned, ["body.young"])


@pytest.mark.skipif(not AFM.exists(), reason="the measured curves are not here")
def test_pixels_of_quick_imaging_without_a_clear_contact_are_read():
    pytest.importorskip("afmformats")
    read = mdr.read_prepared_curves(
        AFM / "fmt-jpk-fd_2020.02.07-16.29.05.036.jpk-qi-data", segment="approach"
    )
    assert len(read) == 4
    assert all(one.steps[1].numbers["force"] == 1.0 for one in read)


@settings(max_examples=examples(60), deadline=None)
@given(
    SIZES,
    FORCES,
    st.sampled_from([1.0, 1.2, 1.5, 2.0]),
    st.floats(0.2, 0.8),
    st.integers(200, 3000),
    st.floats(1.3, 5.0),
    st.floats(-0.5, 0.5),
    st.floats(-2.0, 2.0),
    st.floats(-3.0, 3.0),
    st.integers(0, 10**6),
)
def test_contact_points_lie_where_the_contact_begins(
    size, largest, exponent, free, samples, log_ratio, tilt, offset, place, seed
):
    ratio = 10.0**log_ratio
    x, force = made(size, largest, exponent, free, samples, ratio, tilt, offset, seed)
    curve = mdr.MeasuredCurve(force=force, indentation=x + place * size)
    computed = curve.contact_point()
    deep = (1.0 - free) * size
    assert computed.low <= place * size <= computed.high
    assert computed.low <= computed.value <= computed.high
    if ratio > 100.0:
        assert computed.high - computed.low < 1.5 * deep
        assert abs(computed.value - place * size) < 0.2 * deep
        hidden = deep * (3.0 / ratio) ** (1.0 / exponent)  # where the force is three times the noise
        assert abs(computed.methods["line and power"].value - place * size) < hidden + 0.01 * deep
    assert computed.disagreement <= computed.high - computed.low
    line = computed.baseline
    # six standard errors: of a median of deviations 1.2/sqrt(n), of the end of a line 2/sqrt(n)
    assert line.noise == pytest.approx(largest / ratio, rel=7.0 / math.sqrt(line.samples))
    before = x + place * size < line.high
    true = offset * largest + tilt * largest / size * x[before]
    assert (
        np.max(np.abs(line.force_at((x + place * size)[before]) - true))
        < 12.0 / math.sqrt(line.samples) * largest / ratio + 1e-6 * largest
    )


@settings(max_examples=examples(10), deadline=None)
@given(st.floats(-6.0, -4.0), st.floats(3.0, 5.0), st.floats(-2.0, 0.0), st.integers(0, 10**6))
def test_bodies_that_jump_into_contact_make_the_methods_disagree(log_work, log_young, log_machine, seed):
    gel = mdr.Contact(
        mdr.Paraboloid("5 um"), mdr.Elastic(10.0**log_young, 0.5), adhesion=mdr.JKR(10.0**log_work)
    )
    positions = np.linspace(-3e-6, 2e-6, 1200)
    machine = 10.0**log_machine
    force = mdr.solve(gel, mdr.Path(travel=positions), machine_stiffness=machine)["normal_force"].values
    force = force + 1e-11 * np.random.default_rng(seed).normal(size=positions.size) + 3e-10
    result = mdr.MeasuredCurve(force=force, travel=positions + 1e-6, spring_constant=machine).contact_point()
    assert result.low < 1e-6 < result.high
    jump = 3e-10 - float(force.min())
    if jump > 0.1 * float(force.max()):  # the force comes back to 0 only deep in the contact
        assert result.methods["deviation"].value > 1.05e-6


@settings(max_examples=examples(15), deadline=None)
@given(SIZES, FORCES, st.floats(-1.0, 1.0), st.integers(0, 10**6))
def test_scales_change_nothing_but_the_scale(size, largest, tilt, seed):
    results = []
    for length, newton in ((1.0, 1.0), (size, largest)):
        x, force = made(length, newton, tilt=tilt, seed=seed)
        results.append(mdr.MeasuredCurve(force=force, indentation=x).contact_point())
    one, other = results
    for name in ("value", "low", "high"):
        assert getattr(other, name) / size == pytest.approx(getattr(one, name), rel=1e-6, abs=1e-6)


@settings(max_examples=examples(25), deadline=None)
@given(
    st.booleans(),
    st.booleans(),
    st.floats(-1.0, 1.0),
    st.sampled_from(["approach", "retreat", ""]),
    st.booleans(),
    st.integers(0, 10**6),
)
def test_signs_follow_from_the_record(turned_force, turned_position, offset, segment, backwards, seed):
    x, force = made(offset=offset, tilt=0.05, seed=seed)
    if backwards:
        x, force = x[::-1], force[::-1]
    given_segment = {"approach": "retreat", "retreat": "approach"}.get(segment, segment)
    curve = mdr.MeasuredCurve(
        force=-force if turned_force else force,
        travel=-x if turned_position else x,
        spring_constant="0.1 N/m",
        segment=given_segment if turned_position else segment,
    )
    result = curve.orient()
    assert np.array_equal(result.force, force)
    assert np.array_equal(result.travel, x)
    assert result.segment == segment
    assert ("force" in result.step.description.split(":")[1]) == turned_force or not turned_force
    assert result.step.numbers == {
        "force": -1.0 if turned_force else 1.0,
        "travel": -1.0 if turned_position else 1.0,
    }
    assert result.orient().step.description.startswith("kept")
    assert result.undo() == curve
    assert curve.orient(result.step.numbers) == result
    with pytest.raises(ProblemError, match="sign of travel is None"):
        curve.orient({"force": 1.0})


@settings(max_examples=examples(40), deadline=None)
@given(
    st.lists(st.integers(5, 780), min_size=1, max_size=6, unique=True),
    st.floats(13.0, 1e4),
    st.booleans(),
    st.integers(0, 10**6),
)
def test_spikes_are_marked_and_nothing_else(places, height, jumps, seed):
    assume(all(abs(a - b) > 12 for a in places for b in places if a != b))
    x, force = made(seed=seed)
    noise = 1e-8 / 300.0
    if jumps:  # into contact, as under adhesion
        assume(all(abs(place - 400) > 12 for place in places))
        force = force - np.where(x > 0.0, 5e-9, 0.0)
    spiked = force.copy()
    sides = np.random.default_rng(seed).choice([-1.0, 1.0], size=len(places))
    spiked[places] += sides * (height + 5.0) * noise
    curve = mdr.MeasuredCurve(force=spiked, indentation=x)
    result = curve.mark_outliers()
    assert np.array_equal(result.force, spiked)
    marked = set(np.flatnonzero(result.outliers).tolist())
    assert marked <= set(places)
    if height > 25.0:
        assert marked == set(places)
    clean = mdr.MeasuredCurve(force=force, indentation=x).mark_outliers()
    assert not clean.outliers.any()
    left = result.leave_out_marked()
    assert left.force.size == 800 - len(marked)
    assert left.undo() == result


@settings(max_examples=examples(40), deadline=None)
@given(st.floats(0.3, 1.5), st.floats(1.0, 5.0), st.booleans(), st.integers(0, 10**6))
def test_the_plateau_of_a_detector_is_marked(fraction, log_ratio, returns, seed):
    assume(abs(1.0 - fraction) > 5.0 / 10.0**log_ratio)
    x, force = made(ratio=10.0**log_ratio, seed=seed)
    if returns:
        x, force = np.concatenate([x, x[::-1]]), np.concatenate([force, force[::-1]])
    limit = fraction * 1e-8
    clipped = np.minimum(force, limit)
    result = mdr.MeasuredCurve(force=clipped, indentation=x).mark_saturated()
    assert np.array_equal(result.force, clipped)
    saturated = force >= limit
    if fraction < 1.0:
        assert np.all(clipped[result.saturated] >= clipped.max() - 1.1e-3 * np.ptp(clipped))
        assert (
            np.count_nonzero(result.saturated) > 0.8 * np.count_nonzero(saturated)
            or np.count_nonzero(saturated) < 20
        )
    else:
        assert not result.saturated.any()


def test_a_hold_is_no_plateau_and_quantised_forces_are_no_outliers():
    hold = mdr.MeasuredCurve(
        force=np.ones(100) * 1e-9, indentation=np.full(100, 1e-6) + 1e-12 * np.arange(100)
    )
    position = np.concatenate([np.linspace(0.0, 1e-6, 400), np.full(400, 1e-6)])
    force = np.concatenate([np.linspace(0.0, 1e-9, 400), np.full(400, 1e-9)])
    curve = mdr.MeasuredCurve(force=force, indentation=position)
    assert not curve.mark_saturated().saturated.any()
    assert not hold.mark_outliers().outliers.any()
    x, force = made()
    coarse = np.round(force / 4e-10) * 4e-10
    assert np.count_nonzero(mdr.MeasuredCurve(force=coarse, indentation=x).mark_outliers().outliers) == 0


def test_every_step_is_listed_and_can_be_undone():
    x, force = made(offset=0.5, tilt=-0.2)
    record = mdr.MeasuredCurve(force=-force, travel=-x, spring_constant="0.1 N/m", time=np.arange(800.0))
    curve = record.prepare().to_indentation()
    names = ["outliers", "signs", "saturation", "baseline", "contact point", "lag"]
    assert [step.name for step in curve.steps] == names
    assert curve.original is record
    assert record.steps == ()
    for k in range(len(names)):
        assert [step.name for step in curve.steps] == names[: len(names) - k]
        assert all(str(step) in curve._repr_html_().replace("&gt;", ">") for step in curve.steps[:1])
        curve = curve.undo()
    assert curve is record
    with pytest.raises(ProblemError, match="no preparation step to undo"):
        curve.undo()


def test_a_plateau_is_seen_whatever_the_signs():
    x, force = made(offset=0.5)
    clipped = np.minimum(force, 1.1e-8)
    one, other = (
        mdr.MeasuredCurve(force=sign * clipped, indentation=sign * x).prepare() for sign in (1.0, -1.0)
    )
    assert np.array_equal(one.saturated, other.saturated)
    assert np.count_nonzero(one.saturated) > 50
    assert one.force == pytest.approx(other.force)


def test_curves_are_values():
    x, force = made()
    curve = mdr.MeasuredCurve(force=force, indentation=x, metadata=Facts({"setpoint": 2e-9})).prepare()
    again = pickle.loads(pickle.dumps(curve))
    assert again == curve
    assert hash(again) == hash(curve)
    assert curve != curve.original
    assert again.metadata == {"setpoint": 2e-9}
    with pytest.raises((AttributeError, TypeError, ValueError)):
        curve.outliers[0] = True


@settings(max_examples=examples(15), deadline=None)
@given(st.floats(-1.0, 1.5), st.integers(0, 10**6))
def test_the_lag_of_a_cantilever_is_taken_off(log_stiffness, seed):
    constant = 1e-8 / 0.5e-6 * 10.0**log_stiffness
    depth, force = made(ratio=1e5, offset=0.3, seed=seed)
    noise = force - 0.3e-8 - 1e-8 * np.clip(depth / depth[-1], 0.0, None) ** 1.5
    travel = depth + (force - 0.3e-8 - noise) / constant
    curve = mdr.MeasuredCurve(force=force, travel=travel, spring_constant=constant).prepare().to_indentation()
    point = mdr.MeasuredCurve(force=force, travel=travel, spring_constant=constant).contact_point()
    assert curve.indentation == pytest.approx(
        depth - point.value, abs=1e-4 * depth[-1] + 2e-4 * 1e-8 / constant
    )
    with pytest.raises(ProblemError, match="has its indentation"):
        curve.to_indentation()


def test_baselines_are_not_pulled_by_outliers_nor_by_adhesion():
    x, force = made(tilt=0.1, offset=1.0, ratio=1000.0)
    clean = mdr.MeasuredCurve(force=force, indentation=x).baseline()
    force[20:200:15] += 2e-9
    spiked = mdr.MeasuredCurve(force=force, indentation=x).baseline()
    assert spiked.offset == pytest.approx(clean.offset, abs=2e-11)
    pulled = np.concatenate([force, force[::-1] - np.where(np.abs(x[::-1] + 0.05e-6) < 0.05e-6, 4e-9, 0.0)])
    position = np.concatenate([x, x[::-1]])
    retreat = mdr.MeasuredCurve(force=pulled[800:], indentation=position[800:], segment="retreat")
    assert retreat.baseline().offset == pytest.approx(
        float(clean.force_at(np.array([retreat.baseline().middle]))[0]), abs=1e-10
    )


def of(force, x, **more):
    return mdr.MeasuredCurve(force=force, indentation=x, **more)


X = np.linspace(-1e-6, 1e-6, 400)
NOISE = 1e-11 * np.random.default_rng(5).normal(size=400)


@pytest.mark.parametrize(
    ("curve", "words"),
    [
        (lambda: of(NOISE, X), "shows no contact"),
        (lambda: of(2e-3 * X + 1e-9, X), "shows no contact"),
        (lambda: of(np.zeros(400), X), "shows no contact"),
        (lambda: of(NOISE + 1e-9 * np.sin(8e6 * X), X), "no contact|are before the contact"),
        (
            lambda: of(NOISE + 1.0 * np.clip(X + 0.999e-6, 0.0, None) ** 1.5, X),
            "before the contact|no contact",
        ),
        (lambda: of(NOISE, np.full(400, 1e-6)), "position is constant"),
        (lambda: of(NOISE[:15], X[:15]), "15 samples"),
        (lambda: of(NOISE, X, segment="hold"), "hold has neither"),
        (lambda: of(np.clip(X, 0, None), X, segment="retreat"), "of a retraction is not defined"),
    ],
)
def test_what_has_no_contact_is_refused(curve, words):
    with pytest.raises(ProblemError, match=words):
        curve().contact_point()


@settings(max_examples=examples(40), deadline=None)
@given(st.integers(30, 3000), st.floats(0.0, 0.98), st.integers(0, 10**6))
def test_noise_alone_is_no_contact(samples, memory, seed):
    white = np.random.default_rng(seed).normal(size=samples)
    noise = np.zeros(samples)
    for i in range(samples):  # an instrument that drifts remembers
        noise[i] = memory * (noise[i - 1] if i else 0.0) + white[i]
    assume(memory < 0.9 or samples > 300)
    with pytest.raises(ProblemError):
        of(1e-11 * noise, np.linspace(0.0, 1e-6, samples)).contact_point()


def test_bad_curves_and_steps_are_refused():
    x, force = made()
    with pytest.raises(ProblemError, match="it must be approach, hold, retreat"):
        of(force, x, segment="pause")
    with pytest.raises(ProblemError, match="800 forces, but 3 entries of outliers"):
        of(force, x, outliers=[True, False, False])
    with pytest.raises(ProblemError, match="signs cannot be determined"):
        of(np.sin(np.linspace(0, 60, 800)), x).orient()
    with pytest.raises(ProblemError, match="800 of 800 samples are marked"):
        of(force, x, saturated=np.ones(800, bool)).leave_out_marked()
    with pytest.raises(ProblemError, match="no spring constant"):
        of(force, x).recalibrate("1 N/m")
    travel = mdr.MeasuredCurve(force=force, travel=x, spring_constant="1 N/m")
    with pytest.raises(ProblemError, match="above 0 N/m"):
        travel.recalibrate("-1 N/m")
    again = travel.recalibrate("2 N/m")
    assert again.force == pytest.approx(2.0 * force)
    assert again.travel - again.force / again.spring_constant == pytest.approx(travel.depth)
    with pytest.raises(ProblemError, match="differ in spring constant"):
        travel.join(again)


@settings(max_examples=examples(50), deadline=None)
@given(
    st.integers(60, 3000),
    st.integers(0, 1500).filter(lambda n: n == 0 or n > 60),
    st.integers(60, 3000),
    st.sampled_from([0.0, 0.03]),
    st.floats(0.0, 1e-3),
    st.integers(0, 10**6),
)
def test_segments_follow_from_the_motion(going, resting, coming, creep, noise, seed):
    assume(0.05 < going / coming < 20.0)
    assume(resting == 0 or resting > 0.06 * (going + resting + coming))
    assume(min(going, coming) > 0.06 * (going + resting + coming))
    speed = 1.0 / going
    position = np.concatenate(
        [
            np.linspace(0.0, 1.0, going, endpoint=False),
            1.0 + creep * speed * np.arange(resting),
            1.0 + creep * speed * resting - speed * np.arange(coming),
        ]
    )
    position += noise * speed * np.random.default_rng(seed).normal(size=position.size)
    result = segments_in(position, np.arange(float(position.size)), None)
    names = ["approach", "hold", "retreat"] if resting else ["approach", "retreat"]
    assert [one.name for one in result] == names
    assert [one.first for one in result[1:]] == [one.end for one in result[:-1]]
    assert (result[0].first, result[-1].end) == (0, position.size)
    slack = 2 + 0.02 * position.size
    assert abs(result[0].end - going) <= slack
    assert abs(result[-1].first - going - resting) <= slack


def table(path, header, rows):
    path.write_text(header + "\n" + "\n".join(",".join(f"{v:.10g}" for v in row) for row in rows) + "\n")
    return path


def test_tables_are_read_in_segments(tmp_path):
    x, force = made()
    travel, load = np.concatenate([x, x[::-1]]) * 1e6, np.concatenate([force, force[::-1]]) * 1e9
    time = np.arange(1600) * 1e-3
    header = "time [s],load [nN],travel [um]"
    file = table(tmp_path / "curve.csv", header, zip(time, load, travel, strict=True))
    approach, retreat = mdr.read_curves(file, spring_constant="0.1 N/m")
    assert (approach.segment, retreat.segment) == ("approach", "retreat")
    assert abs(approach.force.size - 800) <= 1
    whole = approach.join(retreat)
    assert whole.step.name == "joined"
    read = read_curve(file, spring_constant="0.1 N/m")
    for name in ("force", "travel", "time"):
        assert np.array_equal(getattr(whole, name), getattr(read, name))
    with pytest.raises(ProblemError, match=r"a table with units\. The file has no spring constant; give"):
        mdr.read_curves(file)
    bad = table(tmp_path / "bad.csv", header, [(0, 1, 2), (1, math.nan, 3)])
    with pytest.raises(CaseError, match=r"line 3: load \[nN\] = 'nan'"):
        mdr.read_curves(bad, spring_constant="0.1 N/m")
    text = tmp_path / "curve.docx"
    with pytest.raises(FileError, match="No such file"):
        mdr.read_curves(text)
    text.write_text("force")
    with pytest.raises(FileError, match=r"no format of force curves ends in '\.docx'"):
        mdr.read_curves(text)


def test_without_afmformats_the_extra_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "afmformats", None)
    file = tmp_path / "curve.jpk-force"
    file.write_bytes(b"PK")
    with pytest.raises(MissingExtraError, match=r"pip install 'pymdr\[afm\]'"):
        mdr.read_curves(file)
    x, force = made()
    file = table(tmp_path / "curve.tsv", "load [N],displacement [m]", zip(force, x, strict=True))
    assert [one.segment for one in mdr.read_curves(file)] == ["approach"]


@pytest.fixture
def afmformats():
    return pytest.importorskip("afmformats", reason="afmformats, of the extra afm, is not installed")


def exported(afmformats, path, records, **metadata):
    """A file as afmformats writes it: heights fall toward the body."""
    import h5py

    facts = {"imaging mode": "force-distance", "spring constant": 0.05, "path": path, **metadata}
    with h5py.File(path, "w") as h5:
        for number, (columns, more) in enumerate(records):
            one = afmformats.AFMForceDistance(columns, {**facts, "enum": number, **more})
            one.export_data(h5, fmt="hdf5", metadata=[key for key in one.metadata if key != "path"])
    return path


def recorded(seed=0):
    x, force = made(seed=seed)
    return {
        "force": np.concatenate([force, force[::-1]]),
        "height (measured)": np.concatenate([-x, -x[::-1]]) + 5e-6,
        "segment": np.repeat(np.array([0, 1], dtype=np.uint8), 800),
        "time": np.arange(1600) * 1e-3,
    }


def test_files_of_microscopes_are_read_with_their_maps(afmformats, tmp_path):
    grid = {
        f"grid {what} {axis}": v
        for axis in "xy"
        for what, v in (("center", 0.0), ("size", 3e-6), ("shape", 3))
    }
    records = [
        (recorded(k), {**grid, "grid index x": k % 3, "grid index y": k // 3, "setpoint": 1e-8})
        for k in range(5)
    ]
    file = exported(afmformats, tmp_path / "map.h5", records)
    curves = mdr.read_curves(file)
    assert [one.segment for one in curves] == ["approach", "retreat"] * 5
    first = curves[0]
    assert first.spring_constant == 0.05
    assert np.array_equal(first.force, records[0][0]["force"][:800])
    assert first.travel == pytest.approx(-records[0][0]["height (measured)"][:800])
    assert first.metadata["setpoint"] == 1e-8
    assert first.metadata["file"] == "map.h5"
    assert str(tmp_path) not in repr(dict(first.metadata))
    approaches = curves[::2]
    shown = mdr.stack_curves(approaches, {"number": range(5)})["number"]
    assert shown.shape == (3, 3)
    assert shown.values[1, 1] == 4.0
    assert np.isnan(shown.values[2]).all()
    assert shown.x.values == pytest.approx([-1e-6, 0.0, 1e-6])
    with pytest.raises(ProblemError, match="same pixel"):
        mdr.stack_curves(curves[:2])
    with pytest.raises(ProblemError, match="1 numbers 'number' for 5 curves"):
        mdr.stack_curves(approaches, {"number": [1.0]})
    alone = mdr.stack_curves([of(*made()[::-1])], {"number": [1.0]})["number"]
    assert alone.dims == ("curve",)
    stiffer = mdr.read_curves(file, spring_constant="0.1 N/m")[0]
    assert stiffer.force == pytest.approx(2.0 * first.force)
    assert stiffer.steps[-1].name == "spring constant"


def test_tables_of_afmformats_and_tip_positions_are_read(afmformats, tmp_path):
    columns = recorded()
    columns["tip position"] = columns.pop("height (measured)")
    metadata = {
        "imaging mode": "force-distance",
        "spring constant": 0.05,
        "path": tmp_path / "a.tab",
        "enum": 0,
    }
    one = afmformats.AFMForceDistance(columns, metadata)
    one.export_data(tmp_path / "a.tab", fmt="tab")
    approach, retreat = mdr.read_curves(tmp_path / "a.tab")
    assert approach.travel is None
    assert retreat.segment == "retreat"
    assert approach.indentation == pytest.approx(-columns["tip position"][:800], rel=1e-6)


def test_files_that_are_damaged_are_refused(afmformats, tmp_path, capfd):
    columns = recorded()
    columns["force"][[7, 90]] = math.nan
    file = exported(afmformats, tmp_path / "missing.h5", [(columns, {})])
    with pytest.raises(CaseError, match=r"force\[7\] = nan, one of 2 of 1600 samples"):
        mdr.read_curves(file)
    curves = mdr.read_curves(file, leave_out_missing=True)
    assert curves[0].force.size == 798
    assert curves[0].steps[0].name == "missing"
    assert "2 of 1600" in curves[0].steps[0].description
    whole = exported(afmformats, tmp_path / "whole.h5", [(recorded(), {})])
    cut = tmp_path / "cut.h5"
    cut.write_bytes(whole.read_bytes()[:-3000])
    with pytest.raises(FileError, match="cut off"):
        mdr.read_curves(cut)
    short = exported(afmformats, tmp_path / "short.h5", [(recorded(), {"point count": 9000})])
    with pytest.raises(FileError, match="1600 of 9000 samples"):
        mdr.read_curves(short)
    (tmp_path / "empty.jpk-force").write_bytes(b"")
    with pytest.raises(CaseError, match="empty"):
        mdr.read_curves(tmp_path / "empty.jpk-force")
    (tmp_path / "no.jpk-force").write_bytes(b"PK\x03\x04 no archive")
    with pytest.raises(FileError, match="damaged"):
        mdr.read_curves(tmp_path / "no.jpk-force")
    with pytest.raises(FileError, match="No such file"):
        mdr.read_curves(tmp_path / "gone.h5")
    (tmp_path / "folder.h5").mkdir()
    with pytest.raises(FileError, match="not a folder"):
        mdr.read_curves(tmp_path / "folder.h5")
    words = tmp_path / "words.csv"
    words.write_text("no, table\n1, 2\n")
    with pytest.raises(CaseError, match="not a header of columns"):
        mdr.read_curves(words)
    assert capfd.readouterr() == ("", "")
    curve = recorded()
    curve.pop("height (measured)")
    with pytest.raises(ProblemError, match="without height of the cantilever"):
        mdr.read_curves(exported(afmformats, tmp_path / "lost.h5", [(curve, {})]))


RECORDS = {
    "fmt-jpk-cc_pr14-polymergel-2021.06.30.jpk-force": (["approach", "hold", "retreat"], -28e-6, 2e-6),
    "fmt-jpk-fd_map2x2_extracted.jpk-force-map": (["approach", "retreat"] * 4, None, None),
    "fmt-jpk-fd_spot3-0192.jpk-force": (["approach", "retreat"], -18.1e-6, 0.1e-6),
    "fmt-jpk-sr_cell1-0008.jpk-force": (["hold", "approach", "hold", "retreat"], -138e-6, 5e-6),
    "zebrafish.jpk-force": (["approach", "retreat"], -39.3e-6, 1e-6),
}


@pytest.mark.parametrize("name", RECORDS)
def test_real_records_are_read_and_prepared(afmformats, name, tmp_path, shell):
    file = AFM / name
    if not file.exists():
        pytest.skip(f"{name}, from the tests of afmformats and nanite, is not beside the repository")
    segments, place, slack = RECORDS[name]
    curves = mdr.read_curves(file)
    assert [one.segment for one in curves] == segments
    approaches = [one for one in curves if one.segment == "approach"]
    for approach in approaches:
        signs = approach.orient().step.numbers
        assert signs == {"force": 1.0, "travel": 1.0}
        curve = approach.prepare()
        assert curve.original is approach
        point = approach.contact_point()
        assert point.low < point.value < point.high
        if place is not None:
            assert abs(point.value - place) < slack
    status, out, error = shell("curves", file, "-o", tmp_path / "out")
    assert (status, error) == (0, "")
    assert all(word in out for word in ("line and power", "disagree", "baseline"))
    assert len(list((tmp_path / "out").glob("*.png"))) == len(approaches)


def test_the_shell_lists_draws_and_refuses(tmp_path, shell):
    x, force = made()
    travel, load = np.concatenate([x, x[::-1]]), np.concatenate([force, force[::-1]])
    load[300] += 1e-8
    file = table(tmp_path / "curve.csv", "load [N],travel [m]", zip(load, travel, strict=True))
    status, out, error = shell("curves", file, "--spring-constant", "0.1 N/m", "-o", tmp_path / "out")
    assert (status, error) == (0, "")
    assert "1 outlier marked" in out
    assert (tmp_path / "out" / "curve.png").stat().st_size > 10_000
    status, out, _ = shell("curves", file, "--spring-constant", "0.1 N/m", "--json")
    data = json.loads(out)
    assert (status, data["command"], data["rows"]) == (0, "curves", 1600)
    (record,) = data["curves"]
    assert set(record["contact_point"]["methods"]) == {
        "deviation",
        "gradient",
        "line and power",
        "ratio of variances",
    }
    assert record["contact_point"]["low"] < 0.0 < record["contact_point"]["high"]
    heights = table(tmp_path / "heights.csv", "load [N],travel [m]", zip(-load, -travel, strict=True))
    status, out, _ = shell("curves", heights, "--spring-constant", "0.1 N/m", "--json")
    (turned,) = json.loads(out)["curves"]
    assert [one["segment"] for one in turned["segments"]] == ["approach", "retreat"]
    for name in ("value", "low", "high"):
        assert turned["contact_point"][name] == pytest.approx(record["contact_point"][name], abs=1e-9)
    flat = table(tmp_path / "flat.csv", "load [N],travel [m]", zip(NOISE, X, strict=True))
    status, out, _ = shell("curves", flat, "--spring-constant", "0.1 N/m", "-o", tmp_path / "flat")
    assert status == 0
    assert "shows no contact" in out
    status, out, error = shell("curves", tmp_path / "gone.csv")
    assert (status, out) == (1, "")
    assert error.startswith("pymdr: cannot read")
