"""Engines by name: built-in ones, and those of other packages by entry point."""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import entry_points
from typing import cast

from pymdr.errors import ProblemError
from pymdr.independent.engines.protocol import Engine
from pymdr.units import shown

GROUP = "pymdr.engines"
"""Group of entry points: a name, and a callable without arguments that returns an Engine."""
DEFAULT = "contactmechanics"
_BUILT_IN = {
    "contactmechanics": "ContactMechanicsEngine",
    "tamaas": "TamaasEngine",
    "aspher": "AspherEngine",
}


def engine_names() -> tuple[str, ...]:
    """Names of all engines, whether their packages are installed or not."""
    return (*_BUILT_IN, *sorted({point.name for point in entry_points(group=GROUP)} - set(_BUILT_IN)))


def find_engine(engine: str | Engine | None = None) -> Engine:
    """
    An engine by its name.

    Parameters
    ----------
    engine : str or Engine, optional
        Built-in name, name of an entry point in the group ``pymdr.engines``, or an Engine; by default ContactMechanics.

    Raises
    ------
    ProblemError
        If the name is unknown.

    Examples
    --------
    >>> find_engine("tamaas").name
    'tamaas'
    """
    if engine is None:
        engine = DEFAULT
    if not isinstance(engine, str):
        if not callable(getattr(engine, "half_space", None)):
            raise ProblemError(
                f"engine = {shown(engine)} is not an engine; give one of {', '.join(engine_names())}"
            )
        return engine
    if engine in _BUILT_IN:
        built_in = getattr(import_module(f"pymdr.independent.engines.{engine}"), _BUILT_IN[engine])()
        return cast(Engine, built_in)
    for point in entry_points(group=GROUP):
        if point.name == engine:
            return cast(Engine, point.load()())
    raise ProblemError(f"engine = {shown(engine)} is unknown; give one of {', '.join(engine_names())}")
