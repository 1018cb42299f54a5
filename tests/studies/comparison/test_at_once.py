"""What many devices share is computed once: the numbers are those of each alone."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from builders import Elsewhere
from keeping import catalogue
from numpy.testing import assert_allclose

from budget import load_procedure, load_requirement
from budget.calibration.problem import _frame, calibration_problem
from budget.inputs.load import try_changed
from budget.methods.cluster import connect
from budget.methods.gum import _KEPT, propagate
from budget.missing.prediction import KEPT, _others, predict, prepare
from budget.problem import Group
from budget.question import Question, laws_together
from budget.studies.comparison import judging
from budget.studies.comparison.compare import compare
from budget.studies.margin import turn

REFERENCES = ("nominal", "as_tested", "next_turn_on")


def changed(device, times):
    """Return a device of another name, with lines so many times as large."""
    own = {
        sensor.kind: replace(
            sensor, lines=tuple(replace(x, u=times * x.u) for x in sensor.lines)
        )
        for sensor in (device.gyro, device.accelerometer)
        if sensor is not None
    }
    name = f"{device.name} times {times}"
    return replace(
        device,
        name=name,
        origin=replace(device.origin, file=f"{name}.yaml", sha256=name),
        gyro=own.get("gyro"),
        accelerometer=own.get("accelerometer"),
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("procedure", "reference"),
    [
        ("zhao-2019", "nominal"),
        ("zhao-2019", "next_turn_on"),
        ("six-positions-and-turns", "as_tested"),
    ],
)
def test_a_law_of_a_shared_structure_is_that_of_its_own(procedure, reference):
    """Of every device that ships, after one of its structure: function and derivatives.

    All else that is kept for a structure is thrown away in between.
    """
    test = load_procedure(procedure)

    def laws(device):
        _frame.cache_clear()
        _KEPT.clear()
        for times in (0.7, 1.0):  # the second one shares what the first one needed
            other = changed(device, times)
            for sensors in ([one] for one in other.sensors):
                yield propagate(
                    calibration_problem(tuple(sensors), test, reference=reference)
                )

    for device in catalogue():
        shared = list(laws(device))[len(device.sensors) :]
        for sensor, law in zip(changed(device, 1.0).sensors, shared, strict=True):
            _frame.cache_clear()
            alone = propagate(calibration_problem((sensor,), test, reference=reference))
            for name in ("mean", "covariance", "source_variance", "C", "H"):
                ours, theirs = getattr(law, name), getattr(alone, name)
                assert_allclose(ours, theirs, rtol=1e-12, atol=0.0)


def test_noise_goes_with_its_size():
    """The covariance of a process is that of size 1 times the square of its size."""
    test = load_procedure("zhao-2019")
    for device in catalogue():
        one, other = (
            calibration_problem((changed(device, times).sensors[0],), test).groups
            for times in (1.0, 3.0)
        )
        for a, b in zip(one, other, strict=True):
            assert isinstance(a, Group)
            assert_allclose(b.covariance, 9.0 * a.covariance, rtol=1e-12)


@pytest.mark.slow
def test_predictions_made_at_once_are_those_of_each_alone():
    """To the last bit, whichever devices are beside one."""
    devices = [changed(one, 1.1) for one in catalogue()]
    untold = [replace(one, technology="") for one in devices[:6]]
    every = [*devices, *untold]
    words = [None] * len(devices) + ["mems"] * len(untold)

    def found(*, at_once):
        _others.cache_clear()
        if at_once:
            prepare(every, catalogue())
        for device, word in zip(every, words, strict=True):
            if not at_once:
                _others.cache_clear()
            names = [name for one in device.sensors for name in one.expected_missing]
            one = predict(device, names, catalogue(), technology=word)
            yield one and (one.names, one.location.tolist(), one.scale.tolist(), one.df)

    together, alone = (list(found(at_once=each)) for each in (True, False))
    assert together == alone
    assert sum(one is not None for one in alone) > len(devices) / 2
    assert len(_others(tuple(catalogue())).kept) <= KEPT


@pytest.mark.slow
@pytest.mark.parametrize("wanted", ["catalogue-edge"])
def test_chunks_and_workers_change_nothing(monkeypatch, wanted):
    """One device at a time, a few, all of them, here or elsewhere: one document."""
    devices = [
        changed(one, times) for one in catalogue()[5:60:11] for times in (0.3, 1.0)
    ]
    requirement = load_requirement(wanted)

    def document(chunk, executor=None):
        monkeypatch.setattr(judging, "CHUNK", chunk)
        _others.cache_clear()
        _frame.cache_clear()
        found = compare(devices, requirement, method="gum", executor=executor)
        return json.dumps(found.to_dict())

    usual = document(64)
    assert document(1) == document(3) == document(3, Elsewhere()) == usual


def test_laws_made_together_are_those_of_each_alone():
    """Of all devices that ship, each in three sizes, in any order."""
    devices = [changed(one, times) for times in (0.7, 1.0, 1.3) for one in catalogue()]
    asked = Question.each(
        devices[::3],
        (load_procedure("zhao-2019"),),
        requirement=load_requirement("catalogue-edge"),
    )
    questions = [one for _, one in asked if one.has_lines]
    laws_together(questions)

    assert len({id(one.problem.function) for one in questions}) < len(questions)
    for one in questions:
        alone = propagate(one.problem)
        for name in ("mean", "covariance", "first_order", "degrees_of_freedom"):
            together = getattr(one.law, name)
            assert_allclose(together, getattr(alone, name), rtol=1e-12, atol=0.0)
        for name in ("source_variance", "source_first_order", "interaction_variance"):
            off = np.abs(getattr(one.law, name) - getattr(alone, name))
            assert (off <= 1e-12 * np.diag(alone.covariance)).all()


@pytest.mark.slow
@pytest.mark.parametrize("where", ["workers", "cluster"])
def test_processes_change_nothing(monkeypatch, where):
    """Two processes of this machine, or a cluster of one: the same document."""
    monkeypatch.setattr(judging, "CHUNK", 3)
    devices = [changed(one, 1.1) for one in catalogue()[::12]]
    shown = {"method": "gum"}
    here = compare(devices, "catalogue-edge", **shown).to_dict()
    if where == "workers":
        there = compare(devices, "catalogue-edge", workers=2, **shown).to_dict()
    else:
        distributed = pytest.importorskip("distributed")
        with (
            distributed.LocalCluster(
                n_workers=1, host="127.0.0.1", dashboard_address=None, silence_logs=60
            ) as running,
            connect(running.scheduler_address) as c,
        ):
            shown |= {"executor": c.executor, "workers": c.workers}
            there = compare(devices, "catalogue-edge", **shown).to_dict()
    assert json.dumps(there) == json.dumps(here)


def test_a_bad_file_among_many_stops_no_other(tmp_path):
    """It is told, once; all others are there, in their order."""
    text = "name: no. {}\ngyro:\n  errors:\n    angle_random_walk: {} deg/sqrt(h)\n"
    for place in range(30):
        path = tmp_path / f"{place:02d}.yaml"
        path.write_text(text.format(place, 0.01 * (place + 1)), encoding="utf-8")
    (tmp_path / "13.yaml").write_text("gyro: [\n", encoding="utf-8")

    devices, issues = try_changed(sorted(tmp_path.iterdir()), (), variants=True)

    assert [one.name for one in devices] == [
        f"no. {place}" for place in range(30) if place != 13
    ]
    assert len(issues) == 1
    assert "13.yaml" in str(issues[0])


@pytest.mark.parametrize("power", [1, 2, 4])
def test_a_bound_is_looked_up_where_it_turns(power):
    """At the root or just below, though the function is hardly asked: counted."""
    for root in np.random.default_rng(power).uniform(1e-6, 1.0, 50).tolist():
        asked = []

        def excess(x, root=root, asked=asked):
            asked.append(x)
            return x**power - root**power

        found = turn(excess, 0.0, 1.0)

        assert excess(found) <= 0.0
        assert_allclose(found, root, rtol=1e-9)
        assert len(asked) < 50


def test_the_laws_of_a_chunk_are_those_that_are_judged():
    """No law is made again where limits are put on it."""
    wanted, how = load_requirement("catalogue-edge"), load_procedure("zhao-2019")
    every = Question.each(catalogue()[:3], [how], requirement=wanted)
    questions = [one for _, one in every if one.has_lines]
    assert questions
    laws_together(questions)
    for one in questions:
        assert "law" in vars(one.limits)
        assert one.law is one.limits.law
