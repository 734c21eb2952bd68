"""Billiards with pybullet 3.2: the best settings, and the effect of each.

In metres, seconds and kilograms. Run it: it simulates a half-ball cut, whose exact rest positions
are 1.098066916, 0.350843120 and 1.766745641, 1.077680802.

Balls roll in the plane, without gravity and without a table under them; `slow` applies rolling
friction. (A table under the balls costs precision, and only flights need it.)
"""

import math

import pybullet

G, ROLLING_FRICTION, BALL_RESTITUTION, CUSHION_RESTITUTION = 9.81, 0.02, 1.0, 1.0
RADIUS, MASS, LENGTH, WIDTH = 0.028575, 0.170097, 2.54, 1.27
DT = 1e-3  # contacts are detected up to a step late: an error of 4 mm here; the default is 1/240


def make_table() -> None:
    """Connect, and build a table without balls."""
    pybullet.connect(pybullet.DIRECT)
    pybullet.setTimeStep(DT)
    pybullet.setPhysicsEngineParameter(
        contactERP=0.0,  # otherwise overlapping balls are pushed apart: 4 % of energy per impact
        erp=0.0,
        frictionERP=0.0,
        contactSlop=0.0,
        restitutionVelocityThreshold=0.0,  # otherwise impacts below 0.2 m/s are inelastic
        solverResidualThreshold=0.0,  # otherwise the solver stops early
        numSolverIterations=50,  # for racks: many contacts at once
        numSubSteps=0,  # contacts within a substep are never reported
        deterministicOverlappingPairs=1,  # otherwise two runs differ
    )
    for point, normal in (
        ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
        ((LENGTH, 0.0, 0.0), (-1.0, 0.0, 0.0)),
        ((0.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
        ((0.0, WIDTH, 0.0), (0.0, -1.0, 0.0)),
    ):
        shape = pybullet.createCollisionShape(pybullet.GEOM_PLANE, planeNormal=normal)
        body = pybullet.createMultiBody(0.0, shape, basePosition=point)
        # Bullet multiplies the restitutions of two bodies: a ball has the root of the pair's value.
        bounce = CUSHION_RESTITUTION / math.sqrt(BALL_RESTITUTION)
        pybullet.changeDynamics(body, -1, restitution=bounce, lateralFriction=0.0)
        # Otherwise Bullet stops a ball at the cushion one step before it arrives.
        pybullet.changeDynamics(body, -1, contactProcessingThreshold=0.0)


def add_ball(x: float, y: float, vx: float = 0.0, vy: float = 0.0) -> int:
    """Add a ball that rolls without slip."""
    shape = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=RADIUS)
    ball: int = pybullet.createMultiBody(MASS, shape, basePosition=(x, y, 0.0))
    pybullet.changeDynamics(
        ball,
        -1,
        restitution=math.sqrt(BALL_RESTITUTION),
        lateralFriction=0.0,
        linearDamping=0.0,  # otherwise a ball loses 4 % of its speed each second
        angularDamping=0.0,
        maxJointVelocity=1e100,  # otherwise the limit is 100 rad/s: 2.86 m/s for a pool ball
    )
    pybullet.resetBaseVelocity(ball, (vx, vy, 0.0))
    return ball


def slow(ball: int, seconds: float) -> bool:
    """Apply rolling friction to a ball; return whether the ball still moves."""
    (x, y, _), _ = pybullet.getBaseVelocity(ball)
    speed, loss = math.hypot(x, y), ROLLING_FRICTION * G * seconds
    share = (speed - loss) / speed if speed > loss else 0.0
    pybullet.resetBaseVelocity(ball, (x * share, y * share, 0.0), (0.0, 0.0, 0.0))
    return share > 0.0


def play() -> list[tuple[float, float]]:
    """Simulate a half-ball cut until the balls rest."""
    make_table()
    balls = [add_ball(0.5, 0.606425, 0.8), add_ball(1.0, 0.635)]
    moving = True
    while moving:
        for ball in balls:  # half the loss before the step, half after it: exact rolling
            slow(ball, 0.5 * DT)
        pybullet.stepSimulation()
        still_moving = [slow(ball, 0.5 * DT) for ball in balls]
        moving = any(still_moving)
    places = [pybullet.getBasePositionAndOrientation(ball)[0][:2] for ball in balls]
    pybullet.disconnect()
    return places


if __name__ == "__main__":
    for x, y in play():
        print(f"  {x:.9f}, {y:.9f}")
