"""How the numbers were made: settings, formulas, the documents they are from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from budget.report.analysis.calibration_formulas import (
    PAPER,
    accelerometer_panel,
    gyro_bias_panel,
    notation,
    turns_panel,
)
from budget.report.analysis.propagation_formulas import (
    coverage_panel,
    indices_panel,
    law_panel,
    noise_panel,
)
from budget.report.blocks import Listing, Pairs, Panel, Paragraph, Section
from budget.report.tables import print_count, print_coverage, words
from budget.report.wording import (
    BY_LAW,
    INTERVALS,
    METHODS,
    REFERENCES,
    points,
)

if TYPE_CHECKING:
    from collections.abc import Collection

    from budget.report.blocks import Block, Words
    from budget.results import Settings
    from budget.spec.records import Device, Procedure

REFERENCE_LIST: tuple[str, ...] = (
    f"Zhao 2019: {PAPER}",
    "JCGM 100:2008, Guide to the expression of uncertainty in measurement (GUM)",
    (
        "JCGM 101:2008, Supplement 1 to the GUM: propagation of distributions by a "
        "Monte Carlo method"
    ),
    "JCGM 102:2011, Supplement 2 to the GUM: any number of output quantities",
    "IEEE Std 528-2019, Standard for Inertial Sensor Terminology",
    "NIMA TR8350.2, Department of Defense World Geodetic System 1984, third edition",
)
SOBOL_REFERENCE = "SALib: estimators of Sobol' indices after Saltelli et al. 2010"


@dataclass(frozen=True, kw_only=True)
class Trials:
    """Trials of Monte Carlo beside those of the method itself."""

    check: int  # of the law; 0 where it was not checked
    densities: int  # 0 where none is drawn


def method_section(
    settings: Settings,
    procedure: Procedure,
    devices: Collection[Device],
    sensors: Collection[str],
    trials: Trials,
) -> Section:
    """Return settings, formulas and references; of the sensors that are there."""
    panels: list[Block] = [
        Pairs(rows=_settings_rows(settings, trials)),
        Paragraph(words=notation()),
    ]
    if "gyro" in sensors:
        panels += [turns_panel(), gyro_bias_panel(procedure.formulas)]
    if "accelerometer" in sensors:
        panels.append(accelerometer_panel())
    lines = {
        line.name
        for device in devices
        for sensor in device.sensors
        for line in sensor.lines
    }
    panels += [law_panel(), coverage_panel(settings)]
    noise = noise_panel(lines)
    if noise is not None:
        panels.append(noise)
    references = REFERENCE_LIST
    if settings.sobol_samples is not None:
        panels.append(indices_panel())
        references += (SOBOL_REFERENCE,)
    panels.append(
        Panel(
            title="References",
            blocks=(Listing(items=points(references), empty="None."),),
        )
    )
    return Section(name="method", title="Method", blocks=tuple(panels))


def _settings_rows(settings: Settings, trials: Trials) -> tuple[tuple[str, Words], ...]:
    """Return what the result depends on besides the files."""
    kind = BY_LAW if settings.method == "gum" else INTERVALS[settings.interval]
    rows: list[tuple[str, str]] = [
        ("method", f"{settings.method}: {METHODS[settings.method]}"),
        ("trials", _trials_words(settings, trials)),
        ("seed", str(settings.seed)),
        ("coverage", f"{print_coverage(settings.coverage)} %"),
        ("interval", f"{settings.interval}: {kind}"),
        (
            "reference",
            f"{words(settings.reference)}: {REFERENCES[settings.reference]}",
        ),
    ]
    if settings.sobol_samples is not None:
        points_text = print_count(settings.sobol_samples)
        rows.append(
            (
                "Sobol' indices",
                f"{settings.sobol_scrambles} scrambles of {points_text} points",
            )
        )
    if settings.only:
        only = ", ".join(settings.only)
        rows.append(("only", f"{only}; all other lines are set to zero in this run"))
    return tuple((term, (text,)) for term, text in rows)


def _trials_words(settings: Settings, trials: Trials) -> str:
    """Say how many trials there were, and what for."""
    parts = []
    if settings.trials is not None:
        each = settings.normals_per_trial
        numbers = "" if each is None else f", {each} random numbers each"
        parts.append(f"{print_count(settings.trials)} for the budget{numbers}")
    if trials.check:
        sure = "one digit" if settings.digits == 1 else f"{settings.digits} digits"
        count = print_count(trials.check)
        parts.append(f"{count} to check the law, which makes {sure} of u sure")
    if trials.densities:
        parts.append(f"{print_count(trials.densities)} for the distributions")
    return "; ".join(parts) or "none"
