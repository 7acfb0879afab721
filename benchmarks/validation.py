"""Validation of every physics: recomputes the tables of docs/validation.md, each number from a solve of this run.

``python -m benchmarks.validation`` prints the tables and writes them into the page; ``--random 0`` omits the random problems. The reference values that are no formula
here are those of tests/reference/refs.json, which states how each was computed.
"""

import argparse
import json
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import pymdr as mdr
from benchmarks import validation_figures

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "validation.md"
REFERENCES = {
    entry["id"]: entry
    for entry in json.loads((ROOT / "tests" / "reference" / "refs.json").read_text(encoding="utf-8"))["refs"]
}
UNIT = mdr.Elastic(1.0, 0.0)
"""E* = 1 Pa on a rigid body."""
ROUNDING = 1e-14
"""Below it a difference or an error is called rounding."""


@dataclass(frozen=True)
class Row:
    """One comparison; errors are relative."""

    physics: str
    quantity: str
    source: str
    actual: float
    claimed: str

    def __str__(self) -> str:
        actual = f"{self.actual:.1e}" if self.actual > ROUNDING else "rounding"
        return f"| {self.physics} | {self.quantity} | {self.source} | {self.claimed} | {actual} |"


def difference(value: object, truth: object) -> float:
    """Largest relative difference."""
    values, truths = np.atleast_1d(np.asarray(value, float)), np.atleast_1d(np.asarray(truth, float))
    worst = float(np.max(np.abs(values / truths - 1.0)))
    if not math.isfinite(worst):
        raise ValueError(f"values {values} cannot be compared with {truths}")
    return worst


def claim_of(answer: Any, name: str, rows: object = -1) -> str:
    """Level and largest error of a claim in some rows, in the words of the page."""
    claim = answer.claims[name]
    level = claim.level.name.lower().replace("_", " ")
    if claim.error is None:
        return f"{level}, error not known"
    error = float(np.max(np.atleast_1d(claim.error)[rows]))
    return f"{level}, {error:.1e}" if error > ROUNDING else level


def compared(physics: str, answer: Any, name: str, truth: object, source: str, rows: object = -1) -> Row:
    """One quantity of a result or a study next to its reference."""
    quantity = name.replace("_", " ")
    values = answer[name].values
    values = np.atleast_1d(values)[rows]
    return Row(physics, quantity, source, difference(values, truth), claim_of(answer, name, rows))


def expected(name: str) -> dict:
    return REFERENCES[name]["expected"]


# -- closed solutions and published tables ------------------------------------------------------------


def normal() -> Iterator[Row]:
    radius, a = 1.0, 0.6
    logarithm = math.log((radius + a) / (radius - a))
    ball = mdr.solve(mdr.Contact(mdr.Sphere(radius), UNIT), mdr.indent(0.5 * a * logarithm))
    force = 0.5 * (radius**2 + a**2) * logarithm - a * radius
    yield compared("normal contact, sphere", ball, "normal_force", force, "Sneddon (1965)")
    hertz = mdr.solve(mdr.Contact(mdr.Paraboloid(radius), UNIT), mdr.load(0.1))
    yield compared("paraboloid", hertz, "contact_radius", 0.075 ** (1 / 3), "Hertz (1882)")
    cone = mdr.solve(mdr.Contact(mdr.Cone(slope=0.2), UNIT), mdr.indent(0.1))
    yield compared("cone", cone, "normal_force", 2 * 0.1**2 / (math.pi * 0.2), "Sneddon (1965)")
    for n in (1.5, 4):
        entry = REFERENCES[f"power_force_{n}"]
        power = mdr.solve(mdr.Contact(mdr.PowerLaw(n, 1.0, 1.0), UNIT), mdr.indent(0.1))
        yield compared(f"power r^{n}", power, "normal_force", entry["expected"]["F"], "Sneddon (1965)")
    function = mdr.solve(mdr.Contact(mdr.Function(lambda r: r**2 / 2), UNIT), mdr.load(0.1))
    yield compared(
        "the same paraboloid as a callable", function, "contact_radius", 0.075 ** (1 / 3), "Hertz (1882)"
    )


