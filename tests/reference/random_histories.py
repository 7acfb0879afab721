"""Random histories of profiles that are powers, with references of another kind: friction, adhesion, torsion, stress, impacts and
shifts in the plane.

Each function draws one problem from a generator, solves it, and yields comparisons as `random_problems` does.

- friction: along a straight row the shift of a spring is a piecewise linear function of its label d = g(x), also where it slips or
  comes into contact on the way, so that the line is integrated in closed form at any row of any history.
- adhesion: JKR by its closed curves and a follower of its own; Maugis-Dugdale by the equations of Maugis (1992), whose radii are drawn.
- torsion: the torque of a disk that sticks and of full slip in closed form.
- stress: integrals of complex potentials, int_0^a q(x) Re H(z + i x) dx, without disks or tables.
- impacts: contact time and largest values in Gamma functions.
- plane: 4,000 springs with vectors of force, whose own error is measured with half of them.
"""

import math

import numpy as np
from pymdr_reference_random_problems import Comparison, claimed, compare, log_uniform, power_profile
from pymdr_reference_vector_springs import many_springs, numerical_errors
from scipy.optimize import brentq
from scipy.special import gamma

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(48)


def _body(rng, mdr):
    """A body and its E*, G* and G on a rigid one."""
    young, poisson = log_uniform(rng, 1e2, 1e12), float(rng.choice([0.0, 0.3, 0.5, rng.uniform(0.0, 0.5)]))
    shear = young / (2.0 * (1.0 + poisson))
    return (
        mdr.Elastic(young, poisson),
        young / (1.0 - poisson**2),
        4.0 * shear / (2.0 - poisson),
        shear,
        poisson,
    )


# --- friction --------------------------------------------------------------------------------------------


class LabelledSprings:
    """Shifts u(y) of springs with label y = g(x), piecewise linear between nodes; the last node is at the edge, y = d."""

    def __init__(self, ratio):
        self.ratio, self.depth, self.shift = ratio, 0.0, 0.0
        self.y, self.u = np.zeros(1), np.zeros(1)

    def move(self, depth, shift):
        """Follow a straight row to a depth above 0."""
        step, before = shift - self.shift, self.depth
        self.shift, self.depth = shift, depth
        y, u = self.y, self.u + step
        if depth > before:
            # springs that come into contact on the way are moved by what is left of the row
            y, u = np.append(y, depth), np.append(u, 0.0)
        else:
            u = np.append(u[y < depth], np.interp(depth, y, u))
            y = np.append(y[y < depth], depth)
        for sign in (1.0, -1.0):
            y, u = self._clipped(y, u, depth, sign)
        self.y, self.u = y, u

    def _clipped(self, y, u, depth, sign):
        """Not beyond the limit on one side: nodes where the shift meets it are added."""
        over = sign * u - self.ratio * (depth - y)
        cross = np.flatnonzero(over[:-1] * over[1:] < 0.0)
        at = y[cross] + np.diff(y)[cross] * over[cross] / (over[cross] - over[cross + 1])
        nodes = np.concatenate([y, at])
        order = np.argsort(nodes, kind="stable")
        values = np.concatenate([u, np.interp(at, y, u)])
        limit = self.ratio * (depth - nodes)
        values = np.minimum(values, limit) if sign > 0.0 else np.maximum(values, -limit)
        return nodes[order], values[order]

    def moments(self, power):
        """int u dx, int |limit| dx and int u^2 dx over the contact for x = y^power, exact; x in units of c^-power."""
        low, high = self.y[:-1], self.y[1:]
        wide = high > low
        low, high = low[wide], high[wide]
        first, last = self.u[:-1][wide], self.u[1:][wide]
        slope = (last - first) / (high - low)

        def part(k):
            """int y^k d(y^power)."""
            return power / (power + k) * (high ** (power + k) - low ** (power + k))

        # about the middle of each piece, where nothing cancels, by a rule that is exact for thin pieces
        thin = low > 0.7 * high
        sums = np.zeros((2, low.size))
        base = first - slope * low
        sums[0] = base * part(0.0) + slope * part(1.0)
        sums[1] = base**2 * part(0.0) + 2.0 * base * slope * part(1.0) + slope**2 * part(2.0)
        if thin.any():
            half = 0.5 * (high - low)[thin, None]
            y = low[thin, None] + half * (1.0 + _NODES)
            u = first[thin, None] + slope[thin, None] * half * (1.0 + _NODES)
            weight = half * _WEIGHTS * power * y ** (power - 1.0)
            sums[0, thin], sums[1, thin] = (u * weight).sum(axis=1), (u**2 * weight).sum(axis=1)
        return sums.sum(axis=1)


