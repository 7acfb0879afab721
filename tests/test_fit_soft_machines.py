"""Records on machines softer than the contact: what they determine is fitted, and what they do not is called so."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from scipy.optimize import least_squares

import pymdr as mdr
from drawing import examples
from pymdr.solving.fits.request import FITTED, UNDETERMINED

RADIUS, N = 5e-6, 160
LAWS = {"hertz": lambda work: None, "jkr": mdr.JKR, "dmt": mdr.DMT}


def contact_of(law, young, work):
    return mdr.Contact(mdr.Paraboloid(RADIUS), mdr.Elastic(young, 0.5), adhesion=LAWS[law](work))


def records_of(law, rng, count):
    """Records with pulls of 0.003 to 3 of the largest Hertz force, machines of 0.003 to 3 of its stiffness, and noise of 0.1 to 10 %."""
    young, depth = 10.0 ** rng.uniform(3.0, 6.0, count), RADIUS * 10.0 ** rng.uniform(-2.0, -0.7, count)
    hertz = 16.0 / 9.0 * young * math.sqrt(RADIUS) * depth**1.5
    work = hertz * 10.0 ** rng.uniform(-2.5, 0.5, count) / (1.5 * math.pi * RADIUS)
    machine = hertz / depth * 10.0 ** rng.uniform(-2.5, 0.5, count)
    travel, force = np.empty((count, N)), np.empty((count, N))
    for i in range(count):
        top, pull = depth[i] + hertz[i] / machine[i], 1.5 * math.pi * RADIUS * work[i] / machine[i]
        travel[i] = np.append(np.linspace(-0.5 * top, top, N // 2), np.linspace(top, -top - pull, N // 2))
        path = mdr.Path(travel=travel[i])
        solved = mdr.solve(contact_of(law, young[i], work[i]), path, machine_stiffness=machine[i])
        force[i] = solved["normal_force"].values
    noise = np.ptp(force, axis=1) * 10.0 ** rng.uniform(-3.0, -1.0, count)
    noisy = force + noise[:, None] * rng.normal(size=force.shape)
    data = xr.Dataset({"force": (("curve", "sample"), noisy), "travel": (("curve", "sample"), travel)})
    return data.assign(spring_constant=("curve", machine)), young, work, noise


def fitted_of(law, data):
    free = ["body.young"] + ["adhesion.work"] * (law != "hertz")
    return mdr.fit_map(contact_of(law, 3e4, 1e-4), data, free)


@pytest.mark.parametrize("law", LAWS)
def test_every_record_on_a_soft_machine_ends_in_the_right_word(law):
    data, young, _, noise = records_of(law, np.random.default_rng(7), 64)
    fitted = fitted_of(law, data)
    words = {"fitted", "the curve does not determine", "the curve does not show an unknown"}
    assert all(text.startswith(tuple(words)) for text in fitted.counts)
    good = fitted["ending"].values == FITTED
    assert good.sum() > 20
    assert law == "hertz" or (fitted["ending"].values == UNDETERMINED).sum() > 5
    assert fitted["noise"].values[good] == pytest.approx(noise[good], rel=5.0 * math.sqrt(0.5 / N))
    off = np.abs(fitted["body.young"].values - young)[good] / fitted["body.young_error"].values[good]
    assert np.mean(off < 2.5) > 0.9


def branch_of(law, young, work, machine, deepest):
    """Travel and force of the stable contact on a machine, by the closed forms over the contact radius; the loss of contact first."""
    modulus = young / 0.75
    widest = 2.0 * math.sqrt(RADIUS * deepest) + 3.0 * (math.pi * work * RADIUS**2 / modulus) ** (1.0 / 3.0)
    a = widest * np.linspace(1e-4, 1.0, 3000) ** 1.5
    depth, force = a * a / RADIUS, 4.0 / 3.0 * modulus * a**3 / RADIUS
    if law == "jkr":
        stretch = np.sqrt(2.0 * math.pi * work * a / modulus)
        depth, force = depth - stretch, force - 2.0 * a * modulus * stretch
    if law == "dmt":
        force = force - 2.0 * math.pi * work * RADIUS
    travel = depth + force / machine
    lowest = int(np.argmin(travel)) if law == "jkr" else 0
    return travel[lowest:], force[lowest:]


def compared(law, numbers, record):
    """Residuals in noises, and the samples in contact: near the jumps the record decides, one jump in and one out."""
    travel, measured, machine, noise = record
    young, work, left = math.exp(numbers[0]), math.exp(numbers[1]), measured - numbers[3] * noise
    path, force = branch_of(law, young, work, machine, 1.2 * float(np.ptp(travel)))
    # the place of the loss of contact moves less than the contact point along a valley
    x = travel - numbers[2] * RADIUS + path[0]
    model, deepest, certain = np.interp(x, path, force), int(np.argmax(x)), x > -path[0]
    gain = np.where(~certain & (x >= 4.0 * path[0]), left**2 - (left - model) ** 2, 0.0)
    first = deepest - int(np.argmax(np.append(0.0, np.cumsum(gain[:deepest][::-1]))))
    last = deepest + int(np.argmax(np.append(0.0, np.cumsum(gain[deepest + 1 :]))))
    within = (np.arange(x.size) >= first) & (np.arange(x.size) <= last) & (x >= 4.0 * path[0])
    touches = certain | within
    return np.where(touches, left - model, left) / noise, touches


def least_at(law, start, fixed, record, used=slice(None)):
    """The least sum of squares near a start with some of the numbers fixed, in variances of the noise."""
    free = np.delete(np.arange(4), fixed)

    def residuals(some):
        numbers = start.copy()
        numbers[free] = some
        return compared(law, numbers, record)[0][used]

    bounds = (start[free] - 9.0, start[free] + 9.0)
    end = least_squares(residuals, start[free], bounds=bounds, x_scale="jac", diff_step=1e-5, max_nfev=200)
    best = start.copy()
    best[free] = end.x
    return 2.0 * float(end.cost), best


def is_flat(law, young, work, record):
    """Whether modulus or work can change by a factor of e with little change of the least squares, all other numbers searched again."""
    path, _ = branch_of(law, young, work, record[2], 1.2 * float(np.ptp(record[0])))
    true = np.array([math.log(young), math.log(work), path[0] / RADIUS, 0.0])
    best = min((least_at(law, true, fixed, record) for fixed in (0, 1)), key=lambda one: one[0])
    grows = []
    for fixed in (0, 1):
        for side in (-1.0, 1.0):
            least, numbers = math.inf, best[1]
            for _ in range(4):
                start = numbers.copy()
                start[fixed] += 0.25 * side
                least, numbers = least_at(law, start, fixed, record)
            grows.append(least - best[0])
    return min(grows) < 4.0


@pytest.mark.parametrize("law", ["jkr", "dmt"])
def test_other_contacts_fit_the_records_that_determine_nothing(law):
    """The profile of the likelihood over a number, by closed forms and another search, is flat."""
    data, young, work, noise = records_of(law, np.random.default_rng(7), 64)
    ended = fitted_of(law, data)["ending"].values
    for i in np.flatnonzero(ended == UNDETERMINED)[: examples(6)]:
        one = data.isel(curve=i)
        record = (one["travel"].values, one["force"].values, float(one["spring_constant"]), noise[i])
        assert is_flat(law, young[i], work[i], record), i


def test_values_and_errors_are_those_of_the_profile_of_the_likelihood():
    """Against closed forms and another search, without the samples adjacent to jumps."""
    data, _, _, _ = records_of("jkr", np.random.default_rng(5), 64)
    fitted = fitted_of("jkr", data)
    size = {name: fitted[name].values for name in ("body.young", "adhesion.work")}
    error = {name: fitted[f"{name}_error"].values / values for name, values in size.items()}
    sure = (fitted["ending"].values == FITTED) & (error["body.young"] < 0.1) & (error["adhesion.work"] < 0.1)
    sure &= fitted["correlated"].values < 1.2
    for i in np.flatnonzero(sure)[: examples(12)]:
        one = data.isel(curve=i)
        noise, machine = float(fitted["noise"][i]), float(one["spring_constant"])
        record = (one["travel"].values, one["force"].values, machine, noise)
        young, work = (float(values[i]) for values in size.values())
        path, _ = branch_of("jkr", young, work, machine, 1.2 * float(np.ptp(record[0])))
        origin = (float(fitted["contact_point"][i]) + path[0]) / RADIUS
        numbers = np.array([math.log(young), math.log(work), origin, float(fitted["baseline"][i]) / noise])
        left, touches = compared("jkr", numbers, record)
        off = np.ones(touches.size, dtype=bool)
        for jump in np.flatnonzero(touches[1:] != touches[:-1]):
            off[jump : jump + 2] = False
        least, best = least_at("jkr", numbers, [], record, off)
        assert float((left[off] ** 2).sum()) - least < 1e-2
        for fixed, own in enumerate(error.values()):
            roots = []
            for side in (-1.0, 1.0):
                start = best.copy()
                start[fixed] += 0.5 * side * own[i]
                grows = least_at("jkr", start, [fixed], record, off)[0] - least
                roots.append(math.sqrt(max(grows, 0.0)))
            # the errors contain the uncertainty of the spectrum of the noise
            assert np.mean(roots) == pytest.approx(0.5, rel=0.2)


def cohesive_branch(young, work, stress, machine, deepest):
    """Travel, force and depth on a machine by Maugis' equations of the ball, from the first attraction on; bodies apart have a zone without contact."""
    modulus, attraction = young / 0.75, work / stress
    pulled = 2.0 * stress / modulus * (1.0 - 2.0 / math.pi)
    zone = (math.sqrt(pulled**2 + 2.0 * attraction / RADIUS) - pulled) * RADIUS * np.linspace(0.0, 1.0, 400)
    free_depth = zone**2 / (2.0 * RADIUS) - 4.0 * stress * zone / (math.pi * modulus) - attraction
    widest = 2.0 * math.sqrt(RADIUS * deepest) + 3.0 * (math.pi * work * RADIUS**2 / modulus) ** (1.0 / 3.0)
    a = widest * np.append(np.geomspace(1e-6, 1e-2, 400), np.linspace(1e-2, 1.0, 3000)[1:])
    low, high = np.full(a.size, 1e-12), np.full(a.size, 0.5 * math.pi - 1e-12)
    for _ in range(80):
        angle = 0.5 * (low + high)  # whose cosine is the ratio of the radii
        root, ratio = np.tan(angle), 1.0 / np.cos(angle)
        gap = a**2 / (math.pi * RADIUS) * (root + (ratio**2 - 2.0) * angle)
        gap += 4.0 * stress * a / (math.pi * modulus) * (root * angle + 1.0 - ratio)
        low, high = np.where(gap > attraction, low, angle), np.where(gap > attraction, angle, high)
    touching = 4.0 / 3.0 * modulus * a**3 / RADIUS - 2.0 * stress * a**2 * (ratio**2 * angle + root)
    depth = np.append(free_depth, a**2 / RADIUS - 2.0 * stress / modulus * a * root)
    force = np.append(-math.pi * stress * zone**2, touching)
    return depth + force / machine, force, depth


