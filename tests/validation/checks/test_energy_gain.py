"""Planted energy gains, and planted energy differences from the reference, are detected."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from shots import FLIES, R, ball, scene_of

from ghostball.engine import simulate
from ghostball.model import Energy, EventKind, ExactTrajectory, Result, SampledTrajectory
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters import make_engine
from ghostball.reference_adapters.base import resolution_of
from ghostball.validation.checks.accuracy import accuracy_of
from ghostball.validation.checks.criteria import common_criteria
from ghostball.validation.checks.energy_curve import compared_instants
from ghostball.validation.checks.energy_gain import largest_gain, largest_rise, least_cloth_loss
from ghostball.validation.checks.metrics import measure
from ghostball.validation.runs.sampling import energy_at
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.suite.plan import shipped_criteria
from ghostball.validation.truth.scene_truth import Truth, truth_of

SCENES = ("head-on", "half-ball-cut", "draw-shot", "break-7")

STEPPING = (
    "pymunk:contact_steps=exact",
    "pybullet:contact_steps=exact",
    "paper-discrete:dt=1e-4",
    "paper-continuous",
)
"""Engines with so little delay of impacts that the cloth takes less than 1e-4 of the energy."""

UNSUITED = {(label, "draw-shot") for label in STEPPING if label != "pymunk:contact_steps=exact"}
"""Engines whose balls can't slide."""

EXACT_GAIN, STEPPED_GAIN = 1e-12, 1e-4


def rise_of(result: Result, resolution: float | None = 0.0) -> float | None:
    measured = measure(result, Truth(None), ("energy_rise",), resolution=resolution)
    return measured.values["energy_rise"]


def instants_of_impacts(result: Result) -> np.ndarray:
    """Return the times of collisions, with the first and the last time of the run [s]."""
    assert result.events is not None
    collisions = result.events["t"][result.events["kind"] == EventKind.BALL_BALL]
    return np.unique(collisions[[0, -1]])


def with_gain_at(result: Result, t: float, gain: float) -> Result:
    """Return a run in which all balls gain `gain` of the initial energy in an impact at t."""
    motion = result.trajectory
    whole = result.energy([0.0, t]).total
    factor = math.sqrt(1.0 + gain * whole[0] / whole[1])
    if isinstance(motion, ExactTrajectory):
        segments = []
        for one in motion.segments:
            k = int(np.searchsorted(one[:, 0], t, side="right")) - 1
            # The ball continues in the same direction, but faster, in a separate segment from t on.
            state, after = motion.sample(np.array([t])), one[k].copy()
            ball = len(segments)
            after[0] = t
            after[1:3] = state.positions[0, ball, :2]
            after[3:5] = state.velocities[0, ball, :2]
            after[7:10] = state.angular_velocities[0, ball]
            grown = np.vstack([one[: k + (one[k, 0] < t)], after, one[k + 1 :]])
            rows = grown[:, 0] >= t
            grown[np.ix_(rows, [3, 4, 7, 8, 9])] *= factor
            segments.append(grown)
        return replace(result, trajectory=replace(motion, segments=tuple(segments)))
    assert isinstance(motion, SampledTrajectory)
    faster = np.arange(len(motion.times)) >= _first_after(result, motion, t)
    factors = np.where(faster, factor, 1.0)[:, np.newaxis, np.newaxis]
    return replace(
        result,
        trajectory=replace(
            motion,
            velocities=motion.velocities * factors,
            angular_velocities=motion.angular_velocities * factors,
        ),
    )


def _first_after(result: Result, motion: SampledTrajectory, t: float) -> int:
    """Return the first frame in which the balls that collide at t have changed their directions."""
    first = max(int(np.searchsorted(motion.times, t, side="left")) - 1, 0)
    changes = np.abs(np.diff(motion.velocities[first : first + 4], axis=0)).max(axis=(1, 2))
    return first + 1 + int(np.argmax(changes))


