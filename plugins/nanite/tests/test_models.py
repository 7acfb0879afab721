"""The models in nanite itself: what made a record is found in it again."""

import time

import lmfit
import nanite
import numpy as np
import pymdr_nanite
import pytest
from nanite.model import models_available
from nanite.model.core import NaniteFitModel

import pymdr as mdr

RADIUS, YOUNG, WORK = 5e-6, 3e3, 2e-4
POSITIONS = np.concatenate([np.linspace(-2e-6, 1.5e-6, 500), np.linspace(1.5e-6, -3e-6, 700)])


@pytest.fixture(autouse=True)
def registered():
    pymdr_nanite.register()


def record(contact, noise=0.0, seed=0, positions=POSITIONS):
    """A record as nanite holds it, of pymdr's own solution."""
    force = mdr.solve(contact, mdr.Path(indentation=positions))["normal_force"].values
    force = force + noise * np.ptp(force) * np.random.default_rng(seed).normal(size=force.size)
    back = np.arange(positions.size) >= int(np.argmax(positions)) + 1
    return nanite.indent.Indentation(
        data={
            "force": force,
            "tip position": -positions,
            "height (measured)": -positions,
            "time": 1e-3 * np.arange(positions.size),
            "segment": back.astype(np.uint8),
        },
        metadata={
            "spring constant": 0.05,
            "sensitivity": 5e-8,
            "imaging mode": "force-distance",
            "path": "synthetic",
            "enum": 0,
        },
    )


def fitted(key, record, segment, **given):
    """The parameters that nanite finds."""
    params = models_available[key].get_parameter_defaults()
    for name, value in given.items():
        params[name].value = value
    record.fit_model(
        model_key=key,
        params_initial=params,
        segment=segment,
        weight_cp=0,
        preprocessing=[],
        x_axis="tip position",
    )
    return record.fit_properties["params_fitted"]


def gel(profile, adhesion=None):
    return mdr.Contact(profile, mdr.Elastic(YOUNG, 0.5), adhesion=adhesion)


def test_nanite_accepts_all_models():
    for key, model in pymdr_nanite.MODELS.items():
        assert isinstance(models_available[key], NaniteFitModel)
        assert models_available[key].parameter_keys == model.parameter_keys


@pytest.mark.parametrize(
    ("key", "law", "given"),
    [
        ("pymdr_jkr", mdr.JKR(WORK), {}),
        ("pymdr_maugis", mdr.MaugisDugdale(WORK, range="100 nm"), {"range": 1e-7}),
    ],
)
def test_a_noiseless_retreat_gives_modulus_and_work(key, law, given):
    fit_result = fitted(key, record(gel(mdr.Paraboloid(RADIUS), law)), "retract", R=RADIUS, **given)
    assert fit_result["E"].value == pytest.approx(YOUNG, rel=1e-4)
    assert fit_result["work"].value == pytest.approx(WORK, rel=1e-4)


def test_a_noisy_retreat_gives_them_within_their_intervals():
    inside = []
    for seed in range(20):
        contact = gel(mdr.Paraboloid(RADIUS), mdr.JKR(WORK))
        fit_result = fitted("pymdr_jkr", record(contact, noise=0.01, seed=seed), "retract", R=RADIUS)
        for name, true in (("E", YOUNG), ("work", WORK)):
            inside.append(abs(fit_result[name].value - true) < 1.96 * fit_result[name].stderr)
    assert (
        np.mean(inside) >= 0.85
    )  # 38 of 40 expected; at most 3 in 10,000 runs have fewer than 34 of independent ones


