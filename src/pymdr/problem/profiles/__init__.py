"""Profiles: the combined initial gap f(r) of the two bodies, with f(0) = 0."""

from pymdr.problem.profiles.base import Profile as Profile
from pymdr.problem.profiles.base import Sum as Sum
from pymdr.problem.profiles.blunt import Hyperboloid as Hyperboloid
from pymdr.problem.profiles.blunt import RoundedCone as RoundedCone
from pymdr.problem.profiles.blunt import TruncatedCone as TruncatedCone
from pymdr.problem.profiles.blunt import TruncatedParaboloid as TruncatedParaboloid
from pymdr.problem.profiles.blunt import TruncatedSphere as TruncatedSphere
from pymdr.problem.profiles.closed import Cone as Cone
from pymdr.problem.profiles.closed import Ellipsoid as Ellipsoid
from pymdr.problem.profiles.closed import FlatPunch as FlatPunch
from pymdr.problem.profiles.closed import Paraboloid as Paraboloid
from pymdr.problem.profiles.closed import PowerLaw as PowerLaw
from pymdr.problem.profiles.closed import Sphere as Sphere
from pymdr.problem.profiles.forcecurve import ForceCurve as ForceCurve
from pymdr.problem.profiles.function import Function as Function
from pymdr.problem.profiles.function import Interpolated as Interpolated
from pymdr.problem.profiles.function import call as call
from pymdr.problem.profiles.punches import ConcavePunch as ConcavePunch
from pymdr.problem.profiles.punches import DomedPunch as DomedPunch
from pymdr.problem.profiles.punches import RoundedFlat as RoundedFlat
from pymdr.problem.profiles.punches import Waviness as Waviness
from pymdr.problem.profiles.sampled import CubicSpline as CubicSpline
from pymdr.problem.profiles.sampled import Sampled as Sampled
from pymdr.problem.profiles.sampled import ShapePreserving as ShapePreserving
from pymdr.problem.profiles.sampled import SmoothingSpline as SmoothingSpline
