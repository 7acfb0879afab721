"""Paths, claims, results, files and bad input."""

import math
import pickle
import sys

import numpy as np
import pint
import pytest
from scipy.special import struve

import pymdr as mdr
from common import STEEL, UNIT
from legibility import faults
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.problem.paths import History
from pymdr.problem.profiles import Interpolated
from pymdr.units import from_si, to_si, to_si_array

BALL = mdr.Contact(mdr.Sphere("10 mm"), STEEL, mdr.Elastic("70 GPa", 0.22))


def wavy(A, k=40.0):
    """r^2/2 + h (1 - cos kr) with A = h k^2 (R = 1): 2.6 gives its thresholds."""
    h = A / k**2
    return mdr.Function(
        lambda r: r * r / 2 + 2 * h * np.sin(k * r / 2) ** 2, derivative=lambda r: r + h * k * np.sin(k * r)
    )


# --- paths -----------------------------------------------------------------------------------------------


def test_load_gives_its_steps_and_not_the_virgin_state():
    force = mdr.solve(BALL, mdr.load("50 N", steps=5))["normal_force"].values
    assert force == pytest.approx([10, 20, 30, 40, 50], rel=1e-14)


def test_legs_follow_each_other_and_hold_keeps_the_controlled_channel():
    path = mdr.indent("1 um", steps=2) >> mdr.load("50 N", steps=2) >> mdr.hold(steps=2) >> mdr.indent("0 um")
    result = mdr.solve(BALL, path)
    force, d = result["normal_force"].values, result["indentation"].values
    assert d[1] == pytest.approx(1e-6, rel=1e-14)
    assert force[2] == pytest.approx((force[1] + 50) / 2, rel=1e-13)
    assert force[3:6] == pytest.approx([50, 50, 50], rel=1e-13)
    assert d[6] == force[6] == 0.0


def test_lift_off_is_no_contact():
    result = mdr.solve(BALL, mdr.indent("1 um") >> mdr.indent("-1 um", steps=2))
    for name in ("normal_force", "contact_radius", "elastic_energy", "mean_pressure"):
        assert result[name].values[1:].tolist() == [0.0, 0.0]
    assert result.field("gap", r=[0.0], step=-1).values[0] == pytest.approx(1e-6, rel=1e-12)


def test_arrays_one_row_per_sample_with_time():
    path = mdr.Path(time=[1.0, 2.0, 4.0], indentation=np.array([1.0, 3.0, 2.0]) * 1e-6)
    result = mdr.solve(BALL, path >> mdr.hold("2 s", steps=2))
    assert result["time"].values.tolist() == [1, 2, 4, 5, 6]
    assert result["indentation"].values.tolist() == [1e-6, 3e-6, 2e-6, 2e-6, 2e-6]


def test_ramp_and_duration():
    result = mdr.solve(BALL, mdr.ramp(indentation="1 um", steps=4, duration="2 s"))
    assert result["time"].values.tolist() == [0.5, 1.0, 1.5, 2.0]


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: mdr.Path(indentation=[]), "empty"),
        (lambda: mdr.Path(), "no channel"),
        (lambda: mdr.Path(indentation=[1.0], normal_force=[1.0]), "cannot both"),
        (lambda: mdr.Path(time=[1, 2], indentation=[1.0]), "2 times for 1 samples"),
        (lambda: mdr.Path(time=[2, 1], indentation=[1.0, 2.0]), "rise strictly"),
        (
            lambda: mdr.Path(time=[0, 1, 1], indentation=[1.0, 2.0, 2.0]),
            "entries 2 and 3 are 1 s and 1 s",
        ),
        (lambda: History(()), "path is empty"),
        (lambda: mdr.load("5 N", steps=0), "at least 1"),
        (lambda: mdr.load("5 N", steps=2.5), "whole number"),
        (lambda: mdr.ramp(), "no channel"),
        (lambda: mdr.ramp(indentation=1.0, normal_force=1.0), "cannot both"),
        (lambda: mdr.solve(BALL, mdr.load("-1 N")), "below 0 N"),
        (lambda: mdr.solve(BALL, mdr.load("1 N", duration="1 s") >> mdr.load("2 N")), "duration"),
        (lambda: mdr.solve(BALL, mdr.indent("10 mm")), "its radius"),
        (lambda: mdr.solve(BALL, mdr.indent("11 mm")), "its radius"),
        (lambda: mdr.solve(BALL, mdr.load("1e12 N")), "its radius"),
        (lambda: mdr.solve(BALL, "50 N"), "not a path"),
    ],
)
def test_bad_paths(make, words):
    with pytest.raises(mdr.PathError, match=words):
        make()


