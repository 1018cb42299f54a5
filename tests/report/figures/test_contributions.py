"""Tornado, waterfall and correlation: numbers, empty states, labels that stand free."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from figure_text import crossed_texts, cut_texts
from matplotlib.figure import Figure
from numpy.testing import assert_allclose
from report_examples import (
    make_assessment,
    make_budget,
    make_coupling,
    make_density,
    make_output,
    make_procedure,
    with_checks,
    with_indices,
)

from budget.inputs import load_device, load_procedure
from budget.question import question_of
from budget.report.figures.contributions import (
    Critical,
    correlated,
    correlation_chart,
    tornado_chart,
    waterfall_chart,
)
from budget.report.figures.density import density_plot
from budget.report.figures.outputs import (
    overview_chart,
    utilisation_chart,
    validity_chart,
)
from budget.report.figures.rows import draw
from budget.report.figures.sources import coupling_chart, share_chart, sobol_chart
from budget.report.figures.timeline import schedule_chart
from budget.report.tables import group_tables
from budget.resources import shipped
from budget.studies.analysis import analyze
from budget.studies.evidence import coupling


@cache
def budget(name):
    """Return the budget of a shipped device."""
    path = shipped("specs") / "devices" / f"{name}.yaml"
    return analyze(load_device(path), validate=False)


def bars(chart):
    """Return the bars of all rows by the name of their row."""
    return {row.label: row.marks[0] for group in chart.groups for row in group.rows}


def test_tornado_is_c_u_on_both_sides():
    """Each bar runs from -c u(x) to +c u(x), the longest first."""
    for group in group_tables(budget("zhao-2019")):
        critical = Critical.of(group, None)
        chart = tornado_chart(critical)
        if len(critical.sources) < 2:
            assert chart is None
            continue
        found = bars(chart)
        sizes = [bar.end for bar in found.values()]
        for source in group.sources:
            if source.title in found:
                part = source.cells[critical.place]
                u = (part.linear or part.u).exact
                assert_allclose(found[source.title].end, u, rtol=1e-12)
                assert_allclose(found[source.title].start, -u, rtol=1e-12)
        assert sizes == sorted(sizes, reverse=True)


def test_waterfall_ends_at_u():
    """Steps are k u of each source squared; the last one ends where U does."""
    for group in group_tables(budget("zhao-2019")):
        critical = Critical.of(group, None)
        chart = waterfall_chart(critical)
        if chart is None:
            assert len(critical.sources) < 2
            continue
        steps = [*bars(chart).values()]
        squares = 0.0
        for source, bar in zip(critical.sources, steps, strict=False):
            k = critical.row.k.exact
            assert_allclose(bar.start, k**2 * squares, rtol=1e-12, atol=1e-15)
            squares += source.cells[critical.place].u.exact ** 2
            assert_allclose(bar.end, k**2 * squares, rtol=1e-12)
        assert_allclose(steps[-1].end, critical.row.expanded.exact**2, rtol=1e-12)
        assert_allclose(steps[-2].end, steps[-1].end, rtol=1e-9)


def test_the_critical_output_is_the_one_nearest_its_limit():
    """With a requirement it is the largest utilisation, without the largest U."""
    assessment = make_assessment(make_budget())
    for group in group_tables(make_budget()):
        used = {
            one.output.name.axis: one.utilisation
            for one in assessment.outputs
            if one.output.name.group == f"{group.sensor}.{group.parameter}"
        }
        critical = Critical.of(group, assessment)
        if used:
            assert_allclose(critical.limit.utilisation, max(used.values()), rtol=1e-12)
        assert Critical.of(group, None).row == group.widest


def test_what_does_not_vary_has_no_figure():
    """Without spread there is neither, and outputs without correlation have no map."""
    still = make_output(
        "gyro", "bias", "x", unit="deg/h", scale=1.0, sources={"bias_stability": 0.0}
    )
    critical = Critical.of(group_tables(make_budget(outputs=(still,)))[0], None)

    assert tornado_chart(critical) is None
    assert waterfall_chart(critical) is None
    assert correlation_chart(make_budget()) is None


def test_the_map_has_every_correlation_from_one_per_cent():
    """As many cells as entries of the matrix off its diagonal, with their sign."""
    made = make_budget()
    u = np.sqrt(np.diag(made.covariance))
    r = np.eye(len(u))
    r[0, 5] = r[5, 0] = -0.42
    r[2, 7] = r[7, 2] = 0.008
    made = replace(made, covariance=r * np.outer(u, u))
    chart = correlation_chart(made)
    texts = [mark.text for g in chart.groups for row in g.rows for mark in row.marks]

    assert correlated(made) == [0, 5]
    assert texts == ["-42", "-42"]
    assert "-42 %" in chart.title
    assert "-42 %" in chart.alt


def charts(name):
    """Yield the figures of one budget."""
    of = budget(name)
    groups = group_tables(of)
    for group in groups:
        critical = Critical.of(group, None)
        yield tornado_chart(critical)
        yield waterfall_chart(critical)
    yield share_chart(groups[-1])
    yield correlation_chart(of)
    yield overview_chart(groups)
    table = coupling(question_of(of))
    yield from (coupling_chart(table, sensor) for sensor in ("gyro", "accelerometer"))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["zhao-2019", "bmi088"])
def test_labels_are_whole_and_on_no_line(name):
    """No text leaves the canvas, lies on a line or on another text."""
    for chart in charts(name):
        if chart is not None:
            figure = draw(chart)
            assert cut_texts(figure) == [], chart.name
            assert crossed_texts(figure) == [], chart.name


def test_limits_stand_beside_no_label():
    """The same where limits are drawn."""
    assessment = make_assessment(make_budget())
    assert crossed_texts(draw(utilisation_chart(assessment))) == []
    for group in group_tables(make_budget())[:3]:
        critical = Critical.of(group, assessment)
        chart = waterfall_chart(critical)
        if chart is None:
            continue
        figure = draw(chart)
        assert cut_texts(figure) == []
        assert crossed_texts(figure) == []


def test_a_label_on_a_line_is_found():
    """Control: a text on a line and one beyond the canvas are seen."""
    figure = Figure(figsize=(2.0, 2.0))
    axes = figure.add_axes((0.1, 0.1, 0.8, 0.8))
    axes.set_axis_off()
    axes.axvline(0.5)
    axes.text(0.4, 0.5, "on the line")
    axes.text(0.9, 0.9, "far beyond the canvas")

    assert ("on the line", "line") in crossed_texts(figure)
    assert [text for text, _ in cut_texts(figure)] == ["far beyond the canvas"]


def other_charts():
    """Return the other figures of a report."""
    budget = with_checks(make_budget())
    return [
        schedule_chart(make_procedure(), ("gyro", "accelerometer")),
        validity_chart(budget, "gyro"),
        sobol_chart(with_indices(make_budget()), "gyro"),
        coupling_chart(make_coupling(), "gyro"),
    ]


@pytest.mark.parametrize("place", range(4))
def test_labels_of_other_figures_stand_free(place):
    """The schedule, the check of the law, indices and the coupling likewise."""
    figure = draw(other_charts()[place])

    assert cut_texts(figure) == []
    assert crossed_texts(figure) == []


def test_labels_of_a_density_stand_free():
    """Limits and intervals of a distribution keep their words beside them."""
    figure = density_plot(make_density(), coverage=0.95).figure

    assert cut_texts(figure) == []
    assert crossed_texts(figure) == []


@pytest.mark.slow
@pytest.mark.parametrize("trials", [20, 40])
def test_waterfall_of_trials_goes_by_the_law_first(trials):
    """Sources grow to the law's U; the trials' is a step apart, and U the last."""
    # A tenth of the samples: the figure is of what the trials found, whatever it was.
    slow = {"procedure": replace(load_procedure(None), sample_rate=10.0)}
    own = load_device("hg4930#A")
    of = analyze(own, method="simulation", trials=trials, **slow)
    law = analyze(own, validate=False, **slow)
    for group, own in zip(group_tables(of), group_tables(law), strict=True):
        critical = Critical.of(group, None)
        steps = bars(waterfall_chart(critical))
        apart = steps["trials in place of GUM propagation"]
        by_law = own.rows[critical.place].expanded.exact
        assert_allclose(apart.start, by_law**2, rtol=1e-6)
        assert_allclose(apart.end, critical.row.expanded.exact**2, rtol=1e-12)
        grows = [bar for name, bar in steps.items() if name in step_names(group)]
        assert all(bar.end >= bar.start for bar in grows)
        assert len(grows) >= 1
        assert_allclose(steps["U95"].end, critical.row.expanded.exact**2, rtol=1e-12)


def step_names(group):
    """Return what steps of sources are called."""
    return {"all others", *(source.title for source in group.sources)}


def test_tornado_leaves_the_second_order_to_the_table():
    """Its bars are c u(x), the table's number: of a curved source less than its u."""
    groups = group_tables(budget("zhao-2019"))
    critical = Critical.of(next(g for g in groups if g.title == "gyro bias"), None)
    source = critical.sources[0]
    cells = [
        replace(part, linear=replace(part.u, text="0.01", exact=part.u.exact / 2.0))
        for part in source.cells
    ]
    curved = replace(source, cells=tuple(cells))
    others = [one for one in critical.group.sources if one.source != source.source]
    group = replace(critical.group, sources=(curved, *others))
    half = source.cells[critical.place].u.exact / 2.0

    found = bars(tornado_chart(replace(critical, group=group)))
    assert_allclose(found[source.title].end, half, rtol=1e-12)
