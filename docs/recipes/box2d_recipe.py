"""Billiards with Box2D 2.3 (Python's package Box2D): the settings that make it right, and why.

Here in metres, seconds and kilograms; in Box2D a metre has `SCALE` units. Run it: it plays a
half-ball cut, whose balls rest in truth at 1.098066915, 0.350843120 and 1.766745641, 1.077680802.
"""

import math

import Box2D

G, ROLLING_FRICTION, BALL_RESTITUTION, CUSHION_RESTITUTION = 9.81, 0.02, 1.0, 1.0
RADIUS, MASS, LENGTH, WIDTH = 0.028575, 0.170097, 2.54, 1.27
DT = 1e-3  # balls are bullets, which meet in continuous time: this cut ends 1 mm off
# Impacts slower than 1 unit/s don't bounce, and 0.005 units of overlap stay: both are compiled in.
# In metres that is 1 m/s and 5 mm. But a body goes 2 units a step at most, here 10 m/s.
SCALE = 200.0


class Restitutions(Box2D.b2ContactListener):  # type: ignore[misc]
    """Have what is meant for each pair: Box2D would take the larger one of two."""

    def PreSolve(self, contact: Box2D.b2Contact, _manifold: object) -> None:  # noqa: N802
        """Set the restitution of a contact before it is solved."""
        cushion = "cushion" in (contact.fixtureA.userData, contact.fixtureB.userData)
        contact.restitution = CUSHION_RESTITUTION if cushion else BALL_RESTITUTION


LISTENER = Restitutions()  # Box2D doesn't keep it alive


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
    """Add a ball; Box2D damps none unless it is told to."""
    body = world.CreateDynamicBody(
        position=(SCALE * x, SCALE * y),
        linearVelocity=(SCALE * vx, 0.0),
        bullet=True,  # else a contact is seen at the end of a step, up to 1 ms late
        fixedRotation=True,  # a disc's turning isn't a ball's
    )
    radius = SCALE * RADIUS
    density = MASS / (math.pi * radius**2)
    body.CreateCircleFixture(radius=radius, density=density, friction=0.0).userData = "ball"
    return body


def slow(ball: Box2D.b2Body, seconds: float) -> bool:
    """Let the cloth slow a ball that rolls; return whether it still moves."""
    speed, loss = ball.linearVelocity.length, SCALE * ROLLING_FRICTION * G * seconds
    ball.linearVelocity *= (speed - loss) / speed if speed > loss else 0.0
    return bool(speed > loss)


def play() -> list[tuple[float, float]]:
    """Play a half-ball cut to its end."""
    world = make_world()
    balls = [add_ball(world, 0.5, 0.606425, 0.8), add_ball(world, 1.0, 0.635)]
    moving = True
    while moving:
        for ball in balls:  # half the loss before the step, half after it: so a roll is exact
            slow(ball, 0.5 * DT)
        world.Step(DT, 8, 3)  # as its manual has it: more buys nothing where two balls meet
        still_moving = [slow(ball, 0.5 * DT) for ball in balls]
        moving = any(still_moving)
    return [(ball.position.x / SCALE, ball.position.y / SCALE) for ball in balls]


if __name__ == "__main__":
    for x, y in play():
        print(f"  {x:.9f}, {y:.9f}")
