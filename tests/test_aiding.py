"""Missions with aids against an independent program: physical error coordinates,
derivatives by complex step, a Joseph filter and its adjoint.
"""  # noqa: D205

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import yaml
from numpy.testing import assert_allclose
from places import TESTS

from budget.aiding import journey_of
from budget.earth import normal_gravity
from budget.errors import CallError
from budget.inputs import load_device, load_mission, load_procedure, uncalibrated
from budget.inputs.records import Believed, OwnFilter
from budget.names import Name
from budget.navigation.aided import Aided
from budget.question import Question
from budget.results import INTERACTION
from budget.studies.mission import SEEN, curve, filtered
from budget.units import ARCSEC

DATA = TESTS / "data" / "aided"
VALUES = yaml.safe_load((DATA / "values.yaml").read_text(encoding="utf-8"))
HORIZONTAL = ("position.north", "position.east")


def question(unit, mission, **more):
    """Return a unit on a mission as its maker calibrated it."""
    found = load_mission(mission if isinstance(mission, dict) else DATA / mission)
    return Question(
        devices=(load_device(DATA / f"{unit}.yaml", more.pop("changes", ())),),
        procedure=more.pop("procedure", uncalibrated("factory")),
        reference="next_turn_on",
        mission=found,
        carried_to=found.at,
        **more,
    )


@cache
def case(name):
    """Return one of the missions with its unit."""
    return question(VALUES[name]["unit"], f"{name}.yaml")


@cache
def grown(name):
    """Return its errors at its times."""
    return curve(case(name), case(name).carried_to)


def journey(one):
    """Return how its errors grow."""
    return journey_of(one.mission, one.carried_to, one.sensors, one.procedure)


def uncertainty(found, key, place):
    """Return a standard uncertainty at a time, as the table has it."""
    quantity, axis = key.split(".")
    if axis == "horizontal":
        return found.drms()[place]
    size = ARCSEC if quantity == "attitude" else 1.0
    return found.standard_uncertainty(quantity, axis)[place] / size


@pytest.mark.parametrize("name", VALUES)
def test_errors_at_every_time(name):
    """Position, velocity and attitude are those of the other program."""
    found, times = grown(name), case(name).carried_to
    for time, row in VALUES[name]["at"].items():
        for key, u in row.items():
            if not key.startswith("believed"):
                own = uncertainty(found, key, times.index(time))
                assert_allclose(own, u, rtol=1e-4, err_msg=f"{key} at {time} s")


@pytest.mark.parametrize("name", VALUES)
def test_what_each_source_leaves(name):
    """At the end of each mission the sources leave what they do there."""
    found = grown(name)
    parts = np.sqrt(np.maximum(found.horizontal_variance()[:, -1], 0.0))
    own = dict(zip(found.sources, parts.tolist(), strict=True))

    for source, u in VALUES[name]["by_source"].items():
        assert_allclose(own[source], u, rtol=2e-4, err_msg=source)
    a, b = (SEEN.index(("position", axis)) for axis in ("north", "east"))
    both = found.covariance[:, -1, a, b].sum()
    assert_allclose(both, VALUES[name]["covariance"], rtol=1e-4)


@pytest.mark.parametrize("name", ["g4", "g5"])
def test_what_a_filter_of_its_own_believes(name):
    """Beside what is true, which is more."""
    believed, times = journey(case(name)).believed, case(name).carried_to
    for time, row in VALUES[name]["at"].items():
        C = believed[times.index(time)]
        u = np.sqrt(C[0, 0] + C[1, 1])
        assert_allclose(u, row["believed.horizontal"], rtol=1e-4)
        heading = np.sqrt(C[8, 8]) / ARCSEC
        assert_allclose(heading, row["believed.heading"], rtol=1e-4)
        assert u < row["position.horizontal"]


@pytest.mark.parametrize("name", ["g1", "g2", "g9"])
def test_the_optimal_filter_believes_what_is_true(name):
    """The sources add up to the covariance that the filter has."""
    found, believed = grown(name), journey(case(name)).believed
    total = found.covariance.sum(axis=0)
    free = np.diag(believed[0]) > 0.0
    for place in range(len(believed)):
        u = np.sqrt(np.diag(believed[place]))[free]
        off = (total[place] - believed[place])[np.ix_(free, free)]
        assert np.abs(off / np.outer(u, u)).max() < 1e-9


