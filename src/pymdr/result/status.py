"""Status of a solution, and the claims of its quantities."""

from __future__ import annotations

import enum

from pymdr import presentation
from pymdr.errors import QuantityError
from pymdr.interpretation.validity import Claim
from pymdr.quantities import one_name
from pymdr.units import shown


class Status(enum.Enum):
    """Status of a solution.

    Examples
    --------
    >>> import pymdr as mdr
    >>> mdr.solve(mdr.Contact(mdr.Sphere("1 mm"), mdr.Elastic("1 GPa", 0.3)), mdr.load("1 N")).status
    <Status.COMPLETED: 'every step was solved and its contact is a disk'>
    """

    COMPLETED = "every step was solved and its contact is a disk"
    GLIDING = "from some step on the tangential force exceeds friction: the whole contact slides, and values in the plane are NaN"
    YIELDED = "every step was solved; the body has yielded, and its contact keeps a residual indentation"
    ELASTIC = "every step was solved; the body has not yielded"
    OF_A_CURVE = (
        "every step was solved on the line of a force curve, which gives neither contact areas nor pressures"
    )
    PARTLY_REFUSED = "at some steps the contact is not a disk, or could not be solved: values there are NaN, and only force_lower_bound is given"
    BY_RINGS = "every step was solved by boundary elements on rings, without the method"
    ATTACHED = "every step was solved; the path ends in contact"
    PULLED_OFF = "every step was solved; the contact was pulled off"
    NOT_TOUCHED = "every step was solved; the surfaces never came into contact"
    NOT_ROUND = "every step was solved; the body is not of revolution, and its contact is not a disk"
    ESTIMATED = "the body is not of revolution: the force is an estimate, given with its lower bound"
    BOUNDED = "the body is not of revolution, and at some steps only force_lower_bound is given"
    SLIPPED = "from some step on the shear exceeds adhesion: the whole contact slips, and values are NaN"
    ADHESION_PARTLY_REFUSED = (
        "at some steps the adhesive contact is not a disk, or could not be solved: values there are NaN"
    )
    ADHESION_REFUSED = "the adhesive contact is not a disk at any step: no values are given"
    REFUSED = "the contact is not a disk at any step: only force_lower_bound is given"


class Claims(dict[str, Claim]):
    """Claims by quantity, a table in notebooks."""

    def __getitem__(self, name: str) -> Claim:
        return super().__getitem__(one_name(name))

    def __missing__(self, name: str) -> Claim:
        raise QuantityError(f"no claim of {shown(name)}; there are claims of {', '.join(self)}")

    def _repr_html_(self) -> str:
        """The table."""
        return presentation.html.claims_html(self)
