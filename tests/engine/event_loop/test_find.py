"""Tests of the reasons for which a run ends before its next event."""

from __future__ import annotations

from shots import POOL_TABLE, ball, scene_of

from ghostball.engine import simulate, simulate_many
from ghostball.model import Status


def test_a_limit_ends_a_shot_and_says_what_was_done():
    scene = scene_of(
        ball((0.5, 0.5), (1.0, 0.3)), table=POOL_TABLE, rolling_friction=0.0, t_max=9e9
    )
    result = simulate(scene, max_work=1_000)
    assert result.status is Status.WORK_LIMIT
    assert not result.status.complete
    assert "events" in result.reason
    assert "work 100" in result.reason
    assert result.settings["max_work"] == 1_000
    assert 0.0 < result.rest_time < 9e9
    few = simulate(scene, record="events", max_events=5)
    assert (few.status, len(few.events)) == (Status.EVENT_LIMIT, 5)
    assert "5 events" in few.reason
    assert few.rest_time == few.events["t"][-1]
    batch = simulate_many([scene], max_work=1_000)
    assert batch.rest_times[0] == result.rest_time
    assert not batch.complete[0]
