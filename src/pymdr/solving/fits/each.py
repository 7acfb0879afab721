"""Fits of many records, each by itself, with groups, quality, and the reason why a record is excluded."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, ClassVar, Unpack

import numpy as np

from pymdr.deferred import mpl, xr
from pymdr.errors import ProblemError, PymdrError
from pymdr.interpretation.validity import Assumption
from pymdr.presentation import plot
from pymdr.problem.contact import Contact
from pymdr.problem.options import with_options
from pymdr.problem.schedule import Progress
from pymdr.solving.curves import MeasuredCurve
from pymdr.solving.fits.calibrations import RECORD
from pymdr.solving.fits.fitting import SHARES, FitOptions, fit
from pymdr.solving.fits.request import DRIFT, IN_CONTACT, RESIDUAL, WAVES
from pymdr.solving.fits.results import FitResult, Fitted
from pymdr.solving.fits.unknowns import Free
from pymdr.solving.grouped import GroupedValues, summarize_groups
from pymdr.solving.study import Study, TextTable

if TYPE_CHECKING:
    from pymdr.presentation.report import ReportPart

_MOST_FIGURES, _ON_SHEET = 40, 15
"""Records of a report up to which each has a figure, and number of records on one sheet otherwise."""


@dataclass(frozen=True, kw_only=True)
class FittedCurves(Study):
    """Fits of many records, each by itself."""

    contact: Contact
    """The contact whose parameters were fitted."""
    data: xr.Dataset
    """
    Over ``curve``, the names of the records: ``group``, each parameter by its name with the ends of its 95 % interval, ``..._low`` and ``..._high``,
    ``noise`` (N), ``waves``, ``samples_in_contact``, ``relative_residual`` and ``baseline_rise``, as for :class:`FittedMap`, ``good``, whether the record
    enters the statistics, and ``excluded``, the reason if not. The claims are those of the deepest good record, the assumptions the worst of all good ones.
    """
    names: tuple[str, ...]
    """Names of the parameters."""
    fits: Mapping[str, FitResult]
    """Fits of the records that could be fitted, by name."""
    statistics: Mapping[str, GroupedValues] = field(default_factory=dict)
    """Medians of the groups, by parameter, over the good records."""

    subject: ClassVar = "these fits"
    summary_claims: ClassVar = ("normal_force",)
    claims_of_rows: ClassVar = False

    def _table(self) -> TextTable:
        rows = []
        for i, curve in enumerate(self.data["curve"].values):
            reason = str(self.data["excluded"].values[i])
            fitted = self.fits.get(str(curve))
            cells = [fitted[name].interval if fitted is not None else "-" for name in self.names]
            quality = [
                f"{float(self.data[name].values[i]):.3g}" if fitted is not None else "-"
                for name in (IN_CONTACT, RESIDUAL, DRIFT)
            ]
            group = str(self.data["group"].values[i])
            rows.append([str(curve), group, *cells, *quality, "excluded" if reason else "good"])
        header = ["curve", "group", *self.names, "in contact", "residual", "baseline rise", "quality"]
        return (header, [""] * len(header)), rows

    def _remarks(self) -> list[str]:
        lines = self._report_lines()
        lines += [f"  {curve} is excluded: {reason}" for curve, reason in self._excluded()]
        for name, study in self.statistics.items():
            lines += [f"{name} by group:", *("  " + line for line in study.summary().split("\n"))]
        return lines

    def _excluded(self) -> list[list[str]]:
        """Names of excluded records, with the reasons."""
        names, reasons = (self.data[name].values.tolist() for name in ("curve", "excluded"))
        return [[name, reason] for name, reason in zip(names, reasons, strict=True) if reason]

    def _report_lines(self) -> list[str]:
        return [f"{int(self.data['good'].values.sum())} of {self.data.sizes['curve']} records are good"]

    def _report_parts(self) -> list[ReportPart]:
        """Statistics of the groups, what was excluded, and the figures of the records."""
        from pymdr.presentation.report import ReportPart

        parts = [
            ReportPart(f"Groups: {name}", study.notes, *study._table())
            for name, study in self.statistics.items()
        ]
        if excluded := self._excluded():
            parts.append(ReportPart("Excluded", (), (["curve", "reason"], ["", ""]), excluded))
        if len(self.fits) <= _MOST_FIGURES:
            figures = [(name, result.plot) for name, result in self.fits.items()]
            return [*parts, ReportPart("Records", figures=figures)]
        return [*parts, ReportPart("Records", figures=self._sheets())]

    def _sheets(self) -> list[tuple[str, Callable[[], mpl.figure.Figure]]]:
        """Captions of sheets of small figures of all records, and what draws them."""
        sheets: list[tuple[str, Callable[[], mpl.figure.Figure]]] = []
        names = list(self.fits)
        for first in range(0, len(names), _ON_SHEET):
            some = {name: self.fits[name].data for name in names[first : first + _ON_SHEET]}
            sheets.append(
                (f"Records {first + 1} to {first + len(some)}", partial(plot.sheet_of_records, some))
            )
        return sheets

    def _figure(self) -> mpl.figure.Figure:
        """The parameters of all records with their intervals, by group."""
        return plot.fitted_groups(
            self.data, {name: study.data for name, study in self.statistics.items()}, self.names
        )


@with_options(FitOptions)
def fit_each(
    contact: Contact,
    curves: Mapping[str, MeasuredCurve],
    free: Free,
    *,
    groups: Mapping[str, str] | None = None,
    excluded: Mapping[str, str] | None = None,
    progress: Progress | None = None,
    **options: Unpack[FitOptions],
) -> FittedCurves:
    """
    Fit each of many records separately, with statistics over groups such as samples.

    Parameters
    ----------
    contact, free
        As for :func:`fit`.
    curves : mapping of str to MeasuredCurve
        Records by name.
    groups : mapping of str to str, optional
        The group of each record by its name, such as the sample; one group unless given.
    excluded : mapping of str to str, optional
        Further records by name that take no part, such as unreadable files, with the reason.
    progress : callable, optional
        Called as ``progress(done, total)``.
    contact_point, baseline, fit_range, uncertainty
        As for :func:`fit`.

    Returns
    -------
    FittedCurves
        Over ``curve``: every parameter with its interval and quality; over the groups medians with intervals.

    Raises
    ------
    ProblemError
        If there is no record, one has no group, the contact has no such parameter, or no record can be fitted.

    See Also
    --------
    fit : one record, or several that share the parameters.
    fit_map : thousands of curves.
    summarize_groups : the statistics.

    Notes
    -----
    A record that cannot be fitted, or whose quality exceeds a limit of :meth:`FittedMap.mask`, is excluded from the statistics with the reason. The
    part of the errors that comes from `uncertainty` is common to all records; it is added to the interval over groups once.

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> depth = np.linspace(-1e-6, 1e-6, 101)
    >>> force = 16e3 / 9 * np.sqrt(5e-6) * np.maximum(depth, 0.0) ** 1.5
    >>> curves = {name: mdr.MeasuredCurve(force=k * force, indentation=depth) for name, k in (("a1", 1), ("a2", 2), ("b1", 4))}
    >>> contact = mdr.Contact(mdr.Paraboloid("5 um"), mdr.Elastic("10 kPa", 0.5))
    >>> study = mdr.fit_each(contact, curves, ["body.young"], groups={"a1": "a", "a2": "a", "b1": "b"})
    >>> study.statistics["body.young"]["median"].values.round(3).tolist()
    [1500.0, 4000.0]
    """
    unread = dict(excluded or {})
    if not isinstance(curves, Mapping) or not curves:
        first = next(iter(unread.items()), None)
        why = f"; the first of {len(unread)} excluded: {first[0]}: {first[1]}" if first else ""
        raise ProblemError(f"no record can be fitted{why}")
    of_group = dict.fromkeys((*curves, *unread), "all") if groups is None else dict(groups)
    if missing := [name for name in curves if name not in of_group]:
        raise ProblemError(f"{missing[0]!r} has no group ({len(missing)} records); give one for each")
    fits: dict[str, FitResult] = {}
    reasons = {**dict.fromkeys(curves, ""), **unread}
    for i, (name, curve) in enumerate(curves.items()):
        if progress is not None:
            progress(i, len(curves))
        try:
            fits[name] = fit(contact, curve, free, **options)
        except PymdrError as error:
            reasons[name] = str(error)
    if not fits:
        name = next(iter(curves))
        raise ProblemError(f"none of {len(curves)} records can be fitted; {name}: {reasons[name]}")
    reasons |= {
        name: "; ".join(one.quality.faults()) for name, one in fits.items() if one.quality is not None
    }
    return _study(contact, fits, reasons, of_group)


def _study(
    contact: Contact,
    fits: Mapping[str, FitResult],
    reasons: Mapping[str, str],
    groups: Mapping[str, str],
) -> FittedCurves:
    names = tuple(u.name for u in next(iter(fits.values())).search.unknowns)
    curves = list(reasons)
    columns: dict[str, tuple[list[float], str]] = {}
    for name in names:
        unit = next(iter(fits.values()))[name].unit
        for end, part in (("", "value"), ("_low", "low"), ("_high", "high")):
            values = [float(getattr(fits[c][name], part)) if c in fits else math.nan for c in curves]
            columns[f"{name}{end}"] = values, unit
    columns["noise"] = [fits[c].noise if c in fits else math.nan for c in curves], "N"
    columns[WAVES] = [fits[c].waves if c in fits else math.nan for c in curves], ""
    for name in (IN_CONTACT, RESIDUAL, DRIFT):
        columns[name] = [float(fits[c].data[name]) if c in fits else math.nan for c in curves], ""
    good = [name for name in curves if not reasons[name]]
    data = xr.Dataset(
        {
            "group": ("curve", np.array([groups.get(name, "") for name in curves], dtype=str), {"units": ""}),
            **{
                name: ("curve", np.array(values), {"units": unit}) for name, (values, unit) in columns.items()
            },
            "good": ("curve", np.array([not reasons[name] for name in curves]), {"units": ""}),
            "excluded": ("curve", np.array([reasons[name] for name in curves], dtype=str), {"units": ""}),
        },
        coords={"curve": ("curve", np.array(curves, dtype=str), {"units": ""})},
    )
    statistics = {}
    for name in names:
        values = [fits[c][name].value for c in good]
        if values and min(values) > 0.0:
            uncertainties = [_common(fits[c], fits[c][name]) for c in good]
            statistics[name] = summarize_groups(
                values,
                [groups[c] for c in good],
                unit=fits[good[0]][name].unit,
                name=name,
                common=float(np.median(uncertainties)),
            )
    judged = [fits[c] for c in good] or list(fits.values())
    deepest = max(judged, key=lambda one: float(one.data["indentation"].max()))
    return FittedCurves(
        contact=contact,
        data=data,
        names=names,
        fits=dict(fits),
        statistics=statistics,
        claims=deepest.claims,
        assumptions=_worst(judged),
        references=deepest.references,
        notes=_notes(fits),
    )


def _common(result: FitResult, one: Fitted) -> float:
    """Relative standard error from what all records share."""
    parts = [
        contributions[one.name] for source, contributions in result.calibration.items() if source != RECORD
    ]
    return math.hypot(*parts) / abs(one.value) if parts and one.value else 0.0


def _worst(results: list[FitResult]) -> tuple[Assumption, ...]:
    """Each assumption where it is most critical."""
    worst: dict[str, Assumption] = {}
    for one in (a for result in results for a in result.assumptions):
        if one.name not in worst or one.measure > worst[one.name].measure:
            worst[one.name] = one
    return tuple(worst.values())


def _notes(fits: Mapping[str, FitResult]) -> tuple[str, ...]:
    """The notes of the records, each once, with the records it is about."""
    about: dict[str, list[str]] = {}
    for name, result in fits.items():
        for note in (
            note for note in result.notes if not note.startswith(SHARES)
        ):  # summarize_groups has its own
            about.setdefault(note, []).append(name)
    notes = []
    for note, names in about.items():
        where = names[0] if len(names) == 1 else f"{len(names)} records"
        notes.append(f"{where}: {note}")
    return tuple(notes)
