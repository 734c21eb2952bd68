"""Fails where an engine that is worse than its step would pass, or one that isn't would fail."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from engine_facts import needs
from step_rules import asked_of_all, criteria_of_step, limit_of_step

from ghostball import Feature, plays
from ghostball.model import (
    Ball,
    EventKind,
    Physics,
    Record,
    Result,
    SampledTrajectory,
    Scene,
    Table,
)
from ghostball.reference_adapters import make_engine
from ghostball.reference_adapters.function import engine_of
from ghostball.reference_adapters.pymunk.engine import PymunkEngine
from ghostball.validation.checks.criteria import Criteria, common_criteria
from ghostball.validation.checks.criterion import StepRule
from ghostball.validation.checks.metrics import measure
from ghostball.validation.checks.step_limits import step_criteria
from ghostball.validation.checks.verdict import Verdict, verdict_of
from ghostball.validation.results.records import CaseRecord
from ghostball.validation.runs.playing import run_ours
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.suite.case import plain_settings, run_case
from ghostball.validation.suite.judge import Case
from ghostball.validation.truth.scene_truth import truth_of

pytest.importorskip("pymunk")


def with_settings(engine: PymunkEngine, **changes: Any) -> PymunkEngine:
    values = {**engine.settings.model_dump(), **changes}
    return PymunkEngine(PymunkEngine.Settings.model_validate(values))


class CoarserEngine(PymunkEngine):
    """Steps ten times more coarsely than it says."""

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        coarse = with_settings(self, dt=10.0 * self.settings.step)
        return coarse.simulate(scene, record=record)


class FixedEngine(PymunkEngine):
    """Says that it ends its steps where balls touch, and doesn't."""

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        return with_settings(self, contact_steps="fixed", dt=1e-3).simulate(scene, record=record)


class WrongSignEngine(PymunkEngine):
    """Rubs the wrong way: against the spin that balls don't have."""

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        balls = tuple(
            ball.model_copy(update={"angular_velocity": spin and tuple(-w for w in spin)})
            for ball in scene.balls
            for spin in [ball.angular_velocity]
        )
        wrong = scene.model_copy(update={"balls": balls})
        return replace(super().simulate(wrong, record=record), scene=scene)


def judged(scene_name: str, engine: PymunkEngine) -> CaseRecord:
    """Run a shipped scene on an engine, judged by its step alone."""
    return judged_in(find_scene(scene_name), engine)


def judged_in(scene: Scene, engine: PymunkEngine) -> CaseRecord:
    """Run a scene on an engine, judged by its step alone."""
    rule = Criteria().step_rule(engine.name, plain_settings(engine), common_criteria())
    case = Case(scene, "pymunk", truth_of(scene), asked_of_all((), rule))
    record, _ = run_case(case, lambda _: engine)
    assert record.outcome == "ran", record.reason
    return record


def broken(record: CaseRecord) -> set[str]:
    return {check.metric for check in record.checks if check.passed is False}


@pytest.mark.parametrize(
    "name", ["half-ball-cut", "thin-cut", "moving-moving", "throw-stick", "wall-bounce"]
)
def test_a_step_ten_times_coarser_than_declared_is_seen(name: str) -> None:
    honest = judged(name, PymunkEngine())
    assert verdict_of(honest) is Verdict.PASS
    lying = judged(name, CoarserEngine())
    assert verdict_of(lying) is Verdict.FAIL
    assert "rest_error_max" in broken(lying)


@pytest.mark.parametrize("name", ["head-on", "rail-into", "thin-cut", "catch-up", "break-7"])
def test_who_says_that_steps_end_at_contacts_must(name: str) -> None:
    exact = PymunkEngine.Settings(contact_steps="exact")
    assert verdict_of(judged(name, PymunkEngine(exact))) is Verdict.PASS
    assert "rest_error_max" in broken(judged(name, FixedEngine(exact)))


@pytest.mark.parametrize("speed", [0.7515606237993473, 0.7548096777227437, 0.8450587876152478])
def test_a_ball_may_bounce_with_an_older_velocity_than_spin(speed: float) -> None:
    """Chipmunk takes the velocity from before its step; the adapter sets the spin after it."""
    scene = Scene(
        name="bounce",
        physics=Physics(preset="pool-coulomb", rolling_friction=0.02, cushion="restitution",
                        cushion_restitution=0.8184844763968429),
        table=Table(length=1.2, width=1.0),
        balls=(Ball(id="cue", position=(0.21262968796233336, 0.25), velocity=(speed, 0.0)),),
    )  # fmt: skip
    engine = PymunkEngine()
    record = judged_in(scene, engine)
    assert record.collision_counts["ball-cushion"] == 1
    assert record.metrics["rest_time_error"] > 2e-3  # two steps
    assert not broken(record)


