"""A scene as a Pymunk space: balls are discs seen from above, cushions are static segments.

There are two configurations: `tuned`, from experiments with Chipmunk's solver, and `naive`, what a
newcomer types after reading the examples.
"""

from __future__ import annotations

import math

import numpy as np
import pymunk
from pymunk import batch

from ghostball.model import Disc, Scene, Segment, Side
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.stepping.contact_world import UnroundedPlans
from ghostball.reference_adapters.stepping.friction import ContactFriction
from ghostball.reference_adapters.stepping.laws import (
    SpeedDependentRestitution,
    cushion_restitution,
    largest_momenta,
    rubs,
)
from ghostball.reference_adapters.stepping.plane import Collision
from ghostball.reference_adapters.stepping.settings import SteppingSettings
from ghostball.reference_adapters.stepping.sides import (
    Normals,
    parts_of,
    reach_beyond,
    sides_of,
)

_BALL, _CUSHION = 1, 2  # collision types
_STATE = batch.BodyFields.POSITION | batch.BodyFields.VELOCITY

CUSHION_THICKNESS = 0.5
"""Radius of the segment of a tuned cushion [m].

A ball that enters a segment less than half way is pushed back, so a thicker segment stops faster
balls.
"""

TUNED_ITERATIONS = 30
"""Number of solver iterations; each also processes the rolling joints.

In elastic breaks of a touching rack of 15, Chipmunk's default of 10 gains up to 3e-4 of the energy;
30 lose less than 1e-9.
"""

_FORGETTING_STEP = 1e-9
"""Step that clears the solver's stored contacts [s]; no ball moves in it, whatever its length."""


