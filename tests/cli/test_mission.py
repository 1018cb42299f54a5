"""`budget mission`: what navigation makes of the errors, and because of which line."""

from __future__ import annotations

import csv
import io
import json
from functools import cache

import pytest
from command_line import call
from numpy.testing import assert_allclose
from places import TESTS, put
from reading import assert_says

pytestmark = pytest.mark.usefixtures("analyzed_once")
OUTAGE = ("mission", "zhao-2019", "--mission", "outage-60-s", "--no-validate")
BENCH = ("mission", "zhao-2019", "--mission", "bench", "--no-validate", "--at", "1 h")
LIMITS = """\
name: a mile
limits:
  gyro: {bias: 0.02 deg/h}
  mission:
    position:
      - {horizontal: 1 m, at: 60 s, probability: 50 %}
      - {horizontal: 100 m, at: 45 s}
    heading: {limit: 1 arcsec, at: 30 s}
"""


@pytest.fixture(scope="module")
def limits(tmp_path_factory):
    """Write a requirement on a mission."""
    return put(tmp_path_factory.mktemp("limits") / "mile.yaml", LIMITS)


@cache
def answer(*args):
    """Return what a call says; that of each is asked for once."""
    return call(*args, code=0)


def document(*args):
    """Return the document of a call, which the schema of results holds for."""
    return answer(*args, "--json", "-").document


def output(found, parameter, axis, time):
    """Return one output of a document."""
    (row,) = (
        one
        for one in found["outputs"]
        if (one["parameter"], one["axis"], one["time"]) == (parameter, axis, time)
    )
    return row


def test_it_says_how_far_off_and_because_of_what():
    """The finding stands first; the rate says how it is defined."""
    assert_says(
        answer(*BENCH).out,
        *("Mission: bench, 1 h, as the maker calibrated it", "After 1 h"),
        *("8.5 km CEP", "18 km R95", "10 km DRMS"),
        *("87 % of the variance is gyro bias repeatability", "4.6 nmi/h"),
        "the CEP after 1 h, divided by 1 h",
    )


def test_after_a_test_it_says_which_test():
    """One calibration in one turn-on: the number of each is under its own name."""
    assert_says(
        answer(*BENCH, "--procedure", "zhao-2019").out,
        "Mission: bench, 1 h, after the calibration Zhao 2019 on an ideal table",
        *("12 km CEP", "26 km R95", "15 km DRMS"),
        *("83 % of the variance is gyro bias repeatability", "6.7 nmi/h"),
    )


def test_a_rate_takes_an_hour():
    """Nothing is said of nmi/h of a minute."""
    assert "nmi/h" not in answer(*OUTAGE).out


def test_terminal_and_document_have_the_same_numbers():
    """CEP, R95 and DRMS of the page are those of the document, to two digits."""
    found = document(*BENCH)
    far = output(found, "position", "horizontal", 3600.0)
    line = next(
        one
        for one in answer(*BENCH, "--full").out.splitlines()
        if one.startswith("1 h") and one.endswith("km")
    )
    near = [output(found, "position", axis, 3600.0) for axis in ("north", "east")]
    exact = [
        *(far[key] / 1e3 for key in ("cep", "r95", "drms")),
        *(one["standard_uncertainty"] / 1e3 for one in near),
    ]
    assert line.split()[2:-1] == [f"{x:.2g}" for x in exact]
    assert far["drms"] == far["standard_uncertainty"]
    assert far["interval"][1] == far["r95"]
    squares = [one["standard_uncertainty"] ** 2 for one in near]
    assert_allclose(far["drms"] ** 2, sum(squares), rtol=1e-12)


def test_radii_are_those_of_a_circle_where_axes_are_alike():
    """1.17741 sigma and 2.44775 sigma; variances north and east differ by 1 %."""
    far = output(document(*BENCH), "position", "horizontal", 3600.0)
    sigma = far["drms"] / 2.0**0.5
    assert_allclose(far["cep"], 1.17741 * sigma, rtol=1e-3)
    assert_allclose(far["r95"], 2.44775 * sigma, rtol=1e-3)


def test_the_document_names_mission_and_file():
    """The file is among the inputs, what it says under a key of its own."""
    found = document(*BENCH, "--procedure", "zhao-2019")
    assert found["command"] == "mission"
    assert found["inputs"]["mission"]["name"] == "bench.yaml"
    said = dict(found["mission"])
    assert said.pop("route")["speed"] == 0.0  # rest of it: tests/report/test_route.py
    tests = [one["name"] for one in said.pop("calibrations")]
    assert tests[:2] == ["no calibration", "calibration by the maker"]
    assert len(tests) == 3
    assert said == {
        "name": "bench, 1 h",
        "duration": 3600.0,
        "alignment": 0.0,
        "aided": True,
    }
    assert found["settings"]["reference"] == "next_turn_on"


def test_no_covariance_is_made_up_beside_lengths():
    """Null stands for what is not known, variances stand everywhere."""
    found = document(*BENCH)
    rows = found["covariance"]
    for k, one in enumerate(found["outputs"]):
        assert_allclose(rows[k][k], one["standard_uncertainty"] ** 2, rtol=1e-12)
        for m, other in enumerate(found["outputs"]):
            known = k == m or "horizontal" not in {one["axis"], other["axis"]}
            assert (rows[k][m] is not None) == known


