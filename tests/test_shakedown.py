"""Shakedown under repeated rolling and sliding, against closed forms and brute force."""

import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

import pymdr as mdr
from drawing import examples
from legibility import faults
from pymdr.interpretation.shakedown import _by_any_residual, _by_two_residuals, safe_bound
from pymdr.solving.yielding import states_of

STEEL = mdr.Elastic("210 GPa", 0.3)
BALL = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL)
JOINT = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(0.6))


@pytest.fixture(scope="module")
def sliding():
    return mdr.shakedown(JOINT, strength="1 GPa", force_ratio=[0.0, 0.2, 0.6])


def largest_shear_of_huber():
    """Largest stress rz of Hertz's contact over its peak pressure (Huber 1904)."""

    def shear(place):
        r, z = place
        s = r * r + z * z - 1.0
        u = 0.5 * (s + math.hypot(s, 2.0 * z))
        return -(r * z * z / (u * u + z * z)) * math.sqrt(u) / (1.0 + u)

    return -minimize(shear, (0.9, 0.35), method="Nelder-Mead", options={"xatol": 1e-10, "fatol": 1e-14}).fun


def test_free_rolling_of_a_hertz_contact(sliding):
    # Johnson (1985) and Ponter, Hearle and Johnson (1985): p_0 = 4.68 k, by the largest stress rz
    upper = float(sliding["pressure_ratio_high"][0])
    assert upper == pytest.approx(1.0 / largest_shear_of_huber(), rel=2e-6)
    assert round(upper, 2) == 4.68
    assert 0.99 * upper < float(sliding["pressure_ratio"][0]) < upper


def test_hard_sliding_is_limited_by_the_traction_at_the_surface(sliding):
    # the layer at the surface bears mu p_0 without help from residual stress
    for name in ("pressure_ratio", "pressure_ratio_high"):
        assert float(sliding[name][2]) == pytest.approx(1.0 / 0.6, rel=1e-5)
    assert float(sliding["shakedown_depth"][2]) == 0.0


def test_loads_lie_in_their_order(sliding):
    first, safe, high = (
        sliding[name].values for name in ("first_yield_force", "normal_force", "normal_force_high")
    )
    assert (first < safe).all()
    assert (safe <= high * (1.0 + 1e-5)).all()
    assert (np.diff(safe) < 0.0).all()
    assert np.allclose(sliding["yield_multiple"], safe / first, rtol=1e-14)
    claim = sliding.claims["normal_force"]
    assert claim.level is mdr.Level.APPROXIMATE
    assert np.allclose(claim.error, high / safe - 1.0, atol=1e-4)
    yields = mdr.first_yield(JOINT, strength="1 GPa", force_ratio=0.2)
    assert float(yields["normal_force"][0]) == pytest.approx(first[1], rel=1e-7)


def test_residual_stresses_keep_the_body_within_yield(sliding):
    """Melan's theorem by brute force: at the safe load, at random depths, residual stresses by golden sections on a net of points."""
    depth, k = float(sliding["indentation"][1]), 1e9 / math.sqrt(3.0)
    interior = states_of(JOINT, None, 0.2)(depth)
    a = interior.load(0).radius
    x, y = a * np.linspace(-3.0, 3.0, 241), a * np.linspace(0.0, 2.0, 21)
    worst = float(sliding["shakedown_depth"][1])
    for z in (worst, *(a * np.random.default_rng(3).uniform(0.0, 1.2, 3))):
        s = interior.spatial("stress", tuple(np.meshgrid(x, y, [z], indexing="ij")), 0)[..., 0]

        def measure(u, v, s=s):
            xx, yy, zz = s[0] + u, s[1] + v, s[2]
            squares = ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 6.0 + np.sum(s[3:] ** 2, axis=0)
            return np.sqrt(squares.max(axis=0))

        def golden(function, shape):
            low, high, fraction = (
                np.full(shape, -2.0 * k),
                np.full(shape, 2.0 * k),
                0.5 * (math.sqrt(5.0) - 1.0),
            )
            for _ in range(34):
                inner = high - fraction * (high - low), low + fraction * (high - low)
                left = function(inner[0]) < function(inner[1])
                low, high = np.where(left, low, inner[0]), np.where(left, inner[1], high)
            return function(0.5 * (low + high))

        least = float(golden(lambda v: golden(lambda u: measure(u, v), y.size).max(), ()))
        assert least <= k * (1.0 + 1e-5)
        if z == worst:
            assert least == pytest.approx(k, rel=1e-3)


