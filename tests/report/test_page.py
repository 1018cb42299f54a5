"""A document as a page: all of it stands there, and none of it is obeyed."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ET
from base64 import b64encode
from dataclasses import fields, is_dataclass, replace
from functools import cache, cached_property
from hashlib import sha256
from html.parser import HTMLParser
from itertools import pairwise
from shutil import copytree

import pytest
from report_examples import make_document, make_picture, make_table

from budget.errors import OutputError
from budget.language import template
from budget.report import page as page_module
from budget.report.blocks import Card, Cell, Column, Picture, RowGroup, Section, Table
from budget.report.figures.style import INK, MUTED
from budget.report.formulas import Math
from budget.report.page import (
    SCRIPTS,
    bind,
    css_string,
    longest_tail,
    natural_width,
    number_markup,
    render_page,
    script_messages,
    script_safe,
    signs_markup,
    svg_element,
)
from budget.resources import shipped

VOID = {"meta", "br", "img", "link", "input", "hr", "col"}
HOSTILE = (
    "<script>alert(1)</script>",
    "</script><script>alert(1)</script>",
    '"><img src=x onerror=alert(1)>',
    "' onmouseover='alert(1)",
    "{{7*7}}{% raw %}{# #}",
    "${alert(1)}`",
    "]]><!--",
    "</style></title></textarea>",
    "a\u2028b\u2029c",
    "&lt;script&gt;",
)
TIMES = "\N{MULTIPLICATION SIGN}"
KEPT = {
    "language",
    "kind",
    "svg",
    "narrow",
    "json",
}  # not text for readers: words of ours, drawn, encoded


class Page(HTMLParser):
    """Reads a page: its elements in order, its text, whether its tags are balanced."""

    def __init__(self, text):
        super().__init__()
        self.elements = []
        self.open = []
        self.text = ""
        self.inside = {}
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        """Note an element and that it is open."""
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        """Note an element that closes itself."""
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        """Close the element that was opened last."""
        assert self.open.pop() == tag

    def handle_data(self, data):
        """Gather text, of the page and of each kind of element."""
        here = self.open[-1] if self.open else ""
        self.inside.setdefault(here, []).append(data)
        if here not in {"script", "style"}:
            self.text += data

    def attributes(self, name):
        """Return all values of one attribute."""
        return [attrs[name] for _, attrs in self.elements if name in attrs]

    @cached_property
    def skeleton(self):
        """What a page is made of, texts apart: tags with the names of attributes."""
        return [(tag, *attrs) for tag, attrs in self.elements]

    @cached_property
    def words(self):
        """Text and spoken text with ordinary minus signs and single spaces."""
        spoken = self.attributes("aria-label")
        return words(" ".join([self.text, *spoken]))


def words(text):
    """Return a text without the spaces and signs that a page sets in its own way."""
    text = re.sub(r"\^(?=-?\d)", "", text.replace("\N{MINUS SIGN}", "-"))
    return re.sub(r"[\s\N{NARROW NO-BREAK SPACE}]", "", text)


def fill(value, text):
    """Return the same records with every text for readers replaced, no formula."""
    if isinstance(value, str):
        return text
    if isinstance(value, tuple | list):
        return type(value)(fill(item, text) for item in value)
    if isinstance(value, dict):
        return {key: fill(item, text) for key, item in value.items()}
    if is_dataclass(value) and not isinstance(value, Math):
        changes = {
            field.name: fill(getattr(value, field.name), text)
            for field in fields(value)
            if field.name not in KEPT
            and not (isinstance(value, Picture) and field.name in {"name", "tips"})
        }
        return replace(value, **changes)
    return value


def texts(value, skipped):
    """Return every text of the records, fields that no one reads apart."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, tuple):
        for item in value:
            yield from texts(item, skipped)
    elif is_dataclass(value):
        for field in fields(value):
            if field.name not in skipped:
                yield from texts(getattr(value, field.name), skipped)


@cache
def drawn():
    """Return the example; its figures are drawn once."""
    return make_document()


def example(**changes):
    """Return the example with some of its parts replaced."""
    return replace(drawn(), **changes)


