"""Engines by name: those of the house, and those that other packages offer by entry point."""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import entry_points
from typing import cast

from pymdr.errors import ProblemError
from pymdr.independent.engines.protocol import Engine
from pymdr.units import shown

GROUP = "pymdr.engines"
"""The group of entry points: a name, and a callable without arguments that makes an Engine."""
DEFAULT = "contactmechanics"
_HOUSE = {
    "contactmechanics": "ContactMechanicsEngine",
    "tamaas": "TamaasEngine",
    "aspher": "AspherEngine",
}


def engine_names() -> tuple[str, ...]:
    """Names of the engines that can be asked for, whether their packages are installed or not."""
    return (*_HOUSE, *sorted({point.name for point in entry_points(group=GROUP)} - set(_HOUSE)))


def find_engine(engine: str | Engine | None = None) -> Engine:
    """
    An engine by its name.

    Parameters
    ----------
    engine : str or Engine, optional
        Of the house, or of an entry point in the group ``pymdr.engines``; an Engine is itself; ContactMechanics unless given.

    Returns
    -------
    Engine

    Raises
    ------
    ProblemError
        If there is none of that name.

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
                f"engine = {shown(engine)}: no engine; give the name of one: {', '.join(engine_names())}"
            )
        return engine
    if engine in _HOUSE:
        made = getattr(import_module(f"pymdr.independent.engines.{engine}"), _HOUSE[engine])()
        return cast(Engine, made)
    for point in entry_points(group=GROUP):
        if point.name == engine:
            return cast(Engine, point.load()())
    raise ProblemError(
        f"engine = {shown(engine)}: there is none of that name; there are {', '.join(engine_names())}"
    )
