"""Impacts of a mass on a contact, from first touch to separation."""

from pymdr.solving.impacts.speeds import restitution
from pymdr.solving.impacts.value import Event, Impact, Restitution
from pymdr.solving.impacts.verb import impact

__all__ = ["Event", "Impact", "Restitution", "impact", "restitution"]
