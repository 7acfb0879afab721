"""Messages of the library in the words of commands and case files."""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterator, Mapping
from typing import NamedTuple


def error_text(error: BaseException) -> str:
    """
    The message of an error, with keys of case files in place of calls.

    Examples
    --------
    >>> error_text(ValueError("no adhesion; give Contact(..., adhesion=JKR('50 mJ/m^2'))"))
    "no adhesion; give [adhesion] kind = 'jkr', work = '50 mJ/m^2'"
    >>> error_text(ValueError("write load('10 N') >> cycle(shift='1 um')"))
    "write [[path]] kind = 'load', normal_force = '10 N' and [[path]] kind = 'cycle', shift = '1 um'"
    >>> error_text(ValueError("a.toml: [friction] coefficient = -1: it must be at least 0; leave mu= out"))
    'a.toml: [friction] coefficient = -1: it must be at least 0; leave mu out'
    >>> error_text(ValueError("runs/load(1).toml: [profile] my hold(2).csv: no column"))
    'runs/load(1).toml: [profile] my hold(2).csv: no column'
    >>> error_text(ValueError("a.toml: [profile] Sphere.csv: no column; radius[1]: cannot read 'x'"))
    "a.toml: [profile] Sphere.csv: no column; entry 2 of radius: cannot read 'x'"
    """
    message = re.sub(
        r"(?:(?<=[:;\]] )|^)([a-z]\w*)\[(\d+)\](?=: )",
        lambda at: f"entry {int(at[2]) + 1} of {at[1]}",
        str(error),
    )
    return "".join(_with_keys(message, _kinds())) or "out of memory; use fewer steps"


class _Kind(NamedTuple):
    """A kind of case files: its table, name and keys in the order of arguments."""

    table: str
    name: str
    keys: tuple[str, ...]


def _kinds() -> dict[str, _Kind]:
    """Kinds by the names of their calls."""
    from pymdr.problem.codec.tables import ONE_CHANNEL_LEGS, TABLES

    places = {
        "profile": "[profile] ",
        "adhesion": "[adhesion] ",
        "friction": "[friction] ",
        "leg": "[[path]] ",
    }
    kinds = {
        cls.__name__: _Kind(places.get(table, ""), kind, tuple(inspect.signature(cls).parameters))
        for table, classes in TABLES.items()
        for kind, cls in classes.items()
    }
    kinds |= {kind: _Kind(places["leg"], kind, (channel,)) for kind, channel in ONE_CHANNEL_LEGS.items()}
    kinds |= {kind: kinds[kind.title()] for kind in ("cycle", "hold")}
    return kinds | {"Rings": _Kind("[solve] solver: ", "rings", ("n",))}


def _with_keys(message: str, kinds: Mapping[str, _Kind]) -> Iterator[str]:
    """The parts of a message with the keys of case files in place of calls of their kinds, and of arguments."""
    rest = message
    while call := re.search(r"(?:\bContact\(\.\.\., )?(?:\b\w+=)?\b(\w+)\(", rest):
        start, end = call.start(1), _closing(rest, call.end() - 1)
        before = rest[: call.start()]
        is_subject = (call.start() == 0 and rest == message) or before.endswith("] ")
        is_file = before.endswith(("/", "\\")) or re.match(r"\.\w|[/\\]", rest[end:])
        is_call = call[1] in kinds and not (is_subject or is_file)
        keys = _keys(rest[start:end], kinds) if is_call else ""
        yield _with_options(before)
        yield keys or rest[call.start() : end]
        end += bool(keys) and call[0].startswith("Contact(")
        link = re.match(r" >> (?=\w+\()| >> \.\.\.", rest[end:]) if keys else None
        if link:
            yield "" if link[0].endswith("...") else " and "
            end += link.end()
        rest = rest[end:]
    yield _with_options(rest)


def _with_options(text: str) -> str:
    """Text between calls without the equal signs of Python's arguments."""
    text = re.sub(r"(?:(?<=\s)|^)([a-z_]+)=(?=[\s,.;]|$)", r"\1", text)
    return re.sub(r"(?:(?<=\s)|^)([a-z_]+)=(?=')", r"\1 = ", text)


def _closing(text: str, start: int) -> int:
    """The place after the bracket that closes the one at `start`, or the end of the text."""
    depth = 0
    for i in range(start, len(text)):
        depth += (text[i] == "(") - (text[i] == ")")
        if depth == 0:
            return i + 1
    return len(text)


def _keys(call: str, kinds: Mapping[str, _Kind]) -> str:
    """The keys of a case file that mean the same as a call of a kind; empty if it is no call."""
    try:
        node = ast.parse(call, mode="eval").body
    except (SyntaxError, ValueError, MemoryError, RecursionError):  # texts of users may be anything
        return ""
    written = _value(node, kinds)
    table = (
        kinds[node.func.id].table if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) else ""
    )
    return table + written.removeprefix("{ ").removesuffix(" }")


def _value(node: ast.expr, kinds: Mapping[str, _Kind]) -> str:
    """A value in a case file; empty for what only stands for one."""
    if isinstance(node, ast.Constant) and node.value is not ...:
        return repr(node.value)
    if isinstance(node, ast.Attribute):
        return node.attr
    if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in kinds):
        return ""
    kind = kinds[node.func.id]
    given = [*zip(kind.keys, node.args, strict=False), *((one.arg or "", one.value) for one in node.keywords)]
    entries = {key: _value(value, kinds) for key, value in given if key}
    named = [one.id for one in node.args if isinstance(one, ast.Name)]
    named += [one.arg for one in node.keywords if one.arg and not entries[one.arg]]
    whole = ", ".join(
        [f"kind = {kind.name!r}", *(f"{key} = {value}" for key, value in entries.items() if value)]
    )
    return "{ " + whole + (f" with {' and '.join(named)}" if named else "") + " }"
