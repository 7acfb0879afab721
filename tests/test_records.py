"""Measured records: read as paths, and what their loops dissipate."""

import ast
import csv
import io
import math

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

import pymdr as mdr
from common import STEEL
from drawing import examples
from pymdr.problem.paths import named_channels
from pymdr.workbench.cli import app
from pymdr.workbench.records import turning_points
from pymdr.workbench.tables import read_rheometry

JOINT = mdr.Contact(mdr.Sphere("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(0.3))


def written(file, columns, comment=""):
    rows = zip(*columns.values(), strict=True)
    lines = [comment, ",".join(columns), *(",".join(f"{float(v)!r}" for v in row) for row in rows)]
    file.write_text("\n".join(lines) + "\n", encoding="utf-8-sig")
    return file


def record(u, force):
    return xr.Dataset({"shift": ("step", u), "tangential_force": ("step", force)})


# --- reading ---------------------------------------------------------------------------------------------

NAMES = {
    "indentation": ("displacement [um]", "d [nm]", "Indentation (mm)", "indentation [m]"),
    "normal_force": ("load [mN]", "Force [kN]", "normal_force [N]", "F_N [uN]"),
    "travel": ("travel [um]", "piezo [nm]"),
    "shift": ("shift [um]", "u_x [nm]", "tangential displacement [mm]"),
    "tangential_force": ("tangential force [N]", "F_x [mN]", "friction force [uN]"),
}
PREFIX = {"n": 1e-9, "u": 1e-6, "m": 1e-3, "k": 1e3}


@settings(max_examples=examples(60), deadline=None)
@given(data=st.data())
def test_columns_come_in_any_order_with_any_unit(tmp_path_factory, data):
    chosen = data.draw(st.lists(st.sampled_from(sorted(NAMES)), min_size=1, max_size=5, unique=True))
    size = data.draw(st.integers(1, 5))
    numbers = st.lists(st.just(0.0) | st.floats(1e-280, 1e3), min_size=size, max_size=size)
    columns, expected = {"note": [1.0] * size}, {}
    for name in chosen:
        title = data.draw(st.sampled_from(NAMES[name]))
        unit = title.strip("])").replace("(", "[").split("[")[1]
        values = data.draw(numbers)
        columns[title] = values
        expected[name] = np.array(values) * (PREFIX[unit[0]] if len(unit) > 1 else 1.0)
    order = data.draw(st.permutations(sorted(columns)))
    file = written(tmp_path_factory.mktemp("r") / "r.csv", {n: columns[n] for n in order}, "# measured")
    result = mdr.read_record(file)
    assert set(result) == set(chosen)
    for name, values in expected.items():
        assert result[name].values == pytest.approx(values, rel=1e-14)
    normal = [n for n in ("indentation", "normal_force", "travel") if n in chosen]
    tangential = [n for n in ("shift", "tangential_force") if n in chosen]
    if len(normal) > 1 or len(tangential) > 1:
        with pytest.raises(mdr.PathError, match=r"channels = \[") as refusal:
            mdr.read_path(file)
        # what is recommended works, and loses no direction
        remedy = ast.literal_eval(str(refusal.value).partition("channels = ")[2])
        kept = named_channels(mdr.read_path(file, channels=remedy))
        assert [any(n in kept for n in group) for group in (normal, tangential)] == [
            bool(normal),
            bool(tangential),
        ]
    named = [*normal[-1:], *tangential[-1:]]
    path = mdr.read_path(file, channels=named)
    for name in NAMES:
        values = getattr(path, name)
        assert (values is not None) == (name in named)
        assert values is None or values == pytest.approx(expected[name], rel=1e-14)


@settings(max_examples=examples(20), deadline=None)
@given(
    st.lists(st.floats(-1e6, 1e6, allow_subnormal=False), min_size=2, max_size=9),
    st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "latin-1"]),
    st.sampled_from([",", ";", "\t"]),
    st.booleans(),
    st.booleans(),
)
def test_records_of_other_places(tmp_path_factory, values, encoding, between, quoted, excel):
    """Encodings, decimal commas, quotes and the first line of Excel change nothing."""
    rows = [[repr(v), f"{v + 0.5:.17g}", "all is well, 1,5"] for v in (*values, 0.25)]
    if between != ",":
        rows = [[a.replace(".", ","), b.replace(".", ","), c] for a, b, c in rows]
    else:
        quoted = True
    rows.insert(0, ["load [\u00b5N]", "shift [\u00b5m]", "note"])
    mark = '"' if quoted else ""
    lines = [between.join(f"{mark}{cell}{mark}" for cell in row) for row in rows]
    file = tmp_path_factory.mktemp("record") / "record.csv"
    file.write_bytes("\r\n".join(["sep=" + between] * excel + lines).encode(encoding))
    result = mdr.read_record(file)
    assert result["normal_force"].values == pytest.approx(1e-6 * np.array([*values, 0.25]), rel=1e-12)
    assert result["shift"].values == pytest.approx(1e-6 * (np.array([*values, 0.25]) + 0.5), rel=1e-12)


