"""The oracle's impacts against closed forms: ball-ball, and ball-cushion.

Formulas: Alciatore's technical proofs (3.3 deflection, A.14 throw); Han 2005, by components.
"""

from __future__ import annotations

import random

import pytest
from mpmath import mp, mpf, workdps
from oracle import DIGITS, solve
from oracle_laws import (
    SIDES,
    Body,
    Laws,
    bounced,
    collided,
    cross,
    dot,
    norm,
    plus,
    scaled,
    settled,
)
from shots import R, ball, scene_of

from ghostball.engine import EventKind, Table

TINY = mpf(10) ** -40
G = 9.81
MU_S, MU_R = 0.2, 0.02


@pytest.fixture(autouse=True)
def _fifty_digits():
    with workdps(DIGITS):
        yield


def sliding_scene(*balls, **physics):
    return scene_of(*balls, **{"motion": "sliding", **physics})


def body(velocity=(0, 0, 0), spin=(0, 0, 0), position=(0, 0, 0), radius=R, mass=0.17):
    numbers = [tuple(map(mpf, vector)) for vector in (position, velocity, spin)]
    slowing = [mpf(MU_R) * mpf(G), mpf(MU_S) * mpf(G), mpf(10)]
    return settled(Body(*numbers, mpf(radius), mpf(mass), *slowing), always_rolls=False)


def laws(**numbers):
    given = {
        "restitution": 1,
        "friction": (0, 0, 0),
        "cushion_restitution": 1,
        "cushion_tangential": 1,
        "cushion_friction": 0,
        "cushion_height": R,
        **numbers,
    }
    in_digits = {
        name: tuple(map(mpf, value)) if isinstance(value, tuple) else mpf(value)
        for name, value in given.items()
        if name != "cushion"
    }
    return Laws(always_rolls=False, cushion=given.get("cushion", "mirror"), **in_digits)


def energy(*bodies):
    return sum(one.energy for one in bodies)


def heading(velocity):
    return mp.degrees(mp.atan2(velocity[1], velocity[0]))


