"""The same functions compiled, for maps. Loads numba."""

from __future__ import annotations

from types import FunctionType

from numba.extending import register_jitable

from pymdr import compiling
from pymdr.solving.fits import touching
from pymdr.solving.fits.kernels import curves, descent, model, starts

_FUSED = {"fastmath": {"contract"}, "error_model": "numpy"}
"""Products and sums may be fused, nothing else."""


def _called_by_kernels() -> None:
    """Let numba compile what the outermost function calls."""
    for module in (touching, model, descent, starts, curves):
        for function in vars(module).values():
            if isinstance(function, FunctionType) and function.__module__ == module.__name__:
                register_jitable(**_FUSED)(function)


_called_by_kernels()
fit_curves = compiling.compiled(
    curves.fit_curves, compiling.stamp_of(__file__, touching.__file__), fastmath={"contract"}
)
