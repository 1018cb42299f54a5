"""The sliders in a real Chromium: what they say is what `analyze` says."""

from __future__ import annotations

import json
import re
import shlex
import shutil
from functools import cache
from math import floor, log10

import numpy as np
import pytest
from browsing import chromium, opened, written
from command_line import call
from numpy.testing import assert_allclose
from reading import assert_says, pages_of
from report.test_page import example
from report_examples import make_table
from studies.test_what_if import NOISE, lacking, oblong, on_outage, scaled
from test_language import left_in

from budget import analyze, load_device, load_requirement
from budget.language import LANGUAGES, speaking, template
from budget.methods.radius import radius_of
from budget.question import Question
from budget.report.analysis.what_if import (
    AnalyzeAgain,
    largest_size,
    what_if_section,
)
from budget.report.blocks import (
    Cell,
    Column,
    RowGroup,
    Section,
    Share,
    Shares,
    Sliders,
    Table,
)
from budget.report.tables import print_two_down, print_utilisation, round_error
from budget.report.writing import VERDICTS
from budget.studies.what_if import one_at_a_time, what_if

pytestmark = pytest.mark.slow

AGREES = 1e-9  # two programmes add up the same numbers in another order
TENFOLD = 40  # places of a slider from as it is to ten times
FACTORS = (1.0, 1.1, 250.0, 500.0)
# A sensor of which nobody said anything but what is missing.
UNJUDGED = {"verdict": "", "is_open": False, "conditions": [], "saturates": False}
SOURCES = ("gyro.bias_repeatability", "accelerometer.mounting_repeatability")


@pytest.fixture(scope="module")
def browser():
    """Provide the machine's Chromium."""
    with chromium() as found:
        yield found


@cache
def device():
    """Return the paper's device."""
    return load_device("zhao-2019")


@cache
def requirement():
    """Return limits that some outputs pass when a source grows."""
    return load_requirement("tactical-grade")


@cache
def law():
    """Return what the page must agree with."""
    return what_if(Question.of(device(), requirement=requirement()))


def page_with(folder, model):
    """Write a page with nothing but sliders."""
    sliders = Sliders(model=model, table=make_table("changes"))
    section = Section(name="w", title="W", blocks=(sliders,))
    return written(folder, example(sections=(section,)))


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """Provide the page of the paper's device."""
    return page_with(tmp_path_factory.mktemp("sliders"), law().to_dict())


def move(page, source, keys):
    """Move the slider of one source with the keyboard."""
    words = source.replace(".", " ").replace("_", " ")
    page.get_by_label(f"{words}, times its present size").focus()
    for key in keys:
        page.keyboard.press(key)


def read(page, cell):
    """Return text and exact value of one column of the what-if table, by output.

    Where it has one: of what has no limit no part is used.
    """
    found = page.evaluate(
        "(cell) => [...document.querySelectorAll('.what-if tr[data-output]')].map("
        "(row) => { const c = row.querySelector(`[data-cell=${cell}]`);"
        " return [row.dataset.output, c.textContent, c.dataset.exact]; })",
        cell,
    )
    return {name: (text, float(exact)) for name, text, exact in found if exact}


