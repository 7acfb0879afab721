"""The package aspher, which comes as source: preconditioned conjugate gradients on exact transforms."""

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
"""Its tolerance over the asked one, which it measures relative to the heights."""
_MOST_ITERATIONS = 5000


class AspherEngine:
    """
    The half-space of aspher that is free outside the grid (Yastrebov, BSD licence).

    Notes
    -----
    It is built from source with CMake, a compiler and Eigen, takes as many pixels along x as along y and square ones, and knows
    forces, so that an indentation is found by some solutions.
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
                f"aspher takes square grids of square pixels, not {shape[0]} x {shape[1]} pixels of {spacing[0]:g} by "
                f"{spacing[1]:g}; take the engine contactmechanics"
            )
        return _Free(shape[0], spacing[0])


class _Free(ByForces):
    def __init__(self, n: int, width: float) -> None:
        self._solver = _package().ContactSolver(grid_size=n, domain_size=n * width, backend="fft")
        self._n = n
        self.area = width * width

    def at_force(self, below: FloatArray, force: float, start: FloatArray, tolerance: float) -> Pressing:
        """The solution at a force; the package begins from pressures of its own."""
        mean = force / (self.area * below.size)
        found = self._solver.solve(
            below.ravel(),
            p_nominal=mean,
            tol=_FINER * tolerance,
            max_iter=_MOST_ITERATIONS,
            precond="fourier-fft",
        )
        pressure = np.array(found.pressure).reshape(self._n, self._n)
        gap = np.array(found.displacement).reshape(self._n, self._n) + below
        depth = float(gap[pressure > 0.0].mean())
        answer = Pressing(pressure, gap - depth, depth, int(found.iterations))
        refuse_unsolved("aspher", answer, tolerance)
        return answer


def _package() -> Any:
    try:
        import aspher
    except ImportError as error:
        raise MissingExtraError(
            "boundary elements by aspher need that package: pip install aspher, with CMake, a compiler and Eigen at hand"
        ) from error
    return aspher
