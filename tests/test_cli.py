"""Case files and the command line."""

import importlib.util
import json
import os
import re
import stat
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
import typer
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

import pymdr as mdr
from common import BALL_CASE
from drawing import examples
from pymdr.problem.codec import decode_press
from pymdr.workbench.casefile import read_case, read_contact
from pymdr.workbench.cli import app
from pymdr.workbench.cli.wording import error_text
from pymdr.workbench.templates import template


@pytest.fixture
def case(tmp_path):
    file = tmp_path / "ball.toml"
    file.write_text(BALL_CASE)
    return file


def test_run_writes_everything_and_prints_the_summary(case, tmp_path, shell):
    status, out, err = shell("run", case, "-o", tmp_path / "out")
    assert (status, err) == (0, "")
    assert "A ball" in out
    assert "normal force" in out
    assert "50 N" in out
    written = sorted(p.name for p in (tmp_path / "out").iterdir())
    assert written == ["curves.png", "fields.png", "result.nc", "section.png"]
    result = mdr.open_result(tmp_path / "out" / "result.nc")
    assert float(result["normal_force"][-1]) == pytest.approx(50.0, rel=1e-12)


def test_quiet_and_json(case, tmp_path, shell):
    status, out, _ = shell("run", case, "-o", tmp_path / "out", "--quiet")
    assert (status, out) == (0, "")
    status, out, _ = shell("run", case, "-o", tmp_path / "out", "--json")
    data = json.loads(out)
    assert data["last"]["normal_force"]["value"] == pytest.approx(50.0, rel=1e-12)
    assert data["claims"]["pressure"]["level"] == "EXACT"


def test_check_solves_nothing(case, tmp_path, shell):
    status, out, _ = shell("check", case)
    assert status == 0
    assert "EXACT" in out
    assert sorted(p.name for p in tmp_path.iterdir()) == ["ball.toml"]


def test_plot_draws_a_saved_result(case, tmp_path, shell):
    shell("run", case, "-o", tmp_path / "out", "--quiet")
    for png in (tmp_path / "out").glob("*.png"):
        png.unlink()
    assert shell("plot", tmp_path / "out" / "result.nc", "--quiet")[0] == 0
    assert len(list((tmp_path / "out").glob("*.png"))) == 3


def test_verify_prints_both_solutions(case, tmp_path, shell):
    status, out, _ = shell("verify", case, "-o", tmp_path / "v", "--rings", "60", "--steps", "2")
    assert status == 0
    assert "rings" in out
    assert (tmp_path / "v" / "verify.png").stat().st_size > 10_000


def test_verify_follows_a_body_that_remembers(tmp_path, shell):
    case = tmp_path / "gel.toml"
    case.write_text(
        'path = [{ kind = "indent", indentation = "0.1 mm", duration = "1 s", steps = 4 }]\n'
        '[profile]\nkind = "paraboloid"\nradius = "5 mm"\n'
        '[body]\nkind = "viscoelastic"\npoisson = 0.5\n'
        'shear = { kind = "maxwell", modulus = "1 MPa", time = "1 s" }\n'
    )
    status, out, _ = shell("verify", case, "-o", tmp_path / "v", "--rings", "40", "--steps", "2", "--json")
    data = json.loads(out)["verification"]
    assert status == 0
    assert data["largest_difference"] < 1e-3
    assert {"time", "row", "normal_force_rings"} <= set(data["table"])
    assert (tmp_path / "v" / "verify.png").stat().st_size > 10_000
    status, _, err = shell("verify", case, "-o", tmp_path / "none", "--steps", "0")
    assert status == 1
    assert "steps = 0; a whole number of at least 1" in err
    assert not (tmp_path / "none").exists()


def test_help_and_version(shell):
    assert "run" in CliRunner().invoke(app, ["--help"]).output
    assert mdr.__version__ in shell("--version")[1]


def test_every_command_has_one_line_of_help():
    lines = (
        CliRunner().invoke(app, ["--help"], env={"COLUMNS": "80", "TERMINAL_WIDTH": "80"}).output.split("\n")
    )
    listed = lines[lines.index("Commands:") + 1 :]
    assert len([line for line in listed if line]) == len(app.registered_commands)
    assert all(line.endswith(".") and "..." not in line for line in listed if line)


def test_help_loads_nothing_that_computes():
    code = (
        "import sys; sys.argv = ['pymdr', '--help']\n"
        "from pymdr.workbench.cli import main\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        "print(*sys.modules, file=sys.stderr)"
    )
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = {name for name in ended.stderr.split() if name.split(".")[0] not in sys.stdlib_module_names}
    assert not {"numpy", "scipy", "xarray", "pydantic", "pint", "matplotlib", "numba", "rich"} & loaded
    ours = {name for name in loaded if name.startswith("pymdr.") and "workbench" not in name}
    assert ours == {"pymdr.errors"}


def test_importing_loads_nothing_that_computes():
    code = "import sys, pymdr; assert len(dir(pymdr)) > 100; print(*sys.modules)"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = {name.partition(".")[0] for name in ended.stdout.split()}
    assert not {"numpy", "scipy", "xarray", "pydantic", "pint", "matplotlib", "numba"} & loaded


