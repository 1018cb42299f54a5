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
