"""Shifts in the plane: springs with vectors, against brute force, the stack and their own invariances."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

import pymdr as mdr
from accuracy import reference_module
from common import STEEL
from pymdr.problem.codec import decode_case
from pymdr.workbench.cli.program import app
from pymdr.workbench.sliding import PlaneVerification

JOINT = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(0.3))
MODULI = mdr.effective_moduli(STEEL, STEEL)
springs = reference_module("vector_springs")


def random_history(seed, rows=40):
    rng = np.random.default_rng(seed)
    return 1e-6 * rng.uniform(0.2, 2.0, rows), 0.4e-6 * rng.uniform(-1.0, 1.0, (rows, 2))


def random_forces(seed, fraction):
    """Loads, and tangential forces of random directions up to a share of mu F_N."""
    rng = np.random.default_rng(seed)
    load = rng.uniform(1.0, 50.0, 60)
    size, angle = 0.3 * load * rng.uniform(0.0, fraction, 60), rng.uniform(0.0, 2.0 * np.pi, 60)
    return load, np.stack([size * np.cos(angle), size * np.sin(angle)], axis=1)


def divided(values, parts):
    """Every straight step from the row before in equal parts."""
    before = np.concatenate([np.zeros((1, *values.shape[1:])), values[:-1]])
    part = np.arange(1, parts + 1).reshape(-1, *[1] * (values.ndim - 1)) / parts
    return np.concatenate([a + (b - a) * part for a, b in zip(before, values, strict=True)])


def brute_force(depth, shift, n=2000, parts=400):
    """Springs by small steps that set every spring back to its limit."""
    E, G, mu = MODULI.normal, MODULI.tangential, 0.3
    radius = math.sqrt(10e-3 * depth.max())
    x = (np.arange(n) + 0.5) / n * radius
    g = x**2 / 10e-3
    q, forces, d0 = np.zeros((2, n)), [], 0.0
    fine_d, fine_u = divided(depth, parts), divided(shift, parts)
    for i, (d, du) in enumerate(zip(fine_d, np.diff(fine_u, axis=0, prepend=0.0), strict=True)):
        touched = np.clip((d - g) / (d - d0), 0.0, 1.0) if d > d0 else np.ones(n)
        q += G * du[:, None] * touched
        limit = mu * E * np.maximum(d - g, 0.0)
        q *= np.minimum(1.0, limit / np.maximum(np.hypot(*q), 1e-300))
        d0 = d
        if (i + 1) % parts == 0:
            forces.append(2.0 * radius / n * q.sum(axis=1))
    return np.array(forces)


def orbit(rows, rng):
    """A circle of random centre, radius and speed."""
    angle = rng.uniform(0.1, 1.0) * np.arange(rows)
    return rng.uniform(-0.5, 0.5, 2) + rng.uniform(0.2, 1.5) * np.stack(
        [np.cos(angle), np.sin(angle)], axis=1
    )


def largest(result, mu=0.3):
    return mu * float(np.max(result["normal_force"].values))


class TestForce:
    def test_a_random_history_against_brute_force(self):
        d, u = random_history(0, 5)
        result = mdr.solve(JOINT, mdr.Path(indentation=d, shift=u))
        coarse, fine = (brute_force(d, u, parts=parts) for parts in (200, 400))
        # the brute force is of first order in its steps
        error = np.abs(result["tangential_force"].values - (2.0 * fine - coarse)).max() / largest(result)
        assert error < 2e-4

    @given(st.integers(0, 1000), st.floats(0.0, 2 * math.pi))
    @settings(max_examples=10, deadline=None)
    def test_rotation_and_mirror(self, seed, angle):
        d, u = random_history(seed, 12)
        turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
        plain, turned, mirrored = (
            mdr.solve(JOINT, mdr.Path(indentation=d, shift=shift)) for shift in (u, u @ turn.T, u * [1, -1])
        )
        force, size = plain["tangential_force"].values, largest(plain)
        assert np.abs(turned["tangential_force"].values - force @ turn.T).max() < 1e-10 * size
        assert np.abs(mirrored["tangential_force"].values - force * [1, -1]).max() < 1e-13 * size
        assert np.allclose(turned["dissipated_energy"], plain["dissipated_energy"], rtol=1e-9)

    @given(st.integers(0, 1000), st.floats(-9, 0))
    @settings(max_examples=10, deadline=None)
    def test_sub_steps_change_nothing_at_any_size(self, seed, power):
        d, u = random_history(seed, 12)
        size = 10.0**power / 1e-2
        joint = mdr.Contact(mdr.Paraboloid(1e-2 * size), STEEL, STEEL, friction=mdr.Coulomb(0.3))
        d, u = d * size, u * size
        whole = mdr.solve(joint, mdr.Path(indentation=d, shift=u))
        parts = mdr.solve(joint, mdr.Path(indentation=divided(d, 7), shift=divided(u, 7)), keep=7)
        number = [note for note in whole.notes if "springs" in note]
        if number == [note for note in parts.notes if "springs" in note]:
            assert np.abs(whole["tangential_force"] - parts["tangential_force"]).max() < 1e-13 * largest(
                whole
            )
            assert np.allclose(whole["dissipated_energy"], parts["dissipated_energy"], rtol=1e-8)

    def test_energy_balance_at_constant_depth(self):
        _, u = random_history(3, 12)
        path = mdr.indent("1 um") >> mdr.Path(shift=divided(u, 2000))
        result = mdr.solve(JOINT, path)
        force, shift = (result[name].values for name in ("tangential_force", "shift"))
        work = np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(shift, axis=0))
        kept = float(result["stored_tangential_energy"][-1] + result["dissipated_energy"][-1])
        assert abs(work / kept - 1) < 1e-5  # trapezoids

    def test_straight_shift_is_cattaneo_mindlin(self):
        # the path turns only after the first row, so that springs follow it
        path = mdr.indent("1 um") >> mdr.Path(shift=0.5e-7 * np.array([[3.0, 4.0], [0.0, 4.0]]))
        result = mdr.solve(JOINT, path)
        lag = MODULI.tangential * 2.5e-7 / (0.3 * MODULI.normal)
        load = 4 / 3 * MODULI.normal * math.sqrt(10e-3) * np.array([1e-6, 1e-6 - lag]) ** 1.5
        expected = 0.3 * (load[0] - load[1])
        assert np.allclose(result["tangential_force"][1], expected * np.array([0.6, 0.8]), rtol=1e-4)
        assert np.isclose(result["stick_radius"][1], math.sqrt(10e-3 * (1e-6 - lag)), rtol=1e-3)

    def test_order_of_rows_of_a_circle(self):
        ends = []
        for steps in (32, 64, 128, 256):
            path = mdr.indent("1 um") >> mdr.circle(shift="0.3 um", steps=steps)
            result = mdr.solve(JOINT, path)
            ends.append(result["tangential_force"][-1].values / largest(result))
        changes = [np.hypot(*(a - b)) for a, b in pairwise(ends)]
        assert changes[0] / changes[1] == pytest.approx(4.0, rel=0.15)

    @pytest.mark.parametrize("seeds", [range(3), pytest.param(range(3, 1000), marks=pytest.mark.long)])
    def test_random_histories_are_those_of_20000_springs_within_the_claim(self, seeds):
        for seed in seeds:
            rng = np.random.default_rng(1000 + seed)
            size, scale = 10.0 ** rng.uniform(-9, 0), 10.0 ** rng.uniform(-1.5, 0.7)
            d, u = random_history(seed)
            if seed % 3 == 0:  # a circle at constant depth
                d, u = d[:1].repeat(d.size), 0.4e-6 * orbit(d.size, rng)
            d, u, radius = d * size, u * size * scale, 10e-3 * size
            joint = mdr.Contact(mdr.Paraboloid(radius), STEEL, STEEL, friction=mdr.Coulomb(0.3))
            result = mdr.solve(joint, mdr.Path(indentation=d, shift=u))
            measured = seed % 50 == 0
            force, work = springs.many_springs(
                d,
                u,
                (1.0 / radius, 2.0),
                (MODULI.normal, MODULI.tangential, 0.3),
                nodes=24 if measured else 0,
            )
            off = np.hypot(*(result["tangential_force"].values - force).T) / largest(result)
            assert off.max() < 2e-4
            number, dissipated = springs.numerical_errors(result)
            assert off.max() <= number + 1e-8
            energy = result["dissipated_energy"].values
            assert not measured or np.abs(energy - work).max() <= (dissipated + 1e-7) * energy.max()


class TestLines:
    @pytest.mark.parametrize("direction", [(1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])
    def test_a_line_is_the_stack_to_the_last_digit(self, direction):
        d, u = random_history(5)
        sense = sum(direction)
        single = mdr.solve(JOINT, mdr.Path(indentation=d, shift=sense * (sense * u[:, 0])))
        plane = mdr.solve(JOINT, mdr.Path(indentation=d, shift=u[:, :1] * direction))
        force = plane["tangential_force"].values @ np.array(direction)
        assert np.array_equal(force, single["tangential_force"].values)
        for name in ("dissipated_energy", "stick_radius", "tangential_stiffness"):
            assert np.array_equal(plane[name], single[name])
        assert np.array_equal(
            plane.field("shear_traction", r="50 um").values[:, 0] @ np.array(direction),
            single.field("shear_traction", r="50 um").values[0],
        )

    @settings(deadline=None)
    @given(st.floats(-9.0, 0.0), st.floats(0.008, 0.9))
    def test_the_work_of_narrow_slip_is_that_of_a_line(self, size, fraction):
        """The zone of slip is narrower than the first cells; the shift turns too little to change the work."""
        depth = np.full(6, 1e-6 * 10.0**size)
        joint = replace(JOINT, profile=mdr.Paraboloid(10e-3 * 10.0**size))
        along = fraction * 0.3 * MODULI.normal / MODULI.tangential * depth * np.linspace(0.0, 1.0, 6)
        turned = np.stack([along, 1e-3 * along**2 / along[-1]], axis=1)
        single = mdr.solve(joint, mdr.Path(indentation=depth, shift=along))
        plane = mdr.solve(joint, mdr.Path(indentation=depth, shift=turned))
        work = single["dissipated_energy"].values[-1]
        assert plane["dissipated_energy"].values[-1] == pytest.approx(work, rel=0.05)

    def test_any_line(self):
        d, u = random_history(6)
        direction = np.array([math.cos(0.7), math.sin(0.7)])
        single = mdr.solve(JOINT, mdr.Path(indentation=d, shift=u[:, 0]))
        plane = mdr.solve(JOINT, mdr.Path(indentation=d, shift=np.outer(u[:, 0], direction)))
        assert "exactly along it" in plane.notes[-1]
        assert np.allclose(
            plane["tangential_force"].values @ direction, single["tangential_force"], rtol=1e-12
        )


class TestControls:
    def test_forces_give_their_shifts_back(self):
        d, u = random_history(7, 30)
        u = 0.4 * u
        moved = mdr.solve(JOINT, mdr.Path(indentation=d, shift=u))
        force = moved["tangential_force"].values
        pulled = mdr.solve(JOINT, mdr.Path(indentation=d, tangential_force=0.98 * force))
        again = mdr.solve(JOINT, mdr.Path(indentation=d, shift=pulled["shift"].values))
        assert np.abs(again["tangential_force"].values - 0.98 * force).max() < 1e-4 * largest(moved)

    @pytest.mark.parametrize("seed", [6, 19, 33, 44, 56])
    @pytest.mark.parametrize("fraction", [0.98, 1.0 - 1e-6])
    def test_loads_and_forces_that_jump_together(self, seed, fraction):
        load, force = random_forces(seed, fraction)
        result = mdr.solve(JOINT, mdr.Path(normal_force=load, tangential_force=force))
        assert result.status is mdr.Status.COMPLETED
        assert np.allclose(result["tangential_force"], force, rtol=0, atol=1e-9 * largest(result))

    @pytest.mark.long
    def test_a_hundred_histories_of_loads_and_forces(self):
        for seed in range(100):
            load, force = random_forces(seed, 0.98)
            result = mdr.solve(JOINT, mdr.Path(normal_force=load, tangential_force=force))
            assert result.status is mdr.Status.COMPLETED
            assert np.allclose(result["tangential_force"], force, rtol=0, atol=1e-9 * largest(result))

    def test_every_force_below_friction_is_carried(self):
        # few springs touch in the second row: they carry mu F_N but for their number
        load, fraction = np.array([50.0, 0.5, 20.0]), np.array([0.5, 1.0 - 1e-6, 1.0 - 1e-6])
        force = 0.3 * (load * fraction)[:, None] * np.array([[1.0, 0.0], [0.6, 0.8], [0.0, -1.0]])
        carried = mdr.solve(JOINT, mdr.Path(normal_force=load, tangential_force=force))
        assert carried.status is mdr.Status.COMPLETED
        glides = mdr.solve(JOINT, mdr.Path(normal_force=load, tangential_force=force * (1.0 + 2e-6)))
        assert glides.status is mdr.Status.GLIDING

    def test_a_force_above_friction_glides(self):
        path = mdr.load("50 N") >> mdr.drag(("3 N", "2 N")) >> mdr.drag(("12 N", "14 N"), steps=4)
        result = mdr.solve(JOINT, path)
        assert result.status.name == "GLIDING"
        assert np.isnan(result["tangential_force"][-1]).all()
        assert np.isfinite(result["normal_force"]).all()
        assert not result.claims["shift"].where[-1]

    @pytest.mark.parametrize("friction", [0.3, 0.0])
    def test_a_body_glides_on_a_line_as_next_to_it(self, friction):
        joint = replace(JOINT, friction=mdr.Coulomb(friction))
        load = np.array([50.0, 50.0, 50.0, 30.0, 30.0, 80.0])
        force = np.outer([3.0, 6.0, -8.0, 9.5, 2.0, 1.0], [0.6, 0.8])
        end = mdr.shift(("0.6 um", "0.8 um"), steps=2) >> mdr.load("20 N", steps=2)
        results = []
        for turned in (0.0, 1e-9):
            force[0] += turned * force[0, ::-1] * [-1.0, 1.0]
            results.append(mdr.solve(joint, mdr.Path(normal_force=load, tangential_force=force) >> end))
        on, off = results
        assert "exactly along it" in on.notes[-1]
        assert on.status is off.status is mdr.Status.GLIDING
        assert all(any("above mu F_N determines no shift" in note for note in one.notes) for one in results)
        for name in set(on.data) & set(off.data):
            assert np.array_equal(on.claims[name].where, off.claims[name].where)
            size = np.nanmax(np.abs(on[name]), initial=0.0)
            assert np.allclose(on[name], off[name], rtol=0, atol=1e-3 * size, equal_nan=True)
        known = on.claims["normal_force"].where if not friction else np.arange(10) < 3
        assert np.array_equal(on.claims["stick_radius"].where, known & (friction > 0.0))
        assert on["normal_force"].values.tolist() == [*load, 80.0, 80.0, 50.0, 20.0]
        if friction:
            assert np.isfinite(on.field("slip", r=0.0, step=2)).all()

    def test_one_number_above_friction_is_refused(self):
        with pytest.raises(
            mdr.PathError, match=r"16 N in row 2 of leg 2: friction carries at most mu F_N = 15 N"
        ):
            mdr.solve(JOINT, mdr.load("50 N") >> mdr.drag("16 N", steps=2) >> mdr.load("10 N"))

    @pytest.mark.parametrize("friction", [0.3, math.inf, 0.0])
    def test_a_body_that_lifts_while_it_moves(self, friction):
        joint = replace(JOINT, friction=mdr.Coulomb(friction))
        depth = 1e-6 * np.array([1.0, -1.0, 1.0, 1.5, -0.2, -0.5, 2.0])
        shift = 1e-7 * np.outer([1.0, 2.0, 3.0, 8.0, 12.0, 2.0, 4.0], [1.0, 0.0])
        on = mdr.solve(joint, mdr.Path(indentation=depth, shift=shift))
        shift[0, 1] = 1e-16
        off = mdr.solve(joint, mdr.Path(indentation=depth, shift=shift))
        for name in ("tangential_force", "slip_distance", "dissipated_energy"):
            size = float(np.abs(on[name]).max())
            assert np.allclose(on[name], off[name], rtol=0, atol=1e-4 * size), name

    def test_load_and_shift_together_do_not_depend_on_the_rows(self):
        ends = []
        for steps in (1, 4, 16):
            path = (
                mdr.load("5 N")
                >> mdr.shift(("0.1 um", 0.0))
                >> mdr.ramp(normal_force="50 N", shift=("0.1 um", "0.4 um"), steps=steps)
            )
            ends.append(mdr.solve(JOINT, path)["tangential_force"][-1].values)
        assert np.ptp(ends, axis=0).max() < 1e-4 * 15.0

    def test_gross_sliding_counts_its_distance(self):
        path = mdr.indent("1 um") >> mdr.Path(shift=1e-6 * np.array([[0.0, 5.0], [5.0, 5.0]]))
        result = mdr.solve(JOINT, path)
        slides = 0.3 * MODULI.normal / MODULI.tangential * 1e-6
        assert result["stick_radius"][1] == 0.0
        assert np.isclose(result["slip_distance"][1], 5e-6 - slides, rtol=1e-12)
        assert np.isclose(np.hypot(*result["tangential_force"][1]), largest(result), rtol=1e-4)

    def test_cycle_about_a_drag(self):
        path = mdr.load("50 N") >> mdr.drag(("3 N", "2 N")) >> mdr.cycle(shift=("0.1 um", "0.2 um"), steps=8)
        result = mdr.solve(JOINT, path)
        assert np.allclose(result["shift"][-1], result["shift"][1], rtol=1e-12)

    def test_without_slip(self):
        stuck = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(math.inf))
        result = mdr.solve(
            stuck, mdr.indent("1 um") >> mdr.Path(shift=1e-6 * np.array([[1.0, 0.0], [1.0, 2.0]]))
        )
        stiffness = 2.0 * MODULI.tangential * math.sqrt(10e-3 * 1e-6)
        assert np.allclose(result["tangential_force"][-1], stiffness * np.array([1e-6, 2e-6]), rtol=1e-9)

    def test_a_force_curve(self):
        depth = np.linspace(0.0, 2e-6, 60)
        load = 4 / 3 * MODULI.normal * math.sqrt(10e-3) * depth**1.5
        curve = mdr.ForceCurve(indentation=depth, force=load, modulus=MODULI.normal)
        contact = mdr.Contact(curve, STEEL, STEEL, friction=mdr.Coulomb(0.3))
        path = mdr.indent("1 um") >> mdr.circle(shift="0.2 um", steps=32)
        known, one = (mdr.solve(c, path)["tangential_force"].values for c in (JOINT, contact))
        assert np.abs(known - one).max() < 2e-3 * np.abs(known).max()

    def test_travel_of_a_machine(self):
        path = mdr.travel("4 um") >> mdr.circle(shift="0.2 um", steps=16)
        result = mdr.solve(JOINT, path, machine_stiffness="20 MN/m")
        assert np.allclose(result["travel"], 4e-6, rtol=1e-12)
        assert np.isfinite(result["tangential_force"]).all()


class TestReading:
    path = mdr.load("50 N") >> mdr.circle(shift="0.4 um", steps=64)

    def test_fields_carry_the_force(self):
        result = mdr.solve(JOINT, self.path)
        r = np.linspace(0.0, 1.0, 2001) * float(result["contact_radius"][-1])
        tau = result.field("shear_traction", r=r)
        assert tau.dims == ("axis", "r")
        force = np.trapezoid(2.0 * np.pi * r * tau.values, r, axis=1)
        assert np.allclose(force, result["tangential_force"][-1], atol=2e-4 * largest(result))
        inside = r < 0.9 * float(result["stick_radius"][-1])
        assert np.abs(result.field("slip", r=r[inside])).max() < 1e-3 * 0.4e-6

    def test_saved_and_opened(self, tmp_path):
        result = mdr.solve(JOINT, self.path)
        result.save(tmp_path / "circle.nc")
        opened = mdr.open_result(tmp_path / "circle.nc")
        assert opened.path == result.path
        assert np.array_equal(opened["shift"], result["shift"])
        assert opened["shift"].dims == ("step", "axis")
        assert np.array_equal(opened.field("slip", r="1 um"), result.field("slip", r="1 um"), equal_nan=True)

    def test_columns_of_files(self, tmp_path):
        result = mdr.solve(JOINT, self.path, keep=8)
        result.to_csv(tmp_path / "circle.csv")
        header = (tmp_path / "circle.csv").read_text().splitlines()[0]
        assert "shift_x [m],shift_y [m],tangential_force_x [N],tangential_force_x_error" in header
        assert {"shift_x", "tangential_force_y"} <= set(result.to_dataframe())
        assert "tangential force along y" in result.summary()

    def test_figures(self):
        assert set(mdr.solve(JOINT, self.path).figures()) == {"section", "plane", "slip"}

    def test_claims(self):
        result = mdr.solve(JOINT, self.path)
        assert result.claims["shift"].level is mdr.Level.EXACT
        claim = result.claims["tangential_force"]
        assert claim.level is mdr.Level.APPROXIMATE
        assert "vector friction" in claim.reason
        assert claim.error.max() <= 1.0
        assert claim.error[-1] > 0.05


class TestRefused:
    @pytest.mark.parametrize(
        "make",
        [
            lambda: mdr.shift(("1 um", "1 um", "1 um")),
            lambda: mdr.Path(shift=np.zeros((4, 3))),
            lambda: mdr.shift(("1 um", "1 N")),
            lambda: mdr.circle(shift="-1 um"),
            lambda: mdr.circle(shift="1 um", tangential_force="1 N"),
            lambda: mdr.circle(shift="1 um", turns=0),
            lambda: mdr.lissajous(shift="1 um"),
            lambda: mdr.lissajous(shift=("1 um", "1 um"), frequencies=(0, 1)),
            lambda: mdr.Path(shift=np.zeros((0, 2))),
        ],
    )
    def test_bad_input(self, make):
        with pytest.raises(mdr.PymdrError):
            make()

    @pytest.mark.parametrize(
        ("contact", "words"),
        [
            (mdr.Contact(mdr.Sphere("1 mm"), STEEL), "friction="),
            (mdr.Contact(mdr.Sphere("1 mm"), STEEL, adhesion=mdr.JKR("50 mJ/m^2")), "friction="),
            (
                mdr.Contact(
                    mdr.Sphere("1 mm"),
                    mdr.Viscoelastic(mdr.Maxwell("1 MPa", "1 s"), poisson=0.5),
                    friction=mdr.Coulomb(0.3),
                ),
                "memory",
            ),
        ],
    )
    def test_other_laws(self, contact, words):
        path = mdr.indent("1 um", duration="1 s") >> mdr.ramp(shift=("1 um", "1 um"), duration="1 s")
        with pytest.raises(mdr.ProblemError, match=words):
            mdr.solve(contact, path)

    def test_torsion_and_single_numbers(self):
        with pytest.raises(mdr.ProblemError, match="superpose"):
            mdr.solve(JOINT, mdr.indent("1 um") >> mdr.shift(("1 um", "1 um")) >> mdr.twist("1 mrad"))
        with pytest.raises(mdr.PathError, match="leg 3 gives shift as one number"):
            mdr.solve(JOINT, mdr.indent("1 um") >> mdr.shift(("1 um", "1 um")) >> mdr.shift("1 um"))

    def test_wear_and_stress(self):
        path = mdr.indent("1 um") >> mdr.cycle(shift=("0.2 um", "0.1 um"))
        with pytest.raises(mdr.ProblemError, match="one line"):
            mdr.wear(JOINT, path, coefficient="1e-5 mm^3/(N m)", cycles=10, law="archard")
        for leg in (mdr.circle(shift="0.2 um", steps=8), mdr.shift(("0.2 um", "0.1 um"))):
            result = mdr.solve(JOINT, mdr.indent("1 um") >> leg)
            assert result.claims["stress"].level is mdr.Level.NOT_VALID
            with pytest.raises(mdr.NotValidError, match="shifts in the plane is not computed"):
                result.field("stress", x=[0.0], y=[0.0], z=["10 um"])


CASE = {
    "profile": {"kind": "paraboloid", "radius": "10 mm"},
    "body": {"kind": "elastic", "young": "210 GPa", "poisson": 0.3},
    "counterbody": {"kind": "elastic", "young": "210 GPa", "poisson": 0.3},
    "friction": {"kind": "coulomb", "coefficient": 0.3},
}
LOAD = {"kind": "load", "normal_force": "50 N"}


class TestCases:
    @pytest.mark.parametrize(
        ("leg", "path"),
        [
            (
                {"kind": "circle", "shift": "0.3 um", "turns": -2, "steps": 24, "center": ["0.1 um", 0]},
                mdr.circle(shift="0.3 um", turns=-2, steps=24, center=("0.1 um", 0.0)),
            ),
            ({"kind": "circle", "tangential_force": "5 N"}, mdr.circle(tangential_force="5 N")),
            (
                {
                    "kind": "lissajous",
                    "shift": ["0.3 um", 1e-7],
                    "frequencies": [2, 3],
                    "phase": "0.5 rad",
                    "turns": 0.5,
                },
                mdr.lissajous(shift=("0.3 um", 1e-7), frequencies=(2, 3), phase=0.5, turns=0.5),
            ),
        ],
    )
    def test_orbits_are_those_of_python(self, leg, path):
        _, contact, decoded = decode_case({**CASE, "path": [LOAD, leg]})
        assert contact == JOINT
        assert decoded == mdr.load("50 N") >> path

    @pytest.mark.parametrize(
        ("leg", "words"),
        [
            ({"kind": "circle"}, "give either shift or tangential_force"),
            ({"kind": "circle", "shift": ["1 um", "1 um"]}, "a number or a text with its unit"),
            ({"kind": "circle", "radius": "1 um"}, "unknown key; use one of kind, shift"),
            ({"kind": "circle", "shift": "-1 um"}, "must be above 0 m"),
            ({"kind": "circle", "shift": "1 um", "steps": 0}, "at least 1"),
            ({"kind": "lissajous", "shift": ["1 um"]}, "pair of amplitudes"),
            ({"kind": "shift", "shift": ["1 um"]}, "has 1 component; give one value, or a pair"),
            ({"kind": "circel", "shift": "1 um"}, "did you mean 'circle'"),
        ],
    )
    def test_mistakes_are_named(self, leg, words):
        with pytest.raises(mdr.CaseError, match=words):
            decode_case({**CASE, "path": [LOAD, leg]})

    def test_from_the_shell_to_figures(self, tmp_path):
        case = tmp_path / "circle.toml"
        tables = [
            f"[{name}]\n" + "\n".join(f"{key} = {value!r}" for key, value in table.items())
            for name, table in CASE.items()
        ]
        legs = "[[path]]\nkind = 'load'\nnormal_force = '50 N'\n[[path]]\nkind = 'circle'\nshift = '0.3 um'\nsteps = 12\n"
        case.write_text("\n".join([*tables, legs]))
        ran = CliRunner().invoke(app, ["run", str(case), "-o", str(tmp_path / "out")])
        assert ran.exit_code == 0
        assert "tangential force along y" in ran.output
        assert {"plane.png", "slip.png"} <= {file.name for file in (tmp_path / "out").rglob("*.png")}
        outcome = CliRunner().invoke(
            app, ["verify", str(case), "-o", str(tmp_path / "v"), "--cells", "12", "--steps", "9"]
        )
        assert outcome.exit_code == 0
        assert "largest difference of the tangential force" in outcome.output
        assert (tmp_path / "v" / "verify.png").is_file()


class TestVerified:
    @pytest.mark.parametrize(("amplitude", "least", "most"), [(0.6, 0.03, 0.045), (3.0, 0.0, 0.015)])
    def test_circles_on_a_grid_differ_as_the_claim_says(self, amplitude, least, most):
        slides = 0.3 * MODULI.normal / MODULI.tangential * 1e-6
        path = mdr.indent("1 um") >> mdr.circle(shift=amplitude * slides, steps=16)
        compared = mdr.verify(JOINT, path, elements=16, steps=18)
        assert isinstance(compared, PlaneVerification)
        assert least <= compared.largest_difference < most
        assert compared.data.sizes["step"] == 18
        assert "shift_y" in compared.data
        assert compared.plot().axes
        assert "tangential force along y" in compared.summary()

    @pytest.mark.parametrize("poisson", [0.0, 0.3, 0.5])
    def test_circles_differ_as_the_claim_says_for_any_poisson_ratio(self, poisson):
        body = mdr.Elastic("210 GPa", poisson)
        joint, moduli = replace(JOINT, body=body, counterbody=body), mdr.effective_moduli(body, body)
        slides = 0.3 * moduli.normal / moduli.tangential * 1e-6
        for radius, stated in ((0.3, 0.6), (0.6, 3.7), (0.9, 15.0), (0.95, 16.0), (1.5, 3.0), (3.0, 1.1)):
            path = mdr.indent("1 um") >> mdr.circle(shift=radius * slides, steps=16)
            compared = mdr.verify(joint, path, elements=16, steps=18)
            # 16 cells have a third of a percent of their own
            assert 100.0 * compared.largest_difference == pytest.approx(stated, rel=0.1, abs=0.3)

    def test_a_turn_of_the_path_turns_the_differences(self):
        shift = 0.2e-6 * np.array([[1.0, 0.0], [1.0, 1.0], [-0.5, 0.5]])
        plain, turned = (
            mdr.verify(JOINT, mdr.indent("1 um") >> mdr.Path(shift=u), elements=12)
            for u in (shift, shift[:, ::-1] * [-1.0, 1.0])
        )
        for end in ("mdr", "grid"):
            x, y = (plain.data[f"tangential_force_{axis}_{end}"].values for axis in "xy")
            assert np.allclose(turned.data[f"tangential_force_x_{end}"], -y, atol=1e-6 * np.abs(x).max())

    def test_gliding_is_refused(self):
        path = mdr.load("50 N") >> mdr.drag(("3 N", "2 N")) >> mdr.drag(("12 N", "14 N"))
        with pytest.raises(mdr.PathError, match="slides; prescribe the shift"):
            mdr.verify(JOINT, path)
