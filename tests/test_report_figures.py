"""Figures: what they show, what they say, and that their bytes stay."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from numpy.testing import assert_allclose
from report_examples import GYRO, make_assessment, make_budget, make_output

from budget.report.figures import (
    STYLES,
    share_alt,
    share_bars,
    share_title,
    to_svg,
    utilisation_alt,
    utilisation_dots,
    utilisation_title,
)
from budget.report.tables import group_tables

BIAS = 2  # place of the gyro bias among the groups
UNIT = {"unit": "deg/h", "scale": 1.0}


def bias_group(sources, **options):
    """Return a gyro bias group of one axis from its sources."""
    output = make_output("gyro", "bias", "x", sources=sources, **UNIT, **options)
    return group_tables(make_budget(outputs=(output,)))[0]


def texts(figure):
    """Return all texts that stand in the SVG of a figure."""
    root = ET.fromstring(to_svg(figure, name="f"))  # noqa: S314 - our own
    return [
        "".join(e.itertext()) for e in root.iter("{http://www.w3.org/2000/svg}text")
    ]


def widths(figure):
    """Return the widths of the bars from left to right, line by line [%]."""
    return [bar.get_width() for bar in figure.axes[0].patches]


def test_same_figure_gives_same_bytes():
    """Drawing twice gives the same SVG, with no date in it."""
    group = group_tables(make_budget())[BIAS]
    first, second = (to_svg(share_bars(group), name="f") for _ in range(2))

    assert first == second
    assert "dc:date" not in first


def test_drawing_leaves_no_global_state():
    """The settings of matplotlib are the same after a figure as before."""
    import matplotlib as mpl

    before = dict(mpl.rcParams)

    to_svg(share_bars(group_tables(make_budget())[BIAS]), name="f")

    assert dict(mpl.rcParams) == before


def test_text_stays_text():
    """Labels are found by a search: they are no outlines."""
    found = texts(share_bars(group_tables(make_budget())[BIAS]))

    assert "bias repeatability" in found
    assert "77 %" in found


def test_ids_begin_with_the_name_of_the_figure():
    """Several figures on one page share no id, and references point to their own."""
    svg = to_svg(share_bars(group_tables(make_budget())[BIAS]), name="gyro-bias")

    assert svg.count('id="') == svg.count('id="gyro-bias-')
    assert svg.count("url(#") == svg.count("url(#gyro-bias-")
    assert svg.count('href="#') == svg.count('href="#gyro-bias-')


def test_each_bar_is_the_whole_variance():
    """The segments of one output add up to 100 %, small ones gathered."""
    for group in group_tables(make_budget()):
        bars = widths(share_bars(group))
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

    assert len(widths(share_bars(group))) == 2
    assert "other 0.9 %" in share_alt(group)


def test_unknown_source_is_gathered_and_not_lost():
    """A source without a colour of its own counts among the others."""
    group = bias_group({"bias_repeatability": 1.0, "levelling": 1.0})

    assert "other 50 %" in share_alt(group)


def test_order_of_segments_is_that_of_the_styles():
    """Segments keep their place even where the ranking is another."""
    group = bias_group({"bias_stability": 3.0, "bias_repeatability": 1.0})

    assert group.sources[0].title == "bias stability"
    assert share_alt(group).endswith("x: bias repeatability 10 %, bias stability 90 %.")


def test_a_source_looks_the_same_in_both_triads_only():
    """No two sources of one triad share colour and hatch."""
    twins = {"velocity_random_walk", "acceleration_random_walk"}
    looks = [style[:2] for name, style in STYLES.items() if name not in twins]

    assert len(set(looks)) == len(looks)


def test_title_states_the_largest_cause():
    """The title names the source and its share of the variance of the group."""
    group = group_tables(make_budget())[BIAS]

    assert share_title(group) == (
        "Bias repeatability makes 74 % of the gyro bias variance"
    )


def test_title_without_majority_names_two():
    """Where no source makes half, the two largest are named together."""
    sources = dict.fromkeys(
        ("bias_repeatability", "bias_stability", "angle_random_walk"), 1.0
    )

    assert share_title(bias_group(sources)) == (
        "Bias repeatability and bias stability make 67 % of the gyro bias variance"
    )


def test_group_without_spread_is_drawn_as_such():
    """Where nothing varies the figure says so instead of being empty."""
    group = bias_group({"bias_repeatability": 0.0})

    assert "no spread" in texts(share_bars(group))
    assert share_title(group) == "The gyro bias has no spread"
    assert share_alt(group).endswith("x: no spread.")


def test_name_stands_in_the_legend_only_where_no_label_fits():
    """A source named at its segment is not named again below."""
    found = texts(share_bars(group_tables(make_budget())[BIAS]))

    assert found.count("bias repeatability") == 1
    assert found.count("angle random walk") == 1


def test_every_required_output_has_its_dot():
    """One row for each required output, its utilisation written beside it."""
    assessment = make_assessment(make_budget())
    found = texts(utilisation_dots(assessment))

    assert found.count("119 %") == 1
    assert sum(text.endswith(" %") for text in found) == len(assessment.outputs)


def test_utilisation_title_counts_the_failing():
    """The title says how many outputs fail and which is worst."""
    assessment = make_assessment(make_budget())

    assert utilisation_title(assessment) == (
        "3 of 24 outputs exceed their limits, "
        "most of all gyro bias z at 119 % of the limit"
    )


def test_utilisation_title_without_failing():
    """Where all meet, the title names the nearest to its limit."""
    assessment = make_assessment(make_budget(), {"gyro.bias": ("1 deg/h", 1.0)})

    assert utilisation_title(assessment) == (
        "All 3 outputs stay within their limits, "
        "the nearest is gyro bias z at 12 % of the limit"
    )


def test_utilisation_alt_has_every_number():
    """The words for the figure hold each output's utilisation, worst group first."""
    alt = utilisation_alt(make_assessment(make_budget()))

    assert "gyro bias: z 119 %, x 112 %, y 112 %; gyro scale factor:" in alt


def test_far_exceeded_limits_fit_the_axis():
    """With a utilisation of 1200 % beside one of 10 % the axis is logarithmic."""
    limits = {"gyro.bias": ("0.01 deg/h", 0.01), "gyro.scale_factor": ("1 %", 1e4)}
    figure = utilisation_dots(make_assessment(make_budget(), limits))

    assert figure.axes[0].get_xscale() == "log"
    assert "1194 %" in texts(figure)


def test_styles_cover_the_example_sources():
    """Every source of the built-in device has a colour of its own."""
    assert {name for sources in GYRO.values() for name in sources} <= set(STYLES)
