"""Tables of moduli in shear and in tension, and rows by which no linear body relaxes."""

import numpy as np
import pytest

import pymdr as mdr
from pymdr.workbench.casefile import read_case

LAW = mdr.StandardSolid("1 MPa", "3 MPa", "20 ms")
W, T = np.geomspace(0.1, 1e3, 41), np.geomspace(1e-3, 10.0, 41)


def table(file, head, *columns):
    rows = (
        ",".join(repr(value) for value in row) for row in zip(*(c.tolist() for c in columns), strict=True)
    )
    file.write_text("\n".join([head, *rows]), encoding="utf-8")
    return file


def columns(names, stiffer):
    storage, loss = LAW.storage(W) / 1e6, LAW.loss(W) / 1e6
    values = {"storage": stiffer * storage, "loss": stiffer * loss, "tan": loss / storage}
    return [W, *(values[name] for name in names.split())]


@pytest.mark.parametrize(
    ("head", "names", "young"),
    [
        ("omega [rad/s], G' [MPa], G'' [MPa]", "storage loss", False),
        ("omega [rad/s], E' [MPa], E'' [MPa]", "storage loss", True),
        ("omega [rad/s], E' (MPa), E'' (MPa)", "storage loss", True),
        ("omega [rad/s], E\u2032 [MPa], E\u2033 [MPa]", "storage loss", True),
        ("omega [rad/s],G' [MPa],G\" [MPa]", "storage loss", False),
        ("omega [rad/s], Shear storage modulus [MPa], Shear loss modulus [MPa]", "storage loss", False),
        ("omega [rad/s], Tensile storage modulus [MPa], tan delta", "storage tan", True),
        ("omega [rad/s], E'' [MPa], tan delta [-]", "loss tan", True),
        ("omega [rad/s], G' [MPa], tan delta [-], G'' [MPa]", "storage tan loss", False),
    ],
)
@pytest.mark.parametrize("poisson", [0.5, 0.2])
def test_sweeps_give_the_series_in_shear(tmp_path, head, names, young, poisson):
    stiffer = 2.0 * (1.0 + poisson) if young else 1.0
    file = table(tmp_path / "dma.csv", head, *columns(names, stiffer))
    series = mdr.fit_prony(file, poisson=poisson).series
    assert series.equilibrium == pytest.approx(1e6, rel=1e-9)
    assert series.moduli == pytest.approx([3e6], rel=1e-9)
    if young:
        with pytest.raises(mdr.ProblemError, match="give poisson"):
            mdr.fit_prony(file)
        with pytest.raises(mdr.ProblemError, match=r"poisson = 0\.7"):
            mdr.fit_prony(file, poisson=0.7)


def test_relaxation_in_tension(tmp_path):
    young = 3.0 * LAW.relaxation(T)
    file = table(tmp_path / "e.csv", "time [s], E [Pa]", T, young)
    for data in (file, {"time": T, "young": young}):
        assert mdr.fit_prony(data, poisson=0.5).series.equilibrium == pytest.approx(1e6, rel=1e-9)
    both = {"omega": W, "young_storage": 3.0 * LAW.storage(W), "young_loss": 3.0 * LAW.loss(W)}
    assert mdr.fit_prony(both, poisson=0.5).series.times == pytest.approx([0.02], rel=1e-9)


@pytest.mark.parametrize(
    "head",
    [
        "frequency [Hz], storage modulus [MPa], loss modulus [MPa]",
        "frequency [Hz], storage [MPa], loss [MPa]",
        "time [s], modulus [MPa]",
    ],
)
def test_a_table_must_say_which_modulus_it_has(tmp_path, head):
    file = table(tmp_path / "dma.csv", head, *columns("storage loss", 3.0)[: head.count(",") + 1])
    with pytest.raises(mdr.CaseError, match=r"does not say whether .* Young's modulus; name the columns G"):
        mdr.fit_prony(file, poisson=0.5)


