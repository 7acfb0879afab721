r"""
Force curves and force volumes of NanoScope software (Bruker, Veeco, Digital Instruments).

The header is text, ``\key: value`` in sections ``\*name``, up to ``\*File list end``. A section ``Ciao force image list`` describes a channel: where its integers are,
and by ``(... V/LSB)`` what one of them is in V; a line ``@Sens.`` elsewhere has the sensitivity. A curve has the samples of the extension, of the
retraction and of a hold, each from the contact on; a force volume has one curve after the other.
"""

from __future__ import annotations

import logging
import math
import re
from pathlib import Path

import numpy as np

from pymdr.errors import FileError, ProblemError, UnitError
from pymdr.units import FloatArray, to_si
from pymdr.workbench.inputs import read_bytes
from pymdr.workbench.readers.record import Calibration, ForceRecord

MAGIC = b"\\*Force file list"
IMAGE_MAGIC = b"\\*File list"
_MAKER = "a force file of Bruker NanoScope"
_LARGEST = 2 * 2**30
_END = b"\\*File list end"
_LSB = re.compile(
    r"\[(?P<sensitivity>[^\]]*)\]\s*\((?P<step>[-+.\deE]+)\s*(?P<unit>\S+)/LSB\)\s*(?P<hard>[-+.\deE]+)"
)
Section = dict[str, str]
_log = logging.getLogger("pymdr")


def read(source: Path, calibration: Calibration) -> list[ForceRecord]:
    """The records of a file: one of a curve, one for each pixel of a force volume."""
    content = read_bytes(source, _LARGEST, "force file")
    end = content.find(_END)
    if end < 0:
        raise FileError(
            f"cannot read {source}: {_MAKER}, whose header has no end: the file is cut off; copy it again from the instrument"
        )
    sections = _sections(content[:end].decode("latin-1"))
    merged = {key: value for _, section in sections for key, value in section.items()}
    channels = [section for name, section in sections if name == "Ciao force image list"]
    if any(section.get("Start context") == "SCRIPT" for _, section in sections):
        raise ProblemError(
            f"{source}: {_MAKER}, recorded by a script with its own ramps; export its curves as tables"
        )
    if source.suffix.lower() == ".pfc":
        raise ProblemError(
            f"{source}: a PeakForce capture of Bruker NanoScope, whose sinusoidal motion is not in the file; export its curves as tables"
        )
    deflection = _channel(channels, "Deflection")
    if deflection is None:
        names = ", ".join(map(_name, channels)) or "none"
        raise ProblemError(
            f"{source}: {_MAKER}, without a deflection channel (channels: {names}); save the deflection error too"
        )
    counts = _counts(deflection, merged)
    signals = _curves(source, content, deflection, counts)
    slope = _sensitivity(merged, "DeflSens")
    constant = _number(deflection.get("Spring Constant"))
    constants = {
        channel.get("Spring Constant") for channel in channels if _name(channel) == _name(deflection)
    }
    if len(constants) > 1:
        _log.warning(
            "%s: the deflection channels have the spring constants %s N/m; the first, %g N/m, is used: give spring_constant to choose another",
            source,
            ", ".join(sorted(map(str, constants))),
            constant or math.nan,
        )
    sensor = _channel(channels, "Height Sensor")
    if sensor is None:
        heights, source_name = [_ramp(source, deflection, merged, counts)] * len(signals), "ramp"
    else:
        scale = _sensitivity(merged, "ZsensSens")
        if scale is None:
            raise ProblemError(
                f"{source}: {_MAKER}, whose height sensor has no sensitivity in m/V; export its curves as tables"
            )
        heights = [one * scale for one in _curves(source, content, sensor, counts)]
        source_name = "height sensor"
    along = int(_number(merged.get("force/line", "").split(" ")[0]) or 1.0)
    facts: dict[str, str | float] = {"position": source_name}
    records = []
    for k, (signal, height) in enumerate(zip(signals, heights, strict=True)):
        pixel = {} if len(signals) == 1 else _pixel(merged, k, along, len(signals))
        columns = _ordered(signal, height, counts)
        time = _times(deflection, merged, counts)
        if time is not None:
            columns["time"] = time
        records.append(ForceRecord(_MAKER, columns, constant, slope, {**facts, **pixel, "record": float(k)}))
    return records


def _sections(header: str) -> list[tuple[str, Section]]:
    sections: list[tuple[str, Section]] = []
    for line in header.splitlines():
        text = line.strip().lstrip("\\")
        if text.startswith("*"):
            sections.append((text[1:], {}))
        elif sections:
            channelled = re.sub(r"^@(?:\d+:)?", "", text)
            key, _, value = channelled.partition(": ")
            sections[-1][1][key.strip()] = value.strip()
    return sections


def _name(channel: Section) -> str:
    match = re.search(r'"([^"]*)"', channel.get("Image Data", ""))
    return match[1] if match else "?"


def _channel(channels: list[Section], name: str) -> Section | None:
    """The first channel of a name; others may repeat its samples over another axis."""
    return next((channel for channel in channels if _name(channel).startswith(name)), None)


def _number(text: str | None) -> float | None:
    try:
        return float((text or "").split()[0])
    except (ValueError, IndexError):
        return None


def _counts(channel: Section, merged: Section) -> tuple[int, int, int]:
    """Samples of extension, retraction and hold."""
    numbers = [int(n) for n in re.findall(r"\d+", channel.get("Samps/line", ""))] or [0]
    hold = int(_number(merged.get("Hold Samples")) or 0)
    return numbers[0], numbers[1] if len(numbers) > 1 else numbers[0], hold


