"""Sentences that records keep: English wherever they go, sayable in any language."""

from __future__ import annotations

import ast
import pickle
from functools import cache

import pytest
from jinja2 import meta, nodes
from places import SHIPPED, nodes_of

from budget.calibration.saturation import Peak
from budget.errors import OutputError
from budget.language import note, say, speaking
from budget.model.sources import SOURCES
from budget.names import Name
from budget.resources import shipped, templates_of
from budget.sentences import PAGE, Sentence, environment_of, sentence

OWN = """{% macro few(trials, of) %}
{% trans trials=trials %}{{ trials }} scale factors{% endtrans %}
{% endmacro %}
"""


FEW = {"trials": 100, "outside": 5.0, "coverage": 0.95, "wanted": 2000}


@pytest.fixture
def own(tmp_path):
    """Return a folder with a page of sentences."""
    (tmp_path / "pages").mkdir()
    (tmp_path / "pages" / "own.md.j2").write_text(OWN, encoding="utf-8")
    return tmp_path


def test_a_sentence_of_a_page_that_does_not_ship_is_refused(own):
    """The English of a record is of what ships, whatever folder goes before."""
    with templates_of(own), pytest.raises(OutputError, match="missing"):
        sentence("own.few", trials=3, of="scale_factor")


def test_a_page_of_ones_own_has_some_macros_and_the_others_ship(own):
    """It is said by them, in the language; what is kept is what ships says."""
    (own / "pages" / "cautions.md.j2").write_text(
        "{% macro nothing_varies() %}still: {{ 'gyro'|said }}{% endmacro %}",
        encoding="utf-8",
    )
    still, few = sentence("cautions.nothing_varies"), "cautions.few_trials"
    with templates_of(own):
        assert say(still) == "still: gyro"
        assert say(sentence(few, **FEW)) == sentence(few, **FEW)
        with speaking("zh"):
            assert say(sentence(few, **FEW)).startswith("100 次试验")
    assert say(still) == still
    assert still.startswith("no source varies")


def test_a_value_is_no_markup():
    """What stands in a value comes out as it went in."""
    text = sentence("cautions.few_trials", **FEW | {"trials": "<3> & **4**"})

    assert text.startswith("of <3> & **4** trials")


def test_a_sentence_is_english_and_can_be_said():
    """It survives another process, and is said where it is a part of another."""
    text = sentence("cautions.few_trials", **FEW)
    again = pickle.loads(pickle.dumps(text))  # noqa: S301 - our own

    assert isinstance(again, Sentence)
    assert text == again
    assert "of 100 trials only 5 are outside" in text
    with speaking("zh"):
        assert say(again) != text
        assert "2000" in say(again)
        assert say("{axis}: ", axis=again) == say("{axis}: ", axis=say(again))
        assert (
            sentence(
                "cautions.few_trials",
                trials=100,
                outside=5.0,
                coverage=0.95,
                wanted=2000,
            )
            == text
        )
    assert note("{x}!", x=again) == f"{text}!"


@cache
def macros_of(page):
    """Return the macros of a page with their arguments, and what it is not given."""
    source = shipped("templates", PAGE.format(page)).read_text(encoding="utf-8")
    tree = environment_of(None).parse(source)
    found = {
        one.name: {argument.name for argument in one.args}
        for one in tree.find_all(nodes.Macro)
    }
    return found, meta.find_undeclared_variables(tree) - {"_trans"}  # of Jinja2


def made_in(tree):
    """Return the places of sentences that code makes, with the names of their values.

    None is among these where some are handed on.

    A place that is no literal is one that a source has.
    """
    return [
        (call.args[0].value, {keyword.arg for keyword in call.keywords})
        for call in tree
        if isinstance(call, ast.Call) and getattr(call.func, "id", "") == "sentence"
        if isinstance(call.args[0], ast.Constant)
    ]


def of_sources():
    """Return the places of sentences on what sources need, are, and are removed by."""
    return {
        place
        for source in SOURCES
        for one in (source.effect, *source.forms.values())
        for place in (one.needs, one.removed, one.removed_by_norm, one.letters)
    } - {""}


MADE = [one for path in SHIPPED for one in made_in(nodes_of(path))]
PAGES = sorted({place.partition(".")[0] for place, _ in MADE})
# Rows of data name their sentences, too.
NAMED = {
    node.value
    for path in SHIPPED
    for node in nodes_of(path)
    if isinstance(node, ast.Constant) and isinstance(node.value, str)
}


def wrong_in(made):
    """Return the sentences that have no macro, or other values than theirs."""
    pages = [(place, *place.split("."), values) for place, values in made]
    return [
        place
        for place, page, name, values in pages
        for known in [macros_of(page)[0].get(name)]
        if known is None or (None not in values and known != values)
    ]