@pytest.mark.parametrize("name", SCENES)
def test_a_gain_of_an_exact_engine_at_an_impact_is_seen(name: str) -> None:
    # Fails if the state just before an impact isn't used: since the previous state, the cloth takes
    # 1e9 times as much energy.
    result = simulate(find_scene(name), record="trajectory")
    honest = rise_of(result)
    assert honest is not None
    assert honest <= 1e-15
    for t in instants_of_impacts(result):
        found = rise_of(with_gain_at(result, float(t), EXACT_GAIN))
        assert found == pytest.approx(EXACT_GAIN, rel=0.01)
    limits = [
        one
        for criteria in (shipped_criteria(result.scene), common_criteria())
        for one in criteria.applying_to("ghostball", {}, "rounding")
        if one.metric == "energy_rise"
    ]
    assert all(one.allows(honest) and not one.allows(EXACT_GAIN) for one in limits)


@pytest.mark.parametrize(
    ("label", "name"),
    [*sorted(set(product(STEPPING, SCENES)) - UNSUITED), ("pymunk:dt=1e-4", "head-on")],
)
def test_a_gain_of_a_stepping_engine_at_an_impact_is_seen(label: str, name: str) -> None:
    if label.startswith("pybullet"):
        pytest.importorskip("pybullet")
    scene, engine = find_scene(name), make_engine(label)
    result = engine.simulate(scene, record="trajectory")
    resolution = resolution_of(engine, scene)
    honest = rise_of(result, resolution)
    assert honest is not None
    assert honest <= 1e-9
    for t in instants_of_impacts(result):
        found = rise_of(with_gain_at(result, float(t), STEPPED_GAIN), resolution)
        assert found is not None
        assert found > 0.1 * STEPPED_GAIN


@pytest.mark.parametrize("label", ["pymunk", "pybullet"])
def test_what_a_late_contact_gives_back_is_no_gain_and_more_is(label: str) -> None:
    pytest.importorskip(label)
    # Chipmunk's bounce restores the energy that the cloth took in its step: 3.8e-4 at 0.8 m/s.
    scene, engine = find_scene("head-on"), make_engine(label)
    result, resolution = engine.simulate(scene, record="trajectory"), resolution_of(engine, scene)
    assert rise_of(result, resolution) == 0.0
    in_a_step = 2.0 * 0.02 * 9.81 * 1e-3 / 0.8
    assert rise_of(result) == pytest.approx(in_a_step, rel=0.7)
    (t,) = instants_of_impacts(result)
    found = rise_of(with_gain_at(result, float(t), 2.0 * in_a_step), resolution)
    assert found is not None
    assert found > 0.5 * in_a_step


def test_what_the_cloth_takes_from_undisturbed_balls_is_what_our_engine_loses() -> None:
    # A ball slides, then rolls, then rests; the steps don't end with these phases.
    scene = scene_of(
        ball((0.0, 0.0), (1.0, 0.4), angular_velocity=(10.0, -40.0, 0.0)), preset="pool", table=None
    )
    result = simulate(scene, record="trajectory")
    assert largest_gain(result) <= 1e-15
    times = np.linspace(0.0, result.rest_time, 50)
    states = result.sample(times)
    before, after = (
        type(states)(*(part[rows] for part in states)) for rows in (slice(-1), slice(1, None))
    )
    lost = -np.diff(result.energy(times).total)
    taken = least_cloth_loss(scene, before, after, np.diff(times))
    assert np.all(taken <= lost + 1e-15)
    # `taken` differs from `lost` by the second order of the step, unless a phase ends in the step.
    assert np.sum(taken >= 0.8 * lost) >= 35


def test_the_largest_rise_is_over_the_least_before() -> None:
    assert largest_rise(np.array([2.0, 1.0, 1.5, 0.0])) == 0.5
    assert largest_rise(np.array([2.0, 1.0, 1.0])) == 0.0
    assert math.isnan(largest_rise(np.array([2.0, math.nan, 1.0])))


