"""Figures: what they show, what they say, and that their bytes stay."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache
from itertools import pairwise
from math import erfc, sqrt

import numpy as np
import pytest
from figure_text import cut_texts, texts
from numpy.testing import assert_allclose
from reading import assert_says, find
from report_examples import (
    GYRO,
    make_assessment,
    make_budget,
    make_coupling,
    make_density,
    make_output,
    make_procedure,
    with_checks,
    with_indices,
)

from budget.inputs.records import AccelerometerProcedure
from budget.names import Name
from budget.report.analysis.groups import budget_section
from budget.report.blocks import Picture
from budget.report.figures.density import (
    density_plot,
    part_beyond,
)
from budget.report.figures.outputs import (
    overview_chart,
    utilisation_chart,
    validity_chart,
)
from budget.report.figures.rows import Chart, chart_picture, draw
from budget.report.figures.sources import (
    STEPS,
    coupling_chart,
    group_shares_chart,
    print_part,
    share_chart,
    sobol_chart,
)
from budget.report.figures.style import (
    BLACK,
    BLUE,
    INK,
    INKS,
    ON_DARK,
    REST,
    folded,
    headed,
    in_order,
    looks,
    to_svg,
)
from budget.report.figures.timeline import schedule_chart
from budget.report.tables import group_tables
from budget.resources import template_file

BIAS = 2  # place of the gyro bias among the groups
BOTH = ("gyro", "accelerometer")
UNIT = {"unit": "deg/h", "scale": 1.0}


def bias_group(sources, **options):
    """Return a gyro bias group of one axis from its sources."""
    output = make_output("gyro", "bias", "x", sources=sources, **UNIT, **options)
    return group_tables(make_budget(outputs=(output,)))[0]


def widths(figure):
    """Return the widths of the bars from left to right, line by line [%]."""
    return [bar.get_width() for bar in figure.axes[0].patches]


def test_same_figure_gives_same_bytes():
    """Drawing twice gives the same SVG, with no date in it."""
    group = group_tables(make_budget())[BIAS]
    first, second = (to_svg(draw(share_chart(group)), name="f") for _ in range(2))

    assert first == second
    assert "dc:date" not in first


def test_drawing_leaves_no_global_state():
    """The settings of matplotlib are the same after a figure as before."""
    import matplotlib as mpl

    before = dict(mpl.rcParams)

    to_svg(draw(share_chart(group_tables(make_budget())[BIAS])), name="f")

    assert dict(mpl.rcParams) == before


def test_text_stays_text():
    """Labels are found by a search: they are no outlines."""
    found = texts(draw(share_chart(group_tables(make_budget())[BIAS])))

    assert "bias repeatability" in found
    assert "77 %" in found


def test_ids_begin_with_the_name_of_the_figure():
    """Several figures on one page share no id, and references point to their own."""
    svg = to_svg(draw(share_chart(group_tables(make_budget())[BIAS])), name="gyro-bias")

    assert svg.count('id="') == svg.count('id="gyro-bias-')
    assert svg.count("url(#") == svg.count("url(#gyro-bias-")
    assert svg.count('href="#') == svg.count('href="#gyro-bias-')


def test_each_bar_is_the_whole_variance():
    """The segments of one output add up to 100 %, small ones gathered."""
    for group in group_tables(make_budget()):
        bars = widths(draw(share_chart(group)))
        assert_allclose(sum(bars), 100.0 * len(group.rows), rtol=1e-12)


def test_sources_below_one_per_cent_are_gathered():
    """A source of 0.5 % and one of 0.4 % become one segment 'other'."""
    group = bias_group(
        {
            "bias_repeatability": 1.0,
            "bias_stability": 0.005**0.5,
            "angle_random_walk": 0.004**0.5,
        }
    )

    assert len(widths(draw(share_chart(group)))) == 2
    assert "all others together 0.9 %" in share_chart(group).alt


def test_each_group_has_a_bar_of_its_whole_variance():
    """Its segments add up to 100 %; a source keeps colour and place in all bars."""
    budget = make_budget()
    chart = group_shares_chart(budget)
    rows = chart.groups[0].rows

    assert [row.label for row in rows] == [one.title for one in group_tables(budget)]
    for row, group in zip(rows, group_tables(budget), strict=True):
        assert row.marks[0].start == 0.0
        assert_allclose(row.marks[-1].end, 100.0, rtol=1e-12)
        inks = [mark.colour for mark in row.marks if mark.colour != REST]
        order = [looks()[name.quantity][0] for name in in_order(sources_of(group))]
        assert inks == [one for one in order if one in inks]
    assert_says(chart.title, "of the variance of the")
    assert "rest" not in chart.alt


def sources_of(group):
    """Return the sources of a group."""
    return [row.source for row in group.sources]


def test_bars_of_groups_name_each_source_once():
    """A source is named in a bar, or at the foot, and at the foot only once."""
    chart = group_shares_chart(make_budget())
    named = {mark.text for row in chart.groups[0].rows for mark in row.marks}
    foot = [name for _, _, name in chart.legend]

    assert len(set(foot)) == len(foot)
    assert not named & set(foot)
    assert "bias repeatability" in named


def test_one_group_alone_is_no_figure():
    """A single bar says no more than a sentence."""
    output = make_output("gyro", "bias", "x", sources={"bias_stability": 1.0}, **UNIT)

    assert group_shares_chart(make_budget(outputs=(output,))) is None


def test_unknown_source_is_gathered_and_not_lost():
    """A source without a colour of its own counts among the others."""
    group = bias_group({"bias_repeatability": 1.0, "levelling": 1.0})

    assert "all others together 50 %" in share_chart(group).alt


def test_order_of_segments_is_that_of_the_styles():
    """Segments keep their place even where the ranking is another."""
    group = bias_group({"bias_stability": 3.0, "bias_repeatability": 1.0})

    assert group.sources[0].title == "bias stability"
    assert re.search(
        "x: bias repeatability 10 %, [^;]*; bias stability 90 %, ",
        share_chart(group).alt,
    )


def test_a_source_looks_the_same_in_both_triads_only():
    """No two sources of one triad share colour and hatch."""
    twins = {"velocity_random_walk", "acceleration_random_walk"}
    found = [look[:2] for name, look in looks().items() if name not in twins]

    assert len(set(found)) == len(found)


def test_title_states_the_largest_cause():
    """The title names the source and its share of the variance of the group."""
    group = group_tables(make_budget())[BIAS]

    title = share_chart(group).title
    assert_says(title, "bias repeatability", "74 % of the gyro bias variance")
    assert "stability" not in title


def test_title_without_majority_names_two():
    """Where no source makes half, the two largest are named together."""
    sources = dict.fromkeys(
        ("bias_repeatability", "bias_stability", "angle_random_walk"), 1.0
    )

    title = share_chart(bias_group(sources)).title
    assert_says(title, "bias repeatability and bias stability", "67 % of the gyro bias")


def test_group_without_spread_is_drawn_as_such():
    """Where nothing varies the figure says so instead of being empty."""
    group = bias_group({"bias_repeatability": 0.0})

    assert "no spread" in texts(draw(share_chart(group)))
    assert share_chart(group).title == "The gyro bias has no spread"
    assert share_chart(group).alt.endswith("x: no spread.")


def test_name_stands_in_the_legend_only_where_no_label_fits():
    """A source named at its segment is not named again below."""
    found = texts(draw(share_chart(group_tables(make_budget())[BIAS])))

    assert found.count("bias repeatability") == 1
    assert found.count("angle random walk") == 1


def test_every_required_output_has_its_dot():
    """One row for each required output, its utilisation written beside it."""
    assessment = make_assessment(make_budget())
    found = texts(draw(utilisation_chart(assessment)))

    assert found.count("119 %") == 1
    assert sum(text.endswith(" %") for text in found) == len(assessment.outputs)


def test_utilisation_title_counts_the_failing():
    """The title says how many outputs fail and which is worst."""
    assessment = make_assessment(make_budget())

    title = utilisation_chart(assessment).title
    assert_says(title, "3 of 24 outputs exceed", "gyro bias z at 119 % of the limit")


def test_utilisation_title_without_failing():
    """Where all meet, the title names the nearest to its limit."""
    assessment = make_assessment(make_budget(), {"gyro.bias": ("1 deg/h", 1.0)})

    title = utilisation_chart(assessment).title
    assert_says(title, "all 3 outputs", "within", "gyro bias z at 11.9 % of the limit")


def test_utilisation_title_of_one_output():
    """One output is not said to be all 1, nor 1 of 1."""
    budget = make_budget()
    for limit, said in ((1.0, "is within its limit"), (0.01, "exceeds its limit")):
        every = make_assessment(budget, {"gyro.bias": ("a limit", limit)})
        one = replace(every, outputs=every.outputs[2:])

        assert_says(utilisation_chart(one).title, "The one output", said, "gyro bias z")


def test_utilisation_title_names_all_that_the_law_finds_equal():
    """Equal axes whose trials differ by chance are named together, as on page one."""
    assessment = make_assessment(make_budget())
    (gyro, other) = assessment.sensors
    names = tuple(Name("bias", owner="gyro", axis=axis) for axis in "xyz")
    equal = replace(assessment, sensors=(replace(gyro, worst_outputs=names), other))

    assert "most of all gyro bias x, y, z at 119 %" in utilisation_chart(equal).title


def test_utilisation_alt_has_every_number():
    """The words hold each output's utilisation, worst group first, axes in order."""
    alt = utilisation_chart(make_assessment(make_budget())).alt

    limit = "0.1 deg/h"
    assert f"Bias: x 112 %, {limit}; y 112 %, {limit}; z 119 %, {limit}; Scale" in alt


