"""Maps, histories and fields of the normal contact against quad and brentq."""

from collections.abc import Iterator

import numpy as np
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.special import j1

import pymdr as mdr
from benchmarks.timing import Ratio, compare, process
from pymdr.line.foundation import ElasticLine, normal_force, states_at_depth

CALLABLES = {
    "sphere": lambda r: r / np.sqrt((1.0 - r) * (1.0 + r)),
    "quartic": lambda r: r + 4.0 * r**3,
    "wavy": lambda r: r + 0.06 * np.sin(6.0 * r),
    "hyperboloid": lambda r: r / np.sqrt(r * r + 0.09),
    "exponential": lambda r: 2.0 * r * np.exp(r * r),
    "bessel": lambda r: r + 0.3 * j1(5.0 * r),
}


def textbook_g(slope, x):
    """g(x) = x int_0^x f'(r) / sqrt(x^2 - r^2) dr by adaptive quadrature."""
    return x * quad(lambda r: slope(r) / np.sqrt(x * x - r * r), 0.0, x)[0]


def maps() -> Iterator[Ratio]:
    x = np.linspace(8e-4, 0.8, 1000)
    for name, slope in CALLABLES.items():
        known = mdr.equivalent_profile(mdr.Function(derivative=slope))

        def ours(slope=slope):
            # a callable of its own, so that nothing of it is mapped yet
            return mdr.equivalent_profile(mdr.Function(derivative=lambda r: slope(r))).g(x)

        def again(known=known):
            return known.g(x)

        def textbook(slope=slope):
            return np.array([textbook_g(slope, xi) for xi in x])

        yield compare(f"g at 1000 points again, {name}", again, "mapping it", ours, "no aim")
        note = f"differ by {np.max(np.abs(ours() / textbook() - 1.0)):.0e}"
        against = "the textbook integrand in quad"
        yield compare(f"g at 1000 points, {name}", ours, against, textbook, "aim 300", note)


def history() -> Iterator[Ratio]:
    slope = CALLABLES["wavy"]
    depths = np.linspace(4e-4, 0.4, 1000)
    radii = np.linspace(6e-4, 0.6, 1000)

    def ours():
        profile = mdr.Function(
            lambda r: r * r / 2 + 0.01 * (1 - np.cos(6 * r)), derivative=lambda r: slope(r)
        )
        contact = mdr.Contact(profile, mdr.Elastic(0.75, 0.5))
        result = mdr.solve(contact, mdr.Path(indentation=depths))
        return (
            result["contact_radius"].values,
            result["normal_force"].values,
            result.field("pressure", r=radii),
        )

    def second(r):
        return 1.0 + 0.36 * np.cos(6.0 * r)

    def g_slope(x):
        # g' = int (f' + r f'') dtheta, the textbook's form 2.3
        return quad(lambda t: slope(x * np.sin(t)) + x * np.sin(t) * second(x * np.sin(t)), 0.0, np.pi / 2)[0]

    def textbook():
        a = np.array([brentq(lambda x, d=d: textbook_g(slope, x) - d, 1e-9, 1.0, xtol=1e-15) for d in depths])
        force = np.array(
            [2 * quad(lambda r, ai=ai: slope(r) * r * r / np.sqrt(ai * ai - r * r), 0.0, ai)[0] for ai in a]
        )
        pressure = np.array(
            [
                quad(
                    lambda t, r=r: g_slope(np.hypot(r, t)) / np.hypot(r, t), 0.0, np.sqrt(a[-1] ** 2 - r * r)
                )[0]
                / np.pi
                for r in radii[radii < a[-1]]
            ]
        )
        return a, force, pressure

    yield compare(
        "1000 indentations and the pressure at 1000 radii",
        ours,
        "quad with brentq",
        textbook,
        "aim 100",
    )


def closed_form() -> Iterator[Ratio]:
    d = np.linspace(1e-7, 0.1, 1_000_000)
    contact = mdr.Contact(mdr.Paraboloid(1.0), mdr.Elastic(0.75, 0.5))
    path = mdr.Path(indentation=d)
    line = ElasticLine(mdr.equivalent_profile(contact.profile), 1.0)

    def formula():
        return np.sqrt(d), 4.0 / 3.0 * d**1.5

    def whole_formula():
        a = np.sqrt(d)
        force = 4.0 / 3.0 * d**1.5
        return a, force, 2.0 * a, force / (np.pi * a * a), 0.4 * force * d

    def kernels():
        states = states_at_depth(line, d)
        return states.contact_radius, normal_force(line, states)

    yield compare("1e6 indentations, radius and force", kernels, "the NumPy formula", formula, "aim 5")
    yield compare(
        "1e6 indentations, solve() with every quantity and claim",
        lambda: mdr.solve(contact, path),
        "the NumPy formula of the same five quantities",
        whole_formula,
        "aim 5",
    )


def startup() -> Iterator[Ratio]:
    bare = process("-c", "import numpy, scipy.special")
    yield compare(
        "import pymdr", process("-c", "import pymdr"), "import numpy, scipy.special", bare, "aim 1.5"
    )
    yield compare(
        "pymdr --help", process("-m", "pymdr", "--help"), "import numpy, scipy.special", bare, "aim 2"
    )


def ratios() -> Iterator[Ratio]:
    yield from startup()
    yield from maps()
    yield from closed_form()
    yield from history()
