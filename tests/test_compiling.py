"""Kernels where numba has no place for its cache, is told not to compile, or is missing; threads."""

import math
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from drawing import first_of

SOURCE = Path(__file__).parent.parent / "src"
FRICTION = """
import numpy as np, pymdr as mdr
steel = mdr.Elastic("210 GPa", 0.3)
joint = mdr.Contact(mdr.Paraboloid("10 mm"), steel, steel, friction=mdr.Coulomb(0.3))
path = mdr.load("50 N") >> mdr.cycle(shift="0.8 um", steps=20)
result = mdr.solve(joint, path).data
print(float(result["tangential_force"][-3]), float(result["dissipated_energy"][-1]))
"""
SMOOTHING = """
r = np.linspace(0, 1e-7, 30)
tip = mdr.Sampled(r, r**2 / 2e-7 + 1e-12 * np.cos(50 * r / 1e-7), interpolation=mdr.SmoothingSpline())
print(float(tip.gap(5e-8)))
"""
HISTORY = FRICTION + SMOOTHING


def run(code, **environment):
    kept = {k: v for k, v in os.environ.items() if not k.startswith("NUMBA_")}
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        env={**kept, "PYTHONPATH": str(SOURCE), **environment},
        capture_output=True,
        text=True,
        timeout=500,
    )
    assert done.returncode == 0, done.stderr
    return done


@pytest.fixture(scope="module")
def numbers():
    return [float(x) for x in run(HISTORY).stdout.split()]


def same(done, numbers):
    assert [float(x) for x in done.stdout.split()] == pytest.approx(numbers, rel=1e-12)


@pytest.mark.long
def test_without_a_folder_for_the_cache(numbers, tmp_path):
    """As in an installation that cannot be written, started by a service without HOME; the first call says so."""
    head = "from numba.core import caching\ncaching.CacheImpl._locator_classes = []\n"
    head += "from pymdr import compiling\ncompiling._PATIENCE = 0.0\n"
    # the kernels of smoothing are compiled soonest
    done = run(head + "import numpy as np, pymdr as mdr\n" + SMOOTHING)
    same(done, numbers[2:])
    assert done.stderr.count("set NUMBA_CACHE_DIR") == 1


def test_without_compiling(numbers):
    same(run(HISTORY, NUMBA_DISABLE_JIT="1"), numbers)


OTHERS = """
import numpy as np, pymdr as mdr
rubber = mdr.Viscoelastic(mdr.StandardSolid("1 MPa", "10 MPa", "0.1 s"), poisson=0.5)
path = mdr.indent("10 um", duration="1 s", steps=3) >> mdr.indent("2 um", duration="1 s", steps=3)
path = path >> mdr.indent("12 um", duration="1 s", steps=3)
print(float(mdr.solve(mdr.Contact(mdr.Paraboloid("10 mm"), rubber), path)["normal_force"][-1]))
gel = mdr.Contact(mdr.Paraboloid("50 um"), mdr.Elastic("10 kPa", 0.5))
depth = np.linspace(-1e-6, 2e-6, 60)
force = 0.3e-6 * np.maximum(depth / 1e-6, 0.0) ** 1.5 + 1e-9 * np.cos(50 * depth / 1e-6)
curve = mdr.MeasuredCurve(indentation=depth, force=force)
print(round(mdr.fit(gel, curve, ["body.young"]).values["body.young"].value, 3))
"""


@pytest.mark.long
def test_memory_and_fits_without_compiling():
    plain = run(OTHERS, NUMBA_DISABLE_JIT="1")
    same(plain, [float(x) for x in run(OTHERS).stdout.split()])
    assert "Compiling" not in plain.stderr


@pytest.mark.parametrize(("module", "announced"), [("pymdr.of.any", True), ("elsewhere", False)])
def test_any_kernel_that_is_compiled_says_so_once(module, announced, monkeypatch):
    from numba import njit

    from pymdr import compiling

    messages = []
    log = SimpleNamespace(warning=lambda text, *values: messages.append(text % values))
    monkeypatch.setattr(compiling, "_log", log)
    monkeypatch.setattr(compiling, "_PATIENCE", 0.0)

    @njit
    def inner(x):
        return x + 1.0

    def kernel(x):
        return 2.0 * x + inner(0.0)

    inner.py_func.__module__ = kernel.__module__ = module
    monkeypatch.setattr(compiling._listener, "announced", False)
    assert njit(kernel)(1.0) == 3.0
    assert njit(kernel, fastmath=True)(1.0) == 3.0
    assert [text.partition(" (up to 20 s in all, ")[0] for text in messages] == [
        "Compiling of.any.kernel"
    ] * announced


