"""The explorer: what is chosen becomes a case, its file, its lines of Python and what is seen; without a browser."""

import asyncio
import sys
import threading
import time
import tomllib
from contextlib import suppress
from importlib.util import find_spec
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pymdr as mdr
from drawing import examples
from pymdr.explore import dropping, lessons, model, running, seen
from pymdr.workbench.casefile import case_text, read_case

QUICK = ("ball", "cone", "punch", "gel", "switch", "cycle")
panel = pytest.mark.skipif(find_spec("panel") is None, reason="panel (the extra explore) is not installed")


def evaluated(lines):
    """Contact and path of lines of Python, which are run without the solution."""
    names = {}
    exec(lines.rsplit("\nresult = ", 1)[0], names)
    return names["contact"], names["path"]


@pytest.mark.parametrize("kind", model.STARTS)
def test_case_file_and_python_lines_are_the_same_problem(kind, tmp_path):
    choice = model.start(kind)
    case = model.case_of(choice)
    assert evaluated(model.python_lines(choice)) == (case.contact, case.path)
    file = tmp_path / "case.toml"
    file.write_text(model.toml(choice), encoding="utf-8")
    read = read_case(file)
    assert (read.contact, read.path, read.options) == (case.contact, case.path, case.options)


plain_values = st.recursive(
    st.text() | st.integers(-(2**53), 2**53) | st.floats(allow_nan=False) | st.booleans(),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.from_regex("[a-z_]{1,8}", fullmatch=True), inner)
    ),
    max_leaves=6,
)


@settings(max_examples=examples(40), deadline=None)
@given(st.dictionaries(st.from_regex("[a-z_]{1,8}", fullmatch=True), plain_values, max_size=5))
def test_case_text_is_read_back(tables):
    assert tomllib.loads(case_text(tables)) == tables


@pytest.mark.parametrize("part", model.PARTS)
@pytest.mark.parametrize("start", ["ball", "gel", "rubber"])
def test_every_kind_of_every_part_is_a_case_or_says_why_not(part, start):
    choice = model.start(start)
    for kind in model.kinds(part, choice):
        changed = model.with_kind(part, kind, choice)
        assert model.kind_of(part, changed) == kind
        with suppress(mdr.PymdrError):  # never another error
            model.case_of(changed)


def test_a_profile_keeps_the_length_of_the_one_before():
    choice = model.with_kind("profile", "cone", model.start("gel"))
    assert model.with_kind("profile", "sphere", choice).tables["profile"]["radius"] == "50 µm"


@settings(max_examples=examples(40), deadline=None)
@given(st.sampled_from(tuple(model.STARTS)), st.data())
def test_knobs_go_where_they_are_dragged_and_typed(kind, data):
    choice = model.start(kind)
    knob = data.draw(st.sampled_from(model.knobs(choice)))
    to = data.draw(st.floats(0.0, 1.0))
    moved = model.dragged(choice, knob, to)
    value = model.number(moved, knob.place)
    assert knob.low - 0.01 * abs(knob.low) <= value <= knob.high + 0.01 * abs(knob.high)
    assert model.fraction(moved, knob) == pytest.approx(to, abs=0.01)
    again = model.typed(moved, knob, model.text(choice, knob))
    assert model.number(again, knob.place) == model.number(choice, knob.place)
    assert choice.tables == model.start(kind).tables  # what was chosen before is not changed


@pytest.mark.parametrize(
    "entry", ["", "ten mm", "1,5 mm", "10 N", "__import__('os')", "9**9**9 m", "nan mm", "inf m"]
)
def test_text_is_read_as_a_quantity_and_never_evaluated(entry):
    choice = model.start("ball")
    with pytest.raises(mdr.PymdrError, match="radius"):
        model.typed(choice, model.knobs(choice)[0], entry)


def test_ranges_are_relative_to_the_size():
    for size in ("1 nm", "1 mm", "1 m"):
        choice = model.typed(model.start("ball"), model.knobs(model.start("ball"))[0], size)
        knob = model.knobs(choice)[0]
        assert (knob.low, knob.high) == pytest.approx((0.1 * choice.length, 10.0 * choice.length), rel=1e-12)


