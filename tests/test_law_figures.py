"""Figures of adhesion and friction show what the results hold."""

import math

import numpy as np
import pytest

import pymdr as mdr

GEL = mdr.Elastic("30 kPa", 0.5)
STEEL = mdr.Elastic("210 GPa", 0.3)
TIP = mdr.Paraboloid("50 um")
THERE_AND_BACK = mdr.indent("1 um", steps=20) >> mdr.indent("-3 um", steps=80)


def labels(figure):
    return [(axes.get_xlabel(), axes.get_ylabel()) for axes in figure.axes]


def drawn(axes, name):
    return next(line for line in axes.lines if line.get_label() == name).get_xydata()


@pytest.mark.parametrize(
    "law", [mdr.JKR("2 mJ/m^2"), mdr.MaugisDugdale("2 mJ/m^2", range="100 nm"), mdr.DMT("2 mJ/m^2")]
)
def test_adhesive_figures(law):
    result = mdr.solve(mdr.Contact(TIP, GEL, adhesion=law), THERE_AND_BACK)
    figures = result.figures()
    assert sorted(figures) == ["fields", "loop", "radius"]
    loop = figures["loop"].axes[0]
    assert labels(figures["loop"]) == [("indentation $d$ (um)", "normal force $F_N$ (nN)")]
    path = drawn(loop, "path")
    np.testing.assert_allclose(path[:, 0] * 1e-6, result["indentation"].values, rtol=1e-12, atol=1e-18)
    np.testing.assert_allclose(path[:, 1] * 1e-9, result["normal_force"].values, rtol=1e-12, atol=1e-20)
    # the stable path lies on the curve of all equilibria
    branch = drawn(loop, "all equilibria")
    in_contact = result["contact_radius"].values > 0
    top = branch[np.argmin(branch[:, 1]) :]
    rising = np.maximum.accumulate(top[:, 0]) == top[:, 0]
    near = np.interp(path[in_contact, 0], top[rising, 0], top[rising, 1])
    assert np.max(np.abs(near - path[in_contact, 1])[path[in_contact, 0] > 0]) < 1e-3 * np.ptp(path[:, 1])
    assert len(result.plot().axes) == 3


def test_travel_is_drawn_beside_the_indentation():
    contact = mdr.Contact(TIP, GEL, adhesion=mdr.JKR("2 mJ/m^2"))
    path = mdr.travel("2 um", steps=10) >> mdr.travel("-20 um", steps=40)
    figure = mdr.solve(contact, path, machine_stiffness="0.05 N/m").figures()["loop"]
    assert [x for x, _ in labels(figure)] == ["travel of the machine $D$ (um)", "indentation $d$ (um)"]


@pytest.mark.parametrize(
    "path",
    [
        mdr.load("0 N") >> mdr.load("-1 uN", steps=20),
        mdr.indent("-1 um", steps=3),
        mdr.indent("1 um"),
    ],
)
def test_lost_untouched_and_single_rows_are_drawn(path):
    result = mdr.solve(mdr.Contact(TIP, GEL, adhesion=mdr.JKR("2 mJ/m^2")), path)
    for figure in (result.plot(), *result.figures().values()):
        figure.canvas.draw()


def test_flat_punch_with_adhesion_is_drawn():
    result = mdr.solve(
        mdr.Contact(mdr.FlatPunch("10 um"), GEL, adhesion=mdr.JKR("2 mJ/m^2")),
        mdr.indent("1 um", steps=10) >> mdr.indent("-3 um", steps=40),
    )
    for figure in (result.plot(), *result.figures().values()):
        figure.canvas.draw()


@pytest.mark.parametrize("mu", [0.0, 0.3, math.inf])
def test_frictional_figures(mu):
    contact = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(mu))
    result = mdr.solve(contact, mdr.load("50 N", steps=5) >> mdr.cycle(shift="0.5 um", steps=40))
    figures = result.figures()
    assert sorted(figures) == ["energies", "loop", "section", "tractions"]
    loop = figures["loop"].axes[0]
    force, unit = result["tangential_force"].values, loop.get_ylabel().rpartition("(")[2].rstrip(")")
    np.testing.assert_allclose(
        loop.lines[0].get_ydata(), result.to("tangential_force", unit).values, rtol=1e-12, atol=1e-12
    )
    assert force.size == 45
    for figure in (result.plot(), *figures.values()):
        figure.canvas.draw()


def test_long_histories_are_thinned_with_their_extremes():
    contact = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(0.3))
    n = 300_000
    path = mdr.Path(indentation=np.full(n, 2e-6), shift=4e-7 * np.sin(np.arange(n) * 0.1))
    result = mdr.solve(contact, path)
    line = result.figures()["loop"].axes[0].lines[0]
    assert line.get_xdata().size < 25_000
    assert max(line.get_ydata()) == result["tangential_force"].values.max()


def test_loop_study():
    contact = mdr.Contact(mdr.Paraboloid("10 mm"), STEEL, STEEL, friction=mdr.Coulomb(0.3))
    figure = mdr.friction_loop(contact, np.geomspace(1e-8, 1e-6, 20), normal_force="50 N").plot()
    assert [y for _, y in labels(figure)] == [
        "energy lost per cycle (uJ)",
        "damping ratio",
        "secant stiffness (MN/m)",
    ]


def test_saved_results_draw_the_same():
    result = mdr.solve(mdr.Contact(TIP, GEL, adhesion=mdr.JKR("2 mJ/m^2")), THERE_AND_BACK)
    import pickle

    again = pickle.loads(pickle.dumps(result))
    one, other = (drawn(r.figures()["loop"].axes[0], "all equilibria") for r in (result, again))
    np.testing.assert_array_equal(one, other)
