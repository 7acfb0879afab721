"""Contacts of linear viscoelastic bodies whose moduli all relax by one function."""

from pymdr.line.memory.dividing import Goal, Parts, parts_of, whole_rows
from pymdr.line.memory.histories import (
    MemoryHistory,
    MemoryState,
    Passage,
    Watch,
    deepest_under,
    follow_loads,
    follow_springs,
    follow_travels,
    line_state,
    prepared,
    virgin,
)
from pymdr.line.memory.moved import RelaxingContacts
from pymdr.line.memory.sheared import ShearedContacts
from pymdr.line.memory.springs import Springs, springs_to
from pymdr.line.memory.tabulated import approach_and_retreat, divided, tabulated
from pymdr.line.memory.tangential import (
    TangentialHistory,
    TangentialState,
    shear_springs,
    unsheared,
)
from pymdr.line.memory.ting import Rows, compliant, creep, relaxed, ting

__all__ = [
    "Goal",
    "MemoryHistory",
    "MemoryState",
    "Parts",
    "Passage",
    "RelaxingContacts",
    "Rows",
    "ShearedContacts",
    "Springs",
    "TangentialHistory",
    "TangentialState",
    "Watch",
    "approach_and_retreat",
    "compliant",
    "creep",
    "deepest_under",
    "divided",
    "follow_loads",
    "follow_springs",
    "follow_travels",
    "line_state",
    "parts_of",
    "prepared",
    "relaxed",
    "shear_springs",
    "springs_to",
    "tabulated",
    "ting",
    "unsheared",
    "virgin",
    "whole_rows",
]
