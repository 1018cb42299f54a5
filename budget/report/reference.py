"""Reference budgets as sections and documents: what moved, and why."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import accumulate
from math import floor, inf, log10
from typing import TYPE_CHECKING, Any

from budget.documents import written
from budget.known import Known
from budget.language import key_title, words
from budget.question import read_name
from budget.references.difference import EXACT, FALSE_ALARM, TOOL, Difference, Move
from budget.report.answers import LEAST_ROWS, decades
from budget.report.document import json_of
from budget.report.figures.rows import Bar, Chart, ChartPanel, chart_picture, rows_of
from budget.report.figures.style import Scale
from budget.report.pages import document, figure, sections
from budget.report.provenance import endings
from budget.report.tables import (
    PLAIN_BELOW,
    round_value,
    source_title,
)
from budget.report.writing import capital

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from budget.references.difference import Alteration
    from budget.report.blocks import Document, Section
    from budget.results import InputFile

# What a reader looks at first; the other numbers follow from what moves these.
PRINCIPAL = (
    "standard_uncertainty",
    "mean",
    "utilisation",
    "conformance",
    "allowed",
    "cost",
)
MOST_ROWS = 24  # on a terminal
MOST_CARDS = 4  # references that a page names before the table of all
MOST_IDLE = 12  # changes without effect that a terminal names
FACTOR = 3.0  # a number that grew by more is said to be so many times as large
MOST_DIGITS = 10  # of a number that moved by very little
PLAIN = (-4, 4)  # decimal exponents that are written without one
AXES = {3, 6}  # how many axes a parameter has
AXIS = 3  # letters that no name of an axis has
ALL = "100 %"
MOST_PART = 1e300  # beyond it a part in per cent may overflow [1]
MOST_PERCENT = 100.0  # a part above this [1] is printed to two digits
NAMED = 2  # causes of one row on a terminal
LITTLE = 0.005  # of a difference: not worth a word [1]
NONE = "-"  # nothing to say
FEW = 0.03  # of a difference: what parts need not add up to, without a word [1]


@dataclass(frozen=True, kw_only=True)
class Title:
    """What moved: a quantity of a parameter, or of it and its partner."""

    group: str  # the parameter: 'Gyro bias'
    quantity: str
    partner: str
    unit: str  # '' where it has none


@dataclass(frozen=True, kw_only=True)
class MovedRow:
    """One or more numbers that moved alike."""

    title: Title
    before: str
    after: str
    is_bound: bool  # whether one of them is this or worse
    change: str  # of the uncertainty of the output, or of the number itself
    times: str  # how many tolerances or standard errors; '' where none
    is_sampled: bool
    causes: tuple[tuple[int, str], ...]  # numbers of the changes, each with its part
    has_more_causes: bool
    together: str  # what all changes do at once beyond these parts, or ''
    # Of the largest of them: absolute difference over what it is measured by [1].
    size: float = field(compare=False)
    labels: tuple[str, ...] = ()

    @property
    def are_all_axes(self) -> bool:
        """Whether it stands for all axes of a parameter."""
        return len(self.labels) in AXES and all(
            len(label) < AXIS and label.isascii() for label in self.labels
        )

    @property
    def mark(self) -> str:
        """What parts its labels; the name of a procedure may have a comma."""
        return "; " if "," in "".join(self.labels) else ", "

    @property
    def has_one_cause(self) -> bool:
        """Whether one change is all that moved it."""
        return [part for _, part in self.causes] == [ALL] and not self.together


@dataclass(frozen=True, kw_only=True)
class Word:
    """A word that moved: of a verdict, of what is not given."""

    title: Title
    before: str
    after: str


@dataclass(frozen=True, kw_only=True)
class MoveTable:
    """What is shown of all moves, and how many are not."""

    rows: tuple[MovedRow, ...]
    words: tuple[Word, ...]
    rest: int


@dataclass(frozen=True, kw_only=True)
class Brief:
    """Changes that are named, and how many more move no number."""

    named: tuple[Alteration, ...]
    rest: int
    only_alone: bool  # whether one of these may have done it with another


def check_sections(checks: Sequence[Difference], bad: int) -> tuple[Section, ...]:
    """Return one line for each reference, and all about those that moved.

    `bad` is how many references could not be computed.
    """
    return sections("check", **_view(checks, bad))


def check_document(
    checks: Sequence[Difference],
    errors: Sequence[str],
    files: Sequence[InputFile],
    *,
    date: str,
    command_line: str = "budget check",
) -> Document:
    """Put a check into one document: how many moved, which ones, by how much, why.

    `errors` are of references that could not be computed, `files` the references.
    """
    view = _view(checks, len(errors))
    chart = moves_chart([(one.first, table.rows) for one, table in view["moved"]])
    stored = [one for check in checks for one in check.before.inputs]
    page = document(
        "check_page",
        **view,
        errors=errors,
        picture=None if chart is None else chart_picture(chart),
        stored=dict.fromkeys((one.role, one.file, one.sha256) for one in stored),
        MOST_CARDS=MOST_CARDS,
        EXACT=EXACT,
        FALSE_ALARM=FALSE_ALARM,
    )
    return page.whole(
        "check",
        *endings(files, command_line=command_line),
        json=json_of((checks, errors), "check"),
        date=date,
    )


def difference_sections(difference: Difference) -> tuple[Section, ...]:
    """Return two budgets side by side, the largest change first."""
    table = move_table(difference.moves, difference.changes)
    return sections("diff", difference=difference, table=table, **WORDED)


def _view(checks: Sequence[Difference], bad: int) -> dict[str, Any]:
    """Return what a page of a check is filled in with."""
    moved = [(x, move_table(x.moves, x.changes)) for x in checks if not x.holds]
    return {"checks": checks, "moved": moved, "bad": bad, **WORDED}


def move_table(moves: Sequence[Move], changes: Sequence[Alteration] = ()) -> MoveTable:
    """Choose and group the moves to be shown, the largest first.

    Titles stand by their largest change, rows under a title too; axes whose rows say
    the same are one row. Where principal numbers moved (u, mean, a verdict), those that
    follow from them are only counted.
    """
    worded = [m for m in moves if isinstance(m.before or m.after, str)]
    numbers = [m for m in moves if not isinstance(m.before or m.after, str)]
    first = [move for move in numbers if move.item.quantity in PRINCIPAL]
    chosen = sorted(first or numbers, key=lambda move: -move.size)[:MOST_ROWS]
    rows: dict[MovedRow, list[str]] = {}
    for move in chosen:
        rows.setdefault(_row(move, changes), []).append(_split(move.item.subject)[1])
    titles = list(dict.fromkeys(row.title for row in rows))
    return MoveTable(
        rows=tuple(
            replace(row, labels=tuple(rows[row]))
            for row in sorted(rows, key=lambda row: titles.index(row.title))
        ),
        words=tuple(
            Word(title=_word_title(m), before=_word(m.before), after=_word(m.after))
            for m in worded
        ),
        rest=len(numbers) - len(chosen),
    )


def brief(changes: Sequence[Alteration]) -> Brief:
    """Choose the changes to be named: all that act, of the others the first ones."""
    idle = accumulate(one.acts is False for one in changes)
    named = tuple(
        one
        for one, place in zip(changes, idle, strict=True)
        if one.acts is not False or place <= MOST_IDLE
    )
    rest = [one for one in changes if one.acts is False][MOST_IDLE:]
    alone = any(not one.is_text and one.where != TOOL for one in rest)
    return Brief(named=named, rest=len(rest), only_alone=alone)


# What every page with moves in it is filled in with.
WORDED: Mapping[str, Any] = {"brief": brief, "DASH": NONE, "TOOL": TOOL}


def cause_texts(move: Move) -> tuple[tuple[Alteration, str], ...]:
    """Return (change, part of the move that it explains), the largest part first."""
    difference = move.difference
    if not difference:
        return ()
    parts = sorted(
        ((cause.change, cause.amount / difference) for cause in move.causes),
        key=lambda pair: -abs(pair[1]),
    )
    return tuple(
        (one, _percent(part)) for one, part in parts if LITTLE <= abs(part) < MOST_PART
    )


def together_text(move: Move) -> str:
    """Return the part of the move that only all changes at once explain, or ''."""
    if not move.difference or move.together is None:
        return ""
    part = move.together / move.difference
    return _percent(part) if FEW < abs(part) < MOST_PART else ""


def print_pair(before: float, after: float) -> tuple[str, str]:
    """Print two numbers to the second digit of both and of their difference."""
    largest = max(abs(before), abs(after))
    if largest == 0.0:
        return "0", "0"
    top = floor(log10(largest))
    difference = abs(after - before)
    place = top - 2
    for number in (difference, abs(before), abs(after)):
        if 0.0 < number < inf:
            place = min(place, floor(log10(number)) - 1)
    place = max(place, top - MOST_DIGITS + 1)
    if top < PLAIN_BELOW:
        place = min(place, 0)  # no digit before the point is rounded away
    u = 10.0 ** (place + 1)  # values are printed to its second digit
    return round_value(before, u), round_value(after, u)


def _row(move: Move, changes: Sequence[Alteration]) -> MovedRow:
    """Return the row of one move, without its label."""
    if isinstance(move.before, float) and isinstance(move.after, float):
        pair = print_pair(move.before, move.after)
    else:
        pair = (_word(move.before), _word(move.after))
    both = (move.before, move.after)
    before, after = (
        one.written(text) if isinstance(one, Known) else text
        for text, one in zip(pair, both, strict=True)
    )
    change = NONE
    ratio = 1.0 if move.relative is None else 1.0 + move.relative
    if ratio > FACTOR and move.scale == move.before:
        change = f"x {_two_digits(ratio)}"
    elif move.difference is not None and 100.0 * move.size < inf:
        sign = "-" if move.difference < 0.0 else "+"
        change = f"{sign}{_two_digits(100.0 * move.size)} %"
    causes = [(changes.index(one) + 1, part) for one, part in cause_texts(move)]
    return MovedRow(
        title=_title(move),
        before=before,
        after=after,
        is_bound=any(isinstance(one, Known) and one.is_bound for one in both),
        change=change,
        times="" if move.times is None else _two_digits(move.times),
        is_sampled=move.is_sampled and move.times is not None,
        causes=tuple(causes[:NAMED]),
        has_more_causes=len(causes) > NAMED,
        together=together_text(move),
        size=move.size,
    )


def _title(move: Move) -> Title:
    """Name the group of a move: 'Gyro bias', u, in deg/h."""
    subject, partner = move.item.subject, move.item.partner
    name = key_title if move.item.quantity == "correlation" else source_title
    group, _ = _split(subject)
    return Title(
        # The name of a file stays as it is.
        group=group if " " in subject else capital(group),
        quantity=move.item.quantity,
        partner=name(read_name(partner)) if partner else "",
        unit="" if move.unit == "1" else move.unit,
    )


def _word_title(move: Move) -> Title:
    """Name a word that moved, and the device it is of: 'imu.yaml gyro, verdict'."""
    title, (_, label) = _title(move), _split(move.item.subject)
    if " " not in move.item.subject:
        return title
    return replace(title, group=f"{label} {title.group}")


def _split(subject: str) -> tuple[str, str]:
    """Return the group and the row that a subject belongs to."""
    device, _, text = subject.rpartition(" ")
    name = read_name(text)
    if not name.owner:
        return name, device
    if name.axis:
        return f"{device} {key_title(name.group)}".strip(), name.axis
    return f"{device} {words(name.owner)}".strip(), source_title(name)


def _word(value: float | str | None) -> str:
    """Show a word; a dash for what is not there."""
    if value is None or value == "":
        return NONE
    return value if isinstance(value, str) else f"{value:.4g}"


def _percent(part: float) -> str:
    """Print a part of a difference."""
    if abs(part) >= MOST_PERCENT:
        return f"{'-' if part < 0.0 else ''}{_two_digits(100.0 * abs(part))} %"
    return f"{round(100.0 * part)} %"


def _two_digits(value: float) -> str:
    """Print two digits, plainly where that is short: 0.0015, 1500, 1.5e4."""
    if value == 0.0:
        return "0"
    top = floor(log10(value))
    if PLAIN[0] <= top < PLAIN[1]:
        return f"{value:.{max(1 - top, 0)}f}"
    mantissa, _, exponent = f"{value:.1e}".partition("e")
    return f"{mantissa}e{int(exponent)}"


MOST_DRAWN = 4  # references, and rows of each


def moves_chart(moved: Sequence[tuple[str, Sequence[MovedRow]]]) -> Chart | None:
    """Show the numbers of each reference that moved most, on one logarithmic axis.

    None where hardly a number did, or they did from nothing.
    """
    sized = [
        (name, [one for one in rows if 0.0 < 100.0 * one.size < inf][:MOST_DRAWN])
        for name, rows in moved
    ]
    shown = sorted(
        ((name, rows) for name, rows in sized if rows),
        key=lambda pair: -pair[1][0].size,
    )[:MOST_DRAWN]
    parts = [100.0 * row.size for _, rows in shown for row in rows]
    if len(parts) < LEAST_ROWS:
        return None
    low, high = decades(parts)
    said, table = figure("figures_check", "moves", shown=shown)
    scale = Scale(low=low, high=high, kind="log", label=said.axis)
    drawn = rows_of(table, lambda at: [Bar(start=low, end=at.size)])
    return Chart(
        name="moves",
        title=said.title,
        panels=(ChartPanel(scale=scale, groups=drawn),),
        table=table,
        has_data=False,
        caption=said.caption,
    )


def moved(differences: Sequence[Difference]) -> list[tuple[str, Move]]:
    """Return what moved, each with the name of what it is in."""
    return [(one.first, move) for one in differences for move in one.moves]


def _because(move: Move) -> str:
    """Say which changes explain how much of a move."""
    because = [f"{one.key} {part}" for one, part in cause_texts(move)]
    if together := together_text(move):
        because.append(f"together {together}")
    return "; ".join(because)


written(
    "difference_moved",
    """
    subject = item.subject: what it is of, 'gyro.bias.x', 'hg4930.yaml#C gyro'
    quantity = item.quantity: 'standard_uncertainty', 'verdict', ...
    partner = item.partner: a source, or the other output of a correlation
    unit: of a number
    before: null where there was none
    after: null where there is none
    difference [unit]: null of words
    relative [1]: difference over the value before
    sampled = is_sampled: whether another seed gives another value
    times [1]: difference over its tolerance or, of a sampled number, over the standard
      error of a difference
    causes not in CSV: changes that explain some of it
    together not in CSV [unit]: what all changes do at once beyond the sum of what each
      does alone
    because: in words, which changes explain it
    """,
    because=_because,
)(Move)
written(
    "moved",
    """
    reference = 0 (str): in which
    *1 as difference_moved
    """,
    said="One number or word that is not what it was.",
)(tuple)
written(
    "difference",
    """
    first: how it is called
    second
    kind = job: 'analyze', 'mission', 'compare' or 'allocate'
    compared: how many numbers and words
    changes: of files, settings and versions
    moved = moves as difference_moved: the largest change first
    """,
    commands="diff",
)(Difference)
written(
    "check",
    """
    holds (bool): whether nothing moved and nothing is wrong with a reference
    references = 0 as reference (tuple[Difference, ...])
    moved as moved (tuple[Move, ...]): in all of them
    errors = 1 (list[str]): of references that are none
    """,
    said="Two budgets side by side: a reference and what it is now, or any two.",
    commands="check",
    holds=lambda found: not found[1] and all(one.holds for one in found[0]),
    moved=lambda found: moved(found[0]),
)(tuple)
