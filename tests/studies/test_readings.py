"""Values whose meaning a data sheet leaves open, and the answer under each meaning."""

from __future__ import annotations

import json
from dataclasses import replace
from math import sqrt

import pytest
from builders import asked
from command_line import call
from numpy.testing import assert_allclose
from reading import assert_says
from reading import say as spoken

import budget
from budget.errors import SpecError
from budget.inputs import load_device
from budget.question import question_of
from budget.report.analysis.verdict import summary, verdict_cards
from budget.report.pages import line
from budget.studies.readings import MOST, effects, under, verdicts_by_reading
from budget.studies.what_if import what_if
from budget.units import DEG_PER_HOUR, PPM

PAPER = budget.load_procedure()
OPEN = {
    "bias_repeatability": "{value: 3 deg/h, reading: [max, 1 sigma]}",
    "bias_stability": "{value: 0.5 deg/h, reading: [sigma, allan_minimum]}",
    "angle_random_walk": "{value: 0.6 deg/h/sqrt(Hz), reading: [one-sided, two-sided]}",
    "scale_factor_repeatability": (
        "{value: 90 ppm, reading: [per axis, root sum square]}"
    ),
    "mounting_repeatability": "{value: 20 arcsec, reading: [1 sigma, 3 sigma]}",
}


# Of a random walk that is no density, whose readings are judged one by one.
JUDGED = OPEN | {
    "angle_random_walk": "{value: 0.01 deg/sqrt(h), reading: [1 sigma, 2 sigma]}"
}


@pytest.fixture
def gyro(tmp_path):
    """Return a function that reads a gyro with these lines, as printed."""

    def read(**lines):
        path = tmp_path / "device.yaml"
        errors = "".join(f"    {name}: {text}\n" for name, text in lines.items())
        head = "name: open\ntechnology: optical\n"
        path.write_text(f"{head}gyro:\n  errors:\n{errors}", encoding="utf-8")
        return load_device(path).gyro

    return read


@pytest.fixture
def limits(tmp_path):
    """Return a function that reads a requirement on gyros."""

    def read(**values):
        path = tmp_path / "limits.yaml"
        text = ", ".join(f"{name}: {value}" for name, value in values.items())
        path.write_text(f"name: l\nlimits: {{gyro: {{{text}}}}}\n", encoding="utf-8")
        return budget.load_requirement(path)

    return read


@pytest.mark.parametrize(
    ("name", "size", "ratio"),
    [
        ("bias_repeatability", 3.0 * DEG_PER_HOUR, 1.0 / sqrt(3.0)),
        ("bias_stability", 0.5 / 0.664 * DEG_PER_HOUR, 0.664),
        ("angle_random_walk", 0.01 * DEG_PER_HOUR * 60.0, sqrt(0.5)),
        ("scale_factor_repeatability", 90.0 * PPM, 1.0 / sqrt(3.0)),
    ],
)
def test_a_line_is_the_largest_of_its_readings(gyro, name, size, ratio):
    """Whatever their order in the file; the others stand beside it."""
    one = gyro(**{name: OPEN[name]}).line(name)
    assert_allclose(one.u, size, rtol=1e-12)
    sizes = {float(read.u.max()) for _, read in one.readings}
    assert_allclose(min(sizes), size * ratio, rtol=1e-12)
    words = OPEN[name].partition("[")[2].partition("]")[0]
    turned = ", ".join(reversed(words.split(", ")))
    again = gyro(**{name: OPEN[name].replace(words, turned)}).line(name)
    assert_allclose(again.u, one.u, rtol=0)


def test_every_reading_is_the_line_that_says_so(gyro):
    """Under a reading a sensor is the one whose file has that key in its place."""
    for name, words, says in (
        ("bias_repeatability", "max", "meaning: max"),
        ("bias_stability", "sigma", "definition: sigma"),
        ("angle_random_walk", "two-sided", "density: two-sided"),
    ):
        sensor = gyro(**{name: OPEN[name]})
        key = next(line for line in sensor.lines if line.name == name)
        read = under(sensor, ((budget.names.Name(name, owner="gyro"), words),))
        value = OPEN[name].partition(",")[0]
        direct = gyro(**{name: f"{value}, {says}}}"}).line(name)
        found = read.line(name)
        assert_allclose(found.u, direct.u, rtol=0)
        assert found.distributions == direct.distributions
        assert found.readings == key.readings