def friction(rng, mdr, full):
    """Random rows of indentation and shift: tangential force, stored energy and dissipated energy."""
    profile, n, c = power_profile(rng, mdr)
    body, normal, tangential, _, _ = _body(rng, mdr)
    mu = log_uniform(rng, 1e-2, 2.0)
    ratio = mu * normal / tangential
    deepest = c * (profile.radius * log_uniform(rng, 1e-2, 1.0)) ** n
    count = int(rng.integers(2, 60 if full else 15))
    depth = deepest * rng.uniform(0.02, 1.0, count)
    constant = rng.random(count) < 0.4
    for row in np.flatnonzero(constant[1:]) + 1:
        depth[row] = depth[row - 1]
    shift = np.cumsum(rng.normal(size=count)) * deepest * ratio * log_uniform(rng, 0.03, 2.0)
    shift[0] = 0.0
    contact = mdr.Contact(profile, body, friction=mdr.Coulomb(mu))
    path = mdr.Path(indentation=depth, shift=shift)
    result = mdr.solve(contact, path)
    springs = LabelledSprings(ratio)
    force = result["tangential_force"].values
    stored = result["stored_tangential_energy"].values
    scale = c ** (-1.0 / n)
    largest = 0.0
    for row in range(count):
        springs.move(depth[row], shift[row])
        moment, square = springs.moments(1.0 / n) * scale
        truth = 2.0 * tangential * moment
        limit = mu * 2.0 * normal * n / (n + 1.0) * c ** (-1.0 / n) * depth[row] ** (1.0 + 1.0 / n)
        # relative to the limit of sliding, to which springs add up
        yield Comparison("tangential_force", f"row {row}", 1.0 + (force[row] - truth) / limit, 1.0, 0.0, True)
        energy = tangential * square
        largest = max(largest, energy, limit * ratio * depth[row])
        yield Comparison(
            "stored_tangential_energy", f"row {row}", 1.0 + (stored[row] - energy) / largest, 1.0, 0.0, True
        )


# --- adhesion --------------------------------------------------------------------------------------------


def adhesion(rng, mdr, full):
    """JKR of a power along random depths, or Maugis-Dugdale of a paraboloid at drawn radii."""
    if rng.random() < 0.5:
        yield from _maugis(rng, mdr)
        return
    profile, n, c = power_profile(rng, mdr)
    if n <= 0.6:
        return
    body, normal, *_ = _body(rng, mdr)
    radius = profile.radius * log_uniform(rng, 1e-2, 0.5)
    # d = c a^n - s a^(1/2), with a zero of the first force or depth at the radius
    strain = c * radius ** (n - 0.5) * log_uniform(rng, 1e-3, 1.0)
    work = strain**2 * normal / (2.0 * math.pi)
    fold = (strain / (2.0 * n * c)) ** (1.0 / (n - 0.5))
    lowest = c * fold**n - strain * math.sqrt(fold)
    highest = c * profile.radius**n - strain * math.sqrt(profile.radius)
    if highest <= 0.0 or fold >= 0.5 * profile.radius:
        return
    top = highest * log_uniform(rng, 1e-2, 0.99)
    depth = rng.uniform(1.3 * lowest, top, int(rng.integers(2, 40 if full else 12)))
    depth = depth[np.abs(depth - lowest) > 1e-6 * abs(lowest)]
    depth = depth[np.abs(depth) > 1e-9 * top]
    if depth.size == 0:
        return
    result = mdr.solve(
        mdr.Contact(profile, body, adhesion=mdr.JKR(work)),
        mdr.Path(indentation=np.append(-abs(lowest), depth)),
    )
    touching = False
    for row, d in enumerate(depth, start=1):
        touching = d > 0.0 or (touching and d > lowest)
        if not touching:
            yield from compare(result, "normal_force", row, 0.0, f"d = {d!r}")
            continue

        def excess(a, d=d):
            return c * a**n - strain * math.sqrt(a) - d

        a = brentq(excess, fold, profile.radius, xtol=1e-300, rtol=1e-15)
        pressed, drawn = 2.0 * normal * n / (n + 1.0) * c * a ** (n + 1.0), 2.0 * normal * strain * a**1.5
        # the equation of the radius, and the difference of two large forces, amplify rounding
        steep = (n * c * a**n - 0.5 * strain * math.sqrt(a)) / (c * a**n + strain * math.sqrt(a))
        rounding = 1e-14 / abs(steep)
        yield from compare(result, "contact_radius", row, a, f"d = {d!r}", rounding)
        truth = pressed - drawn
        yield from compare(
            result, "normal_force", row, truth, f"d = {d!r}", 20.0 * rounding * (pressed + drawn) / abs(truth)
        )


