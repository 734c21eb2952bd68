"""Billiards with Box2D 3 (Python's package pyb2d3): the best settings, and the reason for each.

Here in metres, seconds and kilograms; in Box2D a metre has `SCALE` units. Run it: it simulates
a half-ball cut, whose exact rest positions are 1.098066916, 0.350843120 and 1.766745641,
1.077680802.

No setting helps with balls that touch several others, as in a break: they lose up to half of the
energy, because restitution is applied once, after the solver.
"""

import math
from typing import Any

import pyb2d3

G, ROLLING_FRICTION, BALL_RESTITUTION, CUSHION_RESTITUTION = 9.81, 0.02, 1.0, 1.0
RADIUS, MASS, LENGTH, WIDTH = 0.028575, 0.170097, 2.54, 1.27
DT = 1e-3  # contacts are detected up to a step late: an error of some mm in this cut
SCALE = 100.0  # contacts are resolved 0.02 units before balls touch: 2 cm if a unit were a metre


def make_world() -> Any:
    """Return a table without balls."""
    world = pyb2d3.World(
        gravity=(0.0, 0.0),
        restitution_threshold=0.0,  # otherwise impacts slower than 1 unit/s are inelastic
        maximum_linear_speed=100.0 * SCALE,  # otherwise bodies move at most 4 units in a frame
    )
    corners = [(0.0, 0.0), (LENGTH, 0.0), (LENGTH, WIDTH), (0.0, WIDTH)]
    for start, end in zip(corners, corners[1:] + corners[:1], strict=True):
        ends = [(SCALE * x, SCALE * y) for x, y in (start, end)]
        edge = world.create_static_body()
        edge.create_segment_shape(_material(CUSHION_RESTITUTION), pyb2d3.segment(*ends))
    return world


def _material(restitution: float) -> Any:
    # Box2D takes the larger of two restitutions: a cushion can't have less than the balls.
    material = pyb2d3.surface_material(restitution=restitution, friction=0.0)
    return pyb2d3.shape_def(material=material)


def add_ball(world: Any, x: float, y: float, vx: float = 0.0) -> Any:
    """Add a ball."""
    body = world.create_dynamic_body(
        position=(SCALE * x, SCALE * y),
        fixed_rotation=True,  # the rotation of a disc isn't that of a ball
        enable_sleep=False,  # otherwise a slow ball stops too early
    )
    body.linear_velocity = (SCALE * vx, 0.0)
    definition = _material(BALL_RESTITUTION)
    definition.density = MASS / (math.pi * (SCALE * RADIUS) ** 2)
    body.create_circle_shape(definition, pyb2d3.circle(radius=SCALE * RADIUS))
    return body


def slow(ball: Any, seconds: float) -> bool:
    """Apply rolling friction to a ball; return whether the ball still moves."""
    x, y = ball.linear_velocity.x, ball.linear_velocity.y
    speed, loss = math.hypot(x, y), SCALE * ROLLING_FRICTION * G * seconds
    share = (speed - loss) / speed if speed > loss else 0.0
    ball.linear_velocity = (x * share, y * share)
    return share > 0.0


def play() -> list[tuple[float, float]]:
    """Simulate a half-ball cut until the balls rest."""
    world = make_world()
    balls = [add_ball(world, 0.5, 0.606425, 0.8), add_ball(world, 1.0, 0.635)]
    moving = True
    while moving:
        for ball in balls:  # half the loss before the step, half after it: exact rolling
            slow(ball, 0.5 * DT)
        world.step(DT, 4)  # substeps, as in the manual
        still_moving = [slow(ball, 0.5 * DT) for ball in balls]
        moving = any(still_moving)
    return [(ball.position.x / SCALE, ball.position.y / SCALE) for ball in balls]


if __name__ == "__main__":
    for x, y in play():
        print(f"  {x:.9f}, {y:.9f}")
