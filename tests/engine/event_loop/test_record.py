"""Tests that a NaN or an infinity ends a run with a message that names the ball; no run hangs."""

from __future__ import annotations

import math

import numpy as np
import pytest
from shots import POOL_TABLE, ball, scene_of

from ghostball.engine import simulate
from ghostball.engine.core import state as st
from ghostball.engine.running.calls import Limits
from ghostball.engine.running.driver import KernelRun
from ghostball.model import Status

MOTION = ("X", "Y", "VX", "VY", "AX", "AY", "WX", "WY", "WZ", "BX", "BY", "BZ", "EPOCH")
CONSTANTS = (
    "RADIUS", "MASS", "ROLL_SLOWING", "SLIDE_SLOWING", "SPIN_SLOWING", "CLOTH_FRICTION", "OWN_TIME",
)  # fmt: skip
NOT_FINITE = [math.nan, math.inf, -math.inf]
INTEGRATED = {"preset": "pool", "ball_impact": "mathavan2014", "cushion": "mathavan2010"}
LAWS = ("rolling", "sliding", "integrated")


def shot(**physics):
    balls = [ball((0.3, 0.3), (2.0, 0.1)), ball((0.8, 0.32)), ball((0.86, 0.36))]
    return scene_of(*balls, table=POOL_TABLE, **physics)


def play_events(run, count):
    """Run the first events of a run, one after the other; the first call starts the run."""
    run.play(Limits(events=10, work=10**8), budget=1)
    while run._counters[st.EVENTS] < count:
        run.play(Limits(events=10, work=10**8), budget=1)


@pytest.mark.compiled  # interpreted, a division by zero raises
@pytest.mark.parametrize("physics", [{}, {"preset": "pool"}], ids=["rolling", "sliding"])
@pytest.mark.parametrize("after", [0, 2, 5])
@pytest.mark.parametrize("name", [*MOTION, *CONSTANTS])
def test_planted_in_the_midst_of_a_run(name, after, physics):
    # Fails if a loop in a kernel waits until a comparison with NaN is true.
    for i in range(3):
        for value in NOT_FINITE:
            run = KernelRun(shot(**physics), True)
            play_events(run, after)
            run._state[i, getattr(st, name)] = value
            with np.errstate(all="ignore"):
                run.go(Limits(events=5_000, work=10**8))
            if run.status is Status.FAILED:
                assert "`balls[" in run.reason
                assert "at t = " in run.reason
            else:  # a number that is no longer read
                assert run.status is Status.REST
                assert np.all(np.isfinite(run.final_state()))


@pytest.mark.parametrize("physics", [{}, {"preset": "pool"}], ids=["rolling", "sliding"])
@pytest.mark.parametrize(("i", "name"), [(0, "X"), (0, "VX"), (0, "VY"), (0, "WZ"), (2, "VX")])
def test_the_ball_and_the_instant_are_named(i, name, physics):
    run = KernelRun(shot(**physics), False)
    play_events(run, 1)
    now = run._clock[st.NOW]
    run._state[i, getattr(st, name)] = math.nan
    with np.errstate(all="ignore"):
        run.go(Limits(events=1_000, work=10**8))
    assert run.status is Status.FAILED
    assert run.reason.startswith(f'`balls[{i}]` ("b{i}") has no finite motion (')
    assert now <= float(run.reason.rpartition("t = ")[2].removesuffix(" s")) < math.inf


@pytest.mark.compiled  # interpreted, a division by zero raises
@pytest.mark.parametrize("physics", [{}, {"preset": "pool"}, INTEGRATED], ids=LAWS)
@pytest.mark.parametrize("speed", [1e10, 1e30, 1e50])
@pytest.mark.parametrize("t_max", [1e-40, 1.0, 1e50])
def test_products_that_may_overflow_end_finite_or_failed(t_max, speed, physics):
    fast = ball((0.3, 0.3), (speed, 0.1 * speed))
    scene = scene_of(fast, ball((0.5, 0.1)), ball((0.57, 0.1)), t_max=t_max, **physics)
    result = simulate(scene, record="events")
    if result.status is Status.FAILED:
        assert result.reason
    else:
        assert all(np.all(np.isfinite(part)) for part in result.final_state)
        assert math.isfinite(result.rest_time)
