"""A scene as a PhysX scene: spheres in the plane of the table, or on a plane under gravity.

PhysX uses the mean of the coefficients of two shapes. A tuned ball therefore has three shapes in
the same place, for contacts with balls, cushions and cloth, each with the coefficients of its
contacts. SAPIEN's configuration is global and is read when a scene and its bodies are created, so
it is set for each scene.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

from ghostball.model import Disc, Scene, Segment
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.physx.engine import TUNED_ITERATIONS, PhysxSettings
from ghostball.reference_adapters.stepping.contact_world import (
    REMOVED_COORDINATE,
    SINGLE_PRECISION_NOISE,
    THICKNESS,
    ContactWorld,
    WorldBody,
    collision_of,
)
from ghostball.reference_adapters.stepping.laws import (
    ball_friction,
    cushion_friction,
    cushion_restitution,
    rubs,
)
from ghostball.reference_adapters.stepping.plane import Collision, Planned
from ghostball.reference_adapters.stepping.sides import parts_of, sides_of
from ghostball.reference_adapters.stepping.space import slowest_bounce

# SAPIEN warns about a missing graphics driver and about incomplete types.
with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import sapien


_BALLS, _CUSHIONS, _CLOTH = 1, 2, 4
"""The bodies that a shape of a ball touches, as bits."""

MAX_SPIN = 1e6
"""Limit on spins [rad/s]; PhysX's default of 100 would limit a rolling pool ball to 2.86 m/s."""


