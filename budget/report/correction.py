"""The correction that a recorded calibration found, as code: C, Python, YAML."""

from __future__ import annotations

import json
from functools import cache
from typing import TYPE_CHECKING

from markupsafe import Markup

from budget.errors import CallError
from budget.names import ORDERS
from budget.recordings.columns import LIKE
from budget.resources import own_templates, template_environment
from budget.version import __version__

if TYPE_CHECKING:
    from pathlib import Path

    from jinja2.sandbox import SandboxedEnvironment

    from budget.arrays import Array
    from budget.recordings.calibrated import CompensationMatrix, RecordedCalibration

CORRECTIONS = {"python": "python.py", "c": "c.h", "yaml": "yaml.yaml"}


def _quoted(text: str) -> Markup:
    """Write a text in quotation marks, as it is: code has nothing to escape."""
    return Markup(json.dumps(text))  # noqa: S704 - no page


@cache
def _environment(_: Path | None) -> SandboxedEnvironment:
    """Return what fills templates of a folder in."""
    environment = template_environment(keep_trailing_newline=True)
    environment.filters["quoted"] = _quoted
    return environment


def correction_code(found: RecordedCalibration, *, to: str) -> str:
    """Write what turns readings of a unit into inputs, with its units.

    Parameters
    ----------
    to : str
        One of CORRECTIONS.

    Raises
    ------
    CallError
        It is none of them, or higher orders were found.
    """
    if to not in CORRECTIONS:
        raise CallError(f"to is {to!r}, allowed: {', '.join(CORRECTIONS)}")
    orders = sorted({x.parameter for x in found.outputs if x.parameter in ORDERS})
    if orders:
        raise CallError(
            f"{found.procedure} found {' and '.join(orders)}, and code is of bias and "
            "matrix alone; calibrate by a procedure without it, or take the values of "
            "--json"
        )
    sound = {True: "sound", False: "NOT SOUND", None: "soundness not known"}
    parts = (found.title, found.serial, found.date, found.procedure)
    said = ", ".join(json.dumps(one) for one in parts if one)
    head = f"{said}: {sound[found.is_sound]}; by budget {__version__} calibrate"
    template = _environment(own_templates()).get_template(
        f"correction/{CORRECTIONS[to]}.j2"
    )
    return template.render(
        said=Markup(head),  # noqa: S704 - no page
        matrices=[_matrix(one) for one in found.matrix],
    )


def _matrix(one: CompensationMatrix) -> dict[str, object]:
    """Return what a template is given of a triad."""
    return {
        "sensor": one.sensor,
        "reading": one.bias_unit,
        "input": LIKE[one.sensor],
        "bias": _digits(one.bias),
        "not_estimated": one.not_estimated,
        "rows": [_digits(row) for row in one.body_from_sensor],
    }


def _digits(values: Array) -> list[str]:
    """Write numbers to their last digit."""
    return [repr(float(x)) for x in values]
