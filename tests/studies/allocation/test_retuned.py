"""What each line may be on a mission with aids: with the filter of what is allotted."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from command_line import call
from numpy.testing import assert_allclose
from places import TESTS
from reading import assert_says

from budget.inputs import load_device, load_mission, load_requirement, uncalibrated
from budget.methods.allocation import headroom_of
from budget.methods.scaling import scaled_law
from budget.names import Name
from budget.question import Question
from budget.studies.allocation import cases, rows
from budget.studies.allocation.allocate import allocate
from budget.studies.mission import curve

DATA = TESTS / "data" / "aided"
FACTORY = uncalibrated("factory")
WALK = Name("angle_random_walk", owner="gyro")
# Of tac on g1 at 660 s, by the other program: gains kept, and retuned [m].
FACTORS = (0.9, 1.1, 2.0, 5.0)
KEPT = (5.32200, 5.98592, 9.39129, 21.9623)
RETUNED = (5.31311, 5.97795, 8.85397, 17.7969)
TIGHT = 1e-6  # of a limit that an allocation reaches [1]


def way(limit):
    """Return a limit on the circle of half of all errors at the end of an outage."""
    at = {"horizontal": f"{limit!r} m", "at": "660 s", "probability": "50 %"}
    return {"name": "way", "limits": {"mission": {"position": [at]}}}


def circle(device, mission):
    """Return that circle of a device with a filter of its own, computed afresh [m]."""
    unit = Question(
        devices=(device,),
        procedure=FACTORY,
        reference="next_turn_on",
        mission=load_mission(DATA / f"{mission}.yaml"),
        carried_to=(660.0,),
    )
    (found,) = curve(unit, unit.carried_to).radius(0.5)
    return found


@cache
def allot(unit, mission, limit, **options):
    """Allocate by the law alone, with no catalogue; once for all who ask."""
    return allocate(
        DATA / f"{unit}.yaml",
        requirement=load_requirement(way(limit)),
        mission=load_mission(DATA / f"{mission}.yaml"),
        calibration="factory",
        catalogue=(),
        validate=False,
        **options,
    )


def made(unit, allocation, more=1.0):
    """Return the device as allocated, what was shared out so many times larger."""
    found = {}
    for sensor in allocation.sensors:
        shared = {
            row.source.quantity
            for row in allocation.sources
            if row.source.owner == sensor.kind and row.status == "free"
            if not row.is_spared
        }
        lines = tuple(
            replace(line, u=line.u * more) if line.name in shared else line
            for line in sensor.lines
        )
        found[sensor.kind] = replace(sensor, lines=lines)
    return replace(load_device(DATA / f"{unit}.yaml"), **found)


@pytest.fixture
def nothing_alone(monkeypatch):
    """Retune for no line alone, which takes three times what sharing out takes."""
    monkeypatch.setattr(rows, "RETUNINGS", 0)


@cache
def case():
    """Return tac on g1 under a limit."""
    return cases.set_up(
        Question.of(
            load_device(DATA / "tac.yaml"),
            procedure=FACTORY,
            requirement=load_requirement(way(7.0)),
            mission=load_mission(DATA / "g1.yaml"),
            carried_to=(),
        ),
        cases.NO_BOUNDS,
        {},
    )


def of_walk(factor):
    """Return factors of which all but the angle random walk's are 1."""
    return np.array([factor if name == WALK else 1.0 for name in case().law.sources])


@pytest.mark.parametrize(
    ("factor", "kept", "retuned"), [*zip(FACTORS, KEPT, RETUNED, strict=True)]
)
def test_a_law_with_the_filter_of_other_values(factor, kept, retuned):
    """It is what the other program has with its filter retuned; the present one not."""
    s = of_walk(factor)
    for law, u in ((case().law, kept), (case().law_of(s), retuned)):
        assert_allclose(np.sqrt(law.variance(s)), [u], rtol=1e-4)


