"""One scene built in one Bullet world: the client, its bodies, its parameters, its contacts.

Everything that is set in pybullet is here; what drives it is in `pybullet.rolling` (balls that
roll, in the plane) and `pybullet.sliding` (balls that slide, in space).

The coefficients of its bodies are in `pybullet.coefficients`.
"""

from __future__ import annotations

import math
from types import TracebackType
from typing import Any, Literal, NamedTuple, Self

import numpy as np

from ghostball.model import Disc, EventKind, Scene, Segment, Side
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.pybullet.coefficients import Coefficients
from ghostball.reference_adapters.pybullet.loading import load
from ghostball.reference_adapters.stepping.sides import CornerNames, parts_of, sides_of

Config = Literal["tuned", "default"]

FASTEST = 1e100
"""Bound on a body's velocity [m/s] and spin [rad/s], beyond any scene's.

Bullet's own, 100 of both, clamps a rolling pool ball at 2.86 m/s."""

SHORTEST_STEP = float(np.finfo(np.float64).eps)
"""Shortest step that Bullet makes [s]; it takes a shorter one for none, and moves nothing."""

MOST_IMPULSE = 1e10
"""Bound of Bullet's solver on the impulse of a contact in a step [N s]: more stops no ball."""

# Fields of a contact point, as pybullet documents `getContactPoints`.
_BODY_A, _BODY_B, _NORMAL_FORCE = 1, 2, 9


NOSE_RADIUS = 1e-6
"""Of the nose of a cushion where balls may fly [m]: Bullet has no line, but a thin capsule."""


class Contact(NamedTuple):
    """A ball in contact: `b` is the second ball, the index of the cushion in `CUSHIONS`, or -1.

    The last is the table, which is listed only where balls may fly.
    """

    kind: EventKind
    a: int
    b: int

    @property
    def balls(self) -> tuple[int, ...]:
        """Indices of the balls in it."""
        return (self.a, self.b) if self.kind is EventKind.BALL_BALL else (self.a,)


_IDLE: dict[Config, list[int]] = {"tuned": [], "default": []}
"""Clients that no world uses, all emptied. To connect takes 20 ms, more than a short shot.

What a scene was built with goes when its client is emptied, as `test_pybullet_world` shows to the
bit; what `_configure` sets for good would be the same again.
"""


