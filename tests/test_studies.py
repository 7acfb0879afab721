"""What all studies have in common: claims that bound true errors, conditions at the largest contact, tables, figures and files."""

import json
import math
import pickle

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

import pymdr as mdr
from drawing import examples
from pymdr.line.adhesion import power_law_pull_off
from pymdr.solving.study import Study

STEEL = mdr.Elastic("210 GPa", 0.0)
GEL = mdr.Contact(mdr.Paraboloid("1 mm"), mdr.Elastic("30 kPa", 0.5), adhesion=mdr.JKR("50 mJ/m^2"))
WAVE = np.sin(np.linspace(0.0, 20.0, 400))
PIXELS = (np.arange(64) + 0.5) * 1e-8
RUBBER = mdr.Viscoelastic(mdr.StandardSolid("1 MPa", "3 MPa", "0.1 ms"), poisson=0.5)


def questions(radius, scale):
    """Studies of a ball whose contact is about `scale` of its radius wide, or wider."""
    ball = mdr.Paraboloid(radius)
    soft, joint = (
        mdr.Contact(ball, mdr.Elastic(1e6, 0.0)),
        mdr.Contact(ball, STEEL, STEEL, friction=mdr.Coulomb(0.3)),
    )
    depth = scale**2 * radius
    # m v^2/2 is the energy 8/15 E* sqrt(R) d^2.5
    mass = 16.0 / 15.0 * 1e6 * math.sqrt(radius) * depth**2.5
    work = 1e6 * radius * scale**3 / 4.5 / math.pi * 2.0
    sticky = mdr.Contact(ball, soft.body, adhesion=mdr.JKR(work))
    return {
        "impact": lambda: mdr.impact(soft, mass=mass, speed=1.0),
        "restitution": lambda: mdr.restitution(soft, mass=mass, speeds=[0.5, 1.0]),
        "friction loop": lambda: mdr.friction_loop(joint, [0.1 * depth], indentation=depth),
        "pull-off": lambda: mdr.pull_off(sticky, machine_stiffness=0.0, pressed_to=depth),
        "regime": lambda: mdr.adhesion_regime(sticky, range=1e-3 * depth),
        "rolling": lambda: mdr.rolling(joint, [1e-3], indentation=depth),
    }


@pytest.mark.long
@settings(deadline=None, max_examples=examples(6))
@given(st.sampled_from(sorted(questions(1.0, 0.1))), st.floats(-8.5, 1.0), st.sampled_from([0.05, 0.2, 0.5]))
def test_every_study_measures_its_conditions_at_its_largest_contact(name, decade, scale):
    study = questions(10.0**decade, scale)[name]()
    assert isinstance(study, Study)
    (wide,) = [one for one in study.assumptions if one.name == "half-space"]
    if name not in ("pull-off", "regime"):
        assert wide.measure == pytest.approx(scale, rel=1e-6)
    unmet = [one for one in study.assumptions if not one.met]
    assert wide.met == (wide.measure <= 0.3)
    for text in (study.summary(), str(study)):
        assert text.count("NOT MET") == len(unmet)
    below = study.plot().get_supxlabel().replace("\n", " ")
    assert below.count("NOT MET") == len(unmet)
    assert all(claim.reason for claim in study.claims.values())


def test_a_blow_that_is_too_hard_says_so():
    ball = mdr.Contact(mdr.Paraboloid("10 mm"), mdr.Elastic("1 MPa", 0.5))
    for study in (
        mdr.impact(ball, mass="4 g", speed="100 m/s"),
        mdr.restitution(ball, mass="4 g", speeds=["1 m/s", "100 m/s"]),
    ):
        (slope, wide) = [one for one in study.assumptions if not one.met]
        assert (slope.name, wide.name) == ("small slope", "half-space")
        assert wide.measure == pytest.approx(1.949, rel=1e-3)
        assert "a/R = 1.95 (limit 0.3): NOT MET" in study.summary()


@pytest.mark.long
@settings(deadline=None, max_examples=examples(6))
@given(st.integers(12, 200), st.floats(-8.0, 0.0), st.sampled_from([0.0, math.inf, 0.3]))
def test_errors_of_pull_offs_of_samples_are_bounds(count, decade, machine):
    radius = 10.0**decade
    r = np.linspace(0.0, radius, count)
    body, work = mdr.Elastic(1e6, 0.0), 1e6 * radius * 1e-4
    k = machine * 1e6 * radius if 0.0 < machine < math.inf else machine
    exact = power_law_pull_off(2.0, 0.5 / radius, 1e6, work, k)
    # a cubic spline through a parabola is the parabola; a cosine is not its spline
    tips = {"parabola": r**2 / (2.0 * radius), "hidden": 1e4 * radius + r**2 / (2.0 * radius)}
    result = mdr.pull_off(
        mdr.Contact(mdr.Sampled(r, tips["parabola"]), body, adhesion=mdr.JKR(work)), machine_stiffness=k
    )
    offset = tips["hidden"][0]
    rounded = mdr.Function(lambda x: offset + x**2 / (2.0 * radius))
    hidden = mdr.pull_off(mdr.Contact(rounded, body, adhesion=mdr.JKR(work)), machine_stiffness=k)
    for one in (result, hidden):
        for name in ("normal_force", "indentation", "contact_radius"):
            error = one.claims[name].error
            claimed = 1e-9 if error is None else max(float(error[0]), 1e-12)
            assert abs(float(one[name]) / float(getattr(exact, name)) - 1.0) <= 3.0 * claimed


