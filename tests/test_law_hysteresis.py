"""Headers of two works of adhesion: random histories against the stepper, a closed loop, restarts, sizes from nm to m."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.drawing import examples, first_of
from tests.test_law_history import InC, needs_c

import pymdr as mdr

CALLS = (
    "law_advance(&s, d[i])",
    "out[4 * i] = s.normal_force; out[4 * i + 1] = s.dissipated_energy; out[4 * i + 2] = s.jumps; out[4 * i + 3] = s.contact_radius;",
)
SOFT, DEEPEST = mdr.Elastic("40 kPa", 0.5), 2e-5
PROFILES = {
    "sphere": mdr.Sphere("1 mm"),
    "cone": mdr.Cone(slope=0.1),
    "edge": mdr.DomedPunch("0.3 mm", "1 mm"),
    "flat": mdr.FlatPunch("1 mm"),
    "truncated cone": mdr.TruncatedCone("0.5 mm", slope=0.3),
    "worn ball": mdr.TruncatedParaboloid(radius="1 mm", flat_radius="0.5 mm"),
}
# nearly one work; both branches; a first contact smaller than the pull-off of an edge that recedes
RECEDING = (0.0501, 0.2, 2.0)


def moves(seed, size, low, high):
    """Walks through all depths with jumps, stays and turns."""
    rng = np.random.default_rng(seed)
    depth = low + np.mod(np.cumsum(rng.normal(0.0, 0.05 * (high - low), size)), high - low)
    far = rng.random(size) < 0.1
    depth[far] = rng.uniform(low, high, np.count_nonzero(far))
    depth[7::50] = depth[6::50][: depth[7::50].size]
    depth[size // 2] = high
    return depth


def around(seed, size, pull_off, high):
    """Presses, each followed by pulls to the pull-off, to one rounding and more on both of its sides."""
    rng = np.random.default_rng(seed)
    depth = pull_off * (1.0 + rng.choice([-1.0, 1.0], size) * 10.0 ** rng.uniform(-16.0, -4.0, size))
    depth[::11] = pull_off
    depth[3::11] = np.nextafter(pull_off, 1.0)
    depth[6::11] = np.nextafter(pull_off, -1.0)
    pressed = rng.random(size) < 0.3
    depth[pressed] = rng.uniform(0.0, high, np.count_nonzero(pressed))
    return depth


def followed(contact, deepest, depth):
    stepper, jumps, rows = mdr.Stepper(contact, deepest), 0, []
    for d in depth.tolist():
        force = stepper.advance(d).normal
        jumps += stepper.jumped
        rows.append((force, stepper.dissipated_energy, jumps, stepper.contact_radius))
    return np.array(rows)


@needs_c
@pytest.mark.parametrize("case", first_of([(name, work) for name in PROFILES for work in RECEDING[::-1]]))
def test_histories_in_c_are_those_of_the_stepper(case, tmp_path):
    profile, work = case
    contact = mdr.Contact(PROFILES[profile], SOFT, adhesion=mdr.JKR(0.05, work_receding=work))
    law = mdr.export_law(contact, DEEPEST)
    pull_off = law.history.pull_off[0]
    depth = np.concatenate([moves(1, 2000, 1.5 * pull_off, DEEPEST), around(1, 300, pull_off, DEEPEST)])
    computed = InC(law, tmp_path, CALLS).advance(depth, depth)
    expected = followed(contact, DEEPEST, depth)
    assert expected[-1, 2] > 10
    assert np.all(np.abs(computed - expected) <= 1e-13 * np.abs(expected).max(axis=0))


@needs_c
def test_the_loop_of_a_ball_in_closed_form(tmp_path):
    """JKR's ball: d = a^2/R - sqrt(2 pi a w / E*), F = 4 E* a^3 / 3R - sqrt(8 pi a^3 w E*), and a punch in between."""
    radius, modulus, advancing, receding = 1e-3, 4e4 / 0.75, 0.05, 0.2
    contact = mdr.Contact(mdr.Paraboloid(radius), SOFT, adhesion=mdr.JKR(advancing, work_receding=receding))
    law = mdr.export_law(contact, DEEPEST)

    def state(a, work):
        return (
            a**2 / radius - np.sqrt(2.0 * math.pi * a * work / modulus),
            4.0 * modulus * a**3 / (3.0 * radius) - np.sqrt(8.0 * math.pi * a**3 * work * modulus),
        )

    a = np.linspace(1.82e-4, 2.3e-4, 30)
    ahead, back = state(a, advancing), state(a, receding)
    half = np.array([0.5 * (each[0][-1] + each[1][-1]) for each in zip(ahead, back, strict=True)])
    rows = np.concatenate([ahead[0], [half[0]], back[0][::-1], [-1e-4]])
    result = InC(law, tmp_path, CALLS).advance(rows, rows)
    assert result[:30, 0] == pytest.approx(ahead[1], rel=1e-10)
    assert result[:30, 3] == pytest.approx(a, rel=1e-10)
    assert result[30, 0] == pytest.approx(half[1], rel=1e-10)
    assert result[31:61, 0] == pytest.approx(back[1][::-1], rel=1e-9)
    assert result[31:61, 3] == pytest.approx(a[::-1], rel=1e-9)
    spent = (receding - advancing) * math.pi * (a[-1] ** 2 - a**2)
    assert result[31:61, 1] - result[30, 1] == pytest.approx(spent[::-1], rel=1e-8, abs=1e-9 * spent[0])
    assert result[-1, 0] == result[-1, 3] == 0.0
    assert result[-1, 2] == 2.0
    # out of contact nothing is stored: the energy lost is the work of the loop
    assert result[-1, 1] == pytest.approx(
        float(mdr.solve(contact, mdr.Path(indentation=rows))["external_work"][-1]), rel=1e-10
    )