def test_the_table_has_the_time_of_each_row():
    """CSV has a column of times here; that of a calibration has none."""
    rows = list(csv.DictReader(io.StringIO(answer(*OUTAGE, "--csv", "-").out)))
    assert {float(one["time"]) for one in rows} == {10.0, 30.0, 60.0}
    totals = [one for one in rows if one["source"] == "total"]
    assert all(bool(one["cep"]) == (one["axis"] == "horizontal") for one in totals)
    other = answer("analyze", "--no-validate", "--csv", "-").out.splitlines()[0]
    assert not {"time", "cep", "coverage"} & set(other.split(","))


def test_a_limit_is_judged_at_its_own_probability(limits):
    """The verdict comes first; 50 % is CEP, the others are at 95 %."""
    assert_says(
        answer(*OUTAGE, "--requirement", limits).out,
        *("FAILS a mile, mission only", "does not conform", "conforms"),
        "Limits on gyro are on the calibration",
    )
    found = document(*OUTAGE, "--requirement", limits)
    judged = found["assessment"]["outputs"]
    assert [one.get("coverage") for one in judged] == [0.5, None, None]
    far = output(found, "position", "horizontal", 60.0)
    assert far["coverage"] == 0.5
    assert far["cep"] == judged[0]["largest_error"] == far["interval"][1]
    assert far["r95"] > 2.0 * far["cep"]
    # The time of a limit is looked at, asked for or not.
    assert "coverage" not in output(found, "velocity", "north", 45.0)


def test_times_are_those_asked_for():
    """Any order, any unit; twice the same is once."""
    found = document(*OUTAGE, "--at", "0.5 min", "--at", "20000 ms", "--at", "30 s")
    assert sorted({one["time"] for one in found["outputs"]}) == [20.0, 30.0]


@pytest.mark.parametrize(
    ("word", "hint"),
    [
        ("facotry", "did you mean 'factory'"),
        ("nome", "did you mean 'none'"),
        ("zhao-2091", "did you mean 'zhao-2019'"),
    ],
)
def test_a_calibration_that_is_none_offers_its_words(word, hint):
    """A slip of none or factory, as one of a shipped procedure, has its hint."""
    run = call(*OUTAGE, "--calibration", word, code=2)
    assert_says(run.err, f"{word}:1:1: no such file, expected 'none', 'factory'")
    assert_says(run.err, hint)


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (("--at", "2 h"), ("--at 2 h", "lasts 1 min")),
        (("--at", "0 s"), ("above 0 s",)),
        (("--at", "10"), ("10 s",)),
        (("--requirement", "navigation-grade"), ("no limit on a mission",)),
        (("hg9900",), ("both have",)),
        (("--calibration", "none", "--procedure", "zhao-2019"), ("leave one out",)),
        (
            tuple(word for n in range(17) for word in ("--at", f"{n + 1} s")),
            ("17 times", "16"),
        ),
    ],
)
def test_what_makes_no_sense_is_refused(more, said):
    """In words, with the code of a wrong call."""
    run = call(*OUTAGE, *more, code=2)
    assert_says(run.err, *said)
    assert not run.out


def test_a_mission_is_not_simulated():
    """The simulation of the calibration has no noise in run."""
    run = call(*OUTAGE, "--method", "simulation", "--trials", "2", code=2)
    assert_says(run.err, "noise in run", "gum or monte-carlo")


def test_a_limit_on_a_mission_is_not_stored_without_one(limits, tmp_path):
    """It is not lost in silence."""
    file = tmp_path / "a.json"
    run = call("check", "--save", file, "zhao-2019", "--requirement", limits, code=2)
    assert_says(run.err, "limits on a mission", "give --mission FILE")
    assert not file.exists()


def test_one_sensor_is_no_unit():
    """A mission takes both triads."""
    run = call("mission", "adxl357", "--mission", "bench", code=2)
    assert_says(run.err, "has no gyro", "give a second device")


def test_monte_carlo_agrees_with_the_law():
    """CEP, R95 and DRMS, within what so many trials can be off by."""
    trials = ("--method", "monte-carlo", "--trials", "40000", "--seed", "3")
    pairs = [
        [
            output(found, "position", "horizontal", 30.0)[key]
            for found in (document(*OUTAGE), document(*OUTAGE, *trials))
        ]
        for key in ("cep", "r95", "drms")
    ]
    # The spread of a standard deviation of n trials is 1/sqrt(2 n), 0.35 %; of the
    # 95 % quantile of a Rayleigh law 0.36 %.
    for exact, sampled in pairs:
        assert_allclose(sampled, exact, rtol=4.0 * 0.0036)


def test_lower_bounds_are_marked():
    """What a data sheet does not give would make it worse."""
    out = answer("mission", "icm-20948", *OUTAGE[2:]).out
    assert_says(out, "lower bounds (>=)", "not given")
    assert "m CEP" in out


