"""A source of the station reaches both triads and is shown as its own everywhere."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from places import DOCS
from reading import on_terminal

import budget.model.sources
from budget import load_device, load_procedure, load_requirement
from budget.calibration.problem import calibration_problem
from budget.distributions import NORMAL
from budget.inputs.records import ErrorLine
from budget.methods.gum import propagate
from budget.model.response import BIAS
from budget.model.source import TEST, Disturbance, Source
from budget.model.sources import SOURCES, STATION, lines_of, source_of
from budget.names import Name
from budget.question import Question
from budget.report.allocation import allocation_answer, allocation_section
from budget.report.analysis.verdict import answer_rows
from budget.report.figures.sources import coupling_chart, share_chart
from budget.report.figures.style import looks
from budget.report.inputs import inputs_section
from budget.report.tables import group_tables
from budget.studies.allocation.allocate import allocate
from budget.studies.allocation.records import SHARED
from budget.studies.analysis import analyze
from budget.studies.evidence import coupling
from budget.studies.what_if import one_at_a_time, what_if
from budget.units import DEG_PER_HOUR, MICRO_G

ZHAO = load_device("zhao-2019")
PUSH = Name("push", owner=STATION)
U = 0.2  # of the shared source [1]
GYRO, ACCELEROMETER = 0.5 * DEG_PER_HOUR, 40.0 * MICRO_G  # bias error for one of it


@dataclass(frozen=True)
class Push(Disturbance):
    """One number that moves the bias of every axis of both triads."""

    def bind(self, given, triad):  # noqa: ARG002
        """Return the same bias on each axis."""
        size = GYRO if triad.scheme.turn.any() else ACCELEROMETER

        def act(x, truth, noise):  # noqa: ARG001
            epsilon = np.zeros((3, 4, x.shape[1]), dtype=x.dtype)
            epsilon[:, BIAS] = size * x[0]
            return epsilon

        return act


def forget():
    """Ask for the table of sources anew."""
    for one in (lines_of, source_of, looks):
        one.cache_clear()


@pytest.fixture
def procedure(monkeypatch):
    """Yield the paper's procedure at a station that pushes."""
    source = Source(
        name="push",
        units={STATION: "ppm"},
        model="one constant of the test",
        effect=Push(),
        stays=TEST,
        axes=("",),
    )
    monkeypatch.setattr(budget.model.sources, "SOURCES", (*SOURCES, source))
    line = ErrorLine(
        name="push",
        u=np.array([U]),
        distributions=(NORMAL,),
        printed="0.2",
        unit="ppm",
        si_per_unit=1.0,
    )
    forget()
    yield replace(load_procedure(), station=(line,))
    monkeypatch.undo()
    forget()


@pytest.fixture
def requirement():
    """Return the requirement of the documents: limits for both triads."""
    docs = DOCS
    return load_requirement(docs / "example" / "requirement.yaml")


def test_one_draw_moves_both_triads(procedure):
    """Biases of both triads share it: covariance is the product of what each feels."""
    law = propagate(calibration_problem(ZHAO.sensors, procedure))
    plain = propagate(calibration_problem(ZHAO.sensors, load_procedure()))
    budget = analyze(ZHAO, procedure=procedure, validate=False)
    names = [row.output.name for row in budget.outputs]
    gyro, other = names.index("gyro.bias.x"), names.index("accelerometer.bias.z")

    assert_allclose(law.covariance[gyro, other], GYRO * ACCELEROMETER * U**2, rtol=1e-6)
    assert_allclose(plain.covariance[gyro, other], 0.0, atol=1e-20)
    for place, size in ((gyro, GYRO), (other, ACCELEROMETER)):
        (part,) = [p for p in budget.outputs[place].contributions if p.source == PUSH]
        assert_allclose(part.standard_uncertainty, size * U, rtol=1e-6)


def test_figures_and_tables_show_it_as_the_stations(procedure):
    """In shares, coupling and contributions its owner is named, once for both."""
    budget = analyze(ZHAO, procedure=procedure, validate=False)
    groups = group_tables(budget)
    biases = [group for group in groups if group.parameter == "bias"]
    table = coupling(budget.question)

    assert [group.sensor for group in biases] == ["gyro", "accelerometer"]
    for group in biases:
        assert "station push" in {row.title for row in group.sources}
        # Without a colour of its own it is gathered, and no share is lost.
        shares = share_chart(group)
        assert "other" in shares.alt
        assert len(shares.tips) == sum(
            len(row.marks) for one in shares.groups for row in one.rows
        )
        assert "Station: push" in coupling_chart(table, group.sensor).alt
    rows = [row for row in answer_rows(budget, groups, None) if "bias" in row.title]
    for row in rows:
        assert PUSH in {part.name for part in row.shares.parts}
    assert len(rows) == 2
    titles = [panel.title for panel in inputs_section((ZHAO,), procedure).blocks]
    assert f"{procedure.name}: station" in titles


def test_it_can_be_asked_for_alone(procedure):
    """`only` finds it by its bare name; then it is all that acts."""
    budget = analyze(ZHAO, procedure=procedure, validate=False, only=("push",))

    assert budget.settings.only == (PUSH,)
    u = budget.output("gyro.bias.x").standard_uncertainty
    assert_allclose(u, GYRO * U, rtol=1e-6)


def test_what_if_scales_it_in_both_triads(procedure):
    """It has a slider after those of the sensors; without it both biases shrink."""
    model = what_if(Question.of(ZHAO, procedure=procedure))
    present, without = model.evaluate({}), model.evaluate({PUSH: 0.0})
    names = [output.name for output in model.outputs]

    assert model.sources[-1].name == PUSH
    assert [row.source.name for row in one_at_a_time(model)][-1] == PUSH
    for name, size in (("gyro.bias.x", GYRO), ("accelerometer.bias.x", ACCELEROMETER)):
        k = names.index(name)
        assert_allclose(
            present.u[k] ** 2 - without.u[k] ** 2, (size * U) ** 2, rtol=1e-6
        )


@pytest.mark.slow
def test_allocation_holds_it_and_tells_its_headroom(procedure, requirement):
    """It stays as it is; alone it may grow until the first triad is at a limit."""
    found = allocate(ZHAO, requirement=requirement, procedure=procedure, catalogue=())
    (row,) = [row for row in found.sources if row.source == PUSH]
    alone = []
    for sensor in ("gyro", "accelerometer"):
        one = allocate(
            replace(ZHAO, **{sensor: getattr(ZHAO, sensor)}),
            requirement=replace(
                requirement,
                limits=tuple(x for x in requirement.limits if x.output.owner == sensor),
            ),
            procedure=procedure,
            catalogue=(),
        )
        alone += [r.headroom.value for r in one.sources if r.source == PUSH]

    assert found.sources[-1] == row
    assert row.status == SHARED
    assert row.allowed in {U, None}
    assert len(alone) == 2
    assert_allclose(row.headroom.value, min(alone), rtol=1e-9)
    assert "Station" in on_terminal(allocation_answer(found)).splitlines()
    assert found.to_dict()["sources"][-1]["sensor"] == "station"
    assert "station" in repr(allocation_section(found))
