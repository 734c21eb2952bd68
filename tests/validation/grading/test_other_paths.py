"""The limits of a time step are never too small: other paths within reach are detected."""

from __future__ import annotations

import math

import numpy as np
import pytest
from displaced import displaced

from ghostball.model import Ball, Physics, Scene, Table
from ghostball.reference_adapters import make_engine
from ghostball.reference_adapters.base import ReferenceEngine, resolution_of
from ghostball.reference_adapters.function import engine_of
from ghostball.validation.checks.criterion import StepRule
from ghostball.validation.checks.metrics import measure
from ghostball.validation.checks.step_limits import step_criteria
from ghostball.validation.grading.other_paths import Margins
from ghostball.validation.scenes.random_scenes import PROVABLE, random_scene
from ghostball.validation.truth.scene_truth import Truth, truth_of

DISPLACED = engine_of(displaced, "displaced:displaced")
TABLES = ("posts", "pockets", "polygon", "small", "none")
ENDS = {
    "rest_error_max",
    "ball_ball_count_error",
    "ball_cushion_count_error",
    "matching_events",
    "event_time_error",
    "rest_time_error",
    "phase_time_error",
}
RADIUS = 0.028575


def rule_of(engine: ReferenceEngine) -> StepRule:
    return StepRule(
        engines=(engine.name,),
        late=("ball-ball", "ball-cushion"),
        energy_noise=0.5,
        reason="what makes energy isn't tried here",
    )


def limits_broken(scene: Scene, engine: ReferenceEngine, truth: Truth) -> tuple[int, list[str]]:
    """Return the number of limits on the outcome, and the limits that a run breaks."""
    limits = step_criteria(rule_of(engine), engine, scene, truth)
    limits = tuple(one for one in limits if one.metric in ENDS)
    if not limits:
        return 0, []
    resolution = resolution_of(engine, scene)
    names = [one.metric for one in limits]
    result = engine.simulate(scene, record="trajectory")
    measured = measure(result, truth, names, resolution=resolution)
    judged = [(one, measured.values[one.metric]) for one in limits]
    checks = [
        one.check(value, "") for one, value in judged if value is not None or not one.if_measured
    ]
    return len(checks), [check.sentence for check in checks if not check.passed]


def judge_random(numbers: range, table: str, dt: float = 1e-3, **other: str) -> int:
    """Simulate random scenes on displaced engines; return the number of judged limits."""
    judged = 0
    for number in numbers:
        scene = random_scene(number, **{**PROVABLE, "table": table, **other})
        truth = truth_of(scene)
        if truth.lateness is None:
            continue
        for seed in (0, 1):
            engine = DISPLACED(DISPLACED.Settings(seed=seed, dt=dt))
            count, broken = limits_broken(scene, engine, truth)
            assert not broken, (number, table, seed, broken)
            judged += count
    return judged


@pytest.mark.parametrize("table", TABLES)
def test_a_displaced_exact_engine_keeps_the_limits_of_its_step(table: str) -> None:
    assert judge_random(range(71, 75), table) > 0


def test_a_displaced_exact_engine_finds_the_first_collisions_of_many_balls() -> None:
    assert judge_random(range(1, 5), "small", 4e-3, count="many", cloth="slows") > 0


def test_a_late_bounce_moves_the_end_of_a_ball_that_spins_on_its_place() -> None:
    # The last event is at 1.5 s; then a ball spins until 4.3 s, with the spin from the cushion.
    assert judge_random(range(123, 124), "posts") > 0


def test_an_early_hit_changes_when_a_ball_comes_to_a_cushion_that_it_all_but_reaches() -> None:
    # The ball reaches the cushion at 0.034 m/s, 4 s after the first hit, and rests 6 mm after it.
    assert judge_random(range(300, 301), "pool", 1e-4, count="few") > 0


@pytest.mark.slow
@pytest.mark.parametrize("table", TABLES)
def test_a_displaced_exact_engine_keeps_its_limits_in_200_scenes(table: str) -> None:
    # 40 scenes for each of 5 tables, most of which must be judged.
    assert judge_random(range(100, 140), table) > 40


