"""A scene as a Rapier world: spheres that neither turn nor leave the plane of the table."""

from __future__ import annotations

from typing import Any

import numpy as np
import rapier3d
from numpy.typing import NDArray

from ghostball.engine import CUSHIONS, Scene
from ghostball.reference_adapters.rapier.engine import RapierSettings
from ghostball.reference_adapters.stepping.contact_world import SINGLE, ContactWorld
from ghostball.reference_adapters.stepping.plane import (
    INWARD,
    Collision,
    cushion_restitution,
    multiplied_restitutions,
)

FloatArray = NDArray[np.float64]

PREDICTION = 1e-5
"""Gap from which on contacts are resolved, tuned [m]; Rapier's own is 0.02."""


class World(ContactWorld):
    """A world with its balls in the scene's order, and the collisions of its last step."""

    def __init__(self, scene: Scene, settings: RapierSettings) -> None:
        super().__init__(scene, noise=SINGLE, rubs=False)
        self._tuned = settings.config == "tuned"
        self._world = rapier3d.PhysicsWorld()
        self._parameters = self._world.integration_parameters
        if self._tuned:
            self._parameters.normalized_prediction_distance = PREDICTION
        if settings.iterations is not None:
            self._parameters.num_solver_iterations = settings.iterations
        physics = scene.physics
        self._restitutions = (
            multiplied_restitutions(physics)
            if self._tuned
            else (physics.ball_restitution, cushion_restitution(physics))
        )
        self._parts: dict[Any, tuple[int, bool]] = {}
        self._balls = [self._ball(i) for i in range(len(scene.balls))]
        for name in () if scene.table is None else scene.table.cushions:
            self._cushion(CUSHIONS.index(name))

    @property
    def iterations(self) -> int:
        """Iterations of the contact solver in each step."""
        return int(self._parameters.num_solver_iterations)

    def start(self, velocities: FloatArray, _: FloatArray | None) -> FloatArray:
        """Give the balls velocities, (n, 2) [m/s], for a step."""
        for ball, (x, y) in zip(self._bodies(), velocities.tolist(), strict=True):
            ball.linvel = (x, y, 0.0)
        self._given = self._velocities()
        return self._given

    def step(self, dt: float) -> None:
        """Let Rapier step by `dt` [s]: it finds contacts, solves velocities, then moves."""
        self._parameters.dt = dt
        self._world.step()
        pushing: set[Collision] = set()
        near: set[Collision] = set()
        for pair in self._world.narrow_phase.contact_pairs():
            parts = [self._parts[pair.collider1], self._parts[pair.collider2]]
            one, other = sorted(parts, key=lambda part: part[::-1])
            pushes = pair.total_impulse_magnitude() > self._noise
            (pushing if pushes else near).add(Collision(one[0], *other))
        self._note(pushing, near)

    def positions_and_velocities(self) -> tuple[FloatArray, FloatArray]:
        """Return the centres [m] and velocities [m/s], two arrays (n, 2) float64."""
        places = np.array([tuple(ball.translation)[:2] for ball in self._bodies()])
        return places, self._kept(self._velocities())

    def turns(self) -> FloatArray:
        """Return what the step's contacts added to the spins, (n, 3) [rad/s]: nothing rubs."""
        return np.zeros((len(self._balls), 3))

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
        self._add(shape, self._restitutions[False], handle, (i, False))
        return handle

    def _cushion(self, cushion: int) -> None:
        table = self._scene.table
        assert table is not None
        far = CUSHIONS[cushion] in ("right", "top")
        place = (table.length, table.width, 0.0) if far else (0.0, 0.0, 0.0)
        handle = self._world.add_body(rapier3d.RigidBody.fixed().translation(place).build())
        shape = rapier3d.Collider.halfspace((*INWARD[cushion], 0.0))
        self._add(shape, self._restitutions[True], handle, (cushion, True))

    def _add(self, shape: Any, restitution: float, body: Any, part: tuple[int, bool]) -> None:
        shape = shape.restitution(restitution).friction(0.0)
        if self._tuned:
            shape = shape.restitution_combine_rule(rapier3d.CoefficientCombineRule.MULTIPLY)
        self._parts[self._world.add_collider(shape.build(), body)] = part
