"""Tests of the forces of a contact step, with friction: closed forms, and steps without forces."""

import pytest
from kernels import if_compiled
from recorded import fingerprint
from shots import R, ball, kept_scene, scene_of

from ghostball.engine import simulate
from ghostball.engine.core.kernel import COMPILED
from ghostball.engine.resting_contact import forces, step
from ghostball.engine.resting_contact.forces import solve
from ghostball.model import Ball, Physics, Scene, Status, Table
from ghostball.validation.scenes.random_scenes import random_scene


def spinning_push():
    """Return a ball that its spin drives against another, under which the cloth has no friction."""
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
    """Closed form: half of the cloth's force acts through the contact, with Coulomb's friction."""
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


@pytest.mark.skipif(COMPILED, reason="compiled kernels can't be replaced")
def test_a_step_without_solution_with_friction_neglects_friction_and_is_counted(monkeypatch):
    def jams(*arguments):
        *_, rubs = arguments
        return not rubs and solve(*arguments)

    monkeypatch.setattr(step, "solve", jams)
    monkeypatch.setattr(step, "start_motion", lambda *_: False)
    result = simulate(spinning_push(), record="events")
    assert result.work["unsolved_contact_steps"] == result.work["contact_steps"] > 10
    check_spinning_push(result, friction=0.0)


@pytest.mark.skipif(COMPILED, reason="compiled kernels can't be replaced")
def test_a_step_without_solution_is_the_shortest_and_is_counted(monkeypatch):
    tried = []

    def jams_once(*arguments):
        count = arguments[2]
        tried.append(count)
        return 0 in tried and solve(*arguments)

    monkeypatch.setattr(step, "solve", jams_once)
    monkeypatch.setattr(step, "start_motion", lambda *_: False)
    result = simulate(spinning_push(), record="events")
    assert result.work["unsolved_contact_steps"] == 1
    check_spinning_push(result, rel=1e-6)  # the step takes 3 ns, without friction of the contacts


HOPS = {
    "flight": ("drop", "jump", "on-top"),
    "layout": ("rack", "rack-at-rail"),
    "stop": "rest",
}


@pytest.mark.compiled
def test_gaps_that_no_forces_close_are_given_up_at_once():
    """A ball hops on a frozen rack: most steps that are tried are too long.

    If all rounds of each step were made, in which no force changes, the work would be 555 million.
    """
    hops = random_scene(512, air="no", **HOPS)
    assert simulate(hops, max_work=20_000_000).status is Status.REST


@pytest.mark.skipif(COMPILED, reason="compiled kernels can't be replaced")
@pytest.mark.parametrize(
    ("number", "having"),
    [
        (291, {"air": "no"}),
        (512, {"air": "no"}),
        *((number, {"air": "yes", "count": "few"}) for number in (205, 210, 296)),
    ],
    ids=lambda given: str(given) if isinstance(given, int) else given["air"],
)
def test_steps_given_up_early_have_no_solution_in_more_rounds(monkeypatch, number, having):
    hops = random_scene(number, **HOPS, **having)
    is_still, still = forces._is_still, []

    def note(*arguments):
        still.append(is_still(*arguments))
        return still[-1]

    monkeypatch.setattr(forces, "_is_still", note)
    found = simulate(hops, record="events", max_events=20)
    assert any(still)
    monkeypatch.setattr(forces, "_is_still", lambda *_: False)
    assert fingerprint(simulate(hops, record="events", max_events=20)) == fingerprint(found)


def test_a_chain_that_no_forces_hold_while_it_slips_stops_slipping():
    """Balls between two heavy balls and a cushion: friction would increase any normal force.

    A round of normal forces multiplies them by 1.1. When the rounds were extrapolated, forces were
    found only in steps of 4e-9 s.
    """
    result = simulate(kept_scene("slipping-chain"), record="events", max_work=10**7)
    assert result.status is Status.T_MAX
    assert result.work["contact_steps"] < 20
    assert result.work["unsolved_contact_steps"] == 0
    energy = result.energy([0.0, 1e-4, 2e-4]).total
    assert energy[0] > energy[1] > energy[2]


@pytest.mark.parametrize("lacking", [1e-14, *if_compiled(-1e-14, 0.0, 1e-15, 1e-13)])
@pytest.mark.parametrize("spins", [(1.0, 2.0), (3.0, 1.0, 2.0), (-5.0, 2.0, 9.0)])
def test_a_row_that_fills_the_place_between_two_cushions_stays_until_its_slips_end(spins, lacking):
    """The gaps have a constant sum for any forces, so no force ends an overlap."""
    balls = [
        ball((R + 2.0 * R * k, 0.35), angular_velocity=(0.0, spin, 0.0))
        for k, spin in enumerate(spins)
    ]
    table = Table(length=2.0 * R * len(spins) - lacking, width=0.7)
    scene = scene_of(*balls, table=table, preset="pool", ball_friction=0.0, cushion="restitution")
    result = simulate(scene, max_work=10**6)
    assert result.status is Status.REST
    assert result.work["contact_steps"] < 100
    assert result.work["unsolved_contact_steps"] == 0
    places = [fields["position"][0] for fields in balls]
    assert result.rest_positions[:, 0] == pytest.approx(places, rel=0.0, abs=5e-13)
    # The cloth slows the spin of a ball that can't move by 5/2 mu g / R.
    slowest = max(abs(spin) for spin in spins) * R / (2.5 * 0.2 * 9.81)
    assert result.rest_time == pytest.approx(slowest, rel=1e-3)
