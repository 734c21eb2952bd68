"""The documented result object of any engine, and its conversion to a `Result`.

A function returns the object as a dict, a worker or Node.js writes it as a line of JSON, and a run
made outside Ghostball is a file of such objects. Values are in SI units; balls are in the order of
the scene:

    rest_positions      final positions, [[x, y, z], ...]: centres [m]
    events              [{"t", "kind", "a", "b"}, ...] or [(t, kind, a, b), ...], in any order;
                        kinds "ball-ball", "ball-cushion", "slide-to-roll", "roll-to-rest",
                        "pocketed", "ball-cloth", "leaves-table"; a and b are indices of balls. For
                        a cushion or a pocket, b is its name ("left", "side-1", "post-1",
                        "top-left") or its index; otherwise null or missing
    samples             the motion, from t = 0 to the end: {"t": [...], "positions": [...],
                        "velocities": [...], "angular_velocities": [...]}, with three numbers for
                        each time and ball; or [(t, positions, velocities, angular_velocities),
                        ...]. The motion is interpolated between samples, so samples just before and
                        just after each collision are best. Balls that roll without slip need no
                        angular velocities
    status              "rest" (all balls are at rest), "t-max" (reached `t_max`), "step-limit"
                        (reached a limit of the engine earlier) or "failed"
    rest_time           time at which the last ball came to rest, or the run ended [s]
    scene               the name of a shipped scene, or the scene itself; never a path
    engine, settings, wall_time, version, reason, work, collision_counts, resolution, approximate
                        optional: name and settings of the engine; its run time [s]; its version;
                        why it stopped early; counters of its work, such as {"steps": 500}; numbers
                        of "ball-ball" and "ball-cushion" events, which must agree with the events;
                        the largest position error of a ball at a collision [m], 0 if only rounding
                        causes errors, missing if unknown; and the features that the engine supports
                        approximately, with a description, by their names in `ghostball engines`:
                        {"pure rolling": "in steps"}. All other features count as supported exactly

Positions and velocities may be in the plane, [x, y], for balls on the cloth. A function must return
`rest_positions`, `events` and `samples`, and may return `rest_time`, `status`, `reason`,
`wall_time` and `scene`. Runs in files may have all keys, and must also have `engine`, `scene`,
`status` and `rest_time`. `ghostball run --format json` prints the same keys, except the samples.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainValidator,
    ValidationError,
    model_validator,
)

from ghostball.model import (
    COLLISION_KINDS,
    EVENT_DTYPE,
    EventKind,
    Record,
    Result,
    SampledTrajectory,
    Samples,
    Scene,
    Status,
    Table,
    partner_name,
    rolling_angular_velocity,
)
from ghostball.model.arrays import FloatArray
from ghostball.model.features import Feature
from ghostball.reference_adapters.base import EngineError
from ghostball.reference_adapters.returned import partners_of, shown

Plain = str | float | int | bool | None

_KINDS = {kind.label: kind for kind in EventKind}
_STATUSES = {
    "rest": Status.REST,
    "t-max": Status.T_MAX,
    "step-limit": Status.STEP_LIMIT,
    "failed": Status.FAILED,
}
_STATES = ("positions", "velocities", "angular_velocities")

_FUNCTION_KEYS = (
    *("rest_positions", "events", "samples"),
    *("rest_time", "status", "reason", "wall_time", "scene"),
)
"""Keys that a function may return; the first three are required."""

_LARGEST_INDEX = np.iinfo(np.int32).max
"""Largest index of a ball in the event log."""


def _numbers(value: object) -> FloatArray:
    if value is None:  # NumPy would convert it to NaN
        raise ValueError("must be numbers")
    try:
        return np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"must be numbers: {error}") from None


def _listed(value: object) -> object:
    """Return an iterable, such as an array, as a list; any other value unchanged."""
    return list(value) if isinstance(value, Iterable) and not isinstance(value, str) else value


Numbers = Annotated[FloatArray, PlainValidator(_numbers)]


def _feature(name: object) -> Feature:
    """Return the feature with a name, such as "pure rolling"."""
    names = [feature.value for feature in Feature]
    if name in names:
        return Feature(name)
    close = get_close_matches(str(name), names, n=1, cutoff=0.8)
    hint = f", perhaps {close[0]!r}" if close else ""
    raise ValueError(
        "must have as keys the names of features that `ghostball engines ghostball` lists, such as "
        f"{names[0]!r}{hint}"
    )


FeatureName = Annotated[Feature, PlainValidator(_feature)]


class _AnswerPart(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore", arbitrary_types_allowed=True)


class RunEvent(_AnswerPart):
    """One event of a run."""

    t: Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
    kind: str
    a: Annotated[int, Field(ge=0, le=_LARGEST_INDEX)]
    b: Annotated[int, Field(ge=-1, le=_LARGEST_INDEX)] | str | None = None

    @model_validator(mode="before")
    @classmethod
    def _named(cls, event: object) -> object:
        """Return the event as a dict of plain values."""
        if isinstance(event, Sequence) and not isinstance(event, str) and len(event) in (3, 4):
            event = dict(zip(("t", "kind", "a", "b"), event, strict=False))
        if not isinstance(event, Mapping):
            raise ValueError('must be (t, kind, a, b), such as (0.25, "ball-ball", 0, 1)')
        plain = {key: one.item() if hasattr(one, "item") else one for key, one in event.items()}
        if isinstance(plain.get("kind"), EventKind):
            plain["kind"] = plain["kind"].label
        return plain


class RunSamples(_AnswerPart):
    """The motion of a run at given times: arrays (k,) and (k, n, 2 or 3)."""

    t: Numbers
    positions: Numbers
    velocities: Numbers
    angular_velocities: Numbers | None = None

    @model_validator(mode="before")
    @classmethod
    def _named(cls, samples: object) -> object:
        """Return the samples as a dict."""
        if isinstance(samples, Mapping):
            return {key: one for key, one in samples.items() if one is not None}
        rows = list(samples) if isinstance(samples, Sequence) else []
        lengths = {len(row) if isinstance(row, Sequence) else 0 for row in rows}
        if lengths not in ({3}, {4}):
            raise ValueError(
                "must be a list of (t, positions, velocities), optionally with angular velocities, "
                "and have at least one entry"
            )
        return dict(zip(("t", *_STATES), zip(*rows, strict=True), strict=False))


class EngineAnswer(_AnswerPart):
    """The result object of an engine; see the documentation of this module."""

    engine: Annotated[str, Field(min_length=1, pattern=r"^[^:,=]+$")]
    scene: str | dict[str, Any]
    status: Literal["rest", "t-max", "step-limit", "failed"]
    rest_time: float
    rest_positions: Numbers
    events: Annotated[list[RunEvent], BeforeValidator(_listed)]
    samples: RunSamples | None = None
    settings: dict[str, Plain] = Field(default_factory=dict)
    wall_time: float = 0.0
    version: str = ""
    reason: str = ""
    work: dict[str, int] = Field(default_factory=dict)
    collision_counts: dict[str, int] | None = None
    resolution: Annotated[float, Field(ge=0.0)] | None = None
    approximate: dict[FeatureName, str] = Field(default_factory=dict)

    @classmethod
    def parse(cls, value: object, where: str, none: str = "null") -> EngineAnswer:
        """Return the result object described by plain values; error messages call it `where`.

        `none`: the word for a missing value in messages: "null" for JSON, "None" for Python.

        Raises `EngineError` if the values are invalid.
        """
        try:
            return cls.model_validate(value)
        except ValidationError as error:
            raise _refused(where, error, none=none) from None

    @classmethod
    def returned(
        cls, answer: object, where: str, scene: Scene, **known: str | float | Mapping[str, Plain]
    ) -> EngineAnswer:
        """Return the result object that a function returned for a scene; messages call it `where`.

        `known`: known values of further keys; the answer takes precedence.

        Raises `EngineError` if the answer is invalid.
        """
        if not isinstance(answer, Mapping):
            raise EngineError(
                f'{where} must be a dict, {{"rest_positions": ..., "events": ..., "samples": '
                f"...}}, got {shown(answer)}"
            )
        if unknown := [str(key) for key in answer if key not in _FUNCTION_KEYS]:
            close = get_close_matches(unknown[0], _FUNCTION_KEYS, n=1)
            hint = f"Did you mean `{close[0]}`?" if close else f"Known: {', '.join(_FUNCTION_KEYS)}"
            raise _wrong(where, unknown[0], f"is not a key of a result. {hint}")
        if lacks := [key for key in _FUNCTION_KEYS[:3] if key not in answer]:
            raise _wrong(where, lacks[0], f"is missing, got {', '.join(answer) or '{}'}")
        said = answer.get("scene", scene.name)
        if (said.get("name") if isinstance(said, Mapping) else said) != scene.name:
            raise _wrong(where, "scene", f"must be the requested scene, got {shown(said)}")
        try:
            samples = RunSamples.model_validate(answer["samples"])
        except ValidationError as error:
            raise _refused(where, error, "samples", none="None") from None
        # By default, the run ends at the last sample, at rest or at the `t_max` of the scene.
        end = float(np.max(samples.t, initial=0.0))
        assumed = {"rest_time": end, "status": "rest", **known}
        run = cls.parse(
            {**assumed, **answer, "scene": scene.name, "samples": samples}, where, "None"
        )
        reached = scene.t_max is not None and run.rest_time >= scene.t_max * (1.0 - 1e-9)
        at_end = reached and "status" not in answer
        return run.model_copy(update={"status": "t-max"}) if at_end else run

    def result(
        self,
        scene: Scene,
        *,
        record: Record = "trajectory",
        where: str | None = None,
        none: str = "null",
    ) -> Result:
        """Return the result object as a `Result`.

        `where` is the name of the result object in messages, and `none` the word for a missing
        value: "null" for JSON, "None" for Python. This method checks only the values
        that it converts; `returned.check_result` checks the rest when an engine is run.

        Raises `EngineError` if a kind or a cushion is unknown, or if arrays have a wrong shape.
        """
        where = where or f'run of `{self.engine}` in scene "{scene.name}"'
        centres = _with_height(self.rest_positions, "rest_positions", (), scene, where)[np.newaxis]
        rows = [
            event_row(one, scene.table, f"{where}: `events[{k}]", none)
            for k, one in enumerate(self.events)
        ]
        events = np.array(rows, dtype=EVENT_DTYPE)
        counts = self.collision_counts
        if counts is None:
            of = Counter(event.kind for event in self.events)
            counts = {kind.label: of[kind.label] for kind in COLLISION_KINDS}
        still = np.zeros_like(centres)
        final, trajectory = Samples(centres, still, still), None
        if self.samples is not None:
            trajectory = _motion(self.samples, scene, where)
            # Values that aren't finite are detected when the run is checked, as for any engine.
            with np.errstate(invalid="ignore", over="ignore"):
                last = trajectory.sample(np.array([self.rest_time]))
            final = Samples(centres, last.velocities, last.angular_velocities)
        elif record == "trajectory":
            raise _wrong(where, "samples", "is missing: the checks of the motion need it")
        return Result(
            engine=self.engine,
            settings=self.settings,
            scene=scene,
            status=_STATUSES[self.status],
            final_state=final,
            rest_time=self.rest_time,
            collision_counts=counts,
            work={"events": len(events)} | self.work,
            wall_time=self.wall_time,
            events=None if record == "rest" else events[np.argsort(events["t"], kind="stable")],
            trajectory=trajectory if record == "trajectory" else None,
            reason=self.reason,
        )


def _motion(samples: RunSamples, scene: Scene, where: str) -> SampledTrajectory:
    t = samples.t
    if t.ndim != 1 or not len(t):
        raise _wrong(where, "samples.t", f"must be times (k,), got the shape {t.shape}")
    if len(back := np.flatnonzero(~(np.diff(t) >= 0.0))):
        k = int(back[0]) + 1
        raise _wrong(
            where,
            f"samples.t[{k}]",
            f"must not be earlier than the previous time, {float(t[k - 1])!r} s, got "
            f"{float(t[k])!r} s",
        )
    positions, velocities, spins = (
        None if one is None else _with_height(one, f"samples.{key}", (len(t),), scene, where)
        for key in _STATES
        for one in [getattr(samples, key)]
    )
    assert positions is not None
    assert velocities is not None
    if spins is None:
        if scene.physics.motion != "rolling":
            key = "samples.angular_velocities"
            raise _wrong(where, key, "is missing; it is required because balls slide in this scene")
        spins = rolling_angular_velocity(velocities, scene.radii)
    return SampledTrajectory(t, positions, velocities, spins)


def _with_height(
    array: FloatArray, key: str, before: tuple[int, ...], scene: Scene, where: str
) -> FloatArray:
    """Return an array (..., n, 3), adding the third component if it is missing."""
    n = len(scene.balls)
    if key != "samples.angular_velocities" and array.shape == (*before, n, 2):
        third = np.zeros((*before, n, 1))
        if not key.endswith("velocities"):
            third[..., 0] = scene.radii
        array = np.concatenate([array, third], axis=-1)
    if array.shape != (*before, n, 3):
        balls = "1 ball" if n == 1 else f"{n} balls"
        raise _wrong(
            where,
            key,
            f"must have the shape {(*before, n, 3)} for the {balls} of this scene, got "
            f"{array.shape}",
        )
    return array


def event_row(
    event: RunEvent, table: Table | None, where: str, none: str = "null"
) -> tuple[float, int, int, int]:
    """Return an event as a row of `EVENT_DTYPE`.

    `table`: table with the cushions, sides, posts and pockets that the event may name.
    `where`: location of the event in messages, up to the field of the event.
    `none`: the word for a missing value in messages: "null" for JSON, "None" for Python.

    Raises `EngineError` if the kind or the named obstacle is unknown.
    """
    kind = _KINDS.get(event.kind)
    if kind is None:
        raise EngineError(f"{where}.kind` must be one of {', '.join(_KINDS)}, got {event.kind!r}")
    b = -1 if event.b is None else event.b
    if isinstance(b, str):
        partners = partners_of(table).get(kind)
        named = {partner_name(kind, index): index for index in partners or ()}
        if b not in named:
            rule = (
                f"one of {', '.join(named)}"
                if named
                else "the name of an existing cushion or pocket"
            )
            if partners is None:
                rule = "the index of a ball" if kind is EventKind.BALL_BALL else none
            raise EngineError(
                f"{where}.b` must be {rule} for an event of kind {kind.label}, got {b!r}"
            )
        b = named[b]
    a = event.a
    if kind is EventKind.BALL_BALL and b < a:
        a, b = b, a
    return event.t, int(kind), a, b


def _refused(where: str, error: ValidationError, *inside: str, none: str = "null") -> EngineError:
    """Return an error for the first mistake that validation found: location, rule and value.

    `none`: the word for a missing value: "null" for JSON, "None" for Python.
    """
    first = error.errors()[0]
    places, value = (*inside, *first["loc"]), first["input"]
    if places[-1:] == ("[key]",):  # a wrong key of a mapping: the mapping is the location
        places = places[:-2]
    key = "".join(f"[{one}]" if isinstance(one, int) else f".{one}" for one in places)
    key = key.lstrip(".") or "the object"
    if first["type"] == "missing":
        return _wrong(where, key, f"is missing, got {', '.join(map(str, value)) or '{}'}")
    rule = str(first["msg"]).removeprefix("Value error, ").replace("Input should", "must", 1)
    return _wrong(where, key, f"{rule}, got {none if value is None else shown(value)}")


def _wrong(where: str, key: str, rule: str) -> EngineError:
    return EngineError(f"{where}: `{key}` {rule}")
