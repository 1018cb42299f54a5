"""Words beside a verdict: each is so, what matters comes first, none says another."""

from __future__ import annotations

import html
import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
from command_line import call
from places import put
from reading import assert_says
from report_examples import make_assessment, make_budget

import budget
from budget.report.pages import lines
from budget.report.stations import station_answer
from budget.report.tables import print_contributions
from budget.results import Condition
from budget.ties import foremost, smallest

pytestmark = pytest.mark.usefixtures("analyzed_once")

LAW = ("--no-validate",)
NEED = """\
name: road
environment: none
limits:
  mission: {position: {horizontal: 150 m, at: 60 s, probability: 50 %}}
"""
OF_TEST = """\
name: bench
environment: none
limits:
  accelerometer: {bias: 5 mg}
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
NOISE = "    velocity_random_walk: 0.05 m/s/sqrt(h)\n"
SHEET = f"""\
name: Sheet A
technology: MEMS
range: {{gyro: 400 deg/s, accelerometer: 10 g}}
gyro:
  errors:
    bias_repeatability: 3 deg/h
    bias_stability: {{value: 1 deg/h, correlation_time: 100 s}}
    angle_random_walk: 0.1 deg/sqrt(h)
    scale_factor_repeatability: 100 ppm
    mounting_repeatability: 10 arcsec
    g_sensitivity: 1 deg/h/g
accelerometer:
  errors:
    bias_repeatability: 0.5 mg
    bias_stability: {{value: 50 ug, correlation_time: 100 s}}
{NOISE}    scale_factor_repeatability: 300 ppm
    mounting_repeatability: 10 arcsec
variants:
  narrow:
    range: {{gyro: 30 deg/s, accelerometer: 1.01 g}}
  narrower:
    range:
      gyro: {{x: 0.001 deg/s, y: 0.001 deg/s, z: 30 deg/s}}
      accelerometer: 0.9 g
"""
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
    """Return what writes a YAML file and returns its name."""

    def written(name, text):
        (tmp_path / f"{name}.yaml").write_text(text, encoding="utf-8")
        return str(tmp_path / f"{name}.yaml")

    return written


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Write a sheet, one without a line that takes next to nothing, and the needs."""
    folder = tmp_path_factory.mktemp("words")
    texts = {
        "sheet": SHEET,
        "hidden": SHEET.replace(NOISE, ""),
        "need": NEED,
        "test": OF_TEST,
        "outage": OUTAGE,
    }
    for name, text in texts.items():
        (folder / f"{name}.yaml").write_text(text, encoding="utf-8")
    return {name: str(folder / f"{name}.yaml") for name in texts}


def told(*args):
    """Return what a call says, and its page or document beside it."""
    run = call(*args, *(LAW if args[0] != "compare" else ()))
    assert run.code in {0, 1}, run.err
    return run


def flat(text):
    """Return a text on one line."""
    return " ".join(text.split())


def brief(*args):
    """Return what a call says on one line of a wide terminal, without trials."""
    return flat(call(*args, *LAW, COLUMNS="100").out)


def of_page(tmp_path, *args):
    """Return the text of the page of a call."""
    page = tmp_path / "page.html"
    told(*args, "-o", page)
    text = page.read_text("utf-8")
    for part in ("script", "style", "svg"):
        text = re.sub(rf"(?s)<{part}\b.*?</{part}>", "", text)
    return flat(html.unescape(re.sub(r"<[^>]+>", " ", text))).replace(" .", ".")


def on_outage(files, variant=""):
    """Return the words of a sheet on the minute without satellites."""
    return (f"{files['sheet']}{variant}", "--mission", files["outage"])


def both(tmp_path, *args):
    """Return what a terminal says of a mission, and the page of a report."""
    return flat(told("mission", *args).out), of_page(tmp_path, "report", *args)


# What says that a verdict is open, which MEETS is not.
OPEN = ("open: not given", "cannot be decided", "at the most 100 %", "Not given: a")


