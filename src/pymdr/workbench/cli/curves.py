"""``pymdr curves``: segments, baselines and contact points of measured force curves."""

from __future__ import annotations

from collections.abc import Iterable, Sized
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pymdr.errors import ProblemError
from pymdr.workbench.cli.folders import ready_folder, write_figure
from pymdr.workbench.cli.options import Json, KeepSigns, LeaveOut, Quiet, Sensitivity, with_uncertainty
from pymdr.workbench.cli.reporting import failures_as_json, print_json, print_text, print_written, report

if TYPE_CHECKING:
    from pymdr.solving.curves import ContactPoint, MeasuredCurve


def curves(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="Force curves of an AFM or indenter, a table with units, or an archive .zip of them.",
        ),
    ],
    spring_constant: Annotated[
        str | None,
        typer.Option(help="Spring constant of cantilever or machine, such as '0.1 N/m'; overrides the file."),
    ] = None,
    sensitivity: Sensitivity = None,
    leave_out_missing: LeaveOut = False,
    keep_signs: KeepSigns = False,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="DIR",
            help="Folder for a figure per record; by default nothing is written.",
        ),
    ] = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """List segments, baselines and contact points of force curves."""
    from pymdr.workbench.curves import read_curves

    with failures_as_json("curves", file, as_json):
        _refuse_uncertainty("--spring-constant", spring_constant)
        _refuse_uncertainty("--sensitivity", sensitivity)
        segments_read = read_curves(
            file,
            spring_constant=spring_constant,
            sensitivity=sensitivity,
            leave_out_missing=leave_out_missing,
            keep_signs=keep_signs or None,
        )
        records = [_Record(segments, keep_signs) for segments in _by_record(segments_read)]
        written = []
        if output is not None:
            with ready_folder(output) as folder:
                for record in records:
                    name = "curve.png" if len(records) == 1 else f"curve_{record.number}.png"
                    written.append(write_figure(record.plot(), folder / name))
    if as_json:
        rows = sum(segment.force.size for segment in segments_read)
        plain = [record.plain() for record in records]
        print_json(report("curves", file, written, status="COMPLETED", rows=rows, curves=plain))
    elif not quiet:
        print_text(f"{file}: {_counted(segments_read, 'segment')} of {_counted(records, 'record')}")
        for record in records:
            print_text("\n" + record.summary())
        print_written(written)


def _refuse_uncertainty(option: str, given: str | None) -> None:
    value, uncertainty = with_uncertainty(given or "")
    if uncertainty is not None:
        raise ProblemError(
            f"{option} {given}: segments and contact points have no interval that an uncertainty of {uncertainty} enters; write {option} "
            f"'{value}' here, and give the uncertainty to `pymdr fit`, there or as --uncertainty"
        )


def _by_record(curves: Iterable[MeasuredCurve]) -> list[tuple[MeasuredCurve, ...]]:
    records: dict[float, list[MeasuredCurve]] = {}
    for curve in curves:
        records.setdefault(float(curve.metadata["record"]), []).append(curve)
    return [tuple(segments) for segments in records.values()]


class _Record:
    """The segments of a record in the signs of pymdr, with the contact point of its approach or the reason for none."""

    def __init__(self, segments: tuple[MeasuredCurve, ...], keep_signs: bool) -> None:
        self.number = int(segments[0].metadata["record"])
        self.point: ContactPoint | None = None
        self.refusal = self.signs = ""
        oriented = [segment.mark_outliers() for segment in segments]
        try:
            signs = oriented[0].join(*oriented[1:]).orient(keep_signs=keep_signs or None).step
            assert signs is not None
            oriented = [segment.orient(signs.numbers) for segment in oriented]
            own = [step for segment in segments for step in segment.steps if step.name == "signs"]
            self.signs = str(own[0] if own else signs)  # of a table that was turned when it was read
        except ProblemError as error:
            self.signs = f"signs: unchanged; {error}"
        self.segments = [segment.mark_saturated() for segment in oriented]
        approach = next((segment for segment in self.segments if segment.segment == "approach"), None)
        if approach is None:
            self.refusal = "no contact point: the record has no approach"
            return
        try:
            self.point = approach.contact_point()
        except ProblemError as error:
            self.refusal = str(error)

    def summary(self) -> str:
        """The segments, one line each, and the contact point."""
        lines = [f"record {self.number}{self._place()}"]
        lines += [*("  " + _segment_text(segment) for segment in self.segments), f"  {self.signs}"]
        lines += [
            f"    {step}"
            for segment in self.segments
            for step in segment.steps
            if step.name != "signs" and step.numbers.get("count") != 0.0
        ]
        contact = self.refusal if self.point is None else self.point.summary()
        return "\n".join([*lines, *("  " + line for line in contact.split("\n"))])

    def plain(self) -> dict[str, Any]:
        """The record as plain values for JSON."""
        point = self.point
        return {
            "record": self.number,
            "metadata": dict(self.segments[0].metadata),
            "segments": [
                {
                    "segment": segment.segment,
                    "samples": segment.force.size,
                    "spring_constant": segment.spring_constant,
                    "position": [float(segment.position[0]), float(segment.position[-1])],
                    "force": [float(segment.force.min()), float(segment.force.max())],
                    "steps": [str(step) for step in segment.steps],
                }
                for segment in self.segments
            ],
            "baseline": None
            if point is None
            else {
                name: getattr(point.baseline, name)
                for name in ("offset", "tilt", "middle", "noise", "samples")
            },
            "contact_point": None
            if point is None
            else {
                "value": point.value,
                "low": point.low,
                "high": point.high,
                "methods": {
                    name: {"value": estimate.value, "low": estimate.low, "high": estimate.high}
                    for name, estimate in point.methods.items()
                },
            },
            "signs": self.signs,
            "refusal": self.refusal or None,
        }

    def plot(self) -> Any:
        """The record, with baseline and contact points if known."""
        from pymdr.presentation.plot import measured_curves

        return measured_curves(self.segments) if self.point is None else self.point.plot(*self.segments)

    def _place(self) -> str:
        from pymdr.units import written

        facts = self.segments[0].metadata
        if "grid index x" in facts and "grid index y" in facts:
            return f", pixel ({facts['grid index x']:g}, {facts['grid index y']:g})"
        if "position x" in facts and "position y" in facts:
            x, y = (written(float(facts[f"position {axis}"]), "m") for axis in "xy")
            return f", at ({x}, {y})"
        return ""


def _counted(items: Sized, noun: str) -> str:
    return f"{len(items)} {noun}{'' if len(items) == 1 else 's'}"


def _segment_text(curve: MeasuredCurve) -> str:
    from pymdr.units import written

    name = "travel" if curve.indentation is None else "indentation"
    parts = [
        f"{curve.segment:<8}",
        f"{curve.force.size} samples",
        f"{name} {written(float(curve.position[0]), 'm')} to {written(float(curve.position[-1]), 'm')}",
        f"force {written(float(curve.force.min()), 'N')} to {written(float(curve.force.max()), 'N')}",
    ]
    if curve.time is not None:
        parts.insert(2, f"{written(float(curve.time[-1] - curve.time[0]), 's')}")
    if curve.spring_constant is not None:
        parts.append(f"spring {written(curve.spring_constant, 'N/m')}")
    return ", ".join(parts)
