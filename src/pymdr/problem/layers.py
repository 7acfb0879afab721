"""Layered bodies: coatings, films, cartilage."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pymdr.errors import ProblemError
from pymdr.problem.materials import Elastic, Material, Rigid, Viscoelastic
from pymdr.problem.values import OptionalSIField as OptionalSIField
from pymdr.problem.values import SIField, Value
from pymdr.units import metres, shown

BONDS = ("bonded", "frictionless")
_MOST = 32
"""Largest number of layers."""
_STIFFEST = 1e8
"""Largest ratio of two Young's moduli in a body."""
_THICKEST = 1e4
"""Largest ratio of two thicknesses in a body."""
_FREQUENCIES = np.geomspace(1e-15, 1e15, 241)
"""Angular frequencies in rad/s at which rheologies are compared."""
_ALIKE = 1e-9
"""Largest relative difference of complex moduli of rheologies that count as proportional."""


@dataclass(frozen=True, eq=False)
class Layer(Value):
    """
    One layer of a :class:`Layered` body.

    Parameters
    ----------
    material : Elastic or Viscoelastic
        Isotropic material of the layer, without a thickness of its own; a viscoelastic one with a constant Poisson's ratio.
    thickness : quantity
        In m, above 0.

    Raises
    ------
    ProblemError
        If the material is neither Elastic nor Viscoelastic with a constant Poisson's ratio, or the thickness not above 0.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.Layer(mdr.Elastic("1 MPa", 0.5), "2 mm").thickness
    0.002
    """

    material: Elastic | Viscoelastic
    thickness: SIField = SIField("m", above=0.0, description="thickness")

    def __post_init__(self) -> None:
        if isinstance(self.material, Viscoelastic):
            if self.material.poisson is None:
                raise ProblemError(
                    "material has a constant bulk modulus, so that its Poisson's ratio changes in time and its stiffness relaxes "
                    "differently at every contact radius; give poisson instead of bulk"
                )
            return
        if not isinstance(self.material, Elastic):
            raise ProblemError(
                f"material = {shown(self.material)}: layers are isotropic; give Elastic('1 MPa', 0.5) or "
                "Viscoelastic(rheology, poisson=0.5)"
            )
        if self.material.thickness is not None:
            raise ProblemError(
                f"material has a thickness of {metres(self.material.thickness)}, the layer one of "
                f"{metres(self.thickness)}; give only that of the layer"
            )


