"""``pymdr curves``: what is in a file of force curves, with baselines and contact points."""

from __future__ import annotations

from collections.abc import Iterable, Sized
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pymdr.workbench.cli.folders import ready_folder, write_figure
from pymdr.workbench.cli.options import Json, Quiet
from pymdr.workbench.cli.telling import answer, failures_as_json, print_json, say, say_written

if TYPE_CHECKING:
    from pymdr.solving.curves import ContactPoint, MeasuredCurve


def curves(
    file: Annotated[
        Path,
        typer.Argument(metavar="FILE", help="Of an atomic force microscope, or a table with units."),
    ],
    spring_constant: Annotated[
        str | None,
        typer.Option(
            help="Of the cantilever or the machine, where the file has none or a wrong one, such as '0.1 N/m'."
        ),
    ] = None,
    leave_out_missing: Annotated[
        bool, typer.Option("--leave-out-missing", help="Leave out samples without a number, and say so.")
    ] = False,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o",
            "--output",
            metavar="DIR",
            help="Folder for a figure of each record; nothing is written unless given.",
        ),
    ] = None,
    quiet: Quiet = False,
    as_json: Json = False,
) -> None:
    """List the segments of measured force curves with their baselines and contact points by several methods."""
    from pymdr.workbench.curves import read_curves

    with failures_as_json("curves", file, as_json):
        found = read_curves(file, spring_constant=spring_constant, leave_out_missing=leave_out_missing)
        records = [_Record(segments) for segments in _by_record(found)]
        written = []
        if output is not None:
            with ready_folder(output) as folder:
                for record in records:
                    name = "curve.png" if len(records) == 1 else f"curve_{record.number}.png"
                    written.append(write_figure(record.plot(), folder / name))
    if as_json:
        rows = sum(one.force.size for one in found)
        plain = [record.plain() for record in records]
        print_json(answer("curves", file, written, status="COMPLETED", rows=rows, curves=plain))
    elif not quiet:
        say(f"{file}: {_counted(found, 'segment')} of {_counted(records, 'record')}")
        for record in records:
            say("\n" + record.summary())
        say_written(written)


def _by_record(curves: Iterable[MeasuredCurve]) -> list[tuple[MeasuredCurve, ...]]:
    records: dict[float, list[MeasuredCurve]] = {}
    for curve in curves:
        records.setdefault(float(curve.metadata["record"]), []).append(curve)
    return [tuple(segments) for segments in records.values()]


class _Record:
    """The segments of a record in the signs of pymdr, with what was found in its approach, or why nothing was."""

    def __init__(self, segments: tuple[MeasuredCurve, ...]) -> None:
        from pymdr.errors import ProblemError

        self.number = int(segments[0].metadata["record"])
        self.point: ContactPoint | None = None
        self.refusal = self.signs = ""
        turned = [one.mark_outliers() for one in segments]
        try:
            signs = turned[0].join(*turned[1:]).orient().step
            assert signs is not None
            turned = [one.orient(signs.numbers) for one in turned]
            self.signs = str(signs)
        except ProblemError as error:
            self.signs = f"signs: as they were read; {error}"
        self.segments = [one.mark_saturated() for one in turned]
        approach = next((one for one in self.segments if one.segment == "approach"), None)
        if approach is None:
            self.refusal = "no segment is an approach: the contact point is looked for there"
            return
        try:
            self.point = approach.contact_point()
        except ProblemError as error:
            self.refusal = str(error)

    def summary(self) -> str:
        """The segments, a line each, and what was found."""
        lines = [f"record {self.number}{self._place()}"]
        lines += [*("  " + _told(one) for one in self.segments), f"  {self.signs}"]
        lines += [
            f"    {step}"
            for one in self.segments
            for step in one.steps
            if step.name != "signs" and step.numbers.get("count") != 0.0
        ]
        found = self.refusal if self.point is None else self.point.summary()
        return "\n".join([*lines, *("  " + line for line in found.split("\n"))])

    def plain(self) -> dict[str, Any]:
        """All of it, for JSON."""
        point = self.point
        return {
            "record": self.number,
            "metadata": dict(self.segments[0].metadata),
            "segments": [
                {
                    "segment": one.segment,
                    "samples": one.force.size,
                    "spring_constant": one.spring_constant,
                    "position": [float(one.position[0]), float(one.position[-1])],
                    "force": [float(one.force.min()), float(one.force.max())],
                    "steps": [str(step) for step in one.steps],
                }
                for one in self.segments
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
                    name: {"value": one.value, "low": one.low, "high": one.high}
                    for name, one in point.methods.items()
                },
            },
            "signs": self.signs,
            "refusal": self.refusal or None,
        }

    def plot(self) -> Any:
        """The record, with its baseline and contact points where they were found."""
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


def _counted(what: Sized, word: str) -> str:
    return f"{len(what)} {word}{'' if len(what) == 1 else 's'}"


def _told(curve: MeasuredCurve) -> str:
    from pymdr.units import written

    name = "travel" if curve.indentation is None else "indentation"
    words = [
        f"{curve.segment:<8}",
        f"{curve.force.size} samples",
        f"{name} {written(float(curve.position[0]), 'm')} to {written(float(curve.position[-1]), 'm')}",
        f"force {written(float(curve.force.min()), 'N')} to {written(float(curve.force.max()), 'N')}",
    ]
    if curve.time is not None:
        words.insert(2, f"{written(float(curve.time[-1] - curve.time[0]), 's')}")
    if curve.spring_constant is not None:
        words.append(f"spring {written(curve.spring_constant, 'N/m')}")
    return ", ".join(words)
