"""A ball on a wall by the method and by LAMMPS, which runs as a program of its own where it is installed."""

import math
from collections.abc import Iterator

import numpy as np

import pymdr as mdr
from benchmarks.validation.rows import REFERENCES, Row, absent, claim_of, difference
from pymdr.independent.lammps import Ball, collided, find_lammps, moved, version_of

_BALL = Ball(0.01)
_BODY = mdr.Elastic(1e9, 0.3)
_ROUND = mdr.Paraboloid(_BALL.radius)
_ELASTIC = "1e9 0 0.3"
"""Young's modulus in Pa, damping and Poisson's ratio."""
_YIELDS = "balls that yield, loading and unloading"


def recorded() -> Iterator[Row]:
    """Forces of a ball that yields, as LAMMPS gave them once."""
    given, body = _yielding()
    rows = np.array(REFERENCES["mdr_plastic_Y2e7"]["expected"]["rows"])
    rows = rows[rows[:, 1] > 0.0]
    n, deepest = given["steps"], given["depth"]
    path = mdr.indent(deepest, steps=n) >> mdr.indent(0.0, steps=n)
    result = mdr.solve(mdr.Contact(mdr.Sphere(given["R"]), body), path)
    d = result["indentation"].values
    halves = np.where(np.arange(len(rows)) <= int(rows[:, 0].argmax()), 0, n)
    chosen = [h + int(np.argmin(np.abs(d[h : h + n] - x))) for h, x in zip(halves, rows[:, 0], strict=True)]
    off = difference(result["normal_force"].values[chosen], rows[:, 1])
    claimed = claim_of(result, "normal_force", chosen)
    yield Row(_YIELDS, "normal force", "LAMMPS, recorded", off, claimed)


def particles() -> Iterator[Row | str]:
    """Histories and a collision, each by both programs in this run."""
    yield from recorded()
    try:
        program = find_lammps()
    except mdr.PymdrError:
        yield absent("balls on a wall", "normal force", "LAMMPS")
        return
    source = version_of(program)
    up = np.linspace(0.0, 1.0, 81)[1:]
    there_and_back = 1e-4 * np.concatenate([up, up[-2::-1], [0.0]])
    away = 5e-6 * np.concatenate([up, np.linspace(1.0, -0.6, 161)[1:]])
    hertz = mdr.Contact(_ROUND, _BODY, _BODY)
    # surface energies of the program are half of the work of adhesion; it lets JKR go at the fold of force control
    jkr = mdr.Contact(_ROUND, _BODY, _BODY, adhesion=mdr.JKR(4.0))
    dmt = mdr.Contact(_ROUND, _BODY, _BODY, adhesion=mdr.DMT(4.0))
    fold = float(mdr.pull_off(jkr, machine_stiffness=0.0).indentation)
    stable = away[(away > fold) | (np.arange(away.size) <= away.argmax())]
    for physics, model, contact, depth in (
        ("Hertz, loading and unloading", f"hertz/material {_ELASTIC}", hertz, there_and_back),
        ("JKR, until the largest pull", f"jkr {_ELASTIC} 2", jkr, stable),
        ("DMT", f"dmt {_ELASTIC} 2", dmt, away),
    ):
        there = moved(program, f"{model} tangential mindlin NULL 0 0.3", _BALL, depth, 0.0 * depth)
        result = mdr.solve(contact, mdr.Path(indentation=depth))
        yield _row(physics, result, "normal_force", there.normal, source)
    shift = 1e-5 * np.concatenate([0.0 * up, up])
    depth = 1e-4 * np.concatenate([up, up**0.0])
    there = moved(program, f"hertz/material {_ELASTIC} tangential mindlin NULL 0 1e6", _BALL, depth, shift)
    stuck = mdr.Contact(_ROUND, _BODY, _BODY, friction=mdr.Coulomb(math.inf))
    result = mdr.solve(stuck, mdr.Path(indentation=depth, shift=shift))
    yield _row("a ball that sticks, shifted", result, "tangential_force", there.tangential, source)
    yield from _yields(program, source)


def _yields(program: str, source: str) -> Iterator[Row]:
    """A ball that yields: a history, and its rebound."""
    given, body = _yielding()
    model = f"mdr {given['E']:g} {given['nu']:g} {given['Y']:g} 0 0.5 0 damping mdr 1 tangential linear_history 0 0 0"
    up = np.linspace(0.0, 1.0, given["steps"] + 1)
    depth = given["depth"] * np.concatenate([up[1:], up[-2::-1]])
    # the apparent radius grows with the steps of the program, which are the rows of the method
    there = moved(program, model, Ball(given["R"]), depth, 0.0 * depth, steps=1)
    result = mdr.solve(mdr.Contact(mdr.Sphere(given["R"]), body), mdr.Path(indentation=depth))
    yield _row(_YIELDS, result, "normal_force", there.normal, source)
    # an impact has no steps over which the radius could grow
    plain = mdr.ElasticPlastic(given["E"], given["nu"], yield_strength=given["Y"], wall_factor=True)
    hit = mdr.impact(mdr.Contact(mdr.Sphere(_BALL.radius), plain), mass=_BALL.mass, speed=2.0)
    back = collided(program, model, _BALL, (0.0, 2.0), 1.5 * float(hit["contact_time"]), 40_000)
    yield Row(
        "a ball that yields, thrown at 2 m/s",
        "restitution",
        source,
        difference(hit.restitution, back.velocity[1] / 2.0),
        claim_of(hit, "restitution"),
    )


def _yielding() -> tuple[dict, mdr.ElasticPlastic]:
    """Inputs of the recorded forces, and their body."""
    given = REFERENCES["mdr_plastic_Y2e7"]["inputs"]
    body = mdr.ElasticPlastic(
        given["E"], given["nu"], yield_strength=given["Y"], apparent_radius=True, wall_factor=True
    )
    return given, body


def _row(physics: str, result: mdr.Result, name: str, there: np.ndarray, source: str) -> Row:
    """Forces along a history; they cross 0, and their difference is relative to the largest."""
    off = float(np.max(np.abs(result[name].values - there)) / np.max(np.abs(there)))
    return Row(physics, name.replace("_", " "), source, off, claim_of(result, name, slice(None)))