@pytest.mark.parametrize("name", [name for name in VALUES if "learnt" in VALUES[name]])
def test_what_a_filter_learns_of_the_biases(name):
    """What is left of each bias with its stability after ten minutes."""
    found = filtered(case(name))

    last = [one for one in found.learnt if one.time == 600.0]
    assert_allclose([one.after for one in last], VALUES[name]["learnt"], rtol=1e-4)
    sigma = {"tac": (1.1180, 1001.25), "mems": (200.25, 5001.0)}
    if (unit := VALUES[name]["unit"]) in sigma:
        before = np.repeat(sigma[unit], 3)
        assert_allclose([one.before for one in last], before, rtol=1e-4)


@pytest.mark.slow
def test_a_filter_of_its_own_learns_less_than_it_could():
    """What it has wrong of a bias is more than the optimal filter has."""
    other = replace(case("g1"), mission=case("g4").mission)
    best, own = (
        [one.after for one in filtered(one).learnt] for one in (case("g1"), other)
    )

    assert (np.array(own) >= np.array(best)).all()
    assert filtered(other).kind == "own"


def test_the_problem_is_the_curve():
    """What methods solve has the same errors, sources and covariances between times."""
    one, found = case("g1"), grown("g1")
    law = one.law
    outputs = [output.name for output in one.problem.outputs]
    row = outputs.index(
        Name("position", owner="mission", axis="horizontal", time=660.0)
    )

    assert (*law.sources, INTERACTION) == found.sources
    assert_allclose(law.standard_uncertainty[row], found.drms()[-1], rtol=1e-9)
    parts = found.horizontal_variance()[:-1, -1]
    assert_allclose(law.source_variance[:, row], parts, rtol=1e-9)


def test_only_keeps_the_gains():
    """One line alone leaves what it leaves of the whole unit: 4.33230 m."""
    only = frozenset({Name("angle_random_walk", owner="gyro")})
    one = replace(case("g1"), only=only)

    found = curve(one, one.carried_to)

    assert_allclose(found.drms()[-1], 4.33230, rtol=1e-4)


@pytest.mark.parametrize(
    ("factor", "retuned"),
    [(0.9, 5.31311), (1.1, 5.97795), (2.0, 8.85397), (5.0, 17.7969)],
)
def test_another_value_retunes_the_filter(factor, retuned):
    """Angle random walk times a factor: the filter of that unit, not of the old one."""
    changes = (f"gyro.angle_random_walk={0.1 * factor} deg/sqrt(h)",)
    one = question("tac", "g1.yaml", changes=changes)

    assert_allclose(curve(one, one.carried_to).drms()[-1], retuned, rtol=1e-4)


@pytest.mark.parametrize(
    ("factor", "fixed"),
    [(0.9, 5.32200), (1.1, 5.98592), (2.0, 9.39129), (5.0, 21.9623)],
)
def test_with_fixed_gains_the_variance_is_linear_in_that_of_a_line(factor, fixed):
    """A slider moves what a line leaves, and keeps the gains."""
    found = grown("g1")
    parts = found.horizontal_variance()[:, -1].copy()
    parts[found.sources.index("gyro.angle_random_walk")] *= factor**2

    assert_allclose(np.sqrt(parts.sum()), fixed, rtol=1e-4)


@pytest.mark.parametrize(
    ("unit", "rounds", "u"),
    [
        ("tac", 1, 6.20335),
        ("tac", 2, 5.81458),
        ("mems", 1, 27.5436),
        ("mems", 2, 23.8815),
    ],
)
def test_a_shorter_time_with_aids(unit, rounds, u):
    """Aided for 150 or 300 s in place of 600: an outage of a minute."""
    text = (DATA / "g1.yaml").read_text(encoding="utf-8")
    mission = yaml.safe_load(text)
    mission["mission"]["segments"][0]["repeat"] = rounds
    mission["mission"]["at"] = [f"{150 * rounds + 60} s"]
    one = question(unit, mission)

    assert_allclose(curve(one, one.carried_to).drms()[-1], u, rtol=1e-4)


@pytest.mark.parametrize(
    ("mission", "unit", "printed"),
    [
        ("outage-60-s-after-gnss", "tac", "5.64711"),
        ("outage-60-s-after-gnss", "mems", "23.21"),
        ("outage-60-s-after-straight-gnss", "tac", "5.511"),
        ("outage-60-s-after-straight-gnss", "mems", "20.3571"),
        ("outage-60-s-turning-after-straight-gnss", "tac", "93.6"),
        ("outage-60-s-turning-after-straight-gnss", "mems", "747"),
    ],
)
def test_missions_that_ship(mission, unit, printed):
    """An outage after ten minutes of GNSS is what the other program says it is."""
    found = load_mission(mission)
    one = replace(case("g1"), devices=(load_device(DATA / f"{unit}.yaml"),))
    one = replace(one, mission=found, carried_to=found.at[-1:])
    last_digit = 10.0 ** -len(printed.partition(".")[2])

    u = curve(one, one.carried_to).drms()[-1]

    assert_allclose(u, float(printed), rtol=0, atol=last_digit)