def test_a_contact_in_closed_form_loads_no_more_than_it_needs(case):
    code = (
        "import sys; from pymdr.solving.verb import solve; from pymdr.workbench.casefile import read_case\n"
        f"case = read_case({str(case)!r}); result = solve(case.contact, case.path)\n"
        "print(float(result['normal_force'][-1]), result.field('pressure').size)\n"
        "print(*sys.modules)"
    )
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ended.stdout.startswith("50.0 ")
    numerics = {f"scipy.{name}" for name in ("special", "optimize", "linalg", "interpolate", "ndimage")}
    others = {"pymdr.line.friction", "pymdr.line.following", "pymdr.solving.closure"}
    assert not (numerics | others | {"matplotlib", "numba", "pint", "rich"}) & set(ended.stdout.split())


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('radius = "10 mm"', 'radus = "10 mm"', ["[profile]", "radus", "did you mean 'radius'"]),
        ("[body]", "[boddy]", ["boddy", "did you mean 'body'"]),
        ('kind = "sphere"', 'kind = "spere"', ["[profile]", "spere", "did you mean 'sphere'"]),
        ('kind = "sphere"\n', "", ["[profile]", "'kind' is missing"]),
        ('kind = "load"', 'kind = "laod"', ["path", "laod", "did you mean 'load'"]),
        ("steps = 3", "stesp = 3", ["path", "stesp", "did you mean 'steps'"]),
        ("steps = 3", "steps = 0", ["steps", "0", "at least 1"]),
        ("steps = 3", "steps = 2.5", ["steps", "2.5"]),
        ('"10 mm"', '"1,5 mm"', ["[profile]", "] radius: ", "1,5 mm", "decimal point"]),
        ('"10 mm"', '"9**9 m"', ["[profile]", "9**9 m"]),
        ('"10 mm"', '"5 kg"', ["[profile]", "kg", "does not fit"]),
        ('"10 mm"', '"5 parsnips"', ["[profile]", "unknown unit", "parsnips"]),
        ('"10 mm"', '"-1 mm"', ["[profile]", "-1 mm", "above 0 m"]),
        ('"10 mm"', "nan", ["[profile]", "not finite"]),
        ('"210 GPa"', '"-210 GPa"', ["[body] young = ", "above 0 Pa"]),
        ("poisson = 0.3", "poisson = 0.6", ["[body] poisson = ", "at most 0.5"]),
        ("poisson = 0.3", "", ["[body]", "'poisson' is missing"]),
        ('"50 N"', '"-50 N"', ["normal_force", "-50"]),
        ("[profile]", "[solve]\ntolerance = nan\n[profile]", ["[solve] tolerance = nan: a finite number"]),
        ("[profile]", "[solve]\ntolerance = true\n[profile]", ["[solve] tolerance = True: a number is"]),
        ("[profile]", "[solve]\ntolerance = '1e-4'\n[profile]", ["[solve] tolerance = '1e-4': a number is"]),
        (
            "[profile]",
            "[solve]\ntolerance = 1e-4\n[profile]",
            ["ball.toml: [solve] tolerance = 0.0001; it is for"],
        ),
        (
            "[profile]",
            "[solve]\nmachine_stiffness = -1\n[profile]",
            ["[solve] machine_stiffness = -1: it must be"],
        ),
        ("[profile]", "[profile", ["not TOML"]),
        ('radius = "10 mm"', 'radius = "10 mm"\nfile = "x.csv"', ["[profile]", "file"]),
    ],
)
def test_errors_name_file_table_key_value_and_limit(case, shell, tmp_path, old, new, words):
    case.write_text(BALL_CASE.replace(old, new))
    status, out, err = shell("run", case, "-o", tmp_path / "out")
    assert (status, out) == (1, "")
    assert err.count("\n") == 1
    for word in words if new == '"-50 N"' else [case.name, *words]:
        assert word in err
    assert not (tmp_path / "out" / "result.nc").exists()


def test_messages_begin_with_no_name_of_python(case, shell, tmp_path):
    still = tmp_path / "still.csv"
    still.write_text("shift [um],tangential force [N]\n" + "1,1\n" * 20)
    for command, words in (
        (("loops", still), "shift does not change"),
        (
            ("pull-off", case),
            "the contact has no adhesion; give [adhesion] kind = 'jkr', work = '50 mJ/m^2'",
        ),
    ):
        status, _, error = shell(*command)
        assert status != 0
        assert error.startswith(f"pymdr: {words}"), error
        assert not re.match(r"pymdr: \w+_\w+: ", error)


def test_a_noisy_tip_is_told_of_its_one_line(tmp_path, monkeypatch, shell):
    """And files keep their names, entries are counted from 1."""
    monkeypatch.chdir(tmp_path)
    case, table = Path("tip.toml"), Path("Tip.csv")
    r = np.linspace(0.0, 300.0, 61)
    f = r**2 / 400.0 + np.random.default_rng(0).normal(0.0, 0.15, 61)
    f[0] = 0.0
    rows = ["r [nm],f [nm]", *(f"{x},{y:.4f}" for x, y in zip(r, f, strict=True))]
    table.write_text("\n".join(rows))
    case.write_text(
        "[profile]\nkind = 'sampled'\nfile = 'Tip.csv'\n[body]\nkind = 'elastic'\nyoung = '1 GPa'\npoisson = 0.5\n"
        "[adhesion]\nkind = 'jkr'\nwork = '20 mJ/m^2'\n"
    )
    assert shell("pull-off", case)[2].endswith(
        "smooth them with interpolation = { kind = 'smoothing_spline' }, in Python with SmoothingSpline\n"
    )
    table.write_text("\n".join([rows[0], "x,0"]))
    assert shell("pull-off", case)[2].startswith("pymdr: tip.toml: [profile] Tip.csv, line 2: r [nm] = 'x'")
    case.write_text(case.read_text().replace("file = 'Tip.csv'", "radius = [0, '1']\nheight = [0, 1e-9]"))
    assert "[profile] entry 2 of radius: '1' has no unit" in shell("pull-off", case)[2]


def test_empty_path_missing_file_and_binary(case, shell, tmp_path):
    case.write_text("path = []\n" + BALL_CASE[: BALL_CASE.index("[[path]]")])
    assert "path" in shell("check", case)[2]
    status, _, err = shell("run", tmp_path / "none.toml")
    assert status == 1
    assert "none.toml" in err
    (tmp_path / "b.toml").write_bytes(b"\xff\xfe\x00")
    assert "UTF-8" in shell("check", tmp_path / "b.toml")[2]


def test_unwritable_folder_is_refused_before_any_work(case, shell, tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    status, _, err = shell("run", case, "-o", blocked / "out")
    assert status == 1
    assert "cannot write" in err


def test_result_files_that_are_truncated_or_not_ours(case, shell, tmp_path):
    shell("run", case, "-o", tmp_path / "out", "--quiet")
    whole = (tmp_path / "out" / "result.nc").read_bytes()
    (tmp_path / "half.nc").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "text.nc").write_text("hello")
    import xarray as xr

    xr.Dataset({"a": ("x", [1.0])}).to_netcdf(tmp_path / "other.nc", engine="h5netcdf")
    for name in ("half.nc", "text.nc", "other.nc", "none.nc"):
        status, _, err = shell("plot", tmp_path / name)
        assert status == 1, name
        assert err.startswith("pymdr: ")
        assert "Traceback" not in err


def test_files_are_written_whole_with_ordinary_permissions(case, shell, tmp_path):
    shell("run", case, "-o", tmp_path / "out", "--quiet")
    umask = os.umask(0)
    os.umask(umask)
    mode = stat.S_IMODE((tmp_path / "out" / "result.nc").stat().st_mode)
    assert mode == 0o666 & ~umask
    assert not [p for p in (tmp_path / "out").iterdir() if p.name.startswith(".")]


def test_a_case_reads_as_the_python_values(case):
    request = read_case(case)
    assert request.contact == mdr.Contact(mdr.Sphere("10 mm"), mdr.Elastic("210 GPa", 0.3))
    assert request.path == mdr.load("50 N", steps=3)
    assert request.title == "A ball"


def test_sum_of_profiles_hold_ramp_and_arrays(tmp_path):
    file = tmp_path / "c.toml"
    file.write_text(
        """
        [profile]
        kind = "sum"
        parts = [{kind = "flat_punch", radius = "1 mm"}, {kind = "cone", half_angle = "85 deg"}]
        [body]
        kind = "elastic"
        young = 1e6
        poisson = 0.5
        [counterbody]
        kind = "rigid"
        [[path]]
        kind = "ramp"
        indentation = "1 um"
        steps = 2
        [[path]]
        kind = "hold"
        steps = 2
        [[path]]
        kind = "path"
        indentation = ["2 um", 3e-6]
        """
    )
    request = read_case(file)
    assert request.contact.profile == mdr.FlatPunch(1e-3) + mdr.Cone(half_angle="85 deg")
    assert mdr.solve(request.contact, request.path)["indentation"].values.tolist() == pytest.approx(
        [0.5e-6, 1e-6, 1e-6, 1e-6, 2e-6, 3e-6], rel=1e-12
    )