def bodies() -> Iterator[Row]:
    given, moduli = REFERENCES["TI_zinc"]["inputs"], expected("TI_zinc")
    zinc = mdr.solve(mdr.Contact(mdr.Paraboloid(1.0), mdr.TransverselyIsotropic(**given)), mdr.indent(0.01))
    yield compared(
        "transversely isotropic zinc",
        zinc,
        "normal_force",
        4 / 3 * moduli["E_star"] * 0.01**1.5,
        "Elliott (1949)",
    )
    for bonded, name, nu in (
        ("bonded", "hayes_flat_nu0.3", 0.3),
        ("frictionless", "layer_frictionless_flat", 0.3),
    ):
        entry = REFERENCES[name]
        ratios = entry["inputs"]["a_over_h"]
        i = ratios.index(1.0)
        film = mdr.Layered([mdr.Layer(mdr.Elastic(1.0, nu), 1.0)], bond=bonded)
        flat = mdr.solve(mdr.Contact(mdr.FlatPunch(1.0), film), mdr.indent(0.01))
        force = entry["expected"]["kappa"][i] * 2 * 0.01 / (1 - nu**2)
        source = (
            "Hayes et al. (1972), recomputed"
            if bonded == "bonded"
            else "Lebedev and Ufliand (1958), recomputed"
        )
        yield compared(f"layer, {bonded}, flat punch a = h", flat, "normal_force", force, source)
        if "hayes_table" in entry["expected"]:
            published = entry["expected"]["hayes_table"][i] * 2 * 0.01 / (1 - nu**2)
            yield compared(
                "the same", flat, "normal_force", published, "Hayes et al. (1972), four digits printed"
            )


def shapes() -> Iterator[Row]:
    given, known = REFERENCES["hertz_ellipse_2"]["inputs"], expected("hertz_ellipse_2")
    ellipse = mdr.Contact(mdr.EllipticParaboloid(given["R1"], given["R2"]), UNIT)
    yield compared(
        "elliptic contact", mdr.solve(ellipse, mdr.indent(1.0)), "normal_force", known["F"], "Hertz (1882)"
    )
    for sides in (3, 4):
        pyramid = mdr.solve(mdr.Contact(mdr.Pyramid(sides, slope=1.0), UNIT), mdr.indent(0.1))
        force = expected(f"pyramid_{sides}")["C_bem"] * 0.01
        yield compared(
            f"pyramid of {sides} sides",
            pyramid,
            "normal_force",
            force,
            "boundary elements that gave the constant",
        )


def adhesion() -> Iterator[Row]:
    for n in (1, 2, 3):
        contact = mdr.Contact(mdr.PowerLaw(n, 1.0, 1.0), UNIT, adhesion=mdr.JKR(1.0))
        known = expected(f"jkr_power_{n}")
        pull = mdr.pull_off(contact)
        yield Row(
            f"JKR, r^{n}, pull-off at fixed indentation",
            "normal force",
            "Johnson et al. (1971), Hess (2011)",
            difference(float(pull.normal_force), known["F_D"]),
            claim_of(pull, "normal_force"),
        )
    for strength in ("0.1", "1.0", "3.0"):
        known = expected(f"md_sphere_lam{strength}")
        law = mdr.MaugisDugdale(1.0, strength=known["sigma0"])
        path = mdr.indent(3.0, steps=2) >> mdr.indent(known["d"], steps=2)
        result = mdr.solve(mdr.Contact(mdr.Paraboloid(1.0), UNIT, adhesion=law), path)
        yield compared(
            f"Maugis-Dugdale, lambda = {strength}", result, "normal_force", known["F"], "Maugis (1992)"
        )


