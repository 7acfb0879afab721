"""Sizes at the ends of what a float holds: refused, or numbers."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import pymdr as mdr
from drawing import examples

PROFILES = {
    "paraboloid": lambda size: mdr.Paraboloid(size),
    "sphere": lambda size: mdr.Sphere(size),
    "cone": lambda size: mdr.Cone(slope=0.1),
    "punch": lambda size: mdr.FlatPunch(size),
    "power": lambda size: mdr.PowerLaw(exponent=3.3, height=size, radius=size),
    "dome": lambda size: mdr.Paraboloid(size) + mdr.Cone(slope=0.1),
}
SIZES = st.one_of(
    st.floats(-324.0, 308.0).map(lambda x: 10.0**x), st.floats(-15.0, 15.0).map(lambda x: 10.0**x)
)


@settings(max_examples=examples(250), deadline=None)
@given(
    st.sampled_from(sorted(PROFILES)),
    SIZES,
    SIZES,
    SIZES,
    st.sampled_from([mdr.load, mdr.indent]),
)
def test_any_size_is_refused_or_gives_numbers(kind, size, young, target, leg):
    try:
        contact = mdr.Contact(PROFILES[kind](size), mdr.Elastic(young, 0.3))
        result = mdr.solve(contact, leg(target))
    except mdr.PymdrError:
        return
    for name, values in result.data.items():
        assert np.isfinite(values.values).all(), name
    result.summary()
    given_ = "normal_force" if leg is mdr.load else "indentation"
    assert float(result[given_][-1]) in (target, 0.0)


@pytest.mark.parametrize("make", [mdr.Sphere, mdr.Paraboloid, mdr.FlatPunch, lambda x: mdr.Elastic(x, 0.3)])
@settings(deadline=None)
@given(st.floats(61.0, 308.0))
def test_sizes_that_nothing_has_are_refused(make, exponent):
    with pytest.raises(mdr.ProblemError, match="it must be at most 1e\\+60"):
        make(10.0**exponent)
    with pytest.raises(mdr.ProblemError, match="it must be at least 1e-60"):
        make(10.0**-exponent)


@settings(deadline=None)
@given(st.floats(5e-324, 1e-291))
def test_loads_next_to_nothing_are_none(value):
    for path in (mdr.load(value), mdr.indent(-value), mdr.Path(normal_force=[value, 1.0])):
        values = path.normal_force if path.normal_force is not None else path.indentation
        assert np.atleast_1d(values)[0] == 0.0
