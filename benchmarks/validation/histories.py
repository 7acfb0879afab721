"""Friction, memory, impacts and wear against closed solutions and published tables."""

import math
from collections.abc import Iterator

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq, minimize_scalar

import pymdr as mdr
from benchmarks.validation.rows import REFERENCES, UNIT, Row, claim_of, compared, difference, expected


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
            "Willert et al. (2017), integrated to 1e-11",
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


def soft_edges() -> Iterator[Row]:
    body = mdr.Viscoelastic(mdr.StandardSolid(0.25, 2.25, 1.0), poisson=0.5)
    sticky = mdr.Contact(mdr.Paraboloid(1.0), body, adhesion=mdr.JKR(1.0, range=1.0 / 6.0))
    rest = mdr.indent(1.0, duration=1e3, steps=5) >> mdr.hold(1e4, steps=1)
    for speed, retreat in ((0.1, 8.0), (10.0, 1.2)):
        away = mdr.indent(1.0 - retreat, duration=retreat / speed, steps=160)
        result = mdr.solve(sticky, rest >> away)
        row = int(np.argmin(result["normal_force"].values))
        yield compared(
            f"JKR with memory, pulled at the speed {speed:g}",
            result,
            "normal_force",
            expected(f"visco_md_s6_v{speed:g}")["F_min"],
            "the full law, Haiat and Barthel (2003), recomputed",
            row,
        )


def elastomer() -> Iterator[Row]:
    for s in ("0.001", "1", "100"):
        body = mdr.Viscoelastic(mdr.KelvinVoigt(1.0, float(s)), poisson=0.5)
        slid = mdr.sliding_friction(mdr.Contact(mdr.Paraboloid(1.0), body), 1.0, indentation=1.0)
        yield compared(
            f"sliding over an elastomer, tau v / R = {s}",
            slid,
            "friction_coefficient",
            expected(f"slide_kv_{s}")["mu"],
            "springs of Popov and Hess (2015)",
        )
    # half of the friction of the springs is exact where sliding is slow
    slow = mdr.sliding_friction(
        mdr.Contact(mdr.Paraboloid(1.0), mdr.Viscoelastic(mdr.KelvinVoigt(1.0, 1e-3), poisson=0.5)),
        1.0,
        indentation=1.0,
    )
    yield compared("the same, slow sliding", slow, "slow_limit", 1e-3, "tau v / R, first order in the speed")


def worn() -> Iterator[Row]:
    body, depth, amplitude, mu, radius = mdr.Elastic("210 GPa", 0.0), 1e-6, 2e-7, 0.5, 0.01
    joint = mdr.Contact(mdr.Paraboloid(radius), body, body, friction=mdr.Coulomb(mu))
    cycle = mdr.indent(depth) >> mdr.cycle(shift=amplitude)
    ended = mdr.wear(joint, cycle, coefficient="1e-5 mm^3/(N m)", cycles=[1e9])
    moduli = mdr.effective_moduli(body, body)
    c = math.sqrt(radius * (depth - moduli.tangential * amplitude / (mu * moduli.normal)))

    def worn_depth(r: float) -> float:
        """What has gone of r^2/2R beyond the stick radius c."""
        angle = math.asin(c / r)
        springs = (0.5 * r * r * angle - 0.5 * c * math.sqrt(r * r - c * c)) / radius
        return 2 / math.pi * (springs + depth * math.acos(c / r)) - r * r / (2 * radius)

    b = brentq(worn_depth, math.sqrt(radius * depth), 2 * math.sqrt(radius * depth), xtol=1e-18)
    volume = quad(lambda r: 2 * math.pi * r * worn_depth(r), c, b, epsabs=0.0, epsrel=1e-10, limit=200)[0]
    yield compared("fretting wear, its end", ended, "worn_volume", volume, "Popov (2014)")


def shakedown() -> Iterator[Row]:
    steel = mdr.Elastic("210 GPa", 0.3)
    joint = mdr.Contact(mdr.Paraboloid("10 mm"), steel, steel, friction=mdr.Coulomb(0.6))
    limits = mdr.shakedown(joint, strength="1 GPa", force_ratio=[0.0, 0.6])
    source = "Ponter, Hearle and Johnson (1985), three digits"
    yield compared("shakedown in free rolling, upper bound", limits, "pressure_ratio_high", 4.68, source, 0)
    yield compared("shakedown in sliding, mu = 0.6", limits, "pressure_ratio", 1 / 0.6, "Johnson (1985)", 1)


