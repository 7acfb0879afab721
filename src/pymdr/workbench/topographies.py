"""Measured surfaces from files: matrices with units by themselves, the formats of makers by SurfaceTopography."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from pymdr.errors import CaseError, FileError, MissingExtraError, errors_of_case
from pymdr.presentation.files import named_file
from pymdr.problem.topography import Topography, preparing
from pymdr.units import ArrayQuantityLike, FloatArray, metres, shown
from pymdr.workbench.inputs import read_bytes, text_of
from pymdr.workbench.topography_makers import of_maker
from pymdr.workbench.topography_texts import (
    ARRAY_MAGIC,
    HOW,
    ForeignError,
    Read,
    height_factor,
    of_array,
    of_text,
)

_LARGEST = 2**31
_LARGEST_TEXT = 200 * 2**20


def read_topography(
    file: str | os.PathLike[str],
    channel: int | str | None = None,
    *,
    size: ArrayQuantityLike | None = None,
    unit: str | None = None,
    missing: str | None = None,
    detrend: str | None = None,
) -> Topography:
    r"""
    Read a measured surface.

    Parameters
    ----------
    file : path
        Whatever its suffix: a text of heights, a row of numbers for every y and a column for every x, with commas, semicolons, tabs or
        blanks between them and above them, as Gwyddion writes it, ``# Width: 10 um``, ``# Height: 10 um``, ``# Value units: nm``; a table with the columns
        ``x [um], y [um], z [nm]`` of places on an even grid; an array (nx, ny) in a ``.npy`` file; or, with the extra
        ``topography``, any of the formats of SurfaceTopography. ``nan``, and places that a table leaves out, were not measured.
    channel : int or str, optional
        Number, from 0 on, or name of the channel, where a file has several; unless given, the one that the file names first.
    size : quantity or pair of quantities, optional
        Sides along x and y in m, where the file has none.
    unit : str, optional
        Unit of the heights, where the file has none, such as "nm".
    missing : {"interpolate", "crop", "keep"}, optional
        Treatment of heights that were not measured, as in :meth:`~pymdr.Topography.fill_missing`; "keep" leaves them nan. Unless given, they
        are refused.
    detrend : {"mean", "plane", "sphere", "curvature"}, optional
        Trend to subtract, as in :meth:`~pymdr.Topography.detrend`; nothing unless given.

    Returns
    -------
    Topography
        Its ``steps`` list what was read and changed.

    Raises
    ------
    FileError
        If the file cannot be read, or not by SurfaceTopography.
    CaseError
        If it is no surface on an even grid but a line scan, scattered points or an archive, has no such channel or other quantities than heights in it, units or sides are missing or
        are given twice, or heights are missing and their treatment is not given.
    MissingExtraError
        If it needs SurfaceTopography, which is not installed.

    Notes
    -----
    Heights are positive out of the body. Instruments filter, and tips are blunt: :meth:`~pymdr.Topography.tip_cutoff` gives the shortest wave that a
    tip resolves.

    Examples
    --------
    >>> import pymdr as mdr
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder) / "step.csv"
    ...     _ = file.write_text("# Width: 3 um\n# Height: 2 um\n# Value units: nm\n1,1,4\n1,1,4\n")
    ...     step = mdr.read_topography(file, detrend="mean")
    >>> step.heights.shape, step.steps
    ((3, 2), ('read from step.csv', 'the mean subtracted, 2 nm'))
    """
    source = named_file(file, "read")
    if detrend is not None and detrend not in preparing.TRENDS:
        raise CaseError(
            f"detrend = {shown(detrend)}: one of {', '.join(preparing.TRENDS)}, or nothing, is needed"
        )
    if missing is not None and missing not in (*preparing.REMEDIES, "keep"):
        raise CaseError(
            f"missing = {shown(missing)}: one of {', '.join(preparing.REMEDIES)} and keep is needed"
        )
    heights = _read(source, channel)
    factor, sides = height_factor(source, heights.unit, unit), _sides(source, heights.size, size)
    with errors_of_case(f"{source}:"):
        surface = Topography(np.asarray(heights.heights, dtype=float) * factor, sides, (heights.step,))
    if surface.missing.any() and missing != "keep":
        count = int(surface.missing.sum())
        if missing is None:
            raise CaseError(
                f"{source}: {count} of {surface.heights.size} heights are missing; give missing: 'interpolate', 'crop' or 'keep'"
            )
        surface = surface.fill_missing(missing)
    return surface if detrend is None else surface.detrend(detrend)


def _sides(source: Path, own: FloatArray | None, given: ArrayQuantityLike | None) -> ArrayQuantityLike:
    if own is not None and given is not None:
        raise CaseError(
            f"{source}: size = {shown(given)}, but the file says {metres(own[0])} x {metres(own[1])}; leave it out"
        )
    sides = own if given is None else given
    if sides is None:
        raise CaseError(f"{source}: no sides of the patch; {HOW}")
    return sides


def _read(source: Path, channel: int | str | None) -> Read:
    content = read_bytes(source, _LARGEST, "file of heights")
    if source.suffix.lower() == ".npy" or content.startswith(ARRAY_MAGIC):
        _refuse_channel(source, channel)
        return of_array(source, content)
    if not content:
        raise CaseError(f"{source}: the file is empty and has no heights; export the heights again")
    text = text_of(content)
    if text is None:
        return of_maker(source, content, channel)
    if len(content) > _LARGEST_TEXT:
        raise CaseError(
            f"{source}: larger than {_LARGEST_TEXT} bytes, the limit of a text of heights; save an array as .npy"
        )
    try:
        heights = of_text(source, text)
    except ForeignError as error:
        try:
            return of_maker(source, content, channel)
        except (FileError, MissingExtraError):
            raise CaseError(str(error)) from None
    if text.lstrip().startswith("#") and (heights.unit is None or heights.size is None):
        # a header in other words than those that are read here
        try:
            foreign = of_maker(source, content, channel)
        except (FileError, MissingExtraError, CaseError):
            pass
        else:
            if foreign.unit is not None and foreign.size is not None:
                return foreign
    _refuse_channel(source, channel)
    return heights


def _refuse_channel(source: Path, channel: int | str | None) -> None:
    if channel not in (None, 0):
        raise CaseError(
            f"{source}: channel {shown(channel)}, but the file has one surface only; leave it out"
        )


def described(surface: Topography) -> str:
    """
    What a surface is, in one line.

    Examples
    --------
    >>> described(Topography([[0.0, 1e-9], [2e-9, 3e-9]], "2 um"))
    '2 x 2 heights on 2 µm x 2 µm, pixels of 1 µm x 1 µm, from 0 m to 3 nm'
    """
    (nx, ny), (width, length) = surface.heights.shape, (metres(one) for one in surface.size)
    across, along = (metres(one) for one in surface.spacing)
    low, high = (metres(float(end(surface.heights))) for end in (np.nanmin, np.nanmax))
    return f"{nx} x {ny} heights on {width} x {length}, pixels of {across} x {along}, from {low} to {high}"
