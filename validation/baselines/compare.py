"""Compare two records of a scene: the possible answers, and the rules that decide.

`regress`, `accept` and the pytest plugin compare a run with its baseline. `diff` and `--against`
compare the runs of two folders or engines. All of them, and every report, call `compare`:

| answer | meaning |
|---|---|
| unchanged | the result is bit-identical |
| rounding | rounding explains the difference |
| better | the result is closer to the reference result than before |
| worse | the result is farther from the reference result or unphysical, or the run did not finish |
| wrong collisions | fewer collisions agree with the reference (without it: the earlier result) |
| changed | not rounding, and neither better nor worse by the third rule |

Three rules give the answer; the first that applies decides:

1. *Hash.* If the hash of events and rest positions, the status and the rest time are equal, the
   answer is unchanged. Metrics that differ don't matter here: limits judge them.
2. *Rounding.* The answer is rounding if both records have the same events up to the predictability
   horizon, rounding explains the difference of each event time, and, if the shot can be predicted
   to its end, rounding explains the difference of each rest position. `rounding.allowance`
   computes how large these differences may be. A time-stepping engine is allowed one rounding per
   step. The number of steps is the rest time divided by the step in its settings, because the
   engine's own count could widen the allowance without bound. Two different engines differ by more
   than rounding, so this rule doesn't apply to them.
3. *Error.* Both records are compared with the same reference result. Wrong collisions and
   unphysical results are worse than any error. A smaller error is better, a larger error is worse.
   A difference within rounding, or smaller than `NEGLIGIBLE` times the error, is neither. If there
   is no reference result, the certified part of the shot decides (`quality_factor`); if there is
   no such part, the collisions are compared with the earlier collisions.

A run of generated shots keeps no motion, so its events are unknown. Then the second rule and the
collisions give no answer, and no first difference is shown.

Records of different scenes can't be compared: "not-comparable", with the reason. A baseline of
another engine, or of other settings, is refused when it is read (`baseline.load_baseline`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from ghostball.model import Scene
from ghostball.validation.baselines.compared_run import ComparedRun, EventLog, MotionNotKeptError
from ghostball.validation.baselines.regression import (
    Answer,
    FirstDifference,
    SceneChange,
    ValueChange,
)
from ghostball.validation.baselines.rounding import Allowance
from ghostball.validation.checks.metrics import METRICS
from ghostball.validation.grading.event_logs import ALL_KINDS, Event, compare_logs, events_in
from ghostball.validation.grading.tolerances import ROUNDINGS, TOLERANCE
from ghostball.validation.results.records import CaseRecord, number_with_unit

NEGLIGIBLE = 1e-3
"""Relative change of an error that counts as neither better nor worse: reports show three
digits."""

NOT_COMPARED = ("wall_time", "accuracy")
"""Metrics that aren't compared: run time depends on the machine, the accuracy class on the error.
"""

Pair = tuple[Event | None, Event | None]
"""An event of the base and an event of the head that differ; None if one log has no event there."""


def compare(
    base: ComparedRun,
    head: ComparedRun,
    allowance: Callable[[], Allowance] | None = None,
    command: str = "",
) -> SceneChange:
    """Compare a result with an earlier result of the same scene, or with another engine's.

    `allowance`: returns the differences that rounding explains in `head`; called only if the hashes
        differ. None: two different engines are compared.
    `command`: the command that shows the scene again, for the record.
    """
    one, two = base.record, head.record
    common: dict[str, Any] = {"scene": two.scene, "title": two.title, "command": command}
    common |= {"base_hash": one.bits, "head_hash": two.bits}
    if one.definition != two.definition:
        why = "the scene itself has changed: the earlier result is for a different shot"
        return SceneChange(**common, change="not-comparable", summary=why)
    if two.outcome != "ran":
        why = f"the engine did not run the scene: {two.reason or two.outcome}"
        lost: Answer = "worse" if one.outcome == "ran" else "changed"
        same = one.outcome == two.outcome
        return SceneChange(**common, change="unchanged" if same else lost, summary=why)
    if one.outcome != "ran":
        why = f"the engine runs the scene now; it did not before: {one.reason or one.outcome}"
        return SceneChange(**common, change="better", summary=why)
    common |= _numbers(one, two)
    if allowance is None:  # work counters of two engines can't be compared
        common["counters"] = ()
    if one.bits == two.bits != "" and _end_of(one) == _end_of(two):
        return SceneChange(**common, change="unchanged", summary=_said(["bit-identical"], common))
    try:
        before, after = base.log(), head.log()
    except MotionNotKeptError:
        return _without_events(one, two, common)
    explained = None if allowance is None else allowance()
    pair = _apart(before, after, explained)
    horizon = two.shot_horizon if explained is None else _finite(explained.horizon)
    until = math.inf if horizon is None else horizon
    answer = _by_error(one, two, explained) or _by_collisions(before, after, until)
    words = [] if one.status == two.status and one.bits != two.bits else [_end_words(one, two)]
    words.append(_distance_words(one, two))
    if (
        explained is not None
        and pair is None
        and one.bits != two.bits
        and not _end_moved(one, before, two, after, explained)
    ):
        answer, pair = "rounding", _first_bits(before, after)
    if explained is not None and answer == "rounding":
        words.append(explained.account)
    elif explained is not None and math.isfinite(explained.map_end):
        words.append(f"{explained.account}, up to {explained.map_end:.3g} s only, because {_WHY}")
    if answer != "rounding" and one.accuracy is not None and two.accuracy is not None:
        words.insert(0, f"{one.accuracy.sentence} -> {two.accuracy.sentence}")
    first = None if pair is None else _difference(pair, two, until)
    if first is not None:
        words.append(first.words)
    if answer == "rounding" and horizon is not None:
        words.append(f"nothing is compared after the horizon, {horizon:.3g} s")
    return SceneChange(
        **common,
        change=answer,
        summary=_said(words, common),
        horizon=horizon,
        first_difference=first,
    )


def _without_events(one: CaseRecord, two: CaseRecord, common: dict[str, Any]) -> SceneChange:
    """Compare two runs by error, status and counts; the events of at least one are unknown."""
    words = [] if _end_of(one) == _end_of(two) else [_end_words(one, two)]
    words.append(_distance_words(one, two))
    if one.accuracy is not None and two.accuracy is not None:
        words.insert(0, f"{one.accuracy.sentence} -> {two.accuracy.sentence}")
    for kind in dict.fromkeys([*one.collision_counts, *two.collision_counts]):
        before, after = (case.collision_counts.get(kind, 0) for case in (one, two))
        if before != after:
            words.append(f"{kind} collisions {before} -> {after}")
    words.append("events aren't compared, because the motion was not kept")
    answer = _by_error(one, two, None) or "changed"
    return SceneChange(**common, change=answer, summary=_said(words, common))


_WHY = (
    "collisions are simultaneous, balls are in resting contact, or no certificate gives the growth "
    "of errors"
)


def _by_error(one: CaseRecord, two: CaseRecord, explained: Allowance | None) -> Answer | None:
    """Return the answer of the third rule; None if no reference result gives one."""
    before, after = one.accuracy, two.accuracy
    # A run's own motion shows that it is unphysical: no reference result is needed.
    was_broken = before is not None and before.kind == "broken"
    if after is not None and after.kind == "broken":
        return "changed" if was_broken else "worse"
    if after is not None and was_broken:
        return "better"
    if one.is_own_measure != two.is_own_measure:  # one of the two records is the only reference
        return "changed"
    if before is None or after is None or one.truth != two.truth:
        return _by_certified_part(one, two)
    if after.kind == "another shot":
        if before.kind != "another shot":
            return "wrong collisions"
        more = (after.agree or 0) - (before.agree or 0)
        return "better" if more > 0 else "wrong collisions" if more < 0 else "changed"
    if before.error is None or after.error is None:
        return "better"
    if before.kind == after.kind == "exact":
        return "changed"
    rounding = 0.0
    if explained is not None:  # after the horizon, rounding may move a ball by up to TOLERANCE
        rounding = TOLERANCE if explained.rest is None else float(np.max(explained.rest))
    return _by_size(before.error, after.error, rounding)


def _by_certified_part(one: CaseRecord, two: CaseRecord) -> Answer | None:
    """Return the answer for the certified part of a shot that has no reference result."""
    before, after = (case.metrics.get("quality_factor") for case in (one, two))
    if before is None or after is None or max(before, after) <= ROUNDINGS:
        return None
    answer = _by_size(before, after, ROUNDINGS)
    return None if answer == "changed" else answer


def _by_size(before: float, after: float, rounding: float) -> Answer:
    """Return the answer for two errors; rounding explains a difference of `rounding`."""
    if not abs(after - before) > max(rounding, NEGLIGIBLE * before):
        return "changed"
    return "worse" if after > before else "better"


def _numbers(one: CaseRecord, two: CaseRecord) -> dict[str, Any]:
    """Return the numbers of both records that a report shows."""
    names = [name for name in METRICS if name not in NOT_COMPARED]
    metrics = [(name, METRICS[name].unit, one.metrics, two.metrics) for name in names]
    # A counter that only the new record has can't be compared.
    counters = [(name, "1", one.work, two.work) for name in one.work]
    errors: list[float | None] = [None, None]
    if one.truth == two.truth:
        errors = [
            None if case.is_own_measure else case.metrics.get("rest_error_max")
            for case in (one, two)
        ]
    return {
        "metrics": tuple(found for row in metrics if (found := _moved(*row)) is not None),
        "counters": tuple(found for row in counters if (found := _moved(*row)) is not None),
        "base_error": errors[0],
        "head_error": errors[1],
        "base_is_exact": one.is_exact,
        "head_is_exact": two.is_exact,
        "rest_base": _places(one),
        "rest_head": _places(two),
    }


def _moved(name: str, unit: str, base: Any, head: Any) -> ValueChange | None:
    """Return a quantity if its values differ; two NaN count as equal."""
    before, after = base.get(name), head.get(name)
    if before == after or (
        None not in (before, after) and math.isnan(before) and math.isnan(after)
    ):
        return None
    return ValueChange(name=name, unit=unit, base=before, head=after)


def _places(case: CaseRecord) -> tuple[tuple[float, ...], ...] | None:
    positions = case.rest_positions
    return None if positions is None else tuple(map(tuple, positions.tolist()))


def _apart(before: EventLog, after: EventLog, explained: Allowance | None) -> Pair | None:
    """Return the first event, up to the horizon, that rounding doesn't explain.

    The times of two different engines always differ. For them, return the first collision that
    only one of the two has.
    """
    until = min(before.until, after.until)
    if explained is None:
        parting = compare_logs(events_in(before.events), events_in(after.events)).parting
        if parting is None or parting.t >= until:
            return None
        first = parting.first
        return (first, None) if first is parting.true else (None, first)
    base, head = (events_in(one.events, ALL_KINDS) for one in (before, after))
    compared = compare_logs(base, head, strict=True)
    apart: list[Pair] = [
        *((base[i], None) for i in compared.missing),
        *((None, head[j]) for j in compared.invented),
        *(
            (base[i], head[j])
            for i, j in compared.index_pairs
            if abs(base[i].t - head[j].t) > explained.event_times[j]
        ),
    ]
    apart = [one for one in apart if _time_of(one) <= explained.horizon and _time_of(one) < until]
    return min(apart, key=_time_of, default=None)


def _time_of(pair: Pair) -> float:
    return min(one.t for one in pair if one is not None)


def _by_collisions(before: EventLog, after: EventLog, horizon: float) -> Answer:
    """Return the answer without a reference result, by the collisions before the horizon."""
    parting = compare_logs(events_in(before.events), events_in(after.events)).parting
    until = min(before.until, after.until)
    if parting is None or parting.t > horizon or parting.t >= until:
        return "changed"
    return "wrong collisions"


def _end_moved(
    one: CaseRecord, before: EventLog, two: CaseRecord, after: EventLog, explained: Allowance
) -> bool:
    """Return True if status, rest time or rest positions differ by more than rounding explains."""
    if one.status != two.status:
        return True
    if explained.rest is None:
        return False
    # A baseline stores the order of all events, and the time of the last one.
    if min(before.until, after.until) < math.inf:
        late = abs((one.rest_time or 0.0) - (two.rest_time or 0.0))
        if before.sequence != after.sequence or not late <= explained.event_times[-1]:
            return True
    return bool(np.any(~(_distances(one, two) <= explained.rest)))


def _first_bits(before: EventLog, after: EventLog) -> Pair | None:
    """Return the first event that differs in any bit; None if no kept event differs."""
    base, head = (events_in(one.events, ALL_KINDS) for one in (before, after))
    for k in range(max(len(base), len(head))):
        pair = (base[k] if k < len(base) else None, head[k] if k < len(head) else None)
        if None in pair:
            return None if min(before.until, after.until) < math.inf else pair
        if pair[0] != pair[1]:
            return pair
    return None


def _difference(pair: Pair, case: CaseRecord, horizon: float) -> FirstDifference:
    """Describe an event that differs."""
    scene, (before, after) = case.load_scene(), pair
    if before is None:
        assert after is not None
        words = f"new: {_event_words(after, scene)}"
    elif after is None:
        words = f"missing: {_event_words(before, scene)}"
    elif before.key != after.key:
        words = f"{_event_words(after, scene)}; before: {_event_words(before, scene)}"
    else:
        late = "later" if after.t > before.t else "earlier"
        words = f"{_event_words(after, scene)}, {abs(after.t - before.t):.3g} s {late}"
    index = min(one.index for one in pair if one is not None)
    return FirstDifference(
        index=index, before_horizon=_time_of(pair) <= horizon, words=f"event {index}: {words}"
    )


def _event_words(event: Event, scene: Scene) -> str:
    return f"{event.describe(scene)} at {event.t:.9g} s"


def _end_of(case: CaseRecord) -> tuple[str | None, float | None]:
    return case.status, case.rest_time


def _end_words(one: CaseRecord, two: CaseRecord) -> str:
    if one.status != two.status:
        return f'the run ended as "{two.status}" instead of "{one.status}"'
    return f"the run ended at {two.rest_time!r} s instead of {one.rest_time!r} s"


def _distances(one: CaseRecord, two: CaseRecord) -> Any:
    """Return the distance between the two rest positions of each ball, (n,) float64 [m]."""
    assert one.rest_positions is not None
    assert two.rest_positions is not None
    return np.linalg.norm(one.rest_positions - two.rest_positions, axis=1)


def _distance_words(one: CaseRecord, two: CaseRecord) -> str:
    moved = _distances(one, two)
    if not np.any(moved > 0.0):
        return "all rest positions are bit-identical"
    ball = int(np.argmax(moved))
    distance = number_with_unit(float(moved[ball]), "m", 3)
    return f"{two.definition['balls'][ball]['id']} rests {distance} from its old position"


def _said(words: list[str], numbers: dict[str, Any]) -> str:
    """Return a summary: the words, and the counters that changed."""
    return "; ".join([*words, *(one.words for one in numbers["counters"])])


def _finite(time: float) -> float | None:
    return time if math.isfinite(time) else None
