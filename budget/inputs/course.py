"""What a mission file says of temperature and vibration that are known on the way."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import Field
from pydantic_core import core_schema

from budget.inputs.aiding import Spanned
from budget.inputs.fields import (
    Later,
    Measured,
    Rule,
    Ruled,
    Sign,
    Strict,
    Time,
    fault,
    not_rising,
)
from budget.model.course import Fading, Profile, Stretches
from budget.units import Quantity

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from pydantic import GetCoreSchemaHandler, ValidationInfo
    from pydantic_core import CoreSchema

    from budget.inputs.records import ErrorLine
    from budget.model.course import Course

MOST_POINTS = 1000  # of a profile
_ROUNDING = 1e-9  # of a time, relative
Temperature = Annotated[Quantity, Measured("degC", Sign.ANY)]
Level = Annotated[Quantity, Measured("g")]
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


class WarmUpPart(Strict):
    """T - T0 = -by exp(-t/time), T0 the temperature of the test."""

    by: Temperature = Field(
        description="how far it is below that of the calibration at the start"
    )
    time: Annotated[Quantity, Measured("s", Sign.POSITIVE)] = Field(
        description="in which it comes as near as 1/e"
    )


class TemperaturePart(Ruled):
    """A temperature that is known at every time, in place of how far it may be off."""

    reference: Temperature | None = Field(
        default=None, description="beside a profile: the temperature of the calibration"
    )
    profile: tuple[tuple[Time, Temperature], ...] | None = Field(
        default=None,
        max_length=MOST_POINTS,
        description="points of time from the mission's start and temperature, linear "
        "between them and constant beyond",
    )
    warm_up: WarmUpPart | None = Field(
        default=None,
        description="in place of a profile: it comes to that of the calibration",
    )

    rules: ClassVar[tuple[Rule, ...]] = (
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
        points = self.profile or ()
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

    value: Level = Field(description="rms")


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


@dataclass(frozen=True)
class SizeOrCourse:
    """A size, or a course in its place."""

    size: Any  # type of it
    course: Any  # likewise
    keys: tuple[str, ...] = ()  # of a mapping that is a course; () where it is a list

    def read(
        self,
        value: Any,  # noqa: ANN401
        size: Callable[[object], object],
        info: ValidationInfo,
    ) -> object:
        """Return either; what is wrong with it has its place in it."""
        if self.keys and str(value).lstrip().startswith("-"):
            raise fault(
                f"found {value!r}, expected the size of the difference from the test, "
                "1 sigma and without sign; one that is known goes under 'reference' "
                "and 'profile', as in {reference: 25 degC, profile: [[0 s, -20 degC], "
                "[60 s, -20 degC]]}"
            )
        is_list = isinstance(value, list | tuple)
        if (isinstance(value, dict) and value.keys() & self.keys) or (
            is_list and not self.keys
        ):
            return Later(lambda: self.course).read(value, info)
        return size(value)

    def __get_pydantic_core_schema__(
        self, source: object, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Tell pydantic how to read either, and how to describe both."""
        size = handler.generate_schema(self.size)
        both = [size, handler.generate_schema(self.course)]
        return core_schema.json_or_python_schema(
            json_schema=core_schema.union_schema(both),  # type: ignore[arg-type]
            python_schema=core_schema.with_info_wrap_validator_function(
                self.read, size
            ),
        )
