"""SAPIEN (PhysX 5): what its defaults do to elastic collisions.

Needs `pip install sapien`, no more.

Equal balls with restitution 1, without friction, gravity or damping. Expected in every case: no
energy is lost or gained, and a ball that hits another head-on gives it all its speed.
"""

import warnings

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import sapien

R, MASS = 0.028575, 0.17  # [m], [kg]


def play(places, speed, *, threshold=None, offset=None, tgs=None, dt=1e-3, seconds=0.2):
    """Return the velocities of balls at places (x, y) [m]; the first comes along x [m/s]."""
    physx = sapien.physx
    scene, shape = physx.PhysxSceneConfig(), physx.PhysxShapeConfig()
    scene.gravity = [0, 0, 0]
    if threshold is not None:
        scene.bounce_threshold = threshold
    if tgs is not None:
        scene.enable_tgs = tgs
    if offset is not None:
        shape.contact_offset, shape.rest_offset = offset, 0.0
    # Of the whole process, and read as a scene and its bodies are made.
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


def energy_change(velocities, speed):
    """Return what became of the energy, over what it was, less 1."""
    return float(sum(v[0] ** 2 + v[1] ** 2 + v[2] ** 2 for v in velocities)) / speed**2 - 1


def head_on(what, speed, **settings):
    """Print the worst of many distances, for it depends on where in a step the balls meet."""
    gaps = [0.001 + 0.00097 * k for k in range(40)]
    runs = [play([(0, 0), (2 * R + gap, 0)], speed, **settings) for gap in gaps]
    worst = max(runs, key=lambda run: abs(energy_change(run, speed)))
    first, second = (float(v[0]) for v in worst)
    change = energy_change(worst, speed)
    print(f"{what:66} {first:7.4f} {second:7.4f}  energy {change:+.1e}")


def broken_rack(what, speed, **settings):
    """Print what becomes of the energy as a ball hits a rack of 15."""
    apart = 2 * R + 1e-4
    rack = [
        (apart * row * 0.75**0.5, apart * (k - row / 2)) for row in range(5) for k in range(row + 1)
    ]
    runs = [
        play([(-2 * R - gap, 0.003), *rack], speed, **settings) for gap in (0.01, 0.0107, 0.0114)
    ]
    worst = max((energy_change(run, speed) for run in runs), key=abs)
    print(f"{what:66} {'':15}  energy {worst:+.1e}")


def main():
    """Print what becomes of two balls and of a rack."""
    print(
        f"SAPIEN {sapien.__version__}; velocities of two balls after a head-on hit, and the energy"
    )
    low = {"threshold": 1e-4}
    head_on("1.5 m/s, defaults (bounce_threshold 2 m/s)", 1.5)
    head_on("1.5 m/s, bounce_threshold 1e-4", 1.5, **low)
    head_on("1.5 m/s, bounce_threshold 1e-4, enable_tgs False", 1.5, **low, tgs=False)
    head_on("1.5 m/s, the same, contact_offset 1e-7 for 1e-2", 1.5, **low, tgs=False, offset=1e-7)
    print("a rack of 15 that is hit at 5 m/s")
    broken_rack("bounce_threshold 1e-4 (enable_tgs True)", 5.0, **low)
    broken_rack("bounce_threshold 1e-4, enable_tgs False", 5.0, **low, tgs=False)
    broken_rack("the same, contact_offset 1e-7", 5.0, **low, tgs=False, offset=1e-7)


if __name__ == "__main__":
    main()
