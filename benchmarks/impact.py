"""Many impacts of one contact on one curve against the equation of motion of five hundred springs."""

from collections.abc import Iterator

import numpy as np
from scipy.integrate import solve_ivp

import pymdr as mdr
from benchmarks.timing import Ratio, median_times

MASS, SPRINGS, SPEEDS, FEW = 0.033, 500, 10_000, 20
STEEL = mdr.Elastic("210 GPa", 0.3)
GEL = mdr.Elastic("30 kPa", 0.5)
CONTACTS = {
    "a ball": mdr.Contact(mdr.Paraboloid("10 mm"), STEEL),
    "a callable profile": mdr.Contact(mdr.Function(lambda r: r * r / 20e-3 + r**4 / 1e-3), STEEL),
}


def springs(contact: mdr.Contact, speeds: np.ndarray) -> np.ndarray:
    """Contact times by springs under the equivalent profile."""
    modulus = mdr.effective_moduli(contact.body, contact.counterbody).normal
    line = mdr.equivalent_profile(contact.profile)
    deepest = float(mdr.restitution(contact, mass=MASS, speeds=[speeds.max()])["indentation"][0])
    width = float(line.inverse(1.01 * deepest)) / SPRINGS
    profile = line.g(width * (np.arange(SPRINGS) + 0.5))
    stiffness = 2.0 * modulus * width / MASS

    def motion(t: float, state: np.ndarray) -> list[float]:
        return [state[1], -stiffness * float(np.maximum(state[0] - profile, 0.0).sum())]

    def parted(t: float, state: np.ndarray) -> float:
        return float(state[0]) if t > 0.0 else 1.0

    parted.terminal, parted.direction = True, -1.0
    times = []
    for v in speeds:
        limit = 10.0 * deepest / v
        size = [1e-9 * deepest, 1e-9 * v]
        found = solve_ivp(motion, (0.0, limit), [0.0, v], events=parted, rtol=1e-6, atol=size)
        times.append(found.t[-1])
    return np.array(times)


def ratios() -> Iterator[Ratio]:
    """The springs are timed on a few speeds, and scaled to as many as ours."""
    speeds = np.geomspace(1e-2, 1.0, SPEEDS)
    few = speeds[:: SPEEDS // FEW]
    for name, contact in CONTACTS.items():

        def ours(contact: mdr.Contact = contact) -> object:
            return mdr.restitution(contact, mass=MASS, speeds=speeds)

        def other(contact: mdr.Contact = contact) -> object:
            return springs(contact, few)

        fast, slow = median_times((ours, 5), (other, 2))
        aim = "aim 100 times"
        yield Ratio(f"{SPEEDS} impacts of {name}", "solve_ivp", fast, slow * SPEEDS / few.size, aim)
