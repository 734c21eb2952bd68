"""The pybullet adapter: unsupported scenes, settings, and side effects.

`test_rolling` and `test_sliding` test its results. On a Python without pybullet, the tests that run
it are skipped with the adapter's own reason; the others run.
"""

from __future__ import annotations

from typing import Any

import pytest
from shots import ball, scene_of

from ghostball.model import EventKind, Record, Result, Scene, Table, UnsupportedSceneError
from ghostball.model.features import missing_features
from ghostball.reference_adapters.pybullet.engine import PybulletEngine, PybulletSettings

TABLE = Table(length=2.0, width=1.0)

SLIDING = {"motion": "sliding", "rolling_friction": 0.05, "sliding_friction": 0.2}


def run(scene: Scene, record: Record = "events", **settings: Any) -> Result:
    reason = PybulletEngine.unavailable()
    if reason is not None:
        pytest.skip(reason)
    return PybulletEngine(PybulletSettings(**settings)).simulate(scene, record=record)


UNSUPPORTED: dict[str, tuple[Scene, str]] = {
    "han in flight": (
        scene_of(ball((1, 0.5)), table=TABLE, **SLIDING, airborne=True, cushion="han2005"),
        "no cushions after Han 2005",
    ),
    "ice in flight": (
        scene_of(ball((0, 0)), motion="sliding", sliding_friction=0.0, airborne=True),
        "no sliding without friction",
    ),
    "radii while sliding": (
        scene_of(ball((0, 0)), ball((1, 0), radius=0.05), **SLIDING),
        "no balls of different radii that slide",
    ),
    "ice": (
        scene_of(ball((0, 0)), motion="sliding", sliding_friction=0.0),
        "no sliding without friction",
    ),
    "impulse": (
        scene_of(ball((0, 0), velocity=(1e4, 0), mass=1e6), ball((1, 0), mass=1e6)),
        "no impulses above 1e+10 N s",
    ),
    "ice under one ball": (
        scene_of(ball((0, 0)), ball((1, 0), sliding_friction=0.0), **SLIDING),
        "no sliding without friction",
    ),
}


@pytest.mark.parametrize("name", UNSUPPORTED)
def test_refuses_what_bullet_lacks_and_says_why(name: str) -> None:
    scene, reason = UNSUPPORTED[name]
    with pytest.raises(UnsupportedSceneError, match="engine `pybullet` can't represent") as caught:
        PybulletEngine().simulate(scene)
    assert len(caught.value.features) == 1
    assert reason in caught.value.features[0]


@pytest.mark.parametrize(
    ("settings", "step", "kernels"),
    [
        ({}, 1e-3, ()),
        ({"config": "naive"}, 1.0 / 240.0, ()),
        ({"contact_steps": "exact"}, 0.02, ("contact times",)),
        ({"config": "naive", "dt": 0.01}, 0.01, ()),
    ],
)
def test_steps_and_kernels_by_configuration(
    settings: dict[str, Any], step: float, kernels: tuple[str, ...]
) -> None:
    """The naive step must be pybullet's default."""
    chosen = PybulletSettings(**settings)
    assert (chosen.step, chosen.iterations) == (step, 50)
    assert chosen.kernels == (*kernels, "cloth between steps")


def test_exact_steps_refuse_sliding_and_fixed_ones_play_it() -> None:
    scene = scene_of(ball((0, 0)), **SLIDING)
    exact = PybulletEngine(PybulletSettings(contact_steps="exact"))
    with pytest.raises(UnsupportedSceneError, match="Use `contact_steps` = fixed"):
        exact.simulate(scene)
    assert missing_features(PybulletEngine().capabilities, scene) == ()


def test_exact_steps_refuse_flight_and_fixed_ones_play_it() -> None:
    dropped = ball((0, 0, 0.5), (1, 0))
    scene = scene_of(dropped, **SLIDING, airborne=True, t_max=0.2)
    exact = PybulletEngine(PybulletSettings(contact_steps="exact"))
    with pytest.raises(UnsupportedSceneError, match="Use `contact_steps` = fixed") as caught:
        exact.simulate(scene)
    assert any(why.startswith("no airborne balls") for why in caught.value.features)
    assert missing_features(PybulletEngine().capabilities, scene) == ()
    x, y, z = run(scene).final_state.positions[0, 0]
    # Free fall, plus the error of semi-implicit steps of 1 ms, g t dt / 2.
    assert (x, y) == pytest.approx((0.2, 0.0), abs=1e-12)
    fall = scene.physics.gravity * 0.2 / 2
    assert z == pytest.approx(0.5 - fall * (0.2 + 1e-3), abs=1e-9)


def test_a_ball_that_is_only_dropped_isnt_at_rest_in_the_air() -> None:
    scene = scene_of(ball((0.1, 0, 0.1)), **SLIDING, airborne=True)
    result = run(scene, record="events")
    assert result.rest_time > 0.1
    assert (result.events["kind"] == EventKind.BALL_CLOTH).any()
    assert result.rest_positions[0, 2] == pytest.approx(scene.radii[0], abs=1e-5)
