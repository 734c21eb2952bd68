"""Each recipe plays a half-ball cut as near to the truth as it says."""

from __future__ import annotations

import importlib.util
import runpy
import subprocess
import sys

import numpy as np
import pytest

from ghostball import find_scene, simulate
from ghostball.cli.show.engines import _recipes

TRUE = simulate(find_scene("half-ball-cut")).rest_positions[:, :2]


def off(places) -> float:
    return float(np.max(np.linalg.norm(np.array(places) - TRUE, axis=1)))


def test_pymunk_is_some_millimetres_off_in_its_own_steps_and_right_where_contacts_are_met():
    pytest.importorskip("pymunk")
    (path,) = _recipes("pymunk")
    play = runpy.run_path(str(path))["play"]
    own, exact = (off([tuple(ball.position) for ball in play(exact)]) for exact in (False, True))
    assert 1e-3 < own < 5e-3
    assert exact < 1e-6


@pytest.mark.parametrize(
    ("name", "package"),
    [
        ("box2d", "Box2D"),
        ("box2d3", "pyb2d3"),
        ("dart", "dartpy"),
        ("mujoco", "mujoco"),
        ("physx", "sapien"),
        ("pybullet", "pybullet"),
        ("rapier", "rapier3d"),
    ],
)
def test_it_is_some_millimetres_off_in_its_own_steps(name, package):
    """In a process of its own, as a user runs it: some connect as if nobody else did."""
    if importlib.util.find_spec(package) is None:
        pytest.skip(f"{package} isn't installed")
    (path,) = _recipes(name)
    ran = subprocess.run(
        [sys.executable, str(path)], capture_output=True, text=True, check=True, timeout=60
    )
    lines = [line for line in ran.stdout.splitlines() if line.startswith("  ")]
    places = [tuple(map(float, line.split(","))) for line in lines]
    assert 5e-4 < off(places) < 5e-3
