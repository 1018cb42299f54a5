"""Verdicts: what they are on, what they hold if, and how sure they are."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, prod
from typing import TYPE_CHECKING, Self

from budget.documents import Documented, written
from budget.known import Known
from budget.results.outputs import INTERACTION, TINY, JudgedOutput, worst_of
from budget.sentences import sentence
from budget.ties import settle

if TYPE_CHECKING:
    from collections.abc import Iterable

    from budget.names import Name
    from budget.results.doubts import Doubt, ReadingVerdicts

# Verdicts, best first; of parts put together the last one rules.
VERDICTS = ("meets", "meets_if", "predicted", "undecided", "undecidable", "fails")


@written(
    "conformance",
    """
    conformance = value [1]: probability of being within all limits; null where nothing
      is known of it
    conformance_interval = interval [1]: 95 % sampling; null by the law
    """,
)
@dataclass(frozen=True, kw_only=True)
class Probability(Documented):
    """A probability with its 95 % sampling interval [1]."""

    value: float
    low: float | None  # None where it is computed by the law: not sampled, not exact
    high: float | None

    @property
    def interval(self) -> tuple[float, float] | None:
        """Both ends, where there are any."""
        low, high = self.low, self.high
        return None if low is None or high is None else (low, high)


@written(
    "condition",
    """
    kind: 'missing', 'temperature', 'vibration', 'age'
    line
    below / unit: the bound; null where none is needed, or known
    unit
    largest_comparable / unit: the largest that a comparable device prints, as a
      standard uncertainty
    ceiling / unit: the largest that is thought of
    decides: whether it leaves the verdict open
    not_given = silent: lines of a use that nobody has stated
    text: in words
    """,
)
@written(
    "caution",
    """
    kind
    line
    text: in words
    bound [unit]
    unit
    """,
    said="What qualifies a verdict, beside it wherever it stands.",
)
@dataclass(frozen=True, kw_only=True)
class Condition(Documented):
    """What must hold for a verdict, or what decides it and has to be asked for.

    Of a line that is not given, or of a use that nobody has stated. Or what qualifies
    it, beside it wherever it stands.
    """

    kind: str  # 'missing', 'temperature', 'vibration', 'age', ...
    line: Name
    text: str
    # The bound [SI]; None: none is needed, or none is known.
    below: float | None = None
    unit: str = ""
    si_per_unit: float = 1.0
    # The largest that a comparable device prints, as a standard uncertainty [SI].
    largest_comparable: float | None = None
    ceiling: float | None = None  # [SI]
    decides: bool = False  # whether it leaves the verdict open, being not given
    # Lines of a use that nobody has stated, which its sheet does not give.
    silent: tuple[Name, ...] = ()

    @property
    def bound(self) -> float | None:
        """The bound in its unit, where there is one."""
        return None if self.below is None else self.below / self.si_per_unit


@dataclass(frozen=True, kw_only=True)
class Remedy:
    """The source that limits a sensor, and what its line alone would have to be."""

    source: Name
    share: float  # of the variance of the worst output [1]
    factor: float | None  # on its standard uncertainty; None: it alone cannot mend it


# Of what nobody can judge.
UNJUDGED = Known(inf, low=-inf)
NO_REMEDY = Remedy(source=INTERACTION, share=0.0, factor=None)
NO_CONFORMANCE = Probability(value=0.0, low=0.0, high=1.0)


@written(
    "sensor_verdict",
    """
    sensor
    *self as verdict
    utilisation [1]: the largest over its required outputs
    utilisation_interval [1]: 95 % sampling, and the law's error
    worst_output: that uses most of its limit
    worst_outputs: that one and all that are equal to it
    limiting_source = remedy.source: with the largest share there
    *known_conformance as conformance
    trials: that were made; null by the law alone
    expected_missing: lines that a 'meets' cannot do without
    nothing_known: whether no error line is given
    predicted? = doubt: where the verdict rests on predicted lines
    not_estimated?: parameters with limits that are held in the test
    readings?: verdicts under the readings of lines whose meaning is open
    """,
    said="The verdict on one triad.",
)
@written(
    "standing",
    """
    sensor: or 'mission'
    *self as verdict
    """,
    said="A verdict and what it stands on, the same in every command.",
)
@written(
    "verdict",
    f"""
    verdict (Literal{list(VERDICTS)})
    calibration: after which
    station: at which
    use: in which
    mission or null: on which
    decision: by which rule limits are held
    conditions: that it rests on, or that decide
    cautions as caution
    utilisation_at_ceilings = at_ceilings [1]: with every missing line at its ceiling;
      null where one has none
    """,
    said="A verdict and what it stands on, the same in every command.",
)
@dataclass(frozen=True, kw_only=True)
class Verdict(Documented):
    """A verdict and what it stands on, the same in every command.

    On a sensor, on what belongs to both, or on a mission. In words: after which
    calibration, at which station, in which use, of which mission.
    """

    # 'meets', 'meets_if', 'predicted', 'undecided', 'undecidable', 'fails'.
    verdict: str
    conditions: tuple[Condition, ...] = ()  # that it holds if, or that decide
    cautions: tuple[Condition, ...] = ()
    # Utilisation with every missing line at its ceiling [1]; None: one has none.
    at_ceilings: float | None = None
    calibration: str = ""
    station: str = ""
    use: str = ""
    mission: str = ""
    decision: str = ""  # by which rule limits are held
    # Lines that are not given and, whatever they are, take next to nothing of a limit.
    negligible: tuple[Name, ...] = ()
    sensor: str = ""  # gyro, accelerometer; 'imu' of both, 'mission'
    # Required outputs against their limits; () of what nobody can judge, and below.
    outputs: tuple[JudgedOutput, ...] = ()
    utilisation: Known = UNJUDGED  # the largest of them [1]
    # 95 % sampling, and the law's error [1].
    utilisation_interval: tuple[float, float] = (0.0, inf)
    worst_outputs: tuple[Name, ...] = ()  # the worst, and all equal to it by the law
    remedy: Remedy = NO_REMEDY
    # Of all outputs together.
    conformance: Probability = NO_CONFORMANCE
    at_medians: bool = False  # its numbers are those at medians of predicted lines
    trials: int | None = None  # that were made; None by the law alone
    expected_missing: tuple[Name, ...] = ()  # lines that a 'meets' cannot do without
    nothing_known: bool = False  # no error line is given: a 0 is no good news
    doubt: Doubt | None = None  # of a verdict that rests on predicted lines
    not_estimated: tuple[Name, ...] = ()  # parameters with limits, held in the test
    readings: ReadingVerdicts | None = None  # where the meaning of lines is open

    @property
    def saturates(self) -> bool:
        """Whether a mission asks for more than a sensor reads.

        Its numbers are then those of one that reads enough.
        """
        return any(one.kind == "saturates" for one in self.cautions)

    @property
    def misses(self) -> bool:
        """Whether it is up to a line that nothing stands for.

        Its numbers are then that or more, and what is sure of it that or less.
        """
        is_open = any(one.ceiling is not None for one in self.conditions)
        return is_open or self.verdict == "undecidable"

    def matter(self, lacks: Iterable[Name]) -> tuple[Name, ...]:
        """Return of lines that are not given those that its limits are open to."""
        return tuple(name for name in lacks if name not in self.negligible)

    @property
    def asks(self) -> tuple[Condition, ...]:
        """The lines to ask the maker for, that which decides first."""
        return tuple(one for one in self.conditions if one.decides)

    @property
    def after(self) -> str:
        """Say what it is of: calibration, mission, use."""
        return sentence(
            "conditions.after",
            calibration=self.calibration,
            mission=self.mission,
            use=self.use,
        )

    @property
    def worst_output(self) -> Name:
        """The output that uses most of its limit; of equal ones the first."""
        return worst_of(self.outputs).output.name

    @property
    def known_conformance(self) -> Probability | None:
        """None where its numbers are not those of what is there.

        At the medians of predicted lines it would look better than it is.
        """
        is_other = self.at_medians or self.nothing_known or self.saturates
        return None if is_other else self.conformance

    @property
    def is_near(self) -> bool:
        """Whether it is undecided because its interval does not tell on which side."""
        low, high = map(settle, self.utilisation_interval)
        return self.verdict == "undecided" and low <= 1.0 < high

    @property
    def is_open_by_reading(self) -> bool:
        """Whether it is undecided because another reading of its lines fails."""
        is_all = self.readings is None or self.readings.passes == "all"
        return self.verdict == "undecided" and not self.is_near and not is_all

    def beside(self, other: Verdict) -> Self:
        """Return how both stand as one: the graver, what both hold if, and cautions.

        What both say alike stands once; numbers are those of the one that uses most.
        """
        ceilings = (self.at_ceilings, other.at_ceilings)
        known = [used for used in ceilings if used is not None]
        both: tuple[Verdict, ...] = (self, other)
        worst = max(both, key=lambda one: settle(one.utilisation))
        return replace(
            self,
            verdict=max(self.verdict, other.verdict, key=VERDICTS.index),
            outputs=(*self.outputs, *other.outputs),
            utilisation=Known.largest(one.utilisation for one in both),
            utilisation_interval=worst.utilisation_interval,
            worst_outputs=worst.worst_outputs,
            remedy=worst.remedy,
            at_medians=self.at_medians or other.at_medians,
            doubt=None,
            readings=None,
            conditions=tuple(dict.fromkeys((*self.conditions, *other.conditions))),
            cautions=tuple(dict.fromkeys((*self.cautions, *other.cautions))),
            at_ceilings=max(known) if len(known) == len(ceilings) else None,
        )


@written(
    "cap_assessment",
    """
    device
    merit: 'price', 'mass' or 'power'
    cap: as the requirement gives it
    given: as the device file gives it; '' where it does not
    is_within: null where nobody can tell
    """,
)
@dataclass(frozen=True, kw_only=True)
class CapAssessment:
    """What one device costs, weighs or draws against a cap; it decides no verdict."""

    device: str
    merit: str  # 'price', 'mass' or 'power'
    cap: str  # as the requirement file gives it
    given: str  # as the device file gives it; '' where it does not
    is_within: bool | None  # None where nobody can tell


@written(
    "assessment",
    """
    requirement: its name
    verdict: the gravest of the sensors; of limits to be kept together that of all
    *conformance as conformance
    sensors
    outputs
    not_there: sensors with limits that no device has
    caps
    """,
)
@dataclass(frozen=True, kw_only=True)
class Assessment(Documented):
    """A budget held against a requirement."""

    requirement: str  # its name
    outputs: tuple[JudgedOutput, ...]
    sensors: tuple[Verdict, ...]
    conformance: Probability | None  # of all outputs together; None: nothing known
    not_there: tuple[str, ...] = ()  # sensors with limits that no device has
    caps: tuple[CapAssessment, ...] = ()
    # Probability that all limits are to be kept together with; None: each alone [1].
    together: float | None = None

    @property
    def chance(self) -> float | None:
        """Probability that all sensors meet; None where nothing is predicted.

        As if the missing lines of two sensors were independent: of one device they go
        together, and then it is more.
        """
        doubts = [one.doubt for one in self.sensors if one.doubt is not None]
        return prod(one.probability for one in doubts) if doubts else None

    @property
    def verdict(self) -> str:
        """The gravest of the sensors; of limits to be kept together that of all."""
        found = max((one.verdict for one in self.sensors), key=VERDICTS.index)
        p = self.conformance
        if self.together is not None and p is not None and p.value < self.together:
            return VERDICTS[-1]
        return found

    @property
    def judged(self) -> tuple[JudgedOutput, ...]:
        """Outputs of which something is known."""
        unknown = {one.sensor for one in self.sensors if one.nothing_known}
        return tuple(
            row
            for row in self.outputs
            if row.output.name.owner not in unknown and not row.is_unknown
        )

    def outcome(self, row: JudgedOutput) -> str:
        """Return 'conforms', 'does not conform', or 'open' where its sensor's limit is.

        In the words of JCGM 106:2012, the largest error being held against the limit.
        """
        for sensor in self.sensors:
            if row.output.name.owner == sensor.sensor:
                low, high = sensor.utilisation_interval
                part = row.utilisation / max(sensor.utilisation, TINY)
                if sensor.verdict == "undecided" and low * part <= 1.0 < high * part:
                    return "open"
        return "conforms" if row.is_within else "does not conform"

    @property
    def open_rows(self) -> tuple[JudgedOutput, ...]:
        """Outputs that lines not given leave open; on conditions they are within."""
        waits = {one.sensor for one in self.sensors if one.verdict != "meets_if"}
        return tuple(
            row
            for row in self.outputs
            if row.lower_bound and row.is_within and row.output.name.owner in waits
        )
