"""An engine that is a function of a scene, named by where it is: `my_module:simulate`.

    def simulate(scene, dt=1e-3):
        ...
        return {"rest_positions": x, "events": events, "samples": samples}

    rest_positions  where the balls end [m]: (n, 2) or (n, 3), in the order of the scene's balls
    events          (t, kind, a, b) each: "ball-ball" of two balls, or "ball-cushion" of a ball and
                    a cushion's name ("left", "right", "bottom", "top") or index; others too
    samples         (t, positions, velocities, angular_velocities) each: the motion, from t = 0 to
                    the end. Balls that roll without slip need no angular velocities

`answer` says which keys the dict may hold.

Its parameters with a default are its settings, but for those that begin with an underscore:
`-e my_module:simulate:dt=1e-4`. One that is called `dt` is its step: what that allows is then
computed, shot by shot. What it plays is said by `plays`; a function that says nothing is asked for
balls that roll on a table with cushions that mirror.
"""

from __future__ import annotations

import copyreg
import inspect
import math
import time
from abc import ABCMeta
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from importlib import import_module
from operator import attrgetter
from typing import Any, ClassVar, Final, TypeVar

import numpy as np
from pydantic import Field, create_model

from ghostball.model import (
    EngineFailedError,
    Record,
    Result,
    SampledTrajectory,
    Samples,
    Scene,
    Status,
    UnsupportedSceneError,
)
from ghostball.model.features import EXACT, Capabilities, Capability, Feature
from ghostball.reference_adapters.answer import Run
from ghostball.reference_adapters.base import (
    EngineBase,
    EngineError,
    EngineSettings,
    Resolution,
    resolution_of_step,
)
from ghostball.reference_adapters.returned import ResultRefusedError, check_result

Engine = TypeVar("Engine", bound=Callable[..., Any])

STEP: Final = "dt"
"""The parameter that is a function's step [s]."""

FIRST: Final = (Feature.ROLLING, Feature.MIRROR_CUSHION)
"""What a function is asked for that says nothing of what it plays."""

_PLAYED = "__ghostball_features__"
_UNSTATED = "a function without a parameter `dt` declares no accuracy"


def plays(*features: Feature) -> Callable[[Engine], Engine]:
    """Say what of a scene an engine that is a function represents: only that is asked of it.

    >>> @plays(Feature.ROLLING, Feature.MIRROR_CUSHION, Feature.BALL_RESTITUTION)
    ... def simulate(scene, dt=1e-3): ...
    """
    for one in features:
        if not isinstance(one, Feature):
            raise EngineError(
                f"`plays` must be given members of `Feature`, got {one!r}. "
                f"There are {', '.join(feature.name for feature in Feature)}"
            )

    def decorate(function: Engine) -> Engine:
        setattr(function, _PLAYED, features)
        return function

    return decorate


def name_of_function(where: str) -> str:
    """Return the name of the engine that a function is: of its module where it is `simulate`."""
    module, _, attribute = where.partition(":")
    return module.rpartition(".")[2] if attribute == "simulate" else attribute


class FunctionSettings(EngineSettings):
    """The parameters of a function that have defaults."""

    where: ClassVar[str] = ""

    def __reduce__(self) -> Any:
        return _settings_again, (self.where, self.model_dump())


class _FunctionType(ABCMeta):
    """The type of classes that are made of functions: another process makes them again."""


