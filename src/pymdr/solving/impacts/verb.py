"""The verb `impact`."""

from __future__ import annotations

from dataclasses import replace

from pymdr.problem.contact import Contact
from pymdr.solving.impacts.elastic import adhesive, elastic
from pymdr.solving.impacts.interpreting import of_shape, with_history
from pymdr.solving.impacts.memory import remembering
from pymdr.solving.impacts.plastic import plastic
from pymdr.solving.impacts.value import Impact, read
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
    Impact of two bodies through states of equilibrium.

    The normal motion is m d'' = -F(d). Without adhesion the largest indentation satisfies U(d) = m v^2 / 2, and the bodies
    separate with the initial speed after T = 2 int dd / sqrt(v^2 - 2 U(d) / m). With adhesion the energy W is lost in the
    jumps of the contact under a prescribed indentation, e = sqrt(1 - 2 W / (m v^2)). With friction the contact point moves
    tangentially by m_x u_x'' = -F_x, 1 / m_x = 1 / m + R^2 / I, where F_x depends on the whole history; the normal motion does
    not depend on it. A ball that yields dissipates up to its turning point and rebounds elastically. With memory F = int_0^t1 E*(t - s) dF0(d(s)), where t1 = t on the approach and
    int_t1^t E*(t - s) dd(s) = 0 on the retreat, and the bodies separate at t1 = 0.

    Parameters
    ----------
    contact : Contact
        Profile, materials and laws.
    mass : quantity
        Reduced mass 1 / (1/m_1 + 1/m_2) in kg: that of the body if the other one is fixed.
    speed : quantity
        Speed at the first touch in m/s, above 0.
    angle : quantity, optional
        Angle of the velocity from the normal in rad, at least 0 and below pi/2, such as "30 deg".
    inertia : quantity, optional
        Moment of inertia I in kg m^2 about the centre, for friction; by default that of a solid ball, 2/5 m R^2, for a
        sphere or a paraboloid; required for other profiles.
    radius : quantity, optional
        Distance R in m from the centre to the contact point, for friction and spin; by default the radius of the ball.
    spin : quantity, optional
        Angular velocity in rad/s, positive if it adds to the tangential speed of the contact point.
    steps : int
        Moves of the history, a multiple of 4.

    Returns
    -------
    Impact
        Over ``step``: time, motion and forces; restitution, contact time and other single numbers as attributes.

    Raises
    ------
    ProblemError
        If a value is not above 0, the contact is not a disk during the impact, or friction needs an inertia or a radius.
    PathError
        If the profile ends before the bodies come to rest.

    See Also
    --------
    restitution : many speeds at once.

    Notes
    -----
    Hertz (1882) for spheres; Thornton and Ning (1998) with adhesion; Maw, Barber and Fawcett (1976) with friction;
    Lee and Radok (1960), Ting (1966) with memory, with steps by collocation at Radau's nodes.

    References
    ----------
    - Hertz (1882), J. reine angew. Math. 92, 156-171.
    - Thornton and Ning (1998), Powder Technol. 99, 154-162, doi:10.1016/S0032-5910(98)00099-0.
    - Maw, Barber and Fawcett (1976), Wear 38, 101-114, doi:10.1016/0043-1648(76)90201-5.
    - Lee and Radok (1960), J. Appl. Mech. 27, 438-444.
    - Ting (1966), J. Appl. Mech. 33, 845-854.

    Examples
    --------
    >>> import pymdr as mdr
    >>> ball = mdr.Contact(mdr.Paraboloid("10 mm"), mdr.Elastic("210 GPa", 0.3))
    >>> hit = mdr.impact(ball, mass="33 g", speed="1 m/s")
    >>> round(hit.contact_time * 1 / hit.largest_indentation, 6)
    2.943275
    """
    request = read(contact, mass, speed, angle, inertia, radius, spin, steps)
    if contact.plastic is not None:
        return with_history(plastic(request))
    if contact.adhesion is not None:
        return with_history(adhesive(request))
    result = remembering(request) if contact.is_viscoelastic else elastic(request)
    return with_history(replace(result, data=of_shape(contact, result.data)))
