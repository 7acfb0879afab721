"""Records of readers of force curves, and their conversion to curves."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pymdr.errors import CaseError, FileError, ProblemError, UnitError
from pymdr.problem.facts import Facts
from pymdr.problem.measured import Step
from pymdr.solving.curves import MeasuredCurve
from pymdr.units import FloatArray, QuantityLike, to_si, written
from pymdr.workbench.segments import Segment, segments_in

_FEWEST = 8
_POSITIONS = ("travel", "height", "indentation")
_SLOPES = {"signal": "m/V", "current": "m/A"}
_EXAMPLES = {"m/V": "50 nm/V", "m/A": "50 nm/nA"}


class Calibration(NamedTuple):
    """The user's calibration of the cantilever: spring constant in N/m and sensitivity in m/V or m/A, None if not given."""

    spring_constant: float | None = None
    sensitivity: float | None = None
    sensitivity_unit: str = "m/V"


@dataclass(frozen=True)
class ForceRecord:
    """
    One record of a file, as its reader gives it.

    Parameters
    ----------
    maker : str
        What the file is, for messages, such as "a file of Nanosurf".
    columns : mapping of str to ndarray
        ``force`` in N, or ``deflection`` in m, or ``signal`` in V, or ``current`` of the photodiode in A; ``travel`` in m, positive toward the body, or ``height`` of the
        cantilever in m, or ``indentation`` in m; ``time`` in s and ``segment`` numbers if known.
    spring_constant : float, optional
        Of the file, in N/m.
    sensitivity : float, optional
        Of the file, in m/V or m/A.
    metadata : mapping of str to str or float
        Further metadata of the file, in SI units.
    """

    maker: str
    columns: Mapping[str, FloatArray]
    spring_constant: float | None = None
    sensitivity: float | None = None
    metadata: Mapping[str, str | float] = field(default_factory=dict)


@dataclass(frozen=True)
class ForceFormat:
    """
    A format of force curves. A package offers one by an entry point of the group ``pymdr.readers``.

    Parameters
    ----------
    name : str
        Of the format, for messages.
    suffixes : tuple of str
        Ends of names of its files, in lower case, such as ``(".nid",)``.
    read : callable
        ``read(path, calibration)`` gives the records; any error that is not a PymdrError is reported as a damaged file.
    detect : callable, optional
        ``detect(path)`` is whether a file with such a name has this format; by default all have.
    """

    name: str
    suffixes: tuple[str, ...]
    read: Callable[[Path, Calibration], Iterable[ForceRecord]]
    detect: Callable[[Path], bool] = lambda path: True


def calibration_of(spring_constant: QuantityLike | None, sensitivity: QuantityLike | None) -> Calibration:
    """The calibration in SI units."""
    constant = None if spring_constant is None else to_si(spring_constant, "N/m", name="spring_constant")
    slope, slope_unit = (None, "m/V") if sensitivity is None else _sensitivity(sensitivity)
    for name, value, unit in (("spring_constant", constant, "N/m"), ("sensitivity", slope, slope_unit)):
        if value is not None and not value > 0.0:
            raise ProblemError(f"{name} = {written(value, unit)}: it must be above 0 {unit}")
    return Calibration(constant, slope, slope_unit)


def _sensitivity(given: QuantityLike) -> tuple[float, str]:
    """Metres per volt, or per ampere of photodiodes that give a current, and the unit."""
    try:
        return to_si(given, "m/V", name="sensitivity"), "m/V"
    except UnitError:
        try:
            return to_si(given, "m/A", name="sensitivity"), "m/A"
        except UnitError:
            pass
        raise