class TestBallImpacts:
    @pytest.mark.parametrize(
        ("fraction", "deflection"), [(0.5, 33.670), (0.75, 27.267), (0.25, 27.626)]
    )
    def test_a_rolling_cue_ball_is_deflected(self, fraction, deflection):
        # Proof 3.3: half, quarter and three-quarter ball; the sine of the cut is given.
        scene = sliding_scene(
            ball((0, 0), (1.5, 0), radius=0.25),
            ball((0.75, fraction * 0.5), radius=0.25),
            rolling_friction=0.0,
            t_max=10.0,
        )
        run = solve(scene)
        hit, *slides = run.events
        assert hit.kind is EventKind.BALL_BALL
        assert {event.key for event in slides} == {
            (EventKind.SLIDE_TO_ROLL, 0, -1),
            (EventKind.SLIDE_TO_ROLL, 1, -1),
        }
        assert abs(slides[0].t - slides[1].t) < TINY  # a genuine tie
        cue, struck = run.velocities
        s = mpf(fraction)
        c = mp.sqrt(1 - s**2)
        assert abs(heading(cue)) == pytest.approx(deflection, abs=5e-4)
        assert abs(heading(cue) + mp.degrees(mp.atan(s * c / (s**2 + mpf(2) / 5)))) < TINY * 100
        assert abs(norm(cue) - mpf(1.5) * 5 / 7 * mp.sqrt(9 * s**2 / 5 + mpf(4) / 25)) < TINY
        assert abs(norm(struck) - mpf(1.5) * 5 / 7 * c) < TINY

    def test_a_full_hit_by_a_rolling_ball_is_followed(self):
        run = solve(sliding_scene(ball((0, 0), (2, 0)), ball((0.5, 0))))
        hit = run.events[0].t
        v = 2 - mpf(MU_R) * mpf(G) * hit
        follow = 2 * v**2 / (49 * mpf(G)) * (1 / mpf(MU_S) + 1 / mpf(MU_R))
        assert abs(run.positions[0][0] - (mpf(0.5) - 2 * mpf(R)) - follow) < TINY

    @staticmethod
    def thrown(friction, spin=0.0, speed=1.3, fraction=0.5):
        """Angle from the line of centres [rad] at which a stunned cue ball throws another."""
        sine = mpf(fraction)
        cosine = mp.sqrt(1 - sine**2)
        reach = 2 * mpf(R)
        cue = body((speed, 0, 0), (0, 0, spin))
        other = body(position=(reach * cosine, reach * sine, 0))
        struck = collided(cue, other, laws(friction=friction))[1]
        return mp.atan2(sine, cosine) - mp.atan2(struck.velocity[1], struck.velocity[0])

    @pytest.mark.parametrize("spin", [0.0, 10.0, 60.0, -30.0])
    @pytest.mark.parametrize("fraction", [0.05, 0.3, 0.5, 0.9])
    @pytest.mark.parametrize(
        "friction", [(0.06, 0, 0), (0.5, 0, 0), (9.951e-3, 0.108, 1.088)], ids=str
    )
    def test_the_throw_of_proof_a14(self, friction, fraction, spin):
        v, s = mpf(1.3), mpf(fraction)
        c = mp.sqrt(1 - s**2)
        surface = v * s - mpf(R) * mpf(spin)
        a, b, rate = map(mpf, friction)
        mu = a + b * mp.exp(-rate * abs(surface))
        tangent = min(mu * v * c / abs(surface), mpf(1) / 7) * surface / (v * c)
        assert abs(mp.tan(self.thrown(friction, spin, fraction=fraction)) - tangent) < TINY

    def test_gearing_spin_throws_nothing(self):
        # R wz = v sin(cut), in doubles that multiply without rounding.
        cue = body((1, 0, 0), (0, 0, 2), radius=0.25)
        other = body(position=(mp.sqrt(3) / 4, 0.25, 0), radius=0.25)
        struck = collided(cue, other, laws(friction=(0.5, 0, 0)))[1]
        assert abs(heading(struck.velocity) - 30) < 100 * TINY
        assert norm(struck.spin) < TINY

    @pytest.mark.parametrize("seed", range(12))
    def test_what_an_impact_keeps_and_what_it_loses(self, seed):
        chance = random.Random(seed)
        # Both start on the move; which one slips and which one sticks is left to chance.
        a = body(*(self.random_motion(chance)), radius=R, mass=0.17)
        radius, mass = chance.uniform(0.02, 0.05), chance.uniform(0.1, 0.4)
        angle = chance.uniform(-0.5, 0.5)
        place = tuple((mpf(R) + mpf(radius)) * f for f in (mp.cos(angle), mp.sin(angle), 0))
        b = body((-1, 0.2, 0), self.random_motion(chance)[1], place, radius, mass)
        e, mu = mpf(chance.uniform(0.5, 1)), mpf(chance.choice((0.05, 0.5)))
        after_a, after_b = collided(a, b, laws(restitution=e, friction=(mu, 0, 0)))
        for axis in range(2):
            kept = [
                one.mass * one.velocity[axis] + other.mass * other.velocity[axis]
                for one, other in ((a, b), (after_a, after_b))
            ]
            assert abs(kept[0] - kept[1]) < TINY
        # Both get the same angular impulse per radius.
        turns = [
            scaled(one.inertia / one.radius, plus(one.spin, scaled(-1, old.spin)))
            for one, old in ((after_a, a), (after_b, b))
        ]
        assert norm(plus(turns[0], scaled(-1, turns[1]))) < TINY
        assert after_a.velocity[2] == after_b.velocity[2] == 0
        # Losses: the bounce, the slip, and the motion off the cloth, which the cloth stops.
        n = tuple(c / norm(place) for c in place)
        relative = plus(a.velocity, scaled(-1, b.velocity))
        v_n = dot(relative, n)
        surface = plus(relative, cross(plus(scaled(a.radius, a.spin), scaled(b.radius, b.spin)), n))
        U = norm(plus(surface, scaled(-v_n, n)))
        m = a.mass * b.mass / (a.mass + b.mass)
        J = (1 + e) * m * v_n
        P = min(mu * J, 2 * m * U / 7)
        sticks = mu * J > P
        lost = m * (1 - e**2) * v_n**2 / 2
        lost += m * U**2 / 7 if sticks else mu * J * U - mpf(7) / 4 * (mu * J) ** 2 / m
        lift = P * surface[2] / U
        lost += lift**2 / (2 * m)
        assert abs(energy(a, b) - energy(after_a, after_b) - lost) < TINY

    @staticmethod
    def random_motion(chance):
        velocity = (chance.uniform(0.5, 2), chance.uniform(-0.5, 0.5), 0)
        return velocity, tuple(chance.uniform(-60, 60) for _ in range(3))


