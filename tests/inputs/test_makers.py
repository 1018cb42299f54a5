"""Words of makers: each line has some, each is answered, each link is in the page."""

from __future__ import annotations

import re

import pytest
import yaml
from places import DOCS, ROOT

from budget.errors import SpecError
from budget.inputs import json_schema, load_device
from budget.inputs.device import read_device
from budget.inputs.makers import PAGE, bare, readings
from budget.inputs.reader import parse
from budget.model.sources import SENSORS, lines_of
from budget.units import WALK_PER_DENSITY, UnitError, parse_quantity, per_root_hertz

TEXT = (ROOT / PAGE).read_text(encoding="utf-8")
WORDS = [
    (line, word)
    for one in readings()
    for line, words in one.words.items()
    for word in words
]


def anchors(text):
    """Return the anchors of a page's headings, as GitHub makes them."""
    heads = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    return {re.sub(r"[^\w -]", "", head).lower().replace(" ", "-") for head in heads}


def test_every_line_of_a_device_has_words():
    """A line that is added is printed as something, and nothing else has words."""
    lines = {line.name for sensor in SENSORS for line in lines_of(sensor)}
    named = [line for one in readings() for line in one.words]
    assert sorted(named) == sorted(lines)
    assert all(words for one in readings() for words in one.words.values())


@pytest.mark.parametrize(("line", "word"), WORDS)
def test_a_word_in_the_place_of_a_line_is_answered_with_the_line(line, word):
    """The error names the line and the place in the page, for one sensor at least."""
    said = []
    for sensor in SENSORS:
        text = f"name: x\n{sensor}:\n  errors:\n    {word}: 1 ppm\n"
        try:
            read_device(parse(text.encode(), "x.yaml", base_name="x.yaml"))
        except SpecError as error:
            said.append(str(error))
    link = next(one.link for one in readings() if line in one.words)
    if bare(word) == bare(line):  # 'rate random walk' is its own line, misspelled
        assert any(f"'{line}'" in text for text in said)
        return
    answers = [
        text for text in said if f"'{line}'" in text.partition("did you mean")[2]
    ]
    assert answers
    assert any(link in text for text in answers)


def every_link():
    """Return each place that the package's own texts refer to in the page."""
    sources = (ROOT / "budget").rglob("*.py")
    texts = [path.read_text(encoding="utf-8") for path in sources]
    written = {
        found for text in texts for found in re.findall(r"\{PAGE\}#([\w-]+)", text)
    }
    return written | {one.anchor for one in readings()}


def test_every_link_leads_somewhere():
    """Anchors in messages, schema and other pages are headings of the page."""
    assert {"units", "what-a-value-means", "bias-stability"} <= every_link()
    assert every_link() <= anchors(TEXT)
    pages = [*DOCS.glob("*.md"), ROOT / "README.md"]
    linked = {
        found
        for page in pages
        for found in re.findall(r"datasheets\.md#([\w-]+)", page.read_text("utf-8"))
    }
    assert linked <= anchors(TEXT)
    assert set(re.findall(r"\]\(#([\w-]+)\)", TEXT)) <= anchors(TEXT)


def test_the_schema_says_the_same_words():
    """An editor shows a line's words and link with its key."""
    schema = json_schema("device")["$defs"]
    for sensor in SENSORS:
        keys = schema[f"{sensor}_errors"]["properties"]
        for one in readings():
            for line in one.words.keys() & keys.keys():
                told = keys[line]["description"]
                assert all(word in told for word in one.words[line])
                assert one.link in told


# ---- what the page says, held against what the package does --------------------------


def sheets():
    """Return the worked data sheets of the page: device and its lines."""
    for text in re.findall(
        r"^```yaml\n# (\S+#\S+)\n(.*?)^```", TEXT, re.MULTILINE | re.DOTALL
    ):
        yield text[0], yaml.BaseLoader(text[1]).get_single_data()


@pytest.mark.parametrize(("ref", "shown"), list(sheets()))
def test_a_worked_data_sheet_is_the_shipped_file(ref, shown):
    """Every line of the device is there, with each key but the maker's words."""
    told = {
        (sensor, line): said
        for sensor in SENSORS
        for line, said in shown.get(sensor, {}).get("errors", {}).items()
    }
    device = load_device(ref)
    keys = ("definition", "horizon", "includes", "density")
    for sensor in device.sensors:
        for line in sensor.lines:
            said = told.pop((sensor.kind, line.name))
            assert said.pop("value") == line.printed
            assert said.pop("meaning") == line.meaning
            assert said == {
                key: getattr(line, key) for key in keys if getattr(line, key)
            }
    assert told == {}


def test_there_are_three_worked_data_sheets():
    """And above every line stands a comment with what is printed."""
    assert len(list(sheets())) == 3
    for block in re.findall(r"^```yaml\n(.*?)^```", TEXT, re.MULTILINE | re.DOTALL):
        lines = block.splitlines()
        values = [place for place, line in enumerate(lines) if "{value:" in line]
        assert values
        assert all(lines[place - 1].startswith("    # ") for place in values)


LIKES = [
    *("deg/h", "deg/sqrt(h)", "ug/sqrt(Hz)", "ug", "ppm", "arcsec", "deg/h/degC"),
    "deg/h/g",
]


def in_si(text):
    """Return a value in SI by the first kind that reads it; of a density the walk."""
    for like in LIKES:
        try:
            quantity = parse_quantity(text, like)
        except UnitError:
            continue
        is_density = per_root_hertz(quantity.unit)
        walk = WALK_PER_DENSITY["two-sided"] if is_density else 1.0
        return like, quantity.value * walk
    raise AssertionError(text)


ROWS = re.findall(r"^\| `([^`]+)` \| `([^`]+)` \|", TEXT, re.MULTILINE)


@pytest.mark.parametrize(("printed", "same"), ROWS)
def test_the_table_of_units_is_right(printed, same):
    """Both values of a row are one, to the digits that the row prints."""
    (kind, value), (other, again) = in_si(printed), in_si(same)
    assert kind == other
    assert abs(value / again - 1.0) < 1e-5


def test_the_table_of_units_has_rows():
    """The pattern above finds the table."""
    assert len(ROWS) >= 10
