"""Jaws, holes, posts and sharp corners: what a ball meets on a table that isn't a rectangle."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ghostball.model import Ball, EventKind, Physics, Result, Scene, Table
from ghostball.validation.stress.families.grazing import SHALLOWEST, SPEED, WAY, HitOrMiss
from ghostball.validation.stress.proved import ProvedTrial
from ghostball.validation.stress.trial import Family, SceneTrial, Suite, Trial, Verdict

_RADIUS = Ball(id="any", position=(0.0, 0.0)).radius
_FREE = Physics(rolling_friction=0.0, cushion="mirror")
_POOL = Table.model_validate("wpa-9ft")
_CORNER = ((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0))
"""An L, whose corner at (1, 1) points into the table."""

_POST = 0.04
"""Radius of the post that balls graze [m]."""


@dataclass(frozen=True)
class Meets:
    """Whether a run has as many of an event as there must be, and none where there must be none."""

    kind: EventKind
    count: int

    def __call__(self, result: Result) -> Verdict:
        """Judge a run."""
        assert result.events is not None
        seen = int(np.count_nonzero(result.events["kind"] == self.kind))
        faults = [f"{seen} events {self.kind.label}, where there must be {self.count}"]
        return Verdict.of(result.scene, faults if seen != self.count else [])


def passing(name: str, depth: float, turn: float, *, post: bool) -> Scene:
    """Return a shot that passes a post, or a corner, `depth` diameters nearer than a touch.

    Along a straight line, turned by an angle from the diagonal [rad].
    """
    way = math.radians(-45.0) + turn
    c, s = math.cos(way), math.sin(way)
    aside = _RADIUS - 2.0 * _RADIUS * depth + (_POST if post else 0.0)
    # On the right of the way lies what is met, at (1, 1): the ball passes it on the left of that.
    x, y = 1.0 + s * aside - c * WAY, 1.0 - c * aside - s * WAY
    table = {"length": 2.0, "width": 2.0, "posts": [{"centre": (1.0, 1.0), "radius": _POST}]}
    return Scene(
        name=name,
        table=Table.model_validate(table if post else {"vertices": _CORNER}),
        physics=_FREE,
        t_max=2.0 * WAY / SPEED,
        balls=[Ball(id="cue", position=(x, y), velocity=(SPEED * c, SPEED * s))],
    )


def wedge(name: str, angle: float) -> tuple[Scene, int]:
    """Return a ball that goes into a corner and comes back, and how often it bounces there.

    `angle` [rad]: of the corner.

    The sides that its centre bounces off meet at R / sin(angle / 2) from the corner. Unfolded
    there, its way is a straight line, which crosses a side at every multiple of the angle between
    the directions to where it begins and to where it goes.
    """
    reach, back = _RADIUS / math.sin(angle / 2.0), 1.0
    length = reach + 3.0 * back
    height = length * math.tan(angle / 2.0)
    off = 0.1 * angle
    vertices = ((0.0, height), (length, 0.0), (length, 2.0 * height))
    scene = Scene(
        name=name,
        table=Table.model_validate({"vertices": vertices}),
        physics=_FREE,
        t_max=2.0 * back / SPEED,
        balls=[
            Ball(
                id="cue",
                position=(reach + back, height),
                velocity=(-SPEED * math.cos(off), -SPEED * math.sin(off)),
            )
        ],
    )
    start, end = 0.5 * angle, math.pi + 0.5 * angle + off
    return scene, math.floor(end / angle) - math.floor(start / angle)


def shot(name: str, *balls: dict[str, Any], **fields: Any) -> Scene:
    """Return a shot on a pool table of 9 ft, on which nothing slows balls."""
    data = [{"id": f"b{i}", **ball} for i, ball in enumerate(balls)]
    return Scene.model_validate(
        {"name": name, "table": _POOL, "physics": _FREE, "t_max": 2.0, "balls": data, **fields}
    )


def _grazes(suite: Suite) -> Iterator[Trial]:
    for kind in ("post", "corner"):
        for power in range(1, SHALLOWEST + 1, 4 if suite == "quick" else 1):
            for sign, word in ((1.0, "hit"), (-1.0, "miss")):
                for turn in (0.0, 0.1) if suite == "quick" else (0.0, 0.1, -0.3, 0.5):
                    name = f"{kind}-{word}-1e-{power:02d}" + (f"-turned-{turn:g}" if turn else "")
                    depth = sign * 10.0**-power
                    scene = passing(name, depth, turn, post=kind == "post")
                    yield SceneTrial(name, scene, HitOrMiss(depth, EventKind.BALL_CUSHION))


def _at_holes() -> Iterator[Trial]:
    """Yield balls at the edge of a hole, frozen between jaws, and two that fall together."""
    (hole,) = (one for one in _POOL.holes if one.pocket == 1)  # of the bottom side
    x, edge = hole.centre[0], hole.centre[1] + hole.radius
    for power in (3, 6, 9, 12):
        place = (x, edge + 10.0**-power)
        name = f"hanging-1e-{power:02d}"
        yield SceneTrial(name, shot(name, {"position": place}), Meets(EventKind.POCKETED, 0))
        name = f"falling-1e-{power:02d}"
        pushed = {"position": place, "velocity": (0.0, -1e-3 - 10.0**-power)}
        yield SceneTrial(name, shot(name, pushed), Meets(EventKind.POCKETED, 1))
    pair = [
        {"position": (x + side * 0.03, edge + 0.2), "velocity": (0.0, -1.0)} for side in (-1.0, 1.0)
    ]
    yield SceneTrial("two-at-once", shot("two-at-once", *pair), Meets(EventKind.POCKETED, 2))
    # A ball too large for the mouth lies against both jaws. What strikes it comes back.
    large, jaws = 0.1, [one for one in _POOL.obstacles if getattr(one, "inward", None)]
    jaw = min(
        (one for one in jaws if one not in _POOL.holes),
        key=lambda one: math.dist(one.centre, hole.centre),  # type: ignore[union-attr]
    )
    across = x - jaw.centre[0]  # type: ignore[union-attr]
    up = math.sqrt((large + jaw.radius) ** 2 - across**2)  # type: ignore[union-attr]
    frozen = {"position": (x, jaw.centre[1] + up), "radius": large}  # type: ignore[union-attr]
    name = "frozen-in-the-jaws"
    yield SceneTrial(name, shot(name, frozen), Meets(EventKind.BALL_CUSHION, 0))
    for speed in (0.01, 1.0, 5.0):
        name = f"into-the-jaws-{speed:g}"
        cue = {"position": (x, 0.635), "velocity": (0.0, -speed)}
        # Until it is on its way back to the pocket across.
        scene = shot(name, frozen, cue, t_max=0.9 / speed)
        yield SceneTrial(name, scene, Meets(EventKind.POCKETED, 0))


def _rattles(suite: Suite) -> Iterator[Trial]:
    """Yield balls on their way between the jaws of a corner pocket, held to their proofs."""
    for k in range(6 if suite == "quick" else 60):
        y = 1.185 + 0.02 * k / (5 if suite == "quick" else 59)
        name = f"rattle-{y:.5f}"
        ball = {"position": (1.9, y), "velocity": (2.0, 0.04)}
        scene = shot(name, ball, physics=Physics(preset="pool"), t_max=None)
        yield ProvedTrial(name, scene)


def _corners(suite: Suite) -> Iterator[Trial]:
    """Yield corners that get ever sharper, down to sides that are nearly parallel."""
    degrees = (90.5, 31.0, 7.0, 1.0) if suite == "quick" else (90.5, 31.0, 7.0, 1.0, 0.3, 0.1, 0.03)
    for one in degrees:
        name = f"needle-{one:g}"
        scene, count = wedge(name, math.radians(one))
        yield SceneTrial(name, scene, Meets(EventKind.BALL_CUSHION, count))


def _trials(suite: Suite) -> Iterator[Trial]:
    yield from _grazes(suite)
    yield from _at_holes()
    yield from _rattles(suite)
    yield from _corners(suite)


FAMILY = Family(
    "pockets",
    "Jaws, holes and sharp corners",
    "A path that goes 1e-1 to 1e-13 of a diameter into a post or a corner meets it once; a ball "
    "that hangs at the edge of a hole stays, and falls where it is pushed; one too large for a "
    "mouth never falls; a rattle between jaws is the proved one; and a corner of 90 to 0.03 "
    "degrees is left after as many bounces as a straight line crosses its images.",
    _trials,
)
