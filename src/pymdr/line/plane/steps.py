"""Compiled single steps of springs in the plane. Loads numba."""

from __future__ import annotations

from pymdr.compiling import Fused
from pymdr.line.moved import BEFORE, NOW
from pymdr.line.plane import kernels
from pymdr.line.plane.kernels import advanced, move_of, stick_border
from pymdr.line.plane.layout import AT_X, AT_Y, DEPTH, FORCE_X, FORCE_Y, PER_FORCE, PER_SHIFT, WORK
from pymdr.units import FloatArray

_fused = Fused(__file__, kernels.__file__)


@_fused.compiled
def step(
    labels: FloatArray,
    scales: FloatArray,
    vectors: FloatArray,
    memory: FloatArray,
    target: tuple[float, float, float],
    slips: bool,
) -> tuple[float, float]:
    """
    Go straight to an indentation and a shift in the plane.

    Parameters
    ----------
    labels : ndarray, shape (n + 1,)
        Indentations in m at which the springs touch, rising; the first is that of the middle and carries nothing.
    scales : ndarray, shape (2,)
        Factors from normalised forces and shifts to SI units.
    vectors : ndarray, shape (2, 2, n + 1)
        Vectors of the springs, now and before the last step.
    memory : ndarray, shape (2, 6)
        What the contact remembers besides them.
    target : tuple of float
        Indentation and shift along x and y in m.

    Returns
    -------
    tuple of float
        Forces along x and y in N.
    """
    for i in range(memory.shape[1]):
        memory[BEFORE, i] = memory[NOW, i]
    depth, x, y = target
    before, after = memory[NOW, DEPTH], depth
    move = move_of(
        (x - memory[NOW, AT_X]) / scales[PER_SHIFT],
        (y - memory[NOW, AT_Y]) / scales[PER_SHIFT],
        before,
        after,
    )
    deepest = max(before, after)
    f_x = f_y = work = 0.0
    for i in range(labels.size):
        vectors[BEFORE, 0, i], vectors[BEFORE, 1, i] = vectors[NOW, 0, i], vectors[NOW, 1, i]
        if labels[i] < deepest:
            spring = advanced(vectors[NOW, 0, i], vectors[NOW, 1, i], labels[i], move, slips)
            vectors[NOW, 0, i], vectors[NOW, 1, i] = spring.x, spring.y
            if i > 0:
                f_x += spring.x
                f_y += spring.y
                work += spring.work
    memory[NOW, DEPTH], memory[NOW, AT_X], memory[NOW, AT_Y] = depth, x, y
    memory[NOW, FORCE_X], memory[NOW, FORCE_Y] = scales[PER_FORCE] * f_x, scales[PER_FORCE] * f_y
    memory[NOW, WORK] += scales[PER_FORCE] * scales[PER_SHIFT] * work
    return float(memory[NOW, FORCE_X]), float(memory[NOW, FORCE_Y])


@_fused.compiled
def step_all(
    labels: FloatArray,
    scales: FloatArray,
    vectors: FloatArray,
    memory: FloatArray,
    targets: FloatArray,
    slips: bool,
    forces: FloatArray,
    some: tuple[int, int],
) -> None:
    """Steps of the contacts from one up to another, as :func:`step`; targets and forces have the shapes (3, m) and (2, m)."""
    for i in range(some[0], some[1]):
        target = targets[0, i], targets[1, i], targets[2, i]
        forces[0, i], forces[1, i] = step(labels, scales, vectors[i], memory[i], target, slips)


@_fused.compiled
def stick_borders(
    labels: FloatArray, places: FloatArray, vectors: FloatArray, memory: FloatArray, radius: FloatArray
) -> None:
    """Replace contact radii in m by those of the springs that stick."""
    for i in range(radius.size):
        depth = memory[i, NOW, DEPTH]
        radius[i] = stick_border(labels, places, vectors[i, NOW], depth, radius[i]) if depth > 0.0 else 0.0
