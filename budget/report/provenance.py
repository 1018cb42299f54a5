"""Provenance section: version, command, seed, hashes of inputs; sign-off."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.report.pages import section
from budget.version import __version__

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.report.blocks import Section
    from budget.results import InputFile
    from budget.settings import Settings


def provenance_section(
    inputs: Sequence[InputFile], settings: Settings | None = None, *, command_line: str
) -> Section:
    """Return what it takes to make the report again.

    The command line comes without output names and without what changes no number.
    Where nothing can be set `settings` is None.
    """
    return section(
        "provenance",
        inputs=inputs,
        settings=settings,
        version=__version__,
        command_line=command_line,
    )


def endings(
    inputs: Sequence[InputFile], settings: Settings | None = None, *, command_line: str
) -> tuple[Section, Section]:
    """Return the provenance, and the lines on which those who answer for it sign."""
    provenance = provenance_section(inputs, settings, command_line=command_line)
    return provenance, section("sign_off")
