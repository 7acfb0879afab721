"""Three-dimensional boundary elements by other packages: their protocol and names."""

from pymdr.independent.engines.finding import DEFAULT, engine_names, find_engine
from pymdr.independent.engines.protocol import Engine, HalfSpace, Pressing

__all__ = ["DEFAULT", "Engine", "HalfSpace", "Pressing", "engine_names", "find_engine"]