def test_a_filter_knows_the_lines_and_what_calibrated_them():
    """The law after another calibration is that of such a unit set up by itself."""
    one, s = case(), of_walk(2.0)
    how = uncalibrated("none")
    unit = one.question.under(how)
    own = (cases.resize(sensor, one.law.sources, s) for sensor in unit.sensors)
    afresh = scaled_law(unit.with_sensors(own).problem)
    alike = afresh.select(one.law.outputs).variance(one.task.now)
    assert_allclose(one.law_of(one.known(s), how).variance(s), alike, rtol=1e-9)


@pytest.mark.slow
@pytest.mark.usefixtures("nothing_alone")
@pytest.mark.parametrize(
    ("unit", "mission", "limit"),
    [
        ("tac", "g1", 7.0),
        ("tac", "g1", 2.0),  # which gains as they are cannot meet with exact sensors
        ("mems", "g3", 10.0),
        ("mems", "g5", 20.0),  # a filter of its own
    ],
)
def test_what_is_allotted_is_at_the_limit_with_its_own_filter(unit, mission, limit):
    """Computed afresh it meets, to a millionth; a hundredth larger it fails."""
    allocation = allot(unit, mission, limit)
    assert allocation.feasible
    (row,) = allocation.outputs
    assert row.is_binding
    found = circle(made(unit, allocation), mission)
    assert limit * (1.0 - TIGHT) < found <= limit
    assert circle(made(unit, allocation, 1.01), mission) > limit * 1.001


@pytest.mark.slow
@pytest.mark.usefixtures("nothing_alone")
@pytest.mark.parametrize("strategy", ["equal", "cost"])
def test_every_strategy_retunes(strategy):
    """At the limit, with the filter of what it has shared out."""
    allocation = allot("tac", "g1", 7.0, strategy=strategy)
    found = circle(made("tac", allocation), "g1")
    assert 7.0 * (1.0 - 10.0 * TIGHT) < found <= 7.0 * (1.0 + TIGHT)


@pytest.mark.slow
@pytest.mark.usefixtures("nothing_alone")
def test_gains_that_are_kept_share_out_less(monkeypatch):
    """They are a safe start: a control of what retuning is for."""
    lines = allot("tac", "g1", 7.0).sources
    monkeypatch.setattr(cases, "RETUNINGS", 0)
    allocation = allot.__wrapped__("tac", "g1", 7.0)
    for own, kept in zip(lines, allocation.sources, strict=True):
        if own.status == "free" and not own.is_spared:
            assert kept.factor < 0.99 * own.factor
    assert circle(made("tac", allocation), "g1") < 0.99 * 7.0


@pytest.mark.slow
def test_one_line_alone_may_grow_with_its_filter():
    """To five times, where the limit is what five times reach; kept gains: less."""
    device = load_device(DATA / "tac.yaml", [f"{WALK}=0.5 deg/sqrt(h)"])
    allocation = allot("tac", "g1", float(circle(device, "g1")))
    (row,) = (one for one in allocation.sources if one.source == WALK)
    assert_allclose(row.headroom.value / row.now, 5.0, rtol=1e-4)
    before = replace(case().present, limit=np.array([circle(device, "g1")]))
    kept = headroom_of(before, before.now, case().law.sources.index(WALK))
    assert kept.factor < 4.2


@pytest.mark.slow
def test_the_written_device_meets_on_the_command_line(tmp_path):
    """A file of what is allotted is at the limit of `budget mission`; it is said so."""
    wanted, written = (tmp_path / name for name in ("way.yaml", "made.yaml"))
    wanted.write_text(
        "name: way\nlimits: {mission: {position: "
        "[{horizontal: 7 m, at: 660 s, probability: 50 %}]}}\n",
        encoding="utf-8",
    )
    same = ("--mission", str(DATA / "g1.yaml"), "--calibration", "factory")
    run = call(
        *("allocate", str(DATA / "tac.yaml"), "--requirement", str(wanted), *same),
        *("--write", str(written)),
        code=1,
    )
    assert_says(run.out + run.err, "the filter of the mission is retuned")
    # A file has four or five digits of a value, rounded towards what meets.
    assert 7.0 * (1.0 - 2e-4) < circle(load_device(written), "g1") <= 7.0
