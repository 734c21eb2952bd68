"""Tests of batches: each shot is bit-identical to `simulate`, in any thread."""

import importlib
from collections.abc import Callable
from functools import partial

import numpy as np
import pytest
from batches import assert_same, assert_same_outcomes, two_ball_shot
from interrupts import ctrl_c
from shots import FLIES, POOL_TABLE, R, ball, crowded_table, rack, random_break, scene_of

from ghostball.engine import simulate, simulate_many, simulate_starts, simulate_sweep
from ghostball.engine.batch import batch_of
from ghostball.engine.core import state as st
from ghostball.engine.running.calls import Limits
from ghostball.engine.running.driver import KernelRun
from ghostball.model import GhostballError, Scene, Table, UnsupportedSceneError


def test_no_scenes_give_an_empty_batch():
    batch = simulate_many([])
    assert batch.rest_positions.shape == (0, 0, 3)
    assert len(batch.complete) == 0


def test_many_scenes_are_as_one_by_one():
    scenes = [scene_of(ball((0.0, 0.0), (1.0, 0.0))), two_ball_shot()]
    batch = simulate_many(scenes, threads=2)
    for k, scene in enumerate(scenes):
        assert_same(batch, k, simulate(scene))


@pytest.mark.parametrize("wrong", [0, -2, 1.5, True])
def test_a_wrong_number_of_threads_is_refused(wrong):
    with pytest.raises(GhostballError, match="threads"):
        simulate_many([two_ball_shot()], threads=wrong)


@pytest.mark.compiled
@pytest.mark.parametrize("way", ["sweep", "many", "starts"])
def test_endless_shots_are_interrupted(way):
    """This must hold with polars, too, after whose signal handler the system continues a wait."""
    importlib.import_module("polars")
    # Reaching the event limit would take days.
    rolls_on = scene_of(
        ball((0.5, 0.5), (1.0, 0.3)), table=POOL_TABLE, rolling_friction=0.0, t_max=1e50
    )
    simulate_sweep(rolls_on, 1.0, 0.3, max_events=2)  # compiles the kernel before Ctrl-C is sent
    simulate_many([rolls_on], max_events=2)
    endless: Callable[[], object] = partial(
        simulate_sweep, rolls_on, np.linspace(1.0, 2.0, 600), 0.3, max_events=10**12
    )
    if way == "starts":
        slower = np.linspace(0.5, 1.0, 600)[:, None, None] * rolls_on.velocities
        endless = partial(simulate_starts, rolls_on, velocities=slower, max_events=10**12)
    if way == "many":
        endless = partial(simulate_many, [rolls_on] * 50, threads=2, max_events=10**12)
    with pytest.raises(KeyboardInterrupt), ctrl_c():
        endless()


def test_a_scene_beyond_the_engine_is_refused_before_any_run():
    with pytest.raises(UnsupportedSceneError):
        simulate_many([random_break(1), scene_of(ball((0.2, 0.1)), table=crowded_table())])


# Outcomes of each ball, counted while shots are simulated

POCKET_TABLE = Table.model_validate("wpa-9ft")


def unit(angle: float) -> np.ndarray:
    return np.array([np.cos(angle), np.sin(angle)])


def pool_shots(seed: int, count: int) -> list[Scene]:
    """Return shots on a table with pockets: breaks, and shots at balls anywhere."""
    chance = np.random.default_rng(seed)
    scenes = []
    for k in range(count):
        cue = ball((0.6, 0.635), 10 ** chance.uniform(0.0, 1.0) * unit(chance.uniform(-0.3, 0.3)))
        others = rack(9, (1.9, 0.635), 10 ** chance.uniform(-6, -3))
        if k % 2:
            places = chance.permutation(np.stack(np.mgrid[1:8, 1:4], -1).reshape(-1, 2))[:5]
            others = [ball(tuple(0.3 * place)) for place in places if abs(place - 2).max() > 0]
        scenes.append(scene_of(cue, *others, table=POCKET_TABLE, preset="pool"))
    return scenes


