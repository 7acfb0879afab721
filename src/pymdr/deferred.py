"""Modules that annotations name, imported when a hint is evaluated: ``typing.get_type_hints`` works, and importing pymdr stays fast."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

__all__ = ["interpolate", "mpl", "pd", "xr"]


class _Deferred:
    """A module by its name; its first attribute imports it."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        module = import_module(self._name)
        return getattr(module, name, None) or import_module(f"{self._name}.{name}")


if TYPE_CHECKING:
    import matplotlib as mpl
    import pandas as pd
    import xarray as xr
    from scipy import interpolate
else:
    interpolate, mpl, pd, xr = map(_Deferred, ("scipy.interpolate", "matplotlib", "pandas", "xarray"))