@pytest.mark.parametrize(
    ("key", "profile", "given"),
    [
        ("pymdr_sphere", mdr.Sphere(RADIUS), {"R": RADIUS}),
        ("pymdr_cone", mdr.Cone(half_angle="70 deg"), {"alpha": 70.0}),
        ("pymdr_pyr3s", mdr.Pyramid(3, half_angle="65 deg"), {"alpha": 65.0}),
        ("pymdr_pyr4s", mdr.Pyramid(4, half_angle="35 deg"), {"alpha": 35.0}),
    ],
)
def test_an_approach_gives_the_modulus_of_any_tip(key, profile, given):
    fit_result = fitted(
        key, record(gel(profile), positions=np.linspace(-2e-6, 1e-6, 600)), "approach", **given
    )
    assert fit_result["E"].value == pytest.approx(YOUNG, rel=1e-4)


def test_layers_and_memory():
    body = mdr.Layered([mdr.Layer(mdr.Elastic(YOUNG, 0.4), "4 um")], mdr.Rigid())
    positions = np.linspace(-2e-6, 1e-6, 600)
    fit_result = fitted(
        "pymdr_layer", record(mdr.Contact(mdr.Paraboloid(RADIUS), body), positions=positions), "approach",
        R=RADIUS, thickness=4e-6, nu=0.4,
    )  # fmt: skip
    assert fit_result["E"].value == pytest.approx(YOUNG, rel=1e-4)
    solid = mdr.Viscoelastic(mdr.StandardSolid(YOUNG / 3, 2 * YOUNG / 3, "0.2 s"), poisson=0.5)
    force = mdr.solve(
        mdr.Contact(mdr.Paraboloid(RADIUS), solid),
        mdr.Path(time=1e-3 * np.arange(600), indentation=positions),
    )["normal_force"].values
    model = pymdr_nanite.MODELS["pymdr_memory"]
    values = model.get_parameter_defaults().valuesdict() | {"E": YOUNG, "R": RADIUS, "ratio": 2.0, "tau": 0.2}
    assert model.model_func(-positions, **values) == pytest.approx(force, abs=1e-4 * force.max())


def test_a_pyramid_is_that_of_nanite_but_for_its_constant():
    ours, theirs = pymdr_nanite.MODELS["pymdr_pyr3s"], models_available["hertz_pyr3s"]
    delta = -np.linspace(0.1e-6, 1e-6, 50)
    params = {"E": YOUNG, "alpha": 65.0, "nu": 0.5, "contact_point": 0.0, "baseline": 0.0}
    ratio = ours.model_func(delta, **params) / theirs.module.model_func(delta, **params)
    assert ratio == pytest.approx(0.882409 / 0.8887, rel=1e-9)  # boundary elements, and Bilodeau (1992)


def test_a_tip_of_ones_own():
    tip = mdr.Hyperboloid("50 nm", half_angle="35 deg")
    pymdr_nanite.register_tip(tip, key="my_tip", adhesion="jkr")
    work = 1e-5
    fit_result = fitted(
        "my_tip", record(gel(tip, mdr.JKR(work)), positions=0.5 * POSITIONS), "retract", work=3e-5
    )
    assert fit_result["E"].value == pytest.approx(YOUNG, rel=1e-4)
    assert fit_result["work"].value == pytest.approx(work, rel=1e-4)
    with pytest.raises(ValueError, match="None or 'jkr'"):
        pymdr_nanite.register_tip(tip, key="other", adhesion="dmt")


@pytest.mark.parametrize("key", sorted(pymdr_nanite.MODELS))
def test_a_call_takes_less_than_5_ms(key):
    model = pymdr_nanite.MODELS[key]
    values = model.get_parameter_defaults().valuesdict()
    delta = np.linspace(1e-6, -1e-6, 1000)
    model.model_func(delta, **values)
    durations = []
    for i in range(40):
        values["E"] = 3e3 * 1.01**i
        start = time.process_time()
        model.model_func(delta, **values)
        durations.append(time.process_time() - start)
    assert np.median(durations) < 5e-3


def test_defaults_are_within_their_bounds():
    for model in pymdr_nanite.MODELS.values():
        params = model.get_parameter_defaults()
        assert isinstance(params, lmfit.Parameters)
        assert all(one.min <= one.value <= one.max for one in params.values())
