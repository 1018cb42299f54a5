"""`budget validate` and `budget schema`: are my files right, and what may they say."""

from __future__ import annotations

from typing import Annotated, Literal

import typer

from budget.cli.streams import in_line, tell


def validate(
    files: Annotated[
        list[str], typer.Argument(metavar="FILE...", help="Files of any kind.")
    ],
) -> None:
    """Check files and say everything that is wrong in them, with positions."""
    from budget.cli.output import printing
    from budget.errors import Issue, SpecError
    from budget.spec import validate as check

    issues: list[Issue] = []
    for name in files:
        try:
            found = check(name)
        except SpecError as error:
            issues.extend(error.issues)
            continue
        with printing():
            tell(f"{in_line(name)}: {found.kind}, valid\n")
            for text in found.assumptions:
                tell(f"  assumed: {text}\n")
    if issues:
        raise SpecError(tuple(issues))


def schema(
    kind: Annotated[
        Literal["device", "procedure", "requirement", "costs", "reference"],
        typer.Argument(
            metavar="KIND", help="device, procedure, requirement, costs, reference"
        ),
    ],
) -> None:
    """Print the JSON Schema of a kind of file, for editors that complete and check."""
    from json import dumps

    from budget.cli.output import printing
    from budget.references.store import reference_schema
    from budget.spec import json_schema

    found = reference_schema() if kind == "reference" else json_schema(kind)
    with printing():
        typer.echo(dumps(found, indent=2, ensure_ascii=False))
