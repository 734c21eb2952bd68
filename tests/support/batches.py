"""Compare a batch of shots with single runs."""

from __future__ import annotations

import numpy as np
from shots import POOL_TABLE, ball, scene_of

from ghostball.engine import STATUSES, Batch
from ghostball.model import Result, Scene


def two_ball_shot(velocity=(2.0, 0.0), **cue) -> Scene:
    cue_ball = ball((0.6, 0.6), velocity, **cue)
    return scene_of(cue_ball, ball((1.6, 0.635)), table=POOL_TABLE, preset="pool")


def assert_same(batch: Batch, k: int, result: Result) -> None:
    """Assert that shot k of a batch is bit-identical to the result of a single run."""
    n = len(result.scene.balls)
    assert np.array_equal(batch.rest_positions[k, :n], result.rest_positions)
    assert np.all(np.isnan(batch.rest_positions[k, n:]))
    assert batch.rest_times[k] == result.rest_time
    assert batch.ball_ball[k] == result.collision_counts["ball-ball"]
    assert batch.ball_cushion[k] == result.collision_counts["ball-cushion"]
    assert batch.events[k] == result.work["events"]
    assert STATUSES[batch.status[k]] is result.status
