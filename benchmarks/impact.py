"""Many impacts of one contact on one curve against the equation of motion of five hundred springs, elastic or with memory."""

from collections.abc import Iterator

import numpy as np
from scipy.integrate import solve_ivp

import pymdr as mdr
from benchmarks.timing import Ratio, median_times
from pymdr.mapping.relaxation import relaxation_of

MASS, SPRINGS, SPEEDS, FEW = 0.033, 500, 10_000, 20
STEEL = mdr.Elastic("210 GPa", 0.3)
RUBBER = mdr.Viscoelastic(mdr.StandardSolid("1 MPa", "3 MPa", "1 ms"), poisson=0.5)
BOUNCING = mdr.Contact(mdr.Paraboloid("5 mm"), RUBBER)
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
        result = solve_ivp(motion, (0.0, limit), [0.0, v], events=parted, rtol=1e-6, atol=size)
        times.append(result.t[-1])
    return np.array(times)


def springs_with_memory(contact: mdr.Contact, speeds: np.ndarray) -> np.ndarray:
    """Restitutions by springs under the equivalent profile, each with its Maxwell branch."""
    kernel = relaxation_of(contact.body)
    modulus, time, soft = kernel.moduli[0], kernel.times[0], kernel.equilibrium
    line = mdr.equivalent_profile(contact.profile)
    largest = mdr.restitution(contact, mass=MASS, speeds=[speeds.max()])
    deepest, lasting = float(largest["indentation"][0]), float(largest["contact_time"][0])
    width = float(line.inverse(1.01 * deepest)) / SPRINGS
    profile = line.g(width * (np.arange(SPRINGS) + 0.5))

    def motion(t: float, state: np.ndarray) -> np.ndarray:
        d, v, w, h = state[0], state[1], state[2 : 2 + SPRINGS], state[2 + SPRINGS :]
        q = soft * w + h
        # a free spring keeps q = 0 as it creeps back; one that is touched follows the mass
        creep = h / time / (soft + modulus)
        touching = (d - profile >= w) & ((q > 0.0) | (v > creep))
        rate = np.where(touching, v, creep)
        return np.concatenate(
            [[v, -2.0 * width / MASS * float(q[touching].clip(0.0).sum())], rate, modulus * rate - h / time]
        )

    def parted(t: float, state: np.ndarray) -> float:
        q = soft * state[2 : 2 + SPRINGS] + state[2 + SPRINGS :]
        return float(q[0]) if state[1] < 0.0 else 1.0

    parted.terminal, parted.direction = True, -1.0
    results = []
    for v in speeds:
        limit = 10.0 * lasting * (speeds.max() / v) ** 0.5
        sizes = [1e-6 * deepest] * (2 + SPRINGS) + [1e-6 * deepest * modulus] * SPRINGS
        sizes[1] = 1e-6 * v
        begin = np.zeros(2 + 2 * SPRINGS)
        begin[1] = v
        end = solve_ivp(motion, (0.0, limit), begin, events=parted, rtol=1e-4, atol=sizes)
        results.append(-end.y[1, -1] / v)
    return np.array(results)


def ratios() -> Iterator[Ratio]:
    """The springs are timed on a few speeds, and scaled to as many as ours."""
    speeds = np.geomspace(1e-2, 1.0, SPEEDS)
    few = speeds[:: SPEEDS // FEW]
    for name, contact in CONTACTS.items():

        def ours(contact: mdr.Contact = contact) -> object:
            return mdr.restitution(contact, mass=MASS, speeds=speeds)

        def other(contact: mdr.Contact = contact) -> object:
            return springs(contact, few)

        fast, slow = median_times(ours, other)
        aim = "aim 100 times"
        yield Ratio(f"{SPEEDS} impacts of {name}", "solve_ivp", fast, slow * SPEEDS / few.size, aim)

    def remembering() -> object:
        return mdr.restitution(BOUNCING, mass=MASS, speeds=speeds)

    fast, slow = median_times(remembering, lambda: springs_with_memory(BOUNCING, few))
    yield Ratio(f"{SPEEDS} impacts on rubber", "solve_ivp", fast, slow * SPEEDS / few.size, "aim 100 times")
