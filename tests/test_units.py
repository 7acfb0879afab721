"""The door for units, and the table of quantities."""

import math
import pickle
import re

import numpy as np
import pandas as pd
import pint
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st

import pymdr as mdr
from drawing import examples
from pymdr import units
from pymdr.errors import UnitError
from pymdr.quantities import QUANTITIES, quantity
from pymdr.units import from_si, in_good_units, to_si, to_si_array, without_rounding, written

UREG = pint.UnitRegistry()


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("5 mm", "m", 5e-3),
        ("5mm", "m", 5e-3),
        (" +5.mm ", "m", 5e-3),
        (".5 mm", "m", 5e-4),
        ("-1E+3 nm", "m", -1e-6),
        ("5 µm", "m", 5e-6),  # the micro sign
        ("5 μm", "m", 5e-6),  # the Greek letter
        ("2 Å", "m", 2e-10),
        ("4 mm^2/mm", "m", 4e-3),
        ("4 mm**2/mm", "m", 4e-3),
        ("210 GPa", "Pa", 210e9),
        ("3 N/mm^2", "Pa", 3e6),
        ("3 N/mm²", "Pa", 3e6),
        ("3 kg·m⁻¹·s⁻²", "Pa", 3.0),
        ("3 N·mm", "J", 3e-3),
        ("3 kg m/s^2", "N", 3.0),
        ("50 mJ/m^2", "J/m^2", 0.05),
        ("50 mN/m", "J/m^2", 0.05),
        ("50 %", "", 0.5),
        ("0.3", "", 0.3),
        ("180 deg", "rad", math.pi),
        ("90°", "rad", math.pi / 2),
        ("2 m^-1", "1/m", 2.0),
        ("10 ms", "s", 0.01),
        ("1 min", "s", 60.0),
        ("1 kgf", "N", 9.80665),
    ],
)
def test_texts_with_units(text, unit, value):
    assert to_si(text, unit) == pytest.approx(value, rel=2e-15)


@pytest.mark.parametrize("number", ["1", "2", "3", "5", "7", "9", "12.5", "47"])
@pytest.mark.parametrize(
    ("unit", "exponent"), [("nm", -9), ("um", -6), ("mm", -3), ("cm", -2), ("km", 3), ("Mm", 6), ("Gm", 9)]
)
def test_prefixes_round_correctly(number, unit, exponent):
    assert to_si(f"{number} {unit}", "m") == float(f"{number}e{exponent}")


def test_an_inch_is_exact():
    assert to_si("5 inch", "m") == pytest.approx(0.127, rel=2.3e-16)


@pytest.mark.parametrize(
    "text",
    [
        "1,5 mm",
        "1 000 mm",
        "1_000 mm",
        "9**9 m",
        "9**9**9 m",
        "1/2 m",
        "0x10 m",
        "nan m",
        "inf m",
        "-inf m",
        "1e400 m",
        "1e308 km",
        "mm",
        "",
        " ",
        "5",
        "5 5 mm",
        "5 mm; 3",
        "5 m**99",
        "5 (mm)",
        "5 m" + "m" * 100,
        "5 " + "m*" * 60 + "m",
        "1" * 100 + " m",
        "__import__('os') m",
        "5 degC",
        "5 kg",
        "5 m^2",
        "5 rad",
        "5 foo",
        "5 '",
    ],
)
def test_texts_that_are_refused(text):
    with pytest.raises(UnitError) as caught:
        to_si(text, "m", name="radius")
    assert str(caught.value).startswith("radius: ")
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def test_only_latin_digits_are_numbers():
    with pytest.raises(UnitError):
        to_si("\u0661 mm", "m")


def test_the_refusal_names_value_and_remedy():
    with pytest.raises(UnitError, match=r"radius: .*'kg' does not fit.*'5 mm'.*'5 kg'"):
        to_si("5 kg", "m", name="radius")
    with pytest.raises(UnitError, match=r"radius: unknown unit 'foo'"):
        to_si("5 foo", "m", name="radius")
    with pytest.raises(UnitError, match=r"radius: '5' has no unit; write for example '5 mm'"):
        to_si("5", "m", name="radius")


@pytest.mark.parametrize("unit", ["m", "N", "Pa", "s", "rad", "J/m^2", "N/m", "1/m", "m^2", ""])
def test_the_advice_of_an_error_can_be_read(unit):
    with pytest.raises(UnitError) as caught:
        to_si("no number", unit)
    advice = str(caught.value).rpartition("for example ")[2].strip("'")
    assert to_si(advice, unit) > 0.0


