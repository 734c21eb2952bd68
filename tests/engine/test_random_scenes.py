"""Tests that random scenes with all features have the same results on every path to the engine.

The paths are: alone, in a batch, in a sweep on any number of threads, as one of many starts, with
either scheduler, with each skip switched off, renumbered, and mirrored. The scene, the result and
the certified result are read back as they were stored. The motion agrees with its events and its
end, and gains no energy. Each check is also shown to detect an error.
"""

from __future__ import annotations

import math
import os
from dataclasses import replace

import gate
import numpy as np
import pytest
from kernels import interpreted
from same import CHECKS, OFTEN, SELDOM, differences, images, motion, plays, stored

from ghostball.engine import simulate
from ghostball.engine.running.skips import Skip
from ghostball.model import Ball, EventKind, ExactTrajectory, Physics, Result, Scene, Status, Table
from ghostball.validation.baselines.baseline import Accepted, Baseline, load_baseline
from ghostball.validation.baselines.compared_run import ComparedRun, EventLog
from ghostball.validation.scenes.random_scenes import ASPECTS, random_scene

FOUND = {
    "a first nose lifts a ball off the second of a corner": (575, {"flight": "low"}),
    "a cloth without friction turns no ball in resting contact": (224, {}),
    "two noses at one instant": (330, {}),
    "a ball pushed into a rack is deeper at each bounce": (2736, {}),
    "a slide with its slip ends within the clock's rounding": (
        386,
        {"quadratic": "yes", "layout": "corner"},
    ),
    "a step of nanoseconds along a rail": (459, {"air": "yes", "layout": "rail"}),
    "friction of contacts where no cloth rubs": (168, {"air": "yes", "layout": "corner"}),
    "pairs that touch at once ask for contacts": (10395, {}),
    "a ball that stops in a corner, on a cloth without friction": (15476, {}),
    "a ball that an impact stops dead, on a cloth without friction": (10498, {}),
    "a contact that pulls, on a cloth without friction": (13714, {}),
    "a force of no more than rounding, on a cloth without friction": (12600, {}),
    "a ball of 1e-162 m/s in a corner": (205, {"air": "yes", "layout": "corner"}),
    "an impact at an instant rounded to a clock of minutes": (16756, {}),
    "a slip that ends where an impulse leaves little of it": (11935, {}),
    "a step that looks past the end of the rail that holds a ball": (
        1350,
        {"spin": "struck", "table": ("polygon", "pockets", "posts")},
    ),
    "pieces of a motion whose acceleration changes unevenly": (3390, {"table": "polygon"}),
    "a ball between two, kept together by a hundred impacts": (3179, {"table": "polygon"}),
    "three balls, kept together by a thousand impacts": (4446, {"table": "posts"}),
    "a row without bounce, pushed into a cushion": (2416, {"table": "polygon"}),
    "a row without bounce in air, on a cloth without friction": (3679, {"table": "pockets"}),
    "the same, of balls that may fly": (
        0,
        {
            "table": "pockets",
            "flight": ("low", "jump", "drop", "on-top"),
            "air": "yes",
            "quadratic": ("no", "yes"),
            "speed": ("usual", "fast"),
        },
    ),
    "a ball at a cushion, pushed by one that another lies on": (
        195,
        {"air": "yes", "flight": ("low", "jump", "drop", "on-top")},
    ),
    "a rail and the jaw at its end push as one": (757, {"table": "pockets"}),
    "the same at another rail": (2959, {"table": "pockets"}),
    "balls that push each other 160 m away from an open table": (7797, {}),
    "a ball pushed back to a rail as soon as it has left": (298, {"impacts": "compliant"}),
}
"""Mistakes found in random scenes, with the number and the options of the scene."""


@pytest.mark.compiled
@pytest.mark.slow  # the kernels with all parts take minutes to compile
@pytest.mark.parametrize(("number", "having"), FOUND.values(), ids=FOUND.keys())
def test_what_random_scenes_found_is_gone(number, having):
    assert differences(random_scene(number, **having), OFTEN) == {}


ALOFT = tuple(how for how in ASPECTS["flight"] if how != "no")

