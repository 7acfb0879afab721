"""Exported laws: held against closed forms, against solve, and in C."""

import ctypes
import math
import shutil
import subprocess

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import pymdr as mdr
from common import GEL, STEEL
from drawing import examples

MODULUS = 210e9 / (1 - 0.3**2)
LAYERS = mdr.Layered([mdr.Layer(mdr.Elastic("1 GPa", 0.3), "10 um")], mdr.Elastic("1 MPa", 0.45))
QUANTITIES = ("normal_force", "normal_stiffness", "contact_radius")

needs_c = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler (cc) on this machine")
WARNINGS = ("-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wsign-conversion", "-Wshadow", "-Werror")

CONTACTS = {
    "sphere": (mdr.Contact(mdr.Sphere("10 mm"), STEEL), "1 mm"),
    "cone": (mdr.Contact(mdr.Cone(slope=0.1), STEEL), "1 um"),
    "flat": (mdr.Contact(mdr.FlatPunch("1 mm"), STEEL), "1 um"),
    "edge": (mdr.Contact(mdr.DomedPunch("1 mm", "10 mm"), STEEL), "300 um"),
    "kink": (mdr.Contact(mdr.RoundedCone("1 um", slope=0.3), STEEL), "10 um"),
    "truncated": (mdr.Contact(mdr.TruncatedCone("1 um", slope=0.3), STEEL), "10 um"),
    "sum": (mdr.Contact(mdr.Sphere("1 mm") + mdr.PowerLaw(6, "1 um", "10 um"), STEEL), "1 um"),
    "graded": (mdr.Contact(mdr.Sphere("1 mm"), mdr.Graded("1 MPa", "1 mm", 0.4, 0.3)), "20 um"),
    "layers": (mdr.Contact(mdr.Sphere("1 mm"), LAYERS), "20 um"),
    "friction": (mdr.Contact(mdr.Sphere("1 mm"), STEEL, STEEL, friction=mdr.Coulomb(0.3)), "20 um"),
    "jkr": (mdr.Contact(mdr.Sphere("1 mm"), GEL, adhesion=mdr.JKR("50 mJ/m^2")), "50 um"),
    "jkr_cone": (mdr.Contact(mdr.Cone(slope=0.3), GEL, adhesion=mdr.JKR("50 mJ/m^2")), "50 um"),
    "jkr_flat": (mdr.Contact(mdr.FlatPunch("1 mm"), GEL, adhesion=mdr.JKR("50 mJ/m^2")), "50 um"),
    "jkr_edge": (mdr.Contact(mdr.DomedPunch("0.3 mm", "1 mm"), GEL, adhesion=mdr.JKR("50 mJ/m^2")), "0.2 mm"),
    "dmt": (mdr.Contact(mdr.Sphere("1 um"), STEEL, adhesion=mdr.DMT("50 mJ/m^2")), "2 nm"),
}


@pytest.fixture(scope="module")
def laws():
    """Every law is made once."""
    made = {}

    def law(name):
        if name not in made:
            made[name] = mdr.export_law(*CONTACTS[name])
        return made[name]

    return law


def test_checks_below_the_touch_are_in_contact():
    """The intervals with the largest errors may all be below d = 0, where only bodies in contact pull."""
    contact = mdr.Contact(mdr.Cone(slope=0.1), mdr.Elastic("40 kPa", 0.5), adhesion=mdr.JKR(0.05))
    law = mdr.export_law(contact, "20 um")
    assert np.isfinite(law.checks["contact_radius"].values).all()


def depths_of(law, count, rng):
    """Depths within the table and, where there is a tip, far below it, at random."""
    first, last = law.range
    if law.pull_off is not None and first < 0.0:
        return first + (last - first) * rng.uniform(1e-6, 1.0, count) ** 2
    return np.exp(rng.uniform(math.log(first) - 12.0, math.log(last), count))


def exact_of(contact, depths):
    """Force, stiffness and radius of solve at depths, on the branch of a contact that is made."""
    order = np.argsort(depths)[::-1]
    path = mdr.Path(indentation=depths[order])
    if contact.adhesion is not None:
        path = mdr.indent(float(depths.max())) >> path
    result = mdr.solve(contact, path)
    columns = np.empty((3, depths.size))
    columns[:, order] = [result[name].values[-depths.size :] for name in QUANTITIES]
    return columns


