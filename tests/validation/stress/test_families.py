"""Generated shots are valid scenes with right limits, and a wrong result is detected."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
import wrong_runs
from right_shots import broken, judged, stress_shots
from shots import kept_scene

from ghostball.engine import simulate
from ghostball.model import EventKind, Scene, energy_of, first_energy
from ghostball.reference_adapters.certified import certify
from ghostball.reference_adapters.registry import make_engine
from ghostball.validation.checks.criteria import Criteria
from ghostball.validation.checks.requirements import asked_of
from ghostball.validation.grading.tolerances import EPS
from ghostball.validation.scenes.random_scenes import random_scene
from ghostball.validation.stress import (
    FAMILIES,
    StressError,
    StressShot,
    StressSize,
    chosen_shots,
    lasting,
    path_of,
    storms,
)
from ghostball.validation.stress.long_runs import galperin, galperin_shot
from ghostball.validation.stress.pockets import wedge
from ghostball.validation.stress.shots import lasts, parameters_of
from ghostball.validation.stress.touching import (
    EVENTS_PER_BALL,
    RADIUS,
    STEPS_PER_BALL,
    triangle,
)
from ghostball.validation.stress.tunnelling import crossing, passing
from ghostball.validation.suite.case import plain_settings, run_case
from ghostball.validation.suite.judge import Case
from ghostball.validation.truth.scene_truth import Truth, truth_of

FULL = StressSize(full=True, count=10)


def shot(name: str, size: StressSize = FULL) -> StressShot:
    (found,) = (one for path, one in stress_shots(size, name))
    return found


def broken_in(shot: StressShot, result) -> set[str]:
    """Return the metrics whose limits a run breaks: limits of the shot, or limits for all shots."""
    found = broken(result, *shot.criteria.criteria)
    return {sentence.partition(" must be")[0] for sentence in found}


@pytest.mark.parametrize("size", [StressSize(count=10), FULL], ids=["quick", "full"])
@pytest.mark.parametrize("family", FAMILIES)
def test_each_shot_is_a_scene_with_a_name_of_its_own(family: str, size: StressSize):
    scenes = [one.scene for one in FAMILIES[family].shots(size)]
    assert len({scene.name for scene in scenes}) == len(scenes) > 0
    for scene in scenes:
        assert Scene.model_validate(scene.model_dump(by_alias=True)) == scene
        assert scene.tags[:2] == ("stress", family)
        parameters_of(scene.tags)


def test_shots_are_chosen_by_pattern_and_what_is_not_there_is_refused():
    hits = chosen_shots(StressSize(), ["grazing/*-hit-1e-01"])
    assert {path_of(one.scene.name) for one in hits} > {"grazing/rolling-hit-1e-01"}
    (rare,) = chosen_shots(StressSize(), ["grazing/rolling-hit-1e-02"])  # in no smaller size
    assert rare.scene.name == "grazing.rolling-hit-1e-02"
    for name in ("grasing", "grazing/*-9e-99"):
        with pytest.raises(StressError, match=r"no family or shot is called .*Families: grazing"):
            chosen_shots(StressSize(), [name])


def test_the_random_breaks_are_those_of_the_numbers_that_are_asked_for():
    names = [name for name, _ in stress_shots(StressSize(seed=7, count=2), "storms")]
    assert names == ["storms/break-00007", "storms/begun-00007", "storms/break-00008"]
    scene = random_scene(8, **storms.BREAKS)
    assert shot("storms/break-00008", StressSize(seed=7, count=2)).scene.balls == scene.balls


def test_a_shot_that_lasts_is_asked_of_no_engine_with_a_step():
    slow, rests = shot("extremes/speed-elastic-1e-09"), shot("extremes/speed-rolling-1e-09")
    assert (slow.stepped, rests.stepped) == (False, True)
    assert lasts(rests.scene) >= simulate(rests.scene).rest_time > 0.0
    assert certify(slow.scene).events  # the scene isn't empty


def test_an_engine_with_a_step_is_not_blamed_for_an_energy_that_vanishes():
    """The speed is the smallest double and its square is 0, so energy fractions are undefined."""
    tiny, engine = shot("extremes/tiny-sliding-4.94066e-324"), make_engine("pymunk")
    asked = asked_of([(engine.name, plain_settings(engine))], tiny.criteria)
    limits = asked.limits(engine, tiny.scene, truth_of(tiny.scene))
    assert "energy_difference_max" not in {one.metric for one in limits}


@pytest.mark.parametrize("kind", ["rolling", "elastic", "sliding", "small", "curved", "cushion"])
def test_a_miss_and_a_phantom_are_seen(kind: str):
    hit, miss = (shot(f"grazing/{kind}-{word}-1e-01") for word in ("hit", "miss"))
    runs = [simulate(one.scene, record="trajectory") for one in (hit, miss)]
    assert (broken_in(hit, runs[0]), broken_in(miss, runs[1])) == (set(), set())
    for asked, run in ((miss, runs[0]), (hit, runs[1])):
        assert "collision_count" in broken_in(asked, replace(run, scene=asked.scene))


@pytest.mark.parametrize("gap", ["0", "1e-15", "1e-09"])
def test_a_gap_on_an_axis_is_what_it_says(gap: str):
    a, b = shot(f"touching/pair-elastic-into-gap-{gap}-turned-0.0").scene.balls
    opened = Fraction(b.position[0]) - Fraction(a.position[0]) - 2 * Fraction(RADIUS)
    assert abs(opened - Fraction(float(gap))) <= Fraction(2) ** -57  # an ulp of the position
    assert (opened == 0) == (gap == "0")


def test_a_triangle_is_its_own_image():
    places = triangle(15, 1e-9)
    assert len(places) == 120
    assert {(x, -y) for x, y in places} == set(places)
    assert np.hypot(*np.subtract(places[1], places[0])) >= 2 * RADIUS


@pytest.mark.parametrize("name", ["bisector-to-0-0-from-2e-01", "corner-rolling-slanting-gap-0"])
def test_a_corner_that_gives_one_cushion_only_is_seen(name: str):
    asked = shot(f"touching/{name}")
    assert truth_of(asked.scene).kind == "certified"
    assert broken_in(asked, simulate(asked.scene, record="trajectory")) == set()
    table = asked.scene.table.model_copy(update={"cushions": ("left",)})
    half = asked.scene.model_copy(update={"table": table})
    run = replace(simulate(half, record="trajectory"), scene=asked.scene)
    assert {"ball_cushion_count", "cushion_overlap_max"} <= broken_in(asked, run)


@pytest.mark.compiled
def test_what_rows_racks_and_wedges_need_is_a_third_of_what_they_may():
    """The limits are three to four times the largest need; wider limits would detect little."""
    events, steps = [], []
    for name, one in stress_shots(FULL, "touching"):
        if name.startswith(("touching/line-", "touching/triangle-", "touching/wedged-")):
            work, n = simulate(one.scene).work, len(one.scene.balls)
            events.append(work["events"] / n)
            steps.append(work["contact_steps"] / n)
            assert "elastic" not in name or steps[-1] == 0
    assert 0.25 * EVENTS_PER_BALL < max(events) <= EVENTS_PER_BALL / 3
    assert 0.25 * STEPS_PER_BALL < max(steps) <= STEPS_PER_BALL / 3


@pytest.mark.compiled
def test_what_impacts_that_last_need_is_a_third_of_what_they_may():
    most = max(
        len(simulate(one.scene, record="events").events) / len(one.scene.balls)
        for _, one in stress_shots(FULL, "lasting/*")
    )
    assert 0.25 * lasting.EVENTS_PER_BALL < most <= lasting.EVENTS_PER_BALL / 3


@pytest.mark.parametrize(("overlap", "seen"), [(1e-5, False), (5e-3, True)])
def test_an_overlap_that_needs_more_energy_than_there_is_is_seen(overlap: float, seen: bool):
    wrong = shot("lasting/row-of-2-elastic-gap-1e-04")
    result = wrong_runs.right(wrong.scene)
    frames = wrong_runs.frames_of(result)
    places = frames.positions.copy()
    first = int(np.searchsorted(frames.times, wrong_runs.events_in(result)["t"][0])) - 1
    places[first, 0, 0] = places[first, 1, 0] - (2.0 * RADIUS - overlap)
    result = wrong_runs.with_frames(result, positions=places)
    assert ("overlap_max" in broken_in(wrong, result)) is seen


def test_a_row_that_takes_too_many_events_or_steps_or_leaves_some_unsolved_is_seen():
    asked = shot("touching/line-of-5-sliding-gap-0")
    run = simulate(asked.scene, record="trajectory")
    assert broken_in(asked, run) == set()
    assert "event_count" in broken_in(asked, replace(run, events=np.repeat(run.events, 36)))
    for name, count in (("contact_steps", 6 * 51 + 1), ("unsolved_contact_steps", 1)):
        metric = name.partition("_contact")[0]
        assert metric in broken_in(asked, replace(run, work={**run.work, name: count}))


def test_the_collisions_of_galperin_are_the_digits_of_pi():
    assert [galperin(k) for k in range(9)] == [int("314159265"[: k + 1]) for k in range(9)]


def test_galperin_shots_ask_for_each_collision_for_their_energy_and_for_no_overlap():
    limits = {one.metric: one for one in shot("long-runs/galperin-4").criteria.criteria}
    counts = (limits["ball_ball_count"].equals, limits["ball_cushion_count"].equals)
    assert counts == (15_708, 15_707)
    assert limits["energy_drift"].at_most <= 7e-12
    assert limits["overlap_max"].at_most <= 2e-12


@pytest.mark.compiled
@pytest.mark.parametrize("seed", [0, 7])
def test_a_gas_that_collides_too_often_or_too_seldom_is_seen(seed: int):
    asked = shot("long-runs/gas-1000", StressSize(seed=seed))
    run = simulate(asked.scene, record="trajectory")
    assert broken_in(asked, run) == set()
    for share in (0.6, 1.5):
        counts = {kind: int(share * count) for kind, count in run.collision_counts.items()}
        assert broken_in(asked, replace(run, collision_counts=counts)) == {"ball_ball_count"}


@pytest.mark.compiled
@pytest.mark.parametrize("path", [path for path, _ in stress_shots(StressSize(), "reversal")])
def test_each_shot_of_the_quick_size_is_turned_round_and_measured(path: str):
    asked = shot(path, StressSize())
    found = judged(asked.scene, asked.criteria, reference=False)
    assert found.faults == ()
    measured = {check.metric for check in found.record.checks if check.passed is not None}
    assert {"reversal_error", "reversal_factor"} <= measured


@pytest.mark.slow
@pytest.mark.compiled
@pytest.mark.parametrize(("name", "times"), [("gas-100000", 100.0), ("galperin-6", 1.0)])
def test_runs_too_long_to_be_recorded_keep_their_energy_and_count(name: str, times: float):
    """A gas has ten million collisions, Galperin's balls have 3 141 592."""
    if name.startswith("galperin"):
        scene, count = galperin_shot(6), galperin(6)
    else:
        scene, count = shot(f"long-runs/{name}").scene, None
    scene = scene.model_copy(update={"t_max": times * scene.t_max})
    result = simulate(scene, max_events=40_000_000)
    collisions = sum(result.collision_counts.values())
    assert collisions == count if count else collisions > 10_000_000
    left = energy_of(scene, result.final_state).total[0] / first_energy(scene)
    walk = 16.0 * math.sqrt(collisions) / len(scene.balls)
    assert abs(left - 1.0) <= EPS * (16.0 + walk if count is None else collisions)


