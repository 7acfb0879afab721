"""The verb `solve`: check, map, solve, interpret."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import ArrayLike

from pymdr.errors import PathError, ProblemError
from pymdr.independent.rings import Rings
from pymdr.machine import memory_of_machine
from pymdr.problem.contact import Contact, require_contact
from pymdr.problem.paths import LoadingPath, named_channels
from pymdr.problem.schedule import Progress, check_times, known_legs, planned, total_rows
from pymdr.problem.values import read_stiffness
from pymdr.result import Result
from pymdr.solving.bands import scatter_of, with_bands
from pymdr.solving.laws import law_of
from pymdr.solving.walk import Task
from pymdr.units import QuantityLike, shown


def solve(
    contact: Contact,
    path: LoadingPath,
    *,
    machine_stiffness: QuantityLike | None = None,
    keep: int | ArrayLike | None = None,
    solver: Rings | None = None,
    tolerance: float | None = None,
    progress: Progress | None = None,
) -> Result:
    """
    Solve a contact along a loading path.

    Parameters
    ----------
    contact : Contact
        Profile, materials and laws.
    path : LoadingPath
        For example ``load("50 N", steps=50)``.
    machine_stiffness : quantity, optional
        Stiffness in N/m of the cantilever or load frame, above 0; needed for paths that prescribe ``travel``.
    keep : int or array_like of int, optional
        For elastic contacts with friction: keep every k-th row, or the given rows; all rows by default.
    solver : Rings, optional
        ``Rings(n=400)`` solves by boundary elements on rings instead of the MDR, including annular contacts
        and bodies with memory.
    tolerance : float, optional
        For `MaugisDugdale` and `Capillary` on bodies with memory: the error of the normal force over its largest value, or of the
        indentation where the force is prescribed, that the claims are to show except beside jumps; from 1e-6 to 1e-2. By default
        it is below about 1e-4.
    progress : callable, optional
        Called as ``progress(done, total)`` between legs, and within long legs with friction.

    Returns
    -------
    Result
        Labelled arrays over the rows of the path, with claims.

    Raises
    ------
    ProblemError, PathError
        If the problem cannot be posed, for example an indentation of a sphere by its radius.
    ConvergenceError
        If a quadrature or a root does not converge.

    Examples
    --------
    >>> import pymdr as mdr
    >>> ball = mdr.Contact(mdr.Paraboloid("10 mm"), mdr.Elastic("0.75 MPa", 0.0))
    >>> round(float(mdr.solve(ball, mdr.indent("0.1 mm"))["normal_force"][-1]), 12)
    0.1
    """
    stiffness, kept = check_request(contact, path, machine_stiffness, keep)
    check_tolerance(contact, tolerance, solver=solver)
    solutions = 3 if solver is None and scatter_of(contact.profile) else 1
    parts = itertools.count()

    def solve_once(contact: Contact) -> Result:
        law = law_of(contact, solver, path)
        part_progress = _part_of(progress, next(parts), solutions)
        task = Task(contact, path, law.reading, stiffness, kept, part_progress, solver, tolerance)
        return law.history(task)

    result = solve_once(contact)
    return with_bands(result, solve_once) if solutions > 1 else result


def _part_of(progress: Progress | None, part: int, parts: int) -> Progress | None:
    """The progress of one of several solutions, as a part of the total."""
    if progress is None or parts == 1:
        return progress
    return lambda done, total: progress(part * total + done, parts * total)


def refuse_beyond_memory(path: LoadingPath, keep: int = 1) -> None:
    """Refuse a path whose rows exceed the memory of this machine."""
    rows = total_rows(path)
    needed = bytes_of(rows, keep)
    if needed > memory_of_machine():
        raise PathError(
            f"the path has {rows:.3g} rows, which need about {needed / 1e9:.3g} GB (limit {memory_of_machine() / 1e9:.3g} GB, the memory of "
            "this machine); use fewer steps, or with friction keep every k-th row (keep=k)"
        )


def bytes_of(rows: int, keep: int = 1) -> int:
    """Bytes that the arrays of a path and its result need while it is solved."""
    return 2 * 8 * rows + 2 * 13 * 8 * (rows // keep)


def check_request(
    contact: Contact,
    path: LoadingPath,
    machine_stiffness: QuantityLike | None,
    keep: int | ArrayLike | None,
) -> tuple[float | None, np.ndarray | None]:
    """The stiffness in N/m and the kept rows; raise if the problem cannot be posed."""
    check_problem(contact, path)
    stiffness = None if machine_stiffness is None else read_stiffness(machine_stiffness)
    if stiffness == 0.0:
        raise ProblemError("machine_stiffness = 0 is a dead load: prescribe it with load(...) instead")
    if stiffness is None:
        for leg in planned(path):
            if "travel" in named_channels(leg.leg):
                raise PathError(
                    f"leg {leg.number} prescribes travel, the channel of a machine: give machine_stiffness, for example '0.1 N/m' (in a "
                    "case file under [solve]), or prescribe the indentation"
                )
    if keep is not None and contact.friction is None:
        raise ProblemError("keep= is for contacts with friction; other contacts keep every row")
    if keep is not None and contact.is_viscoelastic:
        raise ProblemError("keep= is for elastic bodies; fields of bodies with memory need every row")
    if keep is None or isinstance(keep, int):
        refuse_beyond_memory(path, 1 if keep is None else max(keep, 1))
    return stiffness, kept_rows(keep, path)


def check_tolerance(contact: Contact, tolerance: float | None, solver: Rings | None = None) -> None:
    """Refuse a tolerance outside its limits, and one of contacts whose claims need none."""
    check_limits_of_tolerance(tolerance)
    if tolerance is None:
        return
    if solver is not None or not (contact.is_viscoelastic and contact.is_cohesive):
        alone = "" if solver is None else ", without solver="
        raise ProblemError(
            f"tolerance = {shown(tolerance)}; it is for MaugisDugdale or Capillary on bodies with memory{alone}; leave it out, the claims state the errors"
        )


def check_limits_of_tolerance(tolerance: float | None) -> None:
    """Refuse what is no number from 1e-6 to 1e-2, nor None."""
    if tolerance is None:
        return
    if isinstance(tolerance, bool) or not isinstance(tolerance, int | float) or not 1e-6 <= tolerance <= 1e-2:
        raise ProblemError(f"tolerance = {shown(tolerance)}; it must be a number from 1e-6 to 1e-2")


def check_problem(contact: Contact, path: LoadingPath) -> None:
    """Refuse arguments of the wrong kind before any work."""
    require_contact(contact)
    if not isinstance(path, LoadingPath):
        several = isinstance(path, list | tuple) and all(isinstance(leg, LoadingPath) for leg in path)
        remedy = (
            "join legs with >>, as in indent('1 um') >> hold('1 s')"
            if several
            else "write for example load('50 N', steps=50)"
        )
        raise PathError(f"{shown(path)} is not a path; {remedy}")
    known_legs(path)
    check_times(path, needed=contact.is_viscoelastic)


def kept_rows(keep: int | ArrayLike | None, path: LoadingPath) -> np.ndarray | None:
    """Indices of the kept rows of a path, None for all."""
    if keep is None:
        return None
    rows = total_rows(path)
    whole = np.asarray(keep)
    if whole.dtype.kind not in "iu" or whole.ndim > 1 or whole.size == 0:
        raise ProblemError(f"keep = {keep!r}; a whole number k (every k-th row) or rows are needed")
    if whole.ndim == 0:
        if not 1 <= int(whole) <= rows:
            raise ProblemError(f"keep = {keep!r}; every k-th of {rows} rows needs 1 <= k <= {rows}")
        return np.arange(int(whole) - 1, rows, int(whole))
    if whole.min() < -rows or whole.max() >= rows:
        raise ProblemError(f"keep names rows {whole.min()} to {whole.max()}; there are {rows} rows")
    return np.unique(whole % rows)
