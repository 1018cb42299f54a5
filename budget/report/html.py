"""The report as one HTML page: what stands there; the words are in the template."""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees
from typing import TYPE_CHECKING

from budget.report import figures
from budget.report.document import to_json
from budget.report.indices import index_tables
from budget.report.inline import inline_svg
from budget.report.markup import (
    css_string,
    markup,
    page_environment,
    script_safe,
)
from budget.report.not_given import not_given_lines
from budget.report.tables import (
    SMALL_SHARE,
    Number,
    group_tables,
    output_title,
    print_causes,
    print_count,
    print_coverage,
    print_given,
    print_utilisation,
    round_value,
    source_title,
    words,
)
from budget.results import INTERACTION
from budget.spec.records import ANGLES, AXES
from budget.units import ARCSEC, DEG_PER_HOUR, MICRO_G
from budget.version import __version__

if TYPE_CHECKING:
    from collections.abc import Sequence

    from budget.arrays import Array
    from budget.report.tables import GroupTable
    from budget.results import Assessment, Budget, OutputAssessment
    from budget.spec.records import Device, ErrorLine, Procedure, Sensor

CAUSES = 5  # as many as a reader keeps in mind
NOMINAL_BIAS = {"gyro": ("deg/h", DEG_PER_HOUR), "accelerometer": ("ug", MICRO_G)}
SEVERITY = ("fails", "undecidable", "undecided", "meets")  # the first one is the page's

Effect = tuple[str, str, str]  # '79 %', 'gyro bias', '0.050 deg/h'


@dataclass(frozen=True, kw_only=True)
class Picture:
    """A figure on the page; its data are the shares of a group or the limits."""

    title: str
    svg: str
    group: GroupTable | None


@dataclass(frozen=True, kw_only=True)
class LimitRow:
    """One required output against its limit, as text."""

    title: str
    error: Number
    unit: str
    limit: str
    utilisation: Number
    is_within: bool
    by_monte_carlo: bool  # the law failed its check there


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """The verdict on one sensor, as text."""

    sensor: str
    verdict: str
    worst: LimitRow
    because: str  # shares of the variance of the worst output
    missing: tuple[str, ...]
    advice: str  # what would make it surer


@dataclass(frozen=True, kw_only=True)
class Cause:
    """One source, and what it makes of the variance of each parameter group."""

    title: str
    printed: str  # the line of the data sheet; '' where it has none
    effects: tuple[Effect, ...]


@dataclass(frozen=True, kw_only=True)
class InputLine:
    """One line of a data sheet with its figures by axis, as text."""

    line: ErrorLine
    u: str
    shape: str
    correlation_time: str


@dataclass(frozen=True, kw_only=True)
class SensorInputs:
    """The data sheet of one triad."""

    sensor: Sensor
    nominal_bias: str
    nominal_angle: str
    lines: tuple[InputLine, ...]


def render_html(
    budget: Budget,
    *,
    devices: tuple[Device, ...],
    procedure: Procedure,
    assessment: Assessment | None,
    date: str,
    sections: tuple[str, ...] = (),
) -> str:
    """Write the whole report as one page that needs nothing else.

    Parameters
    ----------
    budget : Budget
        The result.
    devices : tuple of Device
        Those that it is of.
    procedure : Procedure
        How they are calibrated.
    assessment : Assessment or None
        The budget against a requirement, where there is one.
    date : str
        As it shall stand on the page.
    sections : tuple of str
        Further sections as HTML, made by the renderers of their studies.

    Returns
    -------
    str
        The same bytes for the same arguments.
    """
    environment = page_environment()
    environment.filters |= {
        "words": words,
        "first_up": lambda text: text[:1].upper() + text[1:],
        "given": print_given,
        "count": print_count,
        "degrees": lambda angle: print_given(degrees(angle), digits=7),
    }
    groups = group_tables(budget)
    limits = (
        [_limit_row(budget, row) for row in assessment.outputs] if assessment else []
    )
    verdicts = _verdicts(budget, assessment)
    given = {verdict.verdict for verdict in verdicts}
    pictures = _pictures(groups, assessment)
    return environment.get_template("report.html.j2").render(
        budget=budget,
        coverage=print_coverage(budget.settings.coverage),
        devices=devices,
        procedure=procedure,
        assessment=assessment,
        overall=next((word for word in SEVERITY if word in given), ""),
        verdicts=verdicts,
        limits=limits,
        groups=groups,
        indices=index_tables(budget),
        causes=_causes(groups, devices, assessment),
        not_given=not_given_lines(budget.not_given, budget.settings.reference),
        sections=[markup(section) for section in sections],
        pictures=[(picture, markup(picture.svg)) for picture in pictures],
        inputs=[_inputs(sensor) for device in devices for sensor in device.sensors],
        date=date,
        version=__version__,
        document=markup(script_safe(to_json(budget))),
        css_string=lambda text: markup(css_string(text)),
    )