@pytest.mark.compiled
def test_the_longest_break_known_needs_an_eighth_of_what_is_allowed():
    work = simulate(kept_scene("break-of-most-events")).work  # number 944, the largest of 6550
    needed = work["events"] + work["contact_steps"]
    assert 8 * needed <= storms.MOST_EVENTS < 9 * needed


@pytest.mark.parametrize("phase", [0.0, 0.25, 0.875])
def test_contact_comes_a_phase_after_whole_steps_and_before_the_end(phase: float):
    step, speed, depth = 0.004, 2.0, 0.1
    scene = passing(depth, speed, step, phase)
    (event,) = simulate(scene, record="events").events
    assert event["kind"] == EventKind.BALL_BALL
    assert (event["t"] / step) % 1.0 == pytest.approx(phase, abs=1e-9)
    assert scene.t_max > event["t"] + 2.0 * crossing(depth) / speed
    # The end is a whole number of steps, so no engine shortens its step.
    assert math.ceil(scene.t_max / step) * step == pytest.approx(scene.t_max, rel=1e-8)


@pytest.mark.parametrize(("engine", "chord"), [("pymunk", 1.0), ("paper-discrete", 2.0)])
def test_the_cliff_is_where_theory_puts_it(engine: str, chord: float):
    # Pymunk detects a contact while balls approach, on half of the chord; the paper's algorithm on
    # all of it.
    speed, depth = 2.0, 0.1
    longest = chord * crossing(depth) / speed
    for step in (0.8 * longest, 1.25 * longest):
        made = make_engine(f"{engine}:dt={step}")
        shots = [made.simulate(passing(depth, speed, step, k / 32)) for k in range(32)]
        missed = sum(not run.collision_counts["ball-ball"] for run in shots)
        # The share of missed collisions is 1 - c / (v dt) if the engine detects a contact over a
        # distance c.
        assert missed / 32 == pytest.approx(max(0.0, 1.0 - longest / step), abs=0.05)


