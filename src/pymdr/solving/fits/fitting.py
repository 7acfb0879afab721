"""From measured curves to the numbers of a contact."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pymdr.errors import ProblemError, QuantityError
from pymdr.interpretation.validity import SOURCES, Assumption, Claim
from pymdr.problem.codec import encode
from pymdr.problem.contact import Contact
from pymdr.problem.measured import MeasuredCurve
from pymdr.problem.paths import Path, indent
from pymdr.result import Result, labelled
from pymdr.solving.curves import leave_out_marked
from pymdr.solving.fits.asking import FOUND, SEEN, Asked
from pymdr.solving.fits.quick import fit_by_family
from pymdr.solving.fits.records import ListedCurves
from pymdr.solving.fits.searching import (
    Modelled,
    Search,
    autocorrelation_time,
    beside_jumps,
    found_from,
    free_numbers,
    refuse_blind,
    refuse_unsettled,
)
from pymdr.solving.fits.starting import Start, starts
from pymdr.solving.fits.unknowns import BASELINE, CONTACT_POINT, ORIGINS, Free, origins, put_into, unknowns_of
from pymdr.solving.verb import solve
from pymdr.units import FloatArray, QuantityLike, shown, written

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

LEVENBERG_MARQUARDT, LMFIT = "levenberg-marquardt", "lmfit"
_STARTS = 4
_PULLS, _SMALL = 8.0, 0.02
"""A pull that is told: in parts of the noise, and of the range of the force."""


class Fitted(NamedTuple):
    """A number that was found."""

    name: str
    value: float
    """In the unit."""
    error: float
    """Standard error in the unit."""
    low: float
    high: float
    """Ends of the interval of 95 %, in the unit."""
    unit: str
    """The SI unit."""

    def __str__(self) -> str:
        low, high = (written(end, self.unit, 4) for end in (self.low, self.high))
        return f"{self.name} = {written(self.value, self.unit, 4)}, 95 % between {low} and {high}"


@dataclass(frozen=True, kw_only=True)
class FitResult:
    """What a fit found, and how well it fits."""

    contact: Contact
    """With the values that were found."""
    curves: tuple[MeasuredCurve, ...]
    values: Mapping[str, Fitted]
    """Unknowns and origins by name."""
    data: xr.Dataset
    """Over ``step``, the samples of all curves: ``indentation`` (m) and ``normal_force`` (N) from the origins that were found,
    ``model`` and ``residual`` (N), ``in_contact``, ``used``, and ``curve``; of bodies with memory ``time`` (s)."""
    noise: float
    """Standard deviation of the residuals in N."""
    correlated: float
    """How many samples tell as much as one independent one; it widens the errors by its root."""
    aicc: float
    """Akaike's information criterion for small samples, of the independent ones."""
    claims: Mapping[str, Claim]
    """How far the model can be trusted at the deepest sample."""
    assumptions: tuple[Assumption, ...]
    notes: tuple[str, ...]
    references: tuple[str, ...]
    """Keys of the sources that :meth:`cite` names."""
    search: Search
    minimum: Any
    """Minimizer and result of lmfit, in the logarithms of sizes."""

    def __getitem__(self, name: str) -> Fitted:
        if name not in self.values:
            raise QuantityError(f"no {shown(name)} was looked for; there are {', '.join(self.values)}")
        return self.values[name]

    def profile_intervals(
        self, names: Sequence[str] | None = None, sigma: float = 1.96
    ) -> dict[str, tuple[float, float]]:
        """
        Intervals by profile likelihood, which need not be symmetric.

        Parameters
        ----------
        names : sequence of str, optional
            Of the values; all unknowns of the contact unless given.
        sigma : float
            Half width in standard deviations of a normal distribution: 1.96 for 95 %.

        Returns
        -------
        dict of str to (float, float)
            Ends in SI units; errors that hang together widen them as they do the others.

        Raises
        ------
        QuantityError
            If a name was not looked for.
        """
        from lmfit import conf_interval

        asked = [u.name for u in self.search.unknowns] if names is None else list(names)
        for name in asked:
            self[name]
        numbers = [self.search.names.index(name) for name in asked]
        minimizer, found = self.minimum
        wide = sigma * math.sqrt(self.correlated)
        table = conf_interval(minimizer, found, p_names=[f"p{i}" for i in numbers], sigmas=[wide])
        best, ends = free_numbers(found, len(self.search.names)), {}
        for name, i in zip(asked, numbers, strict=True):
            rows = table[f"p{i}"]
            values = []
            for free in (rows[0][1], rows[-1][1]):
                moved = best.copy()
                moved[i] = free
                inner, outer = self.search.from_free(moved)
                values.append(_named(self.search, inner, outer)[name])
            ends[name] = (min(values), max(values))
        return ends

    def summary(self) -> str:
        """Values with their intervals, how well they fit, and how far to trust the model."""
        claim = self.claims["normal_force"]
        lines = [str(value) for value in self.values.values()]
        lines.append(self._told_of_noise())
        lines.append(f"model: {claim.level.value}: {claim.reason}")
        lines += [
            f"not met: {a.words} {a.measure:.3g}, limit {a.limit:.3g}" for a in self.assumptions if not a.met
        ]
        return "\n".join([*lines, *(f"note: {note}" for note in self.notes)])

    def _told_of_noise(self) -> str:
        used = int(self.data["used"].values.sum())
        told = f"noise {written(self.noise, 'N', 3)} in {used} of {self.data.sizes['step']} samples"
        if self.correlated > 1.0:
            told += f", of which {self.correlated:.3g} tell as much as an independent one"
        return told

    def __str__(self) -> str:
        return self.summary()

    def __repr__(self) -> str:
        found = ", ".join(f"{one.name} = {written(one.value, one.unit, 4)}" for one in self.values.values())
        return f"<pymdr.FitResult {found}>"

    def _repr_html_(self) -> str:
        """The summary as tables, for notebooks."""
        from pymdr.presentation.html import found_html

        rows = (
            [one.name, *(written(value, one.unit, 4) for value in (one.value, one.error, one.low, one.high))]
            for one in self.values.values()
        )
        head = ("found", "value", "standard error", "95 % from", "to")
        return found_html(head, rows, [self._told_of_noise()], self.claims, self.assumptions, self.notes)

    def cite(self) -> tuple[str, ...]:
        """References of the theory and of the search."""
        return tuple(SOURCES[key] for key in self.references)

    def save(self, file: str | os.PathLike[str]) -> None:
        """
        Write the samples with their model, and what was found, to a NetCDF file, which xarray opens, whole or not at all.

        Parameters
        ----------
        file : path
            For example "fit.nc". Its attribute ``pymdr_fit`` is the JSON of the values, the noise, the contact, claims, notes and
            references.

        Raises
        ------
        FileError
            If the file cannot be written, or its name is that of another format.
        ProblemError
            If the profile is a Python function, which no file holds.
        """
        from pymdr.presentation.files import write_dataset

        told = {
            "values": {name: one._asdict() for name, one in self.values.items()},
            "noise": self.noise,
            "correlated": self.correlated,
            "aicc": self.aicc,
            "contact": encode(self.contact),
            "claims": {name: [c.level.name, c.reason, c.source] for name, c in self.claims.items()},
            "notes": self.notes,
            "references": self.cite(),
        }
        write_dataset(self.data.assign_attrs(pymdr_fit=json.dumps(told)), file)

    def to_csv(self, file: str | os.PathLike[str]) -> None:
        """
        Write the samples with their model, one row each, with units in the names of the columns.

        Parameters
        ----------
        file : path
            For example "fit.csv".

        Raises
        ------
        FileError
            If the file cannot be written.
        """
        from pymdr.presentation.tables import write_csv

        units = {name: str(self.data[name].attrs.get("units", "")) for name in self.data}
        write_csv(
            {
                f"{name} [{unit}]" if unit else str(name): self.data[name].values
                for name, unit in units.items()
            },
            file,
        )

    def plot(self) -> Figure:
        """The curves with their model, and what is left."""
        from pymdr.presentation.plot import fitted_curves

        return fitted_curves(self.data, [str(value) for value in self.values.values()])


