"""Earth rotation rate and normal gravity."""

from __future__ import annotations

from math import sin, sqrt

ROTATION_RATE = 7.292115e-5  # [rad/s], WGS 84

EQUATORIAL_GRAVITY = 9.7803253359  # normal gravity at the equator [m/s^2], WGS 84
GRAVITY_CONSTANT = 0.00193185265241  # k = b g_pole / (a g_equator) - 1 [1], WGS 84
ECCENTRICITY_SQUARED = 0.00669437999014  # first eccentricity squared [1], WGS 84


def normal_gravity(latitude: float) -> float:
    """Return normal gravity on the ellipsoid of WGS 84.

    The closed formula of Somigliana, g = g_e (1 + k sin^2 L) / sqrt(1 - e^2 sin^2 L),
    with the constants of WGS 84. Height is not in it: 3 m up, g falls by 1e-6 of
    itself.

    Parameters
    ----------
    latitude : float
        Geodetic latitude [rad].

    Returns
    -------
    float
        Normal gravity [m/s^2].
    """
    s2 = sin(latitude) ** 2
    numerator = EQUATORIAL_GRAVITY * (1.0 + GRAVITY_CONSTANT * s2)
    return numerator / sqrt(1.0 - ECCENTRICITY_SQUARED * s2)