def _maugis(rng, mdr):
    radius = log_uniform(rng, 1e-9, 1.0)
    body, normal, *_ = _body(rng, mdr)
    a = radius * log_uniform(rng, 1e-3, 0.3)
    strength = normal * a / radius * log_uniform(rng, 1e-2, 30.0)

    def opening(a, m):
        """Of the zone at its outer edge."""
        root = math.sqrt((m - 1.0) * (m + 1.0))
        angle = math.atan(root)
        elastic = a * a / (math.pi * radius) * (root + (m * m - 2.0) * angle)
        return elastic + 4.0 * strength * a / (math.pi * normal) * (root * angle - m + 1.0)

    m = 1.0 + log_uniform(rng, 1e-3, 3.0)
    extent = opening(a, m)
    wider = a * (1.0 + 1e-6)
    other = brentq(lambda q: opening(wider, q) - extent, 1.0, 2.0 * m, xtol=1e-15)

    def depth_of(a, m):
        return a * a / radius - 2.0 * strength * a * math.sqrt(m * m - 1.0) / normal

    if depth_of(wider, other) <= depth_of(a, m):
        return
    d, angle = depth_of(a, m), math.atan(math.sqrt(m * m - 1.0))
    pressed = 4.0 * normal * a**3 / (3.0 * radius)
    drawn = 2.0 * strength * a**2 * (math.sqrt(m * m - 1.0) + m * m * angle)
    law = mdr.MaugisDugdale(strength * extent, range=extent)
    deep = max(d, 0.0) + a * a / radius + 2.0 * extent
    result = mdr.solve(
        mdr.Contact(mdr.Paraboloid(radius), body, adhesion=law), mdr.Path(indentation=[deep, d])
    )
    steep = (depth_of(wider, other) - d) / (1e-6 * (a * a / radius + strength * a / normal))
    # the opening is a difference of larger terms for short zones
    uncertain = 1e-12 / min(abs(steep), 1.0) / min(1.0, (m - 1.0))
    at = f"a = {a!r}, c/a = {m!r}"
    yield from compare(result, "contact_radius", 1, a, at, uncertain)
    yield from compare(result, "cohesive_radius", 1, a * m, at, uncertain)
    truth = pressed - drawn
    yield from compare(
        result, "normal_force", 1, truth, at, 10.0 * uncertain * (pressed + drawn) / abs(truth)
    )


# --- torsion ---------------------------------------------------------------------------------------------