def test_a_run_that_makes_energy_of_nothing_fails_and_one_that_rests_says_why() -> None:
    still = simulate(scene_of(ball((0.0, 0.0)), ball((1.0, 0.0))), record="trajectory")
    times = np.array([0.0, 1.0])
    shape = (2, 2, 3)
    places = np.full(shape, R)
    resting = replace(still, trajectory=SampledTrajectory(times, places, *np.zeros((2, *shape))))
    measured = measure(resting, Truth(None), ("energy_rise",))
    assert "nothing moves" in measured.notes["energy_rise"]
    assert not measured.incomplete
    moving = np.zeros(shape)
    moving[1] = 1.0
    woken = replace(still, trajectory=SampledTrajectory(times, places, moving, np.zeros(shape)))
    assert measure(woken, Truth(None), ("energy_rise",)).incomplete == {"energy_rise"}


def test_the_cloth_takes_nothing_from_balls_in_the_air() -> None:
    # Fails if a collision of two balls includes the cloth's energy loss of a third ball.
    flier = ball((0.4, 0.9, 0.3), (1.0, 0.0, 0.0), angular_velocity=(0.0, 0.0, 0.0))
    scene = scene_of(flier, ball((0.5, 0.3), (1.0, 0.0)), ball((0.66, 0.3)), **FLIES)
    run = simulate(scene, record="trajectory")
    assert run.events is not None
    instants = run.events["t"]
    even = np.linspace(0.0, run.rest_time, 1500)
    times = np.unique([*even, *instants, *np.nextafter(instants, 0.0)])
    framed = replace(run, trajectory=SampledTrajectory(times, *run.sample(times)))
    assert EventKind.BALL_BALL in run.events["kind"]
    assert largest_gain(framed) <= 1e-15
    (t,) = instants_of_impacts(run)
    assert largest_gain(with_gain_at(framed, float(t), 1e-9)) > 1e-10


def test_energy_is_measured_by_that_with_which_the_shot_starts() -> None:
    # A ball that loses all its speed keeps a rounded remainder, which isn't the initial energy.
    run = simulate(find_scene("head-on"), record="trajectory")
    motion = run.trajectory
    assert isinstance(motion, ExactTrajectory)
    times = np.array([0.0, 1.0])
    positions, velocities, spins = (part.copy() for part in run.sample(times))
    velocities *= np.array([1e-115, 1e-15])[:, np.newaxis, np.newaxis]
    spins *= 0.0
    rounded = replace(run, trajectory=SampledTrajectory(times, positions, velocities, spins))
    found = rise_of(rounded)
    assert found is not None
    assert found <= 1e-29
    accuracy = accuracy_of(rounded, Truth(None))
    assert accuracy is None


def test_who_counts_steps_of_contacts_may_not_gain_energy_for_that() -> None:
    run = simulate(find_scene("head-on"), record="trajectory")
    (t,) = instants_of_impacts(run)
    gains = replace(with_gain_at(run, float(t), 1e-7), engine="mine", work={"contact_steps": 1000})
    assert rise_of(gains) == pytest.approx(1e-7, rel=0.01)


# --- difference from the reference energy


@pytest.mark.parametrize("late", [0.05, -0.05])
def test_nothing_is_compared_between_the_two_instants_of_an_event(late: float) -> None:
    true = simulate(find_scene("half-ball-cut"), record="trajectory")
    assert true.events is not None
    events = true.events.copy()
    events["t"][0] += late
    between = sorted((float(true.events["t"][0]), float(events["t"][0])))
    times = compared_instants(replace(true, events=events), true)
    assert not np.any((times > between[0]) & (times < between[1]))
    assert (times.min(), times.max()) == (0.0, true.rest_time)
    assert compared_instants(true, true, until=0.3).max() <= 0.3


def test_a_run_is_compared_with_the_truth_once_for_all_metrics(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene, calls = find_scene("half-ball-cut"), list[int]()
    run, truth = simulate(scene, record="trajectory"), truth_of(scene)

    def counted(result: Result, times: FloatArray) -> Energy:
        calls.append(len(times))
        return energy_at(result, times)

    monkeypatch.setattr("ghostball.validation.checks.energy_curve.energy_at", counted)
    found = measure(run, truth).values
    assert found["energy_difference_max"] is not None
    assert found["energy_difference_factor"] is not None
    assert len(calls) == 1
