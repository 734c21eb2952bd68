"""A scene as a Pymunk space: balls are discs seen from above, cushions are static segments.

Two ways to build it, after what experiments with Chipmunk's solver showed (`tuned`), and what a
newcomer types who has read the examples (`default`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pymunk
from numpy.typing import NDArray
from pymunk import batch

from ghostball.engine import CUSHIONS, Scene, Table
from ghostball.engine.result import initial_state
from ghostball.engine.trajectory import energy_of
from ghostball.reference_adapters.pymunk.friction import ContactFriction

FloatArray = NDArray[np.float64]

_BALL, _CUSHION = 1, 2  # collision types
_STATE = batch.BodyFields.POSITION | batch.BodyFields.VELOCITY

CUSHION_THICKNESS = 0.5
"""Radius of a tuned cushion's segment [m].

A ball that enters a segment less than half way is pushed back; the thicker, the faster it may come.
"""

TUNED_ITERATIONS = 30
"""Solver iterations; each also costs a pass over the rolling joints.

In elastic breaks of a touching rack of 15, Chipmunk's default of 10 gains up to 3e-4 of the energy,
30 lose less than 1e-9.
"""

_FORGETTING_STEP = 1e-9
"""Step that empties the solver's memory [s]; no ball moves in it, so its length has no effect."""


class Collision(NamedTuple):
    """A collision of the last step.

    Attributes
    ----------
    a : int
        A ball.
    b : int
        The other ball, or the index of the cushion.
    cushion : bool
        Which of the two `b` is.
    """

    a: int
    b: int
    cushion: bool


