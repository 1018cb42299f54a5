"""Numbers and tables for people."""

from __future__ import annotations

from dataclasses import replace

import pytest
from reading import assert_says
from report_examples import GYRO, make_budget, make_output, make_outputs

from budget import load_device, load_procedure
from budget.language import say, speaking
from budget.missing.expected import could_widen
from budget.names import Name, key_title
from budget.problem import Output
from budget.report.pages import line
from budget.report.standing import not_given_lines
from budget.report.tables import (
    align_decimals,
    group_tables,
    print_contributions,
    print_given,
    print_share,
    print_two_down,
    print_utilisation,
    round_error,
    round_uncertainty,
    round_value,
    settings_lines,
    source_title,
)
from budget.report.writing import print_part
from budget.results import Validation
from budget.units import DEG_PER_HOUR


@pytest.mark.parametrize(
    ("u", "printed"),
    [
        (0.0563, "0.056"),
        (0.0995, "0.10"),
        (0.00995, "0.010"),
        (0.09949, "0.099"),
        (0.125, "0.13"),
        (0.5, "0.50"),
        (1.0, "1.0"),
        (9.96, "10"),
        (50.12, "50"),
        (99.4, "99"),
        (99.6, "100"),
        (123.4, "120"),
        (1234.0, "1200"),
        (9_949_999.0, "9900000"),
        (9_960_000.0, "1.0e7"),
        (1.26e12, "1.3e12"),
        (0.000123, "0.00012"),
        (0.0000996, "0.00010"),
        (0.0000123, "1.2e-5"),
        (2.4e-9, "2.4e-9"),
        (5e-324, "5.0e-324"),
        (0.0, "0"),
    ],
)
def test_uncertainty_keeps_two_significant_digits(u, printed):
    """An uncertainty is printed with two significant digits, after the carry too."""
    assert round_uncertainty(u) == printed


@pytest.mark.parametrize(
    ("value", "u", "printed"),
    [
        (2.5, 0.0563, "2.500"),
        (2.49951, 0.0995, "2.50"),
        (0.0, 0.0563, "0.000"),
        (-1e-9, 0.0563, "0.000"),
        (-0.1105, 0.0563, "-0.111"),
        (123.456, 99.6, "120"),
        (-123.456, 1234.0, "-100"),
        (49.0, 1234.0, "0"),
        (1.23456e-7, 2.4e-9, "1.235e-7"),
        (0.0, 2.4e-9, "0"),
        (3.0, 0.0, "3"),
        (-3.1826454e-10, 0.0, "-3.18265e-10"),
        (0.0, 0.0, "0"),
    ],
)
def test_value_ends_where_its_uncertainty_ends(value, u, printed):
    """A value has the last decimal place of its uncertainty, and no minus zero."""
    assert round_value(value, u) == printed


def test_spread_at_resolution_prints_as_zero():
    """A spread of exactly the resolution prints as 0, one just above does not."""
    assert round_uncertainty(1e-14, resolution=1e-14) == "0"
    assert round_uncertainty(1.1e-14, resolution=1e-14) == "1.1e-14"


def test_value_within_resolution_without_spread_prints_as_zero():
    """A mean that is only rounding is not printed as a finding."""
    assert round_value(-3e-15, 2e-15, resolution=1e-14) == "0"
    assert round_value(-3e-10, 2e-15, resolution=1e-14) == "-3e-10"


@pytest.mark.parametrize("u", [-1.0, float("nan"), float("inf")])
def test_no_uncertainty_is_negative_or_endless(u):
    """What is no uncertainty is refused, not printed."""
    with pytest.raises(ValueError, match="expected a finite number from 0"):
        round_uncertainty(u)
    with pytest.raises(ValueError, match="expected a finite number from 0"):
        round_value(1.0, u)


def test_value_must_be_finite():
    """A value that is not finite is refused, not printed."""
    with pytest.raises(ValueError, match="a value of nan"):
        round_value(float("nan"), 1.0)


