"""The package ContactMechanics: Love's influence of a pixel by fast transforms, and constrained conjugate gradients."""

from __future__ import annotations

import math
import warnings
from importlib.metadata import version
from typing import Any

import numpy as np

from pymdr.errors import MissingExtraError
from pymdr.independent.engines.protocol import HalfSpace, Pressing
from pymdr.independent.engines.solutions import first_pressure, is_solved, refuse_unsolved
from pymdr.units import FloatArray

_MOST_ITERATIONS = 3000
_LARGEST_STIFFNESS = 1.16
"""Stiffness of a square punch over the root of its area: an upper bound for contacts on the patch."""
_BYTES = 500.0
"""Peak memory per pixel."""


class ContactMechanicsEngine:
    """
    The half-space of ContactMechanics that is free outside the grid (Pastewka, Sanner and others, MIT licence).

    Notes
    -----
    Pastewka and Robbins (2016), Appl. Phys. Lett. 108, 221601; solved after Polonsky and Keer (1999), Wear 231, 206,
    starting from a pressure, because three-sided pyramids do not converge from displacements (the default of the package).
    """

    name = "contactmechanics"

    @property
    def version(self) -> str:
        """Name and version of the package."""
        _package()
        return f"ContactMechanics {version('ContactMechanics')}"

    def bytes_for(self, shape: tuple[int, int]) -> float:
        """Memory of a solution in bytes."""
        return _BYTES * shape[0] * shape[1]

    def half_space(self, shape: tuple[int, int], spacing: tuple[float, float]) -> HalfSpace:
        """A half-space under pixels."""
        return _FreeHalfSpace(shape, spacing)


class _FreeHalfSpace:
    def __init__(self, shape: tuple[int, int], spacing: tuple[float, float]) -> None:
        free, self._solve = _package()
        size = tuple(n * width for n, width in zip(shape, spacing, strict=True))
        # Young's modulus is E* here
        self._substrate = free(shape, 1.0, size)
        self._shape = shape
        self._area = spacing[0] * spacing[1]

    def press(
        self,
        heights: FloatArray,
        *,
        indentation: float | None = None,
        force: float | None = None,
        start: FloatArray | None = None,
        tolerance: float = 1e-6,
    ) -> Pressing:
        """Press a rigid surface on the half-space."""
        below = np.max(heights) - heights
        default = first_pressure(below, indentation)
        pressing = self._solved(below, indentation, force, default if start is None else start, tolerance)
        if start is not None and not is_solved(pressing, tolerance):
            # under a force the package may stop at a start with penetration outside its pixels
            pressing = self._solved(below, indentation, force, default, tolerance)
        refuse_unsolved("ContactMechanics", pressing, tolerance)
        return pressing

    def _solved(
        self,
        below: FloatArray,
        indentation: float | None,
        force: float | None,
        first: FloatArray,
        tolerance: float,
    ) -> Pressing:
        """The solution of the package, not yet checked."""
        if indentation is None:
            assert force is not None
            first = first * (force / (self._area * first.sum()))
            least = force / (_LARGEST_STIFFNESS * math.sqrt(self._area * below.size))
            load = {"external_force": force}
        else:
            least = indentation
            load = {"offset": indentation}
        forces = np.zeros(tuple(2 * n for n in self._shape))
        forces[: self._shape[0], : self._shape[1]] = -self._area * first
        solved = self._solve(
            self._substrate,
            -below,
            initial_forces=forces,
            pentol=0.5 * tolerance * least,
            forcetol=tolerance * least * math.sqrt(self._area),
            thermotol=0.1 * tolerance,
            maxiter=_MOST_ITERATIONS,
            logger=_Silent(),
            **load,
        )
        depth = float(solved.offset if indentation is None else indentation)
        gap = np.array(solved.x)[: self._shape[0], : self._shape[1]] + below - depth
        return Pressing(np.array(solved.jac) / self._area, gap, depth, int(solved.nit))


class _Silent:
    """A logger that drops messages; that of the package is slow and stores all of them."""

    def pr(self, *message: object, **how: object) -> None:
        """Drop a message."""

    st = warn = pr


def _package() -> tuple[Any, Any]:
    """The half-space and the solver."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # missing MPI
            from ContactMechanics import FreeFFTElasticHalfSpace
            from ContactMechanics.Optimization import constrained_conjugate_gradients
    except ImportError as error:
        raise MissingExtraError(
            "boundary elements by ContactMechanics need the extra rough: pip install 'pymdr[rough]'"
        ) from error
    return FreeFFTElasticHalfSpace, constrained_conjugate_gradients
