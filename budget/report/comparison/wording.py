"""A comparison in words: the answer, what it leaves open, and what to beware of."""

from __future__ import annotations

from typing import TYPE_CHECKING

from budget.language import counted, say, term, words
from budget.names import IMU, MISSION
from budget.report.comparison.tables import MissingEffect, what_is_judged
from budget.report.readings import verdict_line
from budget.report.tables import print_count, print_coverage, source_title
from budget.report.wording import (
    deciding_lines,
    doubt_sentence,
    error_reference,
    mode_remark,
    mode_sentence,
    standing_lines,
)
from budget.results import VERDICTS
from budget.studies.comparison.records import NUMBERED
from budget.studies.prediction import LEAST_DESIGNS

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from budget.names import Name
    from budget.report.comparison.tables import Ranking
    from budget.results import FilledLine
    from budget.studies.comparison.records import Comparison


def headline(comparison: Comparison) -> str:
    """State the answer in one line."""
    verdict = say("MET") if comparison.is_met else say("NOT MET")
    if _on_conditions(comparison):
        verdict = say("MET ON CONDITIONS")
    if comparison.not_compared:  # 'MET' alone would speak for what nobody judged
        verdict += say(
            " for the {required}",
            required=say(" and the ").join(map(what_is_judged, comparison.required)),
        )
    return say(
        "{verdict}: {requirement}{mode_remark}",
        verdict=verdict,
        requirement=comparison.requirement,
        mode_remark=mode_remark(comparison.settings),
    )


def _on_conditions(comparison: Comparison) -> bool:
    """Say whether each required sensor has a device, and one on conditions alone."""
    return not comparison.is_met and comparison.has(NUMBERED)


# By whether the mission alone has limits, and whether there is one; a device that
# meets, one that does so on conditions, none.
ANSWERS = {
    (False, False): (
        term("Each required sensor has a device that meets."),
        term("Each required sensor has a device that meets, on conditions at least."),
        term("A required sensor has no device that meets."),
    ),
    (False, True): (
        term("Each required sensor and the mission have a device that meets."),
        term(
            "Each required sensor and the mission have a device that meets, on "
            "conditions at least."
        ),
        term("A required sensor or the mission has no device that meets."),
    ),
    (True, True): (
        term("A device meets on the mission."),
        term("A device meets on the mission, on conditions."),
        term("No device meets on the mission."),
    ),
}


def answer(comparison: Comparison) -> str:
    """State the answer in a sentence."""
    if not comparison.not_compared:
        met, on_conditions, not_met = ANSWERS[
            comparison.required == (MISSION,), bool(comparison.mission)
        ]
        if _on_conditions(comparison):
            return say(on_conditions)
        return say(met if comparison.is_met else not_met)
    has_one = comparison.has(NUMBERED)
    if len(comparison.required) == 1:
        has = say("has a") if has_one else say("has no")
    else:
        has = say("each have a") if has_one else say("do not each have a")
    left = comparison.not_compared
    return say(
        "The {required} {has} device that meets, on conditions at least; the limits "
        "for the {left} are not judged: {reasons}."
        if _on_conditions(comparison)
        else "The {required} {has} device that meets; the limits for "
        "the {left} are not judged: {reasons}.",
        required=say(" and the ").join(map(what_is_judged, comparison.required)),
        has=has,
        left=say(" and the ").join(map(words, left)),
        reasons=say(", ").join(dict.fromkeys(map(_why_not_compared, left))),
    )


def basis(comparison: Comparison) -> str:
    """Say what the errors are."""
    settings = comparison.settings
    coverage = print_coverage(settings.coverage)
    said = say(
        "Errors at {coverage} % coverage; {error_references}.",
        coverage=coverage,
        error_references=error_reference(settings),
    )
    if comparison.mission:
        said += say(
            " On the mission {mission}: at the probability that a limit gives, where "
            "it gives one.",
            mission=comparison.mission,
        )
    if sentence := mode_sentence(settings):
        said += say(
            " {sentence} The exit code goes by given lines alone.", sentence=sentence
        )
    return said


def computed_apart(comparison: Comparison) -> str:
    """Say how a comparison inside a report was computed, and why numbers differ."""
    settings = comparison.settings
    how = say("by the law of propagation of uncertainty (JCGM 100)")
    if settings.trials is not None:
        how = say(
            "by Monte Carlo (JCGM 101) with {trials} trials of each device",
            trials=print_count(settings.trials),
        )
        most = max((one.trials or 0 for one in comparison.devices), default=0)
        if most > settings.trials:
            how += say(
                ", up to {most} where a verdict or a rank was open",
                most=print_count(most),
            )
    return say(
        "Computed apart from page one, {how}, seed {seed}, so its "
        "numbers can differ from those of page one in the last "
        "digits.",
        how=how,
        seed=settings.seed,
    )


