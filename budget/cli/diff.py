"""`budget diff`: two budgets side by side, and which input makes the difference."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from budget.cli import options

if TYPE_CHECKING:
    from budget.references.check import Side
    from budget.references.records import Asked, ReferenceBudget

SUFFIX = ".json"


def diff(
    first: Annotated[
        str,
        typer.Argument(
            metavar="A",
            help="A device file, FILE or FILE#VARIANT, or a stored reference.",
        ),
    ],
    second: Annotated[
        str, typer.Argument(metavar="B", help="What it is held against; as A.")
    ],
    *,
    procedure: Annotated[
        str | None,
        typer.Option(
            metavar="FILE",
            help="Procedure file of the devices (the paper's).",
            show_default=False,
        ),
    ] = None,
    coverage: options.Coverage = None,
    reference: options.Reference = None,
    only: options.Only = None,
    json: options.JsonFile = None,
    csv: options.CsvFile = None,
) -> None:
    """Set two budgets side by side, the largest change first.

    Largest is by the difference over A's standard uncertainty of the output; of a
    number that belongs to no output, over itself. Each difference is attributed to the
    inputs that differ: A's keys are exchanged one at a time for those of B, and the
    budget is computed by the law.

    A device is analyzed by the law; beside a reference, with the procedure, the
    requirement and the settings of that. The numbers of a reference are the stored
    ones. Exit code 0 whatever differs.
    """
    from budget.cli.output import check_destinations, hand_out
    from budget.errors import CallError
    from budget.references.check import compare_sides
    from budget.references.records import Asked
    from budget.report.reference.document import difference_json, differences_csv
    from budget.report.reference.sections import difference_sections

    check_destinations(json, csv, inputs=[first, second, procedure])
    stored = [_reference(name) for name in (first, second)]
    asked = Asked(coverage=coverage, reference=reference, only=tuple(only or ()))
    if any(stored) and (procedure or asked != Asked()):
        raise CallError(
            "a reference has its own procedure and settings, and a device beside it "
            "takes them; leave --procedure, --coverage, --reference and --only out"
        )
    model = next((one for one in stored if one is not None), None)
    difference = compare_sides(
        *(
            _side(name, own, model, procedure, asked)
            for name, own in zip((first, second), stored, strict=True)
        )
    )
    hand_out(
        [
            (json, lambda: difference_json(difference)),
            (csv, lambda: differences_csv([difference])),
        ],
        lambda: difference_sections(difference),
    )


def _reference(name: str) -> ReferenceBudget | None:
    """Read a stored reference; None where the name is of a device."""
    from budget.references.files import find_references, shipped_references
    from budget.references.store import read_reference
    from budget.spec.files import find

    ships = {one.shown for one in shipped_references()}
    is_bare = name in ships and not find(name, "device").path.is_file()
    if not (name.endswith(SUFFIX) or is_bare):
        return None
    (found,) = find_references(name)
    return read_reference(found.path, found.shown)


def _side(
    name: str,
    own: ReferenceBudget | None,
    model: ReferenceBudget | None,
    procedure: str | None,
    asked: Asked,
) -> Side:
    """Return one side: what is stored, or a device computed now."""
    from budget.errors import CallError
    from budget.references.check import make_reference, side_of
    from budget.references.files import take, take_procedures

    if own is not None:
        return side_of(own, name=name)
    if model is not None and model.job != "analyze":
        raise CallError(
            f"{name} is a device, and the reference beside it is of kind {model.job}; "
            "give two references of that kind, or one of kind analyze"
        )
    # Nothing is stored, so paths do not matter.
    inputs = [take("device", name)]
    if model is not None:
        inputs += [one for one in model.inputs if one.role != "device"]
        asked = model.settings
    else:
        inputs += take_procedures([procedure])
    made = make_reference("analyze", inputs, asked)
    return side_of(made, name=name, is_fresh=True)
