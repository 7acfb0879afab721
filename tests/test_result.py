"""Results: reading, units, fields, files, tables."""

import math
import os
import pickle
import re
import sys
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pint
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

import pymdr as mdr
from common import STEEL, UNIT
from drawing import examples
from pymdr.errors import MissingExtraError
from pymdr.presentation.files import write_dataset
from pymdr.solving import batch

UREG = pint.LazyRegistry()
BALL = mdr.Contact(mdr.Sphere("10 mm"), mdr.Elastic("210 GPa", 0.3), mdr.Elastic("70 GPa", 0.22))
KINKED = mdr.Function(lambda r: 0.3 * np.maximum(r - 0.4, 0), [0.4], lambda r: np.where(r > 0.4, 0.3, 0.0))
HOLLOW = mdr.FlatPunch(1.0) + mdr.Function(lambda r: -r * r / 2, derivative=lambda r: -r)

RESULTS = {
    "ball": lambda: mdr.solve(BALL, mdr.load("50 N", steps=3)),
    "timed": lambda: mdr.solve(BALL, mdr.load("50 N", steps=2, duration="1 s") >> mdr.hold("5 s")),
    "arrays": lambda: mdr.solve(BALL, mdr.Path(time=[1.0, 2.0], indentation=["1 um", "-1 um"])),
    "punch": lambda: mdr.solve(
        mdr.Contact(mdr.FlatPunch(1.0) + mdr.Sphere(4.0), UNIT), mdr.indent(0.5, steps=2)
    ),
    "function": lambda: mdr.solve(
        mdr.Contact(mdr.Function(lambda r: 3.0 + r**4), UNIT), mdr.indent(0.2, steps=2)
    ),
    "kinked": lambda: mdr.solve(mdr.Contact(KINKED, UNIT), mdr.indent(0.2)),
    "partly": lambda: mdr.solve(mdr.Contact(HOLLOW, UNIT), mdr.indent(2.0, steps=4)),
    "refused": lambda: mdr.solve(mdr.Contact(HOLLOW, UNIT), mdr.indent(0.5)),
    "lifted": lambda: mdr.solve(BALL, mdr.indent("-1 um")),
    "function_untouched": lambda: mdr.solve(mdr.Contact(mdr.Function(np.square), UNIT), mdr.indent(-0.1)),
    "function_unloaded": lambda: mdr.solve(mdr.Contact(mdr.Function(np.square), UNIT), mdr.load(0.0)),
    "numpy_steps": lambda: mdr.solve(
        BALL, mdr.load("50 N", steps=np.int64(2)) >> mdr.hold(steps=np.int32(1))
    ),
}


@pytest.fixture(scope="module")
def ball():
    return RESULTS["ball"]()


def test_files_without_the_library_of_netcdf_say_what_to_do(ball, tmp_path, monkeypatch):
    ball.save(tmp_path / "ball.nc")
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(
        MissingExtraError, match=r"cannot be imported .* or write a table with Result\.to_csv"
    ):
        ball.save(tmp_path / "again.nc")
    with pytest.raises(MissingExtraError, match="NetCDF files need h5netcdf and h5py"):
        mdr.open_result(tmp_path / "ball.nc")
    assert not (tmp_path / "again.nc").exists()


def same(one, other):
    assert other.data.identical(one.data)
    assert other.path == one.path
    assert other.contact.body == one.contact.body
    assert other.contact.counterbody == one.contact.counterbody
    assert (other.status, other.notes, other.assumptions, other.references) == (
        one.status,
        one.notes,
        one.assumptions,
        one.references,
    )
    assert other.cite() == one.cite()
    assert other.summary() == one.summary()
    assert set(other.claims) == set(one.claims)
    for name, claim in one.claims.items():
        computed = other.claims[name]
        assert (computed.level, computed.reason, computed.source) == (claim.level, claim.reason, claim.source)
        assert computed.where.tolist() == claim.where.tolist()


