"""Maps and single fits of the same records end at the same numbers; the records are those of own equations."""

import numpy as np
import pytest

import pymdr as mdr

RADIUS, YOUNG, WORK = 5e-6, 20e3, 1e-4
MODULUS = YOUNG / 0.75
CLOSE = 1e-3
"""Largest difference in standard errors."""
TIP, GEL = mdr.Paraboloid(RADIUS), mdr.Elastic("10 kPa", 0.5)
CONTACTS = {
    "Hertz": mdr.Contact(TIP, GEL),
    "JKR": mdr.Contact(TIP, GEL, adhesion=mdr.JKR(2.0 * WORK)),
    "DMT": mdr.Contact(TIP, GEL, adhesion=mdr.DMT(2.0 * WORK)),
}


def branch(law):
    """Depths and forces of a contact that is stable at prescribed depths, from the loss of contact on."""
    if law == "JKR":
        a = np.linspace(1e-9, 6e-6, 60001)
        depth = a**2 / RADIUS - np.sqrt(2.0 * np.pi * a * WORK / MODULUS)
        force = 4.0 / 3.0 * MODULUS * a**3 / RADIUS - np.sqrt(8.0 * np.pi * a**3 * WORK * MODULUS)
        return depth, force
    depth = np.linspace(0.0, 1e-5, 60001)
    pull = 2.0 * np.pi * RADIUS * WORK if law == "DMT" else 0.0
    return depth, 4.0 / 3.0 * MODULUS * np.sqrt(RADIUS) * depth**1.5 - pull


def record(law, samples, seed, machine=None, tilt=0.0, lasting=0.0, level=0.01):
    """An approach and a retreat with noise of a level, white, or of which a part lasts from sample to sample."""
    depth, force = branch(law)
    place = depth if machine is None else depth + force / machine
    fold = np.argmin(place)
    place, force = place[fold:], force[fold:]
    half = samples // 2
    along = np.concatenate([np.linspace(-1.5e-6, 1.2e-6, half), np.linspace(1.2e-6, -1.5e-6, samples - half)])
    touches = along >= np.where(np.arange(samples) < half, 0.0, place[0])
    borne = np.where(touches, np.interp(along, place, force), 0.0)
    noise = level * np.random.default_rng(seed).normal(size=samples)
    for i in range(1, samples):
        noise[i] = lasting * noise[i - 1] + np.sqrt(1.0 - lasting**2) * noise[i]
    measured = borne + np.ptp(borne) * (noise + tilt * (along - along.mean()) / np.ptp(along))
    channel = {"indentation": along} if machine is None else {"travel": along, "spring_constant": machine}
    return mdr.MeasuredCurve(force=measured, **channel)


def compare(law, curve, free):
    """Assert that both ways agree."""
    one = mdr.fit(CONTACTS[law], curve, free)
    many = mdr.fit_map(CONTACTS[law], [curve], free)
    for name in (*free, "contact_point", "baseline"):
        off = abs(float(many[name][0]) - one[name].value)
        assert off <= CLOSE * one[name].error, name


@pytest.mark.parametrize("tilt", [0.0, 0.1])
@pytest.mark.parametrize(
    ("law", "machine"),
    [("Hertz", None), ("Hertz", 0.02), ("JKR", None), ("JKR", 0.02), ("DMT", None), ("DMT", 0.02)],
)
def test_a_map_of_one_curve_is_the_fit_of_it(law, machine, tilt):
    free = ["body.young"] + ["adhesion.work"] * (law != "Hertz") + ["tilt"] * (tilt > 0.0)
    for seed, level in ((0, 0.01), (1, 0.01), (2, 0.0005)):
        curve = record(law, 400, seed, machine, tilt, level=level)
        compare(law, curve, free)


@pytest.mark.parametrize(("lasting", "seed"), [(0.8, 0), (0.8, 1), (0.95, 1)])
def test_a_jump_in_correlated_noise_is_at_one_sample(lasting, seed):
    """The single fit ended samples beyond the jump of the second and third."""
    compare("DMT", record("DMT", 400, seed, lasting=lasting), ["body.young", "adhesion.work"])


@pytest.mark.parametrize(
    ("samples", "seed", "machine", "lasting"),
    [(400, 1, 0.02, 0.5), (400, 3, 0.02, 0.95), (1000, 1, None, 0.5)],
)
def test_searches_next_to_the_loss_of_contact_end(samples, seed, machine, lasting):
    """The force bends there, so that steps of least squares are too long and swing to either side of the end."""
    compare("JKR", record("JKR", samples, seed, machine, lasting=lasting), ["body.young", "adhesion.work"])


@pytest.mark.parametrize("law", ["JKR", "DMT"])
def test_the_compiled_search_of_many_curves_ends_where_that_of_few_does(law):
    free = ["body.young", "adhesion.work"]
    curves = [record(law, 300, seed, 0.02) for seed in range(64)]
    many, few = mdr.fit_map(CONTACTS[law], curves, free), mdr.fit_map(CONTACTS[law], curves[:2], free)
    for name in (*free, "contact_point", "baseline"):
        off = np.abs(many[name].values[:2] - few[name].values)
        assert np.all(off <= 1e-6 * few[f"{name}_error"].values), name
