"""Rounding explains a change of the input by an ulp, and never a change by 1e-7."""

from __future__ import annotations

import math

import gate
import numpy as np
import pytest
from hypothesis import assume, given, settings, strategies as st

from ghostball import Feature, plays
from ghostball.engine import simulate
from ghostball.engine.sensitivity import EngineTangentMap
from ghostball.model import Scene
from ghostball.reference_adapters.function import engine_of
from ghostball.validation.baselines.compare import compare
from ghostball.validation.baselines.compared_run import ComparedRun, EventLog
from ghostball.validation.baselines.rounding import (
    UNAMPLIFIED,
    allowance,
    allowance_of,
    allowance_of_other,
)
from ghostball.validation.results.records import Accuracy
from ghostball.validation.runs.sampling import events_of
from ghostball.validation.scenes.library import find_scene


def faster(scene: Scene, change) -> Scene:
    """Return a scene with the speed of its first ball changed."""
    cue, *others = scene.balls
    vx, vy, vz = (*cue.velocity, 0.0)[:3]
    moved = cue.model_copy(update={"velocity": (change(vx), vy, vz), "angular_velocity": None})
    return scene.model_copy(update={"balls": (moved, *others)})


def shot(seed: int) -> Scene:
    """Return three balls on a table; one ball hits another one at an angle."""
    chance = np.random.default_rng(seed)
    base = gate.cut_shot(float(chance.uniform(0.5, 2.0)))
    y = float(0.6 + chance.uniform(-0.045, 0.045))
    cue, target = base.balls
    return base.model_copy(
        update={"balls": (cue, target.model_copy(update={"position": (1.0, y, target.radius)}))}
    )


@given(st.integers(0, 10_000))
@settings(max_examples=20)
def test_an_ulp_of_the_input_is_rounding_and_1e7th_is_not(seed):
    scene = shot(seed)
    near, far = (
        faster(scene, lambda v: math.nextafter(v, 9.0)),
        faster(scene, lambda v: v * 1.0000001),
    )
    base = gate.played(scene)
    close = gate.played(near, like=scene)
    assume(close.record.bits != base.record.bits)
    change = gate.compared(base, close, near)
    assert change.change == "rounding", change.summary
    assert gate.compared(base, gate.played(far, like=scene), far).change == "changed"


def test_the_allowance_is_of_the_run_as_it_is():
    scene = gate.cut_shot()
    run = simulate(scene, record="events")
    found = allowance_of(scene)
    assert found.event_times.shape == run.events.shape
    assert found.rest.shape == (2,)
    assert math.isinf(found.horizon)
    assert math.isinf(found.map_end)
    # Some dozens of roundings of a metre or a second: more than 0, less than a nanometre.
    assert np.all(found.event_times > 0.0)
    assert np.all((found.rest > 0.0) & (found.rest < 1e-11))


def test_a_tangent_map_that_is_wrong_explains_nothing(monkeypatch):
    # Fails if a bug in our engine's tangent map makes this bug, or another one, count as rounding.
    scene = find_scene("break-7")
    times = simulate(scene, record="events").events["t"]
    right = allowance_of(scene)
    assert (right.source, right.map_end) == ("certificate", math.inf)
    growth, shifts = EngineTangentMap.growth, EngineTangentMap.event_shifts.fget
    monkeypatch.setattr(EngineTangentMap, "growth", lambda self, t: 1000.0 * growth(self, t))
    monkeypatch.setattr(
        EngineTangentMap, "event_shifts", property(lambda self: 1000.0 * shifts(self))
    )
    wrong = allowance_of(scene)
    assert wrong.horizon == right.horizon
    assert wrong.map_end <= times[0]
    assert np.all(wrong.event_times <= right.event_times + UNAMPLIFIED * (1.0 + times))
    if right.rest is not None:
        assert np.array_equal(wrong.rest, right.rest)


def test_a_wrong_tangent_map_does_not_make_a_changed_result_rounding(monkeypatch):
    scene = gate.cut_shot()
    base, far = gate.played(scene), faster(scene, lambda v: v * (1.0 + 1e-12))
    head = gate.played(far, like=scene)
    assert gate.compared(base, head, far).change == "changed"
    growth = EngineTangentMap.growth
    monkeypatch.setattr(EngineTangentMap, "growth", lambda self, t: 1000.0 * growth(self, t))
    change = gate.compared(base, head, far)
    assert change.change == "changed", change.summary
    assert "from the certified result" in change.summary


