"""The track of a mission: its ellipses against linear algebra, its words and marks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from figure_text import crossed_texts, cut_texts, texts
from numpy.testing import assert_allclose
from reading import assert_says
from scipy.stats import chi2

from budget.inputs import load_mission
from budget.report.figures.track import (
    Ellipse,
    Way,
    track_of,
    track_plot,
)

COVARIANCES = (
    [[4.0, 1.5], [1.5, 1.0]],
    [[1.0, -0.9], [-0.9, 2.0]],
    [[2.0, 0.0], [0.0, 5.0]],
    [[1.0, 1.0], [1.0, 1.0]],
    [[3.0, 0.0], [0.0, 3.0]],
)


def ellipse(covariance, time=60.0, centre=(0.0, 0.0), coverage=0.95):
    """Return the ellipse of a covariance."""
    return Ellipse.of(time, np.array(centre), np.array(covariance), coverage)


@pytest.mark.parametrize("covariance", COVARIANCES)
def test_half_axes_are_those_of_an_eigen_decomposition(covariance):
    """Roots of eigenvalues times that of chi-squared, along the eigenvectors."""
    one = ellipse(covariance)
    values, vectors = np.linalg.eigh(covariance)
    k = np.sqrt(chi2.ppf(0.95, 2))
    expected = k * np.sqrt(np.maximum(values[::-1], 0.0))
    assert_allclose([one.major, one.minor], expected, rtol=1e-9, atol=1e-7)
    if one.major > one.minor:
        along = np.array([np.cos(one.bearing), np.sin(one.bearing)])
        assert_allclose(abs(along @ vectors[:, 1]), 1.0, rtol=1e-9)


def test_the_outline_holds_the_coverage():
    """Every point of it is as far off as chi-squared says, in units of the spread."""
    C = np.array(COVARIANCES[0])
    off = ellipse(C, centre=(10.0, -5.0)).outline() - (10.0, -5.0)
    squares = np.einsum("ni,ij,nj->n", off, np.linalg.inv(C), off)
    assert_allclose(squares, chi2.ppf(0.95, 2), rtol=1e-9)


def test_trials_lie_within_the_ellipse_as_often_as_it_says():
    """Of 40 000 draws 80 % are inside the ellipse of 80 %."""
    C = np.array(COVARIANCES[1])
    one = ellipse(C, coverage=0.8)
    drawn = np.random.default_rng(1).multivariate_normal((0.0, 0.0), C, 40_000)
    c, s = np.cos(one.bearing), np.sin(one.bearing)
    along, across = drawn @ (c, s), drawn @ (-s, c)
    inside = (along / one.major) ** 2 + (across / one.minor) ** 2 <= 1.0
    assert_allclose(inside.mean(), 0.8, atol=0.01)


def way(sigma, name="car-drive"):
    """Return a track with round errors of that size at its middle and its end."""
    clock, track = track_of(load_mission(name).route)
    C = sigma**2 * np.array([[2.0, 0.6], [0.6, 1.0]])
    found = tuple(
        ellipse(part * C, time, [np.interp(time, clock, one) for one in track.T])
        for part, time in ((0.2, clock[-1] / 2.0), (1.0, clock[-1]))
    )
    return Way(track=track, ellipses=found, coverage=0.95)


def test_a_track_is_as_long_as_its_route():
    """The sum of its moves is the way that the route says."""
    route = load_mission("uav-figure-8").route
    clock, track = track_of(route)
    assert clock[-1] == pytest.approx(route.duration)
    moves = np.linalg.norm(np.diff(track, axis=0), axis=1)
    assert moves.sum() == pytest.approx(route.outline.length, rel=1e-3)


def test_small_errors_are_enlarged_and_it_is_said_how_much():
    """Of a metre on a drive of kilometres; of a kilometre the ellipse is to scale."""
    small, large = way(1.0), way(1000.0)
    assert small.times > 10.0
    assert large.times == 1.0
    assert_says(
        track_plot(small).picture.caption,
        f"enlarged {small.times:g} times against the track",
    )
    assert_says(track_plot(large).picture.caption, "to scale")


def test_it_says_its_numbers_and_which_way_is_north():
    """Half axes and bearing are in the words and in the table; north is up."""
    picture = track_plot(way(100.0)).picture
    last = way(100.0).ellipses[-1]
    assert_says(picture.title, "half axes", "from north")
    assert f"{np.degrees(last.bearing):.0f} deg" in picture.alt
    assert len(picture.data.groups[0].rows) == 2
    assert "north is up" in texts(track_plot(way(100.0)).figure)
    for gid in picture.tips:
        assert picture.svg.count(f' id="{picture.name}-{gid}"') == 1


def test_north_is_up_and_east_is_right():
    """What is drawn across is east, and up is north, on one scale."""
    figure = track_plot(way(100.0)).figure
    (axes,) = figure.axes
    x, y = axes.lines[0].get_data()
    assert_allclose(np.column_stack([y, x]), way(100.0).track)
    box = axes.get_window_extent()
    across, up = np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim())
    assert across / box.width == pytest.approx(up / box.height, rel=1e-6)


@pytest.mark.parametrize("sigma", [1.0, 100.0, 1e4])
@pytest.mark.parametrize("name", ["car-drive", "ship", "bench"])
def test_its_texts_stand_apart(name, sigma):
    """None is cut, and no name lies on another one."""
    figure = track_plot(way(sigma, name)).figure
    assert cut_texts(figure) == []
    assert [pair for pair in crossed_texts(figure) if pair[1] != "line"] == []


def test_nothing_known_is_no_track():
    """Without a time that is asked for there is none."""
    assert Way.of(load_mission("bench").route, _Nothing(), (), 0.95) is None


class _Nothing:
    """A curve without times."""

    times = ()
    covariance = np.zeros((1, 0, 9, 9))
    mixture = None


def test_a_round_ellipse_has_no_long_axis():
    """Its bearing is a dash; what lacks makes all of it this or more."""
    one = ellipse(np.eye(2))
    more = replace(way(1.0), ellipses=(replace(one, is_more=True),))
    (row,) = track_plot(more).picture.data.groups[0].rows
    assert row[3].text == "-"
    assert row[1].text == "\N{GREATER-THAN OR EQUAL TO} 2.4"
    assert "\N{GREATER-THAN OR EQUAL TO} 2.4 m" in track_plot(more).picture.title
