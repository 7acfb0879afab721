"""Whole jobs from files through the shell, in three commands or fewer, against closed forms and what made the data."""

import importlib.util
import json
import math
import shutil
import subprocess

import numpy as np
import pytest

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
    found = table(tmp_path / "out" / "result.csv")
    force = np.linspace(10.0, 50.0, 5)
    radius = (3.0 * force * 0.01 / (4.0 * MODULUS)) ** (1.0 / 3.0)
    assert found["normal_force [N]"] == pytest.approx(force, rel=1e-12)
    assert found["contact_radius [m]"] == pytest.approx(radius, rel=1e-12)
    assert found["indentation [m]"] == pytest.approx(radius**2 / 0.01, rel=1e-12)
    assert found["peak_pressure [Pa]"] == pytest.approx(1.5 * force / (math.pi * radius**2), rel=1e-9)


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
    found = table(tmp_path / "out" / "loops.csv")
    radius = (3.0 * load * 0.01 / (4.0 * MODULUS)) ** (1.0 / 3.0)
    shear = 2.0 * 210e9 / 2.6 / (2.0 - 0.3)
    full_slip = 0.3 * MODULUS / shear * radius**2 / 0.01
    assert full_slip > amplitude
    rest = 1.0 - amplitude / full_slip
    force = 0.3 * load * (1.0 - rest**1.5)
    # the area of a loop of Masing's: eight times that below the first loading, less four triangles
    loss = 8.0 * 0.3 * load * (amplitude - 0.4 * full_slip * (1.0 - rest**2.5)) - 4.0 * force * amplitude
    assert found["force_amplitude [N]"] == pytest.approx(np.full(2, force), rel=1e-4)
    assert found["dissipated_per_cycle [J]"] == pytest.approx(np.full(2, loss), rel=2e-3)
    assert found["stick_radius [m]"] == pytest.approx(np.full(2, radius * math.sqrt(rest)), rel=1e-6)
    assert found["contact_radius [m]"] == pytest.approx(np.full(2, radius), rel=1e-12)
    peak = 0.3 * 1.5 * load / (math.pi * radius**2) * math.sqrt(1.0 - rest)
    assert found["peak_shear_traction [Pa]"] == pytest.approx(np.full(2, peak), rel=1e-3)


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
    found = table(tmp_path / "out" / "press.csv")
    modulus = 83e9 / (2.0 * (1.0 - 0.37**2))
    radius = (3.0 * found["normal_force [N]"] * curvature / (4.0 * modulus)) ** (1.0 / 3.0)
    resistance = 15.9e-9 / (2.0 * radius)
    error = np.abs(found["electrical_resistance [ohm]"] / resistance - 1.0)
    assert np.all(error < found["electrical_resistance_error"])
    assert np.all(found["electrical_resistance_error"] < 0.1)