@pytest.mark.parametrize(
    ("text", "channels", "words"),
    [
        ("a,b\n1,2\n", None, "not a header"),
        ("load,shift\n1,2\n", None, "not a header"),
        ("load [N],shift\n1,2\n", None, "'shift' has no unit"),
        ("load [kg],shift [m]\n1,2\n", None, "does not fit"),
        ("load [N],shift [m]\n1\n", None, "line 2: 1 entries for 2 columns"),
        ("load [N],shift [m]\n1,2\n1,x\n", None, r"line 3: shift \[m\] = 'x' is not a number"),
        ("load [N],shift [m]\n1,\n", None, r"line 2: shift \[m\] = ''; every entry"),
        ("load [N],shift [m]\n1,1e999\n", None, "outside the range of floats"),
        ("time [s]\n1\n", None, "no column of indentation"),
        ("load [N]\n1\n", ["shift"], "no column of 'shift'; it has normal_force"),
        ("load [N]\n1\n", "load", "a list of names"),
        ("load [N]\n1\n", 3, "a list of names"),
        ("time [s],load [N]\n2,1\n1,1\n", None, "must rise"),
        ("load [N],force [N]\n1,1\n", None, "2 columns of normal_force"),
        (
            "load [N];shift [m]\n1.5;2,5\n",
            None,
            r"shift \[m\] = '2,5' is not a number; write all decimals with a point",
        ),
        ("load [N];shift [m]\n1,500;2,500\n", None, "'1,500' is not a number; write all decimals"),
        ('"load [N]"\t"shift [m]"\n"1"\t"x"\n', None, r"line 2: shift \[m\] = 'x' is not a number$"),
        ('load [N];shift [m]\n1;2\n1;"2;3"\n', None, r"line 3: shift \[m\] = '2;3' is not a number"),
        ("load [N]\tshift [m]\n1,2\n", None, "line 2: 1 entries for 2 columns"),
    ],
)
def test_records_that_lie(tmp_path, text, channels, words):
    (tmp_path / "r.csv").write_text(text)
    with pytest.raises(mdr.PymdrError, match=words):
        mdr.read_path(tmp_path / "r.csv", channels=channels)


QUOTING = st.sampled_from([csv.QUOTE_MINIMAL, csv.QUOTE_ALL, csv.QUOTE_NONNUMERIC])


@settings(max_examples=examples(60), deadline=None)
@given(
    st.sampled_from(",;\t"), QUOTING, st.integers(1, 5), st.sampled_from(["note", "a, b", "a; b", 'so "called"', "\t"]),
    st.randoms(),
)  # fmt: skip
def test_tables_of_spreadsheets_are_read(tmp_path_factory, separator, quoting, size, other, rng):
    columns = {"load [mN]": "normal_force", "shift [um]": "shift", other: None}
    order = rng.sample(sorted(columns), 3)
    table = [[rng.uniform(-1e3, 1e3) for _ in order] for _ in range(size)]
    written_ = io.StringIO()
    writer = csv.writer(written_, delimiter=separator, quoting=quoting)
    if quoting == csv.QUOTE_ALL:
        writer.writerow(["# measured"])
    writer.writerow(order)
    writer.writerows(table)
    file = tmp_path_factory.mktemp("r") / "r.csv"
    file.write_text(written_.getvalue(), newline="")
    result = mdr.read_record(file)
    for title, column in zip(order, zip(*table, strict=True), strict=True):
        if (name := columns[title]) is not None:
            factor = 1e3 if name == "normal_force" else 1e6
            assert result[name].values == pytest.approx(np.array(column) / factor, rel=1e-14)


