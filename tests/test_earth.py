"""Normal gravity against values of the WGS 84 ellipsoid."""

from __future__ import annotations

from math import pi, radians

import pytest
from numpy.testing import assert_allclose

from budget import earth


@pytest.mark.parametrize(
    ("latitude", "printed"),
    [
        (0.0, "9.7803253359"),
        (34.2394, "9.7966933092"),
        (45.0, "9.8061977694"),
        (90.0, "9.8321849379"),
    ],
)
def test_normal_gravity_is_that_of_wgs84(latitude, printed):
    """Normal gravity agrees with WGS 84 to the last digit of ten."""
    assert_allclose(
        earth.normal_gravity(radians(latitude)), float(printed), rtol=0, atol=1e-10
    )


def test_normal_gravity_is_the_same_on_both_hemispheres():
    """A southern latitude has the gravity of the northern one."""
    assert earth.normal_gravity(-0.6) == earth.normal_gravity(0.6)


def test_sidereal_day():
    """One turn at the rotation rate takes a sidereal day of 86164.1 s."""
    assert_allclose(2.0 * pi / earth.ROTATION_RATE, 86164.1, rtol=1e-6)


def test_the_gradients_are_those_of_the_formula():
    """Differences of normal gravity itself: 0.3086 mGal a metre, 1.4 mGal an arcmin."""
    L, h = radians(34.2394), 1600.0
    up = (earth.normal_gravity(L, h + 10.0) - earth.normal_gravity(L, h - 10.0)) / 20.0
    assert_allclose(earth.gravity_by_height(L, h), up, rtol=1e-8)
    assert_allclose(up, -0.3086e-5, rtol=1e-3)
    north = earth.normal_gravity(L + 1e-4, h) - earth.normal_gravity(L - 1e-4, h)
    assert_allclose(earth.gravity_by_latitude(L, h), north / 2e-4, rtol=1e-7)
    assert_allclose(north / 2e-4 * radians(1.0 / 60.0), 1.4e-5, rtol=1e-2)
