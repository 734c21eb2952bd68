"""A scene as a MuJoCo model: balls are spheres in the plane of the table, cushions are planes.

The heights of MuJoCo are those above the centre of a ball that lies on the cloth.

MuJoCo's contacts are soft, without restitution. A pure damper without a spring makes a contact
hard: `solref` = "0 -b" with b = (1 + e) / dt changes the approach speed v into -e v in one step,
for any e [MuJoCo 4.0's documentation, "Solver parameters"]. A change of the step therefore also
changes the coefficients of the contacts.
"""

from __future__ import annotations

import mujoco
import numpy as np

from ghostball.model import Disc, Scene, Segment, Side
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.stepping.contact_world import DOUBLE_PRECISION_NOISE, ContactWorld
from ghostball.reference_adapters.stepping.laws import (
    ball_friction,
    cushion_friction,
    restitutions,
    rubs,
)
from ghostball.reference_adapters.stepping.plane import Collision
from ghostball.reference_adapters.stepping.settings import SteppingSettings
from ghostball.reference_adapters.stepping.sides import parts_of, sides_of

MARGIN = 1e-9
"""Gap at which balls touch [m]. With 0, touching balls would not collide simultaneously."""

NOSE_RADIUS = 1e-9
"""Radius of a cushion segment, a thin capsule because MuJoCo has no line; at most `MARGIN` [m]."""

REMOVED_GAP = -1e6
"""Contact gap of a removed ball, which can't touch anything [m]."""

MAX_IMPEDANCE = 0.9999
"""Impedance of a contact, MuJoCo's maximum; 1 minus it is the relative error of impulses [1]."""

_CONSTANT_IMPEDANCE = (MAX_IMPEDANCE, MAX_IMPEDANCE, 0.001, 0.5, 2.0)  # independent of the overlap


