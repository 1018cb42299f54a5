"""Filters that run: their errors over many runs against what the law says of them.

Truth, noise and measurements are drawn here, in short steps of their own; of the
package come the equations of motion, which full navigators check elsewhere, and the
gains. Each ratio of a drawn sigma to the one that is said lies within its bounds of
chi square, at once for all of a test (Bonferroni).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from navigation.strapdown import STAGES, State, radii, seen, slope_of
from numpy.testing import assert_allclose
from scipy.linalg import expm
from scipy.spatial.transform import Rotation
from scipy.stats import chi2
from test_aiding import journey, question

from budget.calibration.mission import Sensing, columns_of, constants_problem
from budget.methods.gum import covariance_by_source, derivatives
from budget.navigation.route import moments, moved
from budget.studies.mission import SEEN, curve
from budget.units import DEG_PER_HOUR, DEGREE, MICRO_G

pytestmark = pytest.mark.slow  # hundreds of runs

TIMES = (20, 150, 160, 180)  # after the first turns, all of them, and without aids [s]
CONFIDENCE = 0.999  # of all ratios of a test together
SECOND_ORDER = 0.04  # of a sigma: of 5 deg of heading at the start, and scale factors
AT_START = {"position": "10 m", "velocity": "1 m/s", "level": "1 deg"}
TAU = 300.0  # of both stabilities [s]
# Of the mems unit: density of gyros and accelerometers, and stability.
WHITE = np.repeat([0.3 * DEGREE / 60.0, 0.1 / 60.0], 3)
STABILITY = np.repeat([10.0 * DEG_PER_HOUR, 100.0 * MICRO_G], 3)
FILTERS = {
    "optimal": "optimal",
    "biases alone": {"estimates": ["gyro.bias", "accelerometer.bias"]},
    "less noise": {
        "believes": {
            "gyro.angle_random_walk": "0.03 deg/sqrt(h)",
            "aiding.gnss_position": "5 m",
        }
    },
    "faster noise": {"believes": {"gyro.bias_stability.correlation_time": "20 s"}},
}


def mission(filtered="optimal"):
    """Return a figure of 8 with GNSS and a heading, and half a minute without."""
    turns = [{"turn": f"{angle} deg", "rate": "5 deg/s"} for angle in (360, -360)]
    aided = [turns[0], {"straight": "3 s"}, turns[1], {"straight": "3 s"}]
    gnss = {"position": "2.5 m", "velocity": "0.05 m/s", "rate": "1 Hz"}
    return {
        "name": "eight",
        "mission": {
            "latitude": "47 deg",
            "height": "620 m",
            "speed": "15 m/s",
            "altitude": "free",
            "alignment": {**AT_START, "heading": "5 deg"},
            "aiding": {"gnss": gnss, "heading": {"value": "1 deg", "rate": "1 Hz"}},
            "filter": filtered,
            "segments": [
                {"segments": aided, "aiding": ["gnss", "heading"]},
                {"straight": "30 s"},
            ],
            "at": [f"{time} s" for time in TIMES],
        },
    }


@cache
def on_mission(name, unit="mems"):
    """Return the unit with one of the filters, and the journey of it."""
    one = question(unit, mission(FILTERS[name]))
    return one, journey(one)


@dataclass(frozen=True)
class Steps:
    """Short steps of a route, which end at every second."""

    durations: np.ndarray
    at: object  # Moment at begin, middle and end of each

    @classmethod
    def of(cls, route):
        """Cut a route: a degree of a turn at the most."""
        here, durations, stages, legs = route.start, [], [], []
        for leg in route.legs:
            number = 5 if leg.turn_rate else 2
            h = 1.0 / number
            for _ in range(round(leg.duration) * number):
                stages += [here, moved(here, leg, h / 2), moved(here, leg, h)]
                here = stages[-1]
                durations.append(h)
                legs += [leg] * STAGES
        return cls(np.array(durations), moments(stages, legs, (-1, STAGES)))

    @property
    def seconds(self):
        """The step that ends each second."""
        t = np.cumsum(self.durations)
        return np.flatnonzero(np.abs(t - np.round(t)) < 1e-6)


@cache
def truth():
    """Return the steps, what constants are there, and their covariance."""
    one, _ = on_mission("optimal")
    problem = constants_problem(one.sensors, one.procedure)
    U = covariance_by_source(problem, derivatives(problem)).sum(axis=0)
    names = [output.name for output in problem.outputs]
    steps = Steps.of(one.mission.route)
    columns = columns_of(names, tuple(map(Sensing.of, one.sensors)))(steps.at)
    return steps, names, columns, U


def transitions(tau):
    """Return transitions of states, constants and stabilities by seconds, and noise.

    By the midpoint of each step; stabilities of gyros fade by one time [s].
    """
    steps, names, columns, _ = truth()
    m, n = len(names), 9
    size = n + m + 6
    F, G = (one(aided=False)[:, 1] for one in (steps.at.dynamics, steps.at.entry))
    A, W = np.zeros((2, len(F), size, size))
    times = np.repeat([tau, TAU], 3)
    A[:, :n, :n], A[:, :n, n : n + m] = F, G @ columns[:, 1]
    A[:, :n, n + m :] = G
    A[:, range(n + m, size), range(n + m, size)] = -1.0 / times
    W[:, :n, :n] = G * WHITE**2 @ G.swapaxes(1, 2)
    W[:, range(n + m, size), range(n + m, size)] = 2.0 * STABILITY**2 / times
    h = steps.durations[:, None, None]
    Phi = expm(h * A)
    Q = 0.5 * h * (W + Phi @ W @ Phi.swapaxes(1, 2))
    found, first = [], 0
    for last in steps.seconds + 1:
        P, C = np.eye(size), np.zeros((size, size))
        for step in range(first, last):
            P, C = Phi[step] @ P, Phi[step] @ C @ Phi[step].T + Q[step]
        found.append((P, C))
        first = last
    return found


def root(C):
    """Return a root of a covariance, R R' = C."""
    values, vectors = np.linalg.eigh(C)
    return vectors * np.sqrt(np.maximum(values, 0.0))