def friction() -> Iterator[Row]:
    for nu, known in ((0.0, expected("cm_parab_0.5")), (0.3, expected("cm_parab_0.5"))):
        body = mdr.Elastic(1e9, nu)
        contact = mdr.Contact(mdr.Paraboloid(0.01), body, body, friction=mdr.Coulomb(0.3))
        moduli = mdr.effective_moduli(body, body)
        depth = 1e-5
        slip = 0.3 * moduli.normal / moduli.tangential * depth
        result = mdr.solve(contact, mdr.indent(depth) >> mdr.cycle(shift=0.5 * slip, cycles=2, steps=400))
        load = 4 / 3 * moduli.normal * math.sqrt(0.01) * depth**1.5
        source = "Cattaneo (1938), Mindlin and Deresiewicz (1953)" + (
            ", the same approximation" if nu else ""
        )
        forces = result["tangential_force"].values
        claimed = claim_of(result, "tangential_force", int(forces.argmax()))
        top = difference(forces.max(), known["Fx_over_muFN"] * 0.3 * load)
        yield Row(f"partial slip, nu = {nu:g}", "tangential force", source, top, claimed)
        spent = result["dissipated_energy"].values
        loop = difference(spent[-1] - spent[-201], known["loop_W_over_muFN_us"] * 0.3 * load * slip)
        yield Row(
            "the same, second cycle", "dissipated energy", source, loop, claim_of(result, "dissipated_energy")
        )
    body = mdr.Elastic(2.6, 0.3)
    flat = mdr.Contact(mdr.FlatPunch(1.5), mdr.Elastic(5.2, 0.3), friction=mdr.Coulomb(math.inf))
    turned = mdr.solve(flat, mdr.indent(0.01) >> mdr.twist(0.01))
    yield compared(
        "torsion, flat punch", turned, "torque", expected("torsion_flat")["M"], "Reissner and Sagoci (1944)"
    )
    ball = mdr.Contact(mdr.Paraboloid(0.01), body, friction=mdr.Coulomb(0.3))
    pressed = mdr.solve(ball, mdr.indent(1e-5))
    a, load = (float(pressed[name][-1]) for name in ("contact_radius", "normal_force"))
    known = expected("lubkin_c0.2")
    peak = 1.5 * load / (math.pi * a**2)
    angle = known["Gphi_over_mup0"] * 0.3 * peak / body.shear
    result = mdr.solve(ball, mdr.indent(1e-5) >> mdr.twist(angle))
    torque = known["M_over_Mfull"] * 3 * math.pi / 16 * 0.3 * load * a
    yield compared("torsion with slip", result, "torque", torque, "Lubkin (1951)")
    for nu in (0.0, 0.5):
        body = mdr.Elastic(1e9, nu)
        contact = mdr.Contact(mdr.Paraboloid(1.0), body, body, friction=mdr.Coulomb(0.3))
        for law in ("plain", "calibrated"):
            rolled = mdr.rolling(contact, 1e-12, indentation=1e-4, law=law)
            a = rolled.data.attrs["contact_radius"]
            force = expected(f"kalker_nu{nu}")["C11_num"] * body.shear * a**2 * 1e-12
            yield compared(
                f"rolling, nu = {nu:g}, {law} slope",
                rolled,
                "creep_force",
                force,
                "Kalker (1967), recomputed within 2 %",
                0,
            )


def memory() -> Iterator[Row]:
    entry = REFERENCES["ting_sls_parab"]
    given, known = entry["inputs"], entry["expected"]
    solid = mdr.StandardSolid(given["Ginf"], given["G1"], given["tau"])
    ball = mdr.Contact(mdr.Paraboloid(1.0), mdr.Viscoelastic(solid, poisson=0.5))
    times = np.array(given["t"])
    fine = np.unique(np.concatenate([np.linspace(0.05, 1.5, 30), times[:-1], [given["tm"]]]))
    path = mdr.Path(time=fine, indentation=given["v"] * np.where(fine <= 1, fine, 2 - fine))
    result = mdr.solve(ball, path)
    rows = np.searchsorted(fine, times[:-1] - 1e-12)
    yield compared(
        "viscoelastic, approach and return", result, "normal_force", known["F"][:-1], "Ting (1966)", rows
    )
    known = expected("sls_creep")
    creep = mdr.solve(ball, mdr.Path(time=[0.0, 0.45, 0.9], normal_force=[0.2, 0.2, 0.2]))
    yield compared("viscoelastic, creep", creep, "indentation", known["d"], "Lee and Radok (1960)")
    for name in ("kv_impact_eta0.05", "kv_impact_eta0.3"):
        body = mdr.Viscoelastic(mdr.KelvinVoigt(1.0, REFERENCES[name]["inputs"]["eta"]), poisson=0.5)
        hit = mdr.impact(mdr.Contact(mdr.Paraboloid(1.0), body), mass=1.0, speed=1.0)
        yield Row(
            "impact on a viscoelastic body",
            "restitution",
            "Willert et al. (2017)",
            difference(hit.restitution, expected(name)["e"]),
            claim_of(hit, "restitution"),
        )


