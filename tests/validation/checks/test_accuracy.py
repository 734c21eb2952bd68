"""The accuracy class must not depend on the engine, and unphysical runs have no error."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from toy_engines import ToyEngine, cut

from ghostball.engine import simulate
from ghostball.model import EventKind, Result, Scene
from ghostball.reference_adapters import make_engine
from ghostball.validation.checks.accuracy import BROKEN_SHARE, accuracy_of, kind_of
from ghostball.validation.grading.horizon import Meetings
from ghostball.validation.results.records import CERTIFIED, Accuracy
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.suite.case import run_case
from ghostball.validation.suite.judge import Case
from ghostball.validation.truth.scene_truth import Truth, truth_of


@pytest.fixture(scope="module")
def truth() -> Truth:
    return truth_of(cut())


def displaced(by: float, scene: Scene | None = None) -> Result:
    engine = ToyEngine(ToyEngine.Settings(model=by))
    result: Result = engine.simulate(scene or cut(), record="trajectory")
    return result


def class_of(result: Result, truth: Truth, resolution: float = 0.0) -> Accuracy:
    found = accuracy_of(result, truth, resolution=resolution)
    assert found is not None
    return found


@pytest.mark.parametrize(
    ("by", "kind"),
    [
        (0.0, "exact"),
        (1e-15, "exact"),
        (1e-12, "nanometres"),
        (0.9e-6, "nanometres"),
        (1.1e-6, "micrometres"),
        (0.9e-3, "micrometres"),
        (1.1e-3, "millimetres"),
        (1.1e-2, "centimetres"),
        (3.0, "centimetres"),
    ],
)
def test_the_class_is_that_of_the_farthest_ball(truth: Truth, by: float, kind: str) -> None:
    found = class_of(displaced(by), truth)
    assert found.kind == kind
    assert found.error == pytest.approx(by, abs=1e-14)


def test_a_shot_is_exact_only_if_every_ball_is(truth: Truth) -> None:
    right = displaced(0.0)
    for ball in (0, 1):
        positions = right.final_state.positions.copy()
        positions[0, ball, 0] += 1e-9
        moved = right.final_state._replace(positions=positions)
        found = class_of(replace(right, final_state=moved), truth)
        assert found.kind == "nanometres"


@pytest.mark.parametrize(("horizon", "kind"), [(0.9, None), (1.1, "another shot")])
def test_a_collision_is_judged_up_to_the_horizon_of_rounding(
    truth: Truth, horizon: float, kind: str | None
) -> None:
    # The collision is at t; errors reach the radius of a ball at `horizon` times t.
    t = float(truth.collision_times[0])
    grown = Meetings(np.array([horizon * t]), np.array([np.inf]), 1.0, cut().balls[0].radius)
    chaotic = replace(truth, kind=CERTIFIED, graded=None, meetings=grown)
    right = displaced(0.0)
    assert right.events is not None
    without = replace(right, events=right.events[right.events["kind"] != EventKind.BALL_BALL])
    found = accuracy_of(without, chaotic)
    assert (found and found.kind) == kind


def test_a_class_ends_where_the_next_begins() -> None:
    kinds = [kind_of(error) for error in (0.0, 1e-6, 1e-3, 1e-2, 1e9)]
    assert kinds == ["nanometres", "micrometres", "millimetres", "centimetres", "centimetres"]


def test_rounding_is_what_it_makes_of_this_shot() -> None:
    # 9e-14 m is rounding after 3141 collisions, but not after a straight roll.
    scene = find_scene("galperin-2")
    result, truth = simulate(scene, record="trajectory"), truth_of(scene)
    found = class_of(result, truth)
    assert found.kind == "exact"
    assert found.error is not None
    assert found.error > 5e-14
    positions = result.final_state.positions + np.array([1e-9, 0.0, 0.0])
    moved = result.final_state._replace(positions=positions)
    off = class_of(replace(result, final_state=moved), truth)
    assert off.kind == "nanometres"


def test_other_collisions_are_another_shot_wherever_the_balls_end(truth: Truth) -> None:
    result = displaced(0.0)
    assert result.events is not None
    without = replace(result, events=result.events[result.events["kind"] != EventKind.BALL_BALL])
    found = class_of(without, truth)
    assert (found.kind, found.agree, found.of, found.error) == ("another shot", 0, 1, None)
    assert found.at == pytest.approx(float(truth.collision_times[0]))


def test_the_same_scale_holds_for_every_engine() -> None:
    scene = find_scene("half-ball-cut")
    kinds = {}
    truth = truth_of(scene)
    for label in ("ghostball", "pymunk", "pymunk:contact_steps=exact", "pymunk:config=naive"):
        result = make_engine(label).simulate(scene, record="trajectory")
        found = class_of(result, truth)
        kinds[label] = found.kind
    assert kinds == {
        "ghostball": "exact",
        "pymunk": "millimetres",
        "pymunk:contact_steps=exact": "nanometres",
        "pymunk:config=naive": "centimetres",
    }


def test_where_rounding_decides_the_balls_are_compared_before_that() -> None:
    scene = find_scene("chaos-a")
    truth = truth_of(scene)
    found = class_of(simulate(scene, record="trajectory"), truth)
    assert found.kind == "exact"
    assert truth.graded is not None
    assert found.at == truth.graded.until
    stepped = make_engine("paper-discrete").simulate(scene, record="trajectory")
    other = class_of(stepped, truth)
    assert other.kind in ("another shot", "broken")


def test_energy_out_of_nothing_is_broken() -> None:
    scene = cut()
    result = make_engine("pymunk").simulate(scene, record="trajectory")
    frames: Any = result.trajectory
    late = frames.times > 0.5 * frames.times[-1]
    for factor, kind in ((1.0, None), (3.0, "broken")):
        velocities = frames.velocities.copy()
        velocities[late] *= factor
        made = replace(result, trajectory=replace(frames, velocities=velocities))
        found = class_of(made, truth_of(scene), 1e-3)
        assert (found.kind == "broken") == (kind == "broken")
        if kind == "broken":
            assert found.cause == "energy"
            assert found.amount is not None
            assert found.amount > BROKEN_SHARE


def test_balls_through_each_other_and_nan_are_broken() -> None:
    scene = cut()
    result = make_engine("pymunk").simulate(scene, record="trajectory")
    frames: Any = result.trajectory
    positions = frames.positions.copy()
    middle = len(positions) // 2
    positions[middle, 1] = positions[middle, 0] + [0.5 * scene.balls[0].radius, 0.0, 0.0]
    through = replace(result, trajectory=replace(frames, positions=positions))
    found = class_of(through, truth_of(scene), 1e-3)
    assert (found.kind, found.cause) == ("broken", "overlap")
    velocities = frames.velocities.copy()
    velocities[middle] = np.nan
    nowhere = replace(result, trajectory=replace(frames, velocities=velocities))
    with np.errstate(invalid="ignore"):
        found = class_of(nowhere, truth_of(scene), 1e-3)
    assert (found.kind, found.cause) == ("broken", "not finite")


def test_in_a_contact_that_lasts_collisions_are_not_counted() -> None:
    # Nothing moves in this contact; the balls are in place whether an engine reports collisions or
    # not.
    scene = find_scene("wedged")
    for label in ("pymunk", "pymunk:contact_steps=exact"):
        result = make_engine(label).simulate(scene, record="trajectory")
        assert sum(result.collision_counts.values()) > 0
        found = class_of(result, truth_of(scene), 1e-3)
        assert found.kind == "micrometres"


def test_our_engine_has_no_class_where_it_is_the_truth() -> None:
    scene = find_scene("push-line")
    record, _ = run_case(Case(scene, "ghostball", truth_of(scene)))
    assert record.accuracy is None
