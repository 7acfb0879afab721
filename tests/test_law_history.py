"""What contacts remember in exported headers: random histories against the stepper, merged vertices, restarts, JKR, refusals."""

import ctypes
import math
import shutil
import subprocess

import numpy as np
import pytest
from tests.drawing import first_of

import pymdr as mdr

needs_c = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler (cc) on this machine")
WARNINGS = ["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wsign-conversion", "-Wshadow", "-Werror"]
STEEL = mdr.Elastic("210 GPa", 0.3)
DEEPEST = 1e-5
SOURCE = """#include <string.h>
#include "law.h"
#include "law.h"
#ifdef __cplusplus
extern "C" {
#endif
size_t size_of_state(void);
size_t steps(void *bytes, const double *d, const double *u, double *out, size_t n);
#ifdef __cplusplus
}
#endif
size_t size_of_state(void) { return sizeof(law_state); }
size_t steps(void *bytes, const double *d, const double *u, double *out, size_t n)
{
    law_state s;
    size_t i;
    memcpy(&s, bytes, sizeof s);
    for (i = 0; i < n; ++i) {
        if (ADVANCE)
            break;
        WRITE
    }
    (void)u;
    memcpy(bytes, &s, sizeof s);
    return i;
}
"""
ALONG = (
    "law_advance(&s, d[i], u[i])",
    "out[4 * i] = s.normal_force; out[4 * i + 1] = s.tangential_force; out[4 * i + 2] = law_tangential_error(&s); "
    "out[4 * i + 3] = law_tangential_stiffness(&s);",
)
TOUCHING = (
    "law_advance(&s, d[i])",
    "out[4 * i] = s.normal_force; out[4 * i + 1] = s.dissipated_energy; out[4 * i + 2] = s.jumps; out[4 * i + 3] = s.touches;",
)


class InC:
    """The state of one contact in a compiled header, as bytes."""

    def __init__(self, law, folder, calls, compiler="cc", flags=()):
        (folder / "law.h").write_text(law.c_header("law"))
        source = folder / ("law.c" if compiler == "cc" else "law.cpp")
        source.write_text(SOURCE.replace("ADVANCE", calls[0]).replace("WRITE", calls[1]))
        standard = "-std=c99" if compiler == "cc" else "-std=c++11"
        library = folder / f"{source.suffix[1:]}.so"
        subprocess.run(
            [compiler, standard, *WARNINGS, *flags, "-O2", "-shared", "-fPIC", source, "-o", library, "-lm"],
            check=True, capture_output=True, text=True,
        )  # fmt: skip
        code = ctypes.CDLL(str(library))
        code.size_of_state.restype = code.steps.restype = ctypes.c_size_t
        pointer = np.ctypeslib.ndpointer(dtype=float, flags="C")
        code.steps.argtypes = [ctypes.c_char_p, pointer, pointer, pointer, ctypes.c_size_t]
        self.run, self.bytes = code.steps, ctypes.create_string_buffer(code.size_of_state())

    def advance(self, depth, shift):
        """The rows that were taken."""
        d, u = (np.ascontiguousarray(each, dtype=float) for each in (depth, shift))
        out = np.zeros((d.size, 4))
        taken = self.run(self.bytes, d, u, out, d.size)
        return out[:taken]


def ball(profile, friction=0.3):
    return mdr.Contact(profile, STEEL, STEEL, friction=mdr.Coulomb(friction))


def random_moves(seed, size):
    """Walks with steps of all sizes, and losses of the contact."""
    rng = np.random.default_rng(seed)
    depth = np.abs(np.mod(np.cumsum(rng.normal(0.0, 0.02 * DEEPEST, size)), 2.0 * DEEPEST) - DEEPEST)
    depth[rng.random(size) < 0.003] = -0.1 * DEEPEST
    return depth, np.cumsum(rng.normal(0.0, 0.01 * DEEPEST, size) * 10.0 ** rng.integers(-3, 1, size))


def followed(contact, depth, shift):
    stepper = mdr.Stepper(contact, DEEPEST)
    moves = zip(depth.tolist(), shift.tolist(), strict=True)
    return np.array([(*stepper.advance(*move), stepper.tangential_stiffness) for move in moves])


