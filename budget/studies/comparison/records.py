"""Records of a comparison: frozen, SI inside, and their JSON documents."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from itertools import chain
from math import prod
from sys import intern
from typing import TYPE_CHECKING, NamedTuple

from budget import views
from budget.documents import Documented, written
from budget.inputs.load import UNTESTED
from budget.inputs.records import FACTORY
from budget.results import VERDICTS, Study, Verdict
from budget.spooled import Made
from budget.ties import settle

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    import pandas as pd

    from budget.missing import Filling
    from budget.names import Name
    from budget.settings import Settings
    from budget.studies.judgement import Counted, Judged

NUMBERED = ("meets", "meets_if")  # verdicts that a rank is of


@dataclass(frozen=True, kw_only=True)
class Ranked(Verdict):
    """A verdict with its place in a list, best first."""

    ahead: Lead | None = None  # of the next one with the same verdict
    rank: int | None = None  # in its list; None: neither meets nor meets on conditions
    is_tied: bool = False  # whether it shares its rank with a neighbour

    @property
    def printed_rank(self) -> str:
        """Its rank; '2=' where neighbours cannot be told apart at 95 %."""
        return "" if self.rank is None else f"{self.rank}{'=' * self.is_tied}"


@written(
    "missing_lines",
    """
    lines: expected and not given
    assumed = filling.lines (list[str]): what stands in their place, in words
    utilisation [1]: at worst, or with what stands for them; null where not known
    verdict or null: then
    *filling unless is_bound as filling
    """,
)
@dataclass(frozen=True, kw_only=True)
class MissingLines(Documented):
    """What lines that are not given could do, or what stands in their place.

    Where the mode is to refuse, they are zero at best, which is what the verdict
    counts; at worst they are what the worst device of the catalogue has that is like
    it, of the same technology and grade. Where no such device gives the line nothing is
    known. By the other modes the verdict counts what stands in their place.
    """

    lines: tuple[Name, ...]  # expected and not given
    filling: Filling  # at worst, or as the mode says
    utilisation: float | None  # at worst, by the law [1]; None: not known
    verdict: str  # 'meets', 'fails', or '' where it is not known
    is_bound: bool = True  # what they could do at worst; else the verdict counts them


@written(
    "lead",
    """
    other: the next one in its list
    probability [1]: that its utilisation is the smaller one
    tied = is_tied: whether the two cannot be told apart at 95 %
    """,
)
@dataclass(frozen=True, kw_only=True)
class Lead:
    """How sure it is that a device is better than the next one in its list."""

    other: str
    probability: float  # that its utilisation is the smaller one [1]

    @property
    def is_tied(self) -> bool:
        """Whether the two cannot be told apart at 95 %."""
        return 0.025 < self.probability < 0.975  # noqa: PLR2004 - two-sided 95 %


@written(
    "unknown_cap",
    """
    merit: 'price', 'mass' or 'power'
    cap: as the requirement gives it
    text: of the maker, which cannot be held against it; '' where there is none
    """,
)
@dataclass(frozen=True, kw_only=True)
class UnknownCap:
    """A cap that nobody can say of a device whether it is exceeded."""

    merit: str  # 'price', 'mass', 'power'
    cap: str  # as the requirement gives it
    text: str  # of the maker, which cannot be held against it; '' where there is none


@written(
    "device_verdict",
    """
    *self as entrant
    rank: in its list; equal of what cannot be told apart, null without a verdict that
      ranks
    lower_bound = utilisation.is_bound: whether the utilisation is this or more, the
      conformance this or less
    utilisation [1]: the largest over its required outputs
    utilisation_interval [1]: 95 % sampling, and the law's error
    margin [1]: what is left of the limit; negative beyond
    worst_output: that uses most of its limit
    worst_outputs: that one and all that are equal to it by the law
    *known_conformance as conformance
    limiting_source = remedy.source: with the largest share there
    limiting_share = remedy.share [1]: of the variance there
    improvement_factor = remedy.factor [1]: on its standard uncertainty, to meet; null
      where it alone cannot mend it
    ahead: how sure the place before the next one is; null of the last
    on_front: 'price', 'mass', 'power' that it is Pareto-best in
    advice: in words
    trials: that were made; null by the law alone
    predicted? = doubt: where the verdict rests on predicted lines
    readings?: verdicts under the readings of lines whose meaning is open
    outputs
    """,
    said="One sensor of one device under one procedure, held against the requirement.",
)
@written(
    "entrant",
    """
    name
    file
    measured? not in CSV: file of the result, of a unit that was calibrated
    technology
    sensor: or 'mission', of both
    procedure
    *self as verdict
    not_given: lines of the data sheet that are absent
    missing: expected lines that are not given; null where all are
    price
    mass
    power
    over_caps: caps of the requirement that it exceeds, in words
    unknown_caps
    """,
    said="One sensor of one device under one procedure, and what its data sheet says.",
)
@dataclass(frozen=True, kw_only=True)
class Entrant(Ranked):
    """The verdict on one sensor of one device under one procedure, and its sheet.

    Of a mission it is both sensors, and `sensor` is 'mission'. Of a sensor of which no
    error line is given nothing is computed, as 0 would look like the best of all: it
    has no outputs, and its verdict is 'undecidable'.
    """

    name: str
    place: int  # of the device among those compared, as they were given
    procedure: str
    file: str
    measured: str  # file of the result, of a unit that was calibrated; '' of a sheet
    technology: str
    not_given: tuple[Name, ...]
    missing: MissingLines | None
    price: str
    mass: str
    power: str
    over_caps: tuple[str, ...]  # 'mass 140 g, at most 100 g'
    unknown_caps: tuple[UnknownCap, ...]
    vendor: str = ""  # whom to ask; '' where its file does not say
    advice: str = ""
    on_front: tuple[str, ...] = ()  # 'price', 'mass', 'power' it is Pareto-best in
    # With as many trials as the verdict took; None where nothing is known.
    counted: Counted | None = field(default=None, repr=False, compare=False)
    # With as many as its rank took; None of what the law alone has judged, too.
    closer: Judged | None = field(default=None, repr=False, compare=False)
    normals: int = 0  # that a trial of its Problem draws
    impossible: tuple[str, ...] = ()  # outputs beyond their limits without any source
    doubtful: tuple[str, ...] = ()  # for which Monte Carlo does not confirm the law

    @property
    def is_judged(self) -> bool:
        """Whether anything is known of it."""
        return bool(self.outputs)

    @property
    def parts(self) -> tuple[Entrant, ...]:
        """What it consists of: itself."""
        return (self,)

    @property
    def looked_at(self) -> Judged:
        """What its rank is of.

        Raises
        ------
        ValueError
            It was not judged by trials.
        """
        if self.closer is None:
            raise ValueError(f"{self.name} was not judged by trials")
        return self.closer

    @property
    def rests_on_others(self) -> bool:
        """Whether a line that is not given is left out, or taken from other devices."""
        filled = self.missing is not None and bool(self.missing.filling.lines)
        return self.utilisation.is_bound or (filled and not self.is_bound)

    @property
    def is_bound(self) -> bool:
        """Whether missing lines count as 0 in its numbers."""
        return self.missing is None or self.missing.is_bound

    @property
    def at_worst(self) -> float | None:
        """Utilisation with the worst in the place of what is missing; None: unknown."""
        if self.missing is None or not self.missing.is_bound:
            return self.utilisation
        return self.missing.utilisation

    @property
    def margin(self) -> float:
        """What is left of the limit, as a part of it; negative beyond [1]."""
        return 1.0 - self.utilisation


@written(
    "pair",
    f"""
    gyro
    accelerometer
    procedure
    verdict (Literal{list(VERDICTS)})
    lower_bound = utilisation.is_bound: whether the utilisation is this or more, the
      conformance this or less
    utilisation [1]: the largest over the required outputs of both
    worst_outputs: of the triad that uses most of its limits
    limiting_source = remedy.source: with the largest share there
    *known_conformance as conformance
    probability? [1]: that both meet, where lines are predicted
    """,
    said="A gyro and an accelerometer together, counted in the same trials.",
)
@written(
    "imu",
    """
    name: of the device
    rank: under its procedure
    *self as pair
    *self as verdict
    """,
    said="A gyro and an accelerometer together, counted in the same trials.",
)
@written(
    "offer",
    """
    name
    file = parts.0.file
    after = procedure: the procedure, or the maker's
    verdict: the gravest of all that is limited of it
    utilisation = worst.utilisation [1]: the largest part of a limit; null where nothing
      is known
    lower_bound = utilisation.is_bound: whether the utilisation is this or more
    worst_outputs = worst.worst_outputs or null: that use most of their limits
    limiting_source = worst.remedy.source: with the largest share there
    price = parts.0.price
    mass = parts.0.mass
    power = parts.0.power
    *self as verdict not in CSV
    """,
    said="One device after one calibration, with all that the requirement limits of "
    "it.",
)
@dataclass(frozen=True, kw_only=True)
class Unit(Ranked):
    """What is judged of several parts as one: triads, what belongs to both, a mission.

    Triads are counted in the same trials; the worst outputs and what limits them are of
    the part that uses most. Of a purchase it is all that is limited of one device.
    """

    parts: tuple[Entrant, ...] = field(repr=False, compare=False)
    order: int = 0  # of the calibration, among those at hand

    @property
    def name(self) -> str:
        """The device; of two, that of the gyro."""
        return self.parts[0].name

    gyro = name

    @property
    def accelerometer(self) -> str:
        """The device that the accelerometer is of."""
        return self.parts[-1].name

    @property
    def procedure(self) -> str:
        """What it is calibrated by: a procedure, or its maker."""
        return self.parts[0].procedure

    @property
    def is_as_made(self) -> bool:
        """Whether it is used as its maker calibrated it: no test is needed."""
        return self.procedure == UNTESTED[FACTORY]

    @property
    def is_judged(self) -> bool:
        """Whether anything is known of every part."""
        return all(one.is_judged for one in self.parts)

    @property
    def worst(self) -> Entrant | None:
        """The part that uses most of its limits; None: nothing is known of one."""
        worst = max(self.parts, key=lambda one: settle(one.utilisation))
        return worst if self.is_judged else None

    @property
    def probability(self) -> float | None:
        """Probability that all parts meet; None where nothing is predicted [1]."""
        return probability_of(self.parts)


class Listed(NamedTuple):
    """What an entrant is, and its verdict."""

    name: str
    place: int  # of the device among those compared
    sensor: str
    procedure: str
    verdict: str


def probability_of(parts: Sequence[Entrant]) -> float | None:
    """Return the probability that all parts meet; None where nothing is predicted [1].

    As if their missing lines were independent: of one device they go together, and then
    it is more.
    """
    doubts = [one.doubt for one in parts if one.doubt is not None]
    gravest = max((one.verdict for one in parts), key=VERDICTS.index)
    if not doubts or gravest != "predicted":
        return None
    return prod(doubt.probability for doubt in doubts)


@written(
    "comparison",
    """
    requirement: its name
    mission?: on which devices with both sensors are judged
    procedures
    met = is_met: whether each required sensor has a device that meets
    caps (dict[str, str]): of the requirement
    not_compared: sensors that have limits and no candidate
    inputs: files that it depends on
    settings: what it depends on besides
    devices = ranked: best first within each sensor and procedure
    nothing_known as entrant: of which no error line is given, not ranked
    imus as imu: devices of both sensors as one, best first
    pairs as pair: every gyro with every accelerometer, where asked for
    assumptions
    warnings
    """,
    commands="compare",
)
@dataclass(frozen=True, kw_only=True, repr=False)
class Comparison(Study):
    """All devices, best first within each sensor and procedure."""

    requirement: str
    mission: str = ""  # on which devices with both sensors are judged; '' without one
    procedures: tuple[str, ...]
    settings: Settings
    caps: tuple[tuple[str, str], ...]  # of the requirement: ('mass', '2 kg')
    not_compared: tuple[str, ...]  # sensors that have limits and no candidate
    devices: Sequence[Entrant]
    nothing_known: Sequence[Entrant]  # no error line given: undecidable, not ranked
    # Sensors that have limits and candidates, of which none can be tested (range).
    untested: tuple[str, ...] = ()
    # Devices of both sensors as one, best first under each procedure.
    imus: Sequence[Unit] = ()
    pairs: tuple[Unit, ...]  # every gyro with every accelerometer, where asked for

    def output_frame(self) -> pd.DataFrame:
        """Return its CSV document as a pandas frame: each device, required output."""
        table: pd.DataFrame = views.view().output_frame(self)
        return table

    @cached_property
    def listed(self) -> list[Listed]:
        """What each of the entrants is; of thousands they are looked up once."""
        return [
            Listed(
                name=intern(one.name),
                place=one.place,
                sensor=intern(one.sensor),
                procedure=intern(one.procedure),
                verdict=intern(one.verdict),
            )
            for one in self.entrants
        ]

    @property
    def required(self) -> tuple[str, ...]:
        """Sensors that have limits and candidates."""
        return tuple(dict.fromkeys(one.sensor for one in self.listed))

    @property
    def entrants(self) -> Iterator[Entrant]:
        """All that was to be compared: what was judged, then what nobody can judge."""
        return chain(self.devices, self.nothing_known)

    @property
    def is_met(self) -> bool:
        """Whether each required sensor has a device that meets."""
        return self.has(("meets",))

    def has(self, verdicts: Sequence[str]) -> bool:
        """Whether each required sensor has a device with one of these verdicts."""
        found = {one.sensor for one in self.listed if one.verdict in verdicts}
        return not self.untested and found.issuperset(self.required)

    @cached_property
    def lists(self) -> dict[tuple[str, str], Sequence[Entrant]]:
        """Devices by (sensor, procedure), sensor by sensor, best first."""
        places: dict[tuple[str, str], list[int]] = {
            (sensor, procedure): []
            for sensor in self.required
            for procedure in self.procedures
        }
        for place, one in enumerate(self.listed[: len(self.devices)]):
            places[one.sensor, one.procedure].append(place)
        return {
            key: Made(self.devices.__getitem__, own).held()
            for key, own in places.items()
        }

    @property
    def ranked(self) -> Iterator[Entrant]:
        """The devices, sensor by sensor, best first."""
        return chain.from_iterable(self.lists.values())
