"""Maps of measured curves: what made each curve is found in it again, whatever cores and folders do."""

from __future__ import annotations

import dataclasses
import json
import math
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

import pymdr as mdr
from drawing import examples
from legibility import faults
from pymdr.errors import FileError, PathError, ProblemError, QuantityError
from pymdr.solving.fits import request
from pymdr.solving.fits.families import axes_of
from pymdr.solving.fits.ranges import next_samples
from pymdr.solving.fits.unknowns import unknowns_of

TIPS = {
    "paraboloid": lambda size: mdr.Paraboloid(size),
    "cone": lambda size: mdr.Cone(slope=0.3),
    "sum": lambda size: mdr.Paraboloid(size) + mdr.Cone(slope=0.05),
    "table": lambda size: mdr.Sampled(size * np.linspace(0, 1, 40), 0.4 * size * np.linspace(0, 1, 40) ** 2),
}


def contact_of(tip, young, work=None, size=5e-6):
    adhesion = None if work is None else mdr.JKR(work)
    return mdr.Contact(TIPS[tip](size), mdr.Elastic(young, 0.5), adhesion=adhesion)


def curve_of(contact, depth, machine=None, noise=0.0, seed=0, base=0.0, place=0.0, n=240):
    positions = np.concatenate([np.linspace(-depth, depth, n // 2), np.linspace(depth, -2.0 * depth, n // 2)])
    channel = {"indentation": positions} if machine is None else {"travel": positions}
    force = mdr.solve(contact, mdr.Path(**channel), machine_stiffness=machine)["normal_force"].values
    force = force + noise * np.ptp(force) * np.random.default_rng(seed).normal(size=n) + base * np.ptp(force)
    moved = {name: values + place * depth for name, values in channel.items()}
    return mdr.MeasuredCurve(force=force, spring_constant=machine, **moved)


@settings(max_examples=examples(12), deadline=None)
@given(
    st.sampled_from(list(TIPS)),
    st.floats(-8.0, -1.0),
    st.floats(2.0, 11.0),
    st.floats(-3.0, 3.0),
    st.none() | st.floats(-1.0, 1.5),
    st.floats(-1.0, 1.0),
)
def test_moduli_of_any_size_are_recovered(tip, log_size, log_young, log_start, log_machine, offset):
    size, young = 10.0**log_size, 10.0**log_young
    depth = 0.1 * size
    contact = contact_of(tip, young, size=size)
    largest = float(mdr.solve(contact, mdr.indent(depth))["normal_force"][0])
    machine = None if log_machine is None else largest / depth * 10.0**log_machine
    curve = curve_of(contact, depth, machine, base=offset, place=offset)
    fitted = mdr.fit_map(contact_of(tip, young * 10.0**log_start, size=size), [curve], ["body.young"])
    assert fitted["body.young"].values == pytest.approx(young, rel=1e-6)
    assert fitted["contact_point"].values == pytest.approx(offset * depth, abs=1e-6 * depth)
    assert fitted["baseline"].values == pytest.approx(offset * np.ptp(curve.force), abs=1e-6 * largest)


@settings(max_examples=examples(12), deadline=None)
@given(
    st.sampled_from(list(TIPS)),
    st.floats(2.0, 11.0),
    st.floats(-3.5, -1.5),
    st.floats(-2.0, 2.0),
    st.none() | st.floats(-0.5, 1.5),
)
def test_work_and_modulus_are_recovered(tip, log_young, log_work, log_start, log_machine):
    size, young = 5e-6, 10.0**log_young
    depth, work = 0.1 * size, young * 0.1 * size * 10.0**log_work
    contact = contact_of(tip, young, work)
    largest = float(mdr.solve(contact, mdr.indent(depth))["normal_force"][0])
    machine = None if log_machine is None else abs(largest) / depth * 10.0**log_machine
    curve = curve_of(contact, depth, machine, place=0.3)
    start = contact_of(tip, young * 10.0**log_start, work * 10.0**-log_start)
    fitted = mdr.fit_map(start, [curve], ["body.young", "adhesion.work"])
    assert fitted["body.young"].values == pytest.approx(young, rel=1e-4)
    assert fitted["adhesion.work"].values == pytest.approx(work, rel=1e-4)


@pytest.mark.parametrize("free", [["body.young"], ["adhesion.work"], ["body.young", "adhesion.work"]])
@pytest.mark.parametrize("machine", [None, 0.05])
def test_one_of_a_map_is_that_of_a_single_fit(free, machine):
    curve = curve_of(contact_of("paraboloid", 3e3, 2e-4), 1.5e-6, machine, 0.01, 4, -0.1, 0.2)
    start = contact_of(
        "paraboloid", 4e3 if "body.young" in free else 3e3, 1e-4 if free[-1] != "body.young" else 2e-4
    )
    one, many = mdr.fit(start, curve, free), mdr.fit_map(start, [curve], free)
    for name in (*free, "contact_point", "baseline"):
        assert many[name].values[0] == pytest.approx(one[name].value, abs=0.02 * one[name].error)
        assert many[f"{name}_error"].values[0] == pytest.approx(one[name].error, rel=0.1)
    assert many["noise"].values[0] == pytest.approx(one.noise, rel=1e-3)


def test_errors_are_what_they_say():
    clean = curve_of(contact_of("paraboloid", 3e3, 2e-4), 1.5e-6, 0.05)
    noise = 0.01 * np.ptp(clean.force) * np.random.default_rng(0).normal(size=(1000, clean.force.size))
    curves = [dataclasses.replace(clean, force=clean.force + one) for one in noise]
    fitted = mdr.fit_map(contact_of("paraboloid", 1e4, 1e-4), curves, ["body.young", "adhesion.work"])
    assert fitted.counts == {"fitted": 1000}
    for name, value in (("body.young", 3e3), ("adhesion.work", 2e-4), ("contact_point", 0.0)):
        off = (fitted[name].values - value) / fitted[f"{name}_error"].values
        # four deviations of a mean and of a variance of 1000
        assert abs(off.mean()) < 4.0 / math.sqrt(1000)
        assert off.std() == pytest.approx(1.0, abs=4.0 / math.sqrt(2000))
        assert 0.93 <= np.mean(np.abs(off) < 1.96) <= 0.97


def test_a_constant_pull_leaves_its_jump_where_the_samples_beside_it_are():
    """In correlated noise the contact point moved on from one sample to the next, and the pull counted as noise."""
    contact = mdr.Contact(mdr.Paraboloid("5 um"), mdr.Elastic("3 kPa", 0.5), adhesion=mdr.DMT("0.2 mJ/m^2"))
    clean = curve_of(contact, 1e-6, n=2000)
    curves = []
    for seed in range(20):
        white = np.random.default_rng(seed).normal(size=2030)
        slow = np.convolve(white, np.ones(31) / math.sqrt(31.0), mode="valid")
        noise = 5e-11 * (0.5 * white[15:-15] + 0.87 * slow)
        curves.append(dataclasses.replace(clean, force=clean.force + noise))
    free = ["body.young", "adhesion.work"]
    fitted = mdr.fit_map(contact, curves, free)
    noises = [mdr.fit(contact, curve, free).noise for curve in curves]
    assert fitted["noise"].values == pytest.approx(noises, rel=0.01)


def test_two_bodies_share_the_compliance():
    tip = mdr.Elastic("5 kPa", 0.3)
    contact = mdr.Contact(mdr.Paraboloid("5 um"), mdr.Elastic("3 kPa", 0.45), tip)
    curve = curve_of(contact, 1e-6)
    start = mdr.Contact(contact.profile, mdr.Elastic("9 kPa", 0.45), tip)
    assert mdr.fit_map(start, [curve], ["body.young"])["body.young"].values == pytest.approx(3e3, rel=1e-6)


def test_other_numbers_are_looked_for_too():
    contact = contact_of("paraboloid", 3e3)
    curve = curve_of(contact, 1e-6)
    radius = mdr.fit_map(
        contact_of("paraboloid", 3e3, size=1e-5), [curve], ["profile.radius"], contact_point=0.0
    )
    assert radius["profile.radius"].values == pytest.approx(5e-6, rel=1e-4)
    soft = mdr.Elastic("2 kPa", 0.5)
    layered = mdr.Contact(mdr.Paraboloid("5 um"), mdr.Layered([mdr.Layer(soft, "3 um")], mdr.Rigid()))
    fitted = mdr.fit_map(
        mdr.Contact(
            mdr.Paraboloid("5 um"), mdr.Layered([mdr.Layer(mdr.Elastic("5 kPa", 0.5), "3 um")], mdr.Rigid())
        ),
        [curve_of(layered, 1e-6)],
        ["body.layers[0].material.young"],
    )
    assert fitted["body.layers[0].material.young"].values == pytest.approx(2e3, rel=1e-5)


def stored(curves, shape, file=None):
    data = xr.Dataset(
        {
            "force": (
                ("y", "x", "sample"),
                1e9 * np.array([c.force for c in curves]).reshape(*shape, -1),
                {"units": "nN"},
            ),
            "travel": (
                ("y", "x", "sample"),
                1e6 * np.array([c.travel for c in curves]).reshape(*shape, -1),
                {"units": "um"},
            ),
            "spring_constant": ((), 0.05, {"units": "N/m"}),
        },
        coords={
            "x": ("x", 1.0 * np.arange(shape[1]), {"units": "um"}),
            "y": ("y", 1.0 * np.arange(shape[0]), {"units": "um"}),
        },
    )
    if file is not None:
        data.to_zarr(file, consolidated=False)
    return data


@pytest.fixture(scope="module")
def gel():
    """A map of 6 x 5 curves, and the moduli that made them."""
    young = np.geomspace(1e3, 9e3, 30)
    curves = [
        curve_of(contact_of("paraboloid", E, 2e-4), 1e-6, 0.05, 0.01, i, 0.1, 0.1)
        for i, E in enumerate(young)
    ]
    return curves, young


FREE = ["body.young", "adhesion.work"]


def test_a_map_is_the_same_from_lists_stores_and_cores(gel, tmp_path):
    curves, young = gel
    start = contact_of("paraboloid", 1e4, 1e-4)
    listed = mdr.fit_map(start, curves, FREE)
    data = stored(curves, (6, 5), tmp_path / "map.zarr")
    reports, first = [], None
    for result in (
        mdr.fit_map(start, data, FREE),
        mdr.fit_map(start, tmp_path / "map.zarr", FREE, workers=2),
        mdr.fit_map(start, data, FREE, folder=tmp_path / "fits", progress=lambda *done: reports.append(done)),
    ):
        assert result.data["ending"].dims == ("y", "x")
        first = first or result
        for name in (*FREE, "body.young_error", "noise"):
            assert np.array_equal(result[name].values, first[name].values)
        # other units are rounded apart, which may end the search a step earlier: far within what the curves tell
        for name in FREE:
            off = np.abs(result[name].values.ravel() - listed[name].values)
            assert np.all(off < 1e-3 * listed[f"{name}_error"].values)
    assert reports[-1] == (30, 30)
    assert (
        np.abs(result["body.young"].values.ravel() - young).max()
        < 5.0 * result["body.young_error"].values.max()
    )
    again = xr.open_zarr(tmp_path / "fits", consolidated=False)
    assert again["body.young"].attrs["units"] == "Pa"
    xr.testing.assert_equal(again.load(), result.data)
    assert "<table>" in result._repr_html_()
    assert "30 of 30 curves fitted" in repr(result)
    assert len(repr(result)) < 200
    sources = " ".join(result.cite())
    assert "Johnson, Kendall and Roberts" in sources
    assert "Marquardt" in sources
    assert result.to("body.young", "kPa").values == pytest.approx(1e-3 * result["body.young"].values)
    with pytest.raises(QuantityError, match="no quantity 'modulus'; this map has"):
        result["modulus"]
    assert "30 of 30 curves fitted" in result.summary()
    result.to_csv(tmp_path / "map.csv")
    assert "body.young [Pa]" in (tmp_path / "map.csv").read_text().splitlines()[0]
    figure = result.plot()
    assert not faults(figure)
    assert len([axes for axes in figure.axes if axes.axison]) == 10
    letters = [text.get_text() for axes in figure.axes for text in axes.texts]
    assert letters == ["(a)", "(b)", "(c)", "(d)", "(e)"]
    assert figure.axes[0].get_xlabel() == "x (µm)"


def test_a_killed_map_goes_on_where_it_was(gel, tmp_path, monkeypatch):
    from pymdr.solving.fits import stretches

    monkeypatch.setattr(stretches, "_CHUNK", 10 * 240)
    curves, _ = gel
    start, data = contact_of("paraboloid", 1e4, 1e-4), stored(curves, (6, 5))
    whole = mdr.fit_map(start, data, FREE)

    def killed(done, total):
        if done == 20:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        mdr.fit_map(start, data, FREE, folder=tmp_path / "fits", progress=killed)
    reports = []
    fitted = mdr.fit_map(
        start, data, FREE, folder=tmp_path / "fits", progress=lambda *done: reports.append(done)
    )
    assert reports == [(20, 30), (30, 30)]
    for name in whole.data:
        assert np.array_equal(fitted.data[name].values, whole.data[name].values)
    with pytest.raises(FileError, match="another fit"):
        mdr.fit_map(start, data, ["body.young"], folder=tmp_path / "fits")


def test_a_store_by_url_has_the_numbers_of_a_folder(gel):
    fsspec = pytest.importorskip("fsspec", reason="fsspec, which opens stores by URL, is not installed")
    curves, _ = gel
    start, data = contact_of("paraboloid", 1e4, 1e-4), stored(curves[:4], (2, 2))
    data.to_zarr("memory://image/curves.zarr", consolidated=False)
    whole = mdr.fit_map(start, data, FREE)
    for _ in range(2):  # the second time all curves are finished
        fitted = mdr.fit_map(start, "memory://image/curves.zarr", FREE, folder="memory://image/fits.zarr")
        for name in whole.data:
            assert np.array_equal(fitted.data[name].values, whole.data[name].values)
    assert fsspec.filesystem("memory").exists("/image/fits.zarr/zarr.json")


def test_what_fails_says_why(gel):
    curves, _ = gel
    flat = mdr.MeasuredCurve(
        force=1e-11 * np.random.default_rng(1).normal(size=100),
        travel=np.linspace(0, 1e-6, 100),
        spring_constant=0.05,
    )
    data = stored(curves, (6, 5))
    data["force"][0, 0, :] = np.nan
    data["force"][0, 1, 30:60] = np.nan
    start = contact_of("paraboloid", 1e4, 1e-4)
    fitted = mdr.fit_map(start, data, FREE)
    assert fitted.counts == {"fitted": 29, "no curve, or too few samples that are numbers": 1}
    assert math.isnan(fitted["body.young"].values[0, 0])
    alone = mdr.fit_map(contact_of("paraboloid", 1e4), [flat], ["body.young"])
    assert alone.counts == {"no contact in the curve": 1}
    assert "0 of 1 curves" in alone.summary()
    unseen = mdr.fit_map(start, [curve_of(contact_of("paraboloid", 1e4), 1e-6, noise=0.01)], FREE)
    assert list(unseen.counts) == ["the curve does not show an unknown within its bounds"]
    outside = mdr.fit_map(start, curves[-1:], {"body.young": ["1 kPa", "2 kPa"], "adhesion.work": None})
    assert outside.data["ending"].values[0] != 0


def test_bodies_with_memory_are_fitted_one_by_one():
    time = np.linspace(0.0, 2.0, 60)
    depth = 1e-6 * (1.0 - np.abs(time - 1.0))

    def contact(modulus):
        return mdr.Contact(
            mdr.Paraboloid("5 um"),
            mdr.Viscoelastic(mdr.StandardSolid(modulus, 2.0 * modulus, 0.5), poisson=0.5),
        )

    force = mdr.solve(contact(1e3), mdr.Path(time=time, indentation=depth))["normal_force"].values
    name = next(p.name for p in mdr.parameters_of(contact(1e3)) if p.unit == "Pa")
    curve = mdr.MeasuredCurve(force=force, indentation=depth, time=time)
    fitted = mdr.fit_map(contact(1e3), [curve], {name: ["0.5 kPa", "2 kPa"]}, contact_point=0.0, baseline=0.0)
    assert fitted[name].values == pytest.approx(1e3, rel=1e-3)
    assert any("Lee and Radok" in source for source in fitted.cite())
    assert any("Marquardt" in source for source in fitted.cite())


@pytest.mark.parametrize(
    ("curves", "words"),
    [
        ([], "MeasuredCurves are needed"),
        (7, "MeasuredCurves are needed"),
        (xr.Dataset({"force": (("y", "sample"), np.ones((2, 9)))}), "no travel or indentation"),
        (
            xr.Dataset({n: (("y", "sample"), np.ones((2, 9))) for n in ("force", "travel")}),
            "no spring_constant",
        ),
        (
            xr.Dataset(
                {n: (("y", "sample"), np.ones((2, 9)), {"units": "m"}) for n in ("force", "indentation")}
            ),
            "force has the units 'm'",
        ),
        (xr.Dataset({n: (("sample",), np.ones(9)) for n in ("force", "indentation")}), "a grid and sample"),
    ],
)
def test_bad_maps_are_refused(curves, words):
    with pytest.raises(ProblemError, match=words):
        mdr.fit_map(contact_of("paraboloid", 1e3), curves, ["body.young"])


def test_a_store_that_is_none_is_refused(tmp_path):
    with pytest.raises(FileError, match=r"none\.zarr"):
        mdr.fit_map(contact_of("paraboloid", 1e3), tmp_path / "none.zarr", ["body.young"])


def test_marked_samples_are_left_out():
    curve = curve_of(contact_of("paraboloid", 3e3), 1e-6)
    force = curve.force.copy()
    force[[20, 170]] += 5.0 * np.ptp(force)
    bad = mdr.MeasuredCurve(force=force, indentation=curve.indentation).mark_outliers()
    assert bad.marked.sum() == 2
    one = mdr.fit(contact_of("paraboloid", 1e4), bad, ["body.young"])
    many = mdr.fit_map(contact_of("paraboloid", 1e4), [bad], ["body.young"])
    assert one["body.young"].value == pytest.approx(3e3, rel=1e-6)
    assert "2 samples marked" in one.notes[0]
    assert many["body.young"].values == pytest.approx(3e3, rel=1e-6)


def test_a_table_of_a_whole_record_is_read_ready_for_a_fit(tmp_path):
    curve = curve_of(contact_of("paraboloid", 3e3, 2e-4), 1e-6, 0.05, 0.005, 1, 0.2, 0.3)
    lines = [f"{-1e6 * x:.9f},{-1e9 * f:.9f}" for x, f in zip(curve.travel, curve.force, strict=True)]
    (tmp_path / "curve.csv").write_text("\n".join(["travel [um],load [nN]", *lines]) + "\n")
    (record,) = mdr.read_prepared_curves(tmp_path / "curve.csv", spring_constant="0.05 N/m")
    assert [step.name for step in record.steps] == ["joined", "outliers", "signs", "saturation", "baseline"]
    fitted = mdr.fit_map(contact_of("paraboloid", 1e4, 1e-4), [record], FREE)
    assert fitted["body.young"].values == pytest.approx(3e3, abs=5.0 * fitted["body.young_error"].values[0])
    (approach,) = mdr.read_prepared_curves(
        tmp_path / "curve.csv", segment="approach", spring_constant="0.05 N/m"
    )
    assert approach.force.size < record.force.size
    with pytest.raises(ProblemError, match="one of record, approach, retreat"):
        mdr.read_prepared_curves(tmp_path / "curve.csv", segment="hold", spring_constant="0.05 N/m")


def test_curves_with_pixels_are_stacked_into_a_map():
    young = {(0, 0): 1e3, (1, 0): 2e3, (0, 2): 4e3}
    curves = [
        dataclasses.replace(
            curve_of(contact_of("paraboloid", E), 1e-6, n=100 + 20 * x),
            metadata={"grid index x": x, "grid index y": y, "grid shape x": 2, "grid shape y": 3},
        )
        for (x, y), E in young.items()
    ]
    data = mdr.stack_curves(curves)
    assert data["force"].dims == ("y", "x", "sample")
    fitted = mdr.fit_map(contact_of("paraboloid", 1e4), data, ["body.young"])
    for (x, y), E in young.items():
        assert fitted["body.young"].values[y, x] == pytest.approx(E, rel=1e-6)
    assert np.isnan(fitted["body.young"].values).sum() == 3
    assert mdr.stack_curves(curves[:1])["force"].dims == ("curve", "sample")
    with pytest.raises(ProblemError, match="all with travel"):
        mdr.stack_curves([])


def test_a_map_from_the_shell(gel, tmp_path, shell):
    curves, young = gel
    stored(curves, (6, 5), tmp_path / "map.zarr")
    (tmp_path / "case.toml").write_text(
        "[profile]\nkind = 'paraboloid'\nradius = '5 um'\n[body]\nkind = 'elastic'\nyoung = '1 MPa'\npoisson = 0.5\n"
        "[adhesion]\nkind = 'jkr'\nwork = '10 mJ/m^2'\n"
    )
    arguments = [
        "fit",
        tmp_path / "case.toml",
        tmp_path / "map.zarr",
        "--free",
        "body.young",
        "--free",
        "adhesion.work",
    ]
    status, out, _ = shell(*arguments, "--workers", "2", "-o", tmp_path / "out", "--json")
    assert status == 0
    data = json.loads(out)
    assert data["fit"]["endings"] == {"fitted": 30}
    assert data["fit"]["values"]["body.young"]["median"] == pytest.approx(np.median(young), rel=0.1)
    assert {file.name for file in (tmp_path / "out").iterdir()} == {"fit.csv", "fit.png", "fit.zarr"}
    status, out, _ = shell(*arguments)
    assert "30 of 30 curves fitted" in out
    status, _, err = shell(*arguments, "--spring-constant", "0.1 N/m")
    assert status == 1
    assert "a stored map has its own" in err
    status, _, err = shell(*arguments, "--over-indentation", "3")
    assert status == 1
    assert "--over-indentation is for single records" in err
    more = ("--uncertainty", "profile.radius=5 %", "--max-force", "100 uN", "--json")
    status, out, _ = shell(*arguments, *more)
    assert status == 0
    values = json.loads(out)["fit"]["values"]["body.young"]
    assert values["median_systematic"] / values["median"] == pytest.approx(0.025, rel=0.1)  # E ~ R^(-1/2)


def test_uncertainties_that_all_curves_share_are_beside_the_noise_of_each():
    curves = [
        curve_of(contact_of("paraboloid", young), 1.5e-6, 0.05, noise=0.01, seed=4) for young in (2e3, 3e3)
    ]
    given = {"spring_constant": "10 %", "sensitivity": "3 %", "profile.radius": "5 %"}
    plain, results = (
        mdr.fit_map(contact_of("paraboloid", 1e4), curves, ["body.young"], uncertainty=each)
        for each in (None, given)
    )
    assert "body.young_systematic" not in plain.data
    for name in ("body.young", "body.young_error"):
        np.testing.assert_array_equal(results[name], plain[name])
    scaled = results["body.young_systematic"] / results["body.young"]
    # a stiffer cantilever and a softer one turn a deflection into forces in proportion; E ~ R^(-1/2)
    assert (scaled > math.hypot(0.1, 0.025)).all()
    np.testing.assert_allclose(
        mdr.fit_map(
            contact_of("paraboloid", 1e4), curves, ["body.young"], uncertainty={"spring_constant": "5 mN/m"}
        )["body.young_systematic"]
        / results["body.young"],
        0.1,
        rtol=1e-3,
    )
    one = mdr.fit(contact_of("paraboloid", 1e4), curves[1], ["body.young"], uncertainty=given)["body.young"]
    for end, value in (("low", one.low), ("high", one.high)):
        assert results[f"body.young_{end}"].values[1] == pytest.approx(value, rel=1e-3)
    assert "from spring_constant, sensitivity, profile.radius, which all curves share" in results.summary()
    folded = [mdr.MeasuredCurve(force=one.force, indentation=one.travel) for one in curves]
    for wrong, words in (
        ({}, "by name"),
        ({"body.young": "1 %"}, "it is fitted"),
        ({"sensitivity": "1 %"}, "give travel and spring_constant"),
    ):
        with pytest.raises(ProblemError, match=words):
            mdr.fit_map(contact_of("paraboloid", 1e4), folded, ["body.young"], uncertainty=wrong)


def assert_as_single_fits(start, curves, free, limits):
    """Values within 0.02 standard errors of those of single fits, and the same quality."""
    fitted = mdr.fit_map(start, curves, free, fit_range=limits)
    assert fitted.counts == {"fitted": len(curves)}
    for i, curve in enumerate(curves):
        one = mdr.fit(start, curve, free, fit_range=limits)
        for name in (*free, "contact_point", "baseline"):
            assert abs(fitted[name].values[i] - one[name].value) < 0.02 * one[name].error
        assert fitted["indentation"].values[i] == pytest.approx(
            float(one.data["indentation"].max()), rel=3e-4
        )
        assert fitted["samples_in_contact"].values[i] == one.quality.samples_in_contact
        assert fitted["relative_residual"].values[i] == pytest.approx(one.quality.relative_residual, rel=1e-3)
        assert fitted["baseline_rise"].values[i] == pytest.approx(one.quality.baseline_rise, abs=1e-4)
        # the spectra of the noise of a map have no prior
        assert fitted[f"{free[0]}_error"].values[i] == pytest.approx(one[free[0]].error, rel=0.1)
    return fitted


@pytest.mark.parametrize("limits", [{"indentation": "500 nm"}, {"force": "4 nN"}])
@pytest.mark.parametrize("work", [None, 2e-4])
def test_each_curve_of_a_map_has_the_fit_range(limits, work):
    free = ["body.young"] if work is None else FREE
    start = contact_of("paraboloid", 1e4, None if work is None else 1e-3)
    curves = [
        curve_of(contact_of("paraboloid", young, work), 1.5e-6, 0.05, 0.01, seed, 0.1, 0.2)
        for seed, young in enumerate((2e3, 4e3))
    ]
    result = assert_as_single_fits(start, curves, free, limits)
    assert result.notes[0].startswith("fit range: ")
    for wrong in ({"depth": 1.0}, {}, {"force": "-1 nN"}):
        with pytest.raises(ProblemError, match="fit_range"):
            mdr.fit_map(start, curves, free, fit_range=wrong)


@pytest.mark.parametrize("depth", ["150 nm", "1.5 um"])
@pytest.mark.parametrize("work", [None, 2e-4])
def test_intervals_of_a_map_are_those_of_single_fits(work, depth):
    """Up to 150 nm, where six samples are in contact, errors of 30 % are far from normal."""
    free, start = FREE[: 1 if work is None else 2], contact_of("paraboloid", 1e4, work and 1e-3)
    options = {"fit_range": {"indentation": depth}, "uncertainty": {"profile.radius": "1 %"}}
    for seed in range(3):
        curve = curve_of(contact_of("paraboloid", 3e3, work), 1.5e-6, 0.05, 0.01, seed, 0.1, 0.2)
        many, one = mdr.fit_map(start, [curve], free, **options), mdr.fit(start, curve, free, **options)
        for name in (*free, "contact_point", "baseline"):
            total = math.hypot(float(many[f"{name}_error"][0]), float(many[f"{name}_systematic"][0]))
            own = (*(float(many[f"{name}{end}"][0]) for end in ("", "_low", "_high")), total)
            single = one[name]
            expected = (single.value, single.low, single.high, single.error)
            np.testing.assert_allclose(own, expected, rtol=0.0, atol=1e-3 * single.error)


@pytest.mark.parametrize(("seed", "draws"), [(4, 13), (9, 4)], ids=["jumps", "range"])
def test_jumps_and_ranges_are_found_in_turn(seed, draws):
    ball, positions = mdr.Paraboloid("1 um"), np.linspace(-3e-7, 2.5e-7, 160)
    positions, rng = np.concatenate([positions, positions[::-1]]), np.random.default_rng(seed)
    # the end of the first has other jumps than its start; two samples of the second enter and leave the range by turns
    young, noise = [(10 ** rng.uniform(3.3, 4.3), rng.normal(size=positions.size)) for _ in range(draws)][-1]
    true = mdr.Contact(ball, mdr.Elastic(young, 0.5), adhesion=mdr.JKR(1e-9 * young))
    force = mdr.solve(true, mdr.Path(travel=positions), machine_stiffness=0.02)["normal_force"].values
    force += 0.005 * np.ptp(force) * noise
    curve = mdr.MeasuredCurve(force=force, travel=positions + 1e-8, spring_constant=0.02)
    start = mdr.Contact(ball, mdr.Elastic("5 kPa", 0.5), adhesion=mdr.JKR("5 uJ/m^2"))
    assert_as_single_fits(start, [curve], FREE, {"indentation": "150 nm"})


def test_samples_that_return_to_a_range_are_left_out():
    low, high = np.arange(9) < 5, np.arange(9) < 8
    whole = np.ones(9, dtype=bool)
    assert next_samples([whole], low) is low
    # the smaller set of a cycle is the end, or the next round
    assert next_samples([whole, high, low], high) is None
    np.testing.assert_array_equal(next_samples([whole, low, high], low), low)
    assert next_samples([whole, low, high, low], high) is None
    more = np.arange(9) < 6
    assert next_samples([whole, low], more) is more
    assert next_samples([whole, low], low) is None


@pytest.mark.parametrize("machine", [None, 0.05])
@pytest.mark.parametrize(
    ("limits", "text"),
    [({"indentation": "1e-30 m"}, "indentation up to"), ({"force": "1e-30 N"}, "force up to")],
)
def test_a_fit_range_without_samples_is_refused(machine, limits, text):
    curve, start = curve_of(contact_of("paraboloid", 3e3), 1e-6, machine, 0.01), contact_of("paraboloid", 1e4)
    words = rf"fit range: {text} .*: 0 of 240 samples are within it and in contact \(limit 3\); give a larger range"
    with pytest.raises(ProblemError, match=words):
        mdr.fit(start, curve, ["body.young"], fit_range=limits)
    with pytest.raises(ProblemError, match=rf"no curve is fitted: {words}"):
        mdr.fit_map(start, [curve], ["body.young"], fit_range=limits)


def test_a_curve_with_too_few_samples_in_a_fit_range_is_refused_alone():
    start = contact_of("paraboloid", 1e4)
    stiff, soft = (curve_of(contact_of("paraboloid", young), 1e-6, None, 0.003) for young in (3e5, 3e3))
    fitted = mdr.fit_map(start, [stiff, soft], ["body.young"], fit_range={"force": "3 nN"})
    assert fitted["ending"].values.tolist() == [request.TOO_FEW, request.FITTED]
    assert any("samples are within it and in contact (limit 3)" in note for note in fitted.notes)


def test_ranges_and_uncertainties_hold_curve_by_curve_too():
    tip, law = mdr.Paraboloid("5 um"), mdr.MaugisDugdale("0.2 mJ/m^2", strength="1 kPa")
    true, start = (mdr.Contact(tip, mdr.Elastic(young, 0.5), adhesion=law) for young in ("3 kPa", "5 kPa"))
    assert axes_of(start, unknowns_of(start, ["body.young"])) is None
    curve = curve_of(true, 1.5e-6, noise=0.01, n=100)
    options = {"fit_range": {"indentation": "1 um"}, "uncertainty": {"profile.radius": "5 %"}}
    fitted = mdr.fit_map(start, [curve], ["body.young"], **options)
    one = mdr.fit(start, curve, ["body.young"], **options)
    assert fitted["body.young"].values[0] == pytest.approx(one["body.young"].value, rel=1e-6)
    for end, value in (("low", one["body.young"].low), ("high", one["body.young"].high)):
        assert fitted[f"body.young_{end}"].values[0] == pytest.approx(value, rel=1e-6)
    shared = fitted["body.young_systematic"].values[0]
    assert shared == pytest.approx(one.calibration["profile.radius"]["body.young"], rel=1e-6)
    assert fitted["indentation"].values[0] < 1.05e-6
    slow = mdr.Contact(tip, mdr.Viscoelastic(mdr.StandardSolid("1 kPa", "2 kPa", "0.5 s"), poisson=0.5))
    with pytest.raises(ProblemError, match="only force curves of elastic bodies are cut"):
        mdr.fit_map(slow, [curve], ["body.shear.modulus"], fit_range={"force": "1 nN"})


def test_samples_that_are_nan_are_beyond_the_fit_range():
    depth = np.linspace(-1e-6, 1.5e-6, 400)
    noise = 1e-10 * np.random.default_rng(1).normal(size=(2, depth.size))
    force = 16 / 9 * 3e3 * np.sqrt(5e-6) * np.maximum(depth, 0.0) ** 1.5 + noise
    contact, within = contact_of("paraboloid", 1e4), depth < 0.8e-6
    curves = [mdr.MeasuredCurve(force=one[within], indentation=depth[within]) for one in force]
    alone = [mdr.fit(contact, curve, ["body.young"])["body.young"].value for curve in curves]
    dataset = xr.Dataset(
        {"force": (("curve", "sample"), np.where(within, force, np.nan)), "indentation": ("sample", depth)}
    )
    fitted = mdr.fit_map(contact, dataset, ["body.young"])
    np.testing.assert_allclose(fitted["body.young"], alone, rtol=1e-5)
    assert fitted["indentation"].values.max() < 0.85e-6


def contact_laws():
    tip, gel = mdr.Paraboloid("5 um"), mdr.Elastic("10 kPa", 0.5)
    return {
        "Hertz": mdr.Contact(tip, gel),
        "JKR": mdr.Contact(tip, gel, adhesion=mdr.JKR("1 mJ/m^2")),
        "DMT": mdr.Contact(tip, gel, adhesion=mdr.DMT("1 mJ/m^2")),
    }


@pytest.mark.parametrize("true", ["Hertz", "JKR", "DMT"])
def test_the_law_that_made_a_curve_is_the_best(true):
    adhesion = {"Hertz": None, "JKR": mdr.JKR("0.2 mJ/m^2"), "DMT": mdr.DMT("0.2 mJ/m^2")}[true]
    contact = mdr.Contact(mdr.Paraboloid("5 um"), mdr.Elastic("3 kPa", 0.5), adhesion=adhesion)
    result = mdr.compare_laws(contact_laws(), curve_of(contact, 1e-6, None, 0.002, 2), FREE)
    assert result.best == true
    assert result.weights[true] > 0.99
    assert sum(result.weights.values()) == pytest.approx(1.0)
    assert result[true]["body.young"].value == pytest.approx(3e3, rel=0.1)
    if true == "Hertz":
        assert set(result.refusals) == {"JKR", "DMT"}
        with pytest.raises(QuantityError, match="shows no adhesion"):
            result["JKR"]
    assert true in str(result).splitlines()[1]
    assert repr(result).startswith(f"<pymdr.LawComparison {true}")
    html = result._repr_html_()
    assert html.index(f"<td style='text-align:left'>{true}</td>") == html.index(
        "<td style='text-align:left'>"
    )
    assert all(why.split(":")[0] in html for why in result.refusals.values())
    assert any("Burnham and Anderson" in source for source in result.cite())
    assert len(set(result.cite())) == len(result.cite())
    assert not faults(result.plot())


@pytest.mark.parametrize(
    "machine",
    [None, pytest.param(0.5, marks=pytest.mark.long), pytest.param(5.0, marks=pytest.mark.long)],
)
@pytest.mark.parametrize("law", ["JKR", "DMT"])
def test_jumps_of_each_law_count_in_a_comparison(law, machine):
    """A record of DMT has no hysteresis, one of JKR has; noise is a tenth of the pull or of the largest force, whichever is smaller."""
    right, count = 0, 2 if machine is None else 4
    for seed in range(count):
        rng = np.random.default_rng(seed)
        radius, young = 10 ** rng.uniform(-8, -2), 10 ** rng.uniform(3, 11)
        depth, modulus = 0.05 * radius, young / 0.75
        load = 4 / 3 * modulus * radius**0.5 * depth**1.5
        pull = load * 10 ** rng.uniform(-0.3, 0.3)
        work = pull / ({"JKR": 1.5, "DMT": 2.0}[law] * np.pi * radius)
        stiffness = None if machine is None else machine * load / depth
        lag = 0.0 if machine is None else 1.0 / stiffness
        far = -2.0 * depth - 3.0 * (work**2 * radius / modulus**2) ** (1 / 3)
        ends = far, depth + lag * load, far - 2.0 * lag * pull
        positions = np.concatenate([np.linspace(*ends[:2], 150), np.linspace(*ends[1:], 150)])
        channel, options = (
            ("indentation", {}) if machine is None else ("travel", {"machine_stiffness": stiffness})
        )
        bodies = mdr.Paraboloid(radius), mdr.Elastic(young, 0.5)
        made = mdr.Contact(*bodies, adhesion=getattr(mdr, law)(work))
        force = mdr.solve(made, mdr.Path(**{channel: positions}), **options)["normal_force"].values
        force = force + 0.1 * min(load, pull) * rng.normal(size=force.size)
        curve = mdr.MeasuredCurve(force=force, spring_constant=stiffness, **{channel: positions + depth})
        laws = {
            name: mdr.Contact(*bodies, adhesion=getattr(mdr, name)(0.5 * work)) for name in ("JKR", "DMT")
        }
        weights = mdr.compare_laws(laws, curve, FREE).weights
        assert weights[law] > 0.05
        right += weights[law] > 0.5
    assert right >= min(count, 3)


def test_laws_that_cannot_be_compared_are_refused():
    curve = curve_of(contact_of("paraboloid", 1e3), 1e-6)
    with pytest.raises(ProblemError, match="two laws"):
        mdr.compare_laws({"Hertz": contact_of("paraboloid", 1e3)}, curve, ["body.young"])
    with pytest.raises(ProblemError, match="Hertz has none of the parameters"):
        mdr.compare_laws(contact_laws(), curve, ["adhesion.work"])


def test_a_cluster_gives_the_same_numbers(gel):
    distributed = pytest.importorskip(
        "distributed", reason="distributed, of the extra cluster, is not installed"
    )
    curves, _ = gel
    start, data = contact_of("paraboloid", 1e4, 1e-4), stored(curves, (6, 5))
    here = mdr.fit_map(start, data, FREE)
    with (
        distributed.LocalCluster(
            n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        fitted = mdr.fit_map(start, data, FREE, workers=client)
    for name in here.data:
        assert np.array_equal(fitted.data[name].values, here.data[name].values, equal_nan=True)


REAL = Path(__file__).parents[2] / "shared/data/afm"


@pytest.mark.skipif(not REAL.is_dir(), reason="the measured curves of ../shared are not there")
@pytest.mark.parametrize("name", ["spot3-0192", "polymergel-2021.06.30", "zebrafish"])
@pytest.mark.parametrize("law", ["Hertz", "JKR"])
def test_halves_of_a_measured_record_agree(name, law):
    pytest.importorskip("afmformats", reason="afmformats, of the extra afm, is not installed")
    (file,) = REAL.glob(f"*{name}.jpk-force")
    (curve,) = mdr.read_prepared_curves(file, segment="approach" if law == "Hertz" else "retreat")
    adhesion = None if law == "Hertz" else mdr.JKR("0.1 mJ/m^2")
    start = mdr.Contact(mdr.Paraboloid("5 um"), mdr.Elastic("10 kPa", 0.5), adhesion=adhesion)
    halves = [
        mdr.MeasuredCurve(
            force=curve.force[i::2], travel=curve.travel[i::2], spring_constant=curve.spring_constant
        )
        for i in (0, 1)
    ]
    free = ["body.young"] if law == "Hertz" else FREE
    fitted = mdr.fit_map(start, halves, free)
    assert fitted.counts == {"fitted": 2}
    for one in free:
        low, high = fitted[one].values
        assert abs(low - high) < 1.96 * float(np.hypot(*fitted[f"{one}_error"].values))


@pytest.mark.parametrize("workers", [1, 2])
def test_refusals_are_reported_from_other_processes_and_from_a_store(workers, tmp_path):
    body = mdr.Viscoelastic(mdr.StandardSolid(1e3, 2e3, 0.5), poisson=0.5)
    contact = mdr.Contact(mdr.Paraboloid("5 um"), body)
    name = next(p.name for p in mdr.parameters_of(contact) if p.unit == "Pa")
    untimed = [curve_of(contact_of("paraboloid", 1e3), 1e-6)] * 2
    for _ in range(2):
        fitted = mdr.fit_map(contact, untimed, [name], workers=workers, folder=tmp_path / "fits")
        assert fitted.counts == {"refused": 2}
        assert "needs the times of the samples" in fitted.notes[0]


def test_a_pull_without_adhesion_is_reported():
    sticky = curve_of(contact_of("paraboloid", 3e3, 2e-4), 1e-6, None, 0.01)
    plain = curve_of(contact_of("paraboloid", 3e3), 1e-6, None, 0.01)
    assert "below the fitted baseline, but the contact has no adhesion" in " ".join(
        mdr.fit(contact_of("paraboloid", 1e4), sticky, ["body.young"]).notes
    )
    assert mdr.fit(contact_of("paraboloid", 1e4), plain, ["body.young"]).notes == ()


def test_waves_are_reported_for_every_curve():
    paraboloid, cone = contact_of("paraboloid", 3e3), contact_of("cone", 3e3)
    curves = [
        curve_of(one, 1e-6, noise=0.003, seed=i) for i, one in enumerate((paraboloid, cone, paraboloid))
    ]
    fitted = mdr.fit_map(contact_of("paraboloid", 1e4), curves, ["body.young"])
    single = [mdr.fit(contact_of("paraboloid", 1e4), one, ["body.young"]) for one in curves]
    assert fitted["waves"].values == pytest.approx([one.waves for one in single], rel=1e-3)
    assert fitted["waves"].values[[0, 2]].tolist() == [0.0, 0.0]
    assert fitted["waves"].values[1] > 1.0
    assert any(note.startswith("1 of 3 curves have residual waves") for note in fitted.notes)
    assert any("waves" in note for note in single[1].notes)
    assert not single[0].notes


@settings(max_examples=examples(20), deadline=None)
@given(st.integers(0, 10**6), st.integers(30, 3000))
def test_white_noise_is_no_wave(seed, samples):
    from pymdr.solving.fits.residuals import waves_of

    noise = np.random.default_rng(seed).normal(size=(3, samples))
    assert np.all(waves_of(noise, np.ones(3)) < 1.0)
    # a wave of amplitude A has the variance A^2 / 2
    wave = 4.0 * np.sqrt(2.0) * np.sin(np.linspace(0.0, 12.0, samples))
    if samples > 300:  # the wave itself hardly differs between neighbours
        assert waves_of(noise + wave, np.full(3, 9.0)) == pytest.approx(4.0, rel=0.3)
    assert np.all(waves_of(1e-9 * wave[None, :], np.ones(1)) == 0.0)


def test_every_curve_says_how_far_it_is_from_the_limits():
    rng = np.random.default_rng(4)
    depths = 5e-6 * rng.uniform(0.01, 0.3, 100)
    youngs, works = rng.uniform(1e3, 5e3, 100), rng.uniform(1e-4, 4e-4, 100)
    curves = [
        curve_of(contact_of("paraboloid", E, w), depth, None, 0.01, i)
        for i, (depth, E, w) in enumerate(zip(depths, youngs, works, strict=True))
    ]
    fitted = mdr.fit_map(contact_of("paraboloid", 1e4, 1e-3), curves, FREE)
    of_limit, good = fitted["of_limit"].values, np.isfinite(fitted["body.young"].values)
    assert good.sum() > 90
    for i in np.flatnonzero(good)[::9]:
        made = contact_of("paraboloid", float(fitted["body.young"][i]), float(fitted["adhesion.work"][i]))
        radius = mdr.solve(made, mdr.indent(float(fitted["indentation"][i])))["contact_radius"].values[0]
        assert of_limit[i] == pytest.approx(radius / 5e-6 / 0.3, rel=0.03)
    beyond = int((of_limit[good] > 1.0).sum())
    assert f"{beyond} of {good.sum()} curves exceed a limit" in fitted.summary()
    few = mdr.fit_map(contact_of("paraboloid", 1e4, 1e-3), curves[:20], FREE)
    assert few["of_limit"].values == pytest.approx(of_limit[:20], rel=0.03, nan_ok=True)


def test_an_unfinished_store_is_made_anew(gel, tmp_path, monkeypatch):
    from pymdr.solving.fits.storing import Kept

    curves, _ = gel
    start, make = contact_of("paraboloid", 1e4, 1e-4), Kept._make

    def killed(self, request, *rest):
        make(self, request, *rest)
        raise KeyboardInterrupt

    monkeypatch.setattr(Kept, "_make", killed)
    with pytest.raises(KeyboardInterrupt):
        mdr.fit_map(start, curves[:3], FREE, folder=tmp_path / "fits")
    monkeypatch.undo()
    with pytest.raises(FileError, match="another fit"):
        mdr.fit_map(start, curves[:3], ["body.young"], folder=tmp_path / "fits")
    fitted = mdr.fit_map(start, curves[:3], FREE, folder=tmp_path / "fits")
    assert fitted.counts == {"fitted": 3}


def test_what_no_file_holds_is_not_kept_in_a_folder(tmp_path):
    tip = mdr.Function(lambda r: r**2 / 1e-5)
    contact = mdr.Contact(tip, mdr.Elastic(1e4, 0.5))
    curves = [curve_of(contact_of("paraboloid", 3e3), 1e-6, None, 0.01)]
    with pytest.raises(ProblemError, match="leave folder out"):
        mdr.fit_map(contact, curves, ["body.young"], folder=tmp_path / "fits")
    assert not (tmp_path / "fits").exists()
    assert mdr.fit_map(contact, curves, ["body.young"]).counts == {"fitted": 1}


def test_maps_of_bodies_with_memory_report_every_curve():
    body = mdr.Viscoelastic(mdr.StandardSolid(1e3, 2e3, 0.5), poisson=0.5)
    time = np.linspace(0.0, 2.0, 40)
    depth = 1e-6 * (1.0 - np.abs(time - 1.0))
    contact = mdr.Contact(mdr.Paraboloid("5 um"), body)
    force = mdr.solve(contact, mdr.Path(time=time, indentation=depth))["normal_force"].values
    data = xr.Dataset(
        {
            "force": (("y", "x", "sample"), np.broadcast_to(force, (1, 3, 40))),
            "indentation": ("sample", depth),
            "time": ("sample", time),
        }
    )
    reports = []
    fitted = mdr.fit_map(
        contact,
        data,
        ["body.shear.time"],
        contact_point=0.0,
        baseline=0.0,
        progress=lambda *done: reports.append(done),
    )
    assert reports == [(1, 3), (2, 3), (3, 3)]
    assert fitted.counts == {"fitted": 3}


def test_a_map_determines_what_a_soft_machine_does_not():
    sticky = mdr.Contact(mdr.Paraboloid("5 um"), mdr.Elastic("30 kPa", 0.5), adhesion=mdr.JKR("0.2 mJ/m^2"))
    positions = np.concatenate([np.linspace(-2e-6, 2e-6, 150), np.linspace(2e-6, -3e-6, 190)])
    start = mdr.Contact(sticky.profile, mdr.Elastic(1e5, 0.5), adhesion=mdr.JKR(1e-3))
    endings = {}
    for machine in (0.05, 0.001):
        true = mdr.solve(sticky, mdr.Path(travel=positions), machine_stiffness=machine)["normal_force"].values
        noise = 0.01 * np.ptp(true) * np.random.default_rng(1).normal(size=(8, positions.size))
        data = xr.Dataset({"force": (("curve", "sample"), true + noise), "travel": ("sample", positions)})
        fitted = mdr.fit_map(start, data.assign(spring_constant=machine), FREE)
        endings[machine] = fitted.counts
        for name in FREE:
            assert not (fitted[f"{name}_error"] > fitted[name]).any()
    assert endings[0.05] == {"fitted": 8}
    refused = {name: count for name, count in endings[0.001].items() if name != "fitted"}
    assert all(
        name.startswith(("the curve does not determine", "the curve does not show")) for name in refused
    )
    assert sum(count for name, count in refused.items() if "does not determine" in name) > 2


def test_a_map_reports_saturated_detectors():
    curves = [curve_of(contact_of("paraboloid", young), 1e-6, None, 0.003) for young in (2e3, 3e3, 4e3)]
    limit = 0.7 * float(curves[1].force.max())
    data = mdr.stack_curves(curves).assign_coords(curve=np.arange(3))
    force = data["force"].values
    data["force"].values[:] = np.where(force > limit, limit, force)
    alone = mdr.MeasuredCurve(
        force=data["force"].values[1], indentation=data["indentation"].values[1]
    ).mark_saturated()
    fitted = mdr.fit_map(contact_of("paraboloid", 1e4), data, ["body.young"])
    plateau = fitted["plateau"].values
    assert plateau[0] == 0.0 or float(curves[0].force.max()) > limit
    assert plateau[1] == alone.marked.sum() > 5
    assert any("plateau" in note for note in fitted.notes)
    left_out = data.assign(force=data["force"].where(data["force"] < limit))
    again = mdr.fit_map(contact_of("paraboloid", 1e4), left_out, ["body.young"])
    assert not again["plateau"].any()
    assert again["body.young"].values == pytest.approx([2e3, 3e3, 4e3], rel=0.05)


def test_a_map_feels_no_friction():
    contact = mdr.Contact(mdr.Paraboloid("5 um"), mdr.Elastic(1e3, 0.5), friction=mdr.Coulomb(0.3))
    with pytest.raises(ProblemError, match="to fit"):
        mdr.fit_map(contact, [curve_of(contact_of("paraboloid", 1e3), 1e-6)], ["body.young"])


def test_a_pull_of_a_few_samples_is_recovered_with_honest_errors():
    sticky = mdr.Contact(
        mdr.PowerLaw(3.3, "1 um", "5 um"), mdr.Elastic("3 kPa", 0.5), adhesion=mdr.JKR("30 uJ/m^2")
    )
    positions = np.concatenate([np.linspace(-1e-6, 1.2e-6, 200), np.linspace(1.2e-6, -2.5e-6, 60)])
    true = mdr.solve(sticky, mdr.Path(travel=positions), machine_stiffness=0.02)["normal_force"].values
    assert 4 < (true < 0.3 * true.min()).sum() < 10
    noise = 0.018 * np.ptp(true) * np.random.default_rng(1).normal(size=(150, positions.size))
    data = xr.Dataset({"force": (("curve", "sample"), true + noise), "travel": ("sample", positions)})
    start = mdr.Contact(sticky.profile, mdr.Elastic(1e4, 0.5), adhesion=mdr.JKR(1e-3))
    fitted = mdr.fit_map(start, data.assign(spring_constant=0.02), FREE)
    assert fitted.counts == {"fitted": 150}
    for name, value in zip(FREE, (3e3, 3e-5), strict=True):
        off = np.abs(fitted[name].values - value) / fitted[f"{name}_error"].values
        # three deviations of the count below 95 %
        assert np.mean(off < 1.96) > 0.89
        assert off.max() < 5.0
    single = mdr.fit(
        start, mdr.MeasuredCurve(force=true + noise[0], travel=positions, spring_constant=0.02), FREE
    )
    assert single["adhesion.work"].error == pytest.approx(float(fitted["adhesion.work_error"][0]), rel=0.2)


@settings(max_examples=examples(20), deadline=None)
@given(st.floats(-3.0, -0.5), st.integers(300, 9000), st.booleans(), st.booleans())
def test_a_contact_that_is_a_small_part_of_its_record_is_located(log_fraction, samples, knows_point, sticks):
    fraction = max(10.0**log_fraction, 24.0 / samples)
    contact = contact_of("paraboloid", 3e3, 1e-6 if sticks else None)
    positions = 1e-6 * np.linspace(1.0 - 1.0 / fraction, 1.0, samples)
    if sticks:
        positions = np.concatenate([positions, positions[::-1]])
    force = mdr.solve(contact, mdr.Path(indentation=positions))["normal_force"].values
    noisy = force + 1e-3 * np.ptp(force) * np.random.default_rng(samples).normal(size=positions.size)
    start = contact_of("paraboloid", 1e5, 1e-6 if sticks else None)
    point = 0.0 if knows_point else None
    fitted = mdr.fit_map(
        start, [mdr.MeasuredCurve(force=noisy, indentation=positions)], ["body.young"], contact_point=point
    )
    assert fitted.counts == {"fitted": 1}
    assert abs(fitted["body.young"].values[0] - 3e3) < 5.0 * fitted["body.young_error"].values[0]
    assert fitted["noise"].values[0] == pytest.approx(1e-3 * np.ptp(force), rel=0.2)


def test_maugis_dugdale_of_a_known_range_is_a_family():
    def contact(young, work):
        law = mdr.MaugisDugdale(work, range="100 nm")
        return mdr.Contact(mdr.Paraboloid("5 um"), mdr.Elastic(young, 0.5), adhesion=law)

    curve = curve_of(contact(3e3, 2e-4), 1e-6, 0.05)
    fitted = mdr.fit_map(contact(1e4, 1e-3), [curve], FREE)
    assert any("tables of the forces" in note for note in fitted.notes)
    for name, value in zip(FREE, (3e3, 2e-4), strict=True):
        assert fitted[name].values == pytest.approx(value, rel=1e-3)
    strong = mdr.MaugisDugdale("1 mJ/m^2", strength="2 kPa")
    fixed = dataclasses.replace(contact(1e4, 1e-3), adhesion=strong)
    # a stress that is given does not grow with the modulus
    assert axes_of(fixed, unknowns_of(fixed, FREE)) is None


@pytest.mark.parametrize("work", [None, 2e-5])
@pytest.mark.parametrize("top", [0.6e-6, 2.2e-6])
def test_a_record_beyond_the_profile_is_fitted_up_to_its_end(work, top):
    radii = np.linspace(0.0, 3e-6, 60)
    short = mdr.Sampled(radii, radii**2 / 1e-5)
    adhesion = None if work is None else mdr.JKR(work)
    whole = mdr.Contact(mdr.Paraboloid("5 um"), mdr.Elastic(3e3, 0.5), adhesion=adhesion)
    positions = np.concatenate([np.linspace(-5e-6, top, 200), np.linspace(top, -5e-6, 200)])
    force = mdr.solve(whole, mdr.Path(indentation=positions))["normal_force"].values
    noise = 1e-3 * np.ptp(force) * np.random.default_rng(0).normal(size=positions.size)
    curve = mdr.MeasuredCurve(force=force + noise, indentation=positions)
    start = mdr.Contact(short, mdr.Elastic(1e4, 0.5), adhesion=None if work is None else mdr.JKR(1e-3))
    free = ["body.young"] if work is None else FREE
    fitted = mdr.fit_map(start, [curve], free)
    if top < 1e-6:
        assert fitted.counts == {"fitted": 1}
        assert fitted["body.young"].values == pytest.approx(3e3, rel=3e-3)
        assert mdr.fit(start, curve, free)["body.young"].value == pytest.approx(3e3, rel=3e-3)
    else:
        assert "fitted" not in fitted.counts
        if work is None:
            assert "the profile ends at 1.8 µm" in fitted.notes[0]
        with pytest.raises((ProblemError, PathError), match=r"largest indentation|shows no adhesion"):
            mdr.fit(start, curve, free)


@pytest.mark.parametrize("work", [None, 2e-4])
def test_a_tilt_of_the_baseline_is_recovered_with_the_moduli(work):
    clean = curve_of(contact_of("paraboloid", 3e3, work), 1.5e-6, 0.05)
    tilt = 0.3 * np.ptp(clean.force) / np.ptp(clean.position)
    middle = 0.5 * (clean.position.min() + clean.position.max())
    noise = 0.01 * np.ptp(clean.force) * np.random.default_rng(0).normal(size=(300, clean.force.size))
    drift = tilt * (clean.position - middle)
    curves = [dataclasses.replace(clean, force=clean.force + drift + one) for one in noise]
    start, free = contact_of("paraboloid", 1e4, work and 1e-4), FREE[: 1 if work is None else 2]
    fitted = mdr.fit_map(start, curves, [*free, "tilt"])
    assert fitted.counts == {"fitted": 300}
    true = {"body.young": 3e3, "adhesion.work": work, "contact_point": 0.0, "baseline": 0.0, "tilt": tilt}
    for name in fitted.names:
        off = (fitted[name].values - true[name]) / fitted[f"{name}_error"].values
        # four deviations of a mean and of a share of 300
        assert abs(off.mean()) < 4.0 / math.sqrt(300)
        assert np.mean(np.abs(off) < 1.96) > 0.95 - 4.0 * math.sqrt(0.05 * 0.95 / 300)
    # the spectra of the noise of a map have common information: compare a map of one curve
    single, alone = (
        mdr.fit(start, curves[0], [*free, "tilt"]),
        mdr.fit_map(start, curves[:1], [*free, "tilt"]),
    )
    for name in fitted.names:
        error = float(alone[f"{name}_error"][0])
        assert single[name].value == pytest.approx(float(fitted[name][0]), abs=0.3 * error)
        assert single[name].error == pytest.approx(error, rel=0.1)
    assert mdr.fit(start, curves[0], free).waves > 1.0


def test_a_tilt_has_no_bounds_and_is_looked_for_with_other_numbers():
    curve, start = curve_of(contact_of("paraboloid", 3e3), 1e-6), contact_of("paraboloid", 1e4)
    for fit, record in ((mdr.fit, curve), (mdr.fit_map, [curve])):
        with pytest.raises(ProblemError, match="bounds of tilt"):
            fit(start, record, {"body.young": None, "tilt": ["0 N/m", "1 N/m"]})
        with pytest.raises(ProblemError, match="list every unknown once"):
            fit(start, record, "tilt")
        assert "tilt" in fit(start, record, {"body.young": None, "tilt": None}).summary()


def test_laws_are_compared_with_a_tilt():
    clean = curve_of(contact_of("paraboloid", 3e3), 1e-6)
    drift = 0.3 * clean.force.max() * clean.position / np.ptp(clean.position)
    noise = 1e-3 * clean.force.max() * np.random.default_rng(1).normal(size=drift.size)
    curve = dataclasses.replace(clean, force=clean.force + drift + noise)
    laws = {
        "ball": contact_of("paraboloid", 1e4),
        "cone": mdr.Contact(mdr.Cone(slope=0.5), mdr.Elastic("10 kPa", 0.5)),
    }
    result = mdr.compare_laws(laws, curve, ["body.young", "tilt"])
    assert result.best == "ball"
    assert result["ball"]["body.young"].value == pytest.approx(3e3, rel=0.05)
    assert set(result["cone"].values) >= {"tilt"}
    with pytest.raises(ProblemError, match="has none of the parameters"):
        mdr.compare_laws(laws, curve, ["tilt"])


def test_cores_are_a_number_or_a_client():
    curve, start = curve_of(contact_of("paraboloid", 3e3), 1e-6), contact_of("paraboloid", 1e4)
    for workers in (0, True, 1.5, "2", None):
        with pytest.raises(ProblemError, match="whole number of at least 1"):
            mdr.fit_map(start, [curve], ["body.young"], workers=workers)

    class Client:
        """As one of dask.distributed."""

        def get_executor(self):
            return ThreadPoolExecutor(1)

        def ncores(self):
            return {"here": 1}

    alone, shared = (mdr.fit_map(start, [curve] * 3, ["body.young"], workers=one) for one in (1, Client()))
    xr.testing.assert_identical(alone.data, shared.data)


BLOCKED = """
import sys
sys.modules["numba"] = None
import numpy as np
import pymdr as mdr
depth = np.linspace(-1e-6, 1e-6, 101)
unit = 16 / 9 * np.sqrt(5e-6) * np.maximum(depth, 0.0) ** 1.5
start, young = mdr.Contact(mdr.Paraboloid("5 um"), mdr.Elastic("10 kPa", 0.5)), np.linspace(1e3, 2e3, 70)
curves = [mdr.MeasuredCurve(force=E * unit, indentation=depth) for E in young]
assert abs(mdr.fit(start, curves[0], ["body.young"])["body.young"].value / 1e3 - 1) < 1e-9
print("fitted", flush=True)
for _ in range(2):
    fitted = mdr.fit_map(start, curves, ["body.young"])
    assert np.allclose(fitted["body.young"], young, rtol=1e-9, atol=0.0), fitted
"""


def test_fits_need_no_numba():
    done = subprocess.run([sys.executable, "-c", BLOCKED], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout == "fitted\n"
    assert done.stderr.count("fifty times slower") == 1


def test_the_compiled_search_ends_where_the_array_formulas_do(monkeypatch):
    for work, machine in ((None, None), (2e-4, None), (None, 0.05), (2e-4, 0.05)):
        clean = curve_of(contact_of("paraboloid", 3e3, work), 1e-6, machine)
        noise = 0.01 * np.ptp(clean.force) * np.random.default_rng(0).normal(size=(70, clean.force.size))
        curves = [dataclasses.replace(clean, force=clean.force + one) for one in noise]
        start, free = contact_of("paraboloid", 1e4, work and 1e-3), FREE[: 1 if work is None else 2]
        many = mdr.fit_map(start, curves, free)
        assert many.counts == {"fitted": 70}
        with monkeypatch.context() as patch:
            patch.setattr(request, "_MANY", 1000)
            few = mdr.fit_map(start, curves, free)
        for name in many.names:
            difference = np.abs(many[name].values - few[name].values)
            assert np.all(difference < 1e-3 * few[f"{name}_error"].values)
            assert many[f"{name}_error"].values == pytest.approx(few[f"{name}_error"].values, rel=1e-3)
