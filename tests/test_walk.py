"""The walk along a path: legs of all kinds, split anywhere, for every law; its rows, its progress and its refusals."""

import re
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, reject, settings
from hypothesis import strategies as st

import pymdr as mdr
from pymdr.problem.paths import NORMAL_CHANNELS, Cycle, History, Ramp, legs
from pymdr.problem.schedule import total_rows
from pymdr.rows import joined, taken
from pymdr.solving.laws import law_of
from pymdr.solving.normal import solve_normal
from pymdr.solving.walk import Task, walk
from pymdr.workbench.casefile import read_case

BODY, TIP, MACHINE = mdr.Elastic("1 MPa", 0.3), mdr.Paraboloid(1.0), 1e5
CONTACTS = {
    "normal": mdr.Contact(TIP, BODY),
    "adhesive": mdr.Contact(TIP, BODY, adhesion=mdr.JKR(50.0)),
    "frictional": mdr.Contact(TIP, BODY, friction=mdr.Coulomb(0.3)),
    "by rings": mdr.Contact(TIP, BODY),
}
VALUES = {
    "indentation": st.floats(-0.02, 0.1),
    "normal_force": st.floats(1.0, 2e4),
    "travel": st.floats(-0.02, 0.1),
    "shift": st.floats(-0.02, 0.02),
}
FEW = {"max_examples": 15, "deadline": None}


def solved(law, path, profile=TIP, **options):
    contact = replace(CONTACTS[law], profile=profile)
    if law == "by rings":
        return mdr.solve(contact, path, solver=mdr.Rings(30), **options)
    return mdr.solve(contact, path, machine_stiffness=MACHINE, **options)


def followed(law, path, **options):
    """The solution of a random path, which may pull at a body that does not touch."""
    try:
        return solved(law, path, **options)
    except mdr.PathError:
        reject()


def channels_of(law):
    """Normal and tangential channels that a law follows."""
    normal = [name for name in NORMAL_CHANNELS if law != "by rings" or name != "travel"]
    return normal, ["shift"] if law == "frictional" else []


@st.composite
def random_leg(draw, law, timed, rows=6):
    normal, tangential = channels_of(law)
    duration = draw(st.floats(0.1, 9.0)) if timed else None
    kind = draw(st.sampled_from(["ramp", "hold", "cycle"] + ([] if timed else ["path"])))
    steps = draw(st.integers(1, rows))
    if kind == "hold":
        return mdr.hold(duration, steps=steps)
    named = draw(st.lists(st.sampled_from(normal + tangential), min_size=1, max_size=1))
    if tangential and named[0] in normal and draw(st.booleans()):
        named += tangential
    if kind == "ramp":
        return mdr.ramp(**{name: draw(VALUES[name]) for name in named}, steps=steps, duration=duration)
    if kind == "cycle":
        # a force keeps pressing
        moved = {name: 0.4 if name == "normal_force" else 0.2 * draw(VALUES[name]) for name in named}
        return mdr.cycle(**moved, steps=4 * draw(st.integers(1, 2)), duration=duration)
    return mdr.Path(**{name: draw(st.lists(VALUES[name], min_size=steps, max_size=steps)) for name in named})


@st.composite
def random_path(draw, law, most=4, rows=6, timed=None):
    timed = draw(st.booleans()) if timed is None else timed
    # pressed to begin with, so that no force pulls
    first = mdr.load(draw(VALUES["normal_force"]), duration=1.0 if timed else None)
    return History((first, *draw(st.lists(random_leg(law, timed, rows), min_size=1, max_size=most))))


LAWS = pytest.mark.parametrize(
    ("law", "most", "rows"),
    [("normal", 4, 6), ("adhesive", 4, 6), ("frictional", 4, 6), ("by rings", 1, 2)],
)


def request_of(leg, channel, start):
    """The values of a channel in every row of a leg."""
    target = getattr(leg, channel, None)
    n = total_rows(leg)
    if target is None:
        return [start] * n
    if isinstance(leg, mdr.Path):
        return list(target)
    if isinstance(leg, Cycle):
        corners = np.tile([1.0, 0.0, -1.0, 0.0], leg.cycles)
        return start + target * np.interp(
            np.arange(1, n + 1) / n, np.linspace(0, 1, corners.size + 1), [0.0, *corners]
        )
    return np.linspace(start, target, n + 1)[1:]


