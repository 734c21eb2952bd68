"""Certificates of scenes for tests of the certified engine, and values to compare."""

from __future__ import annotations

from typing import Any

from flint import arb
from mpmath import mpf
from shots import random_break, random_cloth_shot, random_shot, scene_of

from ghostball.engine import simulate
from ghostball.model import EventKind, Scene, partner_name
from ghostball.reference_adapters.certified import (
    Certificate,
    CertifiedSettings,
    Enclosure,
    certify,
)
from ghostball.reference_adapters.certified.problem import problem_of
from ghostball.reference_adapters.certified.prove import prove
from ghostball.validation.scenes.random_scenes import PROVABLE, random_scene
from ghostball.validation.truth.collocation import BITS, Collocation


def proved(scene: Scene, *, motion: bool = False, **settings: float) -> Certificate:
    """Return the certificate of a scene; assert that the whole shot is proved."""
    certificate = certify(scene, CertifiedSettings(**settings), motion=motion, cached=False)
    assert certificate.proved, certificate.reason
    return certificate


def integrated_once(scene: Scene) -> Certificate:
    """Return a shot with slides in air, integrated to about 20 digits, as a certificate."""
    settings = CertifiedSettings(start_precision=BITS, max_precision=BITS, width=1.0)
    ids = tuple(ball.id for ball in scene.balls)
    slide = Collocation(10, arb((1, -2)))
    return prove(problem_of(scene), ids, settings, motion=True, slide=slide)


def keys(certificate: Certificate) -> list[tuple[int, int, int]]:
    """Return kind, a and b of each event as plain numbers."""
    return [(int(e.kind), e.a, e.b) for e in certificate.events]


def engine_keys(scene: Scene) -> list[tuple[int, int, int]]:
    """Return kind, a and b of each event of Ghostball's engine."""
    events = simulate(scene, record="events").events
    assert events is not None
    return [(int(e["kind"]), int(e["a"]), int(e["b"])) for e in events]


def middle(enclosure: Enclosure) -> mpf:
    """Return the middle of an enclosure, in the present precision."""
    return mpf(enclosure.mid.numerator) / enclosure.mid.denominator


def overlap(one: Enclosure, other: Enclosure) -> bool:
    """Return whether two enclosures overlap."""
    return one.lower <= other.upper and other.lower <= one.upper


def widest(certificate: Certificate) -> float:
    """Return the width of the widest enclosure of a position at the end [m]."""
    return max(one.width for position in certificate.positions for one in position)


def after(scene: Scene, events: int) -> Certificate:
    """Return the certificate of a scene up to the given number of events."""
    certificate = certify(scene, CertifiedSettings(max_events=events), cached=False)
    assert certificate.events_proved == events
    return certificate


def flying(*balls: dict[str, Any], **fields: Any) -> Scene:
    """Return a scene with airborne balls on the cloth of a pool table."""
    chosen = {"preset": "pool", "airborne": True, "gravity": 9.81, "table_restitution": 0.5}
    return scene_of(*balls, **chosen | fields)


def jump(number: int, **having: str) -> Scene:
    """Return a random shot with flying balls."""
    wanted = {**PROVABLE, "flight": ("low", "jump", "drop", "on-top"), **having}
    return random_scene(number, **wanted)


def in_air(scene: Scene, t_max: float | None = None, **physics: float) -> Scene:
    """Return the scene with air drag."""
    changed = {"physics": scene.physics.model_dump(exclude_unset=True) | physics, "t_max": t_max}
    return Scene.model_validate({**scene.model_dump(by_alias=True), **changed})


SHOTS = {
    "rolling": random_shot(7, 5),
    "unequal": random_shot(6, 4, ball_restitution=0.9),
    "sliding": random_cloth_shot(3),
    "break": random_break(5, n=7),
    "gas": random_shot(11, 4, rolling_friction=0.0, t_max=3.0),
}
"""Shots that are proved to the end, one of each kind."""

ELL = [[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]]
"""Vertices of a table whose corner (1, 1) points into it."""


def met(certificate: Certificate) -> list[str]:
    """Return the events with obstacles, by kind and name of the obstacle."""
    return [
        f"{e.kind.label} {partner_name(e.kind, e.b)}"
        for e in certificate.events
        if e.kind in (EventKind.BALL_CUSHION, EventKind.POCKETED)
    ]