class World:
    """A space with its balls in the scene's order, and the collisions of its last step.

    Attributes
    ----------
    collisions : list of Collision
        Of the last step.
    contacts_solved : int
        How many contacts the solver has worked on, one for each step that a contact lasts.
    friction : ContactFriction or None
        Friction at contacts, which its user tells the spins; None where nothing rubs.
    """

    def __init__(self, scene: Scene, *, tuned: bool, iterations: int | None) -> None:
        self.scene = scene
        self.collisions: list[Collision] = []
        self.contacts_solved = 0
        self.tuned = tuned
        self._tangential = scene.physics.cushion_tangential_restitution
        if scene.physics.cushion != "restitution":
            self._tangential = 1.0
        # Rounding of the momentum that each ball would have with all the energy: balls that roll on
        # together exchange impulses of this size, and don't collide.
        momenta = np.sqrt(2.0 * _energy(scene) * scene.masses)
        self._impulse_rounding = 16.0 * np.finfo(np.float64).eps * momenta
        self._space = pymunk.Space()
        self._index: dict[pymunk.Shape, int] = {}
        self._bodies: list[pymunk.Body] = []
        self._persistence = self._space.collision_persistence
        self._buffer = batch.Buffer()
        self.friction: ContactFriction | None = None
        if tuned:
            self._tune()
            if ContactFriction.needed(scene):
                self.friction = ContactFriction(scene, self._bodies)
        if iterations is not None:
            self._space.iterations = iterations
        for i in range(len(scene.balls)):
            self._add_ball(i, tuned=tuned)
        if scene.table is not None:
            for name in scene.table.cushions:
                self._add_cushion(scene.table, CUSHIONS.index(name), tuned=tuned)
        for other in (_BALL, _CUSHION):
            self._space.on_collision(_BALL, other, post_solve=self._note)

    def step(self, dt: float) -> None:
        """Let Pymunk step by `dt` [s]: it moves, then finds overlaps, then solves velocities."""
        self.collisions.clear()
        self._space.step(dt)
        if self._tangential != 1.0:
            self._scale_along_cushions()

    @property
    def iterations(self) -> int:
        """Iterations of the contact solver in each step."""
        return self._space.iterations

    def forget_contacts(self) -> None:
        """Drop what the solver remembers of the last step's contacts, and stop every ball.

        Chipmunk starts a lasting contact with its last impulse times the ratio of the two steps,
        and takes back the whole impulse where the contact has come apart: right for equal steps
        only. A step without persistence, in which nothing moves, empties that memory. The caller
        sets the velocities anew.
        """
        solved = self.contacts_solved
        self.set_velocities(np.zeros((len(self._bodies), 2)))
        self._space.collision_persistence = 0
        self._space.step(_FORGETTING_STEP)
        self._space.collision_persistence = self._persistence
        self.contacts_solved = solved

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

    def add_rolling_joints(self) -> None:
        """Slow every ball by mu g with a joint to the table that can't correct positions.

        Its force is limited to mu m g, so the solver takes mu g dt from the speed in each step, and
        what is left in the last one: an exact stop.
        """
        forces = self.scene.rolling_frictions * self.scene.physics.gravity * self.scene.masses
        for body, force in zip(self._bodies, forces.tolist(), strict=True):
            if force == 0.0:
                continue
            joint = pymunk.PivotJoint(self._space.static_body, body, (0.0, 0.0), (0.0, 0.0))
            joint.max_bias = 0.0
            joint.max_force = force
            self._space.add(joint)

    def _tune(self) -> None:
        space = self._space
        space.iterations = TUNED_ITERATIONS
        space.collision_slop = 0.0  # the default, 0.1, is in pixels: here more than a ball
        # A contact that has come apart is a new one in the next step, not 3 steps later; a value
        # of 0 would disable collisions.
        self._persistence = space.collision_persistence = 1
        for other, restitution in (
            (_BALL, self.scene.physics.ball_restitution),
            (_CUSHION, cushion_restitution(self.scene)),
        ):
            # Set for the pair: Chipmunk multiplies two elasticities, and no product is right for
            # dead balls (e = 0) at live cushions.
            space.on_collision(_BALL, other, pre_solve=self._prepare, data=restitution)

    def _add_ball(self, i: int, *, tuned: bool) -> None:
        ball = self.scene.balls[i]
        moment = pymunk.moment_for_circle(ball.mass, 0.0, ball.radius)
        if tuned:  # a disc's moment isn't a ball's, and without friction no contact turns it
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

    def _add_cushion(self, table: Table, cushion: int, *, tuned: bool) -> None:
        # Each runs along one axis, at `nose` on the other.
        across, nose, outward, length = (
            (0, 0.0, -1.0, table.width),
            (0, table.length, 1.0, table.width),
            (1, 0.0, -1.0, table.length),
            (1, table.width, 1.0, table.length),
        )[cushion]
        radius = CUSHION_THICKNESS if tuned else 0.0
        beyond = CUSHION_THICKNESS + self._reach_beyond(table) if tuned else 0.0
        spine = nose + outward * radius
        start, end = (
            (spine, along) if across == 0 else (along, spine)
            for along in (-beyond, length + beyond)
        )
        shape = pymunk.Segment(self._space.static_body, start, end, radius)
        shape.elasticity = cushion_restitution(self.scene)
        shape.collision_type = _CUSHION
        self._space.add(shape)
        self._index[shape] = cushion

    def _reach_beyond(self, table: Table) -> float:
        """Return how far outside an open table a ball can get [m]; 0 where it is closed.

        A cushion is an infinite line; one ball can't have more than all the energy.
        """
        if len(table.cushions) == len(CUSHIONS):
            return 0.0
        scene = self.scene
        speed = math.sqrt(2.0 * _energy(scene) / float(np.min(scene.masses)))
        frictions = [scene.rolling_frictions]
        if scene.physics.motion == "sliding":
            frictions.append(scene.sliding_frictions)
        deceleration = float(np.min(frictions)) * scene.physics.gravity
        distances = [speed**2 / (2.0 * deceleration)] if deceleration > 0.0 else []
        distances += [speed * scene.t_max] if scene.t_max is not None else []
        outside = float(np.max(np.abs(scene.positions)))  # open sides: a ball may start anywhere
        return outside + min(distances, default=0.0)

    def _scale_along_cushions(self) -> None:
        for contact in self.collisions:
            if contact.cushion:
                vx, vy = self._bodies[contact.a].velocity
                across = CUSHIONS[contact.b] in ("left", "right")
                kx, ky = (1.0, self._tangential) if across else (self._tangential, 1.0)
                self._bodies[contact.a].velocity = kx * vx, ky * vy

    def _parts(self, arbiter: pymunk.Arbiter) -> Collision:
        shape_a, shape_b = arbiter.shapes
        cushion = shape_b.collision_type == _CUSHION
        return Collision(self._index[shape_a], self._index[shape_b], cushion)

    def _prepare(self, arbiter: pymunk.Arbiter, _space: pymunk.Space, restitution: float) -> None:
        arbiter.restitution = restitution
        if self.friction is not None:
            a, b, cushion = self._parts(arbiter)
            self.friction.prepare(arbiter, a, b, cushion=cushion)

    def _note(self, arbiter: pymunk.Arbiter, _space: pymunk.Space, _data: object) -> None:
        self.contacts_solved += 1
        if self.friction is None and not arbiter.is_first_contact:
            return
        a, b, cushion = self._parts(arbiter)
        if self.friction is not None:
            self.friction.note(arbiter, a, b, cushion=cushion)
        if not arbiter.is_first_contact:
            return
        noise = self._impulse_rounding[a] if cushion else min(self._impulse_rounding[[a, b]])
        # `begin` also fires for discs that overlap while they move apart: no impulse, no collision.
        if arbiter.total_impulse.length > noise:
            self.collisions.append(Collision(a, b, cushion))


def cushion_restitution(scene: Scene) -> float:
    """Return the normal restitution of the scene's cushions."""
    physics = scene.physics
    return 1.0 if physics.cushion == "mirror" else physics.cushion_restitution


def _energy(scene: Scene) -> float:
    """Return the scene's energy [J]; a spin counts, sliding can turn it into speed."""
    return float(energy_of(scene, initial_state(scene)).total[0])
