"""A rough line over an elastomer: against sums over its waves, springs in time steps, scaling, and refusals."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pymdr as mdr
from drawing import examples
from pymdr.line.rough_sliding import stationary
from pymdr.mapping.relaxation import Relaxation
from pymdr.mapping.rough import rough_heights, rough_waves

ROAD = mdr.RoughSurface(hurst=0.8, rms="5 um", size="1 mm", shortest="50 um", seed=1)
RUBBER = mdr.Viscoelastic(mdr.Prony("1 MPa", ["3 MPa", "5 MPa"], ["10 ms", "0.1 ms"]), poisson=0.5)
KERNELS = {
    "terms": Relaxation(1.0, np.array([3.0, 2.0]), np.array([1.0, 0.05])),
    "dashpot": Relaxation(1.0, viscosity=0.2),
    "both": Relaxation(1.0, np.array([3.0]), np.array([0.3]), 0.1),
}


@settings(max_examples=examples(40), deadline=None)
@given(
    st.floats(-9, 3),
    st.floats(-6, -1),
    st.floats(0.01, 1),
    st.floats(1.5, 300),
    st.floats(0, 1),
    st.floats(0.1, 10),
    st.integers(0, 99),
)
def test_a_line_is_the_sum_of_its_waves(log_length, log_rms, hurst, waves, roll, coefficient, seed):
    length = 10.0**log_length
    surface = mdr.RoughSurface(
        hurst, 10.0**log_rms * length, length, length / waves, length / waves**roll * 1.0001, seed
    )
    q, A = rough_waves(surface, coefficient)
    assert q.size == math.floor(waves * (1 + 1e-12))
    assert 0.5 * np.sum(A**2) == pytest.approx(surface.rms**2 * coefficient / math.pi, rel=1e-12)
    flat = q * surface.roll_off <= 2 * math.pi
    expected = np.where(flat, q, q * (q * surface.roll_off / (2 * math.pi)) ** (-2 * hurst - 2))
    assert (A / A[0]) ** 2 == pytest.approx(expected / expected[0], rel=1e-9)
    n = 64 * math.ceil(4 * q.size / 64)
    phase = 2 * math.pi * np.random.default_rng([seed, 7]).random(q.size)
    by_hand = (A * np.cos(np.outer(length * np.arange(64) / 64, q) + phase)).sum(axis=1)
    computed = rough_heights(surface, 7, n, coefficient)
    assert computed[:: n // 64] == pytest.approx(by_hand, abs=1e-11 * np.sum(A))


def test_a_realisation_is_a_line_and_lambda_only_scales_it():
    v = "1 mm/s"

    def slid(surface, **options):
        return mdr.rough_sliding_friction(surface, RUBBER, v, indentation="1 um", **options)

    mu = float(slid(ROAD)["friction_coefficient"][0])
    assert float(slid(ROAD, realisation=1)["friction_coefficient"][0]) != pytest.approx(mu, rel=1e-6)
    twice = mdr.RoughSurface(hurst=0.8, rms="10 um", size="1 mm", shortest="50 um", seed=1)
    by_lambda = slid(ROAD, coefficient=4 * math.pi)
    by_height = slid(twice)
    for name in ("friction_coefficient", "normal_force"):
        assert float(by_lambda[name][0]) == pytest.approx(float(by_height[name][0]), rel=1e-9)
    (slope,) = by_lambda.assumptions
    heights = rough_heights(twice, 0, 1 << 16)
    assert slope.measure == pytest.approx(
        np.sqrt(np.mean(np.diff(heights) ** 2)) * (1 << 16) / 1e-3, rel=1e-5
    )


@settings(max_examples=examples(25), deadline=None)
@given(st.sampled_from(sorted(KERNELS)), st.floats(-9, 5))
def test_a_line_that_is_touched_everywhere_loses_what_its_waves_do(name, log_speed):
    rough = mdr.RoughSurface(hurst=0.7, rms=0.01, size=1.0, shortest=0.1, seed=4)
    relaxation, speed = KERNELS[name], 10.0**log_speed
    q, A = rough_waves(rough)
    expected = 0.5 * np.sum(A**2 * q * relaxation.loss(q * speed))
    depth = 100.0 * relaxation(0.0) * (1.0 + speed) * np.sum(A)
    results = [stationary(rough_heights(rough, 0, n), 1.0, depth, relaxation, speed) for n in (640, 1280)]
    assert results[1].pressure == pytest.approx(relaxation.equilibrium * depth, rel=1e-10)
    # second order in the distance of the places
    finer = (4.0 * results[1].drag - results[0].drag) / 3.0
    assert finer == pytest.approx(expected, rel=1e-4)


def in_time_steps(heights, depth, relaxation, dt, passages):
    w, h = 0.0, np.zeros(relaxation.times.size)
    kept = np.exp(-dt / relaxation.times)
    fresh = relaxation.moduli * relaxation.times * (1.0 - kept) / dt
    for _ in range(passages):
        total = work = 0.0
        for z in heights:
            free = w - (relaxation.equilibrium * w + kept @ h) / (
                relaxation.equilibrium + fresh.sum() + relaxation.viscosity / dt
            )
            after = max(depth + z, free)
            # the mean of what the terms bear along a straight step
            fraction = relaxation.times * (1.0 - kept) / dt
            slow = relaxation.moduli * relaxation.times * (after - w) / dt
            mean = (fraction * h + (1.0 - fraction) * slow).sum()
            h = kept * h + fresh * (after - w)
            q = 0.5 * relaxation.equilibrium * (w + after) + mean + relaxation.viscosity * (after - w) / dt
            total, work = total + q, work + q * (after - w)
            w = after
    return total / heights.size, work


@settings(max_examples=examples(25), deadline=None)
@given(
    moduli=st.lists(st.floats(-3, 3), min_size=1, max_size=4),
    times=st.lists(st.integers(-30, 30), min_size=4, max_size=4, unique=True),
    log_speed=st.floats(-18, 18),
    fraction=st.floats(-0.9, 0.9),
)
def test_any_line_finds_its_stationary_state_at_any_speed(moduli, times, log_speed, fraction):
    own = 10.0 ** np.array(moduli), 10.0 ** (np.array(times[: len(moduli)]) / 10.0)
    relaxation = Relaxation(1.0, *own)
    rough = mdr.RoughSurface(hurst=0.7, rms=0.01, size=1.0, shortest=0.1, seed=4)
    heights = rough_heights(rough, 0, 200)
    result = stationary(heights, 1.0, fraction * heights.max(), relaxation, 10.0**log_speed)
    # no spring is above the line, or deeper than its highest place
    assert result.pressure >= np.mean(heights) + fraction * heights.max()
    assert 0.0 < result.pressure <= (1.0 + fraction) * heights.max()
    assert result.drag > 0.0


@pytest.mark.parametrize("fraction", [-0.5, 0.0, 0.5])
@pytest.mark.parametrize("name", KERNELS)
def test_passages_one_after_the_other(name, fraction):
    rough = mdr.RoughSurface(hurst=0.7, rms=0.01, size=1.0, shortest=0.1, seed=4)
    heights = rough_heights(rough, 0, 200)
    depth = fraction * heights.max()
    for speed in (0.3, 3.0):
        result = stationary(heights, 1.0, depth, KERNELS[name], speed)
        load, work = in_time_steps(heights, depth, KERNELS[name], 1.0 / (200 * speed), 130)
        assert result.pressure == pytest.approx(load, rel=1e-6)
        assert result.drag == pytest.approx(work, rel=1e-6)


@settings(max_examples=examples(20), deadline=None)
@given(
    st.floats(-9, 1),
    st.floats(-9, 9),
    st.floats(3, 11),
    st.floats(-2, 2),
    st.floats(-3, 1),
    st.floats(0.1, 3),
)
def test_sizes_times_and_steepness_scale(log_size, log_time, log_modulus, log_speed, log_load, steeper):
    size, time, modulus = 10.0**log_size, 10.0**log_time, 10.0**log_modulus

    def slid(size, time, modulus, slope):
        rough = mdr.RoughSurface(hurst=0.8, rms=0.1 * slope * size, size=size, shortest=size / 8)
        body = mdr.Viscoelastic(mdr.StandardSolid(modulus, 9 * modulus, time), poisson=0.5)
        force = 10.0**log_load * slope * modulus * size**2
        return mdr.rough_sliding_friction(rough, body, 10.0**log_speed * size / time, normal_force=force)

    one, other = slid(1.0, 1.0, 1.0, 0.1), slid(size, time, modulus, 0.1 * steeper)
    expected = steeper * float(one["friction_coefficient"][0])
    assert float(other["friction_coefficient"][0]) == pytest.approx(expected, rel=1e-7)
    expected = steeper * size * float(one["indentation"][0])
    assert float(other["indentation"][0]) == pytest.approx(expected, rel=1e-7, abs=1e-9 * size * steeper)


def test_a_load_gives_the_depth_that_gives_the_load():
    v = [1e-4, 1e-2, 1.0]
    by_force = mdr.rough_sliding_friction(ROAD, RUBBER, v, normal_force="20 mN")
    for i, speed in enumerate(v):
        depth = float(by_force["indentation"][i])
        back = mdr.rough_sliding_friction(ROAD, RUBBER, speed, indentation=depth)
        assert float(back["normal_force"][0]) == pytest.approx(0.02, rel=1e-8)
        mu = float(by_force["friction_coefficient"][i])
        assert float(back["friction_coefficient"][0]) == pytest.approx(mu, rel=1e-8)
    assert by_force["normal_force"].values == pytest.approx([0.02] * 3, rel=1e-9)
    claim = by_force.claims["friction_coefficient"]
    assert claim.level is mdr.Level.APPROXIMATE
    assert "qualitative" in claim.reason
    assert claim.error is None
    numerics = np.array(by_force.data.attrs["numerical_error"])
    assert np.all((numerics > 0) & (numerics < 0.01))
    for name in ("contact_area", "slow_limit", "leading_edge"):
        with pytest.raises(mdr.NotValidError):
            by_force[name]
    assert "relative errors not known: friction_coefficient" in str(by_force)
    assert len(by_force.plot().axes) == 2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"speed": 0.0}, "above 0 m/s"),
        ({"indentation": "1 um"}, "exactly one"),
        ({"normal_force": None}, "exactly one"),
        ({"normal_force": "0 N"}, "above 0 N"),
        ({"normal_force": None, "indentation": "-1 mm"}, "no spring is in contact"),
        ({"surface": mdr.Sphere("1 mm")}, "not a RoughSurface"),
        ({"surface": mdr.RoughSurface(0.8, "1 um", "1 mm", "1 nm")}, "limit 4096"),
        ({"coefficient": 0.0}, "coefficient = 0; .* above 0"),
        ({"realisation": -1}, "realisation = -1"),
        ({"realisation": 0.5}, "realisation = 0.5"),
        ({"body": mdr.Elastic("1 MPa", 0.5)}, r"Elastic\(.*\) is not viscoelastic"),
        ({"body": mdr.Viscoelastic(mdr.Maxwell("1 MPa", "1 ms"), poisson=0.5)}, "relaxes completely"),
        ({"body": mdr.Viscoelastic(mdr.PowerLawRheology("1 MPa", "1 s", 0.2), poisson=0.5)}, "without limit"),
    ],
)
def test_bad_questions(arguments, message):
    question = {"surface": ROAD, "body": RUBBER, "speed": "1 mm/s", "normal_force": "10 mN"} | arguments
    with pytest.raises(mdr.ProblemError, match=message):
        mdr.rough_sliding_friction(
            question.pop("surface"), question.pop("body"), question.pop("speed"), **question
        )
