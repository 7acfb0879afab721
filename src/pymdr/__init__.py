"""The Method of Dimensionality Reduction (MDR) in contact mechanics.

Public names are resolved when they are first used, so that importing pymdr does no work.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from pymdr.errors import CaseError as CaseError
    from pymdr.errors import ConvergenceError as ConvergenceError
    from pymdr.errors import FileError as FileError
    from pymdr.errors import NotValidError as NotValidError
    from pymdr.errors import PathError as PathError
    from pymdr.errors import ProblemError as ProblemError
    from pymdr.errors import PymdrError as PymdrError
    from pymdr.errors import QuantityError as QuantityError
    from pymdr.errors import RefusedError as RefusedError
    from pymdr.errors import UnitError as UnitError
    from pymdr.independent.rings import Rings as Rings
    from pymdr.interpretation.validity import Claim as Claim
    from pymdr.interpretation.validity import Level as Level
    from pymdr.mapping.azimuth import azimuthal_mean as azimuthal_mean
    from pymdr.mapping.equivalent import equivalent_profile as equivalent_profile
    from pymdr.mapping.moduli import effective_moduli as effective_moduli
    from pymdr.mapping.patch import full_contact_stiffness as full_contact_stiffness
    from pymdr.mapping.relaxation import Relaxation as Relaxation
    from pymdr.mapping.relaxation import relaxation_of as relaxation_of
    from pymdr.mapping.relaxation import tangential_relaxation_of as tangential_relaxation_of
    from pymdr.mapping.rough_patch import rough_topography as rough_topography
    from pymdr.mapping.surfaces.preparing import detrend as detrend
    from pymdr.mapping.surfaces.preparing import fill_missing as fill_missing
    from pymdr.mapping.surfaces.resolution import tip_cutoff as tip_cutoff
    from pymdr.problem.contact import Contact as Contact
    from pymdr.problem.laws import DMT as DMT
    from pymdr.problem.laws import JKR as JKR
    from pymdr.problem.laws import Coulomb as Coulomb
    from pymdr.problem.laws import MaugisDugdale as MaugisDugdale
    from pymdr.problem.layers import Layer as Layer
    from pymdr.problem.layers import Layered as Layered
    from pymdr.problem.materials import Elastic as Elastic
    from pymdr.problem.materials import Graded as Graded
    from pymdr.problem.materials import Rigid as Rigid
    from pymdr.problem.materials import TransverselyIsotropic as TransverselyIsotropic
    from pymdr.problem.materials import Viscoelastic as Viscoelastic
    from pymdr.problem.measured import MeasuredCurve as MeasuredCurve
    from pymdr.problem.parameters import parameters_of as parameters_of
    from pymdr.problem.parameters import with_parameters as with_parameters
    from pymdr.problem.paths import Cycle as Cycle
    from pymdr.problem.paths import History as History
    from pymdr.problem.paths import Hold as Hold
    from pymdr.problem.paths import Path as Path
    from pymdr.problem.paths import Ramp as Ramp
    from pymdr.problem.paths import cycle as cycle
    from pymdr.problem.paths import drag as drag
    from pymdr.problem.paths import hold as hold
    from pymdr.problem.paths import indent as indent
    from pymdr.problem.paths import load as load
    from pymdr.problem.paths import ramp as ramp
    from pymdr.problem.paths import shift as shift
    from pymdr.problem.paths import travel as travel
    from pymdr.problem.profiles import ConcavePunch as ConcavePunch
    from pymdr.problem.profiles import Cone as Cone
    from pymdr.problem.profiles import CubicSpline as CubicSpline
    from pymdr.problem.profiles import DomedPunch as DomedPunch
    from pymdr.problem.profiles import Ellipsoid as Ellipsoid
    from pymdr.problem.profiles import EllipticParaboloid as EllipticParaboloid
    from pymdr.problem.profiles import FlatPunch as FlatPunch
    from pymdr.problem.profiles import ForceCurve as ForceCurve
    from pymdr.problem.profiles import Function as Function
    from pymdr.problem.profiles import Function2D as Function2D
    from pymdr.problem.profiles import Hyperboloid as Hyperboloid
    from pymdr.problem.profiles import Interpolated as Interpolated
    from pymdr.problem.profiles import Paraboloid as Paraboloid
    from pymdr.problem.profiles import PowerLaw as PowerLaw
    from pymdr.problem.profiles import Pyramid as Pyramid
    from pymdr.problem.profiles import RoundedCone as RoundedCone
    from pymdr.problem.profiles import RoundedFlat as RoundedFlat
    from pymdr.problem.profiles import Sampled as Sampled
    from pymdr.problem.profiles import Sampled2D as Sampled2D
    from pymdr.problem.profiles import ShapePreserving as ShapePreserving
    from pymdr.problem.profiles import SmoothingSpline as SmoothingSpline
    from pymdr.problem.profiles import Sphere as Sphere
    from pymdr.problem.profiles import TruncatedCone as TruncatedCone
    from pymdr.problem.profiles import TruncatedParaboloid as TruncatedParaboloid
    from pymdr.problem.profiles import TruncatedSphere as TruncatedSphere
    from pymdr.problem.profiles import Waviness as Waviness
    from pymdr.problem.rheology import KelvinVoigt as KelvinVoigt
    from pymdr.problem.rheology import Maxwell as Maxwell
    from pymdr.problem.rheology import PowerLawRheology as PowerLawRheology
    from pymdr.problem.rheology import Prony as Prony
    from pymdr.problem.rheology import StandardSolid as StandardSolid
    from pymdr.problem.rough import RoughSurface as RoughSurface
    from pymdr.problem.topography import Topography as Topography
    from pymdr.result import Result as Result
    from pymdr.result import Status as Status
    from pymdr.solving import AdhesionRegime as AdhesionRegime
    from pymdr.solving import Assessment as Assessment
    from pymdr.solving import FrictionLoop as FrictionLoop
    from pymdr.solving import Impact as Impact
    from pymdr.solving import PullOff as PullOff
    from pymdr.solving import Restitution as Restitution
    from pymdr.solving import adhesion_regime as adhesion_regime
    from pymdr.solving import assess as assess
    from pymdr.solving import foundation as foundation
    from pymdr.solving import friction_foundation as friction_foundation
    from pymdr.solving import friction_loop as friction_loop
    from pymdr.solving import impact as impact
    from pymdr.solving import pull_off as pull_off
    from pymdr.solving import restitution as restitution
    from pymdr.solving import solve as solve
    from pymdr.solving import solve_batch as solve_batch
    from pymdr.solving.azimuth import AzimuthalProfile as AzimuthalProfile
    from pymdr.solving.azimuth import azimuthal_profile as azimuthal_profile
    from pymdr.solving.calibrating import LineCalibration as LineCalibration
    from pymdr.solving.calibrating import calibrate_coefficient as calibrate_coefficient
    from pymdr.solving.curves import Baseline as Baseline
    from pymdr.solving.curves import ContactPoint as ContactPoint
    from pymdr.solving.curves import baseline_of as baseline_of
    from pymdr.solving.curves import contact_point_of as contact_point_of
    from pymdr.solving.curves import join_segments as join_segments
    from pymdr.solving.curves import leave_out_marked as leave_out_marked
    from pymdr.solving.curves import mark_outliers as mark_outliers
    from pymdr.solving.curves import mark_saturated as mark_saturated
    from pymdr.solving.curves import orient as orient
    from pymdr.solving.curves import prepare as prepare
    from pymdr.solving.curves import recalibrate as recalibrate
    from pymdr.solving.curves import set_contact_point as set_contact_point
    from pymdr.solving.curves import subtract_baseline as subtract_baseline
    from pymdr.solving.curves import to_indentation as to_indentation
    from pymdr.solving.curves import undo as undo
    from pymdr.solving.exporting import ContactLaw as ContactLaw
    from pymdr.solving.exporting import export_law as export_law
    from pymdr.solving.fits import FitResult as FitResult
    from pymdr.solving.fits import Fitted as Fitted
    from pymdr.solving.fits import FittedMap as FittedMap
    from pymdr.solving.fits import LawComparison as LawComparison
    from pymdr.solving.fits import compare_laws as compare_laws
    from pymdr.solving.fits import fit as fit
    from pymdr.solving.fits import fit_map as fit_map
    from pymdr.solving.heating import FrictionalHeat as FrictionalHeat
    from pymdr.solving.heating import JouleHeating as JouleHeating
    from pymdr.solving.heating import frictional_heat as frictional_heat
    from pymdr.solving.heating import joule_heating as joule_heating
    from pymdr.solving.press import PressedSurface as PressedSurface
    from pymdr.solving.press import open_pressed_surface as open_pressed_surface
    from pymdr.solving.press import press as press
    from pymdr.solving.reopening import open_result as open_result
    from pymdr.solving.rolling import Rolling as Rolling
    from pymdr.solving.rolling import rolling as rolling
    from pymdr.solving.rough import RoughContact as RoughContact
    from pymdr.solving.rough import RoughLine as RoughLine
    from pymdr.solving.rough import press_rough as press_rough
    from pymdr.solving.rough import rough_line as rough_line
    from pymdr.solving.rough_sliding import rough_sliding_friction as rough_sliding_friction
    from pymdr.solving.roughness import PowerSpectrum as PowerSpectrum
    from pymdr.solving.roughness import SelfAffineFit as SelfAffineFit
    from pymdr.solving.roughness import power_spectrum as power_spectrum
    from pymdr.solving.sliding import SlidingFriction as SlidingFriction
    from pymdr.solving.sliding import sliding_friction as sliding_friction
    from pymdr.solving.sweep import Sweep as Sweep
    from pymdr.solving.sweep import sweep as sweep
    from pymdr.solving.thickness import ThicknessCorrection as ThicknessCorrection
    from pymdr.solving.thickness import thickness_correction as thickness_correction
    from pymdr.workbench.curves import force_map as force_map
    from pymdr.workbench.curves import read_curves as read_curves
    from pymdr.workbench.curves import read_records as read_records
    from pymdr.workbench.curves import stack_curves as stack_curves
    from pymdr.workbench.records import MeasuredLoops as MeasuredLoops
    from pymdr.workbench.records import measured_loops as measured_loops
    from pymdr.workbench.rheometry import PronyFit as PronyFit
    from pymdr.workbench.rheometry import fit_prony as fit_prony
    from pymdr.workbench.shapes import ShapeVerification as ShapeVerification
    from pymdr.workbench.sliding import SlidingVerification as SlidingVerification
    from pymdr.workbench.sliding import verify_sliding as verify_sliding
    from pymdr.workbench.tables import read_curve as read_curve
    from pymdr.workbench.tables import read_force_curve as read_force_curve
    from pymdr.workbench.tables import read_path as read_path
    from pymdr.workbench.tables import read_profile as read_profile
    from pymdr.workbench.tables import read_record as read_record
    from pymdr.workbench.topographies import read_topography as read_topography
    from pymdr.workbench.verification import Verification as Verification
    from pymdr.workbench.verification import verify as verify

_HOMES: dict[str, tuple[str, ...]] = {
    "pymdr.errors": (
        "CaseError",
        "ConvergenceError",
        "FileError",
        "NotValidError",
        "PathError",
        "ProblemError",
        "PymdrError",
        "QuantityError",
        "RefusedError",
        "UnitError",
    ),
    "pymdr.independent.rings": ("Rings",),
    "pymdr.interpretation.validity": ("Claim", "Level"),
    "pymdr.mapping.azimuth": ("azimuthal_mean",),
    "pymdr.mapping.equivalent": ("equivalent_profile",),
    "pymdr.mapping.moduli": ("effective_moduli",),
    "pymdr.mapping.patch": ("full_contact_stiffness",),
    "pymdr.mapping.relaxation": ("Relaxation", "relaxation_of", "tangential_relaxation_of"),
    "pymdr.problem.contact": ("Contact",),
    "pymdr.problem.laws": ("DMT", "JKR", "Coulomb", "MaugisDugdale"),
    "pymdr.problem.layers": ("Layer", "Layered"),
    "pymdr.problem.materials": ("Elastic", "Graded", "Rigid", "TransverselyIsotropic", "Viscoelastic"),
    "pymdr.problem.paths": (
        "Cycle",
        "History",
        "Hold",
        "Path",
        "Ramp",
        "cycle",
        "drag",
        "hold",
        "indent",
        "load",
        "ramp",
        "shift",
        "travel",
    ),
    "pymdr.problem.profiles": (
        "ConcavePunch",
        "Cone",
        "CubicSpline",
        "DomedPunch",
        "Ellipsoid",
        "EllipticParaboloid",
        "FlatPunch",
        "ForceCurve",
        "Function",
        "Function2D",
        "Hyperboloid",
        "Interpolated",
        "Paraboloid",
        "PowerLaw",
        "Pyramid",
        "RoundedCone",
        "RoundedFlat",
        "Sampled",
        "Sampled2D",
        "ShapePreserving",
        "SmoothingSpline",
        "Sphere",
        "TruncatedCone",
        "TruncatedParaboloid",
        "TruncatedSphere",
        "Waviness",
    ),
    "pymdr.problem.rheology": ("KelvinVoigt", "Maxwell", "PowerLawRheology", "Prony", "StandardSolid"),
    "pymdr.mapping.rough_patch": ("rough_topography",),
    "pymdr.problem.rough": ("RoughSurface",),
    "pymdr.problem.topography": ("Topography",),
    "pymdr.result": ("Result", "Status"),
    "pymdr.solving.exporting": ("ContactLaw", "export_law"),
    "pymdr.solving.heating": ("FrictionalHeat", "JouleHeating", "frictional_heat", "joule_heating"),
    "pymdr.solving.reopening": ("open_result",),
    "pymdr.solving.rolling": ("Rolling", "rolling"),
    "pymdr.solving.thickness": ("ThicknessCorrection", "thickness_correction"),
    "pymdr.solving.press": ("PressedSurface", "open_pressed_surface", "press"),
    "pymdr.solving.calibrating": ("LineCalibration", "calibrate_coefficient"),
    "pymdr.solving.rough": ("RoughContact", "RoughLine", "press_rough", "rough_line"),
    "pymdr.solving.rough_sliding": ("rough_sliding_friction",),
    "pymdr.problem.measured": ("MeasuredCurve",),
    "pymdr.solving.fits": (
        "FitResult",
        "Fitted",
        "FittedMap",
        "LawComparison",
        "compare_laws",
        "fit",
        "fit_map",
    ),
    "pymdr.solving.curves": (
        "Baseline",
        "ContactPoint",
        "baseline_of",
        "contact_point_of",
        "join_segments",
        "leave_out_marked",
        "mark_outliers",
        "mark_saturated",
        "orient",
        "prepare",
        "recalibrate",
        "set_contact_point",
        "subtract_baseline",
        "to_indentation",
        "undo",
    ),
    "pymdr.solving.sweep": ("Sweep", "sweep"),
    "pymdr.problem.parameters": ("parameters_of", "with_parameters"),
    "pymdr.solving.sliding": ("SlidingFriction", "sliding_friction"),
    "pymdr.solving": (
        "AdhesionRegime",
        "Assessment",
        "FrictionLoop",
        "Impact",
        "PullOff",
        "Restitution",
        "adhesion_regime",
        "assess",
        "foundation",
        "friction_foundation",
        "friction_loop",
        "impact",
        "pull_off",
        "restitution",
        "solve",
        "solve_batch",
    ),
    "pymdr.workbench.curves": ("force_map", "read_curves", "read_records", "stack_curves"),
    "pymdr.workbench.records": ("MeasuredLoops", "measured_loops"),
    "pymdr.workbench.rheometry": ("PronyFit", "fit_prony"),
    "pymdr.workbench.shapes": ("ShapeVerification",),
    "pymdr.workbench.sliding": ("SlidingVerification", "verify_sliding"),
    "pymdr.workbench.tables": ("read_curve", "read_force_curve", "read_path", "read_profile", "read_record"),
    "pymdr.workbench.verification": ("Verification", "verify"),
    "pymdr.mapping.surfaces.preparing": ("detrend", "fill_missing"),
    "pymdr.mapping.surfaces.resolution": ("tip_cutoff",),
    "pymdr.solving.azimuth": ("AzimuthalProfile", "azimuthal_profile"),
    "pymdr.solving.roughness": ("PowerSpectrum", "SelfAffineFit", "power_spectrum"),
    "pymdr.workbench.topographies": ("read_topography",),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}

__all__ = ["__version__", *sorted(_HOME_OF)]


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'pymdr' has no attribute {name!r}")
    value = getattr(importlib.import_module(_HOME_OF[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