def verdict_lines(found: Sequence[Ranking]) -> tuple[str, ...]:
    """Say for each sensor and procedure who is best, or that nobody meets."""
    lines = []
    for table in found:
        best = table.best
        said = say("no device meets")
        if best is not None:
            said = say(
                "{device} is best, {utilisation} % of the limit",
                device=best.device,
                utilisation=best.utilisation,
            )
        lines.append(
            say(
                "{sensor}{under}: {said} ({counts})",
                sensor=what_is_judged(table.sensor),
                under=table.under,
                said=said,
                counts=table.counts,
            )
        )
        likely = next((row for row in table.rows if row.of.doubt is not None), None)
        if likely is not None and likely.of.doubt is not None:
            lines.append(
                say(
                    "{sensor}{under}, by predicted lines: {device} {doubt_sentence}",
                    sensor=what_is_judged(table.sensor),
                    under=table.under,
                    device=likely.device,
                    doubt_sentence=doubt_sentence(likely.of.doubt, of=table.sensor),
                )
            )
    return tuple(lines)


def nothing_known_line(table: Ranking) -> str:
    """Name the devices that no number can be given for; '' where there are none."""
    if not table.nothing_known:
        return ""
    names = say(", ").join(dict.fromkeys(table.nothing_known))
    return say(
        "nothing is known of {names}: no error line of the "
        "{sensor} is given, so nothing is computed and the verdict "
        "is undecidable",
        names=names,
        sensor=what_is_judged(table.sensor),
    )


def not_compared_lines(comparison: Comparison) -> tuple[str, ...]:
    """Say of which sensors limits are judged for no device."""
    return tuple(
        say(
            "{sensor}: limits not judged, {why_not_compared}",
            sensor=what_is_judged(sensor),
            why_not_compared=_why_not_compared(sensor),
        )
        for sensor in comparison.not_compared
    )


def _why_not_compared(sensor: str) -> str:
    """Say why limits are judged for no device."""
    if sensor == IMU:
        return say("no device here has both triads and their angles estimated")
    if sensor == MISSION:
        return say("no device here has gyro and accelerometer")
    return say("no device here has one")


def undecidable_lines(comparison: Comparison) -> Iterator[str]:
    """Say of each sensor how many devices would meet, were nothing missing."""
    for sensor in comparison.required:
        names = {
            one.name
            for one in comparison.devices
            if one.sensor == sensor and one.verdict == "undecidable" and one.missing
        }
        if names:
            yield (
                counted(
                    len(names),
                    "{number} {sensor} device would meet, but lacks a line that "
                    "a verdict needs: undecidable",
                    "{number} {sensor} devices would meet, but lack lines that "
                    "a verdict needs: undecidable",
                    number=len(names),
                    sensor=what_is_judged(sensor),
                )
            )


def rests_on_others_lines(comparison: Comparison) -> Iterator[str]:
    """Say of each sensor how many verdicts rest on lines of other devices."""
    mode = comparison.settings.missing
    for sensor in comparison.required:
        names = {
            one.name
            for one in comparison.devices
            if one.sensor == sensor and one.rests_on_others and not one.is_bound
        }
        if names:
            verb = (
                say(
                    "the verdict on 1 {sensor} device rests",
                    sensor=what_is_judged(sensor),
                )
                if len(names) == 1
                else say(
                    "the verdicts on {names} {sensor} devices rest",
                    names=len(names),
                    sensor=what_is_judged(sensor),
                )
            )
            yield say(
                "{verb} on lines of other devices (missing lines: {mode})",
                verb=verb,
                mode=mode,
            )


def reading_lines(comparison: Comparison) -> Iterator[str]:
    """Say of each device whose lines are open under which readings it meets."""
    several = len(comparison.procedures) > 1
    for one in comparison.devices:
        if one.readings is not None:
            under = say(", {procedure}", procedure=one.procedure) if several else ""
            yield say(
                "the {sensor} of {name}{under} {verdict_line}",
                sensor=what_is_judged(one.sensor),
                name=one.name,
                under=under,
                verdict_line=verdict_line(one.readings),
            )


def standing_effects(comparison: Comparison) -> tuple[MissingEffect, ...]:
    """Return what the verdicts hold if, and whom to ask for what.

    Decided ones first, of devices that do not fail in any case; those with the same
    words in one.
    """
    names: dict[tuple[str, str], list[str]] = {}
    for one in sorted(comparison.entrants, key=lambda one: VERDICTS.index(one.verdict)):
        is_beyond = one.standing.saturates
        lines = (deciding_lines if is_beyond else standing_lines)(one.standing)
        effect = say("; ").join(lines)
        if effect and (one.verdict != "fails" or is_beyond):
            names.setdefault((one.sensor, effect), []).append(one.name)
    return tuple(
        MissingEffect(
            sensor=sensor, devices=tuple(dict.fromkeys(devices)), effect=effect
        )
        for (sensor, effect), devices in names.items()
    )