@pytest.mark.parametrize("name", RESULTS)
def test_saving_and_pickling_keep_everything(name, tmp_path):
    result = RESULTS[name]()
    result.save(tmp_path / "r.nc")
    for other in (mdr.open_result(tmp_path / "r.nc"), pickle.loads(pickle.dumps(result))):
        same(result, other)
        if "function" not in name and name not in ("kinked", "partly", "refused"):
            assert other.contact == result.contact
        if result.claims["pressure"].readable:
            for field in ("pressure", "normal_displacement", "gap"):
                r = np.array([0.1, 0.7, 1.3]) * max(float(np.nanmax(result["contact_radius"])), 1e-6)
                one, two = (res.field(field, r=r, step=-1) for res in (result, other))
                size = np.max(np.abs(one.values[np.isfinite(one.values)]), initial=0.0)
                assert np.isfinite(one.values).tolist() == np.isfinite(two.values).tolist()
                finite = np.isfinite(one.values)
                if name == "function_unloaded":
                    # a function without its derivative is kept to 1e-12 of its value at the last radius, here 1 m
                    size = max(size, 0.1)
                assert np.max(np.abs(one.values[finite] - two.values[finite]), initial=0.0) <= 1e-11 * size
                assert one.attrs == two.attrs
        again = tmp_path / "again.nc"
        other.save(again)
        same(result, mdr.open_result(again))
    assert sorted(p.name for p in tmp_path.iterdir()) == ["again.nc", "r.nc"]


# --- reading ---------------------------------------------------------------------------------------------


def test_quantities_are_labelled_and_carry_units(ball):
    units = {
        "indentation": "m",
        "normal_force": "N",
        "contact_radius": "m",
        "normal_stiffness": "N/m",
        "mean_pressure": "Pa",
        "elastic_energy": "J",
        "force_lower_bound": "N",
    }
    assert {str(name): ball[name].attrs["units"] for name in ball.data} == units
    for name in units:
        assert ball[name].dims == ("step",)
        assert ball[name].dtype == float
        assert ball[name].attrs["long_name"]
        assert ball[name].attrs["symbol"]
    assert RESULTS["timed"]()["time"].attrs["units"] == "s"
    assert RESULTS["punch"]()["edge_amplitude"].attrs["units"] == "Pa*m^0.5"


@pytest.mark.parametrize(
    ("name", "unit", "factor"),
    [
        ("contact_radius", "um", 1e6),
        ("contact_radius", "m", 1.0),
        ("normal_force", "mN", 1e3),
        ("mean_pressure", "GPa", 1e-9),
        ("mean_pressure", "N/mm^2", 1e-6),
        ("elastic_energy", "N*mm", 1e3),
        ("normal_stiffness", "N/um", 1e-6),
    ],
)
def test_other_units(ball, name, unit, factor):
    converted = ball.to(name, unit)
    assert converted.attrs["units"] == unit
    assert converted.values == pytest.approx(factor * ball[name].values, rel=1e-14)
    assert ball[name].attrs["units"] != unit or factor == 1.0


@pytest.mark.parametrize("unit", ["kg", "N", "foo", "m^2", ""])
def test_units_that_do_not_fit(ball, unit):
    with pytest.raises(mdr.UnitError):
        ball.to("contact_radius", unit)


def test_hertz_with_handbook_numbers():
    # 10 mm steel ball on glass under 50 N, Hertz: E* = 55.32 GPa
    compliance = (1 - 0.3**2) / 210e9 + (1 - 0.22**2) / 70e9
    E = 1 / compliance
    hertz = mdr.solve(mdr.Contact(mdr.Paraboloid("10 mm"), BALL.body, BALL.counterbody), mdr.load("50 N"))
    a = (3 * 50 * 0.01 / (4 * E)) ** (1 / 3)
    assert float(hertz["contact_radius"][0]) == pytest.approx(a, rel=1e-13)
    assert float(hertz["indentation"][0]) == pytest.approx(a * a / 0.01, rel=1e-13)
    assert float(hertz.field("pressure", r=0.0)[0]) == pytest.approx(1.5 * 50 / (math.pi * a * a), rel=1e-13)
    assert float(hertz["mean_pressure"][0]) == pytest.approx(50 / (math.pi * a * a), rel=1e-13)
    assert float(hertz["normal_stiffness"][0]) == pytest.approx(2 * E * a, rel=1e-13)
    assert float(hertz["elastic_energy"][0]) == pytest.approx(0.4 * 50 * a * a / 0.01, rel=1e-13)


@pytest.mark.parametrize("name", ["weight", "", "Normal_force", "pressure", "gap", "spring_force"])
def test_quantities_that_do_not_exist(ball, name):
    with pytest.raises(mdr.QuantityError) as caught:
        ball[name]
    assert isinstance(caught.value, KeyError)
    assert not str(caught.value).startswith('"')