@pytest.mark.slow
def test_nothing_is_open_where_a_verdict_hangs_on_no_missing_line(files, tmp_path):
    """A noise that takes next to nothing of a limit: it is met, and nothing lacks."""
    given = (files["hidden"], "--requirement", files["test"])
    texts = {
        "analyze": flat(told("analyze", *given).out),
        "compare": flat(told("compare", *given).out),
        "report": of_page(tmp_path, "report", *given),
    }
    for command, text in texts.items():
        assert "meets" in text.casefold(), command
        assert [word for word in OPEN if word in text] == [], command
        assert "specifications not given" not in text, command
    document = told("analyze", *given, "--json", "-").document
    found = document["assessment"]
    (sensor,) = found["sensors"]
    assert (found["verdict"], sensor["expected_missing"]) == ("meets", [])
    assert not any(row["lower_bound"] for row in found["outputs"])
    # Without a requirement nobody knows what it is nothing of.
    bare = told("analyze", files["hidden"], "--json", "-").document["outputs"]
    assert any(row["lower_bound"] for row in bare if row["parameter"] == "bias")


def test_a_number_that_a_missing_line_changes_stays_a_lower_bound(write):
    """The control: it takes next to nothing of a wide limit, and much of the number."""
    wide = "name: wide\nenvironment: none\nlimits:\n  gyro: {scale_factor: 50 %}\n"
    without = SHEET.replace("    scale_factor_repeatability: 100 ppm\n", "")
    given = (write("bare", without), "--requirement", write("wide", wide))
    found = told("analyze", *given, "--json", "-").document
    assert found["assessment"]["verdict"] == "meets"
    assert all(
        row["lower_bound"]
        for row in found["outputs"]
        if (row["sensor"], row["parameter"]) == ("gyro", "scale_factor")
    )


@pytest.fixture(scope="module")
def beyond(files):
    """Return what is asked of a unit that reads too little."""
    return (*on_outage(files, "#narrow"), "--requirement", files["need"])


@pytest.mark.slow
def test_a_sensor_that_saturates_has_no_good_numbers(beyond, tmp_path):
    """They are those of sensors that read enough, and no conformance is one of it."""
    for text in both(tmp_path, *beyond):
        assert "FAILS" in text
        assert_says(text, "of sensors that read enough")
        assert "It conforms with a probability" not in text
        assert "Conformance probability" not in text
    assert_says(of_page(tmp_path, "report", *beyond), "conforms, if it read enough")
    document = told("mission", *beyond, "--json", "-").document["assessment"]
    assert document["conformance"] is None
    assert document["sensors"][0]["conformance"] is None
    compared = told("compare", *beyond, "--json", "-").document
    found = [one for one in compared["devices"] if one["name"].endswith("(narrow)")]
    assert {one["verdict"] for one in found} == {"fails"}
    assert {one["conformance"] for one in found} == {None}
    assert_says(flat(told("compare", *beyond).out), "saturates: gyro z")


def test_every_axis_that_saturates_is_named_once(beyond):
    """All of a triad in one sentence, both triads, and no warning that repeats it."""
    sheet, *others = beyond
    text = flat(told("mission", f"{sheet}er", *others).out)
    assert_says(text, "gyro x, y, z of Sheet A", "accelerometer x, z of Sheet A")
    assert text.casefold().count("saturates:") == 2


@pytest.mark.slow
def test_an_undecidable_verdict_is_on_what_is_given(files, tmp_path, write):
    """What its table and its sentences say of within is up to what is not given."""
    need = NEED.replace("none", "{temperature: 0 degC, vibration: 1 g}")
    given = (*on_outage(files), "--requirement", write("shaken", need))
    for text in both(tmp_path, *given):
        assert "UNDECIDABLE" in text
        assert_says(text, "on what is given: the required output uses")
        assert "100 %" not in text.partition("limit")[2][:200]
    assert_says(of_page(tmp_path, "report", *given), "conforms on what is given")


