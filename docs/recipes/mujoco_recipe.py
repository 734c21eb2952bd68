"""Billiards with MuJoCo 4: the best settings, and the effect of each.

In metres, seconds and kilograms. Run it: it simulates a half-ball cut, whose exact rest positions
are 1.098066916, 0.350843120 and 1.766745641, 1.077680802.

MuJoCo has no restitution: its contacts are springs and dampers. A damper without a spring, of
(1 + e) / dt, turns the approach speed v into -e v within one step, for any restitution e.
"""

import mujoco
import numpy as np

G, ROLLING_FRICTION, BALL_RESTITUTION, CUSHION_RESTITUTION = 9.81, 0.02, 1.0, 1.0
RADIUS, MASS, LENGTH, WIDTH = 0.028575, 0.170097, 2.54, 1.27
DT = 1e-3  # contacts are detected up to a step late: an error of some mm in this cut
SHOT = ((0.5, 0.606425, 0.8), (1.0, 0.635, 0.0))  # x, y, and the speed along x


def make_model() -> mujoco.MjModel:
    """Return a table with the balls of the shot, which move only along x and y."""
    spec = mujoco.MjSpec()
    spec.option.timestep = DT
    spec.option.gravity = [0.0, 0.0, 0.0]
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    spec.option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    spec.option.iterations = 200  # for racks: many contacts at once
    spec.option.tolerance = 1e-14  # otherwise the solver stops early
    spec.option.ls_tolerance = 1e-6
    for x, y, nx, ny in (
        (0.0, 0.0, 1.0, 0.0),
        (LENGTH, 0.0, -1.0, 0.0),
        (0.0, 0.0, 0.0, 1.0),
        (0.0, WIDTH, 0.0, -1.0),
    ):
        plane = spec.worldbody.add_geom(
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=[1, 1, 1],  # for drawing only: a plane is infinite
            pos=[x, y, 0.0],
            quat=[1.0, -ny, nx, 0.0],  # turns its normal, z, inward
        )
        plane.priority = 1  # otherwise MuJoCo mixes the coefficients of cushion and ball
        harden(plane, CUSHION_RESTITUTION)
    for x, y, _ in SHOT:
        body = spec.worldbody.add_body(pos=[x, y, 0.0])
        for axis in ([1, 0, 0], [0, 1, 0]):
            body.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
        ball = body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[RADIUS, 0, 0], mass=MASS)
        harden(ball, BALL_RESTITUTION)
    return spec.compile()


def harden(geom: mujoco.MjsGeom, restitution: float) -> None:
    """Make a contact a damper that acts in one step; its constant depends on `DT`."""
    geom.condim = 1  # no friction between balls
    geom.margin = 1e-9  # otherwise touching balls of a rack don't collide at the same time
    geom.solref = [0.0, -(1.0 + restitution) / DT]  # the default is a spring: a contact takes 20 ms
    geom.solimp = [0.9999, 0.9999, 0.001, 0.5, 2.0]  # as hard as possible, at any overlap


def slow(velocities: np.ndarray, seconds: float) -> None:
    """Apply rolling friction to the balls."""
    speeds = np.linalg.norm(velocities, axis=1, keepdims=True)
    loss = ROLLING_FRICTION * G * seconds
    velocities *= np.maximum(speeds - loss, 0.0) / np.maximum(speeds, 1e-12)


def play() -> list[tuple[float, float]]:
    """Simulate a half-ball cut until the balls rest."""
    model = make_model()
    data = mujoco.MjData(model)
    velocities = data.qvel.reshape(-1, 2)  # a view: writing into it changes MuJoCo's velocities
    velocities[:, 0] = [speed for _, _, speed in SHOT]
    while velocities.any():
        slow(velocities, 0.5 * DT)  # half the loss before the step, half after: exact rolling
        mujoco.mj_step(model, data)
        slow(velocities, 0.5 * DT)
    mujoco.mj_kinematics(model, data)
    return [(float(x), float(y)) for x, y in data.xpos[1:, :2]]


if __name__ == "__main__":
    for x, y in play():
        print(f"  {x:.9f}, {y:.9f}")
