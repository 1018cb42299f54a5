"""What moved out of budget says where it is, and is there."""

from __future__ import annotations

import pytest

import budget
import budget.distributions
import jcgm


@pytest.mark.parametrize(
    ("module", "name"),
    [(budget, name) for name in sorted(budget.MOVED)]
    + [(budget.distributions, name) for name in budget.distributions.MOVED],
)
def test_a_name_that_moved_says_where_it_is(module, name):
    """The old place names the new one; a slip is a slip."""
    with pytest.raises(ImportError, match=rf"{name} is jcgm\.{name} now: `import j"):
        getattr(module, name)
    assert name in jcgm.__all__
    assert hasattr(jcgm, name)
    assert not hasattr(module, name + "s")
