"""Planted bugs: each is caught by grading against the proof, and no bug is seen where none is."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from shots import POOL_TABLE, ball, scene_of

import engine
from engine import Result, Scene, simulate
from reference_adapters.certified import certify
from validation.faults import faults_of
from validation.grading import grade
from validation.library import find_scene
from validation.mutants import Crash, MutantError, Mutation, planted
from validation.stress.mutations import MUTATIONS

NAMED = {one.name: one for one in MUTATIONS}
DROPPED = NAMED["dropped root"]
WRONG_SIGN = NAMED["wrong sign of spin"]
RESTITUTION = NAMED["restitution - 1e-6"]
STALE = NAMED["stale prediction"]

THROWN_BACK = scene_of(
    ball((0.06, 0.3), (0.3, 0.05), angular_velocity=(0.0, -250.0, 0.0)),
    motion="sliding",
    table=POOL_TABLE,
)
"""A ball with so much backspin that it comes back, still sliding, to the cushion it left."""

HIT_WHILE_SLIDING = scene_of(
    ball((0.6, 0.4), (1.2, 0.9), angular_velocity=(60.0, -40.0, 30.0)),
    ball((0.86, 0.6)),
    preset="pool",
)
"""A ball whose spin the cloth is still changing rubs against another one."""

SHOTS = [
    *(find_scene(name) for name in ("half-ball-cut", "draw-shot", "sliding-swerve")),
    *(find_scene(name) for name in ("three-ball-chain", "throw-slip")),
    THROWN_BACK.model_copy(update={"name": "thrown-back"}),
    HIT_WHILE_SLIDING.model_copy(update={"name": "hit-while-sliding"}),
]


def caught(run: Result | Crash, scene: Scene) -> tuple[str, ...]:
    if isinstance(run, Crash):
        return (run.reason,)
    return faults_of(grade(run, certify(scene, motion=True)), scene)


@pytest.mark.parametrize(
    ("mutation", "seen_in"),
    [
        (DROPPED, {"thrown-back"}),
        (WRONG_SIGN, {"hit-while-sliding"}),
        (RESTITUTION, {"draw-shot", "throw-slip", "hit-while-sliding"}),
        (STALE, {"three-ball-chain"}),
    ],
    ids=lambda value: value.name if isinstance(value, Mutation) else "",
)
def test_a_planted_bug_is_caught(mutation: Mutation, seen_in: set[str]) -> None:
    with planted(mutation) as mutant:
        runs = mutant.run(SHOTS)
    faults = {scene.name: caught(run, scene) for run, scene in zip(runs, SHOTS, strict=True)}
    assert seen_in <= {name for name, found in faults.items() if found}, faults


def test_the_unchanged_engine_is_not_caught_and_gives_the_same_bits() -> None:
    shots = [*SHOTS, find_scene("break-7")]
    with planted() as mutant:
        runs = mutant.run(shots)
    for run, scene in zip(runs, shots, strict=True):
        assert isinstance(run, Result)
        assert caught(run, scene) == ()
        ours = simulate(scene, record="trajectory")
        assert run.events is not None
        assert ours.events is not None
        assert run.events.tobytes() == ours.events.tobytes()
        assert np.array_equal(run.rest_positions, ours.rest_positions)


def test_a_shot_that_raises_is_a_crash_and_one_that_never_ends_is_given_up() -> None:
    mutation = Mutation(
        "raises",
        "shot.py",
        "    check_request(scene, record, max_events)\n    # The compiler",
        "    check_request(scene, record, max_events)\n    if len(scene.balls) == 1:\n"
        "        raise ZeroDivisionError('planted')\n    # The compiler",
        "",
    )
    with planted(mutation) as mutant:
        alone, pack = mutant.run([find_scene("stop"), find_scene("break-7")], max_events=3)
    assert alone == Crash("ZeroDivisionError: planted")
    assert isinstance(pack, Result)
    assert not pack.status.complete
    assert faults_of(grade(pack, certify(pack.scene, motion=True)), pack.scene)


def test_a_mutant_that_breaks_its_module_says_so() -> None:
    broken = Mutation("broken", "errors.py", "from __future__", "from __past__", "")
    with planted(broken) as mutant, pytest.raises(MutantError, match=r'"broken".*__past__'):
        mutant.run([find_scene("stop")])


@pytest.mark.parametrize(
    ("planted_text", "timeout", "reason"),
    [
        # Without the start of its process.
        pytest.param(
            "import time; time.sleep(600)", 5.0, "no answer in 5 s", marks=pytest.mark.slow
        ),
        ("import os; os._exit(7)", 20.0, "exit code 7"),
    ],
)
def test_a_shot_that_hangs_or_kills_its_process_costs_that_shot(
    planted_text: str, timeout: float, reason: str
) -> None:
    mutation = Mutation(
        "ends",
        "shot.py",
        "    check_request(scene, record, max_events)\n    # The compiler",
        "    check_request(scene, record, max_events)\n    if len(scene.balls) == 1:\n"
        f"        {planted_text}\n    # The compiler",
        "",
    )
    scenes = [find_scene(name) for name in ("half-ball-cut", "stop", "head-on")]
    with planted(mutation) as mutant:
        first, second, third = mutant.run(scenes, timeout=timeout)
    assert isinstance(first, Result)
    assert isinstance(second, Crash)
    assert second.reason.startswith(reason)
    assert isinstance(third, Result)
    assert third.scene.name == "head-on"


@pytest.mark.parametrize(
    ("file", "old", "new", "reason"),
    [
        ("motion/on_cloth.py", "no such text", "x", "found 0 times"),
        ("motion/on_cloth.py", "def ", "x", "exactly once"),
        ("motion/on_cloth.py", "first_meeting(rx: float", "first_meeting(rx: float", "differ"),
        ("no_such.py", "x", "y", "must be one of the package"),
    ],
)
def test_a_mutation_that_does_not_fit_is_refused(
    file: str, old: str, new: str, reason: str
) -> None:
    with pytest.raises(MutantError, match=reason), planted(Mutation("odd", file, old, new, "")):
        pass


def test_the_engine_itself_stays_as_it_is() -> None:
    path = Path(engine.__file__).parent / RESTITUTION.file
    before = path.read_bytes()
    with planted(RESTITUTION) as mutant:
        assert not mutant.folder.is_relative_to(path.parent.parent)
        folder = mutant.folder
        assert RESTITUTION.new in (folder / "engine" / RESTITUTION.file).read_text()
    assert not folder.exists()
    assert path.read_bytes() == before
    assert math.isfinite(simulate(find_scene("stop")).rest_time)