def test_far_exceeded_limits_fit_the_axis():
    """With a utilisation of 1200 % beside one of 10 % the axis is logarithmic."""
    limits = {"gyro.bias": ("0.01 deg/h", 0.01), "gyro.scale_factor": ("1 %", 1e4)}
    figure = draw(utilisation_chart(make_assessment(make_budget(), limits)))

    assert figure.axes[0].get_xscale() == "log"
    assert "1190 %" in texts(figure)


def test_styles_cover_the_example_sources():
    """Every source of the built-in device has a colour of its own."""
    assert {name for sources in GYRO.values() for name in sources} <= set(looks())


# Every figure of the report, from one example each.
PICTURES = {
    "groups": lambda: group_shares_chart(make_budget()),
    "shares": lambda: share_chart(group_tables(make_budget())[BIAS]),
    "utilisation": lambda: utilisation_chart(make_assessment(make_budget())),
    "coupling": lambda: coupling_chart(make_coupling(), "gyro"),
    "schedule": lambda: schedule_chart(make_procedure(), BOTH),
    "density": lambda: density_plot(make_density(), coverage=0.95).picture,
    "validity": lambda: validity_chart(
        with_checks(make_budget(), {"gyro.bias.x": -7.0}), "gyro"
    ),
    "sobol": lambda: sobol_chart(with_indices(make_budget(), 0.1), "gyro"),
    "overview": lambda: overview_chart(group_tables(make_budget())),
}
FIGURES = {
    "density": lambda: density_plot(make_density(), coverage=0.95).figure,
}
WORDS_HAVE_DATA = ("utilisation", "validity", "sobol", "overview")