NO_NAMES = st.recursive(
    st.none()
    | st.integers()
    | st.floats()
    | st.binary(max_size=3)
    | st.just(np.arange(2))
    | st.just(slice(1)),
    lambda inner: st.lists(inner | st.just("indentation"), max_size=3) | st.dictionaries(st.text(), inner),
    max_leaves=4,
)


@settings(max_examples=examples(60), deadline=None)
@given(name=NO_NAMES)
def test_what_is_no_name(ball, name):
    joint = mdr.Contact(BALL.profile, BALL.body, BALL.counterbody, friction=mdr.Coulomb(0.3))
    named = [
        ball,
        ball.claims,
        mdr.friction_loop(joint, "1 nm", normal_force="1 N"),
        mdr.impact(BALL, mass="1 g", speed="1 mm/s"),
        mdr.thickness_correction(BALL.profile, 0.3, thickness="1 mm", indentation="1 um"),
    ]
    for one in (*(one.__getitem__ for one in named), ball.field):
        with pytest.raises(mdr.QuantityError, match="give one name as text"):
            one(name)


@pytest.mark.parametrize(
    "r",
    [
        lambda: "100 um",
        lambda: 1e-4,
        lambda: 100 * UREG.um,
        lambda: ["0.1 mm"],
        lambda: np.array([1e-4]),
        lambda: np.array([100.0]) * UREG.um,
    ],
)
def test_radii_in_any_form(ball, r):
    r = r()
    p = ball.field("pressure", r=r)
    assert p.dims == ("r",)
    assert p["r"].values == pytest.approx([1e-4], rel=1e-14)
    assert p["r"].attrs["units"] == "m"
    assert p.attrs["units"] == "Pa"
    assert float(p[0]) == pytest.approx(float(ball.field("pressure", r=[1e-4])[0]), rel=1e-12)


@pytest.mark.parametrize("r", ["1 kg", "1,5 mm", [math.nan], "100", [None]])
def test_radii_that_are_refused(ball, r):
    with pytest.raises(mdr.UnitError):
        ball.field("pressure", r=r)


def test_radii_are_one_row(ball):
    with pytest.raises(mdr.PymdrError):
        ball.field("pressure", r=[[1e-4, 2e-4]])


@pytest.mark.parametrize("step", [3, -4, 100])
def test_steps_that_do_not_exist(ball, step):
    with pytest.raises(mdr.QuantityError, match="does not exist: there are 3 steps"):
        ball.field("pressure", step=step)


def test_steps_count_as_in_a_sequence(ball):
    r = [0.0, 5e-5]
    every = ball.field("pressure", r=r, step=None)
    assert every.dims == ("step", "r")
    for step in range(3):
        one = ball.field("pressure", r=r, step=step)
        assert one.values.tolist() == every.values[step].tolist()
        assert int(one["step"]) == step
        assert ball.field("pressure", r=r, step=step - 3).values.tolist() == one.values.tolist()
    assert ball.field("pressure", r=r).values.tolist() == every.values[2].tolist()
    assert every["edge_amplitude"].dims == ("step",)


def test_the_default_grid_reaches_twice_the_contact(ball):
    p = ball.field("pressure")
    a = float(ball["contact_radius"][-1])
    assert p["r"].values[0] == 0.0
    assert p["r"].values[-1] == pytest.approx(2 * a, rel=1e-14)
    assert np.all(np.diff(p["r"].values) > 0)
    assert a in p["r"].values
    assert float(p[0]) == pytest.approx(float(p.max()), rel=1e-14)
    deep = mdr.solve(mdr.Contact(mdr.Sphere(1.0), UNIT), mdr.indent(0.9))
    assert np.isfinite(deep.field("gap").values).all()


def test_the_edge_amplitude_is_a_coordinate(ball):
    result = RESULTS["punch"]()
    p = result.field("pressure", r=[0.5, 1.0, 1.5])
    assert p.values[1:].tolist() == [math.inf, 0.0]
    K = float(p["edge_amplitude"])
    assert pytest.approx(float(result["edge_amplitude"][-1]), rel=1e-15) == K
    near = float(result.field("pressure", r=1 - 1e-12)[0])
    assert near == pytest.approx(K / math.sqrt(1e-12), rel=1e-4)
    assert float(ball.field("pressure")["edge_amplitude"]) == 0.0


# --- tables, words ---------------------------------------------------------------------------------------