def fatigue() -> Iterator[Row]:
    nu, young = 0.3, 210e9
    steel = mdr.Elastic(young, nu)
    modulus = young / (1 - nu**2) / 2
    peak = (6 * 100.0 * modulus**2 / (math.pi**3 * 0.01**2)) ** (1 / 3)
    joint = mdr.Contact(mdr.Paraboloid(0.01), steel, steel, friction=mdr.Coulomb(0.5))
    slid = mdr.solve(joint, mdr.load(100.0) >> mdr.cycle(shift="30 um", cycles=2, steps=16))
    # at the edge of a contact that slides: along and across the motion, and by the pressure
    along, across = (0.5 * peak * math.pi / 8 * factor for factor in (4 + nu, 3 * nu))
    pressed = (1 - 2 * nu) * peak / 3
    worst = mdr.fatigue(slid, criterion=mdr.SmithWatsonTopper())
    known = (along + pressed) * (along - nu * across) / young
    source = "edge of the contact, Hamilton (1983)"
    yield compared("fatigue, sliding to and fro", worst, "smith_watson_topper", known, source)
    worst = mdr.fatigue(slid, criterion=mdr.DangVan(0.3))
    known = 0.5 * along + 0.3 * (along + across) / 3
    yield compared("the same", worst, "dang_van_stress", known, source)

    def shear(z: float) -> float:
        """Largest shear stress on the axis, over the peak pressure."""
        axial = -1 / (1 + z * z)
        return 0.5 * abs(axial + (1 + nu) * (1 - z * math.atan(1 / z)) + 0.5 * axial)

    deepest = minimize_scalar(
        lambda z: -shear(z), bounds=(0.1, 2.0), method="bounded", options={"xatol": 1e-9}
    )
    largest = shear(deepest.x) * peak * 4 ** (1 / 3)  # E* on a rigid body is twice that of like bodies
    ball = mdr.Contact(mdr.Paraboloid(0.01), steel)
    result = mdr.solve(ball, mdr.load(50.0) >> mdr.cycle(normal_force=50.0, steps=8))
    source, values = "Huber (1904), its largest on the axis", result["largest_shear"].values
    claimed = claim_of(result, "stress")
    yield Row("ball on a plane", "largest shear", source, difference(values.max(), largest), claimed)
    worst = mdr.fatigue(result, criterion=mdr.Findley(0.0))
    yield compared("fatigue, load and no load", worst, "findley_stress", 0.5 * largest, source)


def chain() -> Iterator[Row]:
    radius, mass, count = 5e-3, 4e-3, 30
    steel = mdr.Elastic("210 GPa", 0.3)
    touching = mdr.Contact(mdr.Paraboloid(radius / 2), steel, steel)
    spheres = [mdr.Mass(f"{i}", mass, velocity=0.0 if i else 1.0) for i in range(count)]
    links = [mdr.Joint(touching, (f"{i}", f"{i + 1}"), name=f"{i}") for i in range(count - 1)]
    motion = mdr.move(mdr.Machine(spheres, links), "0.42 ms", steps=1000)
    time, velocity = motion["time"].values, motion["velocity"].values

    def arrival(i: int) -> float:
        """Time at which a sphere is fastest, by a parabola through three rows."""
        j = int(np.argmax(velocity[:, i]))
        before, at, after = velocity[j - 1 : j + 2, i]
        return time[j] + 0.5 * time[1] * (before - after) / (before - 2 * at + after)

    speed = 8 * 2 * radius / (arrival(20) - arrival(12))
    stiffness = 4 / 3 * mdr.effective_moduli(steel, steel).normal * math.sqrt(radius / 2)
    c = math.sqrt(stiffness * (2 * radius) ** 2.5 / mass)
    formula = (16 / 25) ** 0.2 * c**0.8 * velocity[:, 16].max() ** 0.2
    claimed = claim_of(motion, "velocity")
    source = "Nesterenko (1983), for long waves"
    yield Row("chain of spheres", "speed of the wave", source, difference(speed, formula), claimed)


HISTORIES = (friction, memory, soft_edges, elastomer, impacts, worn, shakedown, fatigue, chain)
