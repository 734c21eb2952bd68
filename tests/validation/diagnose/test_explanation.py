"""Explanations name the planted cause of a difference."""

import json
import math
import re
from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
from planted_engines import hit, other_physics, stepping, turned_over
from toy_engines import NoSettings, OtherShotEngine, StrokeChange, ToySettings, other_shot

from ghostball.engine import simulate
from ghostball.model import Ball, EventKind, Scene, Table, UnsupportedSceneError
from ghostball.model.features import EXACT, Feature
from ghostball.reference_adapters import EngineBase, make_engine
from ghostball.reports.reason import reason_of
from ghostball.validation import find_scene
from ghostball.validation.diagnose.attribution import Attribution
from ghostball.validation.diagnose.explanation import (
    ExplanationError,
    _unless_ambiguous,
    explain,
)
from ghostball.validation.diagnose.wrong_factor import LARGEST_REMAINDER
from ghostball.validation.grading.event_logs import Event
from ghostball.validation.runs import time_steps
from ghostball.validation.runs.engine_runs import run_engine
from ghostball.validation.scenes.library import select

TABLE = Table(length=2.0, width=1.0)


def triangle():
    """Return a shot in which the cue ball hits "a" with an overlap of 1 mm, then hits "b"."""
    balls = [
        Ball(id="cue", position=(0.3, 0.5), velocity=(2.0, 0.0)),
        Ball(id="a", position=(0.8, 0.5 + 0.05715 - 0.001)),
        Ball(id="b", position=(1.4, 0.5)),
    ]
    return Scene(name="graze", balls=balls, table=TABLE)


class BlindEngine(EngineBase):
    """Our engine without one ball, which is moved far away."""

    name = "blind"
    Settings = NoSettings
    blind_to = 1

    @property
    def capabilities(self):
        return dict.fromkeys(Feature, EXACT)

    def simulate(self, scene, *, record="rest"):
        far = replace_ball(scene, self.blind_to, (1.9, 0.9))
        return replace(simulate(far, record=record), engine=self.name, scene=scene)


def replace_ball(scene, index, position):
    balls = list(scene.balls)
    balls[index] = Ball(**{**dict(balls[index]), "position": position})
    return Scene(**{**dict(scene), "balls": balls})


def test_a_planted_miss_is_named_with_its_overlap_and_its_competitor():
    scene = triangle()
    found = explain(scene, BlindEngine(), attributed=False)
    parting = found.parting
    assert parting.true.key == (EventKind.BALL_BALL, 0, 1)
    assert parting.other.key == (EventKind.BALL_BALL, 0, 2)
    assert parting.t == parting.true.t == found.known.result.events["t"][0]
    overlap = next(one for one in found.margins if (one.run, one.what) == ("truth", "miss"))
    assert overlap.length == pytest.approx(1e-3, rel=1e-3)
    assert overlap.ulps == pytest.approx(1e-3 / 2.0**-53, rel=0.01)  # coordinates in [1/2, 1)
    cue = next(one for one in found.states if one.ball == "cue")
    assert cue.distance < 1e-12
    assert {one.ball for one in found.states} == {"cue", "a", "b"}


def test_a_planted_collision_is_named_with_the_gap_that_truth_leaves():
    scene = replace_ball(triangle(), 1, (0.8, 0.5 + 0.05715 + 0.002))

    class Seeing(BlindEngine):
        def simulate(self, scene, *, record="rest"):
            near = replace_ball(scene, 1, (0.8, 0.5 + 0.05715 - 0.001))
            return replace(simulate(near, record=record), engine=self.name, scene=scene)

    found = explain(scene, Seeing(), attributed=False)
    assert found.parting.other.key == (EventKind.BALL_BALL, 0, 1)
    assert found.parting.true.key == (EventKind.BALL_BALL, 0, 2)
    gap = next(one for one in found.margins if (one.run, one.what) == ("truth", "collision"))
    assert gap.length == pytest.approx(2e-3, rel=1e-3)


def test_a_planted_swap_is_named_with_the_time_between():
    # Two balls lie on both sides of the cue ball's path, which hits "b" first if `nearer` is
    # negative.
    def scene(nearer):
        balls = [
            Ball(id="cue", position=(0.3, 0.5), velocity=(2.0, 0.0)),
            Ball(id="a", position=(0.8, 0.5 + 0.0285)),
            Ball(id="b", position=(0.8 + nearer, 0.5 - 0.0295)),
        ]
        return Scene(name="fork", balls=balls, table=TABLE)

    class Swapped(BlindEngine):
        def simulate(self, given, *, record="rest"):
            result = simulate(scene(-0.001), record=record)
            return replace(result, engine=self.name, scene=given)

    found = explain(scene(0.001), Swapped(), attributed=False)
    assert found.parting.true.key == (EventKind.BALL_BALL, 0, 1)
    assert found.parting.other.key == (EventKind.BALL_BALL, 0, 2)