@cache
def plain_page():
    """Return the page of the example, rendered and read once."""
    return Page(render_page(drawn()))


@cache
def harmless_page():
    """Return that of the example with one word in all places."""
    return Page(render_page(fill(drawn(), "plain")))


def page_of(*blocks, **changes):
    """Return the page of a document with one section."""
    section = Section(name="s", title="S", blocks=blocks)
    return Page(render_page(example(sections=(section,), **changes)))


def test_same_document_gives_the_same_bytes():
    """Nothing of the time or the process is in the page."""
    assert render_page(example()) == render_page(example())


def test_a_formula_of_its_own_is_set_at_full_size():
    """Quotients of a formula on its own line do not shrink, those in a sentence do."""
    page = render_page(example())

    assert '<math displaystyle="true"><msub><mi>K</mi><mi>x</mi></msub>' in page
    assert "<math><msub><mi>u</mi><mi>c</mi></msub></math>" in page


def test_tags_are_balanced():
    """Every element that is opened is closed, in order."""
    assert plain_page().open == []


def test_every_text_of_the_document_is_on_the_page():
    """Texts, heads, cells, notes, captions, alternatives: none is left out."""
    document = example()
    page = plain_page()

    skipped = KEPT | {"name", "empty", "model", "source", "number"}
    for text in texts(document, skipped):
        shown = re.sub(r"(?<=\d)e([+-]?)0*(?=\d)", f"{TIMES}10\\1", text)
        assert words(shown) in page.words or words(text) in page.words, text


@pytest.mark.parametrize("text", HOSTILE)
def test_foreign_text_adds_no_element(text):
    """With mark-up in every text the page has the same elements and attributes."""
    page = Page(render_page(fill(example(), text)))

    assert page.skeleton == harmless_page().skeleton
    assert words(text) in page.words


def test_the_check_of_elements_can_fail():
    """Control: mark-up that is not escaped changes the elements that are found."""
    document = fill(example(), "marker")
    page = render_page(document)

    assert Page(page.replace(">marker<", "><b></b><", 1)).skeleton != (
        Page(page).skeleton
    )


@pytest.mark.parametrize("text", HOSTILE)
def test_embedded_documents_survive_foreign_text(text):
    """The result and the model of the sliders are read back as they were."""
    result = json.dumps({"title": text})
    document = replace(fill(example(), text), json=result)
    page = Page(render_page(document))

    embedded = [json.loads(s) for s in page.inside["script"] if s.strip()[:1] == "{"]
    assert [text] == [e["title"] for e in embedded if "title" in e]
    assert [text] == [e["sources"][0]["title"] for e in embedded if "sources" in e][:1]


@pytest.mark.parametrize("text", HOSTILE)
def test_running_head_cannot_be_left(text):
    """The verdict in the style sheet is code points where it is not letters."""
    document = example(title=text, sections=())
    (style,) = Page(render_page(document)).inside["style"]

    assert css_string(document.running_head) in style
    assert text not in style


@pytest.mark.parametrize("attribute", ["src", "href", "xlink:href", "action", "data"])
def test_page_loads_nothing(attribute):
    """No address on the page leads anywhere but into the page."""
    page = plain_page()

    assert all(target.startswith("#") for target in page.attributes(attribute))


def test_style_loads_nothing():
    """The style sheet and the figures fetch neither fonts nor pictures."""
    page = render_page(example())

    assert "@import" not in page
    assert "http:" not in page
    assert "https:" not in page
    assert all(target.startswith("#") for target in re.findall(r"url\(([^)]*)", page))


def test_policy_lets_only_the_script_of_the_page_run():
    """The hash in the policy is that of the one script, nothing else may load."""
    page = plain_page()
    (policy,) = [
        attrs["content"]
        for tag, attrs in page.elements
        if tag == "meta" and attrs.get("http-equiv") == "Content-Security-Policy"
    ]
    script = page.inside["script"][-1]
    code = b64encode(sha256(script.encode()).digest()).decode()

    assert "default-src 'none'" in policy
    assert f"script-src 'sha256-{code}';" in policy
    assert not [
        name for _, *names in page.skeleton for name in names if name[:2] == "on"
    ]


