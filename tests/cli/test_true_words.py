"""What a brief answer, an allocation and a prompt say is so, and what matters first."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest
from command_line import call
from reading import assert_says
from report_examples import make_assessment, make_budget

import budget
from budget.report.pages import lines
from budget.report.stations import station_answer
from budget.report.tables import print_contributions
from budget.results import Condition
from budget.ties import foremost, smallest

# Its attitude is lost within a minute; it uses little of a wide limit.
LOST = """\
name: Turned about
technology: MEMS
gyro:
  errors:
    bias_repeatability: 1 deg/h
    bias_stability: {value: 1 deg/h, correlation_time: 100 s}
    angle_random_walk: 0.1 deg/sqrt(h)
    scale_factor_repeatability: 300000 ppm
    mounting_repeatability: 10 arcsec
    g_sensitivity: 0.001 deg/h/g
accelerometer:
  errors:
    bias_repeatability: 0.5 mg
    bias_stability: {value: 50 ug, correlation_time: 100 s}
    velocity_random_walk: 0.05 m/s/sqrt(h)
    scale_factor_repeatability: 300 ppm
    mounting_repeatability: 10 arcsec
"""
OUTAGE = """\
name: a minute without satellites
mission:
  latitude: 45 deg
  segments:
    - {straight: 20 s, speed: 20 m/s}
    - {turn: 90 deg, rate: 36 deg/s}
    - {straight: 40 s}
"""
WIDE = """\
name: wide
environment: none
limits:
  mission: {position: {horizontal: 500 km, at: 60 s, probability: 50 %}}
"""
BENCH = """\
name: bench
environment: none
reference: next_turn_on
limits:
  gyro: {scale_factor: 2000 ppm, mounting_angle: 60 arcsec, bias: 10 deg/h}
