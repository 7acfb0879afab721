"""Surfaces pressed by boundary elements: against closed forms, references and a solver of the house; kept, resumed and refused."""

import importlib.util
import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

import pymdr as mdr
from common import UNIT
from drawing import examples
from pymdr.errors import (
    ConvergenceError,
    FileError,
    MissingExtraError,
    NotValidError,
    PathError,
    ProblemError,
)
from pymdr.independent.engines import Pressing, engine_names, find_engine
from pymdr.independent.engines import protocol as engines_of
from pymdr.independent.engines.solutions import by_force, refuse_unsolved
from pymdr.independent.sliding.following import solve_pressure
from pymdr.independent.sliding.surface import make_surface
from pymdr.presentation.files import read_dataset, write_dataset
from pymdr.solving.press import bytes_of
from pymdr.solving.press import verb as solving

needs_engine = pytest.mark.skipif(
    importlib.util.find_spec("ContactMechanics") is None,
    reason="ContactMechanics, of the extra rough, is missing",
)


def grid(n, size=1.0):
    x = (np.arange(n) + 0.5) / n * size - 0.5 * size
    return np.meshgrid(x, x, indexing="ij")


def ball(n, radius=1.0, size=1.0, height=0.0):
    x, y = grid(n, size)
    return height - (x**2 + y**2) / (2 * radius)


def from_apex(heights, depth):
    """The depth of the highest pixel, where the apex at height 0 is between pixels."""
    return depth + heights.max()


@needs_engine
def test_a_summary_says_why_a_table_has_no_resistance():
    body = mdr.Elastic(1e9, 0.3, resistivity=1e-7)
    pressed = mdr.press(mdr.Topography(ball(16), 1.0), body, indentation=0.02)
    assert "counterbody, Rigid, has no resistivity; give it one" in pressed.summary()
    both = mdr.press(mdr.Topography(ball(16), 1.0), body, body, indentation=0.02)
    assert "electrical_resistance" in both.data
    assert "no resistivity" not in both.summary()
    assert "no resistivity" not in mdr.press(mdr.Topography(ball(16), 1.0), UNIT, indentation=0.02).summary()


@needs_engine
@pytest.mark.parametrize(
    ("n", "force", "stiffness", "area"), [(64, 2e-4, 2e-3, 0.01), (128, 5e-5, 5e-4, 3e-3)]
)
def test_hertz(n, force, stiffness, area):
    a = 0.3
    heights = ball(n)
    pressed = mdr.press(mdr.Topography(heights, 1.0), UNIT, indentation=from_apex(heights, a**2))
    assert float(pressed["normal_force"][0]) == pytest.approx(4 / 3 * a**3, rel=force)
    assert float(pressed["normal_stiffness"][0]) == pytest.approx(2 * a, rel=stiffness)
    assert float(pressed["contact_area"][0]) == pytest.approx(math.pi * a**2, rel=area)
    assert float(pressed["elastic_energy"][0]) == pytest.approx(8 / 15 * a**5, rel=5 * force)
    x, y = grid(n)
    inside = np.hypot(x, y) < 0.9 * a
    exact = 2 / math.pi * np.sqrt(np.maximum(a**2 - x**2 - y**2, 0.0))
    assert np.max(np.abs(pressed.field("pressure").values - exact)[inside]) < 3e-3 * 2 * a / math.pi
    gap = pressed.field("gap").values
    assert gap.min() == 0.0
    assert np.all(gap[pressed.field("contact").values] == 0.0)
    # by the claims: the force counts from the highest pixel
    for name, true in (("normal_stiffness", 2 * a), ("contact_area", math.pi * a**2)):
        assert abs(float(pressed[name][0]) / true - 1) <= pressed.claims[name].error[0]