def test_the_papers_procedure_leaves_residuals_that_go_together():
    """After it the residuals are correlated: the filter begins with all of that."""
    one = question("tac", "g1.yaml", procedure=load_procedure(None))

    found = curve(one, one.carried_to)

    for axis, u in (("north", 4.03427), ("east", 4.02452)):
        assert_allclose(found.standard_uncertainty("position", axis)[-1], u, rtol=2e-4)
    assert_allclose(found.drms()[-1], 5.69842, rtol=2e-4)
    heading = found.standard_uncertainty("attitude", "heading") / ARCSEC
    assert_allclose(heading[[0, -1]], [183.887, 204.101], rtol=2e-4)


def test_a_filter_may_estimate_one_parameter_of_one_triad():
    """Its other states are those of noise."""
    own = OwnFilter(estimates=(Name("bias", owner="gyro"),))
    other = replace(case("g1"), mission=replace(case("g1").mission, filter=own))

    found = curve(other, other.carried_to)

    assert found.drms()[-1] > grown("g1").drms()[-1]


def test_a_belief_in_the_truth_changes_nothing():
    """A filter that believes what is so, in other words, is the optimal one."""
    one = case("g1")
    own = OwnFilter(
        estimates=None,
        believes=(
            Believed(
                line=Name("bias_stability", owner="gyro"),
                value=300.0,
                printed="300 s",
                is_time=True,
            ),
        ),
    )
    other = replace(one, mission=replace(one.mission, filter=own))

    assert_allclose(curve(other, one.carried_to).drms(), grown("g1").drms(), rtol=1e-12)


def test_a_filter_that_believes_another_correlation_time_leaves_more():
    """Truth and estimate run apart then; what is true is above what is best."""
    one = case("g2")
    own = OwnFilter(
        estimates=None,
        believes=(
            Believed(
                line=Name("bias_stability", owner="gyro"),
                value=20.0,
                printed="20 s",
                is_time=True,
            ),
        ),
    )
    other = replace(one, mission=replace(one.mission, filter=own))

    found = curve(other, one.carried_to)

    assert isinstance(journey(other), Aided)
    assert (found.drms() >= grown("g2").drms()).all()
    assert found.drms()[-1] > 1.05 * grown("g2").drms()[-1]


def test_a_belief_of_a_line_that_is_not_there_is_refused():
    """With its place in the file, and the device."""
    one = case("g1")
    line = Name("rate_random_walk", owner="gyro")
    own = OwnFilter(
        estimates=None, believes=(Believed(line=line, value=1.0, printed="1"),)
    )
    other = replace(one, mission=replace(one.mission, filter=own))

    with pytest.raises(CallError, match=r"believes\.gyro\.rate_random_walk.*tac"):
        journey(other)


def alone(name, *segments):
    """Return what a tactical unit does on a mission without aids, told its attitude."""
    part = yaml.safe_load((DATA / f"{name}.yaml").read_text(encoding="utf-8"))
    part["name"] = "alone"
    for key in ("aiding", "filter", "alignment"):
        del part["mission"][key]
    for item in part["mission"]["segments"]:
        item.pop("aiding", None)
    if segments:
        part["mission"] |= {"segments": list(segments), "at": ["72 s"]}
    one = question("tac", part)
    return curve(one, one.carried_to)


def of_mounting(found):
    """Return the heading that mounting angles of gyros leave at the end [arcsec]."""
    place = found.sources.index("gyro.mounting_repeatability")
    heading = SEEN.index(("attitude", "heading"))
    return np.sqrt(found.covariance[place, -1, heading, heading]) / ARCSEC


def test_mounting_angles_do_not_cancel_in_banked_turns():
    """Right and left cancel level; banked both turn the unit about its x alike."""
    level, banked = (alone(name) for name in ("g1", "g10"))
    for found, north, east, heading, own in (
        (level, 898.711, 898.526, 720.6, 19.62),
        (banked, 895.932, 891.685, 898.5, 543.3),
    ):
        u = [
            uncertainty(found, key, -1)
            for key in ("position.north", "position.east", "attitude.heading")
        ]
        assert_allclose(u, [north, east, heading], rtol=1e-4)
        assert_allclose(of_mounting(found), own, rtol=1e-3)


