"""Suggestions for unknown names."""

from __future__ import annotations

import difflib
from collections.abc import Sequence

_SYMBOLS = {
    "E": "young",
    "G": "shear",
    "nu": "poisson",
    "ν": "poisson",
    "R": "radius",
    "mu": "coefficient",
    "μ": "coefficient",
    "gamma": "work",
    "γ": "work",
    "w": "work",
    "k": "machine_stiffness",
}
"""Names of quantities by the symbols of textbooks."""


def nearest(word: str, known: Sequence[str]) -> list[str]:
    """
    The known name closest to another: by its symbol, by capitals, else by spelling; empty if none is close.

    Examples
    --------
    >>> nearest("nu", ["young", "poisson"]), nearest("Radius", ["radius"]), nearest("yuong", ["young"]), nearest("x", ["y"])
    (['poisson'], ['radius'], ['young'], [])
    >>> nearest("radius", ["name", "r"])
    ['r']
    """
    symbol = _SYMBOLS.get(word, word)
    if symbol in known:
        return [symbol]
    plain = word.lower()
    same = [name for name in known if plain in (name.lower(), _SYMBOLS.get(name.upper()))]
    return same or difflib.get_close_matches(plain[:80], known, n=1, cutoff=0.5)
