"""Tables for people: what is written is read back, by our own readers and by those of spreadsheets."""

import math
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pymdr as mdr
from common import BALL_CASE
from drawing import examples
from pymdr.errors import MissingExtraError
from pymdr.presentation.tables import write_csv, write_xlsx

openpyxl = pytest.importorskip("openpyxl", reason="openpyxl, of the extra xlsx, is not installed")

BALL = mdr.Contact(mdr.Sphere("10 mm"), mdr.Elastic("210 GPa", 0.3), friction=mdr.Coulomb(0.3))
GEL = mdr.Contact(mdr.Paraboloid("1 mm"), mdr.Elastic("30 kPa", 0.5), adhesion=mdr.JKR("50 mJ/m^2"))


@pytest.fixture(scope="module")
def result():
    return mdr.solve(BALL, mdr.load("50 N", steps=5) >> mdr.shift("0.5 um", steps=5))


@pytest.fixture(scope="module")
def pulled():
    """Values that are not known: where a body is that a dead load has torn off."""
    return mdr.solve(GEL, mdr.load("0.1 mN", steps=3) >> mdr.load("-1 mN", steps=9))


def sheets(file):
    """Titles and columns of the first sheet, and the rows of the second."""
    book = openpyxl.load_workbook(file)
    assert book.sheetnames == ["table", "about"]
    head, *rows = book["table"].iter_rows(values_only=True)
    kinds, *about = book["about"].iter_rows(values_only=True)
    assert kinds == ("kind", "name", "text")
    return dict(zip(head, zip(*rows, strict=True), strict=True)), about


def test_a_spreadsheet_holds_the_numbers_and_what_they_rest_on(result, tmp_path):
    result.to_xlsx(tmp_path / "ball.xlsx", units={"normal_force": "mN"})
    columns, about = sheets(tmp_path / "ball.xlsx")
    assert columns["step"] == tuple(range(10))
    # a sheet keeps 16 digits
    assert columns["indentation [m]"] == pytest.approx(result["indentation"].values, rel=1e-15)
    assert columns["normal_force [mN]"] == pytest.approx(1e3 * result["normal_force"].values, rel=1e-15)
    kinds = {kind for kind, _, _ in about}
    assert kinds >= {
        "version",
        "profile",
        "body",
        "friction",
        "status",
        "path",
        "claim",
        "assumption",
        "cite",
    }
    claimed = {name: words for kind, name, words in about if kind == "claim"}
    assert set(claimed) == set(result.claims)
    for name, claim in result.claims.items():
        assert claimed[name].startswith(claim.level.name)
        assert claim.reason in claimed[name]


def test_what_is_not_known_is_an_empty_cell(pulled, tmp_path):
    pulled.to_xlsx(tmp_path / "pulled.xlsx")
    pulled.to_csv(tmp_path / "pulled.csv")
    columns, _ = sheets(tmp_path / "pulled.xlsx")
    depth = pulled["indentation"].values
    assert np.isnan(depth).any()
    assert [value is None for value in columns["indentation [m]"]] == np.isnan(depth).tolist()
    with pytest.raises(mdr.CaseError, match="delete rows without data"):
        mdr.read_record(tmp_path / "pulled.csv")


@settings(max_examples=examples(40), deadline=None)
@given(
    units=st.fixed_dictionaries(
        {},
        optional={
            "indentation": st.sampled_from(["nm", "um", "mm"]),
            "normal_force": st.sampled_from(["uN", "kN"]),
        },
    ),
    about=st.booleans(),
    top=st.floats(-9, 0).map(lambda x: 10.0**x),
    steps=st.integers(2, 20),
)
def test_paths_and_curves_are_read_back(tmp_path_factory, units, about, top, steps):
    ball = mdr.Contact(mdr.Sphere(10.0 * top), mdr.Elastic("1 GPa", 0.3))
    result = mdr.solve(ball, mdr.indent(top, steps=steps))
    file = tmp_path_factory.mktemp("t") / "ball.csv"
    result.to_csv(file, units=units, about=about)
    path = mdr.read_path(file, channels=["indentation"])
    assert path.indentation == pytest.approx(result["indentation"].values, rel=4e-15)
    again = mdr.solve(ball, path)
    assert again["normal_force"].values == pytest.approx(result["normal_force"].values, rel=1e-13)
    record = mdr.read_record(file)
    assert record["normal_force"].values == pytest.approx(result["normal_force"].values, rel=4e-15)
    if steps >= 5:
        curve = mdr.read_force_curve(file, modulus="1 GPa")
        assert curve.force == pytest.approx(result["normal_force"].values, rel=4e-15)
    assert file.read_text().startswith("# version: pymdr" if about else "step,indentation [")


