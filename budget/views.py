"""The view of records: the module that prints and draws them, which `budget` names."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable

# Returns that module, and loads it when it is first asked to. It is of a floor above
# all who ask: `budget`, which knows all floors, puts it here.
view: Callable[[], Any]
