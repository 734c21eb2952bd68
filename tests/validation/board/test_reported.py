"""Reported faults: each is a scene that a right engine passes and a wrong one fails."""

from __future__ import annotations

import dataclasses

import pytest
from engine_facts import needs

from ghostball.engine import simulate
from ghostball.validation.board.columns import COLUMNS
from ghostball.validation.board.reported import REPORTED


@pytest.mark.parametrize("name", REPORTED)
def test_each_names_its_thread_and_what_is_off_is_seen(name: str) -> None:
    one = REPORTED[name]
    repository, number = name.rsplit("-", 1)
    assert one.thread.endswith(f"/{number}")
    assert repository in one.thread.lower()
    assert one.right < one.fair
    right = simulate(one.scene)
    assert right.status.complete
    assert one.off(right, right) == 0.0
    end = right.final_state
    wrong = dataclasses.replace(
        right,
        final_state=end._replace(
            positions=end.positions + 0.1,
            velocities=0.9 * end.velocities,
            angular_velocities=0.9 * end.angular_velocities,
        ),
    )
    assert one.off(wrong, right) > one.fair


@pytest.mark.parametrize(
    ("engine", "name"),
    [
        pytest.param("physx", "physx-351", marks=needs("physx")),
        pytest.param("pybullet", "bullet3-1530", marks=needs("pybullet")),
        pytest.param("box2d", "physx-351", marks=needs("box2d")),
    ],
)
def test_the_cure_cures_what_the_default_shows(engine: str, name: str) -> None:
    assert COLUMNS[name].measure(f"{engine}:config=default").worth == "bad"
    assert COLUMNS[name].measure(engine).worth in ("good", "fair")
