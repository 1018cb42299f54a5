"""What a result states, number by number and word by word, each with its tolerance.

A result is read from its JSON document by one table: what stands at which path, under
which name it is stored, and what its tolerance follows from. What the table does not
name is left out, because it follows from the rest (shares, ranks), hangs on chance
(which of two alike comes first) or on more than the inputs (the whole catalogue).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING, Any

from budget.model.source import SENSORS
from budget.names import MISSION, Name, as_name
from budget.references.records import NominalProperty, QuantityValue, Snapshot
from budget.results import BY_TRIALS
from budget.studies.jointly import NORMAL_TRIALS

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence
    from collections.abc import Set as AbstractSet

    from budget.references.sampling import StandardErrors

    Record = Mapping[str, Any]

# A correlation coefficient, a probability or an index is a part of 1; so much of 1 is
# rounding, of the estimators of Sobol' indices too.
PART = 1e-9
# The solver of the least cost is sure of the cost to a part of 1e-6; as the cost is
# flat around its least, it is sure of a line to the root of that only.
LEAST_COST, LEAST_COST_LINE = 1e-5, 2e-3
UTILISATION = "utilisation"
ENDS = ("low", "high", "end")  # statistics of intervals
NO_BOUNDS = {"mean", "sobol_first", "sobol_total"}  # nothing makes them worse


@dataclass(frozen=True)
class Meaning:
    """What a value of a document is, and what its tolerance follows from."""

    quantity: str  # name under which it is stored
    # 'output': in the unit of its output, sure to the resolution of that; 'limit': a
    # part of the limit of one or more outputs, sure to theirs; 'part': of 1; 'line': of
    # a data sheet; 'cost'; 'word'.
    of: str = "output"
    # What the standard error of a sampled number is that of: a field of StandardErrors;
    # 'interval', the one beside it; 'count', of trials; '': the law. Of a word: what
    # decides it.
    statistic: str = ""


_CONFORMANCE = Meaning("conformance", "part", "count")
_USED = Meaning(UTILISATION, "limit", "end")
_VERDICT, _NOT_GIVEN = (
    Meaning("verdict", "word", UTILISATION),
    Meaning("not_given", "word"),
)
# By command and path in its document, lists passed through.
_BUDGET = {
    "outputs.mean": Meaning("mean", statistic="mean"),
    "outputs.standard_uncertainty": Meaning("standard_uncertainty", statistic="u"),
    "outputs.interval.0": Meaning("interval_low", statistic="low"),
    "outputs.interval.1": Meaning("interval_high", statistic="high"),
    "outputs.contributions.standard_uncertainty": Meaning("contribution"),
    "outputs.contributions.sobol_first": Meaning("sobol_first", "part", "interval"),
    "outputs.contributions.sobol_total": Meaning("sobol_total", "part", "interval"),
    "assessment.outputs.utilisation": _USED,
    "assessment.sensors.utilisation": _USED,
    "assessment.sensors.verdict": _VERDICT,
}
MEANINGS: Mapping[str, Mapping[str, Meaning]] = {
    "analyze": _BUDGET,
    "mission": {
        **_BUDGET,
        "mission.filter.learnt.after": Meaning("learnt", "line"),
        "mission.filter.believed.standard_uncertainty": Meaning("believed", "line"),
    },
    "compare": {
        "devices.outputs.standard_uncertainty": Meaning("standard_uncertainty"),
        "devices.outputs.largest_error": Meaning("largest_error", statistic="end"),
        "devices.outputs.conformance": _CONFORMANCE,
        "devices.utilisation": _USED,
        "devices.conformance": _CONFORMANCE,
        "devices.verdict": _VERDICT,
        # Axes are alike: which of them is the worst may hang on rounding.
        "devices.limiting_source": Meaning("limiting_source", "word", UTILISATION),
        "devices.not_given": _NOT_GIVEN,
        "nothing_known.verdict": _VERDICT,
        "nothing_known.not_given": _NOT_GIVEN,
    },
    "allocate": {
        "feasible": Meaning("feasible", "word"),
        "sources.status": Meaning("status", "word"),
        "sources.now": Meaning("now", "line"),
        "sources.allowed": Meaning("allowed", "line"),
        "sources.headroom.value": Meaning("headroom", "line"),
        "outputs.utilisation_now": Meaning("utilisation_now", "limit"),
        "outputs.utilisation_allowed": Meaning("utilisation_allowed", "limit"),
        "outputs.utilisation_floor": Meaning("utilisation_floor", "limit"),
        "costs.now": Meaning("cost_now", "cost"),
        "costs.cost": Meaning("cost", "cost"),
    },
}


def snapshot_of(document: Record, errors: Mapping[str, StandardErrors]) -> Snapshot:
    """Return all that a document of a job states.

    Standard errors are those of what trials made: of an analysis under '', of a
    comparison under the `device_of` each entry of its devices.
    """
    numbers: list[QuantityValue] = []
    words: list[NominalProperty] = []
    meanings = MEANINGS[document["command"]]
    for path, place, value in _leaves(document, "", _Where(), _above(meanings)):
        meaning = meanings.get(path)
        if meaning is None or value is None:
            continue
        sure = errors.get(place.device)
        if meaning.of == "word":
            words.append(_word(place.subject, meaning, value, sure))
        else:
            numbers.append(_number(meaning, place, value, sure))
    if meanings.keys() >= _BUDGET.keys():
        is_law = document["settings"]["method"] == "gum"
        numbers += _correlations(document, None if is_law else errors.get(""))
        there = dict.fromkeys(row["sensor"] for row in document["outputs"])
        for sensor in SENSORS if MISSION in there else there:
            own = [name for name in document["not_given"] if name.owner == sensor]
            words.append(_word(sensor, _NOT_GIVEN, own))
    return Snapshot(numbers=tuple(numbers), words=tuple(words))


def device_of(document: Record, row: Record) -> str:
    """Return what a comparison is of in one entry: device, procedure, sensor."""
    several = len(document["procedures"]) > 1
    procedure = f" @ {row['procedure']}" if several else ""
    unit = f" ({row['measured']})" if "measured" in row else ""
    return f"{row['file']}{unit}{procedure} {row['sensor']}"


@dataclass(frozen=True)
class _Where:
    """Where a value stands: in which records, the document first, and what of."""

    records: tuple[Record, ...] = ()
    device: str = ""  # of a comparison
    name: Name = Name("requirement")  # noqa: RUF009 - as constant as any text

    def within(self, record: Record) -> _Where:
        """Return the place inside a record."""
        records = (*self.records, record)
        device = device_of(records[0], record) if "file" in record else self.device
        name = _name(record)
        # A contribution is one to the output around it.
        return _Where(
            records, device, self.name if "share" in record else name or self.name
        )

    @property
    def subject(self) -> str:
        """'gyro.bias.x', or of a comparison 'hg4930.yaml#C gyro.bias.x'."""
        if not self.device:
            return self.name
        return f"{self.device.removesuffix(self.records[1]['sensor'])}{self.name}"


def _leaves(
    node: object, path: str, place: _Where, wanted: AbstractSet[str] | None = None
) -> Iterator[tuple[str, _Where, Any]]:
    """Yield every value of a document with its path and its place.

    Of all keys, or of those whose paths are wanted: most of a document are matrices and
    rows that no meaning is of.
    """
    if isinstance(node, dict):
        inside = place.within(node)
        for key, child in node.items():
            own = f"{path}.{key}" if path else key
            if wanted is None or own in wanted:
                yield from _leaves(child, own, inside, wanted)
    elif isinstance(node, list) and node and isinstance(node[0], dict):
        for child in node:
            yield from _leaves(child, path, place, wanted)
    elif isinstance(node, list) and node and isinstance(node[0], float):
        for k, child in enumerate(node):
            yield f"{path}.{k}", place, child
    else:
        yield path, place, node


def _above(paths: Iterable[str]) -> frozenset[str]:
    """Return these paths and all above them."""
    return frozenset(
        ".".join(steps[:end])
        for steps in (path.split(".") for path in paths)
        for end in range(1, len(steps) + 1)
    )


def _name(record: Record) -> Name:
    """Return what a record is of; '' where it does not say."""
    if "axis" in record:  # of a bias that a filter has learnt it is that alone
        return Name(
            record.get("parameter", "bias"),
            owner=record.get("sensor", MISSION),
            axis=record["axis"],
            time=record.get("time"),
        )
    keys = ("source", "output", "sensor")
    return as_name(next((record[key] for key in keys if key in record), ""))


def _number(
    meaning: Meaning, place: _Where, value: float, sure: StandardErrors | None
) -> QuantityValue:
    """Return a number with its tolerance."""
    document, record = place.records[0], place.records[-1]
    outputs = _outputs(meaning, place.records)
    parts = [one["limit"] if meaning.of == "limit" else 1.0 for one in outputs]
    resolutions = [one["resolution"] for one in outputs]
    error = freedom = trials = None
    if meaning.statistic == "interval":
        error, freedom = _of_interval(document, record, meaning.quantity)
    elif meaning.statistic == "count":  # by the law a sensor is counted in draws of it
        row = place.records[1]
        trials = row["trials"] or (NORMAL_TRIALS if record is row else None)
    elif sure is not None and _is_drawn(document, meaning.statistic, outputs):
        errors = [sure.of(meaning.statistic, _name(one)) for one in outputs]
        error = max(e / part for e, part in zip(errors, parts, strict=True))
        freedom = sure.freedom(meaning.statistic)
    is_bound = any(one["lower_bound"] for one in outputs)
    has_unit = meaning.of in {"output", "line"}
    return QuantityValue(
        subject=place.subject,
        quantity=meaning.quantity,
        partner=record["source"] if "share" in record else "",
        unit=next(one["unit"] for one in reversed(place.records) if "unit" in one)
        if has_unit
        else "1",
        value=value,
        floor=max(
            _solver(document, meaning, value),
            *(one / part for one, part in zip(resolutions, parts, strict=True)),
            _traced(document, meaning, outputs),
        ),
        standard_error=error,
        degrees_of_freedom=freedom,
        trials=trials,
        lower_bound=record.get("lower_bound", is_bound)
        and meaning.quantity not in NO_BOUNDS,
    )


def _is_drawn(document: Record, statistic: str, outputs: Sequence[Record]) -> bool:
    """Say whether trials gave a number: by the law alone those of some intervals."""
    if document["settings"]["method"] != "gum":
        return bool(statistic)
    return statistic in ENDS and any(one["interval_by"] == BY_TRIALS for one in outputs)


def _outputs(meaning: Meaning, records: Sequence[Record]) -> list[Record]:
    """Return the outputs that a number is of; of a sensor all that are required.

    The largest of several strays no further than that of them which strays furthest.
    """
    if meaning.of not in {"output", "limit"}:
        return []
    for record in reversed(records):
        if "resolution" in record:
            return [record]
        if "outputs" in record:
            own = records[-1]["sensor"]
            return [one for one in record["outputs"] if one["sensor"] == own]
    return []


def _solver(document: Record, meaning: Meaning, value: float) -> float:
    """Return what a number is not sure to whatever it is of [its unit]."""
    line = LEAST_COST_LINE if document["settings"].get("strategy") == "cost" else 0.0
    by_quantity = {"allowed": line * value, "utilisation_allowed": line}
    by_kind = {"part": PART, "cost": LEAST_COST * value}
    return by_quantity.get(meaning.quantity, by_kind.get(meaning.of, 0.0))


def _traced(document: Record, meaning: Meaning, outputs: Sequence[Record]) -> float:
    """Return to what a contribution is sure that was traced back through a filter.

    What aids have all but taken away is a small difference: sure to a part of the
    output [its unit].
    """
    if document["command"] != MISSION or meaning.quantity != "contribution":
        return 0.0
    return float(PART * max(one["standard_uncertainty"] for one in outputs))


def _of_interval(
    document: Record, record: Record, quantity: str
) -> tuple[float, float]:
    """Return standard error and freedom behind a t interval over scrambles."""
    from scipy.special import stdtrit

    from budget.methods.sobol import CONFIDENCE

    low, high = record[f"{quantity}_interval"]
    freedom = document["settings"]["sobol_scrambles"] - 1.0
    t = float(stdtrit(freedom, (1.0 + CONFIDENCE) / 2.0))
    return (high - low) / 2.0 / t, freedom


def _correlations(
    document: Record, sure: StandardErrors | None
) -> Iterator[QuantityValue]:
    """Yield correlations, but those between triads, which the model has independent."""
    outputs = [
        (row["sensor"], _name(row), place, row["standard_uncertainty"])
        for place, row in enumerate(document["outputs"])
        if row["standard_uncertainty"] > row["resolution"]
    ]
    kind = "correlation"
    for (sensor, one, a, u_a), (owner, other, b, u_b) in combinations(outputs, 2):
        # A length, horizontal of a position, has none.
        if sensor == owner and document["covariance"][a][b] is not None:
            yield QuantityValue(
                subject=one,
                quantity=kind,
                partner=other,
                unit="1",
                value=document["covariance"][a][b] / (u_a * u_b),
                floor=PART,
                standard_error=None if sure is None else sure.of(kind, one, other),
                degrees_of_freedom=None if sure is None else sure.freedom(kind),
            )


def _word(
    subject: str, meaning: Meaning, value: object, sure: StandardErrors | None = None
) -> NominalProperty:
    """Return a word: of a list its entries, of a truth yes or no."""
    text = ", ".join(value) if isinstance(value, list) else str(value)
    return NominalProperty(
        subject=subject,
        quantity=meaning.quantity,
        text={"True": "yes", "False": "no"}.get(text, text),
        rests_on="" if meaning is _VERDICT and sure is None else meaning.statistic,
    )
