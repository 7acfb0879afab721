"""Compiled steps of a motion by the discrete gradient. Loads numba."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from pymdr import compiling
from pymdr.line.friction import kernels as stack_kernels
from pymdr.line.friction import layout as stack
from pymdr.line.friction.kernels import Anchors, advance, vertex
from pymdr.line.friction.reading import curve
from pymdr.line.friction.runs import BEYOND
from pymdr.line.motion import layout
from pymdr.line.moved import BEFORE, NOW
from pymdr.numerics.graded.layout import MAX
from pymdr.units import FloatArray

fused = compiling.Fused(__file__, stack_kernels.__file__)

_ITERATIONS = 60
_SETTLED = 4e-16
"""Relative change of the velocities at which the iteration of a step has converged."""
_STAGNANT = 1e-6
"""Largest relative change at which an iteration that rounding stops has converged: it no longer falls."""
_ROUNDED = 1e-13
"""Relative change that rounding explains, where a fall by less than a half is enough."""
_SHORT = 1e-5
"""Work of a step over the stored energy, below which the trapezoidal rule is closer than a difference of energies."""


class Body(NamedTuple):
    """Coefficients of the equations of motion; free coordinates come before driven ones."""

    mass: FloatArray
    """(n,) in kg."""
    push: FloatArray
    """(n,) constant forces in N."""
    force_waves: FloatArray
    """(k, 4) coordinate, amplitude in N, angular frequency, phase."""
    course: FloatArray
    """(m, 2) position and speed of the driven coordinates at time 0."""
    drive_waves: FloatArray
    """(k, 4) driven coordinate, amplitude in m, angular frequency, phase."""
    springs: FloatArray
    """(s, 3 + n + m) stiffness, damping, elongation at the origin, coefficients of the elongation."""
    normal: FloatArray
    """(j, 1 + n + m) indentation at the origin, coefficients of the indentation."""
    tangential: FloatArray
    """(j, n + m) coefficients of the shift."""
    lines: FloatArray
    """Curves of all joints, one below the other."""
    ends: Any
    """(j, 2) first row and end of the curves of each joint in `lines`."""
    scales: FloatArray
    """(j, 3) factors of the stacks to SI units."""
    slips: Any
    """(j,) whether the joint has friction."""
    first: Any
    """(n,) the first coordinate that is linked to each, or to one between them."""


class State(NamedTuple):
    """What a motion remembers from step to step, and room for the next step."""

    position: FloatArray
    """(2, n + m) now and after the step."""
    velocity: FloatArray
    """(3, n) now, after the step, and its change in the step before."""
    joints: FloatArray
    """(j, 2, 6) now and after the step."""
    energies: FloatArray
    """(j, 2, 3) now and after the step."""
    vertices: Any
    """(j, 2, capacity) stacks of the trial and before the step."""
    memory: FloatArray
    """(j, 2, 6) of the stacks."""
    force: FloatArray
    """(4, n + m) mean force of the step, mean applied force, stiffness, and the sum of the sizes of all forces."""
    factor: FloatArray
    """(n, n) Cholesky factor of M + h C / 2 + h^2 K / 4 at the start of the step, below its diagonal from `first` on."""
    residual: FloatArray
    """(n,) momentum that the iteration of the step lacks."""
    sums: FloatArray
    """(2, 4) sums over the steps and their carries."""


@fused.inlined
def _dot(coefficients: FloatArray, row: int, first: int, position: FloatArray, when: int) -> float:
    """The product of a row of coefficients, from a column on, with the positions."""
    total = 0.0
    for i in range(position.shape[1]):
        total += coefficients[row, first + i] * position[when, i]
    return total


@fused.inlined
def _restore(state: State, j: int) -> None:
    """The stack of a joint as it was before the step."""
    vertices, memory = state.vertices[j], state.memory[j]
    for i in range(int(memory[BEFORE, stack.TOP]) + 1):
        vertices[NOW, i] = vertices[BEFORE, i]
    for i in range(memory.shape[1]):
        memory[NOW, i] = memory[BEFORE, i]


@fused.inlined
def _keep(state: State, j: int) -> None:
    """Accept the stack of a joint; its slip work begins anew."""
    vertices, memory = state.vertices[j], state.memory[j]
    memory[NOW, stack.SLIP_WORK] = 0.0
    memory[NOW, stack.CARRY] = 0.0
    for i in range(int(memory[NOW, stack.TOP]) + 1):
        vertices[BEFORE, i] = vertices[NOW, i]
    for i in range(memory.shape[1]):
        memory[BEFORE, i] = memory[NOW, i]


@fused.inner
def _respond(body: Body, state: State, j: int, depth: float, shift: float) -> None:
    """The state of a joint at an indentation and a shift, straight from the state before the step."""
    line = body.lines[body.ends[j, 0] : body.ends[j, 1]]
    joint, energy = state.joints[j, 1], state.energies[j, 1]
    joint[layout.DEPTH] = depth
    joint[layout.SHIFT] = shift
    if body.slips[j]:
        scale, energy_scale = body.scales[j, stack.FORCE_SCALE], body.scales[j, stack.ENERGY_SCALE]
        _restore(state, j)
        memory = state.memory[j, NOW]
        advance(
            Anchors(line, state.vertices[j, NOW], memory),
            depth,
            shift / body.scales[j, stack.SHIFT_SCALE],
        )
        energy[layout.SLIPPED] = energy_scale * memory[stack.SLIP_WORK]
        if depth > 0.0:
            index = int(memory[stack.TOP])
            top = vertex(state.vertices[j, NOW], index)
            joint[layout.FORCE] = top.force
            joint[layout.PULL] = scale * top.pull
            joint[layout.RADIUS] = top.radius
            joint[layout.STICK] = top.radius
            if index > 0 and abs(top.slope) == 1.0:
                joint[layout.STICK] = vertex(state.vertices[j, NOW], index - 1).radius
            energy[layout.WORK] = top.work
            energy[layout.STORED] = energy_scale * max(top.energy, 0.0)
            return
        joint[layout.FORCE] = joint[layout.PULL] = joint[layout.RADIUS] = joint[layout.STICK] = 0.0
        energy[layout.WORK] = energy[layout.STORED] = 0.0
        return
    joint[layout.RADIUS], joint[layout.FORCE], energy[layout.WORK] = curve(line, depth)


@fused.inlined
def _mean(work: float, change: float, before: float, after: float, stored: float) -> float:
    """The mean force of a step from its work, or by the trapezoidal rule if rounding takes the difference of the energies."""
    # a contact that is made or lost within the step has no force at one end or both
    if max(abs(work), abs(change) * max(abs(before), abs(after))) > _SHORT * stored:
        return work / change
    return 0.5 * (before + after)


@fused.merged
def _pull_back(body: Body, state: State, h: float) -> int:
    """Add the mean forces of springs and joints in the trial step to those applied."""
    position, force = state.position, state.force
    count = position.shape[1]
    for i in range(count):
        force[0, i] = force[1, i]
        force[3, i] = abs(force[1, i])
    for s in range(body.springs.shape[0]):
        start = body.springs[s, 2] + _dot(body.springs, s, 3, position, 0)
        end = body.springs[s, 2] + _dot(body.springs, s, 3, position, 1)
        mean = 0.5 * body.springs[s, 0] * (start + end) + body.springs[s, 1] * (end - start) / h
        for i in range(count):
            force[0, i] -= body.springs[s, 3 + i] * mean
            force[3, i] += abs(body.springs[s, 3 + i] * mean)
    for j in range(body.normal.shape[0]):
        depth = body.normal[j, 0] + _dot(body.normal, j, 1, position, 1)
        shift = _dot(body.tangential, j, 0, position, 1)
        if not depth <= body.lines[body.ends[j, 0], MAX] * BEYOND:
            return layout.TOO_DEEP
        _respond(body, state, j, depth, shift)
        old, new = state.joints[j, 0], state.joints[j, 1]
        kept, now = state.energies[j, 0], state.energies[j, 1]
        normal = _mean(
            now[layout.WORK] - kept[layout.WORK],
            new[layout.DEPTH] - old[layout.DEPTH],
            old[layout.FORCE],
            new[layout.FORCE],
            max(kept[layout.WORK], now[layout.WORK]),
        )
        pull = 0.0
        if body.slips[j]:
            pull = _mean(
                now[layout.STORED] - kept[layout.STORED] + now[layout.SLIPPED],
                new[layout.SHIFT] - old[layout.SHIFT],
                old[layout.PULL],
                new[layout.PULL],
                max(kept[layout.STORED], now[layout.STORED]),
            )
        for i in range(count):
            force[0, i] -= body.normal[j, 1 + i] * normal + body.tangential[j, i] * pull
            force[3, i] += abs(body.normal[j, 1 + i] * normal) + abs(body.tangential[j, i] * pull)
    return layout.COMPLETE


@fused.merged
def _apply(body: Body, state: State, t: float, h: float) -> None:
    """The mean of the applied forces, and the driven positions at the end."""
    n = body.mass.size
    position, force = state.position, state.force
    for i in range(position.shape[1]):
        force[1, i] = body.push[i] if i < n else 0.0
    middle, end = t + 0.5 * h, t + h
    for k in range(body.force_waves.shape[0]):
        i = int(body.force_waves[k, 0])
        force[1, i] += body.force_waves[k, 1] * math.sin(
            body.force_waves[k, 2] * middle + body.force_waves[k, 3]
        )
    for i in range(body.course.shape[0]):
        position[1, n + i] = body.course[i, 0] + body.course[i, 1] * end
    for k in range(body.drive_waves.shape[0]):
        i = int(body.drive_waves[k, 0])
        position[1, n + i] += body.drive_waves[k, 1] * math.sin(
            body.drive_waves[k, 2] * end + body.drive_waves[k, 3]
        )


@fused.inlined
def _stiffen(body: Body, state: State, arms: FloatArray, row: int, first: int, stiffness: float) -> None:
    """Add h^2 / 4 of a stiffness along a row of coefficients, from a column on, to the matrix of the step."""
    for i in range(body.mass.size):
        arm = arms[row, first + i]
        if arm != 0.0:
            state.force[2, i] += stiffness * arm * arm
            for k in range(body.first[i], i + 1):
                state.factor[i, k] += stiffness * arm * arms[row, first + k]


@fused.merged
def _factorize(body: Body, state: State, h: float) -> None:
    """Cholesky's factor of the matrix of the step, M + h C / 2 + h^2 K / 4."""
    n, factor = body.mass.size, state.factor
    for i in range(n):
        state.force[2, i] = 0.0
        for k in range(body.first[i], i):
            factor[i, k] = 0.0
        factor[i, i] = body.mass[i]
    for s in range(body.springs.shape[0]):
        stiffness = 0.25 * h * h * body.springs[s, 0] + 0.5 * h * body.springs[s, 1]
        _stiffen(body, state, body.springs, s, 3, stiffness)
    for j in range(body.normal.shape[0]):
        stiffness = (
            0.5 * h * h * body.lines[body.ends[j, 0], stack.MODULUS] * state.joints[j, 0, layout.RADIUS]
        )
        if stiffness > 0.0:
            _stiffen(body, state, body.normal, j, 1, stiffness)
            if body.slips[j]:
                ratio = body.scales[j, stack.FORCE_SCALE] / body.scales[j, stack.SHIFT_SCALE]
                _stiffen(body, state, body.tangential, j, 0, stiffness * ratio)
    for i in range(n):
        for k in range(body.first[i], i + 1):
            rest = factor[i, k]
            for p in range(max(body.first[i], body.first[k]), k):
                rest -= factor[i, p] * factor[k, p]
            factor[i, k] = rest / factor[k, k] if k < i else math.sqrt(rest)