def test_lines_above_a_csv_say_what_its_numbers_rest_on(result, tmp_path):
    result.to_csv(tmp_path / "ball.csv", about=True)
    lines = [line for line in (tmp_path / "ball.csv").read_text().splitlines() if line.startswith("#")]
    text = "\n".join(lines)
    assert "profile: Sphere(radius=0.01)" in text
    assert "Coulomb(coefficient=0.3)" in text
    for source in result.cite():
        assert f"# cite: {source}" in lines
    for claim in result.claims.values():
        assert claim.reason in text


def test_sweeps_studies_and_impacts_too(tmp_path):
    swept = mdr.sweep(GEL, mdr.indent("1 um", steps=3), {"body.young": ["10 kPa", "30 kPa"]})
    swept.to_csv(tmp_path / "sweep.csv", about=True)
    swept.to_xlsx(tmp_path / "sweep.xlsx")
    columns, about = sheets(tmp_path / "sweep.xlsx")
    assert columns["body.young [Pa]"] == (1e4,) * 3 + (3e4,) * 3
    force = swept["normal_force"].values.ravel()
    assert columns["normal_force [N]"] == pytest.approx(force, rel=1e-15)
    assert ("sweep over body.young", None, "2 values, 10 kPa to 30 kPa") in about
    assert mdr.read_record(tmp_path / "sweep.csv")["normal_force"].values == pytest.approx(force, rel=4e-15)
    study = mdr.rolling(
        mdr.Contact(mdr.Sphere("10 mm"), BALL.body, BALL.body, friction=mdr.Coulomb(0.3)),
        [1e-4, 1e-3],
        normal_force="10 N",
    )
    study.to_xlsx(tmp_path / "study.xlsx")
    columns, _ = sheets(tmp_path / "study.xlsx")
    assert columns["creep_force [N]"] == pytest.approx(study["creep_force"].values, rel=1e-15)
    hit = mdr.impact(mdr.Contact(BALL.profile, BALL.body), mass="30 g", speed="1 m/s")
    hit.to_xlsx(tmp_path / "hit.xlsx", units={"time": "us"})
    hit.to_csv(tmp_path / "hit.csv", about=True)
    columns, about = sheets(tmp_path / "hit.xlsx")
    assert columns["time [us]"][-1] == pytest.approx(1e6 * hit.contact_time, rel=1e-12)
    assert ("profile", None, "Sphere(radius=0.01)") in about


def test_texts_are_no_formulas_and_infinities_are_written(tmp_path):
    columns = {
        "a [m]": np.array([1.0, math.inf, -math.inf, math.nan]),
        "=b": np.array(["=1+1", "+x", "a\x07b", ""]),
    }
    write_xlsx(columns, [("note", "", "=HYPERLINK('x')\x1b[31m")], tmp_path / "odd.xlsx")
    book = openpyxl.load_workbook(tmp_path / "odd.xlsx")
    rows = list(book["table"].iter_rows())
    assert {cell.data_type for row in rows for cell in row} <= {"s", "n", "inlineStr"}
    assert [cell.value for cell in rows[1]] == [1.0, "=1+1"]
    assert [row[0].value for row in rows[2:]] == ["inf", "-inf", None]
    assert book["about"]["C2"].data_type != "f"
    write_csv(
        {"a [m]": np.array([1.0, 2.0])}, tmp_path / "odd.csv", [("note", "", "two\nlines\u2028or three")]
    )
    assert (tmp_path / "odd.csv").read_text().splitlines() == [
        "# note: two lines or three",
        "a [m]",
        "1.0",
        "2.0",
    ]


@pytest.mark.parametrize(
    ("call", "error", "words"),
    [
        (lambda r, t: r.to_xlsx(t / "ball.csv"), mdr.FileError, r"ends with '\.xlsx'"),
        (lambda r, t: r.to_csv(t / "ball.xlsx"), mdr.FileError, "to_xlsx"),
        (lambda r, t: r.to_csv(t / "ball.nc"), mdr.FileError, "suffix of array files"),
        (
            lambda r, t: mdr.export_law(r.contact, to="1 um").to_c(t / "ball.csv"),
            mdr.FileError,
            "ends with '.h'",
        ),
        (lambda r, t: r.to_xlsx(t / "none" / "ball.xlsx"), mdr.FileError, "No such file"),
        (lambda r, t: r.to_xlsx(t / "ball.xlsx", units={"slp": "m"}), mdr.QuantityError, "slp"),
        (lambda r, t: r.to_xlsx(t / "ball.xlsx", units={"shift": "N"}), mdr.UnitError, "N"),
        (lambda r, t: r.to_xlsx(3), mdr.FileError, "name of a file"),
        (
            lambda r, t: write_xlsx({"a": np.zeros(2**20)}, [], t / "long.xlsx"),
            mdr.FileError,
            "1048576 rows",
        ),
    ],
)
def test_what_cannot_be_written_is_refused_and_leaves_nothing(result, tmp_path, call, error, words):
    with pytest.raises(error, match=words):
        call(result, tmp_path)
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def case(tmp_path):
    file = tmp_path / "2-ball on plate.toml"
    file.write_text(BALL_CASE)
    return file