"""
NO_RANGE = "the range of the gyro is not given"


def sheet(*without, name="sheet", **lines):
    """Return the device file of a gyro, without some of its lines."""
    own = {
        "bias_repeatability": "3 deg/h",
        "bias_stability": "1 deg/h",
        "angle_random_walk": "0.1 deg/sqrt(h)",
        "scale_factor_repeatability": "300 ppm",
        "mounting_repeatability": "10 arcsec",
        "g_sensitivity": "1 deg/h/g",
        **lines,
    }
    told = "".join(f"    {k}: {v}\n" for k, v in own.items() if k not in without)
    return f"name: {name}\ntechnology: MEMS\ngyro:\n  errors:\n{told}"


@pytest.fixture
def write(tmp_path):
    """Return what writes a file and returns its name."""

    def written(name, text):
        (tmp_path / name).write_text(text, encoding="utf-8")
        return str(tmp_path / name)

    return written


def told(*args):
    """Return what a call says on one line, without trials."""
    return " ".join(call(*args, "--no-validate", COLUMNS="100").out.split())


@pytest.mark.slow
def test_a_lost_unit_is_the_reason_and_no_reading_is(write):
    """UNDECIDED far from the limit: no reading and no interval leaves it open."""
    device, need = write("lost.yaml", LOST), write("wide.yaml", WIDE)
    mission = write("outage.yaml", OUTAGE)
    text = told("mission", device, "--mission", mission, "--requirement", need)
    assert_says(text, "UNDECIDED wide", "that the unit is lost")
    assert "As the values are read here" not in text
    page = write("page.html", "")
    call("report", device, "--mission", mission, "--requirement", need, "-o", page)
    text = Path(page).read_text("utf-8")
    assert "within or beyond is not decided" not in text
    assert "As the values are read here" not in text


def test_an_interval_that_has_the_limit_in_it_is_the_reason():
    """The control: then it is said on which side nobody knows."""
    found = make_assessment(make_budget(), gyro="undecided")
    sensor = replace(found.sensors[0], utilisation_interval=(0.99, 1.01))
    assert (sensor.is_near, sensor.is_open_by_reading) == (True, False)
    far = replace(sensor, utilisation_interval=(0.26, 0.27))
    assert (far.is_near, far.is_open_by_reading) == (False, False)


def test_a_line_that_decides_is_asked_for_and_marks_the_numbers(write):
    """No expected line is missing, and yet the verdict hangs on one."""
    device, need = write("sheet.yaml", sheet("g_sensitivity")), write("n.yaml", BENCH)
    text = told("analyze", device, "--requirement", need)
    assert_says(
        text,
        "Gyro: UNDECIDABLE, numbers on what is given",
        "gyro g sensitivity: the verdict depends on it",
    )
    whole = told("analyze", write("whole.yaml", sheet()), "--requirement", need)
    assert "the verdict depends on" not in whole


def test_what_is_not_given_is_named_widest_first(write):
    """Not a bare count: first what reaches most outputs, never what reaches none."""
    device = write("sheet.yaml", sheet())
    assert_says(told("analyze", device), "gyro rate random walk, gyro quantization and")
    found = budget.analyze(device, validate=False)
    reached = [len(found.could_widen[name]) for name in found.widening]
    assert reached == sorted(reached, reverse=True)
    assert min(reached) > 0
    assert len(found.widening) < len(found.not_given)


def test_cautions_are_cut_by_weight(write):
    """A range that is not given stands behind what may be a wrong unit."""
    wrong = sheet(bias_repeatability="3 deg/s")
    device, need = write("sheet.yaml", wrong), write("need.yaml", BENCH)
    text = told("analyze", device, "--requirement", need)
    assert text.index("check its unit") < text.index(NO_RANGE)
    found = budget.analyze(device, requirement=need, validate=False)
    (standing,) = found.assessment.sensors
    line = standing.cautions[0].line
    bound = Condition(kind="other", line=line, text="a bound", below=1.0, unit="m")
    behind = replace(standing, cautions=(*standing.cautions, bound))
    said = lines("standing", "cautions", standing=behind)
    assert said[0] == "a bound"
    assert NO_RANGE in said[-1]


@pytest.mark.parametrize(
    ("extra", "without", "said"),
    [
        ("", (), "bench can be met"),
        ("", ("g_sensitivity",), "On what is given bench can be met"),
        ("decision: joint\n", (), "Each limit of bench, taken alone, can be met"),
        (
            "decision: joint\n",
            ("bias_repeatability",),
            "On what is given each limit of bench, taken alone, can be met",
        ),
    ],
)
def test_what_can_be_met_is_no_more_than_is_known(write, extra, without, said):
    """Each limit where all are to be kept together; on what is given where it lacks."""
    device = write("sheet.yaml", sheet(*without))
    need = write("need.yaml", BENCH + extra)
    assert_says(told("allocate", device, "--requirement", need), said)
    found = budget.allocate(device, requirement=need, validate=False)
    assert_says(repr(found), f"sheet: {said}")


@pytest.mark.slow
def test_what_the_whole_of_an_allocation_has_is_what_it_names(write):
    """Checks that were not made are not promised."""
    device, need = write("sheet.yaml", sheet()), write("need.yaml", BENCH)
    text = told("allocate", device, "--requirement", need)
    assert "checks by Monte Carlo" not in text[text.index("Everything") :]
    checked = call("allocate", device, "--requirement", need).out
    assert_says(checked[checked.index("Everything") :], "checks by Monte Carlo")


def test_a_prompt_marks_bounds(write, monkeypatch):
    """Parts of a limit and ends of an interval, as every page does."""
    monkeypatch.setenv("COLUMNS", "100")
    device = write("sheet.yaml", sheet("bias_repeatability"))
    need = write("need.yaml", BENCH)
    found = budget.analyze(device, requirement=need, validate=False)
    text = " ".join(repr(found).split())
    assert re.search(r"gyro\.bias\.x (≥|>=) \S+ deg/h (≥|>=) \S+ % of 10 deg/h", text)
    assert re.search(r"gyro\.scale_factor\.x \d+ ppm [\d.]+ % of 2000 ppm", text)
    one = " ".join(repr(found["gyro.bias.x"]).split())
    assert re.search(r"interval (≤|<=) \S+ to (≥|>=) \S+ deg/h", one)
    sure = " ".join(repr(found["gyro.scale_factor.x"]).split())
    assert re.search(r"interval \S+ to \S+ ppm", sure)


def test_a_prompt_names_no_contributor_of_nothing(write):
    """Where nothing spreads nothing contributes."""
    zero = dict.fromkeys(("bias_repeatability", "bias_stability"), "0 deg/h")
    none = sheet("g_sensitivity", angle_random_walk="0 deg/sqrt(h)", **zero)
    found = budget.analyze(write("zero.yaml", none), validate=False)
    row = next(one for one in repr(found).splitlines() if "gyro.bias" in one)
    assert "%" not in row


def test_ties_are_named_together():
    """Two are named, and what is equal to the second; of one rule with the largest."""
    assert foremost([0.4, 0.3, 0.3 * (1 - 1e-9), 0.0], 2) == 3
    assert foremost([0.5], 2) == 1
    assert foremost([], 2) == 0
    assert smallest([2.0, 1.0, 1.0 + 1e-9]) == (1, 2)
    assert smallest([]) == ()
    tied = [("a", 0.4), ("b", 0.25), ("c", 0.25), ("d", 0.1)]
    assert_says(print_contributions(tied), "a 40 %", "b 25 %", "c 25 %", "rest 10 %")


def test_stations_that_are_equally_near_are_named_together(write):
    """Where none will do."""
    device, need = write("sheet.yaml", sheet()), write("need.yaml", BENCH)
    coarse = "station: {mount: 5 deg, positioning: 5 deg}\n"
    labs = [write(f"{x}.yaml", f"name: {x}\n{coarse}") for x in ("one", "two")]
    found = budget.qualify(device, requirement=need, stations=labs)
    (section, *_) = station_answer(found, full=False)
    assert_says(str(section.blocks[0]), "nearest is one and two")
