"""Whole jobs from files through the shell, in three commands or fewer, against closed forms and what made the data."""

import importlib.util
import json
import math
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import fsolve

import pymdr as mdr

STEEL = 'kind = "elastic"\nyoung = "210 GPa"\npoisson = 0.3\n'
MODULUS = 210e9 / (2.0 * (1.0 - 0.3**2))
"""Of two bodies of steel, in Pa."""


@pytest.fixture
def job(tmp_path, shell):
    """Run a command that has to succeed; gives its output."""

    def run(*words):
        status, out, error = shell(*words)
        assert status == 0, error
        return out

    return run


def table(file):
    """The columns of a written table, by title."""
    return np.atleast_1d(np.genfromtxt(file, delimiter=",", names=True, deletechars="", replace_space=" "))


def write_columns(file, **columns):
    """A CSV file with columns by titles, whose units follow the last underscore."""
    titles = [f"{name.rpartition('_')[0].replace('_', ' ')} [{name.rpartition('_')[2]}]" for name in columns]
    rows = zip(*columns.values(), strict=True)
    file.write_text(
        "\n".join([",".join(titles), *(",".join(map(repr, map(float, row))) for row in rows)]) + "\n"
    )


def test_a_table_of_hertz_for_students(tmp_path, job):
    case = tmp_path / "hertz.toml"
    case.write_text(
        f'[profile]\nkind = "paraboloid"\nradius = "10 mm"\n[body]\n{STEEL}[counterbody]\n{STEEL}'
        '[[path]]\nkind = "load"\nnormal_force = "50 N"\nsteps = 5\n'
    )
    job("run", case, "--csv", "--no-figures", "-o", tmp_path / "out")
    result = table(tmp_path / "out" / "result.csv")
    force = np.linspace(10.0, 50.0, 5)
    radius = (3.0 * force * 0.01 / (4.0 * MODULUS)) ** (1.0 / 3.0)
    assert result["normal_force [N]"] == pytest.approx(force, rel=1e-12)
    assert result["contact_radius [m]"] == pytest.approx(radius, rel=1e-12)
    assert result["indentation [m]"] == pytest.approx(radius**2 / 0.01, rel=1e-12)
    assert result["peak_pressure [Pa]"] == pytest.approx(1.5 * force / (math.pi * radius**2), rel=1e-9)


@pytest.mark.parametrize("seed", range(2))
def test_a_fretting_record_with_a_preload(tmp_path, job, seed):
    """Energy, stick radius and largest traction by Cattaneo and Mindlin, from the columns of a rig with a clock of its own."""
    rng = np.random.default_rng(seed)
    load, amplitude = rng.uniform(20.0, 80.0), rng.uniform(0.1e-6, 0.4e-6)
    t = np.linspace(0.0, 3.0, 1201)
    shift = amplitude * np.sin(2.0 * math.pi * t)
    write_columns(tmp_path / "rig.csv", time_s=t + rng.uniform(0.0, 100.0), displacement_um=1e6 * shift)
    case = tmp_path / "joint.toml"
    case.write_text(
        f'[profile]\nkind = "paraboloid"\nradius = "10 mm"\n[body]\n{STEEL}[counterbody]\n{STEEL}'
        f'[friction]\nkind = "coulomb"\ncoefficient = 0.3\n[[path]]\nkind = "load"\nnormal_force = {load!r}\n'
        '[[path]]\nkind = "path"\nfile = "rig.csv"\nchannels = { shift = "displacement" }\n'
    )
    job("loops", case, "-o", tmp_path / "out")
    result = table(tmp_path / "out" / "loops.csv")
    radius = (3.0 * load * 0.01 / (4.0 * MODULUS)) ** (1.0 / 3.0)
    shear = 2.0 * 210e9 / 2.6 / (2.0 - 0.3)
    full_slip = 0.3 * MODULUS / shear * radius**2 / 0.01
    assert full_slip > amplitude
    rest = 1.0 - amplitude / full_slip
    force = 0.3 * load * (1.0 - rest**1.5)
    # the area of a loop of Masing's: eight times that below the first loading, less four triangles
    loss = 8.0 * 0.3 * load * (amplitude - 0.4 * full_slip * (1.0 - rest**2.5)) - 4.0 * force * amplitude
    assert result["force_amplitude [N]"] == pytest.approx(np.full(2, force), rel=1e-4)
    assert result["dissipated_per_cycle [J]"] == pytest.approx(np.full(2, loss), rel=2e-3)
    assert result["stick_radius [m]"] == pytest.approx(np.full(2, radius * math.sqrt(rest)), rel=1e-6)
    assert result["contact_radius [m]"] == pytest.approx(np.full(2, radius), rel=1e-12)
    peak = 0.3 * 1.5 * load / (math.pi * radius**2) * math.sqrt(1.0 - rest)
    assert result["peak_shear_traction [Pa]"] == pytest.approx(np.full(2, peak), rel=1e-3)


