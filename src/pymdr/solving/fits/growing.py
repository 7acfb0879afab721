"""Fitted parameters over the depth up to which a record is fitted."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from pymdr.deferred import mpl, xr
from pymdr.errors import ProblemError, PymdrError
from pymdr.presentation import plot
from pymdr.problem.contact import Contact
from pymdr.solving.curves import MeasuredCurve
from pymdr.solving.fits.fitting import fit
from pymdr.solving.fits.ranges import INDENTATION
from pymdr.solving.fits.results import FitResult, Fitted
from pymdr.solving.fits.unknowns import CONTACT_POINT, Free
from pymdr.solving.study import Study, TextTable
from pymdr.units import QuantityLike, written

_LEAST, _MOST = 2, 200


@dataclass(frozen=True, kw_only=True)
class RangeStudy(Study):
    """Fits of one record over growing ranges of indentation."""

    data: xr.Dataset
    """
    Over ``fit_range`` (m, the largest indentation of a fit): each parameter by its name, with the ends of its 95 % interval as
    ``..._low`` and ``..._high``, ``contact_point`` (m) likewise, and ``samples``, the number in the range; NaN where a fit is refused.
    """
    names: tuple[str, ...]
    """Names of the parameters."""
    whole: FitResult
    """The fit of the largest range."""

    subject: ClassVar = "this study"
    summary_claims: ClassVar = ("normal_force",)
    claims_of_rows: ClassVar = False

    def _table(self) -> TextTable:
        rows = []
        for i, depth in enumerate(self.data["fit_range"].values.tolist()):
            cells = [written(depth, "m", 3)]
            for name in (*self.names, CONTACT_POINT):
                if name not in self.data:
                    continue
                value, low, high = (float(self.data[f"{name}{end}"][i]) for end in ("", "_low", "_high"))
                unit = str(self.data[name].attrs["units"])
                known = math.isfinite(value)
                cells.append(Fitted(name, value, 1.0, low, high, unit).interval if known else "-")
            rows.append(cells)
        names = [name for name in (*self.names, CONTACT_POINT) if name in self.data]
        header = ["indentations up to", *names]
        return (header, [""] * len(header)), rows

    def _figure(self) -> mpl.figure.Figure:
        """The record with its contact point, and the parameters over the range."""
        return plot.growing_ranges(self.whole.data, self.data, self.names)


def fit_over_indentation(
    contact: Contact,
    curve: MeasuredCurve,
    free: Free,
    *,
    steps: int = 12,
    contact_point: QuantityLike | None = None,
    baseline: QuantityLike | None = None,
) -> RangeStudy:
    """
    Fit one record over growing ranges of indentation, such as a modulus over depth.

    A modulus that does not depend on the range supports the model. A modulus that grows toward the end may show the support under a
    thin sample, and one that decreases a stiff skin. A drift near the contact point may show a wrong tip or adhesion.

    Parameters
    ----------
    contact, curve, free, contact_point, baseline
        As for :func:`fit`, with one curve.
    steps : int
        Number of ranges, from 2 to 200, evenly up to the largest indentation.

    Returns
    -------
    RangeStudy
        Over ``fit_range`` (m): every parameter with the ends of its 95 % interval, and the contact point.

    Raises
    ------
    ProblemError
        If `steps` is outside its limits, the contact has friction or a memory, or the whole record cannot be fitted.

    Notes
    -----
    Each range is fitted with its own contact point and baseline, unless they are given; the rows share samples and are not independent.

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> depth = np.linspace(-1e-6, 1e-6, 201)
    >>> force = 16e3 / 9 * np.sqrt(5e-6) * np.maximum(depth, 0.0) ** 1.5
    >>> study = mdr.fit_over_indentation(
    ...     mdr.Contact(mdr.Paraboloid("5 um"), mdr.Elastic("10 kPa", 0.5)),
    ...     mdr.MeasuredCurve(force=force, indentation=depth),
    ...     ["body.young"],
    ...     steps=4,
    ... )
    >>> study["body.young"].values.round(3).tolist()
    [1000.0, 1000.0, 1000.0, 1000.0]
    """
    if type(steps) is not int or not _LEAST <= steps <= _MOST:
        raise ProblemError(f"steps = {steps!r} (limits {_LEAST} and {_MOST}); give a whole number")
    if not isinstance(curve, MeasuredCurve) or contact.friction is not None or contact.is_viscoelastic:
        raise ProblemError(
            "one MeasuredCurve of an elastic contact is needed, because the force of bodies with memory "
            "depends on the whole record"
        )
    whole = fit(contact, curve, free, contact_point=contact_point, baseline=baseline)
    depths = float(whole.data["indentation"].max()) * np.arange(1, steps + 1) / steps
    results: list[FitResult | None] = []
    refusals: list[str] = []
    for depth in depths[:-1].tolist():
        try:
            limits = {INDENTATION: depth}
            results.append(
                fit(contact, curve, free, contact_point=contact_point, baseline=baseline, fit_range=limits)
            )
        except PymdrError as error:
            results.append(None)
            refusals.append(f"indentations up to {written(depth, 'm', 3)} are not fitted: {error}")
    results.append(whole)
    names = tuple(u.name for u in whole.search.unknowns)
    data = xr.Dataset(coords={"fit_range": ("fit_range", depths, {"units": "m"})})
    for name in (*names, CONTACT_POINT) if CONTACT_POINT in whole.values else names:
        attributes = {"units": whole[name].unit}
        for end, field in (("", "value"), ("_low", "low"), ("_high", "high")):
            column = [math.nan if one is None else float(getattr(one[name], field)) for one in results]
            data[f"{name}{end}"] = "fit_range", np.array(column), attributes
    counts = [math.nan if one is None else float(one.data.sizes["step"]) for one in results]
    data["samples"] = "fit_range", np.array(counts), {"units": ""}
    return RangeStudy(
        contact=whole.contact,
        data=data,
        names=names,
        whole=replace(whole, notes=()),
        claims=whole.claims,
        assumptions=whole.assumptions,
        references=whole.references,
        notes=(*whole.notes, *refusals),
    )
