"""Verdicts with their conditions: what would overturn them, and what they depend on.

On what is given the largest error is within its limit or beyond it
(budget.studies.judgement). Where it is within, three things may still overturn it: an
expected line that reaches a limited output and is not given (budget.studies.lacking);
an environment or an age that nobody has stated; a range. How large each may be is
budget.studies.margin's.

    meets        nothing of that matters
    meets_if     it holds with every line at its ceiling, or a use is not stated
    undecidable  a line below its ceiling overturns it, or it has none
"""

from __future__ import annotations

from dataclasses import replace
from math import inf
from typing import TYPE_CHECKING

from budget.aiding import believed, journey_of, overconfident
from budget.calibration.mission import Places, mission_outputs
from budget.inputs.records import JOINT
from budget.known import Known
from budget.missing import usual_line
from budget.names import AIDING, Name
from budget.results import VERDICTS, Condition, Verdict
from budget.sentences import sentence
from budget.studies.cautions import beyond_first_order
from budget.studies.conditions import (
    calibration_words,
    of_line,
    station_words,
    use_words,
    uses_of,
)
from budget.studies.doubt import doubt_of
from budget.studies.judgement import TRIALS, assess_outputs, find_remedy, judge
from budget.studies.lacking import expected_of
from budget.studies.margin import Margin
from budget.studies.sheets import NO_TIME, cautions_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from budget.question import Question
    from budget.results import ReadingVerdicts
    from budget.studies.judgement import Judged

MEETS, MEETS_IF, PREDICTED, UNDECIDED, UNDECIDABLE, FAILS = VERDICTS


def verdict_on(
    question: Question,
    judged: Judged,
    *,
    seed: int,
    readings: ReadingVerdicts | None = None,
) -> Verdict:
    """Return the verdict on a question with its numbers, the same in every command.

    Parameters
    ----------
    question : Question
    judged : Judged
        How it stands on what is given and on what stands for lines that are not.
    seed : int
        Of trials, where the law is not sure enough.
    readings : ReadingVerdicts, optional
        Verdicts under other readings of lines whose meaning is open.
    """
    held = question.limits
    prediction, missing = question.filled.prediction, question.missing
    doubt = None
    if prediction is not None and not missing and not held.absent:
        doubt = doubt_of(prediction, held, judged)
    found = replace(unjudged(question), doubt=doubt, readings=readings)
    found = _within_first_order(question, _decided(question, judged, found, seed=seed))
    outputs = assess_outputs(question, judged, found)
    why = tuple(dict.fromkeys(name for row in outputs for name in row.lacks))
    is_bound = found.misses or bool(why)
    return replace(
        found,
        outputs=outputs,
        utilisation=Known(judged.utilisation, high=inf if is_bound else None, why=why),
        utilisation_interval=judged.utilisation_interval,
        worst_outputs=tuple(held.outputs[k].name for k in judged.all_worst),
        remedy=find_remedy(held, judged),
        conformance=judged.conformance,
        at_medians=prediction is not None,
        trials=judged.trials,
        expected_missing=found.matter(missing),
        nothing_known=not question.has_lines,
        not_estimated=held.absent,
    )


def stand(question: Question, *, seed: int) -> Verdict | None:
    """Judge a question, by few trials where they are needed; None: it has no limit."""
    if question.held is None:
        return None
    judged = judge(question.held, seed=seed, max_trials=TRIALS)
    return verdict_on(question, judged, seed=seed)


def _within_first_order(question: Question, found: Verdict) -> Verdict:
    """Return a verdict with what aids leave of it; open where first order ends."""
    found = replace(found, cautions=(*found.cautions, *_of_aids(question)))
    if found.verdict in {UNDECIDABLE, FAILS}:
        return found
    no_time = (one for one in found.cautions if one.kind == NO_TIME)
    lost = (*no_time, *_lost(question))
    if not lost:
        return found
    cautions = tuple(dict.fromkeys((*lost, *found.cautions)))
    return replace(found, verdict=UNDECIDED, conditions=lost, cautions=cautions)


