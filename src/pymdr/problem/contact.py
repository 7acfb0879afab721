"""The contact: a profile pressed between two bodies."""

from __future__ import annotations

from dataclasses import dataclass, field

from pymdr.errors import ProblemError
from pymdr.problem.materials import Material, Rigid
from pymdr.problem.profiles import Profile
from pymdr.problem.values import Value


@dataclass(frozen=True, eq=False)
class Contact(Value):
    """
    A frictionless contact of two bodies of revolution.

    Parameters
    ----------
    profile : Profile
        The combined initial gap f(r).
    body : Elastic or Rigid
        The first body.
    counterbody : Elastic or Rigid
        The second body; rigid unless given.

    Raises
    ------
    ProblemError
        If an argument is of the wrong kind or both bodies are rigid.

    Examples
    --------
    >>> from pymdr.problem.materials import Elastic
    >>> from pymdr.problem.profiles import Sphere
    >>> Contact(Sphere("10 mm"), Elastic("210 GPa", 0.3)).counterbody
    Rigid()
    """

    profile: Profile
    body: Material
    counterbody: Material = field(default_factory=Rigid)

    def __post_init__(self) -> None:
        if not isinstance(self.profile, Profile):
            raise ProblemError(
                f"Contact.profile = {self.profile!r}: a profile such as Sphere('10 mm') is needed"
            )
        for name in ("body", "counterbody"):
            material = getattr(self, name)
            if not isinstance(material, Material):
                raise ProblemError(
                    f"Contact.{name} = {material!r}: a material such as Elastic('210 GPa', 0.3) is needed"
                )
        if isinstance(self.body, Rigid) and isinstance(self.counterbody, Rigid):
            raise ProblemError("Contact: both bodies are rigid; at least one must be Elastic")
