"""The table of all quantities: symbol, SI unit, dimensions and name in text.

Results, figures, files and the command line take labels and units from here only.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import numpy as np

from pymdr.deferred import xr
from pymdr.errors import QuantityError
from pymdr.units import shown


@dataclass(frozen=True)
class Quantity:
    """One row of the table."""

    name: str
    symbol: str
    """In mathtext, without dollar signs."""
    unit: str
    """SI unit, readable by pint."""
    long_name: str
    """Name in text."""
    dims: tuple[str, ...] = ("step",)

    @property
    def label(self) -> str:
        """Axis label without unit: name and symbol."""
        return f"{self.long_name} ${self.symbol}$"


_STEP = ("step",)
_FIELD = ("step", "r")
_LINE = ("x",)
_INTERIOR = ("step", "z", "r")
_TENSOR = ("step", "component", "z", "r")

QUANTITIES: dict[str, Quantity] = {
    q.name: q
    for q in (
        Quantity("time", "t", "s", "time"),
        Quantity("indentation", "d", "m", "indentation"),
        Quantity("velocity", "\\dot d", "m/s", "velocity of approach"),
        Quantity("travel", "D", "m", "travel of the machine"),
        Quantity("normal_force", "F_N", "N", "normal force"),
        Quantity("contact_radius", "a", "m", "contact radius"),
        Quantity("cohesive_radius", "c", "m", "radius of the cohesive zone"),
        Quantity("inner_contact_radius", "a_i", "m", "inner radius of the contact"),
        Quantity("semi_axis_x", "a_x", "m", "semi-axis of the contact along x"),
        Quantity("semi_axis_y", "a_y", "m", "semi-axis of the contact along y"),
        Quantity("contact_area", "A", "m^2", "contact area"),
        Quantity("normal_stiffness", "k_N", "N/m", "normal stiffness"),
        Quantity("harmonic_stiffness", "S", "N/m", "harmonic contact stiffness"),
        Quantity("mean_pressure", "p_m", "Pa", "mean pressure"),
        Quantity("elastic_energy", "U", "J", "elastic energy"),
        Quantity("effective_modulus", "E_\\mathrm{eff}", "Pa", "effective modulus"),
        Quantity("surface_energy", "U_s", "J", "surface energy"),
        Quantity("energy_release_rate", "G", "J/m^2", "energy release rate"),
        Quantity("effective_work", "\\gamma_\\mathrm{eff}", "J/m^2", "effective work of adhesion"),
        Quantity("preload", "F_0", "N", "force before the retraction"),
        Quantity("speed", "v", "m/s", "speed of the retraction"),
        Quantity("edge_speed", "V", "m/s", "speed of the receding edge"),
        Quantity("dwell", "t_0", "s", "time at rest before the retraction"),
        Quantity("stress_intensity", "K_I", "Pa*m^0.5", "stress intensity of the edge"),
        Quantity("jumped", "j", "", "jumped in this step"),
        Quantity("jump_dissipation", "\\Delta W_j", "J", "energy dissipated in jumps of this step"),
        Quantity("dissipated_energy", "W_d", "J", "dissipated energy"),
        Quantity("adhesion_dissipation", "W_a", "J", "energy dissipated by hysteresis of adhesion"),
        Quantity("position", "x", "m", "position of a body", ("step", "body")),
        Quantity("kinetic_energy", "T", "J", "kinetic energy"),
        Quantity("spring_energy", "U_k", "J", "energy of springs"),
        Quantity("damping_energy", "W_c", "J", "energy dissipated by dampers"),
        Quantity("work_of_drives", "W_u", "J", "work of drives"),
        Quantity("work_of_forces", "W_F", "J", "work of forces"),
        Quantity("residual_indentation", "d_\\mathrm{r}", "m", "residual indentation after unloading"),
        Quantity("apparent_radius", "R_\\mathrm{a}", "m", "apparent radius of the ball"),
        Quantity("yielding", "y", "", "yields in this step"),
        Quantity("external_work", "W", "J", "work done on contact and machine"),
        Quantity("shift", "u_x", "m", "tangential displacement"),
        Quantity("tangential_force", "F_x", "N", "tangential force"),
        Quantity("tangential_stiffness", "k_x", "N/m", "tangential stiffness"),
        Quantity("stick_radius", "b", "m", "stick radius"),
        Quantity("tangential_velocity", "\\dot u_x", "m/s", "tangential velocity of the contact point"),
        Quantity("slip_distance", "s", "m", "distance of full sliding"),
        Quantity("slip_work", "W_s", "J", "energy dissipated by slip"),
        Quantity("stored_tangential_energy", "U_x", "J", "stored tangential energy"),
        Quantity("twist", "\\varphi", "rad", "twist"),
        Quantity("torque", "M", "N*m", "torque"),
        Quantity("torsional_stiffness", "k_\\varphi", "N*m/rad", "torsional stiffness"),
        Quantity("stored_torsional_energy", "U_\\varphi", "J", "stored torsional energy"),
        Quantity("worn_volume", "V", "m^3", "worn volume", ("cycles",)),
        Quantity("worn_depth", "h", "m", "depth of wear", ("cycles",)),
        Quantity("central_pressure", "p_0", "Pa", "pressure on the axis", ("cycles",)),
        Quantity("worn_radius", "b", "m", "radius of the worn surface", ("cycles",)),
        Quantity("restitution", "e", "", "coefficient of restitution", ()),
        Quantity("tangential_restitution", "e_x", "", "tangential coefficient of restitution", ()),
        Quantity("contact_time", "T", "s", "contact time", ()),
        Quantity("rebound_speed", "v'", "m/s", "normal speed after the impact", ()),
        Quantity("tangential_speed", "v_x'", "m/s", "tangential speed after the impact", ()),
        Quantity("contact_point_speed", "v_c'", "m/s", "speed of the contact point after the impact", ()),
        Quantity("spin", "\\omega'", "rad/s", "spin after the impact", ()),
        Quantity("sticking_speed", "v_s", "m/s", "speed below which the bodies stick", ()),
        Quantity("energy_lost", "\\Delta E", "J", "energy lost", ()),
        Quantity("force_lower_bound", "F_{lb}", "N", "lower bound of the normal force"),
        Quantity("force_estimate", "F_e", "N", "estimate of the normal force"),
        Quantity("peak_pressure", "p_\\mathrm{max}", "Pa", "largest pressure"),
        Quantity("largest_mises", "\\sigma_\\mathrm{M,max}", "Pa", "largest von Mises stress"),
        Quantity("largest_shear", "\\tau_\\mathrm{max}", "Pa", "largest shear stress"),
        Quantity("largest_principal", "\\sigma_{1,\\mathrm{max}}", "Pa", "largest principal stress"),
        Quantity("interface_shear", r"\tau_\mathrm{i}", "Pa", "shear traction on an interface"),
        Quantity("interface_tension", r"\sigma_\mathrm{i}", "Pa", "normal traction on an interface"),
        Quantity("yield_radius", "r_Y", "m", "radius of first yield"),
        Quantity("yield_depth", "z_Y", "m", "depth of first yield"),
        Quantity("yield_layer", "i_Y", "", "layer of first yield, from 0 at the surface"),
        Quantity("first_yield_force", r"F_Y", "N", "normal force at first yield", ()),
        Quantity("yield_multiple", r"F/F_Y", "", "shakedown load over that of first yield", ()),
        Quantity("pressure_ratio", r"p_0/k", "", "peak pressure over the yield stress in shear", ()),
        Quantity("shakedown_y", r"y_\mathrm{s}", "m", "place across the path", ()),
        Quantity("shakedown_depth", r"z_\mathrm{s}", "m", "depth that limits shakedown", ()),
        Quantity("dang_van_stress", r"\tau + \alpha p_\mathrm{h}", "Pa", "Dang Van's stress", ()),
        Quantity("findley_stress", r"\tau_\mathrm{a} + k \sigma_\mathrm{n}", "Pa", "Findley's stress", ()),
        Quantity("fatemi_socie_strain", r"\gamma_\mathrm{FS}", "", "strain of Fatemi and Socie", ()),
        Quantity(
            "smith_watson_topper",
            r"\sigma_\mathrm{n} \epsilon_\mathrm{a}",
            "Pa",
            "Smith-Watson-Topper parameter",
            (),
        ),
        Quantity("ruiz_work", r"\tau \delta", "N/m", "first parameter of Ruiz", ()),
        Quantity("ruiz_damage", r"\sigma \tau \delta", "Pa*N/m", "second parameter of Ruiz", ()),
        Quantity("fatigue_ratio", "n_f", "", "value over the endurance limit", ()),
        Quantity("fatigue_x", "x_f", "m", "place along the shift", ()),
        Quantity("fatigue_y", "y_f", "m", "place across the shift", ()),
        Quantity("fatigue_z", "z_f", "m", "depth of the place", ()),
        Quantity("plane_x", "n_x", "", "normal of the plane along the shift", ()),
        Quantity("plane_y", "n_y", "", "normal of the plane across the shift", ()),
        Quantity("plane_z", "n_z", "", "normal of the plane into the body", ()),
        Quantity("stress", "\\sigma", "Pa", "stress, tension positive", _TENSOR),
        Quantity("principal_stress", "\\sigma_i", "Pa", "principal stress, tension positive", _TENSOR),
        Quantity("von_mises", "\\sigma_\\mathrm{M}", "Pa", "von Mises stress", _INTERIOR),
        Quantity("tresca", "\\sigma_\\mathrm{T}", "Pa", "Tresca stress", _INTERIOR),
        Quantity(
            "hydrostatic", "\\sigma_\\mathrm{h}", "Pa", "mean normal stress, tension positive", _INTERIOR
        ),
        Quantity("interior_displacement", "u", "m", "displacement inside the body", _TENSOR),
        Quantity("thermal_conductance", "\\Lambda", "W/K", "thermal conductance"),
        Quantity("electrical_resistance", "R", "ohm", "electrical resistance"),
        Quantity("pressure", "p", "Pa", "pressure", _FIELD),
        Quantity("heat_flux", "j_q", "W/(m^2*K)", "heat flux per temperature drop", _FIELD),
        Quantity("current_density", "j", "A/(m^2*V)", "current density per voltage", _FIELD),
        Quantity("normal_displacement", "u_z", "m", "surface displacement", _FIELD),
        Quantity("gap", "h", "m", "gap", _FIELD),
        Quantity("shear_traction", "\\tau", "Pa", "shear traction", _FIELD),
        Quantity("tangential_displacement", "u_x(r)", "m", "tangential surface displacement", _FIELD),
        Quantity("slip", "\\delta", "m", "slip", _FIELD),
        Quantity("torsional_traction", "\\tau_{z\\theta}", "Pa", "torsional traction", _FIELD),
        Quantity(
            "circumferential_displacement", "u_\\theta", "m", "circumferential surface displacement", _FIELD
        ),
        Quantity("relaxation_modulus", "G", "Pa", "relaxation modulus in shear", ("time",)),
        Quantity("storage_modulus", "G'", "Pa", "storage modulus in shear", ("angular_frequency",)),
        Quantity("loss_modulus", "G''", "Pa", "loss modulus in shear", ("angular_frequency",)),
        Quantity("angular_frequency", "\\omega", "rad/s", "angular frequency", ("angular_frequency",)),
        Quantity("frequency", "f", "Hz", "frequency", ("angular_frequency",)),
        Quantity("edge_amplitude", "K", "Pa*m^0.5", "amplitude of the edge singularity"),
        Quantity("equivalent_profile", "g", "m", "equivalent profile", _LINE),
        Quantity("spring_force", "q", "N/m", "line load", _LINE),
        Quantity("tangential_spring_force", "q_x", "N/m", "tangential line load", _LINE),
        Quantity("spring_shift", "q_x / G^*", "m", "shift of the springs", _LINE),
    )
}
"""Name -> :class:`Quantity`."""

RADIUS = Quantity("r", "r", "m", "radius", ("r",))
DEPTH = Quantity("z", "z", "m", "depth", ("z",))
ALONG = Quantity("x", "x", "m", "position along the shift", ("x",))
ACROSS = Quantity("y", "y", "m", "position across the shift", ("y",))
POSITION = Quantity("x", "x", "m", "position on the line", ("x",))

AXES = {"x": "along x", "y": "along y"}
"""Components of vectors over the axis of a plane."""

BAND_ENDS = {"low": "lower end of the band of", "high": "upper end of the band of"}


_PARAMETERS = {
    "young": "Young's modulus",
    "poisson": "Poisson's ratio",
    "work": "work of adhesion",
    "work receding": "receding work of adhesion",
    "coefficient": "coefficient of friction",
    "shear": "relaxation in shear",
}
_IMPLIED = ("body", "profile", "adhesion", "friction")
"""Parts of a contact that the labels of their parameters leave out."""


def parameter_label(name: str) -> str:
    """
    Label of a parameter of a contact, given by its dotted name.

    Examples
    --------
    >>> parameter_label("counterbody.young")
    "Young's modulus of counterbody"
    >>> parameter_label("adhesion.work_receding")
    'receding work of adhesion'
    >>> parameter_label("profile.parts[1].flat_radius")
    'flat radius of part 2'
    """
    first, *others = name.split(".")
    parts = others if others and first in _IMPLIED else [first, *others]
    words = [
        re.sub(r"s?\[(\d+)\]", lambda index: f" {int(index[1]) + 1}", part).replace("_", " ")
        for part in parts
    ]
    return " of ".join(_PARAMETERS.get(word, word) for word in reversed(words))


def one_name(name: object) -> str:
    """
    Check that a value is the name of one quantity.

    Raises
    ------
    QuantityError
        If it is not text, such as a list of names.
    """
    if not isinstance(name, str):
        raise QuantityError(f"{shown(name)} is not the name of a quantity; give one name as text")
    return name


def of_whole(name: str) -> str:
    """
    The quantity of which a name is a component, or the name itself.

    Examples
    --------
    >>> of_whole("shift_x"), of_whole("semi_axis_x")
    ('shift', 'semi_axis_x')
    """
    base, _, end = name.rpartition("_")
    return base if name not in QUANTITIES and end in AXES and base in QUANTITIES else name


def magnitudes(array: xr.DataArray) -> xr.DataArray:
    """The magnitudes of vectors over ``axis``; scalars as they are."""
    if "axis" not in array.dims:
        return array
    return array.reduce(np.linalg.norm, dim="axis")


def quantity(name: str) -> Quantity:
    """
    The row of a quantity, of an end of its band (``normal_force_low``), or of a component (``shift_y``).

    Raises
    ------
    KeyError
        If there is no such quantity.

    Examples
    --------
    >>> quantity("normal_force_low").long_name
    'lower end of the band of normal force'
    """
    base, _, end = name.rpartition("_")
    if name not in QUANTITIES and end in BAND_ENDS and base in QUANTITIES:
        row = QUANTITIES[base]
        return replace(row, name=name, long_name=f"{BAND_ENDS[end]} {row.long_name}")
    if name not in QUANTITIES and end in AXES and base in QUANTITIES:
        row = QUANTITIES[base]
        symbol = f"{row.symbol.removesuffix('_x')}_{end}"
        return replace(row, name=name, symbol=symbol, long_name=f"{row.long_name} {AXES[end]}")
    return QUANTITIES[name]