# --- values ----------------------------------------------------------------------------------------------


def test_text_pint_and_plain_numbers_are_the_same():
    ureg = pint.UnitRegistry()
    assert mdr.Sphere("10 mm") == mdr.Sphere(10 * ureg.mm) == mdr.Sphere(0.01)
    assert mdr.Elastic("210 GPa", 0.3) == mdr.Elastic(210e9, "0.3")
    assert hash(mdr.Sphere("10 mm")) == hash(mdr.Sphere(0.01))
    assert to_si_array([1, 2] * ureg.um, "m").tolist() == [1e-6, 2e-6]
    assert to_si("50 mJ/m^2", "J/m^2") == 0.05
    assert from_si(1.0, "Pa", "MPa") == 1e-6


def test_values_are_frozen_copies():
    d = np.array([1e-6, 2e-6])
    path = mdr.Path(indentation=d)
    d[0] = 5.0
    assert path.indentation[0] == 1e-6
    with pytest.raises(ValueError, match="read-only"):
        path.indentation[0] = 1.0
    with pytest.raises(AttributeError):
        BALL.body = STEEL


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (lambda: mdr.Elastic(math.nan, 0.3), mdr.UnitError, "not finite"),
        (lambda: mdr.Elastic(math.inf, 0.3), mdr.UnitError, "not finite"),
        (lambda: mdr.Elastic(0.0, 0.3), mdr.ProblemError, "above 0 Pa"),
        (lambda: mdr.Elastic(-1.0, 0.3), mdr.ProblemError, "above 0 Pa"),
        (lambda: mdr.Elastic(1.0, -1.0), mdr.ProblemError, "above -1"),
        (lambda: mdr.Elastic(1.0, 0.51), mdr.ProblemError, "at most 0.5"),
        (lambda: mdr.Elastic(1.0 + 1j, 0.3), mdr.UnitError, "not a quantity"),
        (lambda: mdr.Elastic(True, 0.3), mdr.UnitError, "not a quantity"),
        (lambda: mdr.Sphere("1,5 mm"), mdr.UnitError, "decimal point"),
        (lambda: mdr.Sphere("9**9 m"), mdr.UnitError, "cannot read"),
        (lambda: mdr.Sphere("9**9**9 m"), mdr.UnitError, "cannot read"),
        (lambda: mdr.Sphere("5 kg"), mdr.UnitError, "does not fit"),
        (lambda: mdr.Sphere("5 foo"), mdr.UnitError, "unknown unit"),
        (lambda: mdr.Sphere("5"), mdr.UnitError, "no unit"),
        (lambda: mdr.Sphere("5 " + "m*" * 100 + "m"), mdr.UnitError, "cannot read"),
        (lambda: mdr.Sphere([1.0, 2.0]), mdr.UnitError, "not a quantity"),
        (lambda: mdr.Cone(), mdr.ProblemError, "exactly one"),
        (lambda: mdr.Cone(slope=1.0, half_angle=1.0), mdr.ProblemError, "exactly one"),
        (lambda: mdr.Cone(half_angle="90 deg"), mdr.ProblemError, "below"),
        (lambda: mdr.PowerLaw(0, 1.0, 1.0), mdr.ProblemError, "above 0"),
        (lambda: mdr.Function(), mdr.ProblemError, "neither f nor derivative is given; give one or both"),
        (lambda: mdr.Function(3.0), mdr.ProblemError, "callable"),
        (lambda: mdr.Function(np.square, [-1.0]), mdr.ProblemError, "above 0"),
        (lambda: mdr.Contact(mdr.Sphere(1.0), mdr.Rigid()), mdr.ProblemError, "both bodies are rigid"),
        (lambda: mdr.Contact(1.0, STEEL), mdr.ProblemError, "profile"),
        (lambda: mdr.Contact(mdr.Sphere(1.0), "steel"), mdr.ProblemError, "material"),
        (lambda: mdr.solve(mdr.Sphere(1.0), mdr.load(1.0)), mdr.ProblemError, "not a Contact"),
    ],
)
def test_bad_values(make, error, words):
    with pytest.raises(error, match=words) as caught:
        make()
    assert isinstance(caught.value, mdr.PymdrError | ValueError)
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