def test_a_case_follows_a_record_as_python_does(tmp_path):
    t = np.linspace(0.01, 1.0, 300)
    load, shift = 50.0 + 5.0 * np.sin(9.0 * t), 0.4 * np.sin(60.0 * t)
    file = written(tmp_path / "record.csv", {"time [s]": t, "load [N]": load, "shift [um]": shift})
    case = tmp_path / "case.toml"
    body = 'kind = "elastic"\nyoung = "210 GPa"\npoisson = 0.3\n'
    case.write_text(
        f'[profile]\nkind = "sphere"\nradius = "10 mm"\n[body]\n{body}[counterbody]\n{body}'
        '[friction]\nkind = "coulomb"\ncoefficient = 0.3\n[[path]]\nkind = "path"\nfile = "record.csv"\n'
    )
    from pymdr.workbench.casefile import read_case

    request = read_case(case)
    assert request.contact == JOINT
    assert request.path == mdr.read_path(file) == mdr.Path(time=t, normal_force=load, shift=shift / 1e6)
    text = case.read_text()
    for extra, words in (
        ('channels = ["shift"]\n', None),
        ("shift = [1.0]\n", "gives both file and shift"),
        ('channels = ["travel"]\n', "no column of 'travel'"),
        (
            'channels = ["travel"]\n',
            "give the title of its column, for example channels = {travel = 'displacement'}",
        ),
        ("stesp = 3\n", "unknown key"),
    ):
        case.write_text(text + extra)
        if words is None:
            assert read_case(case).path.normal_force is None
        else:
            with pytest.raises(mdr.CaseError, match=words):
                read_case(case)


def test_tables_of_results_are_records(tmp_path):
    path = mdr.load("50 N") >> mdr.cycle(shift="0.5 um", steps=40, duration=None)
    result = mdr.solve(JOINT, path)
    result.to_csv(tmp_path / "r.csv", units={"shift": "nm", "normal_force": "mN"})
    head = (tmp_path / "r.csv").read_text().splitlines()[0].split(",")
    assert head[0] == "step"
    assert {"shift [nm]", "normal_force [mN]", "contact_radius [m]"} <= set(head)
    study = mdr.read_record(tmp_path / "r.csv")
    for name in ("indentation", "normal_force", "shift", "tangential_force"):
        assert study[name].values == pytest.approx(result[name].values, rel=1e-13, abs=1e-300)
    with pytest.raises(mdr.QuantityError, match="'slp', which is not written"):
        result.to_csv(tmp_path / "r.csv", units={"slp": "m"})
    with pytest.raises(mdr.FileError, match=r"Result\.to_csv"):
        result.save(tmp_path / "ball.csv")


@pytest.mark.parametrize("file", [None, 3, b"r.csv", "", ["r.csv"], {}])
def test_what_is_no_name_of_a_file_is_refused(file):
    from pymdr.workbench.casefile import read_case

    result = mdr.solve(mdr.Contact(mdr.Paraboloid(1.0), STEEL), mdr.indent(1e-3))
    reading = (mdr.read_path, mdr.read_record, mdr.read_profile, mdr.open_result, read_case)
    for verb, functions in {"read": reading, "write": (result.save, result.to_csv)}.items():
        for function in functions:
            with pytest.raises(mdr.FileError, match=f"cannot {verb} .*: give the name of a file"):
                function(file)


