"""Safe reading of user files (regular, of limited size, text), and text that is safe to print."""

from __future__ import annotations

import codecs
import os
import re
import stat

from pymdr.errors import CaseError, FileError
from pymdr.presentation.files import named_file

_BINARY = re.compile("[\x00-\x08\x0e-\x19\x1b-\x1f]")
"""Control characters that no text has, but for the end mark of DOS."""


def read_bytes(file: str | os.PathLike[str], largest: int, what: str) -> bytes:
    """
    The content of a regular file.

    The size is looked at after opening, and no more than `largest` bytes are read, so that neither a device nor a
    file that grows can fill the memory; opening without waiting keeps a pipe from holding the program.

    Parameters
    ----------
    largest : int
        Number of bytes above which the file is refused.
    what : str
        What the file should be, for messages, such as "case file".
    """
    source = named_file(file, "read")
    try:
        handle = os.open(source, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    except ValueError as error:
        raise FileError(
            f"cannot read {str(source)!r}: the name contains the character NUL; remove it"
        ) from error
    except OSError as error:
        raise FileError(f"cannot read {source}: {error.strerror or error}") from error
    if not stat.S_ISREG(os.fstat(handle).st_mode):
        os.close(handle)
        raise FileError(
            f"cannot read {source}: {_article(what)} {what} is a regular file, not a folder, pipe or device"
        )
    try:
        with os.fdopen(handle, "rb") as opened:
            content = opened.read(largest + 1)
    except OSError as error:
        raise FileError(f"cannot read {source}: {error.strerror or error}") from error
    if len(content) > largest:
        raise CaseError(f"{source}: larger than {largest} bytes (the limit of {_article(what)} {what})")
    return content


def _article(what: str) -> str:
    return "an" if what[0] in "aeiou" else "a"


def read_filled(file: str | os.PathLike[str], largest: int, what: str) -> bytes:
    """The content of a regular file, as by :func:`read_bytes`; an empty one is refused."""
    content = read_bytes(file, largest, what)
    if not content:
        raise CaseError(f"{named_file(file, 'read')}: the file is empty; copy it again, or give another file")
    return content


def read_text(file: str | os.PathLike[str], largest: int, what: str) -> str:
    """The text of a regular file; a byte order mark is no part of it."""
    content, source = read_bytes(file, largest, what), named_file(file, "read")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise CaseError(
            f"{source}: not a text file in UTF-8 ({error.reason} at byte {error.start}); save it in UTF-8"
        ) from error


def text_of(content: bytes) -> str | None:
    r"""
    The text that a file of measured data holds, or None where it is no text.

    UTF-16 is known by its byte order mark. What is not UTF-8 is read as latin-1, in which instruments write \u00b5 and \u00b0.

    Examples
    --------
    >>> [text_of(c) for c in ("x [\u00b5m]".encode("latin-1"), "x [\u00b5m]".encode("utf-16"), b"\x88\x1b\x03")]
    ['x [\xb5m]', 'x [\xb5m]', None]
    """
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        try:
            text = content.decode("utf-16")
        except UnicodeDecodeError:
            return None
    else:
        try:
            text = content.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = content.decode("latin-1")
    return None if _BINARY.search(text) else text.rstrip("\x1a")


def read_measured_text(file: str | os.PathLike[str], largest: int, what: str) -> str:
    """The text of a file of measured data, in any encoding that :func:`text_of` supports."""
    content = read_filled(file, largest, what)
    text = text_of(content)
    if text is None:
        raise CaseError(
            f"{named_file(file, 'read')}: binary data, not text; export the {what} as text (.csv, .txt)"
        )
    return text


def printable(text: str) -> str:
    r"""
    A text whose control characters are written out, so that no title or message steers a terminal.

    Examples
    --------
    >>> printable("a" + chr(27) + "[31m b")
    'a\\x1b[31m b'
    """
    return "".join(c if c.isprintable() or c == "\n" else repr(c)[1:-1] for c in text)


def writable(text: str, encoding: str | None) -> str:
    r"""
    A text whose characters that an encoding lacks are written out; the prefix \u00b5 becomes u.

    Examples
    --------
    >>> writable("5 \u00b5m on \u2013", "ascii")
    '5 um on \\u2013'
    """
    known = encoding or "utf-8"
    if not "\u00b5".encode(known, "ignore"):
        text = text.replace("\u00b5", "u")
    return text.encode(known, "backslashreplace").decode(known)