def _limit_row(budget: Budget, row: OutputAssessment) -> LimitRow:
    """Round one required output like its uncertainty."""
    output = budget.output(row.output.name)
    scale = row.output.si_per_unit
    error = row.largest_error / scale
    text = round_value(
        error,
        output.standard_uncertainty / scale,
        resolution=row.output.resolution / scale,
    )
    return LimitRow(
        title=output_title(row.output.name),
        error=Number(text=text, exact=error),
        unit=row.output.unit,
        limit=row.printed_limit,
        utilisation=Number(
            text=print_utilisation(row.utilisation), exact=row.utilisation
        ),
        is_within=row.is_within,
        by_monte_carlo=row.by_monte_carlo,
    )


def _verdicts(budget: Budget, assessment: Assessment | None) -> list[Verdict]:
    """Say of each sensor whether it meets, by which output, and because of what."""
    if assessment is None:
        return []
    rows = {row.output.name: row for row in assessment.outputs}
    return [
        Verdict(
            sensor=sensor.sensor,
            verdict=sensor.verdict,
            worst=_limit_row(budget, rows[sensor.worst_output]),
            because=print_causes(
                [
                    (source_title(part.source), part.share)
                    for part in budget.output(sensor.worst_output).contributions
                ]
            ),
            missing=tuple(source_title(name) for name in sensor.expected_missing),
            advice=sensor.advice,
        )
        for sensor in assessment.sensors
    ]


def _causes(
    groups: Sequence[GroupTable],
    devices: Sequence[Device],
    assessment: Assessment | None,
) -> list[Cause]:
    """Return the largest causes, each with what it makes of every group.

    Ranked by the largest share of a group's variance; with a requirement by that share
    of the group's utilisation, those of groups beyond their limits before all others.
    """
    weight = dict.fromkeys(
        (group.title for group in groups), 0.0 if assessment else 1.0
    )
    for required in assessment.outputs if assessment else ():
        title = output_title(required.output.name.rpartition(".")[0])
        weight[title] = max(weight[title], required.utilisation)
    printed = {
        f"{sensor.kind}.{line.name}": _as_meant(line)
        for device in devices
        for sensor in device.sensors
        for line in sensor.lines
    }
    effects: dict[tuple[str, str], list[tuple[tuple[bool, float], Effect]]] = {}
    for group in groups:
        for row in group.sources:
            share = row.share
            if share.exact >= SMALL_SHARE:
                u = max((cell.u for cell in row.cells), key=lambda u: u.exact)
                effect = (share.text, group.title, f"{u.text} {group.unit}")
                used = weight[group.title]
                found = ((used > 1.0, used * share.exact), effect)
                effects.setdefault((group.sensor, row.source), []).append(found)
    ranked = sorted(effects.items(), key=lambda item: max(item[1])[0], reverse=True)
    return [
        Cause(
            title=f"{sensor} {source_title(source)}",
            printed="" if source == INTERACTION else printed.get(source, ""),
            effects=tuple(effect for _, effect in sorted(found, reverse=True)),
        )
        for (sensor, source), found in ranked[:CAUSES]
    ]


def _as_meant(line: ErrorLine) -> str:
    """'0.06 deg/h, 3 sigma': a figure with its meaning, where not 1 sigma."""
    words = [line.printed]
    if line.meaning != "1 sigma":
        words.append(line.meaning)
    if line.definition not in {"", "sigma"}:
        words.append(line.definition.replace("_", " "))
    return ", ".join(words)


def _pictures(
    groups: Sequence[GroupTable], assessment: Assessment | None
) -> list[Picture]:
    """Draw the figures of the page: the limits first, then the causes."""
    pictures = []
    if assessment is not None:
        figure = figures.utilisation_dots(assessment)
        alt = figures.utilisation_alt(assessment)
        title = figures.utilisation_title(assessment)
        svg = inline_svg(figure, "utilisation", alt)
        pictures.append(Picture(title=title, svg=svg, group=None))
    for group in groups:
        name = f"{group.sensor}-{group.parameter}"
        svg = inline_svg(figures.share_bars(group), name, figures.share_alt(group))
        pictures.append(Picture(title=figures.share_title(group), svg=svg, group=group))
    return pictures


def _inputs(sensor: Sensor) -> SensorInputs:
    """Write the figures of one data sheet by axis."""
    unit, scale = NOMINAL_BIAS[sensor.kind]
    return SensorInputs(
        sensor=sensor,
        nominal_bias=f"{_by_axis(sensor.nominal_bias / scale)} {unit}",
        nominal_angle=f"{_by_axis(sensor.nominal_mounting_angle / ARCSEC)} arcsec",
        lines=tuple(
            InputLine(
                line=line,
                u=f"{_by_axis(line.u / line.si_per_unit)} {line.unit}",
                shape=", ".join(dict.fromkeys(d.name for d in line.distributions)),
                correlation_time=(
                    ""
                    if line.correlation_time is None
                    else f"{_by_axis(line.correlation_time)} s"
                ),
            )
            for line in sensor.lines
        ),
    )


def _by_axis(values: Array) -> str:
    """Write one number where the axes agree, else each with its axis."""
    texts = [print_given(float(value)) for value in values]
    if len(set(texts)) == 1:
        return texts[0]
    names = AXES if len(texts) == len(AXES) else ANGLES
    return ", ".join(f"{name} {text}" for name, text in zip(names, texts, strict=True))
