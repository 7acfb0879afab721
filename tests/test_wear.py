"""Fretting wear: closed form of its end, balances, rings, scaling, worn profiles, records."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import pymdr as mdr
from pymdr.independent.wear import wear_by_rings
from pymdr.line.wear import Wearing, march, outer_radius, wear_limit
from pymdr.line.wear.limits import limiting_profile
from pymdr.line.wear.march import contact_edge, spread_again
from pymdr.line.wear.mesh import Mesh, Stuck
from pymdr.solving.wearing import one_cycle
from pymdr.workbench.cli.program import app

REFS = json.loads((Path(__file__).parent / "reference" / "refs.json").read_text())["refs"]
K = "1e-5 mm^3/(N m)"
BODY = mdr.Elastic("210 GPa", 0.0)
BALL = mdr.Contact(mdr.Paraboloid("10 mm"), BODY, BODY, friction=mdr.Coulomb(0.5))
AT_DEPTH = mdr.indent("1 um") >> mdr.cycle(shift="0.2 um")
LOADED = mdr.load("20 N") >> mdr.cycle(shift="0.4 um")


@pytest.fixture(scope="module")
def at_depth() -> mdr.solving.wear.Wear:
    return mdr.wear(BALL, AT_DEPTH, coefficient=K, cycles=1e7)


@pytest.fixture(scope="module")
def loaded() -> mdr.solving.wear.Wear:
    return mdr.wear(BALL, LOADED, coefficient=K, cycles=1e7)


def test_limiting_shape_of_reference() -> None:
    """Popov (2014): f, b and F of the reference."""
    (ref,) = [r for r in REFS if r["topic"] == "13 wear"]
    d, c = ref["inputs"]["d"], ref["inputs"]["c"]
    gap, profile = (lambda x: x**2), (lambda r: 0.5 * r**2)
    expected = ref["expected"]
    assert limiting_profile(np.array([0.4]), d, c, gap)[0] == pytest.approx(expected["f_inf_04"], rel=1e-12)
    assert outer_radius(d, c, gap, profile) == pytest.approx(expected["b"], rel=1e-12)
    assert 2.0 * wear_limit(d, c, gap, profile).half_load == pytest.approx(
        expected["F_over_Estar"], rel=1e-12
    )


@pytest.mark.parametrize(
    "profile",
    [mdr.Paraboloid("10 mm"), mdr.Cone(slope=0.01), mdr.PowerLaw(4.0, "1 um", "0.1 mm"), mdr.Sphere("10 mm")],
)
def test_wear_at_constant_indentation_ends_at_the_limit(profile: mdr.problem.profiles.Profile) -> None:
    contact = mdr.Contact(profile, BODY, BODY, friction=mdr.Coulomb(0.5))
    worn = mdr.wear(contact, AT_DEPTH, coefficient=K, cycles=[1e9])
    limit = worn.data.attrs
    # the mesh of 160 cells: measured 4e-5 for the paraboloid
    assert float(worn["worn_volume"][-1]) == pytest.approx(limit["limit_volume"], rel=3e-4)
    assert float(worn["normal_force"][-1]) == pytest.approx(limit["limit_force"], rel=1e-6)
    f, end = worn.surface["profile"].values[-1], worn.surface["limiting_profile"].values[-1]
    assert np.max(np.abs(f - end)) < 2e-3 * np.ptp(end)


def test_pressure_in_the_end_is_that_of_the_springs_that_stick(at_depth: mdr.solving.wear.Wear) -> None:
    """Within c, p = (E*/pi) [int_r^c g0'/sqrt(x^2 - r^2) dx + (d - g0(c))/sqrt(c^2 - r^2)], and none beyond."""
    modulus = mdr.effective_moduli(BODY, BODY).normal
    c = float(at_depth["stick_radius"][-1])
    r, p = (at_depth.surface[name].values[-1] for name in ("r", "pressure"))
    root = np.sqrt(c**2 - r[r < c] ** 2)
    exact = modulus / math.pi * (2.0 * root / 1e-2 + (1e-6 - c**2 / 1e-2) / root)
    assert np.allclose(p[r < c], exact, rtol=1e-8)
    assert p[r == c] == math.inf
    assert p[r > c].max() < 1e-6 * exact[0]
    assert float(at_depth["central_pressure"][-1]) == p[0]
    touched = math.pi * float(at_depth["contact_radius"][-1]) ** 2
    assert float(at_depth["mean_pressure"][-1] / at_depth["normal_force"][-1]) == pytest.approx(1.0 / touched)
    assert at_depth["central_pressure"].attrs["units"] == "Pa"


@pytest.mark.parametrize("shift", ["0.4 um", "2 um"], ids=["partial slip", "gross slip"])
def test_pressure_is_that_of_the_worn_profile(shift: str) -> None:
    worn = mdr.wear(BALL, mdr.load("20 N") >> mdr.cycle(shift=shift), coefficient=K, cycles=[0.0, 1e3, 1e4])
    for row in (1, 2):
        r, p = (worn.surface[name].values[row] for name in ("r", "pressure"))
        within = r < 0.9 * float(worn["stick_radius"][row] or worn["contact_radius"][row])
        pressed = mdr.solve(mdr.Contact(worn.worn(row), BODY, BODY), mdr.load("20 N"))
        assert np.allclose(p[within], pressed.field("pressure", r=r[within]), rtol=1e-3)
    assert worn.claims["central_pressure"].error.max() < 1e-3


def test_first_cycle_dissipates_the_loop(at_depth: mdr.solving.wear.Wear) -> None:
    loop = mdr.friction_loop(BALL, "0.2 um", indentation="1 um")
    assert float(at_depth["dissipated_per_cycle"][0]) == pytest.approx(
        float(loop["dissipated_per_cycle"][0]), rel=1e-3
    )
    assert float(at_depth["force_amplitude"][0]) == pytest.approx(float(loop["force_amplitude"][0]), rel=1e-4)


def test_worn_volume_is_dissipated_energy_times_the_energy_coefficient() -> None:
    rows = np.concatenate([[0.0], np.linspace(2.5e3, 2e5, 80)])
    worn = mdr.wear(BALL, LOADED, coefficient="2e-5 mm^3/J", cycles=rows, law="energy")
    dissipated = worn["dissipated_per_cycle"].values
    # Simpson's rule over the cycles
    total = np.sum(
        np.diff(rows)[::2] / 3.0 * (dissipated[:-2:2] + 4.0 * dissipated[1:-1:2] + dissipated[2::2])
    )
    assert float(worn["worn_volume"][-1]) == pytest.approx(2e-14 * total, rel=1e-3)


def test_energy_law_is_archard_with_mu(loaded: mdr.solving.wear.Wear) -> None:
    energy = mdr.wear(BALL, LOADED, coefficient="2e-5 mm^3/J", cycles=1e7, law="energy")
    assert np.allclose(energy["worn_volume"], loaded["worn_volume"], rtol=1e-10)


def test_constant_load_is_kept_and_the_stick_radius_grows(loaded: mdr.solving.wear.Wear) -> None:
    assert np.allclose(loaded["normal_force"], 20.0, rtol=1e-9)
    stick, depth = loaded["stick_radius"].values, loaded["indentation"].values
    assert np.all(np.diff(stick) >= 0.0)
    assert np.all(np.diff(depth) > -1e-9 * depth[0])
    assert stick[-1] > 1.005 * stick[0]


def test_a_million_cycles_are_claimed_to_a_thousandth(
    at_depth: mdr.solving.wear.Wear, loaded: mdr.solving.wear.Wear
) -> None:
    for worn in (at_depth, loaded):
        million = worn["cycles"].values <= 1e6
        assert worn.claims["worn_volume"].error[million].max() < 1e-3


def test_new_cells_hold_the_worn_volume() -> None:
    rng = np.random.default_rng(3)
    for _ in range(100):
        nodes = 3.0 * rng.random() + np.linspace(0.0, 1.0, rng.integers(2, 30)) ** 2
        none = Stuck(nodes[:1], np.zeros(1), np.zeros(1))
        mesh = Mesh(nodes, np.square, np.square, (), none)
        worn = np.maximum(rng.normal(0.2, 0.3, nodes.size - 1), 0.0)
        inner = np.sort(rng.uniform(nodes[0], nodes[-1], rng.integers(1, 40)))
        new = np.append(inner, nodes[-1])
        rings, frozen = spread_again(mesh, worn, new)
        assert min(rings.min(), frozen) > -1e-9
        kept = frozen + math.pi * float(np.diff(new**2) @ rings)
        assert kept == pytest.approx(mesh.volume(worn), rel=1e-12)


def test_end_at_constant_load() -> None:
    """c0 = 0.6 a0: the stick radius and indentation of an independent evolution, 0.623 and 1.199 (three digits)."""
    d = 1e-6
    moduli = mdr.effective_moduli(BODY, BODY)
    load = 4.0 / 3.0 * moduli.normal * math.sqrt(10e-3) * d**1.5
    shift = 0.64 * 0.5 * moduli.normal / moduli.tangential * d
    worn = mdr.wear(BALL, mdr.load(load) >> mdr.cycle(shift=shift), coefficient=K, cycles=[1e9])
    assert float(worn["stick_radius"][-1]) == pytest.approx(0.623e-4, rel=1.5e-3)
    assert float(worn["indentation"][-1]) == pytest.approx(1.199e-6, rel=1.5e-3)


def test_doubled_cells_move_less_than_the_claim(
    monkeypatch: pytest.MonkeyPatch, loaded: mdr.solving.wear.Wear
) -> None:
    monkeypatch.setattr("pymdr.solving.wearing._CELLS", 320)
    monkeypatch.setattr("pymdr.solving.wearing._TOLERANCE", 3e-5)
    fine = mdr.wear(BALL, LOADED, coefficient=K, cycles=loaded["cycles"].values[::10])
    for name in ("worn_volume", "indentation", "stick_radius", "dissipated_per_cycle"):
        coarse, error = loaded[name].values[::10], loaded.claims[name].error[::10]
        assert np.all(np.abs(fine[name].values - coarse) <= error * np.abs(coarse)), name
        assert np.allclose(fine[name].values, coarse, rtol=2e-3, atol=1e-6 * coarse.max()), name


@pytest.mark.parametrize("path", [AT_DEPTH, LOADED, mdr.load("20 N") >> mdr.cycle(shift="2 um")])
def test_rings_wear_alike(path: mdr.LoadingPath) -> None:
    """Also late, where the ring at the stick radius carries an infinite pressure: measured 3.5e-3, 120 rings 7e-4, 240 rings 2e-4."""
    cycles = 1e5 if path.legs[-1].shift > 1e-6 else 1e6
    both = mdr.verify(BALL, path, wear={"coefficient": K, "cycles": cycles}, elements=60, steps=3)
    assert both.largest_difference < 5e-3
    for name in ("worn_depth", "indentation", "normal_force"):
        assert np.all(np.abs(both.data[f"{name}_difference"]) < 6e-3), name
    assert "rings" in both.summary()
    assert both.plot().axes


@pytest.mark.parametrize(
    ("power", "amplitude", "by_force", "cycles", "cells"),
    [
        (2.0, 0.35, False, 25.0, 80),
        (2.0, 1.2, True, 10.0, 80),
        (1.0, 0.35, False, 25.0, 80),
        pytest.param(2.0, 0.6, True, 8.0, 320, marks=pytest.mark.long),
        pytest.param(1.0, 0.35, True, 25.0, 320, marks=pytest.mark.long),
    ],
    ids=["depth", "load in gross slip", "depth of a cone", "load", "load of a cone"],
)
def test_blocks_are_of_second_order(
    power: float, amplitude: float, by_force: bool, cycles: float, cells: int
) -> None:
    """
    Halved blocks on one mesh, in the units of the march; the slope of the line through the changes.

    Partial slip at constant load needs more cells than a user has, because the cells follow the stick radius, which scatters single
    halvings by 3e-4 of the volume on 80 cells, 2e-5 on 160.
    """
    height = {1.0: 2.0 / math.pi, 2.0: 0.5}[power]
    wearing = Wearing(
        gap=lambda x: x**power,
        profile=lambda r: height * r**power,
        kinks=(),
        stick=max(1.0 - amplitude, 0.0) ** (1.0 / power),
        amplitude=amplitude,
        rate=1.0,
        force=power / (1.0 + power) if by_force else None,
        end=2.0 if amplitude > 1.0 else 1.5,
        cells=cells,
    )
    counts, ends = np.array([8, 16, 32, 64]), []
    for count in counts:
        blocks = np.linspace(0.0, cycles, count + 1)[1:]
        mesh, state = march(wearing, np.array([cycles]), math.inf, blocks=blocks).states[-1]
        ends.append((mesh.volume(state.worn), mesh.whole(state.worn)[1].max()))
    assert contact_edge(mesh, state) < 0.98 * wearing.end
    for change in np.abs(np.diff(ends, axis=0)).T:
        order = -np.polyfit(np.log2(counts[1:]), np.log2(change), 1)[0]
        assert order == pytest.approx(2.0, abs=0.3)


def test_blocks_of_rings_are_of_second_order() -> None:
    depth, moduli = 1e-6, mdr.effective_moduli(BODY, BODY)
    volumes = []
    for blocks in (4, 8, 16):
        rings = wear_by_rings(
            np.linspace(0.0, 1.3e-4, 41),
            lambda r: 0.5 * r**2 / 10e-3,
            (moduli.normal, moduli.tangential, 0.5),
            (depth, None),
            0.2e-6,
            1e-14,
            np.linspace(0.0, 3e4, blocks + 1)[1:],
        )
        volumes.append(rings.volume[-1])
    change = np.abs(np.diff(volumes))
    assert change[0] / change[1] > 3.0


def test_loops_late_in_wear_at_constant_load_are_known(loaded: mdr.solving.wear.Wear) -> None:
    """The stiffness is level over half of the depth: that its rise has no digits there says nothing of the last part."""
    row = int(np.searchsorted(loaded["cycles"].values, 1.2e6))
    worn = mdr.Contact(loaded.force_curve(row), BODY, BODY, friction=mdr.Coulomb(0.5))
    loop = mdr.friction_loop(worn, "0.4 um", normal_force="20 N")
    assert float(loop.claims["dissipated_per_cycle"].error[0]) < 0.03
    assert float(loop["dissipated_per_cycle"][0]) == pytest.approx(
        float(loaded["dissipated_per_cycle"][row]), rel=1e-4
    )


def test_friction_of_a_worn_contact_to_the_end(at_depth: mdr.solving.wear.Wear) -> None:
    for row in (15, 25, -1):
        curve = at_depth.force_curve(row)
        result = mdr.solve(mdr.Contact(curve, BODY, BODY, friction=mdr.Coulomb(0.5)), AT_DEPTH)
        assert float(result["normal_force"][0]) == pytest.approx(
            float(at_depth["normal_force"][row]), rel=1e-9
        )
        assert float(result["tangential_force"].max()) == pytest.approx(
            float(at_depth["force_amplitude"][row]), rel=1e-9
        )


@pytest.mark.parametrize(
    ("wrong", "remedy"),
    [
        (lambda c: mdr.solve(c, AT_DEPTH), r"1 µm: .*; give the force curve .* force_curve\(row\)"),
        (lambda c: mdr.solve(c, LOADED), r"µm: .*; give the force curve .* force_curve\(row\)"),
        (lambda c: mdr.friction_loop(c, "0.1 um", indentation="1 um"), r"force_curve\(row\)"),
        (lambda c: mdr.Stepper(c, "1 um"), r"Stepper needs .* force_curve\(row\)"),
        (lambda c: mdr.solve(c, mdr.indent("1 um") >> mdr.twist("1 mrad")), "torsion .* row with less wear"),
        (lambda c: mdr.wear(c, AT_DEPTH, coefficient=K, cycles=1.0), r"wear .* cycles=\[\.\.\.\]\)"),
    ],
)
def test_a_worn_profile_that_is_no_disk_is_refused_with_what_serves(
    at_depth: mdr.solving.wear.Wear, wrong: Callable[[mdr.Contact], object], remedy: str
) -> None:
    image = replace(at_depth.worn(20), spring_radius=None, spring_depth=None)
    with pytest.raises(mdr.RefusedError, match=remedy):
        wrong(mdr.Contact(image, BODY, BODY, friction=mdr.Coulomb(0.5)))


def test_springs_of_a_ball_are_its_line() -> None:
    """G = x^2/R between springs, which it is linear in x^2: curves, inverses and surface integrals of the ball."""
    ball, x = mdr.equivalent_profile(mdr.Paraboloid(1.0)), np.array([1.0, 1.5, 1.5000001, 2.0, 3.0])
    ring = np.array([1.0, 1.2, 1.4])
    line = mdr.equivalent_profile(mdr.Worn(mdr.Paraboloid(1.0), ring, 0.0 * ring, x, x**2))
    inside = np.linspace(0.01, 2.99, 50)
    for name in ("g", "slope", "moment", "squared", "integral"):
        assert np.allclose(getattr(line, name)(inside), getattr(ball, name)(inside), rtol=1e-14)
    assert np.allclose(line.inverse(inside**2), inside, rtol=1e-14)
    assert np.allclose(line.inverse_moment(ball.moment(inside)), inside, rtol=1e-14)
    r, end = np.array([0.1, 0.9, 1.2, 1.5, 2.5]), np.array(2.7)
    assert np.allclose(line.pressure_integral(r, end), 2.0 * np.sqrt(2.7**2 - r**2), rtol=1e-13)
    for a in (0.5, 1.7):
        far = np.array([1.9, 2.5, 2.9])
        rest = (
            0.5 * far**2 * np.arccos(a / far) + 0.5 * a * np.sqrt(far**2 - a**2) - a**2 * np.arccos(a / far)
        )
        assert np.allclose(line.gap_integral(far, np.array(a)), rest, rtol=1e-13)
        whole = 0.5 * math.pi * a**2 - a**2 * np.arccos(a / far) - 0.5 * far**2 * np.arcsin(a / far)
        whole += 0.5 * a * np.sqrt(far**2 - a**2)
        assert np.allclose(line.displacement_integral(far, np.array(a)), whole, rtol=1e-13)


@pytest.mark.parametrize("row", [20, 25, -1])
def test_a_worn_contact_is_solved_by_its_springs_to_the_end(
    at_depth: mdr.solving.wear.Wear, row: int, tmp_path: Path
) -> None:
    """Where the image of the worn depth is no disk, the springs of the study are: every law, at every depth up to that of wear."""
    profile = at_depth.worn(row)
    assert profile.spring_radius is not None
    joint = mdr.Contact(profile, BODY, BODY, friction=mdr.Coulomb(0.5))
    result = mdr.solve(joint, AT_DEPTH)
    own = {
        "normal_force": result["normal_force"][0],
        "force_amplitude": result["tangential_force"].max(),
        "stick_radius": result["stick_radius"].min(),
    }
    for name, value in own.items():
        assert float(value) == pytest.approx(float(at_depth[name][row]), rel=1e-6)
    loop = mdr.friction_loop(joint, "0.2 um", indentation="1 um")
    assert float(loop["dissipated_per_cycle"][0]) == pytest.approx(
        float(at_depth["dissipated_per_cycle"][row]), rel=1e-3, abs=1e-12
    )
    r, p = (at_depth.surface[name].values[row] for name in ("r", "pressure"))
    within = r < 0.9 * float(at_depth["stick_radius"][row])
    # the jump of g at c has a width of 1e-7
    assert np.allclose(result.field("pressure", r=r[within], step=0), p[within], rtol=1e-6)
    assert result.plot() is not None
    result.save(tmp_path / "worn.nc")
    assert mdr.open_result(tmp_path / "worn.nc").contact.profile == profile
    halfway = mdr.solve(joint, mdr.indent("0.9 um") >> mdr.twist("10 urad", steps=2))
    assert halfway["torque"][-1] > 0.0
    sticky = mdr.Contact(profile, BODY, BODY, adhesion=mdr.JKR("1 uJ/m^2"))
    assert mdr.solve(sticky, mdr.indent("0.9 um")).claims["contact_radius"].where.all()
    with pytest.raises(mdr.PathError, match="last radius at which the profile is known"):
        mdr.solve(joint, mdr.indent("1.1 um"))


def test_what_serves_instead_of_a_worn_profile(at_depth: mdr.solving.wear.Wear) -> None:
    worn = mdr.Contact(at_depth.force_curve(20), BODY, BODY, friction=mdr.Coulomb(0.5))
    loop = mdr.friction_loop(worn, "0.2 um", indentation="1 um")
    solved = mdr.solve(worn, AT_DEPTH)["tangential_force"]
    assert float(loop["force_amplitude"][0]) == pytest.approx(float(solved.max()), rel=1e-9)
    assert mdr.Stepper(worn, "1 um")


@pytest.mark.parametrize("radius", [1e-8, 1.0, 1e4])
def test_gross_slip_at_constant_indentation_of_any_size(radius: float) -> None:
    """A flat of the depth d: b = sqrt(2 R d), V = pi R d^2."""
    depth = 1e-4 * radius
    contact = mdr.Contact(mdr.Paraboloid(radius), BODY, BODY, friction=mdr.Coulomb(0.1))
    path = mdr.indent(depth) >> mdr.cycle(shift=0.5 * depth)
    worn = mdr.wear(contact, path, coefficient=K, cycles=10.0)
    assert worn.data.attrs["limit_radius"] == pytest.approx(math.sqrt(2.0 * radius * depth), rel=1e-9)
    assert worn.data.attrs["limit_volume"] == pytest.approx(math.pi * radius * depth**2, rel=1e-9)


@pytest.mark.parametrize(
    "profile", [mdr.Paraboloid("10 mm"), mdr.Cone(slope=0.01), mdr.TruncatedCone("50 um", slope=0.01)]
)
def test_gross_slip_begins_at_the_rate_of_the_exact_springs(profile: mdr.problem.profiles.Profile) -> None:
    """V'(0) = 4 k int p (U - u) dA = 8 k E* int_0^a (U - mu E*/G* (d - g)) (d - g) dx; 160 cells: measured 3e-5."""
    contact = mdr.Contact(profile, BODY, BODY, friction=mdr.Coulomb(0.05))
    depth, shift = 1e-6, 0.1e-6
    worn = mdr.wear(contact, mdr.indent(depth) >> mdr.cycle(shift=shift), coefficient=K, cycles=1e-3)
    moduli, line = mdr.effective_moduli(BODY, BODY), mdr.equivalent_profile(profile)
    a = float(np.ravel(line.inverse(np.array([depth])))[0])
    t, weights = np.polynomial.legendre.leggauss(64)
    marks = [0.0, *(k for k in profile.breakpoints if k < a), a]
    total = 0.0
    for low, high in pairwise(marks):
        x = low + (high - low) * (t + 1.0) ** 2 / 4.0
        w = depth - line.g(x)
        slip = shift - 0.05 * moduli.normal / moduli.tangential * w
        total += float(np.sum(weights * (t + 1.0) / 2.0 * (high - low) * slip * w))
    assert float(worn["worn_volume"][-1]) == pytest.approx(8e-14 * 1e-3 * moduli.normal * total, rel=1e-4)


@pytest.mark.parametrize("seed", range(6))
def test_balances_of_random_problems(seed: int) -> None:
    """From 10 nm to 1 m: volume below the limit, a stick radius that does not fall, and the work of friction as the worn volume."""
    rng = np.random.default_rng(seed)
    size, slope = 10.0 ** rng.uniform(-8.0, 0.0), 10.0 ** rng.uniform(-4.0, -1.0)
    depth, mu = slope * size, 10.0 ** rng.uniform(-1.5, 0.2)
    profile = mdr.PowerLaw(rng.uniform(1.3, 5.0), depth, size)
    body = mdr.Elastic(10.0 ** rng.uniform(5.0, 12.0), rng.uniform(0.0, 0.49))
    contact = mdr.Contact(profile, body, body, friction=mdr.Coulomb(mu))
    pressed = mdr.solve(contact, mdr.indent(depth))
    force, radius = float(pressed["normal_force"][0]), float(pressed["contact_radius"][0])
    moduli = mdr.effective_moduli(body, body)
    slides = mu * moduli.normal / moduli.tangential * depth
    shift = rng.uniform(0.05, 0.98) * slides
    by_force = bool(seed % 2)
    path = (mdr.load(force) if by_force else mdr.indent(depth)) >> mdr.cycle(shift=shift)
    cycles = 10.0 ** rng.uniform(2.0, 8.0)
    k = 10.0 ** rng.uniform(-1.0, 2.0) * depth * math.pi * radius**2 / (cycles * 4.0 * slides * force)
    worn = mdr.wear(contact, path, coefficient=k, cycles=cycles)
    volume = worn["worn_volume"].values
    assert np.all(np.diff(volume) >= -1e-9 * volume[-1])
    assert np.all(np.diff(worn["stick_radius"].values) >= -1e-12 * radius)
    if not by_force:
        assert volume[-1] <= worn.data.attrs["limit_volume"] * (1.0 + 2e-3)
    n, work = worn["cycles"].values, worn["dissipated_per_cycle"].values
    # the trapezoid over 31 rows
    assert k / mu * np.sum(np.diff(n) * (work[1:] + work[:-1]) / 2.0) == pytest.approx(volume[-1], rel=0.03)


def random_wear(seed: int) -> tuple[mdr.Contact, mdr.LoadingPath, dict[str, object]]:
    """Profiles, bodies, laws, controls and amplitudes, partial and gross slip, from 10 nm to 1 m."""
    rng = np.random.default_rng(7000 + seed)
    size, slope = 10.0 ** rng.uniform(-8.0, 0.0), 10.0 ** rng.uniform(-4.0, -1.2)
    depth, inner = slope * size, size * rng.uniform(0.2, 0.8)
    profiles = (
        mdr.PowerLaw(rng.uniform(1.3, 5.0), depth, size),
        mdr.Paraboloid(size**2 / depth),
        mdr.Cone(slope=slope),
        mdr.Sphere(size**2 / depth),
        mdr.TruncatedCone(slope=slope, flat_radius=inner),
        mdr.RoundedFlat(flat_radius=inner, edge_radius=size**2 / depth),
    )
    body = mdr.Elastic(10.0 ** rng.uniform(5.0, 12.0), rng.uniform(0.0, 0.5))
    soft = mdr.Elastic(body.young * 10.0 ** rng.uniform(-1.0, 1.0), rng.uniform(0.0, 0.5))
    other, mu = (mdr.Rigid(), soft)[rng.integers(2)], 10.0 ** rng.uniform(-1.5, 0.2)
    contact = mdr.Contact(profiles[seed % 6], body, other, friction=mdr.Coulomb(mu))
    pressed = mdr.solve(mdr.Contact(contact.profile, body, other), mdr.indent(depth))
    force, radius = float(pressed["normal_force"][0]), float(pressed["contact_radius"][0])
    moduli = mdr.effective_moduli(body, other)
    slides = mu * moduli.normal / moduli.tangential * depth
    shift = (
        slides * rng.uniform(0.05, 0.98) if seed % 4 else min(slides * rng.uniform(1.5, 2.5), 0.09 * radius)
    )
    path = (mdr.load(force) if rng.random() < 0.5 else mdr.indent(depth)) >> mdr.cycle(shift=shift)
    cycles, law = 10.0 ** rng.uniform(2.0, 8.0), ("archard", "energy")[rng.integers(2)]
    worn = 10.0 ** rng.uniform(-1.5, 1.0) * depth * math.pi * radius**2
    k = worn / (cycles * 4.0 * slides * force * (mu if law == "energy" else 1.0))
    return contact, path, {"coefficient": k, "cycles": cycles, "law": law}


@pytest.mark.long
@pytest.mark.parametrize("seed", range(36))
def test_random_wear_is_that_of_rings_within_the_claim(seed: int) -> None:
    """The claim bounds the error of the method; half the rings and blocks measure that of the rings."""
    contact, path, given = random_wear(seed)
    study = mdr.wear(contact, path, **given)
    both = mdr.verify(contact, path, wear=given, elements=100, steps=6)
    rows = np.searchsorted(study["cycles"].values, both.data["cycles"].values)
    for name in ("worn_volume", "indentation"):
        error = study.claims[name].error[rows] + both.halved
        assert np.all(np.abs(both.data[f"{name}_difference"].values) <= error), name


def test_gross_slip_whose_middle_begins_to_stick_is_that_of_rings() -> None:
    """The flat wears most at its edge, so that under load its middle begins to stick."""
    body = mdr.Elastic("12.6 GPa", 0.41)
    flat = mdr.Contact(mdr.RoundedFlat("31 um", "63 mm"), body, friction=mdr.Coulomb(0.142))
    path = mdr.load("38 mN") >> mdr.cycle(shift="5.2 nm")
    request = {"coefficient": "2e-9 m^2/N", "cycles": [50.0, 300.0, 2000.0]}
    worn = mdr.wear(flat, path, **request)
    stick = worn["stick_radius"].values
    assert stick[0] == 0.0 < stick[1] <= stick[2]
    assert "from 300 cycles on the centre sticks" in worn.notes[-1]
    assert np.allclose(worn["normal_force"], 0.038, rtol=1e-9)
    # measured 5e-4; 60 rings resolve the middle to 9e-3 only
    both = mdr.verify(flat, path, wear=request, elements=120)
    assert both.largest_difference < 2e-3


def test_lengths_scale(at_depth: mdr.solving.wear.Wear) -> None:
    """A thousand times larger: the same cycles, a thousandth of the coefficient over the size of nothing else."""
    large = mdr.Contact(mdr.Paraboloid("10 m"), BODY, BODY, friction=mdr.Coulomb(0.5))
    path = mdr.indent("1 mm") >> mdr.cycle(shift="0.2 mm")
    worn = mdr.wear(large, path, coefficient=K, cycles=at_depth["cycles"].values)
    assert np.allclose(worn["worn_volume"], 1e9 * at_depth["worn_volume"], rtol=1e-8)


def test_cycles_and_coefficient_trade(at_depth: mdr.solving.wear.Wear) -> None:
    worn = mdr.wear(BALL, AT_DEPTH, coefficient="1e-4 mm^3/(N m)", cycles=at_depth["cycles"].values / 10.0)
    assert np.allclose(worn["worn_volume"], at_depth["worn_volume"], rtol=1e-8)


def test_gross_slip_follows_archard_in_the_whole() -> None:
    path = mdr.load("20 N") >> mdr.cycle(shift="2 um")
    worn = mdr.wear(BALL, path, coefficient=K, cycles=1e5)
    most = 1e-14 * 20.0 * 4.0 * 2e-6 * worn["cycles"].values
    assert np.all(worn["worn_volume"].values <= most)
    # slip is the amplitude less the elastic shift, which the worn flat makes small
    assert worn["worn_volume"].values[-1] > 0.8 * most[-1]
    assert np.all(worn["stick_radius"].values == 0.0)
    apex = worn.worn()
    assert apex.gap(0.0) == 0.0
    assert np.ptp(apex.depth[apex.radius < 0.3 * apex.radius[-1]]) < 0.2 * apex.depth[0]


def test_worn_profile_is_solved_saved_and_worn_again(at_depth: mdr.solving.wear.Wear, tmp_path: Path) -> None:
    row = 15
    worn = at_depth.worn(row)
    contact = mdr.Contact(worn, BODY, BODY, friction=mdr.Coulomb(0.5))
    result = mdr.solve(contact, AT_DEPTH)
    assert float(result["normal_force"][0]) == pytest.approx(float(at_depth["normal_force"][row]), rel=2e-4)
    assert float(result["stick_radius"][0]) > 0.0
    result.save(tmp_path / "worn.nc")
    assert mdr.open_result(tmp_path / "worn.nc").contact.profile == worn
    at_depth.save(tmp_path / "study.nc")
    with xr.open_dataset(tmp_path / "study.nc", engine="h5netcdf") as saved:
        assert saved["surface_profile"].shape == at_depth.surface["profile"].shape
    with pytest.raises(mdr.ProblemError, match="row 0 has no wear"):
        at_depth.worn(0)


def test_wear_in_two_parts_is_wear_in_one() -> None:
    half = mdr.wear(BALL, AT_DEPTH, coefficient=K, cycles=[1e4]).worn()
    again = mdr.wear(
        mdr.Contact(half, BODY, BODY, friction=mdr.Coulomb(0.5)), AT_DEPTH, coefficient=K, cycles=[1e4]
    )
    whole = mdr.wear(BALL, AT_DEPTH, coefficient=K, cycles=[1e4, 2e4])
    volume = float(whole["worn_volume"][0]) + float(again["worn_volume"][-1])
    assert volume == pytest.approx(float(whole["worn_volume"][1]), rel=5e-3)
    assert isinstance(again.worn().original, mdr.Paraboloid)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"coefficient": 0.0}, "coefficient"),
        ({"coefficient": "-1e-6 mm^3/(N m)"}, "coefficient"),
        ({"cycles": 0.0}, "cycles"),
        ({"cycles": [3.0, 2.0]}, "cycles"),
        ({"cycles": 1e300}, r"1e\+300 cycles .* times the indentation \(limit 1e\+30\); give fewer cycles"),
        ({"coefficient": 1e300}, "check the unit of the coefficient"),
        (
            {"path": mdr.indent("0 um") >> mdr.cycle(shift="1 um")},
            r"indentation = 0\.0; it must be above 0 m",
        ),
        ({"law": "fleischer"}, "law"),
        ({"path": mdr.load("1 N")}, "shift"),
        ({"path": mdr.cycle(shift="1 um")}, "press"),
        ({"path": mdr.load("1 N") >> mdr.cycle(twist="1 mrad")}, "twist"),
        ({"path": mdr.load("1 N") >> mdr.ramp(shift="1 um") >> mdr.load("2 N")}, "constant"),
        ({"path": mdr.load("1 N") >> mdr.cycle(shift="50 um")}, "tenth"),
        ({"contact": mdr.Contact(mdr.Paraboloid("1 mm"), BODY)}, "friction"),
        ({"contact": mdr.Contact(mdr.FlatPunch("1 mm"), BODY, friction=mdr.Coulomb(0.3))}, "edge"),
        (
            {
                "contact": mdr.Contact(
                    mdr.Paraboloid("1 mm"), mdr.Elastic("1 MPa", 0.5), adhesion=mdr.JKR(0.05)
                )
            },
            "adhesion",
        ),
        (
            {
                "contact": mdr.Contact(
                    mdr.Paraboloid("1 mm"),
                    mdr.Viscoelastic(mdr.Maxwell("1 MPa", "1 s"), poisson=0.5),
                    friction=mdr.Coulomb(0.3),
                )
            },
            "memory",
        ),
    ],
)
def test_bad_input_is_refused(change: dict[str, object], message: str) -> None:
    given: dict[str, object] = {"contact": BALL, "path": AT_DEPTH, "coefficient": K, "cycles": 10.0} | change
    with pytest.raises(mdr.ProblemError, match=message):
        mdr.wear(given.pop("contact"), given.pop("path"), **given)


