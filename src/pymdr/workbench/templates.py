"""Commented cases to start from."""

from __future__ import annotations

import difflib

from pymdr.errors import CaseError

_BODIES = """
[body]                      # the first body
kind = "elastic"            # or "rigid"
young = "210 GPa"           # Young's modulus, above 0
poisson = 0.3               # Poisson's ratio, above -1 and at most 0.5

[counterbody]               # the second body; leave the table out for a rigid one
kind = "elastic"
young = "70 GPa"
poisson = 0.22
"""

_SIMILAR = """
[body]                      # the first body
kind = "elastic"
young = "210 GPa"
poisson = 0.3

[counterbody]               # equal bodies: friction is then uncoupled from pressure
kind = "elastic"
young = "210 GPa"
poisson = 0.3
"""

_LOAD = """
[[path]]                    # one table for every leg of the loading path
kind = "load"               # load, indent, ramp, hold or path
normal_force = "50 N"       # the target; the leg starts where the one before ended
steps = 50                  # rows of the result
"""

_INDENT = """
[[path]]                    # one table for every leg of the loading path
kind = "indent"             # load, indent, ramp, hold or path
indentation = "{depth}"     # the target; the leg starts where the one before ended
steps = 40                  # rows of the result
"""

_PROFILES = {
    "ball": """
[profile]                   # the gap f(r) between the undeformed surfaces
kind = "sphere"             # the true sphere; "paraboloid" is Hertz's
radius = "10 mm"
""",
    "gel": """
[profile]                   # the gap f(r) between the undeformed surfaces
kind = "paraboloid"
radius = "50 um"
""",
    "layers": """
[profile]                   # the gap f(r) between the undeformed surfaces
kind = "paraboloid"
radius = "100 um"
""",
    "cone": """
[profile]                   # the gap f(r) between the undeformed surfaces
kind = "cone"
half_angle = "70.3 deg"     # between axis and flank; or slope = 0.358
""",
    "worn": """
[profile]                   # the gap f(r) between the undeformed surfaces
kind = "truncated_sphere"   # or "truncated_paraboloid"
radius = "10 mm"
flat_radius = "0.5 mm"      # up to which it is worn flat
# a blunt cone:             kind = "truncated_cone", half_angle, flat_radius
# a cone with a round tip:  kind = "rounded_cone" or "hyperboloid", half_angle, tip_radius
# a punch:                  kind = "rounded_flat", flat_radius, edge_radius;
#                           "domed_punch", radius, dome_radius; "concave_punch", radius, hollow_radius
""",
    "punch": """
[profile]                   # a cylinder with a domed end, as a sum of two profiles
kind = "sum"

[[profile.parts]]
kind = "flat_punch"         # the sharp edge
radius = "1 mm"

[[profile.parts]]
kind = "paraboloid"         # the dome
radius = "50 mm"
""",
    "tip": """
[profile]                   # a measured profile: radii from 0 and heights, or a file with them
kind = "sampled"
radius = ["0 nm", "20 nm", "40 nm", "60 nm", "80 nm", "100 nm"]
height = ["0 nm", "2.1 nm", "7.9 nm", "18.2 nm", "31.8 nm", "50.1 nm"]
# file = "tip.csv"          # in place of both; header such as: r [nm],f [nm],scatter [nm]
interpolation = { kind = "smoothing_spline" }  # or "cubic_spline" with tip = "round" or "sharp", "shape_preserving";
                            # without this line: smoothing where there is a scatter, else a cubic spline
""",
}

_GEL = """
[body]                      # the soft one
kind = "elastic"
young = "30 kPa"
poisson = 0.5

[adhesion]
kind = "jkr"                # or "maugis_dugdale" (with strength or range), "dmt", "capillary"
work = "2 mJ/m^2"           # work of adhesion

[solve]
machine_stiffness = "0.05 N/m"  # of the cantilever; needed by legs of the kind travel
"""

_JOINT = """
[friction]
kind = "coulomb"
coefficient = 0.3           # inf is contact without slip
"""

_RUBBER = """
[body]                      # the soft one; the counterbody is rigid
kind = "viscoelastic"
poisson = 0.5
shear = { kind = "standard_solid", equilibrium = "1 MPa", modulus = "3 MPa", time = "50 ms" }
# measured: shear = { kind = "prony", file = "dma.csv" }, with the columns time [s], G [MPa]
#           or frequency [Hz], G' [MPa], G'' [MPa]
# friction on it against speed: pymdr sliding CASE.toml --speed "1 mm/s" --normal-force "10 N"
# its rebound:                  pymdr impact CASE.toml --mass "10 g" --speed "1 m/s"
"""

