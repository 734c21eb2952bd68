"""Rapier against closed forms: collisions to single precision, and what it makes of a break."""

import numpy as np
import pytest
from engine_facts import (
    FREE,
    cut_angles,
    energy_ratios,
    half_ball,
    head_on,
    needs,
    play,
    rack,
    shares,
    throw,
    to_the_wall,
)

from ghostball.model import Ball, Scene, Table, UnsupportedSceneError

pytestmark = needs("rapier")


@pytest.mark.parametrize("spec", ["rapier", "rapier:contact_steps=exact"])
@pytest.mark.parametrize("restitution", [0.0, 0.5, 0.9, 1.0])
def test_a_single_collision_is_right_to_single_precision(spec: str, restitution: float) -> None:
    wanted = [(1.0 - restitution) / 2.0, (1.0 + restitution) / 2.0]
    assert shares(spec, head_on(restitution=restitution)) == pytest.approx(wanted, abs=1e-6)
    x, y = play(spec, to_the_wall(restitution)).final_state.velocities[0, 0, :2]
    assert (x, y) == pytest.approx((-restitution, 1.0), abs=1e-6)


def test_balls_and_cushions_have_restitutions_of_their_own() -> None:
    changes = {"ball_restitution": 0.5, "cushion": "restitution", "cushion_restitution": 0.9}
    ball = Ball(id="cue", position=(1.5, 0.3), velocity=(1.0, 1.0))
    scene = Scene(
        name="wall",
        balls=[ball],
        table=Table(length=2.0, width=2.0),
        physics=FREE.model_copy(update=changes),
        t_max=0.6,
    )
    velocity = play("rapier", scene).final_state.velocities[0, 0, :2]
    assert velocity == pytest.approx((-0.9, 1.0), abs=1e-6)


def test_a_cut_is_late_by_a_part_of_the_step_and_in_exact_steps_is_not() -> None:
    assert 0.6 < np.abs(cut_angles("rapier", 1e-3)).max() < 0.75
    assert np.abs(cut_angles("rapier", 1e-4)).max() < 0.08
    x, y = play("rapier:contact_steps=exact", half_ball()).final_state.velocities[0, 1, :2]
    assert np.degrees(np.arctan2(-y, x)) == pytest.approx(30.0, abs=1e-3)


def test_its_prediction_turns_a_cut_and_its_breaks_gain_energy() -> None:
    # The findings: these fail where a later Rapier has mended them.
    assert np.abs(cut_angles("rapier:config=default", 1e-4)).max() > 4.0
    assert energy_ratios("rapier", rack())[-1] > 1.2


def test_what_is_not_driven_is_refused() -> None:
    with pytest.raises(UnsupportedSceneError, match="without friction at contacts"):
        play("rapier", throw())


def test_events_are_those_of_the_shot() -> None:
    result = play("rapier", to_the_wall(), record="events")
    assert result.collision_counts == {"ball-ball": 0, "ball-cushion": 1}
    assert play("rapier", head_on()).collision_counts["ball-ball"] == 1


def test_a_wrong_prediction_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    from ghostball.reference_adapters.rapier import world

    monkeypatch.setattr(world, "PREDICTION", 0.02)
    assert np.abs(cut_angles("rapier", 1e-4)).max() > 1.0


def test_each_bounce_off_a_cushion_is_an_event() -> None:
    # A ball and a half-space are a pair for good: taken for a lasting contact, it bounces once.
    ball = Ball(id="cue", position=(0.5, 0.3), velocity=(2.0, 0.0))
    table = Table(length=1.0, width=1.0)
    scene = Scene(name="to-and-fro", balls=[ball], table=table, physics=FREE, t_max=2.0)
    assert play("rapier", scene).collision_counts["ball-cushion"] == 4
