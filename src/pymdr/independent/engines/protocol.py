"""The protocol of boundary element engines, and engines by name: built-in ones, and those of other packages by entry point."""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import entry_points
from typing import NamedTuple, Protocol, cast

from pymdr.errors import ProblemError
from pymdr.units import FloatArray, shown


class Pressing(NamedTuple):
    """A rigid surface pressed on an elastic half-space of E* = 1."""

    pressure: FloatArray
    """(nx, ny), not below 0; 0 outside the contact."""
    gap: FloatArray
    """(nx, ny); 0 in the contact to the tolerance."""
    indentation: float
    """Counted from the highest pixel."""
    iterations: int


class HalfSpace(Protocol):
    """A half-space of E* = 1 under a grid of pixels, prepared for all loads."""

    def press(
        self,
        heights: FloatArray,
        *,
        indentation: float | None = None,
        force: float | None = None,
        start: FloatArray | None = None,
        tolerance: float = 1e-6,
    ) -> Pressing:
        """
        Press a rigid surface on the half-space, without friction and adhesion, free outside the grid.

        Parameters
        ----------
        heights : ndarray
            (nx, ny).
        indentation, force : float
            Depth of the highest pixel below the undeformed plane, or integral of the pressure; exactly one, above 0.
        start : ndarray, optional
            Initial pressure.
        tolerance : float, optional
            Largest error of the gap in the contact, and largest penetration outside, over the indentation.

        Raises
        ------
        ConvergenceError
            If the tolerance is not reached; the message holds the last iterate.
        """
        ...


class Engine(Protocol):
    """A package of boundary elements."""

    name: str

    @property
    def version(self) -> str:
        """Name and version of the package, stored in results."""
        ...

    def bytes_for(self, shape: tuple[int, int]) -> float:
        """Memory in bytes of a half-space and a solution, without input and output."""
        ...

    def half_space(self, shape: tuple[int, int], spacing: tuple[float, float]) -> HalfSpace:
        """
        A half-space under pixels.

        Parameters
        ----------
        shape : tuple of int
            (nx, ny).
        spacing : tuple of float
            Widths of a pixel along x and y.

        Raises
        ------
        MissingExtraError
            If the package is not installed.
        ProblemError
            If the package does not support the grid.
        """
        ...


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
        built_in = getattr(import_module("pymdr.independent.engines.built_in"), _BUILT_IN[engine])()
        return cast(Engine, built_in)
    for point in entry_points(group=GROUP):
        if point.name == engine:
            return cast(Engine, point.load()())
    raise ProblemError(f"engine = {shown(engine)} is unknown; give one of {', '.join(engine_names())}")