def fit(
    contact: Contact,
    curve: MeasuredCurve | Sequence[MeasuredCurve],
    free: Free,
    *,
    contact_point: QuantityLike | None = None,
    baseline: QuantityLike | None = None,
) -> FitResult:
    """
    Find parameters of a contact in measured force curves.

    Parameters
    ----------
    contact : Contact
        What is known, and the law: elastic bodies with or without adhesion, or bodies with memory. Lengths that are looked for
        begin from what it says.
    curve : MeasuredCurve or sequence of MeasuredCurve
        One, or several of the same contact, each with its own origins.
    free : sequence of str, or mapping of str to pair of quantities or None
        Parameters that are looked for by their dotted names, such as ``["body.young", "adhesion.work"]``, with bounds where
        there are any.
    contact_point : quantity, optional
        The depth of the record in m at which the bodies touch; looked for unless given.
    baseline : quantity, optional
        The force of the record in N when they do not; looked for unless given.

    Returns
    -------
    FitResult

    Raises
    ------
    ProblemError
        If the contact has no number of a name, the records cannot tell the unknowns apart or show no adhesion, the contact has
        friction, or lmfit is not installed.
    ConvergenceError
        If the search does not settle.

    Notes
    -----
    The depth of a sample is its travel less the deflection of the machine; the noise of the force, which is in both, is taken
    out of the weights. Under adhesion samples between the depths at which bodies jump into contact and leave it belong to the
    branch that is nearer, and those beside a jump are left out. The search begins from the best places of a grid over
    everything that is not linear. Errors are those of the curvature of the misfit, times the root of how many samples tell as
    much as an independent one.

    Examples
    --------
    >>> from pymdr.problem.materials import Elastic
    >>> from pymdr.problem.profiles import Paraboloid
    >>> depth = np.linspace(-1e-6, 1e-6, 101)
    >>> force = 16e3 / 9 * np.sqrt(5e-6) * np.maximum(depth, 0.0) ** 1.5
    >>> found = fit(
    ...     Contact(Paraboloid("5 um"), Elastic("10 kPa", 0.5)),
    ...     MeasuredCurve(force=force, indentation=depth + 3e-7),
    ...     ["body.young"],
    ... )
    >>> round(found["body.young"].value, 6), round(1e9 * found["contact_point"].value, 6)
    (1000.0, 300.0)
    """
    if not isinstance(contact, Contact):
        raise ProblemError(f"fit: {contact!r} is not a Contact; write Contact(profile, body)")
    curves = (curve,) if isinstance(curve, MeasuredCurve) else tuple(curve)
    if not curves or not all(isinstance(one, MeasuredCurve) for one in curves):
        raise ProblemError("fit: a MeasuredCurve is needed, or several")
    known = origins({CONTACT_POINT: contact_point, BASELINE: baseline})
    marked = sum(int(one.marked.sum()) for one in curves)
    curves = tuple(leave_out_marked(one) if one.marked.any() else one for one in curves)
    search = Search(contact, unknowns_of(contact, free), curves, known)
    misfit, best = _best(search)
    _refuse_unseen(search, misfit)
    refuse_blind(search, best)
    used = beside_jumps(search.models(best), search)
    if not all(part.all() for part in used):
        search = replace(search, used=used)
    minimum = found_from(search, best)
    refuse_unsettled(minimum[1])
    best = free_numbers(minimum[1], best.size)
    refuse_blind(search, best)
    found = _interpreted(search, best, minimum)
    notes = (f"{marked} samples marked as outliers or saturated are left out",) if marked else ()
    return replace(found, notes=(*notes, *_unexplained_pull(found), *found.notes))


