"""Words that stand in several sections, and small ways to make blocks of them."""

from __future__ import annotations

import string
from typing import TYPE_CHECKING

from budget.inputs.records import UNCALIBRATED
from budget.language import Note, counted, key_title, say, template, term, words
from budget.names import Name
from budget.report.blocks import Cell, Paragraph, Run
from budget.report.tables import (
    HALF_DIGIT,
    print_chance,
    print_share,
    source_title,
)
from budget.studies.verdicts import USE_OF
from budget.ties import settle

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from budget.report.blocks import Words
    from budget.report.formulas import Math
    from budget.report.tables import Number
    from budget.results import (
        Assessment,
        Doubt,
        OutputAssessment,
        Settings,
        Standing,
    )


METHODS = {
    "gum": term(
        "the law of propagation of uncertainty with second-order terms (JCGM 100)"
    ),
    "monte-carlo": term("propagation of distributions by Monte Carlo (JCGM 101)"),
    "simulation": term("simulation of the calibration, sample by sample"),
}
INTERVALS = {
    "symmetric": term("as much probability left out below as above"),
    "shortest": term("the shortest of that coverage"),
}
BY_LAW = term("mean \N{PLUS-MINUS SIGN} U, by the normal law")
ERROR_REFERENCES = {
    "nominal": (
        term(
            "errors are counted from the nominal values: a repeatability counts in full"
        )
    ),
    "as_tested": (
        term(
            "errors are counted from the values during this test: what the procedure "
            "alone adds; a repeatability cancels"
        )
    ),
    "next_turn_on": (
        term(
            "errors are counted from the values at a later, independent turn-on, which "
            "the navigation system will meet: a repeatability counts twice in variance"
        )
    ),
}
ON_ITS_WAY = term(
    "errors are counted from the values at any later turn-on, which the navigation "
    "system will meet: a repeatability counts once, as no one turn-on was calibrated"
)
VERDICTS = {
    "meets": term("MEETS"),
    "meets_if": term("MEETS IF"),
    "fails": term("FAILS"),
    "undecided": term("UNDECIDED"),
    "undecidable": term("UNDECIDABLE"),
    "predicted": term("PREDICTED"),
}
# By whether all that is said of it is what its sheet leaves out.
MEETS = {
    True: term("meets, but {conditions}"),
    False: term("meets {conditions}"),
}
MISSING = {"noise": term("a noise line")}
NOT_KNOWN = term("not known")


def standing_lines(standing: Standing) -> tuple[str, ...]:
    """Say what a verdict stands on: its conditions, or what decides; cautions.

    The same sentences in every command and on every page.
    """
    return (*deciding_lines(standing), *caution_texts(standing))


def deciding_lines(standing: Standing, *, most: int | None = None) -> tuple[str, ...]:
    """Say what a verdict depends on; of a list longer than `most` its first ones."""
    texts, found = condition_texts(standing), []
    if texts and standing.asks:
        first, *others = standing.asks
        said = say("cannot be judged: {first}", first=say(first.text))
        if others:
            names = say(", ").join(key_title(one.line) for one in others)
            said = say("{said}; then for {names}", said=said, names=names)
        found.append(said)
    elif texts:
        # A sheet that is silent is no 'if' that a 'meets' could begin with.
        is_silent = all(one.silent for one in standing.conditions)
        how = MEETS[is_silent]
        is_met = standing.verdict == "meets_if"
        conditions = say("; ").join(_first(texts, most))
        found.append(say(how, conditions=conditions) if is_met else conditions)
    beyond = (one for one in standing.cautions if one.kind == "saturates")
    return (*found, *(say(one.text) for one in beyond))


def condition_texts(standing: Standing) -> list[str]:
    """Say one by one what must hold; uses that a sheet is silent on stand together."""
    texts = [say(one.text) for one in standing.conditions if not one.silent]
    silent = [one for one in standing.conditions if one.silent]
    if silent:
        lines = (key_title(name) for one in silent for name in one.silent)
        texts.append(
            counted(
                len(silent),
                "its sheet does not say what {use} does: {lines} not given",
                "its sheet does not say what {use} do: {lines} not given",
                use=listed([say(one.kind) for one in silent]),
                lines=listed(list(lines)),
            )
        )
    return texts


def caution_texts(standing: Standing, *, most: int | None = None) -> list[str]:
    """Say one by one what qualifies a verdict, besides what it depends on."""
    told = {str(one.text) for one in standing.conditions}
    texts = [
        say(one.text)
        for one in standing.cautions
        if str(one.text) not in told and one.kind != "saturates"
    ]
    return _first(texts, most)


def _first(texts: list[str], most: int | None) -> list[str]:
    """Return the first texts of a list, and how many more there are; never of one."""
    rest = len(texts) - (len(texts) if most is None else most)
    if rest <= 1:
        return texts
    return [*texts[:most], say("and {number} more, under Limits", number=rest)]


def standing_blocks(standing: Standing) -> tuple[Paragraph, ...]:
    """Return what a verdict stands on, below its headline."""
    return tuple(
        Paragraph(words=(Run(text=say("{said}.", said=capital(text)), strong=True),))
        for text in standing_lines(standing)
    )


def error_reference(settings: Settings) -> str:
    """Say what errors are counted from."""
    if settings.formulas in UNCALIBRATED:
        return say(ON_ITS_WAY)
    return say(ERROR_REFERENCES[settings.reference])


# What stands for lines that a device does not give, by the mode.
MODES = {
    "worst": (
        term(
            "the worst of comparable devices, those of the catalogue with the "
            "same sensor, technology and grade"
        )
    ),
    "typical": (
        term(
            "the median of comparable devices, those of the catalogue with the same "
            "sensor, technology and grade"
        )
    ),
    "predict": (
        term(
            "predicted from other devices of the catalogue, and verdicts that "
            "rest on them are probabilities"
        )
    ),
}


