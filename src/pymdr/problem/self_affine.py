"""A rough line: a random profile along which an elastomer is passed."""

from __future__ import annotations

from dataclasses import dataclass

from pymdr.errors import ProblemError
from pymdr.problem.values import OptionalSIField, SIField, Value
from pymdr.units import metres, shown


@dataclass(frozen=True, eq=False, kw_only=True)
class SelfAffineLine(Value):
    """
    A self-affine random line of one length, which repeats itself: waves of random phases, C(q) ~ q^-(2H + 1).

    Parameters
    ----------
    length : quantity
        Of the line in m, above 0.
    rms_slope : quantity
        Root of the mean of its squared slope, above 0.
    hurst : quantity
        Hurst's exponent H, 0 to 1.
    shortest : quantity
        Shortest wavelength in m, above 0 and below the longest.
    longest : quantity, optional
        Longest wavelength in m, at most the length, which it is unless given.
    seed : int
        Of the phases.

    Raises
    ------
    ProblemError
        If a value is outside its limits.

    Notes
    -----
    By the rule of Geike and Popov, C_1D = pi q C_2D, the mean squared slope of the line is that of the full gradient of an
    isotropic surface, twice that of a cut through it (Popov and Hess 2015, chapter 10).

    Examples
    --------
    >>> SelfAffineLine(length="1 mm", rms_slope=0.1, hurst=0.8, shortest="10 um").longest_wave
    0.001
    """

    length: SIField = SIField("m", above=0.0, words="length of the line")
    rms_slope: SIField = SIField("", above=0.0, words="root mean square of the slope")
    hurst: SIField = SIField("", at_least=0.0, at_most=1.0, words="Hurst's exponent")
    shortest: SIField = SIField("m", above=0.0, words="shortest wavelength")
    longest: OptionalSIField = OptionalSIField("m", above=0.0, words="longest wavelength")
    seed: int = 0

    def __post_init__(self) -> None:
        if not isinstance(self.seed, int) or isinstance(self.seed, bool) or self.seed < 0:
            raise ProblemError(
                f"SelfAffineLine: seed = {shown(self.seed)}; a whole number from 0 on is needed"
            )
        if not self.shortest <= self.longest_wave <= self.length:
            raise ProblemError(
                f"SelfAffineLine: wavelengths from {metres(self.shortest)} to {metres(self.longest_wave)} on a length of "
                f"{metres(self.length)}; they must rise, to at most the length"
            )
        if self.length > _MOST * self.shortest:
            raise ProblemError(
                f"SelfAffineLine: length = {metres(self.length)} is more than {_MOST} of the shortest waves of "
                f"{metres(self.shortest)}; take a shorter line, or longer waves"
            )

    @property
    def longest_wave(self) -> float:
        """In m."""
        return self.length if self.longest is None else self.longest


_MOST = 4096