def _best(search: Search) -> tuple[float, FloatArray]:
    """The smallest misfit in N^2 that searches from several starts end at, and the free numbers there."""
    quick = _quick_start(search)
    apart = (
        [starts(search.contact, search.unknowns, curve, search.known, _STARTS) for curve in search.curves]
        if quick is None
        else [[quick]]
    )
    ends = []
    for rank in range(max(len(found) for found in apart)):
        chosen = [found[min(rank, len(found) - 1)] for found in apart]
        places = [{CONTACT_POINT: one.contact_point, BASELINE: one.baseline} for one in chosen]
        _, found = found_from(search, search.to_free(chosen[0].values.tolist(), places))
        ends.append((float(found.chisqr), free_numbers(found, len(search.names))))
    return min(ends, key=lambda end: end[0])


def _unexplained_pull(found: FitResult) -> tuple[str, ...]:
    """A note where a record pulls, and the contact has no adhesion; the noise is that between neighbours."""
    if found.contact.adhesion is not None:
        return ()
    force = found.data["normal_force"].values
    noise = 1.4826 * float(np.median(np.abs(np.diff(force)))) / math.sqrt(2.0)
    smooth = np.median(np.lib.stride_tricks.sliding_window_view(force, 3), axis=1)
    pull = -float(smooth.min())
    if pull <= max(_PULLS * noise, _SMALL * float(np.ptp(force))):
        return ()
    return (
        f"the record pulls with up to {written(pull, 'N', 3)}, below the baseline that was found, and the contact has no adhesion: "
        "fit it with one, such as JKR(work), or the approach alone",
    )


