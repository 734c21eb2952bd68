"""Checks of results: every violation of the contract is rejected, with field, rule and value."""

from dataclasses import replace

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.model import (
    EVENT_DTYPE,
    Ball,
    EventKind,
    Result,
    SampledTrajectory,
    Scene,
    Status,
    Table,
    UnsupportedSceneError,
    initial_state,
)
from ghostball.reference_adapters import EngineUnavailableError, engine_names, make_engine
from ghostball.reference_adapters.returned import ResultRefusedError, check_result
from ghostball.validation import find_scene

TABLE = Table(length=2.0, width=1.0, cushions=("left", "right"))
SCENE = Scene(
    name="shot",
    table=TABLE,
    balls=[
        Ball(id="cue", position=(0.5, 0.5), velocity=(0.8, 0.0)),
        Ball(id="object", position=(1.5, 0.5)),
    ],
)
N = len(SCENE.balls)


@pytest.fixture(scope="module")
def whole():
    """A run in which balls collide, and one ball meets the right cushion."""
    result = simulate(SCENE, record="trajectory")
    assert result.collision_counts == {"ball-ball": 1, "ball-cushion": 1}
    return result


def check(result, record="trajectory"):
    check_result(result, SCENE, "ghostball", record)


def planted(result, k, **values):
    """Return the result with changed values of its k-th event."""
    events = result.events.copy()
    for field, value in values.items():
        events[field][k] = value
    return replace(result, events=events)


def frames(result, times, *, positions=None):
    """Return the result with a motion in frames, in which no ball moves."""
    state = initial_state(SCENE)
    repeated = [np.repeat(part, len(times), axis=0) for part in state]
    if positions is not None:
        repeated[0] = positions
    return replace(result, trajectory=SampledTrajectory(np.array(times), *repeated))


def first(result, kind):
    return int(np.flatnonzero(result.events["kind"] == kind)[0])


def test_a_run_in_order_passes(whole):
    check(whole)
    times = np.array([0.0, 1.0, 1.0, whole.rest_time])
    check(frames(whole, times, positions=whole.sample(times).positions))
    check(replace(whole, events=None, trajectory=None), "rest")
    check(replace(whole, trajectory=None), "events")
    counts = {kind: np.int64(count) for kind, count in whole.collision_counts.items()}
    check(replace(whole, collision_counts=counts, work={"steps": np.int32(3)}))


SHOTS = ["half-ball-cut", "throw-slip", "galperin-1"]  # rolling; sliding; no friction


def represents(engine, scene):
    try:
        engine.check(scene)
    except UnsupportedSceneError:
        return False
    return True


@pytest.mark.parametrize("name", [name for name in engine_names() if name != "pybullet"])
def test_every_engine_here_passes(name):
    # A rule that is wrong for an engine would reject the engine in all scenes.
    try:
        engine = make_engine(name)
    except EngineUnavailableError as error:
        optional = {
            "mujoco",
            "box2d",
            "box2d3",
            "dart",
            "physx",
            "rapier",
            "newton",
            "pooltool",
            "billiards",
        }
        optional |= {"planck", "matter-js", "cannon-es"}
        if name not in optional:
            raise
        pytest.skip(str(error))
    scene = next(scene for scene in map(find_scene, SHOTS) if represents(engine, scene))
    result = engine.simulate(scene, record="trajectory")
    check_result(result, scene, name)


