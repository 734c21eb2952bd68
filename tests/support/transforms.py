"""A scene relabelled or changed: what the same physics must answer alike."""

from __future__ import annotations

from collections.abc import Sequence

from ghostball.engine import Ball, Result
from ghostball.validation.stress.same.images import rows_of, shuffled
from ghostball.validation.stress.same.plays import with_balls

__all__ = ["changed", "same_log", "shuffled", "with_balls"]


def changed(one: Ball, **update: object) -> Ball:
    """Return the ball with other fields."""
    return Ball(**{**one.model_dump(exclude_none=True), **update})


def same_log(base: Result, other: Result, order: Sequence[int]) -> bool:
    """Whether `other`, whose ball k is ball order[k] of `base`, has the same events to the bit."""
    return rows_of(base, range(len(order))) == rows_of(other, order)