def errors_of(law, ours, exact):
    """Relative errors as the law states them: under adhesion beside the pull."""
    added = np.zeros((3, 1))
    if law.pull_off is not None:
        added[0] = -law.pull_off.largest_pull
        if law.range[0] < 0.0:
            a = law.pull_off.contact_radius
            modulus = 30e3 / 0.75
            added[1] = 2 * modulus * a
    return np.max(np.abs(ours - exact) / (np.abs(exact) + added), axis=1)


@pytest.mark.parametrize("name", CONTACTS)
def test_a_law_is_that_of_solve_within_its_stated_error(laws, name):
    law = laws(name)
    assert set(law.errors) == set(QUANTITIES)
    assert max(law.errors.values()) <= law.tolerance == 1e-6
    d = depths_of(law, 3000, np.random.default_rng(1))
    if law.table.form.tip is None:  # no error is stated where rounding of d decides
        d = d[d - law.range[0] >= law.table.form.nearest]
    ours = np.array([law.force(d), law.stiffness(d), law.radius(d)])
    assert np.all(errors_of(law, ours, exact_of(law.contact, d)) <= [law.errors[q] for q in QUANTITIES])


def test_hertz_and_sneddon_in_closed_form():
    law = mdr.export_law(mdr.Contact(mdr.Paraboloid("10 mm"), STEEL), "10 um")
    d = np.geomspace(1e-15, 1e-5, 500)
    assert law.force(d) == pytest.approx(4 / 3 * MODULUS * math.sqrt(0.01) * d**1.5, rel=1e-12)
    assert law.stiffness(d) == pytest.approx(2 * MODULUS * np.sqrt(0.01 * d), rel=1e-12)
    assert law.radius(d) == pytest.approx(np.sqrt(0.01 * d), rel=1e-12)
    law = mdr.export_law(mdr.Contact(mdr.Cone(slope=0.2), STEEL), "10 um")
    assert law.force(d) == pytest.approx(2 / math.pi * MODULUS * d**2 / 0.2, rel=1e-12)


def test_jkr_in_closed_form():
    """JKR's paraboloid: d = a^2/R - sqrt(2 pi a w / E*), F = 4 E* a^3 / 3R - sqrt(8 pi a^3 w E*)."""
    radius, work, modulus = 1e-3, 50e-3, 30e3 / 0.75
    contact = mdr.Contact(mdr.Paraboloid(radius), GEL, adhesion=mdr.JKR(work))
    law = mdr.export_law(contact, "50 um", tolerance=1e-7)
    radius_at_pull_off = (math.pi * work * radius**2 / (8 * modulus)) ** (1 / 3)
    a = np.linspace(1.001 * radius_at_pull_off, 3 * radius_at_pull_off, 400)
    d = a**2 / radius - np.sqrt(2 * math.pi * a * work / modulus)
    a, d = a[d < 50e-6], d[d < 50e-6]
    force = 4 * modulus * a**3 / (3 * radius) - np.sqrt(8 * math.pi * a**3 * work * modulus)
    assert law.radius(d) == pytest.approx(a, rel=1e-7)
    assert np.max(np.abs(law.force(d) - force)) < 1e-7 * 1.5 * math.pi * work * radius
    assert law.pull_off.largest_pull == pytest.approx(-1.5 * math.pi * work * radius, rel=1e-9)


def test_the_stiffness_is_the_derivative_of_the_force(laws):
    for name in ("kink", "jkr", "layers"):
        law = laws(name)
        nodes, weights = np.polynomial.legendre.leggauss(12)
        d = law.data["indentation"].values
        d = d[d > law.range[0] + 1e-3 * (law.range[1] - law.range[0])]
        low, high = d[:-1, None], d[1:, None]
        work = np.sum(
            0.5 * weights * (high - low) * law.stiffness(0.5 * (low + high) + 0.5 * (high - low) * nodes), 1
        )
        rise = np.diff(law.force(d))
        assert np.max(np.abs(work - rise)) < 1e-12 * np.max(np.abs(law.force(d)))