def _of_aids(question: Question) -> Iterator[Condition]:
    """Yield what an aided mission is judged with, and where its filter is too sure."""
    mission, held = question.journey, question.limits
    outputs = held.outputs
    if mission is None or not mission.aiding:
        return
    times = Places.of([output.name for output in outputs]).times
    spans = [span for aid in mission.aiding for span in aid.spans]
    during = [t for t in times if any(begin < t <= end for begin, end in spans)]
    if during:
        text = sentence("conditions.aided", times=during)
        yield Condition(kind="aided", line=Name(AIDING), text=text)
    if mission.filter is not None and question.only is None:
        journey = journey_of(mission, times, question.sensors, question.procedure)
        for said in overconfident(believed(journey, outputs, held.u)):
            yield Condition(kind="filter", line=Name(AIDING), text=said)


def _lost(question: Question) -> tuple[Condition, ...]:
    """Return what leaves a verdict open where first order ends before a limit."""
    if question.journey is None:
        return ()
    times = dict.fromkeys(output.name.time or 0.0 for output in question.limits.outputs)
    attitudes = [
        name
        for name in mission_outputs(question.journey, times)
        if name.quantity == "attitude"
    ]
    own = replace(question, asked=tuple(attitudes), requirement=None, only=None)
    return tuple(
        Condition(
            kind="first_order",
            line=attitudes[-1].group,
            text=text,
        )
        for text in beyond_first_order(own.problem, own.law)
    )


def _decided(
    question: Question, judged: Judged, silent: Verdict, *, seed: int
) -> Verdict:
    """Return the verdict as far as the equations are of first order.

    `silent` is how it stands before anything is computed: 'predicted' where it rests on
    predicted lines; 'undecided' where it meets as its values are read and not under
    every other reading.
    """
    given = judged.verdict(question.limits.absent)
    if silent.doubt is not None:
        given = PREDICTED
    elif given == MEETS and silent.readings and silent.readings.passes != "all":
        given = UNDECIDED
    if silent.saturates:
        given = FAILS
    words = replace(silent, verdict=given, conditions=())
    if question.only is not None and given == MEETS:
        line, text = min(question.only), sentence("conditions.chosen")
        only = (Condition(kind="only", line=line, text=text),)
        return replace(words, verdict=MEETS_IF, conditions=only)
    if given == FAILS or question.only:
        return words
    if not any(one.lines for one in question.there):
        return silent
    margin = Margin.of(question, judged, seed=seed)
    # What is predicted is in the doubt; what else nothing bounds decides all the same.
    is_told = silent.doubt is None
    decisive = margin.decisive if is_told else margin.without_ceiling
    names = decisive or (margin.missing if is_told else ())
    of_lines = (of_line(margin, name, alone=bool(decisive)) for name in names)
    # Whatever a line is that does not decide and has no bound, it is no condition.
    conditions = (
        *(one for one in of_lines if decisive or one.below is not None),
        *uses_of(question, margin),
    )
    if decisive:
        given = UNDECIDABLE
    elif given == MEETS and conditions:
        given = MEETS_IF
    return replace(
        words,
        verdict=given,
        conditions=conditions,
        cautions=(*conditions, *silent.cautions),
        at_ceilings=margin.at_ceilings,
        negligible=tuple(x for x in expected_of(question) if x not in margin.missing),
    )


def unjudged(question: Question) -> Verdict:
    """Return how it stands before anything is computed: what it lacks decides."""
    requirement = question.wanted
    return Verdict(
        verdict=UNDECIDABLE,
        sensor=question.owner,
        conditions=tuple(
            Condition(
                kind="missing",
                line=name,
                unit=line.unit,
                si_per_unit=line.si_per_unit,
                decides=True,
                text=sentence("conditions.decides", line=name),
            )
            for name in expected_of(question)
            for line in [usual_line(name)]
        ),
        cautions=cautions_of(question),
        calibration=calibration_words(question.procedure),
        station=station_words(question.procedure),
        use=use_words(question.procedure, is_later=question.is_later),
        mission="" if question.journey is None else question.journey.name,
        decision=sentence(
            "conditions.decision",
            is_joint=requirement.decision == JOINT,
            coverage=requirement.coverage,
        ),
    )


def gravest(verdicts: Iterable[str]) -> str:
    """Return what parts are together: one that fails, fails."""
    return max(verdicts, key=VERDICTS.index)