def test_tables(ball):
    frame = ball.to_dataframe()
    assert frame.index.tolist() == [0, 1, 2]
    assert set(frame.columns) == {str(name) for name in ball.data}
    assert frame["normal_force"].to_numpy() == pytest.approx([50 / 3, 100 / 3, 50], rel=1e-13)
    assert isinstance(ball.to_xarray(), xr.Dataset)
    assert RESULTS["refused"]().to_dataframe()["force_lower_bound"].to_numpy() == pytest.approx(
        [5 / 3], rel=1e-12
    )


def test_citations_name_what_was_used(ball):
    assert any("Sneddon (1965)" in reference for reference in ball.cite())
    assert not any("Barber" in reference for reference in ball.cite())
    assert any("Barber (1974)" in reference for reference in RESULTS["refused"]().cite())


def test_summaries_say_what_matters(ball):
    text = ball.summary()
    assert str(ball) == text
    for words in ("COMPLETED", "3 steps", "50 N", "EXACT", "normal force", "contact radius", "half-space"):
        assert words in text
    assert "REFUSED" in RESULTS["refused"]().summary()
    assert "offset f(0) = 3 m" in RESULTS["function"]().summary()
    assert repr(ball) == "<pymdr.Result COMPLETED, 3 steps>"
    assert "COMPLETED" in ball._repr_html_()


def test_a_result_is_frozen(ball):
    with pytest.raises(AttributeError):
        ball.status = None


# --- files -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("fraction", [0.0, 0.001, 0.1, 0.5, 0.9, 0.999])
def test_truncated_files(ball, tmp_path, fraction):
    ball.save(tmp_path / "r.nc")
    whole = (tmp_path / "r.nc").read_bytes()
    (tmp_path / "r.nc").write_bytes(whole[: int(fraction * len(whole))])
    with pytest.raises(mdr.FileError, match=r"cannot read .*r\.nc"):
        mdr.open_result(tmp_path / "r.nc")


def test_files_that_are_not_ours(tmp_path):
    (tmp_path / "text.nc").write_text("not a NetCDF file")
    with pytest.raises(mdr.FileError, match="not a complete NetCDF file"):
        mdr.open_result(tmp_path / "text.nc")
    xr.Dataset({"a": ("x", [1.0])}).to_netcdf(tmp_path / "other.nc", engine="h5netcdf")
    with pytest.raises(mdr.FileError, match="not a pymdr result"):
        mdr.open_result(tmp_path / "other.nc")
    for missing in (tmp_path / "none.nc", tmp_path, tmp_path / "text.nc" / "r.nc"):
        with pytest.raises(OSError, match="cannot read"):
            mdr.open_result(missing)


ATTRIBUTES = ["format", "case", "claims", "assumptions", "status", "notes", "references", "rings"]


@pytest.mark.parametrize("attribute", ATTRIBUTES)
@pytest.mark.parametrize("damage", [None, "garbage", "{", "[1]", "{}", 3])
def test_damaged_files(ball, tmp_path, attribute, damage):
    dataset = ball.to_dataset()
    attrs = dict(dataset.attrs)
    if damage is None:
        del attrs[f"pymdr_{attribute}"]
    else:
        attrs[f"pymdr_{attribute}"] = damage
    dataset.attrs = attrs
    dataset.to_netcdf(tmp_path / "r.nc", engine="h5netcdf")
    if (attribute, damage) in (
        ("notes", "{}"),
        ("references", "{}"),
        ("assumptions", "{}"),
        ("notes", "[1]"),
    ):
        return  # an empty list in other words
    with pytest.raises(mdr.FileError):
        mdr.open_result(tmp_path / "r.nc")


def test_files_without_their_quantities(ball, tmp_path):
    ball.to_dataset().drop_vars("contact_radius").to_netcdf(tmp_path / "r.nc", engine="h5netcdf")
    with pytest.raises(mdr.FileError):
        mdr.open_result(tmp_path / "r.nc")
    ball.to_dataset().isel(step=slice(0, 2)).to_netcdf(tmp_path / "s.nc", engine="h5netcdf")
    with pytest.raises(mdr.FileError):
        mdr.open_result(tmp_path / "s.nc")


def test_a_folder_that_cannot_be_written_leaves_nothing(ball, tmp_path):
    (tmp_path / "file").write_text("precious")
    for target in (tmp_path / "file" / "r.nc", tmp_path / "none" / "r.nc", tmp_path):
        with pytest.raises(mdr.FileError, match="cannot write"):
            ball.save(target)
    assert [p.name for p in tmp_path.iterdir()] == ["file"]
    assert (tmp_path / "file").read_text() == "precious"


