"""Words beside a verdict: none of them says another one than it does."""

from __future__ import annotations

import html
import json
import re

import pytest
from command_line import call
from reading import assert_says

import budget

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


def of_page(tmp_path, *args):
    """Return the text of the page of a call."""
    page = tmp_path / "page.html"
    told(*args, "-o", page)
    text = page.read_text("utf-8")
    for part in ("script", "style", "svg"):
        text = re.sub(rf"(?s)<{part}\b.*?</{part}>", "", text)
    return flat(html.unescape(re.sub(r"<[^>]+>", " ", text))).replace(" .", ".")


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


def test_a_number_that_a_missing_line_changes_stays_a_lower_bound(tmp_path):
    """The control: it takes next to nothing of a wide limit, and much of the number."""
    path = tmp_path / "wide.yaml"
    wide = "name: wide\nenvironment: none\nlimits:\n  gyro: {scale_factor: 50 %}\n"
    path.write_text(wide, encoding="utf-8")
    sheet = tmp_path / "bare.yaml"
    without = SHEET.replace("    scale_factor_repeatability: 100 ppm\n", "")
    sheet.write_text(without, encoding="utf-8")
    found = told("analyze", sheet, "--requirement", path, "--json", "-").document
    assert found["assessment"]["verdict"] == "meets"
    assert all(
        row["lower_bound"]
        for row in found["outputs"]
        if (row["sensor"], row["parameter"]) == ("gyro", "scale_factor")
    )


@pytest.fixture(scope="module")
def beyond(files):
    """Return what is asked of a unit that reads too little."""
    return (
        f"{files['sheet']}#narrow",
        *("--mission", files["outage"], "--requirement", files["need"]),
    )


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
def test_an_undecidable_verdict_is_on_what_is_given(files, tmp_path):
    """What its table and its sentences say of within is up to what is not given."""
    need = tmp_path / "shaken.yaml"
    need.write_text(
        NEED.replace("none", "{temperature: 0 degC, vibration: 1 g}"), encoding="utf-8"
    )
    given = (files["sheet"], "--mission", files["outage"], "--requirement", str(need))
    for text in both(tmp_path, *given):
        assert "UNDECIDABLE" in text
        assert_says(text, "on what is given: the required output uses")
        assert "100 %" not in text.partition("limit")[2][:200]
    assert_says(of_page(tmp_path, "report", *given), "conforms on what is given")


@pytest.mark.slow
def test_a_report_counts_from_what_its_mission_counts_from(files, tmp_path):
    """As the maker calibrated it: any later turn-on, once, in the words of mission."""
    given = (
        files["sheet"],
        *("--mission", files["outage"], "--requirement", files["need"]),
    )
    once = "at any later turn-on, which the navigation system will meet"
    words = flat(told("mission", *given).out)
    page = of_page(tmp_path, "report", *given)
    for text in (words, page):
        assert_says(text, once, "a repeatability enters once")
    first, _, rest = page.partition("Errors against their limits")
    assert "twice" not in first
    assert_says(first, "as the maker calibrated it; beside it the budget of procedure")
    assert_says(rest, "error reference of the calibration alone")


def test_a_headline_says_what_stands_for_missing_lines(tmp_path):
    """In words, beside calibration and use; of predicted ones how probable it is."""
    sheet = tmp_path / "bare.yaml"
    bare = SHEET.replace("    scale_factor_repeatability: 300 ppm\n", "")
    sheet.write_text(bare.replace("    g_sensitivity: 1 deg/h/g\n", ""), "utf-8")
    need = tmp_path / "bench.yaml"
    limit = "accelerometer: {scale_factor: 4000 ppm}"
    need.write_text(OF_TEST.replace("accelerometer: {bias: 5 mg}", limit), "utf-8")
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
    given = (
        files["sheet"],
        *("--mission", files["outage"], "--requirement", files["need"]),
    )
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


def test_a_range_that_is_a_text_is_set_beside_that_of_the_other_triad(tmp_path):
    """A text says by its unit whose it is; the change leaves the other one."""
    sheet = tmp_path / "text.yaml"
    of_both = "range: {gyro: 400 deg/s, accelerometer: 10 g}"
    sheet.write_text(SHEET.replace(of_both, "range: 10 g"), encoding="utf-8")
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
    run = call("analyze", files["sheet"], "--set", change)
    assert run.code == 2
    assert_says(run.err, found)


@pytest.mark.parametrize("reference", ["nominal", "as_tested"])
def test_a_requirement_of_the_unit_at_its_test_asks_for_no_use(
    files, tmp_path, reference
):
    """In the place of a use its headline says so."""
    path = tmp_path / "now.yaml"
    text = f"name: now\nreference: {reference}\nlimits:\n  gyro: {{bias: 20 deg/h}}\n"
    path.write_text(text, encoding="utf-8")
    run = told("analyze", files["sheet"], "--requirement", path)
    assert_says(flat(run.out), "an ideal table, as it was in the calibration")
    found = told("analyze", files["sheet"], "--requirement", path, "--json", "-")
    (sensor,) = found.document["assessment"]["sensors"]
    assert (sensor["use"], sensor["conditions"]) == ("as it was in the calibration", [])


