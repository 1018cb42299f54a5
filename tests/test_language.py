"""The catalogues of words: complete, agreeing with the code, and exact."""

from __future__ import annotations

import ast
import pickle
import re
import string
from dataclasses import replace

import pytest
from command_line import call
from extraction import (
    CATALOGUES,
    catalogue_of,
    every_message,
    messages_of,
    shipped_template,
    vocabulary,
)
from places import PACKAGE
from reading import find, on_terminal
from report_examples import make_assessment, make_budget

from budget.errors import CallError
from budget.language import (
    LANGUAGES,
    Note,
    counted,
    key_title,
    note,
    say,
    speaking,
    spoken,
    words,
)
from budget.names import Name
from budget.report.analysis.groups import budget_answer
from budget.report.blocks import Table
from budget.report.notebook import budget_latex, budget_markdown, shown_html
from budget.report.page import SCRIPTS, script_messages

# What stays as it is: units, names, keys of files, options and abbreviations.
KEPT = re.compile(
    r"[\w-]+\.yaml|GUM|deg|arcsec|ppm|sqrt|sigma|inf|[a-z]+\.[a-z_.]+|--[a-z-]+"
)


def parts_of(template):
    """Return the names of the parts of a template, with how they are formatted."""
    return {
        (name, conversion, spec)
        for _, name, spec, conversion in string.Formatter().parse(template)
        if name is not None
    }


@pytest.mark.slow
@pytest.mark.parametrize("language", CATALOGUES)
def test_no_message_is_without_a_translation(language):
    """Every template of the code and every word of the files is in the catalogue."""
    known = catalogue_of(language)

    assert sorted((every_message() | vocabulary()) - set(known)) == []


@pytest.mark.parametrize("language", CATALOGUES)
def test_translations_have_the_parts_of_their_templates(language):
    """No number is lost, none is formatted otherwise."""
    messages = every_message()
    wrong = [
        message
        for message, said in catalogue_of(language).items()
        if message in messages
        and "{" in message
        and parts_of(message) != parts_of(said)
    ]

    assert wrong == []


@pytest.mark.parametrize("language", CATALOGUES)
def test_no_translation_is_left_over(language):
    """A translation with parts belongs to a template that there is."""
    left = {m for m in catalogue_of(language) if "{" in m or len(m.split()) > 6}

    assert sorted(left - every_message()) == []


def test_the_count_can_fail():
    """A template in any of the calls is found, a sentence elsewhere is not."""
    tree = ast.parse(
        "from budget.language import counted, say, term\n"
        "HEAD = term('a head')\n"
        "say('one {x}' if x else 'other {x}', x=1)\n"
        "counted(n, '{n} turn', '{n} turns', n=n)\n"
        "print('an error')\n"
    )

    assert messages_of(tree) == {
        "a head",
        "one {x}",
        "other {x}",
        "{n} turn",
        "{n} turns",
    }


def test_the_count_of_a_script_can_fail():
    """Words that are said and marked are found, in one line or two; others are not."""
    script = 'word("{n} of", { n }); x = term("MEETS"); password("a");\nword(\n  "b")'

    assert script_messages(script) == ("{n} of", "MEETS", "b")


CALL = re.compile(r"\b(?:word|term)\((?!text\b)")  # not where the two are defined


@pytest.mark.parametrize("name", SCRIPTS)
def test_scripts_say_literals_with_all_their_parts(name):
    """The count misses no word: but for verdicts, which are marked, all stand there.

    What a template has in braces is handed over by that name.
    """
    script = shipped_template(name)
    calls = [script[found.end() :] for found in CALL.finditer(script)]
    said = [re.match(r'\s*"([^"\\]*)"(?:,\s*\{([^{}]*)\})?', call) for call in calls]
    others = [call[:12] for call, text in zip(calls, said, strict=True) if text is None]
    lost = [
        text[1]
        for text in filter(None, said)
        for part, _, _ in parts_of(text[1])
        if not re.search(rf"\b{part}\b", text[2] or "")
    ]

    assert len(calls) >= 2
    assert set(others) <= {"was.verdict)", "now.verdict)"}
    assert lost == []


def test_english_is_what_the_template_says():
    """Without a language templates are filled in as they stand."""
    assert spoken() == "en"
    assert say("{a} of {b:.2f} {{x}}", a="1", b=2.0) == "1 of 2.00 {x}"
    assert counted(1, "{n} turn", "{n} turns", n=1) == "1 turn"


def test_chinese_is_spoken_within_the_block_alone():
    """Words follow the context, and what has no translation stays English."""
    with speaking("zh"):
        assert say("scale factors") == "标度因数"
        assert say("no such words {n}", n=3) == "no such words 3"
    assert say("scale factors") == "scale factors"