def places_of(name):
    """Return which states of the truth a filter has, in its order."""
    _, names, _, _ = truth()
    one, own = on_mission(name)
    how = one.mission.filter
    kept = [
        9 + place
        for place, one in enumerate(names)
        if how is None or how.estimates is None or one.group in how.estimates
    ]
    slow = [9 + len(names) + row for row in rows_of_noise(own)]
    return [*range(9), *kept, *slow]


def rows_of_noise(own):
    """Return the inputs whose stability is a state of a filter, in its order."""
    return [row for first, last, row in own.filter.steps.noises if last > first]


def measured(name):
    """Return rows of Moment.measured and sigmas as they are, by second; gains too."""
    _, own = on_mission(name)
    growth = own.filter.growth
    t = np.cumsum(growth.steps.durations)[list(growth.steps.asked)]
    found = {}
    for end, gains in enumerate(own.filter.run.gains):
        there = [aid for aid in own.aids if end in aid.ends]
        rows = [row for aid in there for row in aid.rows]
        u = np.array([one for aid in there for one in aid.u])
        found[round(t[end])] = rows, u, gains
    return found


def in_a_line(filters, runs, rng, *, gains=None, late=0):
    """Return errors of filters at TIMES, (filters, times, 9, runs), of one truth.

    `gains`: those of another unit; `late`: measured so many seconds after it is said.
    """
    steps, _, _, U = truth()
    own = transitions(TAU)
    start = on_mission("optimal")[1].start
    first = steps.at.some(slice(1))
    given = first.given(aided=False)[0, 0] * start
    size = len(own[0][0])
    x = np.zeros((size, runs))
    x[:9] = given @ rng.standard_normal((9, runs))
    x[9 : 9 + len(U)] = root(U) @ rng.standard_normal((len(U), runs))
    x[9 + len(U) :] = STABILITY[:, None] * rng.standard_normal((6, runs))
    true = [x]
    for move, Q in own:
        x = move @ x + root(Q) @ rng.standard_normal((size, runs))
        true.append(x)
    ends = steps.seconds
    M = steps.at.measured(aided=False)[ends, -1]
    S = steps.at.seen(aided=False)[ends, -1]
    drawn = rng.standard_normal((len(own), 7, runs))
    found = []
    for name in filters:
        places = places_of(name)
        tau = 20.0 if name == "faster noise" else TAU
        design = [P[np.ix_(places, places)] for P, _ in transitions(tau)]
        said = measured(name)
        believed = said if gains is None else gains
        e, kept = np.zeros((len(places), runs)), []
        for second, move in enumerate(design, start=1):
            e = move @ e
            rows, u, _ = said.get(second, ((), None, None))
            if len(rows):
                H = M[second - 1, rows]
                then = min(second + late, len(own))
                z = M[then - 1, rows] @ true[then][:9]
                z = z + u[:, None] * drawn[second - 1, : len(rows)]
                e = e + believed[second][2] @ (z - H @ e[:9])
            if second in TIMES:
                kept.append(S[second - 1] @ (true[second][:9] - e[:9]))
        found.append(kept)
    return np.array(found)


