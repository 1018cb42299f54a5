"""Mission files: where a calibrated unit goes by itself, and what it knows of that."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from itertools import pairwise
from math import atan, ceil, degrees, floor, pi, remainder
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from budget.earth import normal_gravity
from budget.inputs.aiding import (
    AIDS,
    ALIGNMENT,
    FILTER,
    MOST_EPOCHS,
    PERFECT,
    SELF,
    ZERO_VELOCITY,
    AidingPart,
    AlignmentPart,
    FilterPart,
)
from budget.inputs.course import LEVEL, TemperaturePart, VibrationPart, stretches
from budget.inputs.fields import (
    SPAN,
    TEXT,
    FieldGroup,
    Keyed,
    KeyRow,
    Rows,
    Rule,
    Rules,
    Sign,
    ValueKind,
    check,
    faults,
    format_row,
    given_of,
    items,
    measured,
    not_rising,
    number,
    one_of,
    table,
)
from budget.inputs.files import exists, unshown
from budget.inputs.procedure import MOST_HEIGHT
from budget.inputs.records import Mission, Origin
from budget.inputs.trajectory import (
    LEAST_SPEED,
    LONGEST,
    MOST_LATITUDE,
    MOST_SPEED,
    read_trajectory,
)
from budget.inputs.tree import describe
from budget.inputs.use import (
    AGE_ROW,
    ON_THE_WAY_ROW,
    Stated,
    stated_line,
    stated_lines,
)
from budget.navigation.route import STEP, TURN_STEP, Leg, Legs, Start, Track, moved
from budget.sentences import sentence

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from budget.inputs.aiding import AidPart
    from budget.inputs.trajectory import Recorded
    from budget.inputs.tree import YamlFile
    from budget.units import Quantity

COORDINATED = "coordinated"
AIDED, FREE = "aided", "free"
SHORTEST = 1e-3  # of a segment [s]
MOST_SEGMENTS = 10_000
MOST_STEPS = 10_000  # in which errors are carried along: 160 turns, 83 h of level
# That are asked for: the law has second derivatives of every output.
MOST_TIMES = 16
DECADES = (10.0, 60.0, 600.0, 3600.0)  # asked for where nothing is said [s]
_ROUNDING = 1e-9  # of a time, relative
_SAME = 1e-6  # of a heading [rad], and of a speed, relative

Faults = dict[tuple[str | int, ...], str]  # what is wrong, by the way to it

# What a segment may be, and which keys say more of it.
MOVES = {
    "stand": (),
    "straight": ("speed", "heading"),
    "turn": ("rate", "bank", "roll_rate"),
    "climb": ("rate",),
    "accelerate": ("to",),
}
# What a trajectory says in their place.
PLACED = ("latitude", "longitude", "height", "speed", "heading", "segments")
START = ("speed", "heading")  # what a mission and its first straight may say
MEANWHILE = ("aiding", "vibration")  # what a group says of all its segments
NEEDED = {"turn": "3 deg/s", "climb": "5 m/s", "accelerate": "100 m/s"}
TOO_FAST = f"expected {MOST_SPEED / 1e3:g} km/s at the most"
MOVING = (  # of what moves and would align itself
    "is by the unit itself, and the mission begins at {speed} m/s; level and north are "
    "found standing: begin with a stand, or align it perfectly"
)


def _beyond(angle: Quantity | None, most: float) -> bool:
    """Say whether an angle, if there is one, is larger than the most [rad]."""
    return angle is not None and abs(angle.value) > most * (1.0 + _ROUNDING)


SPEED = measured("m/s", bare=True)
ANGLE = measured("deg", Sign.ANY, bare=True)
TURN_RATE = measured("deg/s", Sign.POSITIVE)
CLIMB_RATE = measured("m/s", Sign.ANY)


# A velocity beside a climb, an angular rate beside anything else.
RATE = ValueKind(
    schema={"anyOf": [TURN_RATE.schema, CLIMB_RATE.schema]},
    beside=lambda node: (
        CLIMB_RATE if node.child("climb") and not node.child("turn") else TURN_RATE
    ),
)


class SegmentLine(Keyed):
    """What a level vehicle does for a while."""

    rows: ClassVar[Rows] = {
        "stand": KeyRow(SPAN, "how long it stands still"),
        "straight": KeyRow(SPAN, "how long it goes on as it does"),
        "turn": KeyRow(ANGLE, "of the heading; positive to the right, as headings"),
        "climb": KeyRow(SPAN, "how long it climbs or sinks"),
        "accelerate": KeyRow(SPAN, "how long its speed changes, evenly"),
        "speed": KeyRow(
            SPEED,
            "beside straight: of the first segment how fast the mission "
            "begins, of others the speed that is reached by then",
        ),
        "heading": KeyRow(ANGLE, "beside straight: likewise, from north to east"),
        "rate": KeyRow(RATE, "beside turn: deg/s; beside climb: m/s, upwards"),
        "bank": KeyRow(
            one_of("level", COORDINATED),
            "beside turn: level (unset), or coordinated, which leans so far "
            "that nothing pulls aside",
        ),
        "roll_rate": KeyRow(TURN_RATE, "beside bank: at which it is entered and left"),
        "to": KeyRow(SPEED, "beside accelerate: the speed at its end"),
        "repeat": KeyRow(
            number(1, MOST_SEGMENTS), "times one after the other", usual=1
        ),
        "aiding": KeyRow(AIDS, "what is measured meanwhile, of mission.aiding"),
        "vibration": KeyRow(LEVEL, "meanwhile, rms; elsewhere that of environment"),
    }
    rules: ClassVar[Rules] = (
        Rule(
            "stand",
            lambda it: not it.moves,
            f"says not what the vehicle does, expected one of {', '.join(MOVES)}, such "
            "as 'stand: 60 s'",
        ),
        *(
            Rule(
                key,
                lambda it, key=key: key in it.moves[1:],
                "stands beside {move}, and a segment is one thing; give each a segment "
                "of its own",
            )
            for key in MOVES
        ),
        *(
            Rule(
                key,
                lambda it, key=key: (
                    it.moves
                    and getattr(it, key) is not None
                    and key not in MOVES[it.move]
                ),
                f"is of {owners}, and this is {{move}}; remove it{more}",
            )
            for key, owners, more in (
                (
                    key,
                    " or ".join(move for move, keys in MOVES.items() if key in keys),
                    f"; for the {key} at the start put it under mission.{key}"
                    if key in START
                    else "",
                )
                for key in ("speed", "heading", "rate", "bank", "roll_rate", "to")
            )
        ),
        *(
            Rule(
                key,
                lambda it, key=key: (
                    it.moves
                    and it.move != "turn"
                    and (one := getattr(it, key))
                    and abs(one.value) > MOST_SPEED
                ),
                f"found {{{key}!r}}, {TOO_FAST}",
            )
            for key in ("speed", "to", "rate")
        ),
        *(
            Rule(
                move,
                lambda it, move=move, key=MOVES[move][0]: (
                    it.move == move and getattr(it, key) is None
                ),
                f"stands without {MOVES[move][0]}, expected '{MOVES[move][0]}: "
                f"{value}' there",
            )
            for move, value in NEEDED.items()
        ),
        Rule(
            "bank",
            lambda it: it.moves and it.bank == COORDINATED and it.roll_rate is None,
            "stands without roll_rate, expected 'roll_rate: 20 deg/s' there",
        ),
        Rule(
            "roll_rate",
            lambda it: it.moves and it.bank != COORDINATED and it.roll_rate,
            "is of 'bank: coordinated', which is not there; add it, or remove this",
        ),
        *(
            Rule(
                move,
                lambda it, move=move: (
                    it.moves == [move]
                    and (move != "turn" or it.rate)
                    and not SHORTEST <= it.length <= LONGEST * (1.0 + _ROUNDING)
                ),
                f"takes {{length:.6g}} s, expected {SHORTEST:g} s to 24 h",
            )
            for move in MOVES
        ),
    )

    @property
    def moves(self) -> list[str]:
        """What it is said to be: 'stand', 'turn', ...; one thing, if it is sound."""
        return [key for key in MOVES if getattr(self, key) is not None]

    @property
    def move(self) -> str:
        """What it is."""
        return next(iter(self.moves), "")

    @property
    def length(self) -> float:
        """How long it takes once [s]."""
        if self.turn is not None and self.rate is not None:
            return float(abs(self.turn.value) / self.rate.value)
        span: Quantity = getattr(self, self.move)
        return span.value

    @property
    def steps(self) -> int:
        """In how many steps errors are carried along it once, at the least."""
        turned = abs(self.turn.value) if self.turn is not None else 0.0
        if self.roll_rate is not None:  # to 90 deg and back, if there is time
            turned += min(pi, self.roll_rate.value * self.length) + 2.0 * TURN_STEP
        return ceil(max(self.length / STEP, turned / TURN_STEP, 1.0) - _ROUNDING)

    def leg(self, here: Start) -> Leg:
        """Return it, begun there.

        The bank of a coordinated turn is atan(v w/g): nothing is sensed to the side.
        """
        climb_rate = turn_rate = acceleration = bank = roll_rate = 0.0
        if self.turn is not None and self.rate is not None:
            sense = 1.0 if self.turn.value > 0.0 else -1.0
            turn_rate = sense * self.rate.value
            if self.roll_rate is not None:
                gravity = normal_gravity(here.latitude, here.height)
                bank = atan(here.speed * turn_rate / gravity)
                roll_rate = sense * self.roll_rate.value if bank else 0.0
        elif self.climb is not None and self.rate is not None:
            climb_rate = self.rate.value
        elif self.accelerate is not None and self.to is not None:
            acceleration = (self.to.value - here.speed) / self.length
        return Leg(
            duration=self.length,
            turn_rate=turn_rate,
            acceleration=acceleration,
            climb_rate=climb_rate,
            bank=bank,
            roll_rate=roll_rate,
        )

    @property
    def number(self) -> int:
        """How many segments it stands for."""
        return int(self.repeat)

    def each(self) -> Iterator[tuple[tuple[str | int, ...], SegmentLine]]:
        """Yield each segment with its place in this item, those of a repetition too."""
        for _ in range(self.repeat):
            yield (), self


class SegmentItem(FieldGroup, SegmentLine):
    """A segment, or a group of segments that is repeated as a whole."""

    key = "segments"
    of_all = MEANWHILE
    rows: ClassVar[Rows] = {
        key: KeyRow(
            items(table(SegmentLine)), "a group; repeat beside it is of the whole"
        )
    }

    def _faults(self) -> Faults:
        """Return what is wrong with a group, and what its segments say again."""
        again = {
            ("segments", place, key): "stands in a group that says it; remove one of "
            "them"
            for key in self.meanwhile
            for place, line in enumerate(self.segments or ())
            if getattr(line, key) is not None
        }
        return {**super()._faults(), **again}

    def each(self) -> Iterator[tuple[tuple[str | int, ...], SegmentLine]]:
        """Yield each segment with its place in this item, those of a repetition too."""
        if self.segments is None:
            yield from super().each()
            return
        new = self.meanwhile
        lines = tuple(line.but(**new) for line in self.segments)
        for _ in range(self.repeat):
            for place, line in enumerate(lines):
                for _, one in line.each():
                    yield ("segments", place), one

    @property
    def meanwhile(self) -> dict[str, object]:
        """What it says of its segments, or of all in its group."""
        return given_of({key: getattr(self, key) for key in MEANWHILE})


class MissionPart(Keyed):
    """Where the unit is when it navigates by itself, and how that begins."""

    rows: ClassVar[Rows] = {
        "latitude": KeyRow(ANGLE, "geodetic, of the start"),
        "longitude": KeyRow(
            ANGLE,
            "of the start; no error depends on it, the line of the route shows it",
        ),
        "height": KeyRow(
            measured("m", Sign.ANY, bare=True),
            "of the start, above the ellipsoid; unset: 0 m",
        ),
        "speed": KeyRow(
            SPEED,
            "of the start, forward; unset: that of a first segment straight, else 0 "
            "m/s",
        ),
        "heading": KeyRow(
            ANGLE,
            "of the start, from north to east; unset: that of a first segment "
            "straight, else 0 deg",
        ),
        "alignment": KeyRow(
            ALIGNMENT,
            "what is known when it begins: perfect (unset), all; self: what "
            "the unit finds of level and north, standing; or how well, 1 sigma",
        ),
        "alignment_time": KeyRow(
            SPAN, "beside alignment self: how long it stands before"
        ),
        "altitude": KeyRow(
            one_of(AIDED, FREE),
            "aided (unset): height and vertical velocity are known all the "
            "time; free: by the accelerometers alone",
        ),
        "aiding": KeyRow(
            table(AidingPart), "what is measured besides, of segments that name it"
        ),
        "filter": KeyRow(
            FILTER,
            "beside aiding: optimal (unset), which believes what is true; or "
            "what it estimates and believes",
        ),
        "segments": KeyRow(
            items(table(SegmentItem)), "what the vehicle does, one after the other"
        ),
        "trajectory": KeyRow(
            TEXT,
            "a recording in place of place, start and segments: a CSV file beside "
            "this one",
        ),
        "at": KeyRow(
            items(SPAN),
            "times from the start that are asked for, rising; unset: 10 s, 60 "
            "s, 600 s, 3600 s that lie within, and the end",
        ),
    }
    rules: ClassVar[Rules] = (
        *(
            Rule(
                key,
                lambda it, key=key: it.trajectory and getattr(it, key) is not None,
                "stands beside a trajectory, which says it; remove one of them",
            )
            for key in PLACED
        ),
        Rule(
            "segments",
            lambda it: not it.trajectory and it.segments is None,
            "says not what the vehicle does, expected segments, such as 'segments: "
            "[{{stand: 3600 s}}]', or a trajectory",
        ),
        Rule(
            "segments",
            lambda it: it.segments == (),
            "names no segment, expected one at least",
        ),
        Rule(
            "latitude",
            lambda it: not it.trajectory and it.latitude is None,
            "says not where it begins, expected such as 'latitude: 45 deg'",
        ),
        Rule(
            "latitude",
            lambda it: _beyond(it.latitude, MOST_LATITUDE * (1.0 - 2.0 * _ROUNDING)),
            "found {latitude!r}, expected between -89.9 deg and 89.9 deg; at a pole "
            "north is no direction",
        ),
        Rule(
            "longitude",
            lambda it: _beyond(it.longitude, 2.0 * pi),
            "found {longitude!r}, expected -360 deg to 360 deg",
        ),
        Rule(
            "height",
            lambda it: it.height and abs(it.height.value) > MOST_HEIGHT,
            f"found {{height!r}}, expected {-MOST_HEIGHT / 1e3:g} km to "
            f"{MOST_HEIGHT / 1e3:g} km",
        ),
        Rule(
            "speed",
            lambda it: it.speed and it.speed.value > MOST_SPEED,
            f"found {{speed!r}}, {TOO_FAST}",
        ),
        Rule(
            "alignment_time",
            lambda it: it.alignment_time and it.alignment != SELF,
            "is of 'alignment: self', which is not there; add it, or remove this",
        ),
        Rule(
            "alignment",
            lambda it: it.alignment == SELF and it.start.speed > 0.0,
            MOVING.format(speed="{start.speed:.6g}"),
        ),
        Rule(
            "alignment",
            lambda it: it.alignment == SELF and it.alignment_time is None,
            "stands without alignment_time, expected that beside it, as "
            "'alignment_time: 300 s'",
        ),
        Rule(
            "alignment_time",
            lambda it: (
                it.alignment_time
                and not 1.0 <= it.alignment_time.value <= LONGEST * (1.0 + _ROUNDING)
            ),
            "found {alignment_time!r}, expected 1 s to 24 h",
        ),
        Rule(
            "at",
            lambda it: it.at is not None and not 1 <= len(it.at) <= MOST_TIMES,
            f"names {{number_of_times}} times, expected 1 to {MOST_TIMES}",
        ),
        Rule(
            "filter",
            lambda it: it.filter is not None and it.aiding is None,
            "is of a mission with aiding, which is not there; add it, or remove this",
        ),
    )

    @property
    def number_of_times(self) -> int:
        """How many times are asked for."""
        return len(self.at or ())

    def _faults(self) -> Faults:
        """Return which times that are asked for do not rise."""
        says = "found {after!r} after {one!r}, expected times that rise"
        times = self.at or ()
        is_few = len(times) <= MOST_TIMES
        return not_rising(times if is_few else (), "at", says, least=1.0 + _ROUNDING)

    def _faults_of_whole(self) -> Faults:
        """Return what is wrong with the route, laid out."""
        if self.trajectory is not None:
            return {}
        end = self.laid_out.duration
        return {**self.late(end), **self.aiding_faults(end)}

    def aiding_faults(self, end: float) -> Faults:
        """Return what is wrong with what is measured, and when, to the end [s]."""
        given = {} if self.aiding is None else self.aiding.parts
        if self.aiding is not None and not given:
            return {
                ("aiding",): "names nothing that is measured, expected such as {gnss: "
                "{position: 2.5 m, rate: 1 Hz}}; or remove it"
            }
        found = self._misnamed(given) | {
            (
                "aiding",
                key,
                "during",
                place,
            ): f"ends at {last.printed}, and the mission "
            f"ends at {end:.6g} s; expected spans within it"
            for key, part in given.items()
            for place, (_, last) in enumerate(part.during or ())
            if last.value > end * (1.0 + _ROUNDING)
        }
        if found:
            return found
        numbers = {
            key: sum(
                floor(b * part.rate.value + _ROUNDING)
                - floor(a * part.rate.value + _ROUNDING)
                for a, b in self.spans[key]
            )
            for key, part in given.items()
        }
        number = sum(numbers.values())
        if number > MOST_EPOCHS:
            text = f"has {number:.6g} epochs, expected {MOST_EPOCHS} at the most"
            return {("aiding",): f"{text}; lower a rate"}
        return {
            ("aiding", key, "rate"): f"found {given[key].rate.printed!r}, and no "
            "multiple of that period, from the mission's start, is where segments or "
            "during name it; expected a higher rate, or more time with it"
            for key, number in numbers.items()
            if not number
        }

    def _misnamed(self, given: Mapping[str, AidPart]) -> Faults:
        """Return what is wrong with where these aids are named."""
        named = [
            (("segments", place, *(inside if item.aiding is None else ())), key, line)
            for place, item in enumerate(self.segments or ())
            for inside, line in item.each()
            for key in line.aiding or ()
        ]
        found: Faults = {
            (*at, "aiding"): "names zero_velocity, and the vehicle moves; that is of a "
            "stand alone"
            if key in given
            else f"names {key}, which mission.aiding does not have; add it there, or "
            "remove this"
            for at, key, line in named
            if key not in given or (key == ZERO_VELOCITY and line.stand is None)
        }
        used = {key for _, key, _ in named}
        for key, part in given.items():
            if self.trajectory is None and part.during is not None:
                found["aiding", key, "during"] = (
                    "is of a trajectory; here segments say 'aiding: [...]': remove it"
                )
            elif self.trajectory is None and key not in used:
                found["aiding", key] = (
                    f"is used nowhere; name it in segments, as 'aiding: [{key}]', or "
                    "remove it"
                )
            elif self.trajectory is not None and part.during is None:
                found["aiding", key] = (
                    "says not when it is there, expected such as 'during: [[0 s, 600 "
                    "s]]' beside a trajectory"
                )
        return found

    @cached_property
    def spans(self) -> dict[str, list[tuple[float, float]]]:
        """When each aid is there [s]."""
        given = {} if self.aiding is None else self.aiding.parts
        return {
            key: [
                *((a.value, b.value) for a, b in part.during or ()),
                *(
                    (begin, begin + line.length)
                    for begin, _, line in self.timed
                    if key in (line.aiding or ())
                ),
            ]
            for key, part in given.items()
        }

    @property
    def timed(self) -> Iterator[tuple[float, tuple[str | int, ...], SegmentLine]]:
        """Yield each segment with when it begins [s], and its place."""
        begin = 0.0
        for place, item in enumerate(self.segments or ()):
            for inside, line in item.each():
                yield begin, (place, *inside), line
                begin += line.length

    def late(self, end: float) -> Faults:
        """Return what is asked for when the mission is over, at that time [s]."""
        return {
            ("at", place): f"found {one.printed!r}, and the mission ends at {end:.6g} "
            "s; expected times within it"
            for place, one in enumerate(self.at or ())
            if one.value > end * (1.0 + _ROUNDING)
        }

    @property
    def first(self) -> SegmentLine | None:
        """The first segment."""
        item = self.segments[0] if self.segments else None
        return item.segments[0] if item is not None and item.segments else item

    @cached_property
    def start(self) -> Start:
        """Where it begins, and how."""
        first = self.first or self
        speed, heading = self.speed or first.speed, self.heading or first.heading
        return Start(
            latitude=self.latitude.value if self.latitude else 0.0,
            height=self.height.value if self.height else 0.0,
            speed=speed.value if speed else 0.0,
            heading=heading.value if heading else 0.0,
            longitude=self.longitude.value if self.longitude else None,
        )

    @cached_property
    def laid_out(self) -> Legs:
        """The segments one after the other.

        Raises
        ------
        fields.Faults
            They do not follow, are too many or too long, or lead where none can go.
        """
        return lay_out(self.start, self.segments or ())

    def times(self, end: float) -> tuple[float, ...]:
        """Return the times that are asked for, of a mission that ends then [s]."""
        if self.at is not None:
            return tuple(min(one.value, end) for one in self.at)
        return (*(time for time in DECADES if time < end * (1.0 - _ROUNDING)), end)

    def assumptions(self, end: float) -> tuple[str, ...]:
        """Return what a mission that ends then leaves open, and how it is taken."""
        first = self.first
        taken = {
            "alignment": PERFECT,
            "altitude": AIDED,
            "at": ", ".join(f"{time:.12g} s" for time in self.times(end)),
            **({"height": "0 m"} if first else {}),
            **({"heading": "0 deg"} if first and not first.heading else {}),
            **({"speed": "0 m/s"} if first and first.move in NEEDED else {}),
        }
        return tuple(
            sentence("assumed.default", of="mission", name=key, usual=usual)
            for key, usual in taken.items()
            if getattr(self, key) is None
        )


class MissionFile(Keyed):
    """A mission: where a calibrated unit navigates by itself."""

    rows: ClassVar[Rows] = {
        "format": format_row("mission"),
        "name": KeyRow(TEXT, "unset: the file's name"),
        "mission": KeyRow(
            table(MissionPart),
            "place, alignment, what the vehicle does",
            is_needed=True,
        ),
        "environment": ON_THE_WAY_ROW,
        "age": AGE_ROW,
    }

    @property
    def vibrations(self) -> list[tuple[float, float, Quantity]]:
        """Begins and ends of what has a vibration of its own, and that."""
        own = getattr(self.environment, "vibration", None)
        return [
            *(
                (begin, begin + line.length, line.vibration)
                for begin, _, line in self.mission.timed
                if line.vibration is not None
            ),
            *(
                (begin.value, end.value, part.value)
                for part in (own if isinstance(own, tuple) else ())
                for begin, end in part.during or ()
            ),
        ]

    def course_faults(self, end: float) -> Faults:
        """Return what is wrong with temperature and vibration to the end [s]."""
        temperature = getattr(self.environment, "temperature", None)
        vibration = getattr(self.environment, "vibration", None)
        late: Faults = {}
        if isinstance(temperature, TemperaturePart):
            late = temperature.late(end)
        found = {("environment", "temperature", *at): text for at, text in late.items()}
        if isinstance(vibration, tuple) and (text := self._misfit(vibration, end)):
            found["environment", "vibration"] = text
        return found | {
            ("mission", "segments", *path, "vibration"): "is of a part of the way; say "
            "that of the rest, such as 'environment: {vibration: 0 g}'"
            for _, path, line in self.mission.timed
            if line.vibration is not None and vibration is None
        }

    def _misfit(self, parts: tuple[VibrationPart, ...], end: float) -> str:
        """Return what is wrong with a list of vibrations, to the end [s]; or ''."""
        if self.mission.trajectory is None:
            text = "is a list, of a trajectory; here segments say 'vibration: 2 g'"
            return f"{text}, and this the rest, such as 'vibration: 1 g'"
        if sum(part.during is None for part in parts) != 1:
            return (
                "expected one value without during, of the rest of the way, such as "
                "[{value: 2 g, during: [[0 s, 60 s]]}, {value: 1 g}]"
            )
        spans = sorted((begin, stop) for begin, stop, _ in self.vibrations)
        apart = (
            f"has a span to {stop:.6g} s, and the next, or the mission's end, is at "
            f"{begin:.6g} s; expected spans one after the other, within the mission"
            for (_, stop), (begin, _) in pairwise([(0.0, 0.0), *spans, (end, end)])
            if begin < stop * (1.0 - _ROUNDING)
        )
        return next(apart, "")

    def stated(self, end: float) -> Stated:
        """Return what it states of its use, to the end [s]."""
        temperature = getattr(self.environment, "temperature", None)
        rest = getattr(self.environment, "vibration", None)
        if isinstance(temperature, TemperaturePart):
            temperature = temperature.known
        if isinstance(rest, tuple):
            rest = next(part.value for part in rest if part.during is None)
        if self.vibrations:
            rest = stretches(self.vibrations, stated_line("vibration", rest), end)
        return Stated(temperature=temperature, vibration=rest)

    def assumptions(self, end: float) -> tuple[str, ...]:
        """Return how courses are taken where the file leaves it open."""
        temperature = getattr(self.environment, "temperature", None)
        course = temperature if isinstance(temperature, TemperaturePart) else None
        taken = {
            "assumed.short_course": course and course.is_short(end),
            "assumed.while_aligning": self.mission.alignment_time
            and (course or self.vibrations),
        }
        return tuple(sentence(key) for key, is_taken in taken.items() if is_taken)


def read_mission(document: YamlFile) -> Mission:
    """Turn a mission file into a record, in SI.

    Raises
    ------
    SpecError
        Every issue of the file.
    """
    model: MissionFile = check(document, table(MissionFile))
    part = model.mission
    recorded = None
    route: Legs | Track
    said: tuple[str, ...]
    if part.trajectory is None:
        route = legs = part.laid_out
        banks = any(leg.bank for leg in legs.legs)
        said = (sentence("assumed.level", banks=banks),) if leans(legs) else ()
    else:
        recorded = _recorded(document, part)
        said = recorded.assumptions
        route = recorded.track
    end = route.duration
    if messages := model.course_faults(end):
        raise document.refuse(*messages.items())
    return Mission(
        name=model.name or document.stem,
        route=route,
        alignment=part.alignment_time.value if part.alignment_time else 0.0,
        aided=part.altitude != FREE,
        at=part.times(end),
        assumptions=(*part.assumptions(end), *said, *model.assumptions(end)),
        origin=Origin(file=document.base_name, sha256=document.sha256),
        trajectory=recorded.origin if recorded else None,
        doubts=recorded.doubts if recorded else (),
        use=stated_lines(model.stated(end), model.age),
        start=part.alignment.start
        if isinstance(part.alignment, AlignmentPart)
        else (0.0,) * 9,
        aiding=() if part.aiding is None else part.aiding.lines(part.spans),
        filter=part.filter.own if isinstance(part.filter, FilterPart) else None,
    )


def _largest_speed(track: Track, begin: float, end: float) -> float:
    """Return the largest speed of a route between two times [m/s]."""
    course = track.course
    there = (course.time > begin) & (course.time < end)
    speeds = np.linalg.norm(course.moment.velocity[there], axis=-1)
    return float(speeds.max(initial=0.0))


def _recorded(document: YamlFile, part: MissionPart) -> Recorded:
    """Read the recording that a mission names, beside it.

    Raises
    ------
    SpecError
        There is none, something is wrong with it, or it does not fit the mission.
    """
    node = document.root.nearest(("mission", "trajectory"))
    path = Path(document.file).parent / str(part.trajectory)
    if not (exists(path) and path.is_file()):
        what = "is no file" if exists(path) else "does not exist"
        message = (
            f"found {describe(part.trajectory)}, and {str(path)!r} {what}; "
            "expected a CSV file, by its place from this file"
        )
        raise document.refuse((node, message))
    with unshown(path, "a CSV file of a trajectory", document, node):
        recorded = read_trajectory(path, str(path))
    end = recorded.track.duration
    messages: Faults = {**part.late(end), **part.aiding_faults(end)}
    if part.alignment == SELF and recorded.first_speed > LEAST_SPEED:
        messages["alignment",] = MOVING.format(speed=f"{recorded.first_speed:.6g}")
    moving = [
        f"has the vehicle at {speed:.6g} m/s between {begin:g} s and {stop:g} s; "
        "expected times at which it stands"
        for begin, stop in part.spans.get(ZERO_VELOCITY, ())
        if (speed := _largest_speed(recorded.track, begin, stop)) > LEAST_SPEED
    ]
    if moving and not messages:
        messages["aiding", ZERO_VELOCITY, "during"] = moving[-1]
    if messages:
        at = ((("mission", *steps), text) for steps, text in messages.items())
        raise document.refuse(*at)
    return recorded


def leans(route: Legs) -> bool:
    """Say whether a vehicle would bank or pitch there that is taken as level."""
    moves = route.start.speed > 0.0 or any(leg.acceleration for leg in route.legs)
    return moves and any(
        leg.climb_rate or (leg.turn_rate and not leg.bank) for leg in route.legs
    )


def lay_out(start: Start, items: Sequence[SegmentItem]) -> Legs:
    """Put segments one after the other, each begun as the one before has ended.

    Raises
    ------
    fields.Faults
        They do not follow, are too many or too long, or lead where none can go: which,
        all at once.
    """
    number = sum(item.number for item in items)
    if number > MOST_SEGMENTS:
        message = f"are {number}, expected {MOST_SEGMENTS} at the most"
        raise faults({("segments",): message})
    segments = [
        (("segments", place, *inside), line)
        for place, item in enumerate(items)
        for inside, line in item.each()
    ]
    _check_size([line for _, line in segments])
    messages: Faults = {}
    here, legs = start, []
    for path, line in segments:
        for key, message in _faults_at(here, line).items():
            messages.setdefault((*path, key), message)
        # From there on as it says, so that one slip is not said of all that follow.
        speed = 0.0 if line.stand else here.speed
        here = replace(
            here,
            speed=line.speed.value if line.speed else speed,
            heading=line.heading.value if line.heading else here.heading,
        )
        leg = line.leg(here)
        if 2.0 * leg.rolling > leg.duration * (1.0 + _ROUNDING):
            messages.setdefault((*path, "roll_rate"), _too_slow(leg))
            leg = replace(leg, bank=0.0, roll_rate=0.0)
        legs.append(leg)
        here, message = _led(here, leg)
        if line.to is not None:
            here = replace(here, speed=line.to.value)  # to the last bit
        if message:
            messages.setdefault((*path, line.move), message)
            break
    if messages:
        raise faults(messages)
    return Legs(start=start, legs=tuple(legs))


def _check_size(lines: Sequence[SegmentLine]) -> None:
    """Refuse segments that take too long, or too long to be computed."""
    length = sum(line.length for line in lines)
    steps = sum(line.steps for line in lines)
    if length > LONGEST * (1.0 + _ROUNDING):
        message = f"take {length:.6g} s, expected 24 h at the most"
        raise faults({("segments",): message})
    if steps > MOST_STEPS:
        message = (
            f"need {steps} steps, of {STEP:g} s at the most and {TURN_STEP:g} rad of a "
            f"turn, expected {MOST_STEPS}; turn less"
        )
        raise faults({("segments",): message})


def _led(here: Start, leg: Leg) -> tuple[Start, str]:
    """Return where a leg leads, and what is wrong with that."""
    for piece in leg.pieces:
        steps = piece.steps(piece.duration)
        for _ in range(steps):
            here = moved(here, piece, piece.duration / steps)
            if abs(here.latitude) >= MOST_LATITUDE:
                return here, (
                    "leads to a pole, where north is no direction; expected latitudes "
                    "between -89.9 deg and 89.9 deg"
                )
    if abs(here.height) > MOST_HEIGHT:
        return here, (
            f"leads to a height of {here.height / 1e3:.6g} km, expected "
            f"{-MOST_HEIGHT / 1e3:g} km to {MOST_HEIGHT / 1e3:g} km"
        )
    return here, ""


def _faults_at(here: Start, line: SegmentLine) -> dict[str, str]:
    """Return what is wrong with a segment that begins there."""
    speed = here.speed if line.speed is None else line.speed.value
    heading = here.heading if line.heading is None else line.heading.value
    stands = here.speed == 0.0
    is_off = abs(speed - here.speed) > _SAME * max(1.0, here.speed)
    at_speed = f"at {here.speed:.6g} m/s by then"
    found = {
        "stand": (
            line.stand and not stands,
            f"stands still, and the vehicle is {at_speed}; accelerate to 0 m/s first",
        ),
        "straight": (
            line.straight and line.speed is None and stands,
            (
                "goes on, and the vehicle stands by then; say its speed, accelerate "
                "first, or let it stand"
            ),
        ),
        "speed": (is_off, f"and the vehicle is {at_speed}; accelerate first"),
        "heading": (
            abs(remainder(heading - here.heading, 2.0 * pi)) > _SAME,
            (
                f"and the vehicle heads {degrees(here.heading) % 360.0:.6g} deg by "
                "then; turn first"
            ),
        ),
    }
    return {
        key: f"found {getattr(line, key).printed!r}, {text}" if key in START else text
        for key, (is_wrong, text) in found.items()
        if is_wrong
    }


def _too_slow(leg: Leg) -> str:
    """Say that a turn ends before its bank is left."""
    return (
        f"takes {leg.rolling:.6g} s to a bank of {degrees(abs(leg.bank)):.6g} deg and "
        f"as long back, and the turn takes {leg.duration:.6g} s; roll quicker, or turn "
        "slower"
    )
