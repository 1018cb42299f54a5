"""Purchase decision: which device, after which calibration, on which station."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import compress
from math import inf
from typing import TYPE_CHECKING

from budget.documents import Documented, written
from budget.inputs import load_procedure, load_requirement
from budget.inputs.load import load_devices, several
from budget.inputs.records import FACTORY
from budget.model.sources.later import AGEING
from budget.names import MISSION
from budget.results import VERDICTS, Study
from budget.settings import Asked, Engine, Inputs, asking
from budget.studies.allocation.allocate import allocate
from budget.studies.allocation.longer_tests import AS_THEY_ARE
from budget.studies.comparison.compare import check_names, compare
from budget.studies.comparison.ranking import (
    as_one,
    by_device,
    place_of,
    shared_by_both,
)
from budget.studies.comparison.records import NUMBERED, Unit
from budget.studies.stations import qualify
from budget.studies.verdicts import FAILS, gravest

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from budget.inputs.files import File
    from budget.inputs.records import Device, Procedure, Requirement
    from budget.results import Condition
    from budget.settings import Settings
    from budget.studies.allocation.records import Recalibration
    from budget.studies.comparison.records import Comparison
    from budget.studies.stations import StationVerdict


@written(
    "purchase",
    """
    kind: 'device', or the sensor
    chosen = chosen.name: null where nothing meets, on conditions at least
    calibration = chosen.procedure
    offers as offer: each device after each calibration, best first
    stations: for the test of what is chosen
    recalibrations: with the lines as they are
    is_aged: whether the sheet of what is chosen says what age does
    incomplete: devices that lack a sensor that is limited
    unjudged: sensors whose limits nobody judges: nothing is chosen then
    """,
)
@dataclass(frozen=True, kw_only=True)
class Purchase(Documented):
    """What to buy of one kind: a whole unit, or one triad where units have one."""

    kind: str  # 'device', or the sensor
    offers: tuple[Unit, ...]  # best first, a device once after each calibration
    # Of the chosen one: stations for its test, () where it needs none or it is not
    # known which; and how old its calibration may become.
    stations: tuple[StationVerdict, ...] = ()
    recalibrations: tuple[Recalibration, ...] = ()
    is_aged: bool = False  # whether the sheet of the chosen one says what age does
    incomplete: int = 0  # devices that lack a sensor that is limited
    unjudged: tuple[str, ...] = ()  # sensors whose limits are judged of no device

    @property
    def best(self) -> tuple[Unit, ...]:
        """Of each device what it does after the calibration that serves it best."""
        found: dict[tuple[str, str], Unit] = {}
        for one in self.offers:
            found.setdefault(_file_of(one), one)
        return tuple(found.values())

    @property
    def chosen(self) -> Unit | None:
        """The one to buy; None where none meets, on conditions at least.

        Or where a limit of the requirement is judged of none.
        """
        first = self.offers[0]
        is_met = first.verdict in NUMBERED and not self.unjudged
        return first if is_met else None

    @property
    def meeting(self) -> tuple[Unit, ...]:
        """All devices that meet, or meet on conditions."""
        return tuple(one for one in self.best if one.verdict in NUMBERED)

    @property
    def open(self) -> tuple[tuple[Unit, Condition], ...]:
        """Devices that cannot be judged, with the line to ask their makers for."""
        return tuple(
            (one, one.asks[0])
            for one in self.best
            if one.verdict not in {*NUMBERED, FAILS} and one.asks
        )

    @property
    def failing(self) -> tuple[Unit, ...]:
        """Devices that fail after every calibration."""
        return tuple(one for one in self.best if one.verdict == FAILS)

    @property
    def of_chosen(self) -> tuple[Unit, ...]:
        """The chosen device, or the nearest one, after each calibration."""
        first = _file_of(self.offers[0])
        return tuple(one for one in self.offers if _file_of(one) == first)


def _file_of(one: Unit) -> tuple[str, str]:
    """Return the device that a unit is, and its file."""
    return one.name, one.parts[0].file


@written(
    "decision",
    """
    requirement
    mission: '' without one
    calibrations: that are at hand
    met = is_met: whether there is something to buy of every kind that is needed
    purchases
    not_compared: sensors that have limits and no candidate
    inputs
    settings
    assumptions
    warnings
    """,
    commands="decide",
)
@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Decision(Study):
    """What to buy for a requirement, of the devices that were offered."""

    requirement: str
    mission: str  # '' without one
    calibrations: tuple[str, ...]
    purchases: tuple[Purchase, ...]
    not_compared: tuple[str, ...]  # sensors that are limited, and no device has
    settings: Settings

    @property
    def is_met(self) -> bool:
        """Whether there is something to buy of every kind that is needed."""
        return all(one.chosen for one in self.purchases)

    @property
    def offers(self) -> tuple[Unit, ...]:
        """Each device after each calibration, best first within its kind."""
        return tuple(offer for one in self.purchases for offer in one.offers)

    @property
    def verdict(self) -> str:
        """The gravest verdict of what is chosen, or of the best there is."""
        return gravest(one.offers[0].verdict for one in self.purchases)


@asking("decide")
def decide(
    devices: Device | File | Sequence[Device | File],
    requirement: Requirement | File,
    procedures: Procedure | File | Sequence[Procedure | File] = (),
    *,
    inputs: Inputs,
    asked: Asked,
    engine: Engine,
) -> Decision:
    """Say what to buy, after which calibration, on which station.

    Devices are judged as `compare` judges them, after each calibration; where all
    limits are on a mission, as their makers calibrated them, too. Of these the first
    is chosen: by the verdict, then what needs no test of one's own, then by the part of
    the limits that is used. Of what is chosen `qualify` says which station its test
    may have, and `allocate` when it is to be calibrated again.

    Parameters
    ----------
    devices, requirement
        As of `compare`.
    procedures : sequence of Procedure
        Calibrations that are at hand, the one preferred first; the paper's, if none is
        given.

    Returns
    -------
    Decision

    Raises
    ------
    CallError
        As of `compare`; two calibrations have one name.
    """
    wanted = load_requirement(requirement)
    journey = inputs.journey
    inputs = replace(inputs, mission=journey)
    asked = replace(asked, validate=False)
    given = several(procedures)
    as_made = {*wanted.kinds} <= {MISSION}
    at_hand = tuple(map(load_procedure, given if any(given) else (None,)))
    check_names(at_hand)
    tests: tuple[Procedure | str, ...] = (*([FACTORY] if as_made else []), *at_hand)
    imus = load_devices(devices, variants=True)
    found = [
        compare(
            imus,
            wanted,
            inputs=replace(inputs, calibration=test),
            asked=asked,
            engine=engine,
        )
        for test in tests
    ]

    def further(one: Purchase) -> Purchase:
        """Say of what is chosen which station will do, and when it is due."""
        if one.chosen is None:
            return one
        device = imus[one.chosen.parts[0].place]
        test = tests[one.chosen.order]
        given = replace(inputs, requirement=wanted, calibration=test)
        own = replace(one, is_aged=_ages(device))
        if not as_made:
            own = replace(
                own,
                stations=qualify(
                    device, inputs=replace(given, station=None, mission=None)
                ).stations,
            )
        if not own.is_aged:
            return own
        again = allocate(device, inputs=given, asked=asked).recalibrations
        kept = tuple(each for each in again if each.goal == AS_THEY_ARE)
        return replace(own, recalibrations=kept)

    shared = shared_by_both(wanted.outputs)
    purchases = [*map(further, _purchases(found, shared=shared))]
    first = found[0]
    return Decision(
        requirement=wanted.name,
        mission="" if journey is None else journey.name,
        calibrations=tuple(name for one in found for name in one.procedures),
        purchases=tuple(purchases),
        not_compared=first.not_compared,
        inputs=tuple(dict.fromkeys(file for one in found for file in one.inputs)),
        settings=first.settings,
        assumptions=_of_chosen((one.assumptions for one in found), imus, purchases),
        warnings=_of_chosen((one.warnings for one in found), imus, purchases),
    )


def offers_of(comparison: Comparison) -> tuple[Unit, ...]:
    """Return a comparison device by device, best first under each procedure."""
    outputs = (row.output.name for one in comparison.devices for row in one.outputs)
    shared = shared_by_both(outputs)
    found = (
        as_one(parts, shared=shared, order=comparison.procedures.index(procedure))
        for (procedure, _), parts in by_device(comparison.entrants).items()
    )
    return tuple(sorted(found, key=lambda one: (one.order, *_place(one))))


def _of_chosen(
    texts: Iterable[Sequence[str]],
    devices: Sequence[Device],
    purchases: Sequence[Purchase],
) -> tuple[str, ...]:
    """Return each text once, without those of devices that are not the first."""
    bought = {one.offers[0].name for one in purchases}
    others = tuple(f"{one.name}: " for one in devices if one.name not in bought)
    every = dict.fromkeys(text for some in texts for text in some)
    return tuple(text for text in every if not text.startswith(others))


def _ages(device: Device) -> bool:
    """Say whether its sheet says what age does."""
    return any(one.line(line) for one in device.sensors for line in AGEING.values())


def _purchases(
    found: Sequence[Comparison], *, shared: frozenset[str]
) -> Iterator[Purchase]:
    """Gather what is said of each device after each calibration, best first."""
    required = tuple(dict.fromkeys(one for each in found for one in each.required))
    units = [
        (order, parts)
        for order, each in enumerate(found)
        for parts in by_device(each.entrants).values()
    ]
    is_whole = [{one.sensor for one in parts} == {*required} for _, parts in units]
    whole = [*compress(units, is_whole)]
    lacking = [one for one, has in zip(units, is_whole, strict=True) if not has]
    kinds = {required[0] if len(required) == 1 else "device": whole}
    if not whole:
        kinds = {
            sensor: [
                (order, [one])
                for order, parts in units
                for one in parts
                if one.sensor == sensor
            ]
            for sensor in required
        }
    left = (one for each in found for one in (*each.not_compared, *each.untested))
    unjudged = tuple(dict.fromkeys(left))
    for kind, own in kinds.items():
        yield Purchase(
            kind=kind,
            offers=tuple(
                sorted(
                    (as_one(parts, shared=shared, order=n) for n, parts in own),
                    key=_place,
                )
            ),
            incomplete=len({parts[0].place for _, parts in lacking}) if whole else 0,
            unjudged=unjudged,
        )


def _place(one: Unit) -> tuple[float, ...]:
    """Return what is chosen by, less is better: verdict, calibration, as `compare`."""
    if not one.is_judged:
        return VERDICTS.index(one.verdict), one.order, 0.0, inf
    verdict, *rest = place_of(one)
    return verdict, one.order, *rest
