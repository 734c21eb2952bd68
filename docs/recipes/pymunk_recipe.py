"""Billiards with Pymunk 7: the best settings, and the effect of each.

In metres, seconds and kilograms. Run it: it simulates a half-ball cut, whose exact rest positions
are 1.098066916, 0.350843120 and 1.766745641, 1.077680802.
"""

import math

import pymunk

G, ROLLING_FRICTION, BALL_RESTITUTION, CUSHION_RESTITUTION = 9.81, 0.02, 1.0, 1.0
RADIUS, MASS, LENGTH, WIDTH = 0.028575, 0.170097, 2.54, 1.27
DT = 1e-3  # contacts are detected up to a step late: an error of 4 mm in this cut
BALL, CUSHION, THICK = 1, 2, 0.5


def make_space() -> pymunk.Space:
    """Return a table without balls."""
    space = pymunk.Space()
    space.iterations = 30  # the default, 10: a break gains 3e-4 of its energy; 30: below 1e-9
    space.collision_slop = 0.0  # the default, 0.1, is for pixels: in metres, more than a ball
    space.collision_persistence = 1  # forgets a separated contact at once, not 3 steps later
    for x, y, to_x, to_y in (
        (-THICK, -2.0, -THICK, 4.0),
        (LENGTH + THICK, -2.0, LENGTH + THICK, 4.0),
        (-2.0, -THICK, 4.0, -THICK),
        (-2.0, WIDTH + THICK, 4.0, WIDTH + THICK),
    ):  # thick segments: a fast ball can leave a thin one on the other side
        shape = pymunk.Segment(space.static_body, (x, y), (to_x, to_y), THICK)
        shape.collision_type, shape.elasticity = CUSHION, CUSHION_RESTITUTION
        space.add(shape)
    # Chipmunk multiplies the elasticities of two shapes; these callbacks set that of each pair.
    space.on_collision(BALL, BALL, pre_solve=_restitution, data=BALL_RESTITUTION)
    space.on_collision(BALL, CUSHION, pre_solve=_restitution, data=CUSHION_RESTITUTION)
    return space


def _restitution(arbiter: pymunk.Arbiter, _space: pymunk.Space, restitution: float) -> None:
    arbiter.restitution = restitution


def add_ball(space: pymunk.Space, x: float, y: float) -> pymunk.Body:
    """Add a ball, at rest."""
    body = pymunk.Body(MASS, math.inf)  # no rotation: the moment of a disc isn't that of a ball
    body.position = x, y
    shape = pymunk.Circle(body, RADIUS)
    shape.collision_type, shape.elasticity = BALL, BALL_RESTITUTION
    space.add(body, shape)
    return body


def roll(space: pymunk.Space, ball: pymunk.Body) -> None:
    """Let Chipmunk's own steps apply rolling friction to a ball.

    A joint with a limited force takes mu g dt from the speed in each step, down to an exact stop.
    With `space.damping`, the loss would be proportional to the speed, and no ball would ever stop.
    Chipmunk moves a ball before it slows the ball: half of a step's loss at the start compensates.
    """
    joint = pymunk.PivotJoint(space.static_body, ball, (0.0, 0.0), (0.0, 0.0))
    joint.max_bias, joint.max_force = 0.0, ROLLING_FRICTION * MASS * G
    space.add(joint)
    ball.velocity = _slowed(ball.velocity, 0.5 * ROLLING_FRICTION * G * DT)


def advance(space: pymunk.Space, balls: list[pymunk.Body], dt: float) -> None:
    """Advance by any `dt`: move the balls in closed form, and let Chipmunk resolve contacts.

    Until the next contact, a rolling ball moves by v t - mu g t^2 / 2. At the contact, Chipmunk
    takes a step of a nanosecond, so no contact is detected late, at any speed.
    """
    slowing = ROLLING_FRICTION * G
    while dt > 1e-12:
        stops = [ball.velocity.length / slowing for ball in balls if ball.velocity.length > 0.0]
        step = min([dt, *stops])
        for _ in range(20):  # the time of the next contact, from the mean velocities until then
            means = [_slowed(ball.velocity, 0.5 * slowing * step) for ball in balls]
            sooner = min([dt, *stops, *_contacts(balls, means)])
            settled, step = abs(sooner - step) < 1e-15, sooner
            if settled:
                break
        for ball, mean in zip(balls, means, strict=True):
            ball.position += mean * step
            ball.velocity = _slowed(ball.velocity, slowing * step)
        dt -= step
        space.step(1e-9)
        forget(space, balls)


def _slowed(velocity: pymunk.Vec2d, by: float) -> pymunk.Vec2d:
    speed = velocity.length
    return velocity * ((speed - by) / speed) if speed > by + 1e-12 else pymunk.Vec2d(0.0, 0.0)


def forget(space: pymunk.Space, balls: list[pymunk.Body]) -> None:
    """Drop the impulses of the last step: Chipmunk would apply them again in the next one."""
    velocities = [ball.velocity for ball in balls]
    for ball in balls:
        ball.velocity = 0.0, 0.0
    space.collision_persistence = 0
    space.step(1e-9)
    space.collision_persistence = 1
    for ball, velocity in zip(balls, velocities, strict=True):
        ball.velocity = velocity


def _contacts(balls: list[pymunk.Body], velocities: list[pymunk.Vec2d]) -> list[float]:
    """Return the times at which balls touch each other or a cushion at these velocities [s]."""
    times = []
    for i, (a, v) in enumerate(zip(balls, velocities, strict=True)):
        for place, speed, far in (
            (a.position.x, v.x, LENGTH - RADIUS),
            (a.position.y, v.y, WIDTH - RADIUS),
        ):
            if speed:
                times.append(((far if speed > 0.0 else RADIUS) - place) / speed)
        for b, other in zip(balls[i + 1 :], velocities[i + 1 :], strict=True):
            between, closing = b.position - a.position, other - v
            half, square = between.dot(closing), closing.dot(closing)
            left = half * half - square * (between.dot(between) - 4.0 * RADIUS * RADIUS)
            if half < 0.0 and left > 0.0:
                times.append((-half - math.sqrt(left)) / square)
    return [t for t in times if t > 1e-9]


def play(exact: bool) -> list[pymunk.Body]:
    """Simulate a half-ball cut until the balls rest, with fixed or with exact steps."""
    space = make_space()
    balls = [add_ball(space, 0.5, 0.606425), add_ball(space, 1.0, 0.635)]
    balls[0].velocity = 0.8, 0.0
    if not exact:
        for ball in balls:
            roll(space, ball)
    while any(ball.velocity.length > 1e-9 for ball in balls):
        if exact:
            advance(space, balls, 1.0 / 60.0)
        else:
            space.step(DT)
    return balls


if __name__ == "__main__":
    for exact in (False, True):
        print("steps that end at contacts:" if exact else f"steps of {DT} s:")
        for ball in play(exact):
            print(f"  {ball.position.x:.9f}, {ball.position.y:.9f}")