def test_keys_are_words_of_the_language():
    """A dotted key is its owner and its quantity, an axis keeps its letter."""
    with speaking("zh"):
        assert words("bias_stability") == "零偏稳定性"
        assert key_title(Name("bias_stability", owner="gyro")) == "陀螺零偏稳定性"
        assert key_title(Name("bias", owner="gyro", axis="x")) == "陀螺零偏 x"
        assert key_title("gyro.nominal.bias") == "陀螺标称零偏"
        assert key_title(Name("levelling.east", owner="station")) == "测试设备东向调平"
        for key in ("segments", "alignment", "altitude", "heading"):
            assert not re.search("[a-z]", key_title(f"mission.{key}"))
    assert key_title(Name("bias_stability", owner="gyro")) == "gyro bias stability"


def test_a_note_is_english_and_can_be_said():
    """A text of a record is its English wherever it goes, and is said in a report."""
    text = note("{low} to {high}", low=1, high=note("scale factors"))
    again = pickle.loads(pickle.dumps(text))  # noqa: S301 - our own

    assert text == again == "1 to scale factors"
    assert isinstance(again, Note)
    with speaking("zh"):
        assert say(again) == "1 至 标度因数"
        assert say("{said}.", said=text) == "1 至 标度因数。"


def test_an_unknown_language_is_refused():
    """It is said which there are."""
    with pytest.raises(CallError, match="'de', allowed: en, zh"), speaking("de"):
        pass


def answers():
    """Return what a terminal shows of a budget against limits, in two languages."""
    budget = make_budget(title="A 1", assumptions=(), warnings=())
    budget = replace(
        budget, assessment=replace(make_assessment(budget), requirement="B 2")
    )
    for language in ("en", "zh"):
        with speaking(language):
            yield budget_answer(budget)


def test_no_english_is_left_in_a_chinese_answer():
    """Nothing but units, names and keys is in Latin letters; English has far more."""
    english, chinese = (
        re.findall(r"[A-Za-z]{3,}", KEPT.sub("", on_terminal(one))) for one in answers()
    )

    assert sorted(set(chinese)) == []
    assert len(set(english)) > len(CATALOGUES)


TACTICAL = "specs/requirements/tactical-grade.yaml"
NAVIGATION = "specs/requirements/navigation-grade.yaml"
ANSWERS = {
    "analysis": ["analyze", "--no-validate", "--matrices", "--full"],
    "against a requirement": ["analyze", "--no-validate", "--requirement", NAVIGATION],
    "lower bounds": [
        *("analyze", "specs/devices/icm-20948.yaml", "--no-validate", "--full"),
        *("--requirement", TACTICAL),
    ],
    "in brief": [
        *("analyze", "specs/devices/icm-20948.yaml", "--no-validate"),
        *("--requirement", TACTICAL),
    ],
    "Monte Carlo": ["analyze", "--method", "monte-carlo", "--trials", "2000"],
    "predicted lines": [
        *("analyze", "specs/devices/m-a370ad10.yaml", "--no-validate"),
        *("--missing", "predict", "--requirement", TACTICAL),
    ],
    "worst lines": [
        *("analyze", "specs/devices/m-a370ad10.yaml", "--no-validate"),
        *("--missing", "worst"),
    ],
    "comparison": [
        *("compare", "specs/devices/mti-630.yaml", "specs/devices/hg9900.yaml"),
        *("--requirement", TACTICAL, "--trials", "2000"),
    ],
    "allocation": ["allocate", "--requirement", NAVIGATION],
    "allocation in full": ["allocate", "--requirement", NAVIGATION, "--full"],
    "mission": ["mission", "--mission", "bench", "--no-validate"],
    "mission in full": ["mission", "--mission", "bench", "--no-validate", "--full"],
    "station": ["station", "--requirement", NAVIGATION],
    "station in full": ["station", "--requirement", NAVIGATION, "--full"],
    "paper": ["paper"],
    "difference": ["diff", "zhao-2019-eq4-nominal", "zhao-2019-corrected-nominal"],
}
# Names that files give: of devices, their makers' types, requirements and stations.
NAMES = (
    *("zhao-2019-eq4-nominal", "zhao-2019-corrected-nominal"),
    *(
        "Zhao 2019, eq. 4 as printed",
        "Zhao 2019 optical IMU",
        "Zhao 2019",
        "navigation grade",
        "tactical grade",
    ),
    *("Navigation grade", "Tactical grade", "granite plate and cube"),
    *("good three-axis table", "ideal", "bench, 1 h"),
)
STAYING = re.compile(
    r"[\w.-]+\.yaml(?:#\w+)?|"
    + "|".join(map(re.escape, NAMES))
    # Options, keys and their values, designations of types: they hold a mark
    # or a digit.
    + r"|--[a-z-]+|\bbudget (?:analyze|station)\b|\b[a-z]+(?:[._]+[a-z]+)+\b|`[\w: ]+`"
    r"|\N{FULLWIDTH LEFT PARENTHESIS}[a-z_]+: [a-z]+|'\w+'"
    r"|\b(?=\w*-?\w*\d)[A-Z][\w-]*|\bMTi\b|\bDG\b"
    # Versions that a reference was stored with, where they are others here.
    r"|\b[a-z]+ [\d.]+ -> [\d.]+"
    # A key of a file that changed, and its values.
    r"|[a-z_.]+\N{FULLWIDTH COLON}\S+ -> \S+|\bname(?=\N{FULLWIDTH COLON})"
    # Units and signs of formulas.
    r"|\bmean\(N\)|\bint(?= d_)"
    r"|\b(?:deg|degC|arcsec|arcmin|nmi|CEP|DRMS|ppm|dps|mGal|ug|mg|sqrt|\u03bcrad|min|inf|inv|EUR|kg|rad|sigma)\b"
    # What is called so in Chinese as well, and words that stand as a file has them:
    # how a data sheet means a figure, how missing lines are filled, two keys.
    r"|\b(?:JCGM|ANSI|NCSL|IEEE|GUM|IMU|JSON|CSV|TUR|max|typical|predict|worst|factory|height|station)\b"
)


