"""Engines that are functions of a scene, named by their location: `my_module:simulate`.

    def simulate(scene, dt=1e-3):
        ...
        return {"rest_positions": x, "events": events, "samples": samples}

    rest_positions  final positions [m]: (n, 2) or (n, 3), in the order of the scene's balls
    events          list of (t, kind, a, b): "ball-ball" for two balls, or "ball-cushion" for a ball
                    and a cushion, given by its name ("left", "right", "bottom", "top") or index;
                    other kinds are possible
    samples         list of (t, positions, velocities, angular_velocities): the motion from t = 0
                    to the end. Balls that roll without slip need no angular velocities

All keys of the dict are documented in `answer`.

Parameters with a default value are settings, except those that start with an underscore:
`-e my_module:simulate:dt=1e-4`. A parameter called `dt` is the time step, from which the permitted
errors are computed for each shot. The decorator `plays` lists the features that the function
supports; without it, the function is tested with pure rolling on a table with mirror cushions.
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
from ghostball.reference_adapters.answer import EngineAnswer
from ghostball.reference_adapters.base import (
    EngineBase,
    EngineError,
    EngineSettings,
    Resolution,
    resolution_of_step,
)
from ghostball.reference_adapters.returned import ResultRefusedError, check_result

Engine = TypeVar("Engine", bound=Callable[..., Any])

STEP_PARAMETER: Final = "dt"
"""Name of the parameter that is the time step of a function [s]."""

DEFAULT_FEATURES: Final = (Feature.ROLLING, Feature.MIRROR_CUSHION)
"""Features of a function without the decorator `plays`."""

_FEATURES_ATTRIBUTE = "__ghostball_features__"
_UNSTATED = "a function without a parameter `dt` declares no accuracy"


def plays(*features: Feature) -> Callable[[Engine], Engine]:
    """Declare the features that an engine function supports; only these are tested.

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
        setattr(function, _FEATURES_ATTRIBUTE, features)
        return function

    return decorate


def name_of_function(where: str) -> str:
    """Return the engine name of a function: its own, or that of its module for `simulate`."""
    module, _, attribute = where.partition(":")
    return module.rpartition(".")[2] if attribute == "simulate" else attribute


class FunctionSettings(EngineSettings):
    """The parameters of a function that have default values."""

    where: ClassVar[str] = ""

    def __reduce__(self) -> Any:
        return _restore_settings, (self.where, self.model_dump())


class _FunctionType(ABCMeta):
    """The type of classes created from functions; a different process creates the class again."""


class FunctionEngine(EngineBase, metaclass=_FunctionType):
    """A function as an engine.

    `where`: location, `MODULE:FUNCTION`.
    `features`: supported features.
    """

    where: ClassVar[str] = ""
    features: ClassVar[Sequence[Feature]] = DEFAULT_FEATURES
    function: ClassVar[Callable[..., Any]]

    @property
    def capabilities(self) -> Capabilities:
        """The declared features: exact up to the time step; approximate without a time step."""
        known = STEP_PARAMETER in type(self.settings).model_fields
        how = EXACT if known else Capability("approximate", _UNSTATED)
        return dict.fromkeys(self.features, how)

    def resolution(self, scene: Scene) -> Resolution:
        """Return the distance that a ball moves in one time step [m]; None without a step."""
        step = getattr(self.settings, STEP_PARAMETER, None)
        return None if step is None else resolution_of_step(step, scene)

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Call the function, and convert its return value to a result.

        Raises `EngineFailedError` if the return value is invalid; `UnsupportedSceneError` if the
        function raises `NotImplementedError`.
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
            what = f'return value of `{self.where}` for scene "{scene.name}"'
            known = {"engine": name, "settings": settings, "wall_time": seconds}
            result = EngineAnswer.returned(answer, what, scene, **known).result(
                scene, where=what, none="None"
            )
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
    """Raise `EngineError` if a number of the motion isn't finite."""
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
    """Return the engine class of the function at `MODULE:FUNCTION`."""
    module, _, attribute = where.partition(":")
    return engine_of(attrgetter(attribute)(import_module(module)), where)


def engine_of(function: Callable[..., Any], where: str) -> type[FunctionEngine]:
    """Return the engine class of a function; `where` is its location, `MODULE:FUNCTION`.

    Raises `EngineError` if the function can't be called with only a scene, or if its parameters
    can't be settings.
    """
    if not isinstance(function, Hashable):  # the class of each function is cached
        raise EngineError(
            f"engine `{where}` must be a function, got an object of `{type(function).__name__}`, "
            "which can't be hashed. Name a function that calls it"
        )
    return _class_of(function, where)


@cache
def _class_of(function: Callable[..., Any], where: str) -> type[FunctionEngine]:
    name = name_of_function(where)
    features = getattr(function, _FEATURES_ATTRIBUTE, DEFAULT_FEATURES)
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
                f"engine `{where}` is called with only a scene: its parameter `{one.name}` must "
                "have a default value; it then becomes a setting"
            )
        if one.name.startswith("_") or not isinstance(one.default, str | int | float | bool):
            continue
        if hasattr(FunctionSettings, one.name):
            raise EngineError(
                f"engine `{where}`: its parameter `{one.name}` can't be a setting, because the "
                "name is reserved. Rename it, or start it with an underscore"
            )
        if one.name == STEP_PARAMETER:
            fields[STEP_PARAMETER] = (float, Field(_checked_step(one.default, where), gt=0.0))
        else:
            fields[one.name] = (type(one.default), Field(one.default))
    made = create_model("Settings", __base__=FunctionSettings, **fields)
    made.where = where
    return made


def _checked_step(default: str | int | float | bool, where: str) -> float:
    if isinstance(default, str) or not 0.0 < default < math.inf:
        raise EngineError(
            f"engine `{where}`: its parameter `{STEP_PARAMETER}` is its time step, so its "
            f"default must be a number of seconds greater than 0, got {default!r}. Change it, or "
            "rename the parameter"
        )
    return float(default)


def _restore_settings(where: str, values: Mapping[str, Any]) -> EngineSettings:
    return engine_at(where).Settings(**values)
