"""Pages from templates: what of Markdown is read, and that no value is any of it."""

from __future__ import annotations

import pytest
from jinja2 import TemplateError
from markupsafe import Markup

from budget.errors import OutputError
from budget.language import speaking
from budget.report import pages
from budget.report.blocks import (
    Abreast,
    Card,
    Cell,
    Equation,
    Equations,
    Listing,
    Pairs,
    Panel,
    Paragraph,
    Run,
    Section,
    Table,
)
from budget.report.formulas import Math
from budget.report.writing import marked

# What Markdown, HTML and Jinja2 would read.
HOSTILE = (
    "**bold** _x_ `code` | cell | # head\n## two {:name wide}\n- point\n1. one",
    "<b>x</b> &amp; [a](b) ![c](d) \\* {{ found }} {% raw %} {# x #}",
    "| = group |\n|---|\n> small\nTable: x",
    "= a  group",
    "Table: x {:t}",
    # Marks of pages, and ends of lines.
    "a\ue0020\ue005 \ue000zz\ue001x\ue005 \ue0009\ue0012\ue005\r\r## x\u2028y\tz",
)


@pytest.fixture
def page(tmp_path, monkeypatch):
    """Return what makes sections of a template that is given."""

    def make(text, **view):
        folder = tmp_path / "templates" / "pages"
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "own.md.j2").write_text(text, encoding="utf-8")
        return pages.sections("own", **view)

    monkeypatch.setattr("budget.resources.shipped", tmp_path.joinpath)
    pages._environment_of.cache_clear()  # noqa: SLF001 - it has read the shipped folder
    yield make
    pages._environment_of.cache_clear()  # noqa: SLF001


def test_a_page_becomes_the_blocks_that_its_marks_ask_for(page):
    """Sections, panels, paragraphs, listings, and a number with its exact value."""
    (one, two) = page(
        "## One {:one first}\n\nPlain **bold** {{ 2.34567|number(2) }} deg.\n\n"
        "> small\n\n### Part\n\n- a\n- **b**\n\n1. c\n\n## Two {:two page}\n\nEnd.\n"
    )
    assert (one.name, one.title, one.on_first_page, one.in_brief) == (
        *("one", "One", True, None),
    )
    words, small, panel = one.blocks
    number = Run(text="2.3", exact=2.34567)
    run = Run(text="bold", strong=True)
    assert words == Paragraph(words=("Plain ", run, " ", number, " deg."))
    assert small == Paragraph(words=("small",), small=True)
    assert isinstance(panel, Panel)
    bold = (Run(text="b", strong=True),)
    assert panel.blocks == (
        Listing(items=(("a",), bold), empty=""),
        Listing(items=(("c",),), empty="", numbered=True),
    )
    assert (two.in_brief, two.blocks) == ("", (Paragraph(words=("End.",)),))


def test_displayed_formulas_stand_side_by_side_with_their_numbers(page):
    """Each on a line, what stands behind it is its number; those inside words do not.

    A value is a part of a formula, and so are letters that Markdown reads.
    """
    (section,) = page(
        "## T {:t}\n\nOf $n_x$:\n\n$$ K_x = {{ x }}/(4 pi m) $$ eq. (3)\n"
        "{% for one in z %}\n$$ delta_(x {{ one }}) $$\n{% endfor %}\n"
        "$$ e^(-L\\/tau) $$ {% trans tau=tau %}time {{ tau }}{% endtrans %}\n\nEnd.\n",
        x="n_(x 2)",
        z="yz",
        tau="*t*",
    )
    _, formulas, end = section.blocks
    sources = {
        "K_x = n_(x 2)/(4 pi m)": "eq. (3)",
        "delta_(x y)": "",
        "delta_(x z)": "",
        "e^(-L\\/tau)": "time *t*",
    }
    assert formulas == Equations(
        equations=tuple(
            Equation(math=Math(source=source), number=number)
            for source, number in sources.items()
        )
    )
    assert end == Paragraph(words=("End.",))