def test_a_frequency_sweep_to_friction_and_rebound(tmp_path, job):
    """The friction and the rebound of the rubber whose moduli were written as a sweep, within the fit of its series."""
    equilibrium, branch, time = 1e6, 3e6, 1e-3
    frequency = np.geomspace(1e-1, 1e5, 25)
    moved = 1j * 2.0 * math.pi * frequency * time
    modulus = (equilibrium + branch * moved / (1.0 + moved)) / 1e6
    (tmp_path / "dma.csv").write_text(
        "frequency [Hz],G' [MPa],G'' [MPa]\n"
        + "".join(
            f"{f!r},{g.real!r},{g.imag!r}\n"
            for f, g in zip(frequency.tolist(), modulus.tolist(), strict=True)
        )
    )
    case = tmp_path / "rubber.toml"
    case.write_text(
        '[profile]\nkind = "paraboloid"\nradius = "10 mm"\n[body]\nkind = "viscoelastic"\npoisson = 0.5\n'
        'shear = { kind = "prony", file = "dma.csv" }\n'
    )
    speeds = ("--speed", "0.01 m/s, 10 m/s", "--points", "4")
    job("sliding", case, *speeds, "--normal-force", "1 N", "-o", tmp_path / "out")
    job("impact", case, "--mass", "10 g", "--speed", "0.1 m/s, 1 m/s", "-o", tmp_path / "out")
    slid, thrown = table(tmp_path / "out" / "sliding.csv"), table(tmp_path / "out" / "impact.csv")
    rubber = mdr.Viscoelastic(mdr.StandardSolid(equilibrium, branch, time), poisson=0.5)
    contact = mdr.Contact(mdr.Paraboloid("10 mm"), rubber)
    friction = mdr.sliding_friction(contact, np.geomspace(0.01, 10.0, 4), normal_force="1 N")
    rebound = mdr.restitution(contact, mass="10 g", speeds=[0.1, 1.0])
    assert slid["friction_force [N]"] == pytest.approx(friction["friction_force"].values, rel=0.02)
    assert thrown["restitution"] == pytest.approx(rebound["restitution"].values, rel=0.01)
    assert (tmp_path / "out" / "impact.png").exists()


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler (cc) on this machine")
def test_a_noisy_tip_to_a_law_in_c(tmp_path, shell, job):
    """Pull-off as of JKR on the round tip under the noise; the refusal names the line that makes it so."""
    rng = np.random.default_rng(3)
    radius, young, work = 100e-9, 1e9, 50e-3
    r = np.linspace(0.0, 150e-9, 151)
    noise = 0.3e-9 * rng.standard_normal(r.size)
    write_columns(tmp_path / "tip.csv", r_nm=1e9 * r, f_nm=1e9 * (r**2 / (2.0 * radius) + noise))
    text = (
        '[profile]\nkind = "sampled"\nfile = "tip.csv"\n'
        '[body]\nkind = "elastic"\nyoung = "1 GPa"\npoisson = 0.3\n[adhesion]\nkind = "jkr"\nwork = "50 mJ/m^2"\n'
    )
    case = tmp_path / "tip.toml"
    case.write_text(text)
    status, _, error = shell("law", case, "--to", "10 nm", "-o", tmp_path / "law")
    assert status in (1, 3)
    remedy = "interpolation = { kind = 'smoothing_spline' }"
    assert remedy in error
    case.write_text(text.replace("[body]", f"{remedy}\n[body]".replace("'", '"')))
    job("law", case, "--to", "10 nm", "-o", tmp_path / "law")
    (tmp_path / "law" / "main.c").write_text(
        '#include <stdio.h>\n#include "tip.h"\nint main(void) { printf("[%.17g, %.17g, %.17g]", TIP_LARGEST_PULL, '
        "tip_force(5e-9), TIP_ERROR_OF_FORCE); return 0; }\n"
    )
    program = tmp_path / "law" / "main"
    subprocess.run(["cc", program.with_suffix(".c"), "-o", program, "-lm"], check=True)
    pull, force, error = json.loads(subprocess.run([program], check=True, capture_output=True).stdout)
    assert pull == pytest.approx(1.5 * math.pi * work * radius, rel=0.03)
    smooth = mdr.read_profile(tmp_path / "tip.csv", interpolation=mdr.SmoothingSpline())
    contact = mdr.Contact(smooth, mdr.Elastic(young, 0.3), adhesion=mdr.JKR(work))
    path = mdr.indent("10 nm") >> mdr.indent("5 nm")
    assert force == pytest.approx(float(mdr.solve(contact, path)["normal_force"][-1]), rel=2.0 * error + 1e-9)


