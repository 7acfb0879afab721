"""The verb."""

from __future__ import annotations

from dataclasses import replace

from pymdr.problem.contact import Contact
from pymdr.solving.impacts.adhesive import adhesive
from pymdr.solving.impacts.asking import read
from pymdr.solving.impacts.elastic import elastic
from pymdr.solving.impacts.memory import remembering
from pymdr.solving.impacts.telling import of_shape, with_history
from pymdr.solving.impacts.value import Impact
from pymdr.units import QuantityLike


def impact(
    contact: Contact,
    *,
    mass: QuantityLike,
    speed: QuantityLike,
    angle: QuantityLike = 0.0,
    inertia: QuantityLike | None = None,
    radius: QuantityLike | None = None,
    spin: QuantityLike = 0.0,
    steps: int = 200,
) -> Impact:
    """
    The impact of two bodies, by states of equilibrium.

    The normal motion is m d'' = -F(d). Without adhesion the bodies are deepest where U(d) = m v^2 / 2, and part with the
    speed with which they met after T = 2 int dd / sqrt(v^2 - 2 U(d) / m). Adhesion takes the energy W that is lost where
    the contact jumps under a prescribed indentation, e = sqrt(1 - 2 W / (m v^2)). With friction the contact point moves
    sideways by m_x u_x'' = -F_x, 1 / m_x = 1 / m + R^2 / I, where F_x remembers the whole history; the normal motion does
    not depend on it. With memory F = int_0^t1 E*(t - s) dF0(d(s)), where t1 = t on the approach and
    int_t1^t E*(t - s) dd(s) = 0 on the retreat, and the bodies part where t1 = 0.

    Parameters
    ----------
    contact : Contact
        Profile, materials and laws.
    mass : quantity
        Reduced mass 1 / (1/m_1 + 1/m_2) in kg: that of the body where the other one is fixed.
    speed : quantity
        Speed at the first touch in m/s, above 0.
    angle : quantity, optional
        Angle of the velocity from the normal in rad, at least 0 and below pi/2, such as "30 deg".
    inertia : quantity, optional
        Moment of inertia I in kg m^2 about the centre, for friction; of a solid ball, 2/5 m R^2, unless given. It has to
        be given for other profiles than a sphere or a paraboloid.
    radius : quantity, optional
        Distance R in m from the centre to the contact point, for friction and spin; the radius of the ball unless given.
    spin : quantity, optional
        Angular velocity in rad/s, above 0 where it moves the contact point on in the direction of its tangential speed.
    steps : int
        Moves of the history, a multiple of 4.

    Returns
    -------
    Impact

    Raises
    ------
    ProblemError
        If a value is not above 0, the contact is not a disk on the way, or friction needs an inertia or a radius.
    PathError
        If the profile ends before the bodies come to rest.

    Notes
    -----
    Hertz (1882) for spheres; Thornton and Ning (1998) with adhesion; Maw, Barber and Fawcett (1976) with friction;
    Lee and Radok (1960), Ting (1966) with memory, where the motion is followed in steps by collocation at Radau's nodes.

    Examples
    --------
    >>> import pymdr as mdr
    >>> ball = mdr.Contact(mdr.Paraboloid("10 mm"), mdr.Elastic("210 GPa", 0.3))
    >>> hit = mdr.impact(ball, mass="33 g", speed="1 m/s")
    >>> round(hit.contact_time * 1 / hit.largest_indentation, 6)
    2.943275
    """
    asked = read(contact, mass, speed, angle, inertia, radius, spin, steps)
    if contact.adhesion is not None:
        return with_history(adhesive(asked))
    found = remembering(asked) if contact.remembers else elastic(asked)
    return with_history(replace(found, data=of_shape(contact, found.data)))
