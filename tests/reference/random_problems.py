"""Random whole problems with references of another kind: bodies with memory, layers, force curves and fits.

Each function draws one problem from a generator, solves it, and yields comparisons: name, where, value, truth, the error that is
claimed, and the error of the reference, all relative. Lengths, moduli and times are drawn over many decades.

- memory: convolutions with the exact kernel on graded meshes (Lee and Radok 1960 for growing contacts, Ting 1966 for one return),
  neither springs nor series of exponentials.
- layers: Galerkin's method in Legendre polynomials on the line, with the compliance of `pymdr.independent.stacks`.
- closures: curves and sliding of a power law F = C d^m in closed form, of which the package sees points only.
- fits: records of known contacts with noise; the interval must hold the truth.
"""

import itertools
import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq
from scipy.special import eval_legendre, gamma, spherical_jn

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(16)


@dataclass(frozen=True)
class Comparison:
    """One number beside its reference."""

    quantity: str
    at: str
    value: float
    truth: float
    claimed: float | None
    """Relative; None where the claim says that its error is not known."""
    exact: bool
    uncertainty: float = 0.0
    """Of the reference, relative."""


def log_uniform(rng, low, high):
    """A number whose logarithm is evenly distributed."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def claimed(result, name, row):
    """Relative error and exactness that are claimed of a row; False where nothing is."""
    claim = result.claims[name]
    if not claim.readable or not claim.where[row]:
        return False
    error = None if claim.error is None else float(claim.error[row])
    return error, claim.level.name == "EXACT"


def compare(result, name, row, truth, at, uncertainty=0.0):
    """Comparisons of one quantity in one row, if it is claimed."""
    said = claimed(result, name, row)
    if said:
        yield Comparison(name, at, float(result[name].values[row]), float(truth), *said, uncertainty)


# --- powers on the line ----------------------------------------------------------------------------------


def power_profile(rng, mdr):
    """A profile h (r/R)^n of random size, with d = c a^n on the line."""
    n = float(rng.choice([1.0, 2.0, 4.0, rng.uniform(0.5, 8.0)]))
    radius = log_uniform(rng, 1e-9, 1.0)
    height = radius * log_uniform(rng, 1e-3, 0.3)
    factor = math.sqrt(math.pi) * gamma(n / 2 + 1) / gamma((n + 1) / 2)
    return mdr.PowerLaw(exponent=n, height=height, radius=radius), n, factor * height / radius**n


# --- memory ----------------------------------------------------------------------------------------------


def _kernel(rng, mdr, scale):
    """A rheology, its G(t) and, where it is closed, its J(t), with times about `scale`; an exponent if it is a power."""
    modulus = log_uniform(rng, 1e2, 1e9)
    tau = scale * log_uniform(rng, 1e-3, 1e3)
    kind = rng.choice(["standard", "maxwell", "prony", "power"])
    if kind == "power":
        alpha = rng.uniform(0.03, 0.97)
        size = gamma(1 - alpha) * gamma(1 + alpha)
        return (
            mdr.PowerLawRheology(modulus, tau, alpha),
            lambda t: modulus * (t / tau) ** -alpha,
            lambda t: (t / tau) ** alpha / (modulus * size),
            alpha,
        )
    if kind == "maxwell":
        return (
            mdr.Maxwell(modulus, time=tau),
            lambda t: modulus * np.exp(-t / tau),
            lambda t: (1 + t / tau) / modulus,
            0.0,
        )
    if kind == "standard":
        rest = modulus * log_uniform(rng, 1e-3, 1e3)
        slow = tau * (1 + modulus / rest)
        return (
            mdr.StandardSolid(rest, modulus, tau),
            lambda t: rest + modulus * np.exp(-t / tau),
            lambda t: 1 / rest - (1 / rest - 1 / (rest + modulus)) * np.exp(-t / slow),
            0.0,
        )
    moduli = modulus * np.exp(rng.uniform(-5, 5, 3))
    times = tau * np.array([1.0, *np.cumprod(np.exp(rng.uniform(0.5, 5, 2)))])
    rest = modulus * rng.choice([0.0, 1.0])
    return (
        mdr.Prony(rest, moduli, times),
        lambda t: rest + np.exp(-np.asarray(t)[..., None] / times) @ moduli,
        None,
        0.0,
    )


def _graded(low, high, power=0.0):
    """Nodes, weights and distances from the upper end, graded to both ends; with (high - s)^-power in the weights where power is not 0."""
    middle = 0.5 * (low + high)
    # the power u^(1 / (1 - power)) is steep next to 1
    steep = np.linspace(0.0, 1.0, 2 + round(1.0 / (1.0 - power)))
    edges = np.union1d(2.0 ** -np.arange(0.0, 55.0), steep)
    u = edges[:-1, None] + np.diff(edges)[:, None] * (1 + _NODES) / 2
    w = np.diff(edges)[:, None] * _WEIGHTS / 2
    u, w = u.ravel(), w.ravel()
    half = middle - low
    # near the upper end s = high - half v, v = u^(1/(1 - power)): the kernel's power becomes a constant
    beta = 1.0 / (1.0 - power)
    v = np.maximum(u**beta, 1e-280)
    jacobian = beta * v**power
    s = np.concatenate([low + half * u, high - half * v])
    distance = np.concatenate([high - low - half * u, half * v])
    # nodes that round to the upper end still belong to this segment: a rate there is not that of the next one
    s = np.minimum(s, np.nextafter(high, low))
    return s, np.concatenate([half * w, half * w * jacobian]), distance


def convolved(kernel, rate, times, t, end=None, power=0.0):
    """int_0^end K(t - s) rate(s) ds over the segments of `times`, exact to rounding for smooth rates."""
    end = t if end is None else min(end, t)
    total = 0.0
    marks = [0.0, *[m for m in times if 0.0 < m < end], end]
    for low, high in itertools.pairwise(marks):
        if high > low:
            s, w, distance = _graded(low, high, power if high == t else 0.0)
            total += float(np.sum(w * kernel(t - high + distance) * rate(s)))
    return total


def memory(rng, mdr, full):
    """A contact that grows and may shrink once, by indentation or growing force."""
    profile, n, c = power_profile(rng, mdr)
    scale = log_uniform(rng, 1e-6, 1e6)
    rheology, relaxation, creep, alpha = _kernel(rng, mdr, scale)
    poisson = float(rng.choice([0.5, 0.3, 0.0]))
    contact = mdr.Contact(profile, mdr.Viscoelastic(rheology, poisson=poisson))
    modulus = 2.0 / (1.0 - poisson)
    radius = profile.radius
    deepest = c * (radius * log_uniform(rng, 1e-2, 1.0)) ** n
    m = 1.0 + 1.0 / n
    size = modulus * 2.0 * n / (n + 1.0) * c ** (-1.0 / n)  # F = size d^m for G = 1
    legs = int(rng.integers(1, 5 if full else 4))
    duration = scale * np.exp(rng.uniform(-3, 3, legs))
    times = np.cumsum(duration)
    count = int(rng.integers(1, 12 if full else 6))
    rows = np.unique(np.concatenate([times, rng.uniform(0.0, times[-1], count)]))
    if creep is not None and rng.random() < 0.3:
        yield from _creeping(rng, mdr, contact, creep, times, rows, size, m, deepest, relaxation)
        return
    levels = deepest * np.cumsum(rng.uniform(0.0, 1.0, legs) + 1e-3) / legs
    returns = legs > 1 and rng.random() < 0.6
    if returns:
        levels[-1] = levels[-2] * rng.uniform(-0.2, 0.95)
    d_at, t_at = np.array([0.0, *levels]), np.array([0.0, *times])
    result = mdr.solve(contact, mdr.Path(time=rows, indentation=np.interp(rows, t_at, d_at)))
    rates = np.diff(d_at) / np.diff(t_at)
    turn = t_at[-2] if returns else t_at[-1]

    def depth(s):
        return np.interp(s, t_at, d_at)

    def rate(s):
        return rates[np.clip(np.searchsorted(t_at, s, side="right") - 1, 0, legs - 1)]

    def growth(s):
        return size * m * np.maximum(depth(s), 0.0) ** (m - 1.0) * rate(s)

    for row, t in enumerate(rows):
        start = t
        if t > turn and returns:
            back = -rates[-1] * convolved(relaxation, np.ones_like, (), t - turn, power=alpha)

            def left(s, t=t, back=back):
                """int_s^turn G(t - u) d'(u) du less what the return has taken."""
                whole = _between(relaxation, rate, t_at, t, s, turn)
                return whole - back

            if left(0.0) <= 0.0:
                yield from compare(result, "normal_force", row, 0.0, f"t = {t!r}")
                continue
            start = brentq(left, 0.0, turn, xtol=1e-15 * turn, rtol=1e-15)
        force = convolved(relaxation, growth, t_at, t, start, alpha)
        yield from compare(result, "normal_force", row, force, f"t = {t!r}", 1e-10)
        a = (depth(start) / c) ** (1.0 / n)
        yield from compare(result, "contact_radius", row, a, f"t = {t!r}", 1e-10)