class PymunkWorld(UnroundedPlans):
    """A space with its balls in the order of the scene, and the collisions of its last step.

    `collisions`: collisions of the last step.
    `contacts_solved`: number of contacts that the solver has processed; a lasting contact counts
        once per step.
    `touched`: as in `PlaneWorld`.
    `friction`: friction at contacts; None without friction.
    """

    collides_first = False

    def __init__(self, scene: Scene, settings: SteppingSettings) -> None:
        self.scene = scene
        self.collisions: list[Collision] = []
        self.contacts_solved = 0
        self.touched = True
        self._solved = 0
        self._found: list[Collision] = []
        self._forgotten = 0
        self.tuned = settings.config == "tuned"
        # Rounding of the momentum of each ball if it had all the energy. Balls that roll on
        # together exchange impulses of this size without colliding.
        self._impulse_rounding = 16.0 * np.finfo(np.float64).eps * largest_momenta(scene)
        self._space = pymunk.Space()
        # Pymunk moves, then finds overlaps, then solves velocities.
        self.advance = self._space.step
        self._index: dict[pymunk.Shape, int] = {}
        self._bodies: list[pymunk.Body] = []
        self._persistence = self._space.collision_persistence
        self._buffer = batch.Buffer()
        self.friction: ContactFriction | None = None
        self._falling = SpeedDependentRestitution.of(scene.physics)
        self._normals = Normals(scene)
        if self.tuned:
            self._tune()
            if rubs(scene):
                self.friction = ContactFriction(scene)
        if settings.iterations is not None:
            self._space.iterations = settings.iterations
        self.iterations = self._space.iterations
        for i in range(len(scene.balls)):
            self._add_ball(i)
        for side in sides_of(scene):
            self._add_side(side)
        for part in parts_of(scene):
            self._add_part(part)
        for other in (_BALL, _CUSHION):
            self._space.on_collision(_BALL, other, post_solve=self._note)

    def read_contacts(self, dt: float) -> None:  # noqa: ARG002
        """Store the collisions of the last step, of `dt` [s]."""
        self.touched = self.contacts_solved > self._solved
        self._solved = self.contacts_solved
        self.collisions, self._found = self._found, []

    @property
    def rubs(self) -> bool:
        """Whether contacts may change spins."""
        return self.friction is not None

    def start(self, velocities: FloatArray, spins: FloatArray | None) -> FloatArray:
        """Set the velocities, (n, 2) [m/s], and spins, (n, 3) [rad/s], of the balls for a step."""
        if self.contacts_solved > self._forgotten:
            self._forgotten = self.contacts_solved
            self._forget_contacts()
        self.set_velocities(velocities)
        if self.friction is not None and spins is not None:
            self.friction.set_spins(spins)
            for body, spin in zip(self._bodies, spins[:, 2].tolist(), strict=True):
                body.angular_velocity = spin
        return velocities

    def turns(self) -> FloatArray:
        """Return the spin changes by the contacts of the step, (n, 3) [rad/s]."""
        assert self.friction is not None
        return self.friction.turns(np.array([body.angular_velocity for body in self._bodies]))

    def positions_and_velocities(self) -> tuple[FloatArray, FloatArray]:
        """Return the centres [m] and velocities [m/s], two arrays (n, 2) float64."""
        self._buffer.clear()
        batch.get_space_bodies(self._space, _STATE, self._buffer)
        values = np.frombuffer(bytes(self._buffer.float_buf())).reshape(-1, 4)
        balls = values[: len(self._bodies)]  # the space's static body comes last
        return balls[:, :2].copy(), balls[:, 2:].copy()

    def set_velocities(self, velocities: FloatArray) -> None:
        """Set the velocities, (n, 2) float64 [m/s]."""
        with_static_body = np.zeros((len(velocities) + 1, 2))
        with_static_body[:-1] = velocities
        buffer = batch.Buffer()
        buffer.set_float_buf(with_static_body)
        batch.set_space_bodies(self._space, batch.BodyFields.VELOCITY, buffer)

    def remove(self, ball: int) -> None:
        """Remove a ball's disc from the space; its body stays, but nothing meets it."""
        self._space.remove(*self._bodies[ball].shapes)

    def add_rolling_joints(self) -> None:
        """Slow every ball by mu g with a joint to the table that can't correct positions.

        The force of the joint is limited to mu m g, so the solver reduces the speed by mu g dt in
        each step, and to exactly 0 in the last step.
        """
        forces = self.scene.rolling_frictions * self.scene.physics.gravity * self.scene.masses
        for body, force in zip(self._bodies, forces.tolist(), strict=True):
            if force == 0.0:
                continue
            joint = pymunk.PivotJoint(self._space.static_body, body, (0.0, 0.0), (0.0, 0.0))
            joint.max_bias = 0.0
            joint.max_force = force
            self._space.add(joint)

    def _forget_contacts(self) -> None:
        """Clear the contacts that the solver stored in the last step, and stop every ball.

        Chipmunk starts a lasting contact with its last impulse times the ratio of the two steps,
        and reverts the whole impulse if the contact has separated. This is right only for equal
        steps. A step without persistence, in which nothing moves, clears the stored contacts. The
        caller sets the velocities again.
        """
        solved = self.contacts_solved
        self.set_velocities(np.zeros((len(self._bodies), 2)))
        self._space.collision_persistence = 0
        self._space.step(_FORGETTING_STEP)
        self._space.collision_persistence = self._persistence
        self.contacts_solved = solved
        self._found = []

    def _tune(self) -> None:
        space = self._space
        space.iterations = TUNED_ITERATIONS
        space.collision_slop = (
            0.0  # the default, 0.1, is meant for pixels; in metres it exceeds a ball
        )
        # A separated contact is new in the next step, not 3 steps later; a value of 0 would disable
        # collisions.
        self._persistence = space.collision_persistence = 1
        for other, restitution in (
            (_BALL, self.scene.physics.ball_restitution),
            (_CUSHION, cushion_restitution(self.scene.physics)),
        ):
            # Set for each pair, because Chipmunk multiplies two elasticities, and no factors suit
            # inelastic balls (e = 0) with elastic cushions.
            space.on_collision(_BALL, other, pre_solve=self._prepare, data=restitution)

    def _add_ball(self, i: int) -> None:
        ball = self.scene.balls[i]
        moment = pymunk.moment_for_circle(ball.mass, 0.0, ball.radius)
        if self.tuned:  # the moment of a ball, not of a disc; without friction a ball never turns
            moment = math.inf if self.friction is None else 0.4 * ball.mass * ball.radius**2
        body = pymunk.Body(ball.mass, moment)
        body.position = ball.position[0], ball.position[1]
        body.velocity = ball.velocity[0], ball.velocity[1]
        shape = pymunk.Circle(body, ball.radius)
        shape.elasticity = self.scene.physics.ball_restitution
        shape.collision_type = _BALL
        self._space.add(body, shape)
        self._bodies.append(body)
        self._index[shape] = i

    def _add_side(self, side: Side) -> None:
        radius = CUSHION_THICKNESS if self.tuned else 0.0
        beyond = CUSHION_THICKNESS + reach_beyond(self.scene) if self.tuned else 0.0
        spine = side.ends(beyond, outward=radius)
        self._add_cushion(pymunk.Segment(self._space.static_body, *spine, radius), side.cushion)

    def _add_part(self, part: Segment | Disc) -> None:
        """Add a disc, or a segment without thickness: thickness would reach into the table."""
        body = self._space.static_body
        if isinstance(part, Disc):
            shape: pymunk.Shape = pymunk.Circle(body, part.radius, part.centre)
        else:
            shape = pymunk.Segment(body, part.start, part.end, 0.0)
        self._add_cushion(shape, part.obstacle)

    def _add_cushion(self, shape: pymunk.Shape, index: int) -> None:
        shape.elasticity = cushion_restitution(self.scene.physics)
        shape.collision_type = _CUSHION
        self._space.add(shape)
        self._index[shape] = index

    def _parts(self, arbiter: pymunk.Arbiter) -> Collision:
        shape_a, shape_b = arbiter.shapes
        cushion = shape_b.collision_type == _CUSHION
        return Collision(self._index[shape_a], self._index[shape_b], cushion)

    def _prepare(self, arbiter: pymunk.Arbiter, _space: pymunk.Space, restitution: float) -> None:
        arbiter.restitution = restitution
        if self.friction is None and self._falling is None:
            return
        contact = self._parts(arbiter)
        one = self._bodies[contact.a]
        line, velocity = (0.0, 0.0), one.velocity
        if contact.cushion:
            nx, ny = self._normals.at(contact.b, one.position)
            line = -nx, -ny
            if self._falling is not None:
                arbiter.restitution = self._falling.at((nx, ny), velocity)
        if self.friction is not None:
            if not contact.cushion:
                other = self._bodies[contact.b]
                line, velocity = other.position - one.position, one.velocity - other.velocity
            arbiter.friction = self.friction.prepare(contact, line, velocity)

    def _note(self, arbiter: pymunk.Arbiter, _space: pymunk.Space, _data: object) -> None:
        self.contacts_solved += 1
        if self.friction is None and not arbiter.is_first_contact:
            return
        contact = self._parts(arbiter)
        impulse = arbiter.total_impulse
        if self.friction is not None:
            normal = self.friction.normal_part(contact, impulse.x, impulse.y)
            self.friction.note(contact, normal)
        if not arbiter.is_first_contact:
            return
        noise = min(self._impulse_rounding[contact.balls])
        # The callback also fires for separating discs that overlap: no impulse, no collision.
        # Contact with two parts of one cushion at once is one collision.
        if impulse.length > noise and contact not in self._found:
            self._found.append(contact)