def make_anew(name):
    """Return an example as a block."""
    made = PICTURES[name]()
    return chart_picture(made) if isinstance(made, Chart) else made


make = cache(make_anew)


@pytest.mark.parametrize("name", PICTURES)
def test_each_picture_has_the_same_bytes_twice(name):
    """A picture is equal to itself made again."""
    assert make(name) == make_anew(name)


@pytest.mark.parametrize("name", PICTURES)
def test_each_tip_belongs_to_one_element(name):
    """The element of a tip has the id of name and gid, once in the picture."""
    picture = make(name)

    for gid in picture.tips:
        assert picture.svg.count(f' id="{picture.name}-{gid}"') == 1


@pytest.mark.parametrize("name", WORDS_HAVE_DATA)
def test_words_have_the_numbers_of_the_data(name):
    """Every number of the table behind a picture stands in its alternative text."""
    picture = make(name)
    cells = [c for g in picture.data.groups for row in g.rows for c in row]
    numbers = {cell.text for cell in cells if cell.exact is not None}

    assert numbers
    assert not {text for text in numbers if text not in picture.alt}


@pytest.mark.parametrize("name", PICTURES)
def test_words_begin_with_the_finding(name):
    """The alternative text says the finding before the numbers."""
    picture = make(name)

    assert picture.alt.startswith(f"{picture.title}. ")


@pytest.mark.parametrize("name", PICTURES)
def test_no_text_is_smaller_than_eight_points(name):
    """Everything that is written can be read at the size it was drawn for."""
    sizes = re.findall(r"([\d.]+)px", make(name).svg)

    assert sizes
    assert min(map(float, sizes)) >= 8.0


@pytest.mark.parametrize("name", PICTURES)
def test_no_text_is_cut(name):
    """Every text lies within the figure."""
    figure = FIGURES[name]() if name in FIGURES else draw(PICTURES[name]())

    assert cut_texts(figure) == []


