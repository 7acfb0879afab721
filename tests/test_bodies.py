"""Bodies as values: what they refuse, what contacts refuse of them, files, solving, claims."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import pymdr as mdr
from common import STEEL
from drawing import examples
from pymdr.independent.sliding.surface import make_surface
from pymdr.mapping.moduli import surface_compliances
from pymdr.problem.codec import case_schema, decode_case, encode, encode_case, tables

BALL = mdr.Sphere("10 mm")
ZINC = mdr.TransverselyIsotropic(c11="161 GPa", c33="61 GPa", c13="50.1 GPa", c44="38.3 GPa", c66="63.4 GPa")
FIBRES = {
    "young_plane": 10e9,
    "young_axis": 30e9,
    "poisson_plane": 0.3,
    "poisson_axis": 0.2,
    "shear_axis": 5e9,
}
SOIL = mdr.Graded("10 MPa", depth="1 m", exponent=0.5, poisson=0.3)
CARRIED = ("thermal_conductivity", "resistivity", "thermal_diffusivity")
STIFFNESSES = {"c11": 3.0, "c33": 3.0, "c13": 1.0, "c44": 1.0, "c66": 1.0}


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (
            {},
            "no constants are given; give the stiffnesses c11, c33, c13, c44, c66, or the engineering constants",
        ),
        ({"c11": 1.0, "young_axis": 1.0}, "c11 and young_axis belong to different sets"),
        ({**STIFFNESSES, "c66": None}, "c66 is missing"),
        ({"c44": 1.0, "c66": 1.0}, "c11 and c33 and c13 are missing"),
        ({**FIBRES, "poisson_axis": None}, "poisson_axis is missing"),
        ({**STIFFNESSES, "c44": 0.0}, r"c44 = 0\.0: it must be above 0 Pa"),
        ({**STIFFNESSES, "c66": -1.0}, r"c66 = -1\.0: it must be above 0 Pa"),
        ({**STIFFNESSES, "c66": 3.0}, r"c11 = 3 Pa must exceed c66 = 3 Pa"),
        ({**STIFFNESSES, "c13": -2.5}, r"\(c11 - c66\) c33 = 6 Pa\^2 must exceed c13\^2 = 6\.25 Pa\^2"),
        ({**STIFFNESSES, "c13": math.nan}, "c13: nan is not finite"),
        ({**STIFFNESSES, "c13": "50 GN"}, "c13: 'GN' does not fit"),
        ({**FIBRES, "poisson_plane": 1.0}, "poisson_plane = 1.0: it must be above -1 and below 1"),
        (
            {**FIBRES, "poisson_axis": 1.1},
            r"poisson_axis\^2 = 1\.21 must be at most .* young_axis / \(2 young_plane\) = 1\.05",
        ),
        ({**FIBRES, "shear_axis": math.inf}, "shear_axis: inf is not finite"),
    ],
)
def test_bad_transversely_isotropic_bodies(given, words):
    with pytest.raises(ValueError, match=rf"^(the stiffnesses are not positive definite: )?{words}"):
        mdr.TransverselyIsotropic(**given)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"young": 0.0}, "young = 0.0: it must be above 0 Pa"),
        ({"young": "1 m"}, "young: 'm' does not fit"),
        ({"depth": -1.0}, "depth = -1.0: it must be above 0 m"),
        ({"exponent": 1.0}, "exponent = 1.0: it must be above -1 and below 1"),
        ({"exponent": -1.0}, "exponent = -1.0: it must be above -1 and below 1"),
        ({"exponent": math.nan}, "exponent: nan is not finite"),
        ({"poisson": 0.51}, "poisson = 0.51: it must be above -1 and at most 0.5"),
        ({"poisson": None}, "poisson: None is not a quantity"),
    ],
)
def test_bad_graded_bodies(changed, words):
    with pytest.raises(ValueError, match=f"^{words}"):
        mdr.Graded(**{"young": 1.0, "depth": 1.0, "exponent": 0.2, "poisson": 0.3, **changed})


def definiteness(matrix):
    values = np.linalg.eigvalsh(matrix)
    return values[0] / values[-1]


SIZE = st.floats(0.01, 10.0)


@settings(max_examples=examples(300), deadline=None)
@given(SIZE, SIZE, st.floats(-10.0, 10.0), SIZE, SIZE, st.floats(1e-6, 1e12))
def test_unstable_stiffnesses_are_named(c11, c33, c13, c44, c66, unit):
    c12 = c11 - 2 * c66
    strains = np.array([[c11, c12, c13], [c12, c11, c13], [c13, c13, c33]])
    margin = definiteness(strains)
    assume(abs(margin) > 1e-9)
    values = {"c11": c11, "c33": c33, "c13": c13, "c44": c44, "c66": c66}
    scaled = {name: value * unit for name, value in values.items()}
    if margin > 0:
        assert mdr.effective_moduli(mdr.TransverselyIsotropic(**scaled)).normal > 0
    else:
        with pytest.raises(mdr.ProblemError, match=r"not positive definite.*must exceed c(66|13\^2)"):
            mdr.TransverselyIsotropic(**scaled)


@settings(max_examples=examples(300), deadline=None)
@given(SIZE, SIZE, st.floats(-0.99, 0.99), st.floats(-3.0, 3.0), SIZE)
def test_unstable_engineering_constants_are_named(
    young_plane, young_axis, poisson_plane, poisson_axis, shear
):
    s11, s33, s13 = 1 / young_plane, 1 / young_axis, -poisson_axis / young_axis
    s12 = -poisson_plane / young_plane
    margin = definiteness(np.array([[s11, s12, s13], [s12, s11, s13], [s13, s13, s33]]))
    assume(abs(margin) > 1e-9)
    values = {
        "young_plane": young_plane,
        "young_axis": young_axis,
        "poisson_plane": poisson_plane,
        "poisson_axis": poisson_axis,
        "shear_axis": shear,
    }
    if margin > 0:
        assert mdr.effective_moduli(mdr.TransverselyIsotropic(**values)).normal > 0
    else:
        with pytest.raises(mdr.ProblemError, match=r"not positive definite: poisson_axis\^2"):
            mdr.TransverselyIsotropic(**values)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"friction": mdr.Coulomb(0.3)}, r"friction of a graded body \(exponent 0\.5\)"),
        ({"adhesion": mdr.MaugisDugdale("1 mJ/m^2", range="1 nm")}, "use JKR for soft and large bodies"),
        ({"counterbody": STEEL}, r"exponents, 0\.5 and 0 \(0 is homogeneous\)"),
        ({"counterbody": ZINC}, r"exponents, 0\.5 and 0 \(0 is homogeneous\)"),
        ({"counterbody": mdr.Graded("1 MPa", "1 m", 0.4, 0.3)}, r"exponents, 0\.5 and 0\.4"),
    ],
)
def test_what_contacts_refuse_of_graded_bodies(more, words):
    with pytest.raises(mdr.ProblemError, match=words):
        mdr.Contact(BALL, SOIL, **more)


def test_what_contacts_take_of_graded_bodies():
    homogeneous = mdr.Graded("10 MPa", depth="1 m", exponent=0.0, poisson=0.3)
    for other in (STEEL, ZINC, mdr.Rigid(), homogeneous):
        for friction, adhesion in ((mdr.Coulomb(0.3), None), (None, mdr.MaugisDugdale(0.05, range="1 nm"))):
            mdr.Contact(BALL, homogeneous, other, friction=friction, adhesion=adhesion)
    for adhesion in (None, mdr.JKR(0.05), mdr.DMT(0.05)):
        mdr.Contact(BALL, SOIL, mdr.Graded("1 MPa", "1 mm", 0.5, 0.1), adhesion=adhesion)
        mdr.Contact(BALL, mdr.Rigid(), SOIL, adhesion=adhesion)


# --- files -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "body", [ZINC, mdr.TransverselyIsotropic(**FIBRES), SOIL], ids=["zinc", "fibres", "soil"]
)
def test_cases_go_there_and_back(body):
    contact = mdr.Contact(BALL, body)
    assert decode_case(encode_case("", contact, mdr.indent("1 um")))[1] == contact
    assert None not in encode(body).values()
    assert {body, body} == {body}


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ({"kind": "transversely_isotropc"}, "did you mean 'transversely_isotropic'"),
        ({"kind": "transversely_isotropic", "c11": "1 GPa"}, r"\[body\] c33 and"),
        ({"kind": "transversely_isotropic", "young": 1.0}, "young = 1.0: unknown key; did you mean 'young_"),
        (
            {"kind": "graded", "young": "1 MPa", "depth": 1.0, "exponent": 0.2},
            r"\[body\] key 'poisson' is missing",
        ),
        (
            {"kind": "graded", "young": "1 MPa", "depth": 1.0, "exponent": 2, "poisson": 0.3},
            r"\[body\] exponent = 2: it must be above -1 and below 1",
        ),
    ],
)
def test_bad_cases(body, words):
    case = {"profile": {"kind": "sphere", "radius": "1 mm"}, "body": body}
    with pytest.raises(mdr.CaseError, match=words):
        decode_case({**case, "path": [{"kind": "indent", "indentation": "1 um"}]})


def test_the_schema_knows_them():
    tables = case_schema()["$defs"]
    assert set(tables["transversely_isotropic"]["properties"]) == {"kind", *STIFFNESSES, *FIBRES, *CARRIED}
    assert tables["graded"]["required"] == ["kind", "young", "depth", "exponent", "poisson"]


def test_a_case_file_is_run(tmp_path, shell):
    case = tmp_path / "zinc.toml"
    case.write_text(
        '[profile]\nkind = "paraboloid"\nradius = "1 mm"\n\n[body]\nkind = "transversely_isotropic"\n'
        'c11 = "161 GPa"\nc33 = "61 GPa"\nc13 = "50.1 GPa"\nc44 = "38.3 GPa"\nc66 = "63.4 GPa"\n\n'
        '[[path]]\nkind = "load"\nnormal_force = "1 N"\n'
    )
    status, out, _ = shell("run", case, "-o", tmp_path / "out", "--quiet")
    assert status == 0, out
    result = mdr.open_result(tmp_path / "out/result.nc")
    assert result.contact.body == ZINC
    radius = (0.75 * 1e-3 / mdr.effective_moduli(ZINC).normal) ** (1 / 3)
    assert float(result["contact_radius"][0]) == pytest.approx(radius, rel=1e-12)


# --- contacts --------------------------------------------------------------------------------------------


def test_hertz_on_zinc():
    contact = mdr.Contact(mdr.Paraboloid("10 mm"), ZINC)
    result = mdr.solve(contact, mdr.indent("1 um"))
    assert float(result["normal_force"][0]) == pytest.approx(
        4 / 3 * 67799650579.961365 * math.sqrt(1e-2) * 1e-6**1.5, rel=1e-12
    )
    assert result.claims["normal_force"].level is mdr.Level.EXACT


def test_pull_off_from_a_transversely_isotropic_body_does_not_know_its_modulus():
    contact = mdr.Contact(mdr.Paraboloid("1 mm"), ZINC, adhesion=mdr.JKR("50 mJ/m^2"))
    force = mdr.pull_off(contact, machine_stiffness=0.0).normal_force
    assert force == pytest.approx(-1.5 * math.pi * 50e-3 * 1e-3, rel=1e-10)


def sliding_claims(body, counterbody, friction=0.3):
    contact = mdr.Contact(mdr.Paraboloid("10 mm"), body, counterbody, friction=mdr.Coulomb(friction))
    result = mdr.solve(contact, mdr.indent("1 um") >> mdr.shift("0.1 um"))
    return result.claims["tangential_force"], result.claims["normal_force"]


def straight(longitudinal_shear):
    """A body whose compliances along and across a wave of shear differ by a factor."""
    result = surface_compliances(mdr.TransverselyIsotropic(**{**STIFFNESSES, "c13": 0.5}))
    # c66 enters E_L too: solve 2 sqrt(c44 c66) = factor E_L for c66 by bisection
    low, high = 1e-3, 2.9
    for _ in range(200):
        c66 = (low + high) / 2
        body = mdr.TransverselyIsotropic(**{**STIFFNESSES, "c13": 0.5, "c66": c66})
        result = surface_compliances(body)
        low, high = (
            (c66, high) if result.longitudinal < result.transverse * longitudinal_shear else (low, c66)
        )
    return body


def test_sliding_is_exact_without_a_lateral_effect():
    body = straight(1.0)
    tangential, normal = sliding_claims(body, body)
    assert tangential.level is normal.level is mdr.Level.EXACT
    assert "S_L = S_T" in tangential.reason


def test_sliding_is_approximate_with_a_lateral_effect():
    tangential, normal = sliding_claims(ZINC, ZINC)
    assert (tangential.level, normal.level) == (mdr.Level.APPROXIMATE, mdr.Level.EXACT)
    one = surface_compliances(ZINC)
    assert f"1 - S_L/S_T = {1 - one.longitudinal / one.transverse:.6g}" in tangential.reason
    body = straight(0.3)
    assert "not for such transversely isotropic bodies: here 1 - S_L/S_T = 0.7" in (
        sliding_claims(body, body)[0].reason
    )


def test_sliding_on_bodies_that_are_not_similar():
    for claim in sliding_claims(ZINC, mdr.Rigid()):
        assert claim.level is mdr.Level.APPROXIMATE
        assert "Dundurs' beta" in claim.reason


def test_sliding_is_that_of_an_isotropic_body_of_the_same_tangential_compliances():
    # pressure enters Coulomb's limit alone, so that mu E* is all that is left of the normal compliance
    one = surface_compliances(ZINC)
    poisson = 1 - one.longitudinal / one.transverse
    like = mdr.Elastic((1 + poisson) / one.transverse, poisson)
    mu = 0.3 * one.longitudinal / one.normal
    path = (
        mdr.indent("1 um", steps=2)
        >> mdr.ramp(indentation="2 um", shift="0.3 um", steps=3)
        >> mdr.shift("0 um")
    )
    results = [
        mdr.verify(
            mdr.Contact(mdr.Paraboloid("10 mm"), body, body, friction=mdr.Coulomb(friction)),
            path,
            elements=12,
            steps=6,
        ).data
        for body, friction in ((ZINC, 0.3), (like, mu))
    ]
    for name in results[0].data_vars:
        if "tangential" in name:
            size = np.nanmax(np.abs(results[1][name].values))
            np.testing.assert_allclose(
                results[0][name].values, results[1][name].values, atol=1e-7 * size, err_msg=name
            )


def test_the_cells_of_isotropic_bodies_in_the_other_words():
    shear, nu = STEEL.shear, STEEL.poisson
    other = mdr.TransverselyIsotropic(
        young_plane=STEEL.young, young_axis=STEEL.young, poisson_plane=nu, poisson_axis=nu, shear_axis=shear
    )
    results, expected = (make_surface(1.0, 8, body, mdr.Rigid()) for body in (other, STEEL))
    for name in ("normal", "tangential"):
        one, two = getattr(results, name), getattr(expected, name)
        np.testing.assert_allclose(one, two, rtol=1e-10, atol=1e-14 * np.abs(two).max())
    with pytest.raises(mdr.ProblemError, match=r"graded \(exponent 0\.5\)"):
        make_surface(1.0, 8, SOIL, mdr.Rigid())


ISOTROPIC = {"c11": 1.5e9, "c33": 1.5e9, "c13": 0.5e9, "c44": 0.5e9, "c66": 0.5e9}
"""Of 1.25 GPa and 0.25."""
LIKE_ONE_HALF_SPACE = {
    "elastic": mdr.Elastic("1.25 GPa", 0.25),
    "transversely_isotropic": mdr.TransverselyIsotropic(**ISOTROPIC),
    "graded": mdr.Graded("1.25 GPa", depth="1 m", exponent=1e-9, poisson=0.25),
    "viscoelastic": mdr.Viscoelastic(mdr.StandardSolid("0.5 GPa", "2 GPa", "1 s"), poisson=0.25),
    "layered": mdr.Layered(
        [mdr.Layer(mdr.Elastic("1.25 GPa", 0.25), "1 um")], base=mdr.Elastic("1.25 GPa", 0.25)
    ),
    "elastic_plastic": mdr.ElasticPlastic("1.25 GPa", 0.25, "100 GPa"),
}
"""Every kind of body with the constants of one half-space."""


def test_every_body_of_the_package_has_the_limit_of_hertz():
    own = {kind for kind, cls in tables.MATERIALS.items() if cls.__module__.startswith("pymdr.")}
    assert LIKE_ONE_HALF_SPACE.keys() == own - {"rigid"}, "a new kind of body needs an entry here"
    force = 4.0 / 3.0 * 1.25e9 / (1.0 - 0.25**2) * math.sqrt(1e-2) * 1e-9**1.5
    for kind, body in LIKE_ONE_HALF_SPACE.items():
        result = mdr.solve(mdr.Contact(mdr.Paraboloid("10 mm"), body), mdr.indent("1 nm", duration=1e9))
        assert float(result["normal_force"][-1]) == pytest.approx(force, rel=2e-8), kind
