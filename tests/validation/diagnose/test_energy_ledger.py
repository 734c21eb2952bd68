"""Energy is booked to the right entry, and the entries add up to the loss."""

from dataclasses import replace

import numpy as np
import pytest

from ghostball.engine import simulate
from ghostball.model import Ball, Scene
from ghostball.validation.diagnose.energy_ledger import FRAMES, NOT_FINITE, UNSTORED, ledger_of
from ghostball.validation.runs.sampling import motion_of
from ghostball.validation.scenes.library import find_scene


def motion(scene):
    return motion_of(simulate(scene, record="trajectory"))


ADD_UP = ["break-16", "draw-shot", "pool-break-9", "masse", "elastic-gas", "push-line"]
TOO_LONG = "galperin-3"
"""A scene with too many events to keep all of its states."""


@pytest.mark.parametrize("name", [*ADD_UP, TOO_LONG])
def test_the_entries_add_up_to_what_was_lost(name):
    scene = find_scene(name)
    ledger = ledger_of(scene, motion(scene))
    assert sum(ledger.entries.values()) == pytest.approx(ledger.lost, abs=1e-13 * ledger.initial)
    assert (UNSTORED in ledger.entries) == (name == TOO_LONG)


def test_an_inelastic_collision_costs_what_the_formula_says():
    # A head-on impact at v of equal masses costs (1 - e^2) m v^2 / 4; v includes the slowing by
    # rolling.
    scene = find_scene("restitution-head-on")
    stored = motion(scene)
    collision = stored.events[0]["t"]
    before = int(np.searchsorted(stored.times, collision)) - 1
    speed = np.linalg.norm(stored.velocities[before, 0])
    e, m = scene.physics.ball_restitution, scene.masses[0]
    ledger = ledger_of(scene, stored)
    # Balls that continue to roll at once also lose energy of their spin.
    assert ledger.entries["ball-ball"] >= (1.0 - e**2) * m * speed**2 / 4.0 * (1.0 - 1e-12)
    assert set(ledger.entries) == {"ball-ball", "rolling"}
    assert ledger.counts == {"ball-ball": 1, "ball-cushion": 0}


def test_friction_on_the_way_is_not_taken_for_the_cushion():
    scene = find_scene("restitution-bounce")
    stored = motion(scene)
    collision = stored.events["t"][stored.events["kind"] == 1][0]
    at = int(np.searchsorted(stored.times, collision))
    ledger = ledger_of(scene, stored)
    assert ledger.entries["ball-cushion"] == pytest.approx(
        stored.energy[at - 1] - stored.energy[at]
    )
    assert ledger.entries["rolling"] == pytest.approx(ledger.lost - ledger.entries["ball-cushion"])
    assert ledger.final == 0.0


def test_an_elastic_collision_costs_nothing_though_each_ball_changes():
    scene = find_scene("half-ball-cut")
    ledger = ledger_of(scene, motion(scene))
    assert abs(ledger.entries["ball-ball"]) < 1e-15 * ledger.initial * 10


def test_what_is_lost_at_the_start_counts():
    # The balls touch and approach at t = 0: the first stored state is the one after the impact.
    r = 0.028575
    scene = Scene(
        name="struck-at-once",
        title="Touching balls, one driven into the other",
        physics={"preset": "paper", "ball_restitution": 0.5},
        balls=[
            Ball(id="a", position=(0.0, 0.0), velocity=(1.0, 0.0)),
            Ball(id="b", position=(2.0 * r, 0.0)),
        ],
    )
    stored = motion(scene)
    assert stored.events[0]["t"] == 0.0
    ledger = ledger_of(scene, stored)
    assert ledger.entries["ball-ball"] > 0.1 * ledger.initial
    assert sum(ledger.entries.values()) == pytest.approx(ledger.lost)


def test_frames_tell_nothing_but_the_total():
    scene = find_scene("restitution-bounce")
    ledger = ledger_of(scene, replace(motion(scene), phases=None))
    assert ledger.entries is None
    assert ledger.why == FRAMES
    assert ledger.lost == pytest.approx(ledger.initial)


def test_a_motion_that_blew_up_is_not_added_up():
    scene = find_scene("stop")
    stored = motion(scene)
    wrong = stored.velocities.copy()
    wrong[-1] = np.inf
    ledger = ledger_of(scene, replace(stored, velocities=wrong))
    assert ledger.entries is None
    assert ledger.why == NOT_FINITE