def test_every_segment_has_its_tip():
    """There are as many tips as segments, with share and own uncertainty."""
    group = group_tables(make_budget())[BIAS]
    tips = share_chart(group).tips

    assert len(tips) == len(draw(share_chart(group)).axes[0].patches)
    (tip,) = (text for text in tips.values() if "bias z, bias stability" in text)
    assert_says(tip, "gyro bias z, bias stability", "variance 31 %", "[deg/h] 0.034")


def test_sources_have_one_order_and_colour_in_all_figures():
    """Shares, coupling and indices list sources in the order of the styles."""
    names = [name.replace("_", " ") for name in looks()]
    coupling = draw(coupling_chart(make_coupling(), "gyro")).axes[0]
    indices = draw(sobol_chart(with_indices(make_budget()), "gyro")).axes[0]
    rows = [label.get_text() for label in coupling.get_yticklabels()]
    bias = [label.get_text() for label in indices.get_yticklabels()][-3:]
    colours = {line.get_color() for line in indices.lines}

    assert rows == sorted(rows, key=names.index)
    assert bias == ["bias repeatability", "bias stability", "angle random walk"]
    assert {looks()["bias_repeatability"][0], looks()["bias_stability"][0]} <= colours


@pytest.mark.parametrize(("paper", "ink"), [("#ffffff", INK), ("#15181c", "#e6e8eb")])
def test_steps_of_the_map_can_be_told_apart_and_read(paper, ink):
    """Neighbouring hues differ in grey, and the number on each can be read."""
    shades = [mix(BLUE, paper, opacity) for _, opacity in STEPS]
    inks = [ON_DARK if opacity == 1.0 else ink for _, opacity in STEPS]

    for one, other in pairwise([*shades, rgb(paper)]):
        assert contrast(one, other) > 1.08
    for shade, colour in zip(shades, inks, strict=True):
        assert contrast(shade, rgb(colour)) >= 4.5


def rgb(colour):
    """Return red, green and blue of '#rrggbb' [1]."""
    return np.array([int(colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5)])


def mix(colour, paper, opacity):
    """Lay a colour on paper."""
    return opacity * rgb(colour) + (1.0 - opacity) * rgb(paper)


def contrast(one, other):
    """Contrast ratio of two colours, WCAG 2.2."""

    def luminance(colour):
        linear = np.where(
            colour <= 0.04045, colour / 12.92, ((colour + 0.055) / 1.055) ** 2.4
        )
        return float(linear @ [0.2126, 0.7152, 0.0722])

    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def test_nothing_to_show_is_no_picture():
    """Without spread, coupling, triads, checks or indices there is no figure."""
    still = make_output("gyro", "bias", "x", sources={"bias_stability": 0.0}, **UNIT)
    groups = group_tables(make_budget(outputs=(still,)))

    assert not find(budget_section(groups, make_procedure()), Picture)
    assert overview_chart(groups) is None
    nothing = make_coupling({("bias_stability", "bias"): 0.0})
    assert coupling_chart(nothing, "gyro") is None
    assert coupling_chart(make_coupling(), "accelerometer") is None
    assert schedule_chart(make_procedure(), ()) is None
    assert validity_chart(make_budget(outputs=(still,)), "gyro") is None
    assert sobol_chart(make_budget(), "gyro") is None


def test_cells_are_empty_exactly_where_nothing_reaches():
    """The map writes as many numbers as there are paths, frames only own spreads."""
    axes = draw(coupling_chart(make_coupling(), "gyro")).axes[0]
    frames = [p for p in axes.patches if p.get_facecolor()[3] == 0.0]

    assert [t.get_text() for t in axes.texts if t.get_text()[0] in "0123456789>"] == [
        *("89 %", "0.15 %", "3.1e-5", "44 %", "2.0e-7"),
        *("5.0e-4", "15 %", ">99 %", "100 %"),
    ]
    assert len(frames) == 4


def test_words_for_the_map_have_all_its_numbers():
    """Each part of u that is drawn is said, and its data are the same exactly."""
    table = make_coupling()
    picture = coupling_chart(table, "gyro")
    sizes = {cell.size for cell in table.cells if cell.reaches}
    exact = {c.exact for row in picture.data.groups[0].rows for c in row} - {None}

    assert not {size for size in sizes if f" {print_part(size)}" not in picture.alt}
    assert_allclose(sorted(exact), 100.0 * np.array(sorted(sizes)), rtol=1e-12)