def test_every_kernel_has_a_subject_in_messages():
    from pymdr.compiling import _described

    modules = [
        ".".join(file.relative_to(SOURCE / "pymdr").with_suffix("").parts)
        for file in (SOURCE / "pymdr").rglob("*.py")
        if "from pymdr.compiling import" in file.read_text(encoding="utf-8")
    ]
    assert len(modules) > 20
    assert [
        one for one in modules if not _described(f"{one}.kernel").startswith("numerical kernels of")
    ] == []


ONCE = """
import pymdr as mdr
from pymdr.line.memory import kernels, row_kernels, tangential_kernels, groups
from pymdr.numerics import exponentials
rubber = mdr.Viscoelastic(mdr.StandardSolid("1 MPa", "10 MPa", "0.1 s"), poisson=0.5)
joint = mdr.Contact(mdr.Paraboloid("10 mm"), rubber, friction=mdr.Coulomb(0.3))
path = mdr.load("1 N", duration="1 s", steps=3) >> mdr.cycle(shift="1 um", duration="1 s", steps=8)
mdr.solve(joint, path >> mdr.indent("10 um", duration="1 s"))
for module in (kernels, row_kernels, tangential_kernels, groups, exponentials):
    for name, kernel in vars(module).items():
        print(name, len(getattr(kernel, "signatures", ())))
"""


@pytest.mark.long
def test_kernels_of_memory_are_compiled_once(tmp_path):
    """A constant that one kernel hands to another compiles it once more, and all that it calls."""
    counts = dict(line.split() for line in run(ONCE, NUMBA_CACHE_DIR=str(tmp_path)).stdout.splitlines())
    # the path has indentations and loads
    assert (counts["follow"], counts["shear"]) == ("1", "1")
    assert {name: times for name, times in counts.items() if int(times) > 1} == {}


BLOCKED = """
import sys
sys.modules["numba"] = None
"""
MEMORY = """
import pymdr as mdr
rubber = mdr.Viscoelastic(mdr.StandardSolid("1 MPa", "10 MPa", "0.1 s"), poisson=0.5)
soft = mdr.Contact(mdr.Paraboloid("10 mm"), rubber)
path = mdr.indent("10 um", duration="1 s", steps=3) >> mdr.indent("2 um", duration="1 s", steps=3)
print(float(mdr.solve(soft, path)["normal_force"][-1]))
print(float(mdr.impact(soft, mass="10 g", speed="0.1 m/s", steps=8).restitution))
"""


def without_numba(code):
    plain = run(BLOCKED + code)
    assert plain.stderr.count("plain Python") == 1
    return plain


@pytest.mark.long
def test_memory_and_impact_without_numba():
    same(without_numba(MEMORY), [float(x) for x in run(MEMORY).stdout.split()])


SMALL = """
import math
import sys
for name in BLOCKED:
    sys.modules[name] = None
import numpy as np, pymdr as mdr
ball, steel, gel = mdr.Paraboloid("10 mm"), mdr.Elastic("210 GPa", 0.3), mdr.Elastic("30 kPa", 0.5)
hertz = mdr.solve(mdr.Contact(ball, steel), mdr.load("50 N", steps=3))
print(float(hertz["contact_radius"][-1]))
hertz.plot().savefig("hertz.png")
tip = mdr.Paraboloid("50 um")
print(float(mdr.pull_off(mdr.Contact(tip, gel, adhesion=mdr.JKR("2 mJ/m^2"))).normal_force))
print(mdr.impact(mdr.Contact(ball, steel), mass="30 g", speed="0.1 m/s", steps=8).contact_time)
maugis = mdr.Contact(tip, gel, adhesion=mdr.MaugisDugdale("2 mJ/m^2", range="200 nm"))
print(float(mdr.solve(maugis, mdr.indent("1 um", steps=1))["normal_force"][-1]))
thin = mdr.Contact(tip, mdr.Elastic("30 kPa", 0.5, thickness="100 um"))
print(float(mdr.solve(thin, mdr.indent("1 um", steps=1)).claims["normal_force"].error[-1]))
joint = mdr.Contact(ball, steel, steel, friction=mdr.Coulomb(0.3))
loop = mdr.solve(joint, mdr.load("50 N") >> mdr.cycle(shift="0.8 um", steps=8))
print(float(loop["dissipated_energy"][-1]))
rubber = mdr.Viscoelastic(mdr.StandardSolid("1 MPa", "10 MPa", "0.1 s"), poisson=0.5)
path = mdr.indent("10 um", duration="1 s", steps=1) >> mdr.indent("8 um", duration="0.2 s", steps=1)
print(float(mdr.solve(mdr.Contact(ball, rubber), path)["normal_force"][-1]))
hertz.to_csv("hertz.csv")
try:
    hertz.save("hertz.nc")
except (ImportError, mdr.FileError) as error:
    assert "h5" in str(error), error
"""


