"""Adhesive contacts held against rings whose edge is pulled."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pymdr as mdr
from common import GEL
from pymdr.errors import PathError, ProblemError

GLUE = mdr.JKR("5 mJ/m^2")
PROFILES = (
    mdr.Sphere("50 um"),
    mdr.Cone(slope=0.2),
    mdr.PowerLaw(4, "10 um", "50 um"),
    mdr.FlatPunch("20 um"),
    mdr.TruncatedCone("10 um", slope=0.1),
)


@given(st.sampled_from(PROFILES), st.floats(0.2, 3.0))
@settings(max_examples=8, deadline=None)
def test_both_agree_along_loops_of_any_profile(profile, deep):
    contact = mdr.Contact(profile, GEL, adhesion=GLUE)
    path = mdr.indent(f"{deep} um", steps=5) >> mdr.indent("-1 um", steps=10)
    result = mdr.verify(contact, path, elements=100, steps=3)
    assert result.largest_difference < 2e-5
    if not profile.breakpoints:  # at a kink it has a logarithm
        assert np.nanmax(result.data["pressure_difference"]) < 1e-3
    assert np.nanmax(np.abs(result.data["elastic_energy_difference"])) < 1e-4


def test_a_machine_may_pull_and_the_result_is_drawn(tmp_path):
    contact = mdr.Contact(mdr.Sphere("50 um"), GEL, adhesion=GLUE)
    path = mdr.travel("2 um", steps=4) >> mdr.travel("-2 um", steps=4)
    reports = []
    result = mdr.verify(
        contact,
        path,
        elements=60,
        steps=2,
        machine_stiffness="0.1 N/m",
        progress=lambda *at: reports.append(at),
    )
    assert reports == [(1, 2), (2, 2)]
    assert "relative to their largest value" in result.summary()
    assert np.isfinite(result.pressures["mdr"]).all()
    result.plot().savefig(tmp_path / "both.png")
    without = mdr.verify(
        mdr.Contact(mdr.Sphere("50 um"), GEL), path, elements=60, steps=2, machine_stiffness="0.1 N/m"
    )
    assert without.largest_difference < 1e-4


def test_what_rings_do_not_know_of_adhesion_is_refused():
    wide = mdr.Contact(mdr.Sphere("50 um"), GEL, adhesion=mdr.MaugisDugdale("5 mJ/m^2", strength="10 kPa"))
    with pytest.raises(ProblemError, match="other laws of adhesion"):
        mdr.verify(wide, mdr.indent("1 um"))
    with pytest.raises(PathError, match="no contact"):
        mdr.verify(mdr.Contact(mdr.Sphere("50 um"), GEL, adhesion=GLUE), mdr.indent("-1 um"))
