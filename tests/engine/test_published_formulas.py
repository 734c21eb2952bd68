"""Every published formula that a shot on the cloth can show, from whole simulated shots.

Stun, draw and follow; throw and gearing; what an impact costs. Sources: technical proofs of D.
Alciatore (billiards.colostate.edu/technical_proofs), [A.14] among them; Wallace and Schroeder
(1988), American Journal of Physics 56, 815.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from invariants import EPS, ball_impacts
from sampling import direction, kinetic_energy, once_rolling, state_at, state_before, times_of
from shots import R, ball, scene_of

from ghostball.engine import EventKind, Result, Status, simulate

HIT = EventKind.BALL_BALL
CLOTH = {"motion": "sliding", "rolling_friction": 0.01, "sliding_friction": 0.2}


class TestStunDrawAndFollow:
    @pytest.mark.parametrize("v", [0.1, 1.0, 7.0])
    @pytest.mark.parametrize("friction", [0.15, 0.2, 0.4])
    def test_a_stunned_ball_keeps_five_sevenths(self, v, friction):
        scene = scene_of(
            ball((0, 0), (v, 0.0), angular_velocity=(0.0, 0.0, 0.0)),
            **{**CLOTH, "sliding_friction": friction},
        )
        result = simulate(scene, record="events")
        t, velocity = once_rolling(result, 0)
        g = scene.physics.gravity
        assert t == pytest.approx(2 * v / (7 * friction * g), rel=1e-14)
        assert velocity == pytest.approx([5 / 7 * v, 0.0], rel=1e-14)
        place = state_at(result, t).positions[0, 0]
        assert place == pytest.approx(12 * v**2 / (49 * friction * g), rel=1e-14)

    @pytest.mark.parametrize("surface", [2.0, 1.0, 0.3, -0.7, -2.5])
    @pytest.mark.parametrize(("rolling", "sliding"), [(0.01, 0.2), (0.005, 0.4)])
    def test_how_far_a_full_hit_draws_or_follows(self, surface, rolling, sliding):
        # Touching: the cue ball hits with just the spin that it was given, and stops dead.
        scene = scene_of(
            ball((0.0, 0.0), (2.5, 0.0), angular_velocity=(0.0, surface / R, 0.0)),
            ball((2 * R, 0.0)),
            motion="sliding",
            rolling_friction=rolling,
            sliding_friction=sliding,
        )
        result = simulate(scene, record="events")
        assert times_of(result, HIT) == [0.0]
        travel = 2 * surface**2 / (49 * scene.physics.gravity) * (1 / sliding + 1 / rolling)
        assert result.rest_positions[0, 0] == pytest.approx(
            math.copysign(travel, surface), rel=1e-13
        )
        assert result.status is Status.REST


def alciatore(slip: float) -> float:
    """Ball-ball friction at this speed of slip [m/s], Alciatore's fit of Marlow's data."""
    return 9.951e-3 + 0.108 * math.exp(-1.088 * slip)


class TestThrow:
    @staticmethod
    def hit(cut: float, v: float, side: float) -> Result:
        """Play a stunned hit of touching balls, with the surface speed `side` from side spin."""
        scene = scene_of(
            ball((0.0, 0.0), (v, 0.0), angular_velocity=(0.0, 0.0, side / R)),
            ball((2 * R * math.cos(cut), 2 * R * math.sin(cut))),
            ball_friction="alciatore",
            **CLOTH,
        )
        return simulate(scene, record="events")

    @pytest.mark.parametrize("cut", [5, 20, 40, 60, 80])
    @pytest.mark.parametrize("v", [0.3, 1.0, 3.0])
    @pytest.mark.parametrize("side", [0.0, 0.4, -0.8])
    def test_throw_of_a_stunned_hit(self, cut, v, side):
        # [A.14] tan th = min(mu v cos / vrel, 1/7) (v sin - R wz) / (v cos)
        phi = math.radians(cut)
        result = self.hit(phi, v, side * v)
        velocity = state_at(result, times_of(result, HIT)[0]).velocities[1]
        slip = v * math.sin(phi) - side * v
        along = v * math.cos(phi)
        tangent = min(alciatore(abs(slip)) * along / abs(slip), 1 / 7) * slip / along
        thrown = phi - math.atan2(velocity[1], velocity[0])
        assert math.tan(thrown) == pytest.approx(tangent, rel=1e-10, abs=1e-13)

    @pytest.mark.parametrize("cut", [10, 30, 50])
    def test_gearing_spin_neither_throws_nor_turns_the_object_ball(self, cut):
        phi = math.radians(cut)
        result = self.hit(phi, 1.5, 1.5 * math.sin(phi))
        after = state_at(result, times_of(result, HIT)[0])
        assert direction(after.velocities[1]) == pytest.approx(cut, abs=1e-11)
        assert np.max(np.abs(R * after.angular_velocities[1])) <= 64 * EPS

    @pytest.mark.parametrize("e", [1.0, 0.9, 0.5])
    @pytest.mark.parametrize("friction", [0.0, 0.06, "alciatore", 5.0])
    @pytest.mark.parametrize("masses", [(0.17, 0.17), (0.2, 0.1)])
    @pytest.mark.parametrize("spin", [(0, 0, 0), (0, 0, 60), (-30, 20, -40), (10, 90, 5)])
    def test_what_an_impact_costs(self, e, friction, masses, spin):
        """The loss to restitution and to friction, and what would have lifted the balls.

        m_r (1 - e^2) v_n^2 / 2, and P U - (7/4) P^2 / m_r with P = min(mu J, (2/7) m_r U): that is
        m_r U^2 / 7 where it sticks. The cloth takes the vertical part of P, at P_z^2 / (2 m_r).
        """
        phi, v = math.radians(35), 1.2
        scene = scene_of(
            ball((0.0, 0.0), (v, 0.0), angular_velocity=spin, mass=masses[0]),
            ball((2 * R * math.cos(phi), 2 * R * math.sin(phi)), mass=masses[1]),
            **{**CLOTH, "ball_restitution": e, "ball_friction": friction},
        )
        result = simulate(scene, record="events")
        t, a, b = next(iter(ball_impacts(result)))
        assert (a, b) == (0, 1)
        before = kinetic_energy(scene, state_before(result, t)).sum()
        after = kinetic_energy(scene, state_at(result, t)).sum()
        reduced = masses[0] * masses[1] / sum(masses)
        approach = v * math.cos(phi)
        along = -v * math.sin(phi) + R * spin[2]
        up = R * (spin[0] * math.sin(phi) - spin[1] * math.cos(phi))
        slip = math.hypot(along, up)
        push = (1 + e) * reduced * approach
        mu = alciatore(slip) if friction == "alciatore" else friction
        rub = min(mu * push, 2 / 7 * reduced * slip)
        loss = reduced * (1 - e**2) * approach**2 / 2 + rub * slip - 7 / 4 * rub**2 / reduced
        loss += (rub * up / slip) ** 2 / (2 * reduced)
        assert before - after == pytest.approx(loss, rel=1e-10, abs=64 * EPS * before)