@pytest.mark.slow
def test_a_report_counts_from_what_its_mission_counts_from(files, tmp_path):
    """As the maker calibrated it: any later turn-on, once, in the words of mission."""
    given = (*on_outage(files), "--requirement", files["need"])
    once = "at any later turn-on, which the navigation system will meet"
    words = flat(told("mission", *given).out)
    page = of_page(tmp_path, "report", *given)
    for text in (words, page):
        assert_says(text, once, "a repeatability enters once")
    first, _, rest = page.partition("Errors against their limits")
    assert "twice" not in first
    assert_says(first, "as the maker calibrated it; beside it the budget of procedure")
    assert_says(rest, "error reference of the calibration alone")


def test_a_headline_says_what_stands_for_missing_lines(write):
    """In words, beside calibration and use; of predicted ones how probable it is."""
    bare = SHEET.replace("    scale_factor_repeatability: 300 ppm\n", "")
    sheet = write("bare", bare.replace("    g_sensitivity: 1 deg/h/g\n", ""))
    limit = "accelerometer: {scale_factor: 4000 ppm}"
    need = write("bench", OF_TEST.replace("accelerometer: {bias: 5 mg}", limit))
    heads = {}
    for mode in ("worst", "predict"):
        out = told("analyze", sheet, "--requirement", need, "--missing", mode).out
        heads[mode] = flat(out.split("\n\n")[1])
    for mode, how in (
        ("worst", "with specifications not given at the worst of the catalogue"),
        ("predict", "with specifications not given as predicted from the catalogue"),
    ):
        assert_says(
            heads[mode],
            how,
            "after the calibration",
            "in the environment of the calibration",
        )
    assert heads["predict"].startswith("PREDICTED bench")
    assert "meets with a probability of" in heads["predict"]


@pytest.mark.slow
@pytest.mark.parametrize("axis", ["", ".z"])
def test_a_range_is_set_on_a_call(files, axis):
    """As a variant of the file would have it, of the triad or of an axis."""
    given = (*on_outage(files), "--requirement", files["need"])
    run = told("mission", *given, "--set", f"gyro.range{axis}=30 deg/s", "--json", "-")
    found = run.document["assessment"]
    assert found["verdict"] == "fails"
    (caution,) = [
        one for one in found["sensors"][0]["cautions"] if one["kind"] == "saturates"
    ]
    assert_says(caution["text"], "gyro z", "reads up to ±30 deg/s")
    assert told("mission", *given, "--json", "-").document["assessment"]["verdict"] == (
        "meets"
    )


def test_a_range_that_is_a_text_is_set_beside_that_of_the_other_triad(write):
    """A text says by its unit whose it is; the change leaves the other one."""
    of_both = "range: {gyro: 400 deg/s, accelerometer: 10 g}"
    sheet = write("text", SHEET.replace(of_both, "range: 10 g"))
    found = budget.load_device(sheet, changes={"gyro.range": "30 deg/s"})
    shown = [sensor.range_printed for sensor in found.sensors]
    assert [one.split()[0] for one in shown] == ["±30", "±10"]


@pytest.mark.parametrize(
    ("change", "found"),
    [
        ("gyro.range=30 g", "found '30 g', which is an acceleration"),
        ("range=30 deg/s", "did you mean 'gyro.range' or 'accelerometer.range'"),
    ],
)
def test_a_range_that_is_none_is_refused_with_what_is_meant(files, change, found):
    """As a file would be; without a sensor the two that have one are named."""
    run = call("analyze", files["sheet"], "--set", change, code=2)
    assert_says(run.err, found)


@pytest.mark.parametrize("reference", ["nominal", "as_tested"])
def test_a_requirement_of_the_unit_at_its_test_asks_for_no_use(files, write, reference):
    """In the place of a use its headline says so."""
    text = f"name: now\nreference: {reference}\nlimits:\n  gyro: {{bias: 20 deg/h}}\n"
    given = ("analyze", files["sheet"], "--requirement", write("now", text))
    assert_says(flat(told(*given).out), "an ideal table, as it was in the calibration")
    found = told(*given, "--json", "-")
    (sensor,) = found.document["assessment"]["sensors"]
    assert (sensor["use"], sensor["conditions"]) == ("as it was in the calibration", [])