@needs_c
@pytest.mark.parametrize("profile", ["truncated cone", "worn ball"])
def test_a_flat_parts_where_it_does_in_closed_form(tmp_path, profile):
    """Kendall's punch of the flat of radius b: d = -sqrt(2 pi b w / E*), whose energy lost is E* b d^2 less the surfaces that part."""
    flat, modulus, advancing, receding = 5e-4, 4e4 / 0.75, 1e-3, 2e-3
    contact = mdr.Contact(PROFILES[profile], SOFT, adhesion=mdr.JKR(advancing, work_receding=receding))
    law = mdr.export_law(contact, DEEPEST)
    last = law.history.pull_off[0]
    assert last == pytest.approx(-math.sqrt(2.0 * math.pi * flat * receding / modulus), rel=1e-14)
    dissipated = math.pi * flat**2 * (2.0 * receding - advancing)
    depth = last * (1.0 - np.array([1e-5, 1e-8, 1e-9, 1e-12]))
    above, below = (np.nextafter(last, end) for end in (1.0, -1.0))
    code = InC(law, tmp_path, CALLS)
    for rows in (
        [*depth, above, last, below],
        [above, below],
        [last, below],
        [depth[1], 2 * last],
        [2 * last],
    ):
        code.bytes[:] = bytes(len(code.bytes))
        result = code.advance([0.0, DEEPEST, *rows], [0.0] * (2 + len(rows)))
        assert np.all(result[:-1, 3] > 0.999 * flat)
        assert result[-1, [0, 2, 3]].tolist() == [0.0, 2.0, 0.0]
        whole = (receding - advancing) * math.pi * (result[1, 3] ** 2 - flat**2) + dissipated
        assert result[-1, 1] - result[1, 1] == pytest.approx(whole, rel=1e-11)


@needs_c
def test_bytes_continue_where_they_were(tmp_path):
    contact = mdr.Contact(mdr.Sphere("1 mm"), SOFT, adhesion=mdr.JKR(0.05, work_receding=0.2))
    law = mdr.export_law(contact, DEEPEST)
    depth = moves(2, 300, -6e-5, DEEPEST)
    whole, parts, other = (InC(law, tmp_path, CALLS) for _ in range(3))
    expected = whole.advance(depth, depth)
    assert len(whole.bytes) == 8 * 12
    first = parts.advance(depth[:151], depth[:151])
    other.bytes[:] = parts.bytes.raw
    assert np.array_equal(np.concatenate([first, other.advance(depth[151:], depth[151:])]), expected)
    kept = other.bytes.raw
    for d in (2.0 * DEEPEST, math.nan, -math.inf, math.inf):
        assert other.advance([d], [d]).size == 0
        assert other.bytes.raw == kept
    ahead = mdr.Contact(mdr.Sphere("1 mm"), SOFT, adhesion=mdr.JKR(0.05))
    solved = float(mdr.solve(ahead, mdr.indent(1e-5))["normal_force"][0])
    size = abs(solved) - law.pull_off.largest_pull
    assert law.force(1e-5) == pytest.approx(solved, abs=law.errors["normal_force"] * size)
    assert "dissipated_energy" in law.claims


@needs_c
@settings(max_examples=examples(2), deadline=None)
@given(st.floats(-9.0, 0.0), st.floats(-4.0, -1.0), st.floats(1.001, 40.0), st.integers(0, 99))
def test_random_sizes_and_works(tmp_path_factory, size, strength, ratio, seed):
    radius, young = 10.0**size, 1e6
    deepest = 1e-3 * radius
    work = young * deepest**1.5 / math.sqrt(radius) * 10.0**strength
    contact = mdr.Contact(
        mdr.Paraboloid(radius), mdr.Elastic(young, 0.3), adhesion=mdr.JKR(work, work_receding=ratio * work)
    )
    law = mdr.export_law(contact, deepest)
    depth = moves(seed, 500, 1.5 * law.history.pull_off[0], deepest)
    computed = InC(law, tmp_path_factory.mktemp("law"), CALLS).advance(depth, depth)
    expected = followed(contact, deepest, depth)
    assert np.abs(computed - expected).max(axis=0) / np.abs(expected).max(axis=0) == pytest.approx(
        0.0, abs=1e-13
    )


@pytest.mark.parametrize(
    ("profile", "options", "words"),
    [
        (mdr.Sphere("1 mm"), {"tangential": True}, "Coulomb"),
        (mdr.Sphere("1 mm") + mdr.Waviness("1 um", "20 um"), {}, "jumps while its edge moves"),
    ],
)
def test_refusals(profile, options, words):
    contact = mdr.Contact(profile, SOFT, adhesion=mdr.JKR(0.005, work_receding=0.02))
    with pytest.raises(mdr.ProblemError, match=words):
        mdr.export_law(contact, DEEPEST, **options)