STAND_INS = {
    "worst": term(", with missing lines at the worst of the catalogue"),
    "typical": term(", with missing lines at the median of the catalogue"),
    "predict": term(", with missing lines as predicted from the catalogue"),
}


def mode_remark(settings: Settings) -> str:
    """Say beside a headline what stands for missing lines; '' where nothing does."""
    mode = settings.missing
    return say(STAND_INS[mode]) if mode in STAND_INS else ""


def mode_sentence(settings: Settings) -> str:
    """Say what stands for expected lines that are not given; '' where nothing does."""
    if settings.missing not in MODES:
        return ""
    return say(
        "Expected lines that are not given are {modes} (--missing {missing}).",
        modes=say(MODES[settings.missing]),
        missing=settings.missing,
    )


def doubt_sentence(doubt: Doubt, *, of: str) -> str:
    """Say how probable it is to meet, and which missing line to ask for first."""
    said = say("meets with {probability}", probability=print_chance(doubt.probability))
    first = doubt.asks[0]
    if settle(first.reduction) < HALF_DIGIT:
        return said
    line = source_title(first.source, of=of)
    return say(
        "{said}; {reduction} of the doubt is the missing {line}: "
        "ask the maker for it first",
        said=said,
        reduction=print_chance(first.reduction),
        line=line,
    )


def say_words(text: str, /, **parts: str | Run | Math) -> Words:
    """Write a template whose parts may be runs and formulas, as a line of a block."""
    said = template(text)
    line: list[str | Run | Math] = []
    for before, part, _, _ in string.Formatter().parse(said):
        line += [before] if before else []
        line += [] if part is None else [parts[part]]
    return tuple(line)


def parted(text: str) -> tuple[str, str]:
    """Part an assumption into its key and what is assumed: 'height', 'not given, ...'.

    The key stays as files have it.
    """
    key, _, assumed = text.partition(": ")
    if not isinstance(text, Note):
        return key, assumed
    _, _, said = say(text).partition(say(": "))
    whole = text.parts.get("key")
    return whole if isinstance(whole, Name) and whole == key else key, said or assumed


def capital(text: str) -> str:
    """Begin a text with a capital; the rest stays as it is."""
    return text[:1].upper() + text[1:]


def value(number: Number, unit: str = "") -> Run:
    """Return a rounded number in a text, with its unit and its exact value."""
    return Run(text=f"{number.text} {unit}".rstrip(), exact=number.exact)


def cell(number: Number, *, strong: bool = False) -> Cell:
    """Return a rounded number in a table."""
    return Cell(text=number.text, exact=number.exact, strong=strong)


def share_cell(share: float) -> Cell:
    """Return a share of a variance in per cent, with a bar behind it."""
    return Cell(text=print_share(share).removesuffix(" %"), exact=share, share=share)


def points(lines: Iterable[str]) -> tuple[Words, ...]:
    """Return lines of plain text as points of a listing."""
    return tuple((line,) for line in lines)


PLURALS = {
    "scale_factor": term("scale factors"),
    "mounting_angle": term("mounting angles"),
    "bias": term("biases"),
    "position": term("position"),
    "velocity": term("velocity"),
    "attitude": term("attitude"),
}
NOTHING = term("changes nothing under this error reference")


def listed(texts: Sequence[str]) -> str:
    """Write words as a sentence lists them: 'a, b and c'."""
    *most, last = texts
    if not most:
        return last
    return say("{most} and {last}", most=say(", ").join(most), last=last)


def not_given_lines(
    reach: Mapping[Name, tuple[Name, ...]], *, is_later: bool = False
) -> tuple[str, ...]:
    """Say which lines are absent and what they could change, by sensor and effect.

    `reach` has the outputs that each absent line would reach, from
    budget.studies.lower_bounds.could_widen; `is_later`: at a later turn-on.
    """
    acts = term("acts by the {use} at use, which is 0 or not stated")
    absent: dict[tuple[str, str], list[str]] = {}
    for name, outputs in reach.items():
        reached = {output.quantity for output in outputs}
        plurals = [say(PLURALS[key]) for key in PLURALS if key in reached]
        if reached:
            said = say("could widen {effect}", effect=listed(plurals))
        elif is_later and name.quantity in USE_OF:
            said = say(acts, use=say(USE_OF[name.quantity]))
        else:
            said = say(NOTHING)
        absent.setdefault((name.owner, said), []).append(words(name.quantity))
    return tuple(
        say(
            "{sensor} {lines}: {effect}",
            sensor=say(sensor),
            lines=say(", ").join(lines),
            effect=effect,
        )
        for (sensor, effect), lines in absent.items()
    )


def outcome_words(assessment: Assessment, row: OutputAssessment) -> str:
    """Say on which side of its limit an output is, if anybody knows."""
    if row not in assessment.judged:
        return say(NOT_KNOWN)
    if row in assessment.open_rows:
        return say("open: lines missing")
    owner = row.output.name.owner
    own = next((one for one in assessment.sensors if one.sensor == owner), None)
    on_conditions = row.lower_bound or (own is not None and own.verdict == "meets_if")
    if on_conditions and row.is_within:
        return say("conforms on conditions")
    word = say(assessment.outcome(row))
    how = term("{word}, by Monte Carlo") if row.by_monte_carlo else term("{word}")
    if own is not None and own.doubt:
        how = term("{word} at the medians")
    elif own is not None and row.is_within and own.standing.saturates:
        how = term("{word}, if it read enough")
    elif own is not None and row.is_within and own.verdict == "undecidable":
        how = term("{word} on what is given")
    return say(how, word=word)
