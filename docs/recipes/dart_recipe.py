"""Billiards with DART 6 (Python's package dartpy): the best settings, and the reason for each.

Here in metres, seconds and kilograms; in DART a metre has `SCALE` units. Run it: it simulates
a half-ball cut, whose exact rest positions are 1.098066916, 0.350843120 and 1.766745641,
1.077680802.

No setting helps with this: DART omits 1e-5 of each impulse ("constraint force mixing").
"""

import math
from typing import Any

import dartpy
import numpy as np

G, ROLLING_FRICTION, BALL_RESTITUTION, CUSHION_RESTITUTION = 9.81, 0.02, 1.0, 1.0
RADIUS, MASS, LENGTH, WIDTH = 0.028575, 0.170097, 2.54, 1.27
DT = 1e-3  # contacts are detected up to a step late: an error of some mm in this cut
# Constants of DART: rebounds slower than 0.1 unit/s are suppressed, and rebounds above 100 units/s
# are limited: 1 cm/s and 10 m/s with ten units in a metre. Use fewer units for faster balls.
SCALE = 10.0


def make_world() -> Any:
    """Return a table without balls."""
    world = dartpy.simulation.World()
    world.setTimeStep(DT)
    world.setGravity([0.0, 0.0, 0.0])
    # DART multiplies the restitutions of two bodies: a ball has the root of the pair's value.
    bounce = CUSHION_RESTITUTION / math.sqrt(BALL_RESTITUTION)
    for (nx, ny), offset in (
        ((1.0, 0.0), 0.0),
        ((-1.0, 0.0), -LENGTH),
        ((0.0, 1.0), 0.0),
        ((0.0, -1.0), -WIDTH),
    ):
        skeleton = dartpy.dynamics.Skeleton(f"cushion {nx:g} {ny:g}")
        _, body = skeleton.createWeldJointAndBodyNodePair()
        plane = dartpy.dynamics.PlaneShape(np.array([nx, ny, 0.0]), SCALE * offset)
        _set_surface(body.createShapeNode(plane), bounce)
        skeleton.setMobile(False)
        world.addSkeleton(skeleton)
    return world


def _set_surface(node: Any, restitution: float) -> None:
    node.createCollisionAspect()
    node.createDynamicsAspect()
    node.getDynamicsAspect().setRestitutionCoeff(restitution)  # 0 by default
    node.getDynamicsAspect().setFrictionCoeff(0.0)  # 1 by default: balls would make each other spin


def add_ball(world: Any, x: float, y: float, vx: float = 0.0) -> Any:
    """Add a ball that moves in the plane without rotation; return its joint."""
    skeleton = dartpy.dynamics.Skeleton(f"ball at {x:g}, {y:g}")
    joint, body = skeleton.createTranslationalJoint2DAndBodyNodePair()
    sphere = dartpy.dynamics.SphereShape(SCALE * RADIUS)
    _set_surface(body.createShapeNode(sphere), math.sqrt(BALL_RESTITUTION))
    moment = 0.4 * MASS * (SCALE * RADIUS) ** 2
    body.setInertia(dartpy.dynamics.Inertia(MASS, np.zeros(3), moment * np.eye(3)))
    joint.setPositions(SCALE * np.array([x, y]))
    joint.setVelocities(SCALE * np.array([vx, 0.0]))
    world.addSkeleton(skeleton)
    return joint


def slow(ball: Any, seconds: float) -> bool:
    """Apply rolling friction to a ball; return whether the ball still moves."""
    velocity = ball.getVelocities()
    speed, loss = float(np.hypot(*velocity)), SCALE * ROLLING_FRICTION * G * seconds
    share = (speed - loss) / speed if speed > loss else 0.0
    ball.setVelocities(share * velocity)
    return share > 0.0


def play() -> list[tuple[float, float]]:
    """Simulate a half-ball cut until the balls rest."""
    world = make_world()
    balls = [add_ball(world, 0.5, 0.606425, 0.8), add_ball(world, 1.0, 0.635)]
    moving = True
    while moving:
        for ball in balls:  # half the loss before the step, half after it: exact rolling
            slow(ball, 0.5 * DT)
        world.step()
        still_moving = [slow(ball, 0.5 * DT) for ball in balls]
        moving = any(still_moving)
    places = [ball.getPositions() / SCALE for ball in balls]
    return [(float(x), float(y)) for x, y in places]


if __name__ == "__main__":
    for x, y in play():
        print(f"  {x:.9f}, {y:.9f}")
