"""
Packages of boundary elements, loaded only on request.

ContactMechanics: Love's influence of a pixel by fast transforms, and constrained conjugate gradients. tamaas: AGPL. aspher:
distributed as source, preconditioned conjugate gradients on exact transforms.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from importlib.metadata import version
from typing import Any

import numpy as np

from pymdr.errors import ConvergenceError, MissingExtraError, ProblemError
from pymdr.independent.engines.protocol import HalfSpace, Pressing
from pymdr.independent.engines.solutions import ByForces, first_pressure, is_solved, refuse_unsolved
from pymdr.units import FloatArray

_MOST_ITERATIONS = 3000
_LARGEST_STIFFNESS = 1.16
"""Stiffness of a square punch over the root of its area: an upper bound for contacts on the patch."""
_FINEST = 1e-15
"""Finest goal of tamaas, whose error is refined until the gaps meet the tolerance."""
_FINER = 0.003
"""Tolerance of aspher over the requested one, because it is relative to the heights."""


def _contact_mechanics() -> tuple[Any, Any]:
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


def _tamaas() -> Any:
    try:
        import tamaas
    except ImportError as error:
        raise MissingExtraError(
            "boundary elements by tamaas (AGPL) need the extra tamaas: pip install 'pymdr[tamaas]'"
        ) from error
    tamaas.set_log_level(tamaas.LogLevel.error)
    return tamaas


def _aspher() -> Any:
    try:
        import aspher
    except ImportError as error:
        raise MissingExtraError(
            "boundary elements by aspher need the package aspher: pip install aspher (needs CMake, a compiler and Eigen)"
        ) from error
    return aspher


class _Package:
    """What engines have in common."""

    distribution: str
    load: Callable[[], Any]
    bytes_per_pixel = 300.0
    """Peak memory, including the padded grid and its transforms."""

    @property
    def version(self) -> str:
        """Name and version of the package."""
        self.load()
        return f"{self.distribution} {version(self.distribution)}"

    def bytes_for(self, shape: tuple[int, int]) -> float:
        """Memory of a solution in bytes."""
        return self.bytes_per_pixel * shape[0] * shape[1]


class ContactMechanicsEngine(_Package):
    """
    The half-space of ContactMechanics that is free outside the grid (Pastewka, Sanner and others, MIT licence).

    Notes
    -----
    Pastewka and Robbins (2016), Appl. Phys. Lett. 108, 221601; solved after Polonsky and Keer (1999), Wear 231, 206,
    starting from a pressure, because three-sided pyramids do not converge from displacements (the default of the package).
    """

    name, distribution = "contactmechanics", "ContactMechanics"
    bytes_per_pixel = 500.0
    load = staticmethod(_contact_mechanics)

    def half_space(self, shape: tuple[int, int], spacing: tuple[float, float]) -> HalfSpace:
        """A half-space under pixels."""
        return _FreeHalfSpace(shape, spacing)


class _FreeHalfSpace:
    def __init__(self, shape: tuple[int, int], spacing: tuple[float, float]) -> None:
        free, self._solve = _contact_mechanics()
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


class TamaasEngine(_Package):
    """
    The half-space of tamaas that is free outside the grid (Frérot and others, AGPL, with FFTW).

    Notes
    -----
    Frérot, Anciaux, Rey, Pham-Ba and Molinari (2020), J. Open Source Softw. 5, 2121. It prescribes forces: an indentation
    takes several solutions.
    """

    name = distribution = "tamaas"
    load = staticmethod(_tamaas)

    def half_space(self, shape: tuple[int, int], spacing: tuple[float, float]) -> HalfSpace:
        """A half-space under pixels."""
        return _NonPeriodic(shape, spacing)


class _NonPeriodic(ByForces):
    def __init__(self, shape: tuple[int, int], spacing: tuple[float, float]) -> None:
        self._tamaas = _tamaas()
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


class AspherEngine(_Package):
    """
    The half-space of aspher that is free outside the grid (Yastrebov, BSD licence).

    Notes
    -----
    Built from source with CMake, a compiler and Eigen. It accepts only square grids of square pixels, and prescribes forces:
    an indentation takes several solutions.
    """

    name = distribution = "aspher"
    load = staticmethod(_aspher)

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
        self._solver = _aspher().ContactSolver(grid_size=n, domain_size=n * width, backend="fft")
        self._n = n
        self.area = width * width

    def at_force(self, below: FloatArray, force: float, start: FloatArray, tolerance: float) -> Pressing:
        """The solution at a force; the package ignores the start."""
        mean = force / (self.area * below.size)
        solved = self._solver.solve(
            below.ravel(),
            p_nominal=mean,
            tol=_FINER * tolerance,
            max_iter=5000,
            precond="fourier-fft",
        )
        pressure = np.array(solved.pressure).reshape(self._n, self._n)
        gap = np.array(solved.displacement).reshape(self._n, self._n) + below
        depth = float(gap[pressure > 0.0].mean())
        pressing = Pressing(pressure, gap - depth, depth, int(solved.iterations))
        refuse_unsolved("aspher", pressing, tolerance)
        return pressing
