"""What holds for every shot: conservation, symmetry, scaling, order of time, no overlap."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st
from invariants import (
    EPS,
    ball_impacts,
    energies,
    instants,
    overlaps,
)
from shot_strategies import all_shots, shots, sliding_shots

from ghostball.engine import EventKind, Status, simulate


@given(all_shots())
def test_energy_never_rises(scene):
    # A push-apart, a floor on the separation speed or a wrong impulse would raise it.
    result = simulate(scene, record="trajectory")
    energy = energies(result, instants(result))
    assert np.all(np.diff(energy) <= 16 * EPS * energy[0])


FREE = {"rolling_friction": 0.0, "t_max": 3.0}


@given(
    st.one_of(
        shots(laws=st.just(FREE)),
        sliding_shots(
            laws=st.just(
                {
                    **FREE,
                    "motion": "sliding",
                    "sliding_friction": 0.0,
                    "spinning_friction_rate": 0.0,
                }
            )
        ),
    )
)
def test_energy_stays_without_friction_or_losses(scene):
    result = simulate(scene, record="trajectory")
    energy = energies(result, instants(result))
    # Each collision may round it by a few ulp.
    assert np.all(np.abs(energy - energy[0]) <= (8 + 8 * len(result.events)) * EPS * energy[0])


@given(all_shots(ball_laws=("frictional",)))  # in the other the cloth takes part
def test_momentum_survives_every_ball_impact(scene):
    result = simulate(scene, record="trajectory")
    masses = scene.masses
    for t, a, b in ball_impacts(result):
        if t == 0.0:
            continue
        before, after = result.sample([np.nextafter(t, 0.0), t]).velocities
        scale = masses[a] * np.abs(before[a]).max() + masses[b] * np.abs(before[b]).max()
        scale += (masses[a] + masses[b]) * 4.0 * t  # the clock's last unit, at 4 m/s^2
        for i in range(len(masses)):
            if i not in (a, b):
                assert np.allclose(before[i], after[i], rtol=0, atol=8 * EPS * 10)
        momenta = [masses[a] * v[a] + masses[b] * v[b] for v in (before, after)]
        assert np.allclose(*momenta, rtol=0, atol=16 * EPS * scale)


@given(all_shots(ball_laws=("frictional",)))  # in the other, e is one of energies
def test_an_impact_reverses_the_approach_with_its_restitution(scene):
    result = simulate(scene, record="trajectory")
    e = scene.physics.ball_restitution
    for t, a, b in ball_impacts(result):
        if t == 0.0:
            continue
        samples = result.sample([np.nextafter(t, 0.0), t])
        r = samples.positions[1, b] - samples.positions[1, a]
        r[2] = 0.0
        normal = r / np.linalg.norm(r)
        before, after = ((v[b] - v[a]) @ normal for v in samples.velocities)
        speeds = np.abs(samples.velocities[:, [a, b]]).max()
        assert before < 16 * EPS * speeds
        assert after == pytest.approx(-e * before, abs=64 * EPS * (speeds + 4.0 * t))


@given(all_shots())
def test_nothing_overlaps_at_events_or_between(scene):
    # A missed collision shows as an overlap of the order of a radius.
    result = simulate(scene, record="trajectory")
    depth = overlaps(scene, result.sample(instants(result, 20)).positions).max()
    # A contact force holds gaps to 4e-13 m for pool balls, other contacts are exact.
    assert depth <= (1e-12 if result.work["contact_steps"] else 1e-13)


@given(all_shots())
def test_balls_touch_when_they_collide(scene):
    # A phantom collision, at any distance, would show here.
    result = simulate(scene, record="trajectory")
    for t, a, b in ball_impacts(result):
        centres = result.sample(t).positions[0, :, :2]
        gap = np.linalg.norm(centres[a] - centres[b]) - scene.radii[a] - scene.radii[b]
        assert abs(gap) <= (1e-12 if result.work["contact_steps"] else 1e-14)


@given(all_shots())
def test_the_run_ends_at_rest_with_events_in_order_of_time(scene):
    result = simulate(scene, record="events")
    assert result.status is Status.REST
    assert not np.any(result.final_state.velocities)
    assert not np.any(result.final_state.angular_velocities)
    times = result.events["t"]
    assert np.all(np.diff(times) >= 0.0)
    last = times[-1] if len(times) else 0.0
    spinning = np.any(result.sample(last).angular_velocities[0, :, 2])
    assert result.rest_time > last if spinning else result.rest_time == last
    pairs = result.events[result.events["kind"] == EventKind.BALL_BALL]
    assert np.all(pairs["a"] < pairs["b"])


@given(all_shots())
def test_the_recorded_motion_ends_where_the_run_ended(scene):
    result = simulate(scene, record="trajectory")
    end = result.sample([result.rest_time, result.rest_time + 1.0])
    for sampled, final in zip(end, result.final_state, strict=True):
        assert np.allclose(sampled, final, rtol=0, atol=16 * EPS * (1 + np.abs(final)))
    start = result.sample(0.0).positions[0]
    assert np.array_equal(start, scene.positions)
