"""Elastic contacts, with and without adhesion, against closed solutions and published tables."""

import math
from collections.abc import Iterator

import numpy as np

import pymdr as mdr
from benchmarks.validation.rows import REFERENCES, UNIT, Row, claim_of, compared, difference, expected


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
    entry = REFERENCES["layer_parab_bonded_nu0.5"]
    i = entry["inputs"]["a_over_h"].index(1.0)
    film = mdr.Layered([mdr.Layer(mdr.Elastic(1.0, 0.5), 1.0)])
    ball = mdr.Contact(mdr.Paraboloid(100.0), film)
    pressed = mdr.solve(ball, mdr.indent(entry["expected"]["dR_over_a2"][i] / 100.0))
    force = entry["expected"]["F_over_FHertz_a"][i] * 4 / 3 / 0.75 / 100.0
    yield compared(
        "layer, bonded, paraboloid a = h", pressed, "normal_force", force, "Hayes et al. (1972), recomputed"
    )
    modulus = expected("hN_0.2_0.3")["h_N"] / (1 - 0.3**2)
    graded = mdr.Contact(mdr.Paraboloid(1.0), mdr.Graded(1.0, depth=1.0, exponent=0.2, poisson=0.3))
    known = expected("graded_parab_k0.2")
    pressed = mdr.solve(graded, mdr.indent(known["d"]))
    yield compared(
        "graded body, modulus as z^0.2",
        pressed,
        "normal_force",
        modulus * known["F"],
        "Giannakopoulos and Suresh (1997), Hess (2016)",
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
    steel = mdr.Elastic("210 GPa", 0.3)
    slid = mdr.solve(
        mdr.Contact(mdr.Paraboloid("10 mm"), steel, steel, friction=mdr.Coulomb(0.3)),
        mdr.load("50 N") >> mdr.shift("10 um"),
    )
    a, peak = (float(slid[name][-1]) for name in ("contact_radius", "peak_pressure"))
    edges = slid.field("stress", x=[-a, a], y=[0.0], z=[0.0]).sel(component="xx").values.ravel()
    pulled = 0.3 * math.pi * (4 + 0.3) / 8
    off = difference(edges, peak * (np.array([pulled, -pulled]) + (1 - 2 * 0.3) / 3))
    yield Row("sliding, edges of the contact", "stress xx", "Hamilton (1983)", off, claim_of(slid, "stress"))


def other_adhesion() -> Iterator[Row]:
    known = expected("hysteresis_jkr")
    sticky = mdr.Contact(mdr.Paraboloid(1.0), UNIT, adhesion=mdr.JKR(0.2, work_receding=1.0))
    loop = mdr.solve(sticky, mdr.indent(1.0, steps=7) >> mdr.indent(-2.0))
    yield compared(
        "JKR with two works, a loop", loop, "dissipated_energy", known["loop"], "integral of its branches"
    )
    given = REFERENCES["capillary_2"]["inputs"]
    radius = 0.5 * given["h0"]
    law = mdr.Capillary(given["sigma0"] * radius, kelvin_radius=radius)
    meniscus = mdr.Contact(mdr.Paraboloid(1.0), UNIT, adhesion=law)
    pull = mdr.pull_off(meniscus, machine_stiffness=0.0)
    yield Row(
        "meniscus, pull-off",
        "normal force",
        "Maugis and Gauthier-Manuel (1994), six digits",
        difference(float(pull.normal_force), expected("capillary_2")["pull_off_over_piRw"] * math.pi),
        claim_of(pull, "normal_force"),
    )


def known_by_its_curve() -> Iterator[Row]:
    body = mdr.Elastic("210 GPa", 0.0)
    moduli = mdr.effective_moduli(body, body)
    d, depth = np.linspace(0.0, 2e-6, 201)[1:], 1.3e-6

    def hertz(indentation: object) -> np.ndarray:
        return 4 / 3 * moduli.normal * 0.1 * np.asarray(indentation) ** 1.5

    joint = mdr.Contact(
        mdr.ForceCurve(d, hertz(d), modulus=moduli.normal), body, body, friction=mdr.Coulomb(0.3)
    )
    limit = 0.3 * moduli.normal / moduli.tangential * depth
    moved = mdr.solve(joint, mdr.indent(depth) >> mdr.shift(0.5 * limit))
    force = expected("cm_parab_0.5")["Fx_over_muFN"] * 0.3 * float(hertz(depth))
    yield compared(
        "force curve of a paraboloid, partial slip", moved, "tangential_force", force, "Cattaneo (1938)"
    )


def indent_of(hardness: float, body: mdr.Elastic) -> tuple[mdr.MeasuredCurve, mdr.AreaFunction]:
    """An indent without noise of 150 nm contact depth, made by the equations of its evaluation; loading ends at row 250, the hold at row 300."""
    tip = mdr.AreaFunction([24.5, 900.0, 2000.0], unit="1 nm")
    area = float(tip.area_at(150e-9))
    load, exponent = hardness * area, 1.35
    modulus = mdr.effective_moduli(body, mdr.Elastic("1141 GPa", 0.07)).normal
    stiffness = 2 * modulus * math.sqrt(area / math.pi)
    # n and epsilon of an unloading curve by its exponent (Pharr and Bolshakov 2002)
    n = 1 / (exponent - 1)
    kappa = math.sqrt(math.pi) * math.gamma(n / 2 + 1) / math.gamma(n / 2 + 0.5)
    depth = 150e-9 + (1 + 1 / n) * (1 - 1 / kappa) * load / stiffness
    part = np.concatenate([np.linspace(0, 1, 250), np.ones(50), np.linspace(1, 0, 250)])
    h = depth - exponent * load / stiffness * (1 - part ** (1 / exponent))
    h[:250] = depth * np.sqrt(part[:250])
    return mdr.MeasuredCurve(force=load * part, indentation=h), tip


def nanoindentation() -> Iterator[Row]:
    record, tip = indent_of(4e9, mdr.Elastic("210 GPa", 0.3))
    study = mdr.oliver_pharr(record, tip, poisson=0.3, epsilon=None)
    source = "Oliver and Pharr (1992), made by its equations"
    for name, truth in (("hardness", 4e9), ("young_modulus", 210e9)):
        yield compared("indent without noise", study, name, truth, source)


ELASTIC = (
    normal,
    bodies,
    shapes,
    adhesion,
    other_adhesion,
    under_the_surface,
    known_by_its_curve,
    nanoindentation,
)
