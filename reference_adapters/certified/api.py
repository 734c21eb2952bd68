"""A certificate of a scene: computed once, then read from the disk."""

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

_INTEGRATED = Capability("none", "its law is integrated over the impact and has no closed form")

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
    Feature.AIR_DRAG: EXACT,
    Feature.QUADRATIC_ROLLING: EXACT,
    Feature.FLIGHT: EXACT,  # up to where a ball comes to lie on another: there the proof ends
}
"""What can be certified, feature by feature: each is named, so that a new one is not."""


def check_certified(scene: Scene, *, integrates: bool = False) -> None:
    """Refuse a scene whose physics isn't certified; slides in air are, where `integrates` says so.

    Raises `UnsupportedSceneError`.
    """
    check_supported(NAME, CAPABILITIES, scene)
    if scene.physics.airborne and scene.physics.air_drag > 0.0:
        raise UnsupportedSceneError(NAME, ("no air drag of balls that leave the cloth",))
    if not integrates and any(_slides_in_air(scene)):
        raise UnsupportedSceneError(NAME, ("no slides in air: they have no closed form",))


def _slides_in_air(scene: Scene) -> Iterator[bool]:
    """Yield of each ball whether the shot begins with its slide in air."""
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
    """Prove what happens in a scene, as far as it can be proved.

    `scene`: its numbers are taken as the very doubles that they are.
    `motion`: whether the certificate also holds the motion between events.
    `cached`: whether to read the certificate from the disk if it was computed before by the same
        code, and to keep it there.

    Raises `UnsupportedSceneError` where the scene has physics that isn't certified: `CAPABILITIES`
    says why.
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
        if certificate.ending != "time limit":  # another machine, or a quieter hour, gets further
            cache.write(key, certificate)
    return certificate