@settings(max_examples=examples(6), deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(2, 5), st.integers(1, 3))
def test_best_residuals_of_random_stresses(seed, along, across):
    s = np.random.default_rng(seed).normal(size=(6, along, across, 1))

    def squares(free, fixed):
        xx, yy, zz = s[0, ..., 0] + free[None, :], s[1, ..., 0] + fixed, s[2, ..., 0]
        rest = np.sum(s[3:, ..., 0] ** 2, axis=0)
        loaded = ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 6.0 + rest
        empty = (free * free - free * fixed + fixed * fixed) / 3.0  # far away along the path
        return np.concatenate([loaded.ravel(), empty, [0.25 * fixed**2 * (across > 1)]])

    best = minimize(
        lambda v: v[0],
        np.append([50.0], np.zeros(across + 1)),
        constraints={"type": "ineq", "fun": lambda v: v[0] - squares(v[2:], v[1])},
        method="SLSQP",
        options={"maxiter": 500, "ftol": 1e-12},
    )
    result, _ = _by_two_residuals(s)
    assert float(result[0]) == pytest.approx(best.fun, rel=1e-5)
    # no residual stress of any kind does worse than these
    assert float(_by_any_residual(s)[0][0]) <= float(result[0]) * (1.0 + 1e-9)


@settings(max_examples=examples(3), deadline=None)
@given(st.floats(-8.0, 1.0), st.floats(2.0, 12.0), st.floats(0.05, 0.45))
def test_the_ratio_does_not_depend_on_size_and_stiffness(size, stiffness, poisson):
    contact = mdr.Contact(mdr.Paraboloid(10.0**size), mdr.Elastic(10.0**stiffness, poisson))
    interior = states_of(contact, None, 0.0)(1e-3 * 10.0**size)
    same = states_of(mdr.Contact(mdr.Paraboloid(1.0), mdr.Elastic(1.0, poisson)), None, 0.0)(1e-2)
    ratios = [
        safe_bound(one, 0).shear / one.surface.field("pressure", np.zeros(1), 0)[0]
        for one in (interior, same)
    ]
    assert ratios[0] == pytest.approx(ratios[1], rel=1e-6)


def test_a_profile_that_is_not_similar_to_itself():
    profile = mdr.PowerLaw(4, "1 um", "1 mm")
    limit = mdr.shakedown(mdr.Contact(profile, STEEL), strength="800 MPa")
    interior = states_of(limit.contact, None, 0.0)(float(limit["indentation"][0]))
    assert safe_bound(interior, 0).shear == pytest.approx(8e8 / math.sqrt(3.0), rel=1e-5)
    assert float(limit["first_yield_force"][0]) < float(limit["normal_force"][0])


def test_figures_files_and_numbers(sliding, tmp_path):
    assert not faults(sliding.plot())
    sliding.save(tmp_path / "limit.nc")
    sliding.to_csv(tmp_path / "limit.csv")
    assert "p_0/k" in sliding.summary()
    assert "Melan" in sliding.summary()
    assert float(sliding.to("normal_force", "kN")[0]) == float(sliding["normal_force"][0]) / 1e3
    one = mdr.shakedown(BALL, strength="1 GPa")
    assert not faults(one.plot())


@pytest.mark.parametrize(
    ("given_contact", "arguments", "kind", "words"),
    [
        (BALL, {"strength": 0.0}, mdr.ProblemError, "above 0 Pa"),
        (BALL, {"strength": "1 mm"}, mdr.PymdrError, "Pa"),
        (BALL, {"strength": math.nan}, mdr.PymdrError, "strength"),
        (BALL, {"force_ratio": 0.1}, mdr.ProblemError, "no friction"),
        (JOINT, {"force_ratio": [0.2, 0.1]}, mdr.ProblemError, "increasing order"),
        (JOINT, {"force_ratio": []}, mdr.ProblemError, "at least one ratio"),
        (JOINT, {"force_ratio": 0.7}, mdr.ProblemError, "0 to the coefficient of friction"),
        (JOINT, {"side": "base"}, mdr.PymdrError, "counterbody"),
        (mdr.Contact(mdr.Cone(slope=0.1), STEEL), {}, mdr.NotValidError, "shakedown is not valid here"),
        (mdr.Contact(mdr.FlatPunch("1 mm"), STEEL), {}, mdr.NotValidError, "shakedown is not valid here"),
        (
            mdr.Contact(mdr.Paraboloid("1 mm"), STEEL, adhesion=mdr.JKR("50 mJ/m^2")),
            {},
            mdr.ProblemError,
            "adhesion",
        ),
        (
            mdr.Contact(mdr.Paraboloid("1 mm"), mdr.Layered([mdr.Layer(STEEL, "1 mm")], base=STEEL)),
            {},
            mdr.NotValidError,
            "homogeneous",
        ),
    ],
)
def test_refusals(given_contact, arguments, kind, words):
    with pytest.raises(kind, match=words):
        mdr.shakedown(given_contact, **{"strength": "1 GPa"} | arguments)