def test_factory_calibration_counts_a_repeatability_once():
    """One calibration in one turn-on has it twice in variance."""
    by_test, by_maker = (
        output(document(*OUTAGE, *more), "attitude", "roll", 60.0)
        for more in (("--procedure", "zhao-2019"), ())
    )
    shares = [
        next(
            part["standard_uncertainty"]
            for part in one["contributions"]
            if part["source"] == "gyro.bias_repeatability"
        )
        for one in (by_test, by_maker)
    ]
    assert_allclose(shares[0] / shares[1], 2.0**0.5, rtol=1e-6)


@pytest.mark.parametrize(
    ("calibration", "times"),
    [(("--procedure", "zhao-2019"), "twice"), (("--calibration", "factory"), "once")],
    ids=str,
)
def test_it_says_how_often_a_repeatability_counts(calibration, times, limits):
    """In the words of the verdict, after each calibration."""
    words = " ".join(answer(*OUTAGE, "--requirement", limits, *calibration).out.split())
    assert f"a repeatability enters {times}" in words


@pytest.mark.parametrize("width", ["80", "100", "60"])
def test_lines_fit_the_terminal(width, limits):
    """Nothing is wider than the screen, with a verdict too."""
    out = call(*OUTAGE, "--requirement", limits, COLUMNS=width).out
    assert max(map(len, out.splitlines())) <= int(width)


@pytest.mark.parametrize("language", ["en", "zh"])
def test_one_column_is_enough(language, limits):
    """A terminal one column wide shows it in its way."""
    call(*OUTAGE, "--requirement", limits, "--language", language, COLUMNS="1", code=0)


def test_shares_add_up():
    """Of each output the sources make up the variance."""
    for one in document(*OUTAGE)["outputs"]:
        shares = [part["share"] for part in one["contributions"]]
        assert_allclose(sum(shares), 1.0, rtol=1e-9)


@pytest.fixture(scope="module")
def loose(tmp_path_factory):
    """Write a requirement that a unit without its expected lines is far within."""
    return put(
        tmp_path_factory.mktemp("loose") / "loose.yaml",
        "name: loose\nlimits:\n  mission: {position: {horizontal: 9 nmi, at: 60 s}}\n",
    )


def test_what_lacks_lines_conforms_in_no_row(loose):
    """Its row is as open as the verdict; a bound of 100 % is no sentence."""
    out = answer(
        *("mission", "hg4930#A", *OUTAGE[2:]),
        *("--calibration", "none", "--requirement", loose),
    ).out
    assert_says(
        out,
        "UNDECIDABLE loose",
        "The required output is within its limit on what is given",
        "leaves it open",
        "open: not given",
    )
    assert "conforms\n" not in out
    assert "probability of" not in out


@pytest.mark.parametrize("name", ["mpu-6050", "zhao-2019"])
def test_a_lost_unit_has_no_rate(name):
    """Where the attitude is beyond first order, it is said beside the position."""
    options = ("--mission", "bench", "--at", "1 h", "--no-validate")
    text = " ".join(answer("mission", name, *options).out.split())
    finding = text.partition(" after CEP")[0]
    is_lost = name == "mpu-6050"
    assert ("the unit is lost" in finding) == is_lost
    assert ("nmi/h" in finding) != is_lost


AIDED = TESTS / "data" / "aided"


@pytest.mark.slow
def test_a_mission_with_aids_says_what_its_filter_has_learnt(tmp_path):
    """Aids with their times, and each bias: what was there, and what is left."""
    path = tmp_path / "g3.json"
    files = (str(AIDED / "mems.yaml"), "--mission", str(AIDED / "g3.yaml"))
    full = (*files, "--no-validate", "--full")
    said = answer("mission", *full, "--json", str(path)).out

    assert_says(said, "gnss position 0 s - 10 min")
    assert_says(said, "37 states and 600 updates")
    assert_says(said, "gyro bias x 200 6.71 deg/h")
    assert_says(said, "accelerometer bias x 5000 not learnt ug")
    found = json.loads(path.read_text(encoding="utf-8"))["mission"]["filter"]
    assert (found["kind"], found["states"], found["updates"]) == ("optimal", 37, 600)
    assert {one["axis"] for one in found["learnt"]} == {"x", "y", "z"}
    last = found["believed"][-1]
    assert_allclose(last["standard_uncertainty"], last["true"], rtol=1e-9)


@pytest.mark.slow
def test_a_filter_that_believes_too_much_is_warned_of():
    """Where what it believes is below 0.8 of what is true."""
    files = (str(AIDED / "mems.yaml"), "--mission", str(AIDED / "g4.yaml"))
    said = answer("mission", *files, "--no-validate").out

    assert_says(said, "what it says of its own accuracy is too good")
    assert_says(said, "the filter believes 22.9 m DRMS, and 31 m is true")


def test_a_source_of_the_aids_is_asked_for_alone():
    """As a line of the device is."""
    files = (str(AIDED / "tac.yaml"), "--mission", str(AIDED / "g1.yaml"))
    said = answer(
        "mission", *files, "--no-validate", "--only", "aiding.gnss_velocity"
    ).out

    assert_says(said, "100 % of the variance is aiding gnss velocity")
