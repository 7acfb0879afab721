"""Fits of adhesion whose edge has a history: known values behind noise, and refusals of what a record does not determine."""

import numpy as np
import pytest
from typer.testing import CliRunner

import pymdr as mdr
from pymdr.errors import ProblemError
from pymdr.solving.fits.determining import refuse_noisy
from pymdr.solving.fits.searching import Search
from pymdr.solving.fits.unknowns import unknowns_of
from pymdr.workbench.cli import app

GEL = mdr.Elastic("30 kPa", 0.5)
BALL = mdr.Paraboloid("1 mm")
SILICONE = mdr.Viscoelastic(mdr.StandardSolid("10 kPa", "30 kPa", "1 s"), poisson=0.5)
PROBE = mdr.Contact(BALL, SILICONE, adhesion=mdr.MaugisDugdale("50 mJ/m^2", range="5 um"))
STIFFNESS = 20.0


def pressed(speed, approach=20e-6, dwell=5.0, counts=(40, 10, 80)):
    """Times in s and travels in m of an approach, a dwell and a retreat at a speed in m/s."""
    far, top, end = -20e-6, 20e-6, -250e-6
    legs = [(far, top, (top - far) / approach), (top, top, dwell), (top, end, (top - end) / speed)]
    times, travels, now = [0.0], [far], 0.0
    for (start, stop, duration), count in zip(legs, counts, strict=True):
        times += list(now + np.linspace(0.0, duration, count + 1)[1:])
        travels += list(np.linspace(start, stop, count + 1)[1:])
        now += duration
    return np.array(times), np.array(travels)


def measured(contact, speed, seed=0, noise=2e-6, **path):
    """A record of a contact with noise in N, its contact point at 4 um and its baseline 3 uN."""
    time, travel = pressed(speed, **path)
    result = mdr.solve(contact, mdr.Path(time=time, travel=travel), machine_stiffness=STIFFNESS)
    noisy = result["normal_force"].values + noise * np.random.default_rng(seed).normal(size=time.size)
    return mdr.MeasuredCurve(force=noisy + 3e-6, travel=travel + 4e-6, time=time, spring_constant=STIFFNESS)


def holds(computed, **truth):
    """Whether every 95 % interval contains the true value, with the name of the first that does not."""
    for name, value in truth.items():
        one = computed[name.replace("__", ".")]
        assert one.low < value < one.high, f"{one} without {value}"


def test_a_loop_determines_both_works():
    adhesive = mdr.Contact(BALL, GEL, adhesion=mdr.JKR("50 mJ/m^2", work_receding="200 mJ/m^2"))
    start = mdr.with_parameters(adhesive, {"adhesion.work": 0.02, "adhesion.work_receding": 0.06})
    curve = measured(adhesive, 20e-6, counts=(30, 2, 60))
    free = ["adhesion.work", "adhesion.work_receding"]
    fitted = mdr.fit(start, curve, free, contact_point=4e-6, baseline=3e-6)
    holds(fitted, adhesion__work=0.05, adhesion__work_receding=0.2)
    assert fitted["adhesion.work_receding"].error < 0.01 * 0.2


def test_a_tilted_baseline_leaves_out_only_samples_at_jumps():
    """A tilt that lifts the samples after the pull-off above the noise does not make them samples in contact."""
    adhesive = mdr.Contact(BALL, GEL, adhesion=mdr.JKR("50 mJ/m^2", work_receding="200 mJ/m^2"))
    level = measured(adhesive, 20e-6, counts=(30, 2, 60))
    tilted = level.force + 0.1 * (level.travel - 4e-6)
    curve = mdr.MeasuredCurve(force=tilted, travel=level.travel, spring_constant=STIFFNESS)
    fitted = mdr.fit(adhesive, curve, ["adhesion.work", "adhesion.work_receding", "tilt"])
    holds(fitted, adhesion__work=0.05, adhesion__work_receding=0.2, tilt=0.1)
    assert fitted["tilt"].error < 0.01
    assert int((~fitted.data["used"].values).sum()) <= 6


def test_laws_with_and_without_hysteresis_are_distinguished():
    laws = {
        "one": mdr.Contact(BALL, GEL, adhesion=mdr.JKR("20 mJ/m^2")),
        "two": mdr.Contact(BALL, GEL, adhesion=mdr.JKR("20 mJ/m^2", work_receding="60 mJ/m^2")),
    }
    free = ["adhesion.work", "adhesion.work_receding"]
    loop = mdr.Contact(BALL, GEL, adhesion=mdr.JKR("50 mJ/m^2", work_receding="70 mJ/m^2"))
    weighed = mdr.compare_laws(laws, measured(loop, 20e-6, counts=(30, 2, 60)), free)
    assert "two" in weighed
    assert weighed.best == "two"
    assert weighed.weights["one"] < 1e-6
    plain = mdr.Contact(BALL, GEL, adhesion=mdr.JKR("50 mJ/m^2"))
    weighed = mdr.compare_laws(laws, measured(plain, 20e-6, counts=(30, 2, 60)), free)
    assert list(weighed) == ["one"]  # of the laws that could be fitted
    assert weighed.best == "one"
    assert "no hysteresis of adhesion: both works are 49." in weighed.refusals["two"]