def test_a_shot_that_is_not_proved_is_explained_by_our_engine_alone():
    assert allowance_of(find_scene("push-line")).source == "engine"


def test_a_chaotic_shot_has_a_horizon_and_no_end():
    found = allowance_of(find_scene("chaos-a"))
    assert math.isfinite(found.horizon)
    assert found.rest is None
    early = simulate(find_scene("chaos-a"), record="events").events["t"] < found.horizon
    assert np.all(np.isfinite(found.event_times[early]))


@pytest.mark.parametrize("name", ["break-7", "frozen-break", "cradle", "wedged", "roll-distance"])
def test_no_allowance_is_nothing_or_not_a_number(name):
    # With NaN, `<=` would explain nothing, and `>` everything.
    found = allowance_of(find_scene(name))
    assert not np.isnan(found.event_times).any()
    assert np.all(found.event_times >= 0.0)
    if found.rest is not None:
        assert np.all(np.isfinite(found.rest))


def test_in_air_the_proof_says_how_far_the_end_may_move():
    base = gate.cut_shot()
    physics = base.physics.model_copy(update={"air_drag": 0.1})
    found = allowance_of(base.model_copy(update={"physics": physics}))
    assert found.source == "certificate"
    assert found.horizon == math.inf
    assert found.map_end == math.inf
    assert np.all((found.rest > 0.0) & (found.rest < 1e-11))
    assert np.all(found.event_times < 1e-12)


def test_a_time_stepping_engine_may_round_in_every_step():
    scene = gate.cut_shot()
    run = gate.having(gate.played(scene), rest_time=1.0)
    events = run.log().events
    exact = allowance_of_other(scene, events)
    assert np.array_equal(allowance(run).rest, exact.rest)
    for steps, times in ((10, 1.0), (3200, 100.0)):
        found = allowance_of_other(scene, events, steps)
        again = allowance(gate.having(run, label=f"pymunk:dt={1.0 / steps!r}"))
        assert again.rest == pytest.approx(found.rest)
        assert found.event_times == pytest.approx(times * exact.event_times)
        assert found.rest == pytest.approx(times * exact.rest)


@plays(Feature.ROLLING, Feature.UNBOUNDED_CLOTH)
def steps(scene, dt=1e-3, noise=0.0, factor=1.0):
    """Simulate a rolling ball in time steps; each rounds its position, as on another processor."""
    chance, x, v, t = np.random.default_rng(1), scene.positions[:, :2], scene.velocities[:, :2], 0.0
    start = [(0.0, x, v)]
    slows = factor * scene.physics.gravity * scene.physics.rolling_friction
    while v.any():
        v = v * max(1.0 - dt * slows / np.linalg.norm(v), 0.0)
        x, t = (x + dt * v) * (1.0 + noise * chance.uniform(-1.0, 1.0, x.shape)), t + dt
    return {"rest_positions": x, "events": [], "samples": [*start, (t, x, v)]}


@pytest.mark.parametrize(
    ("noise", "factor", "change"),
    [(2.0**-52, 1.0, "rounding"), (1e-10, 1.0, "changed"), (0.0, 0.99, "worse")],
)
def test_an_ulp_in_every_step_is_rounding_and_another_friction_is_worse(noise, factor, change):
    scene = gate.roll_shot()
    truth = simulate(scene).rest_positions

    def ran(**settings):
        run = engine_of(steps, "test_rounding:steps")
        engine = run(run.Settings(**settings))
        result = engine.simulate(scene, record="events")
        error = float(np.max(np.linalg.norm(result.rest_positions - truth, axis=1)))
        record = gate.record_of(result, scene, accuracy=Accuracy("millimetres", error=error))
        return ComparedRun(record, lambda: EventLog.of(events_of(result)))

    base, head = ran(), ran(noise=noise, factor=factor)
    assert base.record.accuracy.error > 1e-4
    assert head.record.bits != base.record.bits
    steps_made = head.record.rest_time / 1e-3
    explained = allowance_of_other(scene, head.log().events, steps_made)
    found = compare(base, head, lambda: explained)
    assert found.change == change, found.summary
