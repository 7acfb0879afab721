"""Profiles of one's own in case files and saved results; those of the page on contributing are in test_docs."""

import json
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import pymdr as mdr
from drawing import examples
from pymdr.mapping.equivalent import equivalent_profile
from pymdr.problem.codec import (
    PROFILES,
    case_schema,
    decode_case,
    encode,
    encode_case,
    forget_models,
    register_profile,
)
from pymdr.problem.profiles import Profile
from pymdr.problem.values import ArrayField, OptionalArrayField, OptionalSIField, SIField

STEEL = mdr.Elastic("210 GPa", 0.3)


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
    register_profile("own", cls)
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
    register_profile("own", first)
    register_profile("own", first)
    register_profile("own", second)
    assert encode(second(b=1.0)) == {"kind": "own", "b": 1.0}
    with pytest.raises(
        mdr.ProblemError, match=r"Own is no class that files know; call .*register_profile\('own', Own\)"
    ):
        encode(first(a=1.0))


@pytest.mark.parametrize(
    ("kind", "cls", "words"),
    [
        ("sphere", own_profile(), "'sphere' is that of Sphere; choose another"),
        ("indent", own_profile(), "'indent' is the word for something else"),
        ("function", own_profile(), "'function' is the word for something else"),
        ("Own one", own_profile(), "a word of small letters"),
        (3, own_profile(), "kind = 3; a word of small letters"),
        ("ball", mdr.Sphere, "Sphere is registered as 'sphere' already"),
        ("own", own_profile(frozen=False), r"@dataclass\(frozen=True, eq=False\)"),
        ("own", own_profile(eq=True), r"@dataclass\(frozen=True, eq=False\)"),
        ("own", own_profile(shape=3), "Own.shape is no quantity; declare it as shape: SIField = SIField"),
        ("own", own_profile(kind=SIField("m")), "Own.kind is a key of files"),
        ("own", mdr.Elastic, "is no class of profiles"),
        ("own", Profile, "is no class of profiles"),
        ("own", mdr.Sphere(1.0), "is no class of profiles"),
    ],
)  # fmt: skip
def test_what_cannot_be_registered(kinds, kind, cls, words):
    before = dict(PROFILES)
    with pytest.raises(mdr.ProblemError, match=words):
        register_profile(kind, cls)
    assert before == PROFILES


def test_files_of_a_profile_that_nobody_registered(kinds, tmp_path):
    cls = own_profile(radius=SIField("m"))
    equivalent_profile.register(cls, lambda profile: equivalent_profile(mdr.Paraboloid(profile.radius)))
    result = mdr.solve(mdr.Contact(cls(1.0) + mdr.Cone(0.1), STEEL), mdr.indent(1e-6))
    with pytest.raises(mdr.ProblemError, match=r"register_profile\('own', Own\)"):
        result.save(tmp_path / "own.nc")
    assert not list(tmp_path.iterdir())
    register_profile("own", cls)
    result.save(tmp_path / "own.nc")
    assert mdr.open_result(tmp_path / "own.nc").contact == result.contact
    del PROFILES["own"]
    forget_models()
    with pytest.raises(
        mdr.FileError, match="nobody has registered the profile 'own' here; import the module"
    ):
        mdr.open_result(tmp_path / "own.nc")