@pytest.mark.parametrize("kind", QUICK)
def test_what_is_seen_is_what_the_result_says(kind):
    choice = model.start(kind)
    result = model.answer(choice)
    computed = running.look(running.Request(choice, running.View()), result, time.perf_counter())
    row = computed.row
    assert row == seen.row_of(result, -1)
    curve = computed.curve
    force = result["normal_force"].values
    factor = float(curve.traces[0].y[-1] / force[-1]) if force[-1] else 0.0
    if factor:
        np.testing.assert_allclose(curve.traces[0].y, factor * force, rtol=1e-14)
        assert np.log10(factor) % 3 == pytest.approx(0.0, abs=1e-9)  # a prefix of the unit
    assert {r[0] for r in computed.numbers} >= {"normal force", "indentation", "contact radius"}
    upper, lower = (trace.y for trace in computed.section.traces[:2])
    assert np.nanmin(upper - lower) >= -1e-9 * np.nanmax(np.abs(upper))  # the bodies do not overlap
    assert computed.fields[0] == "pressure"
    assert "nan" not in computed.curve.text


@pytest.mark.parametrize(
    ("kind", "limit"), [("cone", 0.1), ("ball", 0.1), ("gel", 0.1), ("joint", 0.1), ("tip", 0.3)]
)
def test_an_answer_takes_little_time(kind, limit):
    choice = model.start(kind)
    knob = next(k for k in model.knobs(choice) if k.place == ("body", "young"))

    def seconds(to):
        began = time.thread_time()
        moved = model.dragged(choice, knob, to)
        running.look(running.Request(moved, running.View()), model.answer(moved), time.perf_counter())
        return time.thread_time() - began

    assert min(seconds(to) for to in (0.45, 0.5, 0.55)) < limit  # the first may compile


def test_stress_is_largest_where_it_is_in_a_hertzian_contact():
    choice = model.with_kind("profile", "paraboloid", model.start("ball"))
    result = model.answer(choice)
    picture = seen.stress(result, "von_mises", -1)
    a = float(result["contact_radius"][-1])
    deep, across = np.unravel_index(np.nanargmax(picture.values), picture.values.shape)
    depth = picture.depth * deep / (picture.values.shape[0] - 1)
    assert across == picture.values.shape[1] // 2
    assert depth * 1e-6 == pytest.approx(0.48 * a, abs=0.03 * a)  # Johnson (1985), for nu = 0.3


@pytest.mark.parametrize("shape", lessons.SHAPES)
def test_more_springs_come_closer_to_the_exact_pressure(shape):
    def error(count):
        (_, _, step_3), _ = lessons.pressed_springs(shape, count, 0.6)
        springs, exact = step_3.traces
        inside = (springs.x > 0.1 * springs.x[-1]) & (springs.x < 0.8 * springs.x[-1])
        expected = np.interp(springs.x[inside], exact.x, exact.y)
        return np.max(np.abs(springs.y[inside] / expected - 1.0))

    assert error(200) < 0.5 * error(20) < 0.2


@pytest.mark.parametrize("stiffness", lessons.STIFFNESSES)
def test_the_bead_is_pulled_off_between_both_limits_of_the_machine(stiffness):
    chart, words = lessons.pulled_bead(stiffness, 2e-3, 0.0)
    pull = 1e-9 * -min(np.nanmin(trace.y) for trace in chart.traces if trace.name == "path")
    assert pull == pytest.approx(
        1.5 * np.pi * 50e-6 * 2e-3, rel=1e-3
    )  # the path passes the largest pull (JKR 1971)
    assert words.count("jumps") == 1
    off = float(words.split("Pull-off at -")[1].split(" nN")[0]) * 1e-9
    assert 5.0 / 6.0 * np.pi * 50e-6 * 2e-3 * 0.999 <= off <= pull * 1.001


def test_a_larger_move_wipes_the_memory_of_smaller_ones_out():
    def vertices(moves):
        return int(lessons.friction_memory(moves)[1].split("remembers ")[1].split()[0])

    moves = [(3e-6, 0.0), (3e-6, 0.6e-6), (3e-6, -0.3e-6), (3e-6, 0.2e-6), (3e-6, 0.0)]
    assert vertices(moves) > vertices(moves[:2])
    assert vertices([*moves, (3e-6, -2e-6)]) <= vertices([(3e-6, 0.0), (3e-6, -2e-6)])
    (_, _, loop), _ = lessons.friction_memory(moves)
    steel, ball = mdr.Elastic("210 GPa", 0.3), mdr.Paraboloid("10 mm")
    shifts = [u for _, u in moves]
    path = mdr.Path(indentation=np.full(len(moves), 3e-6), shift=np.array(shifts))
    result = mdr.solve(mdr.Contact(ball, steel, steel, friction=mdr.Coulomb(0.3)), path)
    np.testing.assert_allclose(loop.traces[0].y[1:], result["tangential_force"].values, rtol=1e-9, atol=1e-9)


