"""Readers of instruments' files give the numbers that were written, and say what a file is before what it lacks."""

from __future__ import annotations

import importlib.metadata
import json
import math
import sys
import zipfile
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

import pymdr as mdr
from pymdr.errors import CaseError, FileError, MissingExtraError, ProblemError
from pymdr.workbench.indents import area_function_of
from pymdr.workbench.readers import GROUP, Calibration, ForceFormat, ForceRecord
from pymdr.workbench.segments import segments_in

AFM = Path(__file__).parents[2] / "shared" / "data" / "afm"
YOUNG, RADIUS, SPRING = 5000.0, 5e-6, 0.05


def pressed(samples=500, noise=5e-12, retreat=True, seed=0):
    """Travel and force of a sphere on a gel, approach and retreat, with noise."""
    depth = np.linspace(-1.5e-6, 0.8e-6, samples)
    force = 4.0 / 3.0 * YOUNG / 0.75 * math.sqrt(RADIUS) * np.clip(depth, 0.0, None) ** 1.5
    travel = depth + force / SPRING
    if retreat:
        travel, force = np.concatenate([travel, travel[::-1]]), np.concatenate([force, force[::-1]])
    return travel, force + noise * np.random.default_rng(seed).normal(size=force.size)


def young_of(curve):
    case = mdr.Contact(mdr.Paraboloid(RADIUS), mdr.Elastic("1 kPa", 0.5))
    return mdr.fit(case, curve, ["body.young"])["body.young"].value


def written(path, header, *columns, separator=",", decimal="."):
    rows = [
        separator.join(f"{v:.10g}".replace(".", decimal) for v in row) for row in zip(*columns, strict=True)
    ]
    path.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    return path


def approach_of(curves):
    return next(one for one in curves if one.segment == "approach")


# ---- tables -----------------------------------------------------------------


@pytest.mark.parametrize(
    ("header", "of", "options"),
    [
        ("load [nN],travel [um]", lambda x, f: (f * 1e9, x * 1e6), {}),
        ("load [nN],height [um]", lambda x, f: (f * 1e9, 7.0 - x * 1e6), {}),
        ("load [nN],travel [um]", lambda x, f: (f * 1e9, 7.0 - x * 1e6), {}),
        ("load [nN],travel [um]", lambda x, f: (-f * 1e9, -x * 1e6), {}),
        ("deflection [nm],height (measured) [m]", lambda x, f: (f / SPRING * 1e9, -x), {}),
        (
            "deflection [V],z piezo [um]",
            lambda x, f: (f / SPRING / 50e-9, x * 1e6),
            {"sensitivity": "50 nm/V"},
        ),
        (
            "deflection [nA],height [um]",
            lambda x, f: (f / SPRING * 1e7, -x * 1e6),
            {"sensitivity": "100 nm/nA"},
        ),
    ],
)
def test_tables_of_any_position_and_deflection_give_the_same_modulus(tmp_path, header, of, options):
    travel, force = pressed()
    file = written(tmp_path / "curve.csv", header, *of(travel, force))
    curves = mdr.read_curves(file, spring_constant=f"{SPRING} N/m", **options)
    assert [one.segment for one in curves] == ["approach", "retreat"]
    whole = curves[0].join(*curves[1:])
    assert whole.force == pytest.approx(force, rel=1e-8, abs=1e-15)
    assert np.ptp(whole.travel - travel) < 1e-12
    result = young_of(approach_of(curves))
    assert result == pytest.approx(YOUNG, rel=5e-3)


@pytest.mark.parametrize(("separator", "decimal"), [(",", "."), (";", "."), (";", ","), ("\t", ",")])
def test_separators_decimal_commas_preambles_and_lines_of_units(tmp_path, separator, decimal):
    travel, force = pressed(samples=60)
    for name, lines in (("one", ["load [nN]", "travel [um]"]), ("two", ["load", "travel"])):
        rows = [
            separator.join(f"{v:.9g}".replace(".", decimal) for v in row)
            for row in zip(force * 1e9, travel * 1e6, strict=True)
        ]
        units = [] if name == "one" else [separator.join(["nN", "um"])]
        text = ["Instrument 7", "", f"Speed{separator}5", separator.join(lines), *units, *rows]
        file = tmp_path / f"{name}.txt"
        file.write_text("\n".join(text))
        curves = mdr.read_curves(file, spring_constant="0.05 N/m")
        assert np.concatenate([one.force for one in curves]) == pytest.approx(force, rel=1e-7, abs=1e-17)


@pytest.mark.parametrize("cut", [1, 3, 5, 12])
def test_a_number_that_is_cut_off_is_not_another_number(tmp_path, cut):
    travel, force = pressed(40)
    file = tmp_path / "cut.csv"
    rows = [f"{x:.6e},{f:.6e}" for x, f in zip(travel, force, strict=True)]
    whole = "\n".join(["travel [m],load [N]", *rows])
    file.write_text(whole)
    assert sum(one.force.size for one in mdr.read_curves(file, spring_constant=SPRING)) == force.size
    file.write_text(whole[:-cut])  # without the last digits of an exponent, 1e-10 is 0.1
    with pytest.raises(CaseError, match="cut off in its last line"):
        mdr.read_curves(file, spring_constant=SPRING)


