"""An exported law in C against the same law in Python, and both against solve."""

import ctypes
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

import pymdr as mdr
from benchmarks.timing import Ratio, median_times
from pymdr.solving.exporting import ContactLaw
from pymdr.solving.stepping import StepperState

DEPTHS = 100_000
TIP = mdr.Contact(mdr.RoundedCone("50 nm", half_angle="65 deg"), mdr.Elastic("70 GPa", 0.2))
SOURCE = """#include "tip.h"
void forces(const double *d, double *f, size_t n);
void forces(const double *d, double *f, size_t n)
{
    size_t i;
    for (i = 0; i < n; ++i)
        f[i] = tip_force(d[i]);
}
"""
COLLISIONS, SPEED, MASS, RADIUS = 20_000, 0.1, 0.033, 0.01
STEEL = mdr.Elastic("210 GPa", 0.3)
PAIR = mdr.Contact(mdr.Paraboloid(RADIUS), STEEL, STEEL, friction=mdr.Coulomb(0.3))
COLLISION = """#include "grain.h"
double collide(double vz, double vx, double h, double m);
double collide(double vz, double vx, double h, double m)
{
    double z = 0.0, x = 0.0, fn = 0.0, fx = 0.0;
    STATE
    do {
        vz -= 0.5 * h * fn / m;
        vx -= 3.5 * 0.5 * h * fx / m;
        z += h * vz;
        x += h * vx;
        FORCES
        vz -= 0.5 * h * fn / m;
        vx -= 3.5 * 0.5 * h * fx / m;
    } while (z > 0.0);
    return vx;
}
double collisions(double vz, double vx, double h, double m, int n);
double collisions(double vz, double vx, double h, double m, int n)
{
    double sum = 0.0;
    int i;
    for (i = 0; i < n; ++i)
        sum += collide(vz, vx * (i % 64) / 32.0, h, m);
    return sum;
}
"""
BY_HAND = (
    "double here = 0.0;",
    """const double a = z > 0.0 ? sqrt(z * RADIUS) : 0.0;
        fn = 4.0 / 3.0 * NORMAL * a * z;
        fx += 2.0 * TANGENTIAL * a * (x - here);
        fx = fx > 0.3 * fn ? 0.3 * fn : fx < -0.3 * fn ? -0.3 * fn : fx;
        here = x;""",
)
RUBBER = mdr.Viscoelastic(mdr.Prony("1 MPa", ["2 MPa", "0.5 MPa"], ["1 ms", "20 ms"]), 0.5)
PAD = mdr.Contact(mdr.Paraboloid(RADIUS), RUBBER)
SPRINGS, BOUNCES, IN_PYTHON = 100, 400, 20
"""Springs with memory, and collisions of the header and of the stepper."""
STICKY = mdr.Contact(
    mdr.Paraboloid("1 mm"),
    mdr.Elastic("40 kPa", 0.5),
    adhesion=mdr.JKR("50 mJ/m^2", work_receding="0.2 J/m^2"),
)
DAMPED = (
    "",
    """const double a = z > 0.0 ? sqrt(z * RADIUS) : 0.0;
        fn = 4.0 / 3.0 * NORMAL * a * z + 2.0 * NORMAL * 1e-3 * a * vz;""",
)
REMEMBERS = ("grain_state s = {0};", "grain_advance(&s, z, h); fn = s.normal_force;")
WALK = """#include "law.h"
double walk(const double *d, int n);
double walk(const double *d, int n)
{
    law_state s = {0};
    double sum = 0.0;
    int i;
    for (i = 0; i < n; ++i) {
        law_advance(&s, d[i]);
        sum += s.normal_force;
    }
    return sum;
}
"""
ALONG = ("grain_state s = {0};", "grain_advance(&s, z, x); fn = s.normal_force; fx = s.tangential_force;")
PLANE = ("grain_state s = {0};", "grain_advance(&s, z, x, 0.0); fn = s.normal_force; fx = s.force[0];")


def compiled(law: ContactLaw, source: str, folder: Path, name: str) -> ctypes.CDLL:
    """A source that includes the header of a law."""
    law.to_c(folder / f"{name}.h")
    (folder / "c.c").write_text(source)
    library = folder / "c.so"
    subprocess.run(
        ["cc", "-std=c99", "-O2", "-shared", "-fPIC", folder / "c.c", "-o", library, "-lm"], check=True
    )
    return ctypes.CDLL(str(library))


def collisions(
    law: ContactLaw, code: tuple[str, str], folder: Path, body: mdr.Elastic = STEEL
) -> Callable[..., float]:
    """Collisions by velocity Verlet, compiled with the forces of a law; laws by hand have the moduli of two bodies."""
    folder.mkdir()
    moduli = mdr.effective_moduli(body, body)
    constants = {"RADIUS": RADIUS, "NORMAL": moduli.normal, "TANGENTIAL": moduli.tangential}
    defined = "".join(f"#define {name} {value!r}\n" for name, value in constants.items())
    source = defined + COLLISION.replace("STATE", code[0]).replace("FORCES", code[1])
    function = compiled(law, source, folder, "grain").collisions
    function.argtypes, function.restype = [ctypes.c_double] * 4 + [ctypes.c_int], ctypes.c_double
    return function


