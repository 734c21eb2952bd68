"""Says what a change of one scene is: none, rounding, other results, nearer to the truth or not."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ghostball.model import EventKind, event_dict
from ghostball.validation.baselines.bands import (
    IN_ROUNDINGS_OF_SHOT,
    Band,
    Bands,
    direction,
)
from ghostball.validation.baselines.observed import Observed
from ghostball.validation.baselines.regression import (
    Change,
    FirstDifference,
    Quantity,
    SceneChange,
    rest_error_in,
)
from ghostball.validation.baselines.rounding import Allowance
from ghostball.validation.checks.metric_table import METRICS
from ghostball.validation.grading.event_logs import ALL_KINDS, compare_logs, events_in
from ghostball.validation.grading.tolerances import ROUNDINGS, UNIT_ROUNDOFF

_SOURCES = {
    "proof": "the proof of the shot",
    "engine": "our engine's own account, for no proof says how errors grow up to the end",
    "nothing": "no account: roundings that are never amplified",
}
"""Who says what rounding explains."""

NEGLIGIBLE = 1e-3
"""Part of an error by which it may grow without being worse: reports show three digits of it."""


def classify(
    base: Observed,
    head: Observed,
    bands: Bands,
    allowance: Callable[[], Allowance],
    command: str = "",
) -> SceneChange:
    """Compare what an engine did in a scene with what it did before.

    `base`, `head`: of one scene by name.
    `allowance`: returns what rounding explains in `head`; called only where bits differ.
    `command`: what shows the scene again, for the record.
    """
    common = {"scene": head.scene, "title": head.title, "command": command}
    if base.scene_hash != head.scene_hash:
        return SceneChange(
            **common,
            change="not-comparable",
            failed=False,
            summary="the scene itself was changed since: what was accepted is of another shot",
            base_hash=base.bits,
            head_hash=head.bits,
        )
    metrics = _metrics(base, head, bands)
    counters = _counters(base, head, bands)
    same = base.bits == head.bits
    explained: Allowance | None = None if same else allowance()
    if explained is not None and explained.roundings > ROUNDINGS:
        metrics = tuple(_rounded(one, explained) for one in metrics)
    moved = [one for one in (*metrics, *counters) if not one.within and one.level != "off"]
    change: Change = "identical"
    horizon, first, words = None, None, ""
    if same and (base.status, base.rest_time) != (head.status, head.rest_time):
        same, change, words = False, "results-changed", _end_words(base, head)
    elif explained is not None:
        horizon = explained.horizon if math.isfinite(explained.horizon) else None
        parted = _parted(base, head, explained)
        first = parted or _first_bits(base, head, explained.horizon)
        change = (
            "results-changed"
            if parted is not None or _end_moved(base, head, explained)
            else ("rounding-only")
        )
        words = _distance_words(base, head)
        if base.status != head.status:
            words = f"{_end_words(base, head)}; {words}"
        account = f"what rounding explains is by {_SOURCES[explained.source]}"
        if change == "rounding-only":
            words += f"; {account}"
        elif math.isfinite(explained.map_end):
            words += (
                f"; {account}, up to {explained.map_end:.3g} s only, where collisions tie, balls "
                "are in resting contact, or that account isn't the proof's"
            )
    # Where the truth is another one, it says nothing of which side is nearer.
    directions = [direction(one) for one in metrics if base.truth == head.truth]
    if -1 in directions:
        change = "worse"
    elif 1 in directions and change == "results-changed":
        change = "better"
    elif change == "results-changed" and explained is not None and base.truth == head.truth:
        change = _towards(metrics, explained) or change
    failed = (
        any(one.level == "error" for one in moved)
        or (bands.hash_level == "error" and not same)
        or (bands.hash_level == "warn" and not same and change != "rounding-only")
    )
    return SceneChange(
        **common,
        change=change,
        failed=failed,
        summary=_summary(change, first, metrics, moved, words, horizon),
        horizon=horizon,
        first_difference=first,
        metrics=metrics,
        counters=counters,
        base_hash=base.bits,
        head_hash=head.bits,
        rest_base=_places(base),
        rest_head=_places(head),
    )


def _towards(metrics: Sequence[Quantity], explained: Allowance) -> Change | None:
    """Say whether a shot that moved ends nearer to the truth than it did, or farther from it.

    Within their band errors differ by as much as rounding may make of them. Here more than rounding
    moved, so that an end which is farther off by more than rounding explains is worse; but not if
    that is less than `NEGLIGIBLE` of how far off it was.
    """
    end = rest_error_in(metrics)
    if end is None or end.base is None or end.head is None or explained.rest is None:
        return None
    farther = float(end.head) - float(end.base)
    if not abs(farther) > max(float(np.max(explained.rest)), NEGLIGIBLE * float(end.base)):
        return None
    return "worse" if farther > 0.0 else "better"


def _rounded(one: Quantity, explained: Allowance) -> Quantity:
    """Return a quantity of a time-stepping engine, within its band if rounding explains the move.

    The band is that of a run that rounds its state at each event; here each step does it. Errors
    in roundings move by as many, all others by as many roundings of 1. If the shot can be predicted
    to its end, an error of a place may also move as far as a ball at rest may, and an error of a
    time by as much as an event's time may. Nothing says so much of energies and overlaps.
    """
    if one.within or not isinstance(one.head, float) or not isinstance(one.base, float):
        return one
    moves = 2.0 * explained.roundings
    if one.name not in IN_ROUNDINGS_OF_SHOT:
        metric, moves = METRICS[one.name], moves * UNIT_ROUNDOFF
        if metric.compares is not None and explained.rest is not None:
            amplified = {"m": explained.rest, "s": explained.event_times}.get(metric.unit, ())
            moves = max(moves, float(np.max(amplified, initial=0.0)))
    return one.model_copy(update={"within": True}) if abs(one.head - one.base) <= moves else one


def _metrics(base: Observed, head: Observed, bands: Bands) -> tuple[Quantity, ...]:
    names = [name for name in METRICS if name in base.metrics or name in head.metrics]
    found = []
    for name in names:
        unit, before, after = METRICS[name].unit, base.metrics.get(name), head.metrics.get(name)
        one = _quantity(name, unit, before, after, bands.metrics.get(name))
        if base.truth != head.truth and METRICS[name].compares not in (None, "proof"):
            why = f"can't be compared: the truth was {base.truth}, and is {head.truth} now"
            one = one.model_copy(update={"level": "warn", "within": False, "why": why})
        found.append(one)
    return tuple(found)


def _counters(base: Observed, head: Observed, bands: Bands) -> tuple[Quantity, ...]:
    names = dict.fromkeys([*base.work, *head.work])
    return tuple(
        _quantity(name, "1", base.work.get(name), head.work.get(name), bands.counters.get(name))
        for name in names
    )


def _quantity(
    name: str, unit: str, base: int | float | None, head: int | float | None, band: Band | None
) -> Quantity:
    if band is None:  # it wasn't measured then
        why = "was not measured when the baseline was accepted"
        return Quantity(
            name=name, unit=unit, base=base, head=head, level="warn", within=False, why=why
        )
    return Quantity(
        name=name,
        unit=unit,
        base=base,
        head=head,
        low=band.low,
        high=band.high,
        level=band.level,
        within=band.holds(head),
        why=band.why,
    )


def _parted(base: Observed, head: Observed, explained: Allowance) -> FirstDifference | None:
    """Return the first event up to the horizon that rounding doesn't explain."""
    # A baseline may hold the first events only: then as many are compared.
    ours = base.events[: len(head.events)] if _is_cut(head) else base.events
    theirs = head.events[: len(base.events)] if _is_cut(base) else head.events
    compared = compare_logs(events_in(ours, ALL_KINDS), events_in(theirs, ALL_KINDS), strict=True)
    # What has no partner after the last one of the other log may have it beyond the cut.
    ours_end = ours["t"][-1] if len(ours) < base.event_count else math.inf
    theirs_end = theirs["t"][-1] if len(theirs) < head.event_count else math.inf
    found: list[tuple[float, int | None, int | None]] = []
    for i in compared.missing:
        if ours["t"][i] < theirs_end:
            found.append((float(ours["t"][i]), i, None))
    for j in compared.invented:
        if theirs["t"][j] < ours_end:
            found.append((float(theirs["t"][j]), None, j))
    for i, j in compared.index_pairs:
        if abs(ours["t"][i] - theirs["t"][j]) > explained.event_times[j]:
            found.append((float(min(ours["t"][i], theirs["t"][j])), i, j))
    found = [one for one in found if one[0] <= explained.horizon]
    if found:
        _, before, after = min(found, key=lambda one: one[0])
        return _difference(base, head, before, after, explained.horizon)
    cut = _is_cut(base) or _is_cut(head)
    return _parted_later(base, head, explained) if cut else None


