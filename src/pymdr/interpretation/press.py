"""Claims of surfaces pressed by boundary elements."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from pymdr.interpretation.validity import SOURCES, Assumption, Claim, Level
from pymdr.units import FloatArray

_RESPONSES = ("normal_force", "indentation", "normal_stiffness", "elastic_energy")
_DETAILS = ("contact_area", "mean_pressure", "peak_pressure")
_STEEPEST, _COARSEST = 0.3, 0.1
_FORCE, _STIFFNESS, _AREA = 0.15, 0.2, 0.4
"""Least relative errors times the number n of pixels in the radius of a disk of equal area (times n^2 for the force); from Hertz."""


def press_claims(
    columns: Mapping[str, FloatArray], prescribed: str, punch: bool, package: str
) -> dict[str, Claim]:
    """
    Claims of pressed surfaces.

    Parameters
    ----------
    columns : mapping of str to ndarray
        Values over the loads; those with half the pixels along both sides as ``coarse_``; ``rise`` of the summit above the highest
        pixel in m.
    prescribed : str
        "normal_force" or "indentation".
    punch : bool
        Whether the body ends where the heights end.
    """
    errors = _errors(columns, prescribed)
    within = np.ones(columns["pixels"].shape, dtype=bool) if punch else columns["touches_border"] == 0.0
    solver = (
        f"boundary elements ({package}) on these pixels, exact for elastic half-spaces and small slopes up to the pixel size; the error is "
        "the change with every second pixel along both sides, at least that of a Hertz contact with as many pixels; depths are measured from "
        "the highest pixel, and a summit between pixels may be higher"
    )
    details = {
        "contact_area": "; this is the area at this resolution: finer roughness makes it smaller; pixels on the outline count with the "
        "fraction in contact on average",
        "mean_pressure": "; this is the force over the area at this resolution: finer roughness makes it larger",
        "peak_pressure": "; this is the mean over the most loaded pixel: the peak is higher at corners and with finer roughness",
    }
    claims = {}
    for name in (*_RESPONSES, *_DETAILS):
        source = SOURCES["contact-outline" if name == "contact_area" else "boundary-elements"]
        if not within.any():
            claims[name] = Claim(Level.NOT_VALID, _AT_BORDER, source, within)
            continue
        reason = solver + details.get(name, "")
        if not within.all():
            reason += f"; at {int((~within).sum())} of {within.size} loads {_AT_BORDER}"
        claims[name] = Claim(Level.APPROXIMATE, reason, source, within, errors[name])
    everywhere = np.ones(within.shape, dtype=bool)
    claims[prescribed] = Claim(Level.EXACT, "prescribed", SOURCES["boundary-elements"], everywhere)
    return claims


_AT_BORDER = (
    "the contact reaches the border of the heights, but the body continues beyond it and the force would be larger; use a larger part "
    "of the surface or smaller loads, or punch=True if the body ends there"
)


def _errors(columns: Mapping[str, FloatArray], prescribed: str) -> dict[str, FloatArray]:
    radius = np.sqrt(columns["pixels"] / math.pi)
    least = {"normal_force": _FORCE / radius**2, "normal_stiffness": _STIFFNESS / radius}
    least |= {"indentation": least["normal_force"], "contact_area": _AREA / radius}
    errors = {}
    for name, lowest in least.items():
        # a contact unresolved by half the pixels has an error of its own size
        with np.errstate(divide="ignore", invalid="ignore"):
            change = np.abs(columns[f"coarse_{name}"] / columns[name] - 1.0)
        errors[name] = np.maximum(change, lowest)
    # the indentation is measured from the highest pixel, but the summit may be between pixels
    rise = columns["rise"]
    for name in ("indentation", "normal_stiffness", "contact_area"):
        errors[name] = errors[name] + rise / columns["indentation"]
    errors["normal_force"] = (
        errors["normal_force"] + rise * columns["normal_stiffness"] / columns["normal_force"]
    )
    response = errors["indentation" if prescribed == "normal_force" else "normal_force"]
    errors["elastic_energy"] = 2.0 * response
    errors["mean_pressure"] = errors["contact_area"] + (response if prescribed == "indentation" else 0.0)
    errors["peak_pressure"] = np.maximum(errors["mean_pressure"], response)
    return errors


def press_assumptions(columns: Mapping[str, FloatArray], deepest: int) -> tuple[Assumption, ...]:
    """Assumptions of the model and the grid, measured."""
    errors = np.abs(columns["coarse_normal_stiffness"] / columns["normal_stiffness"] - 1.0)
    return (
        Assumption(
            "small slope",
            "root mean square of the slope in the largest contact",
            float(columns["rms_slope"][deepest]),
            _STEEPEST,
        ),
        Assumption(
            "resolved contact",
            "largest relative change of the stiffness on half the pixels along both sides",
            float(errors.max()),
            _COARSEST,
        ),
    )
