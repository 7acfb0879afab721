"""The protocol of boundary element engines."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from pymdr.units import FloatArray


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