@fused.inlined
def _correct(body: Body, state: State) -> None:
    """Change the velocities at the end by the inverse of the matrix of the step times the residual."""
    n, factor, rest = body.mass.size, state.factor, state.residual
    for i in range(n):
        for k in range(body.first[i], i):
            rest[i] -= factor[i, k] * rest[k]
        rest[i] /= factor[i, i]
    for i in range(n - 1, -1, -1):
        rest[i] /= factor[i, i]
        for k in range(body.first[i], i):
            rest[k] -= factor[i, k] * rest[i]
        state.velocity[1, i] += rest[i]


@fused.inlined
def _add(sums: FloatArray, k: int, term: float) -> None:
    """Kahan's summation."""
    term -= sums[1, k]
    total = sums[0, k] + term
    sums[1, k] = (total - sums[0, k]) - term
    sums[0, k] = total


@fused.merged
def _accept(body: Body, state: State, h: float) -> None:
    """Count the work of the step and keep its end."""
    n = body.mass.size
    position, force = state.position, state.force
    for s in range(body.springs.shape[0]):
        if body.springs[s, 1] > 0.0:
            change = _dot(body.springs, s, 3, position, 1) - _dot(body.springs, s, 3, position, 0)
            _add(state.sums, layout.DAMPING, body.springs[s, 1] * change * change / h)
    for i in range(position.shape[1]):
        change = position[1, i] - position[0, i]
        if i < n:
            _add(state.sums, layout.FORCES, force[1, i] * change)
            state.velocity[2, i] = state.velocity[1, i] - state.velocity[0, i]
            state.velocity[0, i] = state.velocity[1, i]
        else:
            _add(state.sums, layout.DRIVES, -force[0, i] * change)
        position[0, i] = position[1, i]
    for j in range(body.normal.shape[0]):
        _add(state.sums, layout.SLIP, state.energies[j, 1, layout.SLIPPED])
        state.energies[j, 1, layout.SLIPPED] = 0.0
        for i in range(6):
            state.joints[j, 0, i] = state.joints[j, 1, i]
        for i in range(3):
            state.energies[j, 0, i] = state.energies[j, 1, i]
        if body.slips[j]:
            _keep(state, j)