@needs_engine
@settings(max_examples=8, deadline=None)
@given(st.floats(-9, 3), st.floats(-6, 6), st.floats(3, 12), st.floats(0.1, 0.4), st.integers(30, 48))
def test_claims_hold_for_hertz_at_all_scales(size, slope, modulus, fraction, n):
    """The numbers differ from Hertz, counted from the highest pixel as from the apex, by no more than is claimed."""
    size, modulus = 10.0**size, 10.0**modulus
    radius = size * 10.0**slope
    body = mdr.Elastic(modulus, 0.0)
    heights = ball(n, radius, size)
    depth = (fraction * size) ** 2 / radius
    by_depth = mdr.press(mdr.Topography(heights, size), body, indentation=depth)
    true = {"normal_force": 4 / 3 * modulus * math.sqrt(radius) * depth**1.5}
    true |= {
        "normal_stiffness": 2 * modulus * fraction * size,
        "contact_area": math.pi * (fraction * size) ** 2,
    }
    for name, value in true.items():
        error = abs(float(by_depth[name][0]) / value - 1)
        assert error <= by_depth.claims[name].error[0] < 0.6
    force = float(by_depth["normal_force"][0])
    under_force = mdr.press(mdr.Topography(heights, size), body, normal_force=force)
    assert float(under_force["indentation"][0]) == pytest.approx(depth, rel=1e-5)
    assert float(under_force["normal_stiffness"][0]) == pytest.approx(
        float(by_depth["normal_stiffness"][0]), rel=2e-2
    )


@needs_engine
@settings(max_examples=4, deadline=None)
@given(st.integers(0, 2**32), st.floats(-4, -2), st.floats(1.5, 4.0))
@example(1, -3.5, 2.3)
def test_small_forces_one_after_the_other_are_as_each_alone(seed, least, ratio):
    """The contact of the force before, a few pixels, is even on itself: no reason to stop there."""
    surface = mdr.RoughSurface(0.5, 1e-3, 1.0, 1 / 8, seed=seed % 1000)
    patch = surface.topography(points=32)
    forces = 10.0**least * ratio ** np.arange(3) * 1e-3
    together = mdr.press(patch, UNIT, normal_force=forces, punch=True)
    for i, force in enumerate(forces.tolist()):
        alone = mdr.press(patch, UNIT, normal_force=force, punch=True)
        for name in ("indentation", "normal_stiffness"):
            assert float(together[name][i]) == pytest.approx(float(alone[name][0]), rel=1e-4)


@needs_engine
def test_elliptic_hertz():
    radii = 2.0, 1.0
    m = brentq(
        lambda m: (ellipe(m) / (1 - m) - ellipk(m)) / (ellipk(m) - ellipe(m)) - radii[0] / radii[1],
        1e-9,
        1 - 1e-9,
    )
    big, small = ellipk(m), ellipe(m)
    a = 0.35
    depth, b = a * a * m * big / (2 * radii[0] * (big - small)), a * math.sqrt(1 - m)
    x, y = grid(96)
    heights = -(x**2 / radii[0] + y**2 / radii[1]) / 2
    pressed = mdr.press(mdr.Topography(heights, 1.0), UNIT, indentation=from_apex(heights, depth))
    assert float(pressed["normal_force"][0]) == pytest.approx(2 * math.pi * a * depth / (3 * big), rel=3e-4)
    assert float(pressed["contact_area"][0]) == pytest.approx(math.pi * a * b, rel=0.01)
    # a flat ellipse has k = 2 pi E* a / (2 K) ... = pi a E* / K(m)
    assert float(pressed["normal_stiffness"][0]) == pytest.approx(math.pi * a / big, rel=2e-3)


@needs_engine
@pytest.mark.parametrize(("sides", "constant"), [(3, 0.8824), (4, 0.7377), (6, 0.6733), (8, 0.6558)])
def test_pyramids(sides, constant):
    """F/(E* d^2) from boundary elements of 256 x 256 cells, of a slope of 1 at the middles of the faces."""
    x, y = grid(97)
    turned = 0.1
    faces = [2 * math.pi * k / sides + turned for k in range(sides)]
    heights = -np.max([x * math.cos(f) + y * math.sin(f) for f in faces], axis=0)
    depth = 0.2 if sides == 3 else 0.3
    pressed = mdr.press(mdr.Topography(heights, 1.0), UNIT, indentation=depth, punch=True)
    assert float(pressed["normal_force"][0]) / depth**2 == pytest.approx(constant, rel=4e-3)
    assert not pressed.assumptions[0].met


