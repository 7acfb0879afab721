"""The errors of pymdr: one family, each with a builtin parent, each surviving pickling.

Every message names the value, the limit and the remedy.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager


class PymdrError(Exception):
    """Base of every error that pymdr raises on purpose.

    Examples
    --------
    >>> import pymdr as mdr
    >>> try:
    ...     mdr.Sphere("-1 mm")
    ... except mdr.PymdrError as error:
    ...     print(error)
    radius = '-1 mm': it must be above 0 m
    """


class UnitError(PymdrError, ValueError):
    """A text or quantity that is not a number with a compatible unit.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.Sphere("1 N")
    Traceback (most recent call last):
    pymdr.errors.UnitError: radius: 'N' does not fit: ...
    """


class ProblemError(PymdrError, ValueError):
    """A problem value (profile, material, law, contact) outside its limits.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.Elastic("1 GPa", 0.6)
    Traceback (most recent call last):
    pymdr.errors.ProblemError: poisson = 0.6: it must be above -1 and at most 0.5
    """


class RefusedError(ProblemError):
    """A valid contact to which the method does not apply, such as one that is not a disk.

    Examples
    --------
    >>> import pymdr as mdr
    >>> issubclass(mdr.RefusedError, mdr.ProblemError)
    True
    """


class PathError(PymdrError, ValueError):
    """A loading path that cannot be followed.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.solve(mdr.Contact(mdr.Sphere("1 mm"), mdr.Elastic("1 GPa", 0.3)), mdr.load("1 GN"))
    Traceback (most recent call last):
    pymdr.errors.PathError: normal_force = 1 GN: ...
    """


class CaseError(PymdrError, ValueError):
    """A case file that does not describe a problem.

    Examples
    --------
    >>> import pymdr as mdr
    >>> issubclass(mdr.CaseError, ValueError)
    True
    """


class FileError(PymdrError, OSError):
    """A file that cannot be read or written, or has another format.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.open_result("missing.nc")
    Traceback (most recent call last):
    pymdr.errors.FileError: cannot read 'missing.nc': no such file
    """


class QuantityError(PymdrError, KeyError):
    """A quantity that the result does not have.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.solve(mdr.Contact(mdr.Sphere("1 mm"), mdr.Elastic("1 GPa", 0.3)), mdr.load("1 N"))["radius"]
    Traceback (most recent call last):
    pymdr.errors.QuantityError: no quantity 'radius'; ...
    """

    def __str__(self) -> str:
        return str(self.args[0]) if self.args else ""


class NotValidError(PymdrError, RuntimeError):
    """A quantity that the theory does not give for this contact was read.

    Examples
    --------
    >>> import pymdr as mdr
    >>> ellipse = mdr.Contact(mdr.EllipticParaboloid("1 mm", "2 mm"), mdr.Elastic("1 GPa", 0.3))
    >>> mdr.solve(ellipse, mdr.load("1 N"))["contact_radius"]
    Traceback (most recent call last):
    pymdr.errors.NotValidError: contact_radius is not valid here: the contact is an ellipse ...
    """


class ConvergenceError(PymdrError, ArithmeticError):
    """A numerical failure; the message contains the last iterate.

    Examples
    --------
    >>> import pymdr as mdr
    >>> issubclass(mdr.ConvergenceError, ArithmeticError)
    True
    """


class MissingExtraError(PymdrError, ImportError):
    """An optional package is not installed; the message names the extra."""


@contextmanager
def errors_of_case(place: str) -> Iterator[None]:
    """
    Errors of pymdr become errors of a case that begin with their place.

    Examples
    --------
    >>> with errors_of_case("[profile]"):
    ...     raise ProblemError("radius = -1: it must be above 0 m")
    Traceback (most recent call last):
    pymdr.errors.CaseError: [profile] radius = -1: it must be above 0 m
    """
    try:
        yield
    except PymdrError as error:
        raise CaseError(f"{place} {error}") from error
