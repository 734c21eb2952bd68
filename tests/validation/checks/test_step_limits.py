"""Limits from the time step: a worse engine fails, and an engine within its step's limit passes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from step_rules import asked_of_all, criteria_of_step, limit_of_step
from wrong_runs import events_in, frames_of, resting_at, with_events, with_frames, with_late_events

from ghostball import Feature, plays
from ghostball.model import Ball, EventKind, Physics, Record, Result, Scene, Table
from ghostball.reference_adapters import make_engine
from ghostball.reference_adapters.base import resolution_of
from ghostball.reference_adapters.function import engine_of
from ghostball.reference_adapters.pymunk.engine import PymunkEngine
from ghostball.validation.checks.criteria import Criteria, common_criteria
from ghostball.validation.checks.criterion import StepRule
from ghostball.validation.checks.metrics import measure
from ghostball.validation.checks.step_limits import step_criteria
from ghostball.validation.checks.verdict import Verdict, verdict_of
from ghostball.validation.results.records import CaseRecord
from ghostball.validation.runs.engine_runs import run_ours
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.suite.case import plain_settings, run_case
from ghostball.validation.suite.judge import Case
from ghostball.validation.truth.scene_truth import truth_of

pytest.importorskip("pymunk")


def with_settings(engine: PymunkEngine, **changes: Any) -> PymunkEngine:
    values = {**engine.settings.model_dump(), **changes}
    return PymunkEngine(PymunkEngine.Settings.model_validate(values))


class CoarserEngine(PymunkEngine):
    """An engine with a time step ten times as long as declared."""

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        coarse = with_settings(self, dt=10.0 * self.settings.step)
        return coarse.simulate(scene, record=record)


class FixedEngine(PymunkEngine):
    """An engine that declares steps that end at contacts, but has fixed steps."""

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        return with_settings(self, contact_steps="fixed", dt=1e-3).simulate(scene, record=record)


class WrongSignEngine(PymunkEngine):
    """An engine that reverses the initial spins, so that friction has the wrong sign."""

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        balls = tuple(
            ball.model_copy(update={"angular_velocity": spin and tuple(-w for w in spin)})
            for ball in scene.balls
            for spin in [ball.angular_velocity]
        )
        wrong = scene.model_copy(update={"balls": balls})
        return replace(super().simulate(wrong, record=record), scene=scene)


def judged(scene_name: str, engine: PymunkEngine) -> CaseRecord:
    """Run a shipped scene on an engine, judged only by the limits of its time step."""
    return judged_in(find_scene(scene_name), engine)


def judged_in(scene: Scene, engine: PymunkEngine) -> CaseRecord:
    """Run a scene on an engine, judged only by the limits of its time step."""
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
def test_an_engine_that_claims_exact_steps_must_end_steps_at_contacts(name: str) -> None:
    exact = PymunkEngine.Settings(contact_steps="exact")
    assert verdict_of(judged(name, PymunkEngine(exact))) is Verdict.PASS
    assert "rest_error_max" in broken(judged(name, FixedEngine(exact)))


@pytest.mark.parametrize("speed", [0.7515606237993473, 0.7548096777227437, 0.8450587876152478])
def test_a_ball_may_bounce_with_an_older_velocity_than_spin(speed: float) -> None:
    """Chipmunk uses the velocity before its step; the adapter sets the spin after it."""
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
    # The limit is proportional to the step, and slightly larger for coarse steps.
    assert coarse / middle == pytest.approx(10.0, rel=0.02)
    assert middle / fine == pytest.approx(10.0, rel=0.002)


def test_an_amplifying_shot_is_allowed_more() -> None:
    gentle, thin = (limit_of_step(find_scene(name), "pymunk") for name in ("head-on", "thin-cut"))
    assert gentle is not None
    assert thin is not None
    assert thin > 5 * gentle


def test_events_that_are_not_late_add_nothing_to_the_limit() -> None:
    # If the engine ends slides without delay, the limit contains only the delay of collisions.
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
    # The balls approach at 2.5 m/s, so one step of 1 ms allows an overlap of 2.5 mm.
    balls = [
        Ball(id="a", position=(0.3, 0.5), velocity=(1.5, 0.0)),
        Ball(id="b", position=(1.2, 0.5), velocity=(-1.0, 0.0)),
    ]
    scene = Scene(name="head-on", balls=balls)
    found = criteria_of_step(scene, make_engine("pymunk:dt=1e-3"))
    (limit,) = (one.limit for one in found if one.metric == "overlap_max")
    assert 2.5e-3 + 1e-13 < limit < 2.5e-3 + 1e-11  # plus the rounding of positions


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


@cache
def unchanged(scene: Scene, record: Record) -> Result:
    """Simulate a scene with Pymunk, once for all changes."""
    return PymunkEngine().simulate(scene, record=record)


def with_change(change: Callable[[Result], Result]) -> type[PymunkEngine]:
    """Return Pymunk with a change of its results."""

    class Changed(PymunkEngine):
        def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
            return change(unchanged(scene, record))

    return Changed


def right(result: Result) -> Result:
    return result


def late(result: Result) -> Result:
    """Report each event 2 ms (two time steps) too late, and the rest 20 ms too late."""
    return resting_at(with_late_events(result, 2e-3), result.rest_time + 0.02)


def dull(result: Result) -> Result:
    """Report velocities that are 5 % too low, in all frames except the first."""
    velocities = frames_of(result).velocities.copy()
    velocities[1:] *= 0.95
    return with_frames(result, velocities=velocities)


def shifted(kind: EventKind, by: float) -> Callable[[Result], Result]:
    """Return a change that reports the events of a kind later by `by` [s]."""
    return lambda result: with_late_events(result, by, [kind])


def mispocketing(result: Result) -> Result:
    """Report falls into the next pocket."""
    events = events_in(result).copy()
    falls = events["kind"] == EventKind.POCKETED
    events["b"][falls] = (events["b"][falls] + 1) % 6
    return replace(result, events=events)


def silent(result: Result) -> Result:
    """Report no falls into pockets."""
    events = events_in(result)
    return with_events(result, events[events["kind"] != EventKind.POCKETED])


def swerving(result: Result) -> Result:
    """Report a ball 10 cm beside its path for a while, and a right rest position."""
    positions = frames_of(result).positions.copy()
    many = len(positions)
    positions[many * 3 // 10 : many * 6 // 10, 0, 1] += 0.1
    return with_frames(result, positions=positions)


def failed_with(name: str, change: Callable[[Result], Result]) -> set[str]:
    """Return the limits that Pymunk with a change fails in a shipped scene."""
    return broken(judged(name, with_change(change)()))


HITS = ("head-on", "draw-shot", "restitution-head-on")
SLIDES = ("draw-shot", "stun-shot", "throw-slip")
POCKETS = ("pocket-draw", "pocket-bank")
PATHS = ("half-ball-cut", "draw-shot", "stop", "pocket-draw")
WRONG: tuple[tuple[tuple[str, ...], Callable[[Result], Result], set[str]], ...] = (
    (tuple({*HITS, *SLIDES, *POCKETS, *PATHS}), right, set()),
    (HITS, late, {"event_time_error", "rest_time_error"}),
    (HITS, dull, {"energy_difference_max"}),
    (SLIDES, shifted(EventKind.SLIDE_TO_ROLL, -0.06), {"phase_time_error"}),
    (SLIDES, shifted(EventKind.ROLL_TO_REST, -0.06), {"phase_time_error"}),
    (POCKETS, mispocketing, {"events_missing", "events_invented"}),
    (POCKETS, silent, {"events_missing"}),
    (POCKETS, shifted(EventKind.POCKETED, -0.1), {"event_time_error"}),
    (PATHS, swerving, {"path_error"}),
)
"""Scenes, a change of Pymunk's results, and the limits that the change breaks at least."""