def test_script_stands_in_the_page_as_it_is():
    """No template meddles with the script: what is tested is what is written."""
    script = plain_page().inside["script"][-1]

    for name in SCRIPTS:
        source = (shipped("templates") / name).read_text(encoding="utf-8")
        assert source.strip() in script
    assert "innerHTML" not in script
    assert "eval(" not in script


WORDS = re.compile(r'<script type="application/json" id="page-words">(.*?)</script>')


def test_words_of_the_script_are_data_of_the_page(monkeypatch):
    """English pages have none, others those that are translated, and escaped."""
    said = {"Sort": "</script><b>&"}
    monkeypatch.setattr(
        "budget.report.page.template", lambda text: said.get(text, template(text))
    )
    english, chinese = (
        render_page(example(language=language)) for language in ("en", "zh")
    )
    (told,) = WORDS.findall(chinese)
    script = Page(chinese).inside["script"][-1]

    assert set(json.loads(told)) == set(script_messages(script))
    assert json.loads(told)["Sort"] == said["Sort"]
    assert not set(told) & set("<>&")
    assert json.loads(WORDS.findall(english)[0]) == said
    monkeypatch.undo()
    assert WORDS.findall(render_page(example())) == []


@pytest.mark.parametrize("name", ["page.html.j2", "page.css", *SCRIPTS])
def test_missing_template_is_named(monkeypatch, tmp_path, name):
    """An installation that lost a file says which one and what to do."""
    templates = copytree(shipped("templates"), tmp_path / "templates")
    (templates / name).unlink()
    monkeypatch.setattr("budget.resources.shipped", tmp_path.joinpath)
    # As in a process of its own, which has compiled nothing yet.
    own = cache(page_module._environment_of.__wrapped__)  # noqa: SLF001
    monkeypatch.setattr(page_module, "_environment_of", own)

    with pytest.raises(OutputError, match=rf"{re.escape(name)}: this template"):
        render_page(example())


def test_links_of_the_contents_lead_to_sections():
    """Each section has one entry, whose target is there."""
    document = example()
    page = plain_page()
    ids = page.attributes("id")

    targets = [target for target in page.attributes("href") if target[1:] in ids]
    for section in document.sections:
        assert f"#{section.name}" in targets


def test_ids_are_unique():
    """No two elements share an id, those inside figures included."""
    ids = plain_page().attributes("id")

    assert len(ids) == len(set(ids))


def test_answer_stands_before_the_contents():
    """Headline, cards and the sections of page one come first."""
    page = render_page(example())

    places = [
        page.index(mark)
        for mark in (
            '<h2 class="word">FAILS tactical grade</h2>',
            "Accelerometer: MEETS",
            "The five largest contributions",
            "<nav",
            '<section id="budget"',
        )
    ]
    assert places == sorted(places)


def test_what_scrolls_can_be_reached_and_has_a_name():
    """Boxes of tables and figures are stops of the Tab key; a link skips the head."""
    text = render_page(example())
    page = Page(text)
    kinds = {"scroll", "drawing", "equations"}
    boxes = [a for _, a in page.elements if kinds & {*a.get("class", "").split()}]
    figures = sum(tag == "figure" for tag, _ in page.elements)

    assert len(boxes) > figures > 0
    for box in boxes:
        assert (box["tabindex"], box["role"]) == ("0", "group")
        assert box["aria-label"]
    assert page.attributes("href")[0] == "#main"
    assert "main" in page.attributes("id")
    assert re.search(r"<th\b[^>]*>\s*</th>", text) is None


def test_headings_leave_out_no_level():
    """Those who hear the page can follow its headings."""
    page = plain_page()
    levels = [int(tag[1]) for tag, _ in page.elements if re.fullmatch(r"h[1-6]", tag)]

    assert levels[0] == 1
    assert all(b - a <= 1 for a, b in pairwise(levels))