@dataclass(frozen=True, eq=False, repr=False)
class Layered(Material):
    """
    Layers on a base: elastic ones, or viscoelastic ones of one relaxation function on a rigid base.

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
        differ by more than 10^8, or thicknesses by more than 10^4; if a layer is viscoelastic and another part is
        elastic, or relaxes differently.

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
            raise ProblemError(f"base = {shown(self.base)}: a Rigid() or Elastic(...) base is needed")
        if isinstance(self.base, Elastic) and self.base.thickness is not None:
            raise ProblemError(
                f"base has a thickness of {metres(self.base.thickness)}, but a base is a half-space; make it the last "
                "layer on Rigid(), or leave the thickness out"
            )
        if not isinstance(self.bond, str) or self.bond not in BONDS:
            raise ProblemError(
                f"bond = {shown(self.bond)}: it must be 'bonded' or 'frictionless' (the lowest layer slides on the base)"
            )
        if self.is_viscoelastic:
            self._refuse_several_relaxations()
        moduli = [solid.young for solid in (*self.solids, self.base) if isinstance(solid, Elastic)]
        _refuse_ratio("Young's moduli", moduli, "Pa", _STIFFEST, "use Rigid() for the stiffest part")
        thicknesses = [layer.thickness for layer in self.layers]
        _refuse_ratio("thicknesses", thicknesses, "m", _THICKEST, "leave the thinnest out")

    @property
    def half_space(self) -> bool:
        """False: its compliance depends on the contact radius."""
        return False

    @property
    def is_viscoelastic(self) -> bool:
        """Whether a layer is viscoelastic."""
        return any(isinstance(layer.material, Viscoelastic) for layer in self.layers)

    @property
    def solids(self) -> tuple[Elastic, ...]:
        """Elastic materials of the layers; in place of viscoelastic ones those of the same ratios, E* of the first being 1 Pa."""
        materials = [layer.material for layer in self.layers]
        first = materials[0]
        if isinstance(first, Elastic):
            return tuple(one for one in materials if isinstance(one, Elastic))
        # moduli are proportional, so that one frequency has their ratios
        one_frequency = _FREQUENCIES[:1]
        scale = 0.5 * (1.0 - _poisson(first)) / _complex_modulus(first, one_frequency)[0]
        shears = [
            float((scale * _complex_modulus(one, one_frequency)[0]).real)
            for one in materials
            if isinstance(one, Viscoelastic)
        ]
        return tuple(
            Elastic(2.0 * (1.0 + _poisson(one)) * shear, _poisson(one))
            for one, shear in zip(materials, shears, strict=True)
        )

    @property
    def top(self) -> Elastic:
        """The material of the surface, as the first of `solids`."""
        return self.solids[0]

    def _refuse_several_relaxations(self) -> None:
        """Refuse parts that do not relax by one function of time."""
        remedy = (
            "a contact on them has no common relaxation function; give Elastic with the stiffness at one time"
        )
        first = self.layers[0].material
        if not isinstance(self.base, Rigid):
            raise ProblemError(
                f"viscoelastic layers on an elastic base relax differently at every contact radius, and {remedy}"
            )
        for number, layer in enumerate(self.layers, 1):
            if not isinstance(layer.material, Viscoelastic) or not isinstance(first, Viscoelastic):
                raise ProblemError(f"elastic and viscoelastic layers are mixed: {remedy}")
            ratio = _complex_modulus(layer.material) / _complex_modulus(first)
            if np.max(np.abs(ratio / ratio[0] - 1.0)) > _ALIKE:
                raise ProblemError(f"layer {number} relaxes differently from the first: {remedy}")

    @property
    def thickness(self) -> float:
        """Total thickness of the layers in m."""
        return sum(layer.thickness for layer in self.layers)


def _complex_modulus(material: Viscoelastic, frequencies: np.ndarray = _FREQUENCIES) -> np.ndarray:
    """G' + i G'' in Pa at angular frequencies in rad/s."""
    shear = material.shear
    return np.asarray(shear.storage(frequencies) + 1j * shear.loss(frequencies))


def _poisson(material: Elastic | Viscoelastic) -> float:
    assert material.poisson is not None
    return material.poisson


def _as_layers(layers: Any) -> tuple[Layer, ...]:
    if isinstance(layers, Layer) or not isinstance(layers, Iterable) or isinstance(layers, str):
        raise ProblemError(
            f"layers = {shown(layers)}: a list of layers is needed, such as [Layer(Elastic('1 MPa', 0.5), '2 mm')]"
        )
    entries = tuple(layers)
    for entry in entries:
        if not isinstance(entry, Layer):
            raise ProblemError(
                f"layers contains {shown(entry)}: a Layer(Elastic('1 MPa', 0.5), '2 mm') is needed"
            )
    if not 0 < len(entries) <= _MOST:
        raise ProblemError(f"layers: 1 to {_MOST} layers are needed, not {len(entries)}")
    return entries


def _refuse_ratio(name: str, values: list[float], unit: str, most: float, remedy: str) -> None:
    low, high = min(values), max(values)
    if high > most * (1.0 + 1e-9) * low:
        raise ProblemError(
            f"{name} of {low:.6g} {unit} and {high:.6g} {unit} differ by a factor of {high / low:.3g} (limit "
            f"{most:g}); {remedy}"
        )