# --- worked by hand ---------------------------------------------------------------------------


def margins_of(*balls: Ball, table: Table | None = None, t_max: float | None = None) -> Margins:
    physics = Physics(preset="paper")
    scene = Scene(name="by-hand", physics=physics, balls=balls, table=table, t_max=t_max)
    lateness = truth_of(scene).lateness
    assert lateness is not None
    assert lateness.margins is not None
    return lateness.margins


def ball(name: str, x: float, y: float, vx: float = 0.0) -> Ball:
    return Ball(id=name, position=(x, y), velocity=(vx, 0.0), radius=RADIUS, mass=0.17)


def test_a_hit_is_missed_by_the_sum_of_the_radii_less_its_offset() -> None:
    margins = margins_of(ball("a", 0.0, 0.0, 1.0), ball("b", 0.3, 0.03))
    assert np.count_nonzero(margins.turns) == 1
    assert margins.widths[margins.turns] == pytest.approx([2.0 * RADIUS - 0.03], rel=1e-9)
    # No event comes before this hit, so only its own delay counts.
    assert margins.amplified(np.zeros(margins.moved.shape[1]), 2) == pytest.approx([1.0, 1.0])


def test_the_gap_at_which_a_ball_passes_another_is_a_margin() -> None:
    gap = 1e-3
    table = Table(length=1.0, width=0.5)
    # The ball passes after each bounce, whose delay displaces it only along its path.
    margins = margins_of(
        ball("a", 0.8, 0.25, 1.0), ball("b", 0.5, 0.25 + 2.0 * RADIUS + gap), table=table
    )
    passes = np.flatnonzero(np.isclose(margins.widths, gap, rtol=1e-6))
    assert len(passes) > 0
    assert margins.moved[passes].max() < 1e-2
    # With a displacement across the path that is larger than the gap, the ball may hit.
    assert margins.amplified(np.zeros(margins.moved.shape[1]), 2, drift=2.0 * gap) is None
    assert margins.amplified(np.zeros(margins.moved.shape[1]), 2, drift=0.5 * gap) is not None


def test_a_ball_that_all_but_stops_short_of_a_cushion_may_stop_short_of_it() -> None:
    table = Table(length=1.0, width=0.5)
    deceleration = 0.02 * 9.81
    physics = Physics(preset="paper", rolling_friction=0.02)
    left = 1e-4  # distance that it would still roll
    speed = math.sqrt(2.0 * deceleration * (0.4 + left))
    moving = ball("a", 1.0 - RADIUS - 0.4, 0.25, speed)
    scene = Scene(name="by-hand", physics=physics, balls=[moving], table=table)
    lateness = truth_of(scene).lateness
    assert lateness is not None
    assert lateness.margins is not None
    assert lateness.margins.widths.min() == pytest.approx(left, rel=1e-6)


@pytest.mark.parametrize("part", [0.1, 0.3, 0.6])
def test_what_shortens_the_way_of_a_slow_ball_is_amplified_by_no_less_than_it_comes_late(
    part: float,
) -> None:
    # A ball at speed v with the deceleration a would stop after v^2 / 2 a: a displacement d delays
    # it by (v - sqrt(v^2 - 2 a d)) / a, to first order d / v, and changes v by a times this delay.
    speed, slowed = 0.1, 0.2
    stops = speed**2 / (2.0 * slowed)
    moved = part * stops
    exact = (speed - math.sqrt(speed**2 - 2.0 * slowed * moved)) / slowed
    times, one = np.zeros(1), np.ones(1, dtype=bool)
    margins = Margins(
        times, np.array([stops]), np.ones((1, 1)), ~one, one, ((0,),), times, (0,), math.inf
    )
    factors = margins.amplified(np.array([moved]), 1)
    assert factors is not None
    assert exact / (moved / speed) < factors[0] < 1.0 / (1.0 - part)
    assert margins.amplified(np.array([stops]), 1) is None