@pytest.mark.parametrize("sense", ["", "-"])
def test_a_full_banked_turn_in_closed_form(sense):
    """Mounting angles d of 60 arcsec: sqrt(2) d 2 pi sin phi cos phi of heading."""
    turn = {"turn": f"{sense}360 deg", "rate": "5 deg/s"}
    phi = np.arctan(15.0 * np.radians(5.0) / normal_gravity(np.radians(47.0), 620.0))
    expected = 60.0 * 2.0**1.5 * np.pi * np.sin(phi) * np.cos(phi)
    banked = {**turn, "bank": "coordinated", "roll_rate": "2000 deg/s"}

    # Its rolls take 1e-4 of the turn; the earth turns by 5e-3 rad meanwhile.
    assert_allclose(of_mounting(alone("g1", banked)), expected, rtol=5e-3)
    assert of_mounting(alone("g1", turn)) < 0.1 * expected


@pytest.mark.slow
def test_what_a_turn_shows_is_that_of_a_mission_that_turns():
    """After a straight run 18 times as much; after figures of 8 it shows nothing."""
    straight, eight = (
        filtered(replace(one, mission=found, carried_to=found.at)).turned
        for one in [case("g1")]
        for found in map(
            load_mission,
            [
                "outage-60-s-after-straight-gnss",
                "outage-60-s-after-gnss",
            ],
        )
    )
    text = (DATA / "g1.yaml").read_text(encoding="utf-8")
    mission = yaml.safe_load(text)
    mission["mission"]["segments"] = [
        {"straight": "600 s", "aiding": ["gnss"]},
        {"turn": "180 deg", "rate": "6 deg/s"},
        {"straight": "30 s"},
    ]
    back = question("tac", mission)

    assert_allclose(straight.straight, 5.511, rtol=1e-4)
    assert_allclose(straight.turned, curve(back, back.carried_to).drms()[-1], rtol=1e-9)
    assert straight.turned > 15.0 * straight.straight
    assert eight.turned < 1.2 * eight.straight


def test_a_turn_is_asked_of_what_goes_straight_on():
    """Not of a mission that brakes after its aids, nor of one that keeps them."""
    assert filtered(case("g6")).turned is None
    text = (DATA / "g1.yaml").read_text(encoding="utf-8")
    mission = yaml.safe_load(text)
    mission["mission"]["segments"].pop()
    mission["mission"]["at"] = ["600 s"]
    assert filtered(question("tac", mission)).turned is None


@pytest.mark.slow
def test_a_measurement_below_rounding_is_believed_to_be_exact():
    """A GNSS of 3e-11 m/s: what is believed of it is a number, without a warning."""
    text = (DATA / "g6.yaml").read_text(encoding="utf-8")
    mission = yaml.safe_load(text)
    mission["mission"]["aiding"]["gnss"]["velocity"] = "2.93065e-11 m/s"

    found = filtered(question("mems", mission))

    for one in found.believed:
        assert 0.0 <= one.standard_uncertainty < np.inf
    for one in found.learnt:
        assert 0.0 <= one.after <= 1.001 * one.before


@pytest.mark.parametrize("name", ["g3", "g5"])
def test_ends_by_what_a_filter_believes_are_those_source_by_source(name):
    """Of the optimal filter; one of its own believes less, and has its true ones."""
    one = case(name)
    end = (one.mission.route.duration,)
    found = filtered(replace(one, carried_to=end)).turned
    assert_allclose(found.straight, curve(one, end).drms()[-1], rtol=1e-9)
    if name == "g5":
        believed = journey(replace(one, carried_to=end)).believed[-1]
        assert np.sqrt(believed[0, 0] + believed[1, 1]) < 0.8 * found.straight


def late(hours):
    """Return a mission whose height nothing measures for hours, and then GNSS."""
    gnss = {"position": "2.5 m", "velocity": "0.05 m/s", "rate": "1 Hz"}
    segments = [{"stand": f"{hours} h"}, {"stand": "60 s", "aiding": "gnss"}]
    part = {"latitude": "47 deg", "altitude": "free", "aiding": {"gnss": gnss}}
    return {"name": "late", "mission": {**part, "segments": segments}}


@pytest.mark.slow
def test_what_rounding_would_decide_is_refused():
    """A height that nothing measures grows by e in 570 s: after 2 h no filter has it.

    After 1.5 h what the sources leave is still what the filter has, to 1e-4; after 6 h
    it was 1e7 times that, and after 23 h a matrix was singular.
    """
    one = question("tac", late(1.5))
    believed = journey(one).believed[-1]
    total = curve(one, one.carried_to).covariance[:, -1].sum(axis=0)
    assert_allclose(np.diag(total), np.diag(believed), rtol=1e-4)
    for hours in (2, 6, 23):
        one = question("tac", late(hours))
        with pytest.raises(CallError, match=r"mission\.aiding: .* s after the begin"):
            curve(one, one.carried_to)
