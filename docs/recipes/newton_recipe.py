"""Billiards with Newton 1.8 on the processor: the best settings, and the reason for each.

In metres, seconds and kilograms. Run it: it simulates a half-ball cut, whose exact rest positions
are 1.098066916, 0.350843120 and 1.766745641, 1.077680802. The first run compiles for minutes.
"""

from typing import Any

import newton
import numpy as np
import warp

warp.config.log_level = warp.LOG_ERROR  # otherwise each kernel is printed

G, ROLLING_FRICTION, BALL_RESTITUTION, CUSHION_RESTITUTION = 9.81, 0.02, 1.0, 1.0
RADIUS, MASS, LENGTH, WIDTH = 0.028575, 0.170097, 2.54, 1.27
DT = 1e-3  # contacts are detected up to a step late: an error of some mm in this cut


def material(restitution: float) -> Any:
    """Return a material without friction."""
    return newton.ModelBuilder.ShapeConfig(
        density=0.0,  # the mass is set for the body
        mu=0.0,
        mu_torsional=0.0,
        mu_rolling=0.0,
        gap=2.5e-7,  # 0.1 by default: contacts have the normal from before the balls touched
        restitution=restitution,
    )


def add_ball(builder: Any, x: float, y: float) -> None:
    """Add a ball in the plane z = 0."""
    moment = 0.4 * MASS * RADIUS**2
    body = builder.add_body(
        xform=warp.transform((x, y, 0.0), warp.quat_identity()),
        mass=MASS,
        inertia=warp.mat33(np.diag([moment] * 3)),
    )
    # Newton takes the mean of two restitutions. So a ball has one shape for balls and one for
    # cushions.
    builder.add_shape_sphere(body, radius=RADIUS, cfg=material(BALL_RESTITUTION))
    builder.add_shape_sphere(body, radius=RADIUS, cfg=material(CUSHION_RESTITUTION))


def make_model(places: list[tuple[float, float]]) -> tuple[Any, list[tuple[int, int]]]:
    """Return a table with balls, and the pairs of shapes that can touch."""
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0))
    for x, y in places:
        add_ball(builder, x, y)
    n = len(places)
    pairs = [(2 * i, 2 * j) for i in range(n) for j in range(i + 1, n)]
    for x, y, offset in ((1.0, 0.0, 0.0), (-1.0, 0.0, LENGTH), (0.0, 1.0, 0.0), (0.0, -1.0, WIDTH)):
        cushion = builder.add_shape_plane(
            plane=(x, y, 0.0, offset), width=0.0, length=0.0, cfg=material(CUSHION_RESTITUTION)
        )
        pairs += [(2 * i + 1, cushion) for i in range(n)]
    return builder.finalize(device="cpu"), pairs


def slow(motion: Any, seconds: float) -> None:
    """Apply rolling friction to the balls, whose velocities are the first columns of `motion`."""
    speeds = np.linalg.norm(motion[:, :2], axis=1, keepdims=True)
    loss = ROLLING_FRICTION * G * seconds
    motion[:, :2] *= np.where(speeds > loss, 1.0 - loss / np.maximum(speeds, loss), 0.0)


def play() -> list[tuple[float, float]]:
    """Simulate a half-ball cut until the balls rest."""
    model, pairs = make_model([(0.5, 0.606425), (1.0, 0.635)])
    pipeline = newton.CollisionPipeline(
        model,
        broad_phase="explicit",
        rigid_contact_max=len(pairs),  # 1000 by default: slower steps
        shape_pairs_filtered=warp.array(pairs, dtype=warp.vec2i, device="cpu"),
    )
    contacts = pipeline.contacts()
    solver = newton.solvers.SolverSteel(  # SolverXPBD gains energy if a ball touches several others
        model,
        iterations=64,  # 12 by default
        friction_anchor_beta=0.0,  # without patches of friction: steps are four times as fast
        baumgarte=0.0,  # otherwise overlapping balls that separate slowly gain speed
        cfm=0.0,  # otherwise impulses are too small
        restitution_velocity_threshold=0.0,  # 0.5 m/s by default: slower balls don't bounce
    )
    now, after = model.state(), model.state()

    def step() -> None:
        pipeline.collide(now, contacts)
        solver.step(now, after, None, contacts, DT)
        for name in ("joint_q", "joint_qd", "body_q", "body_qd"):
            warp.copy(getattr(now, name), getattr(after, name))

    step()  # loads the kernels; the balls are still at rest
    with warp.ScopedCapture(device="cpu") as recorded:  # twenty times faster than from Python
        step()
    motion = now.joint_qd.numpy().reshape(-1, 6)  # on the processor: no copy
    motion[0, 0] = 0.8
    while motion[:, :2].any():
        slow(motion, 0.5 * DT)  # half the loss before the step, half after it: exact rolling
        warp.capture_launch(recorded.graph)
        slow(motion, 0.5 * DT)
    return [(float(x), float(y)) for x, y in now.body_q.numpy()[:, :2]]


if __name__ == "__main__":
    for x, y in play():
        print(f"  {x:.9f}, {y:.9f}")
