"""What a text says: its facts, in whatever sentence they stand."""

from __future__ import annotations

import re

MINUS = "\N{MINUS SIGN}"


def assert_says(text, *facts):
    """Assert that a text states facts: whole words, names and numbers with units.

    Blanks, line breaks, capitals and the kind of minus sign make no difference; a fact
    is no part of another: '9 %' is not in '19 %', nor '0.1 deg' in '0.1 deg/h'.
    """
    plain = " ".join(text.replace(MINUS, "-").split()).casefold()
    absent = [
        fact
        for fact in facts
        if not re.search(rf"(?<![\w.]){re.escape(fact.casefold())}(?!/?\w|\.\w)", plain)
    ]
    assert absent == [], f"not said: {absent}, but: {plain}"
