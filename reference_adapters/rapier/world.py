"""A scene as a Rapier world: spheres in the plane of the table, or on a plane under gravity."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import rapier3d

from ghostball.model import Disc, Scene, Segment, Side
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.stepping.contact_world import (
    SINGLE_PRECISION_NOISE,
    ContactWorld,
    WorldBody,
    collision_of,
    tuples_of,
)
from ghostball.reference_adapters.stepping.laws import multiplied_restitutions, restitutions
from ghostball.reference_adapters.stepping.plane import Collision, Planned
from ghostball.reference_adapters.stepping.settings import SteppingSettings
from ghostball.reference_adapters.stepping.sides import parts_of, sides_of

PREDICTION = 1e-5
"""Gap below which contacts are resolved when tuned [m]; Rapier's default is 0.02."""

BALL_FRICTION = 1e-6
"""Factor of the friction of a ball on its own cloth [1]; between two balls it is the square."""


class RapierWorld(ContactWorld):
    """A world with its balls in the order of the scene, and the collisions of its last step.

    Without its own cloth, balls don't rotate.

    `on_cloth`: as in `SpaceWorld`.
    """

    def __init__(self, scene: Scene, settings: SteppingSettings, *, own_cloth: bool) -> None:
        super().__init__(scene, noise=SINGLE_PRECISION_NOISE, rubs=own_cloth)
        self._own_cloth, self._dt = own_cloth, math.nan
        self.on_cloth: set[int] = set()
        self._height = float(scene.radii[0]) if own_cloth else 0.0
        self._tuned = settings.config == "tuned"
        self._world = rapier3d.PhysicsWorld()
        self._parameters = self._world.integration_parameters
        if self._tuned:
            self._parameters.normalized_prediction_distance = PREDICTION
        if settings.iterations is not None:
            self._parameters.num_solver_iterations = settings.iterations
        self.iterations = int(self._parameters.num_solver_iterations)
        self._restitutions = (multiplied_restitutions if self._tuned else restitutions)(
            scene.physics
        )
        self._parts: dict[Any, WorldBody] = {}
        self._colliders: list[Any] = []
        handles = [self._ball(i) for i in range(len(scene.balls))]
        self._bodies = [self._world.rigid_bodies[handle] for handle in handles]
        self._rounded: Sequence[tuple[float, ...]] = ()  # the velocities given for a step
        for side in sides_of(scene):
            self._cushion(side)
        for part in parts_of(scene):
            self._add_part(part)
        if own_cloth:
            self._world.gravity = (0.0, 0.0, -scene.physics.gravity)
            self._halfspace((0.0, 0.0), (0.0, 0.0, 1.0), 0.0, float(scene.sliding_frictions[0]))

    def start(self, velocities: FloatArray, _: FloatArray | None) -> FloatArray:
        """Set the velocities of the balls, (n, 2) [m/s], for a step."""
        (planned,) = self.planned(velocities[np.newaxis])
        self.start_planned(planned)
        return self._given

    def planned(self, velocities: FloatArray) -> Sequence[Planned]:
        """Return the velocities of coming steps, (k, n, 2) [m/s]; see `PlaneWorld`."""
        rounded = np.zeros((*velocities.shape[:2], 3), dtype=np.float32)
        rounded[..., :2] = velocities
        return list(zip(rounded[..., :2].astype(np.float64), tuples_of(rounded), strict=True))

    def start_planned(self, planned: Planned) -> None:
        """Set the velocities of the balls for a step."""
        self._given, self._rounded = planned
        for ball, velocity in zip(self._bodies, self._rounded, strict=True):
            ball.linvel = velocity

    def advance(self, dt: float) -> None:
        """Advance Rapier by `dt` [s]: it finds contacts, solves velocities, then moves."""
        if dt != self._dt:  # setting it takes as long as a step
            self._parameters.dt = self._dt = dt
        self._world.step()

    def read_contacts(self, dt: float) -> None:  # noqa: ARG002
        """Store the collisions of the last step, of `dt` [s]."""
        if self._tuned and not self._own_cloth and not self._lasting:
            self.touched = self._have_changed()
            if not self.touched:  # without reading all pairs
                self._note(set())
                return
        pushing: set[Collision] = set()
        near: set[Collision] = set()
        self.on_cloth = set()
        for pair in self._world.narrow_phase.contact_pairs():
            pushes = pair.total_impulse_magnitude() > self._noise
            if pushes or pair.has_any_active_contact:  # a half-space has pairs at any distance
                colliders = pair.collider1, pair.collider2
                parts = [self._parts[one] for one in colliders if one in self._parts]
                if len(parts) == 2:
                    (pushing if pushes else near).add(collision_of(*parts))
                elif pushes:
                    self.on_cloth.add(parts[0][0])
        self.touched = bool(pushing) or not self._tuned
        self._note(pushing, near)

    def positions_and_velocities(self) -> tuple[FloatArray, FloatArray]:
        """Return the centres [m] and velocities [m/s], two arrays (n, 2) float64."""
        places = np.array([tuple(ball.translation)[:2] for ball in self._bodies])
        return places, self._kept(self._velocities())

    def motion(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return centres [m], velocities [m/s] and spins [rad/s], three arrays (n, 3)."""
        bodies = self._bodies
        centres = np.array([tuple(ball.translation) for ball in bodies])
        velocities = np.array([tuple(ball.linvel) for ball in bodies])
        return centres, velocities, np.array([tuple(ball.angvel) for ball in bodies])

    def set_motion(self, velocities: FloatArray, spins: FloatArray) -> None:
        """Set the velocities [m/s] and spins [rad/s], two arrays (n, 3)."""
        motions = zip(self._bodies, velocities.tolist(), spins.tolist(), strict=True)
        for ball, velocity, spin in motions:
            ball.linvel, ball.angvel = tuple(velocity), tuple(spin)

    def _have_changed(self) -> bool:
        """Return whether the last step changed a velocity."""
        for ball, (x, y, _) in zip(self._bodies, self._rounded, strict=True):
            velocity = ball.linvel
            if velocity.x != x or velocity.y != y:
                return True
        return False

    def _velocities(self) -> FloatArray:
        return np.array([tuple(ball.linvel)[:2] for ball in self._bodies])

    def _ball(self, i: int) -> Any:
        ball = self._scene.balls[i]
        x, y = ball.position[:2]
        body = rapier3d.RigidBody.dynamic().translation((x, y, self._height)).can_sleep(False)
        if not self._own_cloth:
            body = body.enabled_translations((True, True, False))
            body = body.enabled_rotations((False, False, False))
        handle = self._world.add_body(body.build())
        shape = rapier3d.Collider.ball(ball.radius).mass(ball.mass)
        factor = BALL_FRICTION if self._own_cloth else 0.0
        collider = self._add(shape, self._restitutions[False], handle, friction=factor)
        self._colliders.append(collider)
        self._parts[collider] = i, False
        return handle

    def remove(self, ball: int) -> None:
        """Remove the shape of a ball; its body stays, but nothing meets it."""
        self._world.remove_collider(self._colliders[ball])
        self._bodies[ball].gravity_scale = 0.0

    def _add_part(self, part: Segment | Disc) -> None:
        if isinstance(part, Disc):
            place, shape = part.centre, rapier3d.Collider.ball(part.radius)
        else:
            place = (0.0, 0.0)
            shape = rapier3d.Collider.segment((*part.start, 0.0), (*part.end, 0.0))
        fixed = rapier3d.RigidBody.fixed().translation((*place, self._height))
        collider = self._add(shape, self._restitutions[True], self._world.add_body(fixed.build()))
        self._parts[collider] = part.obstacle, True

    def _cushion(self, side: Side) -> None:
        collider = self._halfspace(side.point, (*side.normal, 0.0), self._restitutions[True])
        self._parts[collider] = side.cushion, True

    def _halfspace(
        self,
        point: tuple[float, float],
        normal: tuple[float, float, float],
        restitution: float,
        friction: float = 0.0,
    ) -> Any:
        body = rapier3d.RigidBody.fixed().translation((*point, 0.0)).build()
        shape = rapier3d.Collider.halfspace(normal)
        factor = friction / BALL_FRICTION
        return self._add(shape, restitution, self._world.add_body(body), friction=factor)

    def _add(self, shape: Any, restitution: float, body: Any, *, friction: float = 0.0) -> Any:
        """Add a shape with its factors of restitution and friction [1]."""
        shape = shape.restitution(restitution).friction(friction)
        if self._tuned:
            multiply = rapier3d.CoefficientCombineRule.MULTIPLY
            shape = shape.restitution_combine_rule(multiply).friction_combine_rule(multiply)
        return self._world.add_collider(shape.build(), body)
