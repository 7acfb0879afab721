"""A rough line over an elastomer: against sums over its waves, springs in time steps, scaling, and refusals."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pymdr as mdr
from pymdr.line.rough_sliding import stationary
from pymdr.mapping.self_affine import line_heights, waves

ROAD = mdr.SelfAffineLine(length="1 mm", rms_slope=0.1, hurst=0.8, shortest="50 um", seed=1)
RUBBER = mdr.Viscoelastic(mdr.Prony("1 MPa", ["3 MPa", "5 MPa"], ["10 ms", "0.1 ms"]), poisson=0.5)
KERNELS = {
    "terms": mdr.Relaxation(1.0, np.array([3.0, 2.0]), np.array([1.0, 0.05])),
    "dashpot": mdr.Relaxation(1.0, viscosity=0.2),
    "both": mdr.Relaxation(1.0, np.array([3.0]), np.array([0.3]), 0.1),
}


@settings(max_examples=40, deadline=None)
@given(
    st.floats(-9, 3),
    st.floats(-3, 1),
    st.floats(0, 1),
    st.integers(1, 300),
    st.integers(1, 20),
    st.integers(0, 99),
)
def test_waves_have_the_slope_and_the_spectrum(log_length, log_slope, hurst, last, first, seed):
    length = 10.0**log_length
    first = min(first, last)
    rough = mdr.SelfAffineLine(
        length=length,
        rms_slope=10.0**log_slope,
        hurst=hurst,
        shortest=length / last,
        longest=length / first,
        seed=seed,
    )
    q, A, phase = waves(rough)
    assert q.size == last - first + 1
    assert q[0] * length == pytest.approx(2 * math.pi * first, rel=1e-12)
    assert 0.5 * np.sum((A * q) ** 2) == pytest.approx(rough.rms_slope**2, rel=1e-12)
    assert (A[-1] / A[0]) ** 2 == pytest.approx((q[0] / q[-1]) ** (2 * hurst + 1), rel=1e-12)
    x = length * np.arange(64) / 64
    by_hand = (A * np.cos(np.outer(x, q) + phase)).sum(axis=1)
    n = 64 * math.ceil((2 * last + 2) / 64)
    assert line_heights(rough, n)[:: n // 64] == pytest.approx(by_hand, abs=1e-11 * np.sum(A))


def test_a_seed_is_a_line_and_finer_waves_leave_it():
    again = mdr.SelfAffineLine(length="1 mm", rms_slope=0.1, hurst=0.8, shortest="50 um", seed=1)
    assert again == ROAD
    assert np.array_equal(line_heights(again, 512), line_heights(ROAD, 512))
    other = mdr.SelfAffineLine(length="1 mm", rms_slope=0.1, hurst=0.8, shortest="50 um", seed=2)
    assert not np.allclose(line_heights(other, 512), line_heights(ROAD, 512))
    finer = mdr.SelfAffineLine(length="1 mm", rms_slope=0.1, hurst=0.8, shortest="10 um", seed=1)
    assert np.array_equal(waves(finer)[2][:20], waves(ROAD)[2])


@settings(max_examples=25, deadline=None)
@given(st.sampled_from(sorted(KERNELS)), st.floats(-9, 5))
def test_a_line_that_is_touched_everywhere_loses_what_its_waves_do(name, log_speed):
    rough = mdr.SelfAffineLine(length=1.0, rms_slope=0.1, hurst=0.7, shortest=0.1, seed=4)
    relaxation, speed = KERNELS[name], 10.0**log_speed
    q, A, _ = waves(rough)
    expected = 0.5 * np.sum(A**2 * q * relaxation.loss(q * speed))
    depth = 100.0 * relaxation(0.0) * (1.0 + speed) * np.sum(A)
    found = [stationary(line_heights(rough, n), 1.0, depth, relaxation, speed) for n in (640, 1280)]
    assert found[1].pressure == pytest.approx(relaxation.equilibrium * depth, rel=1e-10)
    # second order in the distance of the places
    finer = (4.0 * found[1].drag - found[0].drag) / 3.0
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
            share = relaxation.times * (1.0 - kept) / dt
            slow = relaxation.moduli * relaxation.times * (after - w) / dt
            mean = (share * h + (1.0 - share) * slow).sum()
            h = kept * h + fresh * (after - w)
            q = 0.5 * relaxation.equilibrium * (w + after) + mean + relaxation.viscosity * (after - w) / dt
            total, work = total + q, work + q * (after - w)
            w = after
    return total / heights.size, work


@settings(max_examples=25, deadline=None)
@given(
    moduli=st.lists(st.floats(-3, 3), min_size=1, max_size=4),
    times=st.lists(st.integers(-30, 30), min_size=4, max_size=4, unique=True),
    log_speed=st.floats(-18, 18),
    share=st.floats(-0.9, 0.9),
)
def test_any_line_finds_its_stationary_state_at_any_speed(moduli, times, log_speed, share):
    own = 10.0 ** np.array(moduli), 10.0 ** (np.array(times[: len(moduli)]) / 10.0)
    relaxation = mdr.Relaxation(1.0, *own)
    rough = mdr.SelfAffineLine(length=1.0, rms_slope=0.1, hurst=0.7, shortest=0.1, seed=4)
    heights = line_heights(rough, 200)
    found = stationary(heights, 1.0, share * heights.max(), relaxation, 10.0**log_speed)
    # no spring is above the line, or deeper than its highest place
    assert found.pressure >= np.mean(heights) + share * heights.max()
    assert 0.0 < found.pressure <= (1.0 + share) * heights.max()
    assert found.drag > 0.0


@pytest.mark.parametrize("share", [-0.5, 0.0, 0.5])
@pytest.mark.parametrize("name", KERNELS)
def test_passages_one_after_the_other(name, share):
    rough = mdr.SelfAffineLine(length=1.0, rms_slope=0.1, hurst=0.7, shortest=0.1, seed=4)
    heights = line_heights(rough, 200)
    depth = share * heights.max()
    for speed in (0.3, 3.0):
        found = stationary(heights, 1.0, depth, KERNELS[name], speed)
        load, work = in_time_steps(heights, depth, KERNELS[name], 1.0 / (200 * speed), 130)
        assert found.pressure == pytest.approx(load, rel=1e-6)
        assert found.drag == pytest.approx(work, rel=1e-6)


@settings(max_examples=20, deadline=None)
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
        rough = mdr.SelfAffineLine(length=size, rms_slope=slope, hurst=0.8, shortest=size / 8)
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
    assert np.all((claim.error > 0) & (claim.error < 0.01))
    for name in ("contact_area", "slow_limit", "leading_edge"):
        with pytest.raises(mdr.NotValidError):
            by_force[name]
    assert "F_x/F_N: approximate: qualitative" in str(by_force)
    assert len(by_force.plot().axes) == 2


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"speed": 0.0}, "above 0 m/s"),
        ({"indentation": "1 um"}, "exactly one"),
        ({"normal_force": None}, "exactly one"),
        ({"normal_force": "0 N"}, "above 0 N"),
        ({"normal_force": None, "indentation": "-1 mm"}, "no spring is touched"),
        ({"rough": mdr.Sphere("1 mm")}, "not a SelfAffineLine"),
        ({"body": mdr.Elastic("1 MPa", 0.5)}, "not Viscoelastic"),
        ({"body": mdr.Viscoelastic(mdr.Maxwell("1 MPa", "1 ms"), poisson=0.5)}, "relaxes to nothing"),
        ({"body": mdr.Viscoelastic(mdr.PowerLawRheology("1 MPa", "1 s", 0.2), poisson=0.5)}, "for ever"),
    ],
)
def test_bad_questions(asked, message):
    question = {"rough": ROAD, "body": RUBBER, "speed": "1 mm/s", "normal_force": "10 mN"} | asked
    with pytest.raises(mdr.ProblemError, match=message):
        mdr.rough_sliding_friction(
            question.pop("rough"), question.pop("body"), question.pop("speed"), **question
        )


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"rms_slope": 0.0}, "slope"),
        ({"hurst": 1.2}, "hurst"),
        ({"shortest": "2 mm"}, "must rise"),
        ({"longest": "2 mm"}, "must rise"),
        ({"shortest": "1 nm"}, "4096"),
        ({"seed": -1}, "seed"),
        ({"seed": 0.5}, "seed"),
    ],
)
def test_bad_lines(asked, message):
    with pytest.raises(mdr.ProblemError, match=message):
        mdr.SelfAffineLine(**{"length": "1 mm", "rms_slope": 0.1, "hurst": 0.8, "shortest": "50 um"} | asked)
