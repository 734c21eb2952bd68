"""A NaN or an infinity that gets past the checks ends the run, which says where; nothing hangs."""

from __future__ import annotations

import math

import numpy as np
import pytest
from shots import POOL_TABLE, ball, scene_of

from engine import Status, _state as s, simulate, simulate_sweep
from engine._run import Run
from engine.batch import STATUSES

MOTION = ("X", "Y", "VX", "VY", "AX", "AY", "WX", "WY", "WZ", "BX", "BY", "BZ", "EPOCH")
CONSTANTS = ("RADIUS", "MASS", "ROLL", "SLIDE", "SPIN", "CLOTH", "OWN_TIME")
NOT_FINITE = [math.nan, math.inf, -math.inf]


def shot(**physics):
    balls = [ball((0.3, 0.3), (2.0, 0.1)), ball((0.8, 0.32)), ball((0.86, 0.36))]
    return scene_of(*balls, table=POOL_TABLE, **physics)


def unchecked(scene, i, **fields):
    balls = list(scene.balls)
    balls[i] = balls[i].model_copy(update=fields)
    return scene.model_copy(update={"balls": tuple(balls)})


@pytest.mark.parametrize("record", ["rest", "trajectory"])
@pytest.mark.parametrize("value", NOT_FINITE)
def test_in_a_scene_made_without_its_checks(value, record):
    scene = unchecked(shot(), 1, velocity=(0.0, value, 0.0))
    result = simulate(scene, record=record)
    assert result.status is Status.FAILED
    assert result.reason == (
        f"`balls[1].velocity[1]` is {value} at t = 0 s: the scene was made without its checks"
    )
    assert result.work["events"] == 0
    assert np.array_equal(result.final_state.velocities[0], scene.velocities, equal_nan=True)
    if record == "trajectory":
        with np.errstate(all="ignore"):
            sampled = result.sample([0.0]).positions[0]
        assert np.array_equal(sampled[0], scene.positions[0])


def test_in_a_law_made_without_its_checks():
    scene = shot()
    physics = scene.physics.model_copy(update={"ball_restitution": math.nan})
    result = simulate(scene.model_copy(update={"physics": physics}))
    assert result.status is Status.FAILED
    assert "`physics.ball_restitution` is nan at t = 0 s" in result.reason


def test_in_a_sweep():
    batch = simulate_sweep(unchecked(shot(), 2, mass=math.nan), 1.0, [0.0, 1.0])
    assert [STATUSES[k] for k in batch.status] == [Status.FAILED] * 2


@pytest.mark.compiled  # interpreted, a division by zero raises
@pytest.mark.parametrize("physics", [{}, {"preset": "pool"}], ids=["rolling", "sliding"])
@pytest.mark.parametrize("after", [0, 2, 5])
@pytest.mark.parametrize("name", [*MOTION, *CONSTANTS])
def test_planted_in_the_midst_of_a_run(name, after, physics):
    # Breaks where a loop within a kernel waits for a comparison with NaN to hold.
    for i in range(3):
        for value in NOT_FINITE:
            run = Run(shot(**physics), True)
            if after:
                run._enter(after, False)
            run._state[i, getattr(s, name)] = value
            with np.errstate(all="ignore"):
                run.go(5_000)
            if run.status is Status.FAILED:
                assert "`balls[" in run.reason
                assert "at t = " in run.reason
            else:  # a number that nothing reads any more
                assert run.status is Status.REST
                assert np.all(np.isfinite(run.final_state()))


def test_the_ball_and_the_instant_are_named():
    run = Run(shot(), False)
    run._enter(1, False)
    now = run._clock[s.NOW]
    run._state[2, s.VX] = math.nan
    run.go(1_000)
    assert run.status is Status.FAILED
    assert run.reason.startswith('`balls[2]` ("b2") has no finite motion (position (nan, ')
    assert float(run.reason.rpartition("t = ")[2].removesuffix(" s")) >= now