@pytest.mark.skipif(
    importlib.util.find_spec("ContactMechanics") is None,
    reason="ContactMechanics, of the extra rough, is missing",
)
def test_a_measured_surface_to_its_resistance(tmp_path, job):
    """A summit that is a ball has the resistance of Holm's disk, within the stated error."""
    side, curvature = 1e-3, 1.0
    x = ((np.arange(128) + 0.5) / 128.0 - 0.5) * side
    heights = -1e9 * (x[:, None] ** 2 + x**2) / (2.0 * curvature)
    np.savetxt(tmp_path / "heights.txt", heights)
    case = tmp_path / "contact.toml"
    silver = 'kind = "elastic"\nyoung = "83 GPa"\npoisson = 0.37\nresistivity = "15.9 nohm*m"\n'
    case.write_text(
        f'[surface]\nfile = "heights.txt"\nsize = "1 mm"\nunit = "nm"\n[body]\n{silver}[counterbody]\n{silver}'
    )
    job("press", case, "--indentation", "20 nm, 40 nm", "-o", tmp_path / "out", "-q")
    result = table(tmp_path / "out" / "press.csv")
    modulus = 83e9 / (2.0 * (1.0 - 0.37**2))
    radius = (3.0 * result["normal_force [N]"] * curvature / (4.0 * modulus)) ** (1.0 / 3.0)
    resistance = 15.9e-9 / (2.0 * radius)
    error = np.abs(result["electrical_resistance [ohm]"] / resistance - 1.0)
    assert np.all(error < result["electrical_resistance_error"])
    assert np.all(result["electrical_resistance_error"] < 0.1)


GLASS = 'kind = "elastic"\nyoung = "70 GPa"\npoisson = 0.22\n'
STIFF_GLASS = GLASS.replace("poisson = 0.22", "poisson = 0.0")
PLANE_STRAIN = 70e9 / (1.0 - 0.22**2)
"""E* of glass against a rigid body, in Pa."""


def test_a_coated_glass_under_a_steel_ball(tmp_path, job):
    """One command from a case to the stress below the coat: that of Huber where coat and glass are alike, and bonded to it where not."""
    case = tmp_path / "coat.toml"

    def stresses(young):
        case.write_text(
            '[profile]\nkind = "paraboloid"\nradius = "10 mm"\n[body]\nkind = "layered"\n'
            "base = { kind = 'elastic', young = '70 GPa', poisson = 0.22 }\n[[body.layers]]\nthickness = '20 um'\n"
            f"material = {{ kind = 'elastic', young = '{young}', poisson = 0.22 }}\n[counterbody]\n{STEEL}"
            '[[path]]\nkind = "load"\nnormal_force = "50 N"\n'
            '[stress]\nside = "body"\nr = ["0 um"]\nz = ["20 um", "20 um"]\n'
        )
        job("run", case, "--csv", "--no-figures", "-o", tmp_path / "out")
        coat, base = table(tmp_path / "out" / "stress.csv")
        depth = float(table(tmp_path / "out" / "result.csv")["indentation [m]"][0])
        return depth, coat, base

    def hertz(modulus):
        radius = (0.75 * 50.0 * 0.01 / modulus) ** (1.0 / 3.0)
        return radius, radius**2 / 0.01

    steel = 210e9 / (1.0 - 0.3**2)
    modulus = 1.0 / (1.0 / PLANE_STRAIN + 1.0 / steel)
    radius, indentation = hertz(modulus)
    depth, _, below = stresses("70 GPa")
    assert depth == pytest.approx(indentation, rel=1e-6)
    ratio, peak = 20e-6 / radius, 75.0 / (math.pi * radius**2)
    along = -peak / (1.0 + ratio**2)
    across = peak * (0.5 / (1.0 + ratio**2) - 1.22 * (1.0 - ratio * math.atan(1.0 / ratio)))
    assert below["stress_zz [Pa]"] == pytest.approx(along, rel=1e-6)
    assert below["von_mises [Pa]"] == pytest.approx(across - along, rel=1e-6)

    coated_depth, coat, base = stresses("200 GPa")
    stiffer = 1.0 / (1.0 / (200.0 / 70.0 * PLANE_STRAIN) + 1.0 / steel)
    assert hertz(stiffer)[1] < coated_depth < indentation
    strains = [
        (0.78 * s["stress_rr [Pa]"] - 0.22 * s["stress_zz [Pa]"]) / young
        for s, young in ((coat, 200e9), (base, 70e9))
    ]
    assert strains[0] == pytest.approx(strains[1], rel=1e-8)
    assert coat["stress_zz [Pa]"] == pytest.approx(base["stress_zz [Pa]"], rel=1e-8)
    assert base["von_mises [Pa]"] > below["von_mises [Pa]"]