@settings(max_examples=examples(20), deadline=None)
@given(
    st.lists(st.sampled_from(["normal_force", "peak_pressure", "contact_radius"]), min_size=1, unique=True),
    st.booleans(),
)
def test_tables_contain_the_requested_quantities(tmp_path_factory, names, in_mega):
    result = mdr.solve(mdr.Contact(mdr.Paraboloid("1 mm"), STEEL), mdr.indent("1 um", steps=3))
    frame = result.to_dataframe(quantities=names)
    assert list(frame) == names
    file = tmp_path_factory.mktemp("t") / "t.csv"
    units = {"peak_pressure": "MPa"} if in_mega and "peak_pressure" in names else {}
    result.to_csv(file, quantities=names, units=units)
    computed = np.genfromtxt(file, delimiter=",", names=True, deletechars="")
    head = file.read_text().splitlines()[0].split(",")
    assert [title.partition(" [")[0] for title in head] == ["step", *names]
    for name, title in zip(names, computed.dtype.names[1:], strict=True):
        factor = 1e6 if name in units else 1.0
        assert factor * computed[title] == pytest.approx(result[name].values, rel=1e-13)
    assert list(result.to_dataframe()) == list(result.data)
    for wrong, words in (
        ({"quantities": "normal_force"}, "a list of names"),
        ({"quantities": []}, "a list of names"),
        ({"quantities": ["slp"]}, "no quantity 'slp'"),
        ({"quantities": ["pressure"]}, "is a field"),
        (
            {"quantities": ["indentation"], "units": {"peak_pressure": "MPa"}},
            "'peak_pressure', which is not written; add it to the quantities",
        ),
    ):
        with pytest.raises(mdr.QuantityError, match=words):
            result.to_csv(file, **wrong)


# --- loops -----------------------------------------------------------------------------------------------


@settings(max_examples=examples(40), deadline=None)
@given(
    st.floats(1e-9, 1e3),
    st.floats(1e-9, 1e6),
    st.floats(0.01, 1.5),
    st.floats(-1e3, 1e3),
    st.floats(-1e3, 1e3),
    st.integers(1, 6),
    st.integers(400, 900),
)
def test_ellipses_dissipate_their_area(u, f, phase, u0, f0, cycles, rows):
    """A linear solid with a damper: W = pi u F sin(phase), wherever the origins are."""
    t = 2.0 * np.pi * np.arange(round((cycles + 0.6) * rows)) / rows
    loops = mdr.measured_loops(record(u * (u0 + np.sin(t)), f * (f0 + np.sin(t + phase))))
    assert loops.data.sizes["cycle"] == cycles
    assert loops["dissipated_per_cycle"].values == pytest.approx(np.pi * u * f * np.sin(phase), rel=1e-3)
    # the force is read at the sample nearest to the turn of the displacement
    nearby = np.sin(phase) * np.pi / rows
    stiffness = loops["secant_stiffness"].values
    assert stiffness == pytest.approx(f / u * np.cos(phase), rel=1e-3, abs=1.1 * nearby * f / u)
    loss = loops["dissipated_per_cycle"].values
    assert loops["damping_ratio"].values == pytest.approx(loss / (2.0 * np.pi * u * u * stiffness), rel=1e-3)


@pytest.mark.parametrize("amplitude", [0.3e-6, 0.6e-6, 1.2e-6])
def test_loops_of_a_result_are_those_of_the_theory(amplitude):
    result = mdr.solve(JOINT, mdr.load("50 N") >> mdr.cycle(shift=amplitude, cycles=3, steps=6000))
    study = mdr.measured_loops(result)
    expected = mdr.friction_loop(JOINT, [amplitude], normal_force="50 N")
    assert study.data.sizes["cycle"] == 2
    for name in ("amplitude", "force_amplitude", "dissipated_per_cycle", "damping_ratio", "secant_stiffness"):
        assert study[name].values == pytest.approx(float(expected[name][0]), rel=1e-4), name


@settings(max_examples=examples(200), deadline=None)
@given(
    st.lists(st.floats(-1.0, 1.0, allow_subnormal=False), min_size=2, max_size=40, unique=True),
    st.floats(0.05, 1.5),
)
def test_turning_points_are_detected_one_value_after_the_other(values, least):
    """The same as a loop over all values that remembers the extreme since the last turn."""
    results, rising = [], 0
    low = high = 0
    for i, v in enumerate(values):
        if rising >= 0 and v > values[high]:
            high = i
        if rising <= 0 and v < values[low]:
            low = i
        if rising >= 0 and values[high] - v >= least:
            results.append(high)
            rising, low = -1, i
        elif rising <= 0 and v - values[low] >= least:
            results.append(low)
            rising, high = 1, i
    mine = turning_points(np.array(values), least)
    swings = np.diff(np.array(values)[mine])
    assert np.all(np.abs(swings) >= least)
    assert np.all(swings[1:] * swings[:-1] < 0.0)
    assert mine.tolist() == [i for i in results if 0 < i < len(values) - 1]