def test_outside_of_the_table(laws):
    law = laws("sphere")
    assert law.force([-1.0, 0.0]).tolist() == [0.0, 0.0]
    assert np.isnan(law.radius([1.001e-3, 1.0])).all()
    with pytest.raises(mdr.UnitError, match="finite"):
        law.force([math.nan])
    assert np.isfinite(law.force("1 mm"))
    assert law.force("1 um").shape == ()
    law = laws("jkr")
    first = law.range[0]
    assert first == law.pull_off.indentation
    assert law.force([1.0001 * first, first]).tolist() == [
        0.0,
        # a vertical tangent: rounding of the depth moves the force by its root
        pytest.approx(law.pull_off.normal_force, rel=1e-9),
    ]


def drawn_profile(kind, size, slope):
    return {
        "sphere": lambda: mdr.Sphere(size),
        "power": lambda: mdr.PowerLaw(1.0 + 6.0 * slope, slope * size, size),
        "rounded cone": lambda: mdr.RoundedCone(size, slope=slope),
        "hyperboloid": lambda: mdr.Hyperboloid(size, slope=slope),
        "truncated sphere": lambda: mdr.TruncatedSphere(radius=size, flat_radius=0.1 * slope * size),
        "rounded flat": lambda: mdr.RoundedFlat(0.5 * size, size * (1.0 + slope)),
        "ellipsoid": lambda: mdr.Ellipsoid(radius=size, height=size * (0.5 + slope)),
        "domed": lambda: mdr.DomedPunch(0.3 * size, size),
        "sampled": lambda: mdr.Sampled(
            np.linspace(0, 3 * size, 60), size * (np.hypot(1.0, np.linspace(0, 3, 60)) - 1.0)
        ),
    }[kind]()


KINDS = (
    "sphere",
    "power",
    "rounded cone",
    "hyperboloid",
    "truncated sphere",
    "rounded flat",
    "ellipsoid",
    "domed",
    "sampled",
)


@settings(max_examples=examples(40), deadline=None)
@given(
    kind=st.sampled_from(KINDS),
    size=st.floats(-9, 0).map(lambda x: 10.0**x),
    slope=st.floats(0.05, 0.9),
    depth=st.floats(-3, -0.7).map(lambda x: 10.0**x),
    young=st.floats(2, 12).map(lambda x: 10.0**x),
    tolerance=st.sampled_from([1e-3, 1e-5, 1e-7]),
)
def test_any_profile_at_any_size(kind, size, slope, depth, young, tolerance):
    try:
        contact = mdr.Contact(drawn_profile(kind, size, slope), mdr.Elastic(young, 0.3))
        mdr.solve(contact, mdr.indent(depth * size))
    except mdr.PymdrError:
        assume(False)
    law = mdr.export_law(contact, depth * size, tolerance=tolerance)
    assert max(law.errors.values()) <= tolerance
    d = depths_of(law, 300, np.random.default_rng(2))
    ours = np.array([law.force(d), law.stiffness(d), law.radius(d)])
    assert np.all(errors_of(law, ours, exact_of(contact, d)) <= tolerance)
    assert np.all(np.diff(law.data["indentation"].values) > 0)


@settings(max_examples=examples(15), deadline=None)
@given(
    kind=st.sampled_from(["sphere", "rounded cone", "hyperboloid", "truncated sphere", "domed"]),
    size=st.floats(-8, 0).map(lambda x: 10.0**x),
    slope=st.floats(0.1, 0.9),
    strength=st.floats(-5, -2).map(lambda x: 10.0**x),
    young=st.floats(3, 11).map(lambda x: 10.0**x),
)
def test_any_size_with_jkr(kind, size, slope, strength, young):
    modulus = young / (1 - 0.25)
    contact = mdr.Contact(
        drawn_profile(kind, size, slope),
        mdr.Elastic(young, 0.5),
        adhesion=mdr.JKR(strength**1.5 * modulus * size),
    )
    try:
        law = mdr.export_law(contact, strength * size, tolerance=1e-5)
    except (mdr.ProblemError, mdr.PathError) as refused:
        assert "jumps" in str(refused) or "disk" in str(refused) or "known" in str(refused)  # noqa: PT017
        return
    d = depths_of(law, 300, np.random.default_rng(3))
    exact = exact_of(contact, d)
    pull = -law.pull_off.largest_pull
    stiffness = 2 * modulus * law.pull_off.contact_radius
    assert np.max(np.abs(law.force(d) - exact[0]) / (np.abs(exact[0]) + pull)) <= 1e-5
    assert np.max(np.abs(law.stiffness(d) - exact[1]) / (np.abs(exact[1]) + stiffness)) <= 1e-5
    assert law.radius(d) == pytest.approx(exact[2], rel=1e-5)