def _between(kernel, rate, times, t, low, high):
    total, marks = 0.0, [low, *[m for m in times if low < m < high], high]
    for one, other in itertools.pairwise(marks):
        if other > one:
            s, w, distance = _graded(one, other)
            total += float(np.sum(w * kernel(t - other + distance) * rate(s)))
    return total


def _creeping(rng, mdr, contact, creep, times, rows, size, m, deepest, relaxation):
    # forces below 1e-290 N are no load
    largest = max(size * deepest**m * float(relaxation(times[-1])), 1e-270)
    forces = largest * np.cumsum(rng.uniform(0.0, 1.0, times.size))
    t_at, f_at = np.array([0.0, *times]), np.array([0.0, *forces])
    rates = np.diff(f_at) / np.diff(t_at)
    result = mdr.solve(contact, mdr.Path(time=rows, normal_force=np.interp(rows, t_at, f_at)))
    for row, t in enumerate(rows):
        power = convolved(
            creep,
            lambda s: rates[np.clip(np.searchsorted(t_at, s, side="right") - 1, 0, rates.size - 1)],
            t_at,
            t,
        )
        yield from compare(result, "indentation", row, (power / size) ** (1.0 / m), f"t = {t!r}", 1e-10)


# --- layers ----------------------------------------------------------------------------------------------