def test_without_what_small_systems_lack(tmp_path, monkeypatch, capsys):
    """As where numba, h5py and typer cannot be had: closed forms, and the numbers of an installation that has them."""
    monkeypatch.chdir(tmp_path)
    missing = "('numba', 'h5py', 'h5netcdf', 'typer', 'rich')"
    done = run(SMALL.replace("BLOCKED", missing))
    assert done.stderr.count("plain Python") == 1
    results = [float(x) for x in done.stdout.split()]
    assert (tmp_path / "hertz.png").stat().st_size > 10_000
    assert (tmp_path / "hertz.csv").exists()
    modulus, radius = 210e9 / (1 - 0.3**2), 10e-3
    deepest = (15 * 30e-3 * 0.1**2 / (16 * modulus * math.sqrt(radius))) ** 0.4
    duration = 4 * math.sqrt(math.pi) * math.gamma(0.4) / (5 * math.gamma(0.9)) * deepest / 0.1
    # Hertz (1882), Johnson, Kendall and Roberts (1971) at a fixed indentation, and Hertz's impact
    closed = [(3 * 50 * radius / (4 * modulus)) ** (1 / 3), -5 / 6 * math.pi * 2e-3 * 50e-6, duration]
    assert results[:3] == pytest.approx(closed, rel=1e-12)
    exec(SMALL.replace("BLOCKED", "()"), {})
    assert results == pytest.approx([float(x) for x in capsys.readouterr().out.split()], rel=1e-11)


THREADS = """
import threading
import pymdr
barrier, failures = threading.Barrier(8), []
def work():
    barrier.wait()
    try:
        import pymdr as mdr
        {code}
    except BaseException as error:
        failures.append(repr(error))
threads = [threading.Thread(target=work) for _ in range(8)]
[thread.start() for thread in threads]
[thread.join() for thread in threads]
assert not failures, failures
"""


@pytest.mark.parametrize(
    "code",
    first_of(
        [
            "mdr.Sphere('10 mm'); mdr.Elastic('210 GPa', 0.3); mdr.Cone(half_angle='70 deg')",
            "mdr.solve(mdr.Contact(mdr.Sphere('10 mm'), mdr.Elastic('1 GPa', 0.3)), mdr.load('1 N'))._repr_html_()",
            "mdr.pull_off(mdr.Contact(mdr.Sphere('1 mm'), mdr.Elastic('1 MPa', 0.3), adhesion=mdr.JKR('50 mJ/m^2')))",
        ]
    ),
)
def test_threads_that_begin_together(code):
    for _ in range(2):
        run(THREADS.format(code=code))


WATCHED = """
import importlib, pathlib, types
import pymdr
from pymdr import compiling
root = pathlib.Path(pymdr.__file__).parent
folder = lambda file: pathlib.Path(file).parent
watched, kernels, stamp_of, compiled = {}, [], compiling.stamp_of, compiling.compiled
def stamped(*modules):
    stamp = stamp_of(*modules)
    watched[stamp] = {folder(module) for module in modules}
    return stamp
def kept(function, stamp=None, **options):
    kernel = compiled(function, stamp, **options)
    kernels.append((kernel, stamp, "no_cpython_wrapper" in options))
    return kernel
compiling.stamp_of, compiling.compiled = stamped, kept
for file in root.rglob("*.py"):
    if "pymdr.compiling import" in file.read_text() or "import compiling" in file.read_text():
        importlib.import_module(".".join(("pymdr", *file.relative_to(root).with_suffix("").parts)))
def called(kernel, known):
    scope, names = kernel.py_func.__globals__, kernel.py_func.__code__.co_names
    for value in [scope.get(name) for name in names]:
        inside = [getattr(value, name, None) for name in names] if isinstance(value, types.ModuleType) else [value]
        for each in inside:
            if hasattr(each, "py_func") and each not in known:
                known.append(each)
                called(each, known)
    return known
for kernel, stamp, is_inner in kernels:
    home = folder(kernel.py_func.__code__.co_filename)
    places = {folder(each.py_func.__code__.co_filename) for each in called(kernel, [])}
    places = {place for place in places if not place.is_relative_to(root / "numerics")}
    for place in () if is_inner else places - watched.get(stamp, {home}):
        print(kernel.py_func.__module__, kernel.py_func.__name__, place)
print(len(kernels))
"""


def test_kernels_are_compiled_again_where_what_they_call_has_changed():
    lines = run(WATCHED).stdout.splitlines()
    assert lines[:-1] == []
    assert int(lines[-1]) > 100