def cohesive_record(seed, name="range"):
    """A noisy record with Maugis' parameter of 0.1 to 10 on a machine of 0.1 to 30 of the stiffness of the contact, its true numbers, and a start."""
    rng = np.random.default_rng(seed)
    parameter, young = 10.0 ** rng.uniform(-1.0, 1.0), 10.0 ** rng.uniform(3.0, 5.5)
    deep = RADIUS * 10.0 ** rng.uniform(-1.7, -0.8)
    modulus = young / 0.75
    hertz = 4.0 / 3.0 * modulus * math.sqrt(RADIUS) * deep**1.5
    work = hertz * 10.0 ** rng.uniform(-1.0, 0.5) / (1.5 * math.pi * RADIUS)
    stress = parameter / (9.0 * RADIUS / (2.0 * math.pi * work * modulus**2)) ** (1.0 / 3.0)
    machine, noise = hertz / deep * 10.0 ** rng.uniform(-1.0, 1.5), 10.0 ** rng.uniform(-2.7, -1.7)
    x, force, depth = cohesive_branch(young, work, stress, machine, 6.0 * deep)
    falls = np.flatnonzero(np.diff(x) < 0.0)
    fold, least = x[falls[0]] if falls.size else x[0], x.min()
    top = max(float(np.interp(deep, depth[-2500:], x[-2500:])), fold + 0.3 * (fold - least))
    first = min(least, -work / stress) - 0.3 * (top - least)
    travel = np.append(np.linspace(first, top, 200), np.linspace(top, first, 200))
    approach, retreat = np.maximum.accumulate(x), np.minimum.accumulate(x[::-1])[::-1]
    measured = np.empty(400)
    for part, envelope in ((slice(0, 200), approach), (slice(200, 400), retreat)):
        i = np.clip(np.searchsorted(envelope, travel[part]), 1, x.size - 1)
        step = envelope[i] - envelope[i - 1]
        fraction = np.where(
            step > 0.0, (travel[part] - envelope[i - 1]) / np.where(step > 0.0, step, 1.0), 1.0
        )
        between = force[i - 1] + fraction * (force[i] - force[i - 1])
        measured[part] = np.where(travel[part] < envelope[0], 0.0, between)
    noise *= np.ptp(measured)
    measured = measured + noise * rng.normal(size=400) + 3.0 * noise
    curve = mdr.MeasuredCurve(force=measured, travel=travel + 0.05 * RADIUS, spring_constant=machine)
    unknown = {"range": work / stress, "strength": stress}[name]
    true = {"body.young": young, "adhesion.work": work, f"adhesion.{name}": unknown}
    work_off, unknown_off, young_off = 10.0 ** rng.uniform(-0.4, 0.4, 3)
    law = mdr.MaugisDugdale(work_off * work, **{name: unknown_off * unknown})
    begin = mdr.Contact(mdr.Paraboloid(RADIUS), mdr.Elastic(young_off * young, 0.5), adhesion=law)
    return begin, curve, true, noise


