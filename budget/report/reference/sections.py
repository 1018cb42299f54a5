"""Reference budgets as sections: what holds, what moved, the largest first."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import floor, inf, log10
from typing import TYPE_CHECKING

from budget.names import key_title, words
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
    "standard_uncertainty": "u",
    "interval_low": "interval from",
    "interval_high": "interval to",
    "sobol_first": "first-order index of",
    "sobol_total": "total index of",
    "contribution": "contribution of",
    "correlation": "correlation with",
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
VERDICTS = {True: "unchanged", False: "MOVED"}
TOGETHER = "together"
TOLERANCES, STANDARD_ERRORS = "tol", "s.e."
BOUNDS = (AT_LEAST, AT_MOST)
NONE = "-"


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
        if len(self.labels) in AXES and all(len(label) < AXIS for label in self.labels):
            return "all"
        # The name of a procedure may have a comma.
        return ("; " if "," in "".join(self.labels) else ", ").join(self.labels)


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
                    Field(head="", cell=lambda one: _strong(one, VERDICTS[one.holds])),
                    Field(head="", cell=_extent),
                ),
                name="references",
                caption="References and whether anything moved",
            )
        )
    held = [
        f"{one.first}: {text}"
        for one in checks
        if one.holds
        for text in change_lines(
            [change for change in one.changes if change.where != TOOL], moved=False
        )
    ]
    if held:
        blocks.append(
            Panel(title="Changed, and nothing moved", blocks=(_listing(held),))
        )
    tool = [
        f"{change.key} {change.before} -> {change.after}"
        for one in checks
        if one.holds
        for change in one.changes
        if change.where == TOOL
    ]
    if tool:
        said = f"stored with other versions: {', '.join(dict.fromkeys(tool))}"
        blocks.append(Paragraph(words=(said,), small=True))
    counts = [f"{len(checks) - len(moved)} unchanged", f"{len(moved)} moved"]
    if bad:
        counts.append(f"{bad} cannot be checked")
    number = len(checks) + bad
    noun = "reference" if number == 1 else "references"
    return (
        Section(name="references", title="", blocks=tuple(blocks)),
        *(
            Section(
                name=f"moved-{place}",
                title=f"{one.first}: what moved, the largest first",
                blocks=tuple(_moves(one.changes, table, ("stored", "now"))),
            )
            for place, (one, table) in enumerate(zip(moved, tables, strict=True))
        ),
        *legend([row for table in tables for row in table.rows], "by"),
        Section(name="total", title=f"{number} {noun}: {', '.join(counts)}", blocks=()),
    )


def difference_sections(difference: Difference) -> tuple[Section, ...]:
    """Return two budgets side by side, the largest change first."""
    table = move_table(difference.moves, difference.changes)
    counted = f"{len(difference.moves)} of {difference.compared} numbers and words"
    first = Paragraph(words=(f"A is {difference.first}, B {difference.second}.",))
    return (
        Section(
            name="difference",
            title=f"{counted} differ",
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
    sampled = f", {one.sampled} sampled" if one.sampled else ""
    if one.holds:
        return f"{one.compared} numbers and words{sampled}"
    return f"{len(one.moves)} of {one.compared} numbers and words"


def _moves(
    changes: Sequence[Change], table: MoveTable, heads: tuple[str, str]
) -> Iterator[Block]:
    """Yield what changed, numbered, and the moves that name these numbers."""
    if changes:
        lines = change_lines(changes, moved=bool(table.rows or table.words))
        numbered = [text for text in lines if not text.startswith("and ")]
        yield Panel(title="What changed", blocks=(_listing(numbered, numbered=True),))
        for text in lines[len(numbered) :]:
            yield Paragraph(words=(f"{text}.",), small=True)
    blocks: list[Block] = []
    if table.words:
        blocks.append(_listing(table.words))
    if table.rows:
        before, after = heads
        fields: list[Field[Row]] = [
            Field(head="", cell=lambda row: row.label),
            Field(head=before, kind="number", cell=lambda row: row.before),
            Field(head=after, kind="number", cell=lambda row: row.after),
            Field(head="change", kind="number", cell=lambda row: row.change),
            Field(head="by", kind="number", cell=lambda row: row.times),
            Field(head="because", cell=lambda row: row.because),
        ]
        blocks.append(
            table_of(
                table.rows,
                [field for field in fields if before == "stored" or field.head != "by"],
                name="moves",
                caption="Numbers that moved, the largest first",
                by=lambda row: row.title,
                titled=True,
            )
        )
    if table.rest:
        more = f"And {table.rest} more numbers, all in --json."
        blocks.append(Paragraph(words=(more,), small=True))
    if blocks:
        yield Panel(title="What moved", blocks=tuple(blocks))


def legend(rows: Sequence[Row], by: str = "") -> tuple[Section, ...]:
    """Explain the columns that are there, once for all."""
    if not rows:
        return ()
    text = (
        "change: of the standard uncertainty of the output, or of the number itself "
        "where it belongs to none. because: numbers of the changes above, with the "
        "part of the difference that each explains alone, by the law."
    )
    if any(TOGETHER in row.because for row in rows):
        text += " together: what all changes do at once beyond the sum of these parts."
    if by and any(row.times.endswith(TOLERANCES) for row in rows):
        text += " tol: times the tolerance, 1e-9 relative or rounding."
    if by and any(row.times.endswith(STANDARD_ERRORS) for row in rows):
        text += " s.e.: standard errors of a difference between two seeds."
    if any(pair.startswith(BOUNDS) for row in rows for pair in (row.before, row.after)):
        text += " >=, <=: this or worse, as a line is not given that would add to it."
    words = Paragraph(words=(text,), small=True)
    return (Section(name="legend", title="What the columns mean", blocks=(words,)),)


def move_table(moves: Sequence[Move], changes: Sequence[Change] = ()) -> MoveTable:
    """Choose and group the moves to be shown, the largest first.

    Titles stand by their largest change, rows under a title too; axes whose rows say
    the same are one row. Where principal numbers moved (u, mean, a verdict), those that
    follow from them are only counted.
    """
    words = [m for m in moves if isinstance(m.before or m.after, str)]
    counted = [m for m in moves if not isinstance(m.before or m.after, str)]
    first = [move for move in counted if move.item.quantity in PRINCIPAL]
    chosen = sorted(first or counted, key=lambda move: -move.size)[:MOST_ROWS]
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
            f"{_word_title(m)}: {_word(m.before)} -> {_word(m.after)}" for m in words
        ),
        rest=len(counted) - len(chosen),
    )


def change_lines(changes: Sequence[Change], *, moved: bool) -> tuple[str, ...]:
    """Say each change; of those that move nothing only the first, and how many.

    Where a number `moved`, a key that does nothing alone may have done it with another.
    """
    lines = []
    idle = 0
    alone = ""
    for change in changes:
        note = ""
        if change.acts is False:
            idle += 1
            may = moved and not change.is_text and change.where != TOOL
            note = " (alone moves no number)" if may else " (moves no number)"
            if may and idle > MOST_IDLE:
                alone = "alone "
        elif change.acts is None and change.where != TOOL:
            note = " (cannot be tried alone)"
        if idle <= MOST_IDLE:
            lines.append(f"{change}{note}")
    if idle > MOST_IDLE:
        rest = idle - MOST_IDLE
        lines.append(f"and {rest} more that {alone}move no number, in --json")
    return tuple(lines)


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
        times = f"{_two_digits(move.times)} {kind}"
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
    texts = [f"{k}: {part}" for k, part in parts[:NAMED]]
    if len(parts) > NAMED:
        texts.append("...")
    if together:
        texts.append(f"{TOGETHER}: {together}")
    return ", ".join(texts) or NONE


def _title(move: Move) -> str:
    """Name the group of a move: 'Gyro bias, u [deg/h]'."""
    group, _ = _split(move.item.subject)
    quantity = TITLES.get(move.item.quantity, words(move.item.quantity))
    if move.item.partner:
        is_output = move.item.quantity == "correlation"
        name = key_title if is_output else source_title
        quantity = f"{quantity} {name(read_name(move.item.partner))}"
    unit = f" [{move.unit}]" if move.unit not in {"", "1"} else ""
    # The name of a file stays as it is.
    title = group if " " in move.item.subject else group[:1].upper() + group[1:]
    return f"{title}, {quantity}{unit}"


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
    return f"{device} {name.owner}".strip(), source_title(name)


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