# --- callables -------------------------------------------------------------------------------------------


def test_an_offset_is_removed_and_said_so():
    plain, lifted = (
        mdr.solve(mdr.Contact(mdr.Function(f), UNIT), mdr.indent(0.1))
        for f in (lambda r: r * r / 2, lambda r: 0.25 + r * r / 2)
    )
    assert lifted["normal_force"].values[0] == pytest.approx(plain["normal_force"].values[0], rel=1e-11)
    assert plain.notes == ()
    assert "f(0) = 250 mm of the profile was removed" in lifted.notes[0]
    assert "removed" in lifted.summary()


@pytest.mark.parametrize(
    ("profile", "error", "words"),
    [
        (mdr.Function(lambda r: -r), mdr.ProblemError, "does not rise"),
        (mdr.Function(lambda r: 0.0 * r), mdr.ProblemError, "does not rise"),
        (mdr.Function(lambda r: r * r * np.exp(-r)), mdr.PymdrError, "again|does not rise"),
        (mdr.Function(lambda r: max(r, 0.0)), mdr.ProblemError, "does not accept arrays"),
        (mdr.Function(lambda r: np.where(r > 0.1, r, 0.0), [0.1]), mdr.ProblemError, "jumps"),
        (mdr.Function(lambda r: r * math.nan), mdr.PymdrError, "must be finite"),
    ],
)
def test_callables_that_are_no_profile(profile, error, words):
    with pytest.raises(error, match=words):
        mdr.solve(mdr.Contact(profile, UNIT), mdr.indent(0.7, steps=2))["contact_radius"]


def test_an_unnamed_kink_is_located():
    hidden = mdr.Function(derivative=lambda r: np.where(r > 0.3, 1.0, 0.1))
    named = mdr.Function(derivative=hidden.derivative, breakpoints=[0.3])
    x = np.array([0.29, 0.3, 0.301, 0.5])
    exact = x * (np.pi / 2 * 0.1 + 0.9 * np.arccos(np.minimum(0.3 / x, 1.0)))
    for profile in (hidden, named):
        line = equivalent_profile(profile)
        assert line.g(x) == pytest.approx(exact, rel=1e-13)
        assert line.breakpoints == pytest.approx([0.3], rel=1e-15)
    with pytest.raises(mdr.PymdrError, match="breakpoint"):
        equivalent_profile(mdr.Function(derivative=lambda r: 1.0 + np.sign(np.sin(1e4 * r)))).g(0.5)


def test_a_function_that_ends_is_used_up_to_its_end():
    def f(r):
        return r * r / (1 + np.sqrt(1 - r * r))

    sphere = mdr.solve(mdr.Contact(mdr.Sphere(1.0), UNIT), mdr.indent(0.5, steps=5))
    function = mdr.solve(mdr.Contact(mdr.Function(f), UNIT), mdr.indent(0.5, steps=5))
    assert function["normal_force"].values == pytest.approx(sphere["normal_force"].values, rel=1e-11)


# --- claims ----------------------------------------------------------------------------------------------