@LAWS
@settings(**FEW)
@given(data=st.data())
def test_every_leg_starts_where_the_one_before_ended(law, most, rows, data):
    """Row by row, the prescribed channels are those of the legs read one after the other."""
    path = data.draw(random_path(law, most, rows))
    result = followed(law, path)
    assert result.data.sizes["step"] == total_rows(path)
    largest = {name: np.nanmax(np.abs(column.values)) for name, column in result.data.items()}
    length = largest["indentation"] + largest["normal_force"] / MACHINE + largest.get("shift", 0.0)
    normal, tangential = "indentation", "shift"
    here = {"indentation": 0.0, "normal_force": 0.0, "travel": 0.0, "shift": 0.0}
    done = 0
    for leg in legs(path):
        n = total_rows(leg)
        normal = next(
            (name for name in VALUES if name != "shift" and getattr(leg, name, None) is not None), normal
        )
        for channel in {normal, tangential} & {*map(str, result.data)}:
            values = result[channel].values[done : done + n]
            known = np.isfinite(values)
            expected = np.asarray(request_of(leg, channel, here[channel]), dtype=float)
            scale = largest["normal_force"] if channel == "normal_force" else length
            assert np.max(np.abs(values - expected)[known], initial=0.0) <= 1e-14 * scale
            here[channel] = float(expected[-1])
        done += n
        for name in here:
            if name in result.data and name not in (normal, tangential):
                here[name] = float(result[name].values[done - 1])


def alike(one, other, tolerance):
    assert list(one.data) == list(other.data)
    for name in one.data:
        a, b = one.data[name].values, other.data[name].values
        # energies are the smallest differences of sums
        scale = np.nanmax(np.abs(a), initial=0.0)
        np.testing.assert_allclose(b, a, rtol=0.0, atol=tolerance * scale, err_msg=str(name))


@LAWS
@settings(**FEW)
@given(data=st.data())
def test_a_longer_path_begins_with_a_shorter_one(law, most, rows, data):
    """What comes later changes nothing, and a leg may be told as two."""
    path = data.draw(random_path(law, most, rows))
    cut = data.draw(st.integers(1, len(path.legs) - 1))
    whole = followed(law, path)
    before = solved(law, History(path.legs[:cut]))
    for name in set(before.data) & set(whole.data):
        size = before.data.sizes["step"]
        np.testing.assert_array_equal(whole.data[name].values[:size], before.data[name].values)


@pytest.mark.parametrize("law", ["normal", "adhesive", "frictional"])
@settings(**FEW)
@given(data=st.data())
def test_rows_may_be_cut_into_legs_anywhere(law, data):
    normal, tangential = channels_of(law)
    channel = data.draw(st.sampled_from(normal))
    size = data.draw(st.integers(2, 12))
    columns = {
        name: np.array(data.draw(st.lists(VALUES[name], min_size=size, max_size=size)))
        for name in [channel] + (tangential if channel == "indentation" else [])
    }
    marks = sorted(data.draw(st.sets(st.integers(1, size - 1), min_size=1)))
    legs = [
        mdr.Path(time=None, **{name: values[i:j] for name, values in columns.items()})
        for i, j in zip([0, *marks], [*marks, size], strict=True)
    ]
    alike(solved(law, mdr.Path(**columns)), solved(law, History(tuple(legs))), 1e-14)


@LAWS
@settings(**FEW)
@given(data=st.data())
def test_progress_rises_to_the_total(law, most, rows, data):
    path = data.draw(random_path(law, most, rows))
    seen = []
    followed(law, path, progress=lambda done, total: seen.append((done, total)))
    total = total_rows(path)
    counted = [done for done, _ in seen]
    assert {n for _, n in seen} == {total}
    assert counted[-1] == total
    assert np.all(np.diff([0, *counted]) > 0)
    ends = np.cumsum([total_rows(leg) for leg in path.legs]).tolist()
    assert set(ends) <= set(counted)
    assert law != "by rings" or counted == list(range(1, total + 1))


def task_of(contact, path, machine=None, keep=None):
    return Task(contact, path, law_of(contact, None, path).reading, machine, keep)