def test_a_table_has_columns_by_alignment_and_rows_in_groups(page):
    """Kinds, weights, what goes where nothing stands in it; bars, remarks, titles."""
    (section,) = page(
        "## T {:t}\n\nTable: What it shows {:sizes wide}\n\n"
        "| line{1.4} | size{below} | unit{more} | gone? | hash{code 3.0 more} |\n"
        "|---|--:|:-:|---|---|\n"
        '| a{{ "why"|beneath }} | {{ "1.2"|exact(1.23)|strong }} | deg | | ff |\n'
        '| = more |\n| b | {{ "9"|bar(0.5) }} | g | | 00 |\n'
    )
    (table,) = section.blocks
    assert (table.name, table.caption, table.is_wide) == (
        "sizes",
        "What it shows",
        True,
    )
    assert [(one.head, one.kind, one.weight) for one in table.columns] == [
        *(("line", "text", 1.4), ("size", "number", 1.0)),
        *(("unit", "unit", 1.0), ("hash", "code", 3.0)),
    ]
    assert [one.when_narrow for one in table.columns] == ["", "below", "more", "more"]
    assert [group.title for group in table.groups] == ["", "more"]
    (first,), (second,) = (group.rows for group in table.groups)
    assert first[:2] == (
        Cell(text="a", note="why"),
        Cell(text="1.2", exact=1.23, strong=True),
    )
    assert second[1] == Cell(text="9", share=0.5)


def test_a_table_without_heads_and_caption_is_of_terms(page):
    """With a caption it is a table, and a caption is of one table."""
    empty = "| | |\n|---|---|\n| a | **b** c |\n| d | {{ x|number(2) }} |\n\n"
    (section,) = page(
        f"## T {{:t}}\n\n{empty}Table: it {{:t}}\n\n{empty}{empty}", x=1.5
    )
    terms, table, again = section.blocks
    bold, number = Run(text="b", strong=True), Run(text="1.5", exact=1.5)
    assert terms == again == Pairs(rows=(("a", (bold, " c")), ("d", (number,))))
    assert isinstance(table, Table)
    assert table.caption == "it"


def test_a_macro_writes_each_of_several_things(page):
    """Without the blanks around it, in the marks of the language."""
    text = (
        "{% macro one(x) %}\n{{ x }} deg\n\n{% endmacro %}\n## T {:t}\n\n"
        "{{ x|each(one)|commas }}, {{ x|commas('; ') }}\n"
    )
    (section,) = page(text, x=["*", "2"])
    words = ("* deg, 2 deg, *; 2",)
    assert section.blocks == (Paragraph(words=words),)


@pytest.mark.parametrize("text", HOSTILE)
def test_no_value_is_markdown(page, text):
    """Whatever a value is, it stands as it is: in words, titles, cells, sentences."""
    (section,) = page(
        "## {{ x }} {:t}\n\n{{ x }}\n\n- {% trans x=x %}said {{ x }}{% endtrans %}\n\n"
        "Table: {{ x }} {:t}\n\n| {{ x }} |\n|---|\n| {{ x }}{{ x|beneath }} |\n",
        x=text,
    )
    words, listing, table = section.blocks
    assert section.title == text
    assert words == Paragraph(words=(text,))
    assert listing == Listing(items=((f"said {text}",),), empty="")
    assert table.caption == table.columns[0].head == text
    assert table.groups[0].rows == ((Cell(text=text, note=text),),)


def test_a_block_that_is_made_elsewhere_stands_where_it_is_named(page):
    """A figure goes through a page as it is."""
    figure = Panel(title="a figure", blocks=())
    (section,) = page("## T {:t}\n\nBefore\n\n{{ block(x) }}\n", x=figure)
    assert section.blocks == (Paragraph(words=("Before",)), figure)


def test_sections_that_are_made_elsewhere_stand_where_they_are_named(page):
    """One, several or none, between those of the page."""
    made = [Section(name=one, title=one, blocks=()) for one in "abc"]
    found = page(
        "## T {:t}\n\nWords\n\n{{ sections(x) }}\n{{ sections(none) }}\n"
        "{{ sections(y) }}\n## U {:u}\n\nEnd.\n",
        x=made[0],
        y=made[1:],
    )
    assert [one.name for one in found] == ["t", "a", "b", "c", "u"]
    assert found[1:4] == (*made,)
    assert found[0].blocks == (Paragraph(words=("Words",)),)


