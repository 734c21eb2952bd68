"""Near-degenerate motion: balls that move all but alike, so that contacts hang on small numbers."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from ghostball.engine import Ball, Physics, Scene
from ghostball.validation.grading.tolerances import LOWEST_HOP
from ghostball.validation.stress.family import Family
from ghostball.validation.stress.proved import ProvedTrial
from ghostball.validation.stress.rows import RADIUS
from ghostball.validation.stress.sound import Both, Ends, Sound
from ghostball.validation.stress.trial import SceneTrial, Suite, Trial, size

SPEED = 1.0
T_CATCH = 0.05
"""When the ball behind catches up [s]: the gap is what closes until then."""

KINDS = {
    "elastic": Physics(rolling_friction=0.0),
    "rolling": Physics(rolling_friction=0.02),
    "sliding": Physics(motion="sliding", ball_restitution=0.95, ball_friction=0.06),
}
"""The last one's balls start without spin, and slide all the time."""


def _pair(
    name: str,
    physics: Physics,
    gap: float,
    ahead: tuple[float, float],
    t_max: float,
    turn: float = 0.0,
    behind: tuple[float, float] = (SPEED, 0.0),
    **front: Any,
) -> Scene:
    """Return a ball and another one `gap` ahead along x, all turned by an angle."""
    c, s = math.cos(turn), math.sin(turn)
    if physics.motion == "sliding":
        front["angular_velocity"] = (0.0, 0.0, 0.0)
    apart = 2.0 * RADIUS + gap
    return Scene(
        name=name,
        physics=physics,
        t_max=t_max,
        balls=[
            Ball(
                id="behind",
                radius=RADIUS,
                position=(0.0, 0.0),
                velocity=(c * behind[0] - s * behind[1], s * behind[0] + c * behind[1]),
                angular_velocity=front.get("angular_velocity"),
            ),
            Ball(
                id="ahead",
                radius=RADIUS,
                position=(c * apart, s * apart),
                velocity=(c * ahead[0] - s * ahead[1], s * ahead[0] + c * ahead[1]),
                **front,
            ),
        ],
    )


def _catching_up(kind: str, physics: Physics, suite: Suite) -> Iterator[Trial]:
    """Yield pairs whose velocities differ by little, in size and by an angle; proved."""
    slower = (1e-1, 1e-9) if suite == "quick" else (0.5, 1e-1, 1e-3, 1e-5, 1e-7, 1e-9, 1e-11)
    angles = (0.0, 1e-4, 1e-16) if suite == "quick" else (0.0, *(10.0**-k for k in range(1, 17)))
    turns = (0.0,) if suite == "quick" else (0.0, 0.7)
    for less in slower:
        for angle in angles:
            for turn in turns:
                speed = SPEED * (1.0 - less)
                name = f"{kind}-slower-by-{size(less)}-at-{size(angle)}-turned-{turn:g}"
                ahead = (speed * math.cos(angle), speed * math.sin(angle))
                gap = less * SPEED * T_CATCH
                scene = _pair(name, physics, gap, ahead, 2.0 * T_CATCH, turn)
                yield ProvedTrial(name, scene, cached=False)


def _slowed_alike(suite: Suite) -> Iterator[Trial]:
    """Yield pairs of one velocity whose decelerations differ by little; proved.

    The gap is what closes by the difference, mu g t^2 / 2, in half the time that the run has; or
    twice what closes in all of it.
    """
    friction = 0.02
    more = (0.0, 1e-3, 1e-9) if suite == "quick" else (0.0, *(10.0**-k for k in range(1, 14)))
    for part in more:
        own = friction * (1.0 + part)
        for reach, word in ((0.25, "met"), (2.0, "missed")):
            gap = 0.5 * (own - friction) * 9.81 * (2.0 * T_CATCH) ** 2 * reach
            if part == 0.0:
                gap = 1e-6 * reach
            name = f"rolling-slowed-more-by-{size(part)}-{word}"
            scene = _pair(
                name,
                KINDS["rolling"],
                gap,
                (SPEED, 0.0),
                2.0 * T_CATCH,
                rolling_friction=own,
            )
            sound = Sound(most_events=40, most_steps=200)
            hop = (
                scene.positions[1, 0] - 2.0 * RADIUS
            )  # as high as one that bounced would rise again
            pressed = word == "met" and part > 0.0 and hop <= LOWEST_HOP * 2.0 * RADIUS
            if pressed:
                yield SceneTrial(name, scene, Both(sound, _pressed(hop, friction, own)))
            else:
                yield ProvedTrial(name, scene, cached=False, also=sound)


def _pressed(hop: float, behind: float, ahead: float) -> Ends:
    """Return how a pair ends whose approach is so slow that the balls are taken to stay together.

    A proof says nothing of it: where bounces would stay below `LOWEST_HOP` it is over, and
    nothing happens before. Together both are slowed by the mean, and so is their centre all along.
    An engine may as well follow the bounce: at its top, when the shot ends, the balls are `hop`
    apart; and it takes from each at most half the speed at which they met.
    """
    t_max = 2.0 * T_CATCH
    mean = 0.5 * (behind + ahead) * 9.81
    centre = RADIUS + 0.5 * hop + (SPEED - 0.5 * mean * t_max) * t_max
    met = (ahead - behind) * 9.81 * T_CATCH
    return Ends(
        ((SPEED - mean * t_max, 0.0),) * 2,
        positions=((centre - RADIUS, 0.0), (centre + RADIUS, 0.0)),
        slack=(0.5 * hop, 0.5 * met),
    )


def _alike(kind: str, physics: Physics, suite: Suite) -> Iterator[Trial]:
    """Yield pairs of one velocity, apart or touching: they never collide, and stay as they are."""
    gaps = (0.0, 1e-12, 1e-3) if suite == "quick" else (0.0, *(10.0**-k for k in range(3, 16)))
    courses = (0.0, 0.7) if suite == "quick" else (0.0, 0.7, 0.5 * math.pi, 2.5, math.pi)
    for gap in gaps:
        for course in courses:
            # Along the line of centres on the axis, or at an angle to it.
            velocity = (SPEED * math.cos(course), SPEED * math.sin(course))
            name = f"{kind}-alike-gap-{size(gap)}-course-{course:.1f}"
            scene = _pair(name, physics, gap, velocity, 2.0 * T_CATCH, behind=velocity)
            end = _velocity_at_end(physics)
            alike = Ends(((velocity[0] * end, velocity[1] * end),) * 2, collisions=0)
            # No more than that both balls stop, or roll; touching, each may be pressed by rounding.
            yield SceneTrial(name, scene, Both(Sound(most_events=4, most_steps=64), alike))


def _velocity_at_end(physics: Physics) -> float:
    """Return what is left of the first speed at the end, v - mu g t: it rolls, or slides."""
    slides = physics.motion == "sliding"
    friction = physics.sliding_friction if slides else physics.rolling_friction
    return 1.0 - friction * physics.gravity * 2.0 * T_CATCH / SPEED


def _trials(suite: Suite) -> Iterator[Trial]:
    for kind, physics in KINDS.items():
        yield from _catching_up(kind, physics, suite)
    yield from _slowed_alike(suite)
    for kind, physics in KINDS.items():
        yield from _alike(kind, physics, suite)


FAMILY = Family(
    "near-degenerate",
    "Near-degenerate motion",
    "Balls of nearly one velocity, or nearly one deceleration, meet where and when a proof says, "
    "and nowhere else; balls of exactly one velocity never do, touching or not.",
    _trials,
)
