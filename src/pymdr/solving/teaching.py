"""The discretised foundation for teaching."""

from __future__ import annotations

import math

import numpy as np

from pymdr.errors import ProblemError
from pymdr.line.foundation import SpringFoundation, spring_foundation, states_at_depth
from pymdr.line.friction import SpringHistory, springs
from pymdr.problem.contact import Contact, require_contact
from pymdr.solving.mapped import map_to_springs, refuse_unreachable
from pymdr.units import ArrayQuantityLike, QuantityLike, metres, to_si, to_si_array


def foundation(
    contact: Contact, n: int = 400, *, half_length: QuantityLike | None = None
) -> SpringFoundation:
    """
    The discretised foundation of Popov and Hess (2015): n springs of stiffness E* dx under g(x).

    It is for teaching; :func:`solve` uses the exact integrals instead.

    Parameters
    ----------
    contact : Contact
        Profile, materials and laws.
    n : int
        Number of springs, at least 2.
    half_length : quantity, optional
        Half the length of the line in m; by default 1.2 edges, a third of the radius of curvature, or twice the
        last breakpoint, within the known part of the profile.

    Returns
    -------
    SpringFoundation
        Positions and profile of n springs in m, and their forces in N at any indentation.

    Raises
    ------
    ProblemError
        If `n` is not a whole number of at least 2, or no half length is given for a profile without one.

    See Also
    --------
    equivalent_profile : the profile of the line.
    effective_moduli : the stiffness of its springs.

    References
    ----------
    Popov and Hess (2015), Method of Dimensionality Reduction in Contact Mechanics and Friction, Springer,
    doi:10.1007/978-3-642-53876-6.

    Examples
    --------
    >>> import pymdr as mdr
    >>> springs = mdr.foundation(mdr.Contact(mdr.Paraboloid(1.0), mdr.Elastic(0.75, 0.5)), n=4000, half_length=1.0)
    >>> round(springs.normal_force(0.25), 5), round(springs.contact_radius(0.25), 3)
    (0.16667, 0.5)
    """
    if isinstance(n, bool) or not isinstance(n, int) or n < 2:
        raise ProblemError(f"n = {n!r} springs; a whole number of at least 2 is needed")
    require_contact(contact)
    line = map_to_springs(contact).line
    if half_length is not None:
        length = to_si(half_length, "m", name="half_length")
    elif math.isfinite(line.equivalent.edge):
        length = 1.2 * line.equivalent.edge
    elif contact.profile.curvature_radius is not None:
        length = contact.profile.curvature_radius / 3.0
    elif contact.profile.breakpoints:
        length = min(2.0 * contact.profile.breakpoints[-1], line.equivalent.max_radius)
    elif math.isfinite(line.equivalent.max_radius):
        length = line.equivalent.max_radius
    else:
        raise ProblemError("this profile has no characteristic length; give half_length, such as '1 um'")
    if length <= 0.0:
        raise ProblemError(f"half_length = {metres(length)}; it must be above 0 m")
    return spring_foundation(line, length, n)


def friction_foundation(
    contact: Contact,
    indentation: ArrayQuantityLike,
    shift: ArrayQuantityLike,
    n: int = 400,
) -> SpringHistory:
    """
    The springs of Popov and Hess (2015) with friction: tangential stiffness G* dx, force at most mu E* dx (d - g).

    It is for teaching; :func:`solve` integrates histories exactly.

    Parameters
    ----------
    contact : Contact
        With ``friction=Coulomb(mu)``.
    indentation, shift : array_like or quantity, shape (m,)
        d and u_x of every row in m; the first is reached from (0, 0).
    n : int
        Number of springs, at least 2.

    Returns
    -------
    SpringHistory
        Tangential force, stick radius, stored energy and slip work of every row; the error of the force is
        O(1/n^2) for finite mu and smooth g, and converges more slowly without slip and near cusps, kinks and edges.

    Raises
    ------
    ProblemError
        If the contact has no friction, or `n` or the rows cannot be used.

    Notes
    -----
    Popov and Hess (2015), chapter 5.

    Examples
    --------
    >>> from pymdr.problem.laws import Coulomb
    >>> from pymdr.problem.materials import Elastic
    >>> from pymdr.problem.profiles import Paraboloid
    >>> ball = Contact(Paraboloid(1.0), Elastic(1.0, 0.0), friction=Coulomb(1.0))
    >>> round(float(friction_foundation(ball, [0.5, 0.5], [0.0, 0.25], n=4000).tangential_force[-1]), 5)
    0.30474
    """
    require_contact(contact)
    if contact.friction is None:
        raise ProblemError("give Contact(..., friction=Coulomb(0.3))")
    d = np.atleast_1d(to_si_array(indentation, "m", name="indentation"))
    u = np.atleast_1d(to_si_array(shift, "m", name="shift"))
    if d.shape != u.shape or d.ndim != 1 or d.size == 0:
        raise ProblemError(f"{d.size} indentations for {u.size} shifts; give the same number of each")
    if isinstance(n, bool) or not isinstance(n, int) or n < 2:
        raise ProblemError(f"n = {n!r} springs; a whole number of at least 2 is needed")
    mapped = map_to_springs(contact)
    deepest = states_at_depth(mapped.line, np.array([float(np.max(d))]))
    refuse_unreachable(mapped.line, contact.profile, deepest)
    a = float(deepest.contact_radius[0]) or 1.0
    half = (n + 1) // 2
    spacing = a / half
    g = mapped.line.equivalent.g((np.arange(half) + 0.5) * spacing)
    return springs(
        g, spacing, d, u, contact.friction.coefficient, mapped.line.modulus, mapped.moduli.tangential
    )
