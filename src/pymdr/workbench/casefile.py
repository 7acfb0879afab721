"""Case files: a problem as TOML."""

from __future__ import annotations

import os
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pymdr.errors import CaseError, FileError
from pymdr.problem.codec import decode_case
from pymdr.problem.contact import Contact
from pymdr.problem.paths import LoadingPath
from pymdr.workbench.tables import read_columns

_LARGEST = 4 * 2**20


@dataclass(frozen=True)
class Case:
    """What a case file says."""

    file: Path
    title: str
    contact: Contact
    path: LoadingPath
    options: dict[str, Any]
    """Keyword arguments of :func:`pymdr.solve`, from the table ``[solve]``."""


def read_case(file: str | os.PathLike[str]) -> Case:
    """
    Read a case file.

    Parameters
    ----------
    file : path
        A TOML file with the tables ``[profile]``, ``[body]``, optionally ``[counterbody]``,
        ``[adhesion]``, ``[friction]`` and ``[solve]``, and one ``[[path]]`` for every leg.

    Returns
    -------
    Case

    Raises
    ------
    FileError
        If the file cannot be read.
    CaseError
        If it is not a case; the message names file, table, key, value and remedy.
    """
    source = Path(file)
    try:
        if source.stat().st_size > _LARGEST:
            raise CaseError(f"{source}: larger than {_LARGEST} bytes, which no case file is")
        text = source.read_text(encoding="utf-8")
    except OSError as error:
        raise FileError(f"cannot read {source}: {error.strerror or error}") from error
    except UnicodeDecodeError as error:
        raise CaseError(
            f"{source}: not a text file in UTF-8 ({error.reason} at byte {error.start})"
        ) from error
    try:
        plain = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise CaseError(f"{source}: not TOML: {error}") from error
    try:
        title, contact, path = decode_case(_with_tables(plain, source.parent))
    except CaseError as error:
        raise CaseError(f"{source}: {error}") from error
    return Case(source, title, contact, path, dict(plain.get("solve", {})))


def _with_tables(plain: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The case with the CSV files that its profiles name read in; paths count from the case file."""
    profile = plain.get("profile")
    if not isinstance(profile, dict):
        return plain
    profile = _with_table(profile, folder)
    if isinstance(profile.get("parts"), list):
        parts = [_with_table(part, folder) if isinstance(part, dict) else part for part in profile["parts"]]
        profile = {**profile, "parts": parts}
    return {**plain, "profile": profile}


def _with_table(profile: dict[str, Any], folder: Path) -> dict[str, Any]:
    if profile.get("kind") != "sampled" or "file" not in profile:
        return profile
    both = [key for key in ("radius", "height", "scatter") if key in profile]
    if both:
        raise CaseError(f"[profile] gives both file and {both[0]}; give the samples once")
    if not isinstance(profile["file"], str):
        raise CaseError(f"[profile] file = {profile['file']!r}: the name of a CSV file is needed")
    columns = {name: values.tolist() for name, values in read_columns(folder / profile["file"]).items()}
    return {**{key: value for key, value in profile.items() if key != "file"}, **columns}
