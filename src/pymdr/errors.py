"""The errors of pymdr: one family, each with a builtin parent, each surviving pickling.

Every message names the value, the limit and the remedy.
"""

from __future__ import annotations


class PymdrError(Exception):
    """Base of every error that pymdr raises on purpose."""


class UnitError(PymdrError, ValueError):
    """A text or quantity that is not a number with a compatible unit."""


class ProblemError(PymdrError, ValueError):
    """A problem value (profile, material, law, contact) outside its limits."""


class RefusedError(ProblemError):
    """A valid contact to which the method does not apply, such as one that is not a disk."""


class PathError(PymdrError, ValueError):
    """A loading path that cannot be followed."""


class CaseError(PymdrError, ValueError):
    """A case file that does not describe a problem."""


class FileError(PymdrError, OSError):
    """A file that cannot be read or written, or has another format."""


class QuantityError(PymdrError, KeyError):
    """A quantity that the result does not have."""

    def __str__(self) -> str:
        return str(self.args[0]) if self.args else ""


class NotValidError(PymdrError, RuntimeError):
    """A quantity that the theory does not give for this contact was read."""


class ConvergenceError(PymdrError, ArithmeticError):
    """A numerical failure; the message holds the last iterate."""


class MissingExtraError(PymdrError, ImportError):
    """An optional package is not installed; the message names the extra."""