def said_of(name):
    """Return the standard uncertainties at TIMES, (times, 9)."""
    one, _ = on_mission(name)
    found = curve(one, one.carried_to)
    return np.array([found.standard_uncertainty(*row) for row in SEEN]).T


def bounds(runs, number, allowance=0.0):
    """Return the least and the largest ratio of sigmas of so many runs."""
    tail = (1.0 - CONFIDENCE) / number / 2.0
    low, high = np.sqrt(chi2.ppf([tail, 1.0 - tail], runs) / runs)
    return low * (1.0 - allowance), high * (1.0 + allowance)


def ratios(errors, said):
    """Return drawn over said sigmas of errors, (..., runs)."""
    return np.sqrt((errors**2).mean(axis=-1)) / said


def test_filters_have_the_errors_that_are_said():
    """Of four designs, in linear equations: 600 runs, 144 ratios."""
    runs = 600
    errors = in_a_line(FILTERS, runs, np.random.default_rng(31))
    found = ratios(errors, np.array([said_of(name) for name in FILTERS]))
    low, high = bounds(runs, found.size)
    assert low < found.min(), found.min(axis=(1, 2))
    assert found.max() < high, found.max(axis=(1, 2))
    # Control: what is said of the optimal filter is not so of two of the others.
    other = ratios(errors[1:3], said_of("optimal"))
    assert (other.max(axis=(1, 2)) > high).all()


@pytest.mark.parametrize("wrong", ["gains", "epoch"])
def test_other_gains_and_epochs_have_others(wrong):
    """Control: gains of a tactical unit, and measurements that come a second late."""
    runs = 200
    gains = None
    if wrong == "gains":
        _, own = on_mission("optimal", unit="tac")
        gains = {
            second: (None, None, K)
            for second, K in zip(measured("optimal"), own.filter.run.gains, strict=True)
        }
    errors = in_a_line(
        ["optimal"],
        runs,
        np.random.default_rng(32),
        gains=gains,
        late=int(wrong == "epoch"),
    )
    found = ratios(errors[0], said_of("optimal"))
    assert found.max() > bounds(runs, found.size)[1]


def in_a_loop(runs, rng):
    """Return errors of full navigators whose filter corrects them, (times, 9, runs).

    Velocity, place and attitude are corrected as they stand, rates and forces by what
    is known of their errors; none of it is linear.
    """
    steps, _, columns, U = truth()
    _, own = on_mission("optimal")
    said = measured("optimal")
    m = len(U)
    first = steps.at.some(slice(1))
    z = rng.standard_normal((9, runs)) * own.start[:, None]
    route = on_mission("optimal")[0].mission.route
    states = State(
        np.tile(first.body[0, 0], (runs + 1, 1, 1)),
        np.tile(first.velocity[0, 0], (runs + 1, 1)),
        np.tile([route.start.latitude, 0.0, route.start.height], (runs + 1, 1)),
    )
    corrected(states, -z.T, states.velocity[1:])
    c = (root(U) @ rng.standard_normal((m, runs))).T
    s = STABILITY * rng.standard_normal((runs, 6))
    known, slow = np.zeros((runs, m)), np.zeros((runs, 6))
    order = rows_of_noise(own)
    ends = {step: second for second, step in enumerate(steps.seconds, start=1)}
    found = []
    for step, h in enumerate(steps.durations):
        fade = np.exp(-h / TAU)
        after = fade * s
        after += np.sqrt(1.0 - fade**2) * STABILITY * rng.standard_normal(s.shape)
        noise = 0.5 * (s + after) - slow * (1.0 + fade) / 2.0
        noise += WHITE / np.sqrt(h) * rng.standard_normal(s.shape)
        s, slow = after, fade * slow
        sensed = []
        for stage in range(STAGES):
            ideal = np.concatenate(
                [steps.at.rate[step, stage], steps.at.force[step, stage]]
            )
            off = np.zeros((runs + 1, 6))
            off[1:] = (c - known) @ columns[step, stage].T + noise
            sensed.append(ideal + off)
        states = gone_on(states, sensed, h)
        if (second := ends.get(step)) is None:
            continue
        true = State(*(one[:1] for one in vars(states).values()))
        if len((aids := said.get(second, ((), None, None)))[0]):
            rows, u, K = aids
            error = seen(states, true)[1:]
            z = error[:, rows] + u * rng.standard_normal((runs, len(rows)))
            dx = z @ K.T
            # Of the velocity that the states have, to the velocity itself.
            turned = np.cross(states.velocity[1:], dx[:, 6:9])
            physical = np.concatenate([dx[:, :3], dx[:, 3:6] + turned, dx[:, 6:9]], 1)
            corrected(states, physical, states.velocity[1:])
            known = known + dx[:, 9 : 9 + m]
            slow = slow + dx[:, 9 + m :][:, np.argsort(order)]
        if second in TIMES:
            found.append(seen(states, true)[1:].T)
    return np.array(found)