@settings(max_examples=examples(18), deadline=None)
@given(
    interpolation=st.sampled_from([mdr.ShapePreserving(), mdr.CubicSpline(), mdr.SmoothingSpline()]),
    size=st.floats(-9, 0).map(lambda x: 10.0**x),
    noise=st.sampled_from([0.0, 1e-4, 3e-3]),
    samples=st.integers(8, 20),
    seed=st.integers(0, 2**20),
    work=st.sampled_from([None, 1e-5, 1e-4]),
    tolerance=st.floats(-6, -2).map(lambda x: 10.0**x),
)
def test_bounds_of_measured_tips_hold_between_all_knots(
    interpolation, size, noise, samples, seed, work, tolerance
):
    """Also between the two knots at a kink, where the rounding of ln F is an error of the stiffness, and the stiffness with JKR jumps."""
    rng = np.random.default_rng(seed)
    x = np.concatenate([[0.0], np.sort(rng.uniform(0.01, 1.0, samples))])
    height = 0.2 * size * (x**2 + noise * rng.normal(size=x.size) * (x > 0.0))
    scatter = 0.2 * size * max(noise, 1e-4) * (x > 0.0)
    smoothed = isinstance(interpolation, mdr.SmoothingSpline)
    try:
        tip = mdr.Sampled(size * x, height, scatter if smoothed else None, interpolation=interpolation)
        adhesion = None if work is None else mdr.JKR(work * 1e9 * size)
        law = mdr.export_law(
            mdr.Contact(tip, mdr.Elastic("1 GPa", 0.3), adhesion=adhesion), 0.05 * size, tolerance=tolerance
        )
    except (mdr.ProblemError, mdr.PathError, mdr.RefusedError, mdr.ConvergenceError):
        assume(False)
    u, form = law.table.knots.u, law.table.form
    between = rng.uniform(0.0, 1.0, (u.size - 1, 6))
    d = np.unique(
        np.minimum(form.depth((u[:-1, None] + np.diff(u)[:, None] * between).ravel()), law.range[1])
    )
    d = form.checked(d, law.range[0]) if form.tip is None else d
    ours, exact = np.array([law.force(d), law.stiffness(d), law.radius(d)]), exact_of(law.contact, d)
    relative = np.abs(ours - exact) / (np.abs(exact) + np.array([*form.added, 0.0])[:, None])
    at = np.searchsorted(u, form.coordinate(d), side="right") - 1
    kinks = law.table.kinks(tolerance)[np.clip(at, 0, u.size - 2)]
    bounds = np.array([np.full(d.size, law.errors[name]) for name in QUANTITIES])
    bounds[1, kinks] = law.kink_error
    assert np.all(relative <= bounds)


@pytest.mark.parametrize("size", [1e-9, 1e-2])
def test_bounds_hold_next_to_a_kink_with_a_vertical_tangent(size):
    cone = mdr.RoundedCone(slope=0.3, tip_radius=0.3 * size)
    contact = mdr.Contact(cone, mdr.Elastic("1 GPa", 0.3), adhesion=mdr.JKR(1e5 * size))
    law = mdr.export_law(contact, 0.1 * size, tolerance=1e-2)
    d = law.table.form.checked(np.linspace(0.99 * law.range[0], 0.1 * size, 3001), law.range[0])
    exact = exact_of(contact, d)[1]
    relative = np.abs(law.stiffness(d) - exact) / (np.abs(exact) + law.table.form.added[1])
    assert relative.max() <= law.errors["normal_stiffness"]


def test_rescaled_contacts_have_one_table():
    small, large = (
        mdr.export_law(mdr.Contact(mdr.Hyperboloid(size, slope=0.3), mdr.Elastic(1e9, 0.3)), 5 * size)
        for size in (1e-9, 1.0)
    )
    assert small.data.sizes == large.data.sizes
    assert small.data["normal_force"].values * 1e18 == pytest.approx(
        large.data["normal_force"].values, rel=1e-9
    )


