"""The kinds of the parts of a case, and their default values of the sizes of the case before."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from pymdr.explore.model.choice import Choice, ordered, short_text, with_length, with_path
from pymdr.quantities import QUANTITIES
from pymdr.units import to_si

NONE = "none"
"""The kind of an optional part that is left out."""

_SHAPES: dict[str, dict[str, float | str]] = {
    "sphere": {"radius": 1.0},
    "paraboloid": {"radius": 1.0},
    "sphere_on_sphere": {"radius": 1.0, "sample_radius": 2.0},
    "cone": {"half_angle": "70.3 deg"},
    "rounded_cone": {"tip_radius": 0.1, "half_angle": "70.3 deg"},
    "truncated_cone": {"flat_radius": 0.01, "half_angle": "70.3 deg"},
    "hyperboloid": {"tip_radius": 0.1, "half_angle": "70.3 deg"},
    "power_law": {"exponent": "4", "height": 0.5, "radius": 0.2},
    "flat_punch": {"radius": 0.02},
    "rounded_flat": {"flat_radius": 0.01, "edge_radius": 1.0},
    "domed_punch": {"radius": 0.02, "dome_radius": 2.0},
    "concave_punch": {"radius": 0.02, "hollow_radius": 20.0},
    "truncated_sphere": {"radius": 1.0, "flat_radius": 0.02},
    "truncated_paraboloid": {"radius": 1.0, "flat_radius": 0.02},
    "ellipsoid": {"radius": 1.0, "height": 0.5},
    "elliptic_paraboloid": {"radius_x": 1.0, "radius_y": 0.5},
}
"""Profiles with their lengths as fractions of the length of the profile before."""

_ZINC = {"c11": "161 GPa", "c33": "61 GPa", "c13": "50.1 GPa", "c44": "38.3 GPa", "c66": "63.4 GPa"}

_ADHESION: dict[str, dict[str, Any]] = {
    "jkr": {"work": "50 mJ/m^2"},
    "maugis_dugdale": {"work": "50 mJ/m^2", "range": "1 nm"},
    "dmt": {"work": "50 mJ/m^2"},
    "capillary": {"humidity": "0.5"},
}

_BODIES = ("elastic", "layered", "viscoelastic", "graded", "transversely_isotropic", "elastic_plastic")

PATHS = {
    "load": ("load",),
    "load and unload": ("load", "load"),
    "indent": ("indent",),
    "approach and retract": ("travel", "travel"),
    "shift under load": ("load", "shift"),
    "cycle under load": ("load", "cycle"),
    "twist under load": ("load", "twist"),
}
"""Paths by name, with the kinds of their legs."""

OWN = "of the case"
"""The name of any other path."""


def kinds(part: str, choice: Choice) -> tuple[str, ...]:
    """The kinds of a part, that of the choice among them."""
    now = kind_of(part, choice)
    known = {
        "profile": tuple(_SHAPES),
        "body": _BODIES,
        "counterbody": ("rigid", "elastic", "viscoelastic", "graded", "transversely_isotropic"),
        "adhesion": (NONE, *_ADHESION),
        "friction": (NONE, "coulomb"),
        "path": tuple(PATHS),
    }[part]
    return known if now in known else (now, *known)


def kind_of(part: str, choice: Choice) -> str:
    """The kind of a part of a choice."""
    if part == "path":
        legs = tuple(leg["kind"] for leg in choice.tables["path"])
        return next((name for name, kinds_of_legs in PATHS.items() if kinds_of_legs == legs), OWN)
    left_out = "rigid" if part == "counterbody" else NONE
    return str(choice.tables.get(part, {}).get("kind", left_out))


def with_kind(part: str, kind: str, choice: Choice, largest: Mapping[str, float] | None = None) -> Choice:
    """
    The choice with another kind of a part, whose values are of the size of those before.

    Parameters
    ----------
    part : str
        One of :data:`PARTS`.
    kind : str
        One of :func:`kinds`.
    largest : mapping of str to float, optional
        Largest quantities of the last result, from which the targets of a path are taken.

    Examples
    --------
    >>> from pymdr.explore.model import start
    >>> dict(with_kind("profile", "truncated_sphere", start("ball")).tables["profile"])
    {'kind': 'truncated_sphere', 'radius': '10 mm', 'flat_radius': '200 µm'}
    """
    if kind in (kind_of(part, choice), OWN):
        return choice
    new = dict(choice.tables)
    if kind == NONE or (part == "counterbody" and kind == "rigid"):
        new.pop(part, None)
    elif part == "path":
        new["path"] = _legs(kind, choice, largest or {})
    else:
        new[part] = {"kind": kind, **_default(part, kind, choice)}
    if any(leg["kind"] == "travel" for leg in new["path"]) and "machine_stiffness" not in new.get(
        "solve", {}
    ):
        sizes = _sizes(choice, largest or {})
        stiffness = abs(sizes["normal_force"] / sizes["indentation"])
        new["solve"] = {**new.get("solve", {}), "machine_stiffness": short_text(stiffness, "N/m")}
    timed = with_path(replace(choice, tables=ordered(new)), new["path"])
    return with_length(timed)


def _default(part: str, kind: str, choice: Choice) -> dict[str, Any]:
    if part == "profile":
        return {
            key: value if isinstance(value, str) else short_text(value * choice.length, "m")
            for key, value in _SHAPES[kind].items()
        }
    if part == "adhesion":
        return dict(_ADHESION[kind])
    if part == "friction":
        return {"coefficient": "0.3"}
    before = choice.tables.get(part, {})
    young, poisson = before.get("young", "1 GPa"), before.get("poisson", "0.3")
    stiffness = to_si(young, "Pa") if not isinstance(young, Mapping) else 1e9
    solid = {"young": young if not isinstance(young, Mapping) else "1 GPa", "poisson": poisson}
    defaults: dict[str, dict[str, Any]] = {
        "elastic": solid,
        "graded": {**solid, "depth": short_text(0.1 * choice.length, "m"), "exponent": "0.3"},
        "elastic_plastic": {**solid, "yield_strength": short_text(2e-3 * stiffness, "Pa")},
        "transversely_isotropic": dict(_ZINC),
        "viscoelastic": {
            "poisson": poisson,
            "shear": {
                "kind": "standard_solid",
                "equilibrium": short_text(0.1 * stiffness, "Pa"),
                "modulus": short_text(0.3 * stiffness, "Pa"),
                "time": "1 s",
            },
        },
        "layered": {
            "bond": "bonded",
            "base": {"kind": "elastic", **solid},
            "layers": [
                {
                    "material": {
                        "kind": "elastic",
                        "young": short_text(3.0 * stiffness, "Pa"),
                        "poisson": poisson,
                    },
                    "thickness": short_text(0.01 * choice.length, "m"),
                }
            ],
        },
    }
    return defaults[kind]


def _sizes(choice: Choice, largest: Mapping[str, float]) -> dict[str, float]:
    """Sizes of the targets of a path: of the last result, else of the path before."""
    known = {name: abs(value) for name, value in largest.items() if math.isfinite(value) and value}
    for leg in choice.tables["path"]:
        for channel in ("normal_force", "indentation", "travel"):
            if isinstance(leg.get(channel), str | int | float):
                size = abs(to_si(leg[channel], QUANTITIES[channel].unit))
                known.setdefault(channel, size) if size else None
    known.setdefault("indentation", known.get("travel", 1e-3 * choice.length))
    known.setdefault("normal_force", 1.0)
    return known


def _legs(name: str, choice: Choice, largest: Mapping[str, float]) -> list[dict[str, Any]]:
    sizes = _sizes(choice, largest)
    depth = short_text(sizes["indentation"], "m")
    load = {"kind": "load", "normal_force": short_text(sizes["normal_force"], "N"), "steps": 40}
    moved = short_text(0.3 * sizes["indentation"], "m")
    twisted = short_text(1e-3, "rad")
    paths: dict[str, list[dict[str, Any]]] = {
        "load": [load],
        "load and unload": [load, {**load, "normal_force": "0 N"}],
        "indent": [{"kind": "indent", "indentation": depth, "steps": 40}],
        "approach and retract": [
            {"kind": "travel", "travel": short_text(2.0 * sizes["indentation"], "m"), "steps": 60},
            {"kind": "travel", "travel": short_text(-6.0 * sizes["indentation"], "m"), "steps": 200},
        ],
        "shift under load": [load, {"kind": "shift", "shift": moved, "steps": 60}],
        "cycle under load": [load, {"kind": "cycle", "shift": moved, "cycles": 1, "steps": 120}],
        "twist under load": [load, {"kind": "twist", "twist": twisted, "steps": 40}],
    }
    return paths[name]
