"""Running conditions of fretting: where partial slip ends, over load and amplitude."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from pymdr.deferred import xr
from pymdr.errors import ProblemError
from pymdr.interpretation.validity import Claim, Level
from pymdr.problem.contact import Contact, require_contact
from pymdr.solving.arguments import positive_row
from pymdr.solving.frictional import pressed_joint
from pymdr.solving.loops import friction_loop
from pymdr.solving.study import Answer, Column, Study, dataset
from pymdr.units import ArrayQuantityLike, FloatArray


@dataclass(frozen=True, kw_only=True)
class RunningConditions(Study):
    """The map of load and amplitude, by :func:`running_conditions`."""

    data: xr.Dataset
    """Over ``normal_force`` (N): sliding_shift (m), the amplitude from which the whole contact slips, and indentation (m)."""
    record: tuple[FloatArray, FloatArray] | None = None
    """Amplitude in m and load in N of the cycles of a record."""

    subject: ClassVar = "a map of running conditions"
    _drawn: ClassVar = ("running_conditions_map", "data", "record")
    columns: ClassVar = {
        "normal_force": Column("force", "N"),
        "sliding_shift": Column("gross slip from", "m"),
        "indentation": Column("indentation", "m"),
    }


def running_conditions(
    contact: Contact, normal_force: ArrayQuantityLike, *, record: Answer | None = None
) -> RunningConditions:
    """
    Map of partial and gross slip over load and amplitude: all slips from u = mu (E*/G*) d(F_N).

    Parameters
    ----------
    contact : Contact
        With ``friction=Coulomb(mu)``, mu above 0 and finite.
    normal_force : array_like or quantity
        Loads in N, above 0.
    record : Answer, optional
        What :func:`pymdr.fretting_log` returns, with ``amplitude`` and ``normal_force`` of every cycle.

    Returns
    -------
    RunningConditions
        Over ``normal_force`` (N): the amplitude (m) from which the whole contact slips, and the indentation (m).

    Raises
    ------
    ProblemError
        If the contact has no friction, a load is not above 0, or the record has no normal force.

    Notes
    -----
    Vingsbo and Soderberg (1988), with the boundary by Cattaneo (1938), Mindlin (1949) and Jaeger (1995) for any profile.

    References
    ----------
    - Vingsbo and Soderberg (1988), Wear 126, 131-147, doi:10.1016/0043-1648(88)90134-2.
    - Cattaneo (1938), Rend. Accad. Naz. Lincei 27, 342-348; Mindlin (1949), J. Appl. Mech. 16, 259-268.
    - Jaeger (1995), Arch. Appl. Mech. 65, 478-487.

    Examples
    --------
    >>> import pymdr as mdr
    >>> ball = mdr.Contact(mdr.Paraboloid("10 mm"), mdr.Elastic("210 GPa", 0.3), friction=mdr.Coulomb(0.5))
    >>> chart = mdr.running_conditions(ball, ["10 N", "80 N"])
    >>> round(float(chart["sliding_shift"][1] / chart["sliding_shift"][0]), 12)
    4.0
    """
    loads = positive_row(normal_force, "N", "normal_force")
    require_contact(contact)
    path = None
    if record is not None:
        missing = [name for name in ("amplitude", "normal_force") if name not in record.data]
        if missing:
            raise ProblemError(
                f"the record has no {' and no '.join(missing)}; give fretting_log(..., normal_force=...)"
            )
        path = (record.data["amplitude"].values, record.data["normal_force"].values)
    depths = []
    for load in loads:
        mapped, d, mu, _ = pressed_joint("gross slip", contact, float(load), None)
        depths.append(d)
    depth = np.array(depths)
    factor = mu * mapped.moduli.normal / mapped.moduli.tangential
    like = friction_loop(contact, factor * depth[-1], normal_force=float(loads[-1])).claim
    everywhere = np.ones(loads.shape, dtype=bool)
    boundary = Claim(like.level, like.reason, like.source, everywhere)
    given = Claim(Level.EXACT, "prescribed", like.source, everywhere)
    return RunningConditions(
        data=dataset(
            {
                "sliding_shift": ("normal_force", factor * depth, {"units": "m"}),
                "indentation": ("normal_force", depth, {"units": "m"}),
            },
            coords={"normal_force": ("normal_force", loads, {"units": "N"})},
        ),
        claims={"sliding_shift": boundary, "indentation": boundary, "normal_force": given},
        contact=contact,
        references=("cattaneo-mindlin",),
        record=path,
    )