PUNCH_STIFFNESS = 2.0 * PLANE_STRAIN * 1e-3
"""Of a rigid flat punch of 1 mm on glass, in N/m."""

WAVE_SPEED = 2e3 * math.pi * PUNCH_STIFFNESS * 1e-8 / ((2e3 * math.pi) ** 2 - PUNCH_STIFFNESS)
"""Of 1 kg in steady motion in the middle of a wave of 10 nm and 1 kHz that such a punch follows, in m/s."""


def maugis_radius(force, radius, modulus, work, strength):
    """Contact radius of the elastic paraboloid under a stable load, in m: Maugis (1992), eqs. (6.15) and (6.16)."""
    stiffness = 4.0 / 3.0 * modulus
    unit = (math.pi * work * radius**2 / stiffness) ** (1.0 / 3.0)
    zone = 2.0 * strength / (math.pi * work * stiffness**2 / radius) ** (1.0 / 3.0)

    def unbalanced(unknowns):
        a, m = unknowns
        root, angle = math.sqrt(m * m - 1.0), math.acos(1.0 / m)
        return (
            0.5 * zone * a * a * (root + (m * m - 2.0) * angle)
            + 4.0 / 3.0 * zone**2 * a * (root * angle - m + 1.0)
            - 1.0,
            a**3 - zone * a * a * (root + m * m * angle) - force / (math.pi * work * radius),
        )

    return unit * float(fsolve(unbalanced, (2.0, 1.5), xtol=1e-13)[0])


