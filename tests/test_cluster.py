"""Work on a cluster of processes: the numbers of one process, also where a worker is killed."""

import os
import signal
import sys

import numpy as np
import pytest
import xarray as xr

import pymdr as mdr
from pymdr.solving.workers import in_order

BALL = mdr.Contact(mdr.Paraboloid("1 mm"), mdr.Elastic("1 MPa", 0.5))
OVER = {"profile.radius": np.geomspace(1e-4, 1e-2, 40), "body.young": ["1 MPa", "3 MPa"]}
SURFACE = mdr.RoughSurface(hurst=0.8, rms="1 um", size="1 mm", shortest="125 um")


@pytest.fixture(scope="module")
def client():
    distributed = pytest.importorskip(
        "distributed", reason="distributed, of the extra cluster, is not installed"
    )
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as connected,
    ):
        yield connected


def killed_once(folder, i):
    """The square of a number; the process that is asked for 3 first is killed."""
    mark = folder / "killed"
    if i == 3 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return i * i


def kills(i):
    """End the process that is asked."""
    os.kill(os.getpid(), signal.SIGKILL)


def test_a_sweep_gives_the_same_numbers(client, tmp_path):
    here = mdr.sweep(BALL, mdr.indent("1 um", steps=3), OVER)
    there = mdr.sweep(BALL, mdr.indent("1 um", steps=3), OVER, workers=client, folder=tmp_path)
    for name in here.data:
        assert np.array_equal(here[name].values, there[name].values), name


def test_a_batch_keeps_its_order_its_errors_and_its_functions(client):
    contacts = [
        mdr.Contact(mdr.Function(lambda r, R=R: r**2 / R), mdr.Elastic(1e6, 0.5)) for R in (1e-3, 2e-3)
    ]
    contacts.insert(1, mdr.Contact(mdr.ConcavePunch("1 mm", "1 mm"), mdr.Elastic(1e6, 0.5)))
    path = mdr.indent("1 um")
    here = mdr.solve_batch(contacts, path, throw=False)
    there = mdr.solve_batch(contacts, path, throw=False, workers=client)
    for one, other in zip(here, there, strict=True):
        assert type(one) is type(other)
        if isinstance(one, mdr.Result):
            xr.testing.assert_identical(one.data, other.data)
            assert other.path == one.path


def test_rough_lines_and_their_calibration_give_the_same_numbers(client):
    steel = mdr.Elastic("210 GPa", 0.3)
    lines = [
        mdr.press_rough(SURFACE, steel, normal_force=["1 N", "10 N"], realisations=5, workers=workers)
        for workers in (1, client)
    ]
    assert np.array_equal(lines[0]["normal_stiffness"], lines[1]["normal_stiffness"])
    pytest.importorskip("ContactMechanics")
    results = [
        mdr.calibrate_coefficient(SURFACE, realisations=2, workers=workers).coefficient
        for workers in (1, client)
    ]
    assert results[0] == pytest.approx(results[1], rel=1e-12)


def test_a_killed_worker_loses_nothing(client, tmp_path):
    import functools

    assert list(in_order(functools.partial(killed_once, tmp_path), range(8), client)) == [
        i * i for i in range(8)
    ]
    assert (tmp_path / "killed").exists()


def killed_at_its_second_part(mark):
    """A plugin of dask workers that kills the first process that begins a second part."""
    from distributed import WorkerPlugin

    class Killed(WorkerPlugin):
        name = "killed"

        def setup(self, worker):
            self.started = 0

        def transition(self, key, start, finish, **more):
            self.started += finish == "executing"
            if self.started == 2 and not mark.exists():
                mark.touch()
                os.kill(os.getpid(), signal.SIGKILL)

    return Killed()


def force_curves():
    """Noisy Hertz curves, three parts of a map."""
    depth = np.linspace(0.0, 1e-6, 1000)
    force = 0.1 * depth**1.5 + 1e-12 * np.random.default_rng(0).standard_normal((1500, depth.size))
    return xr.Dataset({"force": (("y", "sample"), force), "indentation": ("sample", depth)})


def swept(workers, folder):
    return mdr.sweep(BALL, mdr.indent("1 um", steps=3), OVER, workers=workers, folder=folder).data


