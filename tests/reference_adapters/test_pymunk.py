"""Pymunk compared with closed forms: errors of its steps; with exact steps, only of its solver."""

import math
import subprocess
import sys

import numpy as np
import pytest
from shots import R

from ghostball import find_scene
from ghostball.model import Ball, EventKind, Physics, Scene, Status, Table
from ghostball.reference_adapters.pymunk.engine import PymunkEngine, PymunkSettings
from ghostball.reference_adapters.pymunk.world import PymunkWorld
from ghostball.reference_adapters.stepping.joints import JointStepper

MU_G = 0.02 * 9.81
EXACT = 1e-8  # [m]: gaps of 1e-10 m, amplified by a cut shot


def run(scene, record="events", **settings):
    return PymunkEngine(PymunkSettings(**settings)).simulate(scene, record=record)


def scene_of(*balls, name="test", **fields):
    return Scene(name=name, balls=balls, **fields)


def kinds_of(result):
    return [EventKind(int(kind)) for kind in result.events["kind"]]


@pytest.mark.parametrize(
    ("settings", "position_error", "time_error"),
    [
        ({"contact_steps": "exact"}, 1e-12, 1e-12),
        ({"config": "tuned"}, MU_G * 1e-3**2, 1e-3),  # second order, by the half kick
        ({"config": "naive"}, 1.05 / 60.0 / 2.0, 1.0 / 60.0),  # v dt / 2 without the half kick
    ],
)
def test_roll_to_rest(settings, position_error, time_error):
    """Fails without the half kick, with a wrong friction, or with an inexact stop."""
    result = run(scene_of(Ball(id="cue", position=(0, 0), velocity=(0.6, 0.8))), **settings)
    assert result.status is Status.REST
    distance = np.hypot(*result.rest_positions[0, :2])
    assert distance == pytest.approx(1.0 / (2 * MU_G), abs=position_error)
    assert result.rest_time == pytest.approx(1.0 / MU_G, abs=time_error)
    assert result.rest_positions[0, 2] == R
    assert kinds_of(result) == [EventKind.ROLL_TO_REST]
    assert not np.any(result.final_state.velocities)
    assert not np.any(result.final_state.angular_velocities)


def test_the_naive_configuration_overshoots():
    """The naive error must be visible: v dt / 2 too far, 8 mm at 1 m/s."""
    result = run(scene_of(Ball(id="cue", position=(0, 0), velocity=(1, 0))), config="naive")
    excess = result.rest_positions[0, 0] - 1.0 / (2 * MU_G)
    assert excess == pytest.approx(0.5 / 60.0, rel=0.05)