def impacts() -> Iterator[Row]:
    given, known = REFERENCES["impact_hertz"]["inputs"], expected("impact_hertz")
    body = mdr.Elastic(given["Estar"], 0.0)
    hit = mdr.impact(mdr.Contact(mdr.Paraboloid(given["R"]), body), mass=given["m"], speed=given["v"])
    yield Row(
        "elastic impact",
        "contact time",
        "Hertz (1882)",
        difference(hit.contact_time, known["T"]),
        claim_of(hit, "contact_time"),
    )
    like = mdr.Elastic(1e9, 0.3)
    moduli = mdr.effective_moduli(like, like)
    ball = mdr.Contact(mdr.Paraboloid(0.01), like, like, friction=mdr.Coulomb(0.3))
    for psi in (0.5, 4.0):
        factor = moduli.tangential / (0.3 * moduli.normal)
        angle = math.atan(psi / factor)
        hit = mdr.impact(ball, mass=0.033, speed=0.1 / math.cos(angle), angle=angle)
        yield Row(
            f"oblique impact, psi = {psi:g}",
            "speed of the contact point",
            "Maw, Barber and Fawcett (1976), recomputed",
            difference(factor * hit.contact_point_speed / 0.1, expected(f"oblique_psi{psi}")["psi2"]),
            claim_of(hit, "contact_point_speed"),
        )
    sticky = mdr.Contact(mdr.Paraboloid(1.0), UNIT, adhesion=mdr.JKR(1.0))
    hit = mdr.impact(sticky, mass=1.0, speed=10.0)
    yield Row(
        "adhesive impact",
        "sticking speed",
        "Thornton and Ning (1998)",
        difference(hit.sticking_speed, expected("jkr_impact")["vs"]),
        claim_of(hit, "sticking_speed"),
    )
    punch = mdr.Contact(
        mdr.FlatPunch(0.5), mdr.Elastic(1.0, 0.0, resistivity=2.0), mdr.Rigid(resistivity=3.0)
    )
    result = mdr.solve(punch, mdr.indent(0.01))
    yield compared(
        "contact resistance", result, "electrical_resistance", expected("holm")["Rc"], "Holm (1929)"
    )


def under_the_surface() -> Iterator[Row]:
    ball = mdr.solve(mdr.Contact(mdr.Paraboloid(1.0), mdr.Elastic(1e9, 0.3)), mdr.load(1.0))
    a = float(ball["contact_radius"][-1])
    depths = a * np.array([0.1, 0.5, 2.0])
    peak = 1.5 / (math.pi * a**2)
    z = depths / a
    axial = -1.0 / (1.0 + z**2)
    radial = -1.3 * (1.0 - z * np.arctan(1.0 / z)) - 0.5 * axial
    mises = ball.field("von_mises", r=[0.0], z=depths).values.ravel()
    off = difference(mises, peak * np.abs(radial - axial))
    yield Row("stress on the axis", "von mises", "Huber (1904)", off, claim_of(ball, "stress"))


CLOSED = (normal, bodies, shapes, adhesion, friction, memory, impacts, under_the_surface)

# -- independent solvers and other programs -----------------------------------------------------------


def verified(physics: str, name: str, solver: str, contact: mdr.Contact, path: Any, **options: Any) -> Row:
    """A quantity along a path by the method, with its largest claim, and by boundary elements."""
    found = mdr.verify(contact, path, **options)
    claimed = claim_of(mdr.solve(contact, path), name, slice(None))
    return Row(physics, name.replace("_", " "), solver, float(found.largest_difference), claimed)


def solvers() -> Iterator[Row]:
    gel = mdr.Elastic("30 kPa", 0.5)
    steel = mdr.Elastic("210 GPa", 0.3)
    tip = mdr.Paraboloid("50 um")
    rings, cells = "rings, 400", "cells on a grid, 32 x 32"
    yield verified(
        "sphere", "normal_force", rings, mdr.Contact(mdr.Sphere("10 mm"), steel), mdr.indent("10 um"), steps=1
    )
    yield verified(
        "cone", "normal_force", rings, mdr.Contact(mdr.Cone(slope=0.1), steel), mdr.indent("10 um"), steps=1
    )
    sticky = mdr.Contact(tip, gel, adhesion=mdr.JKR("2 mJ/m^2"))
    yield verified("JKR", "normal_force", rings, sticky, mdr.indent("1 um", steps=2), steps=2)
    film = mdr.Layered([mdr.Layer(gel, "20 um")])
    yield verified("layer", "normal_force", rings, mdr.Contact(tip, film), mdr.indent("1 um"), steps=1)
    rubber = mdr.Viscoelastic(mdr.StandardSolid("1 MPa", "10 MPa", "0.1 s"), poisson=0.5)
    path = mdr.indent("10 um", duration="1 s", steps=8) >> mdr.indent("2 um", duration="1 s", steps=8)
    yield verified("memory", "normal_force", rings, mdr.Contact(mdr.Paraboloid("10 mm"), rubber), path)
    silicone = mdr.Viscoelastic(mdr.StandardSolid("10 kPa", "30 kPa", "1 s"), poisson=0.5)
    probe = mdr.Contact(
        mdr.Paraboloid("1 mm"), silicone, adhesion=mdr.MaugisDugdale("50 mJ/m^2", range="5 um")
    )
    there = mdr.indent("20 um", duration="2 s", steps=8) >> mdr.hold("5 s", steps=2)
    yield verified(
        "adhesion with memory",
        "normal_force",
        rings,
        probe,
        there >> mdr.indent("-20 um", duration="4 s", steps=8),
    )
    like = mdr.Elastic("1 GPa", 0.0)
    joint = mdr.Contact(mdr.Paraboloid("10 mm"), like, like, friction=mdr.Coulomb(0.3))
    loop = mdr.indent("10 um") >> mdr.cycle(shift="2 um", steps=8)
    yield verified("friction, nu = 0", "tangential_force", cells, joint, loop, steps=4)
    like = mdr.Elastic("1 GPa", 0.3)
    other = mdr.Contact(mdr.Paraboloid("10 mm"), like, like, friction=mdr.Coulomb(0.3))
    yield verified("friction, nu = 0.3", "tangential_force", cells, other, loop, steps=4)
    yield verified("torsion", "torque", "rings, 200", joint, mdr.indent("10 um") >> mdr.twist(1e-3), steps=2)


