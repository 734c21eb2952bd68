"""Storms: random breaks with all laws of the cloth; none of them may get stuck."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final

from ghostball.validation.scenes.random_scenes import Wanted, random_scene
from ghostball.validation.stress.common_limits import POSSIBLE
from ghostball.validation.stress.shots import StressFamily, StressShot, StressSize, limit, shot

MOST_EVENTS = 100_000
"""Largest number of events, and of contact steps, in a break."""

BREAKS: Final[Mapping[str, Wanted]] = {
    "layout": ("rack", "loose-rack"),
    "count": "many",
    "table": ("pool", "small"),
    "cloth": "slows",
    "stop": "rest",
    "speed": ("usual", "fast"),
    "flight": "no",
    "along_rail": "no",
}
"""The options of random scenes that are breaks."""

STEPPED_T_MAX = 2.0
"""Simulated time of a break for time-stepping engines [s]: a whole break takes them seconds."""

STEPPED_INTERVAL = 50
"""Time-stepping engines simulate one break of this number of consecutive breaks."""

COUNT, COUNT_OF_ALL = 100, 5_000
"""Number of breaks."""

LIMITS = (
    *POSSIBLE,
    limit("event_count", "Eight times the events of the longest break.", at_most=MOST_EVENTS),
    limit("contact_steps", "Eight times the steps of the longest break.", at_most=MOST_EVENTS),
)


def _shots(size: StressSize) -> Iterator[StressShot]:
    count = size.count or (COUNT_OF_ALL if size.full else COUNT)
    for number in range(size.seed, size.seed + count):
        scene = random_scene(number, **BREAKS)
        yield shot(f"break-{number:05d}", scene, *LIMITS, truth="none", stepped=False)
        if (number - size.seed) % STEPPED_INTERVAL == 0:
            begun = scene.model_copy(update={"t_max": STEPPED_T_MAX})
            name = f"begun-{number:05d}"
            yield shot(name, begun, *LIMITS, truth="none", stepped=True)


FAMILY = StressFamily(
    "storms",
    "Random breaks",
    "A random break with random laws and frictions ends by itself within "
    f"{MOST_EVENTS} events and contact steps, energy never rises, and no ball overlaps another "
    "ball or a cushion by more than the limits allow. Time-stepping engines simulate "
    f"{STEPPED_T_MAX:g} s of one break in {STEPPED_INTERVAL}. --seed and --count choose "
    "other breaks, or more breaks.",
    _shots,
)