@pytest.mark.parametrize("row", [99, -99, 1.5, "last", None])
def test_rows_that_do_not_exist_are_refused(at_depth: mdr.solving.wear.Wear, row: object) -> None:
    for read in (at_depth.worn, at_depth.force_curve):
        with pytest.raises(mdr.QuantityError, match=r"row .*(31 is needed|0 to 31)"):
            read(row)  # type: ignore[arg-type, operator]


def test_bad_worn_profiles_are_refused() -> None:
    ball = mdr.Paraboloid("1 mm")
    worn = mdr.Worn(ball, [0.0, 1e-5, 2e-5], [1e-8, 1e-8, 0.0])
    smallest = "depths must be at least 0 m, and the last 0 m"
    for original, radius, depth, words in (
        (worn, [0.0, 1e-5, 2e-5], [1e-8, 1e-8, 0.0], r"original = Worn\(.*a profile of revolution is needed"),
        (ball, [0.0, 1e-5], [1e-8, 0.0], "2 radii and 2 depths; give the same number of each, at least 3"),
        (ball, [1e-5, 0.0, 2e-5], [1e-8, 1e-8, 0.0], "radius must rise strictly from 0 m or more"),
        (
            ball,
            [0.0, 1e-5, 2e-5],
            [1e-8, -1e-8, 0.0],
            f"depth: the smallest is -10 nm, the last 0 m; {smallest}",
        ),
        (
            ball,
            [0.0, 1e-5, 2e-5],
            [1e-8, 1e-8, 1e-9],
            f"depth: the smallest is 1 nm, the last 1 nm; {smallest}",
        ),
    ):
        with pytest.raises(mdr.ProblemError, match=words):
            mdr.Worn(original, radius, depth)


