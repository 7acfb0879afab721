"""Problems as plain dictionaries and back: case files and saved results share this.

Models of cases are derived from the problem dataclasses: a new profile or leg needs one entry in `tables`; user classes are
added by :func:`register`.
"""

from pymdr.problem.codec.cases import PressCase as PressCase
from pymdr.problem.codec.cases import RoughCase as RoughCase
from pymdr.problem.codec.cases import SurfaceCase as SurfaceCase
from pymdr.problem.codec.cases import decode_case as decode_case
from pymdr.problem.codec.cases import decode_contact as decode_contact
from pymdr.problem.codec.cases import decode_press as decode_press
from pymdr.problem.codec.cases import decode_rough as decode_rough
from pymdr.problem.codec.encoding import encode as encode
from pymdr.problem.codec.encoding import encode_case as encode_case
from pymdr.problem.codec.machines import MachineCase as MachineCase
from pymdr.problem.codec.machines import decode_machine as decode_machine
from pymdr.problem.codec.models import case_adapter as case_adapter
from pymdr.problem.codec.models import case_schema as case_schema
from pymdr.problem.codec.models import forget_models as forget_models
from pymdr.problem.codec.models import machine_adapter as machine_adapter
from pymdr.problem.codec.models import press_adapter as press_adapter
from pymdr.problem.codec.models import rough_adapter as rough_adapter
from pymdr.problem.codec.registering import import_kinds as import_kinds
from pymdr.problem.codec.registering import import_plugins as import_plugins
from pymdr.problem.codec.registering import register as register
from pymdr.problem.codec.tables import KIND_OF as KIND_OF
from pymdr.problem.codec.tables import PROFILES as PROFILES
from pymdr.problem.codec.tables import unknown_kinds as unknown_kinds