@pytest.mark.parametrize(("decimal", "separator", "name"), [(".", ",", "a.csv"), (",", "\t", "a.txt")])
def test_a_text_of_a_microscope_that_ends_in_a_number_is_refused(tmp_path, decimal, separator, name):
    """A file of AFM workshop, with decimals of another width in its header, and one of NT-MDT."""
    pytest.importorskip("afmformats")
    rows = np.random.default_rng(0).uniform(1.0, 2.0, (40, 4 if name == "a.csv" else 3))
    lines = [separator.join(f"{x:.4f}".replace(".", decimal) for x in row) for row in rows]
    if name == "a.csv":
        columns = "Extend Z-Sense(nm),Extend T-B(V),Retract Z-Sense(nm),Retract T-B(V)"
        lines = ["Force-Distance Curve", "X, um:\t25.000000", "", columns, *lines]
    (tmp_path / name).write_text("\r\n".join(lines)[:-2], newline="")
    with pytest.raises(CaseError, match="cut off in its last line"):
        mdr.read_curves(tmp_path / name, spring_constant="0.1 N/m", sensitivity="50 nm/V")


def test_a_text_of_nt_mdt_that_ends_between_lines_is_refused(tmp_path):
    """Its ramp ends at height 0, so that any block of its last rows is missed."""
    pytest.importorskip("afmformats")
    height = np.linspace(-990.0, 0.0, 100)
    current = np.maximum(-0.01 * (height + 500.0), 0.0) - 1.1
    lines = [
        f"{z:.4f}\t{i:.4f}\t{i - 0.01:.4f}\r\n".replace(".", ",")
        for z, i in zip(height, current, strict=True)
    ]
    file = tmp_path / "curve.txt"
    options = {"spring_constant": "0.1 N/m", "sensitivity": "50 nm/nA"}
    for kept in (*range(3, 99, 6), 99):
        file.write_text("".join(lines[:kept]), newline="")
        with pytest.raises(CaseError, match=rf"cut off \({100 - kept} further rows? missing\)"):
            mdr.read_curves(file, **options)
    file.write_text("".join(lines), newline="")
    assert sum(one.force.size for one in mdr.read_curves(file, **options)) == 200
    file.write_text("".join(lines[::-1]), newline="")
    with pytest.raises(CaseError, match=r"end at -990 nm .*\(further rows? missing\)"):
        mdr.read_curves(file, **options)


