"""Hardness and modulus from unloading curves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from pymdr.deferred import mpl, xr
from pymdr.errors import ProblemError
from pymdr.interpretation.validity import SOURCES, Assumption, BoolArray, Claim, Level
from pymdr.presentation import plot
from pymdr.problem.materials import Material
from pymdr.problem.profiles import AreaFunction
from pymdr.solving.nanoindentation.analysing import (
    PROCEDURES,
    UNITS,
    Indent,
    Settings,
    common_priors,
    evaluated,
    whiteness,
)
from pymdr.solving.nanoindentation.arguments import Known, settings_of
from pymdr.solving.nanoindentation.calibrating import DIAMOND, AreaCalibration
from pymdr.solving.nanoindentation.records import Record, Records, attempted, numbered, records_of, refusals
from pymdr.solving.nanoindentation.unloading import fit_limits, forces
from pymdr.solving.study import Column, Study, dataset
from pymdr.units import FloatArray, QuantityLike, written

_PILE_UP, _EXPONENT, _RISING = 0.7, 0.55, 1.01
_DRAWN = 6
_CORRELATED, _MISFIT = 3.0, 1e-4
"""Rows, and misfit in parts of the largest force, from which correlated residuals are attributes."""


@dataclass(frozen=True, kw_only=True)
class Nanoindentation(Study):
    """
    Hardness and moduli of indents, over ``indent`` and ``procedure``: ``power_law`` and ``effective_shape``.

    ``stiffness`` (N/m), ``epsilon``, ``max_depth``, ``residual_depth``, ``contact_depth`` (m), ``exponent``, ``contact_area`` (m^2),
    ``hardness``, ``reduced_modulus``, ``plane_strain_modulus`` and ``young_modulus`` (Pa), each with the ends of its 95 % interval, such
    as ``hardness_low`` and ``hardness_high``; ``peak_force`` (N) over ``indent``.
    """

    indents: tuple[Indent, ...]
    """The unloading rows, and the curves fitted to them, of the indents that could be evaluated."""

    subject: ClassVar[str] = "a nanoindentation"
    claims_of_rows: ClassVar[bool] = False
    columns: ClassVar[Mapping[str, Column]] = {
        "indent": Column("indent", ""),
        "record": Column("record", ""),
        "procedure": Column("procedure", ""),
        "peak_force": Column("F", "N"),
        "stiffness": Column("S", "N/m"),
        "stiffness_low": Column("S low", "N/m"),
        "stiffness_high": Column("S high", "N/m"),
        "contact_depth": Column("h_c", "m"),
        "epsilon": Column("epsilon", ""),
        "hardness": Column("H", "Pa"),
        "hardness_low": Column("H low", "Pa"),
        "hardness_high": Column("H high", "Pa"),
        "reduced_modulus": Column("E_r", "Pa"),
        "young_modulus": Column("E", "Pa"),
        "young_modulus_low": Column("E low", "Pa"),
        "young_modulus_high": Column("E high", "Pa"),
    }

    def _remarks(self) -> list[str]:
        attributes = self.data.attrs
        return [
            f"frame compliance {written(attributes['frame_compliance'], 'm/N')}, beta = {attributes['beta']:g} (effective shape: 1); low and high "
            "are ends of 95 % intervals"
        ]

    def _figure(self) -> mpl.figure.Figure:
        """Unloading curves with what is fitted to them, and the moduli of both procedures."""
        drawn = [
            (
                indent.rows.depth,
                indent.rows.force,
                {
                    name: forces(result.shape.parameters, result.shape.anchor - indent.rows.depth)
                    for name, result in indent.by.items()
                },
            )
            for indent in self.indents[:_DRAWN]
        ]
        return plot.indent_study(drawn, self.data)


def oliver_pharr(
    records: Records,
    area: AreaFunction | AreaCalibration,
    *,
    frame_compliance: QuantityLike | None = None,
    tip: Material = DIAMOND,
    poisson: QuantityLike | None = None,
    beta: float = 1.0,
    epsilon: float | None = 0.75,
    fit_range: Sequence[float] = (0.25, 0.98),
) -> Nanoindentation:
    """
    Hardness and modulus from the unloading of indents, by Oliver and Pharr and by the method itself.

    The power law F = B (h - h_f)^m through a range of the unloading gives the stiffness S = dF/dh at the largest force, the contact
    depth h_c = h - epsilon F/S, the hardness F/A(h_c) and the reduced modulus S sqrt(pi/A)/(2 beta). The other procedure fits two powers to
    the complete unloading: they are the line of a profile, the effective shape of the unloading, of which S = 2 E* a, and
    h - h_c = d - f(a) = (2/pi) int_0^d arcsin(k(t)/k(d)) dt with the stiffness k. It needs no epsilon and no beta.

    Parameters
    ----------
    records : MeasuredCurve, xarray.Dataset or mapping of str to array_like, a sequence of them, or ThermalDrift
        Indents with their unloading, such as of :func:`pymdr.read_record`. Depths count from the first contact. Those that
        :func:`pymdr.thermal_drift` corrected bring the uncertainty of their rates.
    area : AreaFunction or AreaCalibration
        Area function of the tip. That of :func:`pymdr.calibrate_area` brings its frame compliance and its uncertainty.
    frame_compliance : quantity, optional
        In m/N, such as ``"0.3 nm/mN"``; 0 unless given. It must be left out with a calibration.
    tip : Elastic or Rigid, optional
        Diamond, 1141 GPa and 0.07, unless given.
    poisson : quantity, optional
        Poisson's ratio of the sample; without it there is no Young's modulus, only E/(1 - nu^2).
    beta : float, optional
        Correction of the power-law procedure for tips that are not of revolution. King (1987) has 1.034 for a triangular punch, and 1.02 to
        1.08 are in use for Berkovich tips (Oliver and Pharr 2004). Use the value with which the area function was calibrated.
    epsilon : float, optional
        The constant of the power-law procedure; None derives it from the fitted exponent (Pharr and Bolshakov 2002).
    fit_range : sequence of two floats, optional
        Range of the power law, as fractions of the largest force.

    Returns
    -------
    Nanoindentation
        Both procedures side by side. Intervals of 95 % come from the scatter of the rows and, if there is one, from the calibration. Of several
        indents, those that cannot be evaluated are nan, and a note gives the reason.

    Raises
    ------
    ProblemError
        If no record has an unloading, or an area at its contact depth, or an argument is outside its limits.

    See Also
    --------
    calibrate_area : area function and frame compliance.
    thermal_drift : records without their drift.
    continuous_stiffness : hardness and modulus over depth.

    Notes
    -----
    The procedure of Oliver and Pharr (1992, 2004), with the factor of King (1987). An unloading curve does not show pile-up:
    the true area may be up to 60 % larger where the residual depth is above 0.7 of the largest one (Bolshakov and Pharr 1998), and hardness and modulus are then too large.

    References
    ----------
    - Oliver and Pharr (1992), J. Mater. Res. 7, 1564-1583, doi:10.1557/JMR.1992.1564.
    - Oliver and Pharr (2004), J. Mater. Res. 19, 3-20.
    - King (1987), Int. J. Solids Struct. 23, 1657-1664.
    - Pharr and Bolshakov (2002), J. Mater. Res. 17, 2660-2671, doi:10.1557/JMR.2002.0386.
    - Bolshakov and Pharr (1998), J. Mater. Res. 13, 1049-1058, doi:10.1557/JMR.1998.0146.

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> tip = mdr.AreaFunction([24.5], unit="1 nm")
    >>> depth = np.concatenate([np.linspace(0, 500, 200), np.linspace(500, 430, 200)]) * 1e-9
    >>> force = np.concatenate([np.linspace(0, 1, 200) ** 2, np.linspace(1, 0, 200) ** 1.5]) * 50e-3
    >>> study = mdr.oliver_pharr(mdr.MeasuredCurve(force=force, indentation=depth), tip, poisson=0.3)
    >>> study.to("hardness", "GPa").sel(procedure="power_law").values.round(3)
    array([9.438])
    >>> study["epsilon"].sel(procedure="effective_shape").values.round(3)
    array([0.75])
    """
    listed = records_of(records)
    known = Known(area, frame_compliance, tip, poisson, beta, epsilon)
    settings = settings_of(known, fit_limits(fit_range))
    indents, refused = _evaluated(listed, settings)
    evaluable = [number in indents for number in range(1, len(listed) + 1)]
    known_indents = tuple(indents.values())
    return Nanoindentation(
        data=_data(listed, np.array(evaluable), known_indents, settings),
        claims=_claims(np.repeat(evaluable, len(PROCEDURES)), settings),
        assumptions=_assumptions(known_indents),
        notes=(*refused, *_notes(indents)),
        references=("oliver-pharr", "pharr-bolshakov", "bolshakov-pharr", "popov-hess"),
        indents=known_indents,
    )


def _evaluated(listed: Sequence[Record], settings: Settings) -> tuple[dict[int, Indent], list[str]]:
    """The indents that can be evaluated, by their numbers, and why others cannot."""
    errors: dict[int, ProblemError] = {}
    white = attempted(
        listed,
        lambda _, record: whiteness(record, settings.frame, settings.limits),
        errors,
    )
    priors = dict(zip(white, common_priors(list(white.values())), strict=True))
    indents = attempted(
        listed,
        lambda number, record: evaluated(record, settings, priors[number]),
        errors,
    )
    return indents, refusals(errors)


def _data(
    listed: Sequence[Record], evaluable: BoolArray, indents: Sequence[Indent], settings: Settings
) -> xr.Dataset:
    both = [[indent.by[name] for name in PROCEDURES] for indent in indents]
    peaks = np.full(evaluable.size, np.nan)
    peaks[evaluable] = [indent.rows.peak_force for indent in indents]
    columns: dict[str, tuple[FloatArray, str]] = {}
    for name in both[0][0].values:
        for end in ("values", "low", "high"):
            numbers = np.full((evaluable.size, len(PROCEDURES)), np.nan)
            numbers[evaluable] = [[getattr(result, end)[name] for result in row] for row in both]
            columns[name if end == "values" else f"{name}_{end}"] = (numbers, UNITS[name])
    return dataset(
        {
            "peak_force": ("indent", peaks, {"units": "N"}),
            **{
                name: (("indent", "procedure"), values, {"units": unit})
                for name, (values, unit) in columns.items()
            },
        },
        coords={
            **numbered(listed),
            "procedure": ("procedure", list(PROCEDURES), {"units": ""}),
        },
        attrs={"frame_compliance": settings.frame, "beta": settings.beta},
    )


def _claims(evaluable: BoolArray, settings: Settings) -> dict[str, Claim]:
    depths = Claim(
        Level.APPROXIMATE,
        "from curves fitted to the unloading, which is assumed to be elastic; the intervals cover the scatter of the rows only",
        SOURCES["oliver-pharr"],
        evaluable,
    )
    areas = Claim(
        Level.APPROXIMATE,
        "by the area function at the contact depth: the surface sinks in as that of an elastic body and does not pile up",
        f"{SOURCES['oliver-pharr']}; {SOURCES['bolshakov-pharr']}",
        evaluable,
    )
    with_area = ("contact_area", "hardness", "reduced_modulus", "plane_strain_modulus", "young_modulus")
    claims = {name: areas if name in with_area else depths for name in UNITS}
    if settings.poisson is None:
        reason = "Poisson's ratio of the sample is not known; give poisson"
        claims["young_modulus"] = Claim(
            Level.NOT_VALID, reason, SOURCES["oliver-pharr"], np.zeros_like(evaluable)
        )
    return claims


def _assumptions(indents: Sequence[Indent]) -> tuple[Assumption, ...]:
    laws = [indent.by["power_law"] for indent in indents]
    return (
        Assumption(
            "pile-up",
            "residual depth over the largest depth; above the limit the surface may pile up, which an unloading curve does not show",
            max(law.values["residual_depth"] / law.values["max_depth"] for law in laws),
            _PILE_UP,
        ),
        Assumption(
            "exponent",
            "distance of the unloading exponent from 1.5; that of elastic contacts lies between 1 (flat punch) and 2 (cone)",
            max(abs(law.values["exponent"] - 1.5) for law in laws),
            _EXPONENT,
        ),
        Assumption(
            "effective shape",
            "largest stiffness of the fitted unloading over that at the largest force; it rises with the depth in elastic contacts",
            max(indent.by["effective_shape"].peak.rising for indent in indents),
            _RISING,
        ),
    )


def _notes(indents: Mapping[int, Indent]) -> tuple[str, ...]:
    shapes = [result.shape for indent in indents.values() for result in indent.by.values()]
    largest = max((shape.errors.correlated for shape in shapes if shape.misfit > _MISFIT), default=1.0)
    notes = []
    if largest > _CORRELATED:
        notes.append(
            f"residuals of a fit are correlated over up to {largest:.0f} rows; the intervals are widened for it, not for a curve of another form"
        )
    single = [i for i, indent in indents.items() if indent.by["effective_shape"].shape.parameters.size == 3]
    if single:
        numbers = ", ".join(map(str, single[:10]))
        notes.append(
            f"the noise of the unloading allows a fit of one power only: effective shape of indent {numbers}"
        )
    return tuple(notes)
