"""The points at which an engine is measured: a ladder of its step, or itself where it has none."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from ghostball.model import Record, Result, Scene
from ghostball.reference_adapters import ReferenceEngine, parse_spec
from ghostball.reference_adapters.certified import CertifiedEngine, CertifiedSettings, certify
from ghostball.reference_adapters.certified.engine import result_of
from ghostball.reference_adapters.output import captured
from ghostball.reference_adapters.registry import spec_of
from ghostball.validation.precision.phases import begun_earlier
from ghostball.validation.runs.playing import run_engine
from ghostball.validation.runs.steps import step_of, step_setting, with_step

LONGEST_STEP = 0.02
"""Where a ladder begins [s], unless the engine's own step is longer: the paper's step."""


MOST_STEPS, MOST_LEVELS = 16_000, 20
"""Steps that a shot may take at the finest level of a ladder, and levels, from the coarsest."""


@dataclass(frozen=True, eq=False)
class Rung:
    """One engine with all of its settings.

    `family`: the engine as asked for: one curve.
    `label`: with the step of this point.
    `step` [s]: none where the engine has none: a point, no ladder.
    """

    family: str
    label: str
    engine: ReferenceEngine
    step: float | None

    def simulate(self, scene: Scene) -> tuple[Result, float]:
        """Run a scene to its end; return the result and the run time of the whole call [s].

        A certified result is always computed: a stored one would take no time.
        """
        if not isinstance(self.engine, CertifiedEngine):
            # The collisions of a ladder are looked at; an exact engine isn't slowed by its log.
            record: Record = "rest" if self.step is None else "events"
            timed: Any = _TimedEngine(self.engine)
            with captured():
                result = run_engine(timed, scene, record)
            return result, float(timed.seconds)
        self.engine.check(scene)
        settings: CertifiedSettings = self.engine.settings
        began = time.perf_counter()
        result = result_of(scene, certify(scene, settings, cached=False), settings, "rest")
        return result, time.perf_counter() - began


class _TimedEngine:
    """An engine that records the run time of each of its calls, without the checks around them."""

    def __init__(self, engine: ReferenceEngine) -> None:
        self.engine = engine
        self.seconds = math.nan

    def __getattr__(self, name: str) -> Any:
        """Return what isn't here from the engine, such as its name."""
        return getattr(self.engine, name)

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Run the scene on the engine, and note the seconds that the call took."""
        began = time.perf_counter()
        result = self.engine.simulate(scene, record=record)
        self.seconds = time.perf_counter() - began
        return result


def ladder_of(family: str, engine: ReferenceEngine, duration: float) -> Iterator[Rung]:
    """Yield an engine at halved steps, the longest first; its own step is one of them.

    `family`: the engine as asked for.
    `duration` [s]: of the shot.
    """
    step = step_of(engine)
    if step is None:
        yield Rung(family, family, engine, None)
        return
    longest = step
    while 2.0 * longest <= LONGEST_STEP:
        longest *= 2.0
    name, settings = parse_spec(family)
    for level in range(MOST_LEVELS):
        now = longest / 2.0**level
        if now < step and duration / now > MOST_STEPS:
            return
        settings[step_setting(engine) or ""] = repr(now)
        yield Rung(family, spec_of(name, settings), with_step(engine, now), now)


def part_of_step(turn: int) -> float:
    """Return where in a step the shot begins in a turn: 0, 1/2, 1/4, 3/4, 1/8, ...

    The first 1, 2, 4, 8, ... are spread evenly, however many follow.

    van der Corput (1935), base 2: the binary digits of the turn, mirrored at the point.
    """
    part, digit = 0.0, 0.5
    while turn:
        turn, bit = divmod(turn, 2)
        part += bit * digit
        digit /= 2.0
    return part


def start_of(scene: Scene, rung: Rung, turn: int) -> Scene:
    """Return the shot as it begins in a turn; the scene itself where it can't begin there."""
    if rung.step is None:
        return scene
    return begun_earlier(scene, part_of_step(turn) * rung.step) or scene