def test_paths_of_one_cycle_in_other_words() -> None:
    options = [
        mdr.load("2 N") >> mdr.cycle(shift="1 um"),
        mdr.load("2 N") >> mdr.shift("1 um") >> mdr.shift("-1 um") >> mdr.shift("1 um"),
        mdr.Path(normal_force=[2.0, 2.0, 2.0], shift=[0.0, 1e-6, -1e-6]),
        mdr.ramp(normal_force="2 N", shift="1 um") >> mdr.shift("-1 um") >> mdr.shift("1 um"),
    ]
    assert [one_cycle(path) for path in options] == [(None, 2.0, 1e-6)] * 4


def record(amplitudes: list[float], steps: int = 200) -> mdr.result.Result:
    path = mdr.load("50 N")
    for u in amplitudes:
        path = path >> mdr.cycle(shift=u, steps=steps)
    return mdr.solve(BALL, path)


def test_log_of_a_solved_record() -> None:
    test = record([0.3e-6, 0.6e-6, 0.9e-6, 1.5e-6, 2.0e-6, 2.5e-6])
    log = mdr.fretting_log(test, contact=BALL)
    assert log.data["regime"].values[0] == "partial"
    assert log.data["regime"].values[-1] == "gross"
    assert log.data.attrs["limit"] == pytest.approx(0.2, rel=1e-9)
    assert float(log["friction_coefficient"][-1]) == pytest.approx(0.5, rel=1e-9)
    stuck = 2.0 * mdr.effective_moduli(BODY, BODY).tangential * float(test["contact_radius"][0])
    # a parabola through Mindlin's curve
    assert np.allclose(log["tangential_stiffness"], stuck, rtol=0.05)
    steady = mdr.fretting_log(record([0.9e-6] * 3, steps=1000), contact=BALL)
    assert np.allclose(steady["model_dissipated"], steady["dissipated_per_cycle"], rtol=1e-4)
    assert np.allclose(steady["model_force"], steady["force_amplitude"], rtol=1e-9)


