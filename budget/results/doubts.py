"""What a verdict rests on that no data sheet says: stand-ins, readings, doubt."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from budget.documents import Documented, written
from budget.sentences import sentence

if TYPE_CHECKING:
    from budget.names import Name


# Verdicts, best first; of parts put together the last one rules.
@written(
    "filled_line",
    """
    source: the line that stands for it
    stands_for = expected: the expected line
    printed: of 'worst' as that device's file gives it
    unit
    standard_uncertainty = u / unit: of the largest axis; of 'predict' the median
    devices: how many give the line and are comparable
    designs: that these are variants of; null of 'worst'
    of = owners: of 'worst' the one device, else all that it comes from
    interval_50 / unit: of the standard uncertainty, by 'predict'
    interval_90 / unit: likewise
    """,
)
@dataclass(frozen=True, kw_only=True)
class FilledLine(Documented):
    """A line in the place of an expected one that is not given."""

    source: Name
    expected: Name  # what it stands for, 'gyro.noise'
    mode: str  # 'worst', 'typical' or 'predict'
    printed: str  # of 'worst' as that device's file gives it
    u: float  # of the largest axis; of 'predict' the median [SI]
    unit: str
    si_per_unit: float
    owners: tuple[str, ...]  # of 'worst' the one device, else all that it comes from
    devices: int  # that give the line and are comparable
    designs: int | None = None  # that these are variants of; None of 'worst'
    interval_50: tuple[float, float] | None = None  # of u, by 'predict' [SI]
    interval_90: tuple[float, float] | None = None

    def __str__(self) -> str:
        """'gyro.bias_stability 24 deg/h (of NAME)', or from how many devices."""
        return f"{self.source} {self.printed} ({self.basis})"

    @property
    def basis(self) -> str:
        """'of NAME', 'median of 3 designs', 'predicted from 9 devices of 4 designs'."""
        ends = self.interval_90
        return sentence(
            "filled.basis",
            owner=self.owners[0] if self.mode == "worst" else "",
            devices=self.devices,
            designs=self.designs,
            ends=None if ends is None else tuple(map(self._print, ends)),
        )

    @property
    def origin(self) -> str:
        """The basis, with how many devices the worst is of."""
        if self.mode != "worst":
            return self.basis
        return sentence("filled.worst", owner=self.owners[0], devices=self.devices)

    @property
    def words(self) -> str:
        """Say what was taken for it."""
        return sentence("filled.words", printed=self.printed, origin=self.origin)

    def _print(self, u: float) -> str:
        """Print a size to three digits."""
        return f"{float(f'{u / self.si_per_unit:.3g}'):g}"


@written(
    "ask",
    """
    source: the expected line
    reduction [1]: expected, of the doubt, were it known
    """,
)
@dataclass(frozen=True, kw_only=True)
class Ask:
    """A line that is not given, and what it is worth to be told it."""

    source: Name  # the expected line
    reduction: float  # expected, of the doubt min(p, 1 - p), were it known [1]


@written(
    "predicted",
    """
    probability [1]: that every largest error is within its limit
    doubt [1]: risk of the likelier verdict, min(p, 1 - p)
    utilisation_90 [1]: central 90 % of the utilisation
    worth_asking = asks: lines to ask for, the one that is worth most first
    """,
)
@dataclass(frozen=True, kw_only=True)
class Doubt(Documented):
    """Probability that a device meets over what its missing lines may be."""

    probability: float  # that every largest error is within its limit [1]
    utilisation_90: tuple[float, float]  # central 90 % of the utilisation [1]
    asks: tuple[Ask, ...]  # the one that is worth most first

    @property
    def doubt(self) -> float:
        """min(p, 1 - p): the risk of the likelier verdict [1]."""
        return min(self.probability, 1.0 - self.probability)


@written(
    "reading_effect",
    """
    line: whose meaning the data sheet leaves open
    reading
    taken: the reading that the numbers stand on
    output: whose standard uncertainty changes most
    ratio or null [1]: of that, over the one with the reading taken; null over 0
    """,
)
@dataclass(frozen=True, kw_only=True)
class ReadingEffect(Documented):
    """How another reading of one line alone changes the standard uncertainties."""

    line: Name  # whose meaning the data sheet leaves open
    reading: str
    taken: str  # the one that the numbers stand on
    output: Name  # whose u changes most
    ratio: float  # of its u, over that with the reading taken; inf over 0 [1]


@written(
    "reading",
    """
    readings = words (dict[str, str]): by line
    verdict
    utilisation [1]: the largest over the required outputs
    """,
)
@dataclass(frozen=True, kw_only=True)
class ReadingVerdict:
    """The verdict under one combination of readings."""

    words: tuple[tuple[Name, str], ...]  # by line
    verdict: str
    utilisation: float  # the largest over the required outputs [1]


@written(
    "reading_verdicts",
    """
    combinations = total: of readings, that there are
    passes: under which it meets, 'all', 'some' or 'none' of those computed
    computed = found: the reading that is taken first
    """,
)
@dataclass(frozen=True, kw_only=True)
class ReadingVerdicts(Documented):
    """The verdicts on one sensor under the readings of its open lines."""

    sensor: str
    total: int  # combinations that there are
    found: tuple[ReadingVerdict, ...]  # those computed, the one that is taken first

    @property
    def passing(self) -> tuple[ReadingVerdict, ...]:
        """Those under which it meets."""
        return tuple(one for one in self.found if one.verdict == "meets")

    @property
    def passes(self) -> str:
        """Under which readings it meets: 'all', 'some' or 'none' of those computed."""
        if len(self.passing) == len(self.found):
            return "all"
        return "some" if self.passing else "none"
