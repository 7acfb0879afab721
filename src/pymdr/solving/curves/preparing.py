"""Steps from the record to the fitted curve; each returns a new curve and can be undone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from pymdr.errors import ProblemError
from pymdr.problem.facts import Fact, Facts
from pymdr.problem.measured import BoolArray, MeasuredSamples, Samples, Step
from pymdr.solving.curves.baselines import Baseline, subtract_baseline
from pymdr.solving.curves.branches import blocks
from pymdr.solving.curves.contacts import ContactPoint, contact_point_of, set_contact_point
from pymdr.solving.curves.marking import mark_outliers, mark_saturated
from pymdr.units import FloatArray, QuantityLike, to_si, written

_OTHER = {"approach": "retreat", "retreat": "approach"}


_KNOWN = ("JPK",)
"""Beginnings of the formats, in the metadata of curves, whose files have these signs: compression positive, the height falling toward the body."""


def orient(
    curve: Samples, signs: Mapping[str, Fact] | None = None, *, keep_signs: bool | None = None
) -> Samples:
    """
    Change signs such that compression is positive and the position increases toward the body.

    The contact is at the end of the positions where the force varies more, and is compressive; marked samples are ignored. Signs that the
    maker of the instrument has defined, as in files of JPK, are kept: the record may show no contact, or mostly a pull.

    Parameters
    ----------
    curve : MeasuredCurve
        With any signs; an approach, a retreat or a whole record.
    signs : mapping of str to float, optional
        1 or -1 for ``force`` and for ``travel`` or ``indentation``, as in the `numbers` of the step of another segment; determined from
        the record by default.
    keep_signs : bool, optional
        Whether the signs are kept as they are; by default if they are known from the format of the file.

    Returns
    -------
    MeasuredCurve
        With the step, which names the turned signs.

    Raises
    ------
    ProblemError
        If the force varies similarly at both ends, so that the contact end is not clear, or a sign is neither 1 nor -1.

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> height = np.linspace(2e-6, 0.0, 90)
    >>> curve = mdr.MeasuredCurve(force=-np.clip(1e-6 - height, 0.0, None) ** 2, indentation=height)
    >>> print(curve.orient().step)
    signs: reversed, so that compression is positive and the position grows toward the body: force and indentation
    """
    name = "travel" if curve.indentation is None else "indentation"
    maker = str(curve.metadata.get("format", ""))
    known = keep_signs or (keep_signs is None and maker.startswith(_KNOWN))
    if signs is None:
        signs = {"force": 1.0, name: 1.0} if known else _signs(curve, name)
    else:
        known = False
    for word in ("force", name):
        if signs.get(word) not in (1.0, -1.0):
            raise ProblemError(
                f"the sign of {word} is {signs.get(word)!r}; give 1 or -1, for example hold.orient(approach.orient().step.numbers)"
            )
    turned = [word for word in ("force", name) if signs[word] == -1.0]
    meaning = "compression is positive and the position grows toward the body"
    why = f", as {maker} defines them" if known and keep_signs is None else ""
    position = -curve.position if name in turned else curve.position
    return replace(
        curve,
        force=-curve.force if "force" in turned else curve.force,
        indentation=None if curve.indentation is None else position,
        travel=None if curve.travel is None else position,
        segment=_OTHER.get(curve.segment, curve.segment) if name in turned else curve.segment,
        step=Step(
            "signs",
            f"reversed, so that {meaning}: {' and '.join(turned)}" if turned else f"kept: {meaning}{why}",
            Facts({"force": float(signs["force"]), name: float(signs[name])}),
        ),
        before=curve,
    )


def _signs(curve: MeasuredSamples, name: str) -> dict[str, float]:
    kept = ~curve.marked
    near, far = _ends(curve.position[kept], curve.force[kept])
    low, high = (float(np.ptp(blocks(part, 20))) if part.size >= 20 else 0.0 for part in (near, far))
    if max(near.size, far.size) < 20:
        raise ProblemError(
            f"the signs cannot be determined from {curve.position.size} samples, too few at both ends; give a longer record, keep_signs if compression is positive, or the signs"
        )
    if not max(low, high) > 1.5 * min(low, high):
        raise ProblemError(
            f"the signs cannot be determined: the force varies by {written(low, 'N')} and {written(high, 'N')} at the two ends of the positions, and one "
            "must exceed 1.5 times the other; give a record with samples before and in contact, keep_signs if compression is positive, or the signs"
        )
    deep, free = (far, near) if high > low else (near, far)
    count = max(1, deep.size // 20)
    deepest = deep[-count:] if high > low else deep[:count]
    presses = float(np.median(deepest)) >= float(np.median(free))
    return {"force": 1.0 if presses else -1.0, name: 1.0 if high > low else -1.0}


def _ends(position: FloatArray, force: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Forces of the lower and the upper third of the positions, in the order of the positions."""
    order = np.argsort(position, kind="stable")
    low, width = float(position.min()), float(np.ptp(position))
    sorted_position, sorted_force = position[order], force[order]
    return sorted_force[sorted_position < low + width / 3.0], sorted_force[
        sorted_position > low + 2.0 * width / 3.0
    ]


