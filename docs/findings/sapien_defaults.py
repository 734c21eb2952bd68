"""SAPIEN (PhysX 5): its default settings change the energy of elastic collisions.

Needs only `pip install sapien`.

Equal balls with restitution 1, without friction, gravity or damping. Expected in every case: energy
is conserved, and a ball that hits a resting ball head-on transfers its whole speed.
"""

import warnings
from typing import Any

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import sapien

R, MASS = 0.028575, 0.17  # [m], [kg]


def play(
    places: list[tuple[float, float]],
    speed: float,
    *,
    threshold: float | None = None,
    offset: float | None = None,
    tgs: bool | None = None,
    dt: float = 1e-3,
    seconds: float = 0.2,
) -> list[Any]:
    """Return the final velocities of balls at places (x, y) [m]; the first moves along x [m/s]."""
    physx = sapien.physx
    scene, shape = physx.PhysxSceneConfig(), physx.PhysxShapeConfig()
    scene.gravity = [0, 0, 0]
    if threshold is not None:
        scene.bounce_threshold = threshold
    if tgs is not None:
        scene.enable_tgs = tgs
    if offset is not None:
        shape.contact_offset, shape.rest_offset = offset, 0.0
    # These settings belong to the process and are read when a scene and its bodies are made.
    physx.set_scene_config(scene)
    physx.set_shape_config(shape)
    world = sapien.Scene([physx.PhysxCpuSystem()])
    world.set_timestep(dt)
    material = physx.PhysxMaterial(0.0, 0.0, 1.0)
    bodies = []
    for x, y in places:
        body = physx.PhysxRigidDynamicComponent()
        body.attach(physx.PhysxCollisionShapeSphere(R, material))
        body.set_mass(MASS)
        body.set_linear_damping(0.0)
        body.set_angular_damping(0.0)
        entity = sapien.Entity()
        entity.add_component(body)
        entity.set_pose(sapien.Pose([x, y, 0]))
        world.add_entity(entity)
        bodies.append(body)
    bodies[0].set_linear_velocity([speed, 0, 0])
    for _ in range(round(seconds / dt)):
        world.step()
    return [body.linear_velocity for body in bodies]


def energy_change(velocities: list[Any], speed: float) -> float:
    """Return the relative change of the energy."""
    return float(sum(v[0] ** 2 + v[1] ** 2 + v[2] ** 2 for v in velocities)) / speed**2 - 1


def head_on(what: str, speed: float, **settings: Any) -> None:
    """Print the worst of many distances: the result depends on the phase of the time step."""
    gaps = [0.001 + 0.00097 * k for k in range(40)]
    runs = [play([(0, 0), (2 * R + gap, 0)], speed, **settings) for gap in gaps]
    worst = max(runs, key=lambda run: abs(energy_change(run, speed)))
    first, second = (float(v[0]) for v in worst)
    change = energy_change(worst, speed)
    print(f"{what:66} {first:7.4f} {second:7.4f}  energy {change:+.1e}")


def broken_rack(what: str, speed: float, **settings: Any) -> None:
    """Print the change of the energy when a ball hits a rack of 15."""
    apart = 2 * R + 1e-4
    rack = [
        (apart * row * 0.75**0.5, apart * (k - row / 2)) for row in range(5) for k in range(row + 1)
    ]
    runs = [
        play([(-2 * R - gap, 0.003), *rack], speed, **settings) for gap in (0.01, 0.0107, 0.0114)
    ]
    worst = max((energy_change(run, speed) for run in runs), key=abs)
    print(f"{what:66} {'':15}  energy {worst:+.1e}")


def main() -> None:
    """Print the results for two balls and for a rack."""
    print(f"SAPIEN {sapien.__version__}; velocities after a head-on collision, and energy")
    low = {"threshold": 1e-4}
    head_on("1.5 m/s, defaults (bounce_threshold 2 m/s)", 1.5)
    head_on("1.5 m/s, bounce_threshold 1e-4", 1.5, **low)
    head_on("1.5 m/s, bounce_threshold 1e-4, enable_tgs False", 1.5, **low, tgs=False)
    head_on("1.5 m/s, the same, contact_offset 1e-7 for 1e-2", 1.5, **low, tgs=False, offset=1e-7)
    print("a rack of 15, hit at 5 m/s")
    broken_rack("bounce_threshold 1e-4 (enable_tgs True)", 5.0, **low)
    broken_rack("bounce_threshold 1e-4, enable_tgs False", 5.0, **low, tgs=False)
    broken_rack("the same, contact_offset 1e-7", 5.0, **low, tgs=False, offset=1e-7)


if __name__ == "__main__":
    main()
