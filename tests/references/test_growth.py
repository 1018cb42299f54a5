"""References of an older tool: what the tool has learnt since is no moved number."""

from __future__ import annotations

from dataclasses import replace

from budget.names import Name
from budget.references.difference import count_compared, find_moves
from budget.references.records import (
    KNOWN_FIRST,
    KNOWN_NOW,
    Number,
    Snapshot,
    Word,
)

BIAS = Name("bias", owner="gyro", axis="x")


def number(subject, *, partner="", value=1.0):
    """Return one number of a result."""
    return Number(
        subject=subject,
        quantity="contribution",
        partner=partner,
        unit="deg/h",
        value=value,
    )


def not_given(text):
    """Return the word on what a gyro does not give."""
    return Word(subject="gyro", quantity="not_given", text=text)


OLD = Snapshot(
    numbers=(number(BIAS, partner=Name("bias_stability", owner="gyro")),),
    words=(not_given("gyro.rate_random_walk"),),
    known=KNOWN_FIRST,
)
GROWN = Snapshot(
    numbers=(
        *OLD.numbers,
        number(BIAS, partner=Name("g_sensitivity", owner="gyro")),
        number(Name("non_orthogonality", owner="gyro", axis="xy")),
    ),
    words=(not_given("gyro.rate_random_walk, gyro.g_sensitivity"),),
)


def test_a_new_source_and_a_new_parameter_do_not_move_an_old_reference():
    """Neither counts as compared, and nothing has moved."""
    assert find_moves(OLD, GROWN) == ()
    assert count_compared(OLD, GROWN) == count_compared(OLD, OLD)


def test_what_the_tool_had_then_still_moves():
    """Control: a reference of a tool that knew the source sees it come."""
    knew = replace(OLD, known=KNOWN_NOW | {"non_orthogonality"})
    moved = {str(move.key) for move in find_moves(knew, GROWN)}
    assert moved == {
        "gyro.bias.x contribution gyro.g_sensitivity",
        "gyro.non_orthogonality.xy contribution",
        "gyro not_given",
    }


def test_a_line_that_is_gone_from_the_sheet_moves_an_old_reference():
    """Control: a line that was known and given then, and is not now, is a move."""
    gone = replace(
        GROWN,
        words=(not_given("gyro.rate_random_walk, gyro.bias_stability"),),
    )
    assert [move.key.quantity for move in find_moves(OLD, gone)] == ["not_given"]


def test_the_first_references_knew_eleven_sources():
    """What a reference without the word knew is part of what is known now."""
    assert KNOWN_FIRST < KNOWN_NOW
    assert len(KNOWN_FIRST) == 11 + 3


def test_a_word_on_a_new_source_does_not_move_an_old_reference():
    """The status of a line that the tool did not have then is not compared."""
    lines = [
        Word(subject=Name(source, owner="gyro"), quantity="status", text="free")
        for source in ("bias_stability", "g_sensitivity")
    ]
    old, grown = replace(OLD, words=lines[:1]), replace(OLD, words=lines)
    assert find_moves(old, grown) == ()
    assert len(find_moves(replace(old, known=KNOWN_NOW), grown)) == 1