class TestCushions:
    @staticmethod
    def han_by_components(one, height, e, mu):
        """Han 2005 as printed and corrected: X into the cushion, Y along it, Z up."""
        m, radius, inertia = one.mass, one.radius, one.inertia
        (vX, vY, _), (wX, wY, wZ) = one.velocity, one.spin
        sin = (height - radius) / radius
        cos = mp.sqrt(1 - sin**2)
        sx = vX * sin + radius * wY
        sy = -vY - radius * wZ * cos + radius * wX * sin
        c = vX * cos
        A, B = mpf(7) / 2 / m, 1 / m
        s = mp.hypot(sx, sy)
        Pz = (1 + e) * c / B
        if s / (mu * A) <= Pz:
            Px, Py = sx / A, sy / A
        else:
            Px, Py = mu * Pz * sx / s, mu * Pz * sy / s
        PX, PY, PZ = -Px * sin - Pz * cos, Py, Px * cos - Pz * sin
        velocity = (vX + PX / m, vY + PY / m, mpf(0))
        spin = (
            wX - radius * PY * sin / inertia,
            wY + radius * (PX * sin - PZ * cos) / inertia,
            wZ + radius * PY * cos / inertia,
        )
        lost = m * (1 - e**2) * c**2 / 2 + PZ**2 / (2 * m)
        sticks = s / (mu * A) <= Pz
        lost += m * s**2 / 7 if sticks else mu * Pz * s - mpf(7) / 4 * (mu * Pz) ** 2 / m
        return velocity, spin, lost, sticks

    def test_han_and_its_energy(self):
        stuck = set()
        for seed in range(40):
            chance = random.Random(seed)
            velocity = (chance.uniform(0.2, 3), chance.uniform(-2, 2), 0)
            one = body(velocity, [chance.uniform(-50, 50) for _ in range(3)])
            height = mpf(R * chance.uniform(0.8, 1.5))
            e, mu = mpf(chance.uniform(0.3, 1)), mpf(chance.choice((0.1, 0.2, 0.6)))
            law = laws(
                cushion="han2005",
                cushion_restitution=e,
                cushion_friction=mu,
                cushion_height=height,
            )
            after = bounced(one, SIDES[1], law)
            velocity, spin, lost, sticks = self.han_by_components(one, height, e, mu)
            stuck.add(sticks)
            assert norm(plus(after.velocity, scaled(-1, velocity))) < TINY
            assert norm(plus(after.spin, scaled(-1, spin))) < 100 * TINY
            assert abs(energy(one) - energy(after) - lost) < TINY
        assert stuck == {True, False}

    def test_the_frictional_cushion_is_hans_at_the_height_of_the_centre(self):
        given = {"cushion_restitution": 0.8, "cushion_friction": 0.14}
        for seed in range(10):
            chance = random.Random(seed)
            one = body((1, chance.uniform(-1, 1), 0), [chance.uniform(-50, 50) for _ in range(3)])
            after = bounced(one, SIDES[1], laws(cushion="frictional", **given))
            han = bounced(one, SIDES[1], laws(cushion="han2005", cushion_height=R, **given))
            assert after == han

    def test_all_four_sides_act_alike(self):
        # Turned by a quarter each time, the same ball comes off the same way.
        law = laws(cushion="han2005", cushion_friction=0.2, cushion_height=0.0357)
        quarter = {1: 0, 3: 1, 0: 2, 2: 3}  # right, top, left, bottom

        def turned(vector, times):
            for _ in range(times):
                vector = (-vector[1], vector[0], vector[2])
            return vector

        velocity, spin = (1, 0.7, 0), (10, 20, -30)
        wanted = bounced(body(velocity, spin), SIDES[1], law)
        for side, times in quarter.items():
            after = bounced(body(turned(velocity, times), turned(spin, times)), SIDES[side], law)
            assert norm(plus(after.velocity, scaled(-1, turned(wanted.velocity, times)))) < TINY
            assert norm(plus(after.spin, scaled(-1, turned(wanted.spin, times)))) < 100 * TINY

    @pytest.mark.parametrize("cushion", ["mirror", "restitution"])
    def test_cushions_that_leave_spin_alone_make_a_rolling_ball_slide(self, cushion):
        table = Table(length=1.0, width=8.0, cushions=("right",))
        scene = sliding_scene(
            ball((0.5, 0.5), (1.0, 0.5)),
            table=table,
            cushion=cushion,
            rolling_friction=0.0,
            t_max=9.0,
        )
        run = solve(scene)
        assert [event.kind for event in run.events] == [
            EventKind.BALL_CUSHION,
            EventKind.SLIDE_TO_ROLL,
        ]
        # Off at (-1, 1/2) with the spin of (1, 1/2): u = (-2, 0), of which 2/7 are lost.
        assert abs(run.velocities[0][0] + mpf(3) / 7) < TINY
        assert abs(run.velocities[0][1] - mpf(1) / 2) < TINY