def test_a_body_of_a_rheology_in_tension():
    for law in (LAW, mdr.Prony(1e6, [2e6], [1.0]), mdr.PowerLawRheology("1 kPa", "1 s", 0.3)):
        body, same = mdr.Viscoelastic(young=law.scaled(2.4), poisson=0.2), mdr.Viscoelastic(law, poisson=0.2)
        assert body.shear.relaxation(T) == pytest.approx(same.shear.relaxation(T), rel=1e-14)
    for wrong, match in (
        ({"shear": LAW, "young": LAW, "poisson": 0.5}, "both shear and young"),
        ({"young": LAW, "bulk": "1 GPa"}, "young needs poisson"),
        ({"young": 3.0, "poisson": 0.5}, "a rheology such as"),
        ({"poisson": 0.5}, "a rheology such as"),
    ):
        with pytest.raises(mdr.ProblemError, match=match):
            mdr.Viscoelastic(**wrong)


CASE = """
[profile]
kind = "sphere"
radius = "1 mm"

[body]
kind = "viscoelastic"
poisson = 0.5
{}

[[path]]
kind = "indent"
indentation = "1 um"
duration = 1
"""


@pytest.mark.parametrize(
    "law",
    [
        'young = { kind = "prony", file = "dma.csv" }',
        'shear = { kind = "prony", file = "dma.csv" }',
        'young = { kind = "standard_solid", equilibrium = "3 MPa", modulus = "9 MPa", time = "20 ms" }',
    ],
)
def test_cases_in_tension(tmp_path, law):
    table(tmp_path / "dma.csv", "omega [rad/s], E' [MPa], E'' [MPa]", *columns("storage loss", 3.0))
    case = tmp_path / "case.toml"
    case.write_text(CASE.format(law))
    assert read_case(case).contact.body.shear.equilibrium == pytest.approx(1e6, rel=1e-9)
    case.write_text(CASE.format(law + '\nshear = "1 MPa"' if "young" in law else law + "\nyoung = 3"))
    with pytest.raises(mdr.CaseError, match="both shear and young"):
        read_case(case)


@pytest.mark.parametrize("seed", range(6))
def test_moduli_that_grow_with_time_are_refused(seed):
    rng = np.random.default_rng(seed)
    noise = 1.0 + 10.0 ** rng.uniform(-4, -2) * rng.standard_normal(T.size)
    rise = T ** rng.uniform(0.05, 0.5) * 10.0 ** rng.uniform(2, 9) * noise
    for terms in (None, 2):
        with pytest.raises(
            mdr.ProblemError,
            match=r"G grows with time, from .* which is impossible for a linear body: leave out",
        ):
            mdr.fit_prony({"time": T, "modulus": rise}, terms=terms)
    with pytest.raises(mdr.ProblemError, match="G' grows with falling frequency"):
        mdr.fit_prony({"omega": T, "storage": 1e6 * rise[::-1], "loss": 1e5 * rise[::-1]})


def test_degenerate_rows():
    noise = 1.0 + 0.02 * np.random.default_rng(0).standard_normal(T.size)
    for modulus in (np.full(T.size, 1e5), 1e5 * noise):
        result = mdr.fit_prony({"time": T, "modulus": modulus}).series
        assert (result.times.size, result.equilibrium) == (0, pytest.approx(1e5, rel=0.01))
    elastic = {"omega": T, "storage": np.full(T.size, 1e5), "loss": np.zeros(T.size)}
    assert mdr.fit_prony(elastic).series.equilibrium == pytest.approx(1e5)
    with pytest.raises(mdr.ProblemError, match=r"no term fits, .* misfit of 33 %"):
        mdr.fit_prony(elastic | {"storage": T**0.2})
    with pytest.raises(mdr.ProblemError, match="it must be at least 0 Pa"):
        mdr.fit_prony(elastic | {"loss": np.full(T.size, -1.0)})
    with pytest.raises(mdr.ProblemError, match="1 rows; at least 5 are needed"):
        mdr.fit_prony({"time": [1.0], "modulus": [1.0]})
