"""The kinds of case files and saved results, and their classes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from pymdr.problem.capillary import Capillary
from pymdr.problem.fractional import PowerLawRheology
from pymdr.problem.laws import DMT, JKR, Coulomb, MaugisDugdale
from pymdr.problem.layers import Layered
from pymdr.problem.machines import Drive, Force, Joint, Mass, Rotor, Spring
from pymdr.problem.materials import Elastic, Graded, Rigid, TransverselyIsotropic, Viscoelastic
from pymdr.problem.orbits import circle, lissajous
from pymdr.problem.paths import Cycle, Hold, Path, Ramp
from pymdr.problem.plasticity import ElasticPlastic
from pymdr.problem.profiles import (
    AreaFunction,
    ConcavePunch,
    Cone,
    CubicSpline,
    DomedPunch,
    Ellipsoid,
    EllipticParaboloid,
    FlatPunch,
    ForceCurve,
    Hyperboloid,
    Interpolated,
    Paraboloid,
    PowerLaw,
    Pyramid,
    RoundedCone,
    RoundedFlat,
    Sampled,
    Sampled2D,
    ShapePreserving,
    SmoothingSpline,
    Sphere,
    SphereOnSphere,
    Sum,
    TruncatedCone,
    TruncatedParaboloid,
    TruncatedSphere,
    Waviness,
    Worn,
)
from pymdr.problem.rheology import KelvinVoigt, Maxwell, Prony, StandardSolid

PROFILES: dict[str, type] = {
    "sphere": Sphere,
    "sphere_on_sphere": SphereOnSphere,
    "paraboloid": Paraboloid,
    "cone": Cone,
    "power_law": PowerLaw,
    "flat_punch": FlatPunch,
    "ellipsoid": Ellipsoid,
    "hyperboloid": Hyperboloid,
    "rounded_cone": RoundedCone,
    "truncated_cone": TruncatedCone,
    "truncated_paraboloid": TruncatedParaboloid,
    "truncated_sphere": TruncatedSphere,
    "rounded_flat": RoundedFlat,
    "domed_punch": DomedPunch,
    "concave_punch": ConcavePunch,
    "waviness": Waviness,
    "area_function": AreaFunction,
    "sampled": Sampled,
    "force_curve": ForceCurve,
    "sum": Sum,
    "interpolated": Interpolated,
    "elliptic_paraboloid": EllipticParaboloid,
    "pyramid": Pyramid,
    "sampled_2d": Sampled2D,
    "worn": Worn,
}

MATERIALS: dict[str, type] = {
    "elastic": Elastic,
    "transversely_isotropic": TransverselyIsotropic,
    "graded": Graded,
    "viscoelastic": Viscoelastic,
    "layered": Layered,
    "elastic_plastic": ElasticPlastic,
    "rigid": Rigid,
}

SOLIDS: dict[str, type] = {"elastic": Elastic, "viscoelastic": Viscoelastic, "rigid": Rigid}
"""Materials of layers and their base; a base does not relax."""

RHEOLOGIES: dict[str, type] = {
    "prony": Prony,
    "maxwell": Maxwell,
    "standard_solid": StandardSolid,
    "kelvin_voigt": KelvinVoigt,
    "power_law_rheology": PowerLawRheology,
}

ADHESION: dict[str, type] = {"jkr": JKR, "maugis_dugdale": MaugisDugdale, "dmt": DMT, "capillary": Capillary}

FRICTION: dict[str, type] = {"coulomb": Coulomb}

LEGS: dict[str, type] = {"ramp": Ramp, "cycle": Cycle, "hold": Hold, "path": Path}

ONE_CHANNEL_LEGS: dict[str, str] = {
    "indent": "indentation",
    "load": "normal_force",
    "travel": "travel",
    "shift": "shift",
    "drag": "tangential_force",
    "twist": "twist",
}
"""Kinds that are a ramp of one channel."""

ORBIT_LEGS: dict[str, Callable[..., Path]] = {"circle": circle, "lissajous": lissajous}
"""Kinds that are a path in the plane; results save their rows."""

INTERPOLATIONS: dict[str, type] = {
    "cubic_spline": CubicSpline,
    "shape_preserving": ShapePreserving,
    "smoothing_spline": SmoothingSpline,
}

MACHINE_BODIES: dict[str, type] = {"mass": Mass, "rotor": Rotor, "drive": Drive}
MACHINE_LINKS: dict[str, type] = {"spring": Spring, "joint": Joint, "force": Force}

TABLES: dict[str, dict[str, type]] = {
    "profile": PROFILES,
    "material": MATERIALS,
    "solid": SOLIDS,
    "adhesion": ADHESION,
    "friction": FRICTION,
    "leg": LEGS,
    "interpolation": INTERPOLATIONS,
    "rheology": RHEOLOGIES,
    "machine_body": MACHINE_BODIES,
    "machine_link": MACHINE_LINKS,
}

KIND_OF: dict[type, str] = {cls: kind for table in TABLES.values() for kind, cls in table.items()}


def kinds() -> set[str]:
    """All values of kind = in cases."""
    return {kind for table in TABLES.values() for kind in table} | set(ONE_CHANNEL_LEGS) | set(ORBIT_LEGS)


_WITH_KINDS = ("profile", "body", "counterbody", "adhesion")
"""Tables of a case whose kinds users may register."""


def unknown_kinds(case: Mapping[str, Any]) -> list[str]:
    """Kinds in the plain dictionaries of a case that are not registered; the case may be invalid."""
    known = kinds()
    pending: list[Any] = [case.get(name) for name in reversed(_WITH_KINDS)]
    unknown = []
    while pending:
        value = pending.pop()
        if isinstance(value, Mapping):
            kind = value.get("kind")
            if isinstance(kind, str) and kind not in known:
                unknown.append(kind)
            pending += list(value.values())[::-1]
        elif isinstance(value, list | tuple) and value and isinstance(value[0], Mapping):
            pending += reversed(value)
    return unknown