def as_number(text):
    """Read what the page writes."""
    text = text.replace("\N{MINUS SIGN}", "-").replace(" × 10", "e")  # noqa: RUF001
    return float(text.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")))


MOVES = (
    (["ArrowRight"] * 12, 10.0 ** (12 / TENFOLD)),
    (["End"], 10.0),
    (["Home"], 0.0),
    (["ArrowLeft"] * 10, 10.0 ** (-10 / TENFOLD)),
)


@pytest.mark.usefixtures("nothing_is_missing")
@pytest.mark.parametrize("source", SOURCES)
def test_slider_agrees_with_the_analysis_of_a_changed_device(browser, path, source):
    """U, mean and utilisation in the page are those of `analyze`, to four digits.

    Wherever the slider is moved to, from as it is.
    """
    limits = {limit.output: limit.limit for limit in requirement().limits}
    shown = []
    with opened(browser, path) as (page, record):
        for keys, _ in MOVES:
            move(page, source, keys)
            shown.append([read(page, cell) for cell in ("expanded", "mean", "used")])
            page.get_by_role("button", name="Reset all").click()

    assert record.complaints == []
    for (_, factor), (expanded, mean, used) in zip(MOVES, shown, strict=True):
        truth = analyze(
            scaled(device(), {source: factor}),
            validate=False,
            coverage=requirement().coverage,
            reference=requirement().reference,
        )
        assert len(expanded) == len(truth.outputs) == 24
        for row in truth.outputs:
            name, scale = row.output.name, row.output.si_per_unit
            half = (row.interval[1] - row.interval[0]) / 2.0 / scale
            assert_allclose(expanded[name][1], half, rtol=AGREES)
            # The last of two digits of u; half a unit more where u rounds up to 10.
            last = 10.0 ** (floor(log10(row.standard_uncertainty / scale)) - 1)
            last *= 10.0 if row.standard_uncertainty / scale / last >= 99.5 else 1.0
            printed = as_number(expanded[name][0])
            assert_allclose(printed, half, rtol=0, atol=0.51 * last)
            assert_allclose(
                mean[name][1],
                row.mean / scale,
                rtol=AGREES,
                atol=row.output.resolution / scale,
            )
            utilisation = row.largest_error / limits[name]
            assert_allclose(used[name][1], utilisation, rtol=AGREES)


def test_field_takes_the_standard_uncertainty(browser, path):
    """A number typed into the field counts as it stands, with comma or point."""
    model = law()
    wanted = model.evaluate({"gyro.bias_repeatability": 0.123 / 0.05})
    names = [output.name for output in model.outputs]
    k = names.index("gyro.bias.x")
    with opened(browser, path) as (page, _):
        field = page.get_by_label("gyro bias repeatability, specification value")
        field.fill("0,123")
        field.press("Enter")
        field.blur()
        u = read(page, "expanded")["gyro.bias.x"][1]

    expected = model.coverage_factor[k] * wanted.u[k] / model.outputs[k].si_per_unit
    assert_allclose(u, expected, rtol=AGREES)


def test_field_refuses_what_is_no_size(browser, path):
    """A word or a negative number changes nothing and says what is expected."""
    with opened(browser, path) as (page, _):
        before = read(page, "expanded")
        field = page.get_by_label("gyro bias repeatability, specification value")
        for text in ("much", "-1", "", "0x10", "1 2", "Infinity", "NaN", "1e-"):
            field.fill(text)
            field.blur()
            assert field.get_attribute("aria-invalid") == "true"
            assert page.get_by_text("expected a number from 0 on").is_visible()
            assert read(page, "expanded") == before


def test_field_takes_a_size_that_the_law_can_be_asked_of(browser, path):
    """1e76 is refused in words; a retyped original changes nothing, as does 0x10."""
    with opened(browser, path) as (page, record):
        before, said = read(page, "expanded"), page.locator(".outlook").inner_text()
        field = page.get_by_label("gyro bias repeatability, specification value")
        original = field.input_value()
        for text in ("1e999", "1e76"):
            field.fill(text)
            field.blur()
            assert field.get_attribute("aria-invalid") == "true"
        assert page.get_by_text("a million times its size").is_visible()
        assert page.locator(".outlook").inner_text() == said
        field.fill(f"+{original}")
        field.blur()
        assert field.get_attribute("aria-invalid") is None
        assert read(page, "expanded") == before
        assert page.locator(".control.changed").count() == 0
        field.fill(f"{float(original) * 1e5:g}")
        field.blur()
        fails = page.locator(".outlook").inner_text()
    assert record.complaints == []
    assert "Gyro: FAILS" in fails
    assert "NaN" not in fails


def test_what_is_not_within_a_limit_fails(browser, path):
    """Also what is no number: nothing but a part of 1 at the most meets."""
    model = {
        "sensors": [{"name": "gyro", "missing": [], "doubt": [1, 1], **UNJUDGED}],
        "outputs": [{"name": "gyro.bias.x", "sensor": "gyro"}],
    }
    with opened(browser, path) as (page, _):
        for used in ("NaN", "Infinity", "1.0001"):
            (found,) = page.evaluate(
                "([m, used]) => judge(m, [{utilisation: Number(used)}])", [model, used]
            )
            assert found["verdict"] == "FAILS"
            assert found["worst"] == 0


def test_verdict_follows_the_sliders(browser, path):
    """The verdict is that of the law in Python, is spoken, and can be taken back."""
    model = law()
    outlook = model.evaluate({"gyro.scale_factor_repeatability": 10.0})
    worst = {s.sensor: s for s in outlook.sensors}["gyro"]
    with opened(browser, path) as (page, _):
        said = page.locator(".outlook")
        first = said.inner_text()
        move(page, "gyro.scale_factor_repeatability", ["End"])
        then = said.inner_text()
        beyond = page.locator(".what-if tr.beyond").all_inner_texts()
        page.get_by_role("button", name="Reset all").click()
        last = said.inner_text()

    assert "Gyro: MEETS" in first
    assert worst.verdict == "fails"
    part = f"{100 * worst.utilisation:.0f} %"
    assert f"Gyro: FAILS. gyro scale factor x, y, z at {part}" in then
    assert "as it is: MEETS" in then
    assert len(beyond) == 3
    assert all("does not conform" in row for row in beyond)
    assert last == first


def test_missing_line_makes_a_pass_undecidable(browser, tmp_path):
    """A sensor that would pass waits for the line that its data sheet lacks."""
    model = next(s for s in example().sections if s.name == "what-if").blocks[0].model
    model = {
        **model,
        "sensors": [
            {
                "name": "gyro",
                "title": "gyro",
                "missing": ["angle random walk"],
                "doubt": [1, 1],
                **UNJUDGED,
                "is_open": True,
            }
        ],
    }
    with opened(browser, page_with(tmp_path, model)) as (page, _):
        said = page.locator(".outlook")
        first = said.inner_text()
        move(page, "gyro.bias_repeatability", ["End"])

        assert_says(first, "Gyro: UNDECIDABLE", "angle random walk is not given")
        assert "Gyro: FAILS" in said.inner_text()


def test_conditions_leave_a_pass_that_holds_if(browser, tmp_path):
    """The word is Python's at every size, with what it holds if beside it."""
    budget = lacking()
    model = what_if(budget.question, budget=budget)
    names = [source.name for source in model.sources]
    with opened(browser, page_with(tmp_path, model.to_dict())) as (page, record):
        first = page.locator(".outlook").inner_text()
        words = [
            page.evaluate(
                "([model, factors]) => evaluate(model, factors).sensors[0].verdict",
                [model.to_dict(), [factor if name == NOISE else 1.0 for name in names]],
            )
            for factor in FACTORS
        ]

    (standing,) = (one for one in budget.assessment.sensors)
    assert record.complaints == []
    assert_says(first, "Gyro: MEETS IF", "gyro mounting repeatability stays below")
    assert standing.verdict == "meets_if"
    found = [model.evaluate({NOISE: factor}).sensors[0].verdict for factor in FACTORS]
    assert words == [VERDICTS[one] for one in found]
    assert set(found) == {"meets_if", "undecidable", "fails"}


def test_of_outputs_alike_the_first_is_the_worst(browser, path):
    """A difference of rounding does not make the page name another output."""
    model = {
        "sensors": [{"name": "gyro", "missing": [], "doubt": [1, 1], **UNJUDGED}],
        "outputs": [{"name": f"gyro.bias.{axis}", "sensor": "gyro"} for axis in "xyz"],
    }
    used = (0.5, 0.5 * (1.0 + 1e-15), 0.4)
    rows = [{"utilisation": part} for part in used]
    with opened(browser, path) as (page, _):
        (found,) = page.evaluate("([m, rows]) => judge(m, rows)", [model, rows])

    assert used[1] > used[0]
    assert found["worst"] == 0


PARTS = {
    0.9996: "99.96 %",
    1.0 - 1e-9: "<100 %",
    1.0 - 1e-13: "100 %",
    1.0003: "100.03 %",
    1.0 + 1e-9: ">100 %",
    1.006: "100.6 %",
    1.06: "106 %",
    0.9994: "99.9 %",
    0.0004: "0.0400 %",
}


def test_a_hundred_per_cent_is_the_whole(browser, path):
    """A part of a limit reads as on the rest of the page; 100 % is met exactly."""
    assert [print_utilisation(part) for part in PARTS] == [*PARTS.values()]
    with opened(browser, path) as (page, _):
        said = page.evaluate("(parts) => parts.map((p) => perCent(p))", [*PARTS])
    assert said == [*PARTS.values()]


def test_sliders_without_a_requirement_show_uncertainties(browser, tmp_path):
    """Without limits there are no columns of utilisation and no verdict."""
    model = what_if(Question.of(device())).to_dict()
    with opened(browser, page_with(tmp_path, model)) as (page, record):
        heads = page.locator(".what-if thead th").all_inner_texts()

        assert "No requirement" in page.locator(".outlook").inner_text()
        assert not [head for head in heads if "limit" in head]
        assert record.complaints == []


def test_sources_that_change_nothing_are_folded(browser, path):
    """Below 0.1 % of every variance a slider is behind a line that says how many."""
    model = law()
    small = (model.evaluate({}).share < 1e-3).all(axis=0)
    with opened(browser, path) as (page, _):
        folded = page.locator(".controls details .control")
        assert folded.count() == small.sum() > 0
        assert not folded.first.is_visible()
        page.get_by_text(f"{small.sum()} more, each below 0.1 %").click()
        assert folded.first.is_visible()
        page.goto("about:blank")
        name = model.sources[int(small.argmax())].name
        page.goto(f"{path.as_uri()}#what-if?{name}=2")
        assert page.locator(".control.changed").is_visible()


# ---- what the largest size is that meets ---------------------------------------------


@pytest.mark.parametrize("grade", ["tactical-grade", "navigation-grade", "mission"])
def test_page_finds_the_largest_size_that_the_table_has(browser, path, grade):
    """It is the number of Python for every source: some size, any, or none."""
    if grade == "mission":
        model = what_if(carried().question, budget=carried())
    else:
        wanted = load_requirement(grade)
        model = what_if(Question.of(device(), requirement=wanted))
    rows = {row.source.name: row.most for row in one_at_a_time(model)}
    with opened(browser, path) as (page, record):
        found = page.evaluate(
            "(m) => m.sources.map((_, g) => seek(m, m.sources.map(() => 1), g).factor)",
            model.to_dict(),
        )

    assert record.complaints == []
    assert len(rows) == len(found) > 0
    for source, factor in zip(model.sources, found, strict=True):
        if rows[source.name] is None:
            assert factor is None
        else:
            # Twelve digits of what is used are fewer of a source that adds little.
            assert_allclose(factor, rows[source.name], rtol=1e-6)


def test_button_sets_the_slider_to_what_meets(browser, path):
    """Size and factor are those of the table, and there all of the limit is used."""
    source = "gyro.scale_factor_repeatability"
    row = next(r for r in one_at_a_time(law()) if r.source.name == source)
    words = source.replace(".", " ").replace("_", " ")
    with opened(browser, path) as (page, record):
        page.get_by_role("button", name=f"What meets? {words}").click()
        said = page.locator(".control.changed .sought").inner_text()
        verdict = page.locator(".outlook").inner_text()
        size = (
            f"{largest_size(row)} (\N{MULTIPLICATION SIGN} {print_two_down(row.most)})"
        )
        assert said == f"meets up to {size}"
        used = read(page, "used")["gyro.scale_factor.x"][1]
        assert "Gyro: MEETS." in verdict
        assert 0.999 < used <= 1.0
        assert f"#what-if?{source}=" in page.url
        move(page, source, ["ArrowRight"])
        assert "Gyro: FAILS" in page.locator(".outlook").inner_text()
        assert page.locator(".sought").all_inner_texts().count("") == len(law().sources)
    assert record.complaints == []


def test_where_nothing_meets_the_page_says_what_is_in_the_way(browser, tmp_path):
    """The slider stays, and output and source that exceed the limit are named."""
    model = what_if(
        Question.of(device(), requirement=load_requirement("navigation-grade"))
    )
    with opened(browser, page_with(tmp_path, model.to_dict())) as (page, _):
        page.get_by_role("button", name="What meets? gyro bias stability").click()
        said = " ".join(page.locator(".sought").all_inner_texts())
        assert page.locator(".control.changed").count() == 0
    assert_says(said, "no value meets", "beyond the limit without it", "mainly")


# ---- limits on a mission -------------------------------------------------------------


@cache
def carried():
    """Return the budget of a device against limits on a mission."""
    return on_outage(oblong())


@pytest.mark.parametrize(
    ("source", "key", "factor"),
    [
        ("gyro.bias_repeatability", "End", 10.0),
        ("accelerometer.bias_repeatability", "Home", 0.0),
    ],
)
def test_limits_on_a_mission_follow_the_sliders(browser, tmp_path, source, key, factor):
    """Verdict, radius of the circle, utilisation and shares are those in Python."""
    model = what_if(carried().question, budget=carried())
    outlook = model.evaluate({source: factor})
    with opened(browser, page_with(tmp_path, model.to_dict())) as (page, record):
        first = page.locator(".outlook").inner_text()
        move(page, source, [key])
        expanded, used = read(page, "expanded"), read(page, "used")
        said = page.locator(".outlook").inner_text()
        heads = page.locator(".what-if tr[data-output^=mission] th").all_inner_texts()
        shares = page.locator(
            ".what-if tr[data-output='mission.position.horizontal.60'] td:last-child"
        ).inner_text()

    verdict = next(one for one in outlook.sensors if one.sensor == "mission")
    place = "mission.position.horizontal.60"
    k = [output.name for output in model.outputs].index(place)
    assert record.complaints == []
    assert_allclose(expanded[place][1], outlook.interval[k, 1], rtol=1e-6)
    assert used[place][0] == print_utilisation(outlook.utilisation[k])
    heading = "mission.attitude.heading.10"
    row = [output.name for output in model.outputs].index(heading)
    assert_allclose(used[heading][1], outlook.utilisation[row], rtol=AGREES)
    assert "Mission: FAILS. horizontal position after 1 min at 115 %" in first
    part = print_utilisation(verdict.utilisation)
    worst = {place: "horizontal position after 1 min", heading: "heading after 10 s"}
    named = worst[verdict.worst_outputs[0]]
    assert f"Mission: {verdict.verdict.upper()}. {named} at {part}" in said
    largest = model.sources[int(outlook.share[k].argmax())].name
    assert shares.startswith(largest.replace(".", " ").replace("_", " "))
    assert heads == ["heading, 10 s", "horizontal, 1 min (50\N{NO-BREAK SPACE}%)"]


def test_radius_of_the_page_is_that_of_the_law(browser, path):
    """Circles and lines and all between, at the coverages that limits are set at."""
    ratios = [0.0, 1e-8, 1e-4, 1e-2, 0.1, 0.5, 1.0]
    coverages = [0.1, 0.5, 0.9, 0.95, 0.99, 0.9999]
    with opened(browser, path) as (page, _):
        found = page.evaluate(
            "([ps, bs]) => ps.map((p) => bs.map((b) => radiusOf(p, 4, 4 * b)))",
            [coverages, ratios],
        )
    variances = np.array([np.full(len(ratios), 4.0), 4.0 * np.array(ratios)])
    for p, row in zip(coverages, found, strict=True):
        assert_allclose(row, radius_of(p, variances), rtol=1e-6)


# ---- what is changed: as a file, in the address, against another, on paper -----------

MAKERS = """
format: budget-device/1
name: "\\ue0005\\ue000 O'Neill's \\u200b\\"unit\\" 赵"
gyro:
  nominal: {bias: 2 deg/h, mounting_angle: 3 arcsec}
  errors:
    bias_repeatability: {axes: {x: 0.1 deg/h, y: 0.2 deg/h, z: 0.3 deg/h}}
    bias_stability: {value: 0.3 deg/h, meaning: max, correlation_time: 100 s}
    angle_random_walk: {value: 0.02 deg/h/sqrt(Hz), density: one-sided}
    scale_factor_repeatability: 60 ppm
"""
AGAIN = AnalyzeAgain(
    same="budget analyze imu.yaml --no-validate",
    of_file="budget analyze changed.yaml --no-validate",
)


@pytest.fixture(scope="module")
def changeable(tmp_path_factory):
    """Provide the page of a device in a maker's words, beside its file."""
    folder = tmp_path_factory.mktemp("changeable")
    (folder / "imu.yaml").write_text(MAKERS, encoding="utf-8")
    budget = analyze(load_device(folder / "imu.yaml"), validate=False)
    question = Question.of(load_device(folder / "imu.yaml"))
    model = what_if(question, budget=budget)
    section = what_if_section(
        budget, model, one_at_a_time(model), devices=question.devices, again=AGAIN
    )
    return written(folder, example(sections=(section,)))


def handed_out(page):
    """Return the command and the device file that the page gives."""
    fields = page.locator(".hand-out textarea")
    return [fields.nth(k).input_value() for k in (0, 1)]


@pytest.mark.parametrize(
    ("changes", "by_set"),
    [
        ({"bias_stability": "End", "scale_factor_repeatability": "Home"}, True),
        ({"bias_repeatability": "PageUp", "angle_random_walk": "ArrowLeft"}, False),
        ({"angle_random_walk": "End"}, True),
    ],
)
def test_tool_reads_the_changed_device_back(
    browser, changeable, monkeypatch, changes, by_set
):
    """File and command give the numbers of the page; --set where lines are one number.

    A bound stays a bound, axes stay apart, a source that is switched off is there as 0.
    """
    monkeypatch.chdir(changeable.parent)
    with opened(browser, changeable) as (page, record):
        for line, key in changes.items():
            move(page, f"gyro.{line}", [key])
        command, text = handed_out(page)
        expanded = read(page, "expanded")
    (changeable.parent / "changed.yaml").write_text(text, encoding="utf-8")
    words = shlex.split(command)
    run = call(*words[1:], "--json", "again.json")

    assert record.complaints == []
    assert words[:2] == ["budget", "analyze"]
    assert words.count("--set") == (len(changes) if by_set else 0)
    assert load_device("changed.yaml").name.startswith("\ue0005\ue000 O'Neill's")
    assert (run.code, words[2]) == (0, "imu.yaml" if by_set else "changed.yaml")
    budget = analyze(load_device("changed.yaml"), validate=False)
    again = json.loads((changeable.parent / "again.json").read_text(encoding="utf-8"))
    assert len(again["outputs"]) == len(budget.outputs) == 12
    for row, told in zip(budget.outputs, again["outputs"], strict=True):
        name, scale = row.output.name, row.output.si_per_unit
        half = (row.interval[1] - row.interval[0]) / 2.0 / scale
        assert_allclose(expanded[name][1], half, rtol=AGREES)
        low, high = told["interval"]
        assert_allclose((high - low) / 2.0, half, rtol=AGREES)


def test_address_keeps_both_scenarios(browser, changeable):
    """A reload, and the address opened anew, bring back what is changed and kept."""
    with opened(browser, changeable) as (page, record):
        move(page, "gyro.bias_stability", ["End"])
        page.get_by_role("button", name="Keep to compare").click()
        move(page, "gyro.scale_factor_repeatability", ["ArrowRight"] * 7)
        shown = [read(page, cell) for cell in ("before", "expanded")]
        heads = page.locator(".what-if thead th").all_inner_texts()
        link = page.url
        page.reload()
        assert [read(page, cell) for cell in ("before", "expanded")] == shown
        page.goto("about:blank")
        page.goto(link)
        assert [read(page, cell) for cell in ("before", "expanded")] == shown
        page.get_by_role("button", name="Forget what is kept").click()
        now = page.locator(".what-if thead th").all_inner_texts()
        page.get_by_role("button", name="Reset all").click()
        assert page.locator(".control.changed").count() == 0
        assert page.url.endswith("#what-if")
    assert shown[0] != shown[1]
    assert heads[1].split() == ["U", "kept"]
    assert now[1].split() == ["U", "as", "it", "is"]
    assert record.complaints == []


def test_link_within_the_page_leaves_the_changes_in_the_address(browser, changeable):
    """Wherever one has gone in the page, its address copied shows what is shown."""
    with opened(browser, changeable) as (page, record):
        link = "document.querySelector('main, body').insertAdjacentHTML('beforeend',"
        page.evaluate(f"{link} '<a id=there href=#there>there</a>')")
        page.locator("#there").click()
        assert page.url.endswith("#there")
        move(page, "gyro.bias_stability", ["End"])
        shown = read(page, "expanded")
        for _ in range(2):
            page.locator("#there").click()
            page.wait_for_url(lambda url: "#what-if?" in url)  # no eval: see policy
            assert page.evaluate("scrollY") > 0
        copied = page.url
        page.goto("about:blank")
        page.goto(copied)
        assert read(page, "expanded") == shown
        assert page.locator(".control.changed").count() == 1
    assert record.complaints == []


def sizes(page):
    """Return what the fields of all sources show."""
    return page.locator(".size input").evaluate_all("(all) => all.map((e) => e.value)")


def test_back_undoes_a_change(browser, changeable):
    """A run of keys on one slider is one change; Forward does it again."""
    with opened(browser, changeable) as (page, record):
        page.goto("about:blank")
        page.goto(changeable.as_uri())
        shown = [sizes(page)]
        for line in ("bias_stability", "scale_factor_repeatability"):
            move(page, f"gyro.{line}", ["ArrowRight"] * 5)
            shown.append(sizes(page))
        page.get_by_role("button", name="Reset all").click()
        shown.append(sizes(page))
        walked = []
        for step in ("back", "back", "back", "forward", "forward"):
            page.evaluate(f"history.{step}()")
            page.wait_for_timeout(150)
            walked.append(sizes(page))
            assert (page.locator(".altered").count() == 1) == (walked[-1] != shown[0])
        assert walked == [shown[k] for k in (2, 1, 0, 1, 2)]
    assert shown[0] == shown[3]
    assert len({*map(tuple, shown)}) == 3
    assert record.complaints == []


def test_verdict_is_spoken_when_a_change_is_finished(browser, path):
    """Not on every tick of a drag."""
    with opened(browser, path) as (page, _):
        spoken = page.locator(".what-if [aria-live=polite]")
        slider = page.get_by_label("gyro scale factor repeatability, times its")
        before = spoken.inner_text()
        for value in ("20", "40"):
            slider.evaluate(
                "(e, v) => { e.value = v; e.dispatchEvent(new Event('input')); }", value
            )
        assert "Gyro: FAILS" in page.locator(".outlook").inner_text()
        assert spoken.inner_text() == before
        slider.dispatch_event("change")
        assert "Gyro: FAILS" in spoken.inner_text()


def test_what_is_touched_is_large_enough_on_a_phone(browser, changeable):
    """Targets are 24 px high at the least and nothing is wider than the screen."""
    with opened(browser, changeable, width=400) as (page, _):
        move(page, "gyro.bias_stability", ["End"])
        for one in page.locator(
            ":is(.what-if, .stamp) :is(button, input, summary)"
        ).all():
            if one.is_visible():
                box = one.bounding_box()
                assert min(box["height"], box["width"]) >= 24
        assert page.evaluate("document.documentElement.scrollWidth") == 400


NO_CHANGES = (
    ("gyro.bias_drift=2", '"gyro.bias_drift" is no source of this report'),
    ("<img src=x onerror=alert(1)>=1", "is no source"),
    ("gyro.bias_stability=<script>", "expected a number from 0 to a million"),
    ("gyro.bias_stability=1e7", "expected a number from 0 to a million"),
    ("gyro.bias_stability=-1", "expected a number from 0 to a million"),
    ("gyro.bias_stability=NaN&kept.gyro.bias_stability=1", "expected a number"),
    ("gyro.bias_stability=2&gyro.bias_stability=3", "stands there twice"),
    ("kept.__proto__=3", "is no source"),
    ("%ff%00\u202e=1", "is no source"),
    ("x" * 5000, "5000 characters, 4000 are allowed"),
)


def test_address_that_is_no_change_is_refused(browser, changeable):
    """It is said what is wrong with it; the report stands as it is."""
    with opened(browser, changeable) as (page, record):
        before = read(page, "expanded")
        elements = page.locator("*").count()
        for fragment, said in NO_CHANGES:
            move(page, "gyro.bias_stability", ["End"])
            assert page.locator(".altered").count() == 1
            page.goto(f"{changeable.as_uri()}#what-if?{fragment}")
            assert_says(page.get_by_role("alert").inner_text(), said, "not taken")
            assert read(page, "expanded") == before
            assert page.locator("*").count() == elements
            assert page.locator(".altered").count() == 0
            assert "\u202e" not in page.locator(".wrong").inner_text()
    assert record.complaints == []


def test_page_with_a_slider_moved_is_not_printed_as_the_report(
    browser, changeable, tmp_path
):
    """Every sheet says CHANGED, nothing is there to sign; taken back, it is gone."""
    if shutil.which("pdftotext") is None:
        pytest.skip("reads the sheets by pdftotext")
    with opened(browser, changeable) as (page, _):
        sheets = []
        for act in ("as it is", "End", "Reset all"):
            if act == "End":
                move(page, "gyro.bias_stability", [act])
            elif act == "Reset all":
                page.get_by_role("button", name=act).click()
            pdf = page.pdf(format="A4", prefer_css_page_size=True)
            sheets.append(pages_of(pdf, tmp_path))
            assert page.title().startswith("CHANGED") == (act == "End")
    plain, changed, back = sheets
    assert all("CHANGEDbywhat-if,notthereport" in sheet for sheet in changed)
    assert "gyrobiasstability×10" in changed[0]  # noqa: RUF001 - as it is printed
    assert "CHANGED" not in "".join(plain)
    assert back == plain


# ---- page one ------------------------------------------------------------------------


def answered(folder):
    """Write a page with an answer on page one: two groups, one of them limited."""
    model = law()
    outlook = model.evaluate({})
    columns = (
        Column(head="error"),
        *(Column(head=role, kind="number", role=role) for role in ("u95", "used")),
        Column(head="shares", role="shares"),
    )
    rows = []
    for group in ("gyro.bias", "accelerometer.bias"):
        names = tuple(f"{group}.{axis}" for axis in "xyz")
        k = [one.name for one in model.outputs].index(names[0])
        end = abs(outlook.interval[k]).max()
        error = round_error(end, outlook.u[k], model.outputs[k], limit=model.limit[k])
        part = Share(name=SOURCES[0], text="all", share=1.0, colour="#000000")
        rows.append(
            (
                Cell(text=group),
                Cell(text=error.text, exact=error.exact),
                Cell(text=print_utilisation(outlook.utilisation[k])),
                Cell(text="all", shares=Shares(outputs=names, parts=(part,))),
            )
        )
    table = Table(
        name="answer",
        caption="Answer",
        columns=columns,
        groups=(RowGroup(rows=tuple(rows)),),
    )
    sliders = Sliders(model=model.to_dict(), table=make_table("changes"))
    sections = (
        Section(name="first", title="A", blocks=(table,), on_first_page=True),
        Section(name="w", title="W", blocks=(sliders,)),
    )
    return written(folder, example(sections=sections))


def test_page_one_follows_the_sliders(browser, tmp_path):
    """Headline and table have the changed numbers and say so; Reset brings all back."""
    source = SOURCES[0]
    model = law()
    outlook = model.evaluate({source: 0.1})
    k = [one.name for one in model.outputs].index("gyro.bias.x")
    with opened(browser, answered(tmp_path)) as (page, record):
        of_page_one = "() => [...document.querySelectorAll('.verdict, #answer')]"
        before = page.evaluate(f"{of_page_one}.map((e) => e.outerHTML)")
        move(page, source, ["Home", "ArrowRight"])
        row = page.locator("#answer tr[data-outputs]").first
        error = row.locator("[data-role=u95]").inner_text().split()
        used = row.locator("[data-role=used]").inner_text().split("was")[0].strip()
        parts = row.locator(".parts > span")
        largest = parts.evaluate_all(
            "(all) => all.sort((a, b) => b.offsetWidth - a.offsetWidth)[0]"
            ".dataset.source"
        )
        headline = page.locator(".verdict .word").inner_text()
        marks = page.locator("#answer caption").all_inner_texts()
        still = page.locator("#answer tr[data-outputs]").nth(1).inner_text()
        banner = page.locator(".stamp")
        assert banner.is_visible()
        assert_says(banner.inner_text(), "Gyro: MEETS", "gyro bias repeatability")
        page.get_by_role("button", name="Reset", exact=True).click()
        assert not banner.is_visible()
        after = page.evaluate(f"{of_page_one}.map((e) => e.outerHTML)")

    truth = abs(outlook.interval[k]).max() / model.outputs[k].si_per_unit
    assert record.complaints == []
    assert_allclose(as_number(error[0]), truth, rtol=0.05)
    assert used == print_utilisation(outlook.utilisation[k])
    assert largest == model.sources[int(outlook.share[k].argmax())].name != source
    assert headline.startswith("CHANGED")
    assert marks == ["CHANGED"]
    assert "was" not in still
    assert after == before


# ---- in another language -------------------------------------------------------------


@cache
def judged():
    """Return the budget of the paper's device against limits, as a model of it."""
    budget = analyze(device(), requirement=requirement(), validate=False)
    question = Question.of(device(), requirement=requirement())
    return budget, what_if(question, budget=budget)


def page_in(folder, language):
    """Write the page of that budget in a language, with a table to search."""
    budget, model = judged()
    with speaking(language):
        section = what_if_section(
            budget, model, one_at_a_time(model), devices=(device(),), again=AGAIN
        )
    found = Section(name="t", title="T", blocks=(make_table("t", searchable=True),))
    return written(folder, example(sections=(section, found), language=language))


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """Provide the same page in each language."""
    return {
        language: page_in(tmp_path_factory.mktemp(language), language)
        for language in LANGUAGES
    }


def push(page, source, key):
    """Press a key on the slider of one source, whatever the page calls it."""
    place = [one.name for one in law().sources].index(source)
    page.locator(".control input[type=range]").nth(place).press(key)


def told(page):
    """Return all that is read or spoken of the what-if section, and of the stamp."""
    return page.evaluate(
        "() => { const all = [...document.querySelectorAll("
        "'#what-if, #what-if *, .stamp, .stamp *')];"
        " document.querySelectorAll('details').forEach((e) => { e.open = true; });"
        " return [document.querySelector('#what-if').innerText,"
        " document.querySelector('.stamp').textContent, ...all.flatMap((e) =>"
        " ['aria-label', 'aria-valuetext', 'title'].map((a) => e.getAttribute(a) ?? '')"
        ")].join('\\n'); }"
    )


def test_panel_speaks_the_language_of_its_page(browser, pages):
    """A slider in Chinese has the numbers of the English one, and Chinese verdicts.

    Nothing in the section is left in English: at first, changed, kept, with a size
    that is refused.
    """
    source = "gyro.scale_factor_repeatability"
    numbers, texts = [], {}
    for language, path in pages.items():
        with opened(browser, path) as (page, record):
            outlook = page.locator(".outlook")
            texts[language] = [told(page), outlook.inner_text()]
            push(page, source, "End")
            numbers.append([read(page, cell) for cell in ("expanded", "mean", "used")])
            texts[language] += [told(page), outlook.inner_text()]
            beyond = page.locator(".what-if tr.beyond").all_inner_texts()
            page.locator(".buttons button").first.click()
            push(page, source, "Home")
            for row, size in enumerate(("much", "1e76")):
                page.locator(".size input").nth(row).fill(size)
                page.locator(".size input").nth(row).blur()
            texts[language] += [told(page), page.title()]
            page.locator("[type=search]").fill("scale")
            texts[language].append(page.locator(".search output").inner_text())
        assert record.complaints == []
        assert record.requests == [path.as_uri()]
        assert len(beyond) == 3
    start, first, changed, then, kept, title, count = texts["zh"]

    assert numbers[0] == numbers[1]
    assert re.search(r"^陀螺.满足", first)
    assert re.search(
        r"^陀螺.不满足。陀螺标度因数 x、y、z.为限值的 \d+ %.现在.满足", then
    )
    assert all("不合格" in row for row in beyond)
    assert all(one in kept for one in ("留存", "已由假设分析改变", "应为不小于 0 的数"))
    assert title.startswith("已改变")
    assert re.fullmatch(r"\d+ 行中的 2 行", count)
    assert [left_in(text) for text in (start, changed, kept)] == [[], [], []]
    assert "undefined" not in "".join(texts["zh"] + texts["en"])
    assert len(left_in(texts["en"][0])) > 30


def test_hostile_address_is_refused_in_the_language_of_the_page(browser, pages):
    """What stands in quotation marks is the address's, all else is Chinese."""
    with opened(browser, pages["zh"]) as (page, record):
        elements = page.locator("*").count()
        for fragment, _ in NO_CHANGES:
            page.goto(f"{pages['zh'].as_uri()}#what-if?{fragment}")
            said = page.get_by_role("alert").inner_text()
            assert said.startswith("未采用地址中的改变")
            assert left_in(re.sub('"[^"]*"', "", said)) == []
            assert page.locator("*").count() == elements
    assert record.complaints == []


def test_word_without_a_translation_stays_english(browser, tmp_path, monkeypatch):
    """The page says it as it is written, and the others in its own language."""
    monkeypatch.setattr(
        "budget.report.page.template",
        lambda text: text if text == "Reset all" else template(text),
    )
    with opened(browser, page_in(tmp_path, "zh")) as (page, record):
        buttons = page.locator(".buttons button").all_text_contents()

    assert buttons == ["留存以作比较", "清除留存", "Reset all"]
    assert record.complaints == []
