"""What a mission file says of temperature and vibration that are known on the way."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from budget.inputs.aiding import Spanned
from budget.inputs.fields import (
    TIME,
    Keyed,
    KeyRow,
    Rows,
    Rule,
    Rules,
    Sign,
    ValueKind,
    fault,
    items,
    measured,
    not_rising,
    or_else,
    table,
)
from budget.model.course import Fading, Profile, Stretches

if TYPE_CHECKING:
    from collections.abc import Iterable

    from budget.inputs.records import ErrorLine
    from budget.inputs.tree import Node
    from budget.model.course import Course
    from budget.units import Quantity

MOST_POINTS = 1000  # of a profile
_ROUNDING = 1e-9  # of a time, relative
TEMPERATURE = measured("degC", Sign.ANY)
LEVEL = measured("g")
EXAMPLE = "{reference: 25 degC, profile: [[0 s, 20 degC], [600 s, 45 degC]]}"
Faults = dict[tuple[str | int, ...], str]  # what is wrong, by the way to it
_SHOWN = EXAMPLE.replace("{", "{{").replace("}", "}}")
_LACKS = (
    f"stands without %s, expected such as {_SHOWN}; reference is the temperature of "
    "the calibration"
)
_TWICE = (
    "stands beside warm_up, which ends at that of the calibration; remove one of them"
)


@dataclass(frozen=True, kw_only=True)
class KnownCourse:
    """A course, and how it is shown."""

    course: Course
    printed: str
    unit: str


WARM_UP = table(
    rows={
        "by": KeyRow(
            TEMPERATURE,
            "how far it is below that of the calibration at the start",
            is_needed=True,
        ),
        "time": KeyRow(
            measured("s", Sign.POSITIVE),
            "in which it comes as near as 1/e",
            is_needed=True,
        ),
    },
    title="WarmUp",
)


class TemperaturePart(Keyed):
    """A temperature that is known at every time, in place of how far it may be off."""

    rows: ClassVar[Rows] = {
        "reference": KeyRow(
            TEMPERATURE, "beside a profile: the temperature of the calibration"
        ),
        "profile": KeyRow(
            items(items(TIME, TEMPERATURE), most=MOST_POINTS),
            "points of time from the mission's start and temperature, linear "
            "between them and constant beyond",
        ),
        "warm_up": KeyRow(
            WARM_UP,
            "in place of a profile: it comes to that of the calibration: T - T0 = "
            "-by exp(-t/time)",
        ),
    }
    rules: ClassVar[Rules] = (
        *(
            Rule(key, lambda it, key=key: it.warm_up and getattr(it, key), _TWICE)
            for key in ("reference", "profile")
        ),
        Rule(
            "reference",
            lambda it: it.profile is None and not it.warm_up,
            _LACKS % "profile",
        ),
        Rule(
            "profile",
            lambda it: it.reference is None and not it.warm_up,
            _LACKS % "reference",
        ),
        Rule(
            "profile",
            lambda it: it.profile is not None and not it.profile[1:],
            f"names fewer points than two, expected such as {_SHOWN}",
        ),
    )

    def _faults(self) -> Faults:
        """Return what is wrong with the points of a profile."""
        if self.profile is None or self.reference is None or self.warm_up:
            return {}
        rise = "is at {after} after {one}, expected times that rise"
        units = {
            ("profile", place): f"found {one.printed!r} beside a reference of "
            f"{self.reference.printed!r}, expected the same unit in both: their zeros "
            "differ"
            for place, (_, one) in enumerate(self.profile)
            if one.unit != self.reference.unit
        }
        return not_rising([time for time, _ in self.profile], "profile", rise) | units

    def late(self, end: float) -> Faults:
        """Return what is said of times after the mission's end [s]."""
        return {
            ("profile", place): f"is at {time.printed}, and the mission ends at "
            f"{end:.6g} s; expected times within it"
            for place, (time, _) in enumerate(self.profile or ())
            if time.value > end * (1.0 + _ROUNDING)
        }

    def is_short(self, end: float) -> bool:
        """Say whether a profile does not reach from the start to the end [s]."""
        points: Any = self.profile or ()
        return bool(points) and not (
            points[0][0].value == 0.0 and points[-1][0].value >= end * (1.0 - _ROUNDING)
        )

    @property
    def known(self) -> KnownCourse:
        """The course as a record."""
        if self.warm_up is not None:
            by, time = self.warm_up.by, self.warm_up.time
            return KnownCourse(
                course=Fading(by=by.value, time=time.value),
                printed=f"{-by.value:.6g} degC to 0 degC",
                unit="degC",
            )
        zero = self.reference.value if self.reference else 0.0
        times, values = zip(*self.profile or (), strict=True)
        found = Profile(
            times=tuple(time.value for time in times),
            values=tuple(value.value - zero for value in values),
        )
        ends = (f"{end(found.values):.6g} degC" for end in (min, max))
        return KnownCourse(
            course=found, printed=" to ".join(dict.fromkeys(ends)), unit="degC"
        )


class VibrationPart(Spanned):
    """A vibration, rms, and when it is there."""

    rows: ClassVar[Rows] = {"value": KeyRow(LEVEL, "rms", is_needed=True)}


def stretches(
    spans: Iterable[tuple[float, float, Quantity]], rest: ErrorLine, end: float
) -> KnownCourse:
    """Return the course of vibrations in spans that are apart, to an end [s]."""
    elsewhere = (float(rest.u[0]), rest.printed, rest.unit)
    begins, sizes, last = [0.0], [elsewhere], 0.0
    for begin, stop, one in sorted(spans, key=lambda span: span[:2]):
        if begin <= last * (1.0 + _ROUNDING):
            del begins[-1], sizes[-1]
        begins += [begin, stop]
        sizes += [(one.value, one.printed, one.unit), elsewhere]
        last = stop
    if begins[-1] >= end * (1.0 - _ROUNDING):
        del begins[-1], sizes[-1]
    (_, low, _), (_, high, unit) = min(sizes), max(sizes)
    return KnownCourse(
        course=Stretches(tuple(begins), tuple(value for value, *_ in sizes)),
        printed=" to ".join(dict.fromkeys((low, high))),
        unit=unit,
    )


def or_size(course: ValueKind, size: ValueKind, keys: Iterable[str] = ()) -> ValueKind:
    """Allow, beside a course, a size: a mapping with none of these keys, or a text."""
    known = {*keys}

    def read(node: Node, gravity: float, course: Any) -> object:  # noqa: ANN401
        value = node.value
        if known and str(value).lstrip().startswith("-"):
            raise fault(
                f"found {value!r}, expected the size of the difference from the test, "
                "1 sigma and without sign; one that is known goes under 'reference' "
                "and 'profile', as in {reference: 25 degC, profile: [[0 s, -20 degC], "
                "[60 s, -20 degC]]}"
            )
        is_course = (
            isinstance(value, dict) and bool(value.keys() & known)
            if known
            else isinstance(value, tuple)
        )
        return course(node, gravity) if is_course else size.read(node, gravity)

    return or_else(course, read, size)