def test_several_cases_keep_going_past_one_that_fails(case, tmp_path, shell):
    broken = tmp_path / "broken.toml"
    broken.write_text(BALL_CASE.replace("10 mm", "-10 mm"))
    status, out, err = shell("run", broken, case, "-o", tmp_path / "out")
    assert status == 1
    assert "A ball" in out
    assert "1 of 2 cases failed" in err
    assert (tmp_path / "out" / "ball" / "result.nc").exists()
    assert not (tmp_path / "out" / "broken" / "result.nc").exists()
    status, out, _ = shell("run", broken, case, "-o", tmp_path / "out", "--json")
    assert [answer["status"] for answer in json.loads(out)] == ["FAILED", "COMPLETED"]
    assert [answer["error"] is None for answer in json.loads(out)] == [False, True]


@pytest.mark.parametrize("kind", ["ball", "cone", "worn", "punch", "cycle", "tip"])
def test_new_cases_are_valid(kind, tmp_path, shell):
    file = tmp_path / "new.toml"
    assert shell("new", kind, "-o", file)[0] == 0
    if kind == "tip":
        (tmp_path / "tip.csv").write_text("r [nm],f [nm]\n0,0\n20,2\n40,8\n60,18\n80,32\n99,49\n")
    status, out, err = shell("check", file)
    assert (status, err) == (0, "")
    assert f"My {kind}" in out
    status, _, err = shell("new", kind, "-o", file)
    assert status == 1
    assert "already exists" in err


def test_new_of_an_unknown_kind(shell):
    assert "did you mean 'cone'" in shell("new", "conee")[2]


def test_a_new_rough_case_is_answered(tmp_path, shell):
    file = tmp_path / "new.toml"
    assert shell("new", "rough", "-o", file)[0] == 0
    status, out, err = shell("rough", file, "--realisations", "2", "--json")
    assert (status, err) == (0, "")
    assert json.loads(out)["title"] == "My rough"
    other = file.with_name("other.toml")
    text = file.read_text()
    for line, unit, values in (
        ("indentation = 5e-7", "m", [5e-7]),
        ('normal_force = [ "0.1 N", 2 ]', "N", [0.1, 2.0]),
        ("# no load", "N", [3.0]),
    ):
        other.write_text(re.sub("^normal_force.*", line, text, flags=re.MULTILINE))
        given = () if unit in line or values != [3.0] else ("--normal-force", "3 N")
        status, out, err = shell("rough", other, *given, "--realisations", "2", "--json")
        assert (status, err) == (0, "")
        column = json.loads(out)["study"]["normal_force" if unit == "N" else "indentation"]
        assert (column["values"], column["unit"]) == (values, unit)
    for line, words in (
        ('normal_force = "1 N"\nindentation = 1e-6', "normal_force and indentation: give one of them"),
        ('normal_force = "1"', "normal_force: '1' has no unit; write for example '50 N'"),
        ("normal_force = nan", "nan is not finite"),
        ("normal_forc = 1", "normal_forc = 1: unknown key; did you mean 'normal_force'?"),
    ):
        other.write_text(re.sub("^normal_force.*", line, text, flags=re.MULTILINE))
        for command in ("check", "rough", "press"):
            assert words in shell(command, other)[2]
    schema = json.loads(shell("schema", "--rough")[1])
    assert set(schema["required"]) == {"surface", "body"}
    assert "above 0 and at most 1" in schema["$defs"]["surface"]["properties"]["hurst"]["description"]


@pytest.mark.skipif(
    importlib.util.find_spec("ContactMechanics") is None,
    reason="ContactMechanics, of the extra rough, is missing",
)
def test_a_new_case_of_a_pressed_surface_is_answered(tmp_path, shell):
    file = tmp_path / "new.toml"
    assert shell("new", "press", "-o", file)[0] == 0
    status, _, err = shell("press", file, "--quiet")
    assert (status, err) == (0, "")
    file.write_text(re.sub("^# (punch)", r"\1", file.read_text(), flags=re.MULTILINE))
    assert "always a punch" in shell("press", file, "--normal-force", "1 N")[2]


def test_a_new_case_of_a_pressed_surface_shows_every_key_of_measured_heights():
    text = template("press")
    random = re.search(r"^hurst.*?(?=^# file)", text, re.MULTILINE | re.DOTALL).group()
    measured = tomllib.loads(re.sub(r"^# (?=\w+ = )", "", text.replace(random, ""), flags=re.MULTILINE))
    case = decode_press(measured)
    assert set(case.surface) == {"file", "channel", "size", "unit", "missing", "detrend"}
    assert case.punch


def test_the_schemas_of_surfaces(shell):
    schema = json.loads(shell("schema", "--press")[1])
    assert set(schema["required"]) == {"surface", "body"}
    assert {"punch", "surface", "counterbody"} <= set(schema["properties"])
    assert set(schema["$defs"]["measured"]["properties"]) == {
        "file",
        "channel",
        "size",
        "unit",
        "missing",
        "detrend",
    }
    assert shell("schema", "--press", "--rough")[0] == 2


def test_schema_and_info(shell):
    schema = json.loads(shell("schema")[1])
    assert set(schema["required"]) == {"profile", "body", "path"}
    sphere = schema["$defs"]["sphere"]["properties"]["radius"]
    assert "above 0 m" in sphere["description"]
    assert "numpy" in shell("info")[1]


def test_notebook_forms(case):
    request = read_case(case)
    result = mdr.solve(request.contact, request.path)
    html = result._repr_html_()
    assert html.count("<table>") == html.count("</table>") == 3
    assert "exact" in html
    assert "Sphere" in request.contact._repr_html_()
    assert "exact" in result.claims["pressure"]._repr_html_()


def test_a_failed_command_leaves_no_folder(tmp_path):
    """Too much force in the cycle of a joint, and a verification that the grid refuses."""
    case = tmp_path / "over.toml"
    assert CliRunner().invoke(app, ["new", "joint", "-o", str(case)]).exit_code == 0
    text = case.read_text(encoding="utf-8")
    case.write_text(text.replace('shift = "0.8 um"', 'tangential_force = "40 N"'), encoding="utf-8")
    assert CliRunner().invoke(app, ["run", str(case)]).exit_code != 0
    case.write_text(text.replace("coefficient = 0.3 ", 'coefficient = "inf" '), encoding="utf-8")
    assert CliRunner().invoke(app, ["verify", str(case)]).exit_code != 0
    assert list(tmp_path.iterdir()) == [case]


# --- exit status, JSON, solvers --------------------------------------------------------------------------