def curves_of(
    source: Path,
    number: int,
    record: ForceRecord,
    calibration: Calibration,
    *,
    leave_out_missing: bool,
    turn: Callable[[MeasuredCurve], MeasuredCurve] = lambda curve: curve,
) -> Iterator[MeasuredCurve]:
    """
    The curves of a record, one for each segment, separated by the travel of the probe.

    Parameters
    ----------
    number : int
        Of the record in the file, from 0.
    calibration : Calibration
        What the user gives.
    leave_out_missing : bool
        Whether samples without a number are left out; else they are refused.
    turn : callable
        Gives the record the signs of pymdr, before it is divided into segments.

    Yields
    ------
    MeasuredCurve
    """
    where = f"{source}, record {number}" if number else str(source)
    whole, numbers = _whole(where, record, calibration, leave_out_missing)
    whole = turn(whole)
    name = next(name for name in _POSITIONS if name in record.columns)
    origin = {} if name != "height" else {"position": f"minus {record.metadata.get('height', 'height')}"}
    facts = {key: value for key, value in record.metadata.items() if key != "height"}
    own = {"spring constant": record.spring_constant, "sensitivity": record.sensitivity}
    known = {key: value for key, value in own.items() if value is not None}
    metadata = Facts({"record": float(number), **known, **facts, **origin, "file": source.name})
    for segment in segments_in(whole.position, whole.time, numbers):
        yield _part(whole, segment, metadata)


def _whole(
    where: str, record: ForceRecord, calibration: Calibration, leave_out_missing: bool
) -> tuple[MeasuredCurve, FloatArray | None]:
    """The whole record as a curve, and the numbers of its segments as far as the file has them."""
    columns = dict(record.columns)
    position = next((name for name in _POSITIONS if name in columns), None)
    if position is None:
        raise ProblemError(
            f"{where}: {record.maker}, without height of the cantilever, travel or indentation (it has {', '.join(columns)}); export the height "
            "that was measured too"
        )
    force = next((name for name in ("force", "deflection", *_SLOPES) if name in columns), None)
    if force is None:
        raise ProblemError(
            f"{where}: {record.maker}, without a force or deflection (it has {', '.join(columns)}); export one of them too"
        )
    used = {name: columns[name] for name in (force, position, "time", "segment") if name in columns}
    sizes = {name: values.size for name, values in used.items()}
    if len(set(sizes.values())) > 1:
        counts = ", ".join(f"{size} of {name}" for name, size in sizes.items())
        raise FileError(
            f"cannot read {where}: its columns differ in length ({counts}): the file is cut off; copy it again from the instrument"
        )
    expected = record.metadata.get("point count")
    if isinstance(expected, float) and expected > sizes[force]:
        raise FileError(
            f"cannot read {where}: the file is cut off: it has {sizes[force]} of {expected:g} samples; copy it again from the instrument"
        )
    used, missing = _known(where, used, leave_out_missing)
    constant, slope = _constants(where, record, calibration, force, position)
    forces = used[force]
    if force in _SLOPES:
        assert slope is not None
        forces = forces * slope
    if force != "force":
        assert constant is not None
        forces = forces * constant
    needless = position == "indentation" and force == "force"
    along = -used["height"] if position == "height" else used[position]
    try:
        curve = MeasuredCurve(
            force=forces,
            indentation=along if position == "indentation" else None,
            travel=along if position != "indentation" else None,
            time=used.get("time"),
            spring_constant=record.spring_constant if needless else constant,
            step=_step_of(missing, missing + along.size),
        )
    except ProblemError as error:
        raise ProblemError(f"{where}: {error}") from error
    numbers = used.get("segment")
    return _calibrated(where, curve, record, calibration, force), numbers


def _constants(
    where: str, record: ForceRecord, calibration: Calibration, force: str, position: str
) -> tuple[float | None, float | None]:
    """Spring constant and sensitivity by which the record becomes forces, those of the file first."""
    constant = record.spring_constant if record.spring_constant is not None else calibration.spring_constant
    slope = record.sensitivity if record.sensitivity is not None else calibration.sensitivity
    lacks = []
    if constant is None and (force != "force" or position != "indentation"):
        lacks.append(("spring constant", "spring_constant, such as '0.1 N/m'"))
    if slope is None and force in _SLOPES:
        lacks.append(("sensitivity", f"sensitivity, such as {_EXAMPLES[_SLOPES[force]]!r}"))
    if lacks:
        names = " and ".join(name for name, _ in lacks)
        remedy = " and ".join(text for _, text in lacks)
        raise ProblemError(f"{where}: {record.maker}. The file has no {names}; give {remedy}")
    if force in _SLOPES and record.sensitivity is None:
        check_slope(where, record.maker, calibration, _SLOPES[force])
    return constant, slope