def grains() -> Iterator[Ratio]:
    """Oblique collisions of the exported law against a law written by hand, which forgets."""
    deepest = 1.2 * mdr.impact(PAIR, mass=MASS, speed=SPEED).largest_indentation
    step = mdr.impact(PAIR, mass=MASS, speed=SPEED).contact_time / 100
    line = mdr.export_law(PAIR, deepest, tangential=True)
    plane = mdr.export_law(PAIR, deepest, tangential=True, springs=32)
    with tempfile.TemporaryDirectory() as name:
        kinds = ((line, BY_HAND), (line, ALONG), (plane, PLANE))
        run = [collisions(law, code, Path(name) / str(i)) for i, (law, code) in enumerate(kinds)]
        calls = [lambda f=f: f(SPEED, 0.2 * SPEED, step, MASS, COLLISIONS) for f in run]
        by_hand, along, across = median_times(*calls)
    words = "Hertz-Mindlin by hand in C, one spring with a slider"
    kinds_of_friction = (
        (along, "along a line", "aim 2 times"),
        (across, "in the plane, 32 springs", "no aim"),
    )
    for time, kind, aim in kinds_of_friction:
        text = f"{COLLISIONS:.0e} collisions of the law with friction {kind}"
        yield Ratio(text, words, time, by_hand, aim, f"{time / COLLISIONS * 1e6:.1f} us each")


def bounces(stepper: mdr.Stepper, first: StepperState, step: float, count: int) -> float:
    """Collisions of a ball with memory by the same integrator in Python, each from the first state."""
    total = 0.0
    for _ in range(count):
        stepper.restore(first)
        v, z, force = SPEED, 0.0, 0.0
        while True:
            v -= 0.5 * step * force / MASS
            z += step * v
            force = stepper.advance(z, duration=step).normal
            v -= 0.5 * step * force / MASS
            if z <= 0.0:
                break
        total += v
    return total / count


def pads() -> Iterator[Ratio]:
    """Collisions of a ball that remembers: the header against the stepper, and against a dashpot by hand."""
    hit = mdr.impact(PAD, mass=MASS, speed=SPEED)
    deepest, step = 1.2 * hit.largest_indentation, hit.contact_time / 100
    law, stepper = mdr.export_law(PAD, deepest, springs=SPRINGS), mdr.Stepper(PAD, deepest, springs=SPRINGS)
    first = stepper.state
    with tempfile.TemporaryDirectory() as name:
        ours, by_hand = (
            collisions(law, code, Path(name) / str(i), mdr.Elastic("4 MPa", 0.5))
            for i, code in enumerate((REMEMBERS, DAMPED))
        )
        header, dashpot, python = median_times(
            lambda: ours(SPEED, 0.0, step, MASS, BOUNCES),
            lambda: by_hand(SPEED, 0.0, step, MASS, BOUNCES),
            lambda: bounces(stepper, first, step, IN_PYTHON),
        )
    text = f"a collision of the law with memory, {SPRINGS} springs"
    yield Ratio(text, "the stepper in Python", header / BOUNCES, python / IN_PYTHON, "aim 2 times faster")
    yield Ratio(
        text,
        "Hertz with a dashpot by hand in C, which forgets",
        header / BOUNCES,
        dashpot / BOUNCES,
        "no aim",
    )


def edges() -> Iterator[Ratio]:
    """A walk of an edge that advances, rests and recedes."""
    law, stepper = mdr.export_law(STICKY, "20 um"), mdr.Stepper(STICKY, "20 um")
    rng = np.random.default_rng(3)
    d = np.mod(np.cumsum(rng.normal(0.0, 2e-6, DEPTHS)), 8e-5) - 6e-5
    with tempfile.TemporaryDirectory() as name:
        walk = compiled(law, WALK, Path(name), "law").walk
        walk.argtypes = [np.ctypeslib.ndpointer(dtype=float, flags="C"), ctypes.c_int]
        walk.restype = ctypes.c_double
        depths = d.tolist()
        header, python = median_times(
            lambda: walk(d, DEPTHS), lambda: sum(stepper.advance(each).normal for each in depths)
        )
    text = f"{DEPTHS:.0e} steps of the law with two works of adhesion"
    yield Ratio(text, "the stepper in Python", header, python, "aim 5 times faster")


def ratios() -> Iterator[Ratio]:
    """Forces at many depths, and collisions."""
    if shutil.which("cc") is not None:
        yield from grains()
        yield from pads()
        yield from edges()
    law = mdr.export_law(TIP, "1 um")
    d = 10.0 ** np.random.default_rng(0).uniform(-10, -6, DEPTHS)
    path = mdr.Path(indentation=d)
    note = f"{law.table.knots.u.size} knots, which err by {max(law.errors.values()):.1g}"
    python, solved = median_times(lambda: law.force(d), lambda: mdr.solve(TIP, path))
    yield Ratio(f"{DEPTHS:.0e} forces from knots", "solve", python, solved, "aim 10 times faster", note)
    if shutil.which("cc") is None:
        return
    with tempfile.TemporaryDirectory() as name:
        forces = compiled(law, SOURCE, Path(name), "tip").forces
        pointer = np.ctypeslib.ndpointer(dtype=float, flags="C")
        forces.argtypes = [pointer, pointer, ctypes.c_size_t]
        forces.restype = None
        result = np.empty(DEPTHS)
        in_c, again = median_times(lambda: forces(d, result, DEPTHS), lambda: mdr.solve(TIP, path))
        assert np.allclose(result, law.force(d), rtol=1e-12)
    yield Ratio(f"{DEPTHS:.0e} forces from the header in C", "solve", in_c, again, "aim 50 times faster")