@pytest.mark.long
@settings(deadline=None, max_examples=examples(6))
@given(st.floats(-7.0, 0.0), st.floats(-3.0, 3.0), st.floats(2.0, 6.0))
def test_restitution_of_a_rounded_callable_errs_as_it_claims(decade, log_speed, hides):
    radius = 10.0**decade
    offset = 10.0**hides * 1e-4 * radius
    body, speeds = mdr.Elastic(1e6, 0.0), 10.0**log_speed * np.array([1.0, 1.5])
    depth = 1e-4 * radius
    mass = 16.0 / 15.0 * 1e6 * math.sqrt(radius) * depth**2.5 / speeds[0] ** 2
    results, exact = (
        mdr.restitution(mdr.Contact(tip, body), mass=mass, speeds=speeds)
        for tip in (mdr.Function(lambda r: offset + r**2 / (2.0 * radius)), mdr.Paraboloid(radius))
    )
    assert exact["contact_time"].values == pytest.approx(
        2.943275184324705 * exact["indentation"].values / speeds, rel=1e-11
    )
    for name in ("contact_time", "indentation", "normal_force", "contact_radius"):
        error = results.claims[name].error
        claimed = np.full(2, 1e-9) if error is None else np.maximum(error, 1e-11)
        missed = np.abs(results[name].values / exact[name].values - 1.0)
        assert np.all(missed <= 3.0 * claimed)


@pytest.mark.parametrize(
    "study",
    [
        mdr.impact(GEL, mass="1 mg", speed="0.1 m/s"),
        mdr.restitution(mdr.Contact(GEL.profile, GEL.body), mass="1 mg", speeds=[0.05, 0.2]),
        mdr.pull_off(GEL),
        mdr.adhesion_regime(GEL, range="0.5 nm"),
        mdr.friction_loop(
            mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(0.3)),
            ["0.1 um", "0.2 um"],
            coefficient=[0.2, 0.3],
            normal_force="10 N",
        ),
        mdr.assess(GEL, mdr.indent("1 um")),
        mdr.sweep(
            mdr.Contact(GEL.profile, GEL.body),
            mdr.indent("1 um", steps=2),
            {"body.young": ["1 kPa", "2 kPa"]},
        ),
        mdr.fit_prony({"time": np.geomspace(0.1, 1e2, 9), "modulus": np.geomspace(2e3, 1e3, 9)}, terms=2),
        mdr.measured_loops(
            xr.Dataset({"shift": ("step", WAVE), "tangential_force": ("step", WAVE + np.roll(WAVE, 5))})
        ),
        mdr.azimuthal_profile(
            mdr.Topography(-np.add.outer((PIXELS - 3e-7) ** 2, (PIXELS - 3.4e-7) ** 2) / 2e-6, 6.4e-7)
        ),
        mdr.verify(mdr.Contact(GEL.profile, GEL.body), mdr.indent("1 um", steps=2), elements=40),
    ],
    ids=lambda study: type(study).__name__,
)
def test_every_study_is_written_drawn_pickled_and_saved(study, tmp_path):
    again = pickle.loads(pickle.dumps(study))
    assert again.data.identical(study.data)
    assert str(again) == str(study)
    assert study._repr_html_().startswith("<div>")
    assert study.plot().axes
    study.to_csv(tmp_path / "study.csv", about=True)
    lines = (tmp_path / "study.csv").read_text().splitlines()
    assert any(line.startswith("# claim of") for line in lines) == bool(study.claims)
    rows = [line for line in lines if not line.startswith("#")]
    assert len(rows) - 1 == math.prod(study.data.sizes.values())
    study.to_xlsx(tmp_path / "study.xlsx")
    study.save(tmp_path / "study.nc")
    with xr.open_dataset(tmp_path / "study.nc") as saved:
        assert set(saved.data_vars) == set(study.data.data_vars)
        data = json.loads(saved.attrs["pymdr_metadata"])
    assert set(data["claims"]) == set(study.claims)
    with pytest.raises(mdr.QuantityError, match=r"no quantity 'nothing'"):
        study["nothing"]


def test_restitution_of_rubber_measures_the_fastest_blow():
    ball = mdr.Contact(mdr.Paraboloid("5 mm"), RUBBER)
    study = mdr.restitution(ball, mass="1 g", speeds=[1e-3, 1.0, 100.0])
    measures = {one.name: one.measure for one in study.assumptions}
    assert measures["half-space"] == pytest.approx(float(study["contact_radius"][-1]) / 5e-3, rel=1e-6)
    assert "viscoelastic half-spaces" in study.claims["restitution"].reason
    assert np.all(study.claims["restitution"].error < 1e-6)


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (mdr.equivalent_profile(mdr.FlatPunch("1 mm")), ["EquivalentProfile", "edge", "1 mm"]),
        (mdr.effective_moduli(mdr.Elastic("1 GPa", 0.0)), ["EffectiveModuli", "normal", "1 GPa"]),
        (mdr.foundation(mdr.Contact(GEL.profile, GEL.body), n=40), ["SpringFoundation", "40 values from"]),
    ],
    ids=lambda value: type(value).__name__,
)
def test_steps_of_the_method_show_in_notebooks(value, words):
    html = value._repr_html_()
    assert html.startswith("<div>")
    assert all(word in html for word in words)
