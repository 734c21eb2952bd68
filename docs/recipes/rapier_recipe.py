"""Billiards with Rapier (Python's package rapier3d): the best settings, and the reason for each.

In metres, seconds and kilograms. Run it: it simulates a half-ball cut, whose exact rest positions
are 1.098066916, 0.350843120 and 1.766745641, 1.077680802.

No setting helps with balls that touch several others, as in a break: they gain or lose energy.
"""

import math
from typing import Any

import rapier3d

G, ROLLING_FRICTION, BALL_RESTITUTION, CUSHION_RESTITUTION = 9.81, 0.02, 1.0, 1.0
RADIUS, MASS, LENGTH, WIDTH = 0.028575, 0.170097, 2.54, 1.27
DT = 1e-3  # contacts are detected up to a step late: an error of some mm in this cut


def make_world() -> Any:
    """Return a table without balls."""
    world = rapier3d.PhysicsWorld()
    world.integration_parameters.dt = DT
    # 2 cm by default: contacts are resolved this far before balls touch, along a wrong line.
    world.integration_parameters.normalized_prediction_distance = 1e-5
    for (x, y), normal in (
        ((0.0, 0.0), (1.0, 0.0, 0.0)),
        ((LENGTH, 0.0), (-1.0, 0.0, 0.0)),
        ((0.0, 0.0), (0.0, 1.0, 0.0)),
        ((0.0, WIDTH), (0.0, -1.0, 0.0)),
    ):
        body = world.add_body(rapier3d.RigidBody.fixed().translation((x, y, 0.0)).build())
        bounce = CUSHION_RESTITUTION / math.sqrt(BALL_RESTITUTION)
        _add(world, rapier3d.Collider.halfspace(normal), bounce, body)
    return world


def _add(world: Any, shape: Any, restitution: float, body: Any) -> None:
    # By default Rapier takes the mean of two restitutions, and friction is 0.5. With the product of
    # two roots, the restitution is that of the pair.
    shape = shape.restitution_combine_rule(rapier3d.CoefficientCombineRule.MULTIPLY)
    world.add_collider(shape.restitution(restitution).friction(0.0).build(), body)


def add_ball(world: Any, x: float, y: float, vx: float = 0.0) -> Any:
    """Add a ball that moves in the plane without rotation; return its handle."""
    body = rapier3d.RigidBody.dynamic().translation((x, y, 0.0))
    body = body.can_sleep(False)  # otherwise a slow ball stops too early
    body = body.enabled_translations((True, True, False)).enabled_rotations((False, False, False))
    handle = world.add_body(body.build())
    shape = rapier3d.Collider.ball(RADIUS).mass(MASS)
    _add(world, shape, math.sqrt(BALL_RESTITUTION), handle)
    world.rigid_bodies[handle].linvel = (vx, 0.0, 0.0)
    return handle


def slow(ball: Any, seconds: float) -> bool:
    """Apply rolling friction to a ball; return whether the ball still moves."""
    x, y, _ = tuple(ball.linvel)
    speed, loss = math.hypot(x, y), ROLLING_FRICTION * G * seconds
    share = (speed - loss) / speed if speed > loss else 0.0
    ball.linvel = (x * share, y * share, 0.0)
    return share > 0.0


def play() -> list[tuple[float, float]]:
    """Simulate a half-ball cut until the balls rest."""
    world = make_world()
    handles = [add_ball(world, 0.5, 0.606425, 0.8), add_ball(world, 1.0, 0.635)]
    moving = True
    while moving:
        balls = [world.rigid_bodies[handle] for handle in handles]
        for ball in balls:  # half the loss before the step, half after it: exact rolling
            slow(ball, 0.5 * DT)
        world.step()
        balls = [world.rigid_bodies[handle] for handle in handles]
        still_moving = [slow(ball, 0.5 * DT) for ball in balls]
        moving = any(still_moving)
    places = [tuple(world.rigid_bodies[handle].translation) for handle in handles]
    return [(float(x), float(y)) for x, y, _ in places]


if __name__ == "__main__":
    for x, y in play():
        print(f"  {x:.9f}, {y:.9f}")