_CREEPING = """
[body]                      # the soft one; the counterbody is rigid
kind = "viscoelastic"
poisson = 0.4
shear = { kind = "power_law_rheology", modulus = "1 GPa", time = "1 s", exponent = 0.1 }
# or kind = "prony", "standard_solid", "maxwell" or "kelvin_voigt"
"""

_LAYERS = """
[body]                      # layers on a base; without a table [counterbody] the indenter is rigid
kind = "layered"
bond = "bonded"             # between the lowest layer and the base; or "frictionless"
base = { kind = "elastic", young = "70 GPa", poisson = 0.22 }  # rigid, if you leave it out

[[body.layers]]             # from the surface downward; a viscoelastic material relaxes, on a rigid base
material = { kind = "elastic", young = "400 GPa", poisson = 0.25 }
thickness = "2 um"

[[body.layers]]
material = { kind = "elastic", young = "100 GPa", poisson = 0.3 }
thickness = "5 um"
"""

_SWITCH = """
[body]                      # silver
kind = "elastic"
young = "83 GPa"
poisson = 0.37
resistivity = "15.9 nohm*m"
thermal_conductivity = "429 W/(m*K)"

[counterbody]
kind = "elastic"
young = "83 GPa"
poisson = 0.37
resistivity = "15.9 nohm*m"
thermal_conductivity = "429 W/(m*K)"
# its heat by a voltage: pymdr joule CASE.toml --temperature "20 degC" --voltage "50 mV"
"""

_TRAVEL = """
[[path]]                    # one table for every leg of the loading path
kind = "travel"             # of the piezo: indentation + normal force / machine stiffness
travel = "5 um"
steps = 100

[[path]]
kind = "travel"
travel = "-20 um"
steps = 400
"""

_SHAKEN = """
[[path]]                    # one table for every leg of the loading path
kind = "load"
normal_force = "50 N"

[[path]]                    # the load stays where it is
kind = "cycle"              # to +amplitude, to -amplitude and back
shift = "0.8 um"            # or tangential_force
cycles = 2
steps = 400                 # rows of the whole leg
"""

