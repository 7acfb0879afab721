"""Profiles of one's own in case files and saved results; those of the page on contributing are in test_docs."""

import json
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import pymdr as mdr
from common import STEEL
from drawing import examples
from pymdr.interpretation.theories import THEORIES
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.mapping.moduli import surface_compliances
from pymdr.problem.codec import (
    PROFILES,
    case_schema,
    decode_case,
    encode,
    encode_case,
    forget_models,
    register,
)
from pymdr.problem.laws import AdhesionLaw
from pymdr.problem.materials import Material
from pymdr.problem.profiles import Profile
from pymdr.problem.rheology import SpringsAndDashpots
from pymdr.problem.values import ArrayField, OptionalArrayField, OptionalSIField, SIField


def own_profile(name="Own", *, frozen=True, eq=False, **fields):
    """A class as a person would write it, with fields of given names."""
    body = {
        "__annotations__": dict.fromkeys(fields, "SIField"),
        "gap": lambda self, r: np.asarray(r, dtype=float) ** 2,
        "gap_slope": lambda self, r: 2.0 * np.asarray(r, dtype=float),
        "__module__": __name__,
        **fields,
    }
    return dataclass(frozen=frozen, eq=eq)(type(name, (Profile,), body))


UNITS = st.sampled_from(["m", "", "rad", "Pa"])
FIELDS = st.dictionaries(
    st.sampled_from(["a", "b", "height", "radius", "samples"]),
    st.one_of(
        st.builds(SIField, UNITS), st.builds(OptionalSIField, UNITS), st.builds(ArrayField, UNITS),
        st.builds(OptionalArrayField, UNITS),
    ),
)  # fmt: skip


