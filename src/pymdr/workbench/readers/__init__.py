"""Readers of files of instruments; each returns records: columns in SI units and the instrument's metadata."""

from pymdr.workbench.readers.finding import GROUP, is_user_table, records_of
from pymdr.workbench.readers.record import Calibration, ForceFormat, ForceRecord, calibration_of, curves_of

__all__ = [
    "GROUP",
    "Calibration",
    "ForceFormat",
    "ForceRecord",
    "calibration_of",
    "curves_of",
    "is_user_table",
    "records_of",
]
