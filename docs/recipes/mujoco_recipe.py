"""Billiards with MuJoCo 3: the settings that make it right, and what each changes.

In metres, seconds and kilograms. Run it: it plays a half-ball cut, whose balls rest in truth at
1.098066915, 0.350843120 and 1.766745641, 1.077680802.

MuJoCo has no restitution: its contacts are springs and dampers. A damper without a spring, of
(1 + e) / dt, turns the approach speed v into -e v within one step, for any restitution e.
"""

import mujoco
import numpy as np

G, ROLLING_FRICTION, BALL_RESTITUTION, CUSHION_RESTITUTION = 9.81, 0.02, 1.0, 1.0
RADIUS, MASS, LENGTH, WIDTH = 0.028575, 0.170097, 2.54, 1.27
DT = 1e-3  # contacts are seen up to a step late: this cut ends some millimetres off
SHOT = ((0.5, 0.606425, 0.8), (1.0, 0.635, 0.0))  # x, y, and the speed along x


def make_model() -> mujoco.MjModel:
    """Return a table with the balls of the shot, which slide along x and y alone."""
    spec = mujoco.MjSpec()
    spec.option.timestep = DT
    spec.option.gravity = [0.0, 0.0, 0.0]
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    spec.option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    spec.option.iterations = 200  # for racks: many contacts at once
    spec.option.tolerance = 1e-14  # else the solver stops early
    spec.option.ls_tolerance = 1e-6
    for x, y, nx, ny in (
        (0.0, 0.0, 1.0, 0.0),
        (LENGTH, 0.0, -1.0, 0.0),
        (0.0, 0.0, 0.0, 1.0),
        (0.0, WIDTH, 0.0, -1.0),
    ):
        plane = spec.worldbody.add_geom(
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=[1, 1, 1],  # for drawing: a plane has no end
            pos=[x, y, 0.0],
            quat=[1.0, -ny, nx, 0.0],  # turns its normal, z, inward
        )
        plane.priority = 1  # else MuJoCo mixes the coefficients of cushion and ball
        harden(plane, CUSHION_RESTITUTION)
    for x, y, _ in SHOT:
        body = spec.worldbody.add_body(pos=[x, y, 0.0])
        for axis in ([1, 0, 0], [0, 1, 0]):
            body.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
        ball = body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[RADIUS, 0, 0], mass=MASS)
        harden(ball, BALL_RESTITUTION)
    return spec.compile()


def harden(geom: mujoco.MjsGeom, restitution: float) -> None:
    """Make a contact a damper that bounces in one step: it is of `DT`, and changes with it."""
    geom.condim = 1  # no friction between balls
    geom.margin = 1e-9  # else balls that just touch, as in a rack, don't collide together
    geom.solref = [0.0, -(1.0 + restitution) / DT]  # by default a spring: a bounce takes 20 ms
    geom.solimp = [0.9999, 0.9999, 0.001, 0.5, 2.0]  # as hard as may be, whatever the overlap


def slow(velocities: np.ndarray, seconds: float) -> None:
    """Let the cloth slow balls that roll."""
    speeds = np.linalg.norm(velocities, axis=1, keepdims=True)
    loss = ROLLING_FRICTION * G * seconds
    velocities *= np.maximum(speeds - loss, 0.0) / np.maximum(speeds, 1e-12)


def play() -> list[tuple[float, float]]:
    """Play a half-ball cut to its end."""
    model = make_model()
    data = mujoco.MjData(model)
    velocities = data.qvel.reshape(-1, 2)  # a view: to write into it changes what MuJoCo has
    velocities[:, 0] = [speed for _, _, speed in SHOT]
    while velocities.any():
        slow(velocities, 0.5 * DT)  # half the loss before the step, half after: a roll is exact
        mujoco.mj_step(model, data)
        slow(velocities, 0.5 * DT)
    mujoco.mj_kinematics(model, data)
    return [(float(x), float(y)) for x, y in data.xpos[1:, :2]]


if __name__ == "__main__":
    for x, y in play():
        print(f"  {x:.9f}, {y:.9f}")
