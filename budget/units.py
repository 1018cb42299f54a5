"""Units: the only place where a number that is not SI has a meaning.

Inside the package every number is SI and every angle in radians. Printed units are
factors here; text with a unit is read by `parse_quantity`.
"""

from __future__ import annotations

from math import pi

HOUR = 3600.0  # [s]
DEGREE = pi / 180.0  # [rad]
ARCSEC = DEGREE / 3600.0  # [rad]
PPM = 1e-6  # [1]
DEG_PER_HOUR = DEGREE / HOUR  # [rad/s]
STANDARD_GRAVITY = 9.80665  # [m/s^2], exact by definition (CGPM 1901)
MICRO_G = 1e-6 * STANDARD_GRAVITY  # [m/s^2]