def test_a_late_bounce_takes_twice_what_it_overshoots_from_the_way_that_is_left() -> None:
    table, width = Table(length=1.0, width=0.5), 1.0 - 2.0 * RADIUS
    physics = Physics(preset="paper", rolling_friction=0.02)
    speed = math.sqrt(2.0 * 0.02 * 9.81 * (0.5 - RADIUS + width + 1e-3))
    scene = Scene(name="late", physics=physics, balls=[ball("a", 0.5, 0.25, speed)], table=table)
    lateness = truth_of(scene).lateness
    assert lateness is not None
    assert lateness.margins is not None
    (last,) = np.flatnonzero(np.isclose(lateness.margins.widths, 1e-3, rtol=1e-6))
    # The overshoot counts twice, out and back; the loss of speed there is a part of this.
    assert lateness.margins.moved[last, 0] == pytest.approx(2.0 * lateness.approach[0], rel=1e-6)


def test_what_displaces_one_pair_amplifies_nothing_of_another() -> None:
    turns = np.array([True, True])
    moved = np.array([[1.0], [1.0]])
    widths, balls, times = np.array([2e-3, 4e-3]), ((0, 1), (2, 3)), np.zeros(2)
    margins = Margins(times, widths, moved, turns, ~turns, balls, times, (0, 0), math.inf)
    factors = margins.amplified(np.array([1e-3]), 4)
    assert factors == pytest.approx([1.5, 1.5, 1.25, 1.25])


def test_pymunk_on_a_round_post_is_not_called_wrong() -> None:
    pytest.importorskip("pymunk")
    text = """
        schema = 1
        name = "sinai"
        title = "Sinai's billiard"
        t_max = 10.0
        [physics]
        preset = "paper"
        rolling_friction = 0.0
        [table]
        length = 1.002
        width = 1.002
        [[table.posts]]
        centre = [0.501, 0.501]
        radius = 0.199
        [[balls]]
        id = "p"
        position = [0.1, 0.37]
        velocity = [0.6, 0.8]
        radius = 0.001
        mass = 0.01
    """
    scene = Scene.loads(text)
    truth = truth_of(scene)
    for label in ("pymunk", "pymunk:dt=1e-4"):
        engine = make_engine(label)
        count, broken = limits_broken(scene, engine, truth)
        assert not broken, label
        assert count <= 1, label  # at most the limit on the first collisions
        assert truth.horizon_of(resolution_of(engine, scene)) < scene.t_max


def spun(spin: float, *others: Ball) -> Scene:
    """Return a scene whose first ball is at rest with a spin that makes it roll away."""
    first = Ball(
        id="a", position=(0.0, 0.0), angular_velocity=(0.0, spin, 0.0), radius=RADIUS, mass=0.17
    )
    return Scene(name="spun", physics=Physics(preset="pool"), balls=[first, *others])


def test_what_a_ball_passes_while_its_spin_speeds_it_up_is_seen() -> None:
    gap = 1e-3
    lateness = truth_of(spun(200.0, ball("b", 0.28, 2.0 * RADIUS + gap))).lateness
    assert lateness is not None
    assert lateness.margins is not None
    assert np.min(lateness.margins.widths) == pytest.approx(gap, rel=1e-3)
    assert np.isfinite(lateness.margins.since).all()


def test_a_shot_that_is_too_long_to_look_at_has_no_margins(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ghostball.validation.grading.near_misses._MOST_NUMBERS", 1000)
    lateness = truth_of(spun(100.0, ball("b", 0.28, 0.1))).lateness
    assert lateness is not None
    assert lateness.margins is None


def test_of_a_shot_of_too_many_events_the_first_are_looked_at(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for module in ("other_paths", "lateness"):
        monkeypatch.setattr(f"ghostball.validation.grading.{module}.MOST_EVENTS", 1)
    scene = spun(100.0, ball("b", 0.28, 0.0))
    truth = truth_of(scene)
    _, broken = limits_broken(scene, DISPLACED(DISPLACED.Settings()), truth)
    assert not broken
    assert truth.lateness is not None
    margins = truth.lateness.margins
    assert margins is not None
    assert math.isfinite(margins.until)
    assert margins.amplified(np.zeros(5), 2) is None
