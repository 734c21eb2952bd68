"""Functions as engines that say nothing of how exact they are, and a shot that moves nothing."""

from __future__ import annotations

from ghostball.model import Scene
from ghostball.model.features import Feature
from ghostball.reference_adapters import plays

PLAYED = (Feature.ROLLING, Feature.MIRROR_CUSHION, Feature.BALL_RESTITUTION)


@plays(*PLAYED)
def lazy(scene: Scene) -> dict[str, object]:
    """Move nothing, and state no step."""
    return _unmoved(scene)


@plays(*PLAYED)
def stepping(scene: Scene, dt: float = 1e-3) -> dict[str, object]:
    """Move nothing, and state a step."""
    return _unmoved(scene)


def _unmoved(scene: Scene) -> dict[str, object]:
    samples = [(0.0, scene.positions, scene.velocities)]
    return {"rest_positions": scene.positions, "events": [], "samples": samples}