def test_every_cycle_has_the_loop_of_its_own_load() -> None:
    """Of a profile with a kink, from stick to sliding; progress counts to the last cycle."""
    pin = mdr.Contact(mdr.RoundedFlat("50 um", "10 mm"), BODY, BODY, friction=mdr.Coulomb(0.5))
    loads, amplitudes = np.array([50.0, 20.0, 80.0, 1.0]), np.array([0.1e-6, 0.5e-6, 2.0e-6, 1.0e-9])
    t = np.linspace(0.0, 1.0, 401)
    cycles = [(u * np.cos(2 * np.pi * t), f + 0.0 * t) for u, f in zip(amplitudes, loads, strict=True)]
    shift, load = (np.concatenate(column) for column in zip(*cycles, strict=True))
    counted = []
    data = xr.Dataset(
        {
            "shift": ("step", np.append(shift, 0.0)),
            "tangential_force": ("step", np.append(np.roll(shift, -50), 0.0)),
            "normal_force": ("step", np.append(load, 1.0)),
        }
    )
    log = mdr.fretting_log(
        data, contact=pin, least="1 nm", progress=lambda done, total: counted.append((done, total))
    )
    assert counted[-1] == (log.data.sizes["cycle"],) * 2
    for i in range(log.data.sizes["cycle"]):
        loop = mdr.friction_loop(
            pin, float(log["amplitude"][i]), normal_force=float(log["normal_force"][i])
        ).data
        assert float(log["model_force"][i]) == pytest.approx(float(loop["force_amplitude"][0]), rel=1e-12)
        assert float(log["model_dissipated"][i]) == pytest.approx(
            float(loop["dissipated_per_cycle"][0]), rel=1e-11
        )


