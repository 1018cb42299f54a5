"""A document as one HTML page that needs nothing else: figures and formulas inside."""

from __future__ import annotations

import json
import re
from base64 import b64encode
from functools import cache
from hashlib import sha256
from html import escape, unescape
from typing import TYPE_CHECKING

from budget.language import say, speaking, template
from budget.report.blocks import Abreast, Run, Table, drawn
from budget.report.figures.style import BLACK, GRID, INK, MUTED, PAPER, looks
from budget.report.formulas import Math, to_mathml
from budget.report.inline import MINUS, Raised, bind, cut
from budget.resources import own_templates, telling, template_environment

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence
    from pathlib import Path

    from jinja2.sandbox import SandboxedEnvironment
    from markupsafe import Markup

    from budget.report.blocks import Block, Document, Picture, RowGroup, Words


PAGE = "page.html.j2"
SCRIPTS = ("what_if.js", "page.js")  # in the order that they stand in the page
# Templates that scripts say, `word("{n} of {m}", ...)`, or mark for it, `term("none")`.
MESSAGE = re.compile(r'\b(?:word|term)\(\s*"([^"\\]*)"')
FORMULA = re.compile(r"(<math[^>]*>)(.*?)</math>", re.DOTALL)
SMALL_BAR = 0.005  # a share that is thinner than a line behind its number [1]


def render_page(document: Document) -> str:
    """Write a document as one HTML page that needs nothing else and can load nothing.

    Its texts may come from anywhere: all are escaped. Same document, same bytes.

    Raises
    ------
    OutputError
        A template is missing.
    """
    with speaking(document.language), telling(PAGE):
        return _render(drawn(document))


def _render(document: Document) -> str:
    """Fill the templates in."""
    environment = page_environment()
    environment.filters |= {
        "words": _words,
        "set": lambda text: markup(_text(text)),
        "formula": lambda math: markup(_formula(math, "displaystyle")),
        "kind": lambda block: type(block).__name__,
        "is_broad": _is_broad,
        "tails": _tails,
        "widths": _widths,
        "picture": _picture,
        "natural_width": natural_width,
        "css_string": css_string,
        "model": _model,
        "ink": lambda colour: INKS.get(colour, colour),
        "has_bar": lambda share: share is not None and share > SMALL_BAR,
        "per_cent": lambda share: f"{100.0 * min(share, 1.0):.1f}%",
    }
    script = _script(environment)
    page = environment.get_template(PAGE).render(
        document=document,
        say=say,
        first=[section for section in document.sections if section.on_first_page],
        rest=[section for section in document.sections if not section.on_first_page],
        has_search=any(_has_searchable(s.blocks) for s in document.sections),
        json=markup(script_safe(document.json)),
        running_head=markup(css_string(document.running_head)),
        script_words=_script_words(script),
        script=markup(script),
        script_hash=b64encode(sha256(script.encode()).digest()).decode(),
    )
    return _with_mathml(page)


def _script(environment: SandboxedEnvironment) -> str:
    """Return the script of every page, the same bytes that its hash is of."""
    sources = [environment.get_template(name).render() for name in SCRIPTS]
    return "\n" + "\n".join(sources) + "\n"


def script_messages(script: str) -> tuple[str, ...]:
    """Return the templates that a script says in the language of the page, each once.

    They are ids of the same catalogue as those of `budget.language.say`.
    """
    return tuple(dict.fromkeys(MESSAGE.findall(script)))


def _script_words(script: str) -> Markup:
    """Write what a script says by its English, as JSON; nothing where it is the same.

    A word that has no translation is not there, and the script says it in English.
    """
    said = {text: template(text) for text in script_messages(script)}
    other = {text: own for text, own in said.items() if own != text}
    told = json.dumps(other, ensure_ascii=False) if other else ""
    return markup(script_safe(told))


def _words(words: Words) -> Markup:
    """Set a line of text with what is bold, exact or a formula in it."""
    return markup("".join(_part(part) for part in words))


def _part(part: str | Run | Math) -> str:
    """Set one part of a line; a number stays with its unit."""
    if isinstance(part, str):
        return _text(part)
    if isinstance(part, Math):
        return _formula(part)
    text = _text(part.text)
    if part.exact is not None:
        text = f'<span class="number" title="{part.exact!r}">{_signs(part.text)}</span>'
    return f"<strong>{text}</strong>" if part.strong else text