@pytest.mark.parametrize("steps", ["fixed", "exact"])
def test_cushion_and_corner(steps):
    """A ball bounces off the right and top cushions, and rests at its unfolded position."""
    table = Table(length=1.0, width=0.8)
    velocity = np.array([1.0, 0.7])
    start = np.array([0.3, 0.2])
    result = run(
        scene_of(Ball(id="cue", position=tuple(start), velocity=tuple(velocity)), table=table),
        contact_steps=steps,
    )
    speed = np.hypot(*velocity)
    straight = start + velocity * speed / (2 * MU_G)
    # Fold each coordinate of the straight path back into the strip between R and size - R.
    strip = np.array([1.0, 0.8]) - 2 * R
    folded = (straight - R) % (2 * strip)
    expected = R + np.minimum(folded, 2 * strip - folded)
    error = EXACT if steps == "exact" else 0.02
    np.testing.assert_allclose(result.rest_positions[0, :2], expected, rtol=0, atol=error)
    crossings = int(np.sum((straight - R) // strip))
    assert result.collision_counts == {"ball-ball": 0, "ball-cushion": crossings}
    assert crossings == 6
    first = result.events[0]
    assert (first["a"], first["b"]) == (0, 1)  # the right cushion comes first


def rack(gap, t_max=0.45, **physics):
    balls = [Ball(id="cue", position=(0.6, 0.636), velocity=(4.0, 0.0))]
    pitch = 2 * R + gap
    for row in range(4):
        for i in range(row + 1):
            place = (1.9 + row * pitch * math.sqrt(0.75), 0.635 + (i - row / 2) * pitch)
            balls.append(Ball(id=f"{row}-{i}", position=place))
    table = Table(length=2.54, width=1.27)
    return scene_of(*balls, table=table, physics=Physics(**physics), t_max=t_max)


@pytest.mark.parametrize("gap", [0.0, 1e-6, 1e-3])
@pytest.mark.parametrize("restitution", [0.9, 1.0])
@pytest.mark.parametrize("steps", ["fixed", "exact"])
def test_break_keeps_momentum_and_gains_no_energy(gap, restitution, steps):
    """Impulses of one step must not affect the next step through Chipmunk's stored contacts."""
    scene = rack(gap, ball_restitution=restitution, rolling_friction=0.0)
    result = run(scene, contact_steps=steps)
    assert result.status is Status.T_MAX
    assert result.collision_counts["ball-ball"] >= 9
    energy = result.to_dict()["energy"]
    assert energy["final"] <= energy["initial"] * (1.0 + 1e-9)
    if result.collision_counts["ball-cushion"] == 0:
        momentum = result.final_state.velocities[0].sum(axis=0)
        np.testing.assert_allclose(momentum, [4.0, 0.0, 0.0], rtol=0, atol=1e-9)


@pytest.mark.parametrize("restitution", [0.8, 1.0])
def test_impacts_of_one_instant_are_resolved_together(restitution):
    """Closed form of a ball that hits two touching balls symmetrically, in simultaneous impacts."""
    balls = [Ball(id="cue", position=(0, 0), velocity=(1, 0))]
    balls += [Ball(id=f"{y}", position=(0.2, y)) for y in (R, -R)]
    physics = Physics(ball_restitution=restitution, rolling_friction=0.0)
    velocities = run(
        scene_of(*balls, physics=physics, t_max=0.3), contact_steps="exact"
    ).final_state[1][0]
    share = (1 + restitution) / 5
    expected = [(1 - 3 * share, 0), (1.5 * share, share * math.sqrt(0.75))]
    expected.append((expected[1][0], -expected[1][1]))
    np.testing.assert_allclose(velocities[:, :2], expected, rtol=0, atol=1e-8)


@pytest.mark.parametrize("record", ["rest", "trajectory"])
@pytest.mark.parametrize("name", ["half-ball-cut", "three-ball-chain", "corner-double-bounce"])
def test_quiet_steps_change_no_bit(name, record, monkeypatch):
    """Fails if a quiet step is too late for a contact or for a ball that stops."""
    quiet = run(find_scene(name), record=record)
    reads = count_reads(monkeypatch, lambda: run(find_scene(name), record=record))
    assert reads < quiet.work["steps"]
    monkeypatch.setattr(JointStepper, "_steps_to_stop", lambda _: 0.0)
    read = run(find_scene(name), record=record)
    assert count_reads(monkeypatch, lambda: run(find_scene(name), record=record)) > reads
    assert read.work == quiet.work
    assert read.rest_time == quiet.rest_time
    assert read.collision_counts == quiet.collision_counts
    assert all(map(np.array_equal, read.final_state, quiet.final_state))
    if record == "trajectory":
        assert np.array_equal(read.events, quiet.events)
        times = np.linspace(0.0, quiet.rest_time, 997)
        assert all(map(np.array_equal, read.sample(times), quiet.sample(times)))


def count_reads(monkeypatch, call):
    """Return how often a call reads the motion from Pymunk."""
    count = 0
    original = PymunkWorld.positions_and_velocities

    def counted(world):
        nonlocal count
        count += 1
        return original(world)

    with monkeypatch.context() as patch:
        patch.setattr(PymunkWorld, "positions_and_velocities", counted)
        call()
    return count


def test_importing_the_adapter_does_not_import_pymunk():
    """Listing engines must be fast; loading pymunk takes 0.1 s."""
    code = (
        "import sys, ghostball.reference_adapters.pymunk.engine as e;"
        "assert e.PymunkEngine.unavailable() is None; sys.exit('pymunk' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_unavailable_says_how_to_get_it(monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert "pip install" in PymunkEngine.unavailable()
