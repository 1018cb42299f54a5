"""Equations of growth against those of python-ins, a package of others.

python-ins 1.0.1 (MIT; Morozov): `InsErrorModel(with_altitude=...).system_matrices(pva)`
gives F, B_gyro and B_accel. At rest, height 100 m, heading 30 deg, altitude aided,
`transform_to_output(pva) @ expm(3600 [[F, B], [0, 0]])` was printed; in flight, at 52
deg, 9000 m, heading 130 deg and velocity (-150, 180, -3) m/s, F itself. Its body axes
are front, right, down, its angles in degrees.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from budget.navigation.dynamics import ATTITUDE, POSITION, VELOCITY, Moment, level_body
from budget.navigation.growth import Growth
from budget.navigation.route import Leg, Legs, Start

# By latitude [deg]: errors after an hour, north, east, v north, v east, roll, pitch,
# heading, of gyros x, y, z and accelerometers x, y (that of z makes none).
REST = {
    "5.0": """
        -1.414990612e10 -2.369436230e10 -2.605303891e9 6.940014411e5 -4.011529200e5
        2.399603649e10 -1.432404654e10 -3.094140796e7 4.085386324e5 7.067938702e5
        -3.979400409e6 -6.533786592e6 -2.004592636e6 -6.680039248e2 4.063230660e2
        6.822821849e6 -4.146235846e6 -2.956378772e4 -4.061585161e2 -6.677189161e2
        -4.498952881e4 9.382084654e2 1.691655890e3 -4.027255232e-2 -7.312160134e0
        -1.705677336e3 -4.540411194e4 2.784131056e3 7.269874148e0 3.291991033e-2
        5.272581250e3 -3.437830476e4 2.038974601e5 3.210671334e-1 5.554634589e-1
    """,
    "-45.0": """
        -1.091721047e10 -2.551173039e10 -1.848058061e9 7.001252472e5 -4.003761070e5
        2.566381013e10 -1.100513746e10 1.782703075e8 4.040922847e5 7.065618558e5
        -2.562936062e6 -7.345751057e6 -1.420686105e6 -7.376204959e2 2.592571499e2
        7.491330290e6 -2.647141188e6 1.702186925e5 -2.591737299e2 -7.374760084e2
        -4.364596126e4 -1.078508933e4 8.404402840e2 1.155113467e-2 -7.288831995e0
        1.045638425e4 -4.395204446e4 2.292165551e3 7.267778658e0 4.821764762e-2
        -2.386470730e5 8.161912668e4 2.034856024e5 -3.623885753e0 -6.336422495e0
    """,
    "70.0": """
        -1.755861842e10 -2.163954459e10 -8.934381554e8 6.995639986e5 -4.090219301e5
        2.167518050e10 -1.757915534e10 -1.146335418e8 4.098904594e5 7.010683355e5
        -5.490637431e6 -5.651291726e6 -6.863552512e5 -5.611345353e2 5.444162580e2
        5.685392735e6 -5.510278727e6 -1.093991397e5 -5.443966370e2 -5.611005506e2
        -4.270552211e4 1.395470102e4 8.312404902e2 -4.404587209e-2 -7.270959745e0
        -1.405876686e4 -4.272950531e4 9.039361329e2 7.266014566e0 -3.554329053e-2
        5.281129655e5 -4.401741669e5 2.031677732e5 1.008640757e1 1.725158711e1
    """,
}

OURS = [1, 0, 2, 4, 3]  # right, forward, up of front, right, down
SIGNS = [1.0, 1.0, -1.0, 1.0, 1.0]

FLIGHT = (
    (
        VELOCITY,
        VELOCITY,
        """
        0 -1.509212110306e-04 -2.349568949334e-05
        1.509212110306e-04 0 1.179125729132e-04
        2.349568949334e-05 -1.179125729132e-04 0
    """,
    ),
    (
        ATTITUDE,
        VELOCITY,
        """
        0 1.562393740574e-07 0
        -1.566379299556e-07 0 0
        0 -1.999772794438e-07 0
    """,
    ),
    (
        ATTITUDE,
        ATTITUDE,
        """
        -4.687181221721e-07 -9.345856066525e-05 -5.978338473517e-08
        9.345856066525e-05 -4.699137898668e-07 4.482300272976e-05
        2.409562133167e-05 -7.301783012177e-05 -2.999659191657e-05
    """,
    ),
    (POSITION, ATTITUDE, "0 3 180 -3 0 150 -180 -150 0"),
)
TILT_OF_VELOCITY = "0 9.784781895429 0 -9.784781895429 0 0 0 0 0"
TURN_OF_PLACE = "-9.000830602994e-12 0 0 0 0 0 -7.032219576741e-12 0 0"
B_GYRO = "2.298133329357 -1.92836282906 1.92836282906 2.298133329357"


def matrix(text, columns=3):
    """Return printed numbers as rows."""
    return np.array(text.split(), dtype=float).reshape(-1, columns)


def at_rest(latitude):
    """Return our errors after an hour of a unit of each input, (7, 5)."""
    start = Start(latitude=np.radians(latitude), height=100.0, heading=np.radians(30.0))
    route = Legs(start=start, legs=(Leg(duration=3600.0),))
    growth = Growth(
        first=route.first, alignment=0.0, steps=route.steps((3600.0,)), aided=True
    )
    (S,) = growth.of_constants(lambda _: np.eye(6))
    return S[[0, 1, 3, 4, 6, 7, 8], :5]


def theirs_at_rest(text):
    """Return theirs, in radians and by our axes."""
    S = matrix(text, 5)
    S[4:] = np.radians(S[4:])
    return S[:, OURS] * SIGNS


@pytest.mark.parametrize("latitude", list(REST))
def test_an_hour_at_rest(latitude):
    """To 1e-6 of the largest of each kind and input."""
    ours, theirs = at_rest(float(latitude)), theirs_at_rest(REST[latitude])
    for rows in (slice(0, 2), slice(2, 4), slice(4, 7)):
        size = np.abs(theirs[rows]).max(axis=0)
        assert (np.abs(ours - theirs)[rows].max(axis=0) < 1e-6 * size).all()
    # Control: half a degree of latitude is seen.
    off = np.abs(at_rest(float(latitude) + 0.5) - theirs).max(axis=0)
    assert (off > 1e-4 * np.abs(theirs).max(axis=0))[:3].all()


def flight():
    """Return our moment of that flight."""
    return Moment(
        latitude=np.array(np.radians(52.0)),
        height=np.array(9000.0),
        velocity=np.array([-150.0, 180.0, -3.0]),
        acceleration=np.zeros(3),
        body=level_body(np.array(np.radians(130.0))),
        turning=np.zeros(3),
        time=np.array(0.0),
    )


def test_a_moment_of_flight():
    """What both have is equal to 1e-9; and what only ours has is what it says."""
    one = flight()
    F = one.dynamics(aided=False)
    for rows, columns, text in FLIGHT:
        theirs = matrix(text)
        size = np.abs(theirs).max()
        assert_allclose(F[rows, columns], theirs, rtol=0, atol=1e-9 * size)
    # Coriolis force by the turned rate of the earth: - v x (W x phi).
    turned = [np.cross(one.velocity, np.cross(one.earth_rate, e)) for e in np.eye(3)]
    tilt = matrix(TILT_OF_VELOCITY) - np.stack(turned, axis=1)
    # Its gravity at a height is g (1 - 2 h/a), 1.5e-6 more at 9000 m.
    assert_allclose(F[VELOCITY, ATTITUDE], tilt, rtol=0, atol=2e-5)
    # The earth's rate at another place is theirs; the transport rate's change is not.
    off = F[ATTITUDE, POSITION] - matrix(TURN_OF_PLACE)
    slow = np.abs(one.velocity).max() / 6.3e6**2 / np.cos(one.latitude) ** 2
    assert np.abs(off).max() < 1.5 * slow
    G = one.entry(aided=False)
    assert_allclose(G[3:5, [1, 0]].ravel(), matrix(B_GYRO, 4)[0], rtol=1e-9)
    assert_allclose(G[3:5, 2], [-180.0, -150.0], rtol=1e-9)
    assert_allclose(G[5, [1, 0]], [0.79510327573, 234.306141214397], rtol=1e-9)
