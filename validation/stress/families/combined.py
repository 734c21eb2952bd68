"""Combined: random scenes of all that the engine knows, put to all that it says is the same."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from ghostball.model import Scene
from ghostball.reference_adapters import ReferenceEngine
from ghostball.validation.scenes.random_scenes import ASPECTS, random_scene
from ghostball.validation.stress.random_trials import random_trials
from ghostball.validation.stress.same import OFTEN, SELDOM, Same
from ghostball.validation.stress.same.plays import sweep
from ghostball.validation.stress.trial import Family, Suite, Trial, Verdict

LONG_SWEEP = 600
"""Shots of a sweep that threads share among them: more than each takes at a time."""


@dataclass(frozen=True)
class LongSweep(Trial):
    """A sweep of a random scene, long enough for threads to share it, against its shots."""

    name: str
    scene: Scene
    limit: ClassVar[float] = 300.0

    def run(self, engine: ReferenceEngine) -> Verdict:  # noqa: ARG002 - it is about our engine
        """Compare them."""
        found = sweep(self.scene, LONG_SWEEP)
        return Verdict.of(self.scene, [] if found is None else [found])


def _trials(suite: Suite) -> Iterator[Trial]:
    quick = suite == "quick"
    yield from random_trials("all", Same(OFTEN), *((50, 8) if quick else (200, 100)))
    fewer = (10, 2) if quick else (20, 20)
    shapes = ("polygon", "pockets", "posts")
    yield from random_trials("falling", Same(OFTEN), *fewer, cushion="falling")
    yield from random_trials("shape", Same(OFTEN), *fewer, table=shapes)
    yield from random_trials("struck", Same(OFTEN), *fewer, spin="struck")
    aloft = tuple(how for how in ASPECTS["flight"] if how != "no")
    yield from random_trials("flight-in-air", Same(OFTEN), *fewer, air="yes", flight=aloft)
    yield from random_trials("flight-over-shapes", Same(OFTEN), *fewer, table=shapes, flight=aloft)
    yield from random_trials("stored", Same(SELDOM), *((4, 1) if quick else (10, 10)))
    for flight in ASPECTS["flight"]:
        for number in range(1 if quick else 20):
            scene = random_scene(number, flight=flight, count="few", speed="usual")
            yield LongSweep(f"sweep-flight-{flight}-{number:02d}", scene)


FAMILY = Family(
    "combined",
    "Every feature with every other",
    "A random scene of any two features and whatever else comes out the same to the bit: alone, "
    "in a batch, in a sweep on any number of threads and as one of many starts, with the scheduler "
    "of few balls and of many, with each skip off, renumbered and mirrored; the scene, the run and "
    "the proof read back as they were stored; its motion agrees with its events and its end, and "
    "gains no energy.",
    _trials,
    ours_alone=True,
)
