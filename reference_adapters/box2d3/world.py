"""A scene as a Box2D 3 world: balls are discs that don't turn, cushions are segments."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyb2d3
from numpy.typing import NDArray

from ghostball.engine import CUSHIONS, Scene
from ghostball.reference_adapters.box2d3.engine import Box2d3Settings
from ghostball.reference_adapters.stepping.contact_world import SINGLE, ContactWorld
from ghostball.reference_adapters.stepping.plane import (
    Collision,
    cushion_restitution,
    fastest,
    reach_beyond,
)

FloatArray = NDArray[np.float64]

SUB_STEPS = 4
"""Of a step, as Box2D's manual has it."""


class World(ContactWorld):
    """A world with its balls in the scene's order, and the collisions of its last step.

    Collisions are Box2D's events of hits: two bodies that touch as the shot begins have none.
    """

    def __init__(self, scene: Scene, settings: Box2d3Settings) -> None:
        super().__init__(scene, noise=SINGLE, rubs=False)
        self._units = settings.units
        self._iterations = settings.iterations or SUB_STEPS
        values: dict[str, Any] = {"gravity": (0.0, 0.0), "hit_event_threshold": 0.0}
        if settings.config == "tuned":
            speed = max(2.0 * self._units * fastest(scene), 1.0)
            values |= {"restitution_threshold": 0.0, "maximum_linear_speed": speed}
        self._world = pyb2d3.World(**values)
        self._parts: dict[int, tuple[int, bool]] = {}
        self._balls = [self._ball(i) for i in range(len(scene.balls))]
        for name in () if scene.table is None else scene.table.cushions:
            self._cushion(CUSHIONS.index(name))

    @property
    def iterations(self) -> int:
        """Sub-steps of each step."""
        return self._iterations

    def start(self, velocities: FloatArray, _: FloatArray | None) -> FloatArray:
        """Give the balls velocities, (n, 2) [m/s], for a step."""
        for body, (x, y) in zip(self._balls, (velocities * self._units).tolist(), strict=True):
            body.linear_velocity = (x, y)
        self._given = self._velocities()
        return self._given

    def step(self, dt: float) -> None:
        """Let Box2D step by `dt` [s]: it finds contacts, then solves velocities and moves."""
        self._world.step(dt, self._iterations)
        hits: set[Collision] = set()
        for hit in self._world.get_contact_events().hit_events():
            parts = [self._parts[hit.shape_a.id], self._parts[hit.shape_b.id]]
            one, other = sorted(parts, key=lambda part: part[::-1])
            hits.add(Collision(one[0], *other))
        self._note(hits)

    def positions_and_velocities(self) -> tuple[FloatArray, FloatArray]:
        """Return the centres [m] and velocities [m/s], two arrays (n, 2) float64."""
        places = np.array([(body.position.x, body.position.y) for body in self._balls])
        return places / self._units, self._velocities()

    def turns(self) -> FloatArray:
        """Return what the step's contacts added to the spins, (n, 3) [rad/s]: nothing rubs."""
        return np.zeros((len(self._balls), 3))

    def _velocities(self) -> FloatArray:
        pairs = [body.linear_velocity for body in self._balls]
        return np.array([(pair.x, pair.y) for pair in pairs]) / self._units

    def _ball(self, i: int) -> Any:
        ball, units = self._scene.balls[i], self._units
        body = self._world.create_dynamic_body(
            position=(units * ball.position[0], units * ball.position[1]),
            fixed_rotation=True,
            enable_sleep=False,
        )
        radius = units * ball.radius
        definition = self._definition(self._scene.physics.ball_restitution)
        definition.density = ball.mass / (np.pi * radius**2)
        shape = body.create_circle_shape(definition, pyb2d3.circle(radius=radius))
        self._parts[shape.id] = i, False
        return body

    def _cushion(self, cushion: int) -> None:
        table, units = self._scene.table, self._units
        assert table is not None
        beyond = reach_beyond(self._scene) + table.length
        start, end = (
            ((0.0, -beyond), (0.0, table.width + beyond)),
            ((table.length, -beyond), (table.length, table.width + beyond)),
            ((-beyond, 0.0), (table.length + beyond, 0.0)),
            ((-beyond, table.width), (table.length + beyond, table.width)),
        )[cushion]
        definition = self._definition(cushion_restitution(self._scene.physics))
        edge = pyb2d3.segment(*((units * x, units * y) for x, y in (start, end)))
        shape = self._world.create_static_body().create_segment_shape(definition, edge)
        self._parts[shape.id] = cushion, True

    @staticmethod
    def _definition(restitution: float) -> Any:
        material = pyb2d3.surface_material(restitution=restitution, friction=0.0)
        return pyb2d3.shape_def(material=material, enable_hit_events=True)