def _quick_start(search: Search) -> Start | None:
    """Where the search over a family of forces ends, if there is one and it finds something."""
    unknowns, curves = search.unknowns, ListedCurves(search.curves)
    begun = put_into(search.contact, unknowns, np.array([u.start for u in unknowns]))
    asked = Asked(begun, unknowns, search.known, {}, [u.name for u in unknowns])
    if asked.ways is None or len(search.curves) > 1:
        return None
    found = fit_by_family(asked, asked.ways, curves.read(0, 1)).columns
    if found["ending"][0] != FOUND:
        return None
    origin = {name: float(found[name][0]) for name in asked.origins}
    values = np.array([found[u.name][0] for u in unknowns])
    return Start(0.0, values, origin.get(CONTACT_POINT, 0.0), origin.get(BASELINE, 0.0))


def _refuse_unseen(search: Search, misfit: float) -> None:
    """Refuse an adhesion without which the record fits as well."""
    without = tuple(u for u in search.unknowns if not u.name.startswith("adhesion."))
    if search.contact.adhesion is None or len(without) == len(search.unknowns):
        return
    samples = sum(curve.force.size for curve in search.curves)
    bare = replace(search, contact=replace(search.contact, adhesion=None), unknowns=without)
    if without:
        larger, _ = _best(bare)
    else:
        larger = float((bare.residuals(np.zeros(len(bare.names))) ** 2).sum())
    grows = (larger / misfit - 1.0) * samples
    if grows < SEEN:
        raise ProblemError(
            f"fit: the record shows no adhesion: without it the squares of the differences grow by {max(grows, 0.0):.2g} times "
            f"the variance of the noise, {SEEN:g} are needed; fit the contact without adhesion"
        )


