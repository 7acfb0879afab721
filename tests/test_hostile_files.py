"""Case files, tables and saved results that are broken by chance or on purpose: refused in one line, or right."""

import contextlib
import json
import math
import os
import re
import string
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import pymdr as mdr
from drawing import examples
from pymdr.errors import FileError, PymdrError
from pymdr.problem.codec import decode_case, decode_machine, decode_press, decode_rough
from pymdr.solving.reopening import result_from_dataset
from pymdr.solving.workers import KeptParts
from pymdr.workbench.casefile import read_case, read_rough_case
from pymdr.workbench.cli.starting import kinds_starting
from pymdr.workbench.inputs import printable
from pymdr.workbench.templates import KINDS, template

SLOW = settings(max_examples=examples(60), deadline=None, suppress_health_check=list(HealthCheck))
ESCAPE = "\x1b]0;title\x07\x1b[2J"
SECRET = "root:$6$salt$abcdef:19000:0:99999:7:::"


def plain(text: str) -> bool:
    """Whether no character of a text steers a terminal."""
    return all(c.isprintable() or c == "\n" for c in text)


# --- case files ------------------------------------------------------------------------------------------

VALUES = st.one_of(
    st.sampled_from(
        [
            "1" * 5000,
            "-" + "9" * 400,
            "1e308",
            "5e-324",
            "4e10",
            "40000000000",
            "1" + "0" * 30,
            "true",
            "nan",
            "-inf",
            "[" * 3000 + "]" * 3000,
            "[" * 60 + "]" * 60,
            "{ kind = { kind = { } } }",
            "[1, 2]",
            "[]",
            "[[]]",
            '["1 mm", "2 mm"]',
            '"[/bold] mm"',
            '"[red]x"',
            '"70 deg"',
            '"1e400 m"',
            '"\\u0000"',
            '"\\u001b[2J"',
            '"\\u202e"',
            '""',
            "1979-05-27",
            '"' + "x" * 5000 + '"',
        ]
    ),
    st.integers().map(str),
    st.floats().map(lambda x: repr(x) if np.isfinite(x) else "inf"),
    st.text(string.printable, max_size=20).map(json.dumps),
)


@SLOW
@given(kind=st.sampled_from(KINDS), pick=st.integers(0, 10**6), value=VALUES)
def test_any_value_in_any_place_of_a_case_is_read_or_refused(tmp_path, kind, pick, value):
    lines = template(kind).splitlines()
    places = [i for i, line in enumerate(lines) if " = " in line and not line.startswith("#")]
    i = places[pick % len(places)]
    lines[i] = f"{lines[i].partition(' = ')[0]} = {value}"
    file = tmp_path / "case.toml"
    file.write_text("\n".join(lines), encoding="utf-8")
    text = ""
    try:
        if kind == "rough":
            read_rough_case(file)
            return
        request = read_case(file)
        mdr.assess(request.contact, request.path, **request.options)
    except PymdrError as error:
        text = str(error)
    assert len(text) < 2000
    for word in ("pydantic", "Traceback", "tagged-union", "input should", "valid integer"):
        assert word not in text


@SLOW
@given(content=st.one_of(st.binary(max_size=200), st.text(max_size=200).map(str.encode)))
def test_any_bytes_are_a_case_or_none(tmp_path, content):
    file = tmp_path / "case.toml"
    file.write_bytes(content)
    with pytest.raises(PymdrError):
        read_case(file)


def test_a_byte_order_mark_is_no_part_of_a_case(tmp_path):
    file = tmp_path / "case.toml"
    file.write_text(template("ball"), encoding="utf-8-sig")
    assert read_case(file).contact.profile == mdr.Sphere("10 mm")