def missing_effects(comparison: Comparison) -> tuple[MissingEffect, ...]:
    """Return what stands for lines that are not given.

    Those with the same lines in one.
    """
    names: dict[
        tuple[str, tuple[Name, ...], tuple[FilledLine, ...], bool], list[str]
    ] = {}
    for one in comparison.entrants:
        if one.missing is not None:
            key = (
                one.sensor,
                one.missing.lines,
                one.missing.filling.lines,
                bool(one.technology),
            )
            names.setdefault(key, []).append(one.name)
    found = []
    predicted = comparison.settings.missing == "predict"
    for (sensor, lines, assumed, of_known), devices in names.items():
        if not assumed:
            why = say(
                "no {nobody} gives it"
                if len(lines) == 1
                else "no {nobody} gives them all",
                nobody=say(NOBODY[predicted], number=LEAST_DESIGNS),
            )
            if not (predicted or of_known):
                why = say(NO_TECHNOLOGY)
            effect = say(
                "{lines} not given, and {why}: nothing is known",
                lines=say(", ").join(source_title(name) for name in lines),
                why=why,
            )
        else:
            effect = say(", ").join(
                say(
                    "{source} {line} ({basis})",
                    source=source_title(line.source, of=sensor),
                    line=line.printed,
                    basis=say(line.origin),
                )
                for line in assumed
            )
            met = {line.expected for line in assumed}
            if left := [source_title(name) for name in lines if name not in met]:
                effect += say("; {left}: nothing is known", left=say(", ").join(left))
        found.append(
            MissingEffect(
                sensor=sensor, devices=tuple(dict.fromkeys(devices)), effect=effect
            )
        )
    return tuple(found)


# Why no device of the catalogue is comparable.
NO_TECHNOLOGY = term(
    "the data sheet names no `technology` by which others are comparable"
)
# Who would have to give a line that nothing stands for; where lines are predicted.
NOBODY = {
    False: term("device of the catalogue of the same technology and grade"),
    True: term("{number} designs of the catalogue"),
}
MISSING_NOTES = {
    "refuse": (
        term(
            "Lines that a verdict needs and a data sheet does not give count as "
            "0; at worst they are what the worst device of the catalogue of the "
            "same technology and grade has; where there is none, nothing is "
            "known. Of devices that fail in any case nothing is assumed."
        )
    ),
    "worst": (
        term(
            "Lines that a verdict needs and a data sheet does not give are what "
            "the worst device of the catalogue of the same technology and grade "
            "has."
        )
    ),
    "typical": (
        term(
            "Lines that a verdict needs and a data sheet does not give are the "
            "median of the devices of the catalogue of the same technology and "
            "grade."
        )
    ),
    "predict": (
        term(
            "Lines that a verdict needs and a data sheet does not give are "
            "random: their joint distribution is predicted from the given lines "
            "of the device and of the catalogue. Printed are the median and, in "
            "brackets, the central 90 %."
        )
    ),
}


def missing_note(mode: str) -> str:
    """Say what stands in the place of lines that are not given."""
    return say(MISSING_NOTES[mode])


def advice_lines(comparison: Comparison) -> tuple[str, ...]:
    """Return the advice there is, each once, with the devices that it is for."""
    names: dict[str, list[str]] = {}
    for one in comparison.devices:
        if one.advice:
            names.setdefault(one.advice, []).append(
                say(
                    "{name} ({sensor})",
                    name=one.name,
                    sensor=what_is_judged(one.sensor),
                )
            )
    return tuple(
        say(
            "{devices}: {advice}",
            devices=say(", ").join(dict.fromkeys(of)),
            advice=say(advice),
        )
        for advice, of in names.items()
    )


def cap_lines(comparison: Comparison) -> tuple[str, ...]:
    """Say which devices exceed a cap; a cap sets no verdict."""
    return tuple(
        dict.fromkeys(
            say("{name}: {text}", name=one.name, text=say(text))
            for one in comparison.entrants
            for text in one.over_caps
        )
    )


def unknown_cap_lines(comparison: Comparison) -> tuple[str, ...]:
    """Say of each cap of which devices nobody knows whether they exceed it.

    'mass, at most 2 kg: not given for NAME, OTHER', 'price, ...: given for no device'.
    """
    number = len({one.place for one in comparison.entrants})
    lines = []
    for merit, cap in comparison.caps:
        texts = {  # one for both sensors of a device, under every procedure
            one.place: (one.name, unknown.text)
            for one in comparison.entrants
            for unknown in one.unknown_caps
            if unknown.merit == merit
        }
        if not texts:
            continue
        named = [
            say(
                "{name} ({text!r}, which cannot be held against it)",
                name=name,
                text=text,
            )
            if text
            else name
            for name, text in texts.values()
        ]
        given = any(text for _, text in texts.values())
        said = say(
            "not known for {devices}" if given else "not given for {devices}",
            devices=say(", ").join(dict.fromkeys(named)),
        )
        if len(texts) == number > 1 and not given:
            said = say("given for no device")
        lines.append(
            say("{merit}, at most {cap}: {said}", merit=say(merit), cap=cap, said=said)
        )
    return tuple(lines)
