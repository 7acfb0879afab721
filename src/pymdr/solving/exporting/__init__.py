"""Laws of force, stiffness and radius over the depth, as tables for other programs."""

from pymdr.solving.exporting.value import ContactLaw as ContactLaw
from pymdr.solving.exporting.verb import export_law as export_law

__all__ = ["ContactLaw", "export_law"]
