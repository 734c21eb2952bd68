"""Shots with slides in air, integrated with 40 digits: a reference result that isn't certified.

A slide in air has no closed form. With the velocity v, the slip u and its direction e,

    v' = -a e - k |v| v,   u' = -(7/2) a e - k |v| v,   e = u / |u|,   a = mu_s g.

These equations are solved numerically (`collocation`). The package `certified` computes events and
impacts of this motion by closed formulas. Ghostball's engine isn't used.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from flint import arb

from ghostball.model import Scene, UnsupportedSceneError
from ghostball.reference_adapters.certified import Certificate, CertifiedSettings, cache
from ghostball.reference_adapters.certified.api import check_certified
from ghostball.reference_adapters.certified.problem import problem_of
from ghostball.reference_adapters.certified.prove import prove
from ghostball.validation.truth import collocation
from ghostball.validation.truth.certificates import explained
from ghostball.validation.truth.collocation import BITS, Collocation

_RUNS = ((20, arb((1, -2))), (18, arb((3, -4))))
"""For both runs: points of a step, and its length in units of the time to the singularity."""

_SOURCES = tuple(Path(str(path)).read_text("utf-8") for path in (__file__, collocation.__file__))
"""The source code, part of the key of stored integrations."""

MOST_ERROR = 1e-20
"""Largest estimated error of an accepted integration [m], [s]."""


class Integration(NamedTuple):
    """An integrated shot, in the form of a certificate, and its estimated error [m], [s].

    `error`: the largest difference from a second integration, with fewer points and other steps.
    """

    shot: Certificate
    error: float


def may_be_integrated(scene: Scene) -> bool:
    """Return True if balls may slide in air, and the rest of the scene has closed formulas."""
    physics = scene.physics
    try:
        check_certified(scene, integrates=True)
    except UnsupportedSceneError:
        return False
    return physics.motion == "sliding" and physics.air_drag > 0.0 and not physics.airborne


def integrated(scene: Scene) -> tuple[Integration | None, str]:
    """Return the integration of a shot with slides in air; or None, and why it isn't possible.

    Integrations are stored on the disk, like certificates.
    """
    words = f'integrating scene "{scene.name}" takes a while; the result is kept for the next run'
    try:
        with explained(words):
            one, other = (_kept(scene, run) for run in range(len(_RUNS)))
    except UnsupportedSceneError as refused:
        return None, "; ".join(refused.features)
    for shot in (one, other):
        if not shot.proved:
            return None, f"{shot.ending}: {shot.reason}"
    if [event.key for event in one.events] != [event.key for event in other.events]:
        return None, "its two integrations have different events"
    pairs = [(one.t_end, other.t_end)]
    pairs += [(a.t, b.t) for a, b in zip(one.events, other.events, strict=True)]
    for places in zip(one.positions, other.positions, strict=True):
        pairs += zip(*places, strict=True)
    error = max(float(abs(a.mid - b.mid)) for a, b in pairs)
    if error > MOST_ERROR:
        return None, f"its estimated error is {error:.1e}"
    return Integration(one, error), ""


def _kept(scene: Scene, run: int) -> Certificate:
    """Return one of the two integrations, from the disk if it is stored."""
    problem, ids = problem_of(scene), tuple(ball.id for ball in scene.balls)
    settings = CertifiedSettings(start_precision=BITS, max_precision=BITS, width=1.0)
    key = cache.key_of(problem, (*ids, str(run), *_SOURCES), settings, True)
    shot = cache.read(key)
    if shot is None:
        shot = prove(problem, ids, settings, motion=True, slide=Collocation(*_RUNS[run]))
        cache.write(key, shot)
    return shot
