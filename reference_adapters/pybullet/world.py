"""A scene in a Bullet world: the client, its bodies, its parameters, its contacts.

All settings of pybullet are here, except the coefficients of bodies, which are in
`pybullet.coefficients`. The steppers are in `stepping.closed_form` (rolling balls, in the plane)
and `stepping.space` (sliding balls, in 3D).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from types import TracebackType
from typing import Any, Self

import numpy as np

from ghostball.model import Disc, Scene, Segment, Side
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.pybullet.coefficients import Coefficients
from ghostball.reference_adapters.pybullet.engine import PybulletSettings
from ghostball.reference_adapters.pybullet.loading import load
from ghostball.reference_adapters.stepping.contact_world import (
    ContactWorld,
    WorldBody,
    collision_of,
)
from ghostball.reference_adapters.stepping.plane import Collision, Planned
from ghostball.reference_adapters.stepping.sides import parts_of, sides_of
from ghostball.reference_adapters.stepping.space import slowest_bounce

MAX_SPEED = 1e100
"""Limit on a body's velocity [m/s] and spin [rad/s], larger than in any scene.

Bullet's default of 100 for both limits a rolling pool ball to 2.86 m/s.
"""

# Indices of the fields of a contact point, from the documentation of `getContactPoints`.
_BODY_A, _BODY_B, _NORMAL_FORCE = 1, 2, 9


_AT_REST = (0.0, 0.0, 0.0)

NOSE_RADIUS = 1e-6
"""Radius of a cushion nose with airborne balls [m]: Bullet has no line, so it is a thin capsule."""


_IDLE_CLIENTS: dict[str, list[int]] = {"tuned": [], "naive": []}
"""Empty clients that no world uses at present.

