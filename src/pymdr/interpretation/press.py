"""What can be claimed of a surface that boundary elements have pressed."""

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
"""Least relative errors, over the square and the first power of the pixels in the radius of a disk of the area; from Hertz."""


def press_claims(
    columns: Mapping[str, FloatArray], prescribed: str, punch: bool, package: str
) -> dict[str, Claim]:
    """
    Claims of pressed surfaces.

    Parameters
    ----------
    columns : mapping of str to ndarray
        Numbers of the loads, those on half the pixels along both sides as ``coarse_``; ``rise`` of the summit above the highest pixel
        in m.
    prescribed : str
        "normal_force" or "indentation".
    punch : bool
        Whether the body ends where the heights end.
    package : str
        Of the engine.

    Returns
    -------
    dict of str to Claim
    """
    errors = _errors(columns, prescribed)
    within = np.ones(columns["pixels"].shape, dtype=bool) if punch else columns["touches_border"] == 0.0
    solver = (
        f"boundary elements ({package}) on these pixels, exact for elastic half-spaces and small slopes but for their width; the error is the "
        "change to every second pixel along both sides, and no less than that of Hertz on as many pixels; depths are counted from the highest "
        "pixel, above which a summit may rise between pixels"
    )
    details = {
        "contact_area": "; roughness that is finer than the pixels makes the true area smaller: it is the area at this resolution; "
        "pixels on the outline are counted by what of them is in contact on average",
        "mean_pressure": "; the force over the area at this resolution: finer roughness makes it larger",
        "peak_pressure": "; the mean over the pixel that bears most: at corners, and of finer roughness, the peak is higher",
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
    "the contact reaches the border of the heights, beyond which the body goes on: the force would be larger there; take a larger "
    "part of the surface or smaller loads, or say punch=True where the body ends there"
)


def _errors(columns: Mapping[str, FloatArray], prescribed: str) -> dict[str, FloatArray]:
    radius = np.sqrt(columns["pixels"] / math.pi)
    least = {"normal_force": _FORCE / radius**2, "normal_stiffness": _STIFFNESS / radius}
    least |= {"indentation": least["normal_force"], "contact_area": _AREA / radius}
    errors = {}
    for name, floor in least.items():
        # what half the pixels do not see at all is wrong by as much as itself
        with np.errstate(divide="ignore", invalid="ignore"):
            change = np.abs(columns[f"coarse_{name}"] / columns[name] - 1.0)
        errors[name] = np.maximum(change, floor)
    # the summit may stand between pixels, from the highest of which the indentation is counted
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
    """What the model and the grid assume, measured."""
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
