"""Friction found in measured loops: what made a loop is found in it again; what it does not tell is refused."""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

import pymdr as mdr
from common import STEEL
from legibility import faults
from pymdr.errors import ProblemError
from pymdr.workbench.cli import app

DATA = Path(__file__).parent.parent / "examples" / "data"


def mindlin(shift, turns, slides, most):
    """Mindlin's force of a paraboloid under constant load along turns of the shift, with Masing's branches."""

    def first(u):
        return most * np.sign(u) * (1.0 - np.clip(1.0 - np.abs(u) / slides, 0.0, 1.0) ** 1.5)

    force, begin = np.empty_like(shift), (0.0, 0.0)
    for number, (low, high) in enumerate(turns):
        part = slice(low, high)
        scale = 1.0 if number == 0 else 2.0
        force[part] = begin[1] + scale * first((shift[part] - begin[0]) / scale)
        end = shift[high - 1]
        begin = (end, begin[1] + scale * float(first(np.array((end - begin[0]) / scale))))
    return force


@settings(max_examples=4, deadline=None)
@given(
    log_size=st.floats(-7.0, 0.0),
    log_young=st.floats(4.0, 11.0),
    log_press=st.floats(-4.0, -1.5),
    mu=st.floats(0.05, 1.5),
    shift_ratio=st.floats(0.35, 1.8),
    offset=st.floats(-1.0, 1.0),
    log_start=st.floats(-2.0, 2.0),
    by_force=st.booleans(),
)
def test_friction_and_modulus_of_any_size_are_recovered(
    log_size, log_young, log_press, mu, shift_ratio, offset, log_start, by_force
):
    radius, young, poisson = 10.0**log_size, 10.0**log_young, 0.3
    depth = radius * 10.0**log_press
    modulus = young / (1.0 - poisson**2)
    load = 4.0 / 3.0 * modulus * math.sqrt(radius) * depth**1.5
    # G* of one body on a rigid one, 4 G / (2 - nu)
    slides = mu * modulus * depth / (2.0 * young / (1.0 + poisson) / (2.0 - poisson))
    top = shift_ratio * slides
    n = 40
    shift = np.concatenate(
        [np.linspace(0, top, n)[1:], *(np.linspace(a, -a, 2 * n)[1:] for a in (top, -top))]
    )
    turns = [(0, n - 1), (n - 1, 3 * n - 2), (3 * n - 2, 5 * n - 3)]
    force = mindlin(shift, turns, slides, mu * load)
    noise = 0.01 * force.max() * np.random.default_rng(7).normal(size=shift.size)
    normal = {"normal_force": ("step", np.full(shift.size, load))}
    if not by_force:
        normal = {"indentation": ("step", np.full(shift.size, depth))}
    record = xr.Dataset(
        {
            "shift": ("step", shift + offset * top),
            "tangential_force": ("step", force + noise + offset * force.max()),
            **normal,
        }
    )
    start = mdr.Contact(
        mdr.Paraboloid(radius),
        mdr.Elastic(young * 10.0**log_start, poisson),
        friction=mdr.Coulomb(mu * 10.0 ** (-0.5 * log_start)),
    )
    fitted = mdr.fit(start, record, ["friction.coefficient", "body.young"])
    for name, value in (
        ("friction.coefficient", mu),
        ("body.young", young),
        ("shift_origin", offset * top),
        ("baseline", offset * force.max()),
    ):
        assert abs(fitted[name].value - value) < 4.5 * fitted[name].error
    assert fitted["friction.coefficient"].error < 0.1 * mu
    assert fitted.noise == pytest.approx(np.std(noise), rel=0.1)
    assert fitted.waves == 0.0


def joint(mu=0.5, young="100 GPa"):
    return mdr.Contact(mdr.Sphere("10 mm"), mdr.Elastic(young, 0.3), STEEL, friction=mdr.Coulomb(mu))