def test_a_result_of_kept_rows_is_saved_and_opened(tmp_path):
    contact = mdr.Contact(mdr.Sphere("5 mm"), STEEL, friction=mdr.Coulomb(0.3))
    result = mdr.solve(contact, mdr.indent("5 um") >> mdr.shift("1 um", steps=50), keep=10)
    result.save(tmp_path / "kept.nc")
    xr.testing.assert_identical(mdr.open_result(tmp_path / "kept.nc").data, result.data)
    with xr.open_dataset(tmp_path / "kept.nc") as opened:
        assert list(opened.coords) == ["row"]


def test_all_types_of_values_are_written_as_by_xarray(tmp_path):
    ours, other = tmp_path / "ours.nc", tmp_path / "other.nc"
    columns = {
        "yes": ("x", np.array([True, False]), {"units": "1"}),
        "count": ("x", np.array([1, 2])),
        "half": ("x", np.array([0.5, np.nan], dtype="f4")),
        "text": ("x", np.array(["a", "\u00e9t\u00e9"])),
        "object": ("x", np.array(["a", ""], dtype=object)),
        "none": ("y", np.zeros(0)),
        "pymdr_error_one": ((), 0.1),
        "pymdr_error_each": ("x", np.array([0.1, np.nan])),
    }
    coords = {"x": [0.1, 0.2], "row": ("x", [3, 7]), "place": 2.0, "others": ("z", [1.0, 2.0, 3.0])}
    dataset = xr.Dataset(columns, coords=coords, attrs={"title": "all"})
    write_dataset(dataset, ours)
    dataset.to_netcdf(other, engine="h5netcdf")
    with xr.open_dataset(ours) as first, xr.open_dataset(other) as second:
        del first.attrs["pymdr_checksum"]
        xr.testing.assert_identical(first.load(), dataset)
        assert first.dtypes == second.load().dtypes


def test_a_save_that_fails_keeps_the_old_file(ball, tmp_path, monkeypatch):
    target = tmp_path / "r.nc"
    ball.save(target)
    before = target.read_bytes()

    def fail(*args, **kwargs):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(xr.Dataset, "dump_to_store", fail)
    with pytest.raises(mdr.FileError, match="No space left"):
        RESULTS["timed"]().save(target)
    assert target.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["r.nc"]


def test_saving_over_a_result_replaces_it(ball, tmp_path):
    target = tmp_path / "r.nc"
    RESULTS["timed"]().save(target)
    ball.save(str(target))
    same(ball, mdr.open_result(str(target)))


# --- batches and callables -------------------------------------------------------------------------------


def test_a_batch_keeps_its_order_and_its_errors():
    contacts = [mdr.Contact(mdr.Paraboloid(R), mdr.Elastic(0.75, 0.5)) for R in (1.0, 4.0, 9.0)] + [
        mdr.Contact(mdr.Sphere(0.1), UNIT)
    ]
    for workers in (1, 2):
        seen = []
        answers = mdr.solve_batch(
            contacts,
            mdr.indent(0.25),
            workers=workers,
            throw=False,
            progress=lambda *now, seen=seen: seen.append(now),
        )
        forces = [float(answer["normal_force"][0]) for answer in answers[:3]]
        assert forces == pytest.approx([1 / 6, 2 / 6, 3 / 6], rel=1e-13)
        assert isinstance(answers[3], mdr.PathError)
        assert seen == [(i, 4) for i in range(1, 5)]
        with pytest.raises(mdr.PathError):
            mdr.solve_batch(contacts, mdr.indent(0.25), workers=workers)
    assert mdr.solve_batch([], mdr.indent(0.25)) == []


@pytest.mark.parametrize("seed", range(3))
def test_a_batch_does_not_depend_on_its_processes(seed, monkeypatch):
    """Contacts that can be sent, that cannot, and that are refused, in any order, by any number of processes."""
    rng = np.random.default_rng(seed)
    radii = rng.uniform(0.5, 4.0, 20)
    kinds = rng.integers(4, size=20)
    contacts = [
        mdr.Contact(
            mdr.Function(lambda r, R=R: r * r / (2 * R))
            if kind == 0
            else mdr.Sphere(0.1)
            if kind == 1
            else mdr.Paraboloid(R),
            mdr.Elastic(0.75, 0.5),
        )
        for R, kind in zip(radii, kinds, strict=True)
    ]
    monkeypatch.setattr(batch, "_SHORT", 0.0)
    for workers in (1, 2, 3):
        answers = mdr.solve_batch(contacts, mdr.indent(0.25), workers=workers, throw=False)
        for answer, one, R, kind in zip(answers, contacts, radii, kinds, strict=True):
            if kind == 1:
                assert isinstance(answer, mdr.PathError)
                continue
            assert answer.contact is one
            assert float(answer["normal_force"][0]) == pytest.approx(math.sqrt(R) / 6.0, rel=1e-11)


