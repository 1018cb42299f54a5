"""What every study says besides what it has found, put together from its Question."""

from __future__ import annotations

from itertools import chain
from typing import TYPE_CHECKING, Any

from budget.results import input_file, input_files
from budget.studies.cautions import (
    about_results,
    age_that_counts_not,
    not_calibrated,
    not_estimated,
    not_on_a_mission,
    not_weighted,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from budget.inputs.records import Costs, Station
    from budget.question import Question
    from budget.settings import Settings


def envelope(
    question: Question,
    settings: Settings,
    *,
    assumed: Iterable[str] = (),
    warned: Iterable[str] = (),
    files: Mapping[str, Costs | Station] | None = None,
) -> dict[str, Any]:
    """Return what a `budget.results.Study` of a question has besides its rows.

    Parameters
    ----------
    question : Question
    settings : Settings
    assumed, warned : iterable of str
        What this study alone takes for granted, and warns of.
    files : mapping of str to record
        That it depends on besides, by their roles.
    """
    how, wanted, mission = question.procedure, question.requirement, question.mission
    read = {"procedure": how, "mission": mission, "requirement": wanted}
    there = [*question.devices, how, mission, wanted]
    of_test = question.journey is None
    return {
        "title": question.title,
        "inputs": (
            *input_files(question.devices, **read),
            *(input_file(role, one) for role, one in (files or {}).items()),
        ),
        "settings": settings,
        "assumptions": (
            *chain.from_iterable(one.assumptions for one in there if one is not None),
            *not_weighted(question.sensors, how),
            *assumed,
        ),
        "warnings": (
            *(not_on_a_mission(wanted, mission) if of_test else ()),
            *(not_calibrated(question.devices, how) if of_test else ()),
            *(not_estimated(question.devices, how, wanted) if of_test else ()),
            *age_that_counts_not(how, question.reference),
            *about_results(question.devices, how),
            *warned,
        ),
        "question": question,
    }