def test_machine_is_taken_off() -> None:
    test = record([2.0e-6, 2.0e-6, 2.0e-6])
    data = test.data[["shift", "tangential_force", "normal_force"]]
    soft = data.assign(shift=data["shift"] + data["tangential_force"] / 2e7)
    bare, log = mdr.fretting_log(data), mdr.fretting_log(soft, machine_stiffness="20 MN/m")
    for name in ("amplitude", "dissipated_per_cycle", "tangential_stiffness"):
        assert np.allclose(log[name], bare[name], rtol=1e-9), name
    assert (
        mdr.fretting_log(soft)["tangential_stiffness"].values[0]
        < 0.7 * bare["tangential_stiffness"].values[0]
    )
    assert np.allclose(
        mdr.fretting_log(soft)["dissipated_per_cycle"], bare["dissipated_per_cycle"], rtol=1e-6
    )


def test_wear_coefficient_of_a_record_returns() -> None:
    """The volume that the model wears gives back its coefficient."""
    test = record([0.9e-6, 0.9e-6, 0.9e-6], steps=2000)
    path = mdr.load("50 N") >> mdr.cycle(shift="0.9 um")
    worn = mdr.wear(BALL, path, coefficient="1e-6 mm^3/J", cycles=[1000.0], law="energy")
    volume = float(worn["worn_volume"][-1])
    log = mdr.fretting_log(test, worn_volume=volume, cycles=1000.0)
    assert log.data.attrs["wear_coefficient"] == pytest.approx(1e-15, rel=5e-3)
    assert "energy wear coefficient" in log.summary()