@settings(**FEW)
@given(data=st.data())
def test_times_are_those_of_the_result(data):
    """A law is told when its rows are, and how long they take."""
    path = data.draw(random_path("normal", timed=True))
    reports = []

    def step(state, request, kept, watched):
        assert (kept, watched) == (None, None)
        reports.append((request.begin, request.time, request.durations))
        return request.time, state + request.durations.sum(), {}

    walked = walk(task_of(CONTACTS["normal"], path), 0.0, step)
    np.testing.assert_array_equal(walked.rows, followed("normal", path)["time"].values)
    assert [begin for begin, _, _ in reports] == [0.0, *(time[-1] for _, time, _ in reports[:-1])]
    lengths = [leg.duration for leg in path.legs]
    np.testing.assert_allclose([durations.sum() for _, _, durations in reports], lengths, rtol=1e-12)


def test_times_of_a_record():
    seen = []

    def step(state, request, kept, progress):
        seen.append((request.begin, request.time.tolist(), request.durations.tolist()))
        return request.normal, state, {}

    path = mdr.indent(1e-6, steps=2, duration=2.0) >> mdr.Path(time=[3.0, 5.0], indentation=[0.0, 1e-6])
    walk(task_of(CONTACTS["normal"], path), None, step)
    assert seen == [(0.0, [1.0, 2.0], [1.0, 1.0]), (2.0, [3.0, 5.0], [1.0, 2.0])]
    untimed = []
    walk(
        task_of(CONTACTS["normal"], mdr.indent(1e-6)),
        None,
        lambda state, request, kept, progress: (
            untimed.append((request.time, request.durations)) or request.normal,
            state,
            {},
        ),
    )
    assert untimed == [(None, None)]


# --- kept rows ------------------------------------------------------------------------------------------------


class Pair(NamedTuple):
    left: np.ndarray
    right: np.ndarray


@dataclass(frozen=True)
class Nested:
    rows: np.ndarray
    pair: Pair
    named: dict


@given(sizes=st.lists(st.integers(0, 4), min_size=1, max_size=5), keep=st.sets(st.integers(0, 3)))
def test_rows_of_any_kind_are_joined(sizes, keep):
    column = np.arange(float(sum(sizes)))

    def nested(x):
        return Nested(x, Pair(x > 1.0, np.stack([x, -x], axis=1)), {"a": x + 1.0})

    whole = joined([nested(part) for part in np.split(column, np.cumsum(sizes)[:-1])])
    index = np.array(sorted(i for i in keep if i < column.size), dtype=int)
    for one, other in ((whole, nested(column)), (taken(whole, index), nested(column[index]))):
        assert type(one.pair) is Pair
        for a, b in (
            (one.rows, other.rows),
            (one.named["a"], other.named["a"]),
            *zip(one.pair, other.pair, strict=True),
        ):
            np.testing.assert_array_equal(a, b)
    assert taken(whole, None) is whole


@settings(**FEW)
@given(data=st.data())
def test_kept_rows_of_a_law_without_memory(data):
    path = data.draw(random_path("normal"))
    total = total_rows(path)
    keep = np.array(sorted(data.draw(st.sets(st.integers(0, total - 1), min_size=1))))
    whole = followed("normal", path)
    some = solve_normal(task_of(CONTACTS["normal"], path, MACHINE, keep))
    assert list(some.data) == list(whole.data)
    for name in whole.data:
        np.testing.assert_array_equal(some.data[name].values, whole.data[name].values[keep])
    assert some.data["row"].values.tolist() == keep.tolist()


# --- refusals -------------------------------------------------------------------------------------------------

PULL = "leg {}: normal_force = -1 N: without adhesion the force cannot be below 0 N"
DEEP = "leg {}: .*indentation.* = 2 m: a sphere cannot be pressed in by its radius"
ASIDE = "leg {}: the path prescribes shift, but the contact "
BAD = {
    ("normal", "pull"): (mdr.load(-1.0, steps=3), PULL),
    ("normal", "pull in a row"): (
        mdr.Path(normal_force=[1.0, 2.0, -1.0]),
        "normal_force = -1 N in row 3 of leg {}: without adhesion",
    ),
    ("normal", "cycle"): (mdr.cycle(normal_force=9e9, steps=8), "leg {}: normal_force = -9 GN: without"),
    ("normal", "deep"): (mdr.indent(2.0, steps=2), DEEP),
    ("normal", "aside"): (mdr.shift(0.1), ASIDE + "has no friction"),
    ("adhesive", "deep"): (mdr.indent(2.0, steps=2), DEEP),
    ("adhesive", "aside"): (mdr.shift(0.1), ASIDE + "is adhesive"),
    ("frictional", "pull"): (mdr.load(-1.0, steps=3), PULL),
    ("frictional", "deep"): (mdr.indent(2.0, steps=2), DEEP),
    ("frictional", "deep aside"): (mdr.ramp(indentation=2.0, shift=1.0), DEEP),
    ("frictional", "drag"): (
        mdr.drag(1e9, steps=3),
        "tangential_force = .* in row 1 of leg {}: friction carries",
    ),
    ("by rings", "pull"): (mdr.load(-1.0), PULL),
    ("by rings", "aside"): (mdr.shift(0.1), ASIDE + "has no friction"),
}
GOOD = [mdr.indent(0.01), mdr.Path(indentation=[0.02, 0.01]), mdr.hold(), mdr.load(3.0, steps=2)]


