"""The mean profile of a measured bump about its apex."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from pymdr.deferred import mpl, xr
from pymdr.errors import ProblemError
from pymdr.mapping.surfaces.summits import MeanProfile, mean_profile
from pymdr.presentation import plot
from pymdr.problem.profiles import Sampled
from pymdr.problem.topography import Topography
from pymdr.solving.study import Study, dataset
from pymdr.units import ArrayQuantityLike, QuantityLike, metres, shown, to_si, to_si_array

_DRAWN = 400


@dataclass(frozen=True, kw_only=True)
class AzimuthalProfile(Study):
    """A bump as a body of revolution; :func:`pymdr.read_profile` and case files read its CSV file."""

    data: xr.Dataset
    """Over the radius ``r``: the heights ``f`` and their ``scatter``, in m."""
    profile: Sampled
    """The azimuthal mean with its scatter, for :class:`pymdr.Contact`."""
    centre: tuple[float, float]
    """x and y in m of the apex."""
    radii: tuple[float, float]
    """Principal radii of curvature of its cap in m, the smaller first; inf if it is flat."""
    below_summit: float
    """
    Distance in m of the apex of the mean, the origin of indentations of the profile, below the highest height of the bump, the origin in
    :func:`pymdr.press` and :class:`pymdr.Sampled2D`: an indentation d there is d - below_summit of the profile.
    """
    topography: Topography

    subject: ClassVar = "a mean profile"

    def _remarks(self) -> list[str]:
        x, y = (metres(one) for one in self.centre)
        low, high = (metres(one) for one in self.radii)
        scatter = metres(float(np.sqrt(np.mean(self.data["scatter"].values ** 2))))
        below = metres(self.below_summit)
        return [
            f"one bump with its apex at ({x}, {y}), known up to r = {metres(self.profile.max_radius)}, where it is "
            f"{metres(float(self.profile.height[-1]))} lower",
            f"principal radii of its cap {low} and {high}",
            f"heights at one radius scatter by {scatter} (root mean square)",
            f"its apex is {below} below the highest height. If the bump does not tilt, the force on the mean profile at an indentation "
            f"of d - {below} is a rigorous lower bound of the force on the bump at d below its highest height (as in press)",
        ]

    def _figure(self) -> mpl.figure.Figure:
        """The surface with the apex, and the mean with its scatter and the curve through it."""
        r = np.linspace(0.0, self.profile.max_radius, _DRAWN)
        return plot.bump_study(
            self.topography.heights,
            self.topography.size,
            self.centre,
            (self.data["r"].values, self.data["f"].values, self.data["scatter"].values),
            (r, self.profile.gap(r) + self.profile.offset),
        )


def azimuthal_profile(
    topography: Topography,
    *,
    centre: ArrayQuantityLike | None = None,
    max_radius: QuantityLike | None = None,
) -> AzimuthalProfile:
    """
    The azimuthal mean about the apex of a surface that is one bump, as a profile.

    Parameters
    ----------
    topography : Topography
        Without missing heights.
    centre : pair of quantities, optional
        x and y in m of the axis. By default the vertex of the paraboloid fitted to the cap, up to half of `max_radius`.
    max_radius : quantity, optional
        The last radius in m; by default the distance from the apex to the nearest edge.

    Returns
    -------
    AzimuthalProfile
        Its ``profile`` has one sample per pixel; its scatter is the standard deviation of heights at one radius.

    Raises
    ------
    ProblemError
        If the surface is not one bump: its apex is within 8 pixels of the edge or is not a summit; heights at one radius
        scatter by more than 15 % of the height of the mean profile, after subtraction of the noise; or a second summit exceeds the
        noise and a tenth of that height.

    See Also
    --------
    read_topography : heights from a file.

    Notes
    -----
    The force on the mean profile is a lower bound of that on the body with the plane at the same height, whatever the centre (Shield 1967
    with Barber 1974), second-order accurate in the asymmetry, if it does not tilt. Indentations of
    the profile are relative to its own apex, `below_summit` deeper than those of :func:`pymdr.press`.

    References
    ----------
    - Shield (1967), J. Appl. Math. Phys. 18, 682-693.
    - Barber (1974), Int. J. Eng. Sci. 12, 813-819.

    Examples
    --------
    >>> import numpy as np
    >>> import pymdr as mdr
    >>> x = (np.arange(64) + 0.5) * 10e-9
    >>> ball = mdr.Topography(-np.add.outer((x - 300e-9) ** 2, (x - 340e-9) ** 2) / 2e-6, 640e-9)
    >>> bump = mdr.azimuthal_profile(ball)
    >>> [round(one * 1e9, 6) for one in (*bump.centre, *bump.radii)]
    [300.0, 340.0, 1000.0, 1000.0]
    """
    if not isinstance(topography, Topography):
        raise ProblemError(
            f"{shown(topography)} is not a Topography; read one with read_topography, or write Topography(heights, size)"
        )
    heights = topography.complete()
    middle = None
    if centre is not None:
        given = to_si_array(centre, "m", name="centre")
        if given.shape != (2,) or np.any(given <= 0.0) or np.any(given >= topography.size):
            raise ProblemError(f"centre = {shown(centre)}; give x and y of a point within the patch")
        middle = (float(given[0]), float(given[1]))
    last = None if max_radius is None else to_si(max_radius, "m", name="max_radius")
    if last is not None and not last > 0.0:
        raise ProblemError(f"max_radius = {shown(max_radius)}; it must be above 0 m")
    bump = mean_profile(heights, topography.spacing, middle, last)
    columns = {"f": bump.height, "scatter": bump.scatter}
    return AzimuthalProfile(
        data=dataset(
            {name: ("r", values, {"units": "m"}) for name, values in columns.items()},
            coords={"r": ("r", bump.radius, {"units": "m"})},
        ),
        notes=topography.steps,
        profile=Sampled(bump.radius, bump.height, scatter=bump.scatter),
        centre=bump.centre,
        radii=_radii(bump),
        below_summit=bump.below_summit,
        topography=topography,
    )


def _radii(bump: MeanProfile) -> tuple[float, float]:
    sharp, blunt = (1.0 / bend if bend > 0.0 else float("inf") for bend in bump.curvatures)
    return sharp, blunt