def test_over_temperature_is_another_line(gyro):
    """In-run is a process; over temperature a constant of a later turn-on."""
    said = "{value: 0.5 deg/h, reading: [in-run, over temperature]}"
    sensor = gyro(bias_stability=said)
    name = budget.names.Name("bias_stability", owner="gyro")
    read = under(sensor, ((name, "over temperature"),))
    assert [line.name for line in read.lines] == ["bias_over_temperature"]
    assert "gyro.bias_stability" in read.expected_missing
    assert under(read, ((name, "in-run"),)).lines[0].name == "bias_stability"
    found = effects(asked(sensor, reference="next_turn_on"))
    (one,) = found
    assert one.output == "gyro.bias.x"
    assert one.ratio > 1.3  # a constant is not averaged


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[max]", "expected two different words"),
        ("[max, max]", "expected two different words"),
        ("[max, turn-on]", "words that exclude one another"),
        ("[max, 1 sigma], meaning: max", "leaves open what 'meaning' says"),
        ("[max, 1 sigma], distribution: normal", "never 'normal'"),
        ("[max, 1 sigma], axes: {x: {value: 1 deg/h}}", "an axis is a mapping"),
        ("[max, one-sided]", "found 'one-sided', expected '1 sigma'"),
    ],
)
def test_words_that_leave_nothing_open_are_refused(gyro, text, message):
    """With what is allowed."""
    with pytest.raises(SpecError) as caught:
        gyro(bias_repeatability=f"{{value: 3 deg/h, reading: {text}}}")
    assert message in str(caught.value)


@pytest.mark.parametrize(
    "lines",
    [
        {
            "bias_repeatability": (
                "{value: 3 deg/h, reading: [turn-on, over temperature]}"
            ),
            "bias_stability": "{value: 3 deg/h, reading: [in-run, over temperature]}",
        },
        {
            "bias_stability": "{value: 3 deg/h, reading: [in-run, over temperature]}",
            "bias_over_temperature": "1 deg/h",
        },
    ],
)
def test_two_lines_are_not_over_temperature_both(gyro, lines):
    """One of them would be lost."""
    with pytest.raises(SpecError, match="may be over temperature, and so is"):
        gyro(**lines)


def test_a_density_is_open_per_root_of_hertz_only(gyro):
    """A value per root of hour is the random walk itself."""
    with pytest.raises(SpecError, match="is the random walk itself"):
        gyro(
            angle_random_walk="{value: 1 deg/sqrt(h), reading: [one-sided, two-sided]}"
        )


def test_verdicts_under_every_reading(gyro, limits):
    """U of the bias is k sqrt(2) u by the law: 8.32 and, uniform, less than 6 deg/h."""
    sensor = gyro(bias_repeatability=OPEN["bias_repeatability"])
    for limit, passes in (("9 deg/h", "all"), ("7 deg/h", "some"), ("3 deg/h", "none")):
        found = verdicts_by_reading(
            asked(sensor, requirement=limits(bias=limit)), seed=0
        )
        assert found.total == 2
        # On what is given: lines that are missing are judged apart from readings.
        words = [one.verdict for one in found.found]
        assert (
            words
            == {
                "all": ["meets", "meets"],
                "some": ["fails", "meets"],
                "none": ["fails", "fails"],
            }[passes]
        )
    first, other = found.found
    assert_allclose(first.utilisation, 1.959963984540054 * sqrt(2.0), rtol=1e-6)
    assert first.utilisation > other.utilisation


def test_few_combinations_are_all_computed_and_many_are_not(gyro, limits):
    """Five open lines are 32: those taken, five others, and the smallest of each."""
    wanted = limits(bias="8 deg/h", scale_factor="300 ppm", mounting_angle="70 arcsec")
    how = {"seed": 0, "by_law": True}  # by trials others ask
    some = verdicts_by_reading(
        asked(gyro(**dict(list(JUDGED.items())[:4])), requirement=wanted), **how
    )
    assert some.total == len(some.found) == MOST
    assert len({one.words for one in some.found}) == MOST
    many = verdicts_by_reading(asked(gyro(**JUDGED), requirement=wanted), **how)
    assert (many.total, len(many.found)) == (32, 7)
    used = [one.utilisation for one in many.found]
    assert many.found[0].utilisation == max(used)
    assert many.found[-1].utilisation == min(used)
    assert many.passes == "some"
    assert_says(
        line("readings", "verdict", found=many), "7 of 32 combinations were computed"
    )


def test_the_smaller_density_is_shown_and_not_judged(gyro, limits):
    """Less noise is never worse: no verdict waits for it, and analyze still says it."""
    walk = "300 deg/h/sqrt(Hz)"
    wanted = limits(bias="1000 deg/h")
    for text in (walk, f"{{value: {walk}, reading: [one-sided, two-sided]}}"):
        sensor = gyro(angle_random_walk=text)
        one = asked(sensor, requirement=wanted)
        assert verdicts_by_reading(one, seed=0, by_law=True) is None
        (one,) = effects(asked(sensor, reference="nominal"))
        assert (one.taken, one.reading) == ("two-sided", "one-sided")
        assert_allclose(one.ratio, sqrt(0.5), rtol=1e-9)


