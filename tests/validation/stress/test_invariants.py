"""What any run must keep is found in its motion, wherever it is broken."""

from __future__ import annotations

import numpy as np
import pytest
from shots import POOL_TABLE, R, ball, scene_of

from ghostball.engine import simulate
from ghostball.model import CUSHIONS, Result, SampledTrajectory, Samples, Status
from ghostball.validation.stress.invariants import energy_rise, instants, overlaps


def test_the_deepest_overlap_of_balls_and_the_deepest_at_a_cushion_are_found():
    scene = scene_of(ball((0.5, 0.5)), ball((0.7, 0.5)), ball((0.9, 0.5)), table=POOL_TABLE)
    apart = scene.positions
    touching = apart.copy()
    touching[1, 0] = 0.9 - 2 * R + 1e-3
    beyond = apart.copy()
    beyond[2, 1] = R - 2e-3
    found = overlaps(scene, np.array([apart, touching, beyond]))
    assert found[0, 0] == pytest.approx(2 * R - 0.2)
    assert found[0, 1] == pytest.approx(R - 0.5)
    assert found[1, 0] == pytest.approx(1e-3)
    assert found[2, 1] == pytest.approx(2e-3)


@pytest.mark.parametrize(
    ("place", "side"),
    [((0.0, 0.5), 0), ((2.54, 0.5), 1), ((0.5, 0.0), 2), ((0.5, 1.27), 3)],
)
def test_a_ball_halfway_through_any_cushion_is_found(place, side):
    scene = scene_of(ball((1.0, 0.6)), table=POOL_TABLE)
    out = np.array([[[*place, R]]])
    assert overlaps(scene, out)[0, 1] == pytest.approx(R)
    others = tuple(name for name in CUSHIONS if name != CUSHIONS[side])
    opened = scene.model_copy(update={"table": POOL_TABLE.model_copy(update={"cushions": others})})
    assert overlaps(opened, out)[0, 1] < 0.0


def test_energy_that_rises_is_found():
    assert energy_rise(np.array([2.0, 1.0, 1.5, 0.0])) == 0.25
    assert energy_rise(np.array([2.0, 1.0, 1.0])) == 0.0
    assert energy_rise(np.array([0.0, 1e-300])) == np.inf
    assert energy_rise(np.array([0.0, 0.0])) == 0.0
    # Small rises count as what they add up to, whatever has been lost before.
    assert energy_rise(np.array([1.0, 0.5, 0.6, 0.7])) == pytest.approx(0.2)
    assert energy_rise(np.linspace(1.0, 1.0 + 1e-9, 10_001)) == pytest.approx(1e-9)
    assert np.isnan(energy_rise(np.array([1.0, np.nan, 0.5])))


def test_an_engine_with_frames_is_looked_at_at_these_alone():
    scene = scene_of(ball((0.0, 0.0), (1.0, 0.0)))
    states = Samples(*(np.repeat(one, 3, axis=0) for one in _start(scene)))
    frames = SampledTrajectory(np.array([0.0, 0.1, 0.1]), *states)
    result = Result(
        "toy", {}, scene, Status.T_MAX, Samples(*_start(scene)), 0.1, {}, {}, 0.0,
        events=np.empty(0), trajectory=frames,
    )  # fmt: skip
    assert instants(result).tolist() == [0.0, 0.1]


def _start(scene):
    return (
        scene.positions[np.newaxis],
        scene.velocities[np.newaxis],
        scene.angular_velocities[np.newaxis],
    )


def test_an_exact_run_is_looked_at_just_before_every_change():
    run = simulate(scene_of(ball((0.0, 0.0), (1.0, 0.0)), ball((0.5, 0.0))), record="trajectory")
    times = instants(run)
    t = run.events["t"][0]
    assert np.all(np.diff(times) > 0.0)
    assert np.count_nonzero((times > 0.0) & (times < np.nextafter(t, 0.0))) == 3
    assert {0.0, t, np.nextafter(t, 0.0), run.rest_time} <= set(times.tolist())
