"""Case files: a problem as TOML."""

from __future__ import annotations

import os
import tomllib
from dataclasses import dataclass
from pathlib import Path

from pymdr.errors import CaseError, FileError
from pymdr.problem.codec import decode_case
from pymdr.problem.contact import Contact
from pymdr.problem.paths import LoadingPath

_LARGEST = 4 * 2**20


@dataclass(frozen=True)
class Case:
    """What a case file says."""

    file: Path
    title: str
    contact: Contact
    path: LoadingPath


def read_case(file: str | os.PathLike[str]) -> Case:
    """
    Read a case file.

    Parameters
    ----------
    file : path
        A TOML file with the tables ``[profile]``, ``[body]``, optionally ``[counterbody]``, and one
        ``[[path]]`` for every leg.

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
        title, contact, path = decode_case(plain)
    except CaseError as error:
        raise CaseError(f"{source}: {error}") from error
    return Case(source, title, contact, path)