@needs_engine
@settings(max_examples=examples(10), deadline=None)
@given(
    st.sampled_from([0, 4, 6]),
    st.floats(0.0, 6.3),
    st.floats(-0.5, 0.5),
    st.floats(-0.5, 0.5),
    st.integers(24, 40),
    st.floats(-9.0, 3.0),
)
@example(0, 0.0, 0.5, 0.5, 24, 0.0)
def test_claims_hold_for_sharp_tips_between_pixels(sides, turned, left, up, half, decades):
    """Depths count from the highest pixel, below an apex that nobody has seen; with the apex on a pixel little is claimed."""
    n, size = 2 * half + 1, 10.0**decades
    spacing = size / n
    faces = [2 * math.pi * k / max(sides, 1) + turned for k in range(sides)]
    force = 2 / math.pi if sides == 0 else {4: 0.7377, 6: 0.6733}[sides]
    depth = 0.3 * size
    for fraction in (1.0, 0.0):
        x = spacing * (np.arange(n) - half)[:, None] - fraction * left * spacing
        y = spacing * (np.arange(n) - half) - fraction * up * spacing
        if sides:
            heights = -np.max([x * math.cos(f) + y * math.sin(f) for f in faces], axis=0)
        else:
            heights = -np.hypot(x, y)
        pressed = mdr.press(mdr.Topography(heights, size), UNIT, indentation=depth, punch=True)
        computed = float(pressed["normal_force"][0]) / depth**2
        claimed = float(pressed.claims["normal_force"].error[0])
        rest = 0.5e-3 if sides else 0.0
        # where the flanks of a turned pyramid meet on the rows through a pixel is not quite as high as its apex
        assert abs(computed / force - 1) <= 1.2 * claimed + rest
    assert claimed < 5e-3


@needs_engine
@settings(max_examples=8, deadline=None)
@given(st.integers(0, 2**32), st.floats(0.02, 3.0), st.integers(9, 20))
def test_any_surface_against_the_solver_of_the_house(seed, fraction, n):
    """Boundary elements that share no code: pressures of random surfaces, from one pixel to full contact."""
    rng = np.random.default_rng(seed)
    heights = rng.standard_normal((n, n)) * rng.uniform(0, 1) + ball(n, rng.uniform(0.02, 1.0))
    depth = fraction * float(np.ptp(heights))
    house = make_surface(0.5, n, UNIT, mdr.Rigid())
    cell = float(house.side)
    pressure = solve_pressure(house, heights.max() - heights, depth, np.zeros((n, n)))
    pressed = mdr.press(mdr.Topography(heights, n * cell), UNIT, indentation=depth, punch=True)
    assert float(pressed["normal_force"][0]) == pytest.approx(cell**2 * pressure.sum(), rel=1e-4)
    difference = np.abs(pressed.field("pressure").values - pressure).max()
    assert difference < 1e-3 * pressure.max()


@needs_engine
def test_stiffness_is_the_slope_of_the_force():
    surface = mdr.RoughSurface(hurst=0.8, rms="1 um", size="1 mm", shortest="125 um", seed=3)
    depth = np.array([1.49e-6, 1.5e-6, 1.51e-6])
    pressed = mdr.press(surface, mdr.Elastic("1 GPa", 0.3), indentation=depth)
    force = pressed["normal_force"].values
    slope = (force[2] - force[0]) / (depth[2] - depth[0])
    assert float(pressed["normal_stiffness"][1]) == pytest.approx(slope, rel=5e-3)


@needs_engine
def test_deep_contact_is_a_punch():
    surface = mdr.RoughSurface(0.8, "1 um", "1 mm", "250 um").topography(points=32)
    pressed = mdr.press(surface, UNIT, indentation="1 mm", punch=True)
    assert float(pressed["normal_stiffness"][0]) == pytest.approx(1.15230e-3, rel=0.02)
    # without that word the body goes on where its heights end
    with pytest.raises(NotValidError, match="punch=True"):
        mdr.press(surface, UNIT, indentation="1 mm")["normal_force"]


@needs_engine
def test_a_contact_at_the_border_is_refused_where_it_is():
    heights = ball(32)
    pressed = mdr.press(mdr.Topography(heights, 1.0), UNIT, indentation=[0.05, 0.4])
    assert np.isfinite(pressed["normal_force"].values).tolist() == [True, False]
    assert pressed.field("pressure", 0).values.max() > 0
    with pytest.raises(NotValidError, match="border"):
        pressed.field("pressure", 1)


