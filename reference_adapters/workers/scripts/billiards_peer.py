"""Simulate scenes with python-billiards: elastic discs without friction, infinite cushions."""

import time
from importlib import metadata
from typing import Any

import billiards

_WALLS = {
    "left": ((0, 1), (0, 0)),
    "right": ((1, 0), (1, 1)),
    "bottom": ((0, 0), (1, 0)),
    "top": ((1, 1), (0, 1)),
}


def version() -> str:
    """Return the version of the package."""
    return metadata.version("billiards")


def simulate(scene: dict[str, Any], record: str) -> dict[str, Any]:
    """Simulate a scene to its `t_max`; building the table of pairs isn't timed."""
    physics, table, balls = scene["physics"], scene["table"], scene["balls"]
    if physics["rolling_friction"] or physics["motion"] != "rolling":
        return {"cannot": "it has no friction"}
    if physics["ball_restitution"] != 1.0 or physics["cushion"] != "mirror":
        return {"cannot": "its impacts are elastic, with mirror cushions"}
    names = table["cushions"] if table else []
    size = (table["length"], table["width"]) if table else (0.0, 0.0)
    # The inside is on the left of the direction from the first point to the second.
    cushions = [
        billiards.InfiniteWall(
            *((x * size[0], y * size[1]) for x, y in _WALLS[name]), inside="left"
        )
        for name in names
    ]
    world = billiards.Billiard(cushions)
    for ball in balls:
        world.add_ball(
            ball["position"][:2], ball["velocity"][:2], radius=ball["radius"], mass=ball["mass"]
        )
    seconds, events = 0.0, []
    samples: dict[str, list[Any]] = {
        "t": [],
        "positions": [],
        "velocities": [],
        "angular_velocities": [],
    }

    def sample(t: float) -> None:
        positions, velocities = world.balls_position, world.balls_velocity
        samples["t"].append(t)
        samples["positions"].append(
            [[*map(float, x), b["radius"]] for x, b in zip(positions, balls, strict=True)]
        )
        samples["velocities"].append([[*map(float, v), 0.0] for v in velocities])
        samples["angular_velocities"].append(
            [
                [-float(v[1]) / b["radius"], float(v[0]) / b["radius"], 0.0]
                for v, b in zip(velocities, balls, strict=True)
            ]
        )

    sample(0.0)
    while world.time < scene["t_max"]:
        upcoming = min(world.toi_next[0], world.obstacles_next[0])
        until = min(upcoming, scene["t_max"]) if record == "trajectory" else scene["t_max"]
        if record == "trajectory" and until > world.time:
            # Just before the collision; until then, all velocities are constant.
            moved = world.balls_position + world.balls_velocity * (until - world.time)
            before = [[*map(float, x), b["radius"]] for x, b in zip(moved, balls, strict=True)]
            sample(until)
            samples["positions"][-1] = before
        began = time.perf_counter()
        collisions = world.evolve(until)
        seconds += time.perf_counter() - began
        for t, one, other in collisions:
            obstacle = other if isinstance(other, int) else names[cushions.index(other)]
            kind = "ball-ball" if isinstance(other, int) else "ball-cushion"
            events.append({"t": float(t), "kind": kind, "a": int(one), "b": obstacle})
        sample(float(world.time))
    return {
        "status": "t-max",
        "rest_time": float(world.time),
        "rest_positions": samples["positions"][-1],
        "events": events,
        "samples": samples,
        "wall_time": seconds,
    }
