"""The result of a motion."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from pymdr.deferred import mpl, xr
from pymdr.errors import FileError, QuantityError
from pymdr.problem.machines import Machine
from pymdr.result.rows import row_indices
from pymdr.solving.mapped import map_to_springs
from pymdr.solving.study import Study
from pymdr.units import FloatArray, shown

_FRAMES, _DRAWN, _WIDER = 60, 41, 1.4
"""Frames of an animation, springs on one side of it, and its width over the largest contact."""
ENERGIES = (
    "kinetic_energy",
    "spring_energy",
    "elastic_energy",
    "stored_tangential_energy",
    "dissipated_energy",
    "damping_energy",
    "work_of_drives",
    "work_of_forces",
)
"""Energies of the state, dissipated energies, and work done on the machine; the order of the integration's sums."""
_JOINTS = ("normal_force", "indentation", "tangential_force")


@dataclass(frozen=True, kw_only=True)
class Motion(Study):
    """The motion of a machine."""

    data: xr.Dataset
    """Over ``step`` with ``time`` (s): position (m) and velocity (m/s) over ``body``; indentation, normal_force, contact_radius and with
    friction shift, tangential_force and stick_radius over ``joint``; kinetic, spring and contact energies, dissipated energies and works
    in J since time 0. The position of a rotor is the way of its rim."""
    machine: Machine
    """The machine."""

    subject: ClassVar = "a motion"
    summary_claims: ClassVar = (
        "position",
        "velocity",
        "normal_force",
        "tangential_force",
        "dissipated_energy",
    )

    def groups(self) -> dict[str, dict[str, float]]:
        """Largest values of every joint, and the energies at the end."""
        groups = {"motion": {"time": float(self.data["time"][-1])}}
        for i, name in enumerate(self.data["joint"].values if "joint" in self.data else ()):
            groups[f"largest at {name}"] = {
                key: float(np.max(np.abs(self.data[key].values[:, i]))) for key in _JOINTS if key in self.data
            }
        groups["at the end"] = {name: float(self.data[name][-1]) for name in ENERGIES if name in self.data}
        return groups

    def spectrum(self, name: str, of: str) -> xr.DataArray:
        """
        Amplitudes of the waves in a quantity, from its rows but the last, without their mean, under a Hann window.

        Parameters
        ----------
        name : str
            Such as ``"normal_force"`` or ``"velocity"``.
        of : str
            The joint or body.

        Returns
        -------
        xarray.DataArray
            Over ``frequency`` in Hz, up to half of the rate of the rows.

        Raises
        ------
        QuantityError
            If there is no such quantity, or no such joint or body.
        """
        import xarray as xr

        array = self[name]
        along = next((dim for dim in array.dims if dim != "step"), None)
        if along is None or of not in array[along].values:
            known = ", ".join(map(str, self.data[along].values)) if along else "none"
            raise QuantityError(f"{shown(name)} has no {shown(of)}; it has {known}")
        time = self.data["time"].values
        frequency, amplitude = amplitude_spectrum(
            array.sel({along: of}).values[:-1], float(time[1] - time[0])
        )
        return xr.DataArray(
            amplitude,
            {"frequency": ("frequency", frequency, {"units": "Hz"})},
            "frequency",
            name,
            array.attrs,
        )

    def animate(
        self, file: str | os.PathLike[str], *, joint: str | None = None, rows: Sequence[int] | None = None
    ) -> None:
        """
        Write the line of a joint in motion as a GIF: the pressed springs, those that stick and slip, beside the forces.

        Parameters
        ----------
        file : path
            For example "pad.gif".
        joint : str, optional
            By default the first.
        rows : sequence of int, optional
            One per frame; by default 60, evenly spaced in time.

        Raises
        ------
        FileError
            If the name of the file does not end with .gif, or it cannot be written.
        QuantityError
            If there is no such joint or row.
        """
        from pymdr.presentation.files import named_file, write_atomically
        from pymdr.presentation.plot import LineInMotion, write_motion_animation

        target = named_file(file, "write")
        if target.suffix.lower() != ".gif":
            raise FileError(f"cannot write {target}: an animation is a GIF; end its name with .gif")
        joints = {one.name: one for one in self.machine.joints}
        name = next(iter(joints), None) if joint is None else joint
        if name not in joints:
            raise QuantityError(
                f"there is no joint {shown(joint)}; the joints are {', '.join(joints) or 'none'}"
            )
        count = self.data.sizes["step"]
        taken = np.linspace(0, count - 1, min(_FRAMES, count)).round().astype(int).tolist()
        frames = np.asarray(row_indices(taken if rows is None else rows, count))
        contact = joints[name].contact
        radius = float(np.max(self.data["contact_radius"].sel(joint=name)))
        line = map_to_springs(contact).line
        x = np.linspace(0.0, min(_WIDER * radius, line.edge) if radius > 0.0 else 1.0, _DRAWN)
        slips = contact.friction is not None
        drawn = LineInMotion(self.data.sel(joint=name), x, line.depth(x), slips)
        write_atomically(target, lambda temporary: write_motion_animation(drawn, frames, temporary))

    def _figure(self) -> mpl.figure.Figure:
        """Phase plane, forces against time, the spectrum of one of them, and the flow of energy."""
        from pymdr.presentation.plot import motion_figure

        if "joint" not in self.data:
            return motion_figure(self.data, None)
        steady = float(np.ptp(self.data["normal_force"].values[:, 0])) == 0.0
        name = "tangential_force" if steady and "tangential_force" in self.data else "normal_force"
        return motion_figure(self.data, self.spectrum(name, str(self.data["joint"].values[0])))

    def _columns(self) -> dict[str, np.ndarray]:
        columns: dict[str, np.ndarray] = {}
        for name in map(str, self.data.variables):
            array = self.data[name]
            if array.dims == ("step",):
                columns[name] = array.values
            elif "step" in array.dims:
                labels = self.data[array.dims[1]].values
                columns |= {f"{name} of {label}": array.values[:, i] for i, label in enumerate(labels)}
        return columns

    def _quantity_of(self, column: str) -> str:
        return column.partition(" of ")[0]


def amplitude_spectrum(values: FloatArray, step: float) -> tuple[FloatArray, FloatArray]:
    """
    Frequencies, and amplitudes of the waves in evenly spaced values under a Hann window.

    Parameters
    ----------
    values : ndarray, shape (n,)
    step : float
        Their distance in s.

    Examples
    --------
    >>> t = np.arange(1000) / 1000.0
    >>> frequency, amplitude = amplitude_spectrum(3.0 * np.sin(2 * np.pi * 50.0 * t), 1e-3)
    >>> round(float(frequency[amplitude.argmax()]), 9), round(float(amplitude.max()), 9)
    (50.0, 3.0)
    """
    n = values.size
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(n) / n)
    waves = np.fft.rfft(window * (values - np.average(values, weights=window)))
    return np.asarray(np.fft.rfftfreq(n, step)), np.asarray(2.0 * np.abs(waves) / window.sum())


def residual_of(energies: Mapping[str, FloatArray]) -> float:
    """The largest residual of the balance of energies, relative to the largest energy or work."""
    change = {name: energies[name] - energies[name][0] for name in ENERGIES}
    *inside, drives, forces = change.values()
    residual = sum(inside) - drives - forces
    size = max(float(np.max(np.abs(values))) for values in energies.values())
    return float(np.max(np.abs(residual))) / size if size > 0.0 else 0.0