def flying_shots(seed: int, count: int) -> list[Scene]:
    """Return shots of balls that may fly over the cushions, or off an open side of the table."""
    chance = np.random.default_rng(seed)
    table = Table(length=1.2, width=1.0, cushions=("left", "right", "bottom"))
    return [
        scene_of(
            ball((0.3, 0.5), (*(chance.uniform(1.0, 4.0) * unit(chance.uniform(-0.4, 0.4))), rise)),
            ball((0.7, 0.5)),
            table=table,
            t_max=4.0,
            **FLIES,
        )
        for rise in chance.choice([0.0, 1.0, 2.5], count)
    ]


@pytest.mark.parametrize("count", [20, pytest.param(500, marks=pytest.mark.compiled)])
@pytest.mark.parametrize("shots", [pool_shots, flying_shots])
def test_outcomes_are_those_of_recorded_events(shots, count):
    scenes = shots(count, count)
    batch = simulate_many(scenes)
    for k, scene in enumerate(scenes):
        assert_same_outcomes(batch, k, simulate(scene, record="events"))
    gone = batch.pocketed >= 0 if shots is pool_shots else batch.off_table
    assert np.any(gone)  # otherwise the shots don't test this outcome
    assert not np.all(gone)
    assert np.any(batch.first_contact[:, 0] >= 0)
    assert np.any(batch.cushions_before > 0)


def test_outcomes_of_several_starts_of_a_scene_are_not_added_up():
    # Fails if a shot starts with the counters of the shot before it in the same memory.
    (scene,) = pool_shots(1, 1)
    batch = simulate_starts(scene, velocities=np.stack([scene.velocities] * 3), threads=1)
    for k in range(3):
        assert_same_outcomes(batch, k, simulate(scene, record="events"))


def test_outcomes_of_a_shot_that_is_interrupted_go_on():
    (scene,) = pool_shots(2, 1)
    run = KernelRun(scene, keep_log=False)
    while run._counters[st.STATUS] in (st.RUN_CONTINUES, st.RUN_PAUSED):
        run.play(Limits(events=10**6, work=10**9), budget=1)
    assert_same_outcomes(
        batch_of(run._place.shots, R, (scene,)), 0, simulate(scene, record="events")
    )


def test_balls_that_a_shot_has_not_got_have_no_outcome():
    batch = simulate_many([*pool_shots(3, 1), two_ball_shot()])
    assert np.all(batch.pocketed[1, 2:] == -1)
    assert np.all(np.isnan(batch.pocketed_at[1, 2:]))
    assert np.all(batch.first_contact[1, 2:] == -1)
    assert not batch.ball_cushions[1, 2:].any()
    assert not batch.off_table[1, 2:].any()


def test_a_frame_has_a_row_for_each_shot_and_goes_to_parquet(tmp_path):
    polars = pytest.importorskip("polars")
    batch = simulate_many(pool_shots(4, 3))
    frame = batch.to_frame()
    assert frame.height == 3
    assert frame["status"].to_list() == ["rest"] * 3
    assert np.array_equal(frame["first_contact"], batch.first_contact[:, 0])
    assert np.array_equal(batch.to_frame(cue=2)["cushions_before"], batch.cushions_before[:, 2])
    frame.write_parquet(tmp_path / "shots.parquet")
    again = polars.read_parquet(tmp_path / "shots.parquet")
    for name in ("pocketed", "pocketed_at", "rest_positions", "ball_cushions"):
        assert np.array_equal(again[name].to_numpy(), getattr(batch, name), equal_nan=True), name


def test_a_batch_without_shots_has_no_frame():
    with pytest.raises(GhostballError, match="needs at least one shot"):
        simulate_many([]).to_frame()


@pytest.mark.parametrize("cue", [-1, 10, 0.0, True])
def test_a_frame_of_a_cue_ball_that_is_not_there_is_refused(cue):
    with pytest.raises(GhostballError, match="`cue` must be the index of a ball, 0 to 9"):
        simulate_many(pool_shots(5, 1)).to_frame(cue)
