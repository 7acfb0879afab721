"""Every example runs, each asserts a number of its own, and its figures can be read."""

import math
import re
import runpy
import tomllib
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from matplotlib.figure import Figure

from legibility import collected_figures, faults
from pymdr.solving.verb import solve
from pymdr.workbench.casefile import read_case

EXAMPLES = Path(__file__).parent.parent / "examples"

# last rows of the case files, from closed forms where there is one
CASE_NUMBERS = {
    "ball_on_glass": ("contact_radius", 1.8873e-4, 1e-4),
    # the closed force of a truncated sphere, inverted
    "worn_sphere": ("contact_radius", 1.5063574518091223e-3, 1e-12),
    "conical_indenter": ("normal_force", 0.0, 1e-12),
    # the mean profile, within the noise of the hyperboloid that it was made from
    "worn_tip": ("normal_force", 7.7024e-6, 0.01),
    # jump-in and pull-off of the paraboloid, from the energies of JKR in closed form
    "afm_tip_on_gel": ("dissipated_energy", 2.616772708e-12, 1e-8),
    # Masing's branches of Mindlin's paraboloid, to which the true sphere adds 8e-5
    "bolted_joint_loop": ("tangential_force", 2.0562579, 2e-4),
    # the record has the same amplitude and load, and ends where a cycle does
    # Masing's branch of Lubkin's sphere: back at the twist of the first turn
    "screwdriver_bit": ("twist", 2e-3, 1e-12),
    "joint_record": ("tangential_force", 2.0562579, 2e-4),
    # a of F = 4 c a^(3+k) / (R (1+k)^2 (3+k)), in 30 digits
    "graded_implant": ("contact_radius", 0.00026946870081527825, 1e-12),
    # a of F = (pi/2) cot(70.3 deg) E* a^2 with the indentation modulus of zinc
    "zinc_indentation": (
        "contact_radius",
        math.sqrt(2 * 10e-3 * math.tan(math.radians(70.3)) / (math.pi * 67.799650579961365e9)),
        1e-12,
    ),
    # the contact is lost before the ball is back
    "rubber_indentation": ("normal_force", 0.0, 1e-12),
    # all slides at mu F_N of the relaxed rubber, mu (4/3) 4 G R^(1/2) d^(3/2)
    "rubber_mount": ("tangential_force", 0.4 * 4 / 3 * 4e6 * math.sqrt(50e-3) * 0.5e-3**1.5, 1e-9),
    # boundary elements with friction on the surface whose curve it is; the noise costs 0.3 %
    "rough_joint": ("tangential_force", 0.450883, 0.01),
    # (rho1 + rho2) / (4 a), a^3 = 3 F R / (4 E*)
    "switch_contact": (
        "electrical_resistance",
        15.9e-9 / 2 / (3 * 5e-3 * (1 - 0.37**2) / (2 * 83e9)) ** (1 / 3),
        1e-12,
    ),
    # the contact is lost before the machine is back
    "coated_gel": ("normal_force", 0.0, 1e-12),
    # Johnson (1985), eqs. (4.26) and (4.28), in 40 digits
    "crossed_cylinders": ("semi_axis_x", 5.645993520622424513524607e-5, 1e-13),
    # a of pi a^2 p_Y(d) = F, in 30 digits
    "flattened_ball": ("contact_radius", 1.64462106025272362e-4, 1e-12),
    "rounded_punch": ("normal_stiffness", 2 * (3e6 / 0.75) * 1e-3, 1e-12),
}


SCRIPTS = [*EXAMPLES.glob("*.py"), *(EXAMPLES.parent / "docs" / "demonstrations").glob("*.py")]


@pytest.fixture(autouse=True)
def saved(monkeypatch):
    """The names under which a script saves its figures; no file is written."""
    names = []
    monkeypatch.setattr(Figure, "savefig", lambda figure, name: names.append(name))
    with matplotlib.rc_context():
        yield names


@pytest.mark.parametrize("script", sorted(SCRIPTS), ids=lambda p: p.stem)
def test_script(script, saved, capsys):
    text = script.read_text()
    assert "assert " in text
    assert ("import Figure" in text) == ('matplotlib.style.use("pymdr.figures")' in text)
    with collected_figures() as figures:
        runpy.run_path(str(script))
    for figure in figures:
        assert not faults(figure)
    output = capsys.readouterr().out.splitlines()
    if script.parent == EXAMPLES:
        assert output or script.stem.startswith("make_")
        assert len(saved) >= len(re.findall(r"^figure = ", text, re.MULTILINE))
        assert saved == [f"{script.stem}{f'_{k + 1}' if k else ''}.png" for k in range(len(saved))]
        assert [line for line in output if line.startswith("figure saved")] == [
            f"figure saved as {name}" for name in saved
        ]


RECORDS = {
    "cell_relaxation": "fmt-jpk-sr_cell1-0008.jpk-force",
    "gel_creep": "fmt-jpk-cc_pr14-polymergel-2021.06.30.jpk-force",
}


def recorded(script):
    """The measured record that a script takes; without it, the test is skipped."""
    pytest.importorskip("afmformats", reason="afmformats, of the extra afm, is not installed")
    file = EXAMPLES.parent.parent / "shared" / "data" / "afm" / RECORDS[script]
    if not file.exists():
        pytest.skip(f"{file.name}, from the tests of afmformats, is not beside the repository")
    return str(file)


@pytest.mark.parametrize("script", RECORDS)
def test_script_on_a_measured_record(script, monkeypatch, capsys):
    file = recorded(script)
    monkeypatch.setattr("sys.argv", [script, file])
    runpy.run_path(str(EXAMPLES / f"{script}.py"), run_name="__main__")
    assert file in capsys.readouterr().out


@pytest.mark.parametrize("measured", [False, True])
def test_the_force_of_the_cell_by_quadrature(monkeypatch, measured):
    """Lee and Radok's integral over the ramp and the hold, by the midpoint rule between many rows."""
    monkeypatch.setattr("sys.argv", ["made", *([recorded("cell_relaxation")] if measured else [])])
    space = runpy.run_path(str(EXAMPLES / "cell_relaxation.py"), run_name="__main__")
    shear, t = space["cell"].shear, np.append(0.0, space["time"])
    fine = np.unique(np.concatenate([t, np.linspace(0.0, t[-1], 20000)]))
    depth = np.interp(fine, t, np.append(0.0, space["rows"].depth.values))
    pressed = 16.0 / 3.0 * math.sqrt(50e-6) * np.maximum(depth, 0.0) ** 1.5
    middle = 0.5 * (fine[1:] + fine[:-1])
    for row in (10, 30, 33, 50, -1):
        past = middle < space["time"][row]
        force = np.sum(shear.relaxation(space["time"][row] - middle[past]) * np.diff(pressed)[past])
        assert space["model"][row] == pytest.approx(force, rel=1e-5)


@pytest.mark.parametrize("file", sorted(EXAMPLES.glob("*.toml")), ids=lambda p: p.stem)
def test_case_file(file):
    tomllib.loads(file.read_text())
    case = read_case(file)
    name, value, tolerance = CASE_NUMBERS[file.stem]
    got = float(solve(case.contact, case.path, **case.options)[name].values[-1])
    assert got == pytest.approx(value, rel=tolerance, abs=1e-15)