CHAPTERS = {
    "3, cone": (
        f'[profile]\nkind = "cone"\nslope = 0.1\n[body]\n{GLASS}[[path]]\nkind = "indent"\nindentation = "1 um"\n',
        "run --csv --no-figures",
        "result.csv",
        {
            "contact_radius [m]": 2e-6 / (math.pi * 0.1),
            "normal_force [N]": 2.0 * PLANE_STRAIN * 1e-12 / (math.pi * 0.1),
        },
        1e-12,
    ),
    "4, force of pull-off": (
        f'[profile]\nkind = "paraboloid"\nradius = "1 um"\n[body]\n{GLASS}[adhesion]\nkind = "jkr"\nwork = "50 mJ/m^2"\n'
        '[[path]]\nkind = "load"\nnormal_force = 0.0\n',
        "run --csv --no-figures",
        "result.csv",
        {"contact_radius [m]": (4.5 * math.pi * 0.05 * 1e-12 / PLANE_STRAIN) ** (1.0 / 3.0)},
        1e-9,
    ),
    "5, stick radius of Cattaneo": (
        f'[profile]\nkind = "paraboloid"\nradius = "10 mm"\n[body]\n{STIFF_GLASS}[counterbody]\n{STIFF_GLASS}'
        '[friction]\nkind = "coulomb"\ncoefficient = 0.4\n[[path]]\nkind = "load"\nnormal_force = 50.0\n'
        '[[path]]\nkind = "drag"\ntangential_force = 10.0\n',
        "run --csv --no-figures",
        "result.csv",
        {"stick_radius [m]": (0.75 * 50.0 * 0.01 / 35e9) ** (1.0 / 3.0) * 0.5 ** (1.0 / 3.0)},
        1e-9,
    ),
    "6, rolling": (
        f'[profile]\nkind = "paraboloid"\nradius = "10 mm"\n[body]\n{STIFF_GLASS}[counterbody]\n{STIFF_GLASS}'
        '[friction]\nkind = "coulomb"\ncoefficient = 0.4\n',
        "rolling --creepage 1e-3 --normal-force '50 N'",
        "rolling.csv",
        # G* = 2 G / (2 - nu) / 2 = E* for nu = 0, so xi = zeta R / (2 a mu)
        {
            "creep_force [N]": 20.0
            * (1.0 - (1.0 - 1e-5 / (0.8 * (0.75 * 50.0 * 0.01 / 35e9) ** (1.0 / 3.0))) ** 3)
        },
        1e-9,
    ),
    "7, relaxing springs": (
        '[profile]\nkind = "flat_punch"\nradius = "1 mm"\n[body]\nkind = "viscoelastic"\npoisson = 0.5\n'
        'shear = { kind = "maxwell", modulus = "1 MPa", time = "2 s" }\n'
        '[[path]]\nkind = "indent"\nindentation = "10 um"\nduration = "3 s"\n',
        "run --csv --no-figures",
        "result.csv",
        # 8 a G v tau (1 - exp(-t/tau))
        {"normal_force [N]": 8e-3 * 1e6 * (1e-5 / 3.0) * 2.0 * (1.0 - math.exp(-1.5))},
        1e-6,
    ),
    "8, conductance": (
        f'[profile]\nkind = "flat_punch"\nradius = "1 mm"\n[body]\n{GLASS}thermal_conductivity = 3.0\n'
        f'[counterbody]\n{GLASS}thermal_conductivity = 6.0\n[[path]]\nkind = "load"\nnormal_force = 1.0\n',
        "run --csv --no-figures",
        "result.csv",
        # Holm's constriction on both sides, each 1/(4 a lambda)
        {"thermal_conductance [W/K]": 4e-3 / (1.0 / 3.0 + 1.0 / 6.0)},
        1e-12,
    ),
    "9, adhesion of a relaxed elastomer": (
        '[profile]\nkind = "paraboloid"\nradius = "1 mm"\n[body]\nkind = "viscoelastic"\npoisson = 0.5\n'
        'shear = { kind = "standard_solid", equilibrium = "10 kPa", modulus = "90 kPa", time = "1 s" }\n'
        '[adhesion]\nkind = "maugis_dugdale"\nwork = "50 mJ/m^2"\nstrength = "1 kPa"\n'
        '[[path]]\nkind = "load"\nnormal_force = "50 uN"\nduration = "1 s"\nsteps = 5\n'
        '[[path]]\nkind = "hold"\nduration = "1000 s"\nsteps = 10\n',
        "run --csv --no-figures",
        "result.csv",
        {"contact_radius [m]": maugis_radius(50e-6, 1e-3, 40e3, 50e-3, 1e3)},
        1e-3,
    ),
    "11, friction of an elastomer": (
        '[profile]\nkind = "paraboloid"\nradius = "10 mm"\n[body]\nkind = "viscoelastic"\npoisson = 0.5\n'
        'shear = { kind = "kelvin_voigt", modulus = "1 MPa", viscosity = "10 kPa*s" }\n',
        "sliding --speed '0.1 m/s' --indentation '0.1 mm'",
        "sliding.csv",
        {"trailing_edge [m]": 1e-3 - math.sqrt(1e-6 + 0.01 * 1e-4)},
        1e-9,
    ),
    "12, damping": (
        f'[profile]\nkind = "paraboloid"\nradius = "10 mm"\n[body]\n{STIFF_GLASS}[counterbody]\n{STIFF_GLASS}'
        '[friction]\nkind = "coulomb"\ncoefficient = 0.4\n[[path]]\nkind = "load"\nnormal_force = 50.0\n'
        '[[path]]\nkind = "cycle"\ntangential_force = 10.0\ncycles = 2\nsteps = 4000\n',
        "loops",
        "loops.csv",
        # 36/5 of (mu F_N)^2 / k, k = 2 G* a, G* = E* for nu = 0, times 1 - y^(5/3) - 5/6 x (1 + y^(2/3)), x = 1 - y = 1/2
        {
            "dissipated_per_cycle [J]": 7.2
            * 400.0
            / (2.0 * 35e9 * (0.75 * 50.0 * 0.01 / 35e9) ** (1.0 / 3.0))
            * (1.0 - 0.5 ** (5.0 / 3.0) - 5.0 / 12.0 * (1.0 + 0.5 ** (2.0 / 3.0)))
        },
        1e-4,
    ),
    "13, impact": (
        f'[profile]\nkind = "paraboloid"\nradius = "10 mm"\n[body]\n{GLASS}',
        "impact --mass '10 g' --speed '0.1 m/s'",
        "impact.csv",
        {
            # 2 d_max / v times the integral of 1 / sqrt(1 - s^(5/2)), 1.4716
            "time [s]": 2.0
            * math.sqrt(math.pi)
            * math.gamma(1.4)
            / math.gamma(0.9)
            * (15.0 * 0.01 / (16.0 * PLANE_STRAIN * math.sqrt(0.01))) ** 0.4
            / 0.1**0.2
        },
        1e-6,
    ),
    "14, a body on a wavy track": (
        f'[profile]\nkind = "flat_punch"\nradius = "1 mm"\n[body]\n{GLASS}[machine]\nduration = "1.25 ms"\nsteps = 50\n'
        f'[[machine.bodies]]\nkind = "mass"\nname = "ball"\nmass = "1 kg"\nvelocity = {WAVE_SPEED!r}\n'
        '[[machine.bodies]]\nkind = "drive"\nname = "track"\namplitude = "10 nm"\nfrequency = "1 kHz"\n'
        '[[machine.links]]\nkind = "joint"\nnormal = { ball = 1, track = 1 }\nindentation = "1 um"\n'
        f'[[machine.links]]\nkind = "force"\non = "ball"\nforce = {PUNCH_STIFFNESS * 1e-6!r}\n',
        "move",
        "move.csv",
        # at the crest of a wave the mean force plus k w m omega^2 / (m omega^2 - k)
        {
            "normal_force of contact [N]": PUNCH_STIFFNESS
            * (1e-6 + 1e-8 * (2e3 * math.pi) ** 2 / ((2e3 * math.pi) ** 2 - PUNCH_STIFFNESS))
        },
        1e-4,
    ),
    "17, power laws": (
        f'[profile]\nkind = "power_law"\nexponent = 4\nheight = "1 um"\nradius = "1 mm"\n[body]\n{GLASS}'
        '[[path]]\nkind = "indent"\nindentation = "1 um"\n',
        "run --csv --no-figures",
        "result.csv",
        # kappa_4 = 8/3, F = 2n/(n+1) E* d a
        {"normal_force [N]": 1.6 * PLANE_STRAIN * 1e-6 * 1e-3 * (3.0 / 8.0) ** 0.25},
        1e-12,
    ),
    "18, without slip": (
        f'[profile]\nkind = "flat_punch"\nradius = "1 mm"\n[body]\n{STIFF_GLASS}[counterbody]\n{STIFF_GLASS}'
        '[friction]\nkind = "coulomb"\ncoefficient = inf\n[[path]]\nkind = "load"\nnormal_force = 50.0\n'
        '[[path]]\nkind = "shift"\nshift = "1 um"\n',
        "run --csv --no-figures",
        "result.csv",
        {"tangential_force [N]": 2.0 * 35e9 * 1e-3 * 1e-6},
        1e-12,
    ),
}
"""A case, a command, its table, and last values by closed forms of the book, with their relative tolerance."""


