"""Billiards with pybullet 3.2: the settings that make it right, and what each changes.

In metres, seconds and kilograms. Run it: it plays a half-ball cut, whose balls rest in truth at
1.098066915, 0.350843120 and 1.766745641, 1.077680802.

Balls roll in the plane, without gravity and without a table under them: what the cloth does is
`slow`. (A table under the balls costs precision, and is needed for flight alone.)
"""

import math

import pybullet

G, ROLLING_FRICTION, BALL_RESTITUTION, CUSHION_RESTITUTION = 9.81, 0.02, 1.0, 1.0
RADIUS, MASS, LENGTH, WIDTH = 0.028575, 0.170097, 2.54, 1.27
DT = 1e-3  # contacts are seen up to a step late: this cut ends 4 mm off; by default DT is 1/240


def make_table() -> None:
    """Connect, and build a table without balls."""
    pybullet.connect(pybullet.DIRECT)
    pybullet.setTimeStep(DT)
    pybullet.setPhysicsEngineParameter(
        contactERP=0.0,  # else balls that overlap are pushed apart: 4 % of energy at each impact
        erp=0.0,
        frictionERP=0.0,
        contactSlop=0.0,
        restitutionVelocityThreshold=0.0,  # else impacts below 0.2 m/s don't bounce at all
        solverResidualThreshold=0.0,  # else the solver stops early
        numSolverIterations=50,  # for racks: many contacts at once
        numSubSteps=0,  # contacts inside a substep are never reported
        deterministicOverlappingPairs=1,  # else two runs differ
    )
    for point, normal in (
        ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
        ((LENGTH, 0.0, 0.0), (-1.0, 0.0, 0.0)),
        ((0.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
        ((0.0, WIDTH, 0.0), (0.0, -1.0, 0.0)),
    ):
        shape = pybullet.createCollisionShape(pybullet.GEOM_PLANE, planeNormal=normal)
        body = pybullet.createMultiBody(0.0, shape, basePosition=point)
        # Bullet multiplies the restitutions of two bodies: a ball has the root of that of two.
        bounce = CUSHION_RESTITUTION / math.sqrt(BALL_RESTITUTION)
        pybullet.changeDynamics(body, -1, restitution=bounce, lateralFriction=0.0)
        # Else a ball is stopped at the cushion in the step before it gets there.
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
        linearDamping=0.0,  # else 4 % of its speed is lost each second
        angularDamping=0.0,
        maxJointVelocity=1e100,  # else 100 rad/s is the limit: a pool ball stays below 2.86 m/s
    )
    pybullet.resetBaseVelocity(ball, (vx, vy, 0.0))
    return ball


def slow(ball: int, seconds: float) -> bool:
    """Let the cloth slow a ball; return whether it still moves."""
    (x, y, _), _ = pybullet.getBaseVelocity(ball)
    speed, loss = math.hypot(x, y), ROLLING_FRICTION * G * seconds
    share = (speed - loss) / speed if speed > loss else 0.0
    pybullet.resetBaseVelocity(ball, (x * share, y * share, 0.0), (0.0, 0.0, 0.0))
    return share > 0.0


def play() -> list[tuple[float, float]]:
    """Play a half-ball cut to its end."""
    make_table()
    balls = [add_ball(0.5, 0.606425, 0.8), add_ball(1.0, 0.635)]
    moving = True
    while moving:
        for ball in balls:  # half the loss before the step, half after it: so a roll is exact
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
