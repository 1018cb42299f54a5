"""A recorded calibration: values, how sure they are, and whether the run was sound.

Values come by the estimator of the procedure (budget.model.scheme) from means of its
windows. What is found is put together here: values and their uncertainties from
`run_values`, soundness from `run_soundness`, and what a reader has to know besides.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, replace
from datetime import date as Day  # noqa: N812 - one word with one meaning
from math import isnan, log
from typing import TYPE_CHECKING

import numpy as np

from budget.calibration.mistakes import SUSPECT
from budget.calibration.schemes import (
    as_recorded,
    calibrates,
    estimated,
    is_beside,
    windows_of,
)
from budget.errors import BudgetError, CallError
from budget.inputs import load_device
from budget.inputs.files import find
from budget.inputs.records import UNCALIBRATED
from budget.missing.expected import lacking
from budget.model.estimators import estimator_of
from budget.model.norm import NormScheme
from budget.model.source import GYRO
from budget.model.windows import dwells_of
from budget.names import AXES, IMU, Name, by_group, parameters_of
from budget.recordings.calibrated import (
    CalibratedOutput,
    PassedOver,
    RecordedCalibration,
)
from budget.recordings.health import MOST_OUTLIERS, UnsoundSamples
from budget.recordings.records import RecordedConditions
from budget.recordings.results import read_result
from budget.recordings.run import read_windows
from budget.recordings.run_soundness import (
    chi_square,
    run_of,
    suspicion,
    turn_rows,
    unseen_of,
    window_rows,
    worst_windows,
)
from budget.recordings.run_triads import run_triads, with_gyro
from budget.recordings.run_values import AS_TESTED, SCALE_FACTOR, RunValues
from budget.results import input_files, numbered_files
from budget.sentences import sentence
from budget.settings import Asked, Inputs, RecordingSettings, asking

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from budget.inputs.files import File
    from budget.inputs.records import Device, Procedure, Recording, Requirement
    from budget.recordings.calibrated import CalibrationResult, Key
    from budget.recordings.health import WindowHealth
    from budget.recordings.run_soundness import AnyRun
    from budget.recordings.run_triads import RunTriad
    from budget.recordings.window_table import RecordedWindows
    from budget.results import InputFile

SAME_PACE = 1.25  # of lengths of windows over planned ones [1]
HALF = 0.5  # of a nominal scale factor, from which it is none [1]
MEETS, FAILS, UNDECIDED = "meets", "fails", "undecided"


@asking("calibrate")
def calibrate(
    *runs: Recording | File,
    device: Device | File | None = None,
    recorded: RecordingSettings,
    windows: File | None = None,
    as_found: File | None = None,
    serial: str = "",
    date: str = "",
    inputs: Inputs,
    asked: Asked,
) -> RecordedCalibration:
    """Calibrate a unit from what was recorded of a procedure.

    Parameters
    ----------
    *runs : str, Path or Recording
        A table with a row of means for each window, or recordings one after the other.
    device : str, Path or Device, optional
        What the unit should be; without it uncertainties are those of the scatter.
    windows : str or Path, optional
        Table of when each window begins and ends.
    as_found : str or Path, optional
        Result of an earlier calibration (--json), whose correction the unit came with;
        without it errors as found are of the unit without correction.
    serial, date : str
        Number of the unit, and when it was run, as they are to stand in the result.

    Returns
    -------
    RecordedCalibration

    Raises
    ------
    CallError
        No procedure is given, or its windows are not in the recording.
    SpecError
        Everything that is wrong with a file, each at its line.
    """
    if not runs:
        raise CallError("no run is given; name the file of one")
    if not serial.isprintable():
        raise CallError(f"serial is {serial!r}, expected a text of one line")
    how = inputs.calibrated()
    if how.formulas in UNCALIBRATED:
        raise CallError(f"{how.name} is no test of which a run could be recorded")
    recordings = recorded.load(*runs)
    planned = how
    if is_beside(how):  # the unit is turned any way from dwell to dwell
        how = replace(how, windows=tuple(dwells_of(windows_of(how))))
    times = None
    if windows is not None:
        file = find(windows, "recording")
        times = (file.path, file.shown)
    read = read_windows(
        recordings,
        windows_of(planned),
        name=how.name,
        times=times,
        knows_attitudes=estimator_of(how.formulas).knows_attitudes,
    )
    unit = None if device is None else load_device(device)
    there = as_recorded(how, read.windows)
    triads = [*run_triads(read, there, unit)]
    why = ""
    if is_beside(planned) and GYRO in read.means:
        try:
            there, triads = with_gyro(read, planned, there, unit, triads)
        except BudgetError as error:
            why = str(error)
    if not triads:
        kinds = ", ".join(read.means)
        raise CallError(
            f"{how.name} calibrates no triad of {read.name}, which has the {kinds}; "
            "give another procedure or recording"
        )
    wanted = inputs.required
    _check_limits(wanted)
    before = None if as_found is None else read_result(as_found)
    given = GivenOfRun(
        read=read,
        recordings=recordings,
        how=how,
        there=there,
        unit=unit,
        requirement=wanted,
        coverage=asked.settle(wanted).coverage,
        serial=serial,
        date=_day(date, recordings, before),
        before=before,
        left_out=why,
    )
    return _put_together(given, triads)


def _check_limits(wanted: Requirement | None) -> None:
    """Refuse limits on other errors than those of the values during the run.

    Raises
    ------
    CallError
        They are.
    """
    if wanted is not None and wanted.reference != AS_TESTED:
        raise CallError(
            f"{wanted.name} limits errors of reference {wanted.reference}, and a "
            "recorded calibration knows its values against those during the run; give "
            f"limits of 'reference: {AS_TESTED}', or ask `budget analyze "
            "--requirement` of the device"
        )


def _day(
    date: str, recordings: Sequence[Recording], before: CalibrationResult | None
) -> str:
    """Return the day of a run, as the call or the first recording file says; else ''.

    Raises
    ------
    CallError
        It is none, the two differ, or the correction in force is of a later one.
    """
    days = [one.date for one in recordings if one.date]
    try:
        day = "" if not date else Day.fromisoformat(date).isoformat()
    except ValueError:
        raise CallError(f"date is {date!r}, expected one as 2026-05-31") from None
    if day and days and day not in days:
        raise CallError(
            f"date is {day}, and the recording file says {days[0]}; leave one out"
        )
    found = day or next(iter(days), "")
    if before is not None and found and before.date > found:
        raise CallError(
            f"{before.name} is of {before.date}, after this run of {found}; as found "
            "is the correction that was in force before it"
        )
    return found


# ---- how sure ------------------------------------------------------------------------


def _put_together(given: GivenOfRun, triads: Sequence[RunTriad]) -> RecordedCalibration:
    """Return what has been found, in rows, and what has to be said of it.

    Raises
    ------
    CallError
        Nothing says how sure values are.
    """
    read, how, there = given.read, given.how, given.there
    valued = [one for one in triads if one.is_found]
    made = RunValues.of(valued, there, given.unit)
    sound: dict[str, AnyRun] = {}
    untold: dict[str, str] = {}
    for one in triads if given.unit is not None else ():
        run = run_of(one, triads, there)
        try:
            is_told = not run.is_sound or run.residual.degrees_of_freedom > 0
            why = "" if is_told else sentence("calibrations.no_residual")
            if run.is_sound and not one.is_found:
                why = sentence("calibrations.not_solved", sensor=one.kind)
        except CallError as error:  # of a triad that nothing varies of
            why = str(error)
        if why:
            untold[one.kind] = sentence("calibrations.untold", why=why)
        else:
            sound[one.kind] = run
    looks = [suspicion(kind, run) for kind, run in sound.items() if not run.is_sound]
    suspicions = tuple(one for one in looks if one is not None)
    windows = tuple(
        row for one in triads for row in window_rows(one, read, sound.get(one.kind))
    )
    named = {one.mistake.sensor for one in suspicions}
    lost = [
        kind
        for kind, run in sound.items()
        if run.residual.p < SUSPECT and kind not in named
    ]
    is_bad = any(not one.is_sound for one in sound.values()) or any(
        x.is_spoilt for _, _, x in _healths(read, triads)
    )
    is_followed = there.place.azimuth is not None and any(one.turns for one in triads)
    lacks = _lacks(given, triads)
    open_ones = {*untold} | ({IMU} if untold else set())
    wanted = () if given.requirement is None else given.requirement.limits
    limits = {one.output: one.limit for one in wanted}
    outputs = tuple(
        one
        if is_bad
        else _judged(one, is_lower=one.sensor in open_ones or bool(lacks.get(name)))
        for name, one in zip(
            (x.name for x in made.outputs),
            _as_found(made.rows(given.coverage, limits), made, given),
            strict=True,
        )
    )
    widening = tuple(dict.fromkeys(x for o in made.outputs for x in lacks[o.name]))
    judged = {
        Name(one.parameter, owner=one.sensor, axis=one.axis)
        for one in outputs
        if one.limit is not None
    }
    not_judged = tuple(name for name in limits if name not in judged)
    return RecordedCalibration(
        title=given.unit.name if given.unit else read.name,
        serial=given.serial,
        date=given.date,
        environment=tuple(map(RecordedConditions.of, given.recordings)),
        procedure=how.name,
        estimator=there.formulas,
        station=(*how.station, *how.environment),
        as_found=given.before,
        coverage=given.coverage,
        inputs=tuple(_files(given)),
        outputs=outputs,
        covariance=tuple(map(tuple, made.printed_covariance.tolist())),
        matrix=tuple(made.matrix(one) for one in valued),
        windows=windows,
        turns=tuple(x for one in triads for x in turn_rows(one, sound.get(GYRO))),
        chi_square=tuple(chi_square(kind, one.residual) for kind, one in sound.items()),
        prior=tuple(chi_square(kind, one.prior) for kind, one in sound.items()),
        looks_like=suspicions,
        worst=worst_windows(windows, lost),
        unseen=tuple(x for kind, run in sound.items() for x in unseen_of(kind, run)),
        passed_over=tuple(PassedOver(start=a, end=b) for a, b in read.passed_over),
        assumptions=(
            *(given.unit.assumptions if given.unit else ()),
            *how.assumptions,
            *([sentence("calibrations.first_heading")] if is_followed else []),
            sentence("calibrations.as_tested"),
        ),
        warnings=(
            *_warnings(given, triads, widening, not_judged),
            *untold.values(),
        ),
        least_p=SUSPECT,
        untold=tuple(untold),
        lacks=widening,
        not_judged=not_judged,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class GivenOfRun:
    """What a caller says of a run.

    Attributes
    ----------
    read : RecordedWindows
    recordings : sequence of Recording
    how, there : Procedure
        As it is given, and as it was recorded.
    unit : Device or None
    requirement : Requirement or None
    coverage : float
        Of the intervals [1].
    serial, date : str
    before : CalibrationResult or None
        Whose correction the unit came with.
    left_out : str
        Why the gyro is, where turns between dwells are to tell of it.
    """

    read: RecordedWindows
    recordings: Sequence[Recording]
    how: Procedure
    there: Procedure
    unit: Device | None
    requirement: Requirement | None
    coverage: float
    serial: str = ""
    date: str = ""
    before: CalibrationResult | None = None
    left_out: str = ""


def _pace(read: RecordedWindows, procedure: Procedure) -> float:
    """Return how much longer turns took than planned, the median; dwells without any.

    A dwell is found as long as the unit rested.
    """
    pairs = list(zip(read.windows, windows_of(procedure), strict=True))
    turns = [(one, other) for one, other in pairs if other.sense] or pairs
    return float(np.median([one.length / other.length for one, other in turns]))


def _as_found(
    rows: Iterable[CalibratedOutput], made: RunValues, given: GivenOfRun
) -> Iterator[CalibratedOutput]:
    """Yield values with the errors of the unit as it came: less the correction's.

    The correction is a number, as it was applied: the error is known as the value is.

    Raises
    ------
    CallError
        The correction in force has no value of it in its unit, or none of all.
    """
    before = given.before
    there: dict[Key, tuple[str, float]] = {}
    if before is not None:
        both = zip(before.units, before.values.tolist(), strict=True)
        there = dict(zip(before.keys, both, strict=True))
    has_any = before is None
    for row, nominal in zip(rows, made.nominal.tolist(), strict=True):
        key = (row.sensor, row.parameter, row.axis)
        taken = None if isnan(nominal) or before is not None else nominal
        if before is not None and key in there:
            unit, value = there[key]
            if unit != row.unit:
                raise CallError(
                    f"{' '.join(key)} is in {unit} in {before.name}, and in "
                    f"{row.unit} here; calibrate both with, or without, a gain"
                )
            taken, has_any = value * row.si_per_unit, True
        yield replace(row, as_found=None if taken is None else row.value - taken)
    if before is not None and not has_any:
        raise CallError(f"{before.name} has no parameter in common with this run")


def _judged(row: CalibratedOutput, *, is_lower: bool) -> CalibratedOutput:
    """Return a value with verdicts on its errors as found and as left.

    With U as guard band on either side: |e| + U within the limit meets, |e| - U above
    it fails (JCGM 106, 8.3.2). A U that is a lower bound tells of no error whether it
    meets.
    """
    limit, U = row.limit, row.expanded
    if limit is None:
        return row

    def standing(low: float, high: float) -> str:
        if high <= limit and not is_lower:
            return MEETS
        return FAILS if low > limit and not is_lower else UNDECIDED

    e = None if row.as_found is None else abs(row.as_found)
    return replace(
        row,
        found_standing=None if e is None else standing(e - U, e + U),
        left_standing=FAILS if limit < U else standing(0.0, U),
    )


def _files(given: GivenOfRun) -> Iterator[InputFile]:
    """Yield the files that it rests on."""
    named = [one.origin for one in given.recordings if one.origin]
    every = dict.fromkeys([*((x.file, x.sha256) for x in named), *given.read.sha256])
    yield from numbered_files("recording", [*every])
    there = () if given.unit is None else (given.unit,)
    yield from input_files(there, procedure=given.how, requirement=given.requirement)
    if given.before is not None:
        yield from numbered_files("as found", [given.before.file])


def _lacks(
    given: GivenOfRun, triads: Sequence[RunTriad]
) -> Mapping[Name, tuple[Name, ...]]:
    """Return what the sheet does not give and would widen errors against this run.

    By the output; a repeatability cancels in all of them.
    """
    if given.unit is None:
        return defaultdict(tuple)
    sensors = [one.sensor for one in triads]
    return defaultdict(tuple, lacking(sensors, given.there, reference=AS_TESTED))


def _warnings(
    given: GivenOfRun,
    triads: Sequence[RunTriad],
    lacks: Sequence[Name],
    not_judged: Sequence[Name],
) -> Iterator[str]:
    """Yield what has to be said of a run besides."""
    read, how, unit = given.read, given.how, given.unit
    left = sorted(read.means.keys() - {one.kind for one in triads})
    far = [
        Name(SCALE_FACTOR, owner=one.kind)
        for one in triads
        if not one.has_counts
        if (np.abs(one.scale_factor - 1.0) > HALF).any()
    ]
    held = by_group(
        name
        for one in triads
        for name in parameters_of(one.kind)
        if name not in estimated(one.kind, given.there)
    )
    is_by_norm = any(isinstance(one.scheme, NormScheme) for one in triads)
    missing = [
        one.kind
        for one in (unit.sensors if unit else ())
        if one.kind not in read.means and calibrates(one.kind, how)
    ]
    ratio = _pace(read, how)
    is_spoilt = any(x.is_spoilt for _, _, x in _healths(read, triads))
    before = given.before
    is_other = before is not None and before.serial != given.serial
    is_unsound = before is not None and before.is_sound is False
    name = "" if before is None else before.name
    rows = [
        (is_other, sentence("calibrations.other_unit")),
        (is_unsound, sentence("calibrations.unsound", names=[name])),
        (missing, sentence("calibrations.not_recorded", sensors=missing)),
        (
            abs(log(ratio)) > log(SAME_PACE),
            sentence("calibrations.other_lengths", ratio=ratio),
        ),
        (unit is None and not is_spoilt, sentence("calibrations.no_device")),
        (unit is None and is_spoilt, sentence("calibrations.by_scatter")),
        (unit is not None and not how.station, sentence("calibrations.no_station")),
        (lacks, sentence("calibrations.lacks", names=lacks)),
        (given.there.formulas != how.formulas, sentence("calibrations.other_times")),
        *(
            (one.has_counts, sentence("calibrations.counts", sensor=one.kind))
            for one in triads
        ),
        (far, sentence("calibrations.far", names=far)),
        (not read.has_one_clock, sentence("calibrations.no_pauses")),
        (
            left and not given.left_out,
            sentence("calibrations.not_calibrated", sensors=left),
        ),
        (
            given.left_out,
            sentence("calibrations.gyro_left_out", why=given.left_out),
        ),
        (
            read.turns_left_out,
            sentence("calibrations.turns_left_out", turns=read.turns_left_out),
        ),
        *(
            (
                not one.is_found,
                sentence("calibrations.not_solved", sensor=one.kind),
            )
            for one in triads
        ),
        (not_judged, sentence("calibrations.not_judged", names=by_group(not_judged))),
        *(
            (
                one.is_left_handed,
                sentence("calibrations.left_handed", sensor=one.kind),
            )
            for one in triads
        ),
        (held, sentence("calibrations.held", names=held)),
        (is_by_norm, sentence("calibrations.by_norm")),
        (not read.is_as_planned, sentence("calibrations.other_attitudes")),
        (
            read.passed_over,
            sentence("calibrations.passed_over", spans=read.passed_over),
        ),
    ]
    yield from (said for is_so, said in rows if is_so)
    yield from _of_steps(given, triads)
    yield from _of_health(read, triads)


def _of_steps(given: GivenOfRun, triads: Sequence[RunTriad]) -> Iterator[str]:
    """Yield what steps of readings that are coarse beside their noise do, by triad."""
    for one in triads:
        steps = given.read.steps.get(one.kind, ())
        worst = max(steps, key=lambda x: x.u, default=None)
        if worst is None or not worst.is_coarse:
            continue
        unit, size = one.unit
        yield sentence(
            "calibrations.steps",
            sensor=one.kind,
            step=worst.step / size,
            noise=worst.noise / size,
            u=worst.u / size,
            unit=unit,
            has_u=one.rounding is not None or given.unit is None,
        )


def _healths(
    read: RecordedWindows, triads: Sequence[RunTriad]
) -> Iterator[tuple[int, str, WindowHealth]]:
    """Yield the health of each window of each triad, with its number and sensor."""
    for one in triads:
        own = read.health.get(one.kind)
        if own is not None:
            for number in one.numbers:
                yield number, one.kind, own[number - 1]


def _of_health(read: RecordedWindows, triads: Sequence[RunTriad]) -> Iterator[str]:
    """Yield what windows lack, and what is kept out of their means: each kind once."""
    every = [*_healths(read, triads)]
    turns = {k for k, one in enumerate(read.windows, start=1) if one.sense}

    def places(what: str, least: float = 0.0) -> list[UnsoundSamples]:
        return [
            UnsoundSamples(window=number, sensor=kind, axis=axis, count=count)
            for number, kind, health in every
            for axis, count in zip(AXES, getattr(health, what), strict=True)
            if count > least * health.samples
        ]

    missing: dict[int, int] = {}
    for number, _, health in every:
        if health.missing:
            missing[number] = max(missing.get(number, 0), health.missing)
    in_rest = [one for one in missing if one not in turns]
    in_turn = [one for one in missing if one in turns]
    samples = [sum(missing[one] for one in own) for own in (in_rest, in_turn)]
    lost = sorted({number for number, _, health in every if health.is_lost})
    thin = sorted({number for number, _, health in every if health.is_thin})
    at_end, stuck, outliers = map(places, ("saturated", "stuck", "outliers"))
    many = places("outliers", MOST_OUTLIERS)
    rows = [
        (at_end, sentence("calibrations.saturated", places=at_end)),
        (in_rest, sentence("calibrations.gaps", windows=in_rest, missing=samples[0])),
        (
            in_turn,
            sentence("calibrations.gaps_in_turns", windows=in_turn, missing=samples[1]),
        ),
        (lost, sentence("calibrations.lost", windows=lost)),
        (stuck, sentence("calibrations.stuck", places=stuck)),
        (outliers, sentence("calibrations.outliers", places=outliers)),
        (many, sentence("calibrations.many_outliers", places=many)),
        (thin, sentence("calibrations.thin", windows=thin)),
    ]
    yield from (said for is_so, said in rows if is_so)
