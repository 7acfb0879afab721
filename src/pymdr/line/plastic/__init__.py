"""Step 2 of a ball that yields: its line is an ellipse, whose axes depend on the largest indentation."""

from pymdr.line.plastic.adhesion import (
    Edge,
    Parting,
    follow_edge,
    parting_from,
    start_of_edge,
)
from pymdr.line.plastic.ball import DEEPEST, Ball
from pymdr.line.plastic.ellipse import Ellipse
from pymdr.line.plastic.growth import GrowingBall, Growth, with_growth
from pymdr.line.plastic.moved import GrowingContacts, YieldingContacts

__all__ = [
    "DEEPEST",
    "Ball",
    "Edge",
    "Ellipse",
    "GrowingBall",
    "GrowingContacts",
    "Growth",
    "Parting",
    "YieldingContacts",
    "follow_edge",
    "parting_from",
    "start_of_edge",
    "with_growth",
]