@settings(
    max_examples=examples(10), deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(FIELDS, st.data(), st.booleans())
def test_registered_profiles_are_written_and_read(kinds, given_fields, data, inherited):
    # those that must be given come first in a dataclass
    order = sorted(given_fields, key=lambda n: type(given_fields[n]) not in (SIField, ArrayField))
    cls = own_profile("Base" if inherited else "Own", **{name: given_fields[name] for name in order})
    if inherited:
        cls = dataclass(frozen=True, eq=False)(type("Own", (cls,), {"__module__": __name__}))
    register("own", cls)
    numbers = st.floats(1e-9, 1e9)
    values = {}
    for name in order:
        array = isinstance(given_fields[name], OptionalArrayField)
        optional = (
            isinstance(given_fields[name], OptionalSIField) or type(given_fields[name]) is OptionalArrayField
        )
        value = st.lists(numbers, min_size=1, max_size=3) if array else numbers
        values[name] = data.draw(st.none() | value if optional else value)
    for profile in (cls(**values), cls(**values) + mdr.Sphere(1.0)):
        contact = mdr.Contact(profile, STEEL)
        plain = json.loads(json.dumps(encode_case("", contact, mdr.indent(1.0))))
        assert decode_case(plain)[1] == contact
    assert case_schema()["$defs"]["own"]["properties"].keys() == {"kind", *order}


def test_a_cell_that_registers_may_run_again(kinds):
    first, second = own_profile(a=SIField("m")), own_profile(b=SIField("m"))
    register("own", first)
    register("own", first)
    register("own", second)
    assert encode(second(b=1.0)) == {"kind": "own", "b": 1.0}
    with pytest.raises(
        mdr.ProblemError, match=r"Own is not registered for files; call .*register\('own', Own\)"
    ):
        encode(first(a=1.0))


@pytest.mark.parametrize(
    ("kind", "cls", "words"),
    [
        ("sphere", own_profile(), "'sphere' belongs to Sphere; choose another"),
        ("indent", own_profile(), "'indent' is reserved; choose another"),
        ("function", own_profile(), "'function' is reserved; choose another"),
        ("Own one", own_profile(), "use lower-case letters"),
        (3, own_profile(), "kind = 3; use lower-case letters"),
        ("ball", mdr.Sphere, "Sphere is already registered as 'sphere'"),
        ("own", own_profile(frozen=False), r"@dataclass\(frozen=True, eq=False\)"),
        ("own", own_profile(eq=True), r"@dataclass\(frozen=True, eq=False\)"),
        ("own", own_profile(shape=3), "the field shape of Own is not a quantity; declare it as shape: SIField = SIField"),
        ("own", own_profile(kind=SIField("m")), "the field kind of Own is a reserved key of files"),
        ("own", int, "is not a class of profiles"),
        ("own", mdr.Elastic, "Elastic is already registered as 'elastic'"),
        ("own", Profile, "is not a class of profiles"),
        ("own", mdr.Sphere(1.0), "is not a class of profiles"),
    ],
)  # fmt: skip
def test_what_cannot_be_registered(kinds, kind, cls, words):
    before = dict(PROFILES)
    with pytest.raises(mdr.ProblemError, match=words):
        register(kind, cls)
    assert before == PROFILES


def test_files_of_an_unregistered_profile(kinds, tmp_path):
    cls = own_profile(radius=SIField("m"))
    equivalent_profile.register(cls, lambda profile: equivalent_profile(mdr.Paraboloid(profile.radius)))
    result = mdr.solve(mdr.Contact(cls(1.0) + mdr.Cone(0.1), STEEL), mdr.indent(1e-6))
    with pytest.raises(mdr.ProblemError, match=r"register\('own', Own\)"):
        result.save(tmp_path / "own.nc")
    assert not list(tmp_path.iterdir())
    register("own", cls)
    result.save(tmp_path / "own.nc")
    assert mdr.open_result(tmp_path / "own.nc").contact == result.contact
    del PROFILES["own"]
    forget_models()
    with pytest.raises(mdr.FileError, match="the kind 'own' is not registered; import the module"):
        mdr.open_result(tmp_path / "own.nc")


@dataclass(frozen=True, eq=False)
class Gel(SpringsAndDashpots):
    """A standard solid by its two limits."""

    soft: SIField = SIField("Pa", above=0)
    stiff: SIField = SIField("Pa", above=0)
    time: SIField = SIField("s", above=0)

    def kernel(self, span=None):
        return mdr.StandardSolid(self.soft, self.stiff - self.soft, self.time).kernel(span)


@dataclass(frozen=True, eq=False)
class Rubber(Material):
    shear_modulus: SIField = SIField("Pa", above=0)


surface_compliances.register(
    Rubber, lambda body: surface_compliances(mdr.Elastic(3 * body.shear_modulus, 0.5))
)


@dataclass(frozen=True, eq=False)
class Tape(AdhesionLaw):
    """The edge of JKR under another name."""

    work: SIField = SIField("J/m^2", at_least=0)


def test_bodies_rheologies_and_laws_of_ones_own_are_written_and_read(kinds, tmp_path, monkeypatch):
    for kind, cls in (("gel", Gel), ("rubber", Rubber), ("tape", Tape)):
        register(kind, cls)
    monkeypatch.setitem(THEORIES, Tape, THEORIES[mdr.JKR])
    ball, path = mdr.Sphere("1 mm"), mdr.indent("10 um", duration="2 s", steps=3)
    gel = mdr.Viscoelastic(Gel("1 kPa", "4 kPa", "1 s"), poisson=0.5)
    solid = mdr.Viscoelastic(mdr.StandardSolid("1 kPa", "3 kPa", "1 s"), poisson=0.5)
    soft = mdr.Elastic("30 kPa", 0.5)
    pairs = [
        (mdr.Contact(ball, gel), mdr.Contact(ball, solid)),
        (mdr.Contact(ball, Rubber("10 kPa")), mdr.Contact(ball, soft)),
        (mdr.Contact(ball, soft, adhesion=Tape("50 mJ/m^2")), mdr.Contact(ball, soft, adhesion=mdr.JKR("50 mJ/m^2"))),
    ]  # fmt: skip
    for own, known in pairs:
        assert decode_case(json.loads(json.dumps(encode_case("", own, path))))[1] == own
        result = mdr.solve(own, path)
        result.save(tmp_path / "own.nc")
        again = mdr.open_result(tmp_path / "own.nc")
        assert again.contact == own
        expected = mdr.solve(known, path)["normal_force"].values
        np.testing.assert_allclose(again["normal_force"].values, expected, rtol=1e-12)
    for kind in ("gel", "rubber", "tape"):
        assert kind in case_schema()["$defs"]


def test_the_stress_in_a_body_of_ones_own_is_refused_under_its_name():
    pressed = mdr.solve(mdr.Contact(mdr.Sphere("10 mm"), Rubber("1 MPa")), mdr.load("1 N"))
    with pytest.raises(mdr.NotValidError, match="in a Rubber body is not computed; use Elastic"):
        pressed.field("von_mises")
