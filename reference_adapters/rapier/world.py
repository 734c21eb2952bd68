"""A scene as a Rapier world: spheres that don't rotate and stay in the plane of the table."""

from __future__ import annotations

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
)
from ghostball.reference_adapters.stepping.laws import multiplied_restitutions, restitutions
from ghostball.reference_adapters.stepping.plane import Collision
from ghostball.reference_adapters.stepping.settings import SteppingSettings
from ghostball.reference_adapters.stepping.sides import parts_of, sides_of

PREDICTION = 1e-5
"""Gap below which contacts are resolved when tuned [m]; Rapier's default is 0.02."""


class RapierWorld(ContactWorld):
    """A world with its balls in the order of the scene, and the collisions of its last step."""

    def __init__(self, scene: Scene, settings: SteppingSettings) -> None:
        super().__init__(scene, noise=SINGLE_PRECISION_NOISE, rubs=False)
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
        self._balls = [self._ball(i) for i in range(len(scene.balls))]
        for side in sides_of(scene):
            self._cushion(side)
        for part in parts_of(scene):
            self._add_part(part)

    def start(self, velocities: FloatArray, _: FloatArray | None) -> FloatArray:
        """Set the velocities of the balls, (n, 2) [m/s], for a step."""
        for ball, (x, y) in zip(self._bodies(), velocities.tolist(), strict=True):
            ball.linvel = (x, y, 0.0)
        self._given = velocities.astype(np.float32).astype(np.float64)
        return self._given

    def step(self, dt: float) -> None:
        """Advance Rapier by `dt` [s]: it finds contacts, solves velocities, then moves."""
        self._parameters.dt = dt
        self._world.step()
        pushing: set[Collision] = set()
        near: set[Collision] = set()
        for pair in self._world.narrow_phase.contact_pairs():
            pushes = pair.total_impulse_magnitude() > self._noise
            if pushes or pair.has_any_active_contact:  # a half-space has pairs at any distance
                parts = self._parts[pair.collider1], self._parts[pair.collider2]
                (pushing if pushes else near).add(collision_of(*parts))
        self.touched = bool(pushing) or not self._tuned
        self._note(pushing, near)

    def positions_and_velocities(self) -> tuple[FloatArray, FloatArray]:
        """Return the centres [m] and velocities [m/s], two arrays (n, 2) float64."""
        places = np.array([tuple(ball.translation)[:2] for ball in self._bodies()])
        return places, self._kept(self._velocities())

    def _bodies(self) -> list[Any]:
        bodies = self._world.rigid_bodies
        return [bodies[handle] for handle in self._balls]

    def _velocities(self) -> FloatArray:
        return np.array([tuple(ball.linvel)[:2] for ball in self._bodies()])

    def _ball(self, i: int) -> Any:
        ball = self._scene.balls[i]
        x, y = ball.position[:2]
        body = rapier3d.RigidBody.dynamic().translation((x, y, 0.0)).can_sleep(False)
        body = body.enabled_translations((True, True, False))
        handle = self._world.add_body(body.enabled_rotations((False, False, False)).build())
        shape = rapier3d.Collider.ball(ball.radius).mass(ball.mass)
        self._colliders.append(self._add(shape, self._restitutions[False], handle, (i, False)))
        return handle

    def remove(self, ball: int) -> None:
        """Remove the shape of a ball; its body stays, but nothing meets it."""
        self._world.remove_collider(self._colliders[ball])

    def _add_part(self, part: Segment | Disc) -> None:
        if isinstance(part, Disc):
            place, shape = part.centre, rapier3d.Collider.ball(part.radius)
        else:
            place = (0.0, 0.0)
            shape = rapier3d.Collider.segment((*part.start, 0.0), (*part.end, 0.0))
        body = self._world.add_body(rapier3d.RigidBody.fixed().translation((*place, 0.0)).build())
        self._add(shape, self._restitutions[True], body, (part.obstacle, True))

    def _cushion(self, side: Side) -> None:
        body = rapier3d.RigidBody.fixed().translation((*side.point, 0.0))
        shape = rapier3d.Collider.halfspace((*side.normal, 0.0))
        part = side.cushion, True
        self._add(shape, self._restitutions[True], self._world.add_body(body.build()), part)

    def _add(self, shape: Any, restitution: float, body: Any, part: WorldBody) -> Any:
        shape = shape.restitution(restitution).friction(0.0)
        if self._tuned:
            shape = shape.restitution_combine_rule(rapier3d.CoefficientCombineRule.MULTIPLY)
        collider = self._world.add_collider(shape.build(), body)
        self._parts[collider] = part
        return collider