def _is_cut(one: Observed) -> bool:
    return len(one.events) < one.event_count


def _parted_later(base: Observed, head: Observed, explained: Allowance) -> FirstDifference | None:
    """Look beyond the events that a baseline keeps: of them all, only the order is known.

    It says nothing where either log reaches beyond the horizon, for the logs may differ there.
    """
    ends_later = max(base.rest_time, head.rest_time) > explained.horizon
    if ends_later or base.sequence == head.sequence:
        return None
    return _later_difference(base, head, "come in another order", before_horizon=True)


def _later_difference(
    base: Observed, head: Observed, how: str, *, before_horizon: bool
) -> FirstDifference:
    start = min(len(base.events), len(head.events))
    words = (
        f"events from {start} on {how} (there were {base.event_count} events, and are "
        f"{head.event_count} now); `ghostball diff` of two results folders says where"
    )
    return FirstDifference(index=start, before_horizon=before_horizon, words=words)


def _end_moved(base: Observed, head: Observed, explained: Allowance) -> bool:
    """Whether the end differs by more than rounding explains; past the horizon no place does."""
    if base.status != head.status or base.rest_positions.shape != head.rest_positions.shape:
        return True
    if explained.rest is None:
        return False
    if len(head.events) and (_is_cut(base) or _is_cut(head)):
        # The instant of the last event isn't kept, but that of the end is.
        late = abs(base.rest_time - head.rest_time)
        if not late <= explained.event_times[-1]:
            return True
    moved = np.linalg.norm(base.rest_positions - head.rest_positions, axis=1)
    return bool(np.any(~(moved <= explained.rest)))