HOLLOW = BALL_CASE.replace(
    'kind = "sphere"\nradius = "10 mm"',
    'kind = "sampled"\nradius = ["0 mm", "1 mm", "2 mm", "3 mm", "4 mm", "5 mm"]\n'
    'height = ["0 um", "-1 um", "-3 um", "-1 um", "20 um", "60 um"]\ninterpolation = { kind = "shape_preserving" }',
).replace('"50 N"', '"0.5 N"')
KEYS = {
    "command",
    "case",
    "title",
    "status",
    "rows",
    "memory",
    "last",
    "largest",
    "claims",
    "assumptions",
    "notes",
    "references",
    "verification",
    "loops",
    "impact",
    "study",
    "preceding_studies",
    "fit",
    "curves",
    "written",
    "error",
}
EXAMPLES = Path(__file__).parent.parent / "examples"
_ROLLS = ("--creepage", "0.001", "--normal-force", "1 N")
_PRESSES = ("--normal-force", "10 N", "--realisations", "2")
_SLIDES = ("--speed", "1 mm/s", "--normal-force", "10 mN")


ROUGH = """
title = "Ground steel on glass"

[surface]
hurst = 0.8
rms = "0.5 um"
size = "1 mm"
shortest = "50 um"
seed = 3

[body]
kind = "elastic"
young = "210 GPa"
poisson = 0.3

[counterbody]
kind = "elastic"
young = "70 GPa"
poisson = 0.22
"""


@pytest.fixture
def rough(tmp_path):
    file = tmp_path / "rough.toml"
    file.write_text(ROUGH)
    return file


@pytest.fixture
def hollow(tmp_path):
    file = tmp_path / "hollow.toml"
    file.write_text(HOLLOW)
    return file


def test_a_refused_contact_has_an_exit_status_of_its_own(case, hollow, tmp_path, shell):
    status, out, err = shell("run", hollow, "-o", tmp_path / "out", "--quiet")
    assert (status, out) == (3, "")
    assert "REFUSED: the contact is not a disk at any step" in err
    assert (tmp_path / "out" / "result.nc").exists()
    status, out, _ = shell("check", hollow)
    assert status == 3
    assert "[solve] solver = { kind = 'rings' }" in out
    assert shell("run", hollow, case, "-o", tmp_path / "both", "--quiet")[0] == 3
    broken = tmp_path / "broken.toml"
    broken.write_text(BALL_CASE.replace("10 mm", "-10 mm"))
    assert shell("run", hollow, broken, "-o", tmp_path / "both", "--quiet")[0] == 1


def test_a_case_chooses_the_rings_that_refusals_recommend(hollow, tmp_path, shell):
    hollow.write_text(HOLLOW + '[solve]\nsolver = { kind = "rings", n = 60 }\n')
    assert read_case(hollow).options == {"solver": mdr.Rings(60)}
    status, out, err = shell("run", hollow, "-o", tmp_path / "out")
    assert (status, err) == (0, "")
    assert "BY_RINGS" in out
    result = mdr.open_result(tmp_path / "out" / "result.nc")
    assert result.rings == mdr.Rings(60)
    assert float(result["inner_contact_radius"][-1]) > 0.0
    assert shell("check", hollow)[0] == 0
    for bad, words in (("n = 10", "at least 20"), ("n = 9999", "at most 5000"), ('n = "x"', "whole number")):
        hollow.write_text(HOLLOW + f'[solve]\nsolver = {{ kind = "rings", {bad} }}\n')
        status, _, err = shell("check", hollow)
        assert status == 1
        assert words in err


def test_json_has_one_shape(case, hollow, rough, tmp_path, shell):
    record = tmp_path / "record.csv"
    record.write_text(
        "shift [um],friction force [N]\n" + "\n".join(f"{(-1) ** (i // 2)},{i % 2}" for i in range(9))
    )
    broken = tmp_path / "broken.toml"
    broken.write_text(BALL_CASE.replace("10 mm", "-10 mm"))
    deep = tmp_path / "deep.toml"
    deep.write_text(
        HOLLOW.replace('kind = "load"\nnormal_force = "0.5 N"', 'kind = "indent"\nindentation = "1 um"')
    )
    curve = tmp_path / "curve.csv"
    curve.write_text(
        "indentation [um],force [N]\n" + "\n".join(f"{i},{0.02 * max(i, 0) ** 1.5}" for i in range(-9, 9))
    )
    out = tmp_path / "out"
    for arguments, status, ended in (
        (("run", case, "-o", out), 0, "COMPLETED"),
        (("run", hollow, "-o", out), 3, "REFUSED"),
        (("run", broken, "-o", out), 1, "FAILED"),
        (("check", case), 0, "COMPLETED"),
        (("check", hollow), 3, "REFUSED"),
        (("check", tmp_path / "none.toml"), 1, "FAILED"),
        (("verify", case, "-o", out, "--rings", "40", "--steps", "1"), 0, "COMPLETED"),
        (("verify", deep, "-o", out, "--rings", "40", "--steps", "1"), 3, "REFUSED"),
        (("verify", broken, "-o", out), 1, "FAILED"),
        (("loops", record), 0, "COMPLETED"),
        (("loops", broken), 1, "FAILED"),
        (("rolling", EXAMPLES / "bolted_joint_loop.toml", *_ROLLS), 0, "COMPLETED"),
        (("rolling", case, *_ROLLS), 1, "FAILED"),
        (("sliding", EXAMPLES / "rubber_indentation.toml", *_SLIDES), 0, "COMPLETED"),
        (("sliding", case, *_SLIDES), 1, "FAILED"),
        (("rough", rough, *_PRESSES), 0, "COMPLETED"),
        (("rough", case, *_PRESSES), 1, "FAILED"),
        (("press", case, "--normal-force", "1 N"), 1, "FAILED"),
        (("fit", case, curve, "--free", "body.young"), 0, "COMPLETED"),
        (("fit", case, broken, "--free", "body.young"), 1, "FAILED"),
        (("law", case, "-o", out), 0, "COMPLETED"),
        (("law", broken), 1, "FAILED"),
        (("curves", curve), 0, "COMPLETED"),
        (("curves", broken), 1, "FAILED"),
        (("impact", case, "--mass", "1 g", "--speed", "1 m/s"), 0, "COMPLETED"),
        (("impact", broken, "--mass", "1 g", "--speed", "1 m/s"), 1, "FAILED"),
        (("table", out, "-o", tmp_path / "t.csv"), 0, "REFUSED"),
        (("table", broken, "-o", tmp_path / "t.csv"), 1, "FAILED"),
        (("plot", out), 0, "REFUSED"),
        (("plot", broken), 1, "FAILED"),
    ):
        result, text, _ = shell(*arguments, "--json")
        data = json.loads(text)
        assert (result, data["status"], set(data)) == (status, ended, KEYS), arguments
        assert data["command"] == arguments[0]
        assert (data["error"] is not None) == (ended == "FAILED")
        if ended == "FAILED":
            assert set(data["error"]) == {"kind", "message"}


def test_plot_takes_the_folder_and_run_writes_a_table(case, tmp_path, shell):
    out = tmp_path / "out"
    assert shell("run", case, "-o", out, "--csv", "--quiet")[0] == 0
    head = (out / "result.csv").read_text().splitlines()[0]
    assert "normal_force [N]" in head.split(",")
    for png in out.glob("*.png"):
        png.unlink()
    assert shell("plot", out, "--quiet")[0] == 0
    assert len(list(out.glob("*.png"))) == 3


