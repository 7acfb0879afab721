"""
Hardness and modulus against micromechanics and nanodent, on the example files of their archives.

``PYMDR_INDENTS`` names a folder with further files (the .hld of nanodent's source archive); the .xls is inside micromechanics. Each comparison
takes the same rows and constants in both packages; the largest relative differences are printed, the times of reading and evaluating are the ratio.
"""

import contextlib
import io
import os
import time
from collections.abc import Iterator
from importlib.util import find_spec
from itertools import product
from pathlib import Path
from types import SimpleNamespace

import numpy as np

import pymdr as mdr
from benchmarks.timing import Ratio
from pymdr.errors import PymdrError
from pymdr.workbench.indents import area_function_of

AIM = "hardness and modulus within 0.5 %"
RANGE = (0.25, 0.98)
_DRAWS = 12
"""Synthetic records of a known stiffness for each file."""
BLOCKS = (1, 48)
"""Rows of a block whose mean is a row: as measured, and with little noise."""


def ratios() -> Iterator[Ratio]:
    """One ratio for each package that is installed."""
    missing = [name for name in ("micromechanics", "nanodent") if find_spec(name) is None]
    for name in missing:
        print(f"{name} is not installed: pip install {name} in an environment of its own")
    if "micromechanics" not in missing:
        yield from _against_micromechanics()
    if "nanodent" not in missing:
        folder = Path(os.environ.get("PYMDR_INDENTS", "."))
        files = sorted(folder.rglob("*.hld"))
        if not files:
            print(
                f"no .hld in {folder}: name a folder of them with PYMDR_INDENTS, such as tests/data of nanodent"
            )
        else:
            yield from _against_nanodent(files)


def _against_micromechanics() -> Iterator[Ratio]:
    """Continuous stiffness of its example, row by row: h_c = h - 0.75 F/S, E_r = S sqrt(pi/A)/2, H = F/A."""
    with contextlib.redirect_stdout(io.StringIO()):
        from micromechanics import indentation
        from micromechanics.indentation import Indentation, Tip
    file = Path(indentation.__file__).parent / "data/Example.xls"
    mdr.read_indents(file)  # imports are not timed
    start = time.process_time()
    indents = mdr.read_indents(file)
    tip = area_function_of(indents)
    assert tip is not None
    own = [_continuous(indent, tip) for indent in indents]
    ours = time.process_time() - start
    start = time.process_time()
    worst, rows = np.zeros(2), 0
    coefficients = list(indents[0].attrs["area_coefficients"])
    with contextlib.redirect_stdout(io.StringIO()):
        other = Indentation(str(file), tip=Tip([*coefficients, "iso"]), nuMat=0.18)
        results = {}
        while True:
            other.analyse()
            results[other.testName] = (other.valid.copy(), other.modulusRed, other.hardness)
            if not other.testList:
                break
            other.nextTest()
    theirs = time.process_time() - start
    for indent, (modulus, hardness) in zip(indents, own, strict=True):
        valid, their_modulus, their_hardness = results[indent.attrs["test"]]
        deep = indent["indentation"].values[valid] > 0.1 * float(indent["indentation"].max())
        rows += int(np.count_nonzero(deep))
        both = ((modulus, their_modulus), (hardness, their_hardness * 1e9))
        for k, (a, b) in enumerate(both):
            b = np.asarray(b) * (1e9 if k == 0 else 1.0)
            worst[k] = max(worst[k], float(np.max(np.abs(a[valid][deep] / b[deep] - 1.0))))
    print(
        f"micromechanics, {rows} rows of continuous stiffness: E_r within {100 * worst[0]:.2g} %, H within {100 * worst[1]:.2g} %"
    )
    yield Ratio(
        "reading and evaluating a .xls with continuous stiffness", "micromechanics", ours, theirs, AIM
    )


def _continuous(indent: object, tip: mdr.AreaFunction) -> tuple[np.ndarray, np.ndarray]:
    depth, force, stiffness = (
        indent[name].values for name in ("indentation", "normal_force", "harmonic_stiffness")
    )
    with np.errstate(all="ignore"):
        contact = depth - 0.75 * force / stiffness
        known = np.isfinite(contact) & (contact > 0.0)
        area = np.where(known, tip.area_at(np.where(known, contact, 1e-9)), np.nan)
        return 0.5 * stiffness * np.sqrt(np.pi / area), force / area


