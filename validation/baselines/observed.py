"""What an engine did in one scene, on one side of a comparison."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ghostball.model import Events, GhostballError, Result
from ghostball.model.arrays import FloatArray
from ghostball.model.hashes import bits_hash, sequence_hash
from ghostball.validation.checks.metric_table import METRICS
from ghostball.validation.checks.metrics import Value
from ghostball.validation.results.records import (
    INDEPENDENT,
    CaseRecord,
    Motion,
    scene_hash,
    status_name,
)
from ghostball.validation.runs.sampling import events_of

UNJUDGED = ("wall_time", "accuracy")
"""Metrics that no baseline holds: the time is the machine's, and a class is made of the errors."""

KEPT_EVENTS = 64
"""Events that a baseline holds one by one: what a person reads, and all of most shipped shots.

Of later ones the hashes say that they differ, and `ghostball diff` of two runs says where.
"""


@dataclass(frozen=True, eq=False)
class Observed:
    """What happened, and how well.

    `scene`, `title`, `scene_hash`: name and title of the scene, and the hash of its definition.
    `truth`: what its metrics were measured against, as `CaseRecord.truth`; None where they weren't.
    `rest_time` [s].
    `rest_positions` (n, 3) float64 [m].
    `events`, a structured array (`EVENT_DTYPE`): all of them, or the first ones, of a baseline of a
        long shot.
    `bits`, `sequence`: hashes of all bits, and of the order of all events alone; see
        `model.hashes`.
    `metrics`: those that have a value, without those that compare our engine with itself.
    `ids`: of the balls.
    """

    scene: str
    title: str
    scene_hash: str
    truth: str | None
    status: str
    rest_time: float
    rest_positions: FloatArray
    events: Events
    event_count: int
    bits: str
    sequence: str
    metrics: Mapping[str, int | float] = field(default_factory=dict)
    work: Mapping[str, int] = field(default_factory=dict)
    ids: tuple[str, ...] = ()

    @property
    def is_finite(self) -> bool:
        """Whether all its numbers are: else nothing can be compared with them."""
        numbers = (self.rest_time, *self.metrics.values())
        arrays = (self.rest_positions, self.events["t"])
        return all(map(math.isfinite, numbers)) and all(np.isfinite(one).all() for one in arrays)

    @classmethod
    def of_case(cls, case: CaseRecord, motion: Motion) -> Observed:
        """Return what a case that ran says of it."""
        if case.rest_positions is None or case.rest_time is None or case.status is None:
            raise GhostballError(
                f'scene "{case.scene}" did not run on `{case.label}`: {case.reason or case.outcome}'
            )
        scene = case.load_scene()
        return cls(
            case.scene,
            case.title,
            scene_hash(scene),
            case.truth,
            case.status,
            case.rest_time,
            case.rest_positions,
            motion.events,
            len(motion.events),
            bits_hash(motion.events, case.rest_positions),
            sequence_hash(motion.events),
            judged(case.metrics, case.truth),
            dict(case.work),
            tuple(ball.id for ball in scene.balls),
        )

    @classmethod
    def of_result(cls, result: Result) -> Observed:
        """Return what a run that isn't measured says of it, recorded with its events at least."""
        scene, events = result.scene, events_of(result)
        return cls(
            scene.name,
            scene.title,
            scene_hash(scene),
            None,
            status_name(result.status),
            float(result.rest_time),
            result.rest_positions,
            events,
            len(events),
            bits_hash(events, result.rest_positions),
            sequence_hash(events),
            {},
            {name: int(count) for name, count in result.work.items()},
            tuple(ball.id for ball in scene.balls),
        )


def judged(metrics: Mapping[str, Value], truth: str | None) -> dict[str, int | float]:
    """Return the metrics that say something of our engine: not those that compare it with itself.

    A proof, also of a part of a shot, owes it nothing; see `validation.truth.scene_truth`.
    """
    return {
        name: value
        for name, value in metrics.items()
        if value is not None
        and name not in UNJUDGED
        and (METRICS[name].compares in (None, "proof") or truth in INDEPENDENT)
    }
