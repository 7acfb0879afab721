"""Laws of force, stiffness and radius over the depth, as tables for other programs."""

from pymdr.solving.exporting.value import ContactLaw as ContactLaw
from pymdr.solving.exporting.verb import check_lawful as check_lawful
from pymdr.solving.exporting.verb import export_law as export_law

__all__ = ["ContactLaw", "check_lawful", "export_law"]