def test_where_nothing_parts_the_largest_differences_are_given():
    found = explain(find_scene("half-ball-cut"), other_shot(turn=math.radians(0.01)))
    assert found.parting is None
    assert found.margins == ()
    event, late = found.latest
    assert event.key == (EventKind.BALL_BALL, 0, 1)
    assert late != 0.0
    assert 1e-5 < found.rest_distances.max() < 1e-2
    assert found.attribution.outcome == "model"


def test_chaos_parts_our_engine_from_the_certified_shot():
    found = explain(find_scene("elastic-gas"), make_engine("ghostball"), attributed=False)
    assert found.known.kind == "certified"
    assert len(found.agreement.before) >= 100
    assert found.parting is not None


def test_everything_is_json():
    found = explain(triangle(), BlindEngine(), attributed=False)
    data = json.loads(json.dumps(found.to_dict()))
    assert data["parting"]["true"] == {
        "t": found.parting.true.t,
        "kind": "ball-ball",
        "a": 0,
        "b": 1,
    }
    assert data["truth"]["by"] == "certified"
    assert len(data["rest_differences"]) == 3
    assert data["attribution"] is None


def test_bad_input_is_refused():
    still = Scene(name="still", balls=[Ball(id="a", position=(0.0, 0.0))])
    with pytest.raises(ExplanationError, match="no ball moves"):
        explain(still, make_engine("pymunk"))
    with pytest.raises(ExplanationError, match="`certified` is itself the reference"):
        explain(triangle(), make_engine("certified"))
    with pytest.raises(ExplanationError, match="itself the reference of scene"):
        explain(find_scene("mathavan-cut"), make_engine("ghostball"))
    with pytest.raises(UnsupportedSceneError, match="sliding"):
        explain(find_scene("sliding-stun"), make_engine("paper-discrete"))


def test_a_run_that_stops_early_is_compared_as_far_as_it_goes():
    found = explain(
        find_scene("half-ball-cut"), make_engine("pymunk:max_time=0.5"), attributed=False
    )
    assert not found.result.status.complete
    assert found.parting is None


def test_a_collision_is_described_with_names():
    scene = triangle()
    assert Event(EventKind.BALL_BALL, 0, 2, 1.0).describe(scene) == '"cue" hits "b"'
    assert Event(EventKind.BALL_CUSHION, 1, 3, 1.0).describe(scene) == ('"a" hits the top cushion')
    assert np.isfinite(explain(scene, make_engine("pymunk"), attributed=False).latest[1])


# --- conclusions

SAME = {"dt": 2e-3}
PLANTED = {
    "energy made": (
        hit(),
        stepping(energy=1.02, **SAME),
        "energy rises by 2 % at its ball collision; by the scene's impact law it stays the same",
    ),
    "energy made, head-on": (
        hit(angle=0.0),
        stepping(energy=1.02, **SAME),
        "energy rises by 2 % at its ball collision; by the scene's impact law it stays the same",
    ),
    "energy lost": (
        hit(),
        stepping(energy=0.98, **SAME),
        "energy falls by 2 % at its ball collision; by the scene's impact law it stays the same",
    ),
    "a turned normal": (
        hit(angle=0.0),
        stepping(turned=math.radians(3), **SAME),
        "mine differ from the scene's impact law by 5.2 % of the largest speed before",
    ),
    "sliding": (
        hit(),
        other_physics(motion="sliding"),
        "The balls of mine slide after a ball collision, but mine claims that they roll",
    ),
    "sliding after a cushion": (
        find_scene("wall-bounce"),
        other_physics(motion="sliding"),
        "The balls of mine slide after a cushion contact",
    ),
    "rolling friction": (
        hit(),
        stepping(rolling=5 / 7, **SAME),
        "From the start, mine behaves as if `rolling_friction` were 0.0715: 5/7 of 0.1",
    ),
    "restitution squared": (
        hit(restitution=0.9),
        stepping(restitution=lambda e: e * e, **SAME),
        "behaves as if `ball_restitution` were 0.81: the square of 0.9",
    ),
    "sliding friction": (
        find_scene("sliding-stun"),
        other_physics(sliding_friction=0.22),
        "From the start, mine behaves as if `sliding_friction` were 0.22: 1.1 times 0.2",
    ),
    "milliseconds": (hit(), stepping(times=1e3, **SAME), "its times look like milliseconds"),
    "the step": (hit(), stepping(**SAME), "mine is right except for its time step"),
    "nothing": (find_scene("pool-break-9"), make_engine("ghostball"), "mine is right"),
}


@pytest.mark.parametrize("cause", PLANTED)
def test_a_planted_cause_is_the_conclusion(cause):
    scene, engine, words = PLANTED[cause]
    assert words in reason_of(explain(scene, engine, label="mine"))


