"""A law of contact as a C header."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pymdr.errors import ProblemError
from pymdr.units import FloatArray, shown

_IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}")
_KEYWORDS = frozenset(
    [
        "alignas",
        "alignof",
        "and",
        "asm",
        "auto",
        "bool",
        "break",
        "case",
        "catch",
        "char",
        "class",
        "compl",
        "concept",
        "const",
        "constexpr",
        "continue",
        "decltype",
        "default",
        "delete",
        "do",
        "double",
        "else",
        "enum",
        "explicit",
        "export",
        "extern",
        "false",
        "float",
        "for",
        "friend",
        "goto",
        "if",
        "inline",
        "int",
        "long",
        "mutable",
        "namespace",
        "new",
        "noexcept",
        "not",
        "nullptr",
        "operator",
        "or",
        "private",
        "protected",
        "public",
        "register",
        "requires",
        "restrict",
        "return",
        "short",
        "signed",
        "sizeof",
        "static",
        "struct",
        "switch",
        "template",
        "this",
        "throw",
        "true",
        "try",
        "typedef",
        "typeid",
        "typename",
        "typeof",
        "union",
        "unsigned",
        "using",
        "virtual",
        "void",
        "volatile",
        "while",
        "xor",
    ]
)


@dataclass(frozen=True)
class HeaderData:
    """What a header is written from."""

    name: str
    """What all names begin with."""
    remarks: Sequence[str]
    """Lines of its comment."""
    constants: Mapping[str, tuple[float, str]]
    """Value and unit by name."""
    columns: Mapping[str, FloatArray]
    """u, y, y_slope, z and z_slope of the knots."""
    tip: tuple[float, float, float] | None
    """Powers of F and a below the first knot and the pull in N, of a law over ln d; None of one over sqrt(d - d_off)."""
    least: float
    """The least u that is interpolated."""


def c_header(data: HeaderData) -> str:
    """
    The text of a header.

    Parameters
    ----------
    data : HeaderData

    Returns
    -------
    str

    Raises
    ------
    ProblemError
        If the name is no C identifier.
    """
    name = data.name
    if not isinstance(name, str) or not _IDENTIFIER.fullmatch(name) or name in _KEYWORDS:
        raise ProblemError(
            f"name = {shown(name)}: a C identifier is needed that begins with a letter, has at most 40 letters, digits and "
            "underscores, and is no keyword, such as 'ball_on_glass'"
        )
    big = name.upper()
    parts = [
        _comment([*data.remarks, *_usage(name, data.tip is not None)]),
        f"#ifndef {big}_H\n#define {big}_H\n\n#include <math.h>\n#include <stddef.h>\n",
        "\n".join(
            f"#define {big}_{key} ({value!r})" + (f" /* {unit} */" if unit else "")
            for key, (value, unit) in data.constants.items()
        ),
        f"#define {big}_KNOTS {data.columns['u'].size}\n",
        *(_array(f"{name}_{key}_", values) for key, values in data.columns.items()),
        _body(data).replace("@@", big).replace("@", name),
        "#endif\n",
    ]
    return "\n".join(parts)


def _usage(name: str, from_tip: bool) -> list[str]:
    begin = "d <= 0" if from_tip else "d below the pull-off"
    return [
        "",
        f"{name}_force(d) in N, {name}_stiffness(d) = dF/dd in N/m and {name}_radius(d) in m of the indentation d in m; "
        f"{name}_law gives all three at once.",
        f"{begin}: 0, no contact; d above {name.upper()}_LARGEST_INDENTATION, or NAN: NAN (not with -ffast-math).",
    ]


def _comment(lines: Sequence[str]) -> str:
    """A comment of plain characters that nothing in it ends."""
    wrapped = [
        part
        for line in lines
        for part in textwrap.wrap(
            line.encode("ascii", "replace")
            .decode()
            .replace("*/", "* /")
            .replace("/*", "/ *")
            .replace("\\", "/"),
            110,
            break_long_words=True,
        )
        or [""]
    ]
    return "/*\n" + "\n".join(f" * {line}".rstrip() for line in wrapped) + "\n */"


def _array(name: str, values: FloatArray) -> str:
    numbers = textwrap.fill(
        ", ".join(repr(float(v)) for v in np.asarray(values)), 110, break_on_hyphens=False
    )
    return f"static const double {name}[] = {{\n{numbers}\n}};\n"


def _body(data: HeaderData) -> str:
    if data.tip is None:
        outside = "d < @@_PULL_OFF_INDENTATION"
        below, coordinate = "", "sqrt(d - @@_PULL_OFF_INDENTATION)"
        answers = "    *force = y;\n    *stiffness = slope / (2.0 * u);\n    *radius = z;\n"
    else:
        power, radius_power, pull = data.tip
        off = f" - {pull!r}" if pull else ""
        outside, coordinate = "d <= 0.0", "log(d)"
        below = (
            "    if (d < @@_SMALLEST_INDENTATION) {\n"
            "        const double along = log(d) - @_u_[0];\n"
            f"        const double pressing = exp(@_y_[0] + {power!r} * along);\n"
            f"        *force = pressing{off};\n"
            f"        *stiffness = {power!r} * pressing / d;\n"
            f"        *radius = exp(@_z_[0] + {radius_power!r} * along);\n"
            "        return;\n"
            "    }\n"
        )
        answers = (
            f"    y = exp(y);\n    *force = y{off};\n    *stiffness = y * slope / d;\n    *radius = exp(z);\n"
        )
    return _TEMPLATE % {
        "outside": outside,
        "below": below,
        "coordinate": coordinate,
        "answers": answers,
        "least": repr(data.least),
    }


_TEMPLATE = """\
static inline void @_law(double d, double *force, double *stiffness, double *radius)
{
    size_t low = 0, high = @@_KNOTS - 1;
    double u, h, t, m0, m1, rise, slope, y, z;
    *force = *stiffness = *radius = 0.0;
    if (%(outside)s)
        return;
    if (!(d <= @@_LARGEST_INDENTATION)) {
        *force = *stiffness = *radius = NAN;
        return;
    }
%(below)s    u = %(coordinate)s;
    if (u < %(least)s)
        u = %(least)s;
    if (u > @_u_[high])
        u = @_u_[high];
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (@_u_[middle] <= u)
            low = middle;
        else
            high = middle;
    }
    h = @_u_[high] - @_u_[low];
    t = (u - @_u_[low]) / h;
    m0 = @_y_slope_[low];
    m1 = @_y_slope_[high];
    rise = (@_y_[high] - @_y_[low]) / h;
    y = @_y_[low] + h * t * (m0 + t * (3.0 * rise - 2.0 * m0 - m1 + t * (m0 + m1 - 2.0 * rise)));
    slope = m0 + t * (2.0 * (3.0 * rise - 2.0 * m0 - m1) + 3.0 * t * (m0 + m1 - 2.0 * rise));
    m0 = @_z_slope_[low];
    m1 = @_z_slope_[high];
    rise = (@_z_[high] - @_z_[low]) / h;
    z = @_z_[low] + h * t * (m0 + t * (3.0 * rise - 2.0 * m0 - m1 + t * (m0 + m1 - 2.0 * rise)));
%(answers)s}

static inline double @_force(double d)
{
    double force, stiffness, radius;
    @_law(d, &force, &stiffness, &radius);
    return force;
}

static inline double @_stiffness(double d)
{
    double force, stiffness, radius;
    @_law(d, &force, &stiffness, &radius);
    return stiffness;
}

static inline double @_radius(double d)
{
    double force, stiffness, radius;
    @_law(d, &force, &stiffness, &radius);
    return radius;
}
"""