class MujocoWorld(ContactWorld):
    """A model with its balls in the order of the scene, and the collisions of its last step.

    Tuned, contacts are dampers; otherwise they have MuJoCo's defaults. A ball has six degrees of
    freedom if contacts have friction, otherwise two.

    `on_cloth`: as in `SpaceWorld`.
    """

    def __init__(self, scene: Scene, settings: SteppingSettings, *, own_cloth: bool) -> None:
        super().__init__(scene, noise=DOUBLE_PRECISION_NOISE, rubs=rubs(scene) or own_cloth)
        self._own_cloth = own_cloth
        self.on_cloth: set[int] = set()
        self._tuned = settings.config == "tuned"
        self._n = len(scene.balls)
        self._cushions = [side.cushion for side in sides_of(scene)]
        self._cushions += [part.obstacle for part in parts_of(scene)]
        # In MuJoCo's order: the cushions, the cloth if there is one, the balls.
        self._cloth = len(self._cushions) if own_cloth else -1
        self._first = len(self._cushions) + own_cloth
        ball, cushion = restitutions(scene.physics)
        landing = scene.physics.table_restitution if scene.physics.airborne else 0.0
        self._bounces = (1.0 + ball, 1.0 + cushion, 1.0 + landing)
        self._model = self._compile(scene, settings.iterations)
        earlier = np.minimum(self._model.pair_geom1, self._model.pair_geom2)
        kinds = np.where(earlier >= self._first, 0, np.where(earlier == self._cloth, 2, 1))
        self._pair_bounces = np.array(self._bounces)[kinds]
        self.iterations = int(self._model.opt.iterations)
        self._data = mujoco.MjData(self._model)
        width = 7 if self.rubs else 2
        self._places = self._data.qpos.reshape(self._n, width)
        self._motions = self._data.qvel.reshape(self._n, 6 if self.rubs else 2)
        self._places[:, :2] = scene.positions[:, :2]
        if own_cloth:
            self._places[:, 2] = scene.positions[:, 2] - scene.radii
        self._force = np.zeros(6)  # force of a contact, normal component first
        self._dt = 0.0

    def start(self, velocities: FloatArray, spins: FloatArray | None) -> FloatArray:
        """Set the velocities, (n, 2) [m/s], and spins, (n, 3) [rad/s], of the balls for a step."""
        self._motions[:, :2] = velocities
        if spins is not None:
            # In the plane and without rotation, because MuJoCo's angular velocities are in the
            # ball's frame.
            self._places[:, 2:] = 0.0, 1.0, 0.0, 0.0, 0.0
            self._motions[:, 2] = 0.0
            self._motions[:, 3:] = spins
            self._start = spins
        return velocities

    def advance(self, dt: float) -> None:
        """Advance MuJoCo by `dt` [s]: it finds contacts, solves velocities, then moves."""
        if dt != self._dt:
            self._model.opt.timestep = self._dt = dt
            if self._tuned:
                self._set_dampers(dt)
        mujoco.mj_step(self._model, self._data)

    def read_contacts(self, dt: float) -> None:
        """Store the collisions of the last step, of `dt` [s]."""
        self.touched = self._data.ncon > 0
        self._note(self._pushed(dt))

    def positions_and_velocities(self) -> tuple[FloatArray, FloatArray]:
        """Return the centres [m] and velocities [m/s], two arrays (n, 2) float64."""
        return self._places[:, :2].copy(), self._motions[:, :2].copy()

    def turns(self) -> FloatArray:
        """Return the spin changes by the contacts of the step, (n, 3) [rad/s]."""
        # The frame of the ball has turned by at most half a step of the mean spin; the spin given
        # by a contact at the start of the step is rotated back with the frame.
        return self._turned(self._spins())

    def _spins(self) -> FloatArray:
        """Return the spins in the frame of the table, (n, 3) [rad/s]; a new array."""
        spins = np.empty((self._n, 3))
        for i in range(self._n):
            mujoco.mju_rotVecQuat(spins[i], self._motions[i, 3:], self._places[i, 3:])
        return spins

    def remove(self, ball: int) -> None:
        """Remove a ball: it stays in the list, but nothing meets it."""
        geom = self._first + ball
        self._model.geom_contype[geom] = self._model.geom_conaffinity[geom] = 0
        of_ball = (self._model.pair_geom1 == geom) | (self._model.pair_geom2 == geom)
        self._model.pair_margin[of_ball] = REMOVED_GAP
        if self._own_cloth:  # nothing bears the ball: it would fall
            body = self._model.geom_bodyid[geom]
            weight = self._model.body_mass[body] * self._scene.physics.gravity
            self._data.xfrc_applied[body, 2] = weight

    def motion(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return centres [m], velocities [m/s] and spins [rad/s], three arrays (n, 3)."""
        centres = self._places[:, :3].copy()
        centres[:, 2] += self._scene.radii
        return centres, self._motions[:, :3].copy(), self._spins()

    def set_motion(self, velocities: FloatArray, spins: FloatArray) -> None:
        """Set the velocities [m/s] and spins [rad/s], two arrays (n, 3)."""
        self._places[:, 3:] = 1.0, 0.0, 0.0, 0.0
        self._motions[:, :3], self._motions[:, 3:] = velocities, spins

    def _pushed(self, dt: float) -> set[Collision]:
        pushing: set[Collision] = set()
        self.on_cloth = set()
        for k, (a, b) in enumerate(self._data.contact.geom.tolist()):
            mujoco.mj_contactForce(self._model, self._data, k, self._force)
            if not self._force[0] * dt > self._noise:
                continue
            if min(a, b) == self._cloth:
                self.on_cloth.add(max(a, b) - self._first)
            else:
                pushing.add(self._collision(max(a, b), min(a, b)))
        return pushing

    def _collision(self, later: int, earlier: int) -> Collision:
        """Return the collision of two geometries; the cushions have the first indices."""
        first = self._first
        if earlier < first:
            return Collision(later - first, self._cushions[earlier], cushion=True)
        return Collision(earlier - first, later - first, cushion=False)

    def _set_dampers(self, dt: float) -> None:
        model = self._model
        ball, cushion, _ = self._bounces
        model.geom_solref[: self._first, 1] = -cushion / dt
        model.geom_solref[self._first :, 1] = -ball / dt
        if self.rubs:
            model.pair_solref[:, 1] = -self._pair_bounces / dt
            # Friction stops the slip. Otherwise the damper would also reverse it.
            model.pair_solreffriction[:, 1] = -1.0 / dt

    def _compile(self, scene: Scene, iterations: int | None) -> mujoco.MjModel:
        spec = mujoco.MjSpec()
        gravity = scene.physics.gravity if self._own_cloth else 0.0
        spec.option.gravity = [0.0, 0.0, -gravity]
        if self._tuned:
            spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
            spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
            spec.option.solver = mujoco.mjtSolver.mjSOL_NEWTON
            spec.option.iterations = 200
            spec.option.tolerance = 1e-14
            spec.option.ls_tolerance = 1e-6
        if iterations is not None:
            spec.option.iterations = iterations
        sides = sides_of(scene)
        for k, side in enumerate(sides):
            self._add_side(spec, f"cushion {k}", side, scene)
        for k, part in enumerate(parts_of(scene), start=len(sides)):
            self._add_part(spec, f"cushion {k}", part, scene)
        if self._own_cloth:
            cloth = spec.worldbody.add_geom(
                name="cloth", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[1, 1, 1]
            )
            cloth.pos = [0.0, 0.0, -scene.balls[0].radius]
        for i in range(self._n):
            self._add_ball(spec, i, scene)
        if self._tuned and self.rubs:
            self._add_pairs(spec, scene)
        return spec.compile()

    def _add_ball(self, spec: mujoco.MjSpec, i: int, scene: Scene) -> None:
        ball = scene.balls[i]
        body = spec.worldbody.add_body()
        if self.rubs:
            body.add_freejoint()
        else:
            for axis in ([1, 0, 0], [0, 1, 0]):
                body.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
        geom = body.add_geom(
            name=f"ball {i}",
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            size=[ball.radius, 0, 0],
            mass=ball.mass,
            friction=[ball_friction(scene), 0.0, 0.0],
        )
        self._harden(geom)

    def _add_part(self, spec: mujoco.MjSpec, name: str, part: Segment | Disc, scene: Scene) -> None:
        if isinstance(part, Disc):
            geom = spec.worldbody.add_geom(
                name=name,
                type=mujoco.mjtGeom.mjGEOM_SPHERE,
                size=[part.radius, 0.0, 0.0],
                pos=[*part.centre, 0.0],
            )
        else:
            geom = spec.worldbody.add_geom(
                name=name,
                type=mujoco.mjtGeom.mjGEOM_CAPSULE,
                size=[NOSE_RADIUS, 0.0, 0.0],
                fromto=[*part.start, 0.0, *part.end, 0.0],
            )
        self._finish_cushion(geom, scene)

    def _add_side(self, spec: mujoco.MjSpec, name: str, side: Side, scene: Scene) -> None:
        nx, ny = side.normal
        geom = spec.worldbody.add_geom(
            name=name,
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=[1, 1, 1],  # for drawing only: a plane is infinite
            pos=[*side.point, 0.0],
            quat=[1.0, -ny, nx, 0.0],  # turns z inward
        )
        self._finish_cushion(geom, scene)

    def _finish_cushion(self, geom: mujoco.MjsGeom, scene: Scene) -> None:
        geom.friction = [cushion_friction(scene.physics), 0.0, 0.0]
        # MuJoCo uses the coefficients of the geometry with the higher priority, without mixing.
        geom.priority = 1
        self._harden(geom)

    def _harden(self, geom: mujoco.MjsGeom) -> None:
        if self._tuned:
            geom.condim = 1
            geom.margin = MARGIN
            geom.solref = [0.0, -1.0]
            geom.solimp = _CONSTANT_IMPEDANCE

    def _add_pairs(self, spec: mujoco.MjSpec, scene: Scene) -> None:
        """Define every pair explicitly, because only pairs have a separate damper for friction."""
        balls = [f"ball {i}" for i in range(self._n)]
        friction = ball_friction(scene)
        pairs: list[tuple[str, str, tuple[float, ...]]]
        pairs = [(a, b, (friction,)) for i, a in enumerate(balls) for b in balls[i + 1 :]]
        mu = cushion_friction(scene.physics)
        cushions = [f"cushion {k}" for k in range(len(self._cushions))]
        pairs += [(ball, cushion, (mu,)) for ball in balls for cushion in cushions]
        if self._own_cloth:
            pairs += [
                (ball, "cloth", of) for ball, of in zip(balls, _cloth_friction(scene), strict=True)
            ]
        for one, other, coefficients in pairs:
            pair = spec.add_pair(geomname1=one, geomname2=other)
            # Sliding friction along two directions, torsional friction, rolling friction about two.
            sliding, spinning, rolling = (*coefficients, 0.0, 0.0)[:3]
            pair.condim = 6 if rolling > 0.0 else 4 if spinning > 0.0 else 3 if sliding > 0.0 else 1
            pair.friction = [sliding, sliding, spinning, rolling, rolling]
            pair.margin = MARGIN
            pair.solref = [0.0, -1.0]
            pair.solreffriction = [0.0, -1.0]
            pair.solimp = _CONSTANT_IMPEDANCE


def _cloth_friction(scene: Scene) -> list[tuple[float, float, float]]:
    """Return the sliding [1], torsional [m] and rolling friction [m] of each ball with the cloth.

    MuJoCo's torsional and rolling friction limit the torque to the coefficient times the normal
    force. The torque 7/5 m R mu g slows a rolling ball by mu g, and 2/5 m R^2 a slows its vertical
    spin by a.
    """
    gravity = scene.physics.gravity
    spinning = 0.4 * scene.radii**2 * scene.spinning_friction_rates / gravity
    rolling = 1.4 * scene.radii * scene.rolling_frictions
    columns = (scene.sliding_frictions, spinning, rolling)
    return list(zip(*(one.tolist() for one in columns), strict=True))