def test_messages_list_every_mistake_in_plain_words(case, shell):
    case.write_text(
        BALL_CASE.replace('"10 mm"', "[1]").replace("poisson = 0.3", "").replace("steps = 3", "steps = 0")
    )
    _, _, err = shell("check", case)
    for words in (
        "a number or a text with its unit",
        "'poisson' is missing",
        "[path 1] steps = 0",
        "at least 1",
    ):
        assert words in err
    assert "and 1 more" not in err
    parts = '[profile]\nkind = "sum"\nparts = [{ kind = "sum", parts = [] }]\n'
    case.write_text(parts + BALL_CASE[BALL_CASE.index("[body]") :])
    assert "sums cannot be nested" in shell("check", case)[2]


def test_schema_lets_files_stand_for_samples(shell):
    schema = json.loads(shell("schema")[1])
    sampled = schema["$defs"]["sampled"]
    assert {"file", "radius"} <= set(sampled["properties"])
    assert {"required": ["file"]} in sampled["anyOf"]
    assert {"file", "channels"} <= set(schema["$defs"]["path"]["properties"])


@pytest.mark.parametrize(("name", "head"), [("x.pdf", b"%PDF"), ("x.svg", b"<?xml"), ("x.PNG", b"\x89PNG")])
def test_plot_writes_one_file_for_print(case, shell, tmp_path, name, head):
    assert shell("run", case, "-o", tmp_path / "out", "--quiet")[0] == 0
    file = tmp_path / "print" / name
    status, out, _ = shell("plot", tmp_path / "out", "-o", file)
    assert status == 0
    assert str(file) in out
    assert file.read_bytes().startswith(head)
    assert [p.name for p in file.parent.iterdir()] == [name]


@pytest.mark.parametrize("command", ["run", "verify", "check"])
@pytest.mark.parametrize("name", [".", "/", "..", ""])
def test_what_cannot_be_a_case_is_refused_as_json_too(command, name, shell):
    status, out, err = shell(command, name, "--json")
    assert (status, json.loads(out)["status"]) == (1, "FAILED")
    assert "regular file, not a folder" in err
    assert err.count("\n") == 1


def test_a_case_named_twice_fails_as_json(case, shell):
    status, out, _ = shell("run", str(case), str(case), "--json")
    data = json.loads(out)
    assert status == 1
    assert [one["status"] for one in data] == ["FAILED", "FAILED"]
    assert "give each case once" in data[0]["error"]["message"]


def test_channels_without_a_file(case, shell):
    case.write_text(
        BALL_CASE.replace('kind = "load"', 'kind = "path"').replace("steps = 3", 'channels = ["shift"]')
    )
    status, _, err = shell("check", str(case))
    assert (status, "channels are columns of a file" in err) == (1, True)


def test_rolling_from_the_shell(tmp_path, shell):
    case = EXAMPLES / "bolted_joint_loop.toml"
    arguments = ("rolling", case, "--creepage", "1e-4", "--creepage", "1e-3", "--normal-force", "100 N")
    status, out, error = shell(*arguments, "-o", tmp_path / "out")
    assert (status, error) == (0, "")
    assert "33 to 49 % below" in out
    assert sorted(file.name for file in (tmp_path / "out").iterdir()) == ["rolling.csv", "rolling.png"]
    assert (tmp_path / "out" / "rolling.csv").read_text().startswith("creepage,creep_force [N]")
    status, out, _ = shell(*arguments, "--law", "calibrated", "--direction", "lateral", "--json")
    data = json.loads(out)
    result = mdr.rolling(
        read_case(case).contact, [1e-4, 1e-3], normal_force=100.0, law="calibrated", direction="lateral"
    )
    force = {"values": result["creep_force"].values.tolist(), "unit": "N"}
    assert data["study"]["creep_force"] == force
    assert data["rows"] == 2
    assert data["claims"]["slip"]["level"] == "NOT_VALID"
    for bad, words in (
        (("--law", "carter"), "'plain' or 'calibrated'"),
        (("--indentation", "1 um"), "exactly one"),
        (("--points", "1"), "--points 1"),
    ):
        status, _, error = shell(*arguments, *bad)
        assert status == 1
        assert words in error
        assert len(error.splitlines()) == 1


@pytest.mark.parametrize(
    ("question", "words"),
    [
        (("impact", "--mass", "10 g", "--speed", "1 m/s"), "coefficient of restitution"),
        (("sliding", "--speed", "1 m/s", "--normal-force", "1 N"), "fast limit"),
        (("run",), "table [path] is missing"),
    ],
)
def test_questions_without_a_path_need_none(tmp_path, shell, question, words):
    case = tmp_path / "rubber.toml"
    case.write_text(
        """
        profile = { kind = "sphere", radius = "10 mm" }
        [body]
        kind = "viscoelastic"
        poisson = 0.5
        shear = { kind = "standard_solid", equilibrium = "1 MPa", modulus = "9 MPa", time = "1 ms" }
        """
    )
    status, out, error = shell(question[0], case, *question[1:])
    assert words in (error if question[0] == "run" else out)
    assert (status == 0) == (question[0] != "run")


def test_sliding_from_the_shell(tmp_path, shell):
    case = EXAMPLES / "rubber_indentation.toml"
    arguments = ("sliding", case, "--speed", "1 um/s", "--speed", "1 m/s", "--points", "7")
    load = ("--normal-force", "10 mN")
    status, out, error = shell(*arguments, *load, "-o", tmp_path / "out")
    assert (status, error) == (0, "")
    assert "twice the exact value in slow sliding" in out
    assert sorted(file.name for file in (tmp_path / "out").iterdir()) == ["sliding.csv", "sliding.png"]
    status, out, _ = shell(*arguments, *load, "--json")
    data = json.loads(out)
    speeds = np.geomspace(1e-6, 1.0, 7)
    result = mdr.sliding_friction(read_case(case).contact, speeds, normal_force="10 mN")
    assert data["study"]["friction_coefficient"]["values"] == result["friction_coefficient"].values.tolist()
    assert data["study"]["speed"] == {"values": speeds.tolist(), "unit": "m/s"}
    assert data["claims"]["slow_limit"]["steps_valid"] < 7
    assert data["claims"]["friction_coefficient"]["error"] == 1.0
    status, out, _ = shell("sliding", case, "--speed", "1 mm/s", "--indentation", "1 um", "--quiet")
    assert (status, out) == (0, "")
    for bad, words in (
        (("--speed", "0 m/s", *load), "above 0 m/s"),
        (("--speed", "1 mm", *load), "speed"),
        (("--speed", "1 mm/s"), "exactly one"),
        (("--speed", "1 mm/s", "--points", "5", *load), "--points 5"),
    ):
        status, _, error = shell("sliding", case, *bad)
        assert status == 1
        assert words in error
        assert len(error.splitlines()) == 1