class World:
    """A client of its own with the scene built in it; a context manager that gives it back.

    `planar`: whether to build the paper's plane: no gravity, no table, every centre at z = 0, so
        that balls of different radius touch at the sum of their radii in the plane. Else space,
        with gravity and a table.
    `config`: set what makes the physics right, or leave to pybullet what isn't the scene's.
    `iterations`: of the contact solver, per step.
    `slow` [m/s]: speed below which no impact bounces: 0, or, where balls may fly and the table
        returns some of their speed, what keeps those that lie on it from trembling.
    """

    def __init__(
        self, scene: Scene, *, planar: bool, config: Config, iterations: int, slow: float = 0.0
    ) -> None:
        self._scene = scene
        self._config: Config = config
        self._tuned = config == "tuned"
        self._bullet = load()
        self._dt = math.nan
        self._balls: list[int] = []
        self._ball_of_body: dict[int, int] = {}
        self._cushion_of_body: dict[int, int] = {}
        self._cloths: list[int] = []
        self._flies = scene.physics.airborne
        self._corners = CornerNames(scene)
        self._places = scene.positions
        self._touching: frozenset[Contact] = frozenset()
        self.coefficients = Coefficients.of(scene, planar=planar)
        idle = _IDLE[config]
        self._client: int = idle.pop() if idle else self._bullet.connect(self._bullet.DIRECT)
        try:
            self._configure(iterations, slow)
            self._build(planar)
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
        """Close the client; the world can't be used any more."""
        self._bullet.disconnect(physicsClientId=self._client)

    def _give_back(self) -> None:
        """Empty the client and keep it for the next world of this configuration."""
        self._bullet.resetSimulation(physicsClientId=self._client)
        _IDLE[self._config].append(self._client)

    def step(self, dt: float) -> None:
        """Advance by `dt` [s]: Bullet finds contacts, then solves velocities, then moves."""
        if dt != self._dt:
            self._bullet.setTimeStep(dt, physicsClientId=self._client)
            self._dt = dt
        if self._corners:
            self._places = self.positions()
        self._bullet.stepSimulation(physicsClientId=self._client)

    def contacts(self) -> tuple[list[Contact], list[Contact]]:
        """Return the contacts that pushed in the last step, and those of them that are new.

        Both are sorted, so that a run doesn't depend on the order in which Bullet lists them. A
        contact point without a force is only near; a contact that pushes through several steps is
        one collision.
        """
        points = self._bullet.getContactPoints(physicsClientId=self._client)
        pushing = frozenset(
            contact
            for point in points
            if point[_NORMAL_FORCE] > 0.0
            and (contact := self._contact(point[_BODY_A], point[_BODY_B])) is not None
        )
        new = pushing - self._touching
        self._touching = pushing
        if self._corners:
            new = frozenset(map(self._named, new))
        return sorted(pushing), sorted(new)

    def _named(self, contact: Contact) -> Contact:
        if contact.kind is not EventKind.BALL_CUSHION:
            return contact
        return contact._replace(b=self._corners.name(contact.b, self._places[contact.a]))

    def set_velocity(self, ball: int, velocity: list[float], angular_velocity: list[float]) -> None:
        """Set a ball's velocity [m/s] and angular velocity [rad/s], 3 components each."""
        self._bullet.resetBaseVelocity(
            self._balls[ball], velocity, angular_velocity, physicsClientId=self._client
        )

    def set_rolling_friction(self, ball: int, on: bool) -> None:
        """Switch the rolling resistance of a ball on or off."""
        body = self._cloths[ball] if self.coefficients.own_cloths else self._balls[ball]
        length = float(self.coefficients.rolling_friction[ball]) if on else 0.0
        self._change(body, rollingFriction=length)

    def velocity(self, ball: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Return a ball's velocity [m/s] and angular velocity [rad/s]."""
        linear, angular = self._bullet.getBaseVelocity(
            self._balls[ball], physicsClientId=self._client
        )
        return linear, angular

    def positions(self) -> FloatArray:
        """Return all centres, (n, 3) float64 [m]; a fresh array."""
        get = self._bullet.getBasePositionAndOrientation
        return np.array([get(body, physicsClientId=self._client)[0] for body in self._balls])

    def _contact(self, body_a: int, body_b: int) -> Contact | None:
        a, b = self._ball_of_body.get(body_a), self._ball_of_body.get(body_b)
        if a is not None and b is not None:
            return Contact(EventKind.BALL_BALL, min(a, b), max(a, b))
        ball, plane = (a, body_b) if a is not None else (b, body_a)
        cushion = self._cushion_of_body.get(plane)
        if ball is None:
            return None
        if cushion is None:
            return Contact(EventKind.BALL_CLOTH, ball, -1) if self._flies else None
        return Contact(EventKind.BALL_CUSHION, ball, cushion)

    def remove(self, ball: int) -> None:
        """Take a ball out of the world: it stays where it is, and nothing meets it."""
        body = self._balls[ball]
        self.set_velocity(ball, [0.0] * 3, [0.0] * 3)
        self._change(body, mass=0.0)
        self._bullet.setCollisionFilterGroupMask(body, -1, 0, 0, physicsClientId=self._client)

    def _configure(self, iterations: int, slow: float) -> None:
        """Set the solver; "tuned" removes what changes a collision.

        contactERP adds speed to push overlapping balls apart (an elastic impact gains 4 % of energy
        at any step), the restitution threshold makes impacts below 0.2 m/s inelastic, and a
        residual threshold or a slop stops the solver early.
        """
        parameters: dict[str, float] = {"numSolverIterations": iterations}
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
        if not planar:
            for i in range(len(scene.balls) if factors.own_cloths else 1):
                friction = float(factors.table_friction[i])
                up = (0.0, 0.0, 1.0)
                bounce = factors.table_restitution
                cloth = self._plane((0.0, 0.0, 0.0), up, bounce, friction)
                if self._flies and self._tuned:
                    self._change(cloth, contactProcessingThreshold=0.0)  # as for cushions below
                self._cloths.append(cloth)
        laws = factors.cushion_restitution, factors.cushion_friction
        for side in sides_of(scene):
            body = (
                self._nose(side, *laws)
                if self._flies
                else self._plane((*side.point, 0.0), (*side.normal, 0.0), *laws)
            )
            self._cushion_of_body[body] = side.cushion
            if self._tuned:
                # Else a ball is stopped at the cushion in the step before it gets there, and
                # what it has left of the step is taken from its restitution.
                self._change(body, contactProcessingThreshold=0.0)
        for part in parts_of(scene):
            body = self._part(part, 0.0 if planar else float(scene.radii[0]), *laws)
            self._cushion_of_body[body] = part.obstacle
            if self._tuned:
                self._change(body, contactProcessingThreshold=0.0)
        for i in range(len(scene.balls)):
            self._ball(i, planar)
        if factors.own_cloths:
            self._part_cloths()

    def _part_cloths(self) -> None:
        """Let every ball touch its own table alone."""
        for i, cloth in enumerate(self._cloths):
            for j, ball in enumerate(self._balls):
                if i != j:
                    self._bullet.setCollisionFilterPair(
                        cloth, ball, -1, -1, enableCollision=0, physicsClientId=self._client
                    )

    def _ball(self, i: int, planar: bool) -> None:
        ball, factors = self._scene.balls[i], self.coefficients
        centre = [*ball.position[:2], 0.0 if planar else ball.position[2]]
        shape = self._bullet.createCollisionShape(
            self._bullet.GEOM_SPHERE, radius=ball.radius, physicsClientId=self._client
        )
        body = self._bullet.createMultiBody(
            ball.mass, shape, basePosition=centre, physicsClientId=self._client
        )
        self._balls.append(body)
        self._ball_of_body[body] = i
        self._change(
            body,
            restitution=factors.ball_restitution,
            lateralFriction=factors.ball_friction,
        )
        self._change(
            self._cloths[i] if factors.own_cloths else body,
            rollingFriction=float(factors.rolling_friction[i]),
            spinningFriction=float(factors.spinning_friction[i]),
        )
        if self._tuned:
            self._change(body, linearDamping=0.0, angularDamping=0.0, maxJointVelocity=FASTEST)

    def _part(
        self, part: Segment | Disc, height: float, restitution: float, friction: float
    ) -> int:
        """Add a part of a cushion at the height of the balls' centres [m]: a line, or a sphere.

        The line is the edge of a triangle: where Bullet meets a triangle, or a sphere, with a ball,
        the contact is right to the last digits. Of capsules and cylinders it is so nearly alone, as
        it searches for it, and a box has round edges.
        """
        if isinstance(part, Disc):
            place = (*part.centre, height)
            shape = self._bullet.createCollisionShape(
                self._bullet.GEOM_SPHERE, radius=part.radius, physicsClientId=self._client
            )
        else:
            place = (0.0, 0.0, 0.0)
            (x0, y0), (x1, y1) = part.start, part.end
            top = (0.5 * (x0 + x1), 0.5 * (y0 + y1), height + math.dist(part.start, part.end))
            shape = self._bullet.createCollisionShape(
                self._bullet.GEOM_MESH,
                vertices=[(x0, y0, height), (x1, y1, height), top],
                indices=[0, 1, 2],
                flags=self._bullet.GEOM_FORCE_CONCAVE_TRIMESH,
                physicsClientId=self._client,
            )
        return self._fixed(shape, place, restitution, friction)

    def _nose(self, side: Side, restitution: float, friction: float) -> int:
        """Add a cushion's nose: a capsule along its line, at its height above the cloth."""
        across, (x, y), middle = side.normal[0] != 0.0, side.point, 0.5 * side.length
        shape = self._bullet.createCollisionShape(
            self._bullet.GEOM_CAPSULE,
            radius=NOSE_RADIUS,
            height=2.0 * side.length,
            physicsClientId=self._client,
        )
        height = self._scene.physics.cushion_height
        # Bullet's capsule stands; it is laid along y, or along x.
        turn = math.sqrt(0.5)
        lying = (turn, 0.0, 0.0, turn) if across else (0.0, turn, 0.0, turn)
        place = (*((x, middle) if across else (middle, y)), height)
        return self._fixed(shape, place, restitution, friction, baseOrientation=lying)

    def _plane(
        self,
        origin: tuple[float, float, float],
        normal: tuple[float, float, float],
        restitution: float,
        friction: float,
    ) -> int:
        shape = self._bullet.createCollisionShape(
            self._bullet.GEOM_PLANE, planeNormal=normal, physicsClientId=self._client
        )
        return self._fixed(shape, origin, restitution, friction)

    def _fixed(
        self,
        shape: int,
        place: tuple[float, ...],
        restitution: float,
        friction: float,
        **turned: Any,
    ) -> int:
        """Add a body that never moves."""
        body: int = self._bullet.createMultiBody(
            0.0, shape, basePosition=place, physicsClientId=self._client, **turned
        )
        self._change(body, restitution=restitution, lateralFriction=friction)
        return body

    def _change(self, body: int, **parameters: float) -> None:
        self._bullet.changeDynamics(body, -1, **parameters, physicsClientId=self._client)
