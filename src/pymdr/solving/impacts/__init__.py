"""Impacts: what a mass that meets a contact does until it leaves again."""

from pymdr.solving.impacts.speeds import restitution
from pymdr.solving.impacts.value import Event, Impact, Restitution
from pymdr.solving.impacts.verb import impact

__all__ = ["Event", "Impact", "Restitution", "impact", "restitution"]
