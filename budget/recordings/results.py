"""Results of recorded calibrations read again: what changed between two, and in time.

A parameter moved where its two values differ by more than both uncertainties: z of
their difference has p below 5 % over all that are held beside each other. The change is
the size of a known mistake where that mistake, made in one of the two runs, explains
most of it: with d the changes of a triad, C the sum of both covariances and D what the
estimator makes of readings with the mistake, d' C^-1 d less (d - D)' C^-1 (d - D).
"""

from __future__ import annotations

import json
import re
from collections import Counter
from dataclasses import dataclass, replace
from hashlib import sha256
from itertools import product
from math import erfc, hypot, inf, sqrt
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

import numpy as np

from budget.calibration.mistakes import (
    TOLD_APART,
    Mistake,
    inputs_of,
    mistakes_of,
)
from budget.calibration.problem import BIAS_UNITS
from budget.calibration.schemes import as_recorded, calibrates, scheme_of, windows_of
from budget.documents import Documented, written
from budget.errors import CallError, Issue, SpecError, UnitError
from budget.inputs.files import find
from budget.inputs.reader import read_bytes, refuse
from budget.inputs.records import Sensor
from budget.model.source import GYRO, SENSORS
from budget.names import (
    ANGLES,
    AXES,
    BETWEEN,
    DERIVED,
    IMU,
    ORDERS,
    OUTPUTS,
    PARAMETERS,
    Name,
)
from budget.recordings.calibrated import CalibrationResult, MistakeRow
from budget.recordings.columns import COUNTS, LIKE
from budget.results import InputFile
from budget.sentences import sentence
from budget.units import kind_of, size_of

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
    from pathlib import Path

    from budget.arrays import Array
    from budget.inputs.files import File, NamedFile
    from budget.inputs.records import Procedure
    from budget.model.place import Place
    from budget.model.scheme import Scheme
    from budget.recordings.calibrated import Key

MOVED, WITHIN, NOT_TOLD = "moved", "within", "not told"
LEVEL = 0.05  # probability that one of all is found to have moved, and none has
BY_CHANCE = 32.9  # squares of 12 changes that one in a thousand has more of [1]
# Of one axis, and how many times w sin(latitude) they make.
OF_ONE_AXIS = (("earth_rate_sign", 2.0), ("earth_rate_missing", 1.0))
EXPLAINED = 0.1  # of the squares of a change, that a mistake leaves at the most [1]
COMMAND = "calibrate"
MOST_BYTES = 64 * 1024 * 1024
MOST, TINY = 1e100, 1e-9  # numbers of a result, in size; factors that are above 0
ALIKE = 1e-4  # of numbers that may have been rounded, over u
MOST_NAMED = 3  # files
LONGEST = 40  # of what was found, in a message
NO_RESULT = "is no result of a calibration, expected one of calibrate --json"
UNITS = (
    {"scale_factor": "ppm"}
    | dict.fromkeys(("mounting_angle", *DERIVED, *BETWEEN), "arcsec")
    | dict.fromkeys(ORDERS, "ug/g^2")
)
_IS_RESULT = re.compile(rb'"command"\s*:\s*"calibrate"')


def is_result(name: File) -> bool:
    """Whether a file is of `budget calibrate`, however it is laid out, or cut off."""
    path = find(name, "device").path
    if path.suffix.lower() != ".json":
        return False
    try:
        with path.open("rb") as stream:
            return _IS_RESULT.search(stream.read(MOST_BYTES)) is not None
    except OSError:
        return False


def open_result(file: NamedFile) -> NamedFile:
    """Return the file of a result with what is in it, read from the disk once.

    Raises
    ------
    SpecError
        It cannot be read, or is too large for one.
    """
    if file.content is not None:
        return file
    data = read_bytes(
        file.path, file.shown, most=MOST_BYTES, what="a result of a calibration"
    )
    if len(data) > MOST_BYTES:
        raise refuse(file.shown, NO_RESULT)
    return replace(file, content=data)