class FunctionEngine(EngineBase, metaclass=_FunctionType):
    """A function as an engine.

    `where`: `MODULE:FUNCTION`.
    `features`: what it plays.
    """

    where: ClassVar[str] = ""
    features: ClassVar[Sequence[Feature]] = FIRST
    function: ClassVar[Callable[..., Any]]

    @property
    def capabilities(self) -> Capabilities:
        """What it says it plays: exactly but for its step, or nearly where it states none."""
        known = STEP in type(self.settings).model_fields
        how = EXACT if known else Capability("approximate", _UNSTATED)
        return dict.fromkeys(self.features, how)

    def resolution(self, scene: Scene) -> Resolution:
        """Return what a ball goes in a step [m]; None where the function has none."""
        step = getattr(self.settings, STEP, None)
        return None if step is None else resolution_of_step(step, scene)

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Call the function, and make a result of what it returns.

        Raises `EngineFailedError` where that is none; `UnsupportedSceneError` where the function
        raises `NotImplementedError`.
        """
        self.check(scene)
        started = time.perf_counter()
        name, settings = self.name, self.settings.model_dump()
        try:
            answer = type(self).function(scene, **settings)
        except NotImplementedError as error:
            raise UnsupportedSceneError(name, (str(error) or "not implemented",)) from error
        seconds = time.perf_counter() - started
        try:
            what = f'what `{self.where}` returned for scene "{scene.name}"'
            known = {"engine": name, "settings": settings, "wall_time": seconds}
            result = Run.returned(answer, what, scene, **known).result(scene, where=what)
            _check_finite(result, what)
            check_result(result, scene, name)
        except (EngineError, ResultRefusedError) as error:
            raise EngineFailedError(name, str(error)) from None
        return replace(
            result,
            work={},
            events=None if record == "rest" else result.events,
            trajectory=result.trajectory if record == "trajectory" else None,
        )


def _check_finite(result: Result, where: str) -> None:
    """Raise where a number of the motion isn't finite: a ball ends in a place, and came there."""
    motion = result.trajectory
    assert isinstance(motion, SampledTrajectory)
    if result.status is Status.FAILED:
        return
    for key in Samples._fields:
        states = getattr(motion, key)
        wrong = np.argwhere(~np.isfinite(states).all(axis=2))
        if len(wrong):
            k, ball = wrong[0].tolist()
            raise EngineError(
                f"{where}: `samples.{key}` must be finite, got {states[k, ball].tolist()} at "
                f'{float(motion.times[k])!r} s for ball "{result.scene.balls[ball].id}"'
            )


copyreg.pickle(_FunctionType, lambda made: (engine_at, (made.__dict__["where"],)))


def engine_at(where: str) -> type[FunctionEngine]:
    """Return the engine that the function `MODULE:FUNCTION` is."""
    module, _, attribute = where.partition(":")
    return engine_of(attrgetter(attribute)(import_module(module)), where)


def engine_of(function: Callable[..., Any], where: str) -> type[FunctionEngine]:
    """Return a function as the class of an engine; `where` is `MODULE:FUNCTION`.

    Raises `EngineError` where it can't be called with a scene alone, or where its parameters make
    no settings.
    """
    if not isinstance(function, Hashable):  # one class is made of each
        raise EngineError(
            f"engine `{where}` must be a function, got an object of `{type(function).__name__}`, "
            "which can't be hashed. Name a function that calls it"
        )
    return _class_of(function, where)


@cache
def _class_of(function: Callable[..., Any], where: str) -> type[FunctionEngine]:
    name = name_of_function(where)
    features = getattr(function, _PLAYED, FIRST)
    return _FunctionType(
        name,
        (FunctionEngine,),
        {
            "__module__": where.partition(":")[0],
            "__doc__": function.__doc__,
            "name": name,
            "where": where,
            "features": tuple(features),
            "function": staticmethod(function),
            "Settings": _settings_of(function, where),
        },
    )  # type: ignore[return-value]


def _settings_of(function: Callable[..., Any], where: str) -> type[FunctionSettings]:
    try:
        _, *others = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):
        raise EngineError(
            f"engine `{where}` must take a scene: `def {where.rpartition(':')[2]}(scene): ...`"
        ) from None
    fields: dict[str, Any] = {}
    for one in others:
        if one.kind in (one.VAR_POSITIONAL, one.VAR_KEYWORD):
            continue
        if one.default is one.empty:
            raise EngineError(
                f"engine `{where}` is called with a scene alone: its parameter `{one.name}` must "
                "have a default value, so that it is a setting"
            )
        if one.name.startswith("_") or not isinstance(one.default, str | int | float | bool):
            continue
        if hasattr(FunctionSettings, one.name):
            raise EngineError(
                f"engine `{where}`: its parameter `{one.name}` can't be a setting: the name is "
                "reserved. Rename it, or start it with an underscore"
            )
        if one.name == STEP:
            fields[STEP] = (float, Field(_checked_step(one.default, where), gt=0.0))
        else:
            fields[one.name] = (type(one.default), Field(one.default))
    made = create_model("Settings", __base__=FunctionSettings, **fields)
    made.where = where
    return made


def _checked_step(default: str | int | float | bool, where: str) -> float:
    if isinstance(default, str) or not 0.0 < default < math.inf:
        raise EngineError(
            f"engine `{where}`: its parameter `{STEP}` is its time step, so its default must be a "
            f"number of seconds greater than 0, got {default!r}. Give it one, or rename it"
        )
    return float(default)


def _settings_again(where: str, values: Mapping[str, Any]) -> EngineSettings:
    return engine_at(where).Settings(**values)