class PhysxWorld(ContactWorld):
    """A scene with its balls in the order of the scene, and the collisions of its last step.

    `on_cloth`: as in `SpaceWorld`.
    """

    def __init__(self, scene: Scene, settings: PhysxSettings, *, own_cloth: bool) -> None:
        super().__init__(scene, noise=SINGLE_PRECISION_NOISE, rubs=rubs(scene) or own_cloth)
        self._tuned = settings.config == "tuned"
        self._own_cloth = own_cloth
        self._parts: dict[Any, WorldBody] = {}
        self.on_cloth: set[int] = set()
        self._cloth: Any = None
        self._configure(settings)
        self._physx = sapien.physx.PhysxCpuSystem()
        self._scene_of = sapien.Scene([self._physx])
        self._dt = math.nan
        self._add_bodies()

    def start(self, velocities: FloatArray, spins: FloatArray | None) -> FloatArray:
        """Set the velocities, (n, 2) [m/s], and spins, (n, 3) [rad/s], of the balls for a step."""
        (planned,) = self.planned(velocities[np.newaxis])
        self.start_planned(planned)
        if spins is not None:
            for body, spin in zip(self._bodies, spins.tolist(), strict=True):
                body.set_angular_velocity(spin)
                x, y, z = body.entity_pose.p
                if z != 0.0:  # back to the plane
                    body.set_entity_pose(sapien.Pose([x, y, 0.0]))
            self._start = self._angular()
        return self._given

    def planned(self, velocities: FloatArray) -> Sequence[Planned]:
        """Return the velocities of coming steps, (k, n, 2) [m/s]; see `PlaneWorld`."""
        spatial = np.zeros((*velocities.shape[:2], 3), dtype=np.float32)
        spatial[..., :2] = velocities
        given = spatial[..., :2].astype(np.float64)
        return list(zip(given, map(list, spatial), strict=True))

    def start_planned(self, planned: Planned) -> None:
        """Set the velocities of the balls for a step."""
        self._given, velocities = planned
        for body, velocity in zip(self._bodies, velocities, strict=True):
            body.set_linear_velocity(velocity)

    def advance(self, dt: float) -> None:
        """Advance PhysX by `dt` [s]: it finds contacts, solves velocities, then moves."""
        if dt != self._dt:
            self._physx.set_timestep(dt)
            self._dt = dt
        self._physx.step()

    def read_contacts(self, dt: float) -> None:  # noqa: ARG002
        """Store the collisions of the last step, of `dt` [s]."""
        pushing: set[Collision] = set()
        near: set[Collision] = set()
        self.on_cloth = set()
        for contact in self._physx.get_contacts():
            impulse = sum(float(np.linalg.norm(point.impulse)) for point in contact.points)
            entities = [body.entity for body in contact.bodies]
            parts = [self._parts[entity] for entity in entities if entity != self._cloth]
            if len(parts) == 2:
                (pushing if impulse > self._noise else near).add(collision_of(*parts))
            elif impulse > self._noise:
                self.on_cloth.add(parts[0][0])
        self.touched = bool(pushing) or not self._tuned
        self._note(pushing, near)

    def positions_and_velocities(self) -> tuple[FloatArray, FloatArray]:
        """Return the centres [m] and velocities [m/s], two arrays (n, 2) float64."""
        return self._centres()[:, :2], self._kept(self._linear()[:, :2])

    def turns(self) -> FloatArray:
        """Return the spin changes by the contacts of the step, (n, 3) [rad/s]."""
        return self._turned(self._angular())

    def motion(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return centres [m], velocities [m/s] and spins [rad/s], three arrays (n, 3)."""
        return self._centres(), self._linear(), self._angular()

    def set_motion(self, velocities: FloatArray, spins: FloatArray) -> None:
        """Set the velocities [m/s] and spins [rad/s], two arrays (n, 3)."""
        for body, velocity, spin in zip(
            self._bodies, velocities.tolist(), spins.tolist(), strict=True
        ):
            body.set_linear_velocity(velocity)
            body.set_angular_velocity(spin)

    def remove(self, ball: int) -> None:
        """Move a ball to a place that nothing can reach; it stays in the list."""
        self._bodies[ball].set_entity_pose(sapien.Pose([REMOVED_COORDINATE * (ball + 1), 0.0, 0.0]))

    def _centres(self) -> FloatArray:
        return np.array([body.entity_pose.p for body in self._bodies], dtype=np.float64)

    def _linear(self) -> FloatArray:
        return np.array([body.linear_velocity for body in self._bodies], dtype=np.float64)

    def _angular(self) -> FloatArray:
        return np.array([body.angular_velocity for body in self._bodies], dtype=np.float64)

    def _configure(self, settings: PhysxSettings) -> None:
        physx = sapien.physx
        scene, shape, body = (
            physx.PhysxSceneConfig(),
            physx.PhysxShapeConfig(),
            physx.PhysxBodyConfig(),
        )
        scene.gravity = [0.0, 0.0, -self._scene.physics.gravity if self._own_cloth else 0.0]
        scene.enable_tgs = settings.temporal
        if self._tuned:
            slowest = slowest_bounce(self._scene, settings.step)
            scene.bounce_threshold = slowest if self._scene.physics.airborne else 1e-4
            shape.contact_offset = (
                1e-7  # closer balls would be stopped at the contact without bouncing
            )
            shape.rest_offset = 0.0
            body.sleep_threshold = 0.0
            if not settings.temporal:
                body.solver_position_iterations = TUNED_ITERATIONS
        if settings.iterations is not None:
            body.solver_position_iterations = settings.iterations
        self.iterations = int(body.solver_position_iterations)
        physx.set_scene_config(scene)
        physx.set_shape_config(shape)
        physx.set_body_config(body)

    def _add_bodies(self) -> None:
        physics = self._scene.physics
        friction = ball_friction(self._scene)
        physx = sapien.physx
        materials = {
            touched: physx.PhysxMaterial(mu, mu, e)
            for touched, mu, e in (
                (_BALLS, friction, physics.ball_restitution),
                (_CUSHIONS, cushion_friction(physics), cushion_restitution(physics)),
                (
                    _CLOTH,
                    float(self._scene.sliding_frictions[0]),
                    physics.table_restitution if physics.airborne else 0.0,
                ),
            )
        }
        self._bodies = [self._ball(i, materials) for i in range(len(self._scene.balls))]
        for side in sides_of(self._scene):
            normal, point = (*side.normal, 0.0), (*side.point, 0.0)
            entity = self._plane(normal, point, materials[_CUSHIONS], _CUSHIONS)
            self._parts[entity] = side.cushion, True
        height = float(self._scene.radii[0]) if self._own_cloth else 0.0
        for part in parts_of(self._scene):
            self._parts[self._part(part, height, materials[_CUSHIONS])] = part.obstacle, True
        if self._own_cloth:
            self._cloth = self._plane((0.0, 0.0, 1.0), (0, 0, 0), materials[_CLOTH], _CLOTH)

    def _ball(self, i: int, materials: dict[int, Any]) -> Any:
        ball = self._scene.balls[i]
        body = sapien.physx.PhysxRigidDynamicComponent()
        for touched, material in materials.items() if self._tuned else ((0, materials[_BALLS]),):
            shape = sapien.physx.PhysxCollisionShapeSphere(ball.radius, material)
            if self._tuned:
                # Two shapes touch if the first mask of one has a bit of the second mask of the
                # other.
                shape.set_collision_groups([touched, 1 if touched == _BALLS else 8, 0, 0])
            body.attach(shape)
        body.set_mass(ball.mass)
        body.set_inertia([0.4 * ball.mass * ball.radius**2] * 3)
        if self._tuned:
            body.set_linear_damping(0.0)
            body.set_angular_damping(0.0)
            body.set_max_angular_velocity(MAX_SPIN)
        x, y, z = ball.position
        entity = self._add(body, [x, y, z if self._own_cloth else 0.0])
        if not self.rubs:
            body.set_locked_motion_axes([False, False, True, True, True, True])
        self._parts[entity] = i, False
        return body

    def _plane(
        self,
        normal: tuple[float, float, float],
        point: tuple[float, float, float],
        material: Any,
        touched: int,
    ) -> Any:
        """Add a plane; in PhysX, the normal of a plane is along x."""
        turned = np.array([1.0 + normal[0], 0.0, -normal[2], normal[1]])
        if normal[0] == -1.0:
            turned = np.array([0.0, 0.0, 0.0, 1.0])
        shape = sapien.physx.PhysxCollisionShapePlane(material)
        return self._fixed(shape, touched, point, turned / np.linalg.norm(turned))

    def _part(self, part: Segment | Disc, height: float, material: Any) -> Any:
        """Add a cushion segment or a disc, centred at a height [m]."""
        if isinstance(part, Disc):
            shape = sapien.physx.PhysxCollisionShapeSphere(part.radius, material)
            return self._fixed(shape, _CUSHIONS, [*part.centre, height])
        (x0, y0), (x1, y1) = part.start, part.end
        half = 0.5 * math.dist(part.start, part.end)
        angle = 0.5 * math.atan2(y1 - y0, x1 - x0)
        size = [half, THICKNESS, 2.0 * float(np.max(self._scene.radii))]
        shape = sapien.physx.PhysxCollisionShapeBox(size, material)
        turned = np.array([math.cos(angle), 0.0, 0.0, math.sin(angle)])
        place = [0.5 * (x0 + x1), 0.5 * (y0 + y1), height]
        return self._fixed(shape, _CUSHIONS, place, turned)

    def _fixed(self, shape: Any, touched: int, place: Any, *turned: Any) -> Any:
        body = sapien.physx.PhysxRigidStaticComponent()
        if self._tuned:
            shape.set_collision_groups([16, touched, 0, 0])
        body.attach(shape)
        return self._add(body, place, *turned)

    def _add(self, body: Any, place: Any, turned: Any = (1.0, 0.0, 0.0, 0.0)) -> Any:
        entity = sapien.Entity()
        entity.add_component(body)
        entity.set_pose(sapien.Pose(place, turned))
        self._scene_of.add_entity(entity)
        return entity