def test_one_cycle_has_a_loop_and_no_energy_before_it_closes():
    path = mdr.load("50 N") >> mdr.cycle(shift="0.5 um", cycles=1, steps=400)
    single = mdr.measured_loops(mdr.solve(JOINT, path))
    several = mdr.measured_loops(
        mdr.solve(JOINT, mdr.load("50 N") >> mdr.cycle(shift="0.5 um", cycles=2, steps=800))
    )
    assert single.data.sizes["cycle"] == several.data.sizes["cycle"] == 1
    for name in ("amplitude", "force_amplitude", "secant_stiffness", "stick_radius", "contact_radius"):
        assert single.data[name].values == pytest.approx(several.data[name].values, rel=1e-12)
    for name in ("dissipated_per_cycle", "damping_ratio"):
        assert np.isnan(single[name].values).all()
    assert "ends at shift = 0 m before its only cycle closes at 500 nm" in " ".join(single.notes)
    assert several["dissipated_per_cycle"].values > 0.0
    assert len(single.plot().axes) == len(several.plot().axes) - 2
    with pytest.raises(mdr.ProblemError, match="ends before its only cycle closes; give two cycles"):
        mdr.fretting_log(mdr.solve(JOINT, path))


def test_a_record_that_ends_where_its_only_cycle_began_has_an_energy():
    t = np.linspace(0.0, 2.25 * math.tau, 9001)[
        : 9001 - 4000 + 1
    ]  # a quarter before the cycle, which it ends
    loops = mdr.measured_loops(record(np.sin(t), 2.0 * np.sin(t + 0.1)))
    assert loops["dissipated_per_cycle"].values == pytest.approx(2.0 * math.pi * math.sin(0.1), rel=1e-5)


def test_bad_records_are_refused():
    t = np.linspace(0.0, 20.0, 400)
    for data, words in (
        (xr.Dataset({"shift": ("step", t)}), "the record has shift"),
        (record(t, t), "never reverses by more than .* two reversals"),
        (record(0.0 * t, t), "does not change"),
        (record(t[:1], t[:1]), "the record has one row, but a cycle needs two reversals"),
        (record(np.sin(t), 0.0 * t), "the largest tangential_force = 0 N"),
        (record(1e-300 * np.sin(t), t), "the swing of shift = 2e-300 m: it must be at least 1e-60 m"),
        (record(np.sin(t), 1e-300 * np.sin(t)), "the largest tangential_force = 1e-300 N"),
        (record(1e200 * np.sin(t), t), "at most 1e.60 m"),
        (record(np.where(t > 3.0, math.nan, t), t), "missing in row"),
    ):
        with pytest.raises(mdr.ProblemError, match=words):
            mdr.measured_loops(data)
    loops = mdr.measured_loops(record(np.sin(t), np.sin(t + 0.1)))
    with pytest.raises(mdr.QuantityError, match="damping_ratio"):
        loops["slip"]
    assert not any("give energy" in note for note in loops.notes)
    assert "interchanged" in mdr.measured_loops(record(np.sin(t + 0.1), np.sin(t))).notes[-1]
    falling = mdr.measured_loops(record(np.sin(t), -np.sin(t)))
    assert np.isnan(falling["damping_ratio"]).all()
    assert " - " in falling.summary()
    assert "mean" in loops.summary()
    assert "mean" in loops._repr_html_()
    many = mdr.measured_loops(record(np.sin(20.0 * t), np.sin(20.0 * t + 0.1)))
    assert "40 of 63 rows" in str(many)
    assert len(many.plot().axes) == 6


def test_small_cycles_inside_a_cycle_are_named():
    """Cycles that grow from below the smallest turn: those before it are in the first that exceeds it."""
    t = np.linspace(0.0, 40.0 * np.pi, 8001)
    u = np.where(t < 20.0 * np.pi, 0.09, 1.0) * np.sin(t)
    u[t < 4.0 * np.pi] *= 10.0
    grown = record(u, np.sin(t + 0.1))
    loops = mdr.measured_loops(grown)
    named = [note for note in loops.notes if "a smaller least, such as 100 mm" in note]
    assert len(named) == 1
    assert named[0].startswith("cycle 2 contains turns of shift by less than 200 mm")
    finer = mdr.measured_loops(grown, least=0.1)
    assert not any("smaller least" in note for note in finer.notes)
    assert finer.data.sizes["cycle"] > loops.data.sizes["cycle"] + 7