def hollow(R=1.0):
    return mdr.FlatPunch(1.0) + mdr.Function(lambda r: -r * r / (2 * R), derivative=lambda r: -r / R)


def test_concave_punch_is_exact_from_full_contact_on(references):
    expected = references["concave_punch_full"]["expected"]
    d = expected["d"] * np.array([0.25, 0.5, 0.999, 1.0, 1.5])
    result = mdr.solve(mdr.Contact(hollow(), UNIT), mdr.Path(indentation=d))
    assert result.status is mdr.Status.PARTLY_REFUSED
    assert result.claims["normal_force"].where.tolist() == [False, False, False, True, True]
    force = result["normal_force"].values
    assert np.isnan(force[:3]).all()
    assert force[3] == pytest.approx(expected["F_over_Estar"], rel=1e-12)
    assert result["indentation"].values.tolist() == d.tolist()
    assert result["force_lower_bound"].values == pytest.approx(2 * (d + 1 / 3), rel=1e-12)
    assert "2.667 N and more" in result.claims["normal_force"].reason
    with pytest.raises(mdr.NotValidError, match="step 0"):
        result.field("pressure", r=[0.5], step=0)
    assert result.field("pressure", r=[0.0], step=3).values[0] == pytest.approx(0.0, abs=1e-12)


def test_a_refused_contact_keeps_its_bound():
    result = mdr.solve(mdr.Contact(hollow(), UNIT), mdr.indent(0.5))
    assert result.status is mdr.Status.REFUSED
    for name in ("normal_force", "contact_radius", "elastic_energy"):
        with pytest.raises(mdr.NotValidError, match="not a disk"):
            result[name]
        assert name not in result.data
    with pytest.raises(mdr.NotValidError):
        result.field("pressure")
    assert float(result["force_lower_bound"][0]) == pytest.approx(2 * (0.5 + 1 / 3), rel=1e-12)
    assert "Rings" in result.claims["normal_force"].reason


def test_the_certificate_is_not_the_rise_of_f():
    # f rises below A = 4.6, g only below 3.186: between them f' >= 0 everywhere, and yet not always a disk
    assert mdr.solve(mdr.Contact(wavy(2.5), UNIT), mdr.indent(0.05, steps=40)).status is mdr.Status.COMPLETED
    r = np.linspace(0.0, 0.5, 2001)
    assert np.all(wavy(4.5).gap_slope(r) >= 0)
    result = mdr.solve(mdr.Contact(wavy(4.5), UNIT), mdr.indent(0.05, steps=40))
    assert result.status is mdr.Status.PARTLY_REFUSED
    where = result.claims["contact_radius"].where
    g = equivalent_profile(wavy(4.5))
    for a, d in zip(result["contact_radius"].values[where], result["indentation"].values[where], strict=True):
        assert float(g.g(a)) == pytest.approx(d, rel=1e-11)


@pytest.mark.parametrize("A", [2.5, 6.0, 15.0])
def test_the_bound_is_the_best_disk(A):
    k, d = 40.0, np.linspace(0.002, 0.04, 12)
    result = mdr.solve(mdr.Contact(wavy(A, k), UNIT), mdr.Path(indentation=d))

    def load(x, d):
        """d x - int g dx, for (z H_1)' = z H_0."""
        return d * x - x**3 / 3 - np.pi / 2 * A / k**2 * x * struve(1, k * x)

    bound, coarse = [], np.linspace(0, 0.4, 2001)
    for di in d:
        best = coarse[np.argmax(load(coarse, di))]
        bound.append(2 * np.max(load(best + 2e-4 * np.linspace(-1, 1, 2001), di)))
    assert result["force_lower_bound"].values == pytest.approx(bound, rel=1e-9)


def test_assess_states_claims_without_solving():
    result = mdr.assess(BALL, mdr.load("50 N", steps=1000))
    assert result.claims["pressure"].level is mdr.Level.EXACT
    assert result.largest["normal_force"] == pytest.approx(50, rel=1e-12)
    assert "EXACT" in str(result)
    refused = mdr.assess(mdr.Contact(hollow(), UNIT), mdr.indent(0.5))
    assert refused.claims["pressure"].level is mdr.Level.NOT_VALID