def left_in(text):
    """Return the words in Latin letters that no rule lets stay."""
    line = " ".join(text.split())  # a name may be broken between two
    return sorted(set(re.findall(r"[A-Za-z]{3,}", STAYING.sub(" ", line))))


@pytest.mark.slow
@pytest.mark.parametrize("kind", ANSWERS)
def test_no_english_is_left_on_a_chinese_terminal(kind):
    """Whatever a command answers: what stays is a name, a unit, a key or a sign."""
    # So wide that no cell is broken.
    shown = call(*ANSWERS[kind], "--language", "zh", COLUMNS="300").out

    assert shown.count("\n") > 10
    assert left_in(shown) == []


def test_a_check_that_holds_is_chinese():
    """It is a line for each reference, and their number."""
    shown = call("check", NAMES[0], "--language", "zh", COLUMNS="300").out

    assert "1 个参考结果" in shown
    assert left_in(shown) == []


def test_the_rules_let_no_sentence_stay():
    """The same answer in English is full of words: the rules take no prose away."""
    shown = call(*ANSWERS["against a requirement"]).out

    assert len(left_in(shown)) > 60


def test_tables_of_a_notebook_follow_the_language():
    """Heads and warnings too, in HTML, Markdown and LaTeX alike."""
    budget = make_budget(title="A 1", warnings=("B 2",))
    write = (shown_html, budget_markdown, budget_latex)
    heads = ({"output", "unit"}, {"parameter", "axis"}, {"parameter", "axis"})
    with speaking("zh"):
        shown = [one(budget) for one in write]

    assert "警告\N{FULLWIDTH COLON}B 2" in shown[0]
    english = [one(budget) for one in write]
    for before, after, own in zip(english, shown, heads, strict=True):
        assert "主要贡献" in after
        assert not {*own, "mean", "unit", "Warning"} & set(re.findall(r"\w+", after))
        assert own < set(re.findall(r"\w+", before))


def test_a_chinese_answer_has_the_same_numbers():
    """Every cell of every table is as long, and has the same exact value."""
    english, chinese = (
        [
            [cell.exact for group in table.groups for row in group.rows for cell in row]
            for section in one
            for table in find(section, Table)
        ]
        for one in answers()
    )

    assert chinese == english


def test_json_is_english_in_any_language():
    """A document for programs has no language, what a person reads has."""
    given = ["analyze", "--no-validate"]
    shown = call(*given, "--language", "zh").out
    documents = [
        call(*given, "--json", "-", "--language", language).out
        for language in LANGUAGES
    ]

    assert "重复性误差全部计入" in shown
    assert len(set(documents)) == 1


def test_the_chinese_readme_has_the_numbers_of_the_english_one():
    """Its table of the paper's device says the same."""
    tables = [
        re.findall(r"(?m)^\| .*(?:ppm|arcsec|deg/h|ug) .*%.*$", path.read_text("utf-8"))
        for path in (PACKAGE.parent / "README.md", PACKAGE.parent / "README.zh.md")
    ]
    english, chinese = (
        [re.findall(r"[<>]?\d[\d.]*", row) for row in one] for one in tables
    )

    assert len(chinese) == 6
    assert chinese == english
