"""Every text that is said in a language: of code, pages, scripts, files, the paper."""

from __future__ import annotations

import ast
import re
from functools import cache
from itertools import chain

from places import PACKAGE, ROOT, SHIPPED

from budget.calibration.problem import MEASURED
from budget.language import LANGUAGES, read_catalogue
from budget.model.sources import SOURCES
from budget.names import LENGTHS, MISSION, OUTPUTS, PLACES, key_title
from budget.names import words as plain_words
from budget.report.page import SCRIPTS, script_messages
from budget.report.pages import messages
from budget.resources import shipped
from zhao_2019.printed import load_paper

CATALOGUES = [language for language in LANGUAGES if language != "en"]
SIGNS = re.compile(r"\{.*?\}|\b\w_\w+|^ (?:arcsec|deg/h|mg)$")
SAYING = {"say", "counted", "term", "note"}


def messages_of(tree):
    """Return every template that a module hands to the functions of the language."""
    own = {
        alias.asname or alias.name
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node.module == "budget.language"
        for alias in node.names
    } | {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}
    own &= SAYING
    calls = [
        node
        for node in ast.walk(tree)
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id in own
    ]
    return {
        part.value
        for call in calls
        for given in (call.args[1:] if call.func.id == "counted" else call.args[:1])
        # Of a choice both sides are said; what its condition compares with is not.
        for side in (
            [given.body, given.orelse] if isinstance(given, ast.IfExp) else [given]
        )
        for part in [side]
        if isinstance(part, ast.Constant) and isinstance(part.value, str)
    }


@cache
def places_of_messages():
    """Return every template by its text, with the files that have it."""
    found = {}
    for path in SHIPPED:
        tree = ast.parse(path.read_text(encoding="utf-8"))
        _add(found, messages_of(tree), path.relative_to(ROOT))
    for path in sorted(shipped("templates", "pages").rglob("*.md.j2")):
        _add(found, messages(path.read_text("utf-8")), path.relative_to(ROOT))
    for name in SCRIPTS:
        _add(found, script_messages(shipped_template(name)), f"templates/{name}")
    for name in ("page.html.j2", "page.css"):
        said = re.findall(r'say\("([^"]*)"', shipped_template(name))
        _add(found, said, f"templates/{name}")
    _add(found, paper_messages(), "examples/zhao_2019/printed.yaml")
    return found


def _add(found, texts, place):
    """Add texts of a place to those of others."""
    for text in sorted(texts):
        found.setdefault(text, []).append(str(place))


def every_message():
    """Return the templates of the whole package, of the page and of its scripts."""
    return set(places_of_messages())


def shipped_template(name):
    """Return the text of a template, style sheet or script of the page."""
    return shipped("templates").joinpath(name).read_text(encoding="utf-8")


def paper_messages():
    """Return what the file of the paper says in words, templates of findings too."""
    paper = load_paper()
    findings = paper.findings.values()
    reasons = [
        f.why if isinstance(f.why, str) else (*f.why.values(),) for f in findings
    ]
    texts = {
        *(paper.title, paper.reference, *paper.sections.values(), *paper.cards),
        *(*paper.verdicts, *paper.verdicts.values(), *paper.notes.values()),
        *(*paper.assumptions, *paper.figures, *chain(*paper.figure_3.items())),
        *chain(*((one.condition, one.note) for one in paper.orders)),
        *(one.name for one in (*paper.readings, *paper.noise_readings)),
        *chain(*((f.equation, *f.names, f.ours, f.note) for f in paper.formulas)),
        *(f" {f.unit}" for f in paper.formulas),
        *chain(*((one.section, *one.claims.values()) for one in paper.conclusions)),
        *chain(*((f.where, *f.place, f.printed) for f in findings)),
        *chain(*([why] if isinstance(why, str) else why for why in reasons)),
    }
    # Numbers, units and formulas are no words.
    return {text for text in texts if re.search(r"[a-z]{2}|, ", SIGNS.sub("", text))}


def catalogue_file(language):
    """Return the file of the translations of a language."""
    return PACKAGE / "languages" / f"{language}.po"


def catalogue_of(language):
    """Return the translations of a language, as the file has them."""
    return read_catalogue(catalogue_file(language).read_text(encoding="utf-8"))


def vocabulary():
    """Return the words of files that reports print: of sources, outputs, owners."""
    keys = {source.name.replace(".", " ") for source in SOURCES}
    owners = {owner for source in SOURCES for owner in source.units}
    places = {
        axis if quantity == "attitude" else f"{axis} {quantity}"
        for quantity, axes in PLACES.items()
        for axis in (*axes, *filter(None, [LENGTHS.get(quantity)]))
    }
    words = {plain_words(key) for key in (*keys, *owners, *OUTPUTS, MISSION)}
    return words | places | {key_title(MEASURED), MEASURED.owner}