@needs_engine
def test_the_force_curve_stands_for_the_surface():
    heights = ball(48)
    depths = np.linspace(0.1, 1.0, 16) ** 2 * 0.12
    pressed = mdr.press(mdr.Topography(heights, 1.0), UNIT, indentation=from_apex(heights, depths))
    joint = mdr.Contact(pressed.force_curve(), UNIT, friction=mdr.Coulomb(0.3))
    paraboloid = mdr.Contact(mdr.Paraboloid(1.0), UNIT, friction=mdr.Coulomb(0.3))
    path = mdr.load(0.03, steps=4) >> mdr.shift(2e-3, steps=8)
    results, true = (mdr.solve(one, path) for one in (joint, paraboloid))
    assert results["tangential_force"].values == pytest.approx(
        true["tangential_force"].values, rel=5e-3, abs=1e-9
    )
    few = mdr.press(mdr.Topography(heights, 1.0), UNIT, indentation=[0.05, 0.1])
    with pytest.raises(PathError, match="at least 5"):
        few.force_curve()


@needs_engine
@settings(max_examples=8, deadline=None)
@given(st.integers(0, 2**32), st.lists(st.floats(1e-3, 0.5), min_size=1, max_size=4), st.booleans())
def test_a_saved_surface_comes_back(tmp_path_factory, seed, loads, by_force):
    """Loads at which the contact reaches the border among them."""
    file = tmp_path_factory.mktemp("pressed") / "press.nc"
    heights = ball(16) + 1e-3 * np.random.default_rng(seed).standard_normal((16, 16))
    surface = mdr.Topography(heights, ("1 mm", "2 mm"), steps=("made",))
    name = "normal_force" if by_force else "indentation"
    pressed = mdr.press(surface, mdr.Elastic(1e6, 0.3), **{name: np.array(loads)})
    pressed.save(file)
    again = mdr.open_pressed_surface(file)
    assert again.data.identical(pressed.data)
    assert again.summary() == pressed.summary()
    assert again.surface == pressed.surface
    assert again.assumptions == pressed.assumptions
    assert again.claims.keys() == pressed.claims.keys()
    for quantity, claim in pressed.claims.items():
        assert (again.claims[quantity].level, again.claims[quantity].reason) == (claim.level, claim.reason)
        assert np.array_equal(again.claims[quantity].where, claim.where)
        assert (again.claims[quantity].error is None) == (claim.error is None)
        assert claim.error is None or np.array_equal(again.claims[quantity].error, claim.error)
    for mine, saved in zip(pressed.maps, again.maps, strict=True):
        assert all(np.array_equal(*pair) for pair in zip(mine, saved, strict=True))


@needs_engine
def test_what_is_no_pressed_surface_is_not_opened(tmp_path):
    pressed = mdr.press(mdr.Topography(ball(16), 1.0), UNIT, indentation=0.05)
    with pytest.raises(FileError, match=r"\.nc"):
        pressed.save(tmp_path / "press.txt")
    ball_file = tmp_path / "ball.nc"
    mdr.solve(mdr.Contact(mdr.Sphere(1.0), UNIT), mdr.indent(0.01, steps=3)).save(ball_file)
    with pytest.raises(FileError, match="not a pressed surface"):
        mdr.open_pressed_surface(ball_file)
    pressed.save(tmp_path / "press.nc")
    with pytest.raises(FileError, match="not a pymdr result"):
        mdr.open_result(tmp_path / "press.nc")
    whole = read_dataset(tmp_path / "press.nc")
    for damaged in (
        whole.drop_vars("heights"),
        whole.drop_vars("pressure"),
        whole.drop_vars("normal_stiffness"),
        whole.assign_attrs(pymdr_metadata="{}"),
        whole.assign_attrs(pymdr_metadata=whole.attrs["pymdr_metadata"].replace("true", "true, true")),
    ):
        write_dataset(damaged, tmp_path / "damaged.nc")
        with pytest.raises(FileError, match="damaged pressed surface"):
            mdr.open_pressed_surface(tmp_path / "damaged.nc")


class EndedError(Exception):
    pass


