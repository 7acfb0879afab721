"""Nanoindentation: unloading curves by Oliver and Pharr and by the method, and the calibration of area functions."""

from pymdr.solving.nanoindentation.calibrating import AreaCalibration as AreaCalibration
from pymdr.solving.nanoindentation.calibrating import calibrate_area as calibrate_area
from pymdr.solving.nanoindentation.verb import Nanoindentation as Nanoindentation
from pymdr.solving.nanoindentation.verb import oliver_pharr as oliver_pharr
