"""The options that commands share, and the values that are given with them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperCommand

if TYPE_CHECKING:
    from pymdr.units import FloatArray

CaseFile = Annotated[Path, typer.Argument(metavar="CASE.toml", help="The case file.")]
Output = Annotated[
    Path | None,
    typer.Option(
        "-o", "--output", metavar="DIR", help="Folder for result.nc and the figures; CASE unless given."
    ),
]
Table = Annotated[
    Path | None,
    typer.Option(
        "-o",
        "--output",
        metavar="DIR",
        help="Folder for the table and the figure; nothing is written unless given.",
    ),
]
Points = Annotated[
    int | None,
    typer.Option(help="How many in all, evenly in their logarithm from the first of two to the second."),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")]
Json = Annotated[bool, typer.Option("--json", help="Print JSON instead of the summary, also of what fails.")]

_MOST_POINTS = 1000


class Once(TyperCommand):
    """A command whose options of one value are given once: of several values the last would win silently."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Refuse an option of one value that is repeated, then parse."""
        given: list[Any] = list(self.make_parser(ctx).parse_args(list(args))[2])
        for param in given:
            single = getattr(param, "multiple", True) is False and not getattr(param, "is_flag", False)
            if single and given.count(param) > 1:
                words = f"given {given.count(param)} times, but it takes one value; give it once"
                raise typer.BadParameter(words, ctx=ctx, param=param)
        return super().parse_args(ctx, args)


def spread(
    given: Sequence[str], points: int | None, unit: str, name: str, form: str = "--{name} '{value}'"
) -> FloatArray | list[str]:
    """The values that are given, or so many between two of them; `form` is how one is written."""
    import numpy as np

    from pymdr.errors import ProblemError
    from pymdr.units import to_si_array

    bare = [value for value in given if unit and re.fullmatch(r"\s*[-+.\d][-+.\deE]*\s*", value)]
    if bare:
        raise ProblemError(
            f"--{name} {bare[0]}: a unit is missing; write "
            + form.format(name=name, value=f"{bare[0].strip()} {unit}")
        )
    if points is None:
        return list(given)
    ends = to_si_array(list(given), unit, name=name)
    if ends.shape != (2,) or not np.all(ends > 0.0) or not 2 <= points <= _MOST_POINTS:
        raise ProblemError(
            f"--points {points} with --{name} {', '.join(given)}: give two above 0 and 2 to {_MOST_POINTS} points "
            "from the one to the other"
        )
    return np.geomspace(ends[0], ends[1], points)
