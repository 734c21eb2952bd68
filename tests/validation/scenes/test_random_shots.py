"""Random shots: the same from the same number, and of everything that can be certified."""

from __future__ import annotations

import subprocess
import sys
from collections import Counter

from ghostball.engine import simulate
from ghostball.model.features import scene_features
from ghostball.validation.scenes.random_shots import MOST_BALLS, random_shot
from ghostball.validation.truth.proof import refused_features

MANY = [random_shot(number) for number in range(400)]


def test_a_number_is_a_shot_in_every_process() -> None:
    code = (
        "from ghostball.validation.scenes.random_shots import random_shot;"
        "print(random_shot(17).model_dump_json())"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == random_shot(17).model_dump_json()
    assert random_shot(17) == random_shot(17)
    assert random_shot(17) != random_shot(18)


def test_every_shot_can_be_proved_and_something_moves() -> None:
    for scene in MANY:
        assert refused_features(scene) == ""
        assert scene.velocities.any()
        if scene.physics.rolling_friction == 0.0:
            assert scene.t_max is not None


def test_all_that_can_be_certified_is_drawn() -> None:
    physics = [scene.physics for scene in MANY]
    assert {p.motion for p in physics} == {"rolling", "sliding"}
    assert {p.impacts for p in physics} == {"simultaneous", "sequential"}
    laws = {p.cushion for p, scene in zip(physics, MANY, strict=True) if scene.table is not None}
    assert laws == {"mirror", "restitution", "frictional", "han2005"}
    assert {"alciatore", 0.0} < {p.ball_friction for p in physics}
    assert {len(scene.balls) for scene in MANY} == set(range(1, MOST_BALLS + 1))
    assert {scene.table is None for scene in MANY} == {True, False}
    assert any(len({ball.mass for ball in scene.balls}) > 1 for scene in MANY)
    seen = Counter(feature for scene in MANY for feature in scene_features(scene))
    assert len(seen) > 8


def test_balls_meet_often() -> None:
    # Breaks where shots miss each other: their grades would say nothing of impacts.
    counts = [simulate(scene, max_events=10_000).collision_counts for scene in MANY[:100]]
    assert sum(count["ball-ball"] > 0 for count in counts) > 30
    assert sum(count["ball-cushion"] > 0 for count in counts) > 30
