"""Studies that the tables of a case ask for: first yield, shakedown, fatigue, wear."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pymdr.result import Result
    from pymdr.solving.study import Study
    from pymdr.workbench.casefile import Case


def contact_studies(case: Case) -> dict[str, Study]:
    """
    The studies of a case that need no result, by table.

    Parameters
    ----------
    case : Case
    """
    studies: dict[str, Study] = {}
    if "first_yield" in case.outputs:
        from pymdr.solving.yielding import first_yield

        studies["first_yield"] = first_yield(case.contact, **case.outputs["first_yield"])
    if "shakedown" in case.outputs:
        from pymdr.solving.shakedown import shakedown

        studies["shakedown"] = shakedown(case.contact, **case.outputs["shakedown"])
    if "wear" in case.outputs:
        from pymdr.solving.wear import wear

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
    from pymdr.solving.fatigue import criterion_of, cycled_bulk, fatigue

    wanted = dict(case.outputs["fatigue"])
    side, bulk, amplitude = (wanted.pop(key, None) for key in ("side", "bulk", "bulk_amplitude"))
    criterion = criterion_of(wanted.pop("criterion"), **wanted)
    return fatigue(result, criterion=criterion, side=side, superposed=cycled_bulk(result, bulk, amplitude))