def test_a_short_batch_stays_in_its_process(monkeypatch):
    def refused(*args, **kwargs):
        raise AssertionError("a process was started")

    monkeypatch.setattr("concurrent.futures.ProcessPoolExecutor", refused)
    monkeypatch.setattr(batch, "_SHORT", 1e6)
    contacts = [mdr.Contact(mdr.Paraboloid(R), mdr.Elastic(0.75, 0.5)) for R in np.linspace(1.0, 2.0, 16)]
    assert len(mdr.solve_batch(contacts, mdr.indent(0.25), workers=2)) == 16
    # work that is longer than it seemed is shared
    monkeypatch.setattr(batch, "_SHORT", 0.0)
    with pytest.raises(AssertionError, match="a process was started"):
        mdr.solve_batch(contacts, mdr.indent(0.25), workers=2)


class Deadly:
    """A profile that ends the process that loads it."""

    def __call__(self, r):
        return 0.5 * r * r

    def __reduce__(self):
        return os._exit, (1,)


def test_a_process_that_ends_early_is_one_clear_error():
    contacts = [mdr.Contact(mdr.Function(Deadly()), UNIT)] * 2
    with pytest.raises(mdr.ProblemError, match=r"workers = 2: a worker process ended .*__main__"):
        mdr.solve_batch(contacts, mdr.indent(0.25), workers=2)
    assert len(mdr.solve_batch(contacts, mdr.indent(0.25))) == 2


def test_no_process_is_forked_while_other_threads_run():
    done = threading.Event()
    other = threading.Thread(target=done.wait)
    other.start()
    try:
        assert batch._start_context().get_start_method() != "fork"
    finally:
        done.set()
        other.join()


@pytest.mark.long
def test_batches_give_the_same_while_other_threads_run():
    contacts = [mdr.Contact(mdr.Paraboloid(R), mdr.Elastic(0.75, 0.5)) for R in (1.0, 4.0)]
    with ThreadPoolExecutor(1) as pool:
        answers = pool.submit(mdr.solve_batch, contacts, mdr.indent(0.25), workers=2).result()
    forces = [float(answer["normal_force"][0]) for answer in answers]
    assert forces == pytest.approx([1 / 6, 2 / 6], rel=1e-13)


@pytest.mark.parametrize("workers", [0, -1, 1.5, "2"])
def test_bad_numbers_of_workers(workers):
    with pytest.raises(mdr.PymdrError):
        mdr.solve_batch([BALL], mdr.load(1.0), workers=workers)


def test_a_batch_of_callables_in_processes():
    # a lambda cannot be sent to another process: that is one clear error, or it is solved here
    contacts = [mdr.Contact(mdr.Function(lambda r: r * r / 2), UNIT), mdr.Contact(mdr.Paraboloid(1.0), UNIT)]
    answers = mdr.solve_batch(contacts, mdr.indent(0.25), workers=2, throw=False)
    assert isinstance(answers[0], mdr.PymdrError) or float(answers[0]["normal_force"][0]) == pytest.approx(
        1 / 6, rel=1e-11
    )
    assert float(answers[1]["normal_force"][0]) == pytest.approx(1 / 6, rel=1e-13)


@pytest.mark.parametrize(
    "f",
    [
        lambda r: r**2 + 0j,
        lambda r: "a",
        lambda r: None,
        lambda r: np.array([1.0, 2.0, 3.0]),
        lambda r: r if r > 0.1 else 0.0,
        lambda r: math.cosh(r) - 1,
        lambda r: np.log(r),
        lambda r: 1 / r,
        lambda r: r * math.nan,
        lambda r: 0.0 * r + 3.0,
        lambda r: -r,
        lambda r: -(r**2),
    ],
)
def test_callables_that_are_no_profile(f):
    with pytest.raises(mdr.PymdrError):
        mdr.solve(mdr.Contact(mdr.Function(f), UNIT), mdr.indent(0.1))


