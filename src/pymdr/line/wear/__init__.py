"""Fretting wear on the line: wear over blocks of cycles, and the limiting profile."""

from pymdr.line.wear.limits import WearLimit as WearLimit
from pymdr.line.wear.limits import outer_radius as outer_radius
from pymdr.line.wear.limits import wear_limit as wear_limit
from pymdr.line.wear.march import History as History
from pymdr.line.wear.march import Wearing as Wearing
from pymdr.line.wear.march import march as march