@pytest.mark.parametrize(
    ("part", "printed"),
    [(1e-12, "0"), (1e-11, "<0.1"), (5e-4, "0.1"), (0.0996, "10.0"), (0.104, "10")],
)
def test_part_of_a_squared_limit_is_nothing_only_where_it_is_so(part, printed):
    """Beside rounding of 1e-12 a part is more than 0."""
    assert print_part(part) == printed


@pytest.mark.parametrize(
    ("share", "printed"),
    [
        (0.0, "0 %"),
        (1e-12, "<0.1 %"),
        (0.00099, "<0.1 %"),
        (0.001, "0.1 %"),
        (0.0049, "0.5 %"),
        (0.01, "1 %"),
        (0.786, "79 %"),
        (0.994, "99 %"),
        (0.996, ">99 %"),
        (0.9999999, ">99 %"),
        (1.0 - 1e-15, "100 %"),
        (1.0, "100 %"),
    ],
)
def test_share_says_nothing_and_all_only_where_it_is_so(share, printed):
    """0 % stands for exactly none and 100 % for all of the variance."""
    assert print_share(share) == printed


@pytest.mark.parametrize(
    ("utilisation", "printed"),
    [
        (0.0, "0 %"),
        (0.56, "56.0 %"),
        (0.0042, "0.420 %"),
        (1.0 - 1e-13, "100 %"),
        (1.0 + 1e-13, "100 %"),
        (0.9949, "99.5 %"),
        (0.9996, "99.96 %"),
        (0.99999, "99.999 %"),
        (1.0 - 1e-8, "<100 %"),
        (1.0, "100 %"),
        (1.0 + 1e-8, ">100 %"),
        (1.0004, "100.04 %"),
        (1.00001, "100.001 %"),
        (1.004, "100.4 %"),
        (1.37, "137 %"),
    ],
)
def test_utilisation_does_not_round_across_the_limit(utilisation, printed):
    """A failing output never prints as 100 % of its limit, nor one that meets."""
    assert print_utilisation(utilisation) == printed


@pytest.mark.parametrize(
    ("error", "limit", "printed"),
    [
        (2.388, 2.4, "2.39"),
        (2.412, 2.4, "2.41"),
        (2.4004, 2.4, "2.4004"),
        (2.4, 2.4, "2.4"),
        (2.435, 2.435, "2.435"),
        (2.1, 2.4, "2.1"),
        (2.4, None, "2.4"),
        (2.4 - 1e-9, 2.4, "2.4"),  # no digits tell: the part of the limit says <100 %
    ],
)
def test_an_error_does_not_round_across_its_limit(error, limit, printed):
    """Digits are added to two of u until it stands on its side of the limit."""
    output = Output(name="gyro.bias.x", unit="deg/h", si_per_unit=DEG_PER_HOUR)
    found = round_error(
        error * DEG_PER_HOUR,
        1.2 * DEG_PER_HOUR,
        output,
        limit=None if limit is None else limit * DEG_PER_HOUR,
    )
    assert found.text == printed


@pytest.mark.parametrize(
    ("value", "printed"),
    [(0.0125, "0.0125"), (300.0, "300"), (50.0, "50"), (1.1547, "1.155"), (0.0, "0")],
)
def test_given_figures_keep_their_digits(value, printed):
    """A figure that was given is not cut to two digits and gets no zeros."""
    assert print_given(value) == printed


@pytest.mark.parametrize(
    ("value", "printed"),
    [(1.299, "1.2"), (0.0999, "0.099"), (1290.0, "1200"), (1.3, "1.3"), (0.0, "0")],
)
def test_what_has_to_do_is_rounded_down(value, printed):
    """Two digits, none of them up: what is printed keeps the limit."""
    assert print_two_down(value) == printed


