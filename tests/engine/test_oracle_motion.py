"""The oracle's motion on the cloth against closed forms, and its random shots as a whole.

Formulas: Alciatore's technical proofs. Impacts are in `test_oracle_impacts`.
"""

from __future__ import annotations

import pytest
from mpmath import mp, mpf, workdps
from oracle import DIGITS, solve
from oracle_laws import UP, Phase, cross, norm, plus, scaled, slip
from shots import R, ball, random_cloth_shot, scene_of

from ghostball.engine import EventKind

TINY = mpf(10) ** -40
G = 9.81
MU_S, MU_R = 0.2, 0.02


@pytest.fixture(autouse=True)
def _fifty_digits():
    with workdps(DIGITS):
        yield


def sliding_scene(*balls, **physics):
    return scene_of(*balls, **{"motion": "sliding", **physics})


def spinning(position, velocity, spin, **fields):
    return ball(position, velocity, angular_velocity=spin, **fields)


class TestOnTheCloth:
    def test_a_stunned_ball_slides_then_rolls(self):
        run = solve(sliding_scene(spinning((0, 0), (2, 0), (0, 0, 0))))
        g, mu_s, mu_r = mpf(G), mpf(MU_S), mpf(MU_R)
        slide, rest = run.events
        assert [slide.key, rest.key] == [
            (EventKind.SLIDE_TO_ROLL, 0, -1),
            (EventKind.ROLL_TO_REST, 0, -1),
        ]
        assert abs(slide.t - 2 * mpf(2) / (7 * mu_s * g)) < TINY
        (rolling,) = run.at(slide.t)
        assert abs(rolling.velocity[0] - mpf(10) / 7) < TINY
        slid = 12 * mpf(2) ** 2 / (49 * mu_s * g)
        assert abs(rolling.position[0] - slid) < TINY
        assert abs(run.positions[0][0] - slid - (mpf(10) / 7) ** 2 / (2 * mu_r * g)) < TINY

    @pytest.mark.parametrize("spin", [80.0, -80.0], ids=["follow", "draw"])
    def test_follow_and_draw_from_a_standstill(self, spin):
        run = solve(sliding_scene(spinning((0, 0), (0, 0), (0, spin, 0))))
        surface = mpf(R) * mpf(spin)
        distance = 2 * surface**2 / (49 * mpf(G)) * (1 / mpf(MU_S) + 1 / mpf(MU_R))
        assert abs(run.positions[0][0] - distance * mp.sign(spin)) < TINY

    def test_a_ball_with_side_and_forward_spin_swerves_along_a_parabola(self):
        run = solve(sliding_scene(spinning((0, 0), (2, 0.3), (-40, 10, 25))))
        v, radius = (mpf(2), mpf(0.3)), mpf(R)
        u = (v[0] - radius * 10, v[1] - radius * 40)
        speed = mp.hypot(*u)
        end = run.events[0].t
        assert abs(end - 2 * speed / (7 * mpf(MU_S) * mpf(G))) < TINY
        for part in (mpf(1) / 3, mpf(2) / 3, mpf(1)):
            t = part * end
            (one,) = run.at(t)
            for axis in range(2):
                slowing = mpf(MU_S) * mpf(G) * u[axis] / speed
                assert abs(one.position[axis] - (v[axis] * t - slowing * t**2 / 2)) < TINY
        for axis in range(2):
            assert abs(one.velocity[axis] - (v[axis] - 2 * u[axis] / 7)) < TINY
        # The path bends: along a straight one both velocities would have one direction.
        assert abs(one.velocity[0] * v[1] - one.velocity[1] * v[0]) > 0.1

    def test_cloth_friction_leaves_one_vector_alone(self):
        run = solve(sliding_scene(spinning((0, 0), (1, -0.5), (70, 20, -30))))
        end = run.events[0].t

        def kept(one):
            return plus(one.velocity, scaled(2 * one.radius / 5, cross(one.spin, UP)))

        first = kept(run.at(mpf(0))[0])
        for part in (mpf("0.2"), mpf("0.7"), mpf(1)):
            assert norm(plus(kept(run.at(part * end)[0]), scaled(-1, first))) < TINY

    def test_a_whole_slide_loses_a_seventh_of_the_slip(self):
        run = solve(sliding_scene(spinning((0, 0), (1, -0.5), (70, 20, 0))))
        before, after = run.at(mpf(0))[0], run.at(run.events[0].t)[0]
        lost = before.mass * norm(slip(before)) ** 2 / 7
        assert abs(before.energy - after.energy - lost) < TINY
        assert norm(slip(after)) < TINY

    def test_vertical_spin_decays_in_every_state_and_ends_the_run(self):
        run = solve(sliding_scene(spinning((0, 0), (0.2, 0), (0, 0, -50.0))))
        rest = run.events[-1].t
        assert rest < 5
        for t in (run.events[0].t / 2, (run.events[0].t + rest) / 2, rest, mpf("4.5"), mpf(5)):
            assert abs(run.at(t)[0].spin[2] + (50 - 10 * t)) < TINY
        assert abs(run.t_end - 5) < TINY
        assert run.rested

    def test_spin_that_never_decays_keeps_nobody_waiting(self):
        scene = sliding_scene(spinning((0, 0), (0.2, 0), (0, 0, 50.0)), spinning_friction_rate=0.0)
        run = solve(scene)
        assert run.rested
        assert run.t_end == run.events[-1].t
        assert run.spins[0][2] == 50

    def test_vertical_spin_that_outlasts_the_run_is_no_rest(self):
        run = solve(sliding_scene(spinning((0, 0), (0, 0), (0, 0, 50.0)), t_max=2.0))
        assert not run.rested
        assert run.complete
        assert run.t_end == 2
        assert abs(run.spins[0][2] - 30) < TINY

    def test_without_sliding_friction_a_slide_never_ends(self):
        scene = sliding_scene(spinning((0, 0), (1, 0), (0, 0, 0)), sliding_friction=0.0, t_max=3.0)
        run = solve(scene)
        assert run.events == []
        assert run.positions[0] == (3, 0, 0)

    def test_a_slide_that_uses_up_all_motion_ends_at_rest(self):
        # R w = -(5/2) v: backspin that just stops the ball.
        run = solve(sliding_scene(spinning((0, 0), (1, 0), (0, -10, 0), radius=0.25)))
        assert [event.key for event in run.events] == [(EventKind.ROLL_TO_REST, 0, -1)]
        assert run.rested

    def test_no_angular_velocity_is_rolling(self):
        run = solve(sliding_scene(ball((0, 0), (1, 0.5))))
        assert [event.kind for event in run.events] == [EventKind.ROLL_TO_REST]

    def test_every_ball_has_its_own_cloth(self):
        own = {"rolling_friction": 0.01, "sliding_friction": 0.4, "spinning_friction_rate": 20.0}
        spin = (0, 0, 30)
        scene = sliding_scene(spinning((0, 0), (1, 0), spin), spinning((0, 1), (1, 0), spin, **own))
        run = solve(scene)
        first, second = [
            next(e.t for e in run.events if e.kind is EventKind.SLIDE_TO_ROLL and e.a == i)
            for i in range(2)
        ]
        assert abs(first / second - mpf(0.4) / mpf(0.2)) < TINY
        x = [place[0] for place in run.positions]
        g = mpf(G)
        for i, (mu_s, mu_r) in enumerate(((0.2, 0.02), (0.4, 0.01))):
            far = 12 / (49 * mpf(mu_s) * g) + mpf(25) / 49 / (2 * mpf(mu_r) * g)
            assert abs(x[i] - far) < TINY
        one, other = run.at(mpf(1))
        assert abs(one.spin[2] - 20) < TINY
        assert abs(other.spin[2] - 10) < TINY


@pytest.mark.parametrize("seed", range(10))
def test_energy_falls_and_nothing_overlaps_in_random_shots(seed):
    scene = random_cloth_shot(seed)
    run = solve(scene, max_events=15)
    last = mp.inf
    for t, bodies in run.moments:
        now = sum(one.energy for one in run.at(t))
        assert now <= last + TINY
        last = now
        for i, one in enumerate(bodies):
            assert (one.phase is Phase.RESTING) == (
                norm(one.velocity) == 0 and norm((one.spin[0], one.spin[1], 0)) == 0
            )
            for other in bodies[:i]:
                reach = one.radius + other.radius
                gap = norm(plus(one.position, scaled(-1, other.position))) - reach
                assert gap > -TINY