def test_no_run_is_made_twice(monkeypatch):
    runs = []

    def counted(engine, scene, record="trajectory"):
        runs.append((engine.settings.dt, scene.t_max))
        return run_engine(engine, scene, record)

    monkeypatch.setattr(time_steps, "run_engine", counted)
    found = explain(hit(), stepping(energy=1.02, **SAME))
    assert found.fault is not None  # the fault was searched for in the run with the shortest step
    assert len(runs) == len(found.attribution.ladder)
    assert len(set(runs)) == len(runs)


def test_a_coefficient_comes_with_what_it_leaves():
    found = explain(hit(), stepping(rolling=5 / 7, **SAME), label="mine")
    assert found.factor.after < LARGEST_REMAINDER * found.factor.before
    assert re.search(r"it would be \S+ \S+, 0\.\d+ % of the error", reason_of(found))


@pytest.mark.parametrize("name", ["break-7", pytest.param("break-16", marks=pytest.mark.slow)])
def test_the_step_is_the_cause_of_a_break_with_wrong_collisions(name):
    # Fails if only the ball that rolls up to the rack is compared, so that the cause is "rounding".
    pytest.importorskip("pymunk")
    found = explain(find_scene(name), make_engine("pymunk"), label="pymunk")
    assert found.parting is not None
    assert found.attribution.outcome == "step"
    first, *_, last = found.attribution.ladder
    assert last.late < 0.1 * first.late
    assert reason_of(found).startswith("The time step of pymunk is the cause.")


@pytest.mark.slow
@pytest.mark.parametrize("wrong", [{"energy": 1.02}, {"energy": 0.98}])
def test_a_fault_at_contacts_is_not_taken_for_the_step_in_a_break(wrong):
    found = explain(find_scene("break-7"), stepping(**wrong, **SAME), label="mine")
    assert found.attribution.outcome == "model"
    assert "2 % at each ball collision" in reason_of(found)


def test_collisions_that_are_as_late_with_every_step_leave_the_cause_open():
    # An engine whose cue ball is too slow with any time step.
    class Slow(OtherShotEngine):
        Settings = ToySettings
        stroke = StrokeChange(speed=-0.01, turn=0.003)

        def simulate(self, scene, *, record="rest"):
            return replace(super().simulate(scene, record=record), settings={"dt": 0.01})

    found = explain(find_scene("pool-break-9"), Slow(), label="mine")
    assert found.parting is not None
    assert found.attribution.outcome == "unseparated"
    assert reason_of(found).startswith("The time step and the model of mine can't be separated")


@pytest.mark.parametrize("name", ["chaos-a", "elastic-gas"])
def test_what_comes_past_the_horizon_is_not_called_wrong(name):
    found = explain(find_scene(name), make_engine("ghostball"), label="ghostball")
    assert found.attribution.outcome == "agrees"
    assert "The rest of the shot can't be compared" in reason_of(found)


def test_where_the_reference_is_ambiguous_nobody_is_wrong():
    # The cue ball is on the axis of a symmetric rack: which ball it hits first can't be decided.
    r = 0.028575
    rack = [(0.5, 0.3), (0.551, 0.3 - 1.001 * r), (0.551, 0.3 + 1.001 * r)]
    balls = [
        Ball(id="cue", position=(0.3, 0.3), velocity=(3.0, 0.0)),
        *(Ball(id=f"b{k}", position=place) for k, place in enumerate(rack)),
    ]
    scene = Scene(name="rack", balls=balls, table=TABLE)
    # The reference result is from our engine; the tested engine simulates the mirrored shot.
    found = explain(scene, turned_over(), label="mine")
    assert "ambiguous" in found.known.why
    assert found.attribution.outcome == "agrees"
    assert "mine agrees with the reference up to" in reason_of(found)


def test_a_first_wrong_collision_that_a_rounding_decides_is_no_error():
    scene = triangle()
    found = explain(scene, BlindEngine(), attributed=False)
    before = Attribution(scene.name, "blind", "blind", "model", "certified")
    for length, outcome in ((1e-17, "agrees"), (1e-12, "model")):
        margin = replace(found.margins[0], run="truth", length=length)
        said = _unless_ambiguous(before, scene, found.agreement, (margin,))
        assert said.outcome == outcome


@pytest.mark.slow
@pytest.mark.parametrize("label", ["pymunk", "pybullet"])
def test_nearly_every_smoke_scene_has_a_conclusion(label):
    pytest.importorskip(label)
    # Steps four times as long as the default make the shortest steps of the series faster.
    engine, outcomes = make_engine(f"{label}:dt=4e-3"), []
    for scene in select(["smoke"]):
        with suppress(UnsupportedSceneError):
            outcomes.append(explain(scene, engine).attribution.outcome)
    assert len(outcomes) > 10
    assert outcomes.count("unseparated") <= 0.1 * len(outcomes)
    assert "model" not in outcomes
