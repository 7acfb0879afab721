"""Contacts by the method, by independent solvers and by other programs; and measured records against themselves."""

import contextlib
import io
from collections.abc import Iterator
from importlib.metadata import version
from importlib.util import find_spec
from typing import Any

import numpy as np

import pymdr as mdr
from benchmarks import halves
from benchmarks.fits import TIP, by_nanite
from benchmarks.records import records
from benchmarks.validation.elastic import indent_of
from benchmarks.validation.particles import particles
from benchmarks.validation.rows import Row, absent, claim_of, compared, difference
from benchmarks.validation.surfaces import pressed


def verified(physics: str, name: str, solver: str, contact: mdr.Contact, path: Any, **options: Any) -> Row:
    """A quantity along a path by the method, with its largest claim, and by boundary elements."""
    result = mdr.verify(contact, path, **options)
    claimed = claim_of(mdr.solve(contact, path), name, slice(None))
    return Row(physics, name.replace("_", " "), solver, float(result.largest_difference), claimed)


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
    yield from _circles(other, cells)
    yield verified("torsion", "torque", "rings, 200", joint, mdr.indent("10 um") >> mdr.twist(1e-3), steps=2)
    metal = mdr.Elastic("210 GPa", 0.0)
    fretted = mdr.Contact(mdr.Paraboloid("10 mm"), metal, metal, friction=mdr.Coulomb(0.5))
    for slip, shift, cycles in (("partial", "0.4 um", 1e6), ("gross", "2 um", 1e5)):
        path = mdr.load("20 N") >> mdr.cycle(shift=shift)
        given = {"coefficient": "1e-5 mm^3/(N m)", "cycles": cycles}
        result = mdr.verify(fretted, path, wear=given, elements=240, steps=6)
        claimed = claim_of(mdr.wear(fretted, path, **given), "worn_volume", slice(None))
        physics = f"wear at constant load, {slip} slip, {cycles:,.0f} cycles"
        yield Row(physics, "worn volume", "rings, 240", result.largest_difference, claimed)


def _circles(joint: mdr.Contact, cells: str) -> Iterator[Row]:
    """Circles in the plane at constant indentation, of radii over the shift at which the body slides as a whole."""
    moduli = mdr.effective_moduli(joint.body, joint.counterbody)
    slides = joint.friction.coefficient * moduli.normal / moduli.tangential * 10e-6
    for part in (0.3, 0.95, 3.0):
        path = mdr.indent("10 um") >> mdr.circle(shift=part * slides, steps=16)
        physics = f"circle in the plane, nu = 0.3, radius {part:g} of the shift of first sliding"
        yield verified(physics, "tangential_force", cells, joint, path, steps=18)


def programs() -> Iterator[Row | str]:
    yield from particles()
    yield from _engines()
    yield from pressed()
    yield from _nanite()
    yield from _micromechanics()


def _engines() -> Iterator[Row | str]:
    """Boundary elements of other packages."""
    ellipse = mdr.Contact(mdr.EllipticParaboloid("20 mm", "10 mm"), mdr.Elastic("1 GPa", 0.3))
    path = mdr.indent("10 um")
    for package, engine in (("ContactMechanics", "contactmechanics"), ("tamaas", "tamaas")):
        if find_spec(package) is None:
            yield absent("elliptic contact", "normal force", package)
        else:
            source = f"{package} {version(package)}, 129 x 129"
            yield verified("elliptic contact", "normal_force", source, ellipse, path, steps=1, engine=engine)


def _nanite() -> Iterator[Row | str]:
    """The fit of a record without noise."""
    body = mdr.Contact(TIP, mdr.Elastic("3 kPa", 0.5))
    depth = np.linspace(-1e-6, 1e-6, 2000)
    force = mdr.solve(body, mdr.Path(indentation=depth))["normal_force"].values
    fit = by_nanite(depth, force)
    if fit is None:
        yield absent("Hertz fit", "Young's modulus", "nanite")
        return
    fitted = mdr.fit(body, mdr.MeasuredCurve(force=force, indentation=depth), ["body.young"])
    young = fitted["body.young"]
    off = difference(fit(), young.value)
    claimed = f"interval of {young.high / young.value - 1:.1e}"
    yield Row("Hertz fit", "Young's modulus", f"nanite {version('nanite')}", off, claimed)


def _micromechanics() -> Iterator[Row | str]:
    """Hardness and modulus of an indent without noise, its unloading fitted by each program; the other counts in mN, um and GPa."""
    if find_spec("micromechanics") is None:
        yield absent("indent without noise", "hardness", "micromechanics")
        return
    with contextlib.redirect_stdout(io.StringIO()):
        from micromechanics.indentation import Indentation, Tip

        other = Indentation(tip=Tip([24.5, 900.0, 2000.0, "iso"]), model={"evaluateSAtMax": True})
    record, tip = indent_of(4e9, mdr.Elastic("210 GPa", 0.3))
    other.method, other.iLHU = type(other.method).ISO, [[0, 249, 299, 549]]
    force, depth = 1e3 * record.force, 1e6 * record.indentation
    stiffness, chosen, *_ = other.stiffnessFromUnloading(force, depth)
    modulus, area, _ = other.OliverPharrMethod(np.array(stiffness), force[chosen], depth[chosen])
    study = mdr.oliver_pharr(record, tip, poisson=0.3, epsilon=0.75)
    source = f"micromechanics {version('micromechanics')}"
    for name, truth in (("hardness", 1e9 * force[chosen] / area), ("reduced_modulus", 1e9 * modulus)):
        # of the first indent, by the first procedure, the power law
        yield compared("indent without noise, power law", study, name, truth, source, (0, 0))


def measured() -> Iterator[str]:
    """Young's moduli of odd and of even samples of measured records (``benchmarks/halves.py``)."""
    start, free, segment = halves.LAWS["Hertz"]
    for name, record in records(segment):
        _, own = halves.halves(start, record.leave_out_marked(), free)
        off, likely = own["body.young"]
        yield f"| {name} | Young's modulus | odd and even samples | {likely:.1e} | {abs(off):.1e} |"
