"""An exact engine whose contacts are early by up to a time step, in place of late contacts."""

from __future__ import annotations

import random

import numpy as np

from ghostball import Feature, plays
from ghostball.model import COLLISION_KINDS, Ball, EventKind, Scene
from ghostball.reference_adapters.certified.laws import (
    ImpactLaws,
    from_contact_frame,
    to_contact_frame,
)
from ghostball.reference_adapters.certified.problem import problem_of
from ghostball.validation.grading.slope import Slope
from ghostball.validation.runs.engine_runs import run_ours
from ghostball.validation.runs.sampling import events_of

# At an early contact no balls overlap, so a new scene can continue the motion. To first order, an
# early contact displaces the later motion as much as a late contact, in the opposite direction.


def _plain(value: float) -> Slope:
    return Slope(float(value), np.zeros(1))


@plays(*Feature)
def displaced(scene: Scene, dt: float = 1e-3, seed: int = 0) -> dict[str, object]:
    """Simulate a shot with contacts early by a random part of `dt` [s]; for seed 0, by `dt`."""
    scene = scene.without_strikes()
    laws, chance = ImpactLaws(problem_of(scene)), random.Random(f"{seed} {scene.name}")
    rolling, radii = scene.physics.motion == "rolling", scene.radii
    x, v, w = scene.positions.copy(), scene.velocities.copy(), scene.angular_velocities.copy()
    events: list[tuple[object, ...]] = []
    samples = [(0.0, x.copy(), v.copy(), w.copy())]
    here, start, rows = scene, 0.0, list(range(len(scene.balls)))
    while True:
        run = run_ours(here)
        log = events_of(run)
        hits = np.flatnonzero(np.isin(log["kind"], COLLISION_KINDS))
        hit = log[hits[0]] if len(hits) else None
        early = chance.random() if seed else 1.0
        due = run.rest_time if hit is None else float(hit["t"])
        # A contact is early by at most half of the time since the last contact. Otherwise balls
        # that friction pushes together would collide endlessly at one time.
        t = due if hit is None else max(due - dt * early, 0.5 * due)
        before = log[: hits[0]] if len(hits) else log
        for one in before[before["t"] <= t]:
            kind, a = EventKind(int(one["kind"])), rows[one["a"]]
            pocket = int(one["b"]) if kind is EventKind.POCKETED else None
            events.append((start + float(one["t"]), kind.label, a, pocket))
        gone = {k for _, kind, k, _ in events if kind == EventKind.POCKETED.label}
        x[rows], v[rows], w[rows] = (part[0] for part in run.sample([t]))
        start += t
        if hit is None:
            break
        a, b = rows[hit["a"]], int(hit["b"])
        balls = (a,)
        if int(hit["kind"]) == EventKind.BALL_BALL:
            b = rows[b]
            balls, way = (a, b), x[b, :2] - x[a, :2]
            normal = way / np.hypot(*way)
        else:
            normal = -np.array(scene.table.facing(b, *x[a, :2].tolist())[0])
        n = (_plain(normal[0]), _plain(normal[1]))
        seen = []
        for k in balls:
            slip = v[k, :2] - radii[k] * w[k, [1, 0]] * (1.0, -1.0)
            parts = tuple((_plain(p), _plain(q)) for p, q in (v[k, :2], slip))
            seen.append(to_contact_frame(n, *parts, _plain(w[k, 2]), float(radii[k])))
        after = laws.collide(a, b, *seen) if len(balls) == 2 else (laws.bounce(a, seen[0]),)
        for k, one in zip(balls, after, strict=True):
            velocity, slip = (np.array([float(p) for p in q]) for q in from_contact_frame(n, one))
            turning = velocity if rolling else velocity - slip
            v[k, :2] = velocity
            w[k] = (-turning[1] / radii[k], turning[0] / radii[k], float(one.wz))
        events.append((start, EventKind(int(hit["kind"])).label, a, b))
        samples.append((start, x.copy(), v.copy(), w.copy()))
        rows = [k for k in rows if k not in gone]
        left = None if scene.t_max is None else scene.t_max - start
        moved = [
            Ball(
                **dict(scene.balls[k])
                | {
                    "position": tuple(x[k, :2]),
                    "velocity": tuple(v[k, :2]),
                    "angular_velocity": None if rolling else tuple(w[k]),
                }
            )
            for k in rows
        ]
        here = Scene(
            name=scene.name, physics=scene.physics, table=scene.table, balls=moved, t_max=left
        )
    samples.append((start, x.copy(), v.copy(), w.copy()))
    status = "rest" if scene.t_max is None or start < scene.t_max * (1 - 1e-12) else "t-max"
    return {"rest_positions": x, "events": events, "samples": samples, "status": status}
