"""The features of a scene's physics that Ghostball's engine supports."""

from __future__ import annotations

from ghostball.model.features import EXACT, Capabilities, Capability, Feature

_INTEGRATED = Capability("approximate", "integrated to an accuracy of 1e-7 of the speeds")

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
    Feature.STRONGE_CUSHION: EXACT,
    Feature.AIR_DRAG: EXACT,
    Feature.QUADRATIC_ROLLING: EXACT,
    Feature.FLIGHT: EXACT,
    Feature.COMPLIANT: Capability(
        "approximate", "integrated; the speeds after a break at 10 m/s are within 1e-5 m/s"
    ),
}
"""Support of each feature by Ghostball's engine; features that aren't listed are unsupported."""