def fitted(workers, folder):
    return mdr.fit_map(BALL, force_curves(), ["body.young"], workers=workers, folder=folder).data


def pressed(workers, folder):
    steel = mdr.Elastic("210 GPa", 0.3)
    return mdr.press_rough(SURFACE, steel, normal_force=[1.0, 10.0], realisations=8, workers=workers).data


def calibrated(workers, folder):
    pytest.importorskip("ContactMechanics")
    result = mdr.calibrate_coefficient(SURFACE, realisations=4, workers=workers)
    return xr.Dataset({"coefficient": result.coefficient})


def judged(workers, folder):
    from tests import accuracy

    study = accuracy.study(
        5, 8, workers, effort=accuracy.QUICK, kinds=("profiles", "friction"), folder=folder
    )
    return xr.Dataset({"value": ("value", [v.value for outcome in study.outcomes for v in outcome.values])})


@pytest.mark.parametrize("work", [swept, fitted, pressed, calibrated, judged])
def test_a_worker_that_is_killed_midway_changes_no_number(client, work, tmp_path):
    client.register_plugin(killed_at_its_second_part(tmp_path / "killed"))
    try:
        there = work(client, tmp_path / "there")
    finally:
        client.unregister_worker_plugin("killed")
    assert (tmp_path / "killed").exists()
    xr.testing.assert_identical(there, work(1, tmp_path / "here"))


def test_a_part_that_kills_every_worker_is_an_error_in_words(client):
    with pytest.raises(mdr.ProblemError, match="the cluster abandoned a part of the work"):
        list(in_order(kills, range(1), client))


def test_a_process_of_this_machine_that_ends_is_an_error_in_words():
    with pytest.raises(mdr.ProblemError, match="a worker process ended without an answer"):
        list(in_order(kills, range(4), 2))


def test_the_shell_takes_the_address_of_a_scheduler(client, tmp_path):
    from typer.testing import CliRunner

    from pymdr.workbench.cli import app

    case = tmp_path / "case.toml"
    case.write_text(
        '[profile]\nkind = "sphere"\nradius = "1 mm"\n[body]\nkind = "elastic"\nyoung = "1 MPa"\npoisson = 0.5\n'
        '[[path]]\nkind = "indent"\nindentation = "1 um"\n'
    )
    over = ["--over", "body.young = 1 MPa, 2 MPa"]
    address = client.scheduler.address
    for options in ([], ["--cluster", address]):
        run = CliRunner().invoke(
            app, ["sweep", str(case), *over, *options, "-o", str(tmp_path / f"of{len(options)}")]
        )
        assert run.exit_code == 0, run.output
    one, other = (xr.open_dataset(tmp_path / name / "sweep.nc") for name in ("of0", "of2"))
    assert np.array_equal(one["normal_force"], other["normal_force"])


def test_the_study_of_random_problems_takes_the_address_of_a_scheduler(client, tmp_path, monkeypatch):
    from tests import accuracy

    options = ["--quick", "--seed", "5", "--count", str(len(accuracy.KINDS)), "--folder", str(tmp_path)]
    monkeypatch.setattr(sys, "argv", ["accuracy", *options, "--cluster", client.scheduler.address])
    accuracy.main()
    here = accuracy.study(5, len(accuracy.KINDS), effort=accuracy.QUICK, kinds=accuracy.KINDS)
    there = accuracy.study(5, 0, effort=accuracy.QUICK, kinds=accuracy.KINDS, folder=tmp_path)
    assert [o.values for o in there.outcomes] == [o.values for o in here.outcomes]


def test_an_address_without_a_scheduler(tmp_path, monkeypatch):
    from pymdr.workbench.cli.options import at_work

    pytest.importorskip("distributed", reason="distributed, of the extra cluster, is not installed")
    with (
        pytest.raises(mdr.ProblemError, match="no scheduler answers; start one with `dask scheduler`"),
        at_work(1, "tcp://127.0.0.1:9"),
    ):
        pass


def test_a_cluster_without_dask(monkeypatch):
    from pymdr.workbench.cli.options import at_work

    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ImportError, match=r"pip install 'pymdr\[cluster\]'"), at_work(1, "tcp://node:8786"):
        pass
