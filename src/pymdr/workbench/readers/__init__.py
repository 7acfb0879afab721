"""Readers of files of instruments; each gives records, columns in SI units with what the file says of its instrument."""

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