@pytest.mark.parametrize(("law", "what"), BAD)
@settings(max_examples=8, deadline=None)
@given(
    before=st.lists(st.sampled_from(GOOD[:3]), max_size=2), after=st.lists(st.sampled_from(GOOD), max_size=2)
)
def test_refusals_name_their_leg(law, what, before, after):
    """Once, counted from one; of a path of one leg there is nothing to name but a row."""
    bad, words = BAD[law, what]
    # rings take their time
    path = History((*before[: 1 if law == "by rings" else 2], bad, *after))
    with pytest.raises(mdr.PathError) as refused:
        solved(law, path, mdr.Sphere(1.0))
    text = str(refused.value)
    if len(path.legs) == 1:
        words = words.removeprefix("leg {}: ")
    assert re.match(words.format(len(path.legs) - len(after)), text)
    assert len(re.findall(r"\bleg \d", text)) == ("leg" in words)


def test_a_body_out_of_contact_has_no_position():
    path = mdr.indent(0.01) >> mdr.load(-1e9) >> mdr.indent(0.0)
    with pytest.raises(mdr.PathError, match=r"^leg 3: the contact was lost under a prescribed force"):
        solved("adhesive", path)
    assert solved("adhesive", mdr.indent(0.01) >> mdr.load(-1e9) >> mdr.hold() >> mdr.load(-2.0)).status.name


def test_forces_may_cycle_down_first():
    """An amplitude below 0 is no force below 0."""
    down = solved("normal", mdr.load(5.0) >> mdr.cycle(normal_force=-1.0, steps=4))
    assert down["normal_force"].values.tolist() == [5.0, 4.0, 5.0, 6.0, 5.0]
    with pytest.raises(mdr.PathError, match=r"^leg 2: normal_force = -1 N: without adhesion"):
        solved("normal", mdr.load(5.0) >> mdr.cycle(normal_force=-6.0, steps=4))


# --- rates ----------------------------------------------------------------------------------------------------


@settings(**FEW)
@given(
    depths=st.lists(st.integers(1, 50).map(lambda i: i / 100), min_size=1, max_size=4, unique=True),
    rate=st.floats(1e-2, 1e2),
    wait=st.floats(1e-2, 1e2),
)
def test_a_rate_is_the_speed_of_the_leg(depths, rate, wait):
    """Whatever the start is: the slope of the column over time."""
    path = mdr.indent(depths[0], rate=rate, steps=3)
    for d in depths[1:]:
        path = path >> mdr.hold(wait) >> mdr.indent(d, rate=rate, steps=2)
    force = float(mdr.solve(CONTACTS["normal"], path)["normal_force"][-1])
    path = path >> mdr.load(2.0 * force + 1.0, rate=rate, steps=2)
    result = mdr.solve(CONTACTS["normal"], path)
    time, d = (np.append(0.0, result[name].values) for name in ("time", "indentation"))
    speeds = np.abs(np.diff(d[:-2])) / np.diff(time[:-2])
    np.testing.assert_allclose(speeds[speeds > 0.0], rate, rtol=1e-9)
    assert (force + 1.0) / (time[-1] - time[-3]) == pytest.approx(rate, rel=1e-9)
    assert any("times of the path have no effect" in note for note in result.notes)