def gone_on(states, sensed, h):
    """Return states after a step, by Runge and Kutta."""
    a, b, d = ((one[:, :3], one[:, 3:]) for one in sensed)
    k1 = slope_of(states, *a, aided=False)
    k2 = slope_of(states.moved(k1, h / 2), *b, aided=False)
    k3 = slope_of(states.moved(k2, h / 2), *b, aided=False)
    k4 = slope_of(states.moved(k3, h), *d, aided=False)
    for slope, weight in ((k1, 1.0), (k2, 2.0), (k3, 2.0), (k4, 1.0)):
        states = states.moved(slope, h * weight / 6.0)
    return states


def corrected(states, off, velocity):
    """Take errors of place, velocity and attitude off all states but the first."""
    L, height = states.place[1:, 0].copy(), states.place[1:, 2].copy()
    R_n, R_e = radii(L, height)
    scale = np.stack([R_n, R_e * np.cos(L), -np.ones_like(R_n)], axis=1)
    states.place[1:] -= off[:, :3] / scale
    states.velocity[1:] = velocity - off[:, 3:6]
    turn = Rotation.from_rotvec(off[:, 6:9]).as_matrix()
    states.body[1:] = turn @ states.body[1:]


def test_navigators_that_a_filter_corrects():
    """Full strapdown in a closed loop: 200 runs, 36 ratios, and those of no filter."""
    runs = 200
    errors = in_a_loop(runs, np.random.default_rng(33))
    found = ratios(errors, said_of("optimal"))
    low, high = bounds(runs, found.size, SECOND_ORDER)
    assert low < found.min(), found
    assert found.max() < high, found
    # Control: what is said of a filter that estimates biases alone.
    other = ratios(errors, said_of("biases alone"))
    assert other.min() < low


def test_an_update_that_is_not_symmetrised_goes_astray():
    """Control: P - K H P of a mems unit for ten minutes; symmetrised it is the filter.

    An asymmetry grows with every update; what rounding makes of one is by processor
    0.2 to 7000 times the whole in the end, so one of 1e-14 begins it, which ends a
    million times as large.
    """
    kalman = journey(question("mems", "g5.yaml")).filter
    steps, n = kalman.steps, kalman.n
    fading = range(n, kalman.size)
    ended = dict(zip(kalman.growth.steps.asked, kalman.measured, strict=True))
    last = max(kalman.run.covariances)

    def variances(*, is_symmetrised):
        P = steps.begin.copy()
        sizes = np.sqrt(np.diag(P))
        P += 1e-14 * np.triu(np.outer(sizes, sizes), 1)
        for step, move in enumerate(steps.moves):
            Phi, Q = np.zeros((2, kalman.size, kalman.size))
            Phi[:n], Phi[fading, fading] = move, steps.fades[step]
            Q[:n, :n], Q[:n, n:] = steps.added[step], steps.joint[step]
            Q[n:, :n], Q[fading, fading] = steps.joint[step].T, steps.own[step]
            P = Phi @ P @ Phi.T + Q
            _, H, R = ended.get(step, (None, (), None))
            if len(H):
                HP = H @ P
                P = P - np.linalg.solve(HP @ H.T + np.diag(R), HP).T @ HP
                P = 0.5 * (P + P.T) if is_symmetrised else P
        return np.diag(P)

    own = np.diag(kalman.run.covariances[last])
    assert_allclose(variances(is_symmetrised=True), own, rtol=1e-9)
    off = variances(is_symmetrised=False) / own - 1.0
    assert np.abs(off).max() > 1.0
