"""A scene as a Box2D world: balls are discs seen from above, cushions are edges.

The unit of length isn't a metre; see `box2d.engine`. Box2D uses single precision, so velocities are
rounded; `start` returns the rounded values.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np

from ghostball.model import Disc, Scene, Segment, Side
from ghostball.model.arrays import FloatArray
from ghostball.model.scene.sides import Point
from ghostball.reference_adapters.box2d.engine import SLOP, Box2dSettings
from ghostball.reference_adapters.stepping.contact_world import (
    SINGLE_PRECISION_NOISE,
    ContactWorld,
    collision_of,
    tuples_of,
)
from ghostball.reference_adapters.stepping.friction import ContactFriction
from ghostball.reference_adapters.stepping.laws import SpeedDependentRestitution, restitutions, rubs
from ghostball.reference_adapters.stepping.plane import Collision, Planned
from ghostball.reference_adapters.stepping.sides import (
    Normals,
    corners_of,
    parts_of,
    reach_beyond_corners,
    sides_of,
)

# The import of Box2D raises warnings about missing SWIG attributes, and crashes Python if warnings
# are errors.
with warnings.catch_warnings():
    warnings.simplefilter("ignore", DeprecationWarning)
    import Box2D


SKIN = 2.0 * SLOP
"""Distance of the surface of an edge from the edge in Box2D [units]."""


class Box2dWorld(ContactWorld):
    """A world with its balls in the order of the scene, and the collisions of its last step."""

    def __init__(self, scene: Scene, settings: Box2dSettings) -> None:
        self._tuned = settings.config == "tuned"
        rubbing = self._tuned and rubs(scene)
        super().__init__(
            scene, noise=SINGLE_PRECISION_NOISE, rubs=rubbing, units=settings.units(scene)
        )
        self._settings = settings
        self.iterations = settings.iterations or (8 if self._tuned else 6)  # velocity iterations
        self._restitutions = restitutions(scene.physics)
        self._friction = ContactFriction(scene) if rubbing else None
        self._falling = SpeedDependentRestitution.of(scene.physics)
        self._normals = Normals(scene)
        self._found: set[Collision] = set()
        self._listener = _listener(self)
        self._world = Box2D.b2World(gravity=(0, 0), doSleep=False, contactListener=self._listener)
        if settings.contact_steps == "exact":
            self._world.warmStarting = (
                False  # contacts don't last, and steps have different lengths
            )
        self._bodies = [self._ball(i) for i in range(len(scene.balls))]
        for side in sides_of(scene):
            self._side(side)
        for part in parts_of(scene):
            if isinstance(part, Disc):
                self._disc(part)
            else:
                self._segment(part)
        if self._skin:
            for corner in corners_of(scene):
                self._disc(Disc(corner.before, corner.place, 0.0))

    def start(self, velocities: FloatArray, spins: FloatArray | None) -> FloatArray:
        """Set the velocities, (n, 2) [m/s], and spins, (n, 3) [rad/s], of the balls for a step."""
        (planned,) = self.planned(velocities[np.newaxis])
        self.start_planned(planned)
        if self._friction is not None and spins is not None:
            for body, spin in zip(self._bodies, spins[:, 2].tolist(), strict=True):
                body.angularVelocity = spin
            given = spins.copy()
            given[:, 2] = self._vertical_spins()
            self._friction.set_spins(given)
        return planned[0]

    def planned(self, velocities: FloatArray) -> Sequence[Planned]:
        """Return the velocities of coming steps, (k, n, 2) [m/s]; see `PlaneWorld`."""
        rounded = (velocities * self._units).astype(np.float32)
        return list(zip(rounded / np.float64(self._units), tuples_of(rounded), strict=True))

    def start_planned(self, planned: Planned) -> None:
        """Set the velocities of the balls for a step."""
        for body, velocity in zip(self._bodies, planned[1], strict=True):
            body.linearVelocity = velocity

    def set_velocities(self, velocities: FloatArray) -> None:
        """Set the velocities, (n, 2) [m/s]."""
        self.start(velocities, None)

    def add_rolling_joints(self) -> None:
        """Slow every ball by mu g with a friction joint, Box2D's friction of the top view."""
        scene, table = self._scene, self._world.CreateStaticBody()
        forces = scene.rolling_frictions * scene.physics.gravity * scene.masses * self._units
        for body, force in zip(self._bodies, forces.tolist(), strict=True):
            self._world.CreateFrictionJoint(
                bodyA=table, bodyB=body, localAnchorB=(0, 0), maxForce=force, maxTorque=0.0
            )

    def advance(self, dt: float) -> None:
        """Advance Box2D by `dt` [s]: it finds contacts, solves velocities, then moves."""
        self._found = set()
        self.touched = not self._tuned
        self._world.Step(dt, self.iterations, 3 if self._tuned else 2)

    def read_contacts(self, dt: float) -> None:  # noqa: ARG002
        """Store the collisions of the last step, of `dt` [s]."""
        self._note(self._found)

    def positions_and_velocities(self) -> tuple[FloatArray, FloatArray]:
        """Return the centres [m] and velocities [m/s], two arrays (n, 2) float64."""
        places = np.array([tuple(body.position) for body in self._bodies]) / self._units
        return places, self._velocities()

    def turns(self) -> FloatArray:
        """Return the spin changes by the contacts of the step, (n, 3) [rad/s]."""
        assert self._friction is not None
        return self._friction.turns(self._vertical_spins())

    def remove(self, ball: int) -> None:
        """Remove a ball: it stays in the list, but nothing meets it."""
        self._bodies[ball].active = False

    def prepare(self, contact: Any) -> None:
        """Set the coefficients of a contact before it is solved."""
        parts = self._parts(contact)
        contact.restitution = self._restitutions[parts.cushion]
        one = self._bodies[parts.a]
        line, relative = (0.0, 0.0), one.linearVelocity
        if parts.cushion and not (self._falling is None and self._friction is None):
            nx, ny = self._normals.at(parts.b, one.position / self._units)
            line = -nx, -ny
            if self._falling is not None:
                speed = relative / self._units
                contact.restitution = self._falling.at((nx, ny), (speed[0], speed[1]))
        if self._friction is None:
            return
        if not parts.cushion:
            other = self._bodies[parts.b]
            line = tuple(other.position - one.position)
            relative = relative - other.linearVelocity
        velocity = relative[0] / self._units, relative[1] / self._units
        contact.friction = self._friction.prepare(parts, line, velocity)

    def note(self, contact: Any, impulse: float) -> None:
        """Record a contact that was solved with a normal impulse [kg units/s]."""
        self.touched = True
        parts = self._parts(contact)
        if self._friction is not None:
            self._friction.note(parts, impulse / self._units)
        if impulse > self._noise:
            self._found.add(parts)

    def _parts(self, contact: Any) -> Collision:
        return collision_of(contact.fixtureA.userData, contact.fixtureB.userData)

    def _velocities(self) -> FloatArray:
        return np.array([tuple(body.linearVelocity) for body in self._bodies]) / self._units

    def _vertical_spins(self) -> FloatArray:
        return np.array([body.angularVelocity for body in self._bodies])

    def _ball(self, i: int) -> Any:
        ball, units = self._scene.balls[i], self._units
        body = self._world.CreateDynamicBody(
            position=(units * ball.position[0], units * ball.position[1]),
            bullet=self._settings.bullets,
            fixedRotation=self._tuned and self._friction is None,
        )
        radius = units * ball.radius
        fixture = body.CreateCircleFixture(
            radius=radius,
            density=ball.mass / (np.pi * radius**2),
            restitution=self._restitutions[False],
            friction=0.0,
        )
        fixture.userData = i, False
        if self._friction is not None:  # the moment of inertia of a ball, not of a disc
            inertia = 0.4 * ball.mass * radius**2
            body.massData = Box2D.b2MassData(mass=ball.mass, center=(0, 0), I=inertia)
        return body

    @property
    def _skin(self) -> float:
        """Distance by which edges are moved outwards [m].

        With exact steps, contacts would otherwise be detected early, at the skin.
        """
        return SKIN / self._units if self._settings.contact_steps == "exact" else 0.0

    def _side(self, side: Side) -> None:
        self._edge(side.ends(reach_beyond_corners(self._scene), outward=self._skin), side.cushion)

    def _segment(self, one: Segment) -> None:
        (x0, y0), (x1, y1) = one.start, one.end
        length = math.dist(one.start, one.end)
        # To the right of the direction of the segment, because the table is on its left. The
        # segment is also shortened, so that a ball meets the point of a corner, see `corners_of`,
        # before the skin around the ends.
        skin = min(self._skin, 0.25 * length)
        dx, dy = skin * (x1 - x0) / length, skin * (y1 - y0) / length
        self._edge(((x0 + dx + dy, y0 + dy - dx), (x1 - dx + dy, y1 - dy - dx)), one.obstacle)

    def _edge(self, ends: tuple[Point, Point], index: int) -> None:
        self._cushion("CreateEdgeFixture", index, vertices=[self._scaled(end) for end in ends])

    def _disc(self, one: Disc) -> None:
        place = self._scaled(one.centre)
        self._cushion(
            "CreateCircleFixture", one.obstacle, pos=place, radius=self._units * one.radius
        )

    def _scaled(self, point: Point) -> Point:
        return self._units * point[0], self._units * point[1]

    def _cushion(self, create: str, index: int, **shape: Any) -> None:
        body = self._world.CreateStaticBody()
        fixture = getattr(body, create)(**shape, restitution=self._restitutions[True], friction=0.0)
        fixture.userData = index, True


def _listener(world: Box2dWorld) -> Any:
    """Return the contact listener of Box2D that reports contacts to a world."""

    class Listener(Box2D.b2ContactListener):  # type: ignore[misc]
        def PreSolve(self, contact: Any, _manifold: Any) -> None:  # noqa: N802
            if world._tuned:
                world.prepare(contact)

        def PostSolve(self, contact: Any, impulse: Any) -> None:  # noqa: N802
            world.note(contact, impulse.normalImpulses[0])

    return Listener()
