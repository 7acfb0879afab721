"""Known data of tip, frame and sample of an evaluation."""

from __future__ import annotations

from typing import NamedTuple

from pymdr.errors import ProblemError
from pymdr.problem.materials import Material
from pymdr.problem.profiles import AreaFunction
from pymdr.solving.nanoindentation.analysing import Settings
from pymdr.solving.nanoindentation.calibrating import AreaCalibration, check_factors, frame_of, tip_compliance
from pymdr.units import QuantityLike, shown, to_si


class Known(NamedTuple):
    """Given data of tip, frame and sample."""

    area: AreaFunction | AreaCalibration
    frame_compliance: QuantityLike | None
    tip: Material
    poisson: QuantityLike | None
    beta: float
    epsilon: float | None


def settings_of(known: Known, limits: tuple[float, float]) -> Settings:
    """The known data, checked and in SI units."""
    area, frame_compliance, tip, poisson, beta, epsilon = known
    check_factors(beta, epsilon)
    nu = None if poisson is None else to_si(poisson, "", name="poisson")
    if nu is not None and not -1.0 < nu <= 0.5:
        raise ProblemError(f"poisson = {shown(poisson)}; it must be above -1 and at most 0.5")
    compliance = tip_compliance(tip)
    if isinstance(area, AreaFunction):
        frame = 0.0 if frame_compliance is None else frame_of(frame_compliance)
        return Settings(area, frame, None, compliance, nu, beta, epsilon, limits)
    if not isinstance(area, AreaCalibration):
        raise ProblemError(f"area = {shown(area)}; an AreaFunction or what calibrate_area returns is needed")
    if frame_compliance is not None:
        raise ProblemError("the calibration has a frame compliance; leave frame_compliance out")
    if area.data.attrs["beta"] != beta:
        raise ProblemError(
            f"beta = {beta:g}, but the area function was calibrated with {area.data.attrs['beta']:g}; use the same"
        )
    return Settings(area.area, area.frame_compliance, area.covariance, compliance, nu, beta, epsilon, limits)