LONG_SWEEP = 600
"""Number of shots in a sweep that threads share: more than a thread takes at a time."""

SHAPES = ("polygon", "pockets", "posts")

KINDS = {
    "all": (400, {}),
    "falling": (20, {"cushion": "falling"}),
    "shape": (20, {"table": SHAPES}),
    "struck": (20, {"spin": "struck"}),
    "lasting": (40, {"impacts": "compliant"}),
    "flight-in-air": (20, {"air": "yes", "flight": ALOFT}),
    "flight-over-shapes": (20, {"table": SHAPES, "flight": ALOFT}),
}
"""Number of random scenes of each kind, and their options."""

MORE = int(os.environ.get("GHOSTBALL_RANDOM_SCENES", "1"))
"""Factor on the number of scenes, larger than 1 to search for mistakes."""

AT_ONCE = 20
"""Number of scenes in a test."""


@pytest.mark.compiled
@pytest.mark.slow  # as above
@pytest.mark.parametrize(
    ("kind", "first"),
    [(kind, k) for kind, (count, _) in KINDS.items() for k in range(0, MORE * count, AT_ONCE)],
)
def test_random_scenes_come_out_the_same_by_every_path(kind, first):
    _, having = KINDS[kind]
    numbers = range(first, first + AT_ONCE)
    found = {number: differences(random_scene(number, **having), OFTEN) for number in numbers}
    assert {number: differ for number, differ in found.items() if differ} == {}


@pytest.mark.compiled
@pytest.mark.slow
@pytest.mark.parametrize("number", range(4 * MORE))
def test_results_and_certificates_read_back_as_stored(number):
    assert differences(random_scene(number), SELDOM) == {}


@pytest.mark.compiled
@pytest.mark.slow
@pytest.mark.parametrize("number", range(MORE))
@pytest.mark.parametrize("flight", ASPECTS["flight"])
def test_a_sweep_shared_by_threads_agrees_with_single_shots(flight, number):
    scene = random_scene(number, flight=flight, count="few", speed="usual")
    assert plays.sweep(scene, LONG_SWEEP) is None


SLOW_UNCOMPILED = {3, 7, 13, 19}
"""Scenes that take more than 4 s of processor time without a compiler."""


@interpreted
@pytest.mark.parametrize("number", [k for k in range(27) if k not in SLOW_UNCOMPILED])
def test_some_random_scenes_agree_without_compilation(number):
    assert differences(random_scene(number, count="few"), OFTEN) == {}


SHOT = Scene(
    name="shot",
    table=Table(length=1.0, width=0.6),
    physics=Physics(preset="pool"),
    balls=[
        Ball(id="cue", position=(0.3, 0.3), velocity=(1.0, 0.1), angular_velocity=(9.0, 9.0, 9.0)),
        Ball(id="object", position=(0.6, 0.31)),
    ],
)
OTHER = Scene(**{**dict(SHOT), "physics": Physics(preset="pool", rolling_friction=0.0101)})


def altered(monkeypatch, module, name, when=lambda *_, **__: True):
    """Replace a function by one with a wrong result, if `when` returns True for its arguments."""
    function = getattr(module, name)

    def wrong(scene, *others, **options):
        if not when(scene, *others, **options):
            return function(scene, *others, **options)
        if isinstance(scene, list):
            return function([OTHER] * len(scene), *others, **options)
        return function(replaced(scene), *others, **options)

    monkeypatch.setattr(module, name, wrong)


def replaced(scene: Scene) -> Scene:
    return Scene(**{**dict(scene), "physics": OTHER.physics})


@pytest.mark.slow  # as above
def test_equal_results_have_no_differences():
    assert differences(SHOT) == {}


def in_full(*_, no_skip=(), **__):
    return Skip.AIR_AND_FLIGHT in no_skip