def check_slope(where: str, maker: str, calibration: Calibration, unit: str) -> None:
    """Refuse a sensitivity for another kind of signal."""
    if calibration.sensitivity is not None and calibration.sensitivity_unit != unit:
        raise ProblemError(
            f"{where}: {maker}. Its deflection is a {'voltage' if unit == 'm/V' else 'current'}, but sensitivity is in "
            f"{calibration.sensitivity_unit}; give it in {unit}, such as {_EXAMPLES[unit]!r}"
        )


def _calibrated(
    where: str, curve: MeasuredCurve, record: ForceRecord, calibration: Calibration, force: str
) -> MeasuredCurve:
    """A curve with the constants of the user in place of those of the file."""
    own, given = record.sensitivity, calibration.sensitivity
    if given is not None and own is None and force not in _SLOPES:
        raise ProblemError(
            f"{where}: {record.maker}. The file has no sensitivity in m/V that sensitivity= could replace; leave "
            "sensitivity out"
        )
    if given is not None and own is not None and given != own:
        factor = given / own
        text = f"{written(given, 'm/V')} in place of {written(own, 'm/V')}, and all forces times {factor:.4g}"
        step = Step("sensitivity", text, Facts({"sensitivity": given, "factor": factor}))
        curve = replace(curve, force=curve.force * factor, step=step, before=curve)
    constant = calibration.spring_constant
    if constant is not None and curve.spring_constant not in (None, constant):
        curve = curve.recalibrate(constant)
    return curve


def _known(where: str, columns: dict[str, FloatArray], leave_out: bool) -> tuple[dict[str, FloatArray], int]:
    """The columns without samples that are not numbers, and the number of samples left out."""
    for key, values in columns.items():
        missing = ~np.isfinite(values)
        if missing.any() and not leave_out:
            first = int(np.argmax(missing))
            raise CaseError(
                f"{where}: {key}[{first}] = {values[first]:g}, one of {np.count_nonzero(missing)} of {values.size} samples that are not numbers; every "
                "sample must be finite: leave_out_missing omits them and records their number"
            )
    kept = np.all([np.isfinite(values) for values in columns.values()], axis=0)
    if np.count_nonzero(kept) < _FEWEST and not kept.all():
        raise CaseError(
            f"{where}: {np.count_nonzero(kept)} of {kept.size} samples are numbers; at least {_FEWEST} are needed: measure again"
        )
    return {key: values[kept] for key, values in columns.items()}, int(np.count_nonzero(~kept))


def _step_of(missing: int, size: int) -> Step | None:
    """The preparation step that records the samples left out, if any."""
    if not missing:
        return None
    words = f"{missing} of {size} samples were not numbers, left out"
    return Step("missing", words, Facts({"count": float(missing)}))


def _part(whole: MeasuredCurve, segment: Segment, metadata: Facts) -> MeasuredCurve:
    """A segment of a record, and of the record before each of its steps."""

    def part(values: FloatArray | None) -> FloatArray | None:
        return None if values is None else values[segment.first : segment.end]

    before = whole.before
    assert before is None or isinstance(before, MeasuredCurve)
    return replace(
        whole,
        force=whole.force[segment.first : segment.end],
        indentation=part(whole.indentation),
        travel=part(whole.travel),
        time=part(whole.time),
        segment=segment.name,
        metadata=metadata,
        before=None if before is None else _part(before, segment, metadata),
    )
