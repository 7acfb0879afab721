"""What every solution of a contact with memory needs: how it relaxes along a path, when, and what is assumed of it."""

from __future__ import annotations

import numpy as np

from pymdr.errors import PathError
from pymdr.interpretation.validity import Assumption, small_slope_assumptions
from pymdr.mapping.equivalent import slope_function
from pymdr.mapping.relaxation import Relaxation, relaxation_of
from pymdr.problem.contact import Contact
from pymdr.problem.paths import LoadingPath
from pymdr.problem.rheology import PowerLawRheology
from pymdr.problem.schedule import Stretch, planned
from pymdr.units import FloatArray


def relaxation_along(contact: Contact, path: LoadingPath) -> Relaxation:
    """E*(t) of a contact, over the times of a path where a power of time asks for them."""
    bodies = (contact.body, contact.counterbody)
    powers = any(isinstance(getattr(one, "shear", None), PowerLawRheology) for one in bodies)
    return relaxation_of(*bodies, span=_span(path) if powers else None)


def _span(path: LoadingPath) -> tuple[float, float] | None:
    """About the shortest step and the length of a path in s, if its legs state their times."""
    steps, now, here = [], 0.0, dict[str, float]()
    for leg in planned(path):
        asked = leg.stretch(here, now)
        if asked.time is None:
            return None
        steps.append(np.diff(asked.time, prepend=now))
        now, here = float(asked.time[-1]), {**here, **asked.end}
    waits = np.concatenate(steps)
    return float(waits[waits > 0.0].min()), now


def times_of(asked: Stretch) -> FloatArray:
    """Time of every row of a leg in s; a leg without is refused."""
    if asked.time is None:
        raise PathError(
            "a body with memory asks when: give every leg a duration or a rate, for example indent('1 um', rate='1 um/s')"
        )
    return asked.time


def assumptions_with_memory(contact: Contact, radius: FloatArray) -> tuple[Assumption, ...]:
    """What the model assumes, measured on the largest of some contact radii in m."""
    a = float(np.max(radius, initial=0.0))
    if a == 0.0:
        return ()
    listed = small_slope_assumptions(contact.profile, slope_function(contact.profile), a, 0.0)
    return tuple(one for one in listed if one.name != "elastic similarity")