@needs_engine
def test_a_run_that_was_ended_goes_on(tmp_path):
    surface = mdr.Topography(ball(24), 1.0)
    loads = [0.08, 0.02, 0.05]
    whole = mdr.press(surface, UNIT, indentation=loads)
    reports = []

    def end(done, total):
        reports.append((done, total))
        if done >= 10:
            raise EndedError

    with pytest.raises(EndedError):
        mdr.press(surface, UNIT, indentation=loads, keep=tmp_path / "run", progress=end)
    assert sorted(p.name for p in (tmp_path / "run").iterdir()) == [
        "parts-000000001.nc",
        "parts-000000002.nc",
    ]
    assert reports == [(4, 15), (5, 15), (9, 15), (10, 15)]
    reports.clear()
    after = mdr.press(
        surface, UNIT, indentation=loads, keep=tmp_path / "run", progress=lambda *now: reports.append(now)
    )
    assert reports == [(5, 15), (10, 15), (14, 15), (15, 15)]
    assert after.data.identical(whole.data)
    assert np.array_equal(after.field("pressure", 0), whole.field("pressure", 0))
    with pytest.raises(FileError, match="another computation"):
        mdr.press(mdr.Topography(ball(24, 2.0), 1.0), UNIT, indentation=loads, keep=tmp_path / "run")
    with pytest.raises(FileError, match="another computation"):
        mdr.press(surface, UNIT, indentation=0.08, keep=tmp_path / "run")
    damaged = tmp_path / "run" / "parts-000000000.nc"
    damaged.write_bytes(damaged.read_bytes()[:200])
    with pytest.raises(FileError, match="cannot read"):
        mdr.press(surface, UNIT, indentation=loads, keep=tmp_path / "run")


def test_what_is_refused_before_it_starts(monkeypatch):
    heights = ball(16)
    holes = heights.copy()
    holes[3, 4] = np.nan
    surface = mdr.Topography(heights, 1.0)
    for wrong, words in (
        (
            lambda: mdr.press(mdr.Topography(holes, 1.0), UNIT, indentation=0.1),
            "1 of 256 heights are missing",
        ),
        (lambda: mdr.press(mdr.Topography(heights[:4], 1.0), UNIT, indentation=0.1), "4 x 16 heights"),
        (lambda: mdr.press(mdr.Sphere(1.0), UNIT, indentation=0.1), "is not a Topography"),
        (lambda: mdr.press(surface, UNIT), "exactly one"),
        (lambda: mdr.press(surface, UNIT, indentation=-0.1), "must be above 0"),
        (
            lambda: mdr.press(surface, UNIT, normal_force=[1.0, 1e300]),
            r"normal_force = 1e\+300 N.* at most 1e\+60 N; check the unit",
        ),
        (lambda: mdr.press(surface, UNIT, indentation=1e-300), "indentation = 1e-300 m.* at least 1e-60 m"),
        (lambda: mdr.press(surface, UNIT, indentation=0.1, engine="none"), "is unknown; give one of"),
        (lambda: mdr.press(surface, UNIT, indentation=0.1, engine=3), "is not an engine"),
        (
            lambda: mdr.press(surface, mdr.Viscoelastic(mdr.Maxwell("1 MPa", "1 s"), 0.5), indentation=0.1),
            "Viscoelastic",
        ),
    ):
        with pytest.raises(ProblemError, match=words):
            wrong()
    monkeypatch.setattr(solving, "memory_of_machine", lambda: 1e5)
    with pytest.raises(ProblemError, match=r"16 x 16 pixels at 1 loads need about .*limit"):
        mdr.press(surface, UNIT, indentation=0.1)
    assert bytes_of((1000, 1000), 10) > 5e8


@settings(max_examples=examples(20), deadline=None)
@given(
    st.floats(0.05, 1.0), st.integers(4, 12), st.integers(0, 99), st.sampled_from([(1.0, 1.0), (2.0, 1.0)])
)
def test_realised_surfaces_have_their_spectrum(hurst, waves, number, size):
    surface = mdr.RoughSurface(hurst, 1e-3, size, 2.0 / waves if size[0] > 1 else 1.0 / waves)
    coarse, fine = (surface.topography(number, points=k * waves * 4) for k in (1, 2))
    assert fine.heights.std() == pytest.approx(1e-3, rel=1e-12)
    # the same waves on both grids
    assert np.fft.rfft2(fine.heights, norm="forward")[1, 1] == pytest.approx(
        np.fft.rfft2(coarse.heights, norm="forward")[1, 1], rel=1e-9
    )
    power = np.abs(np.fft.fft2(fine.heights, norm="forward")) ** 2
    kx, ky = (
        2 * math.pi * np.fft.fftfreq(n, d) for n, d in zip(fine.heights.shape, fine.spacing, strict=True)
    )
    q = np.hypot(kx[:, None], ky)
    density = surface.spectrum_2d(q)
    density[0, 0] = 0.0
    fraction = power / power.sum()
    assert fraction == pytest.approx(density / density.sum(), rel=1e-9, abs=1e-12)