_PATHS = {
    "ball": _LOAD,
    "cone": _INDENT.format(depth="100 nm"),
    "worn": _LOAD,
    "punch": _INDENT.format(depth="60 um"),
    "tip": _INDENT.format(depth="20 nm"),
    "rubber": """
[[path]]                    # one table for every leg of the loading path
kind = "indent"
indentation = "0.1 mm"
rate = "2 mm/s"             # or duration
steps = 60

[[path]]
kind = "hold"               # the force relaxes
duration = "0.1 s"
steps = 40

[[path]]
kind = "indent"
indentation = "0 mm"
rate = "2 mm/s"
steps = 60
""",
    "creep": """
[[path]]                    # one table for every leg of the loading path
kind = "load"
normal_force = "10 N"
duration = "0.1 s"
steps = 20

[[path]]
kind = "hold"               # the force stays, and the indentation grows
duration = "100 s"
steps = 100
""",
    "layers": _INDENT.format(depth="200 nm"),
    "switch": """
[[path]]                    # one table for every leg of the loading path
kind = "load"
normal_force = "5 N"
steps = 50
""",
    "gel": _TRAVEL,
    "joint": _SHAKEN,
    "cycle": _LOAD
    + """
[[path]]
kind = "hold"               # every channel stays where it is
steps = 5

[[path]]
kind = "load"
normal_force = "0 N"
steps = 50
""",
}
_ROUGH = """\
# A pymdr case of a rough surface. Solve it with: pymdr rough CASE.toml
# Quantities are texts with units, or plain numbers in SI units.
title = "My rough"
normal_force = "1 N"        # or several: [ "0.1 N", "1 N" ]; or indentation

[surface]
hurst = 0.8                 # Hurst exponent, above 0 and at most 1
rms = "1 um"                # root mean square of the heights of the patch
size = "1 mm"               # side of a square, or [ "1 mm", "2 mm" ]
shortest = "10 um"          # shortest wavelength
# longest = "0.2 mm"        # roll-off; the power law is refused with it
seed = 0                    # which surface of all

[body]
kind = "elastic"
young = "210 GPa"
poisson = 0.3

[counterbody]               # rigid, if you leave this table out
kind = "elastic"
young = "70 GPa"
poisson = 0.22

# [ball]                    # the rough ball; without this table the surface is nominally flat
# radius = "10 mm"
"""
_PRESS = """\
# A pymdr case of a surface that boundary elements press. Solve it with: pymdr press CASE.toml
# Quantities are texts with units, or plain numbers in SI units.
title = "My press"
normal_force = "1 N"        # or several: [ "0.1 N", "1 N" ]; or indentation
# punch = true              # with measured heights: the body ends at their border

[surface]                   # for measured heights replace these keys by the commented ones
hurst = 0.8                 # Hurst exponent, above 0 and at most 1
rms = "1 um"                # root mean square of the heights of the patch
size = "1 mm"               # side of a square, or [ "1 mm", "2 mm" ]
shortest = "0.1 mm"         # shortest wavelength, of 8 pixels
seed = 0                    # which surface of all
# file = "ground.sdf"       # relative to this file; any format of read_topography
# channel = 0               # number or name, where the file has several
# size = "1 mm"             # where the file has none
# unit = "nm"               # of the heights, where the file has none
# missing = "interpolate"   # or "crop": treatment of missing heights
# detrend = "plane"         # mean, plane, sphere or curvature: trend to subtract

[body]
kind = "elastic"            # or "transversely_isotropic"
young = "210 GPa"
poisson = 0.3

[counterbody]               # rigid, if you leave this table out
kind = "elastic"
young = "70 GPa"
poisson = 0.22
"""
_MACHINE = """\
# A pymdr case of a machine. Check it with: pymdr check CASE.toml; move it with: pymdr move CASE.toml -o OUT
# Quantities are texts with units, or plain numbers in SI units.
title = "My machine"

[profile]                   # all joints are this contact
kind = "sphere"
radius = "10 mm"

[body]
kind = "elastic"
young = "210 GPa"
poisson = 0.3

[counterbody]               # rigid, if you leave this table out
kind = "elastic"
young = "210 GPa"
poisson = 0.3

[friction]                  # frictionless, if you leave this table out
kind = "coulomb"
coefficient = 0.3

[machine]
duration = "0.4 s"
steps = 1000                # rows after the first
# accuracy = 1e-3           # largest change of a position by halving the steps

[[machine.bodies]]          # mass, rotor or drive
kind = "mass"
name = "slider"
mass = "1 kg"

[[machine.bodies]]          # a point that is moved
kind = "drive"
name = "stage"
velocity = "20 mm/s"        # the spring is stretched until the contact slips
# amplitude = "1 um"        # and shaken
# frequency = "20 kHz"

[[machine.links]]           # spring, joint or force
kind = "spring"
between = ["stage", "slider"]
stiffness = "2 kN/m"
# damping = "1 N*s/m"

[[machine.links]]
kind = "joint"
name = "pad"
tangential = "slider"       # what shifts the contact; normal = "..." adds to its indentation
indentation = "1 um"
"""
_CONTACTS = {
    "gel": _GEL,
    "joint": _SIMILAR + _JOINT,
    "rubber": _RUBBER,
    "creep": _CREEPING,
    "layers": _LAYERS,
    "switch": _SWITCH,
}
"""What stands between profile and path."""
_WHOLE = {"rough": _ROUGH, "press": _PRESS, "machine": _MACHINE}
"""Cases without a path."""
KINDS = (*_PATHS, *_WHOLE)


def template(kind: str) -> str:
    """
    A commented case file.

    Parameters
    ----------
    kind : str
        One of ``ball``, ``cone``, ``worn`` (blunt shapes), ``punch``, ``tip``, ``gel`` (adhesion), ``joint`` (friction), ``cycle``,
        ``rubber`` and ``creep`` (bodies with memory), ``layers``, ``switch`` (conduction), ``rough``, ``press`` and ``machine``.

    Examples
    --------
    >>> template("ball").splitlines()[0]
    '# A pymdr case. Check it with: pymdr check CASE.toml; solve it with: pymdr run CASE.toml'
    """
    if kind not in KINDS:
        near = difflib.get_close_matches(kind, KINDS, n=1)
        hint = f"did you mean {near[0]!r}?" if near else f"known are {', '.join(KINDS)}"
        raise CaseError(f"unknown kind of case {kind!r}; {hint}")
    if kind in _WHOLE:
        return _WHOLE[kind]
    head = (
        "# A pymdr case. Check it with: pymdr check CASE.toml; solve it with: pymdr run CASE.toml\n"
        "# Quantities are texts with units, or plain numbers in SI units.\n"
        f'title = "My {kind}"\n'
    )
    profile = _PROFILES.get(kind, _PROFILES["ball"])
    return head + profile + _CONTACTS.get(kind, _BODIES) + _PATHS[kind]