def test_map_of_running_conditions() -> None:
    log = mdr.fretting_log(record([0.5e-6, 2.0e-6, 2.0e-6]))
    chart = mdr.running_conditions(BALL, ["10 N", "50 N", "80 N"], record=log)
    begins = float(mdr.friction_loop(BALL, "1 um", normal_force="50 N").data["sliding_shift"])
    assert float(chart["sliding_shift"][1]) == pytest.approx(begins, rel=1e-12)
    assert chart.plot().axes[0].get_ylim() == (10.0, 80.0)
    data = xr.Dataset(
        {"shift": ("step", np.sin(np.arange(100.0))), "tangential_force": ("step", np.cos(np.arange(100.0)))}
    )
    with pytest.raises(mdr.ProblemError, match="normal_force"):
        mdr.running_conditions(BALL, [1.0], record=mdr.fretting_log(data))
    with pytest.raises(mdr.ProblemError, match="above 0 N"):
        mdr.running_conditions(BALL, [0.0])


def test_notes_say_what_a_friction_coefficient_is_not() -> None:
    both = record([0.3e-6, 0.3e-6, 2.0e-6, 2.0e-6])
    (note,) = [note for note in mdr.fretting_log(both).notes if "mu" in note]
    assert note == "mu is a lower limit in 1 of 3 cycles: not all of the contact slips there"
    sliding = record([2.0e-6, 2.0e-6])
    assert not [note for note in mdr.fretting_log(sliding).notes if "mu" in note]
    # in kN, but called N
    wrong = sliding.data.assign(tangential_force=sliding.data["tangential_force"] * 1e-3)
    wrong["tangential_force"].attrs["units"] = "N"
    (note,) = [note for note in mdr.fretting_log(wrong).notes if "mu" in note]
    assert "of forces of 25 mN under loads of 50 N; correct the unit" in note


