"""The cloth between Pymunk's steps, compared with Ghostball's engine, which shares no code."""

from __future__ import annotations

import random
from collections.abc import Callable

import numpy as np
import pytest
from shots import R, ball, scene_of

from ghostball.engine import simulate
from ghostball.model import EventKind, Scene
from ghostball.reference_adapters.stepping import cloth as cloth_module
from ghostball.reference_adapters.stepping.cloth import ClosedFormCloth
from ghostball.reference_adapters.stepping.slowing import advance_within_phases


def distant(seed: int, **physics: object) -> Scene:
    """Return five balls that never collide, with slides, rolls and spins of all kinds."""
    chance = random.Random(seed)

    def vector(size: float, n: int) -> tuple[float, ...]:
        return tuple(chance.uniform(-size, size) for _ in range(n))

    own = {"rolling_friction": 0.03, "sliding_friction": 0.1, "spinning_friction_rate": 3.0}
    return scene_of(
        ball((0, 0), vector(2.0, 2), angular_velocity=vector(80.0, 3)),
        ball((0, 50), vector(2.0, 2), angular_velocity=vector(80.0, 3), **own),
        ball((0, 100), vector(2.0, 2), radius=0.7 * R, mass=0.1),
        ball((0, 150), angular_velocity=(0, 0, 25.0)),
        ball((0, 200), angular_velocity=vector(80.0, 3), radius=1.5 * R),
        **{"motion": "sliding", **physics},
    )


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("dt", [0.013, 0.3, 100.0])
def test_the_cloth_is_that_of_our_engine_at_any_step(seed: int, dt: float) -> None:
    """Fails for any wrong deceleration, spin, duration, or order of phase ends within a step."""
    scene = distant(seed)
    ours = simulate(scene, record="events")
    cloth = ClosedFormCloth(scene)
    positions, t = scene.positions[:, :2], 0.0
    seen: list[tuple[float, EventKind, int]] = []
    while not cloth.at_rest:
        displacements, changes = cloth.advance(dt)
        positions, t = positions + displacements, t + dt
        seen += [(t, kind, i) for kind, i in changes]
        state = cloth.state(positions)
        for found, wanted in zip(state, ours.sample([min(t, ours.rest_time)]), strict=True):
            # Positions and spins are of the order of 10 m and 100 rad/s, after many steps.
            np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-9)
    assert t - dt < ours.rest_time <= t
    assert [(kind, i) for _, kind, i in seen] == [
        (EventKind(int(kind)), int(i)) for kind, i in ours.events[["kind", "a"]]
    ]
    for (end, _, _), exact in zip(seen, ours.events["t"], strict=True):
        assert end - dt <= exact * (1 + 1e-12)
        assert exact <= end * (1 + 1e-12)


def test_a_cloth_without_friction_changes_nothing() -> None:
    scene = distant(
        7, sliding_friction=0.0, rolling_friction=0.0, spinning_friction_rate=0.0, t_max=1.0
    )
    cloth = ClosedFormCloth(scene)
    displacements, changes = cloth.advance(1.0)
    for i in (0, 2, 3, 4):  # ball 1 has its own cloth friction
        assert displacements[i] == pytest.approx(scene.velocities[i, :2], abs=0)
        assert cloth.angular_velocities[i] == pytest.approx(scene.angular_velocities[i], abs=1e-12)
    assert {i for _, i in changes} <= {1}


def test_a_kick_makes_a_rolling_ball_slide_unless_it_would_end_within_the_step() -> None:
    scene = scene_of(ball((0, 0), (1, 0)), motion="sliding")
    cloth = ClosedFormCloth(scene)
    kick = np.array([[-0.5, 0.0]])
    cloth.kick(kick, None, dt=1e-3)
    assert not cloth.rolling[0]
    assert cloth.velocities[0] == pytest.approx([0.5, 0.0])
    assert cloth.angular_velocities[0, 1] == pytest.approx(1.0 / R)
    # The slip is 0.5 m/s and lasts for 2 * 0.5 / (7 * 0.2 * g), 73 ms.
    cloth = ClosedFormCloth(scene)
    cloth.kick(kick, None, dt=0.08)
    assert cloth.rolling[0]
    assert cloth.velocities[0] == pytest.approx([0.5 + 2 / 7 * 0.5, 0.0])


