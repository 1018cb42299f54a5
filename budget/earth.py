"""Earth rotation rate and normal gravity."""

from __future__ import annotations

from math import cos, sin, sqrt

ROTATION_RATE = 7.292115e-5  # [rad/s], WGS 84

EQUATORIAL_GRAVITY = 9.7803253359  # normal gravity at the equator [m/s^2], WGS 84
GRAVITY_CONSTANT = 0.00193185265241  # k = b g_pole / (a g_equator) - 1 [1], WGS 84
ECCENTRICITY_SQUARED = 0.00669437999014  # first eccentricity squared [1], WGS 84
SEMI_MAJOR_AXIS = 6378137.0  # a [m], WGS 84
FLATTENING = 1.0 / 298.257223563  # f [1], WGS 84
CENTRIFUGAL_RATIO = 0.00344978650684  # m = w^2 a^2 b/GM [1], WGS 84


def normal_gravity(latitude: float, height: float = 0.0) -> float:
    """Return normal gravity of WGS 84.

    On the ellipsoid the closed formula of Somigliana, g = g_e (1 + k sin^2 L) / sqrt(1
    - e^2 sin^2 L); above it times 1 - 2/a (1 + f + m - 2 f sin^2 L) h + 3 h^2/a^2
    (NIMA TR8350.2, eq. (4-3)): 3 m up, g falls by 1e-6 of itself, 100 m up by 31.5e-6.

    Parameters
    ----------
    latitude : float
        Geodetic latitude [rad].
    height : float
        Above the ellipsoid [m].

    Returns
    -------
    float
        Normal gravity [m/s^2].
    """
    s2 = sin(latitude) ** 2
    numerator = EQUATORIAL_GRAVITY * (1.0 + GRAVITY_CONSTANT * s2)
    on_ellipsoid = numerator / sqrt(1.0 - ECCENTRICITY_SQUARED * s2)
    return on_ellipsoid * _falls(s2, height)


def gravity_by_latitude(latitude: float, height: float = 0.0) -> float:
    """Return dg/dL of normal gravity [m/s^2 per rad]."""
    s2, e2 = sin(latitude) ** 2, ECCENTRICITY_SQUARED
    grows = GRAVITY_CONSTANT / (1.0 + GRAVITY_CONSTANT * s2)
    grows += 0.5 * e2 / (1.0 - e2 * s2)
    grows += 4.0 * FLATTENING * height / SEMI_MAJOR_AXIS / _falls(s2, height)
    gravity = normal_gravity(latitude, height)
    return gravity * grows * 2.0 * sin(latitude) * cos(latitude)


def gravity_by_height(latitude: float, height: float = 0.0) -> float:
    """Return dg/dh of normal gravity [1/s^2]."""
    s2 = sin(latitude) ** 2
    slope = -2.0 * _shape(s2) + 6.0 * height / SEMI_MAJOR_AXIS
    gravity = normal_gravity(latitude, height)
    return gravity * slope / SEMI_MAJOR_AXIS / _falls(s2, height)


def _shape(s2: float) -> float:
    """Return 1 + f + m - 2 f sin^2 L; s2 is sin^2 L."""
    return 1.0 + FLATTENING + CENTRIFUGAL_RATIO - 2.0 * FLATTENING * s2


def _falls(s2: float, height: float) -> float:
    """Return gravity at a height over that at height 0; s2 is sin^2 L."""
    h = height / SEMI_MAJOR_AXIS
    return 1.0 - 2.0 * _shape(s2) * h + 3.0 * h**2


def meridian_radius(latitude: float) -> float:
    """Return the radius of curvature of the ellipsoid, north and south [m].

    a (1 - e^2) / (1 - e^2 sin^2 L)^(3/2).
    """
    e2 = ECCENTRICITY_SQUARED
    curved = 1.0 - e2 * sin(latitude) ** 2
    return SEMI_MAJOR_AXIS * (1.0 - e2) / (curved * sqrt(curved))


def normal_radius(latitude: float) -> float:
    """Return the radius of curvature of the ellipsoid, east and west [m].

    a / (1 - e^2 sin^2 L)^(1/2).
    """
    return SEMI_MAJOR_AXIS / sqrt(1.0 - ECCENTRICITY_SQUARED * sin(latitude) ** 2)