def test_bad_records_are_refused() -> None:
    test = record([2.0e-6, 2.0e-6])
    bare = test.data[["shift", "tangential_force"]]
    swapped = xr.Dataset(
        {"shift": bare["tangential_force"].drop_attrs(), "tangential_force": bare["shift"].drop_attrs()}
    )
    in_kilonewtons = bare.assign(tangential_force=bare["tangential_force"].assign_attrs(units="kN"))
    slow = record([0.3e-6, 0.3e-6])
    free = mdr.Contact(mdr.Paraboloid("10 mm"), BODY, BODY)
    for wrong, message in (
        (lambda: mdr.fretting_log(test.data[["shift"]]), "tangential_force"),
        (lambda: mdr.fretting_log(bare, machine_stiffness=0.0), "machine_stiffness"),
        (lambda: mdr.fretting_log(bare, normal_force="0 N"), "normal_force"),
        (lambda: mdr.fretting_log(bare, worn_volume="-1 mm^3"), "worn_volume"),
        (lambda: mdr.fretting_log(bare, worn_volume="1 mm^3", cycles=0.0), "cycles"),
        (lambda: mdr.fretting_log(bare, cycles=100.0), "worn_volume too"),
        (lambda: mdr.fretting_log(bare, contact=BALL), "load"),
        (lambda: mdr.fretting_log(slow, contact=free), "no cycle slides"),
        (lambda: mdr.fretting_log(swapped), "are interchanged"),
        (lambda: mdr.fretting_log(in_kilonewtons, normal_force="50 N"), "median friction coefficient.*500"),
    ):
        with pytest.raises(mdr.ProblemError, match=message):
            wrong()