def torsion(rng, mdr, full):
    """Torque without slip and under full slip."""
    profile, n, c = power_profile(rng, mdr)
    body, normal, _, shear, _ = _body(rng, mdr)
    a = profile.radius * log_uniform(rng, 1e-2, 1.0)
    depth, angle = c * a**n, log_uniform(rng, 1e-8, 1e-2)
    path = mdr.indent(depth) >> mdr.twist(angle)
    result = mdr.solve(mdr.Contact(profile, body, friction=mdr.Coulomb(math.inf)), path)
    torque = 16.0 / 3.0 * shear * a**3 * angle
    yield from compare(result, "torque", 1, torque, f"a = {a!r}")
    yield from compare(result, "stored_torsional_energy", 1, 0.5 * torque * angle, f"a = {a!r}")
    mu = log_uniform(rng, 1e-2, 2.0)
    full_slip = math.pi * mu * normal * depth * a**2 * (0.5 - 1.0 / (n + 2.0))
    far = full_slip / (16.0 / 3.0 * shear * a**3) * 1e6
    result = mdr.solve(
        mdr.Contact(profile, body, friction=mdr.Coulomb(mu)), mdr.indent(depth) >> mdr.twist(far)
    )
    # the middle still sticks, over a part that falls with the twist
    yield from compare(result, "torque", 1, full_slip, f"full slip, mu = {mu!r}", 1e-4)


# --- stress ----------------------------------------------------------------------------------------------


def stress(rng, mdr, full):
    """Stress below a pressed body at random points, by complex potentials."""
    profile, n, c = power_profile(rng, mdr)
    body, normal, _, _, poisson = _body(rng, mdr)
    a = profile.radius * log_uniform(rng, 1e-2, 1.0)
    depth, count = c * a**n, 4 if full else 2
    result = mdr.solve(mdr.Contact(profile, body), mdr.Path(indentation=[depth]))
    r, z = a * np.sort(rng.uniform(1e-3, 3.0, count)), a * np.sort(np.exp(rng.uniform(-3.0, 1.5, count)))
    computed = result.field("stress", r=r, z=z, step=0).transpose("component", "z", "r").values
    error, exact = claimed(result, "stress", 0)
    for i, at in enumerate(z):
        truth = potentials(n, a, normal * depth, poisson, r, np.full(count, at))
        size = np.abs(truth).max(axis=0)
        for component, name in enumerate(("rr", "tt", "zz", "rz")):
            for k in range(count):
                miss = (computed[component, i, k] - truth[component, k]) / size[k]
                place = f"r/a = {r[k] / a!r}, z/a = {at / a!r}"
                yield Comparison(f"stress {name}", place, 1.0 + miss, 1.0, error, exact, 1e-10)


def potentials(n, a, size, poisson, r, z):
    """Components rr, tt, zz, rz under a line load q(x) = size (1 - (x/a)^n), shape (4, ...)."""
    # graded to both ends: the load is no polynomial, and the potentials are steep next to x = r for small z
    edges = np.concatenate([np.geomspace(1e-9, 0.5, 31), 1.0 - np.geomspace(0.5, 1e-9, 31)[1:], [1.0]])
    edges = np.concatenate([[0.0], edges])
    totals = np.zeros((4, r.size))
    for k in range(r.size):
        near = (r[k] + np.array([-3, -1, -0.3, 0, 0.3, 1, 3]) * z[k]) / a
        own = np.unique(np.concatenate([edges, np.clip(near, 0.0, 1.0)]))
        x = (own[:-1, None] + np.diff(own)[:, None] * (1.0 + _NODES) / 2.0).ravel()
        load = size * (1.0 - x**n) * (np.diff(own)[:, None] * _WEIGHTS / 2.0).ravel() * a
        at = z[k] + 1j * a * x
        root = np.sqrt(r[k] ** 2 + at**2)
        h1, h2 = -at / root**3, (2.0 * at**2 - r[k] ** 2) / root**5
        k0, k1, k2 = (1.0 - at / root) / r[k], -r[k] / root**3, 3.0 * r[k] * at / root**5
        rr = (-h1 - z[k] * h2) - ((1.0 - 2.0 * poisson) * k0 + z[k] * k1) / r[k]
        both = -(1.0 + 2.0 * poisson) * h1 - z[k] * h2
        parts = np.array([rr, both - rr, -h1 + z[k] * h2, z[k] * k2])
        totals[:, k] = -(parts.real @ load) / math.pi
    return totals


# --- impacts ---------------------------------------------------------------------------------------------