CASE = """\
[profile]
kind = "paraboloid"
radius = "10 mm"

[body]
kind = "elastic"
young = "210 GPa"
poisson = 0.3

[counterbody]
kind = "elastic"
young = "210 GPa"
poisson = 0.3

[friction]
kind = "coulomb"
coefficient = 0.6

{tables}

[[path]]
kind = "load"
normal_force = "50 N"

[[path]]
kind = "cycle"
tangential_force = "10 N"
steps = 8
"""
TABLES = """\
[first_yield]
strength = "1 GPa"
force_ratio = 0.2

[shakedown]
strength = "1 GPa"
force_ratio = 0.6

[fatigue]
criterion = "smith-watson-topper"
limit = "5 MPa"
bulk_amplitude = "80 MPa"
"""


def test_the_tables_of_a_case(tmp_path, shell, sliding):
    case = tmp_path / "case.toml"
    case.write_text(CASE.format(tables=TABLES))
    code, out, _ = shell("run", case, "--json")
    assert code == 0
    studies = json.loads(out)["studies"]
    assert studies["shakedown"]["normal_force"]["values"][0] == pytest.approx(
        float(sliding["normal_force"][2]), rel=1e-5
    )
    assert studies["first_yield"]["normal_force"]["values"][0] == pytest.approx(
        float(sliding["first_yield_force"][1]), rel=1e-7
    )
    result = mdr.open_result(tmp_path / "case" / "result.nc")
    bulk = 8e7 * result["tangential_force"] / float(np.abs(result["tangential_force"]).max())
    alone = mdr.fatigue(result, criterion=mdr.SmithWatsonTopper(), superposed={"xx": bulk})
    assert studies["fatigue"]["smith_watson_topper"]["values"] == [pytest.approx(alone.value, rel=1e-9)]
    for name in ("first_yield", "shakedown", "fatigue"):
        assert {f"{name}.csv", f"{name}.png"} <= {file.name for file in (tmp_path / "case").iterdir()}


def test_the_command(tmp_path, shell, sliding):
    case = tmp_path / "case.toml"
    case.write_text(CASE.format(tables=""))
    code, out, _ = shell("shakedown", case, "--strength", "1 GPa", "--force-ratio", "0.6", "--json")
    assert code == 0
    assert json.loads(out)["study"]["normal_force"]["values"][0] == pytest.approx(
        float(sliding["normal_force"][2]), rel=1e-5
    )
    for arguments, words in (
        (["--strength", "1 mm"], "compatible with 'Pa'"),
        (["--strength", "1 GPa", "--force-ratio", "0.7"], "coefficient of friction"),
        (["--strength", "1 GPa", "--force-ratio", "0.2, 0.1"], "increasing"),
        (["--strength", "1 GPa", "--side", "base"], "counterbody"),
        (["--strength", "-1 GPa"], "above 0 Pa"),
    ):
        code, _, err = shell("shakedown", case, *arguments)
        assert code in (1, 2)
        assert words in err
    assert shell("yield", case, "--strength", "1 GPa", "--json")[0] == 0


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("[shakedown]\nforce_ratio = 0.1", "strength"),
        ('[shakedown]\nstrength = "1 mm"', "compatible with 'Pa'"),
        ('[shakedown]\nstrength = "1 GPa"\nforce_ratios = 0.1', "did you mean 'force_ratio'"),
        ('[first_yield]\nstrength = ["1 GPa", "nan Pa"]', "[first_yield]: strength"),
        ('[fatigue]\ncriterion = "miner"', "'dang-van'"),
        ('[fatigue]\ncriterion = "findley"', "slope"),
        ('[fatigue]\ncriterion = "findley"\nslope = "1 mm"', "normal_slope"),
        ('[fatigue]\ncriterion = "ruiz-work"\nbulk = "80 mm"', "compatible with 'Pa'"),
    ],
)
def test_tables_that_are_wrong(tmp_path, shell, table, words):
    case = tmp_path / "case.toml"
    case.write_text(CASE.format(tables=table))
    code, _, err = shell("run", case, "-q", "--no-figures")
    assert code == 1
    assert words in err
    assert not (tmp_path / "case").exists()
