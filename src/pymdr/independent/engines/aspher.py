"""The package aspher, distributed as source: preconditioned conjugate gradients on exact transforms."""

from __future__ import annotations

from importlib.metadata import version
from typing import Any

import numpy as np

from pymdr.errors import MissingExtraError, ProblemError
from pymdr.independent.engines.protocol import HalfSpace, Pressing
from pymdr.independent.engines.solutions import ByForces, refuse_unsolved
from pymdr.units import FloatArray

_BYTES = 300.0
_FINER = 0.003
"""Its tolerance over the requested one, because it is relative to the heights."""
_MOST_ITERATIONS = 5000


class AspherEngine:
    """
    The half-space of aspher that is free outside the grid (Yastrebov, BSD licence).

    Notes
    -----
    Built from source with CMake, a compiler and Eigen. It accepts only square grids of square pixels, and prescribes forces:
    an indentation takes several solutions.
    """

    name = "aspher"

    @property
    def version(self) -> str:
        """Name and version of the package."""
        _package()
        return f"aspher {version('aspher')}"

    def bytes_for(self, shape: tuple[int, int]) -> float:
        """Memory of a solution in bytes."""
        return _BYTES * shape[0] * shape[1]

    def half_space(self, shape: tuple[int, int], spacing: tuple[float, float]) -> HalfSpace:
        """A half-space under pixels."""
        if shape[0] != shape[1] or abs(spacing[0] / spacing[1] - 1.0) > 1e-9:
            raise ProblemError(
                f"aspher accepts only square grids of square pixels, not {shape[0]} x {shape[1]} pixels of {spacing[0]:g} by "
                f"{spacing[1]:g}; use the engine contactmechanics"
            )
        return _Free(shape[0], spacing[0])


class _Free(ByForces):
    def __init__(self, n: int, width: float) -> None:
        self._solver = _package().ContactSolver(grid_size=n, domain_size=n * width, backend="fft")
        self._n = n
        self.area = width * width

    def at_force(self, below: FloatArray, force: float, start: FloatArray, tolerance: float) -> Pressing:
        """The solution at a force; the package ignores the start."""
        mean = force / (self.area * below.size)
        solved = self._solver.solve(
            below.ravel(),
            p_nominal=mean,
            tol=_FINER * tolerance,
            max_iter=_MOST_ITERATIONS,
            precond="fourier-fft",
        )
        pressure = np.array(solved.pressure).reshape(self._n, self._n)
        gap = np.array(solved.displacement).reshape(self._n, self._n) + below
        depth = float(gap[pressure > 0.0].mean())
        pressing = Pressing(pressure, gap - depth, depth, int(solved.iterations))
        refuse_unsolved("aspher", pressing, tolerance)
        return pressing


def _package() -> Any:
    try:
        import aspher
    except ImportError as error:
        raise MissingExtraError(
            "boundary elements by aspher need the package aspher: pip install aspher (needs CMake, a compiler and Eigen)"
        ) from error
    return aspher
