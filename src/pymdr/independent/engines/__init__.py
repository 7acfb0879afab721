"""Three-dimensional boundary elements by other packages: their protocol and names."""

from pymdr.independent.engines.protocol import DEFAULT, Engine, HalfSpace, Pressing, engine_names, find_engine

__all__ = ["DEFAULT", "Engine", "HalfSpace", "Pressing", "engine_names", "find_engine"]