@pytest.mark.parametrize("degrees", [90.5, 31.0, 7.0, 1.0])
def test_a_proof_says_how_often_a_ball_bounces_in_a_corner(degrees: float):
    scene, count = wedge(math.radians(degrees))
    certificate = certify(scene, cached=False)
    assert certificate.proved
    assert len(certificate.events) == count


def test_a_ball_that_falls_and_must_not_is_seen():
    falls, hangs = shot("pockets/falling-1e-03"), shot("pockets/hanging-1e-03")
    run = simulate(falls.scene, record="trajectory")
    assert broken_in(falls, run) == set()
    assert broken_in(hangs, replace(run, scene=hangs.scene)) == {"pocketed_count"}


def test_an_engine_with_a_step_is_held_to_the_limits_of_a_shot():
    """A cradle that passes its speed to the first ball only fails by its rest positions."""
    asked = shot("touching/cradle-1-into-2-gap-0")
    engine = make_engine("pybullet")
    limits = asked_of([(engine.name, plain_settings(engine))], asked.criteria)
    truth: Truth = truth_of(asked.scene)
    record, _ = run_case(Case(asked.scene, "pybullet", truth, limits))
    assert "rest_error_max" in {one.metric for one in record.checks if one.passed is False}
    free = asked_of([(engine.name, plain_settings(engine))], Criteria())
    record, _ = run_case(Case(asked.scene, "pybullet", truth, free))
    assert record.passed
