"""Bodies that are not of revolution by the method and by boundary elements in three dimensions, which know nothing of it."""

import importlib.util
import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

import pymdr as mdr
from common import STEEL
from pymdr.errors import MissingExtraError, PathError, ProblemError
from pymdr.independent.engines import built_in
from pymdr.workbench.cli import app

needs_engine = pytest.mark.skipif(
    importlib.util.find_spec("ContactMechanics") is None,
    reason="ContactMechanics, of the extra rough, is missing",
)


def verified(shape, depth, pixels=49, steps=1, **given):
    path = mdr.indent(depth, steps=4)
    return mdr.verify(mdr.Contact(shape, STEEL), path, elements=pixels, steps=steps, **given)


def within(result, names):
    for name in names:
        difference, error = (result.data[f"{name}_{end}"].values for end in ("difference", "error"))
        assert np.all(np.abs(difference) <= error)
        assert np.all(error < 0.05)


@needs_engine
@settings(max_examples=3, deadline=None)
@given(st.floats(-2.0, 2.0), st.floats(-8.0, 0.0), st.floats(-6.0, -3.0))
def test_any_ellipse_is_that_of_hertz_within_the_error_of_the_grid(ratio, size, shallow):
    radius, ratio = 10.0**size, 10.0**ratio
    shape = mdr.EllipticParaboloid(radius, radius * ratio)
    result = verified(shape, radius * min(ratio, 1.0) * 10.0**shallow)
    within(result, ("normal_force", "normal_stiffness", "elastic_energy", "contact_area"))
    within(result, ("semi_axis_x", "semi_axis_y"))
    assert result.largest_difference < 8e-4


@pytest.mark.long
@needs_engine
@settings(max_examples=3, deadline=None)
@given(
    st.floats(1.2, 4.0),
    st.lists(st.tuples(st.floats(-0.1, 0.1), st.floats(0.0, 6.3)), min_size=3, max_size=3),
)
def test_no_body_bears_less_than_its_bound(power, lobes):
    """r^n (1 + sum e_m cos(m phi - phi_m)), m = 2, 3, 4."""

    def f(x, y):
        r, phi = np.hypot(x, y), np.arctan2(y, x)
        lobe = sum(e * np.cos((m + 2) * phi - at) for m, (e, at) in enumerate(lobes))
        return 1e-6 * (r / 1e-3) ** power * (1.0 + lobe)

    result = verified(mdr.Function2D(f), 1e-6)
    below, error = (result.data[f"force_lower_bound_{end}"].item() for end in ("difference", "error"))
    assert -0.2 < below <= error < 0.02
    assert abs(result.data["force_estimate_difference"].item()) < 0.012 + error


@needs_engine
def test_pyramids_tables_and_figures():
    calls = []
    result = verified(mdr.Pyramid.berkovich(), "1 um", steps=2, progress=lambda *at: calls.append(at))
    assert calls == [(1, 2), (2, 2)]
    np.testing.assert_allclose(result.data["indentation"], [0.25e-6, 1e-6])
    within(result, ("normal_force", "normal_stiffness", "elastic_energy"))
    # one number, C, at all depths
    constant = result.data["normal_force_engine"] / result.data["indentation"] ** 2
    assert float(constant[0] / constant[1]) == pytest.approx(1.0, abs=1e-6)
    assert "contact_area_mdr" not in result.data
    assert "lower bound" in str(result)
    assert "49 x 49 pixels" in str(result)
    (left, middle, right) = result.plot().axes[:3]
    assert left.get_aspect() == 1.0
    assert middle.lines
    assert right.lines
    ellipse = verified(mdr.EllipticParaboloid("10 mm", "2 mm"), "1 um")
    hertz = [line for line in ellipse.plot().axes[1].lines if line.get_label() == "Hertz"]
    assert len(hertz) == 2