def test_what_is_printed_steers_no_terminal(tmp_path, shell):
    text = template("ball")
    hostile = json.dumps(ESCAPE)
    for old, new in (
        ('title = "My ball"', f"title = {hostile}"),
        ('radius = "10 mm"', f"radius = {hostile}"),
        ('young = "210 GPa"', 'young = "[/bold] GPa"'),
        ('kind = "sphere" ', 'kind = "[profile]" '),
        ("[counterbody]", f"[{hostile}]"),
    ):
        assert old in text
        good, bad = tmp_path / "good.toml", tmp_path / "bad.toml"
        good.write_text(text, encoding="utf-8")
        bad.write_text(text.replace(old, new), encoding="utf-8")
        for arguments in (("check", bad), ("run", good, bad, "-o", tmp_path / "out")):
            _, out, err = shell(*arguments)
            assert plain(out)
            assert plain(err)
            assert "Traceback" not in err
    # the last of them has an unknown table, which the list of failures names whole
    bad.write_text(text.replace('"210 GPa"', '"[/bold] GPa"'), encoding="utf-8")
    _, _, err = shell("run", good, bad, "-o", tmp_path / "out")
    assert "[body]" in err.replace("\n", "")
    assert "[/bold]" in err.replace("\n", "")


@settings(deadline=None)
@given(st.text(max_size=50))
def test_printable_texts_keep_what_can_be_read(text):
    assert plain(printable(text))
    if plain(text):
        assert printable(text) == text


# --- folders ---------------------------------------------------------------------------------------------


@SLOW
@given(
    st.lists(
        st.tuples(*[st.sampled_from("ab")] * 2, st.sampled_from(["x.toml", "y.toml"])), min_size=2, max_size=5
    )
)
def test_no_two_cases_are_written_into_one_folder(tmp_path, parts):
    from pymdr.workbench.cli.folders import folders_of

    cases = [tmp_path.joinpath(*p) for p in parts]
    for output in (tmp_path / "out", None):
        try:
            folders = folders_of(cases, output)
        except mdr.CaseError:
            assert len(set(cases)) < len(cases)
        else:
            assert len(set(folders.values())) == len(set(cases)) == len(cases)


def test_cases_of_one_name_keep_their_results(tmp_path, shell):
    for folder, radius in (("a", "10 mm"), ("b", "20 mm")):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "case.toml").write_text(template("ball").replace("10 mm", radius))
    out = tmp_path / "out"
    status, _, _ = shell("run", tmp_path / "a/case.toml", tmp_path / "b/case.toml", "-o", out, "-q")
    assert status == 0
    for folder, radius in (("a", "10 mm"), ("b", "20 mm")):
        result = mdr.open_result(out / folder / "case" / "result.nc")
        assert result.contact.profile == mdr.Sphere(radius)
    status, _, err = shell("run", tmp_path / "a/case.toml", tmp_path / "a/case.toml", "-q")
    assert status == 1
    assert "each case once" in err


# --- files that a case names -----------------------------------------------------------------------------


def tip_from(file: str) -> str:
    lines = template("tip").splitlines()
    kept = [line for line in lines if not line.startswith(("radius", "height", "# file"))]
    kept.insert(kept.index('kind = "sampled"') + 1, f"file = {json.dumps(file)}")
    return "\n".join(kept)


def record_from(file: str) -> str:
    head = template("ball").partition("[[path]]")[0]
    return f'{head}[[path]]\nkind = "path"\nfile = {json.dumps(file)}\n'


@pytest.mark.parametrize("case_from", [tip_from, record_from])
def test_only_regular_files_are_read_and_none_is_read_aloud(tmp_path, shell, case_from):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "secret").write_text(f"{SECRET}\nsecond,line\n")
    (tmp_path / "commas").write_text(f"{SECRET},{SECRET}\n{SECRET},{SECRET}\n")
    (tmp_path / "folder").mkdir()
    case = tmp_path / "case.toml"
    for name, words in (
        ("/dev/zero", "regular file"),
        (str(tmp_path / "pipe"), "regular file"),
        ("folder", ""),
        ("", "name of a CSV file"),
        ("a\0b", "NUL"),
        ("secret", "not a header"),
        ("commas", "not a header"),
        ("case.toml", ""),
    ):
        case.write_text(case_from(name), encoding="utf-8")
        status, out, err = shell("check", case)
        assert (status, out) == (1, "")
        assert words in err
        assert "salt" not in err
        assert err.count("\n") == 1


def test_a_huge_sparse_file_is_refused_at_once(tmp_path, shell):
    with (tmp_path / "huge.csv").open("wb") as opened:
        opened.truncate(10**12)
    case = tmp_path / "case.toml"
    case.write_text(tip_from("huge.csv"))
    status, _, err = shell("check", case)
    assert status == 1
    assert "larger than" in err


