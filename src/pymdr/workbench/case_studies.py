"""Studies that the tables of a case ask for: first yield, shakedown, fatigue, wear."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from pymdr.solving.fatigue import criterion_of, cycled_bulk, fatigue
from pymdr.solving.shakedown import shakedown
from pymdr.solving.study import Study
from pymdr.solving.wear import wear
from pymdr.solving.yielding import first_yield

if TYPE_CHECKING:
    from pymdr.result import Result
    from pymdr.workbench.casefile import Case


def contact_studies(case: Case) -> dict[str, Study]:
    """
    The studies of a case that need no result, by table.

    Parameters
    ----------
    case : Case
    """
    known: dict[str, Callable[..., Study]] = {"first_yield": first_yield, "shakedown": shakedown}
    studies = {
        name: verb(case.contact, **case.outputs[name]) for name, verb in known.items() if name in case.outputs
    }
    if "wear" in case.outputs:
        studies["wear"] = wear(case.contact, case.path, **case.outputs["wear"])
    return studies


def fatigue_of(case: Case, result: Result) -> Study:
    """
    Fatigue of a result as the table ``[fatigue]`` of its case wants it.

    Parameters
    ----------
    case : Case
        With that table.
    result : Result
    """
    wanted = dict(case.outputs["fatigue"])
    side, bulk, amplitude = (wanted.pop(key, None) for key in ("side", "bulk", "bulk_amplitude"))
    criterion = criterion_of(wanted.pop("criterion"), **wanted)
    return fatigue(result, criterion=criterion, side=side, superposed=cycled_bulk(result, bulk, amplitude))
