"""Folders of force curves: every file is fitted or excluded with its reason, samples are summarised, and the report is whole."""

import json
from html.parser import HTMLParser

import numpy as np
import pytest

import pymdr as mdr
from legibility import faults

CONTACT = mdr.Contact(mdr.Paraboloid("5 um"), mdr.Elastic("10 kPa", 0.5))
CASE = """title = "Gels <i>and</i> cells"
profile = { kind = "paraboloid", radius = "5 um" }
body = { kind = "elastic", young = "10 kPa", poisson = 0.5 }
"""
SAMPLES = {"old": (3e3, 2.5e3, 3.5e3), "young": (1e3, 1.2e3, 0.9e3)}


def curve_of(young, seed=0, noise=1e-11, rise=0.0, stop=1e-6):
    """A record of a cantilever of 0.05 N/m, with its Hertzian force; `rise` is that of the baseline in N/m."""
    depth = np.linspace(-1.5e-6, stop, 200)
    force = 16 / 9 * young * np.sqrt(5e-6) * np.maximum(depth, 0.0) ** 1.5
    force = force + noise * np.random.default_rng(seed).normal(size=depth.size) + 3e-11
    return mdr.MeasuredCurve(force=force + rise * depth, travel=depth + force / 0.05, spring_constant=0.05)


def write(file, curve, separator=",", comma=False):
    rows = [f"{1e6 * z:.8g}{separator}{1e9 * f:.8g}" for z, f in zip(curve.travel, curve.force, strict=True)]
    text = "\n".join([f"travel [um]{separator}load [nN]", *rows])
    file.write_text(text.replace(".", ",") if comma else text)


@pytest.fixture
def folder(tmp_path):
    root = tmp_path / "gels"
    for i, (name, moduli) in enumerate(SAMPLES.items()):
        (root / name).mkdir(parents=True)
        for k, young in enumerate(moduli):
            write(root / name / f"{k}.csv", curve_of(young, k), ";" if i else ",", comma=bool(i))
    (root / "notes.txt").write_text("measured on a rainy day\n")
    write(root / "old" / "flat.csv", curve_of(0.0, 7))
    (root / ".hidden").write_text("x")
    (tmp_path / "gel.toml").write_text(CASE)
    return root


def test_every_file_is_fitted_or_excluded_with_its_reason(folder):
    read = mdr.read_curve_folder(folder, spring_constant="0.05 N/m")
    assert len(read.curves) == 7
    assert list(read.excluded) == ["notes.txt"]
    study = mdr.fit_each(CONTACT, read.curves, ["body.young"], groups=read.groups, excluded=read.excluded)
    reasons = dict(zip(study["curve"].values, study["excluded"].values, strict=True))
    assert {name for name, reason in reasons.items() if reason} == {"old/flat.csv", "notes.txt"}
    assert "no contact" in reasons["old/flat.csv"]
    assert "table" in reasons["notes.txt"]
    for name, moduli in SAMPLES.items():
        result = study["body.young"].sel(curve=[f"{name}/{k}.csv" for k in range(3)])
        np.testing.assert_allclose(result, moduli, rtol=0.01)
    groups = study.statistics["body.young"]
    np.testing.assert_allclose(groups["median"], [np.median(v) for v in SAMPLES.values()], rtol=0.01)
    assert "flat.csv is excluded: the record shows no contact" in study.summary()
    assert not faults(study.plot())


def test_values_are_those_of_single_fits_and_the_quality_that_of_maps():
    curves = {
        "a": curve_of(1e3),
        "b": curve_of(2e3, 1, rise=1e-3),
        "c": curve_of(2e3, 2, stop=0.05e-6, noise=0.0),
    }
    study = mdr.fit_each(CONTACT, curves, ["body.young"])
    alone = mdr.fit(CONTACT, curves["a"], ["body.young"])["body.young"]
    row = study.data.sel(curve="a")
    assert (float(row["body.young"]), float(row["body.young_low"])) == (alone.value, alone.low)
    fitted = mdr.fit_map(CONTACT, list(curves.values()), ["body.young"])
    for name in ("samples_in_contact", "relative_residual", "baseline_rise"):
        np.testing.assert_allclose(study[name], fitted[name], rtol=0.02, atol=1e-4)
    assert study["good"].values.tolist() == fitted["good"].values.tolist() == [True, False, False]
    assert "baseline rises" in str(study["excluded"][1])
    assert "limit 10" in str(study["excluded"][2])


