"""The stress under solved contacts, by the method and by a double integral of point loads, as `verify` shows it."""

import json
import math

import numpy as np
import pytest

import pymdr as mdr
from common import GEL, STEEL
from legibility import faults
from pymdr.workbench.cli import app
from pymdr.workbench.subsurface import compare_subsurface

BALL, TIP = mdr.Paraboloid("10 mm"), mdr.Paraboloid("50 um")
ZINC = mdr.TransverselyIsotropic(c11="161 GPa", c33="61 GPa", c13="50.1 GPa", c44="38.3 GPa", c66="63.4 GPa")
SHEARED = mdr.load("50 N") >> mdr.cycle(shift="0.6 um", steps=8)
COULOMB = mdr.Coulomb(0.3)
CONTACTS = {
    "ball": (mdr.Contact(BALL, STEEL, STEEL), mdr.load("50 N")),
    "cone": (mdr.Contact(mdr.Cone(slope=0.1), STEEL), mdr.load("50 N")),
    "punch": (mdr.Contact(mdr.FlatPunch("1 mm"), STEEL), mdr.load("50 N")),
    "jkr": (mdr.Contact(TIP, GEL, adhesion=mdr.JKR("2 mJ/m^2")), mdr.indent("1 um")),
    "cohesive zone": (
        mdr.Contact(TIP, GEL, adhesion=mdr.MaugisDugdale("2 mJ/m^2", range="100 nm")),
        mdr.indent("1 um"),
    ),
    "partial slip": (mdr.Contact(BALL, STEEL, STEEL, friction=COULOMB), SHEARED),
    "on the counterbody": (mdr.Contact(BALL, mdr.Rigid(), STEEL, friction=COULOMB), SHEARED),
    "nearly auxetic": (
        mdr.Contact(mdr.RoundedFlat("1 mm", "10 mm"), mdr.Elastic("1 GPa", -0.9)),
        mdr.load("1 N"),
    ),
}


def compared(contact, path):
    result = mdr.solve(contact, path)
    return compare_subsurface(result, range(result.data.sizes["step"]))


@pytest.mark.parametrize("name", CONTACTS)
def test_stress_is_that_of_point_loads(name):
    result = compared(*CONTACTS[name])
    assert result.integral_error < 1e-11
    assert result.largest_difference < 1e-11


def test_units_do_not_matter():
    for size in (1e-9, 1.0):
        contact = mdr.Contact(mdr.Paraboloid(size), mdr.Elastic(1.0, 0.3))
        assert compared(contact, mdr.indent(1e-3 * size)).largest_difference < 1e-12


def test_a_wrong_field_is_seen():
    result = compared(*CONTACTS["ball"])
    result.data["mdr"].values[2] *= 1.0 + 1e-6
    assert 1e-7 < result.largest_difference < 1e-5


@pytest.mark.parametrize(
    ("contact", "words"),
    [
        (mdr.Contact(BALL, mdr.Layered([mdr.Layer(GEL, "20 um")], base=STEEL)), "the body has layers"),
        (mdr.Contact(BALL, ZINC), "isotropic bodies"),
        (mdr.Contact(TIP, GEL, adhesion=mdr.DMT("2 mJ/m^2")), "DMT does not resolve"),
    ],
)
def test_what_is_not_compared_says_why(contact, words):
    result = compared(contact, mdr.indent("1 nm"))
    assert result.data is None
    assert math.isnan(result.largest_difference)
    assert words in result.remarks()[0]


def test_verify_shows_the_stress():
    result = mdr.verify(*CONTACTS["ball"], elements=40, steps=1)
    assert result.subsurface.largest_difference < 1e-12
    assert "claim EXACT" in result.summary()
    figure = result.plot()
    assert "depth $z$ (µm)" in [axes.get_xlabel() for axes in figure.axes]
    assert not faults(figure)


def test_verify_shows_the_stress_of_friction():
    contact, path = CONTACTS["partial slip"]
    result = mdr.verify(contact, path, elements=8, steps=4)
    assert result.subsurface.largest_difference < 1e-12
    assert "point loads" in result.summary()
    assert not faults(result.plot())


@pytest.mark.long
def test_the_stress_of_verify_from_the_shell(tmp_path):
    from typer.testing import CliRunner

    case = tmp_path / "joint.toml"
    assert CliRunner().invoke(app, ["new", "joint", "-o", str(case)]).exit_code == 0
    answer = CliRunner().invoke(app, ["verify", str(case), "--cells", "8", "--steps", "4", "--json"])
    stress = json.loads(answer.stdout)["verification"]["stress"]
    assert stress["largest_difference"] < 1e-10
    assert np.isfinite(stress["integral_error"])
