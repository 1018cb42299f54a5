"""`budget new`: a commented device file to begin with."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from budget.cli.streams import say_written, talk

STDOUT = Path("-")
_MEANINGS = "1 sigma, 3 sigma, typical, max, ..."
_OF = "allan_minimum: the lowest point of an Allan curve, or sigma"


def new(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE.yaml", help="The file to write; - writes to stdout."
        ),
    ],
    *,
    line: Annotated[
        list[str] | None,
        typer.Option(
            metavar="SENSOR.SPEC=VALUE",
            help="A specification, as gyro.bias_stability='0.5 deg/h', its value "
            "as a file has it; may be given again.",
            show_default=False,
        ),
    ] = None,
    name: Annotated[
        str | None,
        typer.Option(
            metavar="TEXT", help="Of the device (the file's).", show_default=False
        ),
    ] = None,
    source: Annotated[
        str,
        typer.Option(
            metavar="TEXT",
            help="The data sheet, with its revision.",
            show_default=False,
        ),
    ] = "",
    force: Annotated[
        bool, typer.Option("--force", help="Overwrite the file, if there is one.")
    ] = False,
) -> None:
    """Write a device file: the specifications given, the others as comments.

    Without --line it asks for the expected specifications where stdin and stderr are a
    terminal; elsewhere every one is a comment to fill in. A value with something wrong
    is refused as `budget validate` would, and nothing is written.
    """
    from budget.cli.output import hand_out
    from budget.errors import CallError
    from budget.inputs.blank import new_device, split_line
    from budget.inputs.files import exists
    from budget.report.files import check_targets, write_all

    if file != STDOUT:
        if file.suffix.lower() not in {".yaml", ".yml"}:
            raise CallError(f"{file}: a device file ends in .yaml; give it that name")
        if not force and exists(file):
            raise CallError(
                f"{file}: there is such a file, and it would be lost; give another "
                "name, or --force to overwrite it"
            )
        check_targets([file])
    title = name or (file.stem if file != STDOUT else "new device")
    lines: dict[tuple[str, str], str] = {}
    for text in line or ():
        sensor, key, value = split_line(text)
        if (sensor, key) in lines:
            raise CallError(f"--line {sensor}.{key} is given twice; give it once")
        lines[sensor, key] = value
    is_asked = sys.stdin is not None and sys.stdin.isatty() and sys.stderr.isatty()
    if not line and is_asked:
        title, source, lines = _ask(title, source)
    text = new_device(str(file), title, source, lines)
    if file == STDOUT:
        hand_out([(STDOUT, lambda: text)])
    else:
        write_all({file: text})
        say_written([file])


def _ask(name: str, source: str) -> tuple[str, str, dict[tuple[str, str], str]]:
    """Ask a person for the name, the data sheet and the expected lines."""
    from budget.errors import SpecError
    from budget.inputs.blank import new_device
    from budget.inputs.makers import printed_as
    from budget.inputs.tree import flow, scalar
    from budget.model.sources import SENSORS, lines_of

    talk("Values as printed, with their unit; Enter where a data sheet prints none.")
    name = _answer("Name of the device", name)
    source = _answer("Data sheet and revision", source)
    lines: dict[tuple[str, str], str] = {}
    for sensor in SENSORS:
        met: set[str] = set()
        for one in lines_of(sensor):
            # Of a bias instability flicker is another model, not another value.
            if not one.expected or one.expected in met or one.value == "flicker":
                continue
            talk(f"\n{sensor} {one.name}, {printed_as(one.name)}")
            while value := _answer(f"  value, such as 1 {one.like(sensor)}", ""):
                said = {"value": value}
                said["meaning"] = _answer(f"  meaning ({_MEANINGS})", "1 sigma")
                if one.value == "stability":
                    said["definition"] = _answer(f"  definition ({_OF})", "sigma")
                entry = {(sensor, one.name): flow(said, scalar)}
                try:
                    new_device(one.name, name, source, entry)
                except SpecError as error:
                    for issue in error.issues:
                        talk(f"  {issue.message}")
                    continue
                lines |= entry
                met.add(one.expected)
                break
    return name, source, lines


def _answer(question: str, usual: str) -> str:
    """Return what a person types; Enter is the usual answer."""
    from budget.errors import CallError

    shown = f" [{usual}]" if usual else ""
    talk(f"{question}{shown}: ", end="")
    text = sys.stdin.readline()
    if not text:
        raise CallError(
            "the answers ended before the questions, and nothing was written; answer "
            "each, with Enter where a data sheet prints none, or give --line"
        )
    return text.strip() or usual