CASES = [
    (mdr.Paraboloid("10 mm"), 0.3),
    (mdr.Paraboloid("10 mm"), 1.0),
    (mdr.Sphere("10 mm"), 0.05),
    (mdr.Sphere("10 mm"), 1.0),
    (mdr.RoundedFlat("1 mm", "10 mm"), 0.3),
    (mdr.FlatPunch("1 mm"), 0.3),
    (mdr.Cone(slope=0.01), 0.3),
]


IN_PLANE = (
    "law_advance(&s, d[i], u[2 * i], u[2 * i + 1])",
    "out[4 * i] = s.normal_force; out[4 * i + 1] = s.force[0]; out[4 * i + 2] = s.force[1]; out[4 * i + 3] = s.t[0][0];",
)


@needs_c
@pytest.mark.parametrize("case", first_of([*CASES[:4], CASES[6]]))
@pytest.mark.parametrize("compiler", first_of(["cc", "c++"]))
def test_histories_in_the_plane_in_c_are_those_of_the_stepper(case, compiler, tmp_path):
    contact, n = ball(*case), 2000
    law = mdr.export_law(contact, DEEPEST, tangential=True, springs=16)
    depth, x = random_moves(3, n)
    y = random_moves(4, n)[1]
    for values in (depth, x, y):  # the same place again, and the same line
        values[100:120], values[200:220] = values[100], 0.3 * DEEPEST * np.linspace(0.1, 1.0, 20)
    code = InC(law, tmp_path, IN_PLANE, compiler)
    computed = np.zeros((n, 4))
    assert (
        code.run(code.bytes, depth, np.ascontiguousarray(np.column_stack([x, y]).ravel()), computed, n) == n
    )
    stepper = mdr.Stepper(contact, DEEPEST, springs=16)
    moves = zip(depth.tolist(), x.tolist(), y.tolist(), strict=True)
    expected = np.array([stepper.advance(d, (u, v)) for d, u, v in moves])
    size = np.abs(expected).max()
    assert computed[:, 0] == pytest.approx(expected[:, 0], abs=law.errors["normal_force"] * size)
    assert computed[:, 1:3] == pytest.approx(expected[:, 1:], abs=1e-12 * np.abs(expected[:, 1:]).max())
    assert len(code.bytes.raw) == 48 + 16 * 16