ALONE = ({"phase_time_error"}, {"path_error"})
"""Sets of limits that break without any other limit."""


@pytest.mark.parametrize(
    ("name", "change", "least"),
    [(name, change, least) for names, change, least in WRONG for name in sorted(names)],
)
def test_motion_and_events_of_a_stepping_engine_must_agree_with_its_step(
    name: str, change: Callable[[Result], Result], least: set[str]
) -> None:
    failed = failed_with(name, change)
    assert failed >= least
    assert failed == least or (least and least not in ALONE)


@plays(*Feature)
def behind(scene: Scene, dt: float = 1e-3) -> dict[str, object]:
    """Simulate a scene exactly, and report the motion one time step too late."""
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
        ((0.0, 0.0), (0.0, 100.0, 0.0)),  # the slip is 3.5 times the largest speed
        ((1.0, 0.0), (0.0, -120.0, 0.0)),  # draw: the slip is 4.4 times the largest speed
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


def test_a_limit_wider_than_a_ball_is_no_limit() -> None:
    scene = find_scene("thin-cut")
    radius = float(scene.radii[0])
    fine, coarse = (limit_of_step(scene, f"pymunk:dt={dt}") for dt in ("1.5e-3", "5e-3"))
    assert fine is not None
    assert fine < radius < 2.5 * fine
    assert coarse is None
    found = {one.metric for one in criteria_of_step(scene, make_engine("pymunk:dt=5e-3"))}
    assert found == {"energy_rise", "overlap_max", "matching_events", "early_path_error"}


