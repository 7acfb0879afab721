"""Contacts of one body that another program moves step by step, whatever they remember."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from copy import copy
from itertools import pairwise
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from pymdr.errors import PathError, ProblemError
from pymdr.problem.values import LARGEST
from pymdr.units import FloatArray, shown

BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.intp]

NOW, BEFORE = range(2)
"""Second index of what contacts remember: after the last step, and before it."""


Part = tuple[int, int]
"""Contacts from one up to another."""


class Threads:
    """Parts of several contacts, each of which a thread moves by a kernel that holds no lock of the interpreter."""

    def __init__(self, count: int, workers: int) -> None:
        self._pool = ThreadPoolExecutor(workers) if workers > 1 else None
        self.parts: list[Part] = list(pairwise(np.linspace(0, count, workers + 1).astype(int).tolist()))

    def run(self, kernel: Callable[[Part], Any], parts: list[Part] | None = None) -> list[Any]:
        """What a kernel returns of all parts, or of some."""
        parts = self.parts if parts is None else parts
        return list(map(kernel, parts) if self._pool is None else self._pool.map(kernel, parts))


class CompiledStep(NamedTuple):
    """A compiled step with its arguments."""

    step: Any
    """``step(body, states, i, indentation, shift, duration)`` of contact i, which returns ``(ending, normal, tangential)``."""
    body: tuple[Any, ...]
    """What all contacts share."""
    states: tuple[Any, ...]
    """What the contacts remember, which steps change."""


class Moved(ABC):
    """
    Contacts of one body; quantities are arrays of the shape (count,).

    A kind of memory has its quantities as properties under their names in results, and takes those that it does not have from
    :class:`WithoutShift` and :class:`WithoutAdhesion`.
    """

    arrays: tuple[np.ndarray, ...]
    """All that the contacts remember: their number is the first index, NOW and BEFORE are the second."""
    threads: Threads
    """By which compiled kernels move them together."""

    @property
    def count(self) -> int:
        """Number of contacts."""
        return int(self.arrays[0].shape[0])

    @property
    @abstractmethod
    def indentation(self) -> FloatArray:
        """Indentations in m."""

    @property
    @abstractmethod
    def shift(self) -> FloatArray:
        """Shifts in m."""

    @property
    @abstractmethod
    def normal_force(self) -> FloatArray:
        """F_N in N."""

    @property
    @abstractmethod
    def tangential_force(self) -> FloatArray:
        """F_x in N, which resists the shift."""

    @property
    @abstractmethod
    def contact_radius(self) -> FloatArray:
        """In m; 0 without contact."""

    @property
    @abstractmethod
    def stick_radius(self) -> FloatArray:
        """Radius in m of the part that sticks."""

    @property
    @abstractmethod
    def normal_stiffness(self) -> FloatArray:
        """Tangent stiffness dF_N/dd in N/m."""

    @property
    @abstractmethod
    def tangential_stiffness(self) -> FloatArray:
        """Tangent stiffness in N/m as the motion goes on."""

    @property
    @abstractmethod
    def elastic_energy(self) -> FloatArray:
        """Energy in J stored by the indentation."""

    @property
    @abstractmethod
    def surface_energy(self) -> FloatArray:
        """Energy in J of the surfaces in contact."""

    @property
    @abstractmethod
    def stored_tangential_energy(self) -> FloatArray:
        """Energy in J stored by the shift."""

    @property
    @abstractmethod
    def dissipated_energy(self) -> FloatArray:
        """Energy in J dissipated so far."""

    @property
    @abstractmethod
    def jumped(self) -> BoolArray:
        """Whether the last step jumped."""

    @property
    def branch(self) -> IntArray:
        """Number of the branch of equilibria, -1 without contact; one without adhesion."""
        return np.where(self.contact_radius > 0.0, 0, -1)

    @property
    def touched(self) -> BoolArray:
        """Whether bodies that attract each other have been in contact."""
        return np.zeros(self.count, dtype=bool)

    @property
    def yielded(self) -> BoolArray:
        """Whether a body has yielded."""
        return np.zeros(self.count, dtype=bool)

    @abstractmethod
    def advance(self, depth: float, shift: Any, duration: Any) -> tuple[float, ...]:
        """
        Go with one contact straight to an indentation and a shift in m within a duration in s; the forces in N.

        The indentation is finite and within the reach of the curves; shift and duration are checked where they have an effect.
        """

    @abstractmethod
    def advance_all(self, depth: FloatArray, shift: Any, duration: Any) -> tuple[FloatArray, ...]:
        """The same with all contacts."""

    def rotate(self, angle: Any) -> None:
        """Turn everything in the plane by an angle in rad; contacts that move along one line refuse it."""
        raise ProblemError(
            "the contact moves along one line, which cannot turn; elastic bodies with friction move in the plane with springs=, "
            "such as springs=32"
        )

    def undo(self) -> None:
        """Give all contacts the state before the last step."""
        for array in self.arrays:
            array[:, NOW] = array[:, BEFORE]

    def copied(self) -> Self:
        """The same contacts, which move on their own."""
        other = copy(self)
        other.arrays = tuple(array.copy() for array in self.arrays)
        return other


class _Zeros:
    """A quantity that contacts do not have: 0."""

    def __get__(self, contacts: Moved, owner: type) -> FloatArray:
        return np.zeros(contacts.count)


class WithoutShift:
    """Quantities of contacts that carry no tangential force."""

    shift = tangential_force = stick_radius = _Zeros()
    tangential_stiffness = stored_tangential_energy = _Zeros()


class WithoutAdhesion:
    """Quantities of contacts without adhesion, which do not jump."""

    arrays: tuple[np.ndarray, ...]
    surface_energy = _Zeros()

    @property
    def jumped(self) -> BoolArray:
        """Whether the last step jumped."""
        return np.zeros(self.arrays[0].shape[0], dtype=bool)


class OnNormal(WithoutAdhesion, Moved):
    """Contacts with a tangential part, which remember `_own` arrays besides those of the same contacts without friction."""

    normal: Moved
    """The same contacts without friction."""
    _own: tuple[np.ndarray, ...]

    @property
    def arrays(self) -> tuple[np.ndarray, ...]:
        """All that the contacts remember."""
        return (*self._own, *self.normal.arrays)

    @arrays.setter
    def arrays(self, arrays: tuple[np.ndarray, ...]) -> None:
        one, other, *normal = arrays
        self._own, self.normal.arrays = (one, other), tuple(normal)

    @property
    def threads(self) -> Threads:
        """By which compiled kernels move them together."""
        return self.normal.threads

    @threads.setter
    def threads(self, threads: Threads) -> None:
        self.normal.threads = threads

    def copied(self) -> Self:
        """The same contacts, which move on their own."""
        other = super().copied()
        other.normal = self.normal.copied()
        return other

    @property
    def indentation(self) -> FloatArray:
        """Indentations in m."""
        return self.normal.indentation

    @property
    def normal_force(self) -> FloatArray:
        """F_N in N."""
        return self.normal.normal_force

    @property
    def contact_radius(self) -> FloatArray:
        """In m; 0 without contact."""
        return self.normal.contact_radius

    @property
    def normal_stiffness(self) -> FloatArray:
        """Tangent stiffness in N/m."""
        return self.normal.normal_stiffness

    @property
    def elastic_energy(self) -> FloatArray:
        """Energy in J stored by the indentation."""
        return self.normal.elastic_energy


def beyond(given: str) -> PathError:
    """The error of a value in m that is not finite, or whose products overflow."""
    return PathError(f"{given}; a finite value within {LARGEST:g} m is needed")


def durations_of(count: int, duration: Any) -> list[float]:
    """Durations in s of the steps of a number of contacts with memory, after refusing what is none."""
    given = [duration] if np.ndim(duration) == 0 else np.ravel(duration).tolist()
    for each in given:
        if each is None or not 0.0 <= float(each) <= LARGEST:
            raise PathError(
                f"duration = {shown(each)}; a body with memory needs the duration of every step in s, finite and at least 0 and at most {LARGEST:g}"
            )
    return [float(each) for each in np.broadcast_to(given, count)]