@pytest.mark.parametrize("chapter", CHAPTERS)
def test_one_formula_of_each_chapter(tmp_path, job, chapter):
    case, command, file, expected, tolerance = CHAPTERS[chapter]
    (tmp_path / "case.toml").write_text(case)
    name, *options = shlex.split(command)
    job(name, tmp_path / "case.toml", *options, "-o", tmp_path / "out")
    computed = table(tmp_path / "out" / file)
    for column, value in expected.items():
        assert float(computed[column][-1]) == pytest.approx(value, rel=tolerance), column


def test_what_the_book_has_and_the_shell_refuses(tmp_path, shell):
    case = tmp_path / "case.toml"
    rubber = '[body]\nkind = "viscoelastic"\npoisson = 0.5\nshear = { kind = "maxwell", modulus = 1e6, time = 1.0 }\n'
    ball = '[profile]\nkind = "sphere"\nradius = "1 mm"\n'
    path = '[[path]]\nkind = "indent"\nindentation = "1 um"\nduration = "1 s"\n'
    case.write_text(f'{ball}{rubber}[adhesion]\nkind = "jkr"\nwork = "50 mJ/m^2"\n{path}')
    status, _, error = shell("check", case)
    assert status == 1
    assert "no limit of short range" in error  # chapter 9


