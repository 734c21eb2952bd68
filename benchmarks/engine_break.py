"""Time the engine on shipped scenes, warm, and store what was measured under `benchmarks/results/`.

    python benchmarks/engine_break.py [SCENE[@SPEED] ...]

SPEED [m/s] replaces the first ball's. The scenes take turns, so that a slow moment of the machine
hits all of them; the median is the number to quote. `wall_time` is the simulation alone, `call` the
whole `simulate()`.
"""

from __future__ import annotations

import json
import re
import sys
import time
from pathlib import Path
from statistics import median
from typing import Any

from engine import Scene, simulate
from validation.environment import describe_environment
from validation.library import find_scene

RESULTS = Path(__file__).parent / "results"
DEFAULT_SCENES = (
    "break-16",
    "break-16@8",
    "break-8",
    "break-7",
    "galperin-3",
    "pool-break-9",
    "frozen-break",
    "push",
)
ROUNDS = 200


def scene_of(name: str) -> Scene:
    """Return a shipped scene, its first ball sped up where the name says so."""
    name, _, speed = name.partition("@")
    scene = find_scene(name)
    if not speed:
        return scene
    cue = scene.balls[0]
    factor = float(speed) / cue.speed
    faster = cue.model_copy(update={"velocity": tuple(factor * v for v in cue.velocity)})
    return scene.model_copy(update={"balls": (faster, *scene.balls[1:])})


def measure(names: tuple[str, ...]) -> list[dict[str, Any]]:
    """Run each scene `ROUNDS` times in turn; return one row per scene, times in microseconds."""
    scenes = [scene_of(name) for name in names]
    results = [simulate(scene) for scene in scenes]  # compile, and warm up
    walls: list[list[float]] = [[] for _ in scenes]
    calls: list[list[float]] = [[] for _ in scenes]
    for _ in range(ROUNDS):
        for i, scene in enumerate(scenes):
            started = time.perf_counter()
            walls[i].append(simulate(scene).wall_time)
            calls[i].append(time.perf_counter() - started)
    return [
        {
            "scene": name,
            "balls": len(scene.balls),
            "work": dict(result.work),
            "wall_time_us": {"median": 1e6 * median(wall), "min": 1e6 * min(wall)},
            "call_us": {"median": 1e6 * median(call), "min": 1e6 * min(call)},
            "ns_per_event": 1e9 * median(wall) / result.work["events"],
        }
        for name, scene, result, wall, call in zip(
            names, scenes, results, walls, calls, strict=True
        )
    ]


def main() -> None:
    """Measure, print, store."""
    rows = measure(tuple(sys.argv[1:]) or DEFAULT_SCENES)
    environment = describe_environment()
    words = re.findall(r"[a-z0-9]+", f"{environment['cpu']} {environment['cores']} cores".lower())
    folder = RESULTS / "-".join(words)
    folder.mkdir(parents=True, exist_ok=True)
    stored = folder / "engine_break.json"
    stored.write_text(
        json.dumps({"environment": environment, "rounds": ROUNDS, "rows": rows}, indent=2) + "\n"
    )
    for row in rows:
        wall, call = row["wall_time_us"], row["call_us"]
        print(
            f"{row['scene']:14} {wall['median']:8.1f} us (least {wall['min']:.1f}), "
            f"whole call {call['median']:.1f} us, {row['ns_per_event']:.0f} ns per event"
        )
    print(f"stored in {stored}")


if __name__ == "__main__":
    main()
