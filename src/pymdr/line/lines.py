"""The line of a contact, by the kind of its bodies."""

from __future__ import annotations

from functools import lru_cache

from pymdr.line.curves import ElasticLine, Line
from pymdr.line.layered import LayeredLine
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.mapping.layers import kernel_of
from pymdr.mapping.moduli import effective_moduli
from pymdr.problem.contact import Contact
from pymdr.problem.materials import Material
from pymdr.problem.profiles import Profile


def springs_of(contact: Contact) -> ElasticLine:
    """
    The independent springs that represent two half-spaces.

    Raises
    ------
    ProblemError
        If a body is layered: its springs act on one another.

    Examples
    --------
    >>> from pymdr.problem.materials import Elastic
    >>> from pymdr.problem.profiles import Paraboloid
    >>> springs_of(Contact(Paraboloid(1.0), Elastic(0.75, 0.5))).modulus
    1.0
    """
    moduli = effective_moduli(contact.body, contact.counterbody)
    return ElasticLine(equivalent_profile(contact.profile, moduli.exponent), moduli.normal)


def line_of(contact: Contact) -> Line:
    """
    The line of two bodies of any kind.

    Examples
    --------
    >>> from pymdr.problem.layers import Layer, Layered
    >>> from pymdr.problem.materials import Elastic
    >>> from pymdr.problem.profiles import Paraboloid
    >>> film = Layered([Layer(Elastic(0.75, 0.5), 1.0)])
    >>> line_of(Contact(Paraboloid(1.0), film)).modulus
    1.0
    """
    if contact.layered is None:
        return springs_of(contact)
    return _layered(contact.profile, contact.body, contact.counterbody)


def unit_line_of(contact: Contact) -> ElasticLine | LayeredLine:
    """The line of two bodies that relax by one function E*(t), for E* = 1 Pa."""
    if contact.layered is None:
        return ElasticLine(equivalent_profile(contact.profile), 1.0)
    return _layered(contact.profile, contact.body, contact.counterbody)


@lru_cache(maxsize=8)
def _layered(profile: Profile, body: Material, counterbody: Material) -> LayeredLine:
    """The line of layers with its table, which is made once."""
    return LayeredLine(equivalent_profile(profile), kernel_of(body, counterbody))
