"""Differences before the end are named, even if the end is right."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from ghostball.model import EventKind, Result, SampledTrajectory, Scene
from ghostball.validation.diagnose.motion_differences import differs_before_end
from ghostball.validation.runs.engine_runs import run_ours
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.truth.known_shot import KnownShot, known_shot

CUT, DRAW, POCKET = map(find_scene, ("half-ball-cut", "draw-shot", "pocket-draw"))


def known_and_ours(scene: Scene) -> tuple[KnownShot, Result]:
    return known_shot(scene), run_ours(scene)


@pytest.mark.parametrize("scene", [CUT, DRAW, POCKET])
def test_a_right_run_differs_in_nothing(scene: Scene):
    known, ours = known_and_ours(scene)
    assert differs_before_end(ours, known) == ""


def test_frames_beside_their_place_are_named_beyond_what_a_step_allows():
    known, ours = known_and_ours(CUT)
    times = np.linspace(0.0, ours.rest_time, 300)
    right = ours.sample(times)
    positions = right.positions.copy()
    positions[150, 0, 1] += 0.1
    frames = SampledTrajectory(times, positions, right.velocities, right.angular_velocities)
    aside = replace(ours, trajectory=frames)
    away = "a ball is up to 100 mm from its reference position"
    assert away in differs_before_end(aside, known)
    assert away in differs_before_end(aside, known, step=1e-3)
    assert differs_before_end(aside, known, step=0.1) == ""


def test_an_event_of_any_kind_that_is_late_is_named():
    known, ours = known_and_ours(DRAW)
    assert ours.events is not None
    described = {
        EventKind.SLIDE_TO_ROLL: '"cue": slide-to-roll',
        EventKind.ROLL_TO_REST: '"cue": roll-to-rest',
        EventKind.BALL_BALL: '"cue" hits "object"',
    }
    for kind, what in described.items():
        events = ours.events.copy()
        k = int(np.flatnonzero(events["kind"] == kind)[0])
        events["t"][k] -= 0.02
        said = differs_before_end(replace(ours, events=np.sort(events, order="t")), known)
        assert said == f"in its events, {what} 0.02 s too early"


def test_another_pocket_is_named():
    known, ours = known_and_ours(POCKET)
    assert ours.events is not None
    events = ours.events.copy()
    fell = events["kind"] == EventKind.POCKETED
    events["b"][fell] = (events["b"][fell] + 1) % 6
    said = differs_before_end(replace(ours, events=events), known)
    assert said.startswith('in its events, "object" falls into the pocket "')
    assert said.endswith('" never; in the reference, once')


def test_both_balls_of_a_collision_too_many_are_named():
    known, ours = known_and_ours(DRAW)
    assert ours.events is not None
    again = ours.events[ours.events["kind"] == EventKind.BALL_BALL]
    twice = np.sort(np.concatenate([ours.events, again]), order="t")
    said = differs_before_end(replace(ours, events=twice), known)
    assert said == 'in its events, "cue" hits "object" twice; in the reference, once'
