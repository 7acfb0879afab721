"""The one kind of result: labelled arrays with claims, fields on demand, saving and plotting. Independent of the physics."""

from pymdr.result.arrays import labelled
from pymdr.result.readers import DeflectedReader, DirectedReader, EdgedField, FieldReader
from pymdr.result.status import Claims, Status
from pymdr.result.value import Reading, Result

__all__ = [
    "Claims",
    "DeflectedReader",
    "DirectedReader",
    "EdgedField",
    "FieldReader",
    "Reading",
    "Result",
    "Status",
    "labelled",
]
