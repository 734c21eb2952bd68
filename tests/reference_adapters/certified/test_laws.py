"""Impacts in balls against the oracle's, whose laws are vectors in space, and against limits."""

from __future__ import annotations

import random
from dataclasses import replace

import pytest
from flint import arb
from mpmath import mp, mpf, workdps
from oracle import ALCIATORE, Laws as OracleLaws
from oracle_laws import SIDES, Body, bounced, collided, settled, slip, unit
from shots import R, ball, scene_of

from ghostball.engine import Table
from ghostball.reference_adapters.certified.arithmetic import UndecidedError, working_precision
from ghostball.reference_adapters.certified.laws import Laws, Seen, seen_along, seen_from_table
from ghostball.reference_adapters.certified.problem import problem_of

CUSHIONS = (
    {"cushion": "mirror"},
    {
        "cushion": "restitution",
        "cushion_restitution": 0.75,
        "cushion_tangential_restitution": 0.875,
    },
    {"cushion": "frictional", "cushion_restitution": 0.75, "cushion_friction": 0.25},
    {"cushion": "han2005", "cushion_restitution": 0.75, "cushion_friction": 0.125},
)
FRICTIONS = (0.0, 0.0625, "alciatore")


def scene(friction, cushion, masses=(0.17, 0.2)):
    balls = [ball((0.5, 0.5 + k), mass=m, radius=R * (1 + k / 8)) for k, m in enumerate(masses)]
    return scene_of(
        *balls,
        table=Table(length=3.0, width=3.0),
        motion="sliding",
        ball_restitution=0.9375,
        ball_friction=friction,
        **cushion,
    )


def oracle_laws(scene):
    physics = scene.physics
    a, b, c = ALCIATORE if physics.ball_friction == "alciatore" else (physics.ball_friction, 0, 0)
    mirror = physics.cushion == "mirror"
    return OracleLaws(
        always_rolls=False,
        restitution=mpf(physics.ball_restitution),
        friction=(mpf(a), mpf(b), mpf(c)),
        cushion=physics.cushion,
        cushion_restitution=mpf(1 if mirror else physics.cushion_restitution),
        cushion_tangential=mpf(1 if mirror else physics.cushion_tangential_restitution),
        cushion_friction=mpf(physics.cushion_friction),
        cushion_height=mpf(physics.cushion_height),
    )


def bodies_of(scene, seed):
    chance = random.Random(seed)
    bodies = []
    for one in scene.balls:
        v = [mpf(chance.uniform(-3, 3)) for _ in range(2)]
        w = [mpf(chance.uniform(-60, 60)) for _ in range(3)]
        body = Body(
            position=(mpf(0), mpf(0), mpf(0)),
            velocity=(*v, mpf(0)),
            spin=tuple(w),
            radius=mpf(one.radius),
            mass=mpf(one.mass),
            rolling=mpf(1) / 8,
            sliding=mpf(2),
            spinning=mpf(10),
        )
        bodies.append(settled(body, False))
    return bodies


def ball_of(x):
    """An arb that is within 1e-40 of an mpf."""
    with workdps(45):
        return arb(mp.nstr(x, 45))


def seen(body, n):
    u = slip(body)
    velocity = (ball_of(body.velocity[0]), ball_of(body.velocity[1]))
    wz = ball_of(body.spin[2])
    return seen_along(n, velocity, (ball_of(u[0]), ball_of(u[1])), wz, ball_of(body.radius))


def assert_same(ball, body, n):
    velocity, u = seen_from_table(n, ball)
    expected = slip(body)
    for x, y in (
        (velocity[0], body.velocity[0]),
        (velocity[1], body.velocity[1]),
        (u[0], expected[0]),
        (u[1], expected[1]),
        (ball.wz, body.spin[2]),
    ):
        assert abs(x - ball_of(y)) < 1e-35


@pytest.mark.parametrize("friction", FRICTIONS)
@pytest.mark.parametrize("seed", range(8))
def test_ball_impacts_agree_with_the_oracle(seed, friction):
    one = scene(friction, CUSHIONS[0])
    with workdps(50), working_precision(212):
        a, b = bodies_of(one, seed)
        chance = random.Random(-seed)
        n = unit((mpf(chance.uniform(-1, 1)), mpf(chance.uniform(-1, 1)), mpf(0)))
        if sum(n[k] * (a.velocity[k] - b.velocity[k]) for k in range(2)) < 0:
            n = (-n[0], -n[1], n[2])
        reach = a.radius + b.radius
        b = replace(b, position=tuple(reach * x for x in n))
        normal = (ball_of(n[0]), ball_of(n[1]))
        laws = Laws(problem_of(one))
        after = laws.collide(0, 1, seen(a, normal), seen(b, normal))
        for ball_after, body in zip(after, collided(a, b, oracle_laws(one)), strict=True):
            assert_same(ball_after, body, normal)


@pytest.mark.parametrize("cushion", CUSHIONS, ids=lambda c: c["cushion"])
@pytest.mark.parametrize("seed", range(8))
def test_cushions_agree_with_the_oracle(seed, cushion):
    one = scene(0.0, cushion)
    with workdps(50), working_precision(212):
        body = bodies_of(one, seed)[0]
        side = SIDES[seed % 4]
        if sum(side[k] * body.velocity[k] for k in range(2)) < 0:
            body = settled(
                replace(body, velocity=(-body.velocity[0], -body.velocity[1], mpf(0))), False
            )
        expected = bounced(body, side, oracle_laws(one))
        normal = (arb(int(side[0])), arb(int(side[1])))
        after = Laws(problem_of(one)).bounce(0, seen(body, normal))
        if sum(side[k] * expected.velocity[k] for k in range(2)) > 0:
            # The oracle lets a wedged ball approach on; the model stops it.
            assert after.vn.is_zero()
            return
        assert_same(after, expected, normal)


def test_equal_elastic_balls_swap_their_speeds_exactly():
    one = scene_of(ball((0.0, 0.0)), ball((1.0, 0.0)))
    with working_precision(53):
        zero, third = arb(0), arb(1) / 3
        cue = Seen(third, zero, zero, zero, zero, arb(R))
        rest = Seen(zero, zero, zero, zero, zero, arb(R))
        a, b = Laws(problem_of(one)).collide(0, 1, cue, rest)
        assert a.vn.is_zero()
        assert b.vn.contains(third.mid())


def test_a_slip_that_may_be_nothing_is_ended_by_friction():
    # Stick or slip needs no decision where the impulse is the same: the friction that ends it.
    one = scene(0.0625, CUSHIONS[0], masses=(0.17, 0.17))
    with working_precision(106):
        laws, zero = Laws(problem_of(one)), arb(0)
        a = Seen(arb(1), arb(0, 1e-20), arb(1), arb(0, 1e-20), zero, arb(R))
        b = Seen(zero, zero, -arb(1), zero, zero, arb(R))
        after, _ = laws.collide(0, 1, a, b)
        assert abs(after.vt) < 1e-19


def test_whether_a_cushion_stops_a_ball_may_be_undecided():
    one = scene(0.0, {"cushion": "han2005", "cushion_restitution": 0.0, "cushion_friction": 0.0})
    with working_precision(53):
        laws = Laws(problem_of(one))
        zero = arb(0)
        with pytest.raises(UndecidedError, match="whether the cushion stops it"):
            laws.bounce(0, Seen(arb(0, 1e-3), zero, zero, zero, zero, arb(R)))
