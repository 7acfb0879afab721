"""Models as nanite takes them: a function of the tip position, its parameters, their names and units."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import NamedTuple

import lmfit
import numpy as np
from nanite.model.logic import register_model
from nanite.model.residuals import compute_contact_point_weights

import pymdr as mdr
from pymdr_nanite.curves import (
    Pulled,
    adhesive_branch,
    adhesive_residual,
    contact_of,
    elastic_force,
    force_with_memory,
)


class Parameter(NamedTuple):
    """A parameter of a model, as nanite shows it."""

    key: str
    name: str
    unit: str
    value: float
    low: float = -math.inf
    high: float = math.inf
    vary: bool = False


_YOUNG = Parameter("E", "Young's Modulus", "Pa", 3e3, 1e-3, math.inf, True)
_RADIUS = Parameter("R", "Tip Radius", "m", 5e-6, 1e-12)
_ANGLE = Parameter("alpha", "Angle Between Axis And Flank", "°", 35.0, 0.1, 89.9)
_POISSON = Parameter("nu", "Poisson's Ratio", "", 0.5, -0.99, 0.5)
_WORK = Parameter("work", "Work Of Adhesion", "J/m²", 1e-4, 1e-12, math.inf, True)
_RANGE = Parameter("range", "Range Of Attraction", "m", 1e-9, 1e-13)
_THICKNESS = Parameter("thickness", "Thickness Of Layer", "m", 5e-6, 1e-12)
_RATIO = Parameter("ratio", "Relaxing Over Equilibrium Modulus", "", 1.0, 1e-6)
_TAU = Parameter("tau", "Relaxation Time", "s", 0.1, 1e-9)
_INTERVAL = Parameter("interval", "Time Between Samples", "s", 1e-3, 1e-12)
_ORIGINS = (
    Parameter("contact_point", "Contact Point", "m", 0.0, vary=True),
    Parameter("baseline", "Force Baseline", "N", 0.0, vary=True),
)


def _unit(nu):
    return mdr.Elastic(1.0, nu)


def _sphere(depth, E, R, nu):
    return elastic_force(contact_of(mdr.Sphere(R), _unit(nu)), E, depth)


def _cone(depth, E, alpha, nu):
    return elastic_force(contact_of(mdr.Cone(half_angle=math.radians(alpha)), _unit(nu)), E, depth)


def _pyramid(sides):
    def force(depth, E, alpha, nu):
        profile = mdr.Pyramid(sides, half_angle=math.radians(alpha))
        return elastic_force(contact_of(profile, _unit(nu)), E, depth)

    return force


def _jkr(depth, E, work, R, nu):
    return adhesive_branch(contact_of(mdr.Paraboloid(R), _unit(nu), mdr.JKR(1.0)), E, work, depth)


def _maugis(depth, E, work, R, range, nu):
    law = mdr.MaugisDugdale(1.0, range=range)
    return adhesive_branch(contact_of(mdr.Paraboloid(R), _unit(nu), law), E, work, depth)


def _layer(depth, E, R, thickness, nu):
    body = mdr.Layered((mdr.Layer(_unit(nu), thickness),), mdr.Rigid())
    return elastic_force(contact_of(mdr.Paraboloid(R), body), E, depth)


def _memory(depth, E, R, ratio, tau, interval, nu):
    shear = E / (2.0 * (1.0 + nu))
    body = mdr.Viscoelastic(mdr.StandardSolid(shear, ratio * shear, tau), poisson=nu)
    return force_with_memory(mdr.Contact(mdr.Paraboloid(R), body), interval, depth)


def _model(key: str, name: str, force: Callable, own: tuple[Parameter, ...]) -> SimpleNamespace:
    """A model, with the function that nanite calls."""
    parameters = (*own, _POISSON, *_ORIGINS)
    keys = [one.key for one in parameters]

    def model_func(delta, *values, **named):
        given = dict(zip(keys, values, strict=False)) | named
        point, baseline = given.pop("contact_point", 0.0), given.pop("baseline", 0.0)
        depth = point - np.asarray(delta, dtype=float)  # nanite's positions fall toward the body
        return forces(depth, given) + baseline

    def forces(depth, given):
        result = force(depth, **given)
        return np.where(depth >= result.fold, result.force, 0.0) if isinstance(result, Pulled) else result

    def residual(params, delta, force_measured, weight_cp=5e-7):
        given = params.valuesdict()
        point, baseline = given.pop("contact_point"), given.pop("baseline")
        depth, measured = point - np.asarray(delta, dtype=float), force_measured - baseline
        # in the order of measurement a retreat begins at the deepest sample
        missed = adhesive_residual(force(depth, **given), depth, measured)
        return missed * compute_contact_point_weights(point, delta, weight_cp) if weight_cp else missed

    model_func.__doc__ = f"{name} by pymdr: force in N over the tip position in m."
    model_func.__signature__ = inspect.Signature(
        [inspect.Parameter(one, inspect.Parameter.POSITIONAL_OR_KEYWORD) for one in ("delta", *keys)]
    )

    def get_parameter_defaults():
        defaults = lmfit.Parameters()
        for one in parameters:
            defaults.add(one.key, value=one.value, min=one.low, max=one.high, vary=one.vary)
        return defaults

    own_residual = {"residual": residual} if _WORK in own else {}
    return SimpleNamespace(
        **own_residual,
        get_parameter_defaults=get_parameter_defaults,
        model_doc=model_func.__doc__,
        model_func=model_func,
        model_key=key,
        model_name=name,
        parameter_keys=keys,
        parameter_names=[one.name for one in parameters],
        parameter_units=[one.unit for one in parameters],
        valid_axes_x=["tip position"],
        valid_axes_y=["force"],
    )


MODELS = {
    one.model_key: one
    for one in (
        _model("pymdr_sphere", "sphere (pymdr)", _sphere, (_YOUNG, _RADIUS)),
        _model("pymdr_cone", "cone (pymdr)", _cone, (_YOUNG, _ANGLE)),
        _model("pymdr_pyr3s", "pyramid, three-sided (pymdr)", _pyramid(3), (_YOUNG, _ANGLE)),
        _model("pymdr_pyr4s", "pyramid, four-sided (pymdr)", _pyramid(4), (_YOUNG, _ANGLE)),
        _model("pymdr_jkr", "JKR (pymdr)", _jkr, (_YOUNG, _WORK, _RADIUS)),
        _model("pymdr_maugis", "Maugis-Dugdale (pymdr)", _maugis, (_YOUNG, _WORK, _RADIUS, _RANGE)),
        _model("pymdr_layer", "layer on a rigid support (pymdr)", _layer, (_YOUNG, _RADIUS, _THICKNESS)),
        _model("pymdr_memory", "standard solid (pymdr)", _memory, (_YOUNG, _RADIUS, _RATIO, _TAU, _INTERVAL)),
    )
}
"""The models by their keys."""


def register():
    """
    Register all models in nanite.

    Returns
    -------
    list of nanite.model.core.NaniteFitModel
    """
    return [register_model(model) for model in MODELS.values()]


def register_tip(profile, key, *, name=None, adhesion=None):
    """
    Register the model of any tip.

    Parameters
    ----------
    profile : pymdr profile
        Any, also measured ones (``pymdr.Sampled``), pyramids and sums.
    key : str
        Key of the model in nanite.
    name : str, optional
        The key by default.
    adhesion : {None, "jkr"}
        Whether the work of adhesion is a parameter.

    Returns
    -------
    nanite.model.core.NaniteFitModel

    Raises
    ------
    ValueError
        If `adhesion` is neither None nor "jkr".
    """
    if adhesion not in (None, "jkr"):
        raise ValueError(f"adhesion = {adhesion!r}; it is None or 'jkr'")

    def bare(depth, E, nu):
        return elastic_force(contact_of(profile, _unit(nu)), E, depth)

    def adhesive(depth, E, work, nu):
        return adhesive_branch(contact_of(profile, _unit(nu), mdr.JKR(1.0)), E, work, depth)

    own, force = ((_YOUNG,), bare) if adhesion is None else ((_YOUNG, _WORK), adhesive)
    return register_model(_model(key, name or key, force, own))
