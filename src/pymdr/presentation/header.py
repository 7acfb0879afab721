"""A contact law as a C header."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pymdr.errors import ProblemError
from pymdr.presentation.history_header import HistoryInC
from pymdr.presentation.steps_header import StepInC
from pymdr.units import FloatArray, shown

_IDENTIFIER = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}")
_WHOLE, _LARGEST = 1e-13, 8
"""Distance of twice a power from a whole number that is rounding, and the largest such number that is written as a product."""
_KEYWORDS = frozenset([
    "alignas", "alignof", "and", "asm", "auto", "bool", "break", "case", "catch", "char", "class", "compl",
    "concept", "const", "constexpr", "continue", "decltype", "default", "delete", "do", "double", "else",
    "enum", "explicit", "export", "extern", "false", "float", "for", "friend", "goto", "if", "inline", "int",
    "long", "mutable", "namespace", "new", "noexcept", "not", "nullptr", "operator", "or", "private",
    "protected", "public", "register", "requires", "restrict", "return", "short", "signed", "sizeof",
    "static", "struct", "switch", "template", "this", "throw", "true", "try", "typedef", "typeid", "typename",
    "typeof", "union", "unsigned", "using", "virtual", "void", "volatile", "while", "xor",
])  # fmt: skip


@dataclass(frozen=True)
class HeaderData:
    """The contents of a header."""

    name: str
    """Prefix of all C names."""
    remarks: Sequence[str]
    """Lines of the comment at its top."""
    constants: Mapping[str, tuple[float, str]]
    """Value and unit by name."""
    columns: Mapping[str, FloatArray]
    """u, y, y_slope, z and z_slope at the knots."""
    tip: tuple[float, float, float] | None
    """Of a law over ln d: exponents of F and a below the first knot, and the pull in N. None for a law over sqrt(d - d_off)."""
    least: float
    """Smallest u that is interpolated."""
    history: HistoryInC | None = None
    """What contacts remember."""


def identifier(name: str) -> str:
    """The name, if it is a valid C identifier."""
    if not isinstance(name, str) or not _IDENTIFIER.fullmatch(name) or name in _KEYWORDS:
        raise ProblemError(
            f"name = {shown(name)} is not usable as a C identifier: begin with a letter and use at most 40 letters, digits and "
            "underscores, no keyword, such as 'ball_on_glass'"
        )
    return name


def c_header(data: HeaderData) -> str:
    """The text of a header."""
    name = identifier(data.name)
    constants, usage, body = data.constants, [], _body(data)
    if data.history is not None:
        constants = {**constants, **data.history.constants}
        usage = [data.history.usage]
        body = f"{body}\n{data.history.body}"
    tables = [f"#define @@_KNOTS {data.columns['u'].size}\n"]
    if _power_law(data) is None:
        tables += [_array(f"{name}_{key}_", values) for key, values in data.columns.items()]
    remarks = [*data.remarks, *_usage(name, data.tip is not None), *usage]
    return _assembled(name, remarks, constants, [*tables, body])


def step_header(name: str, remarks: Sequence[str], largest: float, step: StepInC) -> str:
    """The text of a header of a step alone, up to a largest indentation in m."""
    constants = {"LARGEST_INDENTATION": (largest, "m"), **step.constants}
    return _assembled(identifier(name), [*remarks, "", step.usage], constants, [step.body])


def _assembled(
    name: str, remarks: Sequence[str], constants: Mapping[str, tuple[float, str]], parts: Sequence[str]
) -> str:
    """Remarks, constants and parts, in which @@ is the name in capitals and @ the name."""
    prefix = name.upper()
    return "\n".join(
        [
            _comment([line.replace("@@", prefix).replace("@", name) for line in remarks]),
            f"#ifndef {prefix}_H\n#define {prefix}_H\n\n#include <math.h>\n#include <stddef.h>\n",
            "\n".join(
                f"#define {prefix}_{key} ({value!r})" + (f" /* {unit} */" if unit else "")
                for key, (value, unit) in constants.items()
            ),
            *(part.replace("@@", prefix).replace("@", name) for part in parts),
            "#endif\n",
        ]
    )


def _usage(name: str, from_tip: bool) -> list[str]:
    outside = "d <= 0" if from_tip else "d below the pull-off"
    return [
        "",
        f"{name}_force(d) in N, {name}_stiffness(d) = dF/dd in N/m and {name}_radius(d) in m of the indentation d in m; "
        f"{name}_law gives all three at once; a NULL pointer skips its value.",
        f"{outside}: 0, no contact; d above {name.upper()}_LARGEST_INDENTATION, or NAN: NAN (not with -ffast-math).",
    ]


def _comment(lines: Sequence[str]) -> str:
    """A C comment in ASCII; comment marks inside it are broken up."""
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


def _product(power: float) -> str | None:
    """The power of x as a product with its root; None if twice the power is no small whole number."""
    twice = round(2.0 * power)
    if abs(2.0 * power - twice) > _WHOLE or not 0 <= twice <= _LARGEST:
        return None
    return " * ".join(["x"] * (twice // 2) + ["sqrt(x)"] * (twice % 2)) or "1.0"


def _power_law(data: HeaderData) -> str | None:
    """The body of a law that is one power of the depth, evaluated without logarithms; None for others."""
    if data.tip is None or data.columns["u"].size > 2:
        return None
    power, radius_power, pull = data.tip
    force, radius = _product(power), _product(radius_power)
    slopes = (data.columns["y_slope"] - power, data.columns["z_slope"] - radius_power)
    if force is None or radius is None or np.max(np.abs(slopes)) > _WHOLE:
        return None
    return _POWER % {
        "per_unit": repr(float(np.exp(-data.columns["u"][-1]))),
        "force": f"{float(np.exp(data.columns['y'][-1]))!r} * ({force})",
        "off": f" - {pull!r}" if pull else "",
        "power": repr(power),
        "radius": f"{float(np.exp(data.columns['z'][-1]))!r} * ({radius})",
    }


def _body(data: HeaderData) -> str:
    if (power_law := _power_law(data)) is not None:
        return power_law + _FUNCTIONS
    if data.tip is None:
        outside, coordinate = "d < @@_PULL_OFF_INDENTATION", "sqrt(d - @@_PULL_OFF_INDENTATION)"
        below, force, stiffness, radius = "", "y", "slope / (2.0 * u)", "z"
        value = ""
    else:
        power, radius_power, pull = data.tip
        off = f" - {pull!r}" if pull else ""
        outside, coordinate, value = "d <= 0.0", "log(d)", "        y = exp(y);\n"
        below = _BELOW % {"power": repr(power), "radius_power": repr(radius_power), "off": off}
        force, stiffness, radius = f"y{off}", "y * slope / d", "exp(z)"
    law = _TEMPLATE % {
        "outside": outside,
        "below": below,
        "coordinate": coordinate,
        "value": value,
        "force": force,
        "stiffness": stiffness,
        "radius": radius,
        "least": repr(data.least),
    }
    return law + _FUNCTIONS


_BELOW = """\
    if (d < @@_SMALLEST_INDENTATION) {
        u = log(d) - @_u_[0];
        y = exp(@_y_[0] + %(power)s * u);
        if (force)
            *force = y%(off)s;
        if (stiffness)
            *stiffness = %(power)s * y / d;
        if (radius)
            *radius = exp(@_z_[0] + %(radius_power)s * u);
        return;
    }