def test_causes_add_up_to_the_whole():
    """The largest contributions are named and what is left is said as rest."""
    shares = [("a", 0.06), ("b", 0.93), ("c", 0.006), ("d", 0.004)]

    assert print_contributions(shares) == "b 93 %, a 6 %, rest 1 %"


def test_causes_of_no_spread():
    """Without any variance no contribution is named."""
    assert print_contributions([("a", 0.0)]) == "no spread"


@pytest.mark.parametrize(
    ("name", "title"),
    [
        (Name("bias_repeatability", owner="gyro"), "bias repeatability"),
        (Name("velocity_random_walk", owner="accelerometer"), "velocity random walk"),
        ("interaction", "products of two sources"),
    ],
)
def test_titles_of_sources(name, title):
    """A dotted name becomes the words that people use."""
    assert source_title(name) == title


def test_title_of_output():
    """An output is named sensor, parameter, axis."""
    assert (
        key_title(Name("mounting_angle", owner="gyro", axis="xy"))
        == "gyro mounting angle xy"
    )


def test_groups_hold_every_output_once():
    """Every output stands in one row of one group, in the order of the budget."""
    budget = make_budget()

    names = [
        f"{group.sensor}.{group.parameter}.{row.axis}"
        for group in group_tables(budget)
        for row in group.rows
    ]

    assert names == [row.output.name for row in budget.outputs]


def test_every_source_of_every_output_stands_in_its_group():
    """No source is dropped on the way into a table, zero or not."""
    budget = make_budget()

    for group in group_tables(budget):
        for place, row in enumerate(group.rows):
            output = budget.output(f"{group.sensor}.{group.parameter}.{row.axis}")
            found = {s.source: s.cells[place].share.exact for s in group.sources}
            assert found == {c.source: c.share for c in output.contributions}


def test_sources_are_ranked_over_the_group():
    """The source with the most variance over all axes stands first."""
    table = group_tables(make_budget())[2]

    assert [row.title for row in table.sources[:3]] == [
        "bias repeatability",
        "bias stability",
        "angle random walk",
    ]
    assert (
        table.contributions == "bias repeatability 74 %, bias stability 24 %, rest 2 %"
    )


def test_numbers_are_in_printed_units():
    """SI goes in, the printed unit comes out."""
    row = group_tables(make_budget())[2].rows[0]

    assert (row.mean.text, row.u.text, row.expanded.text) == ("0.000", "0.057", "0.112")
    assert (row.low.text, row.high.text) == ("-0.112", "0.112")


def test_unresolved_output_has_no_shares():
    """Where the spread is only rounding, its contributions are not told apart."""
    output = make_output(
        "gyro",
        "bias",
        "x",
        unit="deg/h",
        scale=1.0,
        sources={"bias_stability": 1e-15},
        resolution=1e-14,
    )
    table = group_tables(make_budget(outputs=(output,)))[0]

    assert table.rows[0].u.text == "0"
    assert table.sources[0].share.text == "0 %"
    assert table.contributions == "no spread"


def test_lopsided_interval_is_seen():
    """An interval that is not mean +- U is marked as such, a centred one is not."""
    centred = group_tables(make_budget(outputs=make_outputs("gyro", GYRO)))
    skewed = group_tables(make_budget(outputs=make_outputs("gyro", GYRO, skew=0.3)))

    assert all(row.is_centred for group in centred for row in group.rows)
    assert not any(row.is_centred for group in skewed for row in group.rows)


@pytest.mark.parametrize(("low", "word"), [(0.011, "fails"), (0.004, "unsettled")])
def test_validation_names_the_axis_that_fails(low, word):
    """A law that fails says where; one within the tolerance is not said to fail."""
    check = Validation(
        trials=230_000,
        holds=False,
        difference_low=low,
        difference_high=0.002,
        tolerance=0.005,
        reached=0.001,
        interval=(-0.19, 0.2),
    )
    output = make_output(
        "gyro",
        "bias",
        "x",
        unit="deg/h",
        scale=1.0,
        sources={"bias_stability": 0.1},
        validation=check,
    )
    table = group_tables(make_budget(outputs=(output,)))[0]

    shown = round_uncertainty(low)
    said = line("analysis/group", "law_of", group=table)
    assert_says(said, "Monte Carlo with 230 000 trials", f"x {word}")
    assert_says(said, f"difference {shown} deg/h", "tolerance 0.0050")
    assert table.rows[0].check == word