def test_every_sentence_has_a_macro_and_all_its_values():
    """Those that nothing here makes as well."""
    assert len(MADE) > 100
    assert wrong_in(MADE) == []
    assert wrong_in((place, set()) for place in of_sources()) == []


def test_the_search_for_wrong_sentences_can_fail():
    """Control: a macro that is not there, a value too few and one too many are seen."""
    code = (
        "sentence('cautions.none')\nsentence('conditions.decides')\n"
        "sentence('conditions.decides', line=x, bound=y)\n"
        "sentence('conditions.decides', line=x)\nsentence(place)\n"
    )
    wrong = ["cautions.none", "conditions.decides", "conditions.decides"]

    assert wrong_in(made_in(ast.walk(ast.parse(code)))) == wrong


@pytest.mark.parametrize("page", [*PAGES, "sources"])
def test_macros_are_said_and_ask_for_nothing_else(page):
    """No macro of a page is left over, none has a value that it is not given."""
    macros, strange = macros_of(page)
    made = NAMED | of_sources()
    text = shipped("templates", PAGE.format(page)).read_text(encoding="utf-8")
    left = [
        name
        for name in macros
        if f"{page}.{name}" not in made
        and not (name.startswith("_") and f"({name})" in text)
    ]

    assert strange == set()
    assert left == []


BIAS = Name("bias", owner="gyro")
OUTPUTS = [Name("bias", owner="gyro", axis=axis) for axis in "xy"]
PEAK = Peak(sensor="gyro", axis="y", size=7.0, where="segment 2")
# Of branches that no command of the tests takes: values, and what stays of them.
SELDOM = [
    ("allocations.not_optimal", {"sensor": "gyro", "gap": 0.00234, "residual": 0}, "0"),
    ("allocations.not_there", {"sensor": "gyro", "is_calibrated": False}, ""),
    *(
        ("allocations.unknown", {"name": BIAS, "what": what}, "")
        for what in ("held", "bounded", "given a cost")
    ),
    ("assumed.while_aligning", {}, ""),
    ("cautions.age_counts_not", {"age": "1 year", "reference": "nominal"}, "1 year"),
    ("cautions.asked_alone", {"name": BIAS}, "0"),
    ("cautions.in_radians", {}, "pi/2 deg"),
    ("cautions.judged_otherwise", {"interval": "a", "outputs": None}, "a"),
    ("cautions.judged_otherwise", {"interval": "a", "outputs": OUTPUTS}, " y"),
    ("cautions.limits_on_a_mission", {}, "budget mission --requirement"),
    ("cautions.no_vehicle", {"slip": "speed", "size": 2e3, "most": 1e3, "time": 1}, ""),
    ("cautions.no_weights", {"sensor": "gyro"}, ""),
    ("cautions.not_confirmed", {"outputs": OUTPUTS}, "JCGM 101"),
    ("cautions.not_validated", {"coverage": 0.9999, "least": 123456}, "123456"),
    ("cautions.slow", {"length": 12.3456, "speed": 0.01234}, "0.012 m/s"),
    ("cautions.unsettled", {"trials": 1234000, "outputs": OUTPUTS}, "1 234 000"),
    ("cautions.without_effect", {"option": "interval"}, "U"),
    ("conditions.aided", {"times": [60.0, 5400.0]}, "1.5 h"),
    ("conditions.chosen", {}, ""),
    ("conditions.over_temperature", {}, ""),
    ("conditions.stands", {"line": BIAS}, ""),
    ("conditions.within", {"use": "age", "bound": None, "tops": []}, ""),
    ("filled.basis", {"owner": "", "devices": 1, "designs": 1, "ends": "12"}, "90 %"),
    (
        "saturation.beyond",
        {"device": "D", "peak": PEAK, "range": "1 g", "axes": ("y", "z")},
        "401.1 deg/s",
    ),
    (
        "saturation.segment",
        {"number": 2, "move": "climb", "angle": 0, "duration": 90},
        "90 s",
    ),
    ("stations.counts_nothing", {"what": "", "is_felt": True}, ""),
    *((place, {}, "") for place in sorted(of_sources())),
]


@pytest.mark.parametrize(("place", "parts", "kept"), SELDOM)
def test_what_is_said_seldom_is_said_in_both_languages(place, parts, kept):
    """Every branch has its values; names and numbers are those of both."""
    text = sentence(place, **parts)
    with speaking("zh"):
        chinese = say(text)

    assert text != chinese
    assert {*"{}%"} & {*text + chinese} <= {*kept}
    for said in (text, chinese):
        assert kept in said
        assert said == said.strip()
