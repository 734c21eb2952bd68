"""The step of an engine that has one: which setting it is, and the engine at another one."""

from __future__ import annotations

from typing import Any

from ghostball.reference_adapters import ReferenceEngine

STEP_SETTINGS = ("dt", "frame")
"""Settings that are an engine's step [s], by the names that engines here give it."""


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
