"""python-billiards: elastic discs without friction, walls without end."""

import time
from importlib import metadata
from typing import Any

import billiards


def version() -> str:
    """Return the version of the package."""
    return metadata.version("billiards")


def simulate(scene: dict[str, Any]) -> dict[str, Any]:
    """Run a scene to its `t_max`; building the table of pairs is not timed."""
    physics, table = scene["physics"], scene["table"]
    if physics["rolling_friction"] or physics["motion"] != "rolling":
        return {"cannot": "its balls are never slowed"}
    if physics["ball_restitution"] != 1.0 or physics["cushion"] != "mirror" or not table:
        return {"cannot": "its impacts are elastic, on a table with mirrors for cushions"}
    length, width = table["length"], table["width"]
    # Inside is to the left of the way from the first point to the second one.
    corners = [(0.0, 0.0), (length, 0.0), (length, width), (0.0, width)]
    walls = [
        billiards.InfiniteWall(corners[k], corners[(k + 1) % 4], inside="left") for k in range(4)
    ]
    world = billiards.Billiard(walls)
    for ball in scene["balls"]:
        world.add_ball(
            ball["position"][:2], ball["velocity"][:2], radius=ball["radius"], mass=ball["mass"]
        )
    began = time.perf_counter()
    collisions = world.evolve(scene["t_max"])
    return {"seconds": time.perf_counter() - began, "events": len(collisions)}