def test_archives_that_do_not_decompress_are_refused(tmp_path):
    file = written(tmp_path / "a.csv", "travel [um],load [nN]", *np.array(pressed(200)) * 1e6)
    with zipfile.ZipFile(tmp_path / "a.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.write(file, "a.csv")
    content = bytearray((tmp_path / "a.zip").read_bytes())
    for place in (40, 60, len(content) // 2, len(content) - 5):
        damaged = content.copy()
        damaged[place : place + 4] = b"\xff\xfe\xff\xfe"
        (tmp_path / "b.zip").write_bytes(damaged)
        with pytest.raises(FileError, match="damaged, cut off or encrypted"):
            mdr.read_curves(tmp_path / "b.zip", spring_constant=SPRING)


@pytest.mark.parametrize(("size", "limit"), [(1e290, "at most 1e\\+60"), (1e-300, "at least 1e-60")])
def test_records_beyond_all_sizes_are_refused(size, limit):
    travel, force = pressed(40)
    with pytest.raises(ProblemError, match=rf"^the (largest|range of the) force = .*{limit} N"):
        mdr.MeasuredCurve(force=force * size / 1e-8, indentation=travel)


def test_spreadsheets_are_read_as_text_is(tmp_path):
    openpyxl = pytest.importorskip("openpyxl", reason="openpyxl, of the extra xlsx, is not installed")
    travel, force = pressed(samples=60)
    for units_below in (False, True):
        book = openpyxl.Workbook()
        sheet = book.active
        for row in [["load", "height"], ["nN", "um"]] if units_below else [["load [nN]", "height [um]"]]:
            sheet.append(row)
        for row in zip(force * 1e9, -travel * 1e6, strict=True):
            sheet.append([float(v) for v in row])
        book.save(tmp_path / "curve.xlsx")
        curves = mdr.read_curves(tmp_path / "curve.xlsx", spring_constant="0.05 N/m")
        assert [one.segment for one in curves] == ["approach", "retreat"]
        assert np.concatenate([one.force for one in curves]) == pytest.approx(force, rel=1e-12)
    (tmp_path / "bad.xlsx").write_bytes(b"PK no book")
    with pytest.raises(CaseError, match="no spreadsheet, or it is damaged"):
        mdr.read_curves(tmp_path / "bad.xlsx", spring_constant="0.05 N/m")


def test_the_sheet_with_a_table_is_read_and_several_are_refused(tmp_path):
    openpyxl = pytest.importorskip("openpyxl", reason="openpyxl, of the extra xlsx, is not installed")
    travel, force = pressed(samples=60)
    book = openpyxl.Workbook()
    for words in (["operator", "date"], ["somebody", "today"]):
        book.active.append(words)
    for name, factor in (("data", 1.0), ("more", 2.0)):
        sheet = book.create_sheet(name)
        sheet.append(["load [nN]", "depth [um]"])
        for row in zip(factor * force * 1e9, travel * 1e6, strict=True):
            sheet.append([float(v) for v in row])
        file = tmp_path / f"{name}.xlsx"
        book.save(file)
    curves = mdr.read_curves(tmp_path / "data.xlsx")
    assert np.concatenate([one.force for one in curves]) == pytest.approx(force, rel=1e-12)
    with pytest.raises(CaseError, match=r"2 sheets have tables \(data, more\); save each"):
        mdr.read_curves(tmp_path / "more.xlsx")
    one, two = mdr.read_indents(tmp_path / "more.xlsx")
    assert (one.attrs["test"], two.attrs["test"]) == ("data", "more")
    assert two["normal_force"].values == pytest.approx(2.0 * force, rel=1e-12)


def test_old_spreadsheets_are_read(tmp_path):
    openpyxl = pytest.importorskip("openpyxl", reason="openpyxl, of the extra xlsx, is not installed")
    time, depth, force = indent_of(30)
    book = openpyxl.Workbook()
    for row in [
        ["time", "depth", "load"],
        ["s", "nm", "mN"],
        *zip(time, depth * 1e9, force * 1e3, strict=True),
    ]:
        book.active.append([v if isinstance(v, str) else float(v) for v in row])
    book.save(tmp_path / "a.xlsx")
    (tmp_path / "a.xlsx").rename(tmp_path / "a.xls")  # what is inside decides
    [read] = mdr.read_indents(tmp_path / "a.xls")
    assert read["normal_force"].values == pytest.approx(force, rel=1e-12)
    pytest.importorskip("xlrd", reason="xlrd, of the extra xls, is not installed")
    for content in (b"no book", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(600)):
        (tmp_path / "bad.xls").write_bytes(content)
        with pytest.raises(CaseError, match="no spreadsheet, or it is damaged"):
            mdr.read_indents(tmp_path / "bad.xls")


def test_without_a_package_the_extra_is_named(tmp_path, monkeypatch):
    for module in ("xlrd", "NSFopen.read", "openpyxl"):
        monkeypatch.setitem(sys.modules, module, None)
    for name, extra in (("a.xls", "xls"), ("a.nid", "nanosurf"), ("a.xlsx", "xlsx")):
        (tmp_path / name).write_bytes(b"something")
        with pytest.raises(MissingExtraError, match=rf"pip install 'pymdr\[{extra}\]'"):
            mdr.read_curves(tmp_path / name)


def test_messages_say_what_a_file_is_before_what_it_lacks(tmp_path):
    travel, force = pressed(samples=60)
    volts = written(tmp_path / "volts.csv", "deflection [V],height [um]", force * 1e9, -travel * 1e6)
    with pytest.raises(
        ProblemError, match=r"a table with units\. The file has no spring constant and sensitivity; give"
    ):
        mdr.read_curves(volts)
    with pytest.raises(ProblemError, match="sensitivity is in m/A; give it in m/V"):
        mdr.read_curves(volts, spring_constant="1 N/m", sensitivity="50 nm/nA")
    with pytest.raises(ProblemError, match="sensitivity = 0 m/V: it must be above 0"):
        mdr.read_curves(volts, spring_constant="1 N/m", sensitivity="0 nm/V")
    forces = written(tmp_path / "forces.csv", "load [nN],height [um]", force * 1e9, -travel * 1e6)
    with pytest.raises(ProblemError, match="leave sensitivity out"):
        mdr.read_curves(forces, spring_constant="1 N/m", sensitivity="50 nm/V")
    both = written(tmp_path / "both.csv", "load [nN],travel [um],height [um]", force, travel, -travel)
    with pytest.raises(
        ProblemError, match=r"exactly one of indentation, travel and height .*travel and height"
    ):
        mdr.read_curves(both, spring_constant="1 N/m")
    none = written(tmp_path / "none.csv", "travel [um],time [s]", travel, force)
    with pytest.raises(CaseError, match="a table of time, travel without a force"):
        mdr.read_curves(none, spring_constant="1 N/m")


def test_a_retreat_alone_that_ends_in_a_pull_is_not_turned(tmp_path):
    x = np.linspace(1e-6, -2e-6, 400)
    force = np.where(x > -0.8e-6, 2e-9 * (x / 1e-6) - 1e-9, 0.0)
    file = written(tmp_path / "pull.csv", "load [nN],indentation [um]", force * 1e9, x * 1e6)
    [curve] = mdr.read_curves(file)
    assert curve.segment == "retreat"
    assert curve.indentation[0] == pytest.approx(1e-6)
    assert curve.step is None


@pytest.mark.parametrize("sides", [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)])
@pytest.mark.parametrize("retreat", [True, False])
def test_signs_of_tables_do_not_change_the_modulus(tmp_path, sides, retreat):
    travel, force = pressed(retreat=retreat)
    columns = sides[0] * force * 1e9, sides[1] * (travel - force / SPRING) * 1e6
    file = written(tmp_path / "signs.csv", "load [nN],indentation [um]", *columns)
    assert young_of(mdr.read_curves(file)[0]) == pytest.approx(YOUNG, rel=0.02)
    kept = mdr.read_curves(file, keep_signs=True)[0]
    np.testing.assert_allclose(kept.force * 1e9, columns[0][: kept.force.size], rtol=1e-9)
    assert kept.step is None


def test_a_body_in_tension_only_is_not_turned(tmp_path):
    depth = np.linspace(-1e-6, 0.0, 300)
    force = np.where(depth > -0.6e-6, -2e-9 + 2e-9 * np.maximum(depth / 0.6e-6 + 1.0, 0.0) ** 1.5, 0.0)
    file = written(tmp_path / "tension.csv", "load [nN],indentation [um]", force[:-9] * 1e9, depth[:-9] * 1e6)
    [curve] = mdr.read_curves(file)
    assert curve.step is None
    assert curve.force.min() < -1.9e-9


def test_the_shell_names_its_own_option_for_signs(tmp_path, shell):
    travel, force = pressed(retreat=False)
    file = written(
        tmp_path / "neg.csv", "load [nN],indentation [um]", -force * 1e9, (travel - force / SPRING) * 1e6
    )
    case = tmp_path / "gel.toml"
    case.write_text(
        'profile = { kind = "paraboloid", radius = "5 um" }\nbody = { kind = "elastic", young = "1 kPa", poisson = 0.5 }\n'
    )
    status, out, error = shell("fit", case, file, "--free", "body.young", "--json")
    assert (status, error) == (0, "")
    assert json.loads(out)["fit"]["values"]["body.young"]["value"] == pytest.approx(YOUNG, rel=0.02)
    status, _, error = shell("fit", case, file, "--free", "body.young", "--keep-signs")
    assert status == 1
    assert "with keep_signs compression is positive" in error
    assert "curve.orient" not in error
    kept = mdr.read_curves(file, keep_signs=True)[0]
    with pytest.raises(ProblemError, match="check the signs of force and position"):
        mdr.fit(mdr.Contact(mdr.Paraboloid(RADIUS), mdr.Elastic("1 kPa", 0.5)), kept, ["body.young"])
    status, out, _ = shell("curves", file)
    assert "reversed, so that compression is positive" in out
    status, out, _ = shell("curves", file, "--keep-signs")
    assert "signs: kept" in out
    assert "curve.orient" not in out


@pytest.mark.parametrize("ratio", [0.05, 1.0, 12.0])
def test_a_slow_approach_is_no_hold(ratio):
    slow, fast = 2000, round(2000 * min(ratio, 1.0) if ratio < 1 else 2000 / ratio)
    position = np.concatenate([np.linspace(0, 1, slow), np.linspace(1, 0, fast)])
    result = segments_in(position, np.arange(float(position.size)), None)
    assert [one.name for one in result] == ["approach", "retreat"]


def test_segments_samples_and_signals_of_tables_from_the_shell(tmp_path, shell):
    travel, force = pressed()
    volts = force / SPRING / 50e-9
    rows = [f"{v:.9g},{x * 1e6:.9g}" for v, x in zip(volts, -travel, strict=True)]
    rows[17] = "nan," + rows[17].split(",")[1]
    file = tmp_path / "curve.csv"
    file.write_text("\n".join(["deflection [V],height [um]", *rows]))
    case = tmp_path / "gel.toml"
    case.write_text(
        '[profile]\nkind = "paraboloid"\nradius = "5 um"\n\n[body]\nkind = "elastic"\nyoung = "1 kPa"\npoisson = 0.5\n'
    )
    options = ("--spring-constant", "0.05 N/m", "--sensitivity", "50 nm/V", "--leave-out-missing", "--json")
    status, out, error = shell("fit", case, file, "--free", "body.young", "--segment", "approach", *options)
    assert (status, error) == (0, "")
    fitted = json.loads(out)["fit"]["values"]["body.young"]
    assert fitted["value"] == pytest.approx(YOUNG, rel=5e-3)
    for uncertain in ("50 nm/V +- 5 %", "50 nm/V ± 2.5 nm/V"):
        given = ("--segment", "approach", *options[:3], uncertain, *options[4:])
        status, out, error = shell("fit", case, file, "--free", "body.young", *given)
        assert (status, error) == (0, "")
        one = json.loads(out)["fit"]
        shares = {name: part["body.young"] for name, part in one["calibration"].items()}
        assert shares["sensitivity"] > 0.04 * YOUNG  # E follows the deflection, at least in proportion
        assert shares["sensitivity"] < one["values"]["body.young"]["error"] < 0.2 * YOUNG
    status, _, error = shell("curves", file, *given[2:])
    assert status != 0
    assert "write --sensitivity '50 nm/V' here" in error
    status, out, _ = shell("curves", file, *options)
    assert status == 0
    assert [one["segment"] for one in json.loads(out)["curves"][0]["segments"]] == ["approach", "retreat"]
    status, _, error = shell("fit", case, file, "--free", "body.young", *options[:4])
    assert status != 0
    assert "every entry must be a finite number" in error
    assert "leave_out_missing omits them" in error
    status, _, error = shell("fit", case, file, "--free", "body.young", "--segment", "hold", *options[:-1])
    assert status != 0
    assert "record, approach, retreat" in error


# ---- files of makers ----------------------------------------------------------


def optics11(path, travel, force, time):
    own = np.clip(travel - force / SPRING, 0.0, None)
    rows = zip(time, force * 1e6, own * 1e9, force / SPRING * 1e9, travel * 1e9, strict=True)
    text = [
        "Date\t1/1/2026\tTime\t11:20:38\tStatus\tOK",
        "",
        f"k (N/m)\t{SPRING}",
        "Tip radius (um)\t5.000",
        "",
    ]
    text += ["Device:\tChiaro", "Max load (\u00b5N)\t0.050", "", "E[eff] (Pa)\t6666.0", ""]
    text += ["Time (s)\tLoad (uN)\tIndentation (nm)\tCantilever (nm)\tPiezo (nm)\tAuxiliary"]
    text += ["\t".join([*(f"{v:.7f}" for v in row), "0.1"]) for row in rows]
    path.write_text("\n".join(text), encoding="latin-1")
    return path


def test_the_travel_of_optics11_is_that_of_the_piezo(tmp_path):
    travel, force = pressed()
    file = optics11(tmp_path / "a.txt", travel, force, np.arange(travel.size) * 1e-3)
    approach, retreat = mdr.read_curves(file)
    assert (approach.segment, retreat.segment) == ("approach", "retreat")
    assert approach.spring_constant == SPRING
    assert approach.metadata["tip radius"] == pytest.approx(RADIUS)
    assert young_of(approach) == pytest.approx(YOUNG, rel=5e-3)
    with zipfile.ZipFile(tmp_path / "two.zip", "w") as archive:
        archive.write(file, "a.txt")
        archive.write(file, "b.txt")
    curves = mdr.read_curves(tmp_path / "two.zip")
    assert [one.metadata["member"] for one in curves] == ["a.txt", "a.txt", "b.txt", "b.txt"]
    assert [one.metadata["record"] for one in curves] == [0.0, 0.0, 1.0, 1.0]
    with zipfile.ZipFile(tmp_path / "outer.zip", "w") as archive:
        archive.write(tmp_path / "two.zip", "two.zip")
    with pytest.raises(CaseError, match="contains another archive"):
        mdr.read_curves(tmp_path / "outer.zip")


def nanoscope(path, travel, force, *, sensor, hold=0, curves=1):
    """A force file as NanoScope writes it: samples from the contact on, a hold behind the retraction."""
    n = travel.size // 2
    volts = force / SPRING / 50e-9
    out, back = slice(0, n), slice(n, 2 * n)
    channels = [("DeflectionError", "Deflection Error", "DeflSens", volts)]
    if sensor:
        channels.append(("ZSensor", "Height Sensor", "ZsensSens", travel / 1e-6))
    header = ["\\*Force file list", "\\Version: 0x09300000", "\\*Ciao scan list", "\\Scan Size: 2000 nm"]
    header += [
        "\\@Sens. DeflSens: V 50.00000 nm/V",
        "\\@Sens. ZsensSens: V 1000.000 nm/V",
        "\\@Sens. Zsens: V 20.00000 nm/V",
    ]
    header += ["\\*Ciao force list", "\\Forward vel.: 100", "\\Reverse vel.: 50", "\\force/line: 2"]
    if hold:
        header += [f"\\Hold Samples: {hold}", "\\Hold Time: 0.1"]
    ramp = float(np.ptp(travel)) / 20e-9
    start, blocks = 40960, []
    for short, name, sensitivity, values in channels:
        width = 4 if hold else (4 if short == "ZSensor" else 2)
        step = 20.0 / 2 ** (8 * width)
        stored = np.concatenate([values[out][::-1], values[back], np.full(hold, values[n - 1])])
        block = np.round(np.tile(stored, curves) / step).astype(f"<i{width}").tobytes()
        header += [
            "\\*Ciao force image list",
            f"\\Data offset: {start}",
            f"\\Data length: {len(block)}",
            f"\\Bytes/pixel: {width}",
            f"\\Samps/line: {n} {n}",
            f"\\Spring Constant: {SPRING}",
            f'\\@4:Image Data: S [{short}] "{name}"',
            f"\\@4:Z scale: V [Sens. {sensitivity}] ({step:.12g} V/LSB) 20.00000 V",
            f"\\@4:Ramp size: V [Sens. Zsens] (0.006 V/LSB) {ramp:.9g} V",
        ]
        blocks.append(block)
        start += len(block)
    text = "\r\n".join([*header, "\\*File list end", "\x1a"]).encode("latin-1")
    path.write_bytes(text.ljust(40960, b"\0") + b"".join(blocks))
    return path


@pytest.mark.parametrize("hold", [0, 40])
def test_force_files_of_nanoscope_are_read_in_the_order_of_measurement(tmp_path, hold):
    travel, force = pressed()
    travel = travel - travel.min()
    file = nanoscope(tmp_path / "curve.001", travel, force, sensor=True, hold=hold)
    curves = mdr.read_curves(file)
    assert [one.segment for one in curves] == ["approach", *["hold"] * bool(hold), "retreat"]
    step = 20.0 / 2 ** (32 if hold else 16) * 50e-9 * SPRING
    assert curves[0].force == pytest.approx(force[:500], abs=0.51 * step)
    assert curves[-1].force == pytest.approx(force[500:], abs=0.51 * step)
    assert curves[0].travel == pytest.approx(travel[:500], abs=1e-14)
    assert (curves[0].spring_constant, curves[0].metadata["sensitivity"]) == (SPRING, 50e-9)
    assert np.all(np.diff(np.concatenate([one.time for one in curves])) > 0.0)
    assert young_of(curves[0]) == pytest.approx(YOUNG, rel=5e-3)
    [other, *_] = mdr.read_curves(file, sensitivity="60 nm/V")
    assert other.force == pytest.approx(1.2 * curves[0].force)
    assert other.steps[-1].name == "sensitivity"


def test_ramps_and_force_volumes_of_nanoscope(tmp_path):
    travel = np.concatenate([np.linspace(0.0, 2e-6, 300), np.linspace(2e-6, 0.0, 300)])
    force = 1e-9 * np.clip(travel - 1e-6, 0.0, None) / 1e-6
    [approach, retreat] = mdr.read_curves(nanoscope(tmp_path / "a.spm", travel, force, sensor=False))
    assert approach.travel == pytest.approx(travel[:300], abs=1e-14)
    assert approach.time[-1] - approach.time[0] == pytest.approx(2e-6 / 20e-9 / 100 * 299 / 300)
    assert retreat.time[1] - retreat.time[0] == pytest.approx(2e-6 / 20e-9 / 50 / 300)
    volume = mdr.read_curves(nanoscope(tmp_path / "v.spm", travel, force, sensor=False, curves=6))
    stacked = mdr.stack_curves([one for one in volume if one.segment == "approach"])
    assert dict(stacked.sizes) == {"y": 3, "x": 2, "sample": 300}
    assert stacked.x.values == pytest.approx([-0.5e-6, 0.5e-6])


def test_damaged_and_other_files_of_nanoscope_are_refused(tmp_path):
    travel, force = pressed(samples=100)
    whole = nanoscope(tmp_path / "a.spm", travel, force, sensor=True).read_bytes()
    for content, words, error in (
        (whole[:-100], "the file is cut off", FileError),
        (whole[:300], "whose header has no end", FileError),
        (
            whole.replace(b"DeflectionError", b"Other").replace(b'"Deflection Error"', b'"Other"'),
            "without a deflection channel",
            ProblemError,
        ),
        (
            whole.replace(b"\\Version", b"\\Start context: SCRIPT\r\n\\Version"),
            "by a script with its own ramps",
            ProblemError,
        ),
        (b"\\*File list\r\n" + whole, "holds images, not force curves", ProblemError),
        (b"damaged" + whole, "not a file of Bruker NanoScope, as its suffix suggests", FileError),
    ):
        (tmp_path / "b.spm").write_bytes(content)
        with pytest.raises(error, match=words):
            mdr.read_curves(tmp_path / "b.spm")
    (tmp_path / "c.pfc").write_bytes(whole)
    with pytest.raises(ProblemError, match="a PeakForce capture"):
        mdr.read_curves(tmp_path / "c.pfc")


def test_nanosurf_is_read_by_its_channels(tmp_path, monkeypatch):
    import pandas as pd

    travel, force = pressed()
    n = travel.size // 2
    spec = {
        ("Forward", "Z-Axis Sensor"): [travel[:n]] * 2,
        ("Forward", "Deflection"): [force[:n]] * 2,
        ("Backward", "Z-Axis Sensor"): [travel[n:][::-1]] * 2,
        ("Backward", "Deflection"): [force[n:][::-1]] * 2,
    }
    facts = {
        ("HeaderDump", "DataSet-0:0"): {"Dim2Name": "Deflection", "Dim2Unit": "N"},
        ("Tip", "Prop0"): {"Value": SPRING, "Unit": "N/m"},
        ("Spec", "modFw"): {"Value": 1.0, "Unit": "s"},
        ("Spec", "modBw"): {"Value": 0.5, "Unit": "s"},
    }
    opened = SimpleNamespace(
        data={"Spec": pd.Series(list(spec.values()), index=pd.MultiIndex.from_tuples(spec))}, param=facts
    )
    module = ModuleType("NSFopen.read")
    module.read = lambda name: opened
    monkeypatch.setitem(sys.modules, "NSFopen", ModuleType("NSFopen"))
    monkeypatch.setitem(sys.modules, "NSFopen.read", module)
    (tmp_path / "a.nid").write_bytes(b"[DataSet]")
    curves = mdr.read_curves(tmp_path / "a.nid")
    assert [one.segment for one in curves] == ["approach", "retreat"] * 2
    assert np.array_equal(curves[1].force, force[n:])
    assert young_of(curves[0]) == pytest.approx(YOUNG, rel=5e-3)


def test_other_packages_offer_formats(tmp_path, monkeypatch):
    travel, force = pressed()

    def read(path, calibration):
        assert calibration == Calibration(SPRING, None)
        if path.stat().st_size < 3:
            raise KeyError("header")
        return [
            ForceRecord("a file of ours", {"force": force, "height": -travel}, None, None, {"operator": "M"})
        ]

    offered = [
        SimpleNamespace(name="ours", value="ours:it", load=lambda: ForceFormat("ours", (".our",), read))
    ]
    monkeypatch.setattr(importlib.metadata, "entry_points", lambda group: offered if group == GROUP else [])
    monkeypatch.setattr("pymdr.workbench.readers.finding.entry_points", importlib.metadata.entry_points)
    (tmp_path / "a.our").write_bytes(b"whatever")
    approach, _ = mdr.read_curves(tmp_path / "a.our", spring_constant="0.05 N/m")
    assert approach.metadata["operator"] == "M"
    assert young_of(approach) == pytest.approx(YOUNG, rel=5e-3)
    (tmp_path / "b.our").write_bytes(b"w")
    with pytest.raises(FileError, match="a file of ours, according to its suffix, but it is damaged"):
        mdr.read_curves(tmp_path / "b.our", spring_constant="0.05 N/m")
    table = written(tmp_path / "table.csv", "load [nN],travel [um]", force * 1e9, travel * 1e6)
    offered[0].load = lambda: 3
    assert (
        len(mdr.read_curves(table, spring_constant="0.05 N/m")) == 2
    )  # a broken reader is none of its business
    with pytest.raises(ProblemError, match=r"the reader 'ours' of the group pymdr.readers .* is int"):
        mdr.read_curves(tmp_path / "a.our", spring_constant="0.05 N/m")


MEASURED = {
    "fmt-chiaro-txt_AEBP1_Indentation_002.zip": ({}, ["approach", "retreat"]),
    "fmt-igor-fd_U3_3_p10004.ibw": ({}, ["approach", "retreat"]),
    "fmt-afm-workshop-fd_single_2021-01-15.csv": (
        {"spring_constant": "0.1 N/m", "sensitivity": "50 nm/V"},
        ["approach", "retreat"],
    ),
    "fmt-ntmdt-txt-fd_2015_01_17_gel4-0,1_mQ_adh_6B_Curve_DFL_Height_51.txt": (
        {"spring_constant": "0.1 N/m", "sensitivity": "50 nm/nA"},
        ["approach", "retreat"],
    ),
}


@pytest.mark.parametrize("name", MEASURED)
def test_files_of_laboratories_are_read(name):
    pytest.importorskip("afmformats", reason="afmformats, of the extra afm, is not installed")
    if not (AFM / name).exists():
        pytest.skip(f"{name}, from the tests of afmformats, is not beside the repository")
    options, segments = MEASURED[name]
    assert [one.segment for one in mdr.read_curves(AFM / name, **options)] == segments
    if options:
        with pytest.raises(
            ProblemError,
            match=r"(AFM workshop|NT-MDT).*The file has no sensitivity and spring constant; give",
        ):
            mdr.read_curves(AFM / name)


def test_a_damaged_file_of_igor_is_one_line_of_error(tmp_path, shell):
    pytest.importorskip("afmformats", reason="afmformats, of the extra afm, is not installed")
    source = AFM / "fmt-igor-fd_U3_3_p10004.ibw"
    if not source.exists():
        pytest.skip(f"{source.name}, from the tests of afmformats, is not beside the repository")
    (tmp_path / "cut.ibw").write_bytes(source.read_bytes()[:100_000])
    status, out, error = shell("curves", tmp_path / "cut.ibw")
    assert (status, out, error.count("\n")) == (1, "", 1)
    assert "damaged or cut off" in error


def test_the_modulus_of_optics11_is_that_of_its_own_fit():
    file = AFM / "fmt-chiaro-txt_AEBP1_Indentation_002.zip"
    if not file.exists():
        pytest.skip(f"{file.name}, from the tests of afmformats, is not beside the repository")
    [curve] = mdr.read_prepared_curves(file, segment="approach")
    case = mdr.Contact(mdr.Paraboloid("27.5 um"), mdr.Elastic("100 Pa", 0.5))
    assert mdr.fit(case, curve, ["body.young"])["body.young"].value == pytest.approx(117.0, rel=0.08)


# ---- nanoindentation ------------------------------------------------------------


def indent_of(samples=400):
    loading, unloading = np.linspace(0.0, 1.0, samples), np.linspace(1.0, 0.0, samples)
    depth = np.concatenate([500e-9 * loading, 430e-9 + 70e-9 * unloading])
    force = 5e-3 * np.concatenate([loading**2, unloading**1.5])
    return np.arange(2.0 * samples) * 0.01, depth, force


def hysitron(path, time, depth, force):
    text = [
        "File Version: Hysitron",
        "Tip C0: 24.5 nm^2/nm^2",
        "Tip C1: 900 nm^2/nm",
        "Tip C2: 0 nm^2/nm^0.5",
    ]
    text += ["Sample Approach Data Points: 2", "Time_s\tMotorDisp_mm", "0.0\t0.1", "0.1\t0.2"]
    text += [f"Test Data Points: {time.size}", "Time_s\tDisp_nm\tForce_\u00b5N\tDisp_V\tForce_V"]
    rows = zip(time, depth * 1e9, force * 1e6, depth, force, strict=True)
    text += ["\t".join(f"{v:.9f}" for v in row) for row in rows]
    path.write_text("\r\n".join(text), encoding="latin-1")
    return path


def test_indents_of_hysitron_bring_their_area_function(tmp_path, shell):
    time, depth, force = indent_of()
    file = hysitron(tmp_path / "a.hld", time, depth, force)
    [read] = mdr.read_indents(file)
    assert read["indentation"].values == pytest.approx(depth, abs=1e-17)
    assert read["normal_force"].values == pytest.approx(force, abs=1e-14)
    assert read["time"].values == pytest.approx(time)
    assert read.attrs["area_coefficients"] == [24.5, 900.0]
    tip = area_function_of([read])
    assert tip.area_at("100 nm") == pytest.approx(24.5 * 1e-14 + 900.0 * 1e-16)
    exact = mdr.oliver_pharr(mdr.MeasuredCurve(force=force, indentation=depth), tip)
    study = mdr.oliver_pharr([read], tip)
    assert study["hardness"].values == pytest.approx(exact["hardness"].values, rel=1e-6)
    status, out, error = shell("nanoindent", file, "--json")
    assert (status, error) == (0, "")
    assert json.loads(out)["rows"] == 1
    lines = file.read_bytes().split(b"\r\n")
    (tmp_path / "cut.hld").write_bytes(b"\r\n".join(lines[:-20]))
    with pytest.raises(CaseError, match="780 of 800 rows of the test"):
        mdr.read_indents(tmp_path / "cut.hld")
    (tmp_path / "bad.hld").write_bytes(b"\r\n".join(lines).replace(b"900 nm", b"9\xb90 nm"))
    with pytest.raises(CaseError, match=r"Tip C1.* is not a number"):
        mdr.read_indents(tmp_path / "bad.hld")
    (tmp_path / "none.hld").write_bytes(b"\r\n".join(lines[:8]))
    with pytest.raises(CaseError, match="without the section of its test"):
        mdr.read_indents(tmp_path / "none.hld")
    (tmp_path / "gap.hld").write_bytes(
        b"\r\n".join(lines[:2] + lines[3:]).replace(b"Tip C2: 0 nm", b"Tip C2: 7 nm")
    )
    assert mdr.read_indents(tmp_path / "gap.hld")[0].attrs["area_coefficients"] == [24.5, 0.0, 7.0]
    (tmp_path / "empty.hld").write_bytes(b"")
    with pytest.raises(CaseError, match="the file is empty"):
        mdr.read_indents(tmp_path / "empty.hld")
    text = "depth [nm],load [mN]\n" + "\n".join(f"{h:.9f},{f:.9f}" for h, f in zip(depth, force, strict=True))
    (tmp_path / "cut.csv").write_text(text[:-3])
    with pytest.raises(CaseError, match="cut off in its last line"):
        mdr.read_indents(tmp_path / "cut.csv")


def test_sheets_of_tests_bring_the_harmonic_stiffness(tmp_path):
    openpyxl = pytest.importorskip("openpyxl", reason="openpyxl, of the extra xlsx, is not installed")
    time, depth, force = indent_of(100)
    stiffness = np.where(np.arange(200) % 3 == 0, np.nan, 4e3 * depth / 500e-9)
    book = openpyxl.Workbook()
    book.active.title = "Results"
    book["Results"].append(["Test", "H", "Area Coefficient 1", "Area Coefficient 2"])
    book["Results"].append(["", "GPa", "", ""])
    for number in (1, 2):
        book["Results"].append([f"{number}", 9.0, 24.0 + number, 100.0])
    for number in (2, 1):
        sheet = book.create_sheet(f"Test {number:03d}")
        sheet.append(
            [
                "Segment",
                "Displacement Into Surface",
                "Load On Sample",
                "Time On Sample",
                "Harmonic Contact Stiffness",
                "Raw Load",
            ]
        )
        sheet.append(["", "nm", "mN", "s", "N/m", "mN"])
        for row in zip(depth * 1e9, force * 1e3 * number, time, stiffness, strict=True):
            h, f, t, s = map(float, row)
            sheet.append(["", h, f, t, 1.7976931348623157e308 if math.isnan(s) else s, 7.0])
        sheet.append(["END", "", "", "", "", ""])
    book.save(tmp_path / "tests.xlsx")
    two, one = mdr.read_indents(tmp_path / "tests.xlsx")
    assert (two.attrs["test"], one.attrs["test"]) == ("Test 002", "Test 001")
    assert two["normal_force"].values == pytest.approx(2.0 * force, rel=1e-12)
    assert one.sizes["step"] == 200
    assert np.array_equal(np.isnan(one["harmonic_stiffness"].values), np.isnan(stiffness))
    assert np.nanmax(one["harmonic_stiffness"].values) == pytest.approx(np.nanmax(stiffness))
    assert one["harmonic_stiffness"].attrs["units"] == "N/m"
    assert one.attrs["area_coefficients"] == [25.0, 100.0]
    with pytest.raises(ProblemError, match="2 different area functions"):
        area_function_of([one, two])


def test_texts_of_fischerscope_and_other_indenters(tmp_path):
    time, depth, force = indent_of(50)

    def rows(factor=1.0):
        return [
            "\t".join(f"{v:.9g}".replace(".", ",") for v in row)
            for row in zip(force * 1e3 * factor, depth * 1e6, time + 0.1, strict=True)
        ]

    block = ["Indenter shape correction: Hardness", "HIT\t[N/mm\u00b2]\t8553,6", "F\th\tt"]
    text = ["FS1.hap\tName of the application\t", "1\tNumber of block\t"]
    for k in (1, 2):
        text += [f"FS1.hap   26.05.2020  15:17:5{k}", *block, *rows(float(k)), ""]
    (tmp_path / "fs.txt").write_text("\n".join(text), encoding="latin-1")
    first, second = mdr.read_indents(tmp_path / "fs.txt")
    assert second["normal_force"].values == pytest.approx(2.0 * force, rel=1e-8)
    assert first["indentation"].values == pytest.approx(depth, rel=1e-8)
    lines = [
        f"{h * 1e9:.9f}\t{f * 1e6:.9f}\t{t:.6f}\t0.1\t0.2" for h, f, t in zip(depth, force, time, strict=True)
    ]
    header = [
        "Mon Apr 29 10:41:06 2019",
        "",
        "Number of Points = 100",
        "Depth (nm)\tLoad (\u00b5N)\tTime (s)\tDepth (V)\tLoad (V)",
    ]
    (tmp_path / "lc.txt").write_text("\n".join([*header, *lines]), encoding="latin-1")
    [one] = mdr.read_indents(tmp_path / "lc.txt")
    assert one["normal_force"].values == pytest.approx(force, abs=1e-14)
    (tmp_path / "words.txt").write_text("Method Name : standard\nOwner : somebody\n")
    with pytest.raises(CaseError, match="not a header of columns with units"):
        mdr.read_indents(tmp_path / "words.txt")
