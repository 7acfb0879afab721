"""Headers of bodies with memory and friction: random histories against the stepper, restarts, refusals."""

import math

import numpy as np
import pytest
from tests.drawing import first_of
from tests.test_law_history import InC, needs_c
from tests.test_law_memory import KINDS, PROFILES, moves

import pymdr as mdr
from pymdr.solving.exporting.histories import PARTS
from pymdr.solving.springs_error import errors_of_parts

CALLS = (
    "law_advance(&s, d[i], u[2 * i], u[2 * i + 1])",
    "out[4 * i] = s.normal_force; out[4 * i + 1] = s.tangential_force; out[4 * i + 2] = s.stored_tangential_energy; "
    "out[4 * i + 3] = s.dissipated_energy;",
)
NAMES = ("normal_force", "tangential_force", "stored_tangential_energy", "dissipated_energy")
DEEPEST = 1e-3
CASES = [
    ("solid", "sphere", 0.4, 1.0),
    ("solid", "flat", 0.4, 0.1),
    ("liquid", "cone", 0.4, 0.1),
    ("liquid of two times", "sphere", 1.5, 1.0),
    ("decades", "edge", 0.05, 0.03),
]


def sheared(kind, profile, friction):
    body = mdr.Viscoelastic(KINDS[kind], 0.45)
    return mdr.Contact(PROFILES[profile], body, friction=mdr.Coulomb(friction))


def walk(seed, size, step):
    depth, lasting = moves(seed, size, DEEPEST)
    return depth, np.cumsum(np.random.default_rng(seed).normal(0.0, step * 1e-4, size)), lasting


def in_c(code, depth, shift, lasting):
    both = np.stack([shift, lasting], axis=1).ravel()
    out = np.zeros((depth.size, 4))
    return out[: code.run(code.bytes, np.ascontiguousarray(depth), both, out, depth.size)]


def ends(duration, shortest, parts):
    """Where the parts of a step end: the first of equal parts is graded from the shortest relaxation time, two a decade."""
    decades = math.log10(1.0 + duration / (parts * shortest))
    graded = (10.0 ** np.linspace(0.0, decades, max(math.ceil(2.0 * decades), 1) + 1) - 1.0)[1:-1]
    return [*(graded * shortest / duration).tolist(), *(part / parts for part in range(1, parts))]


def followed(contact, springs, motion, parts=1):
    stepper, rows, here = mdr.Stepper(contact, DEEPEST, springs=springs), [], np.zeros(2)
    shortest = float(contact.body.shear.prony().times.min())
    if parts > 1:  # loads are taken as straight on every part
        stepper._moved.division = math.inf, 1
    for d, u, t in zip(*(each.tolist() for each in motion), strict=True):
        last = 0.0
        for end in ends(t, shortest, parts) if parts > 1 else ():
            at = here + (np.array([d, u]) - here) * end
            stepper.advance(float(at[0]), shift=float(at[1]), duration=t * (end - last))
            last = end
        stepper.advance(d, shift=u, duration=t * (1.0 - last))
        here = np.array([d, u])
        rows.append([getattr(stepper, name) for name in NAMES])
    return np.array(rows)


@needs_c
@pytest.mark.parametrize("case", first_of(CASES))
def test_histories_in_c_are_those_of_the_stepper(case, tmp_path):
    kind, profile, friction, step = case
    contact = sheared(kind, profile, friction)
    law = mdr.export_law(contact, DEEPEST, tangential=True, springs=24)
    codes = [InC(law, tmp_path, CALLS, compiler) for compiler in ("cc", "c++")]
    for seed in range(2):
        motion = walk(seed, 60, step)
        rows = []
        for code in codes:
            code.bytes[:] = bytes(len(code.bytes))
            rows.append(in_c(code, *motion))
        expected, exact = followed(contact, 24, motion, PARTS), followed(contact, 24, motion)
        size = np.abs(exact).max(axis=0)
        # the border of the contact is that of the table, to 1e-6; a search ends within 1e-9 of a step
        assert (np.abs(rows[0] - expected).max(axis=0) < 2e-6 * size).all()
        assert (np.abs(rows[1] - rows[0]).max(axis=0) < 1e-12 * size).all()
        for column, name in enumerate(NAMES[1:], 1):
            claim = law.claims[name]
            assert (
                np.abs(rows[0] - exact)[:, column].max() < (float(claim.error.max()) + 1e-12) * size[column]
            )
            assert f"a step has {PARTS} parts" in claim.reason


def test_the_error_of_equal_parts_holds_in_long_slides():
    """Slip dissipates by the load between the ends of a part, which relaxes there in slow steps."""
    contact = sheared("decades", "sphere", 1.5)
    claimed = errors_of_parts(contact, DEEPEST, PARTS)["dissipated_energy"]
    for seed in range(2):
        depth, shift, _ = walk(seed, 40, 100.0)
        motion = depth, shift, 10.0 ** np.random.default_rng(seed).uniform(-2.0, 4.0, 40)
        divided, exact = (followed(contact, 24, motion, parts)[:, -1] for parts in (PARTS, 1))
        assert np.abs(divided - exact).max() < claimed * exact.max()


@needs_c
def test_full_slip_is_that_of_coulomb_and_bytes_continue(tmp_path):
    contact = sheared("solid", "sphere", 0.4)
    law = mdr.export_law(contact, DEEPEST, tangential=True, springs=16)
    code = InC(law, tmp_path, CALLS)
    rows = in_c(code, np.array([8e-4, 8e-4]), np.array([0.0, 1e-2]), np.array([0.1, 0.1]))
    assert rows[1, 1] == pytest.approx(0.4 * rows[1, 0], rel=1e-14)
    motion, size = walk(1, 40, 1.0), len(code.bytes)
    code.bytes[:] = bytes(size)
    whole = in_c(code, *motion)
    code.bytes[:] = bytes(size)
    first = in_c(code, *(each[:17] for each in motion))
    kept = code.bytes.raw
    for d, u, t in (
        (2.0 * DEEPEST, 0.0, 1.0),
        (math.nan, 0.0, 1.0),
        (1e-4, math.inf, 1.0),
        (1e-4, 0.0, -1.0),
    ):
        assert in_c(code, *np.array([[d], [u], [t]])).size == 0
        assert code.bytes.raw == kept
    code.bytes[:] = bytes(size)
    code.bytes[:] = kept
    assert np.array_equal(np.concatenate([first, in_c(code, *(each[17:] for each in motion))]), whole)


@pytest.mark.parametrize(
    ("kind", "friction", "words"),
    [("dashpot", 0.3, "parallel dashpot"), ("solid", math.inf, "finite coefficient")],
)
def test_refusals(kind, friction, words):
    with pytest.raises(mdr.ProblemError, match=words):
        mdr.export_law(sheared(kind, "sphere", friction), DEEPEST, tangential=True, springs=16)
