"""What the reader lets pass, the engines compute: finite numbers, or words."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path

import pytest
from fuzz.effort import examples
from fuzz.grammar import FIXED, NUMBERS, leaves, random_of, replaced, trees, write
from hypothesis import given
from hypothesis import strategies as st
from places import put

import budget
from budget.errors import BudgetError

# Down to 1e-25 and up to 1e20, in whatever unit stands beside.
EXTREMES = ("0", "1e-25", "1e-12", "1e-6", "1", "30", "1e4", "1e9", "1e12", "1e20")
KEPT = {
    *FIXED,
    "meaning",
    "reading",
    "soak_points",
    "earlier",
}  # no number, or one of its place
REFERENCES = ("nominal", "as_tested", "next_turn_on")


def stretched(tree, seed):
    """Return a tree with every number of the grammar replaced by an extreme one."""
    random = random_of(seed)
    for path, value in leaves(tree):
        number, _, unit = str(value).partition(" ")
        if number in NUMBERS and not KEPT & {*path}:
            tree = replaced(tree, path, f"{random.choice(EXTREMES)} {unit}")
    return tree


def loaded(load, tree, seed):
    """Return the record of a tree, or None where it is refused."""
    with tempfile.TemporaryDirectory() as folder:
        path = put(Path(folder) / "file.yaml", write(tree, seed).text)
        try:
            return load(path)
        except BudgetError:
            return None


@pytest.mark.slow
def test_sound_files_give_finite_numbers_or_words():
    """No device and procedure that are read end in nan, in a warning or a traceback.

    One pair in three at least is computed, else this would say nothing.
    """
    computed = []

    @examples(60)
    @given(
        device=trees("device"),
        procedure=trees("procedure"),
        seed=st.integers(0, 2**32 - 1),
        extreme=st.booleans(),
        reference=st.sampled_from(REFERENCES),
    )
    def judge(device, procedure, seed, extreme, reference):
        if extreme:
            device, procedure = stretched(device, seed), stretched(procedure, seed)
        one = loaded(budget.load_device, device, seed)
        how = loaded(budget.load_procedure, procedure, seed)
        if one is None or how is None:
            return
        try:
            result = budget.analyze(
                one, procedure=how, reference=reference, validate=False
            )
        except BudgetError:
            return
        json.dumps(result.to_dict(), allow_nan=False)
        computed.append(extreme)

    judge()
    assert len(computed) > 20
    assert any(computed)