def layers(rng, mdr, full):
    """A power-law profile on one or a few layers, by indentation."""
    from pymdr.independent.stacks import stack_of

    n = float(rng.choice([2.0, 4.0, 6.0]))
    count = int(rng.integers(1, 4 if full else 3))
    thickness = log_uniform(rng, 1e-8, 1e-1)
    young = log_uniform(rng, 1e3, 1e11)
    parts = [
        mdr.Layer(
            mdr.Elastic(young * log_uniform(rng, 0.03, 30.0), float(rng.choice([0.5, 0.49, 0.3, 0.0]))),
            thickness * log_uniform(rng, 0.2, 5.0),
        )
        for _ in range(count)
    ]
    base = mdr.Rigid() if rng.random() < 0.5 else mdr.Elastic(young * log_uniform(rng, 0.1, 10.0), 0.3)
    body = mdr.Layered(parts, base=base, bond=str(rng.choice(["bonded", "frictionless"])))
    stack = stack_of(body)
    a = parts[0].thickness * log_uniform(rng, 1e-2, 8.0 if full else 3.0)
    height = a * 1e-2
    factor = math.sqrt(math.pi) * gamma(n / 2 + 1) / gamma((n + 1) / 2)
    solution = [galerkin(stack, a, n, factor * height, basis) for basis in (16, 24)]
    (_, coarse), (d, force) = solution
    result = mdr.solve(
        mdr.Contact(mdr.PowerLaw(exponent=n, height=height, radius=a), body), mdr.Path(indentation=[d])
    )
    uncertain = abs(coarse / force - 1.0) + 1e-11
    yield from compare(result, "contact_radius", 0, a, f"a = {a!r}", uncertain * 10.0)
    yield from compare(result, "normal_force", 0, force, f"a = {a!r}", uncertain)


def galerkin(stack, a, n, rise, basis):
    """Depth and force of a disk of radius a whose line rises as rise (x/a)^n, n even."""
    h, total = stack.thickness[0], sum(stack.thickness)
    end = 24.0 / h
    step = min(12.0 / a, 2.0 / h)
    edges = [0.0, 1e-9 / (total + a)]
    while edges[-1] < end:
        edges.append(min(2.0 * edges[-1], edges[-1] + step, end))
    low, width = np.array(edges[:-1])[:, None], np.diff(edges)[:, None]
    k, w = (low + width * (1 + _NODES) / 2).ravel(), (width * _WEIGHTS / 2).ravel()
    order = 2 * np.arange(basis)
    bessel = (-1.0) ** np.arange(basis) * np.array([spherical_jn(int(i), k * a) for i in order]).T
    system = 2.0 * a / math.pi * (bessel.T * (w * (stack.compliance(k) - 1.0))) @ bessel + np.diag(
        1.0 / (2 * order + 1.0)
    )
    x, weight = (1 + np.polynomial.legendre.leggauss(64)[0]) / 2, np.polynomial.legendre.leggauss(64)[1] / 2
    legendre = np.array([eval_legendre(int(i), x) for i in order])
    right = np.array([legendre @ weight, legendre @ (weight * rise * x**n)]).T
    flat, shaped = (np.linalg.solve(system, right) * stack.modulus).T
    d = float(shaped.sum() / flat.sum())  # q(a) = 0; P_2n(1) = 1
    return d, float(2.0 * a * (d * flat[0] - shaped[0]))


# --- force curves ----------------------------------------------------------------------------------------