@pytest.mark.parametrize("name", ["gearing", "draw-shot", "throw-slip", "english-running"])
def test_friction_of_the_wrong_sign_is_seen(name: str) -> None:
    assert verdict_of(judged(name, PymunkEngine())) is Verdict.PASS
    assert "rest_error_max" in broken(judged(name, WrongSignEngine()))


def test_the_limit_goes_with_the_step() -> None:
    scene = find_scene("half-ball-cut")
    limits = [limit_of_step(scene, f"pymunk:dt={dt}") for dt in ("1e-3", "1e-4", "1e-5")]
    coarse, middle, fine = (limit for limit in limits if limit is not None)
    # To first order, and a little more for coarse steps.
    assert coarse / middle == pytest.approx(10.0, rel=0.02)
    assert middle / fine == pytest.approx(10.0, rel=0.002)


def test_an_amplifying_shot_is_allowed_more() -> None:
    gentle, thin = (limit_of_step(find_scene(name), "pymunk") for name in ("head-on", "thin-cut"))
    assert gentle is not None
    assert thin is not None
    assert thin > 5 * gentle


@pytest.mark.parametrize(
    ("name", "label", "why"),
    [
        ("galperin-2", "pymunk", "a step holds many collisions of a ball"),
        ("unbounded-cut", "paper-discrete", "in a step balls go more than a radius"),
        ("break-7", "pymunk", "the engine's errors lead the shot onto another path"),
        ("three-ball-symmetric", "pymunk", "two collisions of one instant have no derivative"),
        pytest.param(
            "push", "pybullet", "a contact that lasts isn't proved", marks=needs("pybullet")
        ),
    ],
)
def test_nothing_is_said_of_the_end_where_the_sum_is_not_the_whole_story(
    name: str, label: str, why: str
) -> None:
    assert limit_of_step(find_scene(name), label) is None, why


def test_collisions_of_different_balls_within_a_step_have_no_order() -> None:
    scene = find_scene("throw-by-angle")
    fixed = {one.metric for one in criteria_of_step(scene, make_engine("pymunk:dt=5e-4"))}
    assert "ball_ball_count_error" in fixed
    assert "matching_events" not in fixed
    exact = criteria_of_step(scene, make_engine("pymunk:contact_steps=exact"))
    assert "matching_events" in {one.metric for one in exact}


@pytest.mark.parametrize(
    "name",
    [
        "break-7",  # a ball hits the next one within the step
        "break-16",  # errors of a step grow to a radius at once
        "frozen-triangle",  # the proof ends where balls that touch are hit
    ],
)
def test_the_first_collision_is_asked_where_the_end_cannot_be_judged(name: str) -> None:
    scene = find_scene(name)
    for label in ("pymunk", "pymunk:dt=1e-4"):
        (first,) = (
            one
            for one in criteria_of_step(scene, make_engine(label))
            if one.metric == "matching_events"
        )
        assert (first.limit_kind, first.limit) == ("at_least", 1), label


def test_the_collisions_before_a_tie_are_asked_in_their_order() -> None:
    # "b" meets "c" at 0.3 s; only a second later "d" and "e" are hit at one instant.
    balls = [
        Ball(id="a", position=(0.0, 0.0), velocity=(1.0, 0.0)),
        Ball(id="d", position=(1.0, 0.03)),
        Ball(id="e", position=(1.0, -0.03)),
        Ball(id="b", position=(0.0, 0.7), velocity=(1.0, 0.0)),
        Ball(id="c", position=(0.3, 0.7)),
    ]
    physics = Physics(preset="paper", rolling_friction=0.0)
    scene = Scene(name="tie", physics=physics, balls=balls, t_max=3.0)
    found = criteria_of_step(scene, make_engine("pymunk:dt=1e-3"))
    limits = [(one.limit_kind, one.limit) for one in found if one.metric == "matching_events"]
    assert limits == [("at_least", 1)]
    assert "rest_error_max" not in {one.metric for one in found}


def test_what_an_engine_does_in_time_costs_nothing() -> None:
    # Slides that end in time, and balls that are found in time, add nothing to the limit.
    scene = find_scene("draw-shot")
    both, collisions = (
        StepRule(engines=("pymunk",), late=late, energy_noise=1e-9, reason="by hand")
        for late in (("ball-ball", "slide-to-roll"), ("ball-ball",))
    )
    limits = []
    for rule in (both, collisions):
        record, _ = run_case(Case(scene, "pymunk", truth_of(scene), asked_of_all((), rule)))
        limits += [check.limit for check in record.checks if check.metric == "rest_error_max"]
    assert limits[0] > 1.5 * limits[1]