def test_shell(tmp_path: Path) -> None:
    case = tmp_path / "fretting.toml"
    case.write_text(
        """
[profile]
kind = "paraboloid"
radius = "10 mm"
[body]
kind = "elastic"
young = "210 GPa"
poisson = 0.3
[friction]
kind = "coulomb"
coefficient = 0.5
[[path]]
kind = "indent"
indentation = "1 um"
[[path]]
kind = "cycle"
shift = "0.2 um"
"""
    )
    table, profile = tmp_path / "worn.csv", tmp_path / "profile.csv"
    command = ["wear", str(case), "--coefficient", K, "--cycles", "1000, 100000"]
    done = CliRunner().invoke(app, [*command, "--profile", str(profile), "--output", str(table)])
    assert done.exit_code == 0, done.output
    assert "at the end of wear" in done.output
    assert table.exists()
    tip = mdr.read_profile(profile)
    assert tip.gap(0.05e-3) == pytest.approx(0.05e-3**2 / 20e-3, rel=1e-3)
    refused = CliRunner().invoke(app, [*command[:-3], "0 mm^3/(N m)", "--cycles", "10"])
    assert refused.exit_code != 0
    with_table = tmp_path / "worn.toml"
    with_table.write_text(f'[wear]\ncoefficient = "{K}"\ncycles = [1000, 100000]\n' + case.read_text())
    ran = CliRunner().invoke(app, ["run", str(with_table), "--json", "-o", str(tmp_path / "out")])
    assert ran.exit_code == 0, ran.output
    compared = CliRunner().invoke(
        app,
        ["verify", str(with_table), "--rings", "24", "--steps", "1", "--json", "-o", str(tmp_path / "out")],
    )
    assert compared.exit_code == 0, compared.output
    assert json.loads(compared.output)["verification"]["largest_difference"] < 0.05
    by_command = CliRunner().invoke(app, [*command, "--json"])
    study = json.loads(ran.output)["studies"]["wear"]
    assert study["worn_volume"] == json.loads(by_command.output)["study"]["worn_volume"]
    assert {"wear.csv", "wear.png"} <= {file.name for file in (tmp_path / "out").iterdir()}
    measured = tmp_path / "record.csv"
    record([2.0e-6, 2.0e-6]).to_csv(measured)
    chart = tmp_path / "map.png"
    command = ["fretting", str(measured), "--case", str(case), "--map", str(chart)]
    logged = CliRunner().invoke(app, [*command, "--json"])
    assert logged.exit_code == 0, logged.output
    assert chart.exists()
    without_case = CliRunner().invoke(app, ["fretting", str(measured), "--map", str(chart), "--json"])
    assert without_case.exit_code != 0
    assert "give --case" in without_case.output


def test_force_curves_of_rows_carry_their_load():
    """Where the stick radius has moved, springs are frozen one after the other."""
    steel = mdr.Elastic("210 GPa", 0.3)

    def joint(profile):
        return mdr.Contact(profile, steel, steel, friction=mdr.Coulomb(0.5))

    cycle = mdr.load("10 N") >> mdr.cycle(shift="0.3 um")
    worn = mdr.wear(joint(mdr.Sphere("10 mm")), cycle, coefficient="1e-6 mm^3/(N m)", cycles=1e8)
    for row in range(1, worn.data.sizes["cycles"], 3):
        loaded = mdr.solve(joint(worn.force_curve(row)), cycle)
        assert float(loaded["normal_force"][0]) == pytest.approx(10.0, rel=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_profiles_worn_by_gross_slip_are_solved_with_friction(seed):
    rng = np.random.default_rng(seed)
    size, depth = 10.0 ** rng.uniform(-5.0, 0.0), 10.0 ** rng.uniform(-5.0, -3.5)
    cycles, steel = 10.0 ** rng.uniform(0.5, 1.2), mdr.Elastic("210 GPa", 0.3)
    profile = (mdr.Paraboloid(size), mdr.Cone(slope=0.05))[seed % 2]
    contact = mdr.Contact(profile, steel, steel, friction=mdr.Coulomb(0.5))
    load = float(mdr.solve(contact, mdr.indent(depth * size))["normal_force"][0])
    shift = 0.75 * depth * size
    coefficient = math.pi * size * (depth * size) ** 2 / (4.0 * load * shift)
    path = mdr.load(load) >> mdr.cycle(shift=shift, cycles=1)
    worn = mdr.wear(contact, path, coefficient=coefficient, cycles=[cycles])
    again = mdr.Contact(worn.worn(), steel, steel, friction=mdr.Coulomb(0.5))
    result = mdr.solve(again, mdr.load(load) >> mdr.shift(0.1 * shift))
    radius = float(worn["contact_radius"][-1])
    assert float(result["contact_radius"][0]) == pytest.approx(radius, rel=2e-2)
    surface = worn.surface
    r, pressure = (
        surface[name].values.reshape(-1, surface["pressure"].shape[-1])[-1] for name in ("r", "pressure")
    )
    inner = (r > 0.2 * radius) & (r < 0.8 * radius)
    assert inner.any()
    np.testing.assert_allclose(result.field("pressure", r=r[inner], step=0), pressure[inner], rtol=5e-3)
