"""Three-dimensional boundary elements, by packages of others: how one is asked, and which there are."""

from pymdr.independent.engines.finding import DEFAULT, engine_names, find_engine
from pymdr.independent.engines.protocol import Engine, HalfSpace, Pressing

__all__ = ["DEFAULT", "Engine", "HalfSpace", "Pressing", "engine_names", "find_engine"]