def test_assumptions_are_measured():
    shallow = {a.name: a for a in mdr.solve(BALL, mdr.load("50 N")).assumptions}
    assert shallow["small slope"].met
    assert shallow["half-space"].measure == pytest.approx(0.018872, rel=1e-4)
    assert shallow["elastic similarity"].measure == pytest.approx(
        abs(mdr.effective_moduli(BALL.body, BALL.counterbody).dundurs_beta)
    )
    deep = {a.name: a for a in mdr.solve(BALL, mdr.indent("4 mm")).assumptions}
    assert not deep["small slope"].met
    assert not deep["half-space"].met


# --- results ---------------------------------------------------------------------------------------------


def test_results_carry_units():
    result = mdr.solve(BALL, mdr.load("50 N", steps=2))
    assert result["contact_radius"].attrs["units"] == "m"
    assert result.to("contact_radius", "um").values == pytest.approx(result["contact_radius"].values * 1e6)
    assert result.to("contact_radius", "um").attrs["units"] == "um"
    assert result.field("pressure", r=["0 um", "100 um"]).attrs["units"] == "Pa"
    with pytest.raises(mdr.UnitError, match="does not fit"):
        result.to("contact_radius", "kg")
    with pytest.raises(mdr.QuantityError, match="read it with"):
        result["pressure"]
    with pytest.raises(mdr.QuantityError, match="no quantity"):
        result["weight"]
    with pytest.raises(mdr.QuantityError, match="no field"):
        result.field("weight")
    with pytest.raises(mdr.QuantityError, match="step 7 does not exist"):
        result.field("pressure", step=7)


def test_fields_of_all_steps():
    result = mdr.solve(BALL, mdr.load("50 N", steps=3))
    p = result.field("pressure", r=[0.0, 1e-4], step=None)
    assert p.dims == ("step", "r")
    assert p.values[1].tolist() == result.field("pressure", r=[0.0, 1e-4], step=1).values.tolist()
    default = result.field("pressure")
    assert default.r.values[0] == 0.0
    assert default.r.values[-1] == pytest.approx(2 * result["contact_radius"].values[-1])


@pytest.mark.parametrize(
    "contact",
    [
        BALL,
        mdr.Contact(mdr.FlatPunch("1 mm") + mdr.Cone(half_angle="85 deg"), STEEL),
        mdr.Contact(mdr.PowerLaw(1.5, "1 um", "1 mm"), STEEL, mdr.Rigid()),
    ],
)
def test_saving_and_pickling_keep_everything(contact, tmp_path):
    result = mdr.solve(contact, mdr.indent("1 um", steps=3) >> mdr.hold(steps=2))
    result.save(tmp_path / "r.nc")
    for other in (mdr.open_result(tmp_path / "r.nc"), pickle.loads(pickle.dumps(result))):
        assert other.contact == result.contact
        assert other.path == result.path
        assert other.data.identical(result.data)
        assert other.status is result.status
        assert other.assumptions == result.assumptions
        assert other.cite() == result.cite()
        for name, claim in result.claims.items():
            assert (other.claims[name].level, other.claims[name].reason) == (claim.level, claim.reason)
            assert other.claims[name].where.tolist() == claim.where.tolist()
        r = np.linspace(0, 2e-4, 7)
        assert other.field("pressure", r=r).values == pytest.approx(
            result.field("pressure", r=r).values, rel=1e-12
        )