COUNTS = '`collision_counts["ball-ball"]` must be a whole number from 0 to 2^53, got '
WRONG = {
    "another type": (lambda r: {"engine": "ghostball"}, "must return a `Result`, got dict"),
    "no result": (lambda r: None, "must return a `Result`, got NoneType"),
    "another engine": (lambda r: replace(r, engine="x"), "`engine` of the result must be"),
    "another scene": (
        lambda r: replace(r, scene=SCENE.model_copy(update={"t_max": 1.0})),
        '`scene` of the result must be the scene that was run, "shot"',
    ),
    "status in words": (
        lambda r: replace(r, status="rest"),
        "`status` must be a `Status` such as `Status.REST`, got 'rest' (text)",
    ),
    "reason": (lambda r: replace(r, reason=None), "`reason` must be text, got None"),
    "time as a text": (lambda r: replace(r, rest_time="1.0"), "got '1.0' (text)"),
    "time that is true": (lambda r: replace(r, rest_time=True), "`rest_time` must be finite"),
    "time before the start": (lambda r: replace(r, rest_time=-1.0), "at least 0 s, got -1.0"),
    "endless": (lambda r: replace(r, rest_time=np.inf), "`rest_time` must be finite"),
    "wall time": (lambda r: replace(r, wall_time=np.nan), "`wall_time` must be finite"),
    "a lost ball": (
        lambda r: replace(
            r, final_state=r.final_state._replace(positions=np.full((1, N, 3), np.nan))
        ),
        '`rest_positions[0]` must be finite, got [nan, nan, nan] for ball "cue"',
    ),
    "a ball too few": (
        lambda r: replace(r, final_state=r.final_state._replace(velocities=np.zeros((1, 1, 3)))),
        "`final_state.velocities` must be an array of floats with shape (1, 2, 3), got an array of "
        "float64 with shape (1, 1, 3)",
    ),
    "positions as lists": (
        lambda r: replace(r, final_state=r.final_state._replace(positions=[[[0.0, 0.0, 0.0]] * N])),
        "`final_state.positions` must be an array of floats",
    ),
    "no state": (lambda r: replace(r, final_state=None), "`final_state.positions` must be"),
    "fewer than none": (
        lambda r: replace(r, collision_counts={"ball-ball": -3, "ball-cushion": 1}),
        COUNTS + "-3",
    ),
    "more than there can be": (
        lambda r: replace(r, collision_counts={"ball-ball": 10**30, "ball-cushion": 1}),
        COUNTS + str(10**30),
    ),
    "half a collision": (
        lambda r: replace(r, collision_counts={"ball-ball": 1.5, "ball-cushion": 1}),
        COUNTS + "1.5",
    ),
    "one as a float": (
        lambda r: replace(r, collision_counts={"ball-ball": 1.0, "ball-cushion": 1}),
        COUNTS + "1.0",
    ),
    "true for one": (
        lambda r: replace(r, collision_counts={"ball-ball": True, "ball-cushion": 1}),
        COUNTS + "True",
    ),
    "numpy's true": (
        lambda r: replace(r, collision_counts={"ball-ball": np.True_, "ball-cushion": 1}),
        COUNTS,
    ),
    "a count missing": (
        lambda r: replace(r, collision_counts={"ball-ball": 1}),
        '`collision_counts` must have exactly the keys "ball-ball" and "ball-cushion", got '
        "{'ball-ball': 1}",
    ),
    "a kind too many": (
        lambda r: replace(r, collision_counts={**r.collision_counts, "ball-moon": 0}),
        "must have exactly the keys",
    ),
    "no counts": (
        lambda r: replace(r, collision_counts=None),
        "`collision_counts` must have exactly",
    ),
    "counts that the log denies": (
        lambda r: replace(r, collision_counts={"ball-ball": 2, "ball-cushion": 1}),
        '`collision_counts["ball-ball"]` must be the number of these events, 1, got 2',
    ),
    "work": (lambda r: replace(r, work={"steps": -1}), "`work['steps']` must be a whole number"),
    "work unnamed": (lambda r: replace(r, work={3: 1}), "`work` must have texts as keys, got 3"),
    "no work": (lambda r: replace(r, work=None), "`work` must map texts to"),
    "a setting": (
        lambda r: replace(r, settings={"dt": {}}),
        "`settings['dt']` must be text, a finite number, True, False or None, got {} (dict)",
    ),
    "an endless setting": (lambda r: replace(r, settings={"dt": np.inf}), "got inf"),
    "no settings": (lambda r: replace(r, settings=None), "`settings` must map texts to"),
    "a forgotten log": (
        lambda r: replace(r, events=None),
        '`events` must be given for record="trajectory", got None',
    ),
    "a log of another type": (
        lambda r: replace(r, events=np.zeros((3, 4))),
        "`events` must be an array (k,) of dtype `EVENT_DTYPE`",
    ),
    "a log of two dimensions": (
        lambda r: replace(r, events=np.zeros((1, 1), EVENT_DTYPE)),
        "got an array of ",
    ),
    "a time that is none": (lambda r: planted(r, 0, t=np.nan), "`events[0].t` must be finite"),
    "an event before the start": (
        lambda r: planted(r, 0, t=-1e-9),
        "`events[0].t` must be at least 0 s, when the shot starts, got -1e-09",
    ),
    "an event after the end": (
        lambda r: planted(r, -1, t=np.nextafter(r.rest_time, np.inf)),
        "s, when the run ended (`rest_time`), got ",
    ),
    "events out of order": (
        lambda r: planted(r, 1, t=r.events["t"][0] / 2.0),
        "`events[1].t` must be no earlier than the previous event",
    ),
    "a kind that is none": (
        lambda r: planted(r, 0, kind=17),
        "`events[0].kind` must be one of 0 (ball-ball), 1 (ball-cushion), 2 (slide-to-roll), "
        "3 (roll-to-rest), 4 (pocketed), 5 (ball-cloth), 6 (leaves-table), got 17",
    ),
    "ball 99": (
        lambda r: planted(r, first(r, 0), a=99),
        "a` must be the index of a ball, from 0 to 1, got 99",
    ),
    "with ball 99": (
        lambda r: planted(r, first(r, 0), b=99),
        "b` must be the index of a ball, from 0 to 1, got 99",
    ),
    "ball -1": (lambda r: planted(r, 0, a=-1), "a` must be the index of a ball"),
    "with itself": (
        lambda r: planted(r, first(r, 0), b=0),
        "b` must be a different ball from a, got 0",
    ),
    "cushion 9": (
        lambda r: planted(r, first(r, 1), b=9),
        "b` must be the index of an existing cushion: 0 (left), 1 (right), got 9",
    ),
    "an open side": (
        lambda r: planted(r, first(r, 1), b=2),
        "b` must be the index of an existing cushion: 0 (left), 1 (right), got 2",
    ),
    "a ball that leaves over no cushion": (
        lambda r: planted(r, first(r, 1), kind=6, b=-1),
        "b` must be the index of an existing cushion: 0 (left), 1 (right), got -1",
    ),
    "a rest with a cushion": (
        lambda r: planted(r, first(r, 3), b=0),
        "b` must be -1 for an event of a single ball, got 0",
    ),
    "no motion": (
        lambda r: replace(r, trajectory=None),
        '`trajectory` must be given for record="trajectory", got None',
    ),
    "a motion that is none": (
        lambda r: replace(r, trajectory=[]),
        "`trajectory` must be a `Trajectory`: [] (list) lacks `sample` and `t_end`",
    ),
    "frames out of order": (
        lambda r: frames(r, [0.0, 2.0, 1.0]),
        "`trajectory.times` must be finite and never decrease",
    ),
    "a frame at no time": (lambda r: frames(r, [0.0, np.nan]), "`trajectory.times` must be finite"),
    "no frame": (lambda r: frames(r, []), "`trajectory.times` must be an array (k,), got an array"),
    "frames of fewer balls": (
        lambda r: frames(r, [0.0, 1.0], positions=np.zeros((2, 1, 3))),
        "`trajectory.positions` must be an array of floats with shape (2, 2, 3)",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_result_that_breaks_the_contract_is_refused(whole, case):
    plant, says = WRONG[case]
    with pytest.raises(ResultRefusedError) as refused:
        check(plant(whole))
    assert says in str(refused.value)
    assert "Fix `simulate` of engine `ghostball`" in str(refused.value)


def test_a_scene_without_a_table_has_no_cushion():
    scene = Scene(name="open", balls=SCENE.balls)
    result = simulate(scene, record="trajectory")
    k = int(np.flatnonzero(result.events["kind"] == 0)[0])
    events = result.events.copy()
    events["kind"][k] = 1
    counts = {"ball-ball": result.collision_counts["ball-ball"] - 1, "ball-cushion": 1}
    with pytest.raises(ResultRefusedError, match=r"existing cushion: this scene has none"):
        check_result(replace(result, events=events, collision_counts=counts), scene, "ghostball")


def test_what_the_engine_says_stands_in_the_refusal(whole):
    said = replace(whole, status="rest", reason="no more balls")
    with pytest.raises(ResultRefusedError, match=r"\(message from the engine: no more balls\)"):
        check(said)


def test_a_run_that_says_that_it_failed_may_end_anywhere(whole):
    lost = whole.final_state._replace(positions=np.full((1, N, 3), np.nan))
    failed = replace(whole, status=Status.FAILED, reason="nan", final_state=lost, rest_time=np.nan)
    check(failed)
    assert isinstance(failed, Result)


def test_a_ball_that_leaves_the_table_may_name_the_cushion_that_it_leaves_over():
    scene = Scene(
        name="over",
        table=TABLE,
        physics={"preset": "pool", "airborne": True},
        balls=[Ball(id="cue", position=(1.5, 0.5), velocity=(3.0, 0.0, 2.0))],
    )
    result = simulate(scene, record="trajectory")
    assert result.events["kind"].tolist() == [EventKind.LEAVES_TABLE]
    check_result(result, scene, "ghostball", "trajectory")
    with pytest.raises(ResultRefusedError, match="the index of an existing cushion"):
        check_result(planted(result, 0, b=3), scene, "ghostball", "trajectory")


def test_a_ball_in_the_cloth_is_refused_but_not_one_that_left_it(whole):
    sunk = whole.final_state.positions * [1.0, 1.0, 0.0]
    fallen = replace(whole, final_state=whole.final_state._replace(positions=sunk))
    with pytest.raises(
        ResultRefusedError, match=r"`rest_positions\[0\]\[2\]` must be .* got 0.0 m"
    ):
        check(fallen)
    with pytest.raises(
        ResultRefusedError, match=r"`rest_positions\[0\]\[2\]` must be .* got 0.0 m"
    ):
        check(replace(fallen, events=None, trajectory=None), "rest")
    # A solver lets a ball sink in slightly; this is a measurable error, not an invalid result.
    little = whole.final_state.positions - [0.0, 0.0, 1e-3]
    check(replace(whole, final_state=whole.final_state._replace(positions=little)))
    # Balls in a pocket, or off the table, may be anywhere.
    scene = find_scene("pocket-side")
    result = simulate(scene, record="trajectory")
    assert result.events["kind"].tolist()[-1] == EventKind.POCKETED
    below = result.final_state.positions - [0.0, 0.0, 0.1]
    down = replace(result, final_state=result.final_state._replace(positions=below))
    check_result(down, scene, "ghostball")
    check_result(replace(down, events=None, trajectory=None), scene, "ghostball", "rest")
