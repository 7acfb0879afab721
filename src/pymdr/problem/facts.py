"""Immutable metadata of a measurement."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

Fact = str | float


class Facts(Mapping[str, Fact]):
    """
    An immutable mapping of texts and numbers, hashed by its content.

    Parameters
    ----------
    facts : mapping of str to str or float
        Numbers in SI units.

    Examples
    --------
    >>> Facts({"setpoint": 2e-9})["setpoint"]
    2e-09
    """

    def __init__(self, facts: Mapping[str, Fact] | None = None) -> None:
        self._facts = dict(facts or {})

    def __getitem__(self, name: str) -> Fact:
        return self._facts[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._facts)

    def __len__(self) -> int:
        return len(self._facts)

    def __hash__(self) -> int:
        return hash(frozenset(self._facts.items()))

    def __repr__(self) -> str:
        return f"Facts({self._facts!r})"
