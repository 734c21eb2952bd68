"""Billiards with PhysX 5 (through SAPIEN 3): the best settings, and the reason for each.

In metres, seconds and kilograms. Run it: it simulates a half-ball cut, whose exact rest positions
are 1.098066916, 0.350843120 and 1.766745641, 1.077680802.
"""

import math
from typing import Any

import sapien

G, ROLLING_FRICTION, BALL_RESTITUTION, CUSHION_RESTITUTION = 9.81, 0.02, 1.0, 1.0
RADIUS, MASS, LENGTH, WIDTH = 0.028575, 0.170097, 2.54, 1.27
DT = 1e-3  # contacts are detected up to a step late: an error of some mm in this cut
BALLS, CUSHIONS = 1, 2


def make_scene() -> Any:
    """Return a table without balls."""
    scene, shape, body = (
        sapien.physx.PhysxSceneConfig(),
        sapien.physx.PhysxShapeConfig(),
        sapien.physx.PhysxBodyConfig(),
    )
    scene.gravity = [0.0, 0.0, 0.0]
    scene.enable_tgs = False  # SAPIEN's own solver changes the energy of every impact
    scene.bounce_threshold = 1e-4  # 2 by default: slower impacts are inelastic
    shape.contact_offset = 1e-7  # 1 cm by default: closer balls are stopped before they touch
    shape.rest_offset = 0.0
    body.solver_position_iterations = 64  # with the default, 10, a break gains 1e-4 of its energy
    body.sleep_threshold = 0.0  # otherwise a slow ball stops too early
    # These settings belong to the process and are read when a scene and its bodies are made.
    sapien.physx.set_scene_config(scene)
    sapien.physx.set_shape_config(shape)
    sapien.physx.set_body_config(body)
    made = sapien.Scene([sapien.physx.PhysxCpuSystem()])
    made.set_timestep(DT)
    for x, y, turned in (  # the normal of a plane is along x; the quaternion turns it inward
        (0.0, 0.0, (1.0, 0.0, 0.0, 0.0)),
        (LENGTH, 0.0, (0.0, 0.0, 0.0, 1.0)),
        (0.0, 0.0, (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))),
        (0.0, WIDTH, (math.sqrt(0.5), 0.0, 0.0, -math.sqrt(0.5))),
    ):
        plane = sapien.physx.PhysxCollisionShapePlane(_material(CUSHION_RESTITUTION))
        plane.set_collision_groups([16, CUSHIONS, 0, 0])
        cushion = sapien.physx.PhysxRigidStaticComponent()
        cushion.attach(plane)
        _add(made, cushion, x, y, turned)
    return made


def _material(restitution: float) -> Any:
    return sapien.physx.PhysxMaterial(0.0, 0.0, restitution)  # without friction


def _add(scene: Any, component: Any, x: float, y: float, turned: Any = (1, 0, 0, 0)) -> None:
    entity = sapien.Entity()
    entity.add_component(component)
    entity.set_pose(sapien.Pose([x, y, 0.0], turned))
    scene.add_entity(entity)


def add_ball(scene: Any, x: float, y: float, vx: float = 0.0) -> Any:
    """Add a ball that moves in the plane without rotation."""
    ball = sapien.physx.PhysxRigidDynamicComponent()
    # PhysX takes the mean of two restitutions. So a ball has one shape for balls and one for
    # cushions. Two shapes collide if a bit of the first group of one shape is in the second group
    # of the other shape.
    for touched, restitution, touches in (
        (BALLS, BALL_RESTITUTION, BALLS),
        (CUSHIONS, CUSHION_RESTITUTION, 8),
    ):
        shape = sapien.physx.PhysxCollisionShapeSphere(RADIUS, _material(restitution))
        shape.set_collision_groups([touched, touches, 0, 0])
        ball.attach(shape)
    ball.set_mass(MASS)
    ball.set_inertia([0.4 * MASS * RADIUS**2] * 3)  # otherwise the inertia of both shapes
    ball.set_linear_damping(0.0)
    ball.set_angular_damping(0.0)  # 0.05 by default
    _add(scene, ball, x, y)
    ball.set_locked_motion_axes([False, False, True, True, True, True])
    ball.set_linear_velocity([vx, 0.0, 0.0])
    return ball


def slow(ball: Any, seconds: float) -> bool:
    """Apply rolling friction to a ball; return whether the ball still moves."""
    x, y = (float(v) for v in ball.linear_velocity[:2])
    speed, loss = math.hypot(x, y), ROLLING_FRICTION * G * seconds
    share = (speed - loss) / speed if speed > loss else 0.0
    ball.set_linear_velocity([x * share, y * share, 0.0])
    return share > 0.0


def play() -> list[tuple[float, float]]:
    """Simulate a half-ball cut until the balls rest."""
    scene = make_scene()
    balls = [add_ball(scene, 0.5, 0.606425, 0.8), add_ball(scene, 1.0, 0.635)]
    moving = True
    while moving:
        for ball in balls:  # half the loss before the step, half after it: exact rolling
            slow(ball, 0.5 * DT)
        scene.step()
        still_moving = [slow(ball, 0.5 * DT) for ball in balls]
        moving = any(still_moving)
    places = [ball.entity_pose.p for ball in balls]
    return [(float(x), float(y)) for x, y, _ in places]


if __name__ == "__main__":
    for x, y in play():
        print(f"  {x:.9f}, {y:.9f}")
