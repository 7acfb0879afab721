"""What is chosen on the page: the tables of a case, their kinds and their adjustable values."""

from pymdr.explore.model.choice import (
    PARTS,
    Choice,
    Place,
    Plain,
    chosen,
    number,
    value_at,
    with_path,
    with_table,
)
from pymdr.explore.model.files import (
    STARTS,
    answer,
    case_of,
    choices_of,
    fitted_to,
    of_file,
    python_lines,
    start,
    toml,
)
from pymdr.explore.model.kinds import NONE, OWN, PATHS, kind_of, kinds, with_kind
from pymdr.explore.model.knobs import Knob, dragged, fraction, knobs, text, typed

__all__ = [
    "NONE",
    "OWN",
    "PARTS",
    "PATHS",
    "STARTS",
    "Choice",
    "Knob",
    "Place",
    "Plain",
    "answer",
    "case_of",
    "choices_of",
    "chosen",
    "dragged",
    "fitted_to",
    "fraction",
    "kind_of",
    "kinds",
    "knobs",
    "number",
    "of_file",
    "python_lines",
    "start",
    "text",
    "toml",
    "typed",
    "value_at",
    "with_kind",
    "with_path",
    "with_table",
]
