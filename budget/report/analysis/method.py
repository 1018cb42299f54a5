"""Method section of a report: settings, formulas, references."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from budget.calibration.schemes import scheme_of
from budget.model.estimators import FORMULAS, estimator_of
from budget.model.response import STATISTICS
from budget.model.source import Noise
from budget.model.sources import source_of
from budget.names import by_group, parameters_of
from budget.question import sensors_of
from budget.report.formulas import check_formula
from budget.report.pages import section
from budget.report.standing import error_reference
from budget.sentences import described
from budget.settings import further

if TYPE_CHECKING:
    from collections.abc import Collection

    from budget.inputs.records import Device, Procedure
    from budget.model.scheme import Scheme
    from budget.names import Name
    from budget.report.blocks import Section
    from budget.settings import Settings


@dataclass(frozen=True, kw_only=True)
class Trials:
    """Trials of Monte Carlo beside those of the method itself."""

    check: int  # of the law; 0 where it was not checked
    densities: int  # 0 where none is drawn


def method_section(
    settings: Settings,
    procedure: Procedure,
    devices: Collection[Device],
    trials: Trials,
    *,
    of_verdict: Settings,
    full: bool = True,
) -> Section:
    """Return settings and references, in full formulas; of the sensors there are."""
    has_weights = estimator_of(procedure.formulas) is not FORMULAS
    weighed = sensors_of(tuple(devices), procedure) if has_weights else ()
    noises: dict[str, str] = {}
    others: dict[str, str] = {}
    for sensor in (sensor for device in devices for sensor in device.sensors):
        for line in sensor.lines if full else ():
            source = source_of(sensor.kind, line.name).meant(line)
            effect = source.effect
            if source.origin:
                check_formula(source)
            if effect.formula:
                said = noises if isinstance(effect, Noise) else others
                said[effect.formula] = described(effect.letters)
    return section(
        "method",
        full=full,
        settings=settings,
        trials=trials,
        of_verdict=of_verdict,
        error_reference=error_reference,
        further=further(settings),
        by_group=by_group,
        weights=[_weights(scheme_of(one.kind, procedure, one)) for one in weighed],
        noises=noises.items(),
        others=others.items(),
    )


@dataclass(frozen=True, kw_only=True)
class Weights:
    """W of one triad, a row for each window."""

    scheme: Scheme
    kind: str  # of what is weighed: 'windows', 'norm' of dwells or 'rotation'
    names: tuple[Name, ...]  # what columns of W are of, where it is not each axis alike
    columns: int  # of W
    # Windows, or parts of F, with the mean input and W; of an axis, '' where all agree.
    groups: tuple[tuple[str, list[tuple[str, list[float]]]], ...]

    @property
    def digits(self) -> int:
        """Digits to print: where there is room for them."""
        return 5 if self.columns == STATISTICS else 3


def _weights(scheme: Scheme) -> Weights:
    """Gather the weights of one triad."""
    (parts, by_axis), names = scheme.shown_weights(), ()
    if scheme.weighed != "windows" and scheme.held is not None:
        names = tuple(parameters_of(scheme.owner)[k] for k in scheme.held.estimated)
    return Weights(
        scheme=scheme,
        kind=scheme.weighed,
        names=names,
        columns=len(next(iter(by_axis.values()))),
        groups=tuple(
            (axis, [(name, [*u, *W[:, k]]) for k, (name, u) in enumerate(parts)])
            for axis, W in by_axis.items()
        ),
    )