def impacts(rng, mdr, full):
    """Contact time, largest force, depth and radius of an elastic impact along the axis."""
    profile, n, c = power_profile(rng, mdr)
    body, normal, *_ = _body(rng, mdr)
    a = profile.radius * log_uniform(rng, 1e-2, 0.9)
    depth = c * a**n
    m = 1.0 + 1.0 / n
    stiff = 2.0 * normal * n / (n + 1.0) * c ** (-1.0 / n)
    mass = log_uniform(rng, 1e-15, 1e3)
    speed = math.sqrt(2.0 * stiff * depth ** (m + 1.0) / ((m + 1.0) * mass))
    result = mdr.impact(mdr.Contact(profile, body), mass=mass, speed=speed)
    fraction = 1.0 / (m + 1.0)
    time = 2.0 * depth / speed * math.sqrt(math.pi) * gamma(1.0 + fraction) / gamma(0.5 + fraction)
    truths = {
        "contact_time": time,
        "largest_force": stiff * depth**m,
        "largest_indentation": depth,
        "largest_radius": a,
        "restitution": 1.0,
    }
    for name, truth in truths.items():
        yield from compare_scalar(result, name, truth)


def compare_scalar(study, name, truth):
    """Comparisons of one number of a study, if it is claimed."""
    claim = study.claims[name]
    if claim.readable and claim.error is not None:
        error = float(np.max(claim.error))
        yield Comparison(name, "", float(study[name]), truth, error, claim.level.name == "EXACT", 1e-13)


# --- shifts in the plane ---------------------------------------------------------------------------------


def plane(rng, mdr, full):
    """Random rows or circles of shifts in the plane at random depths: force and dissipated energy over the claimed numerical errors."""
    profile, n, c = power_profile(rng, mdr)
    body, normal, tangential, _, _ = _body(rng, mdr)
    mu = log_uniform(rng, 1e-2, 2.0)
    deepest = c * (profile.radius * log_uniform(rng, 1e-2, 1.0)) ** n
    count = int(rng.integers(3, 40 if full else 15))
    depth = deepest * rng.uniform(0.02, 1.0, count)
    if rng.random() < 0.4:
        depth[:] = depth[0]
    if rng.random() < 0.4:
        turn = rng.uniform(0.1, 1.0) * np.arange(count)
        shift = rng.uniform(-0.5, 0.5, 2) + rng.uniform(0.2, 1.5) * np.stack([np.cos(turn), np.sin(turn)], 1)
    else:
        shift = np.cumsum(rng.normal(size=(count, 2)), axis=0)
    shift = shift * deepest * mu * normal / tangential * log_uniform(rng, 0.03, 2.0)
    path = mdr.Path(indentation=depth, shift=shift)
    result = mdr.solve(mdr.Contact(profile, body, friction=mdr.Coulomb(mu)), path)
    joint = normal, tangential, mu
    (coarse_force, coarse_work), (force, work) = (
        many_springs(depth, shift, (c, n), joint, number, 24) for number in (2000, 4000)
    )
    limit = mu * 2.0 * normal * n / (n + 1.0) * c ** (-1.0 / n) * depth.max() ** (1.0 + 1.0 / n)
    claims = numerical_errors(result)
    size = work[-1] or limit * float(np.max(np.abs(shift)))  # nothing slips where the depth rises fast enough
    for row in range(count):
        for axis, name in enumerate("xy"):
            off = (result["tangential_force"].values[row, axis] - force[row, axis]) / limit
            own = abs(force - coarse_force)[row, axis] / limit
            yield Comparison(f"tangential_force {name}", f"row {row}", 1.0 + off, 1.0, claims[0], False, own)
        off = (result["dissipated_energy"].values[row] - work[row]) / size
        own = abs(work - coarse_work)[row] / size
        yield Comparison("dissipated_energy", f"row {row}", 1.0 + off, 1.0, claims[1], False, own)


FAMILIES = {
    "friction": friction,
    "adhesion": adhesion,
    "torsion": torsion,
    "stress": stress,
    "impacts": impacts,
    "plane": plane,
}