@SLOW
@given(content=st.one_of(st.binary(max_size=100), st.text(string.printable, max_size=100).map(str.encode)))
def test_any_table_is_read_or_refused(tmp_path, content):
    for head in (b"", b"r [nm],f [nm]\n", b"time [s],load [N]\n"):
        (tmp_path / "t.csv").write_bytes(head + content)
        for read in (mdr.read_profile, mdr.read_path, mdr.read_record):
            with contextlib.suppress(PymdrError):
                read(tmp_path / "t.csv")


# --- saved results ---------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    file = tmp_path_factory.mktemp("saved") / "r.nc"
    joint = mdr.Contact(
        mdr.Paraboloid("10 mm"),
        mdr.Elastic("1 GPa", 0.3),
        mdr.Elastic("1 GPa", 0.3),
        friction=mdr.Coulomb(0.3),
    )
    result = mdr.solve(joint, mdr.load("1 N", steps=3) >> mdr.cycle(shift="1 um", steps=8))
    result.save(file)
    return file, result


@settings(max_examples=examples(150), deadline=None, suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_a_flipped_bit_is_noticed(saved, tmp_path, data):
    file, _ = saved
    content = bytearray(file.read_bytes())
    flips = data.draw(st.sets(st.integers(0, 8 * len(content) - 1), min_size=1, max_size=3))
    for bit in flips:
        content[bit // 8] ^= 1 << (bit % 8)
    (tmp_path / "flipped.nc").write_bytes(content)
    with pytest.raises(mdr.FileError):
        mdr.open_result(tmp_path / "flipped.nc")


@settings(max_examples=examples(60), deadline=None, suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_a_file_that_was_cut_off_is_noticed(saved, tmp_path, data):
    content = saved[0].read_bytes()
    (tmp_path / "cut.nc").write_bytes(content[: data.draw(st.integers(0, len(content) - 1))])
    with pytest.raises(mdr.FileError):
        mdr.open_result(tmp_path / "cut.nc")


def test_what_another_program_wrote_has_no_checksum(saved, tmp_path):
    file, result = saved
    result.to_dataset().to_netcdf(tmp_path / "other.nc", engine="h5netcdf")
    assert np.array_equal(mdr.open_result(tmp_path / "other.nc")["shift"], result["shift"])
    import xarray as xr

    xr.load_dataset(file, engine="h5netcdf").to_netcdf(tmp_path / "again.nc", engine="h5netcdf")
    with pytest.raises(mdr.FileError, match="checksum is missing"):
        mdr.open_result(tmp_path / "again.nc")


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=8,
)
TEXTS = (
    "claims",
    "assumptions",
    "notes",
    "references",
    "rings",
    "machine_stiffness",
    "starts",
    "case",
    "status",
)


@settings(max_examples=examples(200), deadline=None, suppress_health_check=list(HealthCheck))
@given(data=st.data(), name=st.sampled_from(TEXTS))
def test_results_made_by_hand_are_whole_or_refused(saved, data, name):
    packed = saved[1].to_dataset()
    text = packed.attrs[f"pymdr_{name}"]
    if name == "status" or data.draw(st.booleans()):
        new = json.dumps(data.draw(JSON))
    else:
        whole = json.loads(text)
        table = whole
        while isinstance(table, dict | list) and table and data.draw(st.integers(0, 3)) > 0:
            key = data.draw(st.sampled_from(sorted(table) if isinstance(table, dict) else range(len(table))))
            if not isinstance(table[key], dict | list) or not table[key]:
                break
            table = table[key]
        if isinstance(table, dict | list) and table:
            key = data.draw(st.sampled_from(sorted(table) if isinstance(table, dict) else range(len(table))))
            table[key] = data.draw(JSON)
        new = json.dumps(whole)
    try:
        result = result_from_dataset(packed.assign_attrs({f"pymdr_{name}": new}))
    except mdr.FileError:
        return
    result.summary()
    result._repr_html_()
    result.cite()


@pytest.mark.parametrize("kind", sorted({*KINDS} - {"tip", "rough", "press", "machine"}))
def test_every_other_template_runs_as_written(tmp_path, shell, kind):
    file = tmp_path / "case.toml"
    assert shell("new", kind, "-o", file)[0] == 0
    status, out, _ = shell("run", file, "-o", tmp_path / "out", "--no-figures")
    assert status == 0
    assert f"My {kind}" in out
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["result.nc"]


def test_every_template_runs_as_written(tmp_path, shell):
    for kind in KINDS:
        assert tomllib.loads(template(kind))["title"] == f"My {kind}"
        assert kinds_starting(kind[:3]) == [kind]
    file = tmp_path / "tip.toml"
    assert shell("new", "tip", "-o", file)[0] == 0
    status, out, err = shell("run", file)
    assert (status, err) == (0, "")
    assert "My tip" in out


def keys_of(value, place=()):
    """The places of all values of a case."""
    inner = value.items() if isinstance(value, dict) else enumerate(value) if is_tables(value) else ()
    for key, part in inner:
        yield from keys_of(part, (*place, key))
    if not isinstance(value, dict) and not is_tables(value):
        yield place


def is_tables(value):
    return isinstance(value, list) and bool(value) and isinstance(value[0], dict)


PLACES = [(kind, place) for kind in KINDS for place in keys_of(tomllib.loads(template(kind)))]
DECODERS = {"rough": decode_rough, "press": decode_press, "machine": decode_machine}


@settings(max_examples=examples(60), deadline=None)
@given(st.sampled_from(PLACES), st.sampled_from([{"a": 1}, [{"a": [1]}], math.nan, "rubbish", None]))
def test_one_wrong_value_anywhere_has_one_complaint_that_names_its_key(at, wrong):
    """None stands for a misspelt key beside it; any text is a title or a name."""
    kind, (*outer, key) = at
    case = tomllib.loads(template(kind))
    table = case
    for part in outer:
        table = table[part]
    if wrong is None:
        key, wrong = "zzz", 1
    elif wrong == "rubbish" and key in ("title", "name"):
        wrong = 3.5
    table[key] = wrong
    with pytest.raises(mdr.CaseError) as refused:
        DECODERS.get(kind, decode_case)(case)
    message = str(refused.value)
    where, _, rest = message.rpartition("] ")
    assert re.match(rf"(entry 1 of )?{key}\b", rest), message
    assert "; [" not in message
    for part in outer:
        assert re.search(rf"\b{part + 1 if isinstance(part, int) else part}\b", where), message


def test_a_contact_refused_at_every_row_is_summarised_saved_and_read(tmp_path):
    """An adhesive wave that first touches on a ring: no quantity is given at any row."""
    wavy = mdr.Function(
        lambda r: r**2 / 2e-3 + 4e-7 * (1.0 - np.cos(2.5e5 * r)),
        derivative=lambda r: r / 1e-3 + 0.1 * np.sin(2.5e5 * r),
    )
    contact = mdr.Contact(wavy, mdr.Elastic("1 MPa", 0.5), adhesion=mdr.JKR("10 mJ/m^2"))
    for path in (mdr.indent("4 um", steps=3), mdr.indent("4 um", steps=2) >> mdr.load("1 uN", steps=3)):
        result = mdr.solve(contact, path)
        assert result.status in (mdr.Status.ADHESION_REFUSED, mdr.Status.ADHESION_PARTLY_REFUSED)
        result.save(tmp_path / "r.nc")
        result.to_csv(tmp_path / "r.csv")
        again = mdr.open_result(tmp_path / "r.nc")
        rows = result.claims["pressure"].where.size
        for one in (result, again):
            assert f"{rows} steps" in repr(one)
            assert one.status.name in str(one)
            assert one.status.name in one._repr_html_()
            assert one.to_dataframe().shape[0] == rows
            assert "section" in one.figures()


def test_what_a_terminal_cannot_write_is_written_out(tmp_path):
    import subprocess
    import sys

    case = tmp_path / "case.toml"
    case.write_text(template("ball").replace("My ball", "Ø 10 mm, µ"), encoding="utf-8")
    for text, status, words in ((None, 0, b"\\xd8 10 mm"), ("5 Ωm", 1, b"\\u03a9")):
        if text is not None:
            case.write_text(template("ball").replace("10 mm", text), encoding="utf-8")
        done = subprocess.run(
            [sys.executable, "-m", "pymdr", "check", str(case)],
            env={**os.environ, "PYTHONIOENCODING": "ascii"},
            capture_output=True,
        )
        assert done.returncode == status
        assert words in done.stdout + done.stderr
        assert b"Traceback" not in done.stderr


# --- options ---------------------------------------------------------------------------------------------

QUESTIONS = {
    "check": ("joint",),
    "law": ("joint", "--to", "1 um", "-o", "out"),
    "impact": ("joint", "--mass", "1 g", "--speed", "1 m/s"),
    "rolling": ("joint", "--creepage", "0.001", "--normal-force", "1 N"),
    "rough": ("rough", "--normal-force", "1 N", "--realisations", "1"),
    "sweep": ("ball", "--over", "body.young = 1 GPa, 2 GPa"),
    "sliding": ("ball", "--speed", "1 m/s", "--normal-force", "1 N"),
    "heat": ("joint", "--speed", "1 m/s", "--normal-force", "1 N"),
}
TEXTS = st.one_of(
    st.sampled_from(
        [
            "",
            "0",
            "-1",
            "nan",
            "inf",
            "1e400",
            "9" * 400,
            "1 N",
            "-1 m",
            "0 m/s",
            "[/bold] mm",
            "\x1b[2J",
            "a=b",
            "= =",
            "body.young = ",
            "body.young = 1 GPa, 1e400 GPa",
            "5e-324 m",
            "1e308 N",
            "{0}",
            "%s",
            "../x",
            "--",
        ]
    ),
    st.text(string.printable, max_size=12),
)


@SLOW
@given(data=st.data())
def test_any_text_in_any_option_is_taken_or_refused(tmp_path, shell, data):
    """A command ends with its status; what is refused is one line that steers no terminal, and JSON says the same."""
    import typer

    from pymdr.workbench.cli import app

    for kind in ("joint", "rough", "ball"):
        (tmp_path / f"{kind}.toml").write_text(template(kind), encoding="utf-8")
    command = data.draw(st.sampled_from(list(QUESTIONS)))
    kind, *rest = QUESTIONS[command]
    options = [
        option.opts[0]
        for option in typer.main.get_command(app).commands[command].params
        if option.param_type_name == "option"
        and not option.is_flag
        and not {"--output", "--workers"} & set(option.opts)
    ]
    more = [data.draw(st.sampled_from(options)), data.draw(TEXTS)] if options else []
    rest = [str(tmp_path / "out") if one == "out" else one for one in rest]
    status, out, err = shell(command, tmp_path / f"{kind}.toml", *rest, *more, "--json")
    assert status in (0, 1, 2, 3)
    if status == 2 or "--" in more:
        return
    answer = json.loads(out, parse_constant=lambda name: pytest.fail(f"JSON has no {name}"))
    assert (answer["error"] is None) == (status == 0)
    if status:
        assert err.startswith("pymdr: ")
        assert err.count("\n") == 1
        assert plain(err)


@pytest.mark.parametrize("url", ["s3://bucket/out", "memory://out", "https://host/out.nc", "file:///out"])
def test_a_url_is_refused_where_only_files_are_written(url, tmp_path, monkeypatch, shell):
    monkeypatch.chdir(tmp_path)
    ball = mdr.Contact(mdr.Paraboloid("1 mm"), mdr.Elastic("1 MPa", 0.5))
    press, over = mdr.indent("1 um"), {"profile.radius": [1e-3, 2e-3]}
    # a Path keeps one slash of two
    for place in (url, Path(url)):
        for write in (
            lambda p: mdr.sweep(ball, press, over, folder=p),
            lambda p: KeptParts(p, {}),  # the argument keep
            mdr.solve(ball, press).save,
        ):
            with pytest.raises(FileError, match="only fit_map reads a URL"):
                write(place)
    case = tmp_path / "case.toml"
    case.write_text(template("ball"))
    status, out, err = shell("run", case, "-o", url)
    assert (status, out) == (1, "")
    assert "a URL" in err
    assert [file.name for file in tmp_path.iterdir()] == ["case.toml"]


def test_a_rough_calibration_keeps_nothing_at_a_url(tmp_path, monkeypatch):
    pytest.importorskip("ContactMechanics")
    monkeypatch.chdir(tmp_path)
    surface = mdr.RoughSurface(hurst=0.8, rms="1 um", size="1 mm", shortest="125 um")
    with pytest.raises(FileError, match="a URL"):
        mdr.calibrate_coefficient(surface, realisations=1, keep="s3://bucket/out")
    assert not list(tmp_path.iterdir())
