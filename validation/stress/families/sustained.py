"""Sustained contact: balls that are pressed on others, or on a cushion, and stay there for a time.

Bouncing, such balls would collide without end. What is asked is that a shot ends, that its events
and contact steps stay below a bound, that nothing overlaps, and that energy only falls.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

from ghostball.engine import Ball, Physics, Scene, Table
from ghostball.reference_adapters import ReferenceEngine
from ghostball.validation.runs.steps import with_setting
from ghostball.validation.stress.family import Family
from ghostball.validation.stress.rows import RADIUS, Plane, Spin, ball, resting_row
from ghostball.validation.stress.sound import Sound
from ghostball.validation.stress.trial import SceneTrial, Suite, Trial, Verdict

EVENTS_PER_BALL = 150
"""Beside those of a row that is hit: impacts go to and fro through it until no ball approaches the
next, at one instant, which takes up to 4 n^3 of them; see the family "cradles"."""

STEPS_PER_SECOND = 100_000
"""Contact steps in a second of motion: 10 us each.

Two balls of 6 cm that roll around each other at 1 m/s turn their normal by h v / d in a step h, so
that its gap is off by a cubic of the size (h v)^3 / d^2; within 2^-37 d, that is a step of
2^-37/3 d / v, 12 us. They take longer ones as they slow down.
"""

T_QUICK, T_FULL = 0.125, 0.5
"""How long shots are followed [s]: all that is tried presses at once, or soon."""


STEPS_PER_EVENT = 4
"""Steps that an engine which steps may take for each event that is permitted, beside those of its
length. One that lands steps on contacts takes a few for one event; where it takes more than four,
it sees far more events than are permitted, as all that were followed to their end did, and isn't
followed for minutes."""


@dataclass(frozen=True)
class Pressed(SceneTrial):
    """A shot in sustained contact, with a bound of events, and so of steps that end at them.

    Attributes
    ----------
    most_events : int
    """

    most_events: int = 0

    def run(self, engine: ReferenceEngine) -> Verdict:
        """Run the shot and judge it; an engine that takes far too many steps is stopped."""
        return super().run(self._bounded(engine))

    def _bounded(self, engine: ReferenceEngine) -> ReferenceEngine:
        step = getattr(engine.settings, "step", None)
        if not step or "max_steps" not in type(engine.settings).model_fields:
            return engine
        assert self.scene.t_max is not None
        steps = math.ceil(self.scene.t_max / step) + STEPS_PER_EVENT * self.most_events
        allowed: int = engine.settings.max_steps  # type: ignore[attr-defined] # just looked at
        return with_setting(engine, "max_steps", min(steps, allowed))


def _trial(scene: Scene, sound: Sound) -> Trial:
    return Pressed(scene.name, scene, sound, most_events=sound.most_events)


def _physics(ball: float, cushion: float = 0.85, friction: float = 0.06) -> Physics:
    """Return the whole game, with these restitutions and this friction between balls."""
    return Physics(
        motion="sliding",
        rolling_friction=0.01,
        ball_restitution=ball,
        ball_friction=friction,
        cushion="frictional",
        cushion_restitution=cushion,
    )


def _restitutions(suite: Suite) -> tuple[float, ...]:
    return (0.5,) if suite == "quick" else (1.0, 0.95, 0.5, 0.0)


def _topspin(course: Plane, surface: float) -> Spin:
    """Return the spin [rad/s] of a ball that rolls along (cos, sin) at that speed [m/s]."""
    return (-course[1] * surface / RADIUS, course[0] * surface / RADIUS, 0.0)


def _bounds(balls: int, t_max: float, *, symmetric: bool = False) -> Sound:
    """Return what is asked of a shot of so many balls."""
    images = tuple(range(balls)) if symmetric else ()
    most_steps = round(STEPS_PER_SECOND * t_max)
    most_events = EVENTS_PER_BALL * balls + 4 * balls**3
    return Sound(most_events=most_events, most_steps=most_steps, images=images)


def _follow(suite: Suite) -> Iterator[Trial]:
    """Yield follow shots into a frozen line, full or off its middle."""
    t_max = T_QUICK if suite == "quick" else T_FULL
    lines = (1, 4) if suite == "quick" else (1, 2, 4, 8)
    offsets = (0.0, 0.3) if suite == "quick" else (0.0, 1e-9, 1e-3, 0.3, 0.9)
    for n, offset, restitution in product(lines, offsets, _restitutions(suite)):
        line = resting_row(n, 0.0)
        cue = ball("cue", (-0.125, offset * RADIUS), (1.5, 0.0), _topspin((1.0, 0.0), 3.0))
        name = f"follow-{n}-offset-{offset:g}-restitution-{restitution:g}"
        scene = Scene(name=name, physics=_physics(restitution), t_max=t_max, balls=[cue, *line])
        yield _trial(scene, _bounds(n + 1, t_max, symmetric=offset == 0.0))


def _pressed(suite: Suite) -> Iterator[Trial]:
    """Yield a ball that spins behind touching ones, or rolls behind slower ones of its course."""
    t_max = T_QUICK if suite == "quick" else T_FULL
    lines = (3,) if suite == "quick" else (1, 2, 3, 6)
    for n, restitution, angle in product(lines, _restitutions(suite), (0.0, 0.4)):
        line = resting_row(n, 0.0)
        spinning = ball(
            "cue", (-2.0 * RADIUS, 0.0), spin=_topspin((math.cos(angle), math.sin(angle)), 2.0)
        )
        name = f"spinning-behind-{n}-angle-{angle:g}-restitution-{restitution:g}"
        scene = Scene(
            name=name, physics=_physics(restitution), t_max=t_max, balls=[spinning, *line]
        )
        yield _trial(scene, _bounds(n + 1, t_max, symmetric=angle == 0.0))
        # The one behind is slowed less: it presses from the first instant on.
        rolling = [
            Ball(
                id=f"b{k}",
                radius=RADIUS,
                position=(2.0 * RADIUS * k, 0.0),
                velocity=(0.3, 0.3 * math.tan(angle) if k == 0 else 0.0),
                rolling_friction=0.01 * (k + 1),
            )
            for k in range(n + 1)
        ]
        name = f"rolling-behind-{n}-angle-{angle:g}-restitution-{restitution:g}"
        physics = Physics(ball_restitution=restitution)
        scene = Scene(name=name, physics=physics, t_max=t_max, balls=rolling)
        yield _trial(scene, _bounds(n + 1, t_max, symmetric=angle == 0.0))


def _at_cushion(suite: Suite) -> Iterator[Trial]:
    """Yield topspin at a cushion: a ball that drives into it, from touching or from afar."""
    t_max = T_QUICK if suite == "quick" else T_FULL
    table = Table(length=2.0, width=2.0, cushions=("left",))
    angles = (0.0, 0.5) if suite == "quick" else (0.0, 1e-6, 0.1, 0.5, 1.2)
    for away, angle, restitution, speed in product(
        (0.0, 0.0625), angles, _restitutions(suite), (0.0, 1.0)
    ):
        if speed == 0.0 and away > 0.0:
            continue
        course = (-math.cos(angle), -math.sin(angle))
        velocity = (speed * course[0], speed * course[1])
        pressed = ball("a", (RADIUS + away, 0.0), velocity, _topspin(course, 3.0))
        name = f"cushion-away-{away:g}-angle-{angle:g}-restitution-{restitution:g}-speed-{speed:g}"
        scene = Scene(
            name=name,
            physics=_physics(0.95, cushion=restitution),
            table=table,
            t_max=t_max,
            balls=[pressed],
        )
        yield _trial(scene, _bounds(1, t_max, symmetric=angle == 0.0))


def _squeezed(suite: Suite) -> Iterator[Trial]:
    """Yield balls between a cushion, or a corner, and one that drives at them with topspin."""
    t_max = T_QUICK if suite == "quick" else T_FULL
    left = Table(length=2.0, width=2.0, cushions=("left",))
    square = Table(length=2.0, width=2.0)
    counts = (2,) if suite == "quick" else (1, 2, 4)
    offsets = (0.0, 0.3) if suite == "quick" else (0.0, 1e-6, 0.1, 0.9)
    for n, offset, restitution, away in product(
        counts, offsets, _restitutions(suite), (0.0, 0.0625)
    ):
        if away == 0.0 and restitution != 0.5:
            continue  # nothing bounces
        still = resting_row(n, 0.0, RADIUS)
        last = RADIUS + 2.0 * RADIUS * (n - 1)
        reach = (
            2.0 * RADIUS * math.sqrt(1.0 - 0.25 * offset**2) if away == 0.0 else 2.0 * RADIUS + away
        )
        speed = 0.0 if away == 0.0 else -1.0
        cue = ball("cue", (last + reach, offset * RADIUS), (speed, 0.0), _topspin((-1.0, 0.0), 3.0))
        name = f"squeezed-{n}-offset-{offset:g}-restitution-{restitution:g}-away-{away:g}"
        scene = Scene(
            name=name,
            physics=_physics(restitution, cushion=restitution),
            table=left,
            t_max=t_max,
            balls=[cue, *still],
        )
        yield _trial(scene, _bounds(n + 1, t_max, symmetric=offset == 0.0))
    for restitution, friction in product(_restitutions(suite), (0.0, 0.3)):
        diagonal = 2.0 * RADIUS / math.sqrt(2.0)
        place = (RADIUS + diagonal, RADIUS + diagonal)
        cue = ball("cue", place, spin=_topspin((-math.sqrt(0.5), -math.sqrt(0.5)), 3.0))
        name = f"cornered-restitution-{restitution:g}-friction-{friction:g}"
        scene = Scene(
            name=name,
            physics=_physics(restitution, friction=friction),
            table=square,
            t_max=t_max,
            balls=[cue, ball("b", (RADIUS, RADIUS))],
        )
        sound = Sound(
            most_events=2 * EVENTS_PER_BALL,
            most_steps=round(STEPS_PER_SECOND * t_max),
            images=(0, 1),
            swapped=True,
        )
        yield _trial(scene, sound)


def _trials(suite: Suite) -> Iterator[Trial]:
    yield from _follow(suite)
    yield from _pressed(suite)
    yield from _at_cushion(suite)
    yield from _squeezed(suite)


FAMILY = Family(
    "sustained",
    "Sustained contact",
    "Balls that topspin, or a slower ball ahead, presses on others, on cushions and into corners "
    f"don't overlap, gain no energy, and have at most {EVENTS_PER_BALL} n + 4 n^3 events, n balls, "
    f"and {STEPS_PER_SECOND} contact steps a second.",
    _trials,
)
