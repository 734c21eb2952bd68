"""Wrong engines, as functions; two of them declare no accuracy."""

from __future__ import annotations

import numpy as np

from ghostball.model import EventKind, Scene
from ghostball.model.features import Feature
from ghostball.reference_adapters import plays
from ghostball.validation.runs.engine_runs import run_ours
from ghostball.validation.runs.sampling import events_of

PLAYED = (Feature.ROLLING, Feature.MIRROR_CUSHION, Feature.BALL_RESTITUTION)


@plays(*PLAYED)
def lazy(scene: Scene) -> dict[str, object]:
    """Move nothing, and declare no time step."""
    return _unmoved(scene)


@plays(*PLAYED)
def braked(scene: Scene) -> dict[str, object]:
    """Let balls roll half as far, and declare no time step."""
    friction = 2.0 * scene.physics.rolling_friction
    physics = scene.physics.model_copy(update={"rolling_friction": friction})
    run = run_ours(scene.model_copy(update={"physics": physics}))
    times = np.linspace(0.0, run.rest_time, 200)
    samples = [(float(t), *(part[0] for part in run.sample([t]))) for t in times]
    return {
        "rest_positions": run.rest_positions,
        "events": [(e["t"], EventKind(e["kind"]).label, e["a"], e["b"]) for e in events_of(run)],
        "samples": samples,
    }


@plays(*PLAYED)
def stepping(scene: Scene, dt: float = 1e-3) -> dict[str, object]:
    """Move nothing, and declare a time step."""
    return _unmoved(scene)


def _unmoved(scene: Scene) -> dict[str, object]:
    samples = [(0.0, scene.positions, scene.velocities)]
    return {"rest_positions": scene.positions, "events": [], "samples": samples}