def test_a_loop_of_a_file_by_python_and_by_the_shell(tmp_path):
    record = mdr.read_record(DATA / "joint_record.csv")
    free = ["friction.coefficient", "body.young"]
    fitted = mdr.fit(joint(), record, free)
    assert fitted["friction.coefficient"].low < 0.3 < fitted["friction.coefficient"].high
    assert fitted.force == "tangential_force"
    assert set(fitted.data) >= {"shift", "tangential_force", "normal_force", "model", "residual"}
    assert fitted.plot().axes[0].get_xlabel().startswith("tangential displacement")
    assert "tangential_force" in fitted._repr_html_()
    fitted.save(tmp_path / "fit.nc")
    with xr.open_dataset(tmp_path / "fit.nc") as again:
        assert json.loads(again.attrs["pymdr_fit"])["values"]["friction.coefficient"]["unit"] == ""
    case = tmp_path / "case.toml"
    case.write_text(
        "[profile]\nkind = 'sphere'\nradius = '10 mm'\n[body]\nkind = 'elastic'\nyoung = '100 GPa'\npoisson = 0.3\n"
        "[counterbody]\nkind = 'elastic'\nyoung = '210 GPa'\npoisson = 0.3\n[friction]\nkind = 'coulomb'\ncoefficient = 0.5\n"
    )
    arguments = ["fit", str(case), str(DATA / "joint_record.csv"), "--free", free[0], "--free", free[1]]
    run = CliRunner().invoke(app, [*arguments, "-o", str(tmp_path / "out"), "--json"])
    assert run.exit_code == 0, run.output
    values = json.loads(run.stdout)["fit"]["values"]
    assert values["friction.coefficient"]["value"] == pytest.approx(fitted["friction.coefficient"].value)
    assert (tmp_path / "out" / "fit.png").exists()
    assert (
        (tmp_path / "out" / "fit.csv")
        .read_text()
        .splitlines()[0]
        .startswith("shift [m],tangential_force [N]")
    )
    wrong = CliRunner().invoke(app, [*arguments, "--spring-constant", "1 N/m"])
    assert isinstance(wrong.exception, ProblemError)
    assert "force curves" in str(wrong.exception)


@pytest.mark.long
def test_several_loops_share_friction_and_samples_may_be_followed_only():
    record = mdr.read_record(DATA / "joint_record.csv")
    late = record.assign(used=("step", np.arange(record.sizes["step"]) >= 100))
    both = mdr.fit(joint(), [record, late], ["friction.coefficient", "body.young"])
    assert both["friction.coefficient"].low < 0.3 < both["friction.coefficient"].high
    assert {"shift_origin[0]", "baseline[0]"} <= set(both.values)
    # after the first turn, what sticks moves by the shift alone: where it began adds a constant, as the baseline does
    assert "the record does not determine shift_origin[1]" in both.summary()
    assert "the record does not determine baseline[1]" in both.summary()
    assert int((~both.data["used"].values).sum()) == 100
    assert "100 samples marked in the record are left out" in both.summary()


def test_slip_before_the_record_leaves_waves_that_are_reported():
    record = mdr.read_record(DATA / "joint_record.csv")
    fitted = mdr.fit(joint(), record.isel(step=slice(150, None)), ["friction.coefficient", "body.young"])
    assert fitted.waves > 1.0
    assert "slip before the record begins" in fitted.summary()


def test_bodies_with_memory_and_friction():
    rubber = mdr.Viscoelastic(mdr.StandardSolid("1 MPa", "2 MPa", "1 s"), poisson=0.5)
    contact = mdr.Contact(mdr.Sphere("50 mm"), rubber, friction=mdr.Coulomb(0.4))
    time = np.linspace(0.0, 1.5, 16)
    shift = 0.6e-3 * np.sin(2.0 * np.pi * np.maximum(time - 0.5, 0.0))
    depth = np.full(time.size, 0.5e-3)
    force = mdr.solve(contact, mdr.Path(time=time, indentation=depth, shift=shift))["tangential_force"].values
    noise = 0.01 * np.ptp(force) * np.random.default_rng(3).normal(size=time.size)
    columns = {"time": time, "indentation": depth, "shift": shift, "tangential_force": force + noise}
    record = xr.Dataset({name: ("step", values) for name, values in columns.items()})
    start = mdr.Contact(contact.profile, rubber, friction=mdr.Coulomb(1.0))
    fitted = mdr.fit(start, record, ["friction.coefficient"], shift_origin=0.0)
    mu = fitted["friction.coefficient"]
    assert abs(mu.value - 0.4) < 4.5 * mu.error
    assert mu.error < 0.01
    with pytest.raises(ProblemError, match="no time"):
        mdr.fit(start, record.drop_vars("time"), ["friction.coefficient"])


