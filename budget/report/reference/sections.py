"""Reference budgets as sections: what holds, what moved, the largest first."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import floor, inf, log10
from typing import TYPE_CHECKING

from budget.language import counted, key_title, say, term, words
from budget.references.difference import TOOL
from budget.report.blocks import (
    Cell,
    Field,
    Listing,
    Panel,
    Paragraph,
    Section,
    table_of,
)
from budget.report.tables import (
    AT_LEAST,
    AT_MOST,
    PLAIN_BELOW,
    round_value,
    source_title,
)
from budget.report.wording import points
from budget.studies.request import read_name

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from budget.references.difference import Change, Difference, Move
    from budget.report.blocks import Block

# What a reader looks at first; the other numbers follow from what moves these.
PRINCIPAL = (
    "standard_uncertainty",
    "mean",
    "utilisation",
    "conformance",
    "allowed",
    "cost",
)
TITLES = {
    "standard_uncertainty": term("u"),
    "interval_low": term("interval from"),
    "interval_high": term("interval to"),
}
OF_PARTNER = {
    "sobol_first": term("first-order index of {partner}"),
    "sobol_total": term("total index of {partner}"),
    "contribution": term("contribution of {partner}"),
    "correlation": term("correlation with {partner}"),
}
FALLING = {"interval_low", "conformance"}  # the worse, the smaller
MOST_ROWS = 24  # on a terminal
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
FEW = 0.03  # of a difference: what parts need not add up to, without a word [1]
VERDICTS = {True: term("unchanged"), False: term("MOVED")}
TOGETHER = term("together")
TOLERANCES, STANDARD_ERRORS = term("tol"), term("s.e.")
BOUNDS = (AT_LEAST, AT_MOST)
NONE = "-"
NOT_THERE = term("(not there)")


@dataclass(frozen=True, kw_only=True)
class Row:
    """One or more numbers that moved alike."""

    title: str  # what of which parameter: 'Gyro bias, u [deg/h]'
    before: str
    after: str
    change: str  # of the uncertainty of the output, or of the number itself
    times: str  # how many tolerances or standard errors
    because: str  # numbers of the changes
    labels: tuple[str, ...] = ()

    @property
    def label(self) -> str:
        """Name of the row; nothing where it stands for all axes."""
        if len(self.labels) in AXES and all(
            len(label) < AXIS and label.isascii() for label in self.labels
        ):
            return say("all")
        # The name of a procedure may have a comma.
        mark = say("; ") if "," in "".join(self.labels) else say(", ")
        return mark.join(self.labels)


@dataclass(frozen=True, kw_only=True)
class MoveTable:
    """What is shown of all moves, and how many are not."""

    rows: tuple[Row, ...]
    words: tuple[str, ...]  # 'Gyro: verdict: meets -> fails'
    rest: int


def check_sections(checks: Sequence[Difference], bad: int) -> tuple[Section, ...]:
    """Return one line for each reference, and all about those that moved.

    `bad` is how many references could not be computed.
    """
    moved = [one for one in checks if not one.holds]
    tables = [move_table(one.moves, one.changes) for one in moved]
    blocks: list[Block] = []
    if checks:
        blocks.append(
            table_of(
                checks,
                (
                    Field(head="", cell=lambda one: _strong(one, one.first)),
                    Field(
                        head="", cell=lambda one: _strong(one, say(VERDICTS[one.holds]))
                    ),
                    Field(head="", cell=_extent),
                ),
                name="references",
                caption=say("References and whether anything moved"),
            )
        )
    held = [
        say("{key}: {text}", key=one.first, text=text)
        for one in checks
        if one.holds
        for text in change_lines(
            [change for change in one.changes if change.where != TOOL], moved=False
        )
    ]
    if held:
        blocks.append(
            Panel(title=say("Changed, and nothing moved"), blocks=(_listing(held),))
        )
    tool = [
        f"{change.key} {say(change.before)} -> {say(change.after)}"
        for one in checks
        if one.holds
        for change in one.changes
        if change.where == TOOL
    ]
    if tool:
        said = say(
            "stored with other versions: {versions}",
            versions=say(", ").join(dict.fromkeys(tool)),
        )
        blocks.append(Paragraph(words=(said,), small=True))
    counts = [
        say("{number} unchanged", number=len(checks) - len(moved)),
        say("{number} moved", number=len(moved)),
    ]
    if bad:
        counts.append(say("{number} cannot be checked", number=bad))
    number = len(checks) + bad
    total = counted(
        number,
        "{number} reference: {counts}",
        "{number} references: {counts}",
        number=number,
        counts=say(", ").join(counts),
    )
    return (
        Section(name="references", title="", blocks=tuple(blocks)),
        *(
            Section(
                name=f"moved-{place}",
                title=say("{name}: what moved, the largest first", name=one.first),
                blocks=tuple(
                    _moves(one.changes, table, (say("stored"), say("now")), by=True)
                ),
            )
            for place, (one, table) in enumerate(zip(moved, tables, strict=True))
        ),
        *legend([row for table in tables for row in table.rows], by=True),
        Section(name="total", title=total, blocks=()),
    )


def difference_sections(difference: Difference) -> tuple[Section, ...]:
    """Return two budgets side by side, the largest change first."""
    table = move_table(difference.moves, difference.changes)
    first = Paragraph(
        words=(
            say(
                "A is {first}, B {second}.",
                first=difference.first,
                second=difference.second,
            ),
        )
    )
    return (
        Section(
            name="difference",
            title=say(
                "{moved} of {compared} numbers and words differ",
                moved=len(difference.moves),
                compared=difference.compared,
            ),
            blocks=(first, *_moves(difference.changes, table, ("A", "B"))),
        ),
        *legend(table.rows),
    )


def _listing(lines: Iterable[str], *, numbered: bool = False) -> Listing:
    """Return lines of text."""
    return Listing(items=points(lines), empty="", numbered=numbered)


def _strong(one: Difference, text: str) -> Cell:
    """Return a cell that stands out where a reference moved."""
    return Cell(text=text, strong=not one.holds)


def _extent(one: Difference) -> str:
    """Say how many numbers and words were compared."""
    if not one.holds:
        return say(
            "{moved} of {compared} numbers and words",
            moved=len(one.moves),
            compared=one.compared,
        )
    if not one.sampled:
        return say("{compared} numbers and words", compared=one.compared)
    return say(
        "{compared} numbers and words, {sampled} sampled",
        compared=one.compared,
        sampled=one.sampled,
    )


def _moves(
    changes: Sequence[Change],
    table: MoveTable,
    heads: tuple[str, str],
    *,
    by: bool = False,
) -> Iterator[Block]:
    """Yield what changed, numbered, and the moves that name these numbers."""
    if changes:
        lines = change_lines(changes, moved=bool(table.rows or table.words))
        named = len(lines) - (_idle(changes) > MOST_IDLE)
        yield Panel(
            title=say("What changed"),
            blocks=(_listing(lines[:named], numbered=True),),
        )
        for text in lines[named:]:
            yield Paragraph(words=(say("{text}.", text=text),), small=True)
    blocks: list[Block] = []
    if table.words:
        blocks.append(_listing(table.words))
    if table.rows:
        before, after = heads
        fields: list[Field[Row]] = [
            Field(head="", cell=lambda row: row.label),
            Field(head=before, kind="number", cell=lambda row: row.before),
            Field(head=after, kind="number", cell=lambda row: row.after),
            Field(head=say("change"), kind="number", cell=lambda row: row.change),
        ]
        if by:
            fields.append(
                Field(head=say("by"), kind="number", cell=lambda row: row.times)
            )
        fields.append(Field(head=say("because"), cell=lambda row: row.because))
        blocks.append(
            table_of(
                table.rows,
                fields,
                name="moves",
                caption=say("Numbers that moved, the largest first"),
                by=lambda row: row.title,
                titled=True,
            )
        )
    if table.rest:
        more = say("And {rest} more numbers, all in --json.", rest=table.rest)
        blocks.append(Paragraph(words=(more,), small=True))
    if blocks:
        yield Panel(title=say("What moved"), blocks=tuple(blocks))


def legend(rows: Sequence[Row], *, by: bool = False) -> tuple[Section, ...]:
    """Explain the columns that are there, once for all."""
    if not rows:
        return ()
    text = say(
        "change: of the standard uncertainty of the output, or of the number itself "
        "where it belongs to none. because: numbers of the changes above, with the "
        "part of the difference that each explains alone, by the law."
    )
    if any(say(TOGETHER) in row.because for row in rows):
        text += say(
            " together: what all changes do at once beyond the sum of these parts."
        )
    if by and any(row.times.endswith(say(TOLERANCES)) for row in rows):
        text += say(" tol: times the tolerance, 1e-9 relative or rounding.")
    if by and any(row.times.endswith(say(STANDARD_ERRORS)) for row in rows):
        text += say(" s.e.: standard errors of a difference between two seeds.")
    if any(pair.startswith(BOUNDS) for row in rows for pair in (row.before, row.after)):
        text += say(
            " >=, <=: this or worse, as a line is not given that would add to it."
        )
    meaning = Paragraph(words=(text,), small=True)
    title = say("What the columns mean")
    return (Section(name="legend", title=title, blocks=(meaning,)),)


def move_table(moves: Sequence[Move], changes: Sequence[Change] = ()) -> MoveTable:
    """Choose and group the moves to be shown, the largest first.

    Titles stand by their largest change, rows under a title too; axes whose rows say
    the same are one row. Where principal numbers moved (u, mean, a verdict), those that
    follow from them are only counted.
    """
    worded = [m for m in moves if isinstance(m.before or m.after, str)]
    numbers = [m for m in moves if not isinstance(m.before or m.after, str)]
    first = [move for move in numbers if move.item.quantity in PRINCIPAL]
    chosen = sorted(first or numbers, key=lambda move: -move.size)[:MOST_ROWS]
    rows: dict[Row, list[str]] = {}
    for move in chosen:
        label = _split(move.item.subject)[1]
        rows.setdefault(_row(move, changes), []).append(label)
    titles = list(dict.fromkeys(row.title for row in rows))
    return MoveTable(
        rows=tuple(
            replace(row, labels=tuple(rows[row]))
            for row in sorted(rows, key=lambda row: titles.index(row.title))
        ),
        words=tuple(
            say(
                "{key}: {text}",
                key=_word_title(m),
                text=f"{_word(m.before)} -> {_word(m.after)}",
            )
            for m in worded
        ),
        rest=len(numbers) - len(chosen),
    )


def change_lines(changes: Sequence[Change], *, moved: bool) -> tuple[str, ...]:
    """Say each change; of those that move nothing only the first, and how many.

    Where a number `moved`, a key that does nothing alone may have done it with another.
    """
    lines = []
    idle = 0
    alone = ""
    for change in changes:
        remark = ""
        if change.acts is False:
            idle += 1
            may = moved and not change.is_text and change.where != TOOL
            remark = say(" (alone moves no number)" if may else " (moves no number)")
            if may and idle > MOST_IDLE:
                alone = say("alone ")
        elif change.acts is None and change.where != TOOL:
            remark = say(" (cannot be tried alone)")
        if idle <= MOST_IDLE:
            lines.append(f"{_said(change)}{remark}")
    if idle > MOST_IDLE:
        lines.append(
            say(
                "and {rest} more that {alone}move no number, in --json",
                rest=idle - MOST_IDLE,
                alone=alone,
            )
        )
    return tuple(lines)


def _idle(changes: Sequence[Change]) -> int:
    """Count the changes that alone move no number."""
    return sum(change.acts is False for change in changes)


def _said(change: Change) -> str:
    """Say a change in one line; a key of a file and what it is set to stay."""
    kind, _, name = change.where.partition(" ")
    before, after = (
        say(text or NOT_THERE)
        if change.where == TOOL or text in {"", "there"}
        else text
        for text in (change.before, change.after)
    )
    return say(
        "{where}: {key}: {before} -> {after}",
        where=f"{say(kind)} {name}".strip(),
        key=say(change.key) if change.where == TOOL else change.key,
        before=before,
        after=after,
    )


def cause_texts(move: Move) -> tuple[tuple[Change, str], ...]:
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


def _row(move: Move, changes: Sequence[Change]) -> Row:
    """Return the row of one move, without its label."""
    if isinstance(move.before, float) and isinstance(move.after, float):
        pair = print_pair(move.before, move.after)
    else:
        pair = (_word(move.before), _word(move.after))
    sign = AT_MOST if move.item.quantity in FALLING else AT_LEAST
    before, after = (
        f"{sign} {text}" if bound else text
        for text, bound in zip(pair, move.bounds, strict=True)
    )
    change = NONE
    ratio = 1.0 if move.relative is None else 1.0 + move.relative
    if ratio > FACTOR and move.scale == move.before:
        change = f"x {_two_digits(ratio)}"
    elif move.difference is not None and 100.0 * move.size < inf:
        sign = "-" if move.difference < 0.0 else "+"
        change = f"{sign}{_two_digits(100.0 * move.size)} %"
    times = NONE
    if move.times is not None:
        kind = STANDARD_ERRORS if move.is_sampled else TOLERANCES
        times = f"{_two_digits(move.times)} {say(kind)}"
    return Row(
        title=_title(move),
        before=before,
        after=after,
        change=change,
        times=times,
        because=_because(move, changes),
    )


def _because(move: Move, changes: Sequence[Change]) -> str:
    """Name the changes by their numbers, with their parts where there are several."""
    parts = [(changes.index(one) + 1, part) for one, part in cause_texts(move)]
    together = together_text(move)
    if len(parts) == 1 and parts[0][1] == ALL and not together:
        return str(parts[0][0])
    texts = [say("{key}: {text}", key=k, text=part) for k, part in parts[:NAMED]]
    if len(parts) > NAMED:
        texts.append("...")
    if together:
        texts.append(say("{key}: {text}", key=say(TOGETHER), text=together))
    return say(", ").join(texts) or NONE


def _title(move: Move) -> str:
    """Name the group of a move: 'Gyro bias, u [deg/h]'."""
    group, _ = _split(move.item.subject)
    kind = move.item.quantity
    quantity = say(TITLES[kind]) if kind in TITLES else words(kind)
    if move.item.partner:
        name = key_title if kind == "correlation" else source_title
        quantity = say(
            OF_PARTNER.get(kind, "{quantity} {partner}"),
            quantity=quantity,
            partner=name(read_name(move.item.partner)),
        )
    unit = f" [{move.unit}]" if move.unit not in {"", "1"} else ""
    # The name of a file stays as it is.
    title = group if " " in move.item.subject else group[:1].upper() + group[1:]
    return say("{title}, {quantity}{unit}", title=title, quantity=quantity, unit=unit)


def _word_title(move: Move) -> str:
    """Name a word that moved, and the device it is of: 'imu.yaml gyro, verdict'."""
    _, label = _split(move.item.subject)
    return f"{label} {_title(move)}" if " " in move.item.subject else _title(move)


def _split(subject: str) -> tuple[str, str]:
    """Return the group and the row that a subject belongs to."""
    device, _, text = subject.rpartition(" ")
    name = read_name(text)
    if not name.owner:
        return name, device
    if name.axis:
        return f"{device} {key_title(name.group)}".strip(), name.axis
    return f"{device} {say(name.owner)}".strip(), source_title(name)


def _word(value: float | str | None) -> str:
    """Show a word; a dash for what is not there."""
    if value is None or value == "":
        return NONE
    return say(value) if isinstance(value, str) else f"{value:.4g}"


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