def test_rough_surfaces_from_the_shell(rough, tmp_path, shell):
    loads = ("--normal-force", "0.1 N", "--normal-force", "10 N", "--points", "3", "--realisations", "4")
    status, out, error = shell("rough", rough, *loads, "-o", tmp_path / "out")
    assert (status, error) == (0, "")
    assert "Ground steel on glass" in out
    assert "-11 to +22 %" in out
    assert sorted(file.name for file in (tmp_path / "out").iterdir()) == ["rough.csv", "rough.png"]
    assert (tmp_path / "out" / "rough.csv").read_text().startswith("normal_force [N],indentation [m]")
    status, out, _ = shell("rough", rough, *loads, "--workers", "2", "--json")
    data = json.loads(out)
    steel, glass = mdr.Elastic("210 GPa", 0.3), mdr.Elastic("70 GPa", 0.22)
    surface = mdr.RoughSurface(0.8, "0.5 um", "1 mm", "50 um", seed=3)
    result = mdr.press_rough(surface, steel, glass, normal_force=[0.1, 1.0, 10.0], realisations=4)
    assert data["study"]["normal_stiffness"]["values"] == result["normal_stiffness"].values.tolist()
    assert data["claims"]["contact_area"]["level"] == "NOT_VALID"
    assert {one["name"] for one in data["assumptions"]} == {"small slope", "measured bandwidth"}
    status, out, _ = shell("rough", rough, *loads, "--coefficient", "4.6", "--json")
    result = mdr.press_rough(
        surface, steel, glass, normal_force=[0.1, 1.0, 10.0], realisations=4, coefficient=4.6
    )
    assert json.loads(out)["study"]["indentation"]["values"] == result["indentation"].values.tolist()
    assert "above 0" in shell("rough", rough, *loads, "--coefficient", "0")[2]
    text = rough.read_text()
    rough.write_text(text + '\n[ball]\nradius = "10 mm"\n')
    status, out, _ = shell("rough", rough, "--indentation", "0.5 um", "--realisations", "2")
    assert (status, "Hertz" in out) == (0, True)
    for old, new, words in (
        ("hurst = 0.8", "hurst = 1.8", "above 0 and at most 1"),
        ("hurst = 0.8", "hirst = 0.8", "did you mean 'hurst'?"),
        ('rms = "0.5 um"', "", "'rms' is missing"),
        ('size = "1 mm"', 'size = ["1 mm", "2 mm", "3 mm"]', "pair of sides"),
        ('size = "1 mm"', "size = true", "size"),
        ('size = "1 mm"', "size = [[]]", "[surface size] 1 = []"),
        ("seed = 3", "seed = -3", "at least 0"),
        ("seed = 3", "seed = 0.5", "a whole number is needed"),
        ("[surface]", "[surfaces]", "table [surface] is missing"),
        ('title = "Ground steel on glass"', "path = 1", "path = 1: unknown key"),
        (
            'kind = "elastic"\nyoung = "210 GPa"\npoisson = 0.3',
            'kind = "rigid"\n[ball]\nradios = 1',
            "did you mean 'radius'?",
        ),
    ):
        assert old in text
        rough.write_text(text.replace(old, new))
        status, _, error = shell("rough", rough, "--normal-force", "1 N")
        assert status == 1
        assert words in error, error
        assert len(error.splitlines()) == 1
    rough.write_text(text)
    assert "give exactly one of normal_force and indentation" in shell("rough", rough)[2]
    assert "write --normal-force '-3 N'" in shell("rough", rough, "--normal-force", "-3")[2]
    assert "above 0 N" in shell("rough", rough, "--normal-force", "-3 N")[2]
    assert "--points 1" in shell("rough", rough, "--normal-force", "1 N", "--points", "1")[2]
    assert "use pymdr rough" in shell("run", rough)[2]
    status, answer, _ = shell("check", rough)
    assert status == 0
    assert "pymdr rough if it is random" in answer


PRESS = """
title = "A lens"

[surface]
file = "lens.npy"
size = "1 mm"
unit = "um"

[body]
kind = "elastic"
young = "1 MPa"
poisson = 0.5
"""


@pytest.mark.skipif(
    importlib.util.find_spec("ContactMechanics") is None,
    reason="ContactMechanics, of the extra rough, is missing",
)
def test_surfaces_are_pressed_from_the_shell(tmp_path, shell):
    x = (np.arange(24) + 0.5) / 24 - 0.5
    heights = -100.0 * (x[:, None] ** 2 + x**2)
    np.save(tmp_path / "lens.npy", heights)
    case = tmp_path / "press.toml"
    case.write_text(PRESS)
    loads = ("--indentation", "1 um", "--indentation", "10 um", "--points", "3")
    status, out, err = shell("press", case, *loads, "-o", tmp_path / "out", "--keep", tmp_path / "kept")
    assert status == 0, err
    assert "A lens" in out
    assert "24 x 24 pixels at 3 loads need about" in err
    assert sorted(file.name for file in (tmp_path / "out").iterdir()) == [
        "press.csv",
        "press.nc",
        "press.png",
    ]
    kept = mdr.open_pressed_surface(tmp_path / "out" / "press.nc")
    assert len(list((tmp_path / "kept").glob("parts-*.nc"))) == 3
    data = json.loads(shell("press", case, *loads, "--json")[1])
    result = mdr.press(
        mdr.Topography(heights * 1e-6, "1 mm"),
        mdr.Elastic("1 MPa", 0.5),
        indentation=np.geomspace(1e-6, 1e-5, 3),
    )
    assert data["study"]["normal_force"]["values"] == pytest.approx(result["normal_force"].values, rel=1e-9)
    assert kept.data["normal_force"].values.tolist() == data["study"]["normal_force"]["values"]
    rough = """
[surface]
hurst = 0.8
rms = "1 um"
size = "1 mm"
shortest = "500 um"

[body]
kind = "elastic"
young = "1 MPa"
poisson = 0.5
"""
    case.write_text(rough)
    assert shell("press", case, "--normal-force", "1 mN")[0] == 0
    for text, words in (
        (PRESS.replace('unit = "um"', 'units = "um"'), "unknown key"),
        (PRESS.replace("lens.npy", "none.npy"), "none.npy"),
        (PRESS.replace("[surface]", "[surfaces]"), "table [surface] is missing"),
        ('punch = "yes"' + PRESS, "punch"),
        ("punch = true\n" + rough, "always a punch"),
        (rough + '\n[ball]\nradius = "1 mm"\n', "[ball]"),
    ):
        case.write_text(text)
        status, _, error = shell("press", case, "--normal-force", "1 mN")
        assert status == 1
        assert words in error