def read_result(name: File) -> CalibrationResult:
    """Read a result of `budget calibrate --json`.

    Raises
    ------
    SpecError
        It cannot be read, is none, or says what no calibration does: with the key.
    """
    file = open_result(find(name, "device"))
    data = file.content or b""
    try:
        document = json.loads(data.decode("utf-8-sig"), object_pairs_hook=_once)
    except (ValueError, RecursionError):
        raise refuse(file.shown, NO_RESULT) from None
    is_one = isinstance(document, dict) and document.get("command") == COMMAND
    rows = document.get("outputs") if is_one else None
    if not isinstance(rows, list) or not rows:
        raise refuse(file.shown, NO_RESULT)
    return _Said(file.shown, document).result(file.path.name, data)


def read_results(names: Iterable[File]) -> list[CalibrationResult]:
    """Read several, each with a name that no other file of them has.

    Raises
    ------
    SpecError
        As `read_result`.
    """
    files = [*names]
    shown = told_apart([find(one, "device").path for one in files])
    return [
        replace(read_result(one), name=name)
        for one, name in zip(files, shown, strict=True)
    ]


def told_apart(paths: Sequence[Path]) -> list[str]:
    """Return the shortest end of each path that is no end of another one."""
    every = [one.absolute().parts for one in paths]
    length = dict.fromkeys(every, 1)
    open_ = {*every}
    while open_:
        ends = Counter(one[-length[one] :] for one in open_)
        open_ = {
            one
            for one in open_
            if ends[one[-length[one] :]] > 1 and length[one] < len(one)
        }
        for one in open_:
            length[one] += 1
    return [str(PurePath(*one[-length[one] :])) for one in every]