def _first_bits(base: Observed, head: Observed, horizon: float) -> FirstDifference | None:
    """Return the first event that differs in any bit; None where only the end does."""
    shorter = min(len(base.events), len(head.events))
    differs = base.events[:shorter] != head.events[:shorter]
    if differs.any():
        first = int(np.argmax(differs))
        return _difference(base, head, first, first, horizon)
    i = shorter if len(base.events) > shorter else None
    j = shorter if len(head.events) > shorter else None
    if (i is not None and not _is_cut(head)) or (j is not None and not _is_cut(base)):
        return _difference(base, head, i, j, horizon)
    if not (_is_cut(base) or _is_cut(head)):
        return None
    before = bool(np.any(head.events[shorter:]["t"][:1] <= horizon))
    return _later_difference(base, head, "or the end differ", before_horizon=before)


def _difference(
    base: Observed, head: Observed, i: int | None, j: int | None, horizon: float
) -> FirstDifference:
    """Describe event i of the base and event j of the head, of which one may not be there."""
    sides = [(base, i), (head, j)]
    before, after = (None if k is None else event_dict(one.events[k]) for one, k in sides)
    there = [one for one in (before, after) if one is not None]
    if before is None:
        words = f"{_words(there[0], head.ids)} was not there before"
    elif after is None:
        words = f"{_words(before, base.ids)} is no more"
    elif any(before[name] != after[name] for name in ("kind", "a", "b")):
        words = f"{_words(after, head.ids)}, where it was {_words(before, head.ids)}"
    else:
        sooner = "later" if after["t"] > before["t"] else "sooner"
        late = abs(after["t"] - before["t"])
        words = f"{_words(after, head.ids)} comes {late:.3g} s {sooner}"
    index = min(k for k in (i, j) if k is not None)
    return FirstDifference(
        index=index,
        before_horizon=min(one["t"] for one in there) <= horizon,
        words=f"event {index}: {words}",
    )


def _words(event: dict[str, Any], ids: tuple[str, ...]) -> str:
    """Return an event in words, with the names of its balls."""

    def name(ball: int) -> str:
        return ids[ball] if ball < len(ids) else f"ball {ball}"

    at = f"at {event['t']:.9g} s"
    if event["kind"] == EventKind.BALL_BALL.label:
        return f"{name(event['a'])} meets {name(event['b'])} {at}"
    if event["kind"] == EventKind.BALL_CUSHION.label:
        return f"{name(event['a'])} meets the {event['b']} cushion {at}"
    return f"{name(event['a'])}: {event['kind']} {at}"


def _places(observed: Observed) -> tuple[tuple[float, float, float], ...]:
    return tuple((float(x), float(y), float(z)) for x, y, z in observed.rest_positions)


def _end_words(base: Observed, head: Observed) -> str:
    if base.status != head.status:
        return f'it ended as "{head.status}", where that was "{base.status}"'
    return f"it ended at {head.rest_time!r} s, where that was {base.rest_time!r} s"


def _distance_words(base: Observed, head: Observed) -> str:
    if base.rest_positions.shape != head.rest_positions.shape:
        return "other balls"
    moved = np.linalg.norm(base.rest_positions - head.rest_positions, axis=1)
    if not np.any(moved > 0.0):
        return "all balls rest where they did, to the bit"
    ball = int(np.argmax(moved))
    return f"{head.ids[ball]} rests {moved[ball]:.3g} m from where it did"


def _summary(
    change: Change,
    first: FirstDifference | None,
    metrics: Sequence[Quantity],
    moved: list[Quantity],
    words: str,
    horizon: float | None,
) -> str:
    parts = [words] if words else []
    if first is not None:
        parts.append(first.words)
    if horizon is not None and change == "rounding-only":
        parts.append(f"nothing is compared past the horizon, {horizon:.3g} s")
    # In roundings a number says little of an engine that doesn't err by roundings.
    shown = sorted(moved, key=lambda one: one.name.endswith("_ulps"))[:3]
    end = rest_error_in(metrics)
    if change in ("worse", "better") and end is not None and end not in shown:
        shown = [end, *shown]  # the one number that says by how much
    parts += [f"{one.name} {_number(one, one.base)} -> {_number(one, one.head)}" for one in shown]
    if more := len([one for one in moved if one not in shown]):
        parts.append(f"and {more} more")
    return "; ".join(parts) if parts else "the same bits"


def _number(one: Quantity, value: int | float | None) -> str:
    if value is None:
        return "none"
    number = f"{value:.3g}" if isinstance(value, float) else str(value)
    return number if one.unit == "1" else f"{number} {one.unit}"
