"""Worn profiles in files."""

from __future__ import annotations

import os

import numpy as np

from pymdr.presentation.tables import write_csv
from pymdr.solving.wear import Wear
from pymdr.units import FloatArray

_INNER = 64
"""Number of samples in the worn ring."""


def write_worn_profile(study: Wear, file: str | os.PathLike[str]) -> None:
    """
    Write a worn profile as columns radius and height, in m.

    Parameters
    ----------
    file : path
        CSV file that ``Sampled`` profiles of case files read.
    """
    worn = study.worn()
    first, last = float(worn.radius[0]), float(worn.radius[-1])
    inner = np.linspace(0.0, first, _INNER, endpoint=False) if first > 0.0 else np.zeros(1)
    outer = np.linspace(last, 1.5 * last, _INNER // 2)[1:]
    radii: FloatArray = np.unique(np.concatenate([inner, worn.radius, outer[outer <= worn.max_radius]]))
    write_csv({"radius [m]": radii, "height [m]": worn.gap(radii)}, file, ())