def small_loop():
    shift = 1e-8 * np.sin(np.linspace(0.0, 12.0, 200))
    pull = 2e7 * shift + 1e-2 * np.random.default_rng(0).normal(size=200)
    return xr.Dataset(
        {
            "shift": ("step", shift),
            "tangential_force": ("step", pull),
            "normal_force": ("step", np.full(200, 50.0)),
        }
    )


@pytest.mark.long
def test_unknowns_that_a_loop_does_not_determine_are_refused():
    record = mdr.read_record(DATA / "joint_record.csv")
    with pytest.raises(ProblemError, match=r"tangential stiffness at full stick, .* N/m under 50 N"):
        mdr.fit(joint(), record, ["friction.coefficient", "body.young", "body.poisson"])
    with pytest.raises(ProblemError, match="shows no slip"):
        mdr.fit(joint(), small_loop(), ["friction.coefficient", "body.young"])
    fitted = mdr.fit(joint(), small_loop(), ["body.young"])
    assert fitted["body.young"].error < 0.1 * fitted["body.young"].value


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda record: record.drop_vars("shift"), "no shift"),
        (lambda record: record.drop_vars("normal_force"), "no normal_force or indentation"),
        (lambda record: record * np.nan, "missing in row 1"),
        (lambda record: record.assign(shift=record["shift"] * 0.0), "does not change"),
        (lambda record: record.assign(normal_force=-record["normal_force"]), "never above 0"),
        (lambda record: record.isel(step=slice(5)), "5 samples"),
        (lambda record: record.assign(shift=record["shift"].assign_attrs(units="N")), "has the units 'N'"),
        (lambda record: record.assign(normal_force=50.0), "the dimensions none"),
        (lambda record: record.assign(used=("step", np.zeros(200, dtype=bool))), "true at one or more"),
        (lambda record: mdr.MeasuredCurve(force=np.zeros(9), indentation=np.zeros(9)), "has friction"),
    ],
)
def test_what_is_no_record_of_friction(change, words):
    with pytest.raises(ProblemError, match=words):
        mdr.fit(joint(), change(small_loop()), ["friction.coefficient"])


def test_origins_are_of_their_own_kind():
    with pytest.raises(ProblemError, match="shift_origin"):
        mdr.fit(joint(), small_loop(), ["body.young"], contact_point=0.0)
    with pytest.raises(ProblemError, match="a tilt are for normal forces"):
        mdr.fit(joint(), small_loop(), ["body.young", "tilt"])
    plain = mdr.Contact(mdr.Sphere("10 mm"), STEEL)
    curve = mdr.MeasuredCurve(force=np.linspace(0, 1, 20), indentation=np.linspace(0, 1e-6, 20))
    with pytest.raises(ProblemError, match="contact_point"):
        mdr.fit(plain, curve, ["body.young"], shift_origin=0.0)
    with pytest.raises(ProblemError, match="has no friction"):
        mdr.fit(plain, small_loop(), ["body.young"])


def test_laws_of_a_loop_are_compared_or_refused_in_words():
    record = mdr.read_record(DATA / "joint_record.csv")
    guess = joint(young="50 GPa")
    laws = {
        "ball": guess,
        "cone": dataclasses.replace(guess, profile=mdr.Cone(slope=0.001)),
        "stuck": dataclasses.replace(guess, friction=mdr.Coulomb(math.inf)),
        "frictionless": dataclasses.replace(guess, friction=None),
    }
    result = mdr.compare_laws(laws, record, ["friction.coefficient", "body.young"])
    assert result.best == "ball"
    assert result.weights["ball"] > 0.99
    assert "friction.coefficient = inf" in result.refusals["stuck"]
    assert "the contact has no friction" in result.refusals["frictionless"]
    assert not faults(result.plot())