def test_a_listing_without_points_says_what_that_means(page):
    """In the place of points, in words."""
    (section,) = page("## T {:t}\n\nEmpty: none of {{ x }}\n", x="*y*")
    assert section.blocks == (Listing(items=(), empty="none of *y*"),)


def test_a_line_ends_a_panel(page):
    """What follows it belongs to the section; a value of three dashes is none."""
    (section,) = page("## T {:t}\n\n### Part\n\n{{ x }}\n\n---\n\nBelow it.\n", x="---")
    panel, below = section.blocks
    assert panel == Panel(title="Part", blocks=(Paragraph(words=("---",)),))
    assert below == Paragraph(words=("Below it.",))


def test_a_count_stays_a_whole_number(page):
    """The exact value of a count has no decimal point, that of a size has one."""
    (section,) = page('## T {:t}\n\n{{ "2"|exact(2) }} {{ "2"|exact(2.0) }}\n')
    count, _, size = section.blocks[0].words
    assert (repr(count.exact), repr(size.exact)) == ("2", "2.0")


def test_a_page_of_one_paragraph_is_a_line_of_a_file(page):
    """Its lines run on, its values stand as they are."""
    page("One {{ x }}.\n{% if x %}\nTwo.\n{% endif %}\n", x=HOSTILE[0])
    assert pages.line("own", x=HOSTILE[0]) == f"One {HOSTILE[0]}. Two."


@pytest.mark.parametrize("text", ["a?", "x {2.0}", "x {code}", "x {:y wide}", "?{:a}"])
def test_no_value_ends_a_title_or_a_head(page, text):
    """Names, kinds and what goes are of the page: a device may be called so."""
    (section,) = page(
        "## {{ x }} {:t first}\n\nTable: {{ x }} {:u wide}\n\n"
        "| {{ x }} | {{ x }}{1.4} |\n|---|---|\n| | a |\n",
        x=text,
    )
    (table,) = section.blocks

    assert (section.title, section.name, section.on_first_page) == (text, "t", True)
    assert (table.caption, table.name, table.is_wide) == (text, "u", True)
    assert [one.head for one in table.columns] == [text, text]
    assert [one.weight for one in table.columns] == [1.0, 1.4]
    assert {one.kind for one in table.columns} == {"text"}


def test_sentences_are_said_in_the_language_spoken(page):
    """Whole, with their parts where that language wants them; one thing or several."""
    text = (
        "## T {:t}\n\n{% trans said=x %}{{ said }}.{% endtrans %}\n\n"
        "{% trans count=n %}one{% pluralize %}{{ count }} things{% endtrans %}\n"
    )
    assert pages.messages(text) == {"{said}.", "one", "{count} things"}
    with speaking("zh"):
        (section,) = page(text, x="x", n=2)
    assert section.blocks[0] == Paragraph(words=("x。",))
    (section,) = page(text, x="x", n=2)
    assert section.blocks[1] == Paragraph(words=("2 things",))


def test_words_with_formulas_come_in_the_order_of_the_language(page):
    """Parts that are no text keep what they are, wherever the sentence has them."""
    page(
        "{% macro m(low, high) %}{% trans low=block(low), high=high|exact(2.5) %}"
        "{{ low }} to {{ high }}{% endtrans %}{% endmacro %}\n"
    )
    low, high = Math(source="n_x"), Run(text="2", exact=2.5)
    for language, to in (("zh", " \u81f3 "), ("en", " to ")):
        with speaking(language):
            assert pages.runs("own", "m", low=low, high="2") == (low, to, high)


def test_bold_words_end_at_a_full_stop_of_any_language(page):
    """Where no blank follows it, as in Chinese; other bold words run on."""
    page("{% macro m(x) %}**{{ x }}****{{ x }}**{{ x }}{% endmacro %}\n")
    text = "x\u3002"
    assert pages.runs("own", "m", x=text) == (Run(text=2 * text, strong=True), text)


def test_each_line_of_a_macro_is_a_text(page):
    """Blank ones are none, and no value breaks a line."""
    page(
        "{% macro m(x) %}\n{{ x }}\n\n{% for one in x|lines %}\n{{ one }}\n"
        "{% endfor %}\n**b** c\n{% endmacro %}\n"
    )
    text = Markup("one\n\n two \n")
    assert pages.lines("own", "m", x=text) == ("one", "two", "one", "two", "b c")
    assert pages.lines("own", "m", x=Markup("")) == ("b c",)
    assert pages.lines("own", "m", x=marked(HOSTILE[0])) == (
        *(HOSTILE[0], HOSTILE[0], "b c"),
    )