def test_shell(tmp_path):
    adhesive = mdr.Contact(BALL, GEL, adhesion=mdr.JKR("50 mJ/m^2", work_receding="200 mJ/m^2"))
    curve = measured(adhesive, 20e-6, counts=(30, 2, 60))
    rows = [f"{z!r},{f!r}" for z, f in zip(curve.travel.tolist(), curve.force.tolist(), strict=True)]
    (tmp_path / "loop.csv").write_text("travel (m),force (N)\n" + "\n".join(rows))
    case = tmp_path / "gel.toml"
    case.write_text(
        '[profile]\nkind = "paraboloid"\nradius = "1 mm"\n[body]\nkind = "elastic"\nyoung = "30 kPa"\npoisson = 0.5\n'
        '[adhesion]\nkind = "jkr"\nwork = "20 mJ/m^2"\nwork_receding = "60 mJ/m^2"\n'
    )
    words = ["fit", str(case), str(tmp_path / "loop.csv"), "--free", "adhesion.work_receding", "--free"]
    words += ["adhesion.work", "--spring-constant", "20 N/m", "-o", str(tmp_path / "out")]
    answer = CliRunner().invoke(app, words)
    assert answer.exit_code == 0, answer.output
    assert "adhesion.work_receding" in answer.output
    assert (tmp_path / "out" / "fit.png").exists()


def test_a_loop_that_cannot_be_fitted_is_refused():
    equal = mdr.Contact(BALL, GEL, adhesion=mdr.JKR(0.05, work_receding=0.05))
    record = mdr.MeasuredCurve(force=np.arange(9.0), travel=np.arange(9.0), spring_constant=1.0)
    with pytest.raises(ProblemError, match="from a start above"):
        mdr.fit(equal, record, ["adhesion.work_receding"])
    loop = mdr.Contact(BALL, GEL, adhesion=mdr.JKR(0.05, work_receding=0.2))
    whole = measured(loop, 20e-6, counts=(30, 2, 60))
    late = mdr.MeasuredCurve(force=whole.force[20:], travel=whole.travel[20:], spring_constant=STIFFNESS)
    with pytest.raises(ProblemError, match="begins in contact"):
        mdr.fit(loop, late, ["adhesion.work_receding"])


def test_a_fixed_work_that_bounds_the_other_is_named():
    adhesive = mdr.Contact(BALL, GEL, adhesion=mdr.JKR("50 mJ/m^2", work_receding="200 mJ/m^2"))
    start = mdr.with_parameters(adhesive, {"adhesion.work": 0.01, "adhesion.work_receding": 0.02})
    curve = measured(adhesive, 20e-6, counts=(30, 2, 60))
    with pytest.raises(
        ProblemError, match=r"free both adhesion\.work and adhesion\.work_receding: a fixed one bounds"
    ):
        mdr.fit(start, curve, ["adhesion.work"], contact_point=4e-6, baseline=3e-6)


def test_a_retreat_determines_the_work_of_a_body_with_memory():
    start = mdr.with_parameters(PROBE, {"adhesion.work": 0.02})
    fitted = mdr.fit(start, measured(PROBE, 20e-6), ["adhesion.work"])
    holds(fitted, adhesion__work=0.05, contact_point=4e-6, baseline=3e-6)
    assert fitted["adhesion.work"].error < 0.02 * 0.05


def slow_retreat(noise=2e-6):
    return measured(PROBE, 1e-6, 0, noise, approach=2e-6, dwell=30.0, counts=(20, 4, 50))


def test_a_slow_retreat_determines_work_and_range_with_little_noise():
    """Rates by short steps, in which the steps in time scatter, ended the search at the range of the start."""
    start = mdr.with_parameters(PROBE, {"adhesion.work": 0.03, "adhesion.range": 3.5e-6})
    free = ["adhesion.work", "adhesion.range"]
    fitted = mdr.fit(start, slow_retreat(), free, contact_point=4e-6, baseline=3e-6)
    holds(fitted, adhesion__work=0.05, adhesion__range=5e-6)
    assert fitted["adhesion.range"].error < 0.05 * 5e-6