@settings(max_examples=examples(30), deadline=None)
@given(
    units=st.sampled_from([("um", "mN", 1e-6, 1e-3), ("nm", "N", 1e-9, 1.0), ("m", "kN", 1.0, 1e3)]),
    lag=st.floats(0.01, 1.0),
)
def test_units_of_a_record_are_read(units, lag):
    length, force, in_m, in_n = units
    t = np.linspace(0.0, 4.4 * np.pi, 2001)
    u, pull = np.sin(t), np.sin(t + lag)
    given = record(u, pull)
    given["shift"].attrs["units"], given["tangential_force"].attrs["units"] = length, force
    given["time"] = ("step", t, {"units": "ms"})
    result, bare = mdr.measured_loops(given), mdr.measured_loops(record(in_m * u, in_n * pull))
    for name in bare.data:
        assert result[name].values == pytest.approx(bare[name].values, rel=1e-12)
    rows = result["last_row"].values - 1, result["first_row"].values - 1
    assert result["duration"].values == pytest.approx(1e-3 * (t[rows[0]] - t[rows[1]]), rel=1e-12)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (None, "NoneType is not a record"),
        ({"shift": np.zeros(5), "tangential_force": np.zeros(5)}, "dict is not a record"),
        (
            xr.Dataset({n: (("a", "b"), np.zeros((3, 3))) for n in ("shift", "tangential_force")}),
            "one dimension",
        ),
        (xr.Dataset({"shift": ("a", np.zeros(3)), "tangential_force": ("b", np.zeros(4))}), "one dimension"),
        (record(np.array(["0", "1"]), np.zeros(2)), "real numbers"),
        (
            record(np.zeros(2), np.zeros(2)).assign(shift=("step", np.zeros(2), {"units": "N"})),
            "unit of shift",
        ),
        (
            record(np.sin(np.arange(99.0)), np.ones(99)).assign(
                time=("step", np.arange(99).astype("M8[ns]"))
            ),
            "time is of",
        ),
    ],
)
def test_what_is_no_record_is_refused(given, words):
    with pytest.raises(mdr.PymdrError, match=words):
        mdr.measured_loops(given)


@settings(max_examples=examples(9), deadline=None)
@given(st.floats(0.05, 0.9), st.integers(2, 4))
def test_loops_of_a_saved_result(tmp_path_factory, fraction, cycles):
    """The shell tells of a result what the script does."""
    joint = mdr.Contact(mdr.Paraboloid("10 mm"), mdr.Elastic("200 GPa", 0.3), friction=mdr.Coulomb(0.3))
    swing = mdr.cycle(shift=fraction * 1e-7, cycles=cycles, steps=40 * cycles)
    result = mdr.solve(joint, mdr.indent("1 um") >> swing)
    file = tmp_path_factory.mktemp("loops") / "result.nc"
    result.save(file)
    for place in (file, file.parent):
        shown = CliRunner().invoke(app, ["loops", str(place)])
        assert shown.exit_code == 0
        # the first line is the name of the file
        assert shown.output.strip().endswith(mdr.measured_loops(result).summary().strip())


# --- records after other legs ----------------------------------------------------------------------------

STEEL_TABLE = 'kind = "elastic"\nyoung = "210 GPa"\npoisson = 0.3\n'
FRETTING = (
    f'[profile]\nkind = "sphere"\nradius = "10 mm"\n[body]\n{STEEL_TABLE}[counterbody]\n{STEEL_TABLE}'
    '[friction]\nkind = "coulomb"\ncoefficient = 0.3\n[[path]]\nkind = "load"\nnormal_force = "50 N"\n{preload}'
    '[[path]]\nkind = "path"\nfile = "record.csv"\nchannels = { shift = "Displacement" }\n'
)