def test_coupling_title_names_what_reaches_farthest():
    """The finding is the largest of all that are no own spread."""
    title = coupling_chart(make_coupling(), "gyro").title
    assert_says(
        title, "angle random walk", "cross-coupling", "15 % of the u of the gyro bias"
    )
    own = make_coupling({("bias_stability", "bias"): 1.0})
    title = coupling_chart(own, "gyro").title
    assert_says(title, "each gyro parameter", "only its own spread")


def windows_of(chart):
    """Return the windows of each row of windows, in seconds or minutes."""
    return [
        row.marks for group in chart.groups for row in group.rows if row.marks[0].tip
    ]


def test_schedule_is_drawn_to_scale():
    """Windows are as long as their times; turns too short for a name stand twice."""
    chart = schedule_chart(make_procedure(), BOTH)
    lens, gyro, faces = windows_of(chart)
    lengths = np.array([bar.end - bar.start for bar in gyro])
    axes = draw(chart).axes

    assert_allclose([bar.end - bar.start for bar in lens], 18.0, rtol=1e-9)
    assert_allclose(lengths[:6], lengths[-1] * 18.0 / 300.0, rtol=1e-9)
    assert_allclose([b.end - b.start for b in faces], lengths[-1], rtol=1e-9)
    assert [bar.text for bar in gyro[:6]] == [""] * 6
    assert all(bar.text for bar in (*lens, *gyro[6:], *faces))
    # Seconds of the turns beside minutes of the whole, both from left to right.
    assert axes[0].get_xlim() == (0.0, 108.0)
    assert axes[1].get_xlim() == (0.0, 60.0)


def test_pauses_are_gaps():
    """Between two windows there is room for the pause, to scale."""
    procedure = make_procedure(
        accelerometer=AccelerometerProcedure(dwell=300.0, pause=60.0)
    )
    ((first, second, *_),) = windows_of(schedule_chart(procedure, ("accelerometer",)))

    ratio = (second.start - first.end) / (first.end - first.start)
    assert_allclose(ratio, 60.0 / 300.0, rtol=1e-9)


def test_schedule_title_says_how_long_and_of_what():
    """The finding is the length of each test and what it consists of."""
    gyro, accelerometer = schedule_chart(make_procedure(), BOTH).title.split(";")
    assert_says(gyro, "gyro 21.8 min", "6 turns of 18 s", "4 dwells of 5 min")
    assert_says(accelerometer, "accelerometer 60 min", "12 dwells of 5 min")


def test_part_beyond_the_limit_is_that_of_the_normal_law():
    """In fine bins of a normal density the part beyond two sigma is erfc(sqrt(2))."""
    # A bin is 0.075 sigma wide: the density across it is taken for constant.
    assert_allclose(part_beyond(make_density(0.1)), erfc(sqrt(2.0)), rtol=2e-3)
    assert part_beyond(make_density(1.0)) == 0.0
    assert_allclose(part_beyond(make_density(1e-9)), 1.0, rtol=1e-6)


def test_density_title_says_how_often_the_limit_is_exceeded():
    """The finding is a share of the trials, 'none' where there is none."""
    titles = [
        density_plot(make_density(limit), coverage=0.95).said.title
        for limit in (0.1, 1.0, None)
    ]

    some, none, without = titles
    assert_says(some, "gyro bias z exceeds its limit", "5 % of the trials")
    assert_says(none, "gyro bias z exceeds its limit", "none of 100 000 trials")
    assert_says(without, "gyro bias z: 95 %", "between -0.098 and 0.098 deg/h")


def test_limit_far_away_is_told_and_not_drawn():
    """A limit that would squeeze the density is in the caption, not in the picture."""
    near, far = (
        density_plot(make_density(limit), coverage=0.95).picture for limit in (0.1, 1.0)
    )

    assert near.svg.count(">limit<") == 2
    assert far.svg.count(">limit<") == 0
    assert "The limits, \N{PLUS-MINUS SIGN}1 deg/h, are beyond" in far.caption


def test_differences_keep_their_signs():
    """An interval end of the law below Monte Carlo's is left of zero."""
    budget = with_checks(make_budget(), {"gyro.bias.x": -7.0})

    title = validity_chart(budget, "gyro").title
    assert_says(title, "not confirmed for 1 of 12 gyro outputs", "gyro bias x")
    assert_says(title, "7.00 tolerances")
    alt = validity_chart(budget, "gyro").alt
    assert "Bias: x -7.00, +0.10, fails; y -0.10, +0.10, agrees;" in alt
    assert texts(draw(validity_chart(budget, "gyro"))).count("fails 7.00") == 1


