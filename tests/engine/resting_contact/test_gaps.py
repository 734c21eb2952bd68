"""A gap that is held stays closed: what a spinning ball pushes into a corner overlaps nothing."""

from __future__ import annotations

import math

import pytest

from ghostball.engine import simulate
from ghostball.engine.core.kernel import COMPILED
from ghostball.engine.resting_contact import gaps, step
from ghostball.engine.resting_contact.forces import solve
from ghostball.model import Ball, Physics, Scene, Table
from ghostball.validation.stress.judges import Invariants

R = 2.0**-5


@pytest.mark.parametrize("friction", [0.0, 0.3])
def test_a_ball_that_its_spin_drives_onto_another_in_a_corner_presses_it_symmetrically(friction):
    """Breaks where a contact step takes a gap to change otherwise than it does."""
    place = R + 2.0 * R / math.sqrt(2.0)
    turns = 3.0 * math.sqrt(0.5) / R  # 3 m/s of its surface, towards the corner
    scene = Scene(
        name="cornered",
        physics=Physics(
            motion="sliding",
            rolling_friction=0.01,
            ball_restitution=0.5,
            ball_friction=friction,
            cushion="frictional",
            cushion_restitution=0.85,
        ),
        table=Table(length=2.0, width=2.0),
        t_max=0.125,
        balls=[
            Ball(id="a", radius=R, position=(place, place), angular_velocity=(turns, -turns, 0.0)),
            Ball(id="b", radius=R, position=(R, R)),
        ],
    )
    kept = Invariants(most_events=300, most_steps=12_500, images=(0, 1), swapped=True)
    result = simulate(scene, record="trajectory")
    assert result.work["contact_steps"] > 0
    assert kept(result).faults == ()


def test_a_ball_that_its_spin_drives_onto_a_row_at_a_cushion_takes_few_steps():
    """It takes 12; a step that takes a gap to change otherwise than it does is cut again."""
    physics = Physics(
        motion="sliding",
        rolling_friction=0.01,
        ball_restitution=1.0,
        ball_friction=0.06,
        cushion="frictional",
        cushion_restitution=1.0,
    )
    scene = Scene(
        name="squeezed",
        physics=physics,
        table=Table(length=2.0, width=2.0, cushions=("left",)),
        t_max=0.125,
        balls=[
            Ball(id="a", radius=R, position=(5.0 * R, 0.0), angular_velocity=(0.0, -3.0 / R, 0.0)),
            Ball(id="b", radius=R, position=(R, 0.0)),
            Ball(id="c", radius=R, position=(3.0 * R, 0.0)),
        ],
    )
    kept = Invariants(most_events=300, most_steps=25, images=(0, 1, 2))
    assert kept(simulate(scene, record="trajectory")).faults == ()


@pytest.mark.skipif(COMPILED, reason="what is compiled can't be watched")
@pytest.mark.parametrize("parting", [1e-6, 1e-7], ids="{:g}".format)
def test_a_step_in_which_the_cloth_closes_a_gap_again_is_found_at_once(monkeypatch, parting):
    """Two balls that part by microns a second: a force is needed in whatever step takes longer."""
    tried = []

    def watched(*arguments):
        tried.append(solve(*arguments))
        return tried[-1]

    monkeypatch.setattr(step, "solve", watched)
    monkeypatch.setattr(step, "start_motion", lambda *_: False)
    turns = (0.0, 3.0 / R, 0.0)
    scene = Scene(
        name="parting",
        physics=Physics(motion="sliding", rolling_friction=0.01, ball_friction=0.0),
        table=Table(length=2.0, width=2.0, cushions=()),
        t_max=1e-6,
        balls=[
            Ball(id="a", radius=R, position=(0.5, 1.0), angular_velocity=turns),
            Ball(id="b", radius=R, position=(0.5 + 2.0 * R, 1.0)),
            Ball(
                id="c",
                radius=R,
                position=(0.5 + 4.0 * R, 1.0),
                velocity=(parting, 0.0),
                angular_velocity=(0.0, -3.0 / R, 0.0),
            ),
        ],
    )
    simulate(scene)
    assert tried.index(1.0) == 1
    tried.clear()
    monkeypatch.setattr(gaps, "_shorter", lambda *_: 0.5)
    simulate(scene)
    assert tried.index(1.0) >= 8
