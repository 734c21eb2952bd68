"""The certified engine as a reference engine: certificates as a `Result`."""

from __future__ import annotations

import numpy as np
import pytest
from shots import POOL_TABLE, ball, scene_of

from ghostball.engine import simulate
from ghostball.model import EventKind, GhostballError, Status, UnsupportedSceneError
from ghostball.model.features import Feature
from ghostball.reference_adapters import ReferenceEngine
from ghostball.reference_adapters.certified import CertifiedEngine, CertifiedSettings
from ghostball.validation.scenes.library import find_scene


def engine(**settings) -> CertifiedEngine:
    return CertifiedEngine(CertifiedSettings(**settings))


POOL = scene_of(
    ball((0.6, 0.6), (2.0, 0.1), angular_velocity=(0.0, 0.0, 20.0)),
    ball((1.2, 0.62)),
    table=POOL_TABLE,
    preset="pool",
)


def test_it_is_a_reference_engine():
    assert isinstance(CertifiedEngine(), ReferenceEngine)
    assert CertifiedEngine.name == "certified"
    assert CertifiedEngine.unavailable() is None
    assert set(CertifiedEngine().capabilities) == set(Feature)


def test_a_proof_is_a_result_at_rest():
    result = engine().simulate(POOL, record="events")
    ours = simulate(POOL, record="events")
    assert (result.engine, result.status, result.reason) == ("certified", Status.REST, "")
    assert result.collision_counts == ours.collision_counts
    assert result.events is not None
    assert ours.events is not None
    assert result.events[["kind", "a", "b"]].tolist() == ours.events[["kind", "a", "b"]].tolist()
    np.testing.assert_allclose(result.events["t"], ours.events["t"], rtol=1e-13)
    np.testing.assert_allclose(result.rest_positions, ours.rest_positions, atol=1e-13)
    np.testing.assert_allclose(result.rest_time, ours.rest_time, rtol=1e-13)
    assert not result.final_state.velocities.any()
    assert not result.final_state.angular_velocities.any()
    assert result.work["events"] == len(result.events)
    assert result.work["precision"] >= 53
    assert result.wall_time > 0.0
    assert result.to_json()


def test_only_what_is_asked_for_is_kept():
    assert engine().simulate(POOL).events is None
    result = engine().simulate(POOL, record="events")
    assert result.events is not None
    with pytest.raises(GhostballError, match="record"):
        result.sample([0.0])


def test_the_motion_can_be_sampled():
    result = engine().simulate(POOL, record="trajectory")
    ours = simulate(POOL, record="trajectory")
    times = np.linspace(0.0, 1.1 * result.rest_time, 301)
    for mine, other in zip(result.sample(times), ours.sample(times), strict=True):
        np.testing.assert_allclose(mine, other, atol=1e-10)
    np.testing.assert_allclose(result.energy(times).total, ours.energy(times).total, atol=1e-12)
    assert (result.phases(times) == ours.phases(times)).mean() > 0.99


def test_t_max_ends_a_result():
    scene = scene_of(ball((0.0, 0.0), (1.0, 0.0)), rolling_friction=0.0, t_max=2.0)
    result = engine().simulate(scene)
    assert (result.status, result.rest_time) == (Status.T_MAX, 2.0)
    assert result.rest_positions[0].tolist() == [2.0, 0.0, scene.balls[0].radius]
    assert result.final_state.velocities[0, 0].tolist() == [1.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("name", "settings", "status", "reason"),
    [
        ("frozen-break", {}, Status.UNPROVED, "ambiguous: can't determine what comes first"),
        ("wedged", {}, Status.UNPROVED, "sustained contact: in resting contact"),
        ("break-7", {"max_precision": 24}, Status.UNPROVED, "precision cap: 24 bits"),
        ("break-7", {"max_events": 2}, Status.EVENT_LIMIT, "event limit: 2 events"),
        ("break-7", {"time_limit": 1e-9}, Status.UNPROVED, "time limit: 1e-09 s"),
    ],
)
def test_a_partial_proof_says_why_and_is_not_complete(name, settings, status, reason):
    result = engine(**settings).simulate(find_scene(name), record="events")
    assert result.status is status
    assert not result.status.complete
    assert result.reason.startswith(reason)
    assert result.events is not None
    assert result.work["events"] == len(result.events)
    assert np.isfinite(result.rest_positions).all()


def test_the_state_of_a_partial_proof_is_that_of_its_last_event():
    whole = engine().simulate(POOL, record="events")
    part = engine(max_events=2).simulate(POOL, record="events")
    assert whole.events is not None
    assert part.rest_time == whole.events["t"][1]


def test_what_it_cannot_prove_is_refused_with_the_reason():
    scene = find_scene("mathavan-cut")
    with pytest.raises(UnsupportedSceneError, match="without a closed form"):
        engine().simulate(scene)


def test_the_certificate_is_at_hand():
    certificate = engine().certify(POOL)
    assert certificate.proved
    assert certificate.events[0].kind in EventKind
