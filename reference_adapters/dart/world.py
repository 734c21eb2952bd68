"""A scene as a DART world: spheres in the plane of the table, or on a plane under gravity.

DART multiplies the restitutions of two bodies, so the restitution is split into factors, and uses
the smaller of their friction coefficients. The unit of length is defined in `dart.engine`.
"""

from __future__ import annotations

import math
from typing import Any

import dartpy
import numpy as np

from ghostball.model import Disc, Scene, Segment
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.dart.engine import DartSettings
from ghostball.reference_adapters.stepping.contact_world import (
    DOUBLE_PRECISION_NOISE,
    ContactWorld,
    WorldBody,
    collision_of,
)
from ghostball.reference_adapters.stepping.laws import (
    ball_friction,
    cushion_friction,
    multiplied_restitutions,
    restitutions,
    rubs,
)
from ghostball.reference_adapters.stepping.plane import Collision
from ghostball.reference_adapters.stepping.sides import parts_of, sides_of

_CLOTH = "cloth"

THICKNESS = 1e-9
"""Half the thickness of a cushion segment [m]: DART has no finite plane, so it is a thin box."""


class DartWorld(ContactWorld):
    """A world with its balls in the order of the scene, and the collisions of its last step.

    `on_cloth`: as in `SpaceWorld`.
    """

    iterations = 0  # a direct solver

    def __init__(self, scene: Scene, settings: DartSettings, *, own_cloth: bool) -> None:
        rubbing = rubs(scene) or own_cloth
        super().__init__(
            scene, noise=DOUBLE_PRECISION_NOISE, rubs=rubbing, units=settings.units(scene)
        )
        self._skeletons: list[Any] = []
        self._own_cloth, self._height = own_cloth, float(np.max(scene.radii))
        self._names: dict[str, WorldBody] = {}
        self.on_cloth: set[int] = set()
        physics, split = scene.physics, settings.config == "tuned"
        self._world = dartpy.simulation.World()
        self._world.setGravity([0.0, 0.0, -physics.gravity * self._units if own_cloth else 0.0])
        factors = multiplied_restitutions if split else restitutions
        ball_factor, cushion_factor = factors(physics)
        friction = ball_friction(scene)
        # DART uses the smaller of two coefficients: a ball's coefficient limits all its contacts.
        most = max(friction, cushion_friction(physics), float(np.max(scene.sliding_frictions)))
        rub = most if len(scene.balls) == 1 else friction
        self._bodies = [
            self._ball(i, ball_factor, rub, own_cloth=own_cloth) for i in range(len(scene.balls))
        ]
        laws = cushion_factor, cushion_friction(physics)
        for side in sides_of(scene):
            self._names[f"cushion {side.cushion}"] = side.cushion, True
            normal, point = (*side.normal, 0.0), (*side.point, 0.0)
            self._plane(f"cushion {side.cushion}", normal, point, *laws)
        for k, part in enumerate(parts_of(scene)):
            self._names[f"part {k}"] = part.obstacle, True
            self._part(f"part {k}", part, *laws)
        if own_cloth:
            bounce = physics.table_restitution / ball_factor if physics.airborne else 0.0
            self._plane(_CLOTH, (0.0, 0.0, 1.0), (0.0, 0.0, 0.0), bounce, most)

    def start(self, velocities: FloatArray, spins: FloatArray | None) -> FloatArray:
        """Set the velocities, (n, 2) [m/s], and spins, (n, 3) [rad/s], of the balls for a step."""
        self._given = velocities
        if spins is None:
            for (joint, _), velocity in zip(self._bodies, velocities * self._units, strict=True):
                joint.setVelocities(velocity)
            return velocities
        self._start = spins
        spatial = np.zeros((len(velocities), 3))
        spatial[:, :2] = velocities
        centres, _, _ = self.motion()
        centres[:, 2] = 0.0  # back to the plane
        self._set_motion(centres, spatial, spins)
        return velocities

    def advance(self, dt: float) -> None:
        """Advance DART by `dt` [s]: it finds contacts, solves velocities, then moves."""
        if dt != self._world.getTimeStep():
            self._world.setTimeStep(dt)
        self._world.step()

    def read_contacts(self, dt: float) -> None:
        """Store the collisions of the last step, of `dt` [s]."""
        pushing: set[Collision] = set()
        self.on_cloth = set()
        for contact in self._world.getLastCollisionResult().getContacts():
            if not np.linalg.norm(contact.force) * dt > self._noise:
                continue
            parts = self._parts(contact)
            if len(parts) == 1:
                self.on_cloth.add(parts[0][0])
            else:
                pushing.add(collision_of(*parts))
        self.touched = bool(pushing)
        self._note(pushing)

    def positions_and_velocities(self) -> tuple[FloatArray, FloatArray]:
        """Return the centres [m] and velocities [m/s], two arrays (n, 2) float64."""
        if self.rubs:
            centres, velocities, _ = self.motion()
            centres, velocities = centres[:, :2], velocities[:, :2]
        else:
            centres = np.array([joint.getPositions() for joint, _ in self._bodies]) / self._units
            motions = np.array([joint.getVelocities() for joint, _ in self._bodies])
            velocities = motions / self._units
        return centres, self._kept(velocities)

    def turns(self) -> FloatArray:
        """Return the spin changes by the contacts of the step, (n, 3) [rad/s]."""
        return self._turned(self.motion()[2])

    def motion(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return centres [m], velocities [m/s] and spins [rad/s], three arrays (n, 3)."""
        centres = np.array([joint.getPositions()[3:] for joint, _ in self._bodies]) / self._units
        velocities = np.array([body.getLinearVelocity() for _, body in self._bodies])
        spins = np.array([body.getAngularVelocity() for _, body in self._bodies])
        return centres, velocities / self._units, spins

    def set_motion(self, velocities: FloatArray, spins: FloatArray) -> None:
        """Set the velocities [m/s] and spins [rad/s], two arrays (n, 3)."""
        self._set_motion(self.motion()[0], velocities, spins)

    def _set_motion(self, centres: FloatArray, velocities: FloatArray, spins: FloatArray) -> None:
        """Set the motion and reset the rotation: DART's velocities are in the ball's frame."""
        places = np.hstack([np.zeros_like(centres), centres * self._units])
        motions = np.hstack([spins, velocities * self._units])
        for (joint, _), place, motion in zip(self._bodies, places, motions, strict=True):
            joint.setPositions(place)
            joint.setVelocities(motion)

    def remove(self, ball: int) -> None:
        """Remove a ball from the world; it stays in the list."""
        self._world.removeSkeleton(self._skeletons[ball])

    def _parts(self, contact: Any) -> list[WorldBody]:
        """Return the balls and cushions of a contact, without the cloth."""
        sides = (contact.collisionObject1, contact.collisionObject2)
        names = (side.getShapeFrame().getName() for side in sides)
        return [self._names[name] for name in names if name != _CLOTH]

    def _ball(self, i: int, restitution: float, friction: float, *, own_cloth: bool) -> Any:
        ball, units = self._scene.balls[i], self._units
        skeleton = dartpy.dynamics.Skeleton(f"ball {i}")
        if self.rubs:
            joint, body = skeleton.createFreeJointAndBodyNodePair()
        else:
            joint, body = skeleton.createTranslationalJoint2DAndBodyNodePair()
        radius = units * ball.radius
        self._shape(body, dartpy.dynamics.SphereShape(radius), f"ball {i}", restitution, friction)
        self._names[f"ball {i}"] = i, False
        moment = 0.4 * ball.mass * radius**2
        body.setInertia(dartpy.dynamics.Inertia(ball.mass, np.zeros(3), moment * np.eye(3)))
        x, y, height = units * np.array(ball.position)
        if not own_cloth:
            height = 0.0
        joint.setPositions(
            np.array([0.0, 0.0, 0.0, x, y, height]) if self.rubs else np.array([x, y])
        )
        self._world.addSkeleton(skeleton)
        self._skeletons.append(skeleton)
        return joint, body

    def _plane(
        self,
        name: str,
        normal: tuple[float, float, float],
        point: tuple[float, float, float],
        restitution: float,
        friction: float,
    ) -> None:
        offset = self._units * float(np.dot(normal, point))
        plane = dartpy.dynamics.PlaneShape(np.array(normal), offset)
        self._fixed(plane, None, name, restitution, friction)

    def _part(self, name: str, part: Segment | Disc, restitution: float, friction: float) -> None:
        units, height = self._units, self._height if self._own_cloth else 0.0
        pose = dartpy.math.Isometry3()
        if isinstance(part, Disc):
            shape: Any = dartpy.dynamics.SphereShape(units * part.radius)
            pose.set_translation(units * np.array([*part.centre, height]))
        else:
            start, end = (units * np.array([*at, height]) for at in (part.start, part.end))
            length = math.dist(start, end)
            size = [length, 2.0 * units * THICKNESS, 4.0 * units * self._height]
            shape = dartpy.dynamics.BoxShape(size)
            pose.set_translation(0.5 * (start + end))
            along, up = (end - start) / length, np.array([0.0, 0.0, 1.0])
            pose.set_rotation(np.column_stack([along, np.cross(up, along), up]))
        self._fixed(shape, pose, name, restitution, friction)

    def _fixed(self, shape: Any, pose: Any, name: str, restitution: float, friction: float) -> None:
        skeleton = dartpy.dynamics.Skeleton(name)
        joint, body = skeleton.createWeldJointAndBodyNodePair()
        if pose is not None:
            joint.setTransformFromParentBodyNode(pose)
        self._shape(body, shape, name, restitution, friction)
        skeleton.setMobile(False)
        self._world.addSkeleton(skeleton)

    @staticmethod
    def _shape(body: Any, shape: Any, name: str, restitution: float, friction: float) -> None:
        node = body.createShapeNode(shape)
        node.setName(name)
        node.createCollisionAspect()
        aspect = node.createDynamicsAspect()
        aspect = node.getDynamicsAspect() if aspect is None else aspect
        aspect.setRestitutionCoeff(restitution)
        aspect.setFrictionCoeff(friction)
