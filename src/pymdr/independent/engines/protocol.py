"""What a package of boundary elements is asked for."""

from __future__ import annotations

from typing import NamedTuple, Protocol

from pymdr.units import FloatArray


class Pressing(NamedTuple):
    """A rigid surface pressed on an elastic half-space of E* = 1."""

    pressure: FloatArray
    """(nx, ny), not below 0; 0 where there is no contact."""
    gap: FloatArray
    """(nx, ny); 0 in the contact to the tolerance."""
    indentation: float
    """From the highest pixel."""
    iterations: int


class HalfSpace(Protocol):
    """A half-space of E* = 1 under a grid of pixels; what can be prepared for all loads is prepared."""

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
            Of the highest pixel below the undeformed plane, or the integral of the pressure; exactly one, above 0.
        start : ndarray, optional
            A pressure to begin with.
        tolerance : float, optional
            Largest error of the gap in the contact, and largest penetration outside, over the indentation.

        Returns
        -------
        Pressing

        Raises
        ------
        ConvergenceError
            If the tolerance was not reached; with the last iterate.
        """
        ...


class Engine(Protocol):
    """A package of boundary elements."""

    name: str

    @property
    def version(self) -> str:
        """Name and version of the package, which results tell."""
        ...

    def bytes_for(self, shape: tuple[int, int]) -> float:
        """Memory that a half-space and a solution take, without what is asked and answered."""
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

        Returns
        -------
        HalfSpace

        Raises
        ------
        MissingExtraError
            If the package is not installed.
        ProblemError
            If the package does not take such a grid.
        """
        ...