def is_unit(text: str) -> bool:
    """Whether a text is a unit of this package."""
    try:
        return size_of(text) > 0.0
    except UnitError:
        return False


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return an object whose keys stand there once.

    Raises
    ------
    ValueError
        One stands there again.
    """
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError
    return found


@dataclass(frozen=True)
class _Said:
    """What a document says, each key held against what it may be."""

    shown: str
    document: dict[str, Any]

    def refused(self, place: str, found: object, allowed: str) -> SpecError:
        """Return the error of one key."""
        said = "nothing" if found is None else json.dumps(found)
        cut = said if len(said) <= LONGEST else f"{said[:LONGEST]}..."
        message = f"found {cut}, expected {allowed}"
        issue = Issue(file=self.shown, line=1, column=1, field=place, message=message)
        return SpecError((issue,))

    def text(self, place: str, found: object, *, least: int = 0) -> str:
        """Return words of one line."""
        is_text = isinstance(found, str) and len(found) >= least
        if not is_text or not str(found).isprintable():
            raise self.refused(place, found, "a text of one line")
        return str(found)

    def number(
        self, place: str, found: object, allowed: str, low: float = -MOST
    ) -> float:
        """Return a number from `low` on."""
        is_number = isinstance(found, int | float) and not isinstance(found, bool)
        if not is_number or not low <= found <= MOST:  # type: ignore[operator]
            raise self.refused(place, found, f"{allowed}, up to {MOST:g}")
        return float(found)  # type: ignore[arg-type]

    def result(self, name: str, data: bytes) -> CalibrationResult:
        """Return all of it."""
        document, rows = self.document, self.document["outputs"]
        read = [self.row(f"outputs.{k}", row) for k, row in enumerate(rows)]
        keys = [key for key, *_ in read]
        for k, key in enumerate(keys):
            if key in keys[:k]:
                raise self.refused(
                    f"outputs.{k}", " ".join(key), "every parameter once"
                )
        is_sound = document.get("is_sound", "nothing")
        if not (is_sound is None or isinstance(is_sound, bool)):
            raise self.refused("is_sound", is_sound, "true, false or null")
        covariance = self.covariance(len(rows))
        u = np.sqrt(np.diag(covariance))
        for k, row in enumerate(rows):
            own = row.get("standard_uncertainty")
            if own is not None or not np.isnan(u[k]):
                stated = self.number(
                    f"outputs.{k}.standard_uncertainty", own, "0 or more", 0.0
                )
                if not abs(stated - u[k]) <= ALIKE * u[k]:
                    raise self.refused(
                        f"outputs.{k}.standard_uncertainty",
                        own,
                        f"the root of its variance in covariance.{k}.{k}, {u[k]:g}",
                    )
        inputs = document.get("inputs", {})
        inputs = inputs if isinstance(inputs, dict) else {}
        files = {
            role: str(one.get("sha256", ""))
            for role, one in inputs.items()
            if isinstance(one, dict)
        }
        recordings = {
            digest for role, digest in files.items() if role.startswith("recording")
        } - {""}
        device = inputs.get("device")
        changes = device.get("changes", []) if isinstance(device, dict) else []
        return CalibrationResult(
            name=name,
            sha256=sha256(data).hexdigest(),
            **{x: self.text(x, document.get(x)) for x in ("title", "serial", "date")},
            procedure=self.text("procedure", document.get("procedure", "")),
            is_sound=is_sound,
            is_bound=document.get("lower_bound") is True,
            recordings=frozenset(recordings),
            has_device="device" in inputs,
            has_station=bool(document.get("station")),
            files=files,
            changes=tuple(changes) if isinstance(changes, list) else (changes,),
            keys=tuple(keys),
            units=tuple(unit for _, unit, *_ in read),
            values=np.array([value for *_, value, _, _ in read]),
            expanded=u * np.array([factor for *_, factor, _ in read]),
            degrees_of_freedom=np.array([nu for *_, nu in read]),
            covariance=covariance,
        )

    def row(self, place: str, row: Any) -> tuple[Key, str, float, float, float]:  # noqa: ANN401 - of a document
        """Return parameter, unit, value, coverage factor and degrees of freedom."""
        if not isinstance(row, dict):
            raise self.refused(place, row, "an object of one parameter")
        one, two, three = (
            self.text(f"{place}." + x, row.get(x))
            for x in ("sensor", "parameter", "axis")
        )
        owners = (*SENSORS, IMU)
        if one not in owners:
            raise self.refused(f"{place}.sensor", one, " or ".join(owners))
        axes = OUTPUTS.get(two)
        if axes is None:
            raise self.refused(f"{place}.parameter", two, ", ".join(OUTPUTS))
        if three not in axes:
            raise self.refused(f"{place}.axis", three, ", ".join(axes))
        unit = self.text(f"{place}.unit", row.get("unit"))
        allowed = f"{COUNTS}/({LIKE[one]})" if one in LIKE else ""
        like = BIAS_UNITS.get(one, ("arcsec", 1.0))[0] if two == "bias" else UNITS[two]
        if not (
            (two == "scale_factor" and unit == allowed)
            or (two in ORDERS and is_unit(unit))
            or (is_unit(unit) and kind_of(unit) == kind_of(like))
        ):
            raise self.refused(f"{place}.unit", unit, f"a unit such as {like}")
        factor = row.get("coverage_factor")
        nu = row.get("degrees_of_freedom")
        of_nu = f"{place}.degrees_of_freedom"
        return (
            (one, two, three),
            unit,
            self.number(f"{place}.value", row.get("value"), "a number"),
            self.number(f"{place}.coverage_factor", factor, "above 0", TINY),
            inf if nu is None else self.number(of_nu, nu, "above 0, or null", TINY),
        )

    def covariance(self, n: int) -> Array:
        """Return it, (n, n): symmetric and positive semidefinite; nan of null.

        The least eigenvalue of the correlations is 0 but for rounding.
        """
        rows = self.document.get("covariance")
        flat = rows if isinstance(rows, list) and len(rows) == n * n > 1 else None
        if flat is not None:
            rows = [flat[k * n : (k + 1) * n] for k in range(n)]
        if not isinstance(rows, list) or len(rows) != n:
            raise self.refused("covariance", rows, f"{n} rows of {n} numbers")
        found = np.full((n, n), np.nan)
        for i, row in enumerate(rows):
            if not isinstance(row, list) or len(row) != n:
                raise self.refused(f"covariance.{i}", row, f"{n} numbers")
            for k, one in enumerate(row):
                if one is not None:
                    low = 0.0 if i == k else -MOST
                    allowed = "a variance, 0 or more" if i == k else "a number"
                    place = f"covariance.{i}.{k}"
                    found[i, k] = self.number(place, one, allowed, low)
        u = np.sqrt(np.diag(found))
        size = np.where(u > 0.0, u, 1.0)
        scaled = found / size[:, None] / size
        off = np.abs(scaled - scaled.T) > ALIKE
        if off.any():
            i, k = np.argwhere(off)[0].tolist()
            raise self.refused(
                f"covariance.{i}.{k}", rows[i][k], f"that of covariance.{k}.{i}"
            )
        known = np.flatnonzero(np.isfinite(u))
        own = scaled[np.ix_(known, known)]
        if not np.isfinite(own).all() or (np.abs(own) > 1.0 + ALIKE).any():
            i, k = np.argwhere(~(np.abs(own) <= 1.0 + ALIKE))[0].tolist()
            i, k = int(known[i]), int(known[k])
            raise self.refused(
                f"covariance.{i}.{k}", rows[i][k], "no more than the product of both u"
            )
        least = float(np.linalg.eigvalsh(own).min()) if len(known) else 0.0
        if least < -ALIKE * n:
            raise self.refused(
                "covariance",
                least,
                "no eigenvalue of the correlations below 0: it is of no errors",
            )
        return found


def counted_once(
    results: Sequence[CalibrationResult],
) -> tuple[list[CalibrationResult], list[str]]:
    """Leave out results of a run that another one is of; with what is said of them.

    Of one run are equal files, results of one unit of the same recordings, and those
    whose words and numbers are the same.

    Raises
    ------
    CallError
        Two of one run have different dates.
    """
    kept: list[CalibrationResult] = []
    said: list[str] = []
    for one in results:
        same = next((x for x in kept if _is_of_one_run(x, one)), None)
        if same is None:
            kept.append(one)
            continue
        if same.date != one.date:
            raise CallError(
                f"{same.name} and {one.name} are of the same recording, and of "
                f"{same.date!r} and {one.date!r}; give the one that is right"
            )
        said.append(
            sentence("calibrations.given_twice", first=same.name, second=one.name)
        )
    return kept, said


def _is_of_one_run(first: CalibrationResult, second: CalibrationResult) -> bool:
    """Whether two results are of one run."""
    if first.sha256 == second.sha256:
        return True
    if first.serial != second.serial:
        return False
    if first.recordings or second.recordings:
        return first.recordings == second.recordings
    return (first.date, first.keys, first.units) == (
        second.date,
        second.keys,
        second.units,
    ) and np.array_equal(first.values, second.values)


def common_keys(
    named: Sequence[tuple[str, Collection[Key]]], *, among: Collection[str] = OUTPUTS
) -> tuple[list[Key], list[str]]:
    """Return parameters that all files have; with what is said of the others.

    Parameters
    ----------
    named : sequence of (str, collection of Key)
        Name of each file, and what it has.
    among : collection of str
        Which parameters are wanted.
    """
    every = dict.fromkeys(x for _, own in named for x in own if x[1] in among)
    names = {key: Name(key[1], owner=key[0], axis=key[2]) for key in every}
    lacking: dict[tuple[str, ...], list[Key]] = {}
    for key in every:
        files = tuple(name for name, own in named if key not in own)
        lacking.setdefault(files, []).append(key)
    common = lacking.pop((), [])
    said: list[str] = []
    for files, keys in lacking.items():
        # Of a group that lacks as a whole its axes are not named.
        rest = {names[key].group for key in every if key not in keys}
        groups = (names[x] if names[x].group in rest else names[x].group for x in keys)
        said.append(
            sentence(
                "calibrations.not_in_all",
                names=[*dict.fromkeys(groups)],
                files=files[:MOST_NAMED],
                more=len(files[MOST_NAMED:]),
            )
        )
    return common, said


def in_one_unit(
    key: Key, results: Sequence[CalibrationResult], what: str
) -> tuple[str, Array, Array]:
    """Return the unit of a parameter of all results, its values and their variances.

    Raises
    ------
    CallError
        Its units differ.
    """
    places = [(one, one.keys.index(key)) for one in results]
    units = {one.units[k] for one, k in places}
    if len(units) > 1:
        raise CallError(
            f"{' '.join(key)} is in {' and in '.join(sorted(units))}; calibrate all "
            f"{what} with, or without, a gain"
        )
    values = np.array([one.values[k] for one, k in places])
    return units.pop(), values, np.array([one.covariance[k, k] for one, k in places])


def said_of(results: Sequence[CalibrationResult]) -> Iterator[str]:
    """Yield what has to be said of results, once of all: not sound, or lower bounds."""
    unsound = [one.name for one in results if one.is_sound is False]
    bounds = [one.name for one in results if one.is_bound]
    if unsound:
        yield sentence("calibrations.unsound", names=unsound)
    if bounds:
        yield sentence("calibrations.bound", names=bounds)


@written(
    "changed_parameter",
    """
    sensor: 'gyro', 'accelerometer' or, of both together, 'imu'
    parameter
    axis
    is_derived: whether it is a sum of others, as a rotation is of mounting angles
    unit
    first [unit]: value
    second [unit]
    difference [unit]: second less first
    standard_uncertainty or null [unit]: of the difference; null where it is not known
    z or null [1]: difference over it; null where that is 0, or not known
    p or null [1]: probability of one as large where nothing moved; null where no
      uncertainty is known
    standing: 'moved', 'within' or, without p, 'not told'
    """,
)
@dataclass(frozen=True, kw_only=True)
class ChangedParameter(Documented):
    """One parameter in two calibrations."""

    sensor: str
    parameter: str
    axis: str
    is_derived: bool
    unit: str
    first: float
    second: float
    difference: float
    standard_uncertainty: float | None
    z: float | None
    p: float | None
    standing: str


@written(
    "change_of_a_mistake",
    """
    *mistake as mistake
    evidence: squares of the change that it explains
    run: in which it would have been made, 'first', 'second' or 'either'
    """,
)
@dataclass(frozen=True, kw_only=True)
class ChangeOfMistake(Documented):
    """A mistake in one of two runs that a change is the size of."""

    mistake: MistakeRow
    evidence: float
    run: str


@written(
    "calibration_change",
    """
    first: name of the first result
    second: name of the second
    inputs by role as file
    level [1]: below which p has moved, 5 % over all parameters
    parameters
    looks_like: mistakes in one of the two that the change is the size of
    warnings
    """,
    commands="diff",
)
@dataclass(frozen=True, kw_only=True, repr=False)
class CalibrationChange(Documented):
    """Two calibrations of a unit, side by side."""

    first: str
    second: str
    inputs: tuple[InputFile, ...]
    level: float
    parameters: tuple[ChangedParameter, ...]
    looks_like: tuple[ChangeOfMistake, ...]
    warnings: tuple[str, ...]

    @property
    def moved(self) -> tuple[ChangedParameter, ...]:
        """Parameters that moved and are no sums of others, the farthest first."""
        found = [one for one in self.parameters if one.standing == MOVED]
        own = (one for one in found if not one.is_derived)
        return tuple(sorted(own, key=lambda one: -abs(one.z or inf)))


def change_between(
    first: CalibrationResult, second: CalibrationResult, procedure: Procedure | None
) -> CalibrationChange:
    """Hold two calibrations beside each other.

    Parameters
    ----------
    procedure : Procedure or None
        That was followed; without it no mistake is looked for.

    Raises
    ------
    CallError
        They have no parameter in common, or other units.
    """
    keys, left_out = common_keys([(one.name, one.keys) for one in (first, second)])
    common = [(first.keys.index(key), second.keys.index(key)) for key in keys]
    if not common:
        raise CallError(f"{first.name} and {second.name} have no parameter in common")
    for a, b in common:
        if first.units[a] != second.units[b]:
            raise CallError(
                f"{' '.join(first.keys[a])} is in {first.units[a]} in {first.name}, "
                f"and in {second.units[b]} in {second.name}; calibrate both with, or "
                "without, a gain"
            )
    level = LEVEL / len(common)
    rows = [_changed(first, second, a, b, level) for a, b in common]
    changes = {} if procedure is None else _triads(first, second, procedure)
    looks = () if procedure is None else _looks(changes, procedure)
    passed_over = [kind for kind, one in changes.items() if one is None]
    warnings = [
        *said_of((first, second)),
        *counted_once((first, second))[1],
        *left_out,
        *(
            [sentence("calibrations.other_unit")]
            if first.serial != second.serial
            else []
        ),
        *([sentence("calibrations.no_procedure")] if procedure is None else []),
        *(
            [sentence("calibrations.no_mistake_sought", sensors=passed_over)]
            if passed_over
            else []
        ),
        *(
            sentence("calibrations.other_procedure", name=one.name, own=one.procedure)
            for one in (first, second)
            if procedure is not None and one.procedure not in {"", procedure.name}
        ),
    ]
    return CalibrationChange(
        first=first.name,
        second=second.name,
        inputs=tuple(
            InputFile(role=role, name=one.name, sha256=one.sha256)
            for role, one in (("first", first), ("second", second))
        ),
        level=level,
        parameters=tuple(rows),
        looks_like=tuple(looks),
        warnings=tuple(warnings),
    )


def _changed(
    first: CalibrationResult,
    second: CalibrationResult,
    a: int,
    b: int,
    level: float,
) -> ChangedParameter:
    """Return one parameter in both."""
    sensor, parameter, axis = first.keys[a]
    difference = float(second.values[b] - first.values[a])
    u = hypot(sqrt(first.covariance[a, a]), sqrt(second.covariance[b, b]))
    is_known = u >= 0.0
    # Of exact values any difference is one.
    p = erfc(abs(difference / u) / sqrt(2.0)) if u > 0.0 else float(difference == 0.0)
    standing = MOVED if p < level else WITHIN
    return ChangedParameter(
        sensor=sensor,
        parameter=parameter,
        axis=axis,
        is_derived=parameter not in {*PARAMETERS, *ORDERS},
        unit=first.units[a],
        first=float(first.values[a]),
        second=float(second.values[b]),
        difference=difference,
        standard_uncertainty=u if is_known else None,
        z=difference / u if u > 0.0 else None,
        p=p if is_known else None,
        standing=standing if is_known else NOT_TOLD,
    )


def _triads(
    first: CalibrationResult, second: CalibrationResult, procedure: Procedure
) -> dict[str, tuple[Array, Array] | None]:
    """Return the change of each triad, and its covariance; None where it is not told.

    It is not where a parameter is missing or in counts, or the covariance singular.
    """
    found: dict[str, tuple[Array, Array] | None] = {}
    for kind in SENSORS:
        keys = [(kind, q, axis) for q in PARAMETERS for axis in _axes_of(q)]
        both = [key for key in keys if key in first.keys and key in second.keys]
        if not both or not calibrates(kind, procedure):
            continue
        found[kind] = None
        in_counts = any("counts" in first.units[first.keys.index(x)] for x in both)
        if len(both) == len(keys) and not in_counts:
            change, covariance = _of_triad(first, second, both)
            found[kind] = (change, covariance) if _is_told(covariance) else None
    return found


def _looks(
    changes: Mapping[str, tuple[Array, Array] | None], procedure: Procedure
) -> Iterator[ChangeOfMistake]:
    """Yield for each triad the mistake that its change is the size of, if any is."""
    windows = windows_of(procedure)
    numbers = range(1, len(windows) + 1)
    for kind, told in changes.items():
        if told is None:
            continue
        change, covariance = told
        own = [k for k, one in enumerate(windows) if one.use in {kind, "both"}]
        scheme = scheme_of(kind, as_recorded(procedure, windows), Sensor.bare(kind))
        found = [
            (left, run, mistake)
            for mistake in mistakes_of(
                kind,
                [windows[k] for k in own],
                [numbers[k] for k in own],
                procedure.place,
                procedure.sample_rate,
            )
            if (made := _made(scheme, mistake)) is not None
            for run, sign in (("second", 1.0), ("first", -1.0))
            for left in [_square(change - sign * made, covariance)]
        ]
        found += [
            (left, "either", one)
            for one, made in (_in_one_axis(procedure.place) if kind == GYRO else ())
            for sign in (1.0, -1.0)  # up or down: the procedure may be another
            if (left := _square(change - sign * made, covariance)) <= BY_CHANCE
        ]
        whole = _square(change, covariance)
        least = min(found, key=lambda one: one[0], default=None)
        if least is None or whole - least[0] <= TOLD_APART:
            continue
        if least[0] <= EXPLAINED * whole:
            yield ChangeOfMistake(
                mistake=MistakeRow.of(kind, least[2]),
                evidence=whole - least[0],
                run=least[1],
            )


def _in_one_axis(place: Place) -> Iterator[tuple[Mistake, Array]]:
    """Yield mistakes about the earth rate of one axis, and what they make, (12,) [SI].

    Turns there and back about an axis that points up read its bias and w sin(latitude),
    on the average: who computes axis by axis can take that with the wrong sign in one.
    """
    rate = place.earth_rate * np.sin(place.latitude)
    for (name, times), k in product(OF_ONE_AXIS, range(3)):
        made = np.zeros(12)
        made[9 + k] = times * rate
        yield Mistake(name=name, what=(("axis", AXES[k]),)), made


def _axes_of(parameter: str) -> Sequence[str]:
    """Return the axes of a parameter."""
    return ANGLES if parameter == "mounting_angle" else AXES


def _of_triad(
    first: CalibrationResult, second: CalibrationResult, keys: Sequence[Key]
) -> tuple[Array, Array]:
    """Return the change of parameters, (12,), and its covariance [SI]."""
    a = [first.keys.index(key) for key in keys]
    b = [second.keys.index(key) for key in keys]
    sizes = np.array([size_of(first.units[k]) for k in a])
    change = (second.values[b] - first.values[a]) * sizes
    C = first.covariance[np.ix_(a, a)] + second.covariance[np.ix_(b, b)]
    return change, np.asarray(C * np.outer(sizes, sizes))


def _is_told(covariance: Array) -> bool:
    """Whether every change of a triad is known to something above 0."""
    u = np.sqrt(np.diag(covariance))
    if not (u > 0.0).all() or not np.isfinite(u).all():
        return False
    scaled = covariance / u[:, None] / u
    return bool(np.linalg.eigvalsh(scaled)[0] > TINY)


def _square(change: Array, covariance: Array) -> float:
    """Return d' C^-1 d."""
    u = np.sqrt(np.diag(covariance))
    scaled = change / u
    return float(scaled @ np.linalg.solve(covariance / u[:, None] / u, scaled))


def _made(scheme: Scheme, mistake: Mistake) -> Array | None:
    """Return what a mistake makes of the parameters of a nominal triad, (12,) [SI]."""
    place = mistake.place or scheme.place
    windows = mistake.really(scheme.schedule.windows)
    readings = mistake.done(inputs_of(scheme.owner, windows, place).T)
    with np.errstate(all="ignore"):
        found = scheme.estimate(readings)
    values = np.concatenate(
        [found.scale_factor - 1.0, found.mounting_angle, found.bias]
    )
    return values if np.isfinite(values).all() else None