def test_an_offset_is_removed_and_said_so():
    for derivative in (None, lambda r: 2 * r):
        result = mdr.solve(
            mdr.Contact(mdr.Function(lambda r: 0.25 + r * r, derivative=derivative), UNIT), mdr.indent(0.1)
        )
        assert result.notes == ("the offset f(0) = 250 mm of the profile was removed",)
        assert float(result["normal_force"][0]) == pytest.approx(4 / 3 * math.sqrt(0.5) * 0.1**1.5, rel=1e-11)
    assert mdr.solve(mdr.Contact(mdr.Function(np.square), UNIT), mdr.indent(0.1)).notes == ()


def test_a_narrow_bump_outside_the_contact_is_seen():
    # r^2/2 with a dip of width 0.02 at r = 5 that stands out by 0.1: the ring touches first
    profile = mdr.Function(lambda r: r**2 / 2 - 12.6 * np.exp(-(((r - 5) / 0.02) ** 2)), max_radius=6.0)
    result = mdr.solve(mdr.Contact(profile, UNIT), mdr.indent(0.2))
    assert result.status is not mdr.Status.COMPLETED
    assert "touch again outside" in result.claims["normal_force"].reason


# --- several rows, notebooks -----------------------------------------------------------------------------


@settings(deadline=None)
@given(st.lists(st.integers(-3, 2), min_size=1, max_size=5))
def test_fields_of_several_rows_are_those_of_each(ball, rows):
    r = [0.0, 1e-5, 1e-3]
    for steps in (rows, tuple(rows), np.array(rows)):
        together = ball.field("pressure", r=r, step=steps)
        assert together.dims == ("step", "r")
        assert together["step"].values.tolist() == [i % 3 for i in rows]
        for i, row in enumerate(rows):
            assert np.array_equal(together[i], ball.field("pressure", r=r, step=row), equal_nan=True)


@pytest.mark.parametrize("step", [[], [0, 5], [[0]], [0.5], "01", [True], np.array([[0]])])
def test_rows_that_do_not_exist(ball, step):
    with pytest.raises(mdr.QuantityError):
        ball.field("pressure", step=step)


def test_notebooks_show_figures_claims_and_questions(ball):
    assert ball.plot()._repr_png_().startswith(b"\x89PNG")
    assert "<table>" in ball.claims._repr_html_()
    result = mdr.assess(ball.contact, ball.path)
    assert result.status is ball.status
    assert "the path reaches" in result._repr_html_()
    assert "<table>" in result.claims._repr_html_()
    assert len(result.plot().axes[0].patches) == len(result.assumptions)
    gel = mdr.Contact(mdr.Paraboloid("1 mm"), mdr.Elastic("1 MPa", 0.5), adhesion=mdr.JKR("50 mJ/m^2"))
    assert "pull-off" in mdr.pull_off(gel)._repr_html_()


# --- peak pressure ---------------------------------------------------------------------------------------


def test_peak_pressure_of_closed_forms():
    ball = mdr.solve(mdr.Contact(mdr.Paraboloid(2.0), mdr.Elastic(3.0, 0.0)), mdr.load(1.0, steps=4))
    hertz = 1.5 * ball["mean_pressure"].values
    assert ball["peak_pressure"].values == pytest.approx(hertz, rel=1e-12)
    assert ball["peak_pressure"].attrs["units"] == "Pa"
    assert ball.to("peak_pressure", "kPa").values == pytest.approx(1e-3 * hertz, rel=1e-12)
    for profile in (mdr.FlatPunch(1.0), mdr.Cone(slope=0.1)):
        sharp = mdr.solve(mdr.Contact(profile, UNIT), mdr.indent(0.01))
        assert sharp["peak_pressure"].values.tolist() == [math.inf]
    lifted = RESULTS["lifted"]()
    assert lifted["peak_pressure"].values.tolist() == [0.0]
    with pytest.raises(mdr.NotValidError):
        RESULTS["refused"]()["peak_pressure"]
    assert np.isnan(RESULTS["partly"]()["peak_pressure"].values[0])
    gel = mdr.Contact(mdr.Paraboloid(1.0), UNIT, adhesion=mdr.JKR(1e-4))
    pressed = mdr.solve(gel, mdr.load(0.01))
    a, modulus = float(pressed["contact_radius"][-1]), 1.0
    r = a * np.sin(np.linspace(0.0, 0.5 * np.pi, 20001))[:-1]
    p = 2.0 * modulus / np.pi * np.sqrt(a * a - r * r) - np.sqrt(2e-4 * modulus / np.pi / a) / np.sqrt(
        1 - (r / a) ** 2
    )
    assert float(pressed["peak_pressure"][-1]) == pytest.approx(p.max(), rel=1e-7)


