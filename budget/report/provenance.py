"""Provenance section: version, command, seed, hashes of inputs; sign-off."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.report.pages import sections

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.report.blocks import Section
    from budget.results import InputFile
    from budget.settings import Settings


def provenance_section(
    inputs: Sequence[InputFile],
    settings: Settings | None,
    *,
    version: str,
    command_line: str,
) -> Section:
    """Return what it takes to make the report again.

    The command line comes without output names and without what changes no number.
    Where nothing can be set `settings` is None.
    """
    (section,) = sections(
        "provenance",
        inputs=inputs,
        settings=settings,
        version=version,
        command_line=command_line,
    )
    return section


def sign_off_section() -> Section:
    """Return the lines on which those who answer for a report sign it."""
    (section,) = sections("sign_off")
    return section