@pytest.mark.slow
def test_limits_of_a_mission_and_of_triads_stand_in_one_table(files, tmp_path):
    """Page one has a row for each, with its own limit and what makes it up."""
    need = tmp_path / "all.yaml"
    gyro = "  gyro: {bias: 20 deg/h}\n  accelerometer: {bias: 5 mg}\n  mission"
    need.write_text(NEED.replace("  mission", gyro), encoding="utf-8")
    page = tmp_path / "all.html"
    given = (files["sheet"], "--mission", files["outage"], "--requirement", need)
    told("report", *given, "-o", page)
    (table,) = re.findall(r'(?s)<table id="answer".*?</table>', page.read_text("utf-8"))
    rows = re.findall(r'data-outputs="([^"]+)"', table)
    assert [row.split()[0].rpartition(".")[0] for row in rows[:2]] == [
        *("gyro.bias", "accelerometer.bias")
    ]
    assert all(row.startswith("mission.") for row in rows[2:])
    assert len(rows) > 2
    assert table.count('class="parts"') == len(rows)


@pytest.mark.slow
def test_limits_kept_together_are_used_by_one_number(tmp_path):
    """Card and compare print the utilisation of the verdict, the output's as its own.

    Of 12 limits each met with 97 %, all are met by fewer units than 95 %.
    """
    need = tmp_path / "need.yaml"
    need.write_text(
        "name: all\ncoverage: 95 %\ndecision: joint\nenvironment: none\nlimits:\n"
        "  gyro: {scale_factor: 2300 ppm, mounting_angle: 460 arcsec, "
        "bias: 28.5 deg/h}",
        encoding="utf-8",
    )
    call("analyze", "hg4930#C", "--requirement", need, *LAW, "--json", tmp_path / "j")
    said = call("analyze", "hg4930#C", "--requirement", need, *LAW).out
    (one,) = json.loads((tmp_path / "j").read_text("utf-8"))["assessment"]["sensors"]
    used = round(100.0 * one["utilisation"])
    assert used > 100
    assert one["verdict"] == "fails"
    assert_says(said, f"Its limits, kept together: {used} % used")
    said = call("analyze", "hg4930#C", "--requirement", need, *LAW, "--full").out
    assert_says(said, f"Its limits, kept together: {used} % used.")
    assert_says(said, "93.2 % of its own limit.")
    each = need.read_text("utf-8").replace("decision: joint\n", "")
    need.write_text(each, encoding="utf-8")
    said = call("analyze", "hg4930#C", "--requirement", need, *LAW, "--full").out
    assert_says(said, "93.2 % of the limit.")
    assert "kept together" not in said


def test_what_is_not_judged_is_not_signed(tmp_path):
    """Pairs of two files: nobody judged their misalignment, and the code is 1."""
    (tmp_path / "need.yaml").write_text(
        "name: all\nenvironment: none\nlimits:\n  gyro: {bias: 100 deg/h}\n"
        "  accelerometer: {bias: 50 mg}\n",
        encoding="utf-8",
    )
    both = tmp_path / "both.yaml"
    sheets = []
    for kind in ("gyro", "accelerometer"):
        lines = SHEET[SHEET.index(f"\n{kind}:") + 1 :]
        lines = lines[: lines.index("\naccelerometer:" if kind == "gyro" else "\nvar")]
        sheet = f"name: {kind}\ntechnology: MEMS\n{lines}\n"
        (tmp_path / f"{kind}.yaml").write_text(sheet, encoding="utf-8")
        sheets.append(tmp_path / f"{kind}.yaml")
    how = ("--method", "gum", "--pairs", "--requirement")
    assert call("compare", *sheets, *how, tmp_path / "need.yaml").code == 0
    text = (tmp_path / "need.yaml").read_text("utf-8") + "  misalignment: 900 arcsec\n"
    both.write_text(text, encoding="utf-8")
    run = call("compare", *sheets, *how, both)
    assert run.code == 1
    assert_says(run.out, "not judged")


def test_a_table_is_as_conditional_as_its_headline(tmp_path):
    """A g-sensitivity that is not given is a condition of each row."""
    need, sheet = tmp_path / "need.yaml", tmp_path / "sheet.yaml"
    need.write_text(
        "name: bias\nenvironment: none\nlimits: {gyro: {bias: 900 deg/h}}\n", "utf-8"
    )
    sheet.write_text(SHEET.replace("    g_sensitivity: 1 deg/h/g\n", ""), "utf-8")
    said = call("analyze", sheet, "--requirement", need, *LAW, "--full").out
    assert_says(said, "MEETS bias ON A CONDITION", "conforms on conditions")
    sheet.write_text(SHEET, "utf-8")
    said = call("analyze", sheet, "--requirement", need, *LAW, "--full").out
    assert_says(said, "MEETS bias,", "conforms")
    assert "on conditions" not in said
