"""An example engine with one deliberate mistake, for `ghostball validate`: replace it by your own.

The mistake: balls bounce off each other without loss, whatever the scene's `ball_restitution` is.
`ghostball validate` fails in the scene restitution-head-on, and `ghostball explain` names the
coefficient. To fix the mistake, change one line: `restitution = physics.ball_restitution`.
"""

import numpy as np

from ghostball import Feature, Scene, plays


@plays(
    *(Feature.ROLLING, Feature.FRICTIONLESS_CLOTH, Feature.BALL_RESTITUTION),
    *(Feature.MIRROR_CUSHION, Feature.UNBOUNDED_CLOTH),
)
def simulate(scene: Scene, dt: float = 1e-3) -> dict[str, object]:
    """Let balls roll in time steps of `dt` seconds, and bounce if they overlap."""
    physics, table, end = scene.physics, scene.table, scene.t_max or np.inf
    t, x, v, radius = 0.0, scene.positions[:, :2], scene.velocities[:, :2], scene.radii[0]
    near = radius if table else -np.inf
    far = np.array([table.length, table.width]) - radius if table else np.inf
    first, second = np.triu_indices(len(x), k=1)  # each pair of balls
    restitution = 1.0  # the mistake: it must be physics.ball_restitution
    events, samples = [], [(t, x, v)]
    while v.any() and t < end:
        step = min(dt, end - t)
        slowing = step * physics.gravity * physics.rolling_friction
        speed = np.linalg.norm(v, axis=1, keepdims=True)
        v = v * np.maximum(1.0 - slowing / np.maximum(speed, 1e-9), 0.0)
        x, t = x + step * v, t + step
        leaving = ((x < near) & (v < 0.0)) | ((x > far) & (v > 0.0))
        v[leaving] *= -1.0
        for ball, axis in np.argwhere(leaving):  # cushions: 0 left, 1 right, 2 bottom, 3 top
            events.append((t, "ball-cushion", ball, 2 * axis + (v[ball, axis] < 0.0)))
        distances = np.linalg.norm(x[second] - x[first], axis=1)
        for pair in np.flatnonzero(distances < 2.0 * radius):
            a, b = first[pair], second[pair]
            normal = (x[b] - x[a]) / distances[pair]
            approach_speed = (v[a] - v[b]) @ normal
            if approach_speed > 0.0:
                impulse = 0.5 * (1.0 + restitution) * approach_speed * normal
                v[[a, b]] += np.array([-impulse, impulse])
                events.append((t, "ball-ball", a, b))
        samples.append((t, x, v))
    return {"rest_positions": x, "events": events, "samples": samples}