def test_one_fit_has_its_quality(folder, shell, tmp_path):
    rising = curve_of(2e3, 1, rise=1e-3)
    fitted = mdr.fit(CONTACT, rising, ["body.young"])
    in_map = mdr.fit_map(CONTACT, [rising], ["body.young"])
    for name in mdr.fit(CONTACT, [rising], ["body.young"]).quality._fields:
        assert float(fitted.data[name]) == pytest.approx(float(in_map[name][0]), rel=0.02)
    assert "quality: not good: the baseline rises by " in fitted.summary()
    both = mdr.fit(CONTACT, [curve_of(2e3, 3), rising], ["body.young"])
    assert both.quality.baseline_rise == pytest.approx(fitted.quality.baseline_rise, rel=0.1)
    file = folder / "old" / "0.csv"
    given = ("fit", tmp_path / "gel.toml", file, "--free", "body.young", "--spring-constant", "0.05 N/m")
    status, out, _ = shell(*given, "-o", tmp_path / "out")
    assert status == 0
    assert "quality: good: 80 samples in contact; of the range of the force, residuals 0." in out
    table = np.genfromtxt(tmp_path / "out" / "fit.csv", delimiter=",", names=True)
    quality = json.loads(shell(*given, "--json")[1])["fit"]["quality"]
    assert quality["good"] is True
    for name in fitted.quality._fields:
        assert table[name] == pytest.approx(quality[name], rel=1e-6)


def test_a_fitted_tilt_explains_the_rise_of_the_baseline():
    curves = {"a": curve_of(2e3, 1, rise=1e-3)}
    study = mdr.fit_each(CONTACT, curves, ["body.young", "tilt"])
    fitted = mdr.fit_map(CONTACT, list(curves.values()), ["body.young", "tilt"])
    assert study["good"].values.tolist() == fitted["good"].values.tolist() == [True]
    assert abs(float(study["baseline_rise"][0])) < 0.01


def test_a_common_uncertainty_is_in_the_interval_over_groups_once():
    values, groups = [1e3, 1.1e3, 1.2e3, 1.3e3], ["a", "a", "b", "b"]
    alone, shared = (mdr.summarize_groups(values, groups, common=c) for c in (0.0, 0.1))
    half = [float(np.log(one["typical_high"] / one["typical"])) for one in (alone, shared)]
    assert half[1] == pytest.approx(np.hypot(half[0], 0.1959964), rel=1e-6)
    with pytest.raises(mdr.ProblemError, match="limits 0 and"):
        mdr.summarize_groups(values, groups, common=-1.0)
    curves = {name: curve_of(1e3, i) for i, name in enumerate("abc")}
    study = mdr.fit_each(
        CONTACT,
        curves,
        ["body.young"],
        groups=dict(zip("abc", "112", strict=True)),
        uncertainty={"spring_constant": "10 %"},
    )
    assert "all body.young share: 10 %" in study.statistics["body.young"].notes[0]