def _stiffness(fitted, peak: float) -> float:
    """Stiffness of a power law of nanodent at the largest force."""
    m = fitted.power_law_m
    return m * fitted.power_law_k ** (1.0 / m) * peak ** (1.0 - 1.0 / m)


def _known_stiffness(rows, law, analyse) -> str:
    """The error of a fit without a correction, on rows of a known power law with the noise of the depths of a record."""
    rng, m, stiffness, peak = np.random.default_rng(1), law["exponent"], law["stiffness"], rows.peak_force
    depth, force = rows.depth[rows.fitted], np.sort(rows.force[rows.fitted])[::-1]

    def depths(force):
        return -(m * peak / stiffness) * (1.0 - (force / peak) ** (1.0 / m))

    left = depth - depths(rows.force[rows.fitted])
    noise = float(np.std(np.diff(left))) / 2.0**0.5
    errors = []
    for _ in range(_DRAWS):
        noisy = depth.max() + depths(force) + noise * rng.normal(size=force.size)
        errors.append(1e3 * _stiffness(analyse(1e9 * noisy, 1e6 * force), 1e6 * peak) / stiffness - 1.0)
    return (
        f"with its noise of {1e9 * noise:.2g} nm nanodent's stiffness of rows of a known one errs by {100 * np.mean(errors):+.2g} % "
        f"(scatter {100 * np.std(errors):.2g} %)"
    )


def _against_nanodent(files: list[Path]) -> Iterator[Ratio]:
    """
    The power law of the unloading, on the rows from 0.98 to 0.25 of the largest force, and the area function of each file.

    pymdr fits the depths where their noise is larger than that of the forces, and nanodent the forces: the procedure is the same where that noise is
    small, in means of blocks of rows.
    """
    from nanodent.analysis.oliver_pharr import analyze_oliver_pharr

    ours = theirs = 0.0
    for file, block in product(files, BLOCKS):
        start = time.process_time()
        read = mdr.read_indents(file)
        tip = area_function_of(read)
        assert tip is not None
        indents = [one.coarsen(step=block, boundary="trim").mean() for one in read]
        try:
            study = mdr.oliver_pharr(indents, tip, fit_range=RANGE)
        except PymdrError as refusal:
            print(f"{file.name}, means of {block}: refused: {refusal}")
            continue
        ours += time.process_time() - start
        rows = study.indents[0].rows
        depth, force = rows.depth[rows.fitted], rows.force[rows.fitted]
        start = time.process_time()
        other = analyze_oliver_pharr(depth * 1e9, force * 1e6)
        theirs += time.process_time() - start
        law = study.indents[0].by["power_law"].values
        if block == 1:
            print(f"{file.name}: {_known_stiffness(rows, law, analyze_oliver_pharr)}")
        here = SimpleNamespace(modulus=law["reduced_modulus"], hardness=law["hardness"])
        peak = rows.peak_force * 1e6
        k, m, residual = other.power_law_k, other.power_law_m, other.power_law_hf_nm
        stiffness = _stiffness(other, peak)
        contact = residual + (peak / k) ** (1.0 / m) - 0.75 * peak / stiffness
        area = float(tip.area_at(contact * 1e-9))
        there = SimpleNamespace(
            modulus=0.5 * stiffness * 1e3 * np.sqrt(np.pi / area), hardness=peak * 1e-6 / area
        )
        print(
            f"{file.name}, means of {block}: E_r = {here.modulus / 1e9:.4g} GPa ({100 * (here.modulus / there.modulus - 1):+.2g} % of nanodent's), H = "
            f"{here.hardness / 1e9:.4g} GPa ({100 * (here.hardness / there.hardness - 1):+.2g} %), exponent {law['exponent']:.3f} and {m:.3f}"
        )
    if theirs > 0.0:
        yield Ratio(
            "unloadings of .hld, with both procedures and intervals",
            "nanodent's power law",
            ours,
            theirs,
            AIM,
        )
