"""The friction stack held against vector friction on the half-space, from Python and from the shell."""

import math

import numpy as np
import pytest

import pymdr as mdr
from common import STEEL
from pymdr.errors import PathError, ProblemError
from pymdr.workbench.cli import app


def test_verify_sliding_thins_a_long_history():
    steel = mdr.Elastic("210 GPa", 0.3)
    joint = mdr.Contact(mdr.Sphere("10 mm"), steel, steel, friction=mdr.Coulomb(0.3))
    path = mdr.load("50 N") >> mdr.cycle(shift="0.6 um", steps=400)
    result = mdr.verify(joint, path, elements=20, steps=8)
    assert result.data.sizes["step"] <= 8
    assert result.largest_difference < 2e-3  # measured 8e-4
    assert "boundary elements" in result.summary()
    figure = result.plot()
    assert [axes.get_xlabel() for axes in figure.axes] == [
        "tangential displacement $u_x$ (nm)",
        "radius $r$ (µm)",
        "",  # the stress over the depth, above its differences
        "depth $z$ (µm)",
    ]


@pytest.mark.long
def test_oblique_loading_is_refined():
    joint = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(0.3))
    result = mdr.verify(joint, mdr.ramp(indentation="2 um", shift="0.4 um", steps=8), elements=24)
    assert result.largest_difference < 2e-3  # measured 1.1e-3, and 4.3e-2 with undivided rows
    assert result.extrapolated > result.largest_difference


def test_more_turning_points_than_steps_are_noted():
    joint = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(0.3))
    i = np.arange(60)
    path = mdr.Path(indentation=1e-6 * (1 + 0.5 * np.sin(i * 1.3)), shift=3e-7 * np.sin(i * 0.9))
    result = mdr.verify(joint, path, elements=12, steps=4)
    assert (result.rows.size, result.path_rows) == (4, 60)
    assert f"to row {result.rows[-1] + 1}; use more steps to reach its end" in result.summary()


def test_verify_from_the_shell(tmp_path):
    from typer.testing import CliRunner

    case = tmp_path / "joint.toml"
    assert CliRunner().invoke(app, ["new", "joint", "-o", str(case)]).exit_code == 0
    answer = CliRunner().invoke(app, ["verify", str(case), "--cells", "16", "--steps", "6"])
    assert answer.exit_code == 0, answer.output
    assert "largest difference of the tangential force" in answer.output
    assert (tmp_path / "joint" / "verify.png").stat().st_size > 10_000


def test_bad_input():
    joint = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, friction=mdr.Coulomb(0.3))
    for make, kind, words in (
        (lambda: mdr.verify(joint, mdr.indent("1 um"), elements=4), ProblemError, "at least 8"),
        (lambda: mdr.verify(joint, mdr.indent("1 um"), steps=1), PathError, "at least 2"),
        (
            lambda: mdr.verify(
                mdr.Contact(
                    mdr.Paraboloid(1.0),
                    mdr.Viscoelastic(mdr.Maxwell(1.0, time=1.0), poisson=0.5),
                    friction=mdr.Coulomb(0.3),
                ),
                mdr.indent("1 um", duration="1 s"),
            ),
            ProblemError,
            "use Elastic",
        ),
        (
            lambda: mdr.verify(
                mdr.Contact(mdr.Paraboloid(1.0), STEEL, friction=mdr.Coulomb(math.inf)), mdr.indent("1 um")
            ),
            ProblemError,
            "finite",
        ),
    ):
        with pytest.raises(kind, match=words):
            make()