def test_realised_surfaces_are_refused():
    surface = mdr.RoughSurface(0.8, "1 um", "1 mm", "100 um")
    for name, wrong, needed in (
        ("points", 39, "at least 40"),
        ("points", -1, "a whole number"),
        ("realisation", 1.5, "a whole number"),
    ):
        with pytest.raises(ProblemError, match=rf"^{name} = {wrong}; {needed}"):
            surface.topography(**{name: wrong})
    assert surface.topography().heights.shape == (80, 80)


class Punch:
    """An engine of its own: half-spaces of independent springs."""

    name = "springs"
    version = "springs 1"

    def bytes_for(self, shape):
        return 8.0

    def half_space(self, shape, spacing):
        return self

    def press(self, heights, *, indentation=None, force=None, start=None, tolerance=1e-6):
        overlap = indentation - (heights.max() - heights)
        return Pressing(np.maximum(overlap, 0.0), np.maximum(-overlap, 0.0), indentation, 1)


def test_engines_are_discovered_by_entry_point(monkeypatch):
    class Point:
        name = "springs"

        def load(self):
            return Punch

    monkeypatch.setattr(
        engines_of, "entry_points", lambda group: [Point()] if group == "pymdr.engines" else []
    )
    assert engine_names() == ("contactmechanics", "tamaas", "aspher", "springs")
    result = mdr.press(mdr.Topography(ball(16), 16.0), UNIT, indentation=0.1, engine="springs", punch=True)
    assert result.data.attrs["engine"] == "springs 1"
    assert float(result["normal_force"][0]) > 0
    text = result.summary()
    assert "springs 1, 16 x 16 pixels" in text
    assert "stiffness" in text
    figure = result.plot()
    assert len(figure.axes) == 6


def test_a_missing_package_names_its_extra(monkeypatch):
    import sys

    for package, extra in (("ContactMechanics", "rough"), ("tamaas", "tamaas"), ("aspher", "aspher")):
        monkeypatch.setitem(sys.modules, package, None)
        with pytest.raises(MissingExtraError, match=extra):
            mdr.press(mdr.Topography(ball(16), 1.0), UNIT, indentation=0.1, engine=package.lower())


@pytest.mark.parametrize("name", ["tamaas", "aspher"])
def test_peers_agree(name):
    if importlib.util.find_spec(name) is None:
        pytest.skip(f"{name} is not installed")
    heights = ball(32)
    half_space = find_engine(name).half_space((32, 32), (1.0, 1.0))
    result = half_space.press(heights, indentation=0.09)
    house = make_surface(0.5, 32, UNIT, mdr.Rigid())
    pressure = solve_pressure(house, heights.max() - heights, 0.09, np.zeros((32, 32)))
    assert result.pressure.sum() == pytest.approx(pressure.sum() / 32.0, rel=1e-4)
    assert half_space.press(heights, force=float(result.pressure.sum())).indentation == pytest.approx(
        0.09, rel=1e-5
    )


@needs_engine
@pytest.mark.parametrize("seed", range(8))
def test_tamaas_on_rough_surfaces(seed):
    """Depths, from a single pixel to all of them, as ContactMechanics has them; a second load does not depend on the first."""
    pytest.importorskip("tamaas", reason="tamaas is not installed")
    rng = np.random.default_rng(seed)
    q = np.hypot(*np.meshgrid(np.fft.fftfreq(24), np.fft.fftfreq(24)))
    q[0, 0] = np.inf
    heights = np.fft.ifft2(np.fft.fft2(rng.standard_normal(q.shape)) * q ** -rng.uniform(1.3, 2.0)).real
    heights *= 10 ** rng.uniform(-9, 0) / np.ptp(heights)
    ours, other = (
        find_engine(name).half_space((24, 24), (1.0, 1.0)) for name in ("tamaas", "contactmechanics")
    )
    for fraction in (1e-3, 0.3, 3.0, 1e-3):
        depth = fraction * float(np.ptp(heights))
        result, known = ours.press(heights, indentation=depth), other.press(heights, indentation=depth)
        assert result.indentation == pytest.approx(depth, rel=1e-5)
        assert result.pressure.sum() == pytest.approx(known.pressure.sum(), rel=1e-5)
        by_force = ours.press(heights, force=float(known.pressure.sum()))
        assert by_force.indentation == pytest.approx(depth, rel=1e-5)


