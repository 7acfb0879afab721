"""Adhesion by menisci: the constants of water, Kelvin's equation, and the law of a constant stress."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pymdr as mdr
from drawing import examples
from pymdr.errors import ProblemError
from pymdr.problem.capillary import water_molar_volume, water_surface_tension
from pymdr.workbench.casefile import read_case


@pytest.mark.parametrize(
    ("celsius", "tension", "density"),
    [
        (5.0, 74.94, 999.964),
        (20.0, 72.74, 998.204),
        (25.0, 71.97, 997.045),
        (50.0, 67.94, 988.04),
        (100.0, 58.91, 958.4),
    ],
)
def test_the_constants_of_water(celsius, tension, density):
    """IAPWS R1-76 and tables of the density of water at atmospheric pressure."""
    kelvin = celsius + 273.15
    assert 1e3 * water_surface_tension(kelvin) == pytest.approx(tension, abs=0.01)
    assert 18.01528e-3 / water_molar_volume(kelvin) == pytest.approx(density, rel=5e-5)


def test_kelvins_radius_and_the_law():
    """The radius of water at 20 degC is 0.54 nm / ln(1/H) within a percent (Israelachvili 2011, chapter 17)."""
    law = mdr.Capillary(humidity=0.5, contact_angle="30 deg")
    assert law.radius == pytest.approx(0.54e-9 / math.log(2.0), rel=0.01)
    assert law.work == pytest.approx(2.0 * law.tension * math.cos(math.radians(30.0)), rel=1e-14)
    assert law.cohesive_stress * law.range == pytest.approx(law.work, rel=1e-14)
    dry, wet = (mdr.Capillary(humidity=h).radius for h in (0.1, 0.99))
    assert dry < law.radius < wet
    other = mdr.Capillary("22 mN/m", humidity=0.5, molar_volume="58.7 ml/mol")
    assert other.radius == pytest.approx(22e-3 * 58.7e-6 / (8.314462618 * 293.15 * math.log(2.0)), rel=1e-12)


@pytest.mark.parametrize(("strength", "height", "expected"), [(2.0, 0.5, -1.528098), (0.5, 2.0, -1.695372)])
def test_pull_off_of_a_meniscus(strength, height, expected):
    """Pull-off over pi R work under a dead load, by an independent solution."""
    radius = 0.5 * height
    law = mdr.Capillary(strength * radius, kelvin_radius=radius)
    ball = mdr.Contact(mdr.Paraboloid(1.0), mdr.Elastic(1.0, 0.0), adhesion=law)
    force = mdr.pull_off(ball, machine_stiffness=0.0).normal_force
    assert force / (math.pi * law.work) == pytest.approx(expected, rel=1e-6)


@settings(max_examples=examples(10), deadline=None)
@given(st.floats(0.05, 0.95), st.floats(0.0, 80.0), st.floats(1e-8, 1e-3), st.floats(1e6, 1e11))
def test_the_law_is_that_of_maugis(humidity, angle, radius, young):
    law = mdr.Capillary(humidity=humidity, contact_angle=f"{angle} deg")
    same = mdr.MaugisDugdale(law.work, range=law.range)
    ball, body = mdr.Paraboloid(radius), mdr.Elastic(young, 0.3)
    one, other = (
        mdr.pull_off(mdr.Contact(ball, body, adhesion=each), machine_stiffness=0.0) for each in (law, same)
    )
    assert one.normal_force == pytest.approx(other.normal_force, rel=1e-10)
    assert -2.0 * (1 + 1e-9) <= one.normal_force / (math.pi * law.work * radius) <= -1.5 * (1 - 1e-6)


def test_a_case_of_a_humid_tip(tmp_path):
    file = tmp_path / "humid.toml"
    file.write_text(
        '[profile]\nkind = "paraboloid"\nradius = "30 nm"\n[body]\nkind = "elastic"\nyoung = "70 GPa"\npoisson = 0.2\n'
        '[adhesion]\nkind = "capillary"\nhumidity = 0.5\ncontact_angle = "30 deg"\ntemperature = "25 degC"\n'
        '[[path]]\nkind = "indent"\nindentation = "0.2 nm"\nsteps = 4\n[[path]]\nkind = "indent"\nindentation = "-3 nm"\nsteps = 30\n'
    )
    case = read_case(file)
    result = mdr.solve(case.contact, case.path)
    assert result.status is mdr.Status.PULLED_OFF
    assert "meniscus" in result.claims["normal_force"].reason
    result.save(tmp_path / "humid.nc")
    assert mdr.open_result(tmp_path / "humid.nc").contact == case.contact
    assert {"loop", "radius"} <= set(result.figures())


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, "neither of humidity and kelvin_radius"),
        ({"humidity": 0.5, "kelvin_radius": 1e-9}, "both of humidity"),
        ({"humidity": 1.0}, "below 1"),
        ({"humidity": 1.2}, "below 1"),
        ({"humidity": -0.1}, "above 0"),
        ({"humidity": 0.5, "contact_angle": "95 deg"}, "below"),
        ({"humidity": 0.5, "temperature": "-5 degC"}, "constants of water"),
        ({"humidity": 0.5, "temperature": "200 degC"}, "constants of water"),
        ({"humidity": 0.5, "volume": "1 um^3"}, "another law"),
        ({"kelvin_radius": "0 nm"}, "above 0"),
    ],
)
def test_refusals(given, words):
    with pytest.raises(ProblemError, match=words):
        mdr.Capillary(**given)


def test_bodies_without_a_known_zone_refuse_menisci():
    body = mdr.Graded("30 kPa", "1 mm", 0.4, 0.3)
    with pytest.raises(ProblemError, match="Capillary is not derived"):
        mdr.Contact(mdr.Sphere("1 mm"), body, adhesion=mdr.Capillary(humidity=0.5))
