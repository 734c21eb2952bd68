"""Billiards with Box2D 2.3 (Python's package Box2D): the best settings, and the reason for each.

Here in metres, seconds and kilograms; in Box2D a metre has `SCALE` units. Run it: it simulates
a half-ball cut, whose exact rest positions are 1.098066916, 0.350843120 and 1.766745641,
1.077680802.
"""

import math

import Box2D

G, ROLLING_FRICTION, BALL_RESTITUTION, CUSHION_RESTITUTION = 9.81, 0.02, 1.0, 1.0
RADIUS, MASS, LENGTH, WIDTH = 0.028575, 0.170097, 2.54, 1.27
DT = 1e-3  # balls are bullets, with continuous detection: an error of 1 mm in this cut
# Constants of Box2D: impacts slower than 1 unit/s are inelastic, and 0.005 units of overlap remain
# (1 m/s and 5 mm if a unit were a metre). A body moves at most 2 units in a step: 10 m/s here.
SCALE = 200.0


class Restitutions(Box2D.b2ContactListener):  # type: ignore[misc]
    """Set the restitution of each pair: Box2D would take the larger one of two."""

    def PreSolve(self, contact: Box2D.b2Contact, _manifold: object) -> None:  # noqa: N802
        """Set the restitution of a contact before it is solved."""
        cushion = "cushion" in (contact.fixtureA.userData, contact.fixtureB.userData)
        contact.restitution = CUSHION_RESTITUTION if cushion else BALL_RESTITUTION


LISTENER = Restitutions()  # keeps a reference: Box2D doesn't


def make_world() -> Box2D.b2World:
    """Return a table without balls."""
    world = Box2D.b2World(gravity=(0, 0), doSleep=False, contactListener=LISTENER)
    corners = [(0.0, 0.0), (LENGTH, 0.0), (LENGTH, WIDTH), (0.0, WIDTH)]
    for (x, y), (to_x, to_y) in zip(corners, corners[1:] + corners[:1], strict=True):
        ends = [(SCALE * x, SCALE * y), (SCALE * to_x, SCALE * to_y)]
        edge = world.CreateStaticBody().CreateEdgeFixture(vertices=ends, friction=0.0)
        edge.userData = "cushion"
    return world


def add_ball(world: Box2D.b2World, x: float, y: float, vx: float = 0.0) -> Box2D.b2Body:
    """Add a ball; by default Box2D doesn't damp it."""
    body = world.CreateDynamicBody(
        position=(SCALE * x, SCALE * y),
        linearVelocity=(SCALE * vx, 0.0),
        bullet=True,  # otherwise contacts are detected at the end of a step, up to 1 ms late
        fixedRotation=True,  # the rotation of a disc isn't that of a ball
    )
    radius = SCALE * RADIUS
    density = MASS / (math.pi * radius**2)
    body.CreateCircleFixture(radius=radius, density=density, friction=0.0).userData = "ball"
    return body


def slow(ball: Box2D.b2Body, seconds: float) -> bool:
    """Apply rolling friction to a ball; return whether the ball still moves."""
    speed, loss = ball.linearVelocity.length, SCALE * ROLLING_FRICTION * G * seconds
    ball.linearVelocity *= (speed - loss) / speed if speed > loss else 0.0
    return bool(speed > loss)


def play() -> list[tuple[float, float]]:
    """Simulate a half-ball cut until the balls rest."""
    world = make_world()
    balls = [add_ball(world, 0.5, 0.606425, 0.8), add_ball(world, 1.0, 0.635)]
    moving = True
    while moving:
        for ball in balls:  # half the loss before the step, half after it: exact rolling
            slow(ball, 0.5 * DT)
        world.Step(DT, 8, 3)  # as in the manual; more iterations don't improve a single collision
        still_moving = [slow(ball, 0.5 * DT) for ball in balls]
        moving = any(still_moving)
    return [(ball.position.x / SCALE, ball.position.y / SCALE) for ball in balls]


if __name__ == "__main__":
    for x, y in play():
        print(f"  {x:.9f}, {y:.9f}")