@pytest.mark.parametrize(
    ("check", "module", "name", "when"),
    [
        ("records", plays, "simulate", lambda *_, record="rest", **__: record == "events"),
        ("many", plays, "simulate_many", lambda *_, threads, **__: threads == 5),
        ("sweep", plays, "simulate_sweep", lambda *_, threads, **__: threads == 5),
        ("cells", plays, "simulate", in_full),
        ("skips", plays, "simulate", in_full),
        ("renumbered", images, "play", lambda *_, **__: True),
        ("mirrored", images, "play", lambda *_, **__: True),
    ],
)
def test_a_path_with_another_result_is_detected(monkeypatch, check, module, name, when):
    plays.played(SHOT)
    altered(monkeypatch, module, name, when)
    assert CHECKS[check](SHOT) is not None


def test_a_motion_that_contradicts_itself_is_detected(monkeypatch):
    result = plays.played(SHOT)
    trajectory = result.trajectory
    assert isinstance(trajectory, ExactTrajectory)

    def seen(**changes):
        monkeypatch.setattr(motion, "played", lambda _: replace(result, **changes))
        return {name for name in ("ends", "sampled", "invariants") if CHECKS[name](SHOT)}

    assert seen() == set()
    assert seen(status=Status.WORK_LIMIT) == {"ends", "invariants"}
    assert seen(rest_time=result.rest_time + 1e-9, status=Status.T_MAX) >= {"ends"}
    met = result.events["t"][result.events["kind"] == EventKind.BALL_BALL]
    assert not motion._left_by_impacts(result, 0, 1, met, 1e-15).any()  # they were apart before
    late = result.events.copy()
    late["t"][np.argmax(late["kind"] == EventKind.BALL_BALL)] += 1e-9
    assert seen(events=late) >= {"sampled"}
    segments = tuple(one.copy() for one in trajectory.segments)
    segments[1][-1, 1] += 1e-9
    assert seen(trajectory=replace(trajectory, segments=segments)) >= {"sampled"}
    segments[1][-1, 1] = math.nan
    assert seen(trajectory=replace(trajectory, segments=segments)) >= {"sampled"}
    moved = result.final_state._replace(velocities=result.final_state.velocities + 1e-9)
    assert seen(final_state=moved) >= {"ends", "sampled"}
    heavy = replace(trajectory, radii=1.01 * trajectory.radii)
    assert seen(trajectory=heavy, work={**result.work, "unsolved_contact_steps": 1}) >= {
        "invariants"
    }


def test_what_reads_back_otherwise_is_seen(monkeypatch):
    monkeypatch.setattr(stored.toml, "dumps", lambda scene, dumps=stored.toml.dumps: dumps(OTHER))
    assert "TOML" in stored.scene_file(SHOT)
    found = stored.Results.motion
    monkeypatch.setattr(
        stored.Results, "motion", lambda self, case: replace(found(self, case), phases=None)
    )
    assert "phases of the motion" in stored.results(SHOT)
    read = stored.Certificate.from_json
    monkeypatch.setattr(
        stored.Certificate, "from_json", lambda text: replace(read(text), rested=None)
    )
    assert "rested of the proof" in stored.proof(SHOT)


def test_a_baseline_of_a_random_scene_reads_back_the_same(tmp_path):
    accepted = Accepted(date="2026-01-01", revision="0", platform="any", reason="test")
    for number in range(20):
        scene = random_scene(number, count="few", air="no", flight="no")
        result = plays.play(scene, "events")
        record, log = gate.record_of(result, result.scene), EventLog.of(result.events)
        path = tmp_path / f"{record.scene}.json"
        path.write_text(
            Baseline.of(ComparedRun(record, lambda log=log: log), accepted).text, "utf-8"
        )
        read = load_baseline(path)
        for name in ("definition", "status", "rest_time", "bits", "work"):
            assert getattr(read.record, name) == getattr(record, name), (number, name)
        assert read.record.rest_positions.tobytes() == record.rest_positions.tobytes()
        assert read.events.log.sequence == log.sequence


def test_a_result_of_balls_that_continue_spinning_is_at_rest():
    scene = Scene(
        name="spins",
        physics=Physics(motion="sliding", spinning_friction_rate=0.0),
        balls=[Ball(id="b", position=(0.0, 0.0), angular_velocity=(0.0, 0.0, 9.0))],
    )
    result: Result = simulate(scene)
    assert result.status is Status.REST
    assert motion.ends(scene) is None