@fused.inner
def step(body: Body, state: State, t: float, h: float) -> int:
    """One step by M (v1 - v0) = h F, x1 - x0 = h (v0 + v1) / 2 with the mean force F of the straight step, by iteration."""
    n = body.mass.size
    for j in range(body.normal.shape[0]):
        if state.memory[j, BEFORE, stack.TOP] > state.vertices.shape[2] - 4:
            return layout.STACK_FULL
    _apply(body, state, t, h)
    _factorize(body, state, h)
    position, velocity, force = state.position, state.velocity, state.force
    for i in range(n):
        velocity[1, i] = velocity[0, i] + velocity[2, i]
    last = math.inf
    for _ in range(_ITERATIONS):
        for i in range(n):
            position[1, i] = position[0, i] + 0.5 * h * (velocity[0, i] + velocity[1, i])
        code = _pull_back(body, state, h)
        if code != layout.COMPLETE:
            return code
        for i in range(n):
            state.residual[i] = body.mass[i] * (velocity[0, i] - velocity[1, i]) + h * force[0, i]
        _correct(body, state)
        change = 0.0
        for i in range(n):
            correction = abs(state.residual[i])
            # h k = 4 (h^2 k / 4) / h
            rounded = h * force[3, i] + 4.0 / h * force[2, i] * abs(position[0, i])
            size = abs(velocity[0, i]) + rounded / body.mass[i]
            if correction > change * size:
                change = correction / size if size > 0.0 else math.inf
        if change <= _SETTLED or (
            change <= _STAGNANT and change >= (0.5 if change <= _ROUNDED else 1.0) * last
        ):
            _accept(body, state, h)
            return layout.COMPLETE
        last = change
    return layout.NOT_CONVERGED