def _text(text: str) -> str:
    """Set a text: minus signs are true, powers raised, addresses links."""
    pieces = []
    for part in cut(text):
        if isinstance(part, str):
            pieces.append(escape(part))
        elif isinstance(part, Raised):
            pieces.append(f"<sup>{part.text}</sup>")
        else:
            to, said = escape(part.address), escape(part.text)
            pieces.append(f'<a href="{to}" rel="noreferrer">{said}</a>')
    return "".join(pieces)


def _formula(math: Math, style: str = "") -> str:
    """Hold the place of a formula; all of a page are set at once in the end."""
    opening = f'<math {style}="true">' if style else "<math>"
    return f"{opening}{escape(math.source)}</math>"


def _with_mathml(page: str) -> str:
    """Set the formulas of a page; no other text in it can have such a tag."""
    sources = tuple(dict.fromkeys(unescape(one[2]) for one in FORMULA.finditer(page)))
    if not sources:
        return page
    found = dict(zip(sources, to_mathml(sources), strict=True))
    return FORMULA.sub(lambda one: f"{one[1]}{found[unescape(one[2])]}</math>", page)


def _signs(text: str) -> str:
    """Set a number with its unit."""
    return signs_markup(bind(text))


def _is_broad(blocks: Sequence[Block]) -> bool:
    """Whether a section needs more than a column of the first page."""
    return any(
        getattr(block, "is_wide", False)
        or (
            isinstance(block, Abreast)
            and (block.columns > 2 or _is_broad(block.blocks))  # noqa: PLR2004
        )
        for block in blocks
    )


def _has_searchable(blocks: Sequence[Block]) -> bool:
    """Whether a table among blocks, or in the panels among them, is searchable."""
    return any(
        block.searchable
        if isinstance(block, Table)
        else _has_searchable(getattr(block, "blocks", ()))
        for block in blocks
    )


def _tails(group: RowGroup) -> list[int]:
    """Return for each column how long the tails of its numbers are."""
    columns = zip(*group.rows, strict=True)
    return [longest_tail(cell.text for cell in column) for column in columns]


def _widths(table: Table) -> list[str]:
    """Return the part of the width that each column of a wide table asks for.

    Text columns share out what the others leave, by their weights; those are as wide
    as their numbers, some 8 % each.
    """
    texts = [column.weight for column in table.columns if column.kind == "text"]
    if not (table.is_wide or table.for_pen) or len(set(texts)) < 2:  # noqa: PLR2004 - all alike
        return [""] * len(table.columns)
    count = len(table.columns)
    part = max(len(texts) / count, 1.0 - 0.08 * (count - len(texts))) / sum(texts)
    return [
        f"{100.0 * part * column.weight:.1f}%" if column.kind == "text" else ""
        for column in table.columns
    ]


def _picture(picture: Picture, svg: str, name: str) -> Markup:
    """Set a drawing of a figure into the page."""
    return markup(svg_element(svg, name=name, alt=picture.alt, tips=picture.tips))


def _model(model: Mapping[str, object]) -> Markup:
    """Write what the sliders compute from, with the colours of the figures."""
    colours = {name: colour for name, (colour, _, _) in looks().items()}
    return markup(
        script_safe(json.dumps({**model, "colours": colours}, allow_nan=False))
    )


# The figures take their inks from the page, so that they turn with light and dark.
INKS = {
    INK: "currentColor",
    MUTED: "var(--muted)",
    GRID: "var(--grid)",
    PAPER: "var(--paper)",
    BLACK: "var(--black)",
}
INK_OF = re.compile(r"((?:fill|stroke): ?)(#[0-9a-fA-F]{6})")  # as matplotlib writes it
ELEMENT = re.compile(r'<(?P<tag>\w+) [^>]*?\bid="(?P<id>[^"]+)"[^>]*?(?P<empty>/?)>')
ID = re.compile(r' id="([^"]+)"')
REFERENCE = re.compile(r'(?:url\(|href=")#([^)"]+)')  # to an element of a drawing
PROLOG = re.compile(
    r"<title>.*?</title>|<metadata>.*?</metadata>|<style.*?</style>", re.DOTALL
)


def svg_element(
    svg: str, *, name: str, alt: str, tips: Mapping[str, str] | None = None
) -> str:
    """Turn an SVG file of `style.to_svg` into an element of HTML with the page's inks.

    It has no prolog and no size, and no ids but those that it refers to, which begin
    with `name`; tips go by the gid of the element that they belong to.

    Raises
    ------
    ValueError
        A tip belongs to no element.
    """
    head, end, rest = PROLOG.sub("", svg[svg.index("<svg") :]).partition(">")
    head = re.sub(r' (xmlns(:\w+)?|width|height|version)="[^"]*"', "", head)
    rest = INK_OF.sub(lambda ink: ink[1] + INKS.get(ink[2], ink[2]), rest)
    rest = _with_tips(rest, {f"{name}-{gid}": tip for gid, tip in (tips or {}).items()})
    named = {*REFERENCE.findall(rest)}
    rest = ID.sub(lambda one: one[0] if one[1] in named else "", rest)
    return f'{head} role="img" aria-label="{escape(alt)}"{end}{rest}'