@pytest.mark.slow
def test_limits_of_a_mission_and_of_triads_stand_in_one_table(files, tmp_path, write):
    """Page one has a row for each, with its own limit and what makes it up."""
    gyro = "  gyro: {bias: 20 deg/h}\n  accelerometer: {bias: 5 mg}\n  mission"
    need = write("all", NEED.replace("  mission", gyro))
    page = tmp_path / "all.html"
    told("report", *on_outage(files), "--requirement", need, "-o", page)
    (table,) = re.findall(r'(?s)<table id="answer".*?</table>', page.read_text("utf-8"))
    rows = re.findall(r'data-outputs="([^"]+)"', table)
    assert [row.split()[0].rpartition(".")[0] for row in rows[:2]] == [
        *("gyro.bias", "accelerometer.bias")
    ]
    assert all(row.startswith("mission.") for row in rows[2:])
    assert len(rows) > 2
    assert table.count('class="parts"') == len(rows)


@pytest.mark.slow
def test_limits_kept_together_are_used_by_one_number(tmp_path, write):
    """Card and compare print the utilisation of the verdict, the output's as its own.

    Of 12 limits each met with 97 %, all are met by fewer units than 95 %.
    """
    each = """name: all
coverage: 95 %
environment: none
limits: {gyro: {scale_factor: 2300 ppm, mounting_angle: 460 arcsec, bias: 28.5 deg/h}}
"""
    given = ("analyze", "hg4930#C", *LAW, "--requirement")
    joint = (*given, write("joint", f"{each}decision: joint\n"))
    said = call(*joint, "--json", tmp_path / "j").out
    (one,) = json.loads((tmp_path / "j").read_text("utf-8"))["assessment"]["sensors"]
    used = round(100.0 * one["utilisation"])
    assert used > 100
    assert one["verdict"] == "fails"
    assert_says(said, f"Its limits, kept together: {used} % used")
    said = call(*joint, "--full").out
    assert_says(said, f"Its limits, kept together: {used} % used.")
    assert_says(said, "93.2 % of its own limit.")
    said = call(*given, write("each", each), "--full").out
    assert_says(said, "93.2 % of the limit.")
    assert "kept together" not in said


def test_what_is_not_judged_is_not_signed(write):
    """Pairs of two files: nobody judged their misalignment, and the code is 1."""
    need = (
        "name: all\nenvironment: none\nlimits:\n  gyro: {bias: 100 deg/h}\n"
        "  accelerometer: {bias: 50 mg}\n"
    )
    gyro, rest = SHEET.partition("gyro:\n")[2].split("accelerometer:\n")
    triads = {"gyro": gyro, "accelerometer": rest.partition("variants")[0]}
    sheets = [
        write(kind, f"name: {kind}\ntechnology: MEMS\n{kind}:\n{lines}")
        for kind, lines in triads.items()
    ]
    how = ("compare", *sheets, "--method", "gum", "--pairs", "--requirement")
    assert call(*how, write("need", need)).code == 0
    run = call(*how, write("both", f"{need}  misalignment: 900 arcsec\n"), code=1)
    assert_says(run.out, "not judged")


def test_a_table_is_as_conditional_as_its_headline(write):
    """A g-sensitivity that is not given is a condition of each row."""
    bias = "name: bias\nenvironment: none\nlimits: {gyro: {bias: 900 deg/h}}\n"
    without = SHEET.replace("    g_sensitivity: 1 deg/h/g\n", "")
    given = ("--requirement", write("need", bias), *LAW, "--full")
    said = call("analyze", write("bare", without), *given).out
    assert_says(said, "MEETS bias ON A CONDITION", "conforms on conditions")
    said = call("analyze", write("whole", SHEET), *given).out
    assert_says(said, "MEETS bias,", "conforms")
    assert "on conditions" not in said


# ---- a brief answer, an allocation, a prompt -----------------------------------------


