"""Metrics of the outcome of a shot: where and when its balls end, and which collisions it has."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from ghostball.model import COLLISION_KINDS, EventKind
from ghostball.validation.checks.metric import Compute, MetricGroup, NotMeasuredError, RunAndTruth
from ghostball.validation.grading.event_logs import Agreement, compare_collisions
from ghostball.validation.grading.tolerances import EPS
from ghostball.validation.runs.sampling import events_of

OUTCOME: Final = MetricGroup()


@OUTCOME.metric(
    "rest_error_max",
    "m",
    "largest distance of a ball from its reference rest position",
    "rest",
    "end",
)
def _rest_error_max(run: RunAndTruth) -> float:
    return float(np.max(run.ball_errors))


@OUTCOME.metric(
    "rest_error_rms",
    "m",
    "root mean square over all balls of the distance from the reference rest position",
    "rest",
    "end",
)
def _rest_error_rms(run: RunAndTruth) -> float:
    return float(np.sqrt(np.mean(run.ball_errors**2)))


@OUTCOME.metric(
    "rest_error_ulps",
    "1",
    "`rest_error_max` in units of the error that rounding the scene's numbers once would cause",
    "conditioning",
    "end",
)
def _rest_error_ulps(run: RunAndTruth) -> float:
    conditioning = run.known("conditioning", run.truth.conditioning)
    return float(np.max(run.ball_errors / (EPS * conditioning)))


@OUTCOME.metric(
    "rest_time_error", "s", "error of the time at which the last ball stops", "time", "end"
)
def _rest_time_error(run: RunAndTruth) -> float:
    run.require_end()
    right = run.known("time", run.truth.rest_time)
    return abs((run.result.rest_time - right) - run.truth.rest_time_low)


@OUTCOME.metric(
    "rest_time_error_ulps",
    "1",
    "`rest_time_error` in units of the error that rounding the scene's numbers once would cause",
    "conditioning",
    "end",
)
def _rest_time_error_ulps(run: RunAndTruth) -> float:
    conditioning = run.known("conditioning", run.truth.rest_time_conditioning)
    if conditioning == 0.0:
        raise NotMeasuredError("no ball moves in this scene: its rest time is 0 by definition")
    return _rest_time_error(run) / (EPS * conditioning)


def _count(*kinds: EventKind) -> Compute:
    return lambda run: sum(int(run.result.collision_counts[kind.label]) for kind in kinds)


def _count_error(kind: EventKind) -> Compute:
    def error(run: RunAndTruth) -> int:
        run.require_end()
        right = run.known("events", run.truth.collision_counts)[kind.label]
        return abs(int(run.result.collision_counts[kind.label]) - right)

    return error


def _add_counts() -> None:
    """Add the numbers of collisions, and their differences from the reference numbers."""
    for name, meaning, kinds in (
        ("ball_ball_count", "collisions between balls", (EventKind.BALL_BALL,)),
        ("ball_cushion_count", "collisions with cushions", (EventKind.BALL_CUSHION,)),
        ("collision_count", "collisions between balls and with cushions", COLLISION_KINDS),
    ):
        OUTCOME.metric(name, "1", meaning, judges="shot")(_count(*kinds))
    for kind in (EventKind.BALL_BALL, EventKind.BALL_CUSHION):
        name = f"{kind.label.replace('-', '_')}_count_error"
        meaning = f"error of the number of {kind.label} collisions"
        OUTCOME.metric(name, "1", meaning, "events", "end")(_count_error(kind))


_add_counts()


def _compared(run: RunAndTruth) -> Agreement:
    """Compare the collisions with those of the reference."""
    collisions = run.known("events", run.truth.collisions)
    return compare_collisions(collisions, run.truth.collision_times, events_of(run.result))


@OUTCOME.metric(
    "matching_events",
    "1",
    "number of collisions from the start that match the reference sequence (kind and balls)",
    "events",
    "shot",
)
def _matching_events(run: RunAndTruth) -> int:
    return _compared(run).leading


@OUTCOME.metric("first_divergence_time", "s", "time of the first wrong collision", "events")
def _first_divergence_time(run: RunAndTruth) -> float:
    run.require_end()
    parts_at = _compared(run).parts_at(timed=bool(len(run.truth.collision_times)))
    if parts_at is None:
        raise NotMeasuredError("a collision is missing; the closed form doesn't give its time")
    if math.isinf(parts_at):
        raise NotMeasuredError("never: all collisions match")
    return parts_at
