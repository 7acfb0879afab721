"""The package tamaas (AGPL), loaded only on request."""

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
"""Finest goal of the package, whose error is refined until the gaps meet the tolerance."""
_BYTES = 300.0
"""Bytes per pixel, including the padded grid and its transforms."""


class TamaasEngine:
    """
    The half-space of tamaas that is free outside the grid (Frérot and others, AGPL, with FFTW).

    Notes
    -----
    Frérot, Anciaux, Rey, Pham-Ba and Molinari (2020), J. Open Source Softw. 5, 2121. It prescribes forces: an indentation
    takes several solutions.
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
            # the package misses contacts of a single pixel
            return summit
        pressing, failure = summit, None
        # a start may miss pixels that the package does not recover; then start uniformly
        for first in (
            start * (force / (self.area * start.sum())),
            np.full_like(start, force / (self.area * start.size)),
        ):
            self._model.traction[:] = first
            goal = tolerance
            while goal >= _FINEST:
                try:
                    pressing = self._solved(below, force, goal)
                except self._tamaas.FloatingPointError as error:
                    failure = error
                    break
                if is_solved(pressing, 0.5 * tolerance):
                    return pressing
                goal *= 0.01
        if failure is not None:
            raise ConvergenceError(
                f"tamaas failed at a force of {force:g}: {' '.join(str(failure).split())}; use the engine contactmechanics"
            ) from failure
        refuse_unsolved("tamaas", pressing, tolerance)
        return pressing

    def _solved(self, below: FloatArray, force: float, goal: float) -> Pressing:
        """The solution of the package, starting from the traction of its model."""
        # kept alive by its name: the solver holds no reference
        surface = np.ascontiguousarray(-below)
        solver = self._tamaas.PolonskyKeerRey(self._model, surface, goal)
        solver.setIntegralOperator("free")
        solver.max_iter = _MOST_ITERATIONS
        solver.solve(force / (self.area * below.size))
        return self._pressing(below, np.maximum(np.array(self._model.traction), 0.0))

    def _pressing(self, below: FloatArray, pressure: FloatArray) -> Pressing:
        """Gap and depth of a pressure; those of the model have an offset."""
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