@pytest.mark.parametrize("value", [5, 5.0, np.float32(5), np.int8(5), np.array(5.0), np.str_("5 m")])
def test_plain_numbers_are_si(value):
    number = to_si(value, "m")
    assert number == 5.0
    assert type(number) is float


@pytest.mark.parametrize(
    "value",
    [None, True, np.True_, 1 + 0j, np.complex128(1), b"5 mm", [5.0], np.array([5.0]), object(), 10**400],
)
def test_values_that_are_no_quantity(value):
    with pytest.raises(UnitError):
        to_si(value, "m")


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, np.float32("nan")])
def test_numbers_that_are_not_finite(value):
    with pytest.raises(UnitError, match="not finite"):
        to_si(value, "m")


def test_pint_quantities():
    assert to_si(5 * UREG.mm, "m") == 5e-3
    assert to_si(UREG("200 GPa"), "Pa") == 200e9
    assert to_si(30 * UREG.percent, "") == pytest.approx(0.3, rel=1e-15)
    with pytest.raises(UnitError, match="does not fit"):
        to_si(5 * UREG.kg, "m")
    with pytest.raises(UnitError, match="not finite"):
        to_si(math.nan * UREG.mm, "m")


def test_a_pint_array_is_no_single_number():
    with pytest.raises(UnitError):
        to_si(np.array([1.0, 2.0]) * UREG.mm, "m")


@pytest.mark.parametrize(
    ("values", "answer"),
    [
        (["1 mm", 2.0, 3 * UREG.cm], [1e-3, 2.0, 3e-2]),
        (np.array([1, 2]), [1.0, 2.0]),
        (np.array([1.0, 2.0]) * UREG.um, [1e-6, 2e-6]),
        (range(3), [0.0, 1.0, 2.0]),
        ([], []),
    ],
)
def test_arrays(values, answer):
    array = to_si_array(values, "m")
    assert array.tolist() == answer
    assert array.dtype == float
    assert not array.flags.writeable


@pytest.mark.parametrize(
    "values",
    [
        [1.0, math.nan],
        np.array([1.0, math.inf]),
        ["1 mm", "1,5 mm"],
        ["1 mm", "1 kg"],
        [[1.0, 2.0], [3.0]],
        [None],
        [True],
        np.array([1 + 1j]),
        np.array([True]),
        {1: 2},
        np.array([1.0, 2.0]) * UREG.kg,
        np.array([1.0, math.nan]) * UREG.mm,
    ],
)
def test_arrays_that_are_refused(values):
    with pytest.raises(UnitError):
        to_si_array(values, "m", name="radii")


def test_arrays_name_the_bad_entry():
    with pytest.raises(UnitError, match=r"radii\[1\]: cannot read '1,5 mm'"):
        to_si_array(["1 mm", "1,5 mm"], "m", name="radii")


def test_an_array_is_a_copy():
    given_ = np.array([1.0, 2.0])
    array = to_si_array(given_, "m")
    given_[0] = 9.0
    assert array[0] == 1.0


@settings(max_examples=examples(40), deadline=None)
@given(st.floats(min_value=1e-200, max_value=1e200), st.sampled_from(["nm", "um", "mm", "m", "km", "inch"]))
def test_there_and_back(value, unit):
    assert float(from_si(to_si(f"{value!r} {unit}", "m"), "m", unit)) == pytest.approx(value, rel=5e-16)


@pytest.mark.parametrize("unit", ["kg", "m^2", "foo", "", "m/m", "1,5 m"])
def test_answers_in_a_unit_of_another_kind_are_refused(unit):
    with pytest.raises(UnitError):
        from_si(1.0, "m", unit)


def test_answers_for_lists():
    assert np.asarray(from_si([1.0, 2.0], "m", "mm")).tolist() == [1e3, 2e3]


@pytest.mark.parametrize("name", sorted(QUANTITIES))
def test_the_table_of_quantities(name):
    q = quantity(name)
    assert q.name == name
    assert q.long_name
    assert q.symbol
    assert q.label == f"{q.long_name} ${q.symbol}$"
    assert to_si(UREG.Quantity(2.0, q.unit), q.unit) == 2.0
    assert set(q.dims) <= {"step", "r", "x", "z", "component", "time", "angular_frequency", "cycles", "body"}