def test_claims_and_remarks(laws):
    law = laws("jkr")
    for name in QUANTITIES:
        claim = law.claims[name]
        assert claim.level is mdr.Level.APPROXIMATE
        assert "as a table" in claim.reason
        assert float(claim.error.max()) >= law.errors[name]
    text = "\n".join(law.remarks())
    for words in (
        "Sphere(radius=0.001)",
        "separate at d = -1.8",
        "JKR(work=0.05",
        "doi:10.1098/rspa.1971.0141",
    ):
        assert words in text
    assert any("friction has no effect on the law" in note for note in laws("friction").notes)
    assert "2 knots" in laws("cone").summary()
    assert "lost at d = -18.6553 µm" in str(law)
    assert "<table>" in law._repr_html_()
    for figure in (law.plot(), laws("kink").plot(), laws("dmt").plot()):
        assert len(figure.axes) == 2


REFUSED = {
    "maugis": (
        mdr.Contact(mdr.Sphere("1 mm"), GEL, adhesion=mdr.MaugisDugdale("50 mJ/m^2", range="1 um")),
        "zone",
    ),
    "shape": (mdr.Contact(mdr.EllipticParaboloid("1 mm", "2 mm"), STEEL), "no radius"),
    "ring": (mdr.Contact(mdr.ConcavePunch("1 mm", "10 mm"), STEEL), "not a disk"),
    "no contact": (mdr.Sphere("1 mm"), "not a Contact"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_has_no_law_is_refused(name):
    contact, words = REFUSED[name]
    with pytest.raises(mdr.ProblemError, match=words):
        mdr.export_law(contact, "1 um")


@pytest.mark.parametrize(
    ("to", "options", "error", "words"),
    [
        ("0 um", {}, mdr.ProblemError, "above 0 m"),
        ("-1 um", {}, mdr.ProblemError, "above 0 m"),
        ("1 N", {}, mdr.UnitError, "N"),
        ("1 m", {}, mdr.PathError, "sphere cannot be pressed in"),
        ("1 um", {"tolerance": 1e-12}, mdr.ProblemError, "1e-07 to 0.01"),
        ("1 um", {"tolerance": "small"}, mdr.ProblemError, "1e-07 to 0.01"),
    ],
)
def test_wrong_arguments(to, options, error, words):
    with pytest.raises(error, match=words):
        mdr.export_law(CONTACTS["sphere"][0], to, **options)


def test_a_wavy_contact_that_jumps_is_refused():
    wavy = mdr.Sphere("1 mm") + mdr.Waviness("0.5 um", "20 um")
    contact = mdr.Contact(wavy, mdr.Elastic("1 MPa", 0.5), adhesion=mdr.JKR("50 mJ/m^2"))
    with pytest.raises(mdr.ProblemError, match=r"jumps|not a disk"):
        mdr.export_law(contact, "20 um")


def test_the_table_is_read_back(laws, tmp_path):
    for name in ("kink", "jkr"):
        law = laws(name)
        law.to_csv(tmp_path / "law.csv", units={"indentation": "nm", "normal_force": "uN"})
        result = mdr.read_record(tmp_path / "law.csv")
        assert result["indentation"].values == pytest.approx(law["indentation"].values, rel=1e-14)
        assert result["normal_force"].values == pytest.approx(law["normal_force"].values, rel=1e-14)
    laws("kink").to_csv(tmp_path / "law.csv")
    curve = mdr.read_force_curve(tmp_path / "law.csv", modulus=MODULUS)
    assert np.array_equal(curve.force, laws("kink")["normal_force"].values)


@pytest.mark.parametrize("name", ["1a", "double", "", "a b", "x" * 60, None, "ö", "a*/"])
def test_names_that_c_does_not_know(laws, name):
    with pytest.raises(mdr.ProblemError, match="C identifier"):
        laws("cone").c_header(name)


def compiled(header, name, folder, compiler="cc"):
    """The functions of a header in a library."""
    (folder / f"{name}.h").write_text(header)
    source = folder / ("one.cpp" if compiler != "cc" else "one.c")
    start = 'extern "C" ' if compiler != "cc" else ""
    source.write_text(
        f'#include "{name}.h"\n#include "{name}.h"\n'
        f"{start}void all(const double *d, double *out, size_t n);\n"
        f"{start}void all(const double *d, double *out, size_t n)\n{{\n    size_t i;\n"
        f"    for (i = 0; i < n; ++i)\n        {name}_law(d[i], out + i, out + n + i, out + 2 * n + i);\n"
        f"    for (i = 0; i < n; ++i)\n        if ({name}_force(d[i]) < out[i] || {name}_stiffness(d[i]) < out[n + i] "
        f"|| {name}_radius(d[i]) > out[2 * n + i])\n            out[i] = {name.upper()}_LARGEST_INDENTATION / 0.0;\n}}\n"
    )
    library = folder / f"{name}_{compiler.replace('+', 'p')}.so"
    standard = "-std=c99" if compiler == "cc" else "-std=c++11"
    subprocess.run(
        [compiler, standard, *WARNINGS, "-O2", "-shared", "-fPIC", source, "-o", library, "-lm"],
        check=True, capture_output=True, text=True,
    )  # fmt: skip
    run = ctypes.CDLL(str(library)).all
    pointer = np.ctypeslib.ndpointer(dtype=float, flags="C")
    run.argtypes = [pointer, pointer, ctypes.c_size_t]
    run.restype = None

    def law(d):
        d = np.ascontiguousarray(d, dtype=float)
        out = np.empty((3, d.size))
        run(d, out, d.size)
        return out

    return law


@needs_c
@pytest.mark.parametrize("name", CONTACTS)
def test_the_header_compiles_without_warnings_and_is_the_law(laws, name, tmp_path):
    law = laws(name)
    in_c = compiled(law.c_header(name), name, tmp_path)
    d = depths_of(law, 5000, np.random.default_rng(4))
    ours = in_c(d)
    assert np.all(errors_of(law, ours, exact_of(law.contact, d)) <= 1e-6)
    python = np.array([law.force(d), law.stiffness(d), law.radius(d)])
    assert (
        np.max(np.abs(ours - python) / (np.abs(python) + np.abs(python).max(1, keepdims=True) * 1e-6)) < 1e-9
    )
    first, last = law.range
    outside = in_c([first - abs(first) if first < 0 else -1.0, last * 1.0000001, math.nan, math.inf, last])
    assert outside[:, 0].tolist() == [0.0, 0.0, 0.0]
    assert np.isnan(outside[:, 1:4]).all()
    assert np.isfinite(outside[:, 4]).all()
    knots = law.data["indentation"].values
    assert in_c(knots)[0] == pytest.approx(
        law.data["normal_force"].values, rel=1e-9, abs=1e-9 * np.abs(ours[0]).max()
    )


@pytest.mark.skipif(shutil.which("c++") is None, reason="no C++ compiler (c++) on this machine")
@pytest.mark.parametrize("name", ["kink", "jkr", "dmt"])
def test_the_header_is_c_plus_plus_too(laws, name, tmp_path):
    law = laws(name)
    d = depths_of(law, 100, np.random.default_rng(5))
    in_cpp = compiled(law.c_header(name), name, tmp_path, "c++")
    assert in_cpp(d)[0] == pytest.approx(law.force(d), rel=1e-9)


@needs_c
def test_a_comment_that_nothing_ends(tmp_path):
    """Profiles of one's own may say anything of themselves."""

    class Odd(mdr.Cone):
        def __repr__(self):
            return "Odd */ int x; /* ??/ \\\n µ"

    law = mdr.export_law(mdr.Contact(Odd(slope=0.1), STEEL), "1 um")
    assert np.isfinite(compiled(law.c_header("odd"), "odd", tmp_path)([1e-6])[0, 0])


def test_a_header_is_written_under_the_name_of_its_file(laws, tmp_path):
    laws("cone").to_c(tmp_path / "steel_cone.h")
    assert "steel_cone_force(double d)" in (tmp_path / "steel_cone.h").read_text()
    with pytest.raises(mdr.ProblemError, match="C identifier"):
        laws("cone").to_c(tmp_path / "steel-cone.h")
    assert [file.name for file in tmp_path.iterdir()] == ["steel_cone.h"]