def _curves(source: Path, content: bytes, channel: Section, counts: tuple[int, int, int]) -> list[FloatArray]:
    """The samples of all curves of a channel in V."""
    match = _LSB.search(channel.get("Z scale", ""))
    offset, length = (int(_number(channel.get(f"Data {what}")) or 0) for what in ("offset", "length"))
    both = counts[0] + counts[1]
    if match is None or both == 0 or length == 0:
        raise FileError(
            f"cannot read {source}: {_MAKER}, whose channel {_name(channel)!r} has no scale or no samples; export its curves as tables"
        )
    if match["unit"] != "V":
        raise ProblemError(
            f"{source}: {_MAKER}, whose channel {_name(channel)!r} is in {match['unit']}; V is needed"
        )
    width = int(_number(channel.get("Bytes/pixel")) or 2)
    for bytes_each, size in ((4, both + counts[2]), (width, both + counts[2]), (width, both), (4, both)):
        if length % (bytes_each * size) == 0 and (length == bytes_each * size or counts[2] == 0):
            break
    else:
        raise FileError(
            f"cannot read {source}: {_MAKER}, whose channel {_name(channel)!r} has {length} bytes for curves of {both + counts[2]} samples; copy "
            "it again from the instrument"
        )
    if offset + length > len(content):
        raise FileError(
            f"cannot read {source}: {_MAKER}; the file is cut off: it has {len(content)} of {offset + length} bytes; copy it again from "
            "the instrument"
        )
    if counts[2] == 0 and length % (width * both) == 0:
        bytes_each, size = width, both
    raw = np.frombuffer(content, f"<i{bytes_each}", length // bytes_each, offset).reshape(-1, size)
    return [row * float(match["step"]) for row in raw.astype(float)]


def _sensitivity(merged: Section, name: str) -> float | None:
    """A sensitivity of the header, such as ``V 40.2 nm/V``, in m/V."""
    text = merged.get(f"Sens. {name}", "").removeprefix("V ").strip()
    try:
        return to_si(text, "m/V", name=name)
    except UnitError:
        return None


def _ramp(source: Path, channel: Section, merged: Section, counts: tuple[int, int, int]) -> FloatArray:
    """Positions of the ramp where no sensor measured them, in the order of the file."""
    size = channel.get("Ramp size", channel.get("Ramp Size", ""))
    match, slope = _LSB.search(size), _sensitivity(merged, "Zsens")
    if match is None or slope is None:
        raise ProblemError(
            f"{source}: {_MAKER}, with neither a height sensor nor the size of the ramp; export its curves as tables"
        )
    travel = float(match["hard"]) * slope
    parts = [
        np.linspace(travel, 0.0, counts[0]),
        np.linspace(travel, 0.0, counts[1]),
        np.full(counts[2], travel),
    ]
    return np.concatenate(parts)


def _ordered(signal: FloatArray, height: FloatArray, counts: tuple[int, int, int]) -> dict[str, FloatArray]:
    """Samples in the order of measurement: the extension is stored from the contact on, the hold behind the retraction."""
    ends = np.cumsum(counts)
    there = signal.size > ends[1]
    parts = [slice(0, ends[0]), slice(ends[1], signal.size), slice(ends[0], ends[1])]

    def ordered(values: FloatArray) -> FloatArray:
        out, hold, back = (values[part] for part in parts)
        return np.concatenate([out[::-1], hold, back] if there else [out[::-1], back])

    sizes = [counts[0], signal.size - int(ends[1]), counts[1]] if there else [counts[0], counts[1]]
    toward = 1.0 if height[0] >= height[counts[0] - 1] else -1.0
    return {
        "signal": ordered(signal),
        "travel": toward * ordered(height[: signal.size]),
        "segment": np.repeat(np.arange(len(sizes), dtype=float), sizes),
    }


def _times(channel: Section, merged: Section, counts: tuple[int, int, int]) -> FloatArray | None:
    """Times of the samples, from the velocities of the ramp in V/s."""
    match = _LSB.search(channel.get("Ramp size", channel.get("Ramp Size", "")))
    speeds = [_number(merged.get(name)) for name in ("Forward vel.", "Reverse vel.")]
    hold = _number(merged.get("Hold Time")) or 0.0
    if match is None or any(not speed for speed in speeds) or (counts[2] > 0 and not hold > 0.0):
        return None
    durations = [float(match["hard"]) / speed for speed in speeds if speed]
    spans = [
        (durations[0], counts[0]),
        *([(hold, counts[2])] if counts[2] else []),
        (durations[1], counts[1]),
    ]
    parts, start = [], 0.0
    for duration, count in spans:
        parts.append(start + duration / count * np.arange(count))
        start += duration
    return np.concatenate(parts)


def _pixel(merged: Section, k: int, along: int, number: int) -> dict[str, str | float]:
    """Where a curve of a force volume is."""
    rows = -(-number // along)
    facts: dict[str, str | float] = {}
    try:
        size = to_si(merged.get("Scan Size", "").replace("~m", "um"), "m", name="Scan Size")
    except UnitError:
        size = None
    for axis, index, count in (("x", k % along, along), ("y", k // along, rows)):
        facts[f"grid index {axis}"], facts[f"grid shape {axis}"] = float(index), float(count)
        if size is not None:
            facts[f"grid size {axis}"] = size * count / along
    return facts
