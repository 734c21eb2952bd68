"""Shots whose end has a closed form, where a proof ends too early.

That is at two collisions of one instant, or where contact is sustained.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from ghostball.engine import Result, Scene
from ghostball.validation.scenes.library import find_scene
from ghostball.validation.stress.sound import Sound
from ghostball.validation.stress.trial import Verdict
from ghostball.validation.truth.closed_forms import closed_form


class End(NamedTuple):
    """How a shot ends: places [m], the instant [s], collisions by kind."""

    places: tuple[tuple[float, float], ...]
    time: float
    collisions: dict[str, int]


def shipped_end(scene: Scene) -> End:
    """Return how a shipped scene that has a closed form ends."""
    form = closed_form(scene)
    assert form is not None
    places = tuple((float(x), float(y)) for x, y in form.rest_positions)
    return End(places, float(form.rest_time), form.collision_counts)


def parting() -> Scene:
    """Return the shot of a ball that pushes another until it rolls, and then is slowed more.

    So a contact that was pressed opens.
    """
    scene = find_scene("push")
    rear, front = scene.balls
    braked = rear.model_copy(update={"rolling_friction": 0.04})
    return scene.model_copy(update={"name": "parting", "title": "", "balls": (braked, front)})


def parted_end(scene: Scene) -> End:
    """Return how `parting` ends.

    While the rear ball slides, both go with (5 mu_s - 7 mu_f) g / 12, mu_f the rolling friction of
    the front ball, as in the shipped scene `push`; the slide ends where a t = R w - (5/2) mu_s g t.
    From there each rolls out alone.
    """
    g, slide = scene.physics.gravity, float(scene.sliding_frictions[0])
    of_rear, of_front = scene.rolling_frictions.tolist()
    rear, front = scene.balls
    together = (5.0 * slide - 7.0 * of_front) * g / 12.0
    gripping = rear.radius * float(scene.angular_velocities[0, 1]) / (together + 2.5 * slide * g)
    speed = together * gripping
    pushed = 0.5 * speed * gripping
    rolled = [speed * speed / (2.0 * friction * g) for friction in (of_rear, of_front)]
    places = tuple(
        (ball.position[0] + pushed + way, ball.position[1])
        for ball, way in zip((rear, front), rolled, strict=True)
    )
    return End(places, gripping + speed / (of_front * g), {"ball-ball": 0, "ball-cushion": 0})


@dataclass(frozen=True)
class ClosedEnd:
    """Whether a shot ends where and when its closed form says, after as many collisions.

    Attributes
    ----------
    truth : callable
        Given the scene, returns its end.
    distance : float [m]
    duration : float [s]
        How far off the end may be: what its scene's own criteria say, and why.
    """

    truth: Callable[[Scene], End]
    distance: float
    duration: float

    def __call__(self, result: Result) -> Verdict:
        """Judge a run."""
        scene = result.scene
        places, time, collisions = self.truth(scene)
        off = max(
            math.dist(here, there)
            for here, there in zip(result.rest_positions[:, :2].tolist(), places, strict=True)
        )
        late = abs(result.rest_time - time)
        faults = []
        if not off <= self.distance:
            faults.append(f"a ball ends {off:.3g} m off, at most {self.distance:g} m")
        if not late <= self.duration:
            faults.append(f"the end is {late:.3g} s off, at most {self.duration:g} s")
        if dict(result.collision_counts) != collisions:
            faults.append(f"{dict(result.collision_counts)} collisions instead of {collisions}")
        near = max(off / self.distance, late / self.duration)
        return Verdict.of(scene, faults, near, {"rest_error": off, "rest_time_error": late})


CLOSED_ENDS = {
    "corner-exact": ClosedEnd(shipped_end, 1e-14, 1e-14),
    "frozen-to-cushion": ClosedEnd(shipped_end, 1e-14, 1e-14),
    "three-ball-symmetric": ClosedEnd(shipped_end, 1e-14, 1e-14),
    "push": ClosedEnd(shipped_end, 1e-6, 5e-6),
    "wedged": ClosedEnd(shipped_end, 1e-12, 1e-5),
}
"""Where a proof ends too early: at two collisions of one instant, or where contact is sustained."""

PARTED = ClosedEnd(parted_end, 1e-5, 5e-6)
"""Of `parting`: our engine ends a slip at once that the cloth would end within `STOP_WAY`.

That is one of up to sqrt(2 mu_s g 2e-10 m) = 3e-5 m/s, of which 2/7 come off the rear ball alone
instead of off both: 8e-6 m/s, worth v dv / (mu_r g) = 8 um in its roll out.
"""

PRESSED = Sound(most_events=50, most_steps=500)
"""Of `push-line`: no closed form, but nothing may overlap and no energy come in."""
