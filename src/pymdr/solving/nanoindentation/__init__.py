"""Nanoindentation: unloading curves, continuous stiffness, films, drift, pop-in, and the calibration of area functions."""

from pymdr.solving.nanoindentation.calibrating import AreaCalibration as AreaCalibration
from pymdr.solving.nanoindentation.calibrating import calibrate_area as calibrate_area
from pymdr.solving.nanoindentation.continuous import ContinuousStiffness as ContinuousStiffness
from pymdr.solving.nanoindentation.continuous import continuous_stiffness as continuous_stiffness
from pymdr.solving.nanoindentation.drift import ThermalDrift as ThermalDrift
from pymdr.solving.nanoindentation.drift import thermal_drift as thermal_drift
from pymdr.solving.nanoindentation.films import FilmModulus as FilmModulus
from pymdr.solving.nanoindentation.films import film_modulus as film_modulus
from pymdr.solving.nanoindentation.popin import PopIn as PopIn
from pymdr.solving.nanoindentation.popin import first_pop_in as first_pop_in
from pymdr.solving.nanoindentation.verb import Nanoindentation as Nanoindentation
from pymdr.solving.nanoindentation.verb import oliver_pharr as oliver_pharr
