"""Studies that the tables of a case ask for: first yield, shakedown, pull-off, fatigue, wear."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from pymdr.errors import ProblemError

if TYPE_CHECKING:
    from pymdr.problem.contact import Contact
    from pymdr.result import Result
    from pymdr.solving.study import Study
    from pymdr.workbench.casefile import Case


def contact_studies(case: Case) -> dict[str, Study]:
    """The studies of a case that need no result, by table."""
    studies: dict[str, Study] = {}
    if "first_yield" in case.outputs:
        from pymdr.solving.yielding import first_yield

        studies["first_yield"] = first_yield(case.contact, **case.outputs["first_yield"])
    if "shakedown" in case.outputs:
        from pymdr.solving.shakedown import shakedown

        studies["shakedown"] = shakedown(case.contact, **case.outputs["shakedown"])
    if "pull_off" in case.outputs:
        given = pull_off_arguments(case.options, case.outputs["pull_off"])
        studies["pull_off"] = pull_off_of(case.contact, **given)
    if "wear" in case.outputs:
        from pymdr.solving.wear import wear

        studies["wear"] = wear(case.contact, case.path, **case.outputs["wear"])
    return studies


def pull_off_arguments(solve: Mapping[str, Any], pull_off: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments of :func:`pull_off_of` from the tables ``[solve]`` and ``[pull_off]`` of a case."""
    return {**{name: solve[name] for name in ("machine_stiffness", "tolerance") if name in solve}, **pull_off}


def pull_off_of(contact: Contact, *, edge: bool = False, **given: Any) -> Study:
    """
    The pull-off of a contact, or its curve over several speeds or dwells.

    Parameters
    ----------
    edge : bool
        Whether the work of the receding edge over its speed is given instead; only for bodies with memory.
    **given
        Arguments of :func:`pymdr.pull_off`; those that are None are left out, and `speed` and `dwell` may be lists.
    """
    if edge and not contact.is_viscoelastic:
        raise ProblemError(
            "edge: the bodies have no memory, and the work of their edge does not depend on its speed; leave edge out, or give a viscoelastic body"
        )
    from pymdr.solving.tack import TackPullOff, pull_off
    from pymdr.solving.tack_curves import pull_off_curve

    wanted: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
    for name in ("speed", "dwell"):
        if isinstance(wanted.get(name), list) and len(wanted[name]) == 1:
            wanted[name] = wanted[name][0]
    several = any(isinstance(wanted.get(name), list | np.ndarray) for name in ("speed", "dwell"))
    if not several or not contact.is_viscoelastic or "speed" not in wanted:
        study = pull_off(contact, **wanted)
        return study.edge if edge and isinstance(study, TackPullOff) else study
    curve = pull_off_curve(contact, **wanted)
    return curve.edge if edge else curve


def fatigue_of(case: Case, result: Result) -> Study:
    """
    Fatigue of a result as the table ``[fatigue]`` of its case wants it.

    Parameters
    ----------
    case : Case
        With that table.
    """
    from pymdr.solving.fatigue import criterion_of, cycled_bulk, fatigue

    wanted = dict(case.outputs["fatigue"])
    side, bulk, amplitude = (wanted.pop(key, None) for key in ("side", "bulk", "bulk_amplitude"))
    criterion = criterion_of(wanted.pop("criterion"), **wanted)
    return fatigue(result, criterion=criterion, side=side, superposed=cycled_bulk(result, bulk, amplitude))