@needs_engine
def test_what_is_not_known_of_a_body_is_not_judged():
    bowl = mdr.Function2D(lambda x, y: x**2 + 2.0 * y**2, max_radius=0.5)
    shallow, deep = verified(bowl, 0.1), verified(bowl, 0.6)
    assert abs(shallow.largest_difference) < 1e-3
    assert math.isnan(deep.largest_difference)
    assert np.isnan(deep.data["normal_force_engine"]).all()
    assert "the contact reaches the unknown part of the body" in str(deep)
    assert deep.plot().axes


@pytest.mark.long
@needs_engine
@settings(max_examples=2, deadline=None)
@given(st.floats(2.2, 5.0), st.floats(0.0, 6.3), st.floats(0.1, 0.6))
def test_another_summit_is_seen(far, angle, low):
    """As on one grid over both, of about the same spacing."""
    x0, y0 = far * math.cos(angle), far * math.sin(angle)

    def f(x, y):
        return 1e-6 * np.minimum(x * x + y * y, (x - x0) ** 2 + (y - y0) ** 2 + low)

    body = mdr.Elastic(1.0, 0.0)
    result = mdr.verify(mdr.Contact(mdr.Function2D(f), body), mdr.indent(1e-6), elements=33, steps=1)
    assert max(result.data.attrs["points"]) > 33
    n = 161
    x, y = (np.linspace(min(0.0, end) - 1.2, max(0.0, end) + 1.2, n) for end in (x0, y0))
    heights = -f(x[:, None], y)
    size = [float(np.ptp(one)) * n / (n - 1) for one in (x, y)]
    both = mdr.press(mdr.Topography(heights, size), body, indentation=1e-6 + float(heights.max()))
    assert result.data["normal_force_engine"].item() == pytest.approx(
        float(both["normal_force"][0]), rel=5e-3
    )
    assert result.data["normal_force_engine"].item() > result.data["force_lower_bound_mdr"].item() * 1.05


@needs_engine
def test_a_measured_tip_turned_by_hand():
    """Heights on a grid and the same function bear alike."""
    x = 1e-8 * np.arange(-60, 61)
    heights = -(x[:, None] ** 2 + 0.5 * x**2 + 0.4 * x[:, None] * x) / 4e-6
    sampled = verified(mdr.Sampled2D(heights, 121e-8), "10 nm")
    smooth = verified(mdr.Function2D(lambda x, y: (x**2 + 0.5 * y**2 + 0.4 * x * y) / 4e-6), "10 nm")
    forces = [float(one.data["normal_force_engine"].item()) for one in (sampled, smooth)]
    assert forces[0] == pytest.approx(forces[1], rel=1e-3)


def test_refusals(monkeypatch):
    tip = mdr.EllipticParaboloid("1 mm", "2 mm")
    with pytest.raises(ProblemError, match="pixels = 9; a whole number from 33 to 1025"):
        verified(tip, "1 um", pixels=9)
    with pytest.raises(PathError, match="no contact"):
        verified(tip, "-1 um")
    with pytest.raises(ProblemError, match="is unknown; give one of"):
        verified(tip, "1 um", engine="none")

    def missing():
        raise MissingExtraError("ContactMechanics is missing; install pymdr[rough]")

    monkeypatch.setattr(built_in, "_contact_mechanics", missing)
    with pytest.raises(MissingExtraError, match=r"pymdr\[rough\]"):
        verified(tip, "1 um")


@needs_engine
def test_from_the_shell(tmp_path):
    case = tmp_path / "tip.toml"
    case.write_text(
        '[profile]\nkind = "pyramid"\nsides = 4\nslope = 0.2\n[body]\nkind = "elastic"\nyoung = "1 GPa"\npoisson = 0.3\n'
        '[[path]]\nkind = "indent"\nindentation = "1 um"\n'
    )
    arguments = ["verify", str(case), "--pixels", "49", "--steps", "1", "--json", "-o", str(tmp_path / "out")]
    answer = CliRunner().invoke(app, arguments)
    assert answer.exit_code == 0, answer.output
    data = json.loads(answer.stdout)["verification"]
    assert data["solver"] == "pixels"
    assert data["n"] == 49
    assert data["largest_difference"] < 2e-3
    assert (tmp_path / "out" / "verify.png").exists()