@pytest.mark.parametrize("name", ["break-7", "frozen-triangle", "break-16"])
def test_the_path_before_the_first_contact_is_asked_where_the_end_cannot_be_judged(
    name: str,
) -> None:
    def aside(result: Result) -> Result:
        positions = frames_of(result).positions.copy()
        positions[1, 0, 1] += 0.02  # after the first step
        return with_frames(result, positions=positions)

    scene = find_scene(name)
    found = {one.metric: one for one in criteria_of_step(scene, make_engine("pymunk"))}
    # The limit is about the distance that a ball moves in a step.
    assert found["early_path_error"].limit < 1.5e-3 * np.max(
        np.linalg.norm(scene.velocities, axis=1)
    )
    assert "early_path_error" not in failed_with(name, right)
    assert "early_path_error" in failed_with(name, aside)


@pytest.mark.parametrize(
    ("kind", "b"),
    [(EventKind.BALL_CLOTH, -1), (EventKind.BALL_CUSHION, 0), (EventKind.BALL_BALL, 1)],
)
def test_a_contact_that_no_ball_could_have_hides_nothing_of_the_path_before(
    kind: EventKind, b: int
) -> None:
    scene = find_scene("half-ball-cut")
    engine = make_engine("pymunk")
    run = engine.simulate(scene, record="trajectory")
    positions = frames_of(run).positions.copy()
    positions[1:, 0, 1] += 0.01
    aside = with_frames(run, positions=positions)
    early = np.array([(1e-9, kind, 0, b)], dtype=events_in(run).dtype)
    said = with_events(aside, np.concatenate([early, events_in(run)]))
    for shown in (aside, said):
        found = measure(
            shown, truth_of(scene), ["early_path_error"], resolution=resolution_of(engine, scene)
        )
        assert found.values["early_path_error"] == pytest.approx(0.01, abs=2e-3)


@pytest.mark.parametrize("unknown", [np.nan, np.inf])
def test_past_what_has_no_derivative_only_the_beginning_is_judged(unknown: float) -> None:
    scene, engine = find_scene("stun-shot"), make_engine("pymunk")
    truth = truth_of(scene)
    assert truth.lateness is not None
    lateness = replace(truth.lateness, places=np.full_like(truth.lateness.places, unknown))
    rule = Criteria().step_rule(engine.name, plain_settings(engine), common_criteria())
    assert rule is not None
    known, past = (
        {one.metric for one in step_criteria(rule, engine, scene, each)}
        for each in (truth, replace(truth, lateness=lateness))
    )
    assert {"rest_error_max", "ball_ball_count_error"} <= known
    assert past - {"matching_events"} == {"energy_rise", "overlap_max", "early_path_error"}


@pytest.mark.parametrize(
    ("name", "t_max"), [("cue-jump", 0.32), ("flight-bounces", 0.17), ("flight-lands", 0.34)]
)
def test_the_first_landing_comes_on_time(name: str, t_max: float) -> None:
    """Fails if an engine may report landings later than its time step explains.

    Each shot ends 30 ms after its first landing.
    """
    pytest.importorskip("pybullet")
    scene, engine = find_scene(name).model_copy(update={"t_max": t_max}), make_engine("pybullet")
    truth = truth_of(scene)
    rule = Criteria().step_rule(engine.name, plain_settings(engine), common_criteria())
    assert rule is not None
    limits = {one.metric: one.limit for one in step_criteria(rule, engine, scene, truth)}
    run = engine.simulate(scene, record="trajectory")
    resolution = resolution_of(engine, scene)

    def error(result: Result) -> float:
        measured = measure(result, truth, ["first_landing_error"], resolution=resolution)
        return float(measured.values["first_landing_error"])

    assert error(run) < limits["first_landing_error"] <= 3.001e-3
    late = with_late_events(run, 5e-3, [EventKind.BALL_CLOTH])
    assert error(late) > limits["first_landing_error"]