def test_units_of_the_table():
    units = {
        "time": "s",
        "indentation": "m",
        "normal_force": "N",
        "contact_radius": "m",
        "normal_stiffness": "N/m",
        "mean_pressure": "Pa",
        "elastic_energy": "J",
        "force_lower_bound": "N",
        "pressure": "Pa",
        "normal_displacement": "m",
        "gap": "m",
        "equivalent_profile": "m",
        "spring_force": "N/m",
    }
    assert {name: QUANTITIES[name].unit for name in units} == units
    with pytest.raises(KeyError):
        quantity("weight")


# --- arrays of other packages ------------------------------------------------------------------------------

UNITS = {"nm": 1e-9, "um": 1e-6, "mm": 1e-3, "inch": 0.0254}


def in_a_list(numbers, unit):
    return [xr.DataArray(x, attrs={"units": unit}) for x in numbers]


CARRIERS = {
    "xarray": lambda x, unit: xr.DataArray(x, attrs={"units": unit}),
    "a list of xarray": in_a_list,
    "pint in xarray": lambda x, unit: xr.DataArray(UREG.Quantity(x, unit)),
    "pandas": lambda x, unit: _with_attrs(pd.Series(x), unit),
    "the name of a column": lambda x, unit: pd.Series(x, name=f"d [{unit}]"),
    "pint in pandas": lambda x, unit: pd.Series([UREG.Quantity(v, unit) for v in x]),
    "an array with a unit": lambda x, unit: _Carrying(x, unit),
    "pint": lambda x, unit: UREG.Quantity(x, unit),
    "texts": lambda x, unit: [f"{float(v)!r} {unit}" for v in x],
    "arrays of texts": lambda x, unit: np.array([f"{float(v)!r} {unit}" for v in x]),
}


def _with_attrs(series, unit):
    series.attrs["units"] = unit
    return series


class _Carrying(np.ndarray):
    """As arrays of astropy and unyt are: NumPy arrays with a unit beside them."""

    def __new__(cls, values, unit):
        array = np.asarray(values).view(cls)
        array.unit = unit
        return array


@settings(max_examples=examples(100), deadline=None)
@given(
    st.sampled_from(sorted(CARRIERS)),
    st.sampled_from(sorted(UNITS)),
    st.lists(st.floats(1e-3, 1e3), min_size=1, max_size=4),
)
def test_units_that_an_array_carries_are_honoured(carrier, unit, numbers):
    carried = CARRIERS[carrier](np.array(numbers), unit)
    expected = np.array(numbers) * UNITS[unit]
    assert to_si_array(carried, "m") == pytest.approx(expected, rel=1e-14)
    with pytest.raises(UnitError):
        to_si_array(CARRIERS[carrier](np.array(numbers), "kg"), "m")
    with pytest.raises(UnitError):
        to_si_array(CARRIERS[carrier](np.array(numbers), "parsnip") if "pint" not in carrier else [None], "m")


@settings(deadline=None)
@given(st.lists(st.booleans(), min_size=1, max_size=5))
def test_masked_numbers_are_refused_in_any_wrapping(mask):
    masked = np.ma.masked_array(np.ones(len(mask)), mask)
    for values in (masked, UREG.Quantity(masked, "um")):
        if any(mask):
            with pytest.raises(UnitError, match="masked"):
                to_si_array(values, "m")
        else:
            assert to_si_array(values, "m").size == len(mask)
    with pytest.raises(UnitError, match="masked"):
        to_si(np.ma.masked, "m")


@settings(deadline=None)
@given(st.floats(0.1, 80.0), st.sampled_from(["deg", "rad", "mrad", "arcmin", "turn", "grad"]))
def test_angles_are_no_plain_numbers_and_plain_numbers_no_angles(number, unit):
    for value in (
        f"{number!r} {unit}",
        UREG.Quantity(number, unit),
        xr.DataArray(number, attrs={"units": unit}),
    ):
        assert to_si(value, "rad") > 0.0
        with pytest.raises(UnitError, match="angle"):
            to_si(value, "")
    for value in (f"{number!r} %", UREG.Quantity(number, "percent")):
        with pytest.raises(UnitError):
            to_si(value, "rad")
        assert to_si(value, "") == pytest.approx(number / 100.0, rel=1e-14)


@pytest.mark.parametrize("value", [np.array("5"), np.array(True), np.array(b"5"), np.timedelta64(5, "s")])
def test_arrays_without_shape_are_what_they_hold(value):
    with pytest.raises(UnitError):
        to_si(value, "s")


def test_a_text_in_an_array_without_shape_is_a_text():
    assert to_si(np.array("5 mm"), "m") == 5e-3