def test_what_tamaas_ends_without_a_number_has_a_remedy(monkeypatch):
    tamaas = pytest.importorskip("tamaas", reason="tamaas is not installed")
    half_space = find_engine("tamaas").half_space((32, 32), (1.0, 1.0))

    def ended(*args):
        raise tamaas.FloatingPointError("NaN")

    monkeypatch.setattr(type(half_space), "_solved", ended)
    with pytest.raises(ConvergenceError, match=r"at a force of 0\.1: NaN; use the engine contactmechanics"):
        half_space.press(ball(32), force=0.1)


def test_what_an_engine_did_not_solve_is_refused():
    pressure, gap = np.array([[1.0, 0.0]]), np.array([[0.0, 1.0]])
    refuse_unsolved("engine", Pressing(pressure, gap, 1.0, 3), 1e-6)
    for wrong in (
        Pressing(pressure, gap - 1e-5, 1.0, 3),
        Pressing(-pressure, gap, 1.0, 3),
        Pressing(0.0 * pressure, gap, 1.0, 3),
        Pressing(pressure * np.nan, gap, 1.0, 3),
    ):
        with pytest.raises(ConvergenceError, match="engine did not converge in 3 iterations"):
            refuse_unsolved("engine", wrong, 1e-6)


@settings(max_examples=examples(50), deadline=None)
@given(st.floats(0.3, 3.0), st.floats(-8, 8), st.floats(-8, 8))
def test_indentations_by_force(exponent, depth, first):
    def press(force):
        d = force ** (1 / exponent) * (1 + 0.2 * math.tanh(math.log(force)))
        return Pressing(np.ones((1, 1)), np.zeros((1, 1)), d, 1)

    reached = []

    def press_near(force, tolerance):
        reached.append(tolerance)
        return press(force)

    result = by_force(press_near, 10.0**depth, 10.0**first, 1e-9)
    assert reached[-1] == 1e-9
    assert result.indentation == pytest.approx(10.0**depth, rel=1e-8)


@needs_engine
@pytest.mark.parametrize("step", [7, -2, True, "last"])
def test_loads_that_are_not_there(step):
    heights = mdr.RoughSurface(hurst=0.8, rms="1 um", size="1 mm", shortest="0.25 mm")
    result = mdr.press(heights, mdr.Elastic("1 GPa", 0.3), normal_force="1 N")
    for ask in (result.plot, lambda step: result.field("pressure", step)):
        with pytest.raises(mdr.QuantityError, match="there are 1 loads, counted from 0"):
            ask(step)


@needs_engine
def test_the_error_of_a_pressed_surface_is_in_its_curve_and_tables(tmp_path):
    surface = mdr.RoughSurface(hurst=0.8, rms="1 um", size="1 mm", shortest="250 um", seed=3)
    body = mdr.Elastic("1 GPa", 0.0)
    pressed = mdr.press(surface, body, indentation=np.linspace(0.3, 1.4, 7) ** 2 * 1e-6)
    claimed = pressed.claims["normal_force"].error
    curve = pressed.force_curve()
    assert np.array_equal(curve.error, claimed)
    solved = mdr.solve(mdr.Contact(curve, body), mdr.Path(indentation=curve.indentation[2:]))
    for name in ("normal_force", "normal_stiffness", "elastic_energy"):
        assert np.all(solved.claims[name].error >= claimed[2:])
    pressed.to_csv(tmp_path / "press.csv")
    assert "normal_force [N],normal_force_error" in (tmp_path / "press.csv").read_text()
    assert mdr.read_force_curve(tmp_path / "press.csv", modulus=curve.modulus).error == pytest.approx(claimed)
    by_force = mdr.press(surface, body, normal_force=pressed["normal_force"].values).force_curve()
    assert np.all(by_force.error > 0.5 * claimed)
    pressed.save(tmp_path / "press.nc")
    assert mdr.open_pressed_surface(tmp_path / "press.nc").force_curve() == curve
    line = mdr.rough_line(surface, body).force_curve(indentation="1 um")
    assert mdr.solve(mdr.Contact(line, body), mdr.indent("0.5 um")).claims["normal_force"].error is None