def test_two_balls_may_overlap_by_what_both_go_in_a_step() -> None:
    # The two close in at 1.5 m/s + 1 m/s, so that one step of 1 ms lets them overlap by 2.5 mm.
    balls = [
        Ball(id="a", position=(0.3, 0.5), velocity=(1.5, 0.0)),
        Ball(id="b", position=(1.2, 0.5), velocity=(-1.0, 0.0)),
    ]
    scene = Scene(name="head-on", balls=balls)
    found = criteria_of_step(scene, make_engine("pymunk:dt=1e-3"))
    (limit,) = (one.limit for one in found if one.metric == "overlap_max")
    assert 2.5e-3 + 1e-13 < limit < 2.5e-3 + 1e-11  # and what rounding of their places makes


def test_balls_that_touch_may_overlap_by_the_rounding_of_their_places_more() -> None:
    balls = [
        Ball(id="a", position=(0.3, 0.6), velocity=(1.0, 0.0)),
        Ball(id="b", position=(0.35714999999999997, 0.6)),
    ]
    scene = Scene(name="touching", balls=balls, t_max=0.01)
    (limit,) = (
        one
        for one in criteria_of_step(scene, make_engine("pymunk:dt=1e-3"))
        if one.metric == "overlap_max"
    )
    assert limit.allows(0.0010000000000000217)
    assert not limit.allows(0.001 + 1e-9)


def test_what_is_stated_replaces_what_is_computed() -> None:
    scene = find_scene("head-on")
    rule = Criteria().step_rule("pymunk", plain_settings(PymunkEngine()), common_criteria())
    stated = Criteria.model_validate(
        {
            "criteria": [
                {
                    "engines": ["pymunk"],
                    "metric": "rest_error_max",
                    "at_most": 1e-9,
                    "reason": "stricter than its step",
                }
            ]
        }
    )
    record, _ = run_case(
        Case(scene, "pymunk", truth_of(scene), asked_of_all(stated.criteria, rule))
    )
    limits = [check.limit for check in record.checks if check.metric == "rest_error_max"]
    assert limits == [1e-9]
    assert broken(record) == {"rest_error_max"}


def test_a_scene_may_say_that_an_engine_errs_by_more_than_its_step() -> None:
    own = Criteria.model_validate(
        {"beyond_step": [{"engines": ["pymunk"], "reason": "it has no such law"}]}
    )
    fixed = plain_settings(PymunkEngine())
    assert own.step_rule("pymunk", fixed, common_criteria()) is None
    assert Criteria().step_rule("pymunk", fixed, common_criteria()) is not None


class LateEngine(PymunkEngine):
    """Reports each collision, and the end, two of its steps too late."""

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        result = super().simulate(scene, record=record)
        assert result.events is not None
        events, late = result.events.copy(), 2.0 * self.settings.step
        events["t"] += late
        motion = result.trajectory
        assert isinstance(motion, SampledTrajectory)
        end = result.rest_time + 10.0 * late
        longer = replace(motion, times=np.append(motion.times[:-1], end))
        return replace(result, events=events, rest_time=end, trajectory=longer)


class DullEngine(PymunkEngine):
    """Shows balls that are a twentieth slower than they go, at the end of each of its steps."""

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        result = super().simulate(scene, record=record)
        motion = result.trajectory
        assert isinstance(motion, SampledTrajectory)
        velocities = motion.velocities.copy()
        velocities[1:] *= 0.95
        return replace(result, trajectory=replace(motion, velocities=velocities))


@pytest.mark.parametrize(
    ("engine", "broken"),
    [
        (PymunkEngine, set()),
        (LateEngine, {"event_time_error", "rest_time_error"}),
        (DullEngine, {"energy_difference_max"}),
    ],
)
@pytest.mark.parametrize("name", ["head-on", "draw-shot", "restitution-head-on"])
def test_who_steps_is_held_to_its_step_in_time_and_energy(
    name: str, engine: type[PymunkEngine], broken: set[str]
) -> None:
    failed = {check.metric for check in judged(name, engine()).checks if check.passed is False}
    assert failed >= broken
    assert bool(failed) == bool(broken)