def test_points_are_in_line():
    """Set flush right, padded texts have their decimal points in one column."""
    texts = align_decimals(["50", "0.69", "8.7"])
    widest = max(len(text) for text in texts)

    assert [text.rjust(widest) for text in texts] == ["50   ", " 0.69", " 8.7 "]


@pytest.mark.parametrize(
    ("reference", "nonlinearity"),
    # During this test it is the same; without a full scale no calibration takes it out
    # of a later turn-on.
    [
        ("nominal", "could widen scale factors"),
        ("next_turn_on", "could widen scale factors"),
        ("as_tested", "no effect"),
    ],
)
def test_not_given_says_what_it_could_change(reference, nonlinearity):
    """Absent lines stand together where they reach the same, as the model has it."""
    sensor = replace(
        load_device("zhao-2019").gyro,
        not_given=tuple(
            Name(name, owner="gyro")
            for name in ("rate_random_walk", "scale_factor_nonlinearity")
        ),
    )
    reach = could_widen((sensor,), load_procedure(), reference=reference)

    walk, other = not_given_lines(reach)
    assert_says(walk, "gyro rate random walk:", "widen")
    assert_says(walk, "scale factors, mounting angles and biases")
    assert_says(other, "gyro scale factor nonlinearity:", nonlinearity)
    assert ("widen" in other) is (reference != "as_tested")


def test_an_absent_repeatability_reaches_its_own_parameter_only():
    """One parameter is named alone, by its plural."""
    name = Name("mounting_repeatability", owner="accelerometer")
    sensor = replace(load_device("zhao-2019").accelerometer, not_given=(name,))
    reach = could_widen((sensor,), load_procedure(), reference="nominal")

    (said,) = not_given_lines(reach)
    assert_says(said, "accelerometer mounting repeatability:", "mounting angles")
    assert "bias" not in said


def test_settings_hold_everything_a_result_depends_on():
    """Method, trials, seed, coverage, interval, reference, formulas, none left out."""
    lines = dict(settings_lines(replace(make_budget().settings, trials=230_000)))

    assert lines == {
        "method": "gum",
        "trials": "230 000",
        "seed": "0",
        "coverage": "95 %",
        "interval": "symmetric",
        "error reference": "nominal",
        "formulas": "corrected",
    }


def test_settings_have_names_in_every_language():
    """Their names are no templates of the code, and are said where they are shown."""
    chosen = replace(
        make_budget().settings,
        only=("gyro.bias_stability",),
        outputs=(Name("bias", owner="gyro", axis="x"),),
        missing="worst",
    )
    names = [name for name, _ in settings_lines(chosen)]
    with speaking("zh"):
        assert [name for name in names if say(name) == name] == []
    assert len(names) == 10


def test_sources_set_to_zero_are_told():
    """A run of some sources alone says which."""
    only = replace(make_budget().settings, only=("gyro.bias_stability",))

    assert settings_lines(only)[-1] == ("only", "gyro.bias_stability")


def test_a_line_that_acts_by_a_use_is_said_to():
    """At a later turn-on; in the test of a calibration it changes nothing."""
    gyro = load_device("stim300#5g").gyro
    for reference, is_later in (("next_turn_on", True), ("nominal", False)):
        reach = could_widen((gyro,), load_procedure(), reference=reference)
        said = not_given_lines(reach, is_later=is_later)
        (line,) = [one for one in said if "vibration rectification" in one]
        assert ("acts by the vibration at use, which is 0 or not" in line) is is_later
