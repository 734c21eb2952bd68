"""The engine's front door: check the scene, run the kernel, wrap what it found."""

from __future__ import annotations

from engine.features import EXACT, Capability, Feature, check_supported
from engine.result import Record, Result
from engine.scene import Scene

_LATER = Capability("none", "not in this version of the engine")

CAPABILITIES = {
    Feature.ROLLING: EXACT,
    Feature.SLIDING: _LATER,
    Feature.FRICTIONLESS_CLOTH: EXACT,
    Feature.VERTICAL_SPIN: _LATER,
    Feature.BALL_RESTITUTION: EXACT,
    Feature.BALL_FRICTION: _LATER,
    Feature.UNEQUAL_MASSES: EXACT,
    Feature.UNEQUAL_RADII: EXACT,
    Feature.UNBOUNDED_CLOTH: EXACT,
    Feature.OPEN_SIDES: EXACT,
    Feature.MIRROR_CUSHION: EXACT,
    Feature.CUSHION_RESTITUTION: EXACT,
    Feature.CUSHION_TANGENTIAL: EXACT,
    Feature.FRICTIONAL_CUSHION: _LATER,
    Feature.HAN_CUSHION: _LATER,
    Feature.MATHAVAN_CUSHION: _LATER,
    Feature.AIR_DRAG: _LATER,
    Feature.FLIGHT: _LATER,
}


def simulate(scene: Scene, *, record: Record = "rest", max_events: int = 1_000_000) -> Result:
    """Simulate `scene`."""
    check_supported("ghostball", CAPABILITIES, scene)
    raise NotImplementedError(record, max_events)