@plays(*Feature)
def behind(scene: Scene, dt: float = 1e-3) -> dict[str, object]:
    """Show the true motion a step too late."""
    run = run_ours(scene)
    times = np.linspace(0.0, run.rest_time, 400)
    samples = [(float(t) + dt, *(part[0] for part in run.sample([t]))) for t in times]
    return {
        "rest_positions": run.rest_positions,
        "samples": [(0.0, scene.positions, scene.velocities, scene.angular_velocities), *samples],
        "events": [],
        "status": "rest",
    }


@pytest.mark.parametrize(
    ("velocity", "spin"),
    [
        ((0.0, 0.0), (0.0, 100.0, 0.0)),  # slips 3.5 times what it goes at most
        ((1.0, 0.0), (0.0, -120.0, 0.0)),  # draw: slips 4.4 times as much
    ],
)
def test_what_friction_takes_in_a_step_allows_for_spin(
    velocity: tuple[float, float], spin: tuple[float, float, float]
) -> None:
    first = Ball(id="a", position=(0.0, 0.0), velocity=velocity, angular_velocity=spin)
    scene = Scene(name="spun", physics=Physics(preset="pool"), balls=[first])
    engine = engine_of(behind, "behind:behind")()
    rule = StepRule(engines=("behind",), late=("ball-ball",), energy_noise=1e-12, reason="by hand")
    truth = truth_of(scene)
    (limit,) = (
        one
        for one in step_criteria(rule, engine, scene, truth)
        if one.metric == "energy_difference_max"
    )
    measured = measure(engine.simulate(scene, record="trajectory"), truth, [limit.metric])
    off = measured.values[limit.metric]
    assert off is not None
    assert 0.5 * limit.limit < off <= limit.limit


class MispocketingEngine(PymunkEngine):
    """Names the next pocket."""

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        result = super().simulate(scene, record=record)
        assert result.events is not None
        events = result.events.copy()
        falls = events["kind"] == EventKind.POCKETED
        events["b"][falls] = (events["b"][falls] + 1) % 6
        return replace(result, events=events)


class SilentEngine(PymunkEngine):
    """Says nothing of balls that fall."""

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        result = super().simulate(scene, record=record)
        assert result.events is not None
        said = result.events[result.events["kind"] != EventKind.POCKETED]
        return replace(result, events=said)


class EarlyEngine(PymunkEngine):
    """Says that balls fall 0.1 s before they do."""

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        result = super().simulate(scene, record=record)
        assert result.events is not None
        events = result.events.copy()
        events["t"] -= 0.1 * (events["kind"] == EventKind.POCKETED)
        events = events[np.argsort(events["t"], kind="stable")]
        return replace(result, events=events)


@pytest.mark.parametrize(
    ("engine", "broken"),
    [
        (PymunkEngine, set()),
        (MispocketingEngine, {"events_missing", "events_invented"}),
        (SilentEngine, {"events_missing"}),
        (EarlyEngine, {"event_time_error"}),
    ],
)
@pytest.mark.parametrize("name", ["pocket-draw", "pocket-bank"])
def test_who_steps_must_say_which_ball_falls_where_and_when(
    name: str, engine: type[PymunkEngine], broken: set[str]
) -> None:
    failed = {check.metric for check in judged(name, engine()).checks if check.passed is False}
    assert failed >= broken
    assert bool(failed) == bool(broken)


class SwervingEngine(PymunkEngine):
    """Shows a ball 10 cm aside for a while, and ends it in its place."""

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        result = super().simulate(scene, record=record)
        motion = result.trajectory
        assert isinstance(motion, SampledTrajectory)
        positions = motion.positions.copy()
        many = len(positions)
        positions[many * 3 // 10 : many * 6 // 10, 0, 1] += 0.1
        return replace(result, trajectory=replace(motion, positions=positions))


@pytest.mark.parametrize(
    ("engine", "broken"), [(PymunkEngine, set()), (SwervingEngine, {"path_error"})]
)
@pytest.mark.parametrize("name", ["half-ball-cut", "draw-shot", "stop", "pocket-draw"])
def test_who_steps_must_keep_to_the_path(
    name: str, engine: type[PymunkEngine], broken: set[str]
) -> None:
    assert {one.metric for one in judged(name, engine()).checks if one.passed is False} == broken


def test_a_limit_wider_than_a_ball_is_no_limit() -> None:
    scene = find_scene("thin-cut")
    radius = float(scene.radii[0])
    fine, coarse = (limit_of_step(scene, f"pymunk:dt={dt}") for dt in ("1.5e-3", "5e-3"))
    assert fine is not None
    assert fine < radius < 2.5 * fine
    assert coarse is None
    found = {one.metric for one in criteria_of_step(scene, make_engine("pymunk:dt=5e-3"))}
    assert found == {"energy_rise", "overlap_max", "matching_events"}
