"""Options shared by commands, and ranges of their values."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperCommand

from pymdr.errors import MissingExtraError, ProblemError

if TYPE_CHECKING:
    from pymdr.units import FloatArray

CaseFile = Annotated[Path, typer.Argument(metavar="CASE.toml", help="The case file.")]
Output = Annotated[
    Path | None,
    typer.Option(
        "-o", "--output", metavar="DIR", help="Folder for result.nc and the figures; by default CASE."
    ),
]
Table = Annotated[
    Path | None,
    typer.Option(
        "-o",
        "--output",
        metavar="DIR",
        help="Folder for a table and a figure; by default nothing is written.",
    ),
]
Points = Annotated[int | None, typer.Option(help="Total number of values, log-spaced between the two given.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print only errors.")]
KeepSigns = Annotated[
    bool,
    typer.Option(
        "--keep-signs", help="Keep the signs of the file: compression is positive, height falls to the body."
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON instead of text, also for errors.")]
ReportFile = Annotated[
    Path | None,
    typer.Option(
        "--report", metavar="FILE.html", help="Printable report with tables, figures, claims and settings."
    ),
]

Cluster = Annotated[
    str | None,
    typer.Option(metavar="ADDRESS", help="A dask scheduler instead of --workers, such as tcp://node:8786."),
]
Sensitivity = Annotated[
    str | None,
    typer.Option(help="Sensitivity of a deflection in V, such as '50 nm/V'; fit: or '50 nm/V +- 5 %'."),
]
Uncertainties = Annotated[
    list[str] | None,
    typer.Option(
        metavar="NAME=VALUE",
        help="Standard uncertainty in the intervals, such as 'spring_constant=10 %', sensitivity or profile.radius; repeatable.",
    ),
]
Groups = Annotated[
    Path | None,
    typer.Option(
        metavar="TABLE",
        help="CSV of file and sample, for a folder; by default the subfolders are the samples.",
    ),
]
FitSegment = Annotated[
    str | None,
    typer.Option(
        help="Part to fit: approach, retreat or record (all); by default the record of a table, the approach of an AFM "
        "curve, and its record with adhesion or memory."
    ),
]
LeaveOut = Annotated[bool, typer.Option("--leave-out-missing", help="Leave out samples without a number.")]

_MOST_POINTS = 1000


class Once(TyperCommand):
    """A command that refuses repeated single-valued options, whose last value would win silently."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Refuse repeated single-valued options, then parse."""
        given: list[Any] = list(self.make_parser(ctx).parse_args(list(args))[2])
        for param in given:
            single = getattr(param, "multiple", True) is False and not getattr(param, "is_flag", False)
            if single and given.count(param) > 1:
                message = f"given {given.count(param)} times, but it takes one value; give it once"
                raise typer.BadParameter(message, ctx=ctx, param=param)
        return super().parse_args(ctx, args)


def values_of(given: Sequence[str]) -> list[str]:
    """
    The values of a repeatable option, each of which may hold several.

    Examples
    --------
    >>> values_of(["1 m/s, 2 m/s", "3 m/s"]), values_of(["1,5 m/s"])
    (['1 m/s', '2 m/s', '3 m/s'], ['1,5 m/s'])
    """
    return [value for text in given for value in re.split(r"(?<=\D),\s*|,\s+", text.strip())]


def spread(
    given: Sequence[str], points: int | None, unit: str, name: str, form: str = "--{name} '{value}'"
) -> FloatArray | list[str]:
    """The given values, or `points` values between two; `form` shows in messages how one is given."""
    import numpy as np

    from pymdr.units import to_si_array

    given = values_of(given)
    bare = [value for value in given if unit and re.fullmatch(r"\s*[-+.\d][-+.\deE]*\s*", value)]
    if bare:
        raise ProblemError(
            f"--{name} {bare[0]}: a unit is missing; write "
            + form.format(name=name, value=f"{bare[0].strip()} {unit}")
        )
    if points is None:
        return given
    ends = to_si_array(list(given), unit, name=name)
    if ends.shape != (2,) or not np.all(ends > 0.0) or not 2 <= points <= _MOST_POINTS:
        raise ProblemError(
            f"--points {points}: give two values above 0, not {', '.join(given)}, and 2 to "
            f"{_MOST_POINTS} points from one to the other"
        )
    return np.geomspace(ends[0], ends[1], points)


def with_uncertainty(given: str) -> tuple[str, str | None]:
    """
    A value and its standard uncertainty; None without one.

    Examples
    --------
    >>> with_uncertainty("0.05 N/m +- 10 %"), with_uncertainty("50 nm/V")
    (('0.05 N/m', '10 %'), ('50 nm/V', None))
    """
    value, sign, uncertainty = given.replace("±", "+-").partition("+-")
    return value.strip(), (uncertainty.strip() if sign else None)


@contextmanager
def at_work(workers: int | None, cluster: str | None) -> Iterator[Any]:
    """The workers of a command: a number of cores, or the client of a cluster while it is connected."""
    if cluster is None:
        yield workers
        return
    try:
        from distributed import Client
    except ImportError as error:
        raise MissingExtraError(
            f"--cluster {cluster} needs dask ({error}): pip install 'pymdr[cluster]'"
        ) from error
    try:
        client = Client(cluster, timeout="10s")
    except (OSError, ValueError, TimeoutError) as error:
        raise ProblemError(
            f"--cluster {cluster}: no scheduler answers; start one with `dask scheduler`, and workers with `dask worker {cluster}`"
        ) from error
    with client:
        yield client