TIP = b"r [nm], f [nm]\n0, 0\n20, 2.1\n40, 7.9\n60, 18.2\n80, 31.8\n100, 50.1\n"


def test_a_dropped_tip_is_the_profile():
    result = dropping.dropped("tip.csv", TIP, model.start("ball"))
    assert result.choice.tables["profile"]["kind"] == "sampled"
    assert model.case_of(result.choice).contact.profile.height[-1] == pytest.approx(50.1e-9, rel=1e-14)
    assert tomllib.loads(model.toml(result.choice))["profile"]["height"][1] == 2.1e-9
    assert evaluated(model.python_lines(result.choice))[0] == model.case_of(result.choice).contact


def test_a_dropped_force_curve_gives_its_modulus_back():
    ball = model.typed(start := model.start("gel"), model.knobs(start)[1], "30 kPa")
    ball = model.with_kind("adhesion", model.NONE, ball)
    contact = model.case_of(ball).contact
    depth = np.linspace(-1e-6, 2e-6, 61)
    force = [float(mdr.solve(contact, mdr.indent(d))["normal_force"][-1]) if d > 0.0 else 0.0 for d in depth]
    rows = "".join(f"{1e6 * d:.9f},{1e9 * f:.9f}\n" for d, f in zip(depth, force, strict=True))
    table = f"indentation [um],force [nN]\n{rows}".encode()
    result = dropping.dropped("curve.csv", table, ball)
    wrong = model.typed(ball, model.knobs(ball)[1], "10 kPa")
    fitted = dropping.fitted(wrong, result.curve, dropping.first_free(wrong))
    assert model.number(fitted.choice, ("body", "young")) == pytest.approx(30e3, rel=1e-4)
    assert {trace.name for trace in fitted.chart.traces} == {"measured", "fitted"}


def test_a_dropped_surface_is_its_mean_profile():
    x = np.linspace(-10.0, 10.0, 41)
    heights = 0.05 * (400.0 - x[:, None] ** 2 - x[None, :] ** 2)
    lines = "\n".join("\t".join(f"{z:.6f}" for z in row) for row in heights)
    text = f"# Width: 20.5 um\n# Height: 20.5 um\n# Value units: nm\n{lines}\n"
    result = dropping.dropped("bump.txt", text.encode(), model.start("ball"))
    tip = model.case_of(result.choice).contact.profile
    assert float(np.interp(5e-6, tip.radius, tip.height)) == pytest.approx(0.05e-9 * 25.0, rel=0.02)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("bad.csv", b"a,b\n1,2\n"),
        ("empty.csv", b""),
        ("noise.bin", bytes(range(256)) * 8),
        ("../../etc/passwd", b"root"),
        ("case.toml", b"profile = 1"),
        ("large.csv", b" " * (dropping.LARGEST + 1)),
    ],
)
def test_bad_files_are_refused_by_name(name, content, tmp_path):
    with pytest.raises(mdr.PymdrError) as caught:
        dropping.dropped(name, content, model.start("ball"))
    assert name in str(caught.value)
    assert str(tmp_path.parent) not in str(caught.value)


def test_cases_of_a_folder_come_first_and_invalid_ones_are_named(tmp_path):
    left_out = []
    with pytest.raises(mdr.FileError, match="no case file"):
        model.choices_of(tmp_path)
    (tmp_path / "good.toml").write_text(model.toml(model.start("cone")), encoding="utf-8")
    (tmp_path / "bad.toml").write_text("profile = 1", encoding="utf-8")
    names = list(model.choices_of(tmp_path, left_out.append))
    assert names == ["good.toml", *model.STARTS.values()]
    assert "bad.toml" in left_out[0]
    assert next(iter(model.choices_of(tmp_path / "good.toml"))) == "good.toml"
    with pytest.raises(mdr.CaseError, match=r"bad\.toml"):
        model.choices_of(tmp_path / "bad.toml")


def test_without_panel_the_extra_is_named(monkeypatch):
    from pymdr.errors import MissingExtraError
    from pymdr.workbench.cli.exploring import explore

    monkeypatch.setitem(sys.modules, "panel", None)
    with pytest.raises(MissingExtraError, match=r"pymdr\[explore\]"):
        explore()


class Shown:
    """What a runner shows, and a way to wait for it."""

    def __init__(self):
        self.answers, self.fractions, self.changed = [], [], threading.Condition()

    def show(self, answer):
        with self.changed:
            self.answers.append(answer)
            self.changed.notify()

    def wait(self, holds, seconds=60.0):
        with self.changed:
            assert self.changed.wait_for(lambda: holds(self.answers), seconds)


