"""The ladder of time steps: one engine, played with several steps, and what the errors say.

`explain` plays a shot with the engine's own step and shorter ones (`shorter_steps`);
`ghostball engines --steps` with halved steps, from a long one on (`halved_steps`). What an error
does from step to step says where it comes from (`shrinks`) and which step pays (`knee_step`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

from ghostball.model import Record, Result, Scene
from ghostball.reference_adapters import ReferenceEngine
from ghostball.validation.runs.playing import run_engine

STEP_SETTINGS: Final = ("dt", "frame")
"""Settings that are an engine's step [s], by the names that engines here give it."""

SHORTER: Final = 4.0
"""How many times shorter each of an engine's shorter steps is than the one before."""

LONGEST_STEP: Final = 0.02
"""Where halved steps begin [s], unless the engine's own step is longer: the paper's step."""

MOST_STEPS, MOST_LEVELS = 16_000, 20
"""Steps that a shot may take with the shortest halved step, and levels, from the longest step."""

GOES_AWAY: Final = 0.5
"""A difference goes away where the shortest step leaves at most this part of it.

A step sees a contact late by any part of it: a ball's error over the step is as good as random. So
the largest difference at the two longer steps is compared with that at a sixteenth: where it is the
step's, it stays above this part in one shot of fifty, by chance.
"""


def step_setting(engine: ReferenceEngine) -> str | None:
    """Return the name of the setting that is the engine's step, or None where it has none."""
    fields = type(engine.settings).model_fields
    return next((name for name in STEP_SETTINGS if name in fields), None)


def step_of(engine: ReferenceEngine) -> float | None:
    """Return the engine's step [s], or None where it has none.

    A setting that is left out may stand for a step: the settings' property `step` then says which.
    """
    name = step_setting(engine)
    if name is None:
        return None
    value = getattr(engine.settings, name)
    return getattr(engine.settings, "step", None) if value is None else float(value)


def step_in(settings: Mapping[str, Any]) -> float | None:
    """Return the step [s] in the settings of a run, as plain values; None where it has none."""
    return next((float(settings[name]) for name in STEP_SETTINGS if settings.get(name)), None)


def with_step(engine: ReferenceEngine, step: float) -> ReferenceEngine:
    """Return the same engine with another step [s]."""
    name = step_setting(engine)
    assert name is not None, "the engine has no step"
    return with_setting(engine, name, step)


def with_setting(engine: ReferenceEngine, name: str, value: Any) -> ReferenceEngine:
    """Return the same engine with one setting changed.

    Raises `ValidationError` where the engine has no such setting, or refuses the value.
    """
    settings = type(engine.settings).model_validate(engine.settings.model_dump() | {name: value})
    make: Any = type(engine)  # see `make_engine`
    made: ReferenceEngine = make(settings)
    return made


def shorter_steps(engine: ReferenceEngine, count: int) -> list[float]:
    """Return the engine's own step and shorter ones, `count` in all [s].

    Empty if the engine has no step.
    """
    own = step_of(engine)
    return [] if own is None else [own / SHORTER**k for k in range(count)]


def halved_steps(own: float, duration: float) -> Iterator[float]:
    """Yield steps [s], each half of the one before; an engine's own step is one of them.

    `duration` [s]: of the shot.
    """
    longest = own
    while 2.0 * longest <= LONGEST_STEP:
        longest *= 2.0
    for level in range(MOST_LEVELS):
        step = longest / 2.0**level
        if step < own and duration / step > MOST_STEPS:
            return
        yield step


def run_with_step(
    engine: ReferenceEngine, scene: Scene, step: float | None, record: Record = "events"
) -> Result:
    """Run a scene with a step of the engine [s]; None: its own. See `run_engine`."""
    return run_engine(engine if step is None else with_step(engine, step), scene, record)


def shrinks(errors: Sequence[float]) -> bool:
    """Return whether the shortest step leaves little of the errors at the longer ones.

    `errors`: the longest step's first.
    """
    return len(errors) > 1 and errors[-1] <= GOES_AWAY * max(errors[:-1])


def knee_step(errors: Mapping[float, float]) -> float | None:
    """Return the longest step worth its cost [s]; None if there are no errors.

    It is that of the least error, times the root of the steps that it takes: so from any coarser
    one four times the steps at least halve the error, and to any finer one not.

    `errors`: of each step [s] that has one.

    Steps are counted, not timed: so the answer is the same on every machine.
    """
    return min(errors, key=lambda step: (errors[step] / step**0.5, -step), default=None)
