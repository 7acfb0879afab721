"""The halves of a record, as the benchmark compares them, on records whose truth is known."""

from __future__ import annotations

import importlib
from pathlib import Path

import numpy as np
import pytest

import pymdr as mdr

DEPTH = np.linspace(-1e-6, 1e-6, 400)
GEL = mdr.Contact(mdr.Paraboloid("5 um"), mdr.Elastic("3 kPa", 0.5))
FORCE = mdr.solve(GEL, mdr.Path(indentation=DEPTH))["normal_force"].values


@pytest.fixture
def benchmark(monkeypatch):
    """The module, which stands beside the tests."""
    monkeypatch.syspath_prepend(str(Path(__file__).parent.parent))
    return importlib.import_module("benchmarks.halves")


def curve_of(noise):
    return mdr.MeasuredCurve(force=FORCE + 0.01 * np.ptp(FORCE) * noise, indentation=DEPTH)


def white(seed):
    return np.random.default_rng(seed).normal(size=DEPTH.size)


def test_halves_of_white_noise_agree_as_often_as_they_should(benchmark):
    agreed = 0
    for seed in range(40):
        _, own = benchmark.halves(GEL, curve_of(white(seed)), ["body.young"])
        difference, largest = own["body.young"]
        agreed += abs(difference) <= largest
    # 95 % of 40 are 38, with a deviation of 1.4
    assert agreed >= 34


def test_what_is_likely_is_what_the_noise_makes_of_a_fit(benchmark):
    ratios = []
    for seed in range(8):
        fitted = mdr.fit(GEL, curve_of(white(seed)), ["body.young"])
        young = fitted["body.young"]
        ratios.append(benchmark.likely(fitted, seed).std(axis=0)[0] / (young.error / young.value))
    # of 50 blocks each, which tell a deviation to a fifth
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.25)


def test_parts_and_means_keep_the_record(benchmark):
    curve = mdr.MeasuredCurve(force=FORCE, travel=DEPTH, time=np.arange(400.0), spring_constant=0.05)
    even, odd = (benchmark.part(curve, i, 2) for i in (0, 1))
    assert np.array_equal(np.sort(np.append(even.force, odd.force)), np.sort(FORCE))
    assert (even.spring_constant, odd.time[0]) == (0.05, 1.0)
    few = benchmark.thinned(curve, 100)
    assert few.force.size == 100
    assert few.force == pytest.approx(FORCE.reshape(100, 4).mean(axis=1))


def test_halves_of_a_record_without_contact_are_refused(benchmark):
    record = mdr.MeasuredCurve(force=1e-11 * white(3), indentation=DEPTH)
    with pytest.raises(mdr.PymdrError, match="no contact"):
        benchmark.halves(GEL, record, ["body.young"])