def test_what_the_method_refuses_is_no_failure(case, hollow, tmp_path, shell):
    """Whatever is asked of a contact that is no disk; a number that is not above 0 fails."""
    rubbed = tmp_path / "rubbed.toml"
    rubbed.write_text(
        HOLLOW + '[counterbody]\nkind = "rigid"\n[friction]\nkind = "coulomb"\ncoefficient = 0.3\n'
    )
    for arguments in (
        ("law", hollow, "--to", "1 um"),
        ("impact", hollow, "--mass", "1 g", "--speed", "0.1 m/s"),
        ("run", rubbed, "-o", tmp_path / "out"),
        ("check", rubbed),
    ):
        status, out, err = shell(*arguments, "--json")
        data = json.loads(out)
        assert (status, data["status"], data["error"]["kind"]) == (3, "REFUSED", "RefusedError"), arguments
        assert "disk" in data["error"]["message"]
        assert err == f"pymdr: {data['error']['message']}\n"
    assert shell("run", rubbed, case, "-o", tmp_path / "both", "--quiet")[0] == 3
    assert shell("impact", hollow, "--mass", "0 g", "--speed", "0.1 m/s")[0] == 1


@pytest.mark.parametrize(
    ("values", "status", "ended", "words"),
    [
        ("1 GPa, 2 GPa", 0, "COMPLETED", ""),
        ("1 GPa, -2 GPa", 1, "PARTLY_FAILED", "1 of 2 points failed"),
        ("-1 GPa, -2 GPa", 1, "FAILED", "none of 2 points can be solved"),
    ],
)
def test_how_a_sweep_ends(case, values, status, ended, words, shell):
    result, out, err = shell("sweep", case, "--over", f"body.young = {values}", "--json")
    assert (result, json.loads(out)["status"]) == (status, ended)
    assert words in err


def test_a_sweep_lists_the_points_that_the_method_refuses(hollow, shell):
    arguments = ("sweep", hollow, "--over", "body.young = 100 GPa, 200 GPa")
    status, out, err = shell(*arguments)
    assert (status, "2 of 2 points REFUSED: the contact is not a disk at any step" in out) == (3, True)
    assert "refuses the contact at all points" in err
    assert json.loads(shell(*arguments, "--json")[1])["status"] == "REFUSED"


def test_a_remedy_of_a_sweep_is_a_sweep(case, shell):
    _, _, err = shell("sweep", case, "--over", "body.young = 1e9, 2 GPa")
    remedy = re.search(r"write (--over) '(.*)'", err)
    assert remedy is not None
    assert shell("sweep", case, *remedy.groups())[0] == 0
    _, _, err = shell("sliding", case, "--speed", "1", "--normal-force", "1 N")
    assert "write --speed '1 m/s'" in err


def test_more_workers_than_points(case, shell):
    assert shell("sweep", case, "--over", "body.young = 1 GPa, 2 GPa", "--workers", "1" * 40)[0] == 0


def test_a_unit_is_given_once(case, tmp_path, shell):
    assert shell("run", case, "-o", tmp_path / "out", "--quiet")[0] == 0
    arguments = ("table", tmp_path / "out", "-o", tmp_path / "ball.csv")
    status, _, err = shell(*arguments, "--unit", "indentation=um", "--unit", "indentation=mm")
    assert (status, "indentation has a unit already" in err) == (1, True)
    assert not (tmp_path / "ball.csv").exists()
    data = json.loads(shell(*arguments, "--unit", "indentation=um", "--json")[1])
    assert (data["status"], data["written"]) == ("COMPLETED", [str(tmp_path / "ball.csv")])


def test_a_law_with_friction_is_written_where_there_is_friction(case, tmp_path, shell):
    rubbed = tmp_path / "rubbed.toml"
    plain = case.read_text()
    rubbed.write_text(plain + '\n[friction]\nkind = "coulomb"\ncoefficient = 0.3\n')
    arguments = ("--to", "1 um", "--tangential", "-o", tmp_path / "out")
    assert shell("law", rubbed, *arguments, "--quiet")[0] == 0
    assert (
        "rubbed_advance(rubbed_state *s, double d, double u)" in (tmp_path / "out" / "rubbed.h").read_text()
    )
    status, _, err = shell("law", case, *arguments)
    assert (status, "coefficient of friction" in err) == (1, True)


def test_folders_that_were_made_go_again_with_their_parents(case, tmp_path, shell):
    (tmp_path / "kept").mkdir()
    status, _, _ = shell("law", case, "--to", "-1 um", "-o", tmp_path / "kept" / "a" / "b")
    assert status == 1
    assert list((tmp_path / "kept").iterdir()) == []


def test_a_fit_names_the_file_that_cannot_be_fitted(case, tmp_path, shell):
    few, whole = tmp_path / "few.csv", tmp_path / "whole.csv"
    head = "indentation [um],force [N]\n"
    few.write_text(head + "1,1\n2,2\n")
    whole.write_text(head + "\n".join(f"{i},{0.02 * max(i, 0) ** 1.5}" for i in range(-9, 9)))
    for command in (("fit", case, few, "--free", "body.young"), ("curves", few)):
        assert f"{few}: 2 samples" in shell(*command)[2]
    status, _, err = shell("fit", case, whole, "--free", "body.young", "--segment", "aproach")
    assert (status, "segment = 'aproach'; it must be one of record, approach, retreat" in err) == (1, True)
    rubbed = tmp_path / "rubbed.toml"
    rubbed.write_text(BALL_CASE + '[friction]\nkind = "coulomb"\ncoefficient = 0.3\n')
    _, _, err = shell("fit", rubbed, whole, "--free", "body.young")
    assert err.startswith("pymdr: the contact has friction")


# --- options ------------------------------------------------------------------------------------------------

OPTIONS = [
    pytest.param(command, option, id=f"{name} {option.opts[0]}")
    for name, command in typer.main.get_command(app).commands.items()
    for option in command.params
    if option.opts[0].startswith("-") and not option.is_flag
]


@pytest.mark.parametrize(("command", "option"), OPTIONS)
def test_an_option_of_one_value_is_given_once(command, option):
    """By any of its names; what takes several values keeps them all."""
    args = [option.opts[0], "1", option.opts[-1], "2"]
    if option.multiple:
        context = command.make_context("pymdr", list(args), resilient_parsing=True)
        assert list(context.params[option.name]) == ["1", "2"]
        return
    with pytest.raises(typer.BadParameter, match="given 2 times, but it takes one value") as refusal:
        command.make_context("pymdr", args)
    assert option.opts[0] in refusal.value.format_message()


def test_a_repeated_option_from_the_shell(shell, tmp_path):
    for args in (
        ("impact", "case.toml", "--speed", "1 m/s", "--mass", "1 g", "--mass=2 g"),
        ("run", "case.toml", "-o", tmp_path / "a", "--output", tmp_path / "b"),
    ):
        status, out, error = shell(*args)
        assert (status, out) == (2, "")
        assert "given 2 times" in error


