"""The discretised foundation in which the method is taught."""

from __future__ import annotations

import math

from pymdr.errors import ProblemError
from pymdr.line.foundation import SpringFoundation, spring_foundation
from pymdr.problem.contact import Contact
from pymdr.solving.reach import map_to_line
from pymdr.units import QuantityLike, to_si


def foundation(
    contact: Contact, n: int = 400, *, half_length: QuantityLike | None = None
) -> SpringFoundation:
    """
    The discretised foundation of the founding paper: n springs of stiffness E* dx under g(x).

    It is how the method is taught; :func:`solve` uses the exact integrals instead.

    Parameters
    ----------
    contact : Contact
    n : int
        Number of springs, at least 2.
    half_length : quantity, optional
        Half the length of the line in m; a third of the profile's radius (or 1.2 edges) unless given.

    Returns
    -------
    SpringFoundation

    Raises
    ------
    ProblemError
        If `n` is not a whole number of at least 2, or no half length is given for a profile without one.

    Examples
    --------
    >>> from pymdr.problem.materials import Elastic
    >>> from pymdr.problem.profiles import Paraboloid
    >>> springs = foundation(Contact(Paraboloid(1.0), Elastic(0.75, 0.5)), n=4000, half_length=1.0)
    >>> round(springs.normal_force(0.25), 5), round(springs.contact_radius(0.25), 3)
    (0.16667, 0.5)
    """
    if isinstance(n, bool) or not isinstance(n, int) or n < 2:
        raise ProblemError(f"foundation: n = {n!r} springs; a whole number of at least 2 is needed")
    line = map_to_line(contact).line
    if half_length is not None:
        length = to_si(half_length, "m", name="half_length")
    elif math.isfinite(line.equivalent.edge):
        length = 1.2 * line.equivalent.edge
    elif contact.profile.curvature_radius is not None:
        length = contact.profile.curvature_radius / 3.0
    else:
        raise ProblemError("foundation: this profile has no length of its own; give half_length='1 um' or so")
    if length <= 0.0:
        raise ProblemError(f"foundation: half_length = {length:g} m; it must be above 0 m")
    return spring_foundation(line, length, n)