def programs() -> Iterator[Row]:
    entry = REFERENCES["mdr_plastic_Y2e7"]
    given, rows = entry["inputs"], np.array(entry["expected"]["rows"])
    rows = rows[rows[:, 1] > 0.0]
    body = mdr.ElasticPlastic(
        given["E"], given["nu"], yield_strength=given["Y"], apparent_radius=True, wall_factor=True
    )
    n, deepest = given["steps"], given["depth"]
    path = mdr.indent(deepest, steps=n) >> mdr.indent(0.0, steps=n)
    result = mdr.solve(mdr.Contact(mdr.Sphere(given["R"]), body), path)
    d = result["indentation"].values
    halves = np.where(np.arange(len(rows)) <= int(rows[:, 0].argmax()), 0, n)
    chosen = [h + int(np.argmin(np.abs(d[h : h + n] - x))) for h, x in zip(halves, rows[:, 0], strict=True)]
    forces = result["normal_force"].values[chosen]
    off = difference(forces, rows[:, 1])
    claimed = claim_of(result, "normal_force", chosen)
    yield Row("balls that yield, loading and unloading", "normal force", "LAMMPS, recorded", off, claimed)
    ellipse = mdr.Contact(mdr.EllipticParaboloid("20 mm", "10 mm"), mdr.Elastic("1 GPa", 0.3))
    yield verified(
        "elliptic contact",
        "normal_force",
        "ContactMechanics, 129 x 129",
        ellipse,
        mdr.indent("10 um"),
        steps=1,
    )


# -- random problems ----------------------------------------------------------------------------------


def random_problems(count: int, seed: int) -> Iterator[str]:
    """Problems, values and violations of each kind, from the study of tests/accuracy.py."""
    from tests import accuracy

    effort = accuracy.Effort(False, 4, 1, 1)
    for kind in accuracy.KINDS:
        outcomes = accuracy.study(seed, count, effort=effort, kinds=(kind,)).outcomes
        values = [value for outcome in outcomes for value in outcome.values]
        violated = sum(any(value.violated for value in outcome.values) for outcome in outcomes)
        failed = sum(bool(outcome.crashes) for outcome in outcomes)
        refused = sum(bool(outcome.refusals) for outcome in outcomes)
        yield f"| {kind} | {len(outcomes)} | {len(values)} | {violated} | {failed} | {refused} |"


CLAIMED = "| physics | quantity | reference | claim | difference |\n|---|---|---|---|---|"
DRAWN = "| kind | problems | values | problems that violate a claim | that fail | with a refusal |\n|---|---|---|---|---|---|"


def write(name: str, head: str, rows: Iterable[object]) -> None:
    """Print a table, and put it between its marks in the page."""
    lines = [head]
    print(head)
    for row in rows:
        lines.append(str(row))
        print(row, flush=True)
    page = PAGE.read_text(encoding="utf-8")
    begin, end = f"<!-- begin {name} -->\n", f"<!-- end {name} -->"
    before, _, rest = page.partition(begin)
    _, _, after = rest.partition(end)
    if not rest:
        raise ValueError(f"{PAGE} has no mark {begin!r}")
    PAGE.write_text(f"{before}{begin}\n" + "\n".join(lines) + f"\n\n{end}{after}", encoding="utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--random", type=int, default=200, help="random problems of each kind")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    write("closed", CLAIMED, (row for part in CLOSED for row in part()))
    write("solvers", CLAIMED, solvers())
    write("programs", CLAIMED, programs())
    validation_figures.curves(ROOT / "docs" / "validation_curves.png")
    if given.random:
        validation_figures.claims(ROOT / "docs" / "validation_claims.png", given.random, given.seed)
        write("random", DRAWN, random_problems(given.random, given.seed))


if __name__ == "__main__":
    main()