@pytest.mark.parametrize(
    "speeds",
    [
        ("--speed", "0.05 m/s, 0.1 m/s,50 cm/s"),
        ("--speed", "0.05 m/s", "--speed", "0.1 m/s", "--speed=0.5 m/s"),
    ],
)
def test_impacts_at_several_speeds(tmp_path, shell, speeds):
    case = tmp_path / "gel.toml"
    case.write_text(
        'profile = { kind = "paraboloid", radius = "1 mm" }\nadhesion = { kind = "jkr", work = "50 mJ/m^2" }\n'
        'body = { kind = "elastic", young = "30 kPa", poisson = 0.5 }\n'
    )
    status, out, _ = shell("impact", case, "--mass", "1 mg", *speeds, "-o", tmp_path / "out", "--json")
    assert status == 0
    result = json.loads(out)
    restitution = mdr.restitution(read_contact(case)[1], mass="1 mg", speeds=[0.05, 0.1, 0.5])
    assert result["rows"] == 3
    assert result["study"]["restitution"]["values"] == restitution["restitution"].values.tolist()
    assert [Path(file).name for file in result["written"]] == ["impact.csv", "impact.png"]
    for extra, words in (
        (("--angle", "40 deg"), "--angle applies to oblique impacts"),
        (("--points", "4"), "give two values above 0"),
        (("--speed", "2"), "write --speed '2 m/s'"),
    ):
        status, _, error = shell("impact", case, "--mass", "1 mg", *speeds, *extra)
        assert status == 1
        assert words in error


@pytest.mark.parametrize("command", ["rough", "press"])
@pytest.mark.parametrize("table", ["body", "counterbody"])
def test_rough_surfaces_refuse_bodies_with_memory_by_their_table(tmp_path, shell, command, table):
    """Not for a key or a file of the table, of which nothing has to be right."""
    bodies = {"body": 'kind = "elastic"\nyoung = "1 GPa"\npoisson = 0.3\n'}
    bodies[table] = 'kind = "viscoelastic"\nshear = { kind = "prony", file = "missing.csv" }\n'
    case = tmp_path / "case.toml"
    tables = "".join(f"[{name}]\n{text}" for name, text in bodies.items())
    case.write_text(f'[surface]\nhurst = 0.8\nrms = "1 um"\nsize = "1 mm"\nshortest = "0.1 mm"\n{tables}')
    status, _, error = shell(command, case, "--normal-force", "1 N")
    assert status == 1
    assert f"[{table}] kind = 'viscoelastic': rough surfaces are pressed on homogeneous elastic" in error
    assert len(error.splitlines()) == 1


def test_errors_of_tables_name_their_keys_alone(tmp_path, shell):
    """Also of tables without a key `kind`, and of properties that all bodies have."""
    surface = '[surface]\nhurst = {}\nrms = "1 um"\nsize = "1 mm"\nshortest = "0.1 mm"\n'
    body = '[body]\nkind = "elastic"\nyoung = "1 GPa"\npoisson = 0.3\nresistivity = "{}"\n'
    layers = '[profile]\nkind = "sphere"\nradius = "1 mm"\n[friction]\nkind = "coulomb"\ncoefficient = 0.1\n[body]\nkind = "layered"\n'
    layers += '[[body.layers]]\nmaterial = {{ kind = "elastic", young = "1 GPa", poisson = 0.3 }}\nthickness = "{}"\n'
    layers += '[[path]]\nkind = "indent"\nindentation = "1 um"\n'
    case = tmp_path / "case.toml"
    for command, text, words in (
        ("press", surface.format(1.8) + body.format("1 ohm m"), ": [surface] hurst = 1.8: it must"),
        ("press", surface.format(0.8) + body.format("1 ohm"), ": [body] resistivity: 'ohm' does not fit"),
        ("run", layers.format("0 um"), ": [body.layers 1] thickness = '0 um': it must be above 0 m"),
        ("run", layers.format("1 um"), "case.toml: friction of a layered body is not available"),
    ):
        case.write_text(text)
        assert words in shell(command, case)[2]


def test_an_output_that_is_a_file_is_refused_before_the_work(tmp_path, monkeypatch, shell):
    place = tmp_path / "taken"
    place.write_text("x")
    case = tmp_path / "ball.toml"
    case.write_text(
        "[profile]\nkind = 'sphere'\nradius = '10 mm'\n[body]\nkind = 'elastic'\nyoung = '1 MPa'\npoisson = 0.5\n"
    )
    monkeypatch.setattr("pymdr.solving.impacts.impact", None)
    monkeypatch.setattr("pymdr.solving.impacts.restitution", None)
    for speeds in (["1 m/s"], ["1 m/s, 2 m/s"]):
        status, _, error = shell("impact", case, "--mass", "1 g", "--speed", *speeds, "-o", place)
        assert status == 1
        assert "taken: it is a file; choose another folder with -o DIR" in error
    assert "give --to, such as --to '1 um'" in shell("law", case)[2]
    assert "[path] is missing; add a leg, such as [[path]] with" in shell("run", case)[2]
    case.write_text(case.read_text().replace("radius = '10 mm'", "") + "[[path]]\nkind = 'load'\n")
    assert "'radius' is missing; write for example radius = '5 mm'" in shell("run", case)[2]
    assert (
        "[path 1] key 'normal_force' is missing; write for example normal_force = '50 N'"
        in shell("run", case)[2]
    )


def test_pull_off_takes_the_tables_of_its_case(tmp_path, shell):
    """The largest pull of JKR is 3/2 pi w R under a dead load, and 5/6 pi w R under a held depth."""
    case = tmp_path / "gel.toml"
    text = (
        "[profile]\nkind = 'paraboloid'\nradius = '1 mm'\n[body]\nkind = 'elastic'\nyoung = '30 kPa'\npoisson = 0.5\n"
        "[adhesion]\nkind = 'jkr'\nwork = '50 mJ/m^2'\n"
    )
    unit = np.pi * 50e-3 * 1e-3
    for tables, options, factor in (
        ("", (), 5 / 6),
        ("[solve]\nmachine_stiffness = 0\n", (), 3 / 2),
        ("[solve]\nmachine_stiffness = 0\n[pull_off]\nmachine_stiffness = '1e9 N/m'\n", (), 5 / 6),
        ("[pull_off]\nmachine_stiffness = '1e9 N/m'\n", ("--machine-stiffness", "0"), 3 / 2),
    ):
        case.write_text(text + tables)
        study = json.loads(shell("pull-off", case, *options, "--json")[1])["study"]
        assert study["normal_force"]["values"][0] == pytest.approx(-factor * unit, rel=1e-6)
    case.write_text(text + "[solve]\ntolerance = 1e-4\n")
    status, _, error = shell("pull-off", case)
    assert (status, "tolerance = 0.0001; it is for MaugisDugdale" in error) == (1, True)


@pytest.mark.parametrize("name", ["load(1).toml", "of Sphere(2).toml", "JKR(3).d/a.toml"])
def test_errors_keep_the_names_of_files_that_look_like_calls(tmp_path, shell, name):
    case = tmp_path / name
    case.parent.mkdir(exist_ok=True)
    case.write_text(BALL_CASE.replace("[profile]", "[profil]"))
    status, _, error = shell("check", case)
    assert status == 1
    assert f"{case}: " in error


@settings(max_examples=examples(60), deadline=None)
@given(
    st.sampled_from(("Sphere", "JKR", "load", "Contact")),
    st.one_of(st.text(), st.integers(1, 10**5).flatmap(lambda n: st.sampled_from(["(" * n, "-" * n]))),
)
def test_errors_with_any_text_of_a_user_are_written(kind, text):
    assert error_text(ValueError(f"a.toml: kind = {kind}({text}) is not known"))