"""
_TEMPLATE = """\
static inline void @_law(double d, double *force, double *stiffness, double *radius)
{
    size_t low = 0, high = @@_KNOTS - 1;
    double u, h, t, m0, m1, rise, slope, y, z;
    if (!(d <= @@_LARGEST_INDENTATION) || %(outside)s) {
        double value = 0.0;
        if (!(d <= @@_LARGEST_INDENTATION))
            value = NAN;
        if (force)
            *force = value;
        if (stiffness)
            *stiffness = value;
        if (radius)
            *radius = value;
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
    if (force || stiffness) {
        m0 = @_y_slope_[low];
        m1 = @_y_slope_[high];
        rise = (@_y_[high] - @_y_[low]) / h;
        y = @_y_[low] + h * t * (m0 + t * (3.0 * rise - 2.0 * m0 - m1 + t * (m0 + m1 - 2.0 * rise)));
        slope = m0 + t * (2.0 * (3.0 * rise - 2.0 * m0 - m1) + 3.0 * t * (m0 + m1 - 2.0 * rise));
%(value)s        if (force)
            *force = %(force)s;
        if (stiffness)
            *stiffness = %(stiffness)s;
    }
    if (radius) {
        m0 = @_z_slope_[low];
        m1 = @_z_slope_[high];
        rise = (@_z_[high] - @_z_[low]) / h;
        z = @_z_[low] + h * t * (m0 + t * (3.0 * rise - 2.0 * m0 - m1 + t * (m0 + m1 - 2.0 * rise)));
        *radius = %(radius)s;
    }
}

"""
_POWER = """\
static inline void @_law(double d, double *force, double *stiffness, double *radius)
{
    const int known = d <= @@_LARGEST_INDENTATION;
    const double x = known && d > 0.0 ? d * %(per_unit)s : 0.0;
    const double pressing = %(force)s;
    if (force)
        *force = !known ? (double)NAN : x > 0.0 ? pressing%(off)s : 0.0;
    if (stiffness)
        *stiffness = !known ? (double)NAN : x > 0.0 ? %(power)s * pressing / d : 0.0;
    if (radius)
        *radius = !known ? (double)NAN : x > 0.0 ? %(radius)s : 0.0;
}
"""
_FUNCTIONS = """\

static inline double @_force(double d)
{
    double force;
    @_law(d, &force, NULL, NULL);
    return force;
}

static inline double @_stiffness(double d)
{
    double stiffness;
    @_law(d, NULL, &stiffness, NULL);
    return stiffness;
}

static inline double @_radius(double d)
{
    double radius;
    @_law(d, NULL, NULL, &radius);
    return radius;
}
"""