def to_indentation(curve: Samples) -> Samples:
    """
    A curve over its indentation, without the deflection of the machine: indentation = travel - force/spring constant.

    The noise of the force enters the indentation. :func:`pymdr.fit` does not need this step; it computes the model over the travel.

    Parameters
    ----------
    curve : MeasuredCurve
        Over travel, with its baseline subtracted, which would otherwise count as a deflection.

    Returns
    -------
    MeasuredCurve
        With the step.

    Raises
    ------
    ProblemError
        If the curve already has its indentation.

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> curve = mdr.MeasuredCurve(force=np.linspace(0, 1e-6, 9), travel=np.linspace(0, 2e-6, 9), spring_constant="1 N/m")
    >>> float(curve.to_indentation().indentation[-1])
    1e-06
    """
    if curve.travel is None or curve.spring_constant is None:
        raise ProblemError("the curve already has its indentation; only a curve over travel has a deflection")
    lag = float(np.ptp(curve.force)) / curve.spring_constant
    return replace(
        curve,
        travel=None,
        indentation=curve.depth,
        step=Step(
            "lag",
            f"the machine of {written(curve.spring_constant, 'N/m')} deflects by up to {written(lag, 'm')}: indentation = travel - force/spring constant",
            Facts({"spring_constant": curve.spring_constant, "largest": lag}),
        ),
        before=curve,
    )


def recalibrate(curve: Samples, spring_constant: QuantityLike) -> Samples:
    """
    A curve with another spring constant: the measured deflection is kept, the force is proportional to the constant.

    Parameters
    ----------
    curve : MeasuredCurve
        Over travel.
    spring_constant : quantity
        In N/m.

    Returns
    -------
    MeasuredCurve
        With the step.

    Raises
    ------
    ProblemError
        If the curve has no spring constant, or the new one is not above 0.
    """
    if curve.spring_constant is None:
        raise ProblemError(
            "the curve has no spring constant; only a force from a deflection can be recalibrated"
        )
    new = to_si(spring_constant, "N/m", name="spring_constant")
    if not new > 0.0:
        raise ProblemError(f"spring_constant = {written(new, 'N/m')}: it must be above 0 N/m")
    factor = new / curve.spring_constant
    return replace(
        curve,
        force=curve.force * factor,
        spring_constant=new,
        step=Step(
            "spring constant",
            f"{written(new, 'N/m')} in place of {written(curve.spring_constant, 'N/m')}, and all forces times {factor:.4g}",
            Facts({"spring_constant": new, "factor": factor}),
        ),
        before=curve,
    )


def prepare(
    curve: Samples,
    *,
    baseline: Baseline | QuantityLike | None = None,
    contact_point: ContactPoint | QuantityLike | None = None,
    keep_signs: bool | None = None,
) -> Samples:
    """
    All steps in order: outliers, signs, saturation, baseline, contact point.

    Parameters
    ----------
    curve : MeasuredCurve
        An approach, a retreat or a whole record.
    baseline : Baseline or quantity, optional
        That of the oriented curve by default.
    contact_point : ContactPoint or quantity, optional
        That of the curve by default.
    keep_signs : bool, optional
        As `keep` of :meth:`~pymdr.MeasuredCurve.orient`.

    Returns
    -------
    MeasuredCurve
        Its `steps` list what was done, and its `original` is the record.

    Raises
    ------
    ProblemError
        As the steps.

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> height = np.linspace(2e-6, 0.0, 400)
    >>> curve = mdr.MeasuredCurve(force=1e-9 + np.clip(1e-6 - height, 0.0, None) ** 1.5, indentation=height).prepare()
    >>> [step.name for step in curve.steps]
    ['outliers', 'signs', 'saturation', 'baseline', 'contact point']
    >>> bool(curve.original.indentation[0] == 2e-6)
    True
    """
    straight = subtract_baseline(
        mark_saturated(orient(mark_outliers(curve), keep_signs=keep_signs)), baseline
    )
    return set_contact_point(straight, contact_point_of(straight) if contact_point is None else contact_point)


def join(curve: Samples, *others: Samples) -> Samples:
    """
    One record from its segments, in order.

    Parameters
    ----------
    curve, *others : MeasuredCurve
        Segments of one record, as read or all with the same steps.

    Returns
    -------
    MeasuredCurve
        With the metadata of the first.

    Raises
    ------
    ProblemError
        If their machines differ, only some have times, or they are of different records.
    """
    parts, first = (curve, *others), curve
    for name in ("spring_constant", "metadata"):
        if any(getattr(one, name) != getattr(first, name) for one in parts):
            raise ProblemError(
                f"the curves differ in {name.replace('_', ' ')}: they are not of one record; join the segments of each record separately"
            )
    for name in ("time", "travel", "indentation"):
        if len({getattr(one, name) is None for one in parts}) > 1:
            raise ProblemError(f"only some of the curves have {name}; give all or none")

    def whole(name: str) -> FloatArray | None:
        columns = [getattr(one, name) for one in parts]
        return None if columns[0] is None else np.concatenate(columns)

    def marks(name: str) -> BoolArray | None:
        given = [getattr(one, name) for one in parts]
        if all(one is None for one in given):
            return None
        none = [np.zeros(one.force.size, bool) for one in parts]
        return np.concatenate([n if g is None else g for n, g in zip(none, given, strict=True)])

    text = ", ".join(one.segment or "a record" for one in parts)
    earlier = dict.fromkeys(str(step) for one in parts for step in one.steps)
    text += f"; done before: {'; '.join(earlier)}" if earlier else ""
    return replace(
        first,
        force=np.concatenate([one.force for one in parts]),
        indentation=whole("indentation"),
        travel=whole("travel"),
        time=whole("time"),
        segment="",
        step=Step("joined", text),
        before=None,
        outliers=marks("outliers"),
        saturated=marks("saturated"),
    )