def test_interactions_are_named_only_where_they_can_be_seen():
    """The finding is the largest gap, or that there is none."""
    title = sobol_chart(with_indices(make_budget(), 0.1), "gyro").title
    tiny = sobol_chart(with_indices(make_budget(), 1e-6), "gyro").title
    none = sobol_chart(with_indices(make_budget()), "gyro").title

    assert "interacts in the gyro" in title
    assert_says(tiny, "products of gyro sources", "negligible")
    assert_says(none, "no gyro source interacts", "chance")


def test_overview_without_accelerometer_is_one_column():
    """One sensor alone takes the whole width."""
    groups = group_tables(make_budget())
    one = draw(overview_chart(groups[:3])).axes[0].get_position()
    both = draw(overview_chart(groups)).axes[0].get_position()

    assert one.width > 2.0 * both.width


def test_every_visible_source_of_the_bars_is_named():
    """In grey a segment is known by its name: at the bar, or in the legend below."""
    for group in group_tables(make_budget()):
        found = texts(draw(share_chart(group)))
        seen = {
            row.title
            for row in group.sources
            if any(cell.share.exact >= 0.01 for cell in row.cells)
        }
        assert seen
        assert seen <= set(found)


@pytest.mark.parametrize("figure", ["coupling", "sobol"])
@pytest.mark.parametrize("long", ["scale factor repeatability", "x" * 80])
def test_names_and_numbers_have_the_room_that_they_need(figure, long):
    """A long name widens the margin; a text beside that is too long is cut."""
    chart = PICTURES[figure]()
    group = chart.panels[0].groups[0]
    row = replace(group.rows[0], label="a name", beside=(long,))
    panel = replace(chart.panels[0], groups=(replace(group, rows=(row,)),))
    drawn = draw(replace(chart, panels=(panel,)))

    assert cut_texts(drawn) == []
    assert (long in texts(drawn)) == (len(long) < 80)


def page_inks(is_dark):
    """Return the colours of the style sheet, by their names."""
    sheet = template_file("page.css").read_text(encoding="utf-8")
    light, dark = sheet.split("@media (prefers-color-scheme: dark)", 1)
    found = dict(re.findall(r"(--[\w]+): (#[0-9a-f]{6})", light.split("}")[0]))
    if is_dark:
        found |= dict(re.findall(r"(--[\w]+): (#[0-9a-f]{6})", dark.split("}")[0]))
    return found


@pytest.mark.parametrize("is_dark", [False, True])
def test_every_source_stands_out_from_the_paper(is_dark):
    """Colours have a contrast of 3:1 to both papers, and texts one of 4.5:1 to them."""
    inks = page_inks(is_dark)
    for name, (colour, _, ink) in looks().items():
        shade = rgb(inks["--black"] if colour == BLACK else colour)

        assert contrast(shade, rgb(inks["--paper"])) >= 3.0, name
        assert not ink or contrast(shade, rgb(ink)) >= 4.5, name


def test_colours_are_told_apart_in_grey():
    """No two inks have one lightness: a copy in grey keeps them apart."""
    every = sorted(INKS.values(), key=lambda one: contrast(rgb(one), rgb(BLACK)))

    for one, other in pairwise(every):
        assert contrast(rgb(one), rgb(other)) > 1.08


def test_a_figure_that_stands_alone_says_what_it_is_of():
    """Above it are its finding and the device; on a page the heading has these."""
    chart = group_shares_chart(make_budget())
    before = draw(chart)
    spare = before.get_size_inches()[1]
    alone = headed(draw(chart), "a device")

    found = texts(alone)
    assert "a device" in found
    assert chart.title in " ".join(found)
    assert chart.title not in " ".join(texts(before))
    assert alone.get_size_inches()[1] > spare
    assert cut_texts(alone) == []
    for one, other in zip(before.axes, alone.axes, strict=True):
        assert_allclose(
            one.get_window_extent().size, other.get_window_extent().size, rtol=1e-9
        )


def test_a_long_title_is_broken_in_lines_that_fit():
    """Between words, and within a language that has none; nothing is lost."""
    for text in (
        "a title of several words of some length",
        "偏置重复性占陀螺零偏方差的大部分",
    ):
        lines = folded(text, 80.0, 9.0)

        assert len(lines) > 1
        assert "".join(lines).replace(" ", "") == text.replace(" ", "")
