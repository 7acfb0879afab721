"""The errors of pymdr: one family, each with a builtin parent, each surviving pickling.

Every message names the value, the limit that it breaks and what to do instead.
"""

from __future__ import annotations


class PymdrError(Exception):
    """Base of every error that pymdr raises on purpose."""


class UnitError(PymdrError, ValueError):
    """A text or quantity that is not a number with a fitting unit."""


class ProblemError(PymdrError, ValueError):
    """A problem value (profile, material, law, contact) outside its limits."""


class RefusedError(ProblemError):
    """A contact for which the method gives nothing: it was asked well, and is no disk."""


class PathError(PymdrError, ValueError):
    """A loading path that cannot be followed."""


class CaseError(PymdrError, ValueError):
    """A case file that does not describe a problem."""


class FileError(PymdrError, OSError):
    """A file that cannot be read, is not ours, or cannot be written."""


class QuantityError(PymdrError, KeyError):
    """A quantity that the result does not have."""

    def __str__(self) -> str:
        return str(self.args[0]) if self.args else ""


class NotValidError(PymdrError, RuntimeError):
    """A quantity was read that the theory does not give for this contact."""


class ConvergenceError(PymdrError, ArithmeticError):
    """A numerical failure: the message holds the last iterate. Never to be read as physics."""


class MissingExtraError(PymdrError, ImportError):
    """An optional package is not installed; the message says which extra brings it."""