class Tags(HTMLParser):
    """Open tags, links, and the text of a page."""

    def __init__(self):
        super().__init__()
        self.open, self.links, self.text = [], [], []

    def handle_starttag(self, tag, attrs):
        self.links += [value for name, value in attrs if name in ("src", "href")]
        if tag not in ("meta", "img"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


def test_the_shell_writes_a_whole_report(folder, shell, tmp_path):
    report = tmp_path / "report.html"
    samples = tmp_path / "samples.csv"
    rows = [f"{name}/0.csv;{name} gel" for name in SAMPLES]
    samples.write_text("\n".join(["file;sample", *rows]))
    status, out, error = shell(
        "fit", tmp_path / "gel.toml", folder, "--free", "body.young", "--spring-constant", "0.05 N/m +- 10 %",
        "--groups", samples, "--report", report, "-o", tmp_path / "out", "--json",
    )  # fmt: skip
    assert status == 0, error
    plain = json.loads(out)
    assert plain["fit"]["groups"]["body.young"]["group"]["values"] == ["old gel", "young gel"]
    assert sum(plain["fit"]["curves"]["good"]["values"]) == 2
    names = {"fit.csv", "fit.png", "groups_body.young.csv"}
    assert {file.name for file in (tmp_path / "out").iterdir()} == names
    page = Tags()
    page.feed(report.read_text())
    text = " ".join(page.text)
    assert not page.open
    assert len(page.links) == 3  # all fits, and each of two records
    assert all(link.startswith("data:image/png;base64,") for link in page.links)  # nothing outside the file
    for part in ("Gels <i>and</i> cells", "pymdr 0", "0.05 N/m +- 10 %", "Groups: body.young", "it is not in", "Assumptions",
                 "Claims", "Sneddon", "old/0.csv"):  # fmt: skip
        assert part in text, part


def test_a_report_of_many_records_draws_all_of_them_on_sheets(tmp_path):
    """Beyond 40 records every fitted one has a small panel, and the reasons of exclusion are sentences without code."""
    curves = {f"gel {i}": curve_of(1e3 + 10.0 * i) for i in range(41)}
    noise = np.random.default_rng(1).normal(size=200)
    curves["noise"] = mdr.MeasuredCurve(force=noise, indentation=np.linspace(-1e-6, 1e-6, 200))
    study = mdr.fit_each(CONTACT, curves, ["body.young"])
    study.to_html(tmp_path / "report.html")
    page = Tags()
    page.feed((tmp_path / "report.html").read_text())
    text = " ".join(page.text)
    assert len(page.links) == 1 + 3
    assert "Records 31 to 41" in text
    assert "check the signs of force and position" in text
    assert "curve.orient" not in text


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("", "the file is empty"),
        ("file,sample\n", "no rows"),
        ("file,sample\nold/0.csv\n", "has no group"),
        ("file,sample\nnone.csv,a\n", "'none.csv' is not in the folder"),
        ("file,sample\nold/0.csv,a\nold/0.csv,b\n", "given twice"),
    ],
)
def test_bad_tables_of_groups_are_refused(folder, tmp_path, table, message):
    (tmp_path / "samples.csv").write_text(table)
    with pytest.raises(mdr.PymdrError, match=message):
        mdr.read_curve_folder(folder, groups=tmp_path / "samples.csv")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--report", "report.pdf"], "ends with '.html'"),
        (["-o", "gels/out"], "is in the folder of the records"),
        (["--over-indentation", "4", "-o", "out"], "give one file"),
        (["--groups", "none.csv"], "none.csv"),
        (["--workers", "2"], "--workers 2 is for a map"),
        (["--uncertainty", "sensitivity"], "--uncertainty"),
    ],
)
def test_bad_options_for_folders_are_refused(folder, shell, tmp_path, monkeypatch, options, message):
    monkeypatch.chdir(tmp_path)
    status, _, error = shell(
        "fit", "gel.toml", "gels", "--free", "body.young", "--spring-constant", "0.05 N/m", *options
    )
    assert status == 1
    assert message in error


def test_empty_folders_and_records_are_refused(tmp_path):
    with pytest.raises(mdr.FileError, match="no files"):
        mdr.read_curve_folder(tmp_path)
    with pytest.raises(mdr.FileError, match="not a folder"):
        mdr.read_curve_folder(tmp_path / "none")
    with pytest.raises(mdr.ProblemError, match="no record"):
        mdr.fit_each(CONTACT, {}, ["body.young"], excluded={"a.csv": "it is empty"})
    with pytest.raises(mdr.ProblemError, match="'a' has no group"):
        mdr.fit_each(CONTACT, {"a": curve_of(1e3)}, ["body.young"], groups={})
    with pytest.raises(mdr.ProblemError, match="none of 1 records can be fitted; a: "):
        mdr.fit_each(CONTACT, {"a": curve_of(0.0)}, ["body.young"])


def test_the_quality_of_several_curves_is_that_of_the_worst():
    contact = mdr.Contact(mdr.Paraboloid("5 um"), mdr.Elastic("20 kPa", 0.5))
    depth = np.linspace(-1e-6, 1e-6, 150)
    force = mdr.solve(contact, mdr.Path(indentation=depth))["normal_force"].values
    draw = np.random.default_rng(0).normal(size=(6, 150)) * force.max()
    curves = [mdr.MeasuredCurve(indentation=depth, force=force + 0.005 * each) for each in draw[:5]]
    bad = mdr.MeasuredCurve(indentation=depth, force=force + 0.25 * draw[5])
    together = mdr.fit(contact, [*curves, bad], ["body.young"]).quality
    alone = mdr.fit(contact, bad, ["body.young"]).quality
    assert together.relative_residual == pytest.approx(alone.relative_residual, rel=0.1)
    assert together.faults()