@needs_engine
def test_figures_draw_the_largest_valid_load():
    surface = mdr.Topography(ball(24), 1.0)
    some = mdr.press(surface, UNIT, indentation=[0.02, 0.05, 0.03, 0.6])
    assert some.plot().axes[0].get_title() == "depth 50 mm, load 2 of 4"
    assert some.plot(2).axes[0].get_title() == "depth 30 mm, load 3 of 4"
    none = mdr.press(surface, UNIT, indentation=[0.6, 0.7])
    assert "border" in none.plot().texts[0].get_text()
    with pytest.raises(NotValidError, match="border"):
        none.force_curve()


@needs_engine
@settings(max_examples=6, deadline=None)
@given(st.integers(0, 2**32), st.floats(1e-3, 0.3), st.floats(-9, 3))
def test_a_mean_pressure_is_not_above_the_peak(seed, fraction, decades):
    """From one pixel on."""
    rng, size = np.random.default_rng(seed), 10.0**decades
    heights = size * (rng.standard_normal((12, 12)) * rng.uniform(0, 0.1) + ball(12, rng.uniform(0.02, 1.0)))
    pressed = mdr.press(
        mdr.Topography(heights, size), UNIT, indentation=fraction * float(np.ptp(heights)), punch=True
    )
    assert float(pressed["mean_pressure"][0]) <= float(pressed["peak_pressure"][0]) * (1.0 + 1e-12)


def test_memory_is_checked_before_heights_are_made(monkeypatch):
    from pymdr.problem import rough

    def never(*_):
        raise AssertionError

    monkeypatch.setattr(rough, "_heights", never)
    huge = mdr.RoughSurface(0.8, "1 um", "1 m", "1 um")
    with pytest.raises(ProblemError, match=r"8000000 x 8000000 pixels .* longer shortest wavelength"):
        huge.topography()
    with pytest.raises(
        ProblemError, match=r"8000000 x 8000000 pixels at 1 loads .* longer shortest wavelength"
    ):
        mdr.press(huge, UNIT, indentation="1 um")


@needs_engine
@settings(max_examples=examples(5), deadline=None)
@given(
    st.floats(1e-10, 1e-6), st.floats(1.0, 500.0), st.floats(1e-9, 1e-3), st.booleans(), st.floats(1e-12, 1e-9)
)  # fmt: skip
def test_conduction_through_a_pressed_surface(tmp_path_factory, resistivity, conductivity, other, same, size):
    """That of Hertz's disk within the error of the stiffness; kept in files; none of a body that does not conduct."""
    ratio = 1.0 if same else other
    bodies = [
        mdr.Elastic("100 GPa", 0.3, thermal_conductivity=conductivity * k, resistivity=resistivity / k)
        for k in (1.0, ratio)
    ]
    surface = mdr.Topography(ball(64, 1e3 * size, size), size)
    pressed = mdr.press(surface, *bodies, indentation=[4e-5 * size, 8e-5 * size])
    length = pressed["normal_stiffness"].values / (2.0 * pressed.data.attrs["modulus"])
    # in series on both sides: 2 a over the sum of the resistivities' halves
    through = 4.0 * length * conductivity * ratio / (1.0 + ratio)
    assert pressed["thermal_conductance"].values == pytest.approx(through, rel=1e-12)
    assert pressed["electrical_resistance"].values == pytest.approx(
        (1.0 + 1.0 / ratio) * resistivity / (4.0 * length), rel=1e-12
    )
    radius = np.sqrt(1e3 * size * pressed["indentation"].values)
    error = pressed.claims["thermal_conductance"].error
    assert np.abs(length / radius - 1.0).max() < 0.02
    assert error == pytest.approx(pressed.claims["normal_stiffness"].error)
    file = tmp_path_factory.mktemp("p") / "p.nc"
    pressed.save(file)
    again = mdr.open_pressed_surface(file)
    assert again["electrical_resistance"].values.tolist() == pressed["electrical_resistance"].values.tolist()
    pressed.to_csv(file.with_suffix(".csv"))
    assert "thermal_conductance_error" in file.with_suffix(".csv").read_text().splitlines()[0]
    bare = mdr.press(surface, bodies[0], indentation=8e-5 * size)
    assert bare.claims["electrical_resistance"].level.name == "NOT_VALID"
    assert (
        "electrical_resistance"
        not in mdr.press(surface, mdr.Elastic("1 GPa", 0.3), indentation=8e-5 * size).data
    )
