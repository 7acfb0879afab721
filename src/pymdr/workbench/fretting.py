"""From a record of fretting to friction, stiffness, slip regime and wear rate of its cycles."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from pymdr.deferred import mpl, xr
from pymdr.errors import ProblemError
from pymdr.problem.contact import Contact
from pymdr.problem.laws import Coulomb
from pymdr.result import Result
from pymdr.solving.loops import friction_loop, loops_at_loads
from pymdr.solving.study import Column, Study, over_rows
from pymdr.units import FloatArray, QuantityLike, newtons, shown, to_si, written
from pymdr.workbench.records import backward_loops, measured_loops, refuse_without_shift

_HERTZ = 0.2
"""Energy ratio W/(4 F u) of a paraboloid at the limit of gross slip, 8 (1 - 2/5) - 4 over 4."""
_BAND = 0.15
"""Around the limit, relative to it: the cycles in between are mixed."""
_STRAIGHT = 0.6
"""Part of the swing of the force over which the stiffness after a turn is fitted."""
_GIVEN = 0.05
"""Energy ratio of a cycle above which energy that it gives is no noise."""
_LARGEST_FRICTION = 100.0
"""Largest friction coefficient of a record whose units are right."""
_SMALLEST_FRICTION = 1e-3
"""Friction coefficient of gross slip below which a wrong unit is more likely than friction."""
_FEWEST = 4
_DRAWN = 12
_REPORTED = 100
"""Number of cycles between two reports of progress."""
_NOT_SHOWN = {"normal_force": Column("load", "N"), "model_force": Column("of the model", "N")}


@dataclass(frozen=True, kw_only=True)
class FrettingLog(Study):
    """Cycles of a record of fretting, by :func:`fretting_log`."""

    data: xr.Dataset
    """
    Over ``cycle``: amplitude (m), force_amplitude (N), dissipated_per_cycle (J), tangential_stiffness (N/m) after the turns, energy_ratio
    and regime ("partial", "mixed" or "gross"); with a load normal_force (N) and friction_coefficient, the largest force over it; with a
    contact also model_dissipated (J) and model_force (N) of its loop at that amplitude and load.
    """
    loops: tuple[tuple[float, FloatArray, FloatArray], ...]
    """Number, shift in m and force in N of some cycles."""

    subject: ClassVar = "a fretting log"
    columns: ClassVar = {
        "cycle": Column("cycle", ""),
        "amplitude": Column("amplitude", "m"),
        "force_amplitude": Column("force", "N"),
        "friction_coefficient": Column("mu", ""),
        "tangential_stiffness": Column("stiffness", "N/m"),
        "dissipated_per_cycle": Column("dissipated", "J"),
        "energy_ratio": Column("W/(4 F u)", ""),
        "regime": Column("regime", ""),
        "model_dissipated": Column("of the model", "J"),
    }

    def _remarks(self) -> list[str]:
        regimes, counts = np.unique(self.data["regime"].values, return_counts=True)
        counted = ", ".join(f"{kind} {count}" for kind, count in zip(regimes, counts, strict=True))
        lines = [
            f"cycles by regime: {counted}; the limit of gross slip is W/(4 F u) = {self.data.attrs['limit']:.3g}"
        ]
        if "wear_coefficient" in self.data.attrs:
            rate = written(float(self.data.attrs["wear_coefficient"]) * 1e9, "mm^3/J")
            lines.append(f"energy wear coefficient: {rate}")
        return lines

    def _figure(self) -> mpl.figure.Figure:
        """Loops over cycles, friction and stiffness."""
        from pymdr.presentation.plot import fretting_log as draw

        return draw(list(self.loops), self.data)


def fretting_log(
    record: xr.Dataset | Result,
    *,
    contact: Contact | None = None,
    normal_force: QuantityLike | None = None,
    machine_stiffness: QuantityLike | None = None,
    worn_volume: QuantityLike | None = None,
    cycles: float | None = None,
    least: QuantityLike | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> FrettingLog:
    """
    Friction coefficient, tangential stiffness and slip regime of every cycle of a record.

    Parameters
    ----------
    record : xarray.Dataset or Result
        With ``shift`` and ``tangential_force``, as :func:`pymdr.measured_loops` takes it; with ``normal_force`` if it was recorded.
    contact : Contact, optional
        Its loop at every amplitude and load is compared with the record. If it has no friction, the median coefficient of the gross
        cycles is used.
    normal_force : quantity, optional
        Constant load in N, if the record has none.
    machine_stiffness : quantity, optional
        Tangential stiffness k of the machine in N/m; F/k is subtracted from the shift.
    worn_volume : quantity, optional
        Measured worn volume in m^3, from which the energy wear coefficient follows.
    cycles : float, optional
        Number of cycles that caused the worn volume, if the record has only some of them; all are taken to dissipate their mean.
    least : quantity, optional
        As for :func:`pymdr.measured_loops`.
    progress : callable, optional
        Called with the number of finished cycles and their total number.

    Returns
    -------
    FrettingLog
        Over ``cycle``: amplitude (m), force (N), dissipation (J), stiffness (N/m), energy ratio and regime.

    Raises
    ------
    ProblemError
        If the record has no shift and tangential force or no whole cycle, cycles give energy in place of dissipating it, the friction
        coefficient is above 100, a value is not above 0, or a contact is given without load.

    See Also
    --------
    running_conditions : load against amplitude, with the cycles of the record.
    wear : with the coefficient found here.

    Notes
    -----
    The regimes follow from the energy ratio A = W/(4 F u) of dissipation, force and amplitude: A = 0.2 where a paraboloid begins to slip
    everywhere; with a contact, that of its profile; mixed within 15 % of it. The stiffness is that after a turn, from a parabola.

    References
    ----------
    Fouvry, Kapsa and Vincent (1995), Wear 185, 35-46, doi:10.1016/0043-1648(94)06582-9.

    Examples
    --------
    >>> import pymdr as mdr
    >>> ball = mdr.Contact(mdr.Paraboloid("10 mm"), mdr.Elastic("210 GPa", 0.3), friction=mdr.Coulomb(0.5))
    >>> test = mdr.solve(ball, mdr.load("10 N") >> mdr.cycle(shift="2 um", cycles=3, steps=300))
    >>> log = mdr.fretting_log(test)
    >>> log.data["regime"].values.tolist()[-1], round(float(log["friction_coefficient"][-1]), 6)
    ('gross', 0.5)
    """
    data, clean = _read(record, machine_stiffness)
    shift, force = clean["shift"].values, clean["tangential_force"].values
    loops = measured_loops(clean, least=least)
    measured = loops.data
    rows = zip(measured["first_row"].values.tolist(), measured["last_row"].values.tolist(), strict=True)
    spans = [slice(first - 1, last) for first, last in rows]
    columns = _columns(shift, force, measured, spans, progress)
    amplitude, swing, ratio = columns["amplitude"], columns["force_amplitude"], columns["energy_ratio"]
    load = _loads(data, normal_force, spans)
    if load is not None:
        columns |= {"normal_force": load, "friction_coefficient": _coefficients(swing, load)}
    limit = _HERTZ
    if contact is not None:
        limit, model = _model(contact, amplitude, load, ratio, swing)
        columns |= model
    columns["regime"] = _regimes(ratio, limit)
    attrs = {"limit": limit}
    if cycles is not None and worn_volume is None:
        raise ProblemError(
            "cycles is the number of cycles that caused worn_volume; give worn_volume too, or leave cycles out"
        )
    if worn_volume is not None:
        attrs["wear_coefficient"] = _rate(worn_volume, columns["dissipated_per_cycle"], cycles)
    number = measured["cycle"].values
    drawn = np.unique(np.linspace(0, number.size - 1, min(number.size, _DRAWN)).round().astype(int))
    return FrettingLog(
        data=over_rows("cycle", number, columns, FrettingLog.columns | _NOT_SHOWN, attrs),
        contact=contact,
        notes=(*loops.notes, *_friction_notes(columns)),
        loops=tuple((float(number[i]), shift[spans[i]], force[spans[i]]) for i in drawn),
    )


def _columns(
    shift: FloatArray,
    force: FloatArray,
    measured: xr.Dataset,
    spans: list[slice],
    progress: Callable[[int, int], None] | None,
) -> dict[str, FloatArray]:
    """The numbers of every cycle that need no load."""
    amplitude, loss = measured["amplitude"].values, measured["dissipated_per_cycle"].values
    swing = np.array([0.5 * np.ptp(force[span]) for span in spans])
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = loss / (4.0 * swing * amplitude)
    _refuse_given_energy(loss, ratio)
    return {
        "amplitude": amplitude,
        "force_amplitude": swing,
        "dissipated_per_cycle": loss,
        "tangential_stiffness": _stiffnesses(shift, force, spans, progress),
        "energy_ratio": ratio,
    }


def _read(
    record: xr.Dataset | Result, machine_stiffness: QuantityLike | None
) -> tuple[xr.Dataset, xr.Dataset]:
    """A record, and its shift and force in SI units without the deflection of the machine."""
    data = record.data if isinstance(record, Result) else record
    if isinstance(data, xr.Dataset):
        refuse_without_shift(data)
    if not isinstance(data, xr.Dataset) or "tangential_force" not in data:
        raise ProblemError("a record with shift and tangential_force is needed, such as read_record returns")
    shift, force = _column(data, "shift", "m"), _column(data, "tangential_force", "N")
    if machine_stiffness is not None:
        shift = shift - force / _above_zero("machine_stiffness", machine_stiffness, "N/m")
    dim = data["shift"].dims
    columns = {"shift": (dim, shift, {"units": "m"}), "tangential_force": (dim, force, {"units": "N"})}
    return data, xr.Dataset(columns)


def _regimes(ratio: FloatArray, limit: float) -> np.ndarray:
    """The regime of slip of every cycle by its energy ratio."""
    bounds = [~np.isfinite(ratio), ratio < limit * (1.0 - _BAND), ratio > limit * (1.0 + _BAND)]
    return np.select(bounds, ["unknown", "partial", "gross"], "mixed")


def _column(data: xr.Dataset, name: str, unit: str) -> FloatArray:
    own = data[name].attrs.get("units", unit)
    return to_si(f"1 {own}", unit, name=name) * np.asarray(data[name].values, dtype=float)


def _above_zero(name: str, given: QuantityLike, unit: str) -> float:
    value = to_si(given, unit, name=name)
    if not value > 0.0:
        raise ProblemError(f"{name} = {shown(given)}; it must be above 0 {unit}")
    return value


def _loads(data: xr.Dataset, given: QuantityLike | None, spans: list[slice]) -> FloatArray | None:
    """Mean load in N of every cycle."""
    if given is not None:
        return np.full(len(spans), _above_zero("normal_force", given, "N"))
    if "normal_force" not in data:
        return None
    force = _column(data, "normal_force", "N")
    loads = np.array([float(np.mean(force[span])) for span in spans])
    loaded = np.isfinite(loads) & (loads > 0.0)
    if not loaded.all():
        row = int(np.argmin(loaded)) + 1
        raise ProblemError(
            f"the mean normal force of cycle {row} is {loads[row - 1]:.4g} N, and it must be above 0 N and finite; check the sign "
            "and that the columns of both forces are not interchanged"
        )
    return loads


def _refuse_given_energy(loss: FloatArray, ratio: FloatArray) -> None:
    """Refuse a record whose cycles give more energy than noise does."""
    if np.all(np.isnan(loss)):
        raise ProblemError("the record ends before its only cycle closes; give two cycles or a longer record")
    given = backward_loops("shift", "tangential_force", loss)
    if given and np.nanmedian(ratio) < -_GIVEN:
        raise ProblemError(str(given[0]))


def _coefficients(swing: FloatArray, load: FloatArray) -> FloatArray:
    """Friction coefficients of cycles, refused where only a wrong unit explains them."""
    coefficients = swing / load
    median = float(np.median(coefficients))
    if median > _LARGEST_FRICTION:
        raise ProblemError(
            f"the median friction coefficient of the cycles is {median:.4g} (limit {_LARGEST_FRICTION:g}), of forces of "
            f"{newtons(float(np.median(swing)))} under loads of {newtons(float(np.median(load)))}; correct the unit of the force or of the load"
        )
    return coefficients


def _friction_notes(columns: dict[str, FloatArray]) -> tuple[str, ...]:
    """What the friction coefficients of a record are not."""
    if "friction_coefficient" not in columns:
        return ()
    notes, slides = [], columns["regime"] == "gross"
    if not slides.all():
        notes.append(
            f"mu is a lower limit in {np.sum(~slides)} of {slides.size} cycles: not all of the contact slips there"
        )
    if slides.any():
        median = float(np.median(columns["friction_coefficient"][slides]))
        if median < _SMALLEST_FRICTION:
            force, load = (
                float(np.median(columns[name][slides])) for name in ("force_amplitude", "normal_force")
            )
            notes.append(
                f"mu of the gross cycles is {median:.2g} (usually above {_SMALLEST_FRICTION:g}), of forces of {newtons(force)} under loads of "
                f"{newtons(load)}; correct the unit of the force or of the load if it is wrong"
            )
    return tuple(notes)


def _stiffnesses(
    shift: FloatArray, force: FloatArray, spans: list[slice], progress: Callable[[int, int], None] | None
) -> FloatArray:
    """The tangential stiffness of every cycle in N/m."""
    stiffness = np.empty(len(spans))
    for i, span in enumerate(spans):
        stiffness[i] = _stiffness(shift[span], force[span])
        if progress is not None and (i + 1) % _REPORTED == 0:
            progress(i + 1, len(spans))
    if progress is not None:
        progress(len(spans), len(spans))
    return stiffness


def _stiffness(shift: FloatArray, force: FloatArray) -> float:
    """Slope of the force in N/m after the turns of a cycle: of parabolas of the shift over the force."""
    middle = int(np.argmax(np.abs(shift - shift[0])))
    slopes = []
    for u, f in ((shift[: middle + 1], force[: middle + 1]), (shift[middle:], force[middle:])):
        turned = f - f[0]
        swing = float(np.ptp(f))
        near = np.abs(turned) <= _STRAIGHT * swing
        # only up to where it is exceeded first
        near[int(np.argmin(near)) :] = near.all()
        if near.sum() < _FEWEST or swing == 0.0:
            continue
        x = turned[near] / swing
        fitted = np.linalg.lstsq(
            np.stack([x, x * np.abs(x), np.ones(x.size)], axis=1), u[near] - u[0], rcond=None
        )[0]
        if fitted[0] > 0.0:
            slopes.append(swing / fitted[0])
    return float(np.mean(slopes)) if slopes else math.nan


def _model(
    contact: Contact, amplitude: FloatArray, load: FloatArray | None, ratio: FloatArray, swing: FloatArray
) -> tuple[float, dict[str, FloatArray]]:
    """The energy ratio of a contact at the limit of gross slip, and its loops at the amplitudes and loads of cycles."""
    from dataclasses import replace

    if load is None:
        raise ProblemError("a contact needs the load; give normal_force, or a record that has it")
    if contact.friction is None:
        slides = ratio > _HERTZ * (1.0 + _BAND)
        if not slides.any():
            raise ProblemError(
                "no cycle slides grossly, so the record does not give mu; give Contact(..., friction=Coulomb(mu))"
            )
        contact = replace(contact, friction=Coulomb(float(np.median((swing / load)[slides]))))
    at_limit = friction_loop(contact, float(amplitude[0]), normal_force=float(np.mean(load)))
    edge = friction_loop(
        contact, float(at_limit.data["sliding_shift"]), normal_force=float(np.mean(load))
    ).data
    limit = float(
        (edge["dissipated_per_cycle"] / (4.0 * edge["force_amplitude"] * edge["amplitude"])).values[0]
    )
    forces, losses = loops_at_loads(contact, amplitude, load)
    return limit, {"model_dissipated": losses, "model_force": forces}


def _rate(worn_volume: QuantityLike, loss: FloatArray, cycles: float | None) -> float:
    """Energy wear coefficient in m^3/J."""
    volume = _above_zero("worn_volume", worn_volume, "m^3")
    if cycles is not None and not cycles > 0.0:
        raise ProblemError(f"cycles = {cycles!r}; it must be above 0")
    total = float(loss.sum()) if cycles is None else float(loss.mean()) * cycles
    if not total > 0.0:
        raise ProblemError(
            f"the cycles dissipate {total:.4g} J in all, which must be above 0 J for a wear rate"
        )
    return volume / total
