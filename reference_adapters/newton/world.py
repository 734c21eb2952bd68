"""A scene as a Newton model: spheres in the plane of the table, or on a plane under gravity.

Each kernel launch from Python takes some 20 us, and a step has tens of them. So fixed steps are
recorded once as a Warp graph and replayed. Steps that end at contacts differ in length, so they are
launched. On the CPU, the arrays of Warp are memory that NumPy reads and writes without a copy.
"""

from __future__ import annotations

import math
from itertools import combinations, product
from typing import Any

import newton
import numpy as np
import warp

from ghostball.model import Disc, Scene, Segment
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.newton.engine import TUNED_ITERATIONS, NewtonSettings
from ghostball.reference_adapters.output import captured
from ghostball.reference_adapters.stepping.contact_world import (
    REMOVED_COORDINATE,
    SINGLE_PRECISION_NOISE,
    THICKNESS,
    ContactWorld,
    WorldBody,
    collision_of,
)
from ghostball.reference_adapters.stepping.laws import (
    ball_friction,
    cushion_friction,
    restitutions,
    rubs,
)
from ghostball.reference_adapters.stepping.plane import Collision
from ghostball.reference_adapters.stepping.sides import parts_of, sides_of

DEVICE = "cpu"

GAP = 5e-7
"""Gap below which contacts are found when tuned [m]: the rounding of coordinates on a table.

Newton's default is 0.2 m: contacts keep the normal that they had before the balls touched.
"""

_CLOTH: WorldBody = (-1, True)

_ARRAYS = ("joint_q", "joint_qd", "body_q", "body_qd")
"""The motion in a state of Newton: Steel reads that of joints, XPBD that of bodies."""

warp.config.log_level = warp.LOG_WARNING  # otherwise Warp prints each kernel that it loads
with captured(errors=True):  # Warp reports a missing NVIDIA driver, which isn't needed
    warp.init()