def test_the_last_request_is_answered_and_errors_are_shown():
    shown = Shown()
    runner = running.Runner(running.Looking(shown.show), shown.fractions.append)
    try:
        choice = model.start("ball")
        knob = model.knobs(choice)[-1]
        for i in range(20):
            moved = model.dragged(choice, knob, i / 19)
            runner.ask(running.Request(moved, running.View()))
        shown.wait(lambda answers: any(one.request.choice is moved for one in answers))
        last = next(one for one in shown.answers if one.request.choice is moved)
        assert float(last.result["normal_force"][-1]) == pytest.approx(500.0, rel=1e-12)
        wrong = model.with_kind("path", "cycle under load", choice)
        runner.ask(running.Request(wrong, running.View()))
        shown.wait(lambda answers: any(one.request.choice is wrong for one in answers))
        last = next(one for one in shown.answers if one.request.choice is wrong)
        assert last.result is None
        assert "no friction" in last.error
    finally:
        runner.close()


@panel
def test_charts_and_pictures_become_columns():
    from pymdr.explore import views

    result = model.answer(model.start("gel"))
    chart = seen.section(result, -1)
    lines, marks = views.columns_of(chart)
    assert {len(column) for column in lines.values()} == {len(chart.traces)}
    assert lines["dash"][-1] == "dashed"
    assert list(marks["x"]) == []
    columns = views.image_of(seen.stress(result, "tresca", -1))
    assert columns["dh"] == [-columns["y"][0]]
    assert views.image_of(None)["image"] == []


@panel
@pytest.mark.filterwarnings("ignore:Widget.name is deprecated:PendingDeprecationWarning")
def test_a_file_that_is_dropped_soon_after_another_is_read():
    """The browser does not take back the first file when the second one comes while it still shows the upload."""
    from pymdr.explore import files

    chosen = [model.start("ball")]
    place = files.Files(lambda: chosen[-1], chosen.append)
    try:
        for file, kind in (("a.toml", "cone"), ("b.toml", "ball"), ("a.toml", "gel"), ("b.toml", "cone")):
            content, count = model.toml(model.start(kind)), len(chosen)
            data = {"name": file, "type": "", "data": content.encode(), "chunk": 1, "total_chunks": 1}
            place._place._process_event(SimpleNamespace(event_name="upload_event", data=data))
            end = time.monotonic() + 60.0
            while len(chosen) == count:
                assert time.monotonic() < end
                time.sleep(0.01)
            assert chosen[-1].tables["profile"] == model.start(kind).tables["profile"]
    finally:
        place.close()


@panel
def test_tables_escape_what_they_show():
    from pymdr.explore import views

    table = views.numbers_html("<script>", [("<b>", "1 N", "exact", "", "'<&\"")])
    assert "<script>" not in table
    assert "<b>" not in table


@panel
@pytest.mark.filterwarnings("ignore:Widget.name is deprecated:PendingDeprecationWarning")
def test_a_notebook_shows_the_page_until_it_is_closed(tmp_path):
    from tornado.httpclient import AsyncHTTPClient, HTTPClientError

    from pymdr.explore.notebook import page

    file = tmp_path / "own.toml"
    file.write_text(model.toml(model.start("cone")), encoding="utf-8")

    async def visit():
        shown = page(file, height=700)
        try:
            frame = shown._repr_html_()
            assert f'<iframe src="{shown.address}"' in frame
            assert 'height="700"' in frame
            client = AsyncHTTPClient()
            answer = await client.fetch(shown.address)
            assert b"pymdr explore" in answer.body
            with pytest.raises(HTTPClientError, match="403"):
                await client.fetch(shown.address.split("?")[0])
        finally:
            shown.close()

    asyncio.run(visit())


@panel
@pytest.mark.parametrize("closed", [False, True])
def test_a_page_that_was_closed_is_left_alone(closed, monkeypatch):
    """A thread may finish its work after the browser has gone, when the document of the page has been destroyed."""
    from pymdr.explore import widgets

    waiting = []
    document = SimpleNamespace(
        session_context=SimpleNamespace(destroyed=closed), add_next_tick_callback=waiting.append
    )
    monkeypatch.setattr(widgets.pn, "state", SimpleNamespace(curdoc=document))

    async def served():
        call = widgets.soon()
        worker = threading.Thread(target=call, args=(waiting.append, 1))
        worker.start()
        worker.join()
        await asyncio.sleep(0)

    asyncio.run(served())
    assert len(waiting) == (0 if closed else 1)
