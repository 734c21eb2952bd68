"""Newton 1.8, SolverXPBD: a ball that touches several others gains or loses momentum and energy.

Needs only `pip install newton`; the first run compiles for some two minutes.

Equal balls with restitution 1, without friction, gravity or damping. Expected in every case: the
momentum and the energy are those of the first ball.
"""

from typing import Any

import newton

R = 0.028575  # [m]
DT = 1e-3  # [s]


def play(places: list[tuple[float, float]], speed: float, solver: Any) -> Any:
    """Return the velocities [m/s] at 0.2 s of balls at places (x, y) [m]; the first moves in x."""
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0))
    material = newton.ModelBuilder.ShapeConfig(
        mu=0.0, mu_torsional=0.0, mu_rolling=0.0, restitution=1.0, gap=2.5e-7
    )
    for _ in places:
        builder.add_shape_sphere(builder.add_body(), radius=R, cfg=material)
    model = builder.finalize(device="cpu")
    pipeline = newton.CollisionPipeline(model)
    contacts, solves = pipeline.contacts(), solver(model)
    now, after = model.state(), model.state()
    # On the processor these are views of Newton's memory. XPBD reads the bodies, Steel the joints.
    now.body_q.numpy()[:, :2] = now.joint_q.numpy().reshape(-1, 7)[:, :2] = places
    now.body_qd.numpy()[0, 0] = now.joint_qd.numpy()[0] = speed
    for _ in range(round(0.2 / DT)):
        pipeline.collide(now, contacts)
        solves.step(now, after, None, contacts, DT)
        now, after = after, now
    return now.body_qd.numpy()[:, :3]


def xpbd(**settings: Any) -> Any:
    """Return a function that makes the solver for a model."""
    return lambda model: newton.solvers.SolverXPBD(model, enable_restitution=True, **settings)


def steel(model: Any) -> Any:
    """Return Newton's other solver with restitution, for comparison."""
    return newton.solvers.SolverSteel(model, restitution_velocity_threshold=0.0)


SHOTS = {
    "one ball, head-on": [(-0.1 - 2 * R, 0.0), (0.0, 0.0)],
    "two touching balls in line": [(-0.1 - 2 * R, 0.0), (0.0, 0.0), (2 * R, 0.0)],
    "two touching balls side by side": [(-0.1 - 3**0.5 * R, 0.0), (0.0, R), (0.0, -R)],
    "a rack of 15": [
        (-0.1 - 2 * R, 0.003),
        *(
            ((2 * R + 1e-4) * row * 0.75**0.5, (2 * R + 1e-4) * (k - row / 2))
            for row in range(5)
            for k in range(row + 1)
        ),
    ],
}
SOLVERS = {
    "SolverXPBD": xpbd(),
    "SolverXPBD, 32 restitution iterations": xpbd(rigid_contact_restitution_iterations=32),
    "SolverXPBD, rigid_contact_con_weighting False": xpbd(rigid_contact_con_weighting=False),
    "SolverSteel": steel,
}


def main() -> None:
    """Print momentum and energy after each shot, divided by those before."""
    print(f"Newton {newton.__version__}; momentum and energy after a hit at 1.5 m/s; expected 1, 1")
    for what, places in SHOTS.items():
        print(what)
        for name, solver in SOLVERS.items():
            velocities = play(places, 1.5, solver) / 1.5
            momentum, energy = velocities[:, 0].sum(), (velocities**2).sum()
            print(f"  {name:46} {momentum:8.4f} {energy:8.4f}")


if __name__ == "__main__":
    main()