Connecting and disconnecting takes 20 ms, as long as a short shot; emptying a client takes 0.7 ms.
Emptying removes the scene, as `test_world` checks bit for bit. The permanent settings of
`_configure` are the same for the next world.
"""


class PybulletWorld(ContactWorld):
    """A client with the scene built in it; a context manager that returns the client at the end.

    With its own cloth, the world has gravity and a table. Otherwise it is the paper's plane:
    without both, and with every centre at z = 0, so that balls of different radii touch at the sum
    of their radii in the plane. Tuned, it has settings for accurate physics; otherwise it keeps
    pybullet's defaults for everything that the scene doesn't define.

    `on_cloth`: as in `SpaceWorld` with airborne balls; otherwise empty.
    """

    def __init__(self, scene: Scene, settings: PybulletSettings, *, own_cloth: bool) -> None:
        super().__init__(scene, noise=0.0, rubs=False)
        self.iterations = settings.iterations
        self.on_cloth: set[int] = set()
        self._config = settings.config
        self._tuned = settings.config == "tuned"
        self._bullet_slows = settings.bullet_slows
        self._bullet = load()
        self._dt = math.nan
        self._balls: list[int] = []
        self._parts: dict[int, WorldBody] = {}
        self._cloths: list[int] = []
        self._flies = scene.physics.airborne
        # Velocities of balls in the plane, stored so that Bullet is only asked about moving balls.
        self._in_plane = np.zeros((len(scene.balls), 2))
        self.coefficients = Coefficients.of(scene, planar=not own_cloth)
        idle = _IDLE_CLIENTS[self._config]
        self._client: int = idle.pop() if idle else self._bullet.connect(self._bullet.DIRECT)
        try:
            # With a restitution of the table, balls on the table would jitter.
            slow = slowest_bounce(scene, settings.step) if self._flies else 0.0
            self._configure(slow)
            self._build(not own_cloth)
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if kind is None:
            self._give_back()
        else:
            self.close()

    def close(self) -> None:
        """Close the client; the world can't be used afterwards."""
        self._bullet.disconnect(physicsClientId=self._client)

    def _give_back(self) -> None:
        """Empty the client and keep it for the next world with this configuration."""
        self._bullet.resetSimulation(physicsClientId=self._client)
        _IDLE_CLIENTS[self._config].append(self._client)

    def start(self, velocities: FloatArray, _: FloatArray | None) -> FloatArray:
        """Set the velocities of the balls, (n, 2) [m/s], for a step without rotation."""
        (planned,) = self.planned(velocities[np.newaxis])
        self.start_planned(planned)
        return velocities

    def planned(self, velocities: FloatArray) -> Sequence[Planned]:
        """Return the velocities of coming steps, (k, n, 2) [m/s]; see `PlaneWorld`."""
        known = [self._in_plane.tolist(), *velocities.tolist()]
        changed = [
            [(i, (x, y, 0.0)) for i, (x, y) in enumerate(given) if [x, y] != last[i]]
            for last, given in pairwise(known)
        ]
        return list(zip(velocities, changed, strict=True))

    def start_planned(self, planned: Planned) -> None:
        """Set the velocities of the balls for a step without rotation."""
        self._given, changed = planned
        self._in_plane = self._given
        for ball, velocity in changed:
            self._set(ball, velocity, _AT_REST)

    def advance(self, dt: float) -> None:
        """Advance Bullet by `dt` [s]: it finds contacts, solves velocities, then moves."""
        if dt != self._dt:
            self._bullet.setTimeStep(dt, physicsClientId=self._client)
            self._dt = dt
        self._bullet.stepSimulation(physicsClientId=self._client)

    def read_contacts(self, dt: float) -> None:  # noqa: ARG002
        """Store the collisions of the last step, of `dt` [s]."""
        pushing: set[Collision] = set()
        self.on_cloth = set()
        points = self._bullet.getContactPoints(physicsClientId=self._client)
        self.touched = bool(points) or not self._tuned
        for point in points:
            if not point[_NORMAL_FORCE] > 0.0:  # near, but without contact
                continue
            a, b = self._parts.get(point[_BODY_A]), self._parts.get(point[_BODY_B])
            if a and b:
                pushing.add(collision_of(a, b))
            elif (ball := a or b) and self._flies:
                self.on_cloth.add(ball[0])
        self._note(pushing)

    def positions(self) -> FloatArray:
        """Return all centres, (n, 3) float64 [m]; a new array."""
        get = self._bullet.getBasePositionAndOrientation
        return np.array([get(body, physicsClientId=self._client)[0] for body in self._balls])

    def positions_and_velocities(self) -> tuple[FloatArray, FloatArray]:
        """Return the centres [m] and velocities [m/s] in the plane, two arrays (n, 2) float64."""
        changed = {ball for contact in self._pushing for ball in contact.balls}
        if not self._tuned:  # Bullet damps moving balls
            changed.update((self._in_plane != 0.0).any(axis=1).nonzero()[0].tolist())
        velocities = self._in_plane.copy()
        for i in changed:
            velocities[i] = self._velocity(i)[0][:2]
        self._in_plane = velocities
        return self.positions()[:, :2], velocities.copy()

    def motion(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return centres [m], velocities [m/s] and spins [rad/s], three arrays (n, 3)."""
        motions = np.array([self._velocity(i) for i in range(len(self._balls))])
        return self.positions(), motions[:, 0], motions[:, 1]

    def set_motion(self, velocities: FloatArray, spins: FloatArray) -> None:
        """Set the velocities [m/s] and spins [rad/s], two arrays (n, 3)."""
        for i, motion in enumerate(zip(velocities.tolist(), spins.tolist(), strict=True)):
            self._set(i, *motion)

    def remove(self, ball: int) -> None:
        """Remove a ball from the world: it stays where it is, but nothing meets it."""
        body, self._in_plane[ball] = self._balls[ball], 0.0
        self._set(ball, _AT_REST, _AT_REST)
        self._change(body, mass=0.0)
        self._bullet.setCollisionFilterGroupMask(body, -1, 0, 0, physicsClientId=self._client)

    def _set(self, ball: int, velocity: Sequence[float], spin: Sequence[float]) -> None:
        self._bullet.resetBaseVelocity(
            self._balls[ball], velocity, spin, physicsClientId=self._client
        )

    def _velocity(self, ball: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Return a ball's velocity [m/s] and spin [rad/s]."""
        velocity, spin = self._bullet.getBaseVelocity(
            self._balls[ball], physicsClientId=self._client
        )
        return velocity, spin

    def _configure(self, slow: float) -> None:
        """Set the parameters of the solver; "tuned" removes those that change collisions.

        `slow`: in "tuned", impacts below this speed don't bounce [m/s].

        contactERP adds speed to separate overlapping balls (an elastic impact gains 4 % of energy
        at any step), the restitution threshold makes impacts below 0.2 m/s inelastic, and a
        residual threshold or a slop ends the solver early.
        """
        parameters: dict[str, float] = {"numSolverIterations": self.iterations}
        if self._tuned:
            parameters |= {
                "numSubSteps": 0,  # contacts inside a substep are never reported
                "solverResidualThreshold": 0.0,
                "erp": 0.0,
                "contactERP": 0.0,
                "frictionERP": 0.0,
                "contactSlop": 0.0,
                "restitutionVelocityThreshold": slow,
                "enableConeFriction": 1,
                "deterministicOverlappingPairs": 1,
            }
        self._bullet.setPhysicsEngineParameter(**parameters, physicsClientId=self._client)

    def _build(self, planar: bool) -> None:
        scene, factors = self._scene, self.coefficients
        gravity = 0.0 if planar else -scene.physics.gravity
        self._bullet.setGravity(0.0, 0.0, gravity, physicsClientId=self._client)
        origin, up = (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)
        if not planar:
            for i in range(len(scene.balls) if factors.own_tables else 1):
                laws = factors.table_restitution, float(factors.table_friction[i])
                cloth = self._fixed(self._plane(up), origin, laws, bounces=self._flies)
                self._cloths.append(cloth)
        laws = factors.cushion_restitution, factors.cushion_friction
        for side in sides_of(scene):
            if self._flies:
                body = self._nose(side, laws)
            else:
                body = self._fixed(self._plane((*side.normal, 0.0)), (*side.point, 0.0), laws)
            self._parts[body] = side.cushion, True
        for part in parts_of(scene):
            body = self._part(part, 0.0 if planar else float(scene.radii[0]), laws)
            self._parts[body] = part.obstacle, True
        for i in range(len(scene.balls)):
            self._ball(i, planar)
        if factors.own_tables:
            self._separate_cloths()

    def _separate_cloths(self) -> None:
        """Let every ball touch only its own table."""
        for i, cloth in enumerate(self._cloths):
            for j, ball in enumerate(self._balls):
                if i != j:
                    self._bullet.setCollisionFilterPair(
                        cloth, ball, -1, -1, enableCollision=0, physicsClientId=self._client
                    )

    def _ball(self, i: int, planar: bool) -> None:
        ball, factors = self._scene.balls[i], self.coefficients
        centre = [*ball.position[:2], 0.0 if planar else ball.position[2]]
        shape = self._shape(self._bullet.GEOM_SPHERE, radius=ball.radius)
        body = self._bullet.createMultiBody(
            ball.mass, shape, basePosition=centre, physicsClientId=self._client
        )
        self._balls.append(body)
        self._parts[body] = i, False
        self._change(
            body,
            restitution=factors.ball_restitution,
            lateralFriction=factors.ball_friction,
        )
        if self._tuned:
            self._change(body, linearDamping=0.0, angularDamping=0.0, maxJointVelocity=MAX_SPEED)
        if self._bullet_slows:  # this rolling friction also slows sliding balls
            self._change(
                body,
                rollingFriction=float(factors.rolling_friction[i]),
                spinningFriction=float(factors.spinning_friction[i]),
            )

    def _part(self, part: Segment | Disc, height: float, laws: tuple[float, float]) -> int:
        """Add a cushion segment or a disc at the height of the balls' centres [m].

        A segment is the edge of a triangle, a disc is a sphere: Bullet's contacts of a ball with a
        triangle or a sphere are accurate to the last digits. Contacts with capsules and cylinders
        are less accurate, because Bullet finds them by iteration, and boxes have rounded edges.
        """
        if isinstance(part, Disc):
            sphere = self._shape(self._bullet.GEOM_SPHERE, radius=part.radius)
            return self._fixed(sphere, (*part.centre, height), laws)
        (x0, y0), (x1, y1) = part.start, part.end
        top = (0.5 * (x0 + x1), 0.5 * (y0 + y1), height + math.dist(part.start, part.end))
        line = self._shape(
            self._bullet.GEOM_MESH,
            vertices=[(x0, y0, height), (x1, y1, height), top],
            indices=[0, 1, 2],
            flags=self._bullet.GEOM_FORCE_CONCAVE_TRIMESH,
        )
        return self._fixed(line, (0.0, 0.0, 0.0), laws)

    def _nose(self, side: Side, laws: tuple[float, float]) -> int:
        """Add a cushion's nose: a capsule along its line, at its height above the cloth."""
        across, (x, y), middle = side.normal[0] != 0.0, side.point, 0.5 * side.length
        capsule = self._shape(
            self._bullet.GEOM_CAPSULE, radius=NOSE_RADIUS, height=2.0 * side.length
        )
        place = (*((x, middle) if across else (middle, y)), self._scene.physics.cushion_height)
        # Bullet's capsules are vertical; this one is turned along y or x.
        turn = math.sqrt(0.5)
        lying = (turn, 0.0, 0.0, turn) if across else (0.0, turn, 0.0, turn)
        return self._fixed(capsule, place, laws, lying)

    def _plane(self, normal: tuple[float, float, float]) -> int:
        return self._shape(self._bullet.GEOM_PLANE, planeNormal=normal)

    def _shape(self, kind: int, **form: Any) -> int:
        shape: int = self._bullet.createCollisionShape(kind, **form, physicsClientId=self._client)
        return shape

    def _fixed(
        self,
        shape: int,
        place: tuple[float, ...],
        laws: tuple[float, float],
        turned: tuple[float, ...] = (0.0, 0.0, 0.0, 1.0),
        *,
        bounces: bool = True,
    ) -> int:
        """Add a fixed body with its factors of restitution and friction [1].

        Tuned, a body that `bounces` doesn't stop a ball in the step before the contact, because the
        rest of that step would be lost from the rebound.
        """
        body: int = self._bullet.createMultiBody(
            0.0,
            shape,
            basePosition=place,
            baseOrientation=turned,
            physicsClientId=self._client,
        )
        self._change(body, restitution=laws[0], lateralFriction=laws[1])
        if bounces and self._tuned:
            self._change(body, contactProcessingThreshold=0.0)
        return body

    def _change(self, body: int, **parameters: float) -> None:
        self._bullet.changeDynamics(body, -1, **parameters, physicsClientId=self._client)
