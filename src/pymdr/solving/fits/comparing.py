"""Comparison of laws by their fits to a measured curve."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from pymdr.deferred import mpl, xr
from pymdr.errors import ProblemError, PymdrError, QuantityError
from pymdr.presentation import plot
from pymdr.problem.contact import Contact
from pymdr.problem.parameters import parameters_of
from pymdr.quantities import one_name
from pymdr.solving.curves import MeasuredCurve
from pymdr.solving.fits.estimating import aicc
from pymdr.solving.fits.fitting import fit
from pymdr.solving.fits.own_jumps import judged
from pymdr.solving.fits.results import FitResult
from pymdr.solving.fits.unknowns import TILT
from pymdr.solving.study import Answer, Column
from pymdr.units import ArrayQuantityLike, QuantityLike, shown


@dataclass(frozen=True, kw_only=True)
class LawComparison(Answer):
    """Fits of several laws to one record, with their weights."""

    data: xr.Dataset
    """Over ``law``, the most likely first: ``weight``, ``difference`` of AICc from the smallest one, the level of the ``claim`` of the
    force, and the assumptions that are ``not_met``."""
    fits: Mapping[str, FitResult]
    """By the names of the laws."""
    refusals: Mapping[str, str]
    """Messages of the laws that could not be fitted."""
    samples: int
    """Number of samples that all fits use."""

    columns: ClassVar = {
        "law": Column("law", ""),
        "weight": Column("weight", ""),
        "difference": Column("AICc above the best", ""),
        "claim": Column("model", ""),
        "not_met": Column("not met", ""),
    }

    @property
    def weights(self) -> dict[str, float]:
        """Akaike weights: the probability of each law to be the best of those compared."""
        return self._by_law("weight")

    @property
    def differences(self) -> dict[str, float]:
        """Differences of AICc from the smallest one."""
        return self._by_law("difference")

    @property
    def best(self) -> str:
        """The law with the largest weight."""
        return str(self.data["law"].values[0])

    def __getitem__(self, name: str) -> FitResult:
        if one_name(name) in self.refusals:
            raise QuantityError(f"{name} could not be fitted: {self.refusals[name]}")
        if name not in self.fits:
            raise QuantityError(f"no law {shown(name)}; the laws are {', '.join(self.fits)}")
        return self.fits[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.fits)

    def __repr__(self) -> str:
        weights = ", ".join(f"{name} {weight:.3g}" for name, weight in self.weights.items())
        refused = f"; not weighed: {', '.join(self.refusals)}" if self.refusals else ""
        return f"<pymdr.LawComparison {weights}{refused}>"

    def _by_law(self, name: str) -> dict[str, float]:
        return dict(zip(self.data["law"].values.tolist(), self.data[name].values.tolist(), strict=True))

    def _remarks(self) -> list[str]:
        return [
            f"{len(self.fits)} laws over {self.samples} samples",
            *(f"{name}: {text}" for name, text in self.refusals.items()),
        ]

    def _figure(self) -> mpl.figure.Figure:
        """The record with the models of all laws, and the residuals of each."""
        return plot.weighed_laws({name: one.data for name, one in self.fits.items()}, self.weights)


def compare_laws(
    contacts: Mapping[str, Contact],
    curve: MeasuredCurve | xr.Dataset | Sequence[MeasuredCurve] | Sequence[xr.Dataset],
    free: Sequence[str] | Mapping[str, ArrayQuantityLike | None],
    *,
    contact_point: QuantityLike | None = None,
    shift_origin: QuantityLike | None = None,
    baseline: QuantityLike | None = None,
) -> LawComparison:
    """
    Fit several laws to one record and weigh them.

    Parameters
    ----------
    contacts : mapping of str to Contact
        The laws by name.
    curve, contact_point, shift_origin, baseline
        As for :func:`fit`.
    free : sequence of str, or mapping of str to pair of quantities or None
        Unknowns; every law uses those that it has.

    Returns
    -------
    LawComparison
        Over ``law``, the most likely first: weight, difference of AICc, and claim; ``fits`` has the fit of every law.

    Raises
    ------
    ProblemError
        If fewer than two laws are given, none can be fitted, or one has none of the unknowns.

    See Also
    --------
    fit : one law.

    Notes
    -----
    A fit takes the jumps into and out of contact from the record; a comparison uses those of the law, which is refitted so that its misfit
    is least: a JKR contact separates at a larger distance than it forms, a DMT contact does not. Samples adjacent to a jump of any law are not counted.

    AICc = n log(S/n) + 2 k + 2 k (k + 1)/(n - k - 1), with the sum of squares S over the samples that all fits use, k numbers and
    the noise, and n independent samples: those of the law that leaves the least correlated differences. Akaike's weights are
    exp(-difference/2) over their sum (Burnham and Anderson 2002, sections 2.4 and 2.9). They compare the given laws only; all of
    them may be wrong. An adhesion that the record does not show is refused by :func:`fit` and listed in `refusals`.

    References
    ----------
    Burnham and Anderson (2002), Model Selection and Multimodel Inference, 2nd ed., Springer.

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> depth = np.linspace(-1e-6, 1e-6, 101)
    >>> noise = 1e-11 * np.random.default_rng(1).normal(size=depth.size)
    >>> curve = mdr.MeasuredCurve(force=4e3 * np.maximum(depth, 0.0) ** 2 + noise, indentation=depth)
    >>> gel = mdr.Elastic("10 kPa", 0.5)
    >>> mdr.compare_laws({"ball": mdr.Contact(mdr.Paraboloid("5 um"), gel), "cone": mdr.Contact(mdr.Cone(slope=0.5), gel)}, curve, ["body.young"]).best
    'cone'
    """
    if not isinstance(contacts, Mapping) or len(contacts) < 2:
        raise ProblemError(
            "at least two laws are needed, such as {'Hertz': Contact(...), 'JKR': Contact(...)}"
        )
    known = {"contact_point": contact_point, "shift_origin": shift_origin, "baseline": baseline}
    fits, refusals = _fits_of(contacts, curve, free, known)
    if not fits:
        raise ProblemError(f"no law can be fitted: {'; '.join(refusals.values())}")
    against = {name: judged(one) for name, one in fits.items()}
    used = np.logical_and.reduce([one.used for one in against.values()])
    n = used.sum() / min(one.correlated for one in fits.values())
    criteria = {
        name: aicc(float((one.residuals[used] ** 2).mean()), n, len(fits[name].values))
        for name, one in against.items()
    }
    return LawComparison(
        data=_weighed(fits, criteria),
        fits=fits,
        refusals=refusals,
        references=tuple(
            dict.fromkeys([*(key for one in fits.values() for key in one.references), "akaike"])
        ),
        samples=int(used.sum()),
        notes=(
            (f"the weights are those of the fitted laws only; not weighed: {', '.join(refusals)}",)
            if refusals
            else ()
        ),
    )


def _fits_of(
    contacts: Mapping[str, Contact],
    curve: MeasuredCurve | xr.Dataset | Sequence[MeasuredCurve] | Sequence[xr.Dataset],
    free: Sequence[str] | Mapping[str, ArrayQuantityLike | None],
    known: Mapping[str, QuantityLike | None],
) -> tuple[dict[str, FitResult], dict[str, str]]:
    """The fits by law, and the messages of the laws that could not be fitted."""
    fits: dict[str, FitResult] = {}
    refusals: dict[str, str] = {}
    for name, contact in contacts.items():
        own = {p.name for p in parameters_of(contact)}
        taken = [key for key in free if key in own or key == TILT]
        if not own.intersection(taken):
            raise ProblemError(
                f"{name} has none of the parameters {', '.join(free)}; leave this law out, or free one of its parameters"
            )
        try:
            fits[name] = fit(
                contact,
                curve,
                {key: free[key] for key in taken} if isinstance(free, Mapping) else taken,
                contact_point=known["contact_point"],
                shift_origin=known["shift_origin"],
                baseline=known["baseline"],
            )
        except PymdrError as error:
            refusals[name] = str(error)
    return fits, refusals


def _weighed(fits: Mapping[str, FitResult], criteria: Mapping[str, float]) -> xr.Dataset:
    """The laws with their weights, the most likely first."""
    order = sorted(criteria, key=lambda name: criteria[name])
    above = np.array([criteria[name] for name in order])
    above -= above[0]
    likely = np.exp(-0.5 * above)
    columns = {
        "weight": likely / likely.sum(),
        "difference": above,
        "claim": [fits[name].claims[fits[name].force].level.value for name in order],
        "not_met": [", ".join(a.description for a in fits[name].assumptions if not a.met) for name in order],
    }
    return xr.Dataset(
        {name: ("law", values, {"units": ""}) for name, values in columns.items()}, coords={"law": order}
    )
