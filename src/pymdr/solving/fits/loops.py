"""Records of tangential force against shift, and the force of a contact with friction along them."""

from __future__ import annotations

import math
from collections.abc import Hashable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pymdr.deferred import xr
from pymdr.errors import ProblemError, UnitError
from pymdr.problem.contact import Contact
from pymdr.problem.laws import Coulomb
from pymdr.problem.paths import LoadingPath, Path, indent, load
from pymdr.result import Result
from pymdr.solving.verb import solve
from pymdr.units import FloatArray, shown, to_si

_LEAST = 8
NORMAL = ("normal_force", "indentation")
"""Normal channels of a record; the first that it has is prescribed."""
_UNITS = {"shift": "m", "tangential_force": "N", "normal_force": "N", "indentation": "m", "time": "s"}
BoolArray = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class ShearRecord:
    """Tangential force against shift of bodies that are pressed together."""

    shift: FloatArray
    """In m, from any origin."""
    force: FloatArray
    """Tangential force in N, with or without an offset."""
    channel: str
    """The normal channel, one of :data:`NORMAL`."""
    normal: FloatArray
    """Normal force in N or indentation in m."""
    time: FloatArray | None
    """In s."""
    used: BoolArray
    """Samples that are compared with the model; all of them are solved."""

    @property
    def depth(self) -> FloatArray:
        """The shift in m."""
        return self.shift

    @property
    def position(self) -> FloatArray:
        """The measured shift in m."""
        return self.shift

    def path(self, contact: Contact, origin: float) -> LoadingPath:
        """The path: pressed at the origin of the shift in m, then moved as recorded."""
        shift = self.shift - origin
        pressed: dict[str, Any] = {self.channel: self.normal}
        if contact.is_viscoelastic:
            if self.time is None:
                raise ProblemError(
                    "a body with memory needs the times of the samples; the record has no time"
                )
            return Path(time=self.time - self.time[0], shift=shift, **pressed)
        moved = Path(shift=shift, **pressed)
        first = float(self.normal[0])
        if first <= 0.0:
            return moved
        return (load(first) if self.channel == "normal_force" else indent(first)) >> moved

    def solved(self, contact: Contact, origin: float) -> Result:
        """The contact solved along the record."""
        return solve(contact, self.path(contact, origin))

    def stuck(self, contact: Contact) -> tuple[float, float]:
        """Tangential stiffness in N/m at full stick over the shift of the record, and the largest load in N."""
        result = self.solved(replace(contact, friction=Coulomb(math.inf)), float(self.shift[0]))
        force = result["tangential_force"].values
        return float(np.ptp(force) / np.ptp(self.shift)), float(result["normal_force"].max())

    def forces(self, contact: Contact, origin: float) -> FloatArray:
        """Tangential force of a contact at every sample, in N."""
        force = self.solved(contact, origin)["tangential_force"].values
        return np.asarray(force[force.size - self.shift.size :])


def shear_record(data: xr.Dataset) -> ShearRecord:
    """
    A record as :func:`pymdr.read_record` reads it.

    Parameters
    ----------
    data : xarray.Dataset
        With ``shift``, ``tangential_force`` and ``normal_force`` or ``indentation`` over one dimension, in the units of their
        attributes, or in SI units; ``used`` is false at samples that are not compared.
    """
    channel = next((name for name in NORMAL if name in data), None)
    missing = [name for name in ("shift", "tangential_force") if name not in data]
    if channel is None:
        missing.append(" or ".join(NORMAL))
    if missing or channel is None:
        raise ProblemError(
            f"the contact has friction, but the record has no {' and no '.join(missing)}; its columns are "
            f"{', '.join(map(str, data.variables)) or 'none'}"
        )
    columns = {name: _column(data, name) for name in ("shift", "tangential_force", channel)}
    n = columns["shift"].size
    if n < _LEAST:
        raise ProblemError(f"the record has {n} sample{'s' * (n != 1)}; at least {_LEAST} are needed")
    if float(np.ptp(columns["shift"])) == 0.0:
        raise ProblemError("the shift of the record does not change; give a record of a contact that moves")
    if not float(np.max(columns[channel])) > 0.0:
        raise ProblemError(
            f"{channel} of the record is never above 0 {_UNITS[channel]}; press the bodies together"
        )
    used = np.asarray(data["used"].values, dtype=bool) if "used" in data else np.ones(n, dtype=bool)
    if used.shape != (n,) or not used.any():
        raise ProblemError(
            "'used' of the record must be true or false at each sample, and true at one or more"
        )
    return ShearRecord(
        columns["shift"],
        columns["tangential_force"],
        channel,
        columns[channel],
        _column(data, "time") if "time" in data else None,
        used,
    )


def _column(data: xr.Dataset, name: Hashable) -> FloatArray:
    array, unit = data[name], _UNITS[str(name)]
    if array.ndim != 1 or array.dims != data["shift"].dims:
        raise ProblemError(
            f"{name} of the record has the dimensions {', '.join(map(str, array.dims)) or 'none'}, and shift "
            f"{', '.join(map(str, data['shift'].dims)) or 'none'}; give both over the same dimension, such as step"
        )
    own = array.attrs.get("units", unit)
    try:
        values = np.asarray(array.values, dtype=float) * to_si(f"1 {own}", unit, name=str(name))
    except (UnitError, TypeError, ValueError) as error:
        raise ProblemError(
            f"{name} of the record has the units {shown(own)}; units compatible with {unit} are needed"
        ) from error
    if not np.isfinite(values).all():
        row = int(np.argmin(np.isfinite(values))) + 1
        raise ProblemError(f"{name} of the record is missing in row {row}; leave such rows out")
    return values