@settings(max_examples=examples(10), deadline=None)
@given(
    st.floats(0.05, 0.5), st.integers(2, 4), st.integers(40, 80), st.floats(-3.0, 1e4), st.sampled_from([None, 0.5])
)  # fmt: skip
def test_a_record_follows_a_preload(tmp_path_factory, amplitude, cycles, rows, start, duration):
    """The loops of the theory, whatever the clock of the record; all rows survive a file."""
    from pymdr.workbench.casefile import read_case

    folder = tmp_path_factory.mktemp("fretting")
    t = np.arange(4 * rows * cycles + 1) / (4 * rows)
    swing = amplitude * np.sin(2.0 * np.pi * t)
    columns = {"time [s]": start + t, "displacement [um]": swing, "friction force [N]": 10.0 * swing}
    written(folder / "record.csv", columns)
    preload = "" if duration is None else f"duration = {duration}\n"
    (folder / "case.toml").write_text(FRETTING.replace("{preload}", preload))
    case = read_case(folder / "case.toml")
    result = mdr.solve(case.contact, case.path)
    begin = duration or 0.0
    assert result["time"].values == pytest.approx(
        np.append(begin, begin + t + t[1]), abs=1e-11 * (1.0 + abs(start))
    )
    loops = mdr.measured_loops(result)
    expected = mdr.friction_loop(JOINT, [1e-6 * amplitude], normal_force="50 N")
    assert loops.data.sizes["cycle"] == cycles - 1
    assert loops["dissipated_per_cycle"].values == pytest.approx(
        float(expected["dissipated_per_cycle"][0]), rel=3e-3
    )
    contact_radius = float(result["contact_radius"][-1])
    stick = float(expected["stick_ratio"][0]) * contact_radius
    assert loops["stick_radius"].values == pytest.approx(stick, rel=1e-9)
    assert loops["contact_radius"].values == pytest.approx(contact_radius, rel=1e-12)
    # mu times the pressure of Hertz at the edge of stick
    peak = 0.3 * 1.5 * 50.0 / (np.pi * contact_radius**2) * np.sqrt(1.0 - (stick / contact_radius) ** 2)
    assert loops["peak_shear_traction"].values == pytest.approx(peak, rel=2e-4)
    result.save(folder / "result.nc")
    again = mdr.open_result(folder / "result.nc")
    assert again.path == result.path
    assert mdr.measured_loops(again).summary() == loops.summary()


def test_loops_of_a_case_from_the_shell(tmp_path, shell):
    t = np.linspace(0.0, 2.0, 161)
    written(tmp_path / "record.csv", {"time [s]": t, "displacement [um]": 0.3 * np.sin(2.0 * np.pi * t)})
    (tmp_path / "case.toml").write_text(FRETTING.replace("{preload}", ""))
    status, output, _ = shell("loops", tmp_path / "case.toml", "-o", tmp_path / "out")
    assert status == 0
    for words in (
        "stick radius",
        "contact radius",
        "peak shear",
        "APPROXIMATE: stick_radius, peak_shear_traction",
    ):
        assert words in output
    head = (tmp_path / "out" / "loops.csv").read_text().splitlines()[0]
    assert "stick_radius [m]" in head
    assert (tmp_path / "out" / "loops.png").exists()


def test_records_after_other_legs_are_refused_where_time_counts(tmp_path):
    gel = mdr.Viscoelastic(mdr.Prony("1 kPa", ["1 kPa"], ["1 s"]), poisson=0.5)
    later = mdr.Path(time=[3.0, 4.0], normal_force=[1e-3, 2e-3], relative_time=True)
    path = mdr.load("1 mN") >> later
    with pytest.raises(mdr.PathError, match="leg 1 has no time, but leg 2 has"):
        mdr.solve(mdr.Contact(mdr.Sphere("1 mm"), gel), path)
    with pytest.raises(mdr.PathError, match="legs 1 and 3 have no time, but leg 2 has"):
        mdr.solve(JOINT, path >> mdr.load("3 mN"))
    with pytest.raises(mdr.PathError, match="no sampling interval"):
        mdr.Path(time=[3.0], shift=[0.0], relative_time=True)
    file = written(tmp_path / "r.csv", {"time [s]": [0.0, 1.0], "displacement [um]": [0.0, 1.0]})
    assert mdr.read_path(file, channels={"shift": "Displacement [um]"}).shift[-1] == pytest.approx(1e-6)
    for channels, words in (
        ({"shft": "displacement"}, "channels: 'shft' = 'displacement'"),
        ({"shift": 3}, "channels: 'shift' = 3"),
        ({"shift": "position"}, "no column of shift"),
        ({"time": "time"}, "a list of names"),
    ):
        with pytest.raises(mdr.PymdrError, match=words):
            mdr.read_path(file, channels=channels)


