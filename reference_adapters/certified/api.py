"""Compute the certificate of a scene, or read it from the disk."""

from __future__ import annotations

from collections.abc import Iterator

from ghostball.model import Scene, UnsupportedSceneError
from ghostball.model.features import EXACT, Capabilities, Capability, Feature, check_supported
from ghostball.reference_adapters.certified import cache
from ghostball.reference_adapters.certified.certificate import Certificate
from ghostball.reference_adapters.certified.problem import problem_of
from ghostball.reference_adapters.certified.prove import prove
from ghostball.reference_adapters.certified.settings import CertifiedSettings

NAME = "certified"

_INTEGRATED = Capability(
    "none", "this law is a numerical integration over the impact, without a closed form"
)

CAPABILITIES: Capabilities = {
    Feature.ROLLING: EXACT,
    Feature.SLIDING: EXACT,
    Feature.FRICTIONLESS_CLOTH: EXACT,
    Feature.VERTICAL_SPIN: EXACT,
    Feature.BALL_RESTITUTION: EXACT,
    Feature.BALL_FRICTION: EXACT,
    Feature.SPEED_DEPENDENT_FRICTION: EXACT,
    Feature.MATHAVAN_BALL: _INTEGRATED,
    Feature.UNEQUAL_MASSES: EXACT,
    Feature.UNEQUAL_RADII: EXACT,
    Feature.PER_BALL_FRICTION: EXACT,
    Feature.UNBOUNDED_CLOTH: EXACT,
    Feature.OPEN_SIDES: EXACT,
    Feature.POLYGON: EXACT,
    Feature.POCKETS: EXACT,
    Feature.POSTS: EXACT,
    Feature.MIRROR_CUSHION: EXACT,
    Feature.CUSHION_RESTITUTION: EXACT,
    Feature.FALLING_RESTITUTION: EXACT,
    Feature.CUSHION_TANGENTIAL: EXACT,
    Feature.FRICTIONAL_CUSHION: EXACT,
    Feature.HAN_CUSHION: EXACT,
    Feature.MATHAVAN_CUSHION: _INTEGRATED,
    Feature.STRONGE_CUSHION: Capability(
        "none", "the instant at which the cushion lets the ball slip has no closed form"
    ),
    Feature.AIR_DRAG: EXACT,
    Feature.QUADRATIC_ROLLING: EXACT,
    Feature.FLIGHT: EXACT,  # until a ball comes to lie on a different ball, where the proof ends
    Feature.COMPLIANT: Capability(
        "none", "contacts that last are a numerical integration, without a closed form"
    ),
}
"""Capabilities of certificates; a feature that isn't listed is unsupported."""


def check_certified(scene: Scene, *, integrates: bool = False) -> None:
    """Reject a scene that can't be certified; with `integrates`, slides in air are allowed.

    Raises `UnsupportedSceneError`.
    """
    check_supported(NAME, CAPABILITIES, scene)
    if scene.physics.airborne and scene.physics.air_drag > 0.0:
        raise UnsupportedSceneError(NAME, ("no air drag on airborne balls",))
    if not integrates and any(_slides_in_air(scene)):
        raise UnsupportedSceneError(NAME, ("no slides in air: they have no closed form",))


def _slides_in_air(scene: Scene) -> Iterator[bool]:
    """Yield for each ball whether it starts with a slide in air."""
    problem = problem_of(scene)
    for ball in problem.balls:
        slips = problem.slides and not ball.rolls and ball.sliding_friction > 0.0
        yield slips and problem.air_drag > 0.0


def certify(
    scene: Scene,
    settings: CertifiedSettings | None = None,
    *,
    motion: bool = False,
    cached: bool = True,
) -> Certificate:
    """Prove the events of a scene, as far as possible.

    `scene`: its numbers are taken as the exact values of their doubles.
    `motion`: whether the certificate also contains the motion between events.
    `cached`: whether to read the certificate from the disk if the same code computed it before, and
        to store it there.

    Raises `UnsupportedSceneError` if the scene has physics that can't be certified; the reasons are
    in `CAPABILITIES`.
    """
    settings = CertifiedSettings() if settings is None else settings
    check_certified(scene)
    problem, ids = problem_of(scene), tuple(ball.id for ball in scene.balls)
    if not cached:
        return prove(problem, ids, settings, motion=motion)
    key = cache.key_of(problem, ids, settings, motion)
    certificate = cache.read(key)
    if certificate is None:
        certificate = prove(problem, ids, settings, motion=motion)
        if certificate.ending != "time limit":  # a faster run may get further
            cache.write(key, certificate)
    return certificate