def test_a_callable_is_saved_as_its_interpolant(tmp_path):
    contact = mdr.Contact(wavy(2.5), UNIT)
    result = mdr.solve(contact, mdr.indent(0.02, steps=3))
    result.save(tmp_path / "w.nc")
    other = mdr.open_result(tmp_path / "w.nc")
    assert isinstance(other.contact.profile, Interpolated)
    again = mdr.solve(other.contact, other.path)
    assert again["normal_force"].values == pytest.approx(result["normal_force"].values, rel=1e-11)
    r = np.linspace(0.01, 0.1, 9)
    for name in ("pressure", "normal_displacement", "gap"):
        assert other.field(name, r=r).values == pytest.approx(
            result.field(name, r=r).values, rel=1e-9, abs=1e-14
        )


def test_tables_and_citations():
    result = mdr.solve(BALL, mdr.load("50 N", steps=3))
    assert list(result.to_dataframe().index) == [0, 1, 2]
    assert result.to_xarray().identical(result.data)
    assert any("Sneddon" in reference for reference in result.cite())
    assert "50 N" in result.summary()
    assert "COMPLETED" in repr(result)


def test_files_that_cannot_be_read_or_written(tmp_path):
    result = mdr.solve(BALL, mdr.load("50 N"))
    (tmp_path / "file").write_text("x")
    with pytest.raises(mdr.FileError, match="cannot write"):
        result.save(tmp_path / "file" / "r.nc")
    with pytest.raises(mdr.FileError, match="no such file"):
        mdr.open_result(tmp_path / "none.nc")
    with pytest.raises(mdr.FileError, match=r"it has no result\.nc, which pymdr run writes$"):
        mdr.open_result(tmp_path)
    (tmp_path / "impact.csv").write_text("step")
    with pytest.raises(mdr.FileError, match=r"impact\.csv of a study; read it with pandas\.read_csv\('"):
        mdr.open_result(tmp_path)
    with pytest.raises(OSError, match="not a complete NetCDF file"):
        mdr.open_result(tmp_path / "file")


@pytest.mark.parametrize("workers", [1, 2])
def test_batches(workers):
    contacts = [mdr.Contact(mdr.Sphere(R), STEEL) for R in (1e-3, 2e-6, 4e-3)]
    seen = []
    answers = mdr.solve_batch(
        contacts,
        mdr.indent("3 um"),
        workers=workers,
        throw=False,
        progress=lambda done, n: seen.append((done, n)),
    )
    assert isinstance(answers[1], mdr.PathError)
    assert answers[2]["normal_force"].values[0] > answers[0]["normal_force"].values[0]
    assert seen[-1] == (3, 3)
    with pytest.raises(mdr.PathError):
        mdr.solve_batch(contacts, mdr.indent("3 um"))


def test_progress_counts_steps():
    seen = []
    mdr.solve(BALL, mdr.load(1.0, steps=3) >> mdr.load(2.0, steps=2), progress=lambda *now: seen.append(now))
    assert seen == [(3, 5), (5, 5)]


# --- figures ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("profile", "depth", "steps"),
    [
        (mdr.Sphere(1.0), 0.01, 1),
        (mdr.Sphere(1.0), 0.01, 6),
        (mdr.Cone(slope=0.2), 1e-9, 6),
        (mdr.FlatPunch(1.0), 0.01, 1),
        (mdr.FlatPunch(1.0) + mdr.Paraboloid(5.0), 0.5, 6),
        (hollow(), 2.0, 6),
        (hollow(), 0.5, 1),
    ],
)
def test_figures_have_units_and_finite_axes(profile, depth, steps, monkeypatch):
    monkeypatch.delitem(sys.modules, "matplotlib.pyplot", raising=False)
    result = mdr.solve(mdr.Contact(profile, UNIT), mdr.indent(depth, steps=steps))
    figures = {**result.figures(), "overview": result.plot()}
    assert set(figures) == {"section", "curves", "fields", "overview"}
    for figure in figures.values():
        assert not faults(figure)
        for axes in figure.axes:
            if axes.axison:
                assert axes.get_ylabel().endswith(")")
                assert np.isfinite([*axes.get_xlim(), *axes.get_ylim()]).all()
            else:
                assert "lower bound" in axes.texts[0].get_text()
    assert "matplotlib.pyplot" not in sys.modules