def test_cell_shows_its_exact_value_and_its_share():
    """The tooltip has the full number, the bar the part of the cell."""
    page = page_of(make_table())
    cells = [attrs for tag, attrs in page.elements if tag == "td"]

    (bar,) = [a for a in cells if a.get("style") == "--part: 79.0%"]
    assert bar["title"] == "0.79"
    assert bar["data-exact"] == "0.79"


def test_decimal_points_of_a_group_are_in_line():
    """Shorter tails are filled up to the longest of their group, not of the table."""
    table = Table(
        name="t",
        caption="c",
        columns=(Column(head="row"), Column(head="n", kind="number")),
        groups=tuple(
            RowGroup(rows=tuple((Cell(text="r"), Cell(text=t)) for t in texts))
            for texts in (("1.25", "3.5"), ("7", "8"))
        ),
    )
    page = page_of(table, cards=())

    assert page.inside["td"] == ["1.25", "3.5\N{FIGURE SPACE}", "7", "8"]


def test_row_heads_and_group_titles_are_heads():
    """The first cell of a row heads it; a title heads its group across the table."""
    page = page_of(make_table())
    scopes = [attrs.get("scope") for tag, attrs in page.elements if tag == "th"]

    assert scopes.count("row") == 5
    assert scopes.count("rowgroup") == 2
    assert scopes.count("col") == 6


def test_table_has_bodies_by_group():
    """Rows that belong together stand in one body."""
    page = page_of(make_table())

    assert [tag for tag, _ in page.elements].count("tbody") == 2


def test_figure_is_spoken_and_has_its_data():
    """A figure says in words what it shows, and its numbers stand behind it."""
    picture = make_picture(data=make_table("numbers"))
    page = page_of(picture)

    assert picture.alt in page.attributes("aria-label")
    assert "numbers" in page.attributes("id")
    assert "details" in {tag for tag, _ in page.elements}


def test_page_without_long_tables_has_no_search():
    """A search field stands only where there is something to search."""
    short = page_of(make_table())
    long = page_of(make_table(searchable=True))

    assert "search" not in short.attributes("type")
    assert "search" in long.attributes("type")


def test_page_of_an_answer_alone_has_no_contents():
    """Without further sections there is nothing to list."""
    page = Page(render_page(example(sections=(), cards=())))

    assert "nav" not in {tag for tag, _ in page.elements}


def test_empty_list_says_what_that_means():
    """A list without points is a sentence."""
    page = plain_page()

    assert page.inside["p"].count("None.") == 1


def test_cards_stand_in_their_order():
    """As many cards as the answer has parts."""
    cards = tuple(Card(title=f"part {k}", lines=()) for k in range(3))
    page = page_of(cards=cards)

    assert [t for t in page.inside["h3"] if t.startswith("part")] == [
        "part 0",
        "part 1",
        "part 2",
    ]


# ---- text for a page -----------------------------------------------------------------

FIGURE, POINT = "\N{FIGURE SPACE}", "\N{PUNCTUATION SPACE}"


@pytest.mark.parametrize(
    ("text", "markup"),
    [
        ("-0.11", "\N{MINUS SIGN}0.11"),
        ("2.4e-9", "2.4&#8239;&times;&#8239;10<sup>\N{MINUS SIGN}9</sup>"),
        ("1e+05", "1&#8239;&times;&#8239;10<sup>5</sup>"),
        ("<0.1", "&lt;0.1"),
        ("none", "none"),
        ("none <b>", "none &lt;b&gt;"),
    ],
)
def test_numbers_are_set_for_reading(text, markup):
    """Minus signs are true ones, exponents are raised, the rest is escaped."""
    assert number_markup(text) == markup


@pytest.mark.parametrize(
    ("text", "markup"),
    [
        ("-0.1 to -0.2", "\N{MINUS SIGN}0.1 to \N{MINUS SIGN}0.2"),
        ("HG-4930", "HG-4930"),
        ("2019-11-21", "2019-11-21"),
        ("0.41 deg/h", "0.41 deg/h"),
    ],
)
def test_a_hyphen_is_no_minus(text, markup):
    """Only what stands before a number becomes its sign."""
    assert signs_markup(text) == markup