@fused.merged
def write_row(body: Body, state: State, row: FloatArray) -> None:
    """Positions, velocities, joints, energies and sums of the present state."""
    n, count, joints = body.mass.size, state.position.shape[1], body.normal.shape[0]
    kinetic = springs = normal = tangential = 0.0
    for i in range(count):
        row[i] = state.position[0, i]
    for i in range(n):
        row[count + i] = state.velocity[0, i]
        kinetic += 0.5 * body.mass[i] * state.velocity[0, i] * state.velocity[0, i]
    at = count + n
    for j in range(joints):
        for i in range(6):
            row[at + i] = state.joints[j, 0, i]
        normal += state.energies[j, 0, layout.WORK]
        tangential += state.energies[j, 0, layout.STORED]
        at += 6
    for s in range(body.springs.shape[0]):
        elongation = body.springs[s, 2] + _dot(body.springs, s, 3, state.position, 0)
        springs += 0.5 * body.springs[s, 0] * elongation * elongation
    row[at] = kinetic
    row[at + layout.SPRINGS] = springs
    row[at + layout.NORMAL] = normal
    row[at + layout.TANGENTIAL] = tangential
    for k in range(4):
        row[at + 4 + k] = state.sums[0, k]


@fused.merged
def _begin(body: Body, state: State) -> int:
    """The joints where a motion begins, straight from a touch."""
    for j in range(body.normal.shape[0]):
        depth = body.normal[j, 0] + _dot(body.normal, j, 1, state.position, 0)
        shift = _dot(body.tangential, j, 0, state.position, 0)
        if not depth <= body.lines[body.ends[j, 0], MAX] * BEYOND:
            return layout.TOO_DEEP
        for target in (0.0, depth):
            _respond(body, state, j, target, shift)
            if body.slips[j]:
                _keep(state, j)
        for i in range(6):
            state.joints[j, 0, i] = state.joints[j, 1, i]
        for i in range(3):
            state.energies[j, 0, i] = state.energies[j, 1, i]
        state.energies[j, :, layout.SLIPPED] = 0.0
    return layout.COMPLETE


@fused.compiled
def run(body: Body, state: State, out: FloatArray, h: float, parts: int, done: int) -> tuple[int, int]:
    """
    Rows of a motion, the first where it begins, then one after every `parts` steps of h; `done` steps are already taken.

    Returns
    -------
    tuple
        The ending, and the number of steps taken.
    """
    if done == 0:
        code = _begin(body, state)
        if code != layout.COMPLETE:
            return code, 0
        write_row(body, state, out[0])
    steps = parts * (out.shape[0] - 1)
    for taken in range(done, steps):
        code = step(body, state, taken * h, h)
        if code != layout.COMPLETE:
            return code, taken
        if (taken + 1) % parts == 0:
            write_row(body, state, out[taken // parts + 1])
    return layout.COMPLETE, steps
