"""Effect of the finite thickness of a sample on its indentation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from pymdr.deferred import mpl
from pymdr.interpretation.layers import base_assumption, first_fault
from pymdr.interpretation.validity import EXACT_WITHIN, Claim, Level, bodies_of
from pymdr.line.foundation import normal_force, states_at_depth
from pymdr.line.layered import LayeredLine
from pymdr.line.lines import line_of
from pymdr.presentation import plot
from pymdr.problem.contact import Contact
from pymdr.problem.layers import Layer, Layered
from pymdr.problem.materials import Elastic
from pymdr.problem.profiles import Profile
from pymdr.solving.arguments import positive_row
from pymdr.solving.mapped import refuse_unreachable
from pymdr.solving.study import Column, Study, over_rows
from pymdr.units import ArrayQuantityLike, QuantityLike


@dataclass(frozen=True, kw_only=True)
class ThicknessCorrection(Study):
    """Stiffness and force of a layer relative to a half-space over ``indentation``, by :func:`thickness_correction`."""

    subject: ClassVar[str] = "a thickness correction"
    columns: ClassVar[Mapping[str, Column]] = {
        "indentation": Column("indentation", "m"),
        "contact_radius": Column("radius", "m"),
        "width": Column("a / h", ""),
        "punch_factor": Column("punch factor", ""),
        "force_factor": Column("force factor", ""),
    }
    summary_claims: ClassVar[tuple[str, ...]] = ("force_factor",)

    def _figure(self) -> mpl.figure.Figure:
        """Both factors over the indentation."""
        return plot.thickness_study(
            self.data["indentation"].values,
            {name: self.data[name].values for name in ("force_factor", "punch_factor")},
        )


def thickness_correction(
    profile: Profile,
    poisson: QuantityLike,
    *,
    thickness: QuantityLike,
    indentation: ArrayQuantityLike,
    bond: str = "bonded",
) -> ThicknessCorrection:
    """
    Force of a layer on a rigid base over that of a half-space at the same indentation.

    Parameters
    ----------
    profile : Profile
        Shape of the tip.
    poisson : quantity
        Poisson's ratio of the sample, -1 < nu <= 0.5.
    thickness : quantity
        Thickness of the sample in m.
    indentation : array_like or quantity
        In m, above 0.
    bond : str
        "bonded" to its base, or "frictionless".

    Returns
    -------
    ThicknessCorrection
        Over the indentations: `contact_radius` a in m, `width` a/h, `punch_factor` k / (2 E* a), the stiffness over that of a
        half-space at the same radius, and `force_factor`. Divide a measured force by it to get that of a half-space.

    Raises
    ------
    ProblemError, PathError
        If the arguments cannot be used.
    ConvergenceError
        If the contact is wider than 300 thicknesses.

    See Also
    --------
    Layered : the contact of the layer itself.
    Elastic : has the thickness of a sample.

    Notes
    -----
    From the Fredholm equation of Lebedev and Ufliand (1958), without the errors of the table of Hayes and others (1972).

    References
    ----------
    - Lebedev and Ufliand (1958), J. Appl. Math. Mech. 22, 442-450.
    - Hayes, Keer, Herrmann and Mockros (1972), J. Biomech. 5, 541-551.

    Examples
    --------
    >>> import pymdr as mdr
    >>> cell = mdr.thickness_correction(mdr.Sphere("10 um"), 0.5, thickness="5 um", indentation=["0.1 um", "1 um"])
    >>> cell["force_factor"].values.round(6).tolist()
    [1.297254, 2.677441]
    """
    depth = positive_row(indentation, "m", "indentation")
    sample = Elastic(1.0, poisson)
    layered = Contact(profile, Layered([Layer(sample, thickness)], bond=bond))
    line, plain = line_of(layered), line_of(Contact(profile, sample))
    assert isinstance(line, LayeredLine)
    states = states_at_depth(line, depth)
    refuse_unreachable(line, profile, states)
    deep = states_at_depth(plain, depth)
    a = states.contact_radius
    widest = float(np.max(a))
    columns = {
        "contact_radius": a,
        "width": a / line.thickness,
        "punch_factor": line.stiffness(states.place) / (2.0 * line.modulus * a),
        "force_factor": normal_force(line, states) / normal_force(plain, deep),
    }
    fault = first_fault(line, widest, float(np.max(states.edge_excess)))
    where = np.ones(a.shape, dtype=bool) if fault is None else a < fault.before
    bodies, source = bodies_of(line)
    error = np.max(line.error(states.place), axis=1)
    level = Level.EXACT if np.max(error) <= EXACT_WITHIN else Level.APPROXIMATE
    reason = (
        f"exact for {bodies} in frictionless contact on a disk, against a half-space at the same indentation"
    )
    if fault is not None:
        level, reason = (level if where.any() else Level.NOT_VALID), f"{reason}; {fault.description}"
    claim = Claim(level, reason, source, where, error)
    columns = {name: np.where(where, values, np.nan) for name, values in columns.items()}
    at = int(np.argmax(a))
    return ThicknessCorrection(
        data=over_rows("indentation", depth, columns, ThicknessCorrection.columns),
        claims=dict.fromkeys(columns, claim),
        assumptions=base_assumption(line, float(a[at]), float(states.edge_excess[at])),
        notes=(),
    )