@pytest.mark.parametrize(
    ("leg", "words"),
    [
        (lambda: mdr.indent(1.0, rate="1 N/s"), "moves in m/s"),
        (lambda: mdr.load(1.0, rate="1 m/s"), "moves in N/s"),
        (lambda: mdr.indent(1.0, rate=1.0, duration=1.0), "either duration or rate"),
        (lambda: mdr.indent(1.0, rate=-1.0), "above 0 m/s"),
        (lambda: mdr.load(1.0, rate="-1 N/s"), "above 0 N/s"),
        (lambda: Ramp(indentation=1.0, shift=1.0, rate=1.0), "a rate needs a single moving channel"),
    ],
)
def test_rates_that_say_nothing(leg, words):
    with pytest.raises(mdr.PymdrError, match=words):
        leg()


def test_a_leg_that_goes_nowhere_takes_no_time():
    path = mdr.indent(0.1, rate=1.0) >> mdr.indent(0.1, rate=1.0)
    with pytest.raises(mdr.PymdrError, match=r"leg 2: .* a rate gives no duration"):
        mdr.solve(CONTACTS["normal"], path)


# --- refusals name legs and files ---------------------------------------------------------------------------


def _drawn_leg(rng, timed):
    duration = "2 s" if timed else None
    kind = rng.integers(4)
    if kind == 0:
        return mdr.hold("1 s") if timed else mdr.hold(steps=2)
    if kind == 1:
        return mdr.cycle(indentation="1 nm", duration=duration)
    if kind == 2:
        return mdr.Path(time=[1.0] if timed else None, indentation=[1e-6])
    return mdr.indent("1 um", rate="1 um/s") if timed else mdr.indent("1 um")


@pytest.mark.parametrize("seed", range(20))
def test_legs_with_and_without_a_time_are_numbered(seed):
    rng = np.random.default_rng(seed)
    timed = rng.permutation([True, False, *(rng.random(int(rng.integers(3))) < 0.5)])
    path = History(tuple(_drawn_leg(rng, bool(one)) for one in timed))
    with pytest.raises(mdr.PathError) as refusal:
        mdr.solve(mdr.Contact(mdr.Sphere("1 mm"), mdr.Elastic("1 MPa", 0.5)), path)
    without, with_time = (
        set(map(int, re.findall(r"\d+", part))) for part in str(refusal.value).split(":")[0].split("no time")
    )
    assert without == set((np.flatnonzero(~timed) + 1).tolist())
    assert with_time == set((np.flatnonzero(timed) + 1).tolist())


CASE = (
    '[profile]\nkind = "sphere"\nradius = "1 mm"\n[body]\nkind = "elastic"\nyoung = "1 MPa"\npoisson = 0.5\n'
)
LEG = '[[path]]\nkind = "ramp"\nindentation = "1 um"\n'


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ('[[path]]\nkind = "path"\nfile = "good.csv"\n' + LEG, ["leg 2 has no time, but leg 1 has"]),
        (LEG + '[[path]]\nkind = "path"\nfile = "back.csv"\n', ["[path 2]", "back.csv: time must rise"]),
    ],
)
def test_refusals_of_a_case_name_its_file(tmp_path, path, words):
    (tmp_path / "good.csv").write_text("time [s], d [um]\n1,1\n2,2\n")
    (tmp_path / "back.csv").write_text("time [s], d [um]\n1,1\n0.5,2\n")
    (tmp_path / "case.toml").write_text(CASE + path)
    with pytest.raises(mdr.CaseError) as refusal:
        read_case(tmp_path / "case.toml")
    for word in ("case.toml", *words):
        assert word in str(refusal.value)


@pytest.mark.parametrize(
    ("path", "words"),
    [
        (mdr.indent("1 um") >> mdr.travel("1 um"), "leg 2 prescribes travel"),
        (
            mdr.load("1 N", duration="1 s") >> mdr.load("1 N", rate="1 N/s"),
            "leg 2: the start equals the target, normal_force = 1 N",
        ),
        (mdr.indent("1 um", duration=3.0) >> mdr.Path(time=[2.0], shift=[0.0]), "leg 2: time begins"),
    ],
)
def test_refusals_of_a_path_number_the_leg(path, words):
    contact = mdr.Contact(mdr.Sphere("1 mm"), mdr.Elastic("1 MPa", 0.5), friction=mdr.Coulomb(0.3))
    with pytest.raises(mdr.PathError) as refusal:
        mdr.solve(contact, path)
    assert str(refusal.value).startswith(words)


def test_what_is_no_leg_is_numbered():
    with pytest.raises(mdr.PathError, match="leg 2 is 'hold'; every entry must be a leg"):
        History((mdr.hold(steps=1), "hold"))