@settings(max_examples=examples(6), deadline=None)
@given(st.integers(1, 12), st.floats(0.01, 10.0))
def test_tables_hold_the_peak_pressure(tmp_path_factory, steps, load):
    """Of few rows by themselves, 1.5 times the mean for Hertz; not where the method refuses it, nor of long results."""
    file = tmp_path_factory.mktemp("t") / "t.csv"
    result = mdr.solve(mdr.Contact(mdr.Paraboloid("1 mm"), STEEL), mdr.load(load, steps=steps))
    result.to_csv(file, units={"peak_pressure": "MPa"})
    computed = np.genfromtxt(file, delimiter=",", names=True, deletechars="").reshape(-1)
    assert 1e6 * computed["peak_pressure_[MPa]"] == pytest.approx(
        1.5 * result["mean_pressure"].values, rel=1e-9
    )
    curve = mdr.ForceCurve(np.linspace(0.0, 1e-6, 9), np.linspace(0.0, 1.0, 9) ** 1.5, modulus="1 GPa")
    for other in (
        mdr.solve(mdr.Contact(curve, mdr.Elastic("1 GPa", 0.3)), mdr.indent("0.5 um", steps=3)),
        mdr.solve(mdr.Contact(mdr.Paraboloid("1 mm"), STEEL), mdr.load(load, steps=501)),
    ):
        other.to_csv(file)
        assert "peak_pressure" not in file.read_text().splitlines()[0]


def test_loops_name_the_rows_outside_of_cycles_and_open_loops():
    """Two cycles of 1 and 2 um that begin at 0: one lies between turning points, and it is open by 1 um."""
    shift = 1e-6 * np.array([0.0, 1.0, 0.0, -1.0, 0.0, 2.0, 0.0, -2.0, 0.0])
    record = xr.Dataset({"shift": ("step", shift), "tangential_force": ("step", 1e6 * shift)})
    rows, opened = mdr.measured_loops(record).notes
    assert rows.startswith("rows 1 to 1 and 7 to 9 of 9 are in no cycle")
    assert opened.startswith("cycle 1 ends at another shift than at the beginning (by 1 \N{MICRO SIGN}m)")
    again = 1e-6 * np.array([0.0, 1.0, -1.0, 1.0, 0.0])
    closed = mdr.measured_loops(
        xr.Dataset({"shift": ("step", again), "tangential_force": ("step", again)})
    ).notes
    assert [note.split(" are")[0] for note in closed] == ["rows 1 to 1 and 5 to 5 of 5"]


def test_a_tangential_force_without_shift_is_refused_with_the_columns_it_has(tmp_path):
    t = np.linspace(0.0, 3.0, 301)
    rows = [f"{a:.3f},50,{np.sin(6.283 * a):.6f},{np.sin(6.283 * a + 0.1):.6f}" for a in t]
    rig = tmp_path / "rig.csv"
    rig.write_text("\n".join(["time [s],load [N],displacement [um],friction force [N]", *rows]))
    words = r"no shift \(it has time, indentation, normal_force, tangential_force\); name the column .* 'shift \[um\]'"
    for verb in (mdr.measured_loops, mdr.fretting_log):
        with pytest.raises(mdr.ProblemError, match=words):
            verb(mdr.read_record(rig))
    rig.write_text("\n".join(["time [s],load [N],shift [um],friction force [N]", *rows[::-1]]))
    assert "run backward in time" in " ".join(mdr.measured_loops(mdr.read_record(rig)).notes)


def test_frequency_sweeps_may_fall(tmp_path):
    w = np.geomspace(0.1, 1e3, 41)
    rubber = mdr.StandardSolid("1 MPa", "3 MPa", "20 ms")
    rows = [
        f"{a / (2 * np.pi)},{b},{c}" for a, b, c in zip(w, rubber.storage(w), rubber.loss(w), strict=True)
    ]
    times = []
    for name, order in (("up.csv", 1), ("down.csv", -1)):
        (tmp_path / name).write_text("\n".join(["frequency [Hz],G' [Pa],G'' [Pa]", *rows[::order]]))
        times.append(mdr.Prony.from_dma(*read_rheometry(tmp_path / name).values()).times)
    assert times[0] == pytest.approx(times[1], rel=1e-12)
    assert times[0] == pytest.approx([0.02], rel=1e-6)