@settings(max_examples=examples(15), deadline=None)
@given(st.floats(0.0, 0.3), st.floats(1.0, 9.0), st.floats(0.05, 0.4))
def test_peak_pressure_is_above_all_pressures(height, waves, depth):
    wavy = mdr.Function(
        lambda r: r**2 + height / waves**2 * (1.0 - np.cos(waves * r)),
        derivative=lambda r: 2.0 * r + height / waves * np.sin(waves * r),
    )
    result = mdr.solve(mdr.Contact(wavy, UNIT), mdr.indent(depth))
    a = float(result["contact_radius"][-1])
    everywhere = result.field("pressure", r=np.linspace(0.0, a, 3001)).values
    assert float(result["peak_pressure"][-1]) == pytest.approx(everywhere.max(), rel=1e-5)
    assert float(result["peak_pressure"][-1]) >= everywhere.max() * (1.0 - 1e-12)


@settings(max_examples=examples(10), deadline=None)
@given(st.floats(-14.0, -4.0))
def test_a_summary_ends_with_the_last_row_however_small(decades):
    """A summary ends with the row of the path that it is about, however small, and not with 0."""
    ball = mdr.Contact(mdr.Sphere("10 mm"), mdr.Elastic("210 GPa", 0.3))
    small = 1e-5 * 10.0**decades
    text = mdr.solve(ball, mdr.Path(indentation=[1e-5, small])).summary()
    force = next(line for line in text.splitlines() if "normal force" in line)
    assert not re.search(r"\b0 N\b", force)


def test_names_of_quantities_complete_and_attributes_name_the_remedy(tmp_path):
    ball = mdr.Contact(mdr.Sphere("10 mm"), STEEL)
    result = mdr.solve(ball, mdr.load("50 N"))
    assert {"contact_radius", "peak_pressure"} <= set(result._ipython_key_completions_())
    assert not hasattr(result, "contact_radius")
    assert pickle.loads(pickle.dumps(result)).status is result.status
    with pytest.raises(AttributeError, match=re.escape("write result['contact_radius']")):
        result.contact_radius  # noqa: B018
    with pytest.raises(AttributeError, match=re.escape("write result.field('pressure')")):
        result.pressure  # noqa: B018
    with pytest.raises(AttributeError, match=r"no attribute 'radius'$"):
        result.radius  # noqa: B018
    slow = mdr.restitution(ball, mass="30 g", speeds=["0.1 m/s"])
    assert "restitution" in slow._ipython_key_completions_()
    with pytest.raises(AttributeError, match=re.escape("write ['restitution']")):
        pickle.loads(pickle.dumps(slow)).restitution  # noqa: B018


def test_names_in_a_result_are_those_that_can_be_read():
    ball = mdr.Contact(mdr.Sphere("10 mm"), STEEL)
    pressed = mdr.solve(ball, mdr.load("50 N", steps=8))
    curve = mdr.solve(mdr.Contact(pressed.force_curve(), STEEL), mdr.load("20 N", steps=8))
    for result in (pressed, curve):
        assert all(result[name].sizes["step"] == 8 for name in result)
        assert "normal_force" in result
        assert ("peak_pressure" in result) is result.claims["pressure"].readable
        assert not any(name in result for name in ("torque", "contact", 0, None))
    assert "peak_pressure" in pressed
    assert "peak_pressure" not in curve
    slow = mdr.restitution(ball, mass="30 g", speeds=["0.1 m/s", "0.2 m/s"])
    assert all(slow[name].size == 2 for name in slow)
    assert "restitution" in slow
    assert "torque" not in slow
    assert all(name in slow for name in slow.data.variables)


def test_a_result_is_opened_by_the_folder_of_its_run(tmp_path):
    result = mdr.solve(mdr.Contact(mdr.Sphere("10 mm"), STEEL), mdr.load("50 N"))
    result.save(tmp_path / "result.nc")
    assert mdr.open_result(tmp_path).data.equals(result.data)
    (tmp_path / "empty").mkdir()
    with pytest.raises(mdr.PymdrError, match=r"result\.nc"):
        mdr.open_result(tmp_path / "empty")