@pytest.mark.slow
def test_a_lost_unit_is_the_reason_and_no_reading_is(write, tmp_path):
    """UNDECIDED far from the limit: no reading and no interval leaves it open."""
    device, need = write("lost", LOST), write("wide", WIDE)
    mission = write("outage", OUTAGE)
    text = brief("mission", device, "--mission", mission, "--requirement", need)
    assert_says(text, "UNDECIDED wide", "that the unit is lost")
    assert "As the values are read here" not in text
    page = str(tmp_path / "page.html")
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
    device, need = write("sheet", sheet("g_sensitivity")), write("n", BENCH)
    text = brief("analyze", device, "--requirement", need)
    assert_says(
        text,
        "Gyro: UNDECIDABLE, numbers on what is given",
        "gyro g sensitivity: the verdict depends on it",
    )
    whole = brief("analyze", write("whole", sheet()), "--requirement", need)
    assert "the verdict depends on" not in whole


def test_what_is_not_given_is_named_widest_first(write):
    """Not a bare count: first what reaches most outputs, never what reaches none."""
    device = write("sheet", sheet())
    assert_says(
        brief("analyze", device), "gyro rate random walk, gyro quantization and"
    )
    found = budget.analyze(device, validate=False)
    reached = [len(found.could_widen[name]) for name in found.widening]
    assert reached == sorted(reached, reverse=True)
    assert min(reached) > 0
    assert len(found.widening) < len(found.not_given)


def test_cautions_are_cut_by_weight(write):
    """A range that is not given stands behind what may be a wrong unit."""
    wrong = sheet(bias_repeatability="3 deg/s")
    device, need = write("sheet", wrong), write("need", BENCH)
    text = brief("analyze", device, "--requirement", need)
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
    device = write("sheet", sheet(*without))
    need = write("need", BENCH + extra)
    assert_says(brief("allocate", device, "--requirement", need), said)
    found = budget.allocate(device, requirement=need, validate=False)
    assert_says(repr(found), f"sheet: {said}")


@pytest.mark.slow
def test_what_the_whole_of_an_allocation_has_is_what_it_names(write):
    """Checks that were not made are not promised."""
    device, need = write("sheet", sheet()), write("need", BENCH)
    text = brief("allocate", device, "--requirement", need)
    assert "checks by Monte Carlo" not in text[text.index("Everything") :]
    checked = call("allocate", device, "--requirement", need).out
    assert_says(checked[checked.index("Everything") :], "checks by Monte Carlo")


def test_a_prompt_marks_bounds(write, monkeypatch):
    """Parts of a limit and ends of an interval, as every page does."""
    monkeypatch.setenv("COLUMNS", "100")
    device = write("sheet", sheet("bias_repeatability"))
    need = write("need", BENCH)
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
    found = budget.analyze(write("zero", none), validate=False)
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
    device, need = write("sheet", sheet()), write("need", BENCH)
    coarse = "station: {mount: 5 deg, positioning: 5 deg}\n"
    labs = [write(x, f"name: {x}\n{coarse}") for x in ("one", "two")]
    found = budget.qualify(device, requirement=need, stations=labs)
    (section, *_) = station_answer(found, full=False)
    assert_says(str(section.blocks[0]), "nearest is one and two")


def test_a_figure_aside_is_cautioned_by_its_own_sensor(tmp_path):
    """Once, though both triads are judged: the rate per vibration of a STIM300."""
    wanted = put(
        tmp_path / "loose.yaml",
        "name: loose\nenvironment: none\nlimits:\n  gyro: {bias: 200 deg/h}\n"
        "  accelerometer: {bias: 200 mg}\n",
    )
    run = call(
        *("analyze", "stim300#5g", *LAW, "--requirement", wanted, "--json", "-"), code=0
    )
    said = {
        one["sensor"]: [x for x in one["cautions"] if "under figures" in str(x)]
        for one in run.document["assessment"]["sensors"]
    }
    assert {sensor: len(own) for sensor, own in said.items()} == {
        "gyro": 1,
        "accelerometer": 0,
    }