@given(
    st.floats(1.0, 999.0),
    st.integers(-5, 1),
    st.sampled_from(["m", "N", "Pa", "J", "N/m", "J/m^2", "Pa*m^0.5"]),
    st.sampled_from([-1, 1]),
)
def test_a_person_reads_one_to_a_thousand_with_the_prefix_of_a_person(digits, thousands, unit, sign):
    value = sign * digits * 1000.0**thousands
    if unit not in ("m", "N", "J", "N/m") and thousands < -2:
        return
    text = written(value, unit)
    number, prefixed = text.split()
    assert 1.0 <= abs(float(number)) < 1000.0
    assert not prefixed.startswith("u")
    assert to_si(text, unit) == pytest.approx(value, rel=6e-4)
    exact, same = in_good_units(float(f"{value:.4g}"), unit)
    assert same == prefixed
    assert to_si(f"{exact!r} {same}", unit) == pytest.approx(float(f"{value:.4g}"), rel=1e-14)


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (-0.0, "m", "0 m"),
        (9.99999e-7, "m", "1 µm"),
        (6.371e6, "m", "6371 km"),
        (6.9e-8, "m^2", "0.069 mm^2"),
        (50e-3, "J/m^2", "50 mJ/m^2"),
        (2.5e6, "Pa*m^0.5", "2.5 MPa*m^0.5"),
        (4.1e-18, "J", "4.1 aJ"),
        (5.0, "", "5"),
        (math.nan, "N", "-"),
    ],
)
def test_values_in_words(value, unit, text):
    assert written(value, unit) == text


@given(st.floats(-1e-15, 1e-15), st.floats(1e-12, 1e6))
def test_rounding_is_nothing(noise, size):
    column = np.array([0.0, -size, np.nan, noise * size])
    assert without_rounding(column[-1], column, "1/m") == 0.0
    assert without_rounding(1e-14 * size, column, "1/m") == 1e-14 * size
    assert without_rounding(1e-20, np.array([1e-20]), "m") == 1e-20
    assert without_rounding(1e-35, np.array([1e-35]), "J/m^2") == 0.0


@pytest.mark.parametrize("stiffness", ["0 N/m", "0.05 N/m", None])
@pytest.mark.parametrize("tip", [mdr.Paraboloid("50 um"), mdr.FlatPunch("10 um"), mdr.Cone(slope=0.3)])
def test_no_rounding_is_read_in_words(tip, stiffness):
    contact = mdr.Contact(tip, mdr.Elastic("30 kPa", 0.5), adhesion=mdr.JKR("2 mJ/m^2"))
    machine = {} if stiffness is None else {"machine_stiffness": stiffness}
    path = mdr.indent("1 um", steps=7) >> mdr.indent("0 um", steps=7)
    last = mdr.solve(contact, path).summary().partition("Claims:")[0]
    for text in (mdr.pull_off(contact, **machine).summary(), last):
        for number in re.findall(r" (-?[0-9.]+(?:e[+-]\d+)?) [a-zµ]*[mNJ]\b", text):
            assert number != "-0"
            assert number == "0" or 1e-2 <= abs(float(number)) < 1e4, text


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("50 W/(m K)", "W/(m*K)", 50.0),
        ("0.5 W/(cm*K)", "W/(m*K)", 50.0),
        ("50 W / (m·K)", "W/(m*K)", 50.0),
        ("1.7 uohm cm", "ohm*m", 1.7e-8),
        ("20 degC", "K", 293.15),
        ("-40 °C", "K", 233.15),
        ("-40 degF", "K", 233.15),
        ("293 K", "K", 293.0),
        ("2 W/(m^2 K)", "W/(m^2*K)", 2.0),
    ],
)
def test_products_in_brackets_and_temperatures(text, unit, value):
    assert to_si(text, unit) == pytest.approx(value, rel=1e-13)
    assert to_si_array([text, text], unit) == pytest.approx(np.full(2, value), rel=1e-13)


@pytest.mark.parametrize(
    "text", ["50 W/(m K", "50 W/m K)", "50 W/(m/K)", "50 W/((m K))", "50 (W)/(m K)", "5 ()"]
)
def test_other_brackets_are_refused(text):
    with pytest.raises(UnitError):
        to_si(text, "W/(m*K)")


def test_temperatures_are_not_differences():
    with pytest.raises(UnitError, match="start at 0 K"):
        from_si(300.0, "K", "degC")
    assert from_si(0.3, "K", "mK") == pytest.approx(300.0)


def test_common_units_have_the_factors_of_pint():
    for (unit, si_unit), factor in units._COMMON.items():
        assert units._factor_of(unit, si_unit) == factor, unit
