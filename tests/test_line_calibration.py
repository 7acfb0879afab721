"""Lambda of the lines of rough surfaces against boundary elements: the fit, what it keeps, and what it refuses."""

import importlib.util
import math
import sys
from pathlib import Path

import numpy as np
import pytest

import pymdr as mdr
from pymdr.errors import FileError, NotValidError, ProblemError
from pymdr.solving import calibrating

needs_engine = pytest.mark.skipif(
    importlib.util.find_spec("ContactMechanics") is None,
    reason="ContactMechanics, of the extra rough, is missing",
)


def square(hurst=0.8, waves=16, **given):
    return mdr.RoughSurface(hurst, rms=1e-3, size=1.0, shortest=1.0 / waves, **given)


def test_loads_do_not_depend_on_last_bits():
    """Threads of linear algebra change them, and a folder whose loads are others is refused."""
    full = 1.15229648425949
    loads = [calibrating._loads(square(), full * (1.0 + bits * 2.0**-52)).tolist() for bits in (-4, 0, 4)]
    assert loads[0] == loads[1] == loads[2]


@pytest.mark.long
@needs_engine
def test_two_surfaces_and_one_exponent(tmp_path):
    """The quick form: 65 x 65 pixels; ended and gone on, and the same numbers as by steps of one's own."""
    calls = []

    class EndedError(Exception):
        pass

    def ended(done, total):
        calls.append((done, total))
        if done >= total / 2:
            raise EndedError

    with pytest.raises(EndedError):
        mdr.calibrate_coefficient(square(), realisations=2, points=65, keep=tmp_path, progress=ended)
    kept = {file: file.stat().st_mtime_ns for file in tmp_path.rglob("parts-*.nc")}
    assert len(kept) >= 12
    fitted = mdr.calibrate_coefficient(square(), realisations=2, points=65, keep=tmp_path)
    assert all(file.stat().st_mtime_ns == at for file, at in kept.items())

    data, full = fitted.data, fitted.data.attrs["full_contact_stiffness"]
    mean = data["stiffness"].values
    assert full == pytest.approx(1.15230, rel=1e-4)
    assert np.all(np.diff(mean) > 0)
    assert mean[0] < 0.03 * full < 0.85 * full < mean[-1] < full
    assert np.all(data["stiffness_low"] <= data["stiffness_high"])
    # no other lambda is better, by the public line
    inside = (mean > 0.03 * full) & (mean < 0.85 * full)

    def misfit(coefficient):
        line = mdr.press_rough(
            square(),
            mdr.Elastic(1.0, 0.0),
            normal_force=data["load"].values * 1e-3,
            coefficient=coefficient,
        )
        return np.sqrt(np.mean(np.log(line["normal_stiffness"].values / mean)[inside] ** 2))

    best = misfit(fitted.coefficient)
    assert best == pytest.approx(data.attrs["misfit"], rel=1e-9)
    assert best < 0.2
    assert min(misfit(fitted.coefficient * factor) for factor in (0.9, 1.1)) > best
    low, high = data.attrs["coefficients"]
    assert low <= fitted.coefficient * 1.2
    assert high >= fitted.coefficient / 1.2
    # the share of the springs is no area
    with pytest.raises(NotValidError, match="not an area"):
        fitted["line_fraction"]
    over = (data["line_fraction"] / data["area"]).values
    assert over.min() > 2.0
    assert over.max() > 20.0 * over.min()
    assert "lambda = " in str(fitted)
    assert len(fitted.plot().axes) == 3
    with pytest.raises(FileError, match="another computation"):
        mdr.calibrate_coefficient(square(seed=1), realisations=1, points=65, keep=tmp_path)


@pytest.mark.parametrize("coefficient", [1.5, math.pi, 6.0])
def test_a_known_lambda_is_recovered(coefficient, monkeypatch):
    surface = square(0.5)

    class Pressed(dict):
        data = mdr.press_rough(surface, mdr.Elastic(1.0, 0.0), normal_force=1e-3, realisations=1).data

    Pressed.data.attrs["engine"] = "lines"

    def by_lines(patch, body, *, normal_force, **given):
        fitted = mdr.press_rough(surface, body, normal_force=normal_force, coefficient=coefficient)
        return Pressed(
            normal_stiffness=fitted["normal_stiffness"], contact_area=0.1 * fitted["normal_stiffness"]
        )

    monkeypatch.setattr(calibrating, "press", by_lines)
    fitted = mdr.calibrate_coefficient(surface, realisations=1)
    assert fitted.coefficient == pytest.approx(coefficient, rel=2e-3)
    assert fitted.data.attrs["largest_misfit"] < 2e-3


def test_refusals():
    with pytest.raises(ProblemError, match="not a RoughSurface"):
        mdr.calibrate_coefficient(3.0)
    with pytest.raises(ProblemError, match="rectangle"):
        mdr.calibrate_coefficient(mdr.RoughSurface(0.8, 1e-3, (1.0, 2.0), 0.1))
    with pytest.raises(ProblemError, match="realisations = 0"):
        mdr.calibrate_coefficient(square(), realisations=0)
    with pytest.raises(ProblemError, match="at least 64"):
        mdr.calibrate_coefficient(square(), points=20)


@needs_engine
def test_the_command_writes_table_and_figure(tmp_path, monkeypatch, capsys):
    path = Path(__file__).parent.parent / "benchmarks" / "lambda_calibration.py"
    spec = importlib.util.spec_from_file_location("lambda_calibration", path)
    command = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, "lambda_calibration", command)
    spec.loader.exec_module(command)
    command.main(["--hurst", "0.5", "--pixels", "32", "--realisations", "1", "--out", str(tmp_path)])
    table = np.genfromtxt(tmp_path / "lambda.csv", delimiter=",", names=True)
    assert table.size == 12
    assert np.all(table["area"] < table["line_fraction"])
    assert (tmp_path / "lambda_H0.5_32.png").exists()
    assert "lambda = " in capsys.readouterr().out
