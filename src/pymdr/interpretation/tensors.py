"""Measures of a stress: principal stresses, equivalent stresses, and components in turned axes.

The first axis of a tensor holds the components 11, 22, 33, 13, 12, 23; the last two may be left out where they vanish. They are rr, tt,
zz, rz, rt, tz around the axis, and xx, yy, zz, xz, xy, yz in fixed directions.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from pymdr.units import FloatArray


def principal_stresses(tensor: FloatArray) -> FloatArray:
    """
    Principal stresses in Pa, falling, shape (3, ...).

    Parameters
    ----------
    tensor : ndarray, shape (4, ...) or (6, ...)
        Components in Pa.

    Examples
    --------
    >>> principal_stresses(np.array([0.0, 1.0, 0.0, 2.0])).tolist()
    [2.0, 1.0, -2.0]
    >>> principal_stresses(np.array([1.0, 1.0, 0.0, 0.0, 2.0, 0.0])).round(12).tolist()
    [3.0, 0.0, -1.0]
    """
    if tensor.shape[0] == 4:
        rr, tt, zz, rz = tensor
        middle, half = 0.5 * (rr + zz), np.hypot(0.5 * (rr - zz), rz)
        return np.asarray(np.sort([middle + half, tt, middle - half], axis=0)[::-1])
    xx, yy, zz, xz, xy, yz = tensor
    whole = np.moveaxis(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), (0, 1), (-2, -1))
    finite = np.isfinite(whole).all(axis=(-2, -1))
    values = np.linalg.eigvalsh(np.where(finite[..., None, None], whole, 0.0))
    return np.asarray(np.moveaxis(np.where(finite[..., None], values, np.nan)[..., ::-1], -1, 0))


def von_mises(tensor: FloatArray) -> FloatArray:
    """
    Equivalent stress of von Mises in Pa.

    Examples
    --------
    >>> float(von_mises(np.array([0.0, 0.0, -3.0, 0.0])))
    3.0
    """
    rr, tt, zz = tensor[:3]
    squares = 0.5 * ((rr - tt) ** 2 + (tt - zz) ** 2 + (zz - rr) ** 2) + 3.0 * np.sum(tensor[3:] ** 2, axis=0)
    return np.asarray(np.sqrt(squares))


def tresca(tensor: FloatArray) -> FloatArray:
    """
    Equivalent stress of Tresca in Pa: the difference of the largest and the smallest principal stress.

    Examples
    --------
    >>> float(tresca(np.array([0.0, 0.0, -3.0, 0.0])))
    3.0
    """
    principal = principal_stresses(tensor)
    return np.asarray(principal[0] - principal[2])


def hydrostatic(tensor: FloatArray) -> FloatArray:
    """
    The mean normal stress in Pa, tension positive.

    Examples
    --------
    >>> float(hydrostatic(np.array([1.0, 2.0, 3.0, 0.0])))
    2.0
    """
    return np.asarray((tensor[0] + tensor[1] + tensor[2]) / 3.0)


def fixed_axes(tensor: FloatArray, cosine: FloatArray | float, sine: FloatArray | float) -> FloatArray:
    """
    Components around the axis in fixed directions.

    Parameters
    ----------
    tensor : ndarray, shape (6, ...)
        rr, tt, zz, rz, rt, tz.
    cosine, sine : ndarray
        Of the angle from x to the radius.

    Returns
    -------
    ndarray, shape (6, ...)
        xx, yy, zz, xz, xy, yz.

    Examples
    --------
    >>> fixed_axes(np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]), 0.0, 1.0).tolist()
    [2.0, 1.0, 3.0, -6.0, -5.0, 4.0]
    """
    rr, tt, zz, rz, rt, tz = tensor
    c, s = cosine, sine
    cross = 2.0 * c * s * rt
    return np.array(
        [
            c * c * rr + s * s * tt - cross,
            s * s * rr + c * c * tt + cross,
            zz,
            c * rz - s * tz,
            c * s * (rr - tt) + (c * c - s * s) * rt,
            s * rz + c * tz,
        ]
    )


DERIVED: Mapping[str, Callable[[FloatArray], FloatArray]] = {
    "stress": lambda tensor: tensor,
    "principal_stress": principal_stresses,
    "von_mises": von_mises,
    "tresca": tresca,
    "hydrostatic": hydrostatic,
}
"""Measures of the stress, by field."""
