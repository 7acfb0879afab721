"""Adhesion under shear without slip: closed forms of the sheared edge, slip, limits, scaling and what is refused."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

import pymdr as mdr
from drawing import examples
from pymdr.errors import PathError, ProblemError
from pymdr.workbench.casefile import read_case

BODY = mdr.Elastic(0.75, 0.5)
"""E* = 1 Pa and G* = 2/3 Pa."""
WORK, SHEAR = 0.1, 2.0 / 3.0
STICK = mdr.Coulomb(math.inf)


def contact(profile=None, work=WORK, body=BODY):
    return mdr.Contact(profile or mdr.Paraboloid(1.0), body, adhesion=mdr.JKR(work), friction=STICK)


@pytest.mark.parametrize(
    ("profile", "g"),
    [
        (mdr.Paraboloid(1.0), lambda a: a**2),
        (mdr.Cone(slope=1.0), lambda a: 0.5 * math.pi * a),
        (mdr.PowerLaw(4.0, height=1.0, radius=1.0), lambda a: 8.0 / 3.0 * a**4),
    ],
)
def test_the_edge_releases_the_work_of_adhesion_in_both_modes(profile, g):
    d, shifts = 0.4, [0.2, 0.5, 0.35]
    path = mdr.indent(d) >> mdr.Path(shift=shifts)
    result = mdr.solve(contact(profile), path)
    a, u = result["contact_radius"].values, result["shift"].values
    for radius, shift in zip(a, u, strict=True):
        expected = brentq(
            lambda x, shift=shift: g(x) - math.sqrt(2.0 * math.pi * x * WORK - SHEAR * shift**2) - d,
            radius * (1.0 - 1e-3),
            radius * (1.0 + 1e-3),
            xtol=1e-15,
        )
        assert radius == pytest.approx(expected, rel=1e-12)
    assert result["tangential_force"].values == pytest.approx(2.0 * SHEAR * a * u, rel=1e-13)
    assert result["stored_tangential_energy"].values == pytest.approx(SHEAR * a * u**2, rel=1e-13)
    assert result["energy_release_rate"].values == pytest.approx(WORK, rel=1e-12)
    assert a[0] > a[1] > a[2] < a[3]
    claim = result.claims["contact_radius"]
    assert claim.level is mdr.Level.APPROXIMATE
    assert "disputed" in claim.reason
    plain = float(
        mdr.solve(mdr.Contact(profile, BODY, adhesion=mdr.JKR(WORK)), mdr.indent(d))["contact_radius"][0]
    )
    assert plain == pytest.approx(a[0], rel=1e-12)
    assert np.all(claim.error >= np.abs(plain / a - 1.0) * (1.0 - 1e-9))


def test_a_held_ball_slips_at_the_fold():
    """At constant depth 2 a (a^2 - d) = pi work / E* where the contact is lost."""
    d = 0.5
    a = brentq(lambda x: 2.0 * x * (x**2 - d) - math.pi * WORK, 0.5, 2.0)
    u = math.sqrt((2.0 * math.pi * a * WORK - (a**2 - d) ** 2) / SHEAR)
    shifts = u * np.array([1.0 - 1e-10, 1.0 + 1e-10])
    result = mdr.solve(contact(), mdr.indent(d) >> mdr.Path(shift=shifts) >> mdr.indent(-0.1))
    assert float(result["contact_radius"][1]) == pytest.approx(a, rel=1e-4)
    assert result.status is mdr.Status.SLIPPED
    assert np.isnan(result["normal_force"].values).tolist() == [False, False, True, False]
    assert float(result["normal_force"][3]) == 0.0
    assert result["jumped"].values.tolist() == [1.0, 0.0, 1.0, 0.0]
    assert any(note.startswith("slipped after row 1") for note in result.notes)


def test_a_loaded_ball_slips_where_savkoor_and_briggs_say():
    """At constant force dF/da = 0 of F = 4 a^3 / 3 - 2 a sqrt(2 pi a work - G* u^2), by elimination of u."""
    load = 0.3

    # dF/da = 4 a^2 - 2 w - 2 pi a work / w with w from the force
    def fold(x):
        w = (4.0 * x**3 / 3.0 - load) / (2.0 * x)
        return 4.0 * x**2 - 2.0 * w - 2.0 * math.pi * x * WORK / w

    a = brentq(fold, (0.75 * load) ** (1.0 / 3.0) * 1.01, 1.5)
    w = (4.0 * a**3 / 3.0 - load) / (2.0 * a)
    u = math.sqrt((2.0 * math.pi * a * WORK - w * w) / SHEAR)
    shifts = u * np.array([1.0 - 1e-10, 1.0 + 1e-10])
    result = mdr.solve(contact(), mdr.load(load) >> mdr.Path(shift=shifts))
    assert float(result["contact_radius"][1]) == pytest.approx(a, rel=1e-4)
    assert result.status is mdr.Status.SLIPPED
    assert np.isnan(result["tangential_force"].values).tolist() == [False, False, True]


def test_a_sheared_ball_pulls_off_earlier_and_forms_anew_without_shear():
    path = mdr.indent(0.2) >> mdr.shift(0.3) >> mdr.indent(-0.6, steps=8) >> mdr.indent(0.2)
    result = mdr.solve(contact(), path)
    plain = mdr.solve(
        mdr.Contact(mdr.Paraboloid(1.0), BODY, adhesion=mdr.JKR(WORK)),
        mdr.indent(0.2) >> mdr.indent(-0.6, steps=8),
    )
    assert np.count_nonzero(result["contact_radius"]) - 2 < np.count_nonzero(plain["contact_radius"])
    assert result["contact_radius"].values[-1] == pytest.approx(result["contact_radius"].values[0], rel=1e-12)
    assert float(result["tangential_force"][-1]) == 0.0
    assert result.status is mdr.Status.ATTACHED


def test_a_flat_punch_slips_at_once():
    """Its edge is at rest up to E* w^2 + G* u^2 = 2 pi a work."""
    flat = contact(mdr.FlatPunch(1.0))
    u = math.sqrt(2.0 * math.pi * WORK / SHEAR)
    path = mdr.indent(0.2) >> mdr.Path(shift=[0.5 * u, u * (1.0 - 1e-8), u * (1.0 + 1e-8)])
    result = mdr.solve(flat, path)
    assert result["contact_radius"].values[:3].tolist() == [1.0, 1.0, 1.0]
    assert np.isnan(result["contact_radius"].values[3])


def test_a_machine_and_the_fields():
    result = mdr.solve(contact(), mdr.travel(0.8) >> mdr.shift(0.4, steps=2), machine_stiffness=2.0)
    d, force, a = (result[name].values for name in ("indentation", "normal_force", "contact_radius"))
    assert d + force / 2.0 == pytest.approx(0.8, rel=1e-12)
    w = np.sqrt(2.0 * math.pi * a * WORK - SHEAR * result["shift"].values ** 2)
    assert force == pytest.approx(4.0 * a**3 / 3.0 - 2.0 * a * w, rel=1e-12)
    points, weights = np.polynomial.legendre.leggauss(40)
    angle = 0.25 * math.pi * (points + 1.0)
    for name, total in (("pressure", force[-1]), ("shear_traction", float(result["tangential_force"][-1]))):
        values = result.field(name, a[-1] * np.sin(angle)).values
        summed = (
            0.25
            * math.pi
            * np.sum(weights * values * 2.0 * math.pi * a[-1] ** 2 * np.sin(angle) * np.cos(angle))
        )
        assert summed == pytest.approx(total, rel=1e-10)


def test_the_figures():
    result = mdr.solve(contact(), mdr.indent(0.5) >> mdr.shift(0.9, steps=9))
    assert set(result.figures(step=4)) == {"section", "shear", "fields"}
    result.plot(step=4)


@given(R=st.floats(-8.0, 0.0), E=st.floats(3.0, 9.0), fraction=st.floats(0.1, 0.8), depth=st.floats(0.5, 3.0))
@settings(max_examples=examples(16), deadline=None)
def test_lengths_and_moduli_scale(R, E, fraction, depth):
    """With lengths in units of (R work^2 / E*^2)^(1/3) all balls are one ball, and shear only shrinks the contact."""
    radius, modulus = 10.0**R, 0.75 * 10.0**E
    work = 1e-6 * radius * 10.0**E
    unit = (radius * work**2 / 10.0 ** (2.0 * E)) ** (1.0 / 3.0)
    shift = fraction * math.sqrt(2.0 * math.pi * work * math.sqrt(depth * unit * radius) * 1.5 / 10.0**E)
    made = contact(mdr.Paraboloid(radius), work, mdr.Elastic(modulus, 0.5))
    result = mdr.solve(made, mdr.indent(depth * unit) >> mdr.shift(shift))
    alike = contact(mdr.Paraboloid(1.0), 1e-6, BODY)
    scale = 1.0 / radius
    other = mdr.solve(alike, mdr.indent(depth * unit * scale) >> mdr.shift(shift * scale))
    a = result["contact_radius"].values
    assert a * scale == pytest.approx(other["contact_radius"].values, rel=1e-9, nan_ok=True)
    assert not a[1] > a[0]


def test_the_case_file_and_the_saved_result(tmp_path, shell):
    case = tmp_path / "sheared.toml"
    case.write_text(
        '[profile]\nkind = "paraboloid"\nradius = "1 mm"\n[body]\nkind = "elastic"\nyoung = "1 MPa"\npoisson = 0.5\n'
        '[adhesion]\nkind = "jkr"\nwork = "50 mJ/m^2"\n[friction]\nkind = "coulomb"\ncoefficient = "inf"\n'
        '[[path]]\nkind = "load"\nnormal_force = "1 mN"\n[[path]]\nkind = "shift"\nshift = "1 um"\nsteps = 4\n'
    )
    result = mdr.solve(read_case(case).contact, read_case(case).path)
    a = result["contact_radius"].values
    assert np.all(np.diff(a[1:]) < 0.0)
    result.save(tmp_path / "sheared.nc")
    again = mdr.open_result(tmp_path / "sheared.nc")
    assert again["contact_radius"].values.tolist() == a.tolist()
    assert again.field("shear_traction", [0.0]).values == pytest.approx(
        result.field("shear_traction", [0.0]).values
    )
    code, out, _ = shell("run", case, "--no-figures")
    assert code == 0
    assert "disputed" in out


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (
            lambda: mdr.Contact(mdr.Paraboloid(1.0), BODY, adhesion=mdr.JKR(WORK), friction=mdr.Coulomb(0.3)),
            ProblemError,
            "coefficient of 0.3",
        ),
        (
            lambda: mdr.Contact(
                mdr.Paraboloid(1.0), BODY, adhesion=mdr.MaugisDugdale(WORK, strength=1.0), friction=STICK
            ),
            ProblemError,
            "shear of its zone",
        ),
        (
            lambda: mdr.Contact(
                mdr.Paraboloid(1.0), BODY, adhesion=mdr.JKR(WORK, work_receding=1.0), friction=STICK
            ),
            ProblemError,
            "one work of adhesion",
        ),
        (lambda: mdr.solve(contact(), mdr.indent(0.1) >> mdr.drag(0.1)), PathError, "prescribe shift"),
        (lambda: mdr.solve(contact(), mdr.indent(0.1) >> mdr.twist(0.1)), PathError, "prescribe shift"),
        (lambda: mdr.solve(contact(), mdr.indent(0.1) >> mdr.shift((0.1, 0.0))), PathError, "along one line"),
        (lambda: mdr.solve(contact(), mdr.load(-0.1)), PathError, "out of contact"),
        (lambda: mdr.solve(contact(), mdr.indent(0.1), keep=1), PathError, "keep="),
    ],
)
def test_what_adhesion_under_shear_refuses(make, error, words):
    with pytest.raises(error, match=words):
        make()
