"""What each source alone would do if it were less or more, by the law."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from budget.model.sources import SENSORS
from budget.ties import first_largest

if TYPE_CHECKING:
    from budget.problem import Output
    from budget.studies.what_if import Outlook, WhatIf, WhatIfSource

FACTORS = (0.0, 0.5, 1.0, 2.0)  # on the standard uncertainty of the source [1]


@dataclass(frozen=True, kw_only=True)
class Step:
    """One size of one source, all others as they are."""

    factor: float  # [1]
    u: float  # standard uncertainty of the output [SI]
    expanded: float  # U, half the coverage interval [SI]
    utilisation: float | None  # the sensor's largest; None where nothing is required
    verdict: str  # of the sensor; '' where nothing is required


@dataclass(frozen=True, kw_only=True)
class SourceSteps:
    """One source in several sizes, seen at the output where its share is largest."""

    source: WhatIfSource
    output: Output
    share: float  # of the variance of that output as it is [1]
    lower_bound: bool  # a line that is not given would widen that output
    used_lower_bound: bool  # or an output of the sensor that has a limit
    steps: tuple[Step, ...]


def one_at_a_time(what_if: WhatIf) -> tuple[SourceSteps, ...]:
    """Change one source after another, each to nothing, half and twice its size.

    Parameters
    ----------
    what_if : WhatIf
        A budget as a function of its sources.

    Returns
    -------
    tuple of SourceSteps
        In the order of the sources.
    """
    present = what_if.evaluate({})
    rows = []
    for g, source in enumerate(what_if.sources):
        k = first_largest(present.share[:, g].tolist())
        output = what_if.outputs[k]
        owner = source.name.owner
        sensor = owner if owner in SENSORS else output.name.owner
        outlooks = [what_if.evaluate({source.name: factor}) for factor in FACTORS]
        rows.append(
            SourceSteps(
                source=source,
                output=output,
                share=float(present.share[k, g]),
                lower_bound=what_if.lower_bound[k],
                used_lower_bound=_is_used_lower_bound(what_if, sensor),
                steps=tuple(
                    _step(what_if, outlook, factor, k, sensor)
                    for factor, outlook in zip(FACTORS, outlooks, strict=True)
                ),
            )
        )
    return tuple(rows)


def _is_used_lower_bound(what_if: WhatIf, sensor: str) -> bool:
    """Whether the part of its limits that a sensor uses is that or more."""
    return any(
        lacks
        for output, limit, lacks in zip(
            what_if.outputs, what_if.limit, what_if.lower_bound, strict=True
        )
        if output.name.owner == sensor and limit is not None
    )


def _step(
    what_if: WhatIf, outlook: Outlook, factor: float, k: int, sensor: str
) -> Step:
    """Read one output and one verdict from an outlook."""
    verdict = next((s for s in outlook.sensors if s.sensor == sensor), None)
    return Step(
        factor=factor,
        u=float(outlook.u[k]),
        expanded=float(what_if.factor[k] * outlook.u[k]),
        utilisation=None if verdict is None else verdict.utilisation,
        verdict="" if verdict is None else verdict.verdict,
    )
