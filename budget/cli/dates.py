"""The date that a document bears."""

from __future__ import annotations


def document_date() -> str:
    """Return today's date, or that of SOURCE_DATE_EPOCH where it is set."""
    import os
    from datetime import UTC, datetime

    from budget.errors import CallError

    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    if epoch is None:
        return datetime.now().astimezone().date().isoformat()
    try:
        return datetime.fromtimestamp(int(epoch), tz=UTC).date().isoformat()
    except (ValueError, OverflowError, OSError):
        raise CallError(
            f"SOURCE_DATE_EPOCH is {epoch!r}, expected seconds since 1970 as a whole "
            "number; unset it to use today's date"
        ) from None