@pytest.mark.parametrize(
    ("text", "tail", "markup"),
    [
        ("50", 3, f"50{POINT}{FIGURE}{FIGURE}"),
        ("0.69", 4, f"0.69{FIGURE}"),
        ("0.077", 4, "0.077"),
        ("97 %", 2, f"97{POINT}{FIGURE} %"),
        ("none", 4, "none"),
        ("10-20", 4, "10-20"),
    ],
)
def test_points_of_a_column_are_in_line(text, tail, markup):
    """Shorter tails are filled up with spaces as wide as digits and point."""
    assert number_markup(text, tail=tail) == markup


def test_longest_tail_is_that_of_plain_numbers():
    """Powers of ten, words and intervals do not widen a column."""
    assert longest_tail(["1.25", "3", "2.4567e-9", "e.g. 1.2345", "97.5 %"]) == 3
    assert longest_tail([]) == 0


def test_css_string_cannot_be_left():
    """Quotes, brackets and line ends become code points."""
    assert css_string('a"}\n') == r'"a\000022\00007d\00000a"'


def test_number_stays_with_its_unit():
    """The space between a number and its unit does not break."""
    assert bind("after 300 s at 5 deg/h or so") == (
        "after 300\N{NO-BREAK SPACE}s at 5\N{NO-BREAK SPACE}deg/h or so"
    )


def test_script_safe_json_is_the_same_json():
    """What could end a script element is written in another way, and read the same."""
    document = {"title": "</script><!-- & \u2028"}
    safe = script_safe(json.dumps(document))

    assert not set("<>&") & set(safe)
    assert json.loads(safe) == document


# ---- figures inside a page -----------------------------------------------------------

SVG = (
    '<?xml version="1.0"?>\n<svg xmlns="http://www.w3.org/2000/svg" width="330pt" '
    'height="9pt" viewBox="0 0 330 9" version="1.1"><title>t</title>'
    "<metadata>m</metadata><defs><style>*{stroke-linejoin: round}</style></defs>"
    f'<g id="f-bar"><path style="fill: {INK}; stroke: #0072b2"/></g>'
    f'<use id="f-dot" x="1"/><text style="fill: {MUTED}">{INK}</text>'
    "</svg>"
)


def element(**options):
    """Return the figure as an element, and parsed."""
    text = svg_element(SVG, name="f", **({"alt": "words"} | options))
    return text, ET.fromstring(text)  # noqa: S314 - our own


def test_figure_takes_the_inks_of_the_page():
    """Ink and muted ink turn with light and dark; colours and texts stay."""
    text, svg = element()

    assert svg.find("g/path").get("style") == "fill: currentColor; stroke: #0072b2"
    assert svg.find("text").get("style") == "fill: var(--muted)"
    assert svg.find("text").text == INK
    assert not text.startswith("<?xml")


def test_figure_brings_no_styles_or_titles_of_its_own():
    """What would hold for all the page, or show as a tooltip of it all, is left out."""
    text, svg = element()

    assert not svg.findall(".//style")
    assert not svg.findall(".//title")
    assert not svg.findall(".//metadata")
    assert not {"http:", " id="} & set(re.findall("http:| id=", text))


def test_figure_is_spoken():
    """Those who cannot see it get the words, whatever stands in them."""
    _, svg = element(alt='"quoted" <b> & more')

    assert svg.get("role") == "img"
    assert svg.get("aria-label") == '"quoted" <b> & more'


def test_tips_belong_to_their_elements():
    """A tooltip is the first thing inside its element, empty ones included."""
    _, svg = element(tips={"bar": "a < b", "dot": "c"})

    assert svg.find("g")[0].tag == "title"
    assert svg.find("g")[0].text == "a < b"
    assert svg.find("use/title").text == "c"


def test_tip_without_an_element_is_refused():
    """A tooltip that would get lost is an error of the figure."""
    with pytest.raises(ValueError, match="'f-line' belongs to no element"):
        element(tips={"line": "lost"})


def test_natural_width_is_that_of_the_drawing():
    """The page scales a figure by the width that it was drawn for."""
    assert natural_width(SVG) == 330.0
    with pytest.raises(ValueError, match="no viewBox"):
        natural_width("<svg></svg>")