@pytest.mark.parametrize("seed", [24, 0, 44])
def test_intervals_of_an_unknown_range_contain_the_minima_that_fit_as_well(seed):
    """One of two minima was taken, with an interval 0.3 (44) or 2.3 % (24) wide that excluded the true range; by the curvature alone one (0) ended short of it."""
    begin, curve, true, noise = cohesive_record(seed)
    fitted = mdr.fit(begin, curve, list(true))
    assert fitted.noise < 1.15 * noise
    for name, value in true.items():
        assert fitted[name].low < value < fitted[name].high, name


def test_the_interval_of_a_strength_is_open_towards_a_limit_that_fits_as_well():
    """JKR fits as well as the law, beyond the scanned ranges: the interval of the strength ended below the true one, and that of the work at it."""
    begin, curve, true, noise = cohesive_record(37, "strength")
    fitted = mdr.fit(begin, curve, list(true))
    assert fitted.noise < 1.15 * noise
    for name, value in true.items():
        assert fitted[name].low < value < fitted[name].high, name
    limit = mdr.fit(
        replace(begin, adhesion=mdr.JKR(begin.adhesion.work)), curve, ["body.young", "adhesion.work"]
    )
    # as well: less than a variance of the noise, of 400 samples
    assert limit.noise**2 < (1.0 + 4.0 / 400.0) * fitted.noise**2
    for name in ("body.young", "adhesion.work"):
        assert fitted[name].low < limit[name].value < fitted[name].high, name
    strength = fitted["adhesion.strength"]
    assert strength.high == math.inf
    # the other side is not widened with it: the weakest scanned strength does not fit
    assert 0.0 < strength.low < strength.value < 0.2 * true["adhesion.strength"]
    assert any("adhesion.strength is not determined" in note and "inf" in note for note in fitted.notes)


def test_a_map_keeps_a_curve_whose_interval_is_open_on_one_side():
    """Its error, which the open side widens beyond the value, made all numbers of the curve NaN in a map."""
    begin, curve, true, _ = cohesive_record(37, "strength")
    shared = {"profile.radius": "5 %"}
    mapped = mdr.fit_map(begin, [curve], list(true), uncertainty=shared)
    fitted = mdr.fit(begin, curve, list(true), uncertainty=shared)
    assert fitted["adhesion.strength"].error > fitted["adhesion.strength"].value
    assert mapped["ending"].item() == FITTED
    for name in true:
        assert abs(mapped[name].item() - fitted[name].value) <= 1e-3 * fitted[name].error, name
        ends = mapped[f"{name}_low"].item(), mapped[f"{name}_high"].item()
        assert ends == pytest.approx((fitted[name].low, fitted[name].high), rel=1e-6), name
    # the other side stays closed
    assert mapped["adhesion.strength_high"].item() == math.inf
    assert mapped["adhesion.strength_low"].item() > 0.0