def test_the_exponent_of_a_rough_contact(tmp_path, job):
    """Chapter 10: k ~ F^(1/(1+H)), by the springs of 100 random lines; the area is not in the table."""
    case = tmp_path / "case.toml"
    rough = '[surface]\nhurst = 0.8\nrms = "1 um"\nsize = "1 mm"\nshortest = "5 um"\n'
    case.write_text(f"{rough}[body]\n{STEEL}")
    job("rough", case, "--normal-force", "0.03 N, 1 N", "--points", "4", "-o", tmp_path / "out")
    result = table(tmp_path / "out" / "rough.csv")
    slopes = {
        name: np.polyfit(np.log(result["normal_force [N]"]), np.log(result[f"{name} [N/m]"]), 1)[0]
        for name in ("normal_stiffness", "power_law_stiffness")
    }
    assert slopes["power_law_stiffness"] == pytest.approx(1.0 / 1.8, rel=1e-9)
    assert slopes["normal_stiffness"] == pytest.approx(1.0 / 1.8, rel=0.05)
    assert not any("area" in name for name in result.dtype.names)


PLUGINS = Path(__file__).parent.parent / "docs" / "plugins.md"
FILE = re.compile(r"^:::\{code-block\} \w+\n:caption: (\S+)\n\n(.*?)^:::", re.MULTILINE | re.DOTALL)


@pytest.fixture
def own_files(tmp_path, monkeypatch, kinds):
    """The files of the page on kinds of one's own, in the working directory."""
    for name, body in FILE.findall(PLUGINS.read_text()):
        (tmp_path / name).write_text(body)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    sys.modules.pop("mine", None)
    yield tmp_path
    sys.modules.pop("mine", None)


def check_own_results(folder):
    """Those of the named profile, rheology and law that the file of one's own repeats."""
    rubber, gel = table(folder / "rubber" / "result.csv"), table(folder / "gel" / "result.csv")
    tip = mdr.PowerLaw(4, "1 um", "1 mm")
    solid = mdr.Viscoelastic(mdr.StandardSolid("1 MPa", "3 MPa", "0.5 s"), poisson=0.5)
    path = mdr.indent("1 um", duration="0.1 s", steps=20) >> mdr.hold("2 s", steps=20)
    expected = mdr.solve(mdr.Contact(tip, solid), path)
    assert rubber["normal_force [N]"] == pytest.approx(expected["normal_force"].values, rel=1e-12)
    work = 2.0 * math.sqrt(20e-3 * 70e-3)
    contact = mdr.Contact(tip, mdr.Elastic("30 kPa", 0.5), adhesion=mdr.JKR(work))
    radius = float(mdr.solve(contact, mdr.load("1 mN"))["contact_radius"][0])
    assert gel["contact_radius [m]"] == pytest.approx([radius], rel=1e-12)


def test_kinds_of_ones_own_from_a_file(own_files, job, shell):
    for case in ("rubber", "gel"):
        job("--plugin", "mine.py", "run", f"{case}.toml", "--csv", "--no-figures", "-o", case)
    check_own_results(own_files)


def test_kinds_of_ones_own_from_an_installed_package(own_files, job):
    distribution = own_files / "mine-1.0.dist-info"
    distribution.mkdir()
    (distribution / "METADATA").write_text("Metadata-Version: 2.1\nName: mine\nVersion: 1.0\n")
    (distribution / "entry_points.txt").write_text("[pymdr.plugins]\nmine = mine\n")
    sys.path.insert(0, str(own_files))
    for case in ("rubber", "gel"):
        job("run", f"{case}.toml", "--csv", "--no-figures", "-o", case)
    check_own_results(own_files)
    assert '"relaxing"' in job("schema")
