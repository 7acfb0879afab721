"""Measured force curves with the steps from the record to the fitted curve."""

from __future__ import annotations

from pymdr.problem.measured import MeasuredSamples
from pymdr.solving.curves import baselines, contacts, marking, preparing


class MeasuredCurve(MeasuredSamples):
    """
    Force against indentation, or against the travel of a machine, in the order of measurement.

    Parameters
    ----------
    force : array_like of quantity
        Normal force in N, compression positive, with or without an offset.
    indentation : array_like of quantity, optional
        In m, positive into the body, from any origin; or
    travel : array_like of quantity, optional
        of the machine (a piezo, a crosshead) in m, positive toward the body, from any origin: indentation + force /
        spring constant.
    time : array_like of quantity, optional
        In s, increasing; needed for bodies with memory.
    spring_constant : quantity, optional
        Stiffness in N/m of the machine (a cantilever, a load frame); needed with travel.
    segment : str
        ``"approach"``, ``"hold"`` or ``"retreat"``; empty for a whole record.
    metadata : Facts
        Metadata of the file in SI units.
    outliers, saturated : array_like of bool, optional
        Marked samples; none by default.
    step : Step, optional
        The step that made this curve from the one `before`.
    before : MeasuredCurve, optional
        The curve before the last step.

    Raises
    ------
    ProblemError
        If both or none of indentation and travel are given, travel without a spring constant, columns of different lengths or
        of fewer than 8 samples, or times that do not increase; an unknown segment.
    UnitError
        If a text is not a quantity of the right kind, or a number is not finite.

    Examples
    --------
    >>> import pymdr as mdr
    >>> import numpy as np
    >>> curve = mdr.MeasuredCurve(force=np.linspace(0, 1e-6, 9), travel=np.linspace(0, 2e-6, 9), spring_constant="1 N/m")
    >>> float(curve.depth[-1])
    1e-06
    """

    mark_outliers = marking.mark_outliers
    mark_saturated = marking.mark_saturated
    leave_out_marked = marking.leave_out_marked
    orient = preparing.orient
    baseline = baselines.baseline_of
    subtract_baseline = baselines.subtract_baseline
    contact_point = contacts.contact_point_of
    set_contact_point = contacts.set_contact_point
    prepare = preparing.prepare
    to_indentation = preparing.to_indentation
    recalibrate = preparing.recalibrate
    join = preparing.join
