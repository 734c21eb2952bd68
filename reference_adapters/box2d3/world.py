"""A scene as a Box2D 3 world: balls are discs that don't rotate, cushions are segments."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pyb2d3

from ghostball.model import Disc, Scene, Segment
from ghostball.model.arrays import FloatArray
from ghostball.model.scene.sides import Point
from ghostball.reference_adapters.box2d3.engine import Box2d3Settings
from ghostball.reference_adapters.stepping.contact_world import (
    SINGLE_PRECISION_NOISE,
    ContactWorld,
    WorldBody,
    collision_of,
    tuples_of,
)
from ghostball.reference_adapters.stepping.laws import cushion_restitution, fastest
from ghostball.reference_adapters.stepping.plane import Planned
from ghostball.reference_adapters.stepping.sides import parts_of, reach_beyond_corners, sides_of

SUB_STEPS = 4
"""Number of sub-steps per step, as in Box2D's manual."""


class Box2d3World(ContactWorld):
    """A world with its balls in the order of the scene, and the collisions of its last step.

    Collisions are Box2D's hit events: bodies that touch at the start of the shot have none.
    """

    def __init__(self, scene: Scene, settings: Box2d3Settings) -> None:
        super().__init__(scene, noise=SINGLE_PRECISION_NOISE, rubs=False, units=settings.units)
        self.iterations = settings.iterations or SUB_STEPS
        values: dict[str, Any] = {"gravity": (0.0, 0.0), "hit_event_threshold": 0.0}
        if settings.config == "tuned":
            speed = max(2.0 * self._units * fastest(scene), 1.0)
            values |= {"restitution_threshold": 0.0, "maximum_linear_speed": speed}
        self._world = pyb2d3.World(**values)
        self._parts: dict[int, WorldBody] = {}
        self._rounded: Sequence[tuple[float, ...]] = ()  # velocities given for a step, in units
        self._balls = [self._ball(i) for i in range(len(scene.balls))]
        for side in sides_of(scene):
            ends = side.ends(reach_beyond_corners(scene))
            self._cushion("segment", self._segment(*ends), side.cushion)
        for part in parts_of(scene):
            self._add_part(part)

    def start(self, velocities: FloatArray, _: FloatArray | None) -> FloatArray:
        """Set the velocities of the balls, (n, 2) [m/s], for a step."""
        (planned,) = self.planned(velocities[np.newaxis])
        self.start_planned(planned)
        return self._given

    def planned(self, velocities: FloatArray) -> Sequence[Planned]:
        """Return the velocities of coming steps, (k, n, 2) [m/s]; see `PlaneWorld`."""
        rounded = (velocities * self._units).astype(np.float32)
        return list(zip(rounded / np.float64(self._units), tuples_of(rounded), strict=True))

    def start_planned(self, planned: Planned) -> None:
        """Set the velocities of the balls for a step."""
        self._given, self._rounded = planned
        for body, velocity in zip(self._balls, self._rounded, strict=True):
            body.linear_velocity = velocity

    def advance(self, dt: float) -> None:
        """Advance Box2D by `dt` [s]: it finds contacts, then solves velocities and moves."""
        self._world.step(dt, self.iterations)

    def read_contacts(self, dt: float) -> None:  # noqa: ARG002
        """Store the collisions of the last step, of `dt` [s]."""
        self.touched = self._have_changed()
        if not self.touched:
            if self._lasting:
                self._note(set())
            return
        events = self._world.get_contact_events().hit_events()
        self._note(
            {
                collision_of(self._parts[event.shape_a.id], self._parts[event.shape_b.id])
                for event in events
            }
        )

    def positions_and_velocities(self) -> tuple[FloatArray, FloatArray]:
        """Return the centres [m] and velocities [m/s], two arrays (n, 2) float64."""
        places = np.array([(body.position.x, body.position.y) for body in self._balls])
        return places / self._units, self._velocities()

    def _have_changed(self) -> bool:
        """Return whether the last step changed a velocity; a lasting contact has no event."""
        for body, (x, y) in zip(self._balls, self._rounded, strict=True):
            velocity = body.linear_velocity
            if velocity.x != x or velocity.y != y:
                return True
        return False

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

    def remove(self, ball: int) -> None:
        """Remove a ball: it stays in the list, but nothing meets it."""
        self._balls[ball].enabled = False

    def _add_part(self, part: Segment | Disc) -> None:
        if isinstance(part, Disc):
            x, y = (self._units * place for place in part.centre)
            circle = pyb2d3.circle(center=(x, y), radius=self._units * part.radius)
            self._cushion("circle", circle, part.obstacle)
        else:
            self._cushion("segment", self._segment(part.start, part.end), part.obstacle)

    def _segment(self, *ends: Point) -> Any:
        return pyb2d3.segment(*((self._units * x, self._units * y) for x, y in ends))

    def _cushion(self, kind: str, geometry: Any, index: int) -> None:
        definition = self._definition(cushion_restitution(self._scene.physics))
        create = getattr(self._world.create_static_body(), f"create_{kind}_shape")
        self._parts[create(definition, geometry).id] = index, True

    @staticmethod
    def _definition(restitution: float) -> Any:
        material = pyb2d3.surface_material(restitution=restitution, friction=0.0)
        return pyb2d3.shape_def(material=material, enable_hit_events=True)