def test_work_and_range_that_noise_hides_are_refused():
    """A pair whose weakest combination has a 95 % interval of more than a factor of 4 is not told apart."""
    free = ["adhesion.work", "adhesion.range"]
    known = {"contact_point": 4e-6, "baseline": 3e-6, "tilt": 0.0}
    search = Search(PROBE, unknowns_of(PROBE, free), (slow_retreat(),), known)
    best = search.to_free([0.05, 5e-6], [{}])
    slopes = search.slopes(best)
    weakest = np.linalg.svd(slopes)[1][-1]
    error = np.log(4.0) / 3.92
    refuse_noisy(search, best, slopes, 0.99 * error * weakest)
    with pytest.raises(
        ProblemError, match=r"cannot distinguish adhesion\.work and adhesion\.range.*other speeds"
    ):
        refuse_noisy(search, best, slopes, 1.01 * error * weakest)


def test_two_speeds_determine_work_and_rheology():
    unknown = {"adhesion.work": 0.03, "body.shear.modulus": 15e3, "body.shear.time": 2.0}
    start = mdr.with_parameters(PROBE, unknown)
    curves = [measured(PROBE, speed, seed) for seed, speed in enumerate((5e-6, 100e-6))]
    fitted = mdr.fit(start, curves, list(unknown))
    holds(fitted, adhesion__work=0.05, body__shear__modulus=30e3, body__shear__time=1.0)
    assert fitted["body.shear.modulus"].error < 0.05 * 30e3


def test_a_slow_retreat_does_not_determine_a_relaxation_time():
    speed = 1e-13
    slow = measured(PROBE, speed, approach=speed, dwell=1e8, counts=(30, 2, 60))
    with pytest.raises(ProblemError, match="determines only the equilibrium modulus, 10 kPa"):
        mdr.fit(PROBE, slow, ["adhesion.work", "body.shear.time"], contact_point=4e-6, baseline=3e-6)


def very_slow(speed, seed):
    """A record of a retreat in which the relaxation nearly completes, with noise of a thousandth of the pull-off force."""
    legs = {"approach": min(2e-6, 2.0 * speed), "dwell": 30.0, "counts": (30, 6, 100)}
    time, travel = pressed(speed, **legs)
    force = mdr.solve(PROBE, mdr.Path(time=time, travel=travel), machine_stiffness=STIFFNESS)["normal_force"]
    return measured(PROBE, speed, seed, noise=1e-3 * abs(float(force.min())), **legs)


@pytest.mark.parametrize("seed", [0, 1])
def test_the_time_of_a_very_slow_retreat_lies_in_its_interval(seed):
    fitted = mdr.fit(PROBE, very_slow(1e-8, seed), ["adhesion.work", "body.shear.time"])
    holds(fitted, adhesion__work=0.05, body__shear__time=1.0)


def test_a_retreat_too_slow_for_a_time_is_refused():
    with pytest.raises(
        ProblemError, match=r"hardly determines body\.shear\.time: .* more than a factor of 4"
    ):
        mdr.fit(PROBE, very_slow(1e-10, 1), ["adhesion.work", "body.shear.time"])


@pytest.mark.parametrize("seed", range(4))
def test_retreats_of_random_bodies_find_their_work(seed):
    """Truth, start, speed and noise are random; the work is within four standard errors, of 5 % at most."""
    rng = np.random.default_rng(seed)
    work, modulus = rng.uniform(0.03, 0.1), 10.0 ** rng.uniform(4.0, 4.6)
    body = mdr.Viscoelastic(mdr.StandardSolid("10 kPa", modulus, rng.uniform(0.3, 3.0)), poisson=0.5)
    probe = mdr.Contact(BALL, body, adhesion=mdr.MaugisDugdale(work, range=rng.uniform(4e-6, 8e-6)))
    start = mdr.with_parameters(probe, {"adhesion.work": work * rng.uniform(0.5, 2.0)})
    speed, noise = 10.0 ** rng.uniform(-5.0, -4.0), 10.0 ** rng.uniform(-6.0, -5.3)
    fitted = mdr.fit(start, measured(probe, speed, seed, noise, counts=(30, 4, 60)), ["adhesion.work"])
    one = fitted["adhesion.work"]
    assert abs(one.value - work) < 4.0 * one.error
    assert one.error < 0.05 * work


def test_memory_is_compared_with_other_laws_and_mapped():
    curve = measured(PROBE, 20e-6, counts=(20, 4, 40))
    laws = {"memory": PROBE, "elastic": mdr.Contact(BALL, GEL, adhesion=mdr.JKR("50 mJ/m^2"))}
    weighed = mdr.compare_laws(laws, curve, ["adhesion.work"])
    assert weighed.best == "memory"
    assert weighed.weights["elastic"] < 1e-6
    fitted = mdr.fit_map(PROBE, [curve, curve], ["adhesion.work"])
    np.testing.assert_allclose(fitted["adhesion.work"].values, 0.05, rtol=0.05)
