"""Layered bodies: coatings, films, cartilage."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from pymdr.errors import ProblemError
from pymdr.problem.materials import Elastic, Material, Rigid, Viscoelastic
from pymdr.problem.values import SIField, Value
from pymdr.units import metres, shown

BONDS = ("bonded", "frictionless")
_MOST = 32
"""Largest number of layers."""
_STIFFEST = 1e8
"""Largest ratio of two Young's moduli in a body."""
_THICKEST = 1e4
"""Largest ratio of two thicknesses in a body."""


@dataclass(frozen=True, eq=False)
class Layer(Value):
    """
    One layer of a :class:`Layered` body.

    Parameters
    ----------
    material : Elastic
        Isotropic material of the layer, without a thickness of its own.
    thickness : quantity
        In m, above 0.

    Raises
    ------
    ProblemError
        If the material is not Elastic, or the thickness not above 0.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.Layer(mdr.Elastic("1 MPa", 0.5), "2 mm").thickness
    0.002
    """

    material: Elastic
    thickness: SIField = SIField("m", above=0.0, description="thickness")

    def __post_init__(self) -> None:
        if isinstance(self.material, Viscoelastic):
            raise ProblemError(
                "Layer.material is Viscoelastic: layers with memory are not available, because only their force, not their pressure, "
                "follows from independent springs; give Elastic with the stiffness at one time"
            )
        if not isinstance(self.material, Elastic):
            raise ProblemError(
                f"Layer.material = {shown(self.material)}: layers are isotropic and elastic; give Elastic('1 MPa', 0.5)"
            )
        if self.material.thickness is not None:
            raise ProblemError(
                f"Layer.material has a thickness of {metres(self.material.thickness)}, the layer one of "
                f"{metres(self.thickness)}; give only that of the layer"
            )


@dataclass(frozen=True, eq=False, repr=False)
class Layered(Material):
    """
    Elastic layers on a base.

    Parameters
    ----------
    layers : list of Layer
        From the surface downward, bonded to one another.
    base : Rigid or Elastic, optional
        Half-space below the layers; by default rigid.
    bond : str, optional
        "bonded", or "frictionless": the lowest layer slides on the base without lifting off.

    Raises
    ------
    ProblemError
        If there are no layers or more than 32, the base is neither rigid nor elastic, the bond is unknown, moduli
        differ by more than 10^8, or thicknesses by more than 10^4.

    Examples
    --------
    >>> import pymdr as mdr
    >>> cartilage = mdr.Layered([mdr.Layer(mdr.Elastic("0.7 MPa", 0.49), "2 mm")], base=mdr.Elastic("1 GPa", 0.3))
    >>> cartilage.top.young
    700000.0
    """

    layers: Sequence[Layer]
    base: Material = field(default_factory=Rigid)
    bond: str = "bonded"

    def __post_init__(self) -> None:
        object.__setattr__(self, "layers", _as_layers(self.layers))
        if not isinstance(self.base, Rigid | Elastic):
            raise ProblemError(f"Layered.base = {shown(self.base)}: a Rigid() or Elastic(...) base is needed")
        if isinstance(self.base, Elastic) and self.base.thickness is not None:
            raise ProblemError(
                f"Layered.base has a thickness of {metres(self.base.thickness)}, but a base is a half-space; make it the last "
                "layer on Rigid(), or leave the thickness out"
            )
        if not isinstance(self.bond, str) or self.bond not in BONDS:
            raise ProblemError(
                f"Layered.bond = {shown(self.bond)}: it must be 'bonded' or 'frictionless' (the lowest layer slides on the base)"
            )
        solids = [layer.material for layer in self.layers]
        moduli = [solid.young for solid in (*solids, self.base) if isinstance(solid, Elastic)]
        _refuse_ratio("Young's moduli", moduli, "Pa", _STIFFEST, "use Rigid() for the stiffest part")
        _refuse_ratio(
            "thicknesses",
            [layer.thickness for layer in self.layers],
            "m",
            _THICKEST,
            "leave the thinnest out",
        )

    @property
    def half_space(self) -> bool:
        """False: its compliance depends on the contact radius."""
        return False

    @property
    def top(self) -> Elastic:
        """The material of the surface."""
        return self.layers[0].material

    @property
    def thickness(self) -> float:
        """Total thickness of the layers in m."""
        return sum(layer.thickness for layer in self.layers)


def _as_layers(layers: Any) -> tuple[Layer, ...]:
    if isinstance(layers, Layer) or not isinstance(layers, Iterable) or isinstance(layers, str):
        raise ProblemError(
            f"Layered.layers = {shown(layers)}: a list of layers is needed, such as [Layer(Elastic('1 MPa', 0.5), '2 mm')]"
        )
    entries = tuple(layers)
    for entry in entries:
        if not isinstance(entry, Layer):
            raise ProblemError(
                f"Layered.layers holds {shown(entry)}: a Layer(Elastic('1 MPa', 0.5), '2 mm') is needed"
            )
    if not 0 < len(entries) <= _MOST:
        raise ProblemError(f"Layered.layers: 1 to {_MOST} layers are needed, not {len(entries)}")
    return entries


def _refuse_ratio(name: str, values: list[float], unit: str, most: float, remedy: str) -> None:
    low, high = min(values), max(values)
    if high > most * (1.0 + 1e-9) * low:
        raise ProblemError(
            f"Layered: {name} of {low:.6g} {unit} and {high:.6g} {unit} differ by a factor of {high / low:.3g} (limit "
            f"{most:g}); {remedy}"
        )