def test_an_estimator_that_weighs_by_the_noise_is_judged_under_both(gyro, limits):
    """There less noise moves the weights, of what is no noise too."""
    sensor = gyro(angle_random_walk="300 deg/h/sqrt(Hz)")
    found = verdicts_by_reading(
        asked(
            sensor,
            procedure=replace(PAPER, formulas="weighted"),
            requirement=limits(bias="1000 deg/h"),
        ),
        seed=0,
        by_law=True,
    )
    assert [dict(one.words).popitem()[1] for one in found.found] == [
        "two-sided",
        "one-sided",
    ]


def test_effects_are_what_the_law_gives_for_each(gyro):
    """U of the bias, of two turn-ons: the ratio of the two sizes."""
    sensor = gyro(
        bias_repeatability=OPEN["bias_repeatability"],
        bias_stability=OPEN["bias_stability"].replace(
            "{", "{correlation_time: 300 s, "
        ),
    )
    one, other = effects(asked(sensor, reference="next_turn_on"))
    a, b = 2.0 * 3.0**2, 2.0 * 3.0**2 / 3.0
    assert one.reading == "max"
    assert_allclose(one.ratio, sqrt(b / a), rtol=0.02)  # of the stability too
    assert other.taken == "allan_minimum"
    assert other.output.quantity != "bias"
    assert_says(
        line("readings", "effect", one=one),
        "bias repeatability read as max in place of 1 sigma",
    )
    assert effects(asked(gyro(bias_repeatability="3 deg/h"))) == ()


@pytest.mark.slow
def test_commands_say_what_readings_do(gyro, limits, tmp_path):
    """compare, report and analyze: one record, printed and in JSON."""
    gyro(**JUDGED)
    limits(bias="8 deg/h", scale_factor="300 ppm", mounting_angle="70 arcsec")
    device, wanted = tmp_path / "device.yaml", tmp_path / "limits.yaml"
    said = call("analyze", device, "--no-validate", "--json", tmp_path / "a.json").out
    assert_says(said, "Open readings", "bias stability read as sigma")
    document = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))
    assert len(document["readings"]) == len(JUDGED)
    how = ("--requirement", wanted, "--json", tmp_path / "c.json", "--method", "gum")
    said = call("compare", device, *how, "--validate").out
    assert_says(said, "meets under 2 of 7 readings")
    (row,) = json.loads((tmp_path / "c.json").read_text(encoding="utf-8"))["devices"]
    found = budget.analyze(
        load_device(device),
        requirement=budget.load_requirement(wanted),
        reference="next_turn_on",
        validate=False,
    )
    (judged,) = found.to_dict()["assessment"]["sensors"]
    assert judged["readings"]["passes"] == row["readings"]["passes"] == "some"
    pairs = zip(
        judged["readings"]["computed"], row["readings"]["computed"], strict=True
    )
    for here, there in pairs:
        assert here["readings"] == there["readings"]
        assert_allclose(here["utilisation"], there["utilisation"], rtol=1e-9)


@pytest.mark.parametrize(
    "words", ["in-run, over temperature", "over temperature, in-run"]
)
def test_a_verdict_is_that_of_all_readings_whatever_their_order(
    gyro, limits, tmp_path, words
):
    """What meets by one reading and not by another is undecided: no device meets."""
    gyro(
        bias_repeatability="1 deg/h",
        bias_stability=f"{{value: 3 deg/h, reading: [{words}]}}",
        angle_random_walk="0.001 deg/sqrt(h)",
        scale_factor_repeatability="1 ppm",
        mounting_repeatability="1 arcsec",
    )
    device = load_device(tmp_path / "device.yaml")
    found = budget.compare([device], limits(bias="6.2 deg/h"), method="gum")
    (row,) = found.devices
    assert (row.verdict, row.readings.passes) == ("undecided", "some")
    assert not found.is_met
    assert_allclose(row.utilisation, row.readings.found[0].utilisation, rtol=1e-12)
    judged = budget.analyze(
        device,
        requirement=limits(bias="6.2 deg/h"),
        reference="next_turn_on",
        validate=False,
    )
    (sensor,) = judged.assessment.sensors
    assert sensor.verdict == "undecided"
    assert sensor.is_open_by_reading
    (card,) = verdict_cards(judged, judged.assessment)
    said = spoken(card.lines[0])
    assert_says(said, "it meets under 1 of 2 readings", "bias stability as in-run")
    assert_says(
        spoken(summary(judged, judged.assessment)), "As the values are read here"
    )
    # The sliders of a report begin with the same verdict.
    (outlook,) = what_if(question_of(judged), budget=judged).evaluate({}).sensors
    assert outlook.verdict == "undecided"