def test_without_openpyxl_the_extra_is_named_before_any_work(result, case, tmp_path, shell, monkeypatch):
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    with pytest.raises(MissingExtraError, match=r"pymdr\[xlsx\]"):
        result.to_xlsx(tmp_path / "ball.xlsx")
    for command in (["run"], ["law"], ["sweep", "--over", "body.young = 1 MPa, 2 MPa"]):
        status, _, error = shell(*command, case, "--xlsx", "-o", tmp_path / "out")
        assert status == 1
        assert "pymdr[xlsx]" in error
    assert [file.name for file in tmp_path.iterdir()] == [case.name]


def test_tables_from_the_shell(case, tmp_path, shell):
    out = tmp_path / "out"
    status, _, error = shell("run", case, "-o", out, "--csv", "--xlsx", "--quiet")
    assert (status, error) == (0, "")
    columns, _ = sheets(out / "result.xlsx")
    assert columns["normal_force [N]"] == pytest.approx((50.0 / 3.0, 100.0 / 3.0, 50.0), rel=1e-15)
    status, _, error = shell(
        "table", out, "-o", tmp_path / "t.csv", "--unit", "indentation=um", "--quantity", "indentation"
    )
    assert (status, error) == (0, "")
    head = next(line for line in (tmp_path / "t.csv").read_text().splitlines() if not line.startswith("#"))
    assert head == "step,indentation [um]"
    assert shell("table", out, "-o", tmp_path / "t.xlsx", "--quantity", "peak_pressure")[0] == 0
    assert "peak_pressure [Pa]" in sheets(tmp_path / "t.xlsx")[0]
    status, _, _ = shell(
        "sweep", case, "--over", "body.young = 1 GPa, 2 GPa", "-o", tmp_path / "s", "--xlsx", "-q"
    )
    assert status == 0
    assert len(sheets(tmp_path / "s" / "sweep.xlsx")[0]["step"]) == 6
    for wrong, words in (
        (["-o", tmp_path / "t.txt"], "a .csv or an .xlsx"),
        (["-o", tmp_path / "t.csv", "--unit", "um"], "indentation=um"),
        (["-o", tmp_path / "t.csv", "--quantity", "slp"], "no quantity 'slp'"),
    ):
        status, _, error = shell("table", out, *wrong)
        assert status == 1
        assert words in error


def test_a_law_from_the_shell(case, tmp_path, shell):
    status, out, error = shell("law", case, "-o", tmp_path / "law", "--xlsx")
    assert (status, error) == (0, "")
    name = "law_2_ball_on_plate"
    assert sorted(file.name for file in (tmp_path / "law").iterdir()) == [
        f"{name}.csv",
        f"{name}.h",
        f"{name}.png",
        f"{name}.xlsx",
    ]
    assert "below the table F ~ d^1.5" in out
    force = mdr.read_record(tmp_path / "law" / f"{name}.csv")["normal_force"].values
    # the depth of the path, which the load gives
    assert force[-1] == pytest.approx(50.0, rel=1e-6)
    status, out, _ = shell(
        "law", case, "-o", tmp_path / "b", "--to", "1 um", "--tolerance", "1e-3", "--name", "ball", "--json"
    )
    assert status == 0
    assert '"unit": "N/m"' in out
    assert "double ball_force(double d)" in (tmp_path / "b" / "ball.h").read_text()
    for wrong, words in (
        (["--to", "1 N"], "N"),
        (["--to", "20 mm"], "sphere cannot be pressed in"),
        (["--tolerance", "1"], "1e-07 to 0.01"),
        (["--name", "2"], "C identifier"),
        (["--name", "../x"], "C identifier"),
    ):
        status, _, error = shell("law", case, "-o", tmp_path / "none", *wrong)
        assert status == 1
        assert words in error
    assert not (tmp_path / "none").exists()
