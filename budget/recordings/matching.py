"""Rests and turns matched to the windows of a procedure, in their order.

The cheapest match is taken: what is between two rests is a turn of the procedure where
its angle is that of whole turns, and rests that are no window are passed over.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import permutations, product
from math import acos, exp, inf, log, radians
from typing import TYPE_CHECKING

import numpy as np

from budget.errors import CallError
from budget.names import AXES
from budget.recordings.rests import NEAR, STILL, RestOrTurn, rests_and_turns
from budget.recordings.track import MOST_ISSUES, RecordedTrack, WindowSpan
from budget.sentences import sentence

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from budget.arrays import Array
    from budget.model.windows import Window

STILLER = radians(0.02)  # the same, where units may be wrong: the earth's is below it
SAME_TURN = 0.1  # of whole turns [1]
LONG = 0.7  # ln of a length over the right one, of a rest that may be at another face
MOST_PACE = 1.2  # ln of the length of a turn over the right one, at the most
PACE = 0.1  # of ln of lengths over those wanted: how alike, how far from 0 [1]
ELSEWHERE = 10.0  # price of such a rest
ABSENT = 5.0  # of a window that is not there


@dataclass(frozen=True, kw_only=True)
class _Fit:
    """Segments matched to windows: when each was, and how badly they fit."""

    found: Sequence[RestOrTurn]
    spans: Sequence[WindowSpan]
    is_as_planned: bool
    price: float


def matched_windows(
    tracks: Sequence[RecordedTrack],
    windows: Sequence[Window],
    name: str,
    *,
    knows_attitudes: bool,
) -> _Fit:
    """Find rests and turns, and match them.

    Where what should be a turn is so slow that it passes for a rest, units may be
    wrong: a rest is then what is still by its own noise. Over gaps rests go on, unless
    the windows are so far from fitting by then that each part is one of its own.

    Raises
    ------
    CallError
        Some window is not there.
    """
    first: CallError | None = None
    for still in (STILL, STILLER):
        fits: list[_Fit] = []
        has_gaps = any(one.places.size for one in tracks)
        for is_joined in (True, False) if has_gaps else (False,):
            found = [
                one
                for each in tracks
                for one in rests_and_turns(each, windows, still, is_joined=is_joined)
            ]
            try:
                fit = _matched(found, windows, name, knows_attitudes=knows_attitudes)
            except CallError as error:
                first = first or error
            else:
                more = 0.0 if is_joined else LONG
                fits.append(replace(fit, price=fit.price + more))
        if fits:
            return min(fits, key=lambda one: (not one.is_as_planned, one.price))
    pace = _of_pace(found, windows, tracks)
    dead = _of_dead(tracks)
    why = dead or pace or _of_stamps(tracks)
    raise CallError(f"{first or name}{_of_gaps(tracks)}{why}")


def _of_dead(tracks: Sequence[RecordedTrack]) -> str:
    """Say which channel reads the same all the time, so that turns are not seen."""
    for one in tracks:
        for kind, (_, values) in one.values.items():
            for axis, own in zip(AXES, values, strict=True):
                if np.ptp(own) == 0.0:
                    channel = f"{kind}_{axis}"
                    return f". {sentence('calibrations.dead', channel=channel)}"
    return ""


def _of_gaps(tracks: Sequence[RecordedTrack]) -> str:
    """Say where samples are missing, if some are."""
    found = [
        f"{(times[k + 1] - times[k]) * one.rate - 1.0:.0f} after {times[k]:.2f} s"
        for one in tracks
        for times in [one.smooth[0]]
        for k in one.places.tolist()[:MOST_ISSUES]
    ]
    return f". Samples are missing: {', '.join(found[:MOST_ISSUES])}" if found else ""


def _of_pace(
    found: Sequence[RestOrTurn],
    windows: Sequence[Window],
    tracks: Sequence[RecordedTrack],
) -> str:
    """Say that the rate may be another, where rests are there at another pace."""
    rests = sorted((one.length for one in found if one.is_rest), reverse=True)
    dwells = sorted((one.length for one in windows if not one.sense), reverse=True)
    if not (rests and dwells):
        return ""
    ratios = np.log([a / b for a, b in zip(dwells, rests, strict=False)])
    pace = float(np.median(ratios))
    if len(rests) < len(dwells) or np.ptp(ratios) > PACE or abs(pace) < PACE:
        return ""
    rate = tracks[0].rate
    return (
        f". The longest rests are {exp(-pace):.2g} times as long as those wanted: is "
        f"the rate about {rate * exp(-pace):.2g} Hz, not {rate:.3g} Hz (--rate, or "
        "the unit of its stamps)?"
    )


def _of_stamps(tracks: Sequence[RecordedTrack]) -> str:
    """Say that stamps may be in another unit, where they are far apart."""
    for one in tracks:
        if unit := one.likely_unit:
            return (
                f". Stamps come every {1.0 / one.rate:.3g} s: if they are in {unit}, "
                f"write 'time [{unit}]' in the head or in --columns"
            )
    return ""


def _matched(
    found: Sequence[RestOrTurn],
    windows: Sequence[Window],
    name: str,
    *,
    knows_attitudes: bool,
) -> _Fit:
    """Return when each window was, in order.

    Where attitudes are those of the procedure with axes exchanged or reversed, or a few
    windows are at others though they last as long, they are taken as they come: what is
    wrong the readings will say.

    Raises
    ------
    CallError
        Some window is not there: what is, and what should be.
    """
    spans, price = _match(found, windows, turned=np.eye(3), knows=knows_attitudes)
    if spans is not None:
        return _Fit(spans=spans, is_as_planned=True, price=price, found=found)
    tried = [
        _match(found, windows, turned=np.array(turned), knows=True)
        for turned in _turned_axes()
    ]
    tried += [_match(found, windows, turned=np.eye(3), knows=True, strict=False)]
    best = min((price, k) for k, (_, price) in enumerate(tried))
    spans, price = tried[best[1]]
    if spans is not None and price < inf:
        return _Fit(spans=spans, is_as_planned=False, price=price, found=found)
    wanted = "; ".join(f"{k + 1} {one.name}" for k, one in enumerate(windows))
    there = "; ".join(one.said for one in found if one.is_rest or one.is_back)
    raise CallError(
        f"the windows of {name} are not all in the recording, in their order"
        f"{_of_absent(found, windows, knows=knows_attitudes)}.\n"
        f"wanted: {wanted}\nfound: {there or 'no rest of 1 s or more'}\n"
        "Record what is missing, give the times of windows (--windows), or the "
        "procedure that was run"
    )


def _of_absent(
    found: Sequence[RestOrTurn], windows: Sequence[Window], *, knows: bool
) -> str:
    """Say without which windows the others would fit; of many, that they are."""
    rests = sum(one.is_rest for one in found)
    if not knows:
        return f": {rests} rests are there, {len(windows)} wanted"
    # A turn, of which no force is known, is at the attitude of the rest before it.
    before = [*found[:1], *found[:-1]]
    pairs = zip(found, before, strict=True)
    there = [x if x.is_rest else replace(x, force=y.force) for x, y in pairs]
    _, last = _costs(there, windows, turned=np.eye(3), knows=True, skipped=ABSENT)
    absent: list[int] = []
    j, s = len(windows), len(found)
    while j:
        taken = last.get((j, s), 0)
        if taken < 0:
            absent.insert(0, j)
        j -= abs(taken)
        s -= taken >= 0
    if len(absent) > len(windows) // 2:
        return f": {len(absent)} of {len(windows)} are not (is it that procedure?)"
    named = ", ".join(f"{k} {windows[k - 1].name}" for k in absent)
    return f": without {named} they would be" if absent else ""


def _turned_axes() -> Iterator[Array]:
    """Yield axes that are exchanged or reversed, as matrices (3, 3)."""
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            matrix = np.eye(3)[list(order)] * np.array(signs)[:, None]
            if not np.array_equal(matrix, np.eye(3)):
                yield matrix


def _match(
    found: Sequence[RestOrTurn],
    windows: Sequence[Window],
    *,
    turned: Array,
    knows: bool,
    strict: bool = True,
) -> tuple[list[WindowSpan] | None, float]:
    """Return the cheapest match in order, and its price; None without any.

    Dwells one after the other at the same angles may be one rest. Of forces, turned
    into body axes, it `knows` where they should point; where it is not `strict`, a few
    may point elsewhere.
    """
    n, m = len(windows), len(found)
    cost, last = _costs(found, windows, turned=turned, knows=knows, strict=strict)
    price = float(cost[n, m])
    most = max(2, n // 4) * (ELSEWHERE + LONG) + n * LONG
    if price == inf or (not strict and price > most):
        return None, inf
    return _traced(found, windows, last), price


def _costs(
    found: Sequence[RestOrTurn],
    windows: Sequence[Window],
    *,
    turned: Array,
    knows: bool,
    strict: bool = True,
    skipped: float = inf,
) -> tuple[Array, dict[tuple[int, int], int]]:
    """Return prices of the first j windows in the first s segments, (n + 1, m + 1).

    And how many windows the last segment is, by both; -1 where the last window is left
    out, at the price of one that is `skipped`.
    """
    n, m = len(windows), len(found)
    cost = np.full((n + 1, m + 1), inf)
    cost[0] = 0.0
    last: dict[tuple[int, int], int] = {}
    groups = [_alike(windows, j) for j in range(n)]
    unit = _turn_unit(found, windows)
    for s in range(m + 1):
        for j in range(1, n + 1):
            if s:
                cost[j, s] = cost[j, s - 1]
            for g in range(1, groups[j - 1] + 1 if s else 1):
                own, segment = windows[j - g : j], found[s - 1]
                price = cost[j - g, s - 1] + _price(segment, own, unit)
                if price < inf and knows:
                    price += _askew(segment, own, turned, strict=strict)
                if price < cost[j, s]:
                    cost[j, s], last[j, s] = price, g
            if cost[j - 1, s] + skipped < cost[j, s]:
                cost[j, s], last[j, s] = cost[j - 1, s] + skipped, -1
    return cost, last


def _traced(
    found: Sequence[RestOrTurn],
    windows: Sequence[Window],
    last: Mapping[tuple[int, int], int],
) -> list[WindowSpan]:
    """Return the spans of a match, from its end."""
    spans: list[WindowSpan] = []
    j, s = len(windows), len(found)
    while j:
        taken = last.get((j, s), 0)
        if taken:
            spans = [*_split(found[s - 1], windows[j - taken : j]), *spans]
            j -= taken
        s -= 1
    return spans


def _alike(windows: Sequence[Window], last: int) -> int:
    """Return how many dwells up to one stand as it does, without a move."""
    count = 1
    while (
        last - count >= 0
        and not windows[last].sense
        and not windows[last - count].sense
        and windows[last - count].setting == windows[last].setting
    ):
        count += 1
    return count


def _turn_unit(found: Sequence[RestOrTurn], windows: Sequence[Window]) -> float:
    """Return the size of a turn as it is integrated over the true one [1].

    Of counts, whose gain is not known, or of other units, by the largest of both.
    """
    turns = [abs(one.setting.angle) for one in windows if one.sense]
    seen = [one.angle for one in found if not one.is_rest and one.is_back]
    if not turns or not seen:
        return 1.0
    unit = float(np.median(sorted(seen)[-len(turns) :])) / float(np.median(turns))
    return unit if abs(unit - 1.0) > SAME_TURN and unit > 0.0 else 1.0


def _price(segment: RestOrTurn, windows: Sequence[Window], unit: float) -> float:
    """Return how badly a segment fits windows by length, infinite if not at all."""
    window = windows[0]
    if bool(window.sense) == segment.is_rest:
        return inf
    price = abs(log(segment.length / sum(one.length for one in windows)))
    if window.sense:
        off = segment.angle / unit / abs(window.setting.angle) - 1.0
        is_whole = abs(off) <= SAME_TURN or (segment.is_clipped and off < 0.0)
        is_it = is_whole and segment.is_back and price <= MOST_PACE
        if not is_it:
            return inf
        return price + abs(off) if segment.is_clipped else price
    return price


def _askew(
    segment: RestOrTurn, windows: Sequence[Window], turned: Array, *, strict: bool
) -> float:
    """Return how far a rest is off the attitude of windows [rad]; infinite if far."""
    window = windows[0]
    if segment.force is None:
        return 0.0
    up = window.setting.to_body @ np.array([0.0, 0.0, 1.0])
    off = acos(float(np.clip(up @ turned @ segment.force, -1.0, 1.0)))
    if off <= NEAR:
        return off
    long = abs(log(segment.length / sum(one.length for one in windows)))
    return inf if strict or long > LONG else ELSEWHERE


def _split(segment: RestOrTurn, windows: Sequence[Window]) -> Iterator[WindowSpan]:
    """Yield parts of a segment, as long beside each other as the windows are."""
    total = sum(one.length for one in windows)
    begin = segment.start
    for one in windows:
        end = begin + segment.length * one.length / total
        yield WindowSpan(track=segment.track, start=begin, end=end, rests=segment.rests)
        begin = end
