"""Shots with slides in air, integrated in 40 digits: a reference that is no proof.

A slide in air has no closed form. With the velocity v, the slip u and its direction e,

    v' = -a e - k |v| v,   u' = -(7/2) a e - k |v| v,   e = u / |u|,   a = mu_s g.

The equations are solved as they stand (`collocation`). Events and impacts are what the package
`certified` makes of such a motion, by closed formulas. Nothing is our engine's.
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
from ghostball.validation.truth.collocation import BITS, Collocation
from ghostball.validation.truth.proof import explained

_RUNS = ((20, arb((1, -2))), (18, arb((3, -4))))
"""Of both runs: points of a step; its length, in units of the time to where it is singular."""

_SOURCES = tuple(Path(str(path)).read_text("utf-8") for path in (__file__, collocation.__file__))
"""What is kept is of this code."""

MOST_ERROR = 1e-20
"""Largest estimated error of what is called integrated [m], [s]."""


class Integration(NamedTuple):
    """An integrated shot, in the form of a proof, and its estimated error [m], [s].

    `error`: the largest difference from a second integration, with fewer points and other steps.
    """

    shot: Certificate
    error: float


def may_be_integrated(scene: Scene) -> bool:
    """Whether balls may slide in air in a scene, all else of which has closed formulas."""
    physics = scene.physics
    try:
        check_certified(scene, integrates=True)
    except UnsupportedSceneError:
        return False
    return physics.motion == "sliding" and physics.air_drag > 0.0 and not physics.airborne


def integrated(scene: Scene) -> tuple[Integration | None, str]:
    """Return a shot with slides in air as it is integrated; or None and why it can't be.

    An integration is kept on the disk, as a proof is.
    """
    words = f'integrating scene "{scene.name}" takes a while; it is kept for the next run'
    try:
        with explained(words):
            one, other = (_kept(scene, run) for run in range(len(_RUNS)))
    except UnsupportedSceneError as refused:
        return None, "; ".join(refused.features)
    for shot in (one, other):
        if not shot.proved:
            return None, f"{shot.ending}: {shot.reason}"
    if [event.key for event in one.events] != [event.key for event in other.events]:
        return None, "two integrations of it have different events"
    pairs = [(one.t_end, other.t_end)]
    pairs += [(a.t, b.t) for a, b in zip(one.events, other.events, strict=True)]
    for places in zip(one.positions, other.positions, strict=True):
        pairs += zip(*places, strict=True)
    error = max(float(abs(a.mid - b.mid)) for a, b in pairs)
    if error > MOST_ERROR:
        return None, f"its estimated error is {error:.1e}"
    return Integration(one, error), ""


def _kept(scene: Scene, run: int) -> Certificate:
    """Return one of the runs, from the disk where it is cache."""
    problem, ids = problem_of(scene), tuple(ball.id for ball in scene.balls)
    settings = CertifiedSettings(start_precision=BITS, max_precision=BITS, width=1.0)
    key = cache.key_of(problem, (*ids, str(run), *_SOURCES), settings, True)
    shot = cache.read(key)
    if shot is None:
        shot = prove(problem, ids, settings, motion=True, slide=Collocation(*_RUNS[run]))
        cache.write(key, shot)
    return shot