@needs_c
def test_a_plane_that_turns_in_c(tmp_path):
    calls = (
        "law_advance(&s, d[i], u[i], 0.0)",
        "law_rotate(&s, 0.5); out[4 * i] = s.force[0]; out[4 * i + 1] = s.force[1];",
    )
    code = InC(mdr.export_law(ball(*CASES[0]), DEEPEST, tangential=True, springs=16), tmp_path, calls)
    depth, shift = random_moves(5, 200)
    computed = code.advance(depth, shift)
    stepper = mdr.Stepper(ball(*CASES[0]), DEEPEST, springs=16)
    expected = []
    for move in zip(depth.tolist(), shift.tolist(), strict=True):
        stepper.advance(move[0], (move[1], 0.0))
        stepper.rotate(0.5)
        expected.append(stepper.tangential_force)
    assert computed[:, :2] == pytest.approx(np.array(expected), abs=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize(
    ("options", "words"),
    [({"springs": 32}, "give tangential=True"), ({"springs": 4, "tangential": True}, "from 8 to 4096")],
)
def test_springs_that_are_refused(options, words):
    with pytest.raises(mdr.ProblemError, match=words):
        mdr.export_law(ball(*CASES[0]), DEEPEST, **options)
    with pytest.raises(mdr.ProblemError, match="finite coefficient of friction in headers"):
        mdr.export_law(ball(CASES[0][0], math.inf), DEEPEST, tangential=True, springs=32)


@needs_c
@pytest.mark.parametrize("case", first_of(CASES))
def test_histories_in_c_are_those_of_the_stepper(case, tmp_path):
    contact = ball(*case)
    law = mdr.export_law(contact, DEEPEST, tangential=True)
    for seed in range(2):
        depth, shift = random_moves(seed, 2000)
        computed, expected = InC(law, tmp_path, ALONG).advance(depth, shift), followed(contact, depth, shift)
        normal, tangential, stiffness = (np.abs(each).max() for each in expected.T)
        assert computed[:, 0] == pytest.approx(
            expected[:, 0], rel=law.errors["normal_force"], abs=1e-14 * normal
        )
        error = np.abs(computed[:, 1] - expected[:, 1])
        assert (error <= computed[:, 2] + 1e-12 * tangential).all()
        # the bound is honest and not far: sums of errors of one sign
        assert computed[:, 2].max() < 300.0 * law.errors["normal_force"] * tangential + 1e-4 * tangential
        same = np.abs(computed[:, 3] - expected[:, 2]) < 2e-6 * stiffness
        assert np.count_nonzero(~same) < 0.01 * same.size


@needs_c
@pytest.mark.parametrize("profile", first_of([case[0] for case in (CASES[0], *CASES[4:])]))
@pytest.mark.parametrize("capacity", first_of([64, 3]))
def test_histories_without_slip_in_c_are_those_of_the_stepper(profile, capacity, tmp_path):
    contact = ball(profile, math.inf)
    law = mdr.export_law(contact, DEEPEST, tangential=True)
    depth, shift = random_moves(7, 2000)
    depth[::9], shift[::5] = (
        np.append(depth[0], depth[8:-1:9]),
        np.append(shift[0], shift[4:-1:5]),
    )  # stays of either
    computed = InC(law, tmp_path, ALONG, flags=[f"-DLAW_CAPACITY={capacity}"]).advance(depth, shift)
    expected = followed(contact, depth, shift)
    normal, tangential, stiffness = (np.abs(each).max() for each in expected.T)
    assert computed[:, 0] == pytest.approx(expected[:, 0], rel=law.errors["normal_force"], abs=1e-14 * normal)
    error = np.abs(computed[:, 1] - expected[:, 1])
    assert (error <= computed[:, 2] + 1e-12 * tangential).all()
    assert computed[:, 3] == pytest.approx(
        expected[:, 2], rel=law.errors["normal_stiffness"], abs=1e-14 * stiffness
    )
    if capacity == 64:
        assert error.max() < 1e-4 * tangential


@needs_c
def test_depths_next_to_nothing_leave_numbers(tmp_path):
    contact = ball(mdr.Paraboloid("10 mm"), math.inf)
    least = math.ulp(0.0)
    depth, shift = np.array([least, DEEPEST, least, 0.5 * DEEPEST]), 1e-6 * np.arange(1.0, 5.0)
    law = mdr.export_law(contact, DEEPEST, tangential=True)
    computed, expected = InC(law, tmp_path, ALONG).advance(depth, shift), followed(contact, depth, shift)
    assert (np.abs(computed[:, 1] - expected[:, 1]) <= computed[:, 2] + 1e-12 * expected[-1, 1]).all()


@needs_c
def test_a_stack_of_two_vertices_does_not_compile(tmp_path):
    law = mdr.export_law(ball(mdr.FlatPunch("1 mm")), DEEPEST, tangential=True)
    with pytest.raises(subprocess.CalledProcessError) as refused:
        InC(law, tmp_path, ALONG, flags=["-DLAW_CAPACITY=2"])
    assert "at least 3 vertices" in refused.value.stderr


@needs_c
def test_a_full_stack_merges_and_counts_the_error(tmp_path):
    """Ever smaller swings add two vertices each: far more than there is room for."""
    contact = ball(mdr.Paraboloid("10 mm"))
    in_c = InC(mdr.export_law(contact, DEEPEST, tangential=True), tmp_path, ALONG)
    swing = 1e-6 * 0.97 ** np.arange(200) * np.where(np.arange(200) % 2, 1.0, -1.0)
    depth, shift = np.full(201, 0.5 * DEEPEST), np.append(0.0, swing)
    computed, expected = in_c.advance(depth, shift), followed(contact, depth, shift)
    error, largest = np.abs(computed[:, 1] - expected[:, 1]), np.abs(expected[:, 1]).max()
    assert (error <= computed[:, 2] + 1e-12 * largest).all()
    assert 1e-9 * largest < error.max() < 1e-4 * largest
    assert computed[-1, 2] < 1e-2 * largest
    folder = tmp_path / "long"
    folder.mkdir()
    long = InC(mdr.export_law(contact, DEEPEST, tangential=True), folder, ALONG, flags=["-DLAW_CAPACITY=512"])
    assert np.abs(long.advance(depth, shift)[:, 1] - expected[:, 1]).max() < 1e-10 * largest
    # sliding forgets the vertices and their error
    slid = in_c.advance([0.5 * DEEPEST], [DEEPEST])
    assert slid[0, 1] == pytest.approx(0.3 * slid[0, 0], rel=1e-12)
    assert slid[0, 2] < 1e-9 * largest


@needs_c
def test_bytes_continue_where_they_were(tmp_path):
    law = mdr.export_law(ball(mdr.Paraboloid("10 mm")), DEEPEST, tangential=True)
    depth, shift = random_moves(5, 400)
    whole, parts = (InC(law, tmp_path, ALONG) for _ in range(2))
    expected = whole.advance(depth, shift)
    assert len(whole.bytes) == 8 * (6 + 5 * 64)
    first = parts.advance(depth[:150], shift[:150])
    other = InC(law, tmp_path, ALONG)
    other.bytes[:] = parts.bytes.raw
    assert np.array_equal(np.concatenate([first, other.advance(depth[150:], shift[150:])]), expected)
    # a step that cannot be taken leaves the state
    kept = other.bytes.raw
    for move in ((2.0 * DEEPEST, 0.0), (math.nan, 0.0), (-math.inf, 0.0), (0.0, math.inf)):
        assert other.advance([move[0]], [move[1]]).size == 0
        assert other.bytes.raw == kept


@needs_c
def test_jkr_in_c_jumps_where_the_stepper_does(tmp_path):
    contact = mdr.Contact(mdr.Sphere("1 mm"), mdr.Elastic("40 kPa", 0.5), adhesion=mdr.JKR(0.05))
    law = mdr.export_law(contact, 2.0 * DEEPEST)
    rng = np.random.default_rng(1)
    depth = np.minimum(
        np.cumsum(rng.normal(0.0, 0.3 * DEEPEST, 1500)) % (8.0 * DEEPEST) - 6.0 * DEEPEST, 2e-5
    )
    result = InC(law, tmp_path, TOUCHING).advance(depth, np.zeros(depth.size))
    stepper, jumps = mdr.Stepper(contact, 2.0 * DEEPEST), 0
    for row, d in zip(result, depth.tolist(), strict=True):
        force = stepper.advance(d).normal
        jumps += stepper.jumped
        scale = abs(force) + abs(law.pull_off.largest_pull)
        assert abs(row[0] - force) <= law.errors["normal_force"] * scale * (1.0 + 1e-9)
        assert row[1] == pytest.approx(stepper.dissipated_energy, rel=1e-9)
        assert row[3] == (stepper.contact_radius > 0.0)
    assert result[-1, 2] == jumps > 20.0


@pytest.mark.skipif(shutil.which("c++") is None, reason="no C++ compiler (c++) on this machine")
def test_the_header_is_c_plus_plus_too(tmp_path):
    law = mdr.export_law(ball(mdr.Paraboloid("10 mm")), DEEPEST, tangential=True)
    depth, shift = random_moves(2, 200)
    in_c, in_cpp = (InC(law, tmp_path, ALONG, compiler).advance(depth, shift) for compiler in ("cc", "c++"))
    assert in_cpp == pytest.approx(in_c, rel=1e-12)


@pytest.mark.parametrize(
    ("contact", "words"),
    [
        (mdr.Contact(mdr.Sphere(1.0), STEEL), "a coefficient of friction above 0"),
        (ball(mdr.Sphere(1.0), 0.0), "a coefficient of friction above 0"),
    ],
)
def test_refusals(contact, words):
    with pytest.raises(mdr.ProblemError, match=words):
        mdr.export_law(contact, "1 um", tangential=True)
