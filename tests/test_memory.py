"""Contacts that remember against closed forms, quadrature, limits and each other."""

from __future__ import annotations

import numpy as np
import pytest

from pymdr.line.curves import ElasticLine
from pymdr.line.memory import Relaxation, creep, follow_springs, ting
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.problem.profiles import Paraboloid


def line_of(profile):
    return ElasticLine(equivalent_profile(profile), 1.0)


PARABOLOID = line_of(Paraboloid(1.0))

STANDARD = Relaxation(1.2, np.array([4.0]), np.array([0.4]))


def solid(inputs):
    return Relaxation(4.0 * inputs["Ginf"], np.array([4.0 * inputs["G1"]]), np.array([inputs["tau"]]))


def triangle(t, top, speed):
    return speed * np.where(t <= top, t, 2.0 * top - t)


def test_standard_solid_of_the_references(references):
    entry = references["ting_sls_parab"]
    t = np.array([0.0, *entry["inputs"]["t"]])
    rows = ting(PARABOLOID, solid(entry["inputs"]), t, triangle(t, 1.0, 0.4))
    assert rows.force[1:] == pytest.approx(entry["expected"]["F"], rel=entry["rtol"], abs=1e-14)
    assert rows.contact_radius[1:] == pytest.approx(entry["expected"]["a"], rel=entry["rtol"], abs=1e-14)


def test_maxwell_of_the_references(references):
    entry = references["maxwell_constvel"]
    i = entry["inputs"]
    body = Relaxation(0.0, np.array([4.0 * i["G"]]), np.array([i["tau"]]))
    rows = ting(PARABOLOID, body, [0.0, i["t"]], [0.0, i["v"] * i["t"]])
    assert rows.force[1] == pytest.approx(entry["expected"]["F"], rel=entry["rtol"])
    lost = references["maxwell_detach"]["expected"]["t_end"]
    t = np.array([0.0, 1.0, lost * (1.0 - 1e-8), lost * (1.0 + 1e-8)])
    for rows in (
        ting(PARABOLOID, body, t, triangle(t, 1.0, 0.4)),
        follow_springs(PARABOLOID, body, t, triangle(t, 1.0, 0.4), n=4000),
    ):
        assert rows.force[3] == 0.0 == rows.contact_radius[3]
    assert ting(PARABOLOID, body, t, triangle(t, 1.0, 0.4)).contact_radius[2] > 0.0


def test_creep_of_the_references(references):
    entry = references["sls_creep"]
    i = entry["inputs"]
    rows = creep(PARABOLOID, STANDARD, [0.0, i["t"]], [i["F0"], i["F0"]])
    assert rows.contact_radius[1] == pytest.approx(entry["expected"]["a"], rel=entry["rtol"])
    assert rows.indentation[1] == pytest.approx(entry["expected"]["d"], rel=entry["rtol"])
