"""Forces of a contact step, with friction: as the closed form says, and where none are found."""

import pytest
from shots import R

from ghostball.engine import simulate
from ghostball.engine.core.kernel import COMPILED
from ghostball.engine.resting_contact import step
from ghostball.engine.resting_contact.forces import solve
from ghostball.model import Ball, Physics, Scene, Status
from ghostball.validation.scenes.random_scenes import random_scene


def spinning_push():
    """A ball whose spin drives it against another, on a cloth that gives that one nothing."""
    return Scene(
        name="spinning-push",
        physics=Physics(
            motion="sliding",
            sliding_friction=0.2,
            rolling_friction=0.0,
            ball_friction=0.06,
            ball_restitution=0.9,
        ),
        balls=[
            Ball(id="free", position=(0.0, 0.0), rolling_friction=0.0, sliding_friction=0.0),
            Ball(id="push", position=(-2 * R, 0.0), angular_velocity=(0.0, 60.0, 0.0)),
        ],
        t_max=0.1,
    )


def check_spinning_push(result, friction=0.06, rel=1e-9):
    """Closed form: half the cloth's force goes through the contact, and Coulomb's part of that."""
    mu, g, t = 0.2, 9.81, 0.1
    end = result.sample([t])
    rubbed = 2.5 / R * friction * 0.5 * mu * g * t
    slowed = 2.5 / R * mu * g * t
    spins = end.angular_velocities[0]
    assert spins[:, 1] == pytest.approx([-rubbed, 60.0 - slowed - rubbed], rel=rel)
    assert end.velocities[0, :, 0] == pytest.approx(0.5 * mu * g * t, rel=rel)


def test_a_spinning_ball_that_pushes_another_rubs_it():
    result = simulate(spinning_push(), record="events")
    assert result.work["contact_steps"] > 0
    check_spinning_push(result)


@pytest.mark.skipif(COMPILED, reason="what is compiled can't be replaced")
def test_a_step_that_no_forces_with_friction_solve_is_taken_without_and_counted(monkeypatch):
    def jams(*arguments):
        *_, rubs = arguments
        return not rubs and solve(*arguments)

    monkeypatch.setattr(step, "solve", jams)
    monkeypatch.setattr(step, "start_motion", lambda *_: False)
    result = simulate(spinning_push(), record="events")
    assert result.work["unsolved_contact_steps"] == result.work["contact_steps"] > 10
    check_spinning_push(result, friction=0.0)


@pytest.mark.skipif(COMPILED, reason="what is compiled can't be replaced")
def test_a_step_that_no_forces_solve_is_as_short_as_can_be_and_counted(monkeypatch):
    tried = []

    def jams_once(*arguments):
        count = arguments[2]
        tried.append(count)
        return 0 in tried and solve(*arguments)

    monkeypatch.setattr(step, "solve", jams_once)
    monkeypatch.setattr(step, "start_motion", lambda *_: False)
    result = simulate(spinning_push(), record="events")
    assert result.work["unsolved_contact_steps"] == 1
    check_spinning_push(result, rel=1e-6)  # it lasts 3 ns, and what it lets approach rubs nothing


@pytest.mark.compiled
def test_gaps_that_no_forces_close_are_given_up_at_once():
    """A ball hops on a frozen rack: a gap opens so fast in each step that is tried.

    All 96 rounds, in each of which no force changed, took sixty times as much work.
    """
    hops = random_scene(
        512,
        flight=("drop", "jump", "on-top"),
        layout=("rack", "rack-at-rail"),
        stop="rest",
        air="no",
    )
    assert simulate(hops, max_work=20_000_000).status is Status.REST