def natural_width(svg: str) -> float:
    """Return the width that a figure was drawn for [pt]."""
    found = re.search(r'viewBox="[-\d.]+ [-\d.]+ ([\d.]+) [\d.]+"', svg)
    if found is None:
        raise ValueError("an SVG figure has no viewBox, expected one of style.to_svg")
    return float(found[1])


def _with_tips(svg: str, tips: Mapping[str, str]) -> str:
    """Put a title into the elements of those ids, which browsers show as a tooltip."""
    left = dict(tips)

    def with_title(found: re.Match[str]) -> str:
        tip = left.pop(found["id"], None)
        if tip is None:
            return found[0]
        closing = f"</{found['tag']}>" if found["empty"] else ""
        start = found[0].removesuffix(">").removesuffix("/")
        return f"{start}><title>{escape(tip)}</title>{closing}"

    told = ELEMENT.sub(with_title, svg)
    if left:
        lost = ", ".join(map(repr, left))
        raise ValueError(f"the tip {lost} belongs to no element of its figure")
    return told


DIGIT, POINT = "\N{FIGURE SPACE}", "\N{PUNCTUATION SPACE}"  # as wide as those
SIGN = re.compile(r"(?<![\w.)\]])-(?=\d)")  # a sign, not a hyphen
POWER = re.compile(r"(?<=\d)e([+-]?)0*(\d+)\b")  # of ten, as Python prints it
PLAIN = re.compile(r"([<>]?[-+]?\d+(\.\d+)?)( [^\d]*)?")


def page_environment() -> SandboxedEnvironment:
    """Return the jinja2 environment of every page: escaping, numbers kept with units.

    Missing values are errors, plain text is escaped and its numbers bound to their
    units; the filters `number` and `longest_tail` set columns.
    """
    return _environment_of(own_templates())


@cache  # it keeps what it has compiled, and reads a template that has changed again
def _environment_of(_: Path | None) -> SandboxedEnvironment:
    """Return that of a folder of templates that go before those that ship."""
    environment = template_environment(
        finalize=lambda value: bind(value) if type(value) is str else value
    )
    environment.filters |= {
        "number": lambda text, tail=0: markup(number_markup(text, tail=tail)),
        "longest_tail": longest_tail,
    }
    return environment


def markup(html: str) -> Markup:
    """Mark HTML as made here: its makers escape what they are given."""
    from markupsafe import Markup

    return Markup(html)  # noqa: S704 - see above


def number_markup(text: str, *, tail: int = 0) -> str:
    """Set a printed number for a page: true minus signs, powers of ten raised.

    It is filled up to `tail` characters from the decimal point on, so that the points
    of a column that is set flush right are in line.
    """
    own = _tail(text)
    if own is None:
        return signs_markup(text)
    missing = tail - own
    filler = DIGIT * missing if own else (POINT + DIGIT * missing)[:missing]
    return signs_markup(
        PLAIN.sub(lambda parts: parts[1] + filler + (parts[3] or ""), text)
    )


def signs_markup(text: str) -> str:
    """Escape a text; minus signs of numbers in it are true, powers of ten raised."""
    return POWER.sub(
        lambda power: (
            "&#8239;&times;&#8239;10<sup>"
            f"{power[1].replace('-', MINUS).replace('+', '')}{power[2]}</sup>"
        ),
        SIGN.sub(MINUS, escape(text)),
    )


def longest_tail(texts: Iterable[str]) -> int:
    """Return the most characters from a decimal point on, powers of ten left out."""
    return max((_tail(text) or 0 for text in texts), default=0)


def script_safe(document: str) -> str:
    """Escape JSON so that nothing in it can end the script element around it."""
    for character in "&<>":
        document = document.replace(character, f"\\u{ord(character):04x}")
    return document


def css_string(text: str) -> str:
    """Quote a text for CSS; all but plain letters and digits as code points."""
    return '"' + re.sub(r"[^A-Za-z0-9]", lambda c: f"\\{ord(c[0]):06x}", text) + '"'


def _tail(text: str) -> int | None:
    """Return the length from the decimal point on; None where no point is in line.

    That is so for words, powers of ten and intervals; a unit may follow the number.
    """
    plain = PLAIN.fullmatch(text)
    return None if plain is None else len(plain[2] or "")