class NewtonWorld(ContactWorld):
    """A model with its balls in the order of the scene, and the collisions of its last step.

    `on_cloth`: as in `SpaceWorld`.
    """

    def __init__(self, scene: Scene, settings: NewtonSettings, *, own_cloth: bool) -> None:
        super().__init__(scene, noise=SINGLE_PRECISION_NOISE, rubs=rubs(scene) or own_cloth)
        self._tuned = settings.config == "tuned"
        self._own_cloth = own_cloth
        self.on_cloth: set[int] = set()
        self._parts: list[WorldBody] = []  # of each shape
        gravity = scene.physics.gravity if own_cloth else 0.0
        self._builder = newton.ModelBuilder(gravity=(0.0, 0.0, -gravity))
        newton.solvers.SolverSteel.register_custom_attributes(self._builder)
        self._add_bodies()
        self._model = self._builder.finalize(device=DEVICE)
        if self._tuned:  # Steel's default damps spins by 5 % in a second
            self._model.steel.rigid_body_angular_damping.fill_(0.0)
        self._solver = self._make_solver(settings)
        self.iterations = int(self._solver.iterations)
        self._now, self._next = self._model.state(), self._model.state()
        self._control = self._model.control()
        pairs = self._pairs()
        self._pipeline = newton.CollisionPipeline(
            self._model,
            rigid_contact_max=max(len(pairs), 1),  # by default 1000 or more: slower steps
            broad_phase="explicit",
            shape_pairs_filtered=warp.array(pairs, dtype=warp.vec2i, device=DEVICE),
        )
        self._contacts = self._pipeline.contacts()
        # Views of the memory of Warp's arrays, not copies. A row has a place and a quaternion, or a
        # velocity and a spin.
        self._places = [getattr(self._now, name).numpy() for name in ("body_q", "joint_q")]
        self._motions = [getattr(self._now, name).numpy() for name in ("body_qd", "joint_qd")]
        self._places[1] = self._places[1].reshape(-1, 7)
        self._motions[1] = self._motions[1].reshape(-1, 6)
        self._count = self._contacts.rigid_contact_count.numpy()
        self._shapes = [
            self._contacts.rigid_contact_shape0.numpy(),
            self._contacts.rigid_contact_shape1.numpy(),
        ]
        self._observed = self._solver.observables(["contact_f"], contacts=self._contacts)
        self._forces = self._observed.contact_f.numpy()
        self._replays = settings.contact_steps == "fixed"
        self._graph: Any = None
        self._graph_dt = math.nan
        self._load_kernels()

    def start(self, velocities: FloatArray, spins: FloatArray | None) -> FloatArray:
        """Set the velocities, (n, 2) [m/s], and spins, (n, 3) [rad/s], of the balls for a step."""
        for places, motions in zip(self._places, self._motions, strict=True):
            motions[:, :2] = velocities
            motions[:, 2] = 0.0
            if spins is not None:
                motions[:, 3:] = spins
                places[:, 2:] = 0.0, 0.0, 0.0, 0.0, 1.0  # back to the plane, not turned
        self._given = self._velocities()
        self._start = self._spins()
        return self._given

    def advance(self, dt: float) -> None:
        """Advance Newton by `dt` [s]: it finds contacts, solves velocities, then moves."""
        if self._replays and dt != self._graph_dt:
            self._graph, self._graph_dt = self._record(dt), dt
        if self._replays:
            warp.capture_launch(self._graph)
        else:
            self._launch(dt)

    def positions_and_velocities(self) -> tuple[FloatArray, FloatArray]:
        """Return the centres [m] and velocities [m/s], two arrays (n, 2) float64."""
        return self._centres(), self._kept(self._velocities())

    def turns(self) -> FloatArray:
        """Return the spin changes by the contacts of the step, (n, 3) [rad/s]."""
        return self._turned(self._spins())

    def motion(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return centres [m], velocities [m/s] and spins [rad/s], three arrays (n, 3)."""
        centres = np.array(self._places[0][:, :3], dtype=np.float64)
        return centres, np.array(self._motions[0][:, :3], dtype=np.float64), self._spins()

    def set_motion(self, velocities: FloatArray, spins: FloatArray) -> None:
        """Set the velocities [m/s] and spins [rad/s], two arrays (n, 3)."""
        for motions in self._motions:
            motions[:, :3], motions[:, 3:] = velocities, spins

    def remove(self, ball: int) -> None:
        """Move a ball to a place that nothing can reach; it stays in the list."""
        for places in self._places:
            places[ball, 0] = REMOVED_COORDINATE * (ball + 1)

    def _centres(self) -> FloatArray:
        return np.array(self._places[0][:, :2], dtype=np.float64)

    def _velocities(self) -> FloatArray:
        return np.array(self._motions[0][:, :2], dtype=np.float64)

    def _spins(self) -> FloatArray:
        return np.array(self._motions[0][:, 3:], dtype=np.float64)

    def _load_kernels(self) -> None:
        """Compile or load the kernels by a step from the initial state, which is restored.

        A recording can't compile kernels, and the run time must not contain the compilation.
        """
        saved = [view.copy() for view in (*self._places, *self._motions)]
        self._launch(1e-9)
        for view, values in zip((*self._places, *self._motions), saved, strict=True):
            view[:] = values

    def _record(self, dt: float) -> Any:
        """Return a step of `dt` [s] as a graph, which is replayed without Python."""
        with warp.ScopedCapture(device=DEVICE) as capture:
            self._launch(dt)
        return capture.graph

    def _launch(self, dt: float) -> None:
        self._pipeline.collide(self._now, self._contacts)
        self._solver.step(
            self._now, self._next, self._control, self._contacts, dt, observables=self._observed
        )
        for name in _ARRAYS:
            warp.copy(getattr(self._now, name), getattr(self._next, name))

    def read_contacts(self, dt: float) -> None:
        """Store the collisions of the last step, of `dt` [s]."""
        pushing: set[Collision] = set()
        near: set[Collision] = set()
        self.on_cloth = set()
        count = int(self._count[0])
        forces = np.linalg.norm(self._forces[:count, :3], axis=1)
        for one, other, force in zip(*self._shapes, forces, strict=False):
            pushed = float(force) * dt > self._noise
            parts = [self._parts[shape] for shape in (one, other)]
            if _CLOTH not in parts:
                (pushing if pushed else near).add(collision_of(*parts))
            elif pushed:
                self.on_cloth.add(max(parts)[0])
        self._note(pushing, near - pushing)

    def _make_solver(self, settings: NewtonSettings) -> Any:
        iterations = {} if settings.iterations is None else {"iterations": settings.iterations}
        if settings.solver_used == "xpbd":
            return newton.solvers.SolverXPBD(self._model, enable_restitution=True, **iterations)
        if not self._tuned:
            return newton.solvers.SolverSteel(self._model, **iterations)
        return newton.solvers.SolverSteel(
            self._model,
            **({"iterations": TUNED_ITERATIONS} | iterations),
            # Three rows per contact: a ball touches up to six equal balls and two cushions.
            free_body_constraint_max=max(512, 24 * len(self._scene.balls)),
            friction_anchor_beta=0.0,  # friction at a point; patches take four times as long
            baumgarte=0.0,  # otherwise overlapping balls that separate slowly gain speed
            cfm=0.0,  # otherwise impulses are too small
            restitution_velocity_threshold=0.0,  # 0.5 m/s by default: slower balls don't bounce
        )

    def _add_bodies(self) -> None:
        """Add the balls, the cushions and the cloth.

        Newton takes the mean of the coefficients of two shapes. A ball therefore has three shapes,
        for balls, cushions and cloth, and both shapes of a contact have equal coefficients.
        """
        physics = self._scene.physics
        e_ball, e_cushion = restitutions(physics)
        by_balls = self._shape(e_ball, ball_friction(self._scene))
        by_cushions = self._shape(e_cushion, cushion_friction(physics))
        by_cloth = self._shape(0.0, float(self._scene.sliding_frictions[0]))
        for i, ball in enumerate(self._scene.balls):
            moment = 0.4 * ball.mass * ball.radius**2
            x, y, z = ball.position
            body = self._builder.add_body(
                xform=warp.transform((x, y, z if self._own_cloth else 0.0), warp.quat_identity()),
                mass=ball.mass,
                inertia=warp.mat33(np.diag([moment] * 3)),
            )
            for shape in (by_balls, by_cushions, by_cloth):
                self._builder.add_shape_sphere(body, radius=ball.radius, cfg=shape)
                self._parts.append((i, False))
        for side in sides_of(self._scene):
            plane = (*side.normal, 0.0, -float(np.dot(side.normal, side.point)))
            self._builder.add_shape_plane(plane=plane, width=0.0, length=0.0, cfg=by_cushions)
            self._parts.append((side.cushion, True))
        for part in parts_of(self._scene):
            self._add_part(part, by_cushions)
            self._parts.append((part.obstacle, True))
        if self._own_cloth:
            self._builder.add_shape_plane(width=0.0, length=0.0, cfg=by_cloth)
            self._parts.append(_CLOTH)

    def _pairs(self) -> list[tuple[int, int]]:
        """Return the pairs of shapes that can touch; see `_add_bodies`."""
        end = 3 * len(self._scene.balls)
        cushions = range(end, len(self._parts) - self._own_cloth)
        cloths = range(cushions.stop, len(self._parts))
        return [
            *combinations(range(0, end, 3), 2),
            *product(range(1 if self._tuned else 0, end, 3), cushions),
            *product(range(2, end, 3), cloths),
        ]

    def _add_part(self, part: Segment | Disc, shape: Any) -> None:
        height = float(self._scene.radii[0]) if self._own_cloth else 0.0
        if isinstance(part, Disc):
            at = warp.transform((*part.centre, height), warp.quat_identity())
            self._builder.add_shape_sphere(-1, xform=at, radius=part.radius, cfg=shape)
            return
        (x0, y0), (x1, y1) = part.start, part.end
        turned = warp.quat_from_axis_angle(warp.vec3(0.0, 0.0, 1.0), math.atan2(y1 - y0, x1 - x0))
        self._builder.add_shape_box(
            -1,
            xform=warp.transform((0.5 * (x0 + x1), 0.5 * (y0 + y1), height), turned),
            hx=0.5 * math.dist(part.start, part.end),
            hy=THICKNESS,
            hz=2.0 * float(np.max(self._scene.radii)),
            cfg=shape,
        )

    def _shape(self, restitution: float, friction: float) -> Any:
        gap = {"gap": 0.5 * GAP} if self._tuned else {}
        return newton.ModelBuilder.ShapeConfig(
            density=0.0,  # the mass is the body's
            restitution=restitution,
            mu=friction,
            mu_torsional=0.0,
            mu_rolling=0.0,
            **gap,
        )