@pytest.mark.parametrize(("ending", "spins"), [("slide-to-roll", True), ("roll-to-rest", False)])
def test_mirrored_balls_end_together_whatever_rounding_leaves(ending: str, spins: bool) -> None:
    """A ball without remaining slip or speed must not continue for the rest of the step.

    After reflection in an oblique line, durations differ by a few ulps: the step ends with one
    ball, and by rounding the other ball may have a tiny rest left.
    """
    chance = random.Random(1)
    for _ in range(500):
        angle = chance.uniform(0.0, 2.0 * np.pi)
        place, speed = (np.cos(angle), np.sin(angle)), chance.uniform(0.1, 3.0)
        velocity = (speed * place[0], speed * place[1])
        spin = {"angular_velocity": (0.0, 0.0, 0.0)} if spins else {}
        scene = scene_of(
            ball((0, 0), (velocity[0], velocity[1]), **spin),
            ball((0, 50), (velocity[1], velocity[0]), **spin),
            ball((0, 100), (speed, 0.0), **spin),
            motion="sliding",
        )
        cloth = ClosedFormCloth(scene)
        t, seen = 0.0, []
        while len(seen) < 3 and t < 100.0:
            # The step lasts to the next change; without a change, it is much longer.
            dt = min(cloth.time_to_change(), 1.0)
            _, changes = cloth.advance(dt)
            t += dt
            seen += [t for kind, _ in changes if kind.label == ending]
        assert len(seen) == 3
        assert seen[-1] - seen[0] <= 1e-12 * t


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("physics", [{}, {"spinning_friction_rate": 0.0}, {"motion": "rolling"}])
@pytest.mark.parametrize("dt", [1e-3, 0.013])
def test_one_call_of_a_kernel_gives_the_bits_of_many(seed, physics, dt, monkeypatch) -> None:
    """The kernel for a step without the end of a phase replaces four kernels."""
    scene = distant(seed, t_max=3.0, **({} if "motion" in physics else physics))
    if "motion" in physics:
        rolls = [ball(one.position[:2], one.velocity[:2]) for one in scene.balls]
        scene = scene_of(*rolls, t_max=3.0, **physics)
    one, many = ClosedFormCloth(scene), ClosedFormCloth(scene)
    in_one_call = 0

    class Counted:
        def __call__(self, *arguments: object) -> bool:
            return self.bind(*arguments)()

        def bind(self, *arguments: object) -> Callable[[], bool]:
            call = advance_within_phases.bind(*arguments)

            def done() -> bool:
                nonlocal in_one_call
                found: bool = call()
                in_one_call += found
                return found

            return done

    for _ in range(int(3.0 / dt)):
        monkeypatch.setattr(cloth_module, "advance_within_phases", Counted())
        at_once, ended = one.advance(dt)
        monkeypatch.setattr(cloth_module, "advance_within_phases", lambda *_: False)
        by_parts, ended_too = many.advance(dt)
        assert (at_once.tobytes(), ended) == (by_parts.tobytes(), ended_too)
        assert one.velocities.tobytes() == many.velocities.tobytes()
        assert one.angular_velocities.tobytes() == many.angular_velocities.tobytes()
        assert one.at_rest == many.at_rest
    assert in_one_call > 0.9 * 3.0 / dt - 20


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("motion", ["sliding", "rolling"])
@pytest.mark.parametrize("dt", [1e-3, 0.013])
def test_steps_planned_at_once_have_the_bits_of_single_steps(seed, motion, dt) -> None:
    scene = distant(seed, t_max=3.0)
    if motion == "rolling":
        rolls = [ball(one.position[:2], one.velocity[:2]) for one in scene.balls]
        scene = scene_of(*rolls, t_max=3.0)
    cloth, planned = ClosedFormCloth(scene), 0
    while not cloth.at_rest:
        steps = cloth.steps(dt, 50)
        planned += len(steps.means)
        ahead = ClosedFormCloth(scene)
        ahead.rolling = cloth.rolling.copy()
        for k, means in enumerate(steps.means):
            ahead.set_motion(steps, k)
            assert ahead.velocities.tobytes() == cloth.velocities.tobytes()
            assert ahead.angular_velocities.tobytes() == cloth.angular_velocities.tobytes()
            displacements, ended = cloth.advance(dt)
            assert (displacements / dt).tobytes() == means.tobytes()
            assert not ended
            cloth.keep(rubs=False)
        if len(steps.means) < 50:  # a phase ends in the next step
            assert cloth.advance(dt)[1] or motion == "sliding"  # spins end without an event
            cloth.keep(rubs=False)
    assert planned > 100
