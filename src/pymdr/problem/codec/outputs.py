"""Pydantic models of the tables of a case that ask for more than its result: stress and studies."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, TypeAlias

if TYPE_CHECKING:
    from pydantic import BaseModel, ConfigDict

CLOSED: ConfigDict = {"extra": "forbid", "defer_build": True}
"""Of the models inside a case: no other keys, and no validator of their own, since only the whole case is validated."""

_Number: TypeAlias = int | float | str
_SIDE: Any = Literal["body", "counterbody"] | None
_MEASURE: Any = Literal["von_mises", "tresca", "principal_stress", "hydrostatic"]
_COMPONENT: Any = Literal["xx", "yy", "zz", "xz", "xy", "yz"]
_CRITERION: Any = Literal[
    "dang-van", "findley", "fatemi-socie", "smith-watson-topper", "ruiz-work", "ruiz-damage"
]
_WEAR: Any = Literal["archard", "energy"]
_SEVERAL: Any = _Number | list[_Number]
_OPTIONAL: Any = _Number | None

OUTPUTS: dict[str, tuple[str, dict[str, tuple[Any, Any, str]]]] = {
    "stress": (
        "The stress inside the bodies that pymdr run draws and tabulates.",
        {
            "measure": (_MEASURE, "von_mises", "what the section shows"),
            "side": (_SIDE, None, "every body whose stress is known unless given"),
            "superposed": (
                dict[_COMPONENT, _Number] | None,
                None,
                "stress that is added, in Pa, by component",
            ),
            "animate": (bool, False, "whether stress.gif shows the rows of the path"),
            "r": (list[_Number] | None, None, "radii of the table stress.csv, frictionless"),
            "x": (list[_Number] | None, None, "positions along the shift instead of r, needed with friction"),
            "z": (list[_Number] | None, None, "depths of the table stress.csv, at least 0"),
        },
    ),
    "first_yield": (
        "The load of first yield that pymdr run computes.",
        {
            "strength": (_SEVERAL, ..., "yield strength in Pa, one or one for every layer"),
            "tensile_strength": (_SEVERAL | None, None, "largest tension in Pa at the first crack"),
            "bond_strength": (_OPTIONAL, None, "shear strength of the interfaces of layers in Pa"),
            "side": (_SIDE, None, "which body; the first whose stress is known unless given"),
            "force_ratio": (_OPTIONAL, None, "tangential over normal force; sliding unless given"),
        },
    ),
    "shakedown": (
        "The load of shakedown under repeated rolling or sliding that pymdr run computes.",
        {
            "strength": (_Number, ..., "yield strength in Pa"),
            "force_ratio": (_SEVERAL | None, None, "tangential over normal force, one or several"),
            "side": (_SIDE, None, "which body; the first whose stress is known unless given"),
        },
    ),
    "pull_off": (
        "The pull-off that pymdr run computes.",
        {
            "machine_stiffness": (_OPTIONAL, None, "in N/m; that of [solve], or infinite, unless given"),
            "preload": (_OPTIONAL, None, "normal force in N before the retraction"),
            "pressed_to": (_OPTIONAL, None, "indentation in m before the retraction"),
            "dwell": (_SEVERAL | None, None, "with memory: time at rest in s, one or several"),
            "speed": (_SEVERAL | None, None, "with memory: speed of the retraction in m/s, one or several"),
            "approach_speed": (_OPTIONAL, None, "with memory: speed of the approach in m/s"),
            "edge": (bool, False, "with memory: the work of the edge over its speed instead"),
        },
    ),
    "fatigue": (
        "Fatigue over the last cycle of the path that pymdr run computes.",
        {
            "criterion": (_CRITERION, ..., "the criterion"),
            "slope": (_OPTIONAL, None, "weight of the mean (dang-van) or normal stress of the criterion"),
            "yield_strength": (_OPTIONAL, None, "of fatemi-socie, in Pa"),
            "limit": (_OPTIONAL, None, "endurance limit in the SI unit of the criterion"),
            "bulk": (_OPTIONAL, None, "constant bulk stress along the shift in Pa"),
            "bulk_amplitude": (_OPTIONAL, None, "bulk stress in phase with the tangential force in Pa"),
            "side": (_SIDE, None, "which body; the first whose stress is known unless given"),
        },
    ),
    "wear": (
        "Fretting wear over many cycles that pymdr run computes; the path is one cycle.",
        {
            "coefficient": (
                _Number,
                ...,
                "wear coefficient, such as '1e-6 mm^3/(N m)', for energy '1e-6 mm^3/J'",
            ),
            "cycles": (_SEVERAL, ..., "number of cycles, or the numbers at which rows are wanted"),
            "law": (_WEAR, "archard", "archard (load times path) or energy"),
        },
    ),
}
"""Tables by name: what they ask for, and for every key its type, default (... if there is none) and description."""


def output_tables() -> dict[str, Any]:
    """Optional fields of the model of a case, by table."""
    from pydantic import Field

    return {
        name: (
            _model(name),
            Field(None, description=f"{text[0].lower()}{text[1:-1]}; omitted unless this table is given"),
        )
        for name, (text, _) in OUTPUTS.items()
    }


def _model(name: str) -> type[BaseModel]:
    from pydantic import Field, StrictBool, create_model

    text, keys = OUTPUTS[name]
    columns: dict[str, Any] = {
        key: (StrictBool if kind is bool else kind, Field(default, description=description))
        for key, (kind, default, description) in keys.items()
    }
    return create_model(name, __config__=CLOSED, __doc__=text, **columns)