def _interpreted(search: Search, best: FloatArray, minimum: Any) -> FitResult:
    from scipy.stats import t as student

    residuals = search.residuals(best)
    slopes = search.slopes(best)
    n, p = residuals.size, best.size
    noise = math.sqrt(float((residuals**2).sum()) / max(n - p, 1))
    correlated = autocorrelation_time(residuals)
    independent = n / correlated
    scale = np.linalg.norm(slopes, axis=0)
    covariance = np.linalg.pinv((slopes / scale).T @ (slopes / scale)) / np.outer(scale, scale)
    errors = noise * np.sqrt(correlated * np.diag(covariance))
    width = float(student.ppf(0.975, max(independent - p, 1.0)))
    values = _fitted(search, best, errors, width)
    inner, _ = search.from_free(best)
    contact = put_into(search.contact, search.unknowns, inner)
    models = search.models(best)
    deepest = max(float(one.depth.max()) for one in models)
    judged = _judged(contact, search.curves[0], models[0], deepest)
    left_out = sum(int((~part).sum()) for part in search.used)
    notes = (f"{left_out} samples beside jumps are left out",) if left_out else ()
    return FitResult(
        contact=contact,
        curves=search.curves,
        values=values,
        data=_table(search, models),
        noise=noise,
        correlated=correlated,
        aicc=aicc(float((residuals**2).mean()), independent, p),
        claims=judged.claims,
        assumptions=judged.assumptions,
        notes=notes,
        references=(*judged.references, LEVENBERG_MARQUARDT, LMFIT),
        search=search,
        minimum=minimum,
    )


def _judged(contact: Contact, curve: MeasuredCurve, first: Modelled, deepest: float) -> Result:
    """The contact that was found, where it is pressed deepest; with memory along the whole record."""
    if contact.remembers:
        assert curve.time is not None
        return solve(contact, Path(time=curve.time - curve.time[0], indentation=first.depth))
    if deepest <= 0.0:
        raise ProblemError(
            "fit: the bodies touch at no sample; give contact_point, or a record that presses them"
        )
    return solve(contact, indent(deepest))


def aicc(mean_square: float, independent: float, p: int) -> float:
    """AICc of least squares with an unknown noise (Burnham and Anderson 2002), of the independent samples."""
    k = p + 1
    room = max(independent - k - 1.0, 1.0)
    return independent * math.log(max(mean_square, 1e-300)) + 2.0 * k + 2.0 * k * (k + 1) / room


def _named(search: Search, values: FloatArray, places: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Unknowns and origins by name."""
    named = {u.name: float(v) for u, v in zip(search.unknowns, values, strict=True)}
    for i, place in enumerate(places):
        for name in (CONTACT_POINT, BASELINE):
            named[f"{name}[{i}]" if len(places) > 1 else name] = place[name]
    return named


def _fitted(search: Search, best: FloatArray, errors: FloatArray, width: float) -> dict[str, Fitted]:
    found = {}
    units = {u.name: u.unit for u in search.unknowns}
    for i, name in enumerate(search.names):
        ends = []
        for side in (0.0, -width, width, 1.0):
            moved = best.copy()
            moved[i] += side * errors[i]
            ends.append(_named(search, *search.from_free(moved))[name])
        value, low, high, one = ends
        unit = units.get(name) or ORIGINS.get(name.partition("[")[0], "")
        found[name] = Fitted(name, value, abs(one - value), min(low, high), max(low, high), unit)
    return found


def _table(search: Search, models: Sequence[Modelled]) -> xr.Dataset:
    """The samples of all curves, one after another."""
    used = search.used or tuple(np.ones(one.force.size, dtype=bool) for one in models)
    columns = {
        "indentation": np.concatenate([one.depth for one in models]),
        "normal_force": np.concatenate([one.force for one in models]),
    }
    if search.contact.remembers:
        columns["time"] = np.concatenate([curve.time for curve in search.curves if curve.time is not None])
    table = labelled(columns)
    more = {
        "model": np.concatenate([one.model for one in models]),
        "residual": np.concatenate([one.force - one.model for one in models]),
        "in_contact": np.concatenate([one.touches for one in models]),
        "used": np.concatenate(used),
        "curve": np.repeat(np.arange(len(models)), [one.force.size for one in models]),
    }
    units = {"model": "N", "residual": "N"}
    return table.assign(
        {name: ("step", column, {"units": units.get(name, "")}) for name, column in more.items()}
    )
