"""Steps of contacts as C headers: those that are small state machines without a law of the depth alone."""

from __future__ import annotations

import math
from functools import singledispatch

import numpy as np

from pymdr.errors import ProblemError
from pymdr.line.following import Branches, RestingBranches
from pymdr.line.following import layout as at
from pymdr.line.moved import Moved
from pymdr.line.plastic import YieldingContacts
from pymdr.numerics.panels import nodes, to_coefficients
from pymdr.numerics.table import FIRST_TERM, KEY, START, WIDTH
from pymdr.presentation.steps_header import BranchesInC, StepInC, YieldingInC


@singledispatch
def step_in_c(contacts: Moved) -> StepInC:
    """The step of contacts for a header."""
    raise ProblemError(
        "no header has this step. Zones with memory, and bodies that yield with adhesion or apparent_radius, solve equations in "
        "every step: call Stepper.advance. For elastic bodies with friction or two works of adhesion, and for bodies with memory, use export_law(...)"
    )


@step_in_c.register
def _(contacts: RestingBranches) -> StepInC:
    return step_in_c.dispatch(Moved)(contacts)


@step_in_c.register
def _(contacts: Branches) -> StepInC:
    rows = contacts.rows
    count, first, cells, terms = (int(number) for number in rows[0, : at.TERMS + 1])
    table = np.roll(rows[1 : count + 1, : at.LAST + 1], 1, axis=0)
    # a free body is the first one, so that a state of zeros is free
    table[:, [at.DOWN_TO, at.UP_TO]] += 1.0
    # the last branch ends at the largest indentation, which no step passes
    for row in table:
        if row[at.UP_TO] < 0.0:
            row[at.HIGH], row[at.UP_TO], row[at.UP_LOSS] = math.inf, 0.0, 0.0
    columns = (at.LOW, at.HIGH, at.DOWN_TO, at.DOWN_LOSS, at.DOWN_JUMPS, at.UP_TO, at.UP_LOSS, at.UP_JUMPS)
    packed = rows[first : first + cells]
    series = packed[:, FIRST_TERM : FIRST_TERM + 2 * terms].reshape(cells, 2, terms)
    parameters = np.polynomial.chebyshev.chebval(2.0 * nodes(terms) - 1.0, series[:, at.PARAMETER].T)
    radii = contacts.radii(np.asarray(parameters, dtype=float).ravel()).reshape(parameters.shape)
    return BranchesInC(
        table[:, [*columns, at.FIRST, at.LAST]],
        rows[1 + count : first, : at.SEGMENT_HIGH + 1],
        np.column_stack(
            [packed[:, [KEY, START, WIDTH]], series[:, at.FORCE], radii @ to_coefficients(terms).T]
        ),
    )


@step_in_c.register
def _(contacts: YieldingContacts) -> StepInC:
    if contacts.adhesive:
        return step_in_c.dispatch(Moved)(contacts)
    radius, modulus, shear, poisson, strength, yield_depth, walled = contacts.body.tolist()
    return YieldingInC(radius, modulus, shear, poisson, strength, yield_depth, walled > 0.0)