def closures(rng, mdr, full):
    """Points of F = C d^m, even or not, with or without noise: force, depth, stiffness, energy, and a shift under load."""
    m = rng.uniform(1.05, 3.0)
    deepest = log_uniform(rng, 1e-9, 1e-3)
    body = mdr.Elastic(log_uniform(rng, 1e3, 1e11), 0.0)
    size = log_uniform(rng, 1e-6, 1e2) / deepest**m
    count = int(rng.integers(8, 200))
    d = np.linspace(0.0, 1.0, count) ** rng.uniform(0.7, 2.0)
    if rng.random() < 0.3:
        d = np.sort(np.concatenate([[0.0, 1.0], rng.uniform(0.0, 1.0, count - 2)]))
        d = d[np.append(True, np.diff(d) > 1e-6)]
    d = deepest * d
    noise = float(rng.choice([0.0, 0.0, 1e-4, 1e-2]))
    force = size * d**m + noise * size * deepest**m * rng.normal(size=d.size)
    e_star = mdr.effective_moduli(body, mdr.Rigid()).normal
    curve = mdr.ForceCurve(d, force, modulus=e_star, contact_point=0.0)
    at = deepest * np.sort(rng.uniform(0.02, 0.98, 4 if full else 2))
    result = mdr.solve(mdr.Contact(curve, body), mdr.Path(indentation=at))
    for row, depth in enumerate(at):
        truths = {
            "normal_force": size * depth**m,
            "normal_stiffness": m * size * depth ** (m - 1.0),
            "elastic_energy": size * depth ** (m + 1.0) / (m + 1.0),
        }
        for name, truth in truths.items():
            yield from compare(result, name, row, truth, f"d = {depth!r}, m = {m!r}, noise {noise}")
    result = mdr.solve(mdr.Contact(curve, body), mdr.Path(normal_force=size * at**m))
    for row, depth in enumerate(at):
        yield from compare(result, "indentation", row, depth, f"by force, m = {m!r}, noise {noise}")
    # a shift under load: u = mu (E*/G*) (d - d1), F_x = mu (F(d) - F(d1)), E*/G* = 1/2 for nu = 0 against a rigid body
    moduli = mdr.effective_moduli(body, mdr.Rigid())
    mu, depth = float(rng.uniform(0.05, 1.0)), float(at[-1])
    inner = depth * rng.uniform(0.05, 0.95)
    shift = mu * moduli.normal / moduli.tangential * (depth - inner)
    result = mdr.solve(
        mdr.Contact(curve, body, friction=mdr.Coulomb(mu)), mdr.indent(depth) >> mdr.shift(shift)
    )
    truth = mu * size * (depth**m - inner**m)
    yield from compare(result, "tangential_force", 1, truth, f"d = {depth!r}, d1 = {inner!r}, noise {noise}")


# --- fits ------------------------------------------------------------------------------------------------


def fits(rng, mdr, full):
    """A record with noise of a sphere on a half-space; the modulus lies within five standard errors."""
    radius = log_uniform(rng, 1e-7, 1e-3)
    young = log_uniform(rng, 1e2, 1e10)
    body = mdr.Elastic(young, 0.5)
    deepest = radius * log_uniform(rng, 3e-3, 0.2)
    count = int(rng.integers(60, 600 if full else 200))
    point = deepest * rng.uniform(-0.2, 0.8)
    depth = np.linspace(-1.0, 1.0, count) * deepest + point
    adhesive = full and rng.random() < 0.5
    law = None
    if adhesive:
        work = log_uniform(rng, 1e-3, 1e-1) * young * deepest**1.5 / radius**0.5
        law = mdr.JKR(work)
    contact = mdr.Contact(mdr.Paraboloid(radius), body, adhesion=law)
    clean = np.where(
        depth > point, 16.0 / 9.0 * young * math.sqrt(radius) * np.maximum(depth - point, 0.0) ** 1.5, 0.0
    )
    if adhesive:
        positions = np.concatenate([np.linspace(-1.0, 1.0, count), np.linspace(1.0, -1.5, count)]) * deepest
        clean = mdr.solve(contact, mdr.Path(indentation=positions))["normal_force"].values
        depth = positions + point
    noise = log_uniform(rng, 1e-4, 3e-2) * np.ptp(clean)
    curve = mdr.MeasuredCurve(force=clean + noise * rng.normal(size=clean.size), indentation=depth)
    start = mdr.Contact(
        mdr.Paraboloid(radius),
        mdr.Elastic(young * log_uniform(rng, 0.1, 10.0), 0.5),
        adhesion=mdr.JKR(work * log_uniform(rng, 0.3, 3.0)) if adhesive else None,
    )
    free = ["body.young", *(["adhesion.work"] if adhesive else [])]
    fitted = mdr.fit(start, curve, free)
    truths = {"body.young": young, **({"adhesion.work": work} if adhesive else {}), "contact_point": point}
    for name, truth in truths.items():
        one = fitted[name]
        scale = abs(truth) if name != "contact_point" else deepest
        # a normal error lies beyond five standard errors once in two million
        yield Comparison(
            name, f"noise {noise!r}", 1.0 + (one.value - truth) / scale, 1.0, 0.5 * one.error / scale, False
        )


FAMILIES = {"memory": memory, "layers": layers, "closures": closures, "fits": fits}
