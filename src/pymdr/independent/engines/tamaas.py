"""The package tamaas, under the AGPL: it is never loaded unless it is asked for."""

from __future__ import annotations

from importlib.metadata import version
from typing import Any

import numpy as np

from pymdr.errors import ConvergenceError, MissingExtraError
from pymdr.independent.engines.protocol import HalfSpace, Pressing
from pymdr.independent.engines.solutions import ByForces, is_solved, refuse_unsolved
from pymdr.units import FloatArray

_MOST_ITERATIONS = 3000
_FINEST = 1e-15
"""It measures its error in its own way: the goal is made finer until the gaps, which are measured afterwards, keep to the tolerance."""
_BYTES = 300.0
"""Per pixel, of the padded grid with its transforms."""


class TamaasEngine:
    """
    The half-space of tamaas that is free outside the grid (Frérot and others, AGPL, with FFTW).

    Notes
    -----
    Frérot, Anciaux, Rey, Pham-Ba and Molinari (2020), J. Open Source Softw. 5, 2121. It knows forces, so that an indentation
    is found by some solutions.
    """

    name = "tamaas"

    @property
    def version(self) -> str:
        """Name and version of the package."""
        _package()
        return f"tamaas {version('tamaas')}"

    def bytes_for(self, shape: tuple[int, int]) -> float:
        """Memory of a solution in bytes."""
        return _BYTES * shape[0] * shape[1]

    def half_space(self, shape: tuple[int, int], spacing: tuple[float, float]) -> HalfSpace:
        """A half-space under pixels."""
        return _NonPeriodic(shape, spacing)


class _NonPeriodic(ByForces):
    def __init__(self, shape: tuple[int, int], spacing: tuple[float, float]) -> None:
        self._tamaas = _package()
        size = [n * width for n, width in zip(shape, spacing, strict=True)]
        kind = self._tamaas.model_type.basic_2d
        self._model = self._tamaas.ModelFactory.createModel(kind, size, list(shape))
        self._model.E, self._model.nu = 1.0, 0.0
        self._tamaas.ModelFactory.registerNonPeriodic(self._model, "free")
        self.area = spacing[0] * spacing[1]

    def at_force(self, below: FloatArray, force: float, start: FloatArray, tolerance: float) -> Pressing:
        """The solution at a force."""
        summit = self._pressing(
            below, np.where(below == 0.0, force / (self.area * np.sum(below == 0.0)), 0.0)
        )
        if is_solved(summit, tolerance):
            # a contact that the package does not find where it is a single pixel
            return summit
        found, failure = summit, None
        # from a start that misses pixels which the package does not find again it begins evenly
        for first in (
            start * (force / (self.area * start.sum())),
            np.full_like(start, force / (self.area * start.size)),
        ):
            self._model.traction[:] = first
            goal = tolerance
            while goal >= _FINEST:
                try:
                    found = self._solved(below, force, goal)
                except self._tamaas.FloatingPointError as error:
                    failure = error
                    break
                if is_solved(found, 0.5 * tolerance):
                    return found
                goal *= 0.01
        if failure is not None:
            raise ConvergenceError(
                f"tamaas ended without a number at a force of {force:g}: {' '.join(str(failure).split())}; take the engine contactmechanics"
            ) from failure
        refuse_unsolved("tamaas", found, tolerance)
        return found

    def _solved(self, below: FloatArray, force: float, goal: float) -> Pressing:
        """What the package ends with, begun from the traction of its model."""
        # named, since the solver does not keep the array that it looks at
        surface = np.ascontiguousarray(-below)
        solver = self._tamaas.PolonskyKeerRey(self._model, surface, goal)
        solver.setIntegralOperator("free")
        solver.max_iter = _MOST_ITERATIONS
        solver.solve(force / (self.area * below.size))
        return self._pressing(below, np.maximum(np.array(self._model.traction), 0.0))

    def _pressing(self, below: FloatArray, pressure: FloatArray) -> Pressing:
        """Gap and depth of a pressure: of the model they are shifted."""
        displacement = np.zeros_like(pressure)
        self._model.operators["free"](pressure, displacement)
        gap = displacement + below
        depth = float(gap[pressure > 0.0].mean())
        return Pressing(pressure, gap - depth, depth, 0)


def _package() -> Any:
    try:
        import tamaas
    except ImportError as error:
        raise MissingExtraError(
            "boundary elements by tamaas (AGPL) need the extra tamaas: pip install 'pymdr[tamaas]'"
        ) from error
    tamaas.set_log_level(tamaas.LogLevel.error)
    return tamaas
