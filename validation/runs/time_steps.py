"""Run one engine with several time steps, and interpret the errors.

`explain` runs a shot with the engine's own time step and shorter ones (`shorter_steps`); `ghostball
engines --steps` uses steps that are halved repeatedly (`halved_steps`). The change of the error
with the step shows its cause (`shrinks`) and the step that is worth its cost (`knee_step`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

from ghostball.model import Record, Result, Scene
from ghostball.reference_adapters import ReferenceEngine
from ghostball.validation.runs.engine_runs import run_engine

STEP_SETTINGS: Final = ("dt", "frame")
"""Names of settings that hold the time step of an engine [s]."""

STEP_RATIO: Final = 4.0
"""Ratio between consecutive steps of `shorter_steps`."""

LONGEST_STEP: Final = 0.02
"""Longest of the halved steps [s], unless the engine's own step is longer: the step of the paper.
"""

MOST_STEPS, MOST_LEVELS = 16_000, 20
"""Largest number of time steps in a shot, and of halved steps."""

REMAINING_SHARE: Final = 0.5
"""A difference disappears if the shortest step leaves at most this share of it.

A contact is detected late by a random part of a time step, so the error divided by the step is
nearly random. The largest difference at the two longer steps is therefore compared with the
difference at a sixteenth of the step. If the step is the cause, chance keeps the share above this
limit in one shot of fifty.
"""


def step_setting(engine: ReferenceEngine) -> str | None:
    """Return the name of the setting that holds the time step of an engine, or None."""
    fields = type(engine.settings).model_fields
    return next((name for name in STEP_SETTINGS if name in fields), None)


def step_of(engine: ReferenceEngine) -> float | None:
    """Return the time step of an engine [s], or None if it has none.

    If the setting is None, the property `step` of the settings gives the step, if it exists.
    """
    name = step_setting(engine)
    if name is None:
        return None
    value = getattr(engine.settings, name)
    return getattr(engine.settings, "step", None) if value is None else float(value)


def step_in(settings: Mapping[str, Any]) -> float | None:
    """Return the time step [s] in the settings of a run (plain values); None if there is none."""
    return next((float(settings[name]) for name in STEP_SETTINGS if settings.get(name)), None)


def with_step(engine: ReferenceEngine, step: float) -> ReferenceEngine:
    """Return the same engine with another time step [s]."""
    name = step_setting(engine)
    assert name is not None, "the engine has no step"
    return with_setting(engine, name, step)


def with_setting(engine: ReferenceEngine, name: str, value: Any) -> ReferenceEngine:
    """Return the same engine with one setting changed.

    Raises `ValidationError` if the engine has no such setting, or refuses the value.
    """
    settings = type(engine.settings).model_validate(engine.settings.model_dump() | {name: value})
    make: Any = type(engine)  # see `make_engine`
    made: ReferenceEngine = make(settings)
    return made


def shorter_steps(engine: ReferenceEngine, count: int) -> list[float]:
    """Return `count` time steps [s]: the engine's own and shorter ones.

    Empty if the engine has no time step.
    """
    own = step_of(engine)
    return [] if own is None else [own / STEP_RATIO**k for k in range(count)]


def halved_steps(own: float, duration: float) -> Iterator[float]:
    """Yield time steps [s], each half of the one before; the engine's own step is one of them.

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
    """Run a scene with a time step of the engine [s]; None: its own. See `run_engine`."""
    return run_engine(engine if step is None else with_step(engine, step), scene, record)


def shrinks(errors: Sequence[float]) -> bool:
    """Return True if the shortest step has a much smaller error than the longer ones.

    `errors`: in the order of the steps, the longest step first.
    """
    return len(errors) > 1 and errors[-1] <= REMAINING_SHARE * max(errors[:-1])


def knee_step(errors: Mapping[float, float]) -> float | None:
    """Return the longest time step that is worth its cost [s]; None without errors.

    This step has the smallest product of error and square root of the number of steps. Compared
    with any longer step, using four times as many steps at least halves the error; with any shorter
    step it doesn't.

    `errors`: by time step [s].

    Steps are counted, not timed, so the answer is the same on every machine.
    """
    return min(errors, key=lambda step: (errors[step] / step**0.5, -step), default=None)