def test_what_a_template_makes_has_no_blanks_around_it_in_a_sentence(page):
    """Neither of a macro nor of a block of lines; a value keeps its own."""
    (section,) = page(
        "{% macro m() %}\nx\n{% endmacro %}\n{% set s %}\ny\n{% endset %}\n"
        "## T {:t}\n\n"
        "{% trans a=m(), b=s, c=v %}{{ a }},{{ b }}.{{ c }}.{% endtrans %}\n",
        v="z ",
    )
    assert section.blocks == (Paragraph(words=("x,y.z .",)),)


def test_a_value_that_is_not_there_is_an_error(page):
    """Nothing is printed in its place; a template reaches only what it is given."""
    for text in ("{{ absent }}", "{{ x.__class__.__mro__ }}"):
        with pytest.raises(TemplateError):
            page(f"## T {{:t}}\n\n{text}\n", x=1)


@pytest.mark.usefixtures("page")
def test_a_page_whose_template_is_missing_is_named():
    """Which file, and to install the program again: no limit of the system is it."""
    with pytest.raises(OutputError, match=r"own\.md\.j2: this template is missing"):
        pages.sections("own")


def test_a_whole_document_has_title_facts_headline_summary_and_cards(page):
    """And its sections; what a terminal prints in brief; panels beside each other."""
    formula = Math(source="n_x")
    view = {"title": "*t* | u", "formula": formula, "x": 2}
    page(
        "# {{ title }}\n\n- fact\n- {{ title }}\n\n**FAILS** it\n\n"
        'By {{ "2"|exact(2.5) }}, {{ block(formula) }}.\n\n'
        "### Card\n\n**Fails**\n\nof $K_x^({{ x }} m)$, $n_x$\n\n"
        "### Next\n\n## S {:s}\n\nBrief: short {{ title }}\n\n"
        "{% call abreast(3) %}\n### A\n\na\n\n### B\n\nb\n{% endcall %}\n",
        **view,
    )
    found = pages.document("own", **view)
    assert (found.title, found.facts) == ("*t* | u", ("fact", "*t* | u"))
    assert found.headline == "FAILS it"
    assert found.summary == ("By ", Run(text="2", exact=2.5), ", ", formula, ".")
    bold = (Run(text="Fails", strong=True),)
    power = Math(source="K_x^(2 m)")
    assert found.cards == (
        Card(title="Card", lines=(bold, ("of ", power, ", ", formula))),
        Card(title="Next", lines=()),
    )
    (section,) = found.sections
    assert section.in_brief == "short *t* | u"
    (abreast,) = section.blocks
    assert abreast == Abreast(
        blocks=tuple(
            Panel(title=one, blocks=(Paragraph(words=(one.lower(),)),)) for one in "AB"
        ),
        columns=3,
    )


def test_the_words_of_a_figure_are_macros_of_a_page(page):
    """As plain text, as words with bold and exact numbers, as blocks."""
    page(
        "{% macro axis(unit) %}u [{{ unit }}]{% endmacro %}\n"
        '{% macro said(x) %}**{{ x }}** and {{ "1"|exact(1.5) }}{% endmacro %}\n'
        "{% macro listed(rows) %}\n{% for one in rows %}\n- {{ one }}\n{% endfor %}\n"
        "{% endmacro %}\n"
        "{% macro of(x) %}\n### {{ x }}\n\n**a**\n\n{{ x }}\n{% endmacro %}\n"
    )
    assert pages.line("own", "axis", unit="deg/h [x]") == "u [deg/h [x]]"
    run = Run(text="1", exact=1.5)
    assert pages.runs("own", "said", x="*") == (
        *(Run(text="*", strong=True), " and ", run),
    )
    (card,) = pages.cards("own", "of", x="# x")
    assert card == Card(title="# x", lines=((Run(text="a", strong=True),), ("# x",)))
    (listing,) = pages.blocks("own", "listed", rows=["# a", "b"])
    assert listing == Listing(items=(("# a",), ("b",)), empty="")
