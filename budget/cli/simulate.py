"""`budget simulate`: the recording that a device would give."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from budget.cli import options
from budget.settings import Asked, Inputs, read_rate

if TYPE_CHECKING:
    from budget.recordings.simulated import SimulatedReadings


@options.asking("simulate")
def simulate(
    device: Annotated[
        str,
        typer.Argument(
            metavar="DEVICE",
            autocompletion=options.complete_device,
            help="Device file, FILE or FILE#VARIANT.",
        ),
    ],
    *,
    static: Annotated[
        str | None,
        options.judged(
            metavar="TIME",
            help="How long it rests, as '2 h', in the place of a test.",
            show_default=False,
        ),
    ] = None,
    means: Annotated[
        bool,
        options.judged(help="A table of the means of windows, and no recording."),
    ] = False,
    blunder: Annotated[
        list[str] | None,
        options.judged(
            metavar="NAME[=WHAT]",
            help="A mistake that is made in the test, as earth_rate_sign, "
            "latitude='39.9 deg', window_face='7:x up', axes_swapped=xy; may be given "
            "again.",
            show_default=False,
        ),
    ] = None,
    rate: Annotated[
        float | None,
        options.judged(
            parser=options.reading(read_rate),
            metavar="HZ",
            help="Sampling rate (the procedure's).",
            show_default=False,
        ),
    ] = None,
    inputs: Inputs,
    asked: Asked,
    output: Annotated[
        Path,
        options.written(
            "-o",
            "--output",
            metavar="FILE.csv",
            help="Recording to write; - writes to stdout.",
            show_default=False,
        ),
    ],
    truth: Annotated[
        Path | None,
        options.written(
            metavar="FILE.yaml", help="Write what was drawn.", show_default=False
        ),
    ] = None,
    out: options.OutputFiles,
) -> None:
    """Write the recording that a device would give, at rest or in a calibration.

    With --static body axes to east, north and up, from noise and the constants of one
    turn-on as the device file gives them; temperature stays as it is. Without it the
    windows of the procedure with the moves between them, and what station and
    environment are not known to. The same seed gives the same bytes, another one
    another unit.
    """
    from budget.cli.output import check_destinations, hand_out
    from budget.cli.streams import talk
    from budget.errors import CallError
    from budget.inputs import load_device
    from budget.recordings.simulated import simulated_recording
    from budget.recordings.simulated_run import simulated_run
    from budget.report.simulated import simulated_answer, truth_yaml

    for path, suffixes in ((output, (".csv",)), (truth, (".yaml", ".yml"))):
        if path in {None, options.STDOUT} or path.suffix.lower() in suffixes:
            continue
        raise CallError(f"{path}: expected a name that ends in {suffixes[0]}")
    files = [path for path in (output, truth) if path is not None]
    check_destinations(None, None, *files, inputs=[device, *inputs.files])
    if files.count(options.STDOUT) > 1:
        raise CallError("-o - and --truth - would both write to stdout; name a file")
    if static is not None and (means or blunder or inputs.station is not None):
        raise CallError(
            "--means, --blunder and --station are of a calibration, and --static of a "
            "unit at rest; leave one or the others out"
        )
    unit = load_device(device, inputs.changes)
    made: SimulatedReadings
    if static is not None:
        made = simulated_recording(
            unit, static=static, rate=rate, inputs=inputs, asked=asked
        )
    else:
        made = simulated_run(
            unit,
            means=means,
            rate=rate,
            blunders=blunder or (),
            inputs=inputs,
            asked=asked,
        )
    for name in made.not_in_it if options.STDOUT in files else ():
        talk(f"warning: {name} is not given: nothing of it is in the recording")
    hand_out(
        [(truth, lambda: truth_yaml(made)), (output, made.csv)],
        lambda: simulated_answer(made, name=output.name),
        language=out.language,
    )
