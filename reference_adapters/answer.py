"""What an engine that is a function returns of a scene, read: a `Result`, or one error.

`function` says what it may hold.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from ghostball.model import (
    COLLISION_KINDS,
    EVENT_DTYPE,
    EventKind,
    Result,
    SampledTrajectory,
    Samples,
    Scene,
    Status,
    rolling_angular_velocity,
)
from ghostball.model.arrays import FloatArray
from ghostball.reference_adapters.base import EngineError
from ghostball.reference_adapters.elsewhere import STATUSES, RunEvent, event_row

_NEEDED = ("rest_positions", "events", "samples")
_KNOWN = (*_NEEDED, "rest_time", "status", "reason", "wall_time", "scene")
_STATES = ("positions", "velocities", "angular_velocities")


class Answer:
    """What a function returned of a scene; whatever is wrong with it is one `EngineError`.

    `where`: `MODULE:FUNCTION`.
    """

    def __init__(self, where: str, scene: Scene, answer: object) -> None:
        self._what, self._scene = f'`{where}` returned for scene "{scene.name}"', scene
        if not isinstance(answer, Mapping):
            raise EngineError(
                f'what {self._what} must be a dict, {{"rest_positions": ..., "events": ..., '
                f'"samples": ...}}, got {_shown(answer)}'
            )
        self._answer = answer
        for key in answer:
            if key not in _KNOWN:
                close = get_close_matches(str(key), _KNOWN, n=1)
                hint = f"Did you mean `{close[0]}`?" if close else f"Known: {', '.join(_KNOWN)}"
                raise self._wrong(str(key), f"is no key of an answer. {hint}")
        for key in _NEEDED:
            if key not in answer:
                raise self._wrong(key, f"is missing, got {', '.join(map(str, answer)) or '{}'}")
        said = answer.get("scene", scene.name)
        if (said.get("name") if isinstance(said, Mapping) else said) != scene.name:
            raise self._wrong("scene", f"must be the one that was asked, got {_shown(said)}")

    def result(self, engine: str, settings: Mapping[str, Any], seconds: float) -> Result:
        """Return it whole as a result of an engine; the call took so many `seconds`."""
        centres = self._balls("rest_positions", self._answer["rest_positions"], ())[np.newaxis]
        motion = self._motion()
        rest_time = self._number("rest_time", float(motion.times[-1]))
        status, events = self._status(rest_time), self._events()
        if status is not Status.FAILED:
            self._check_finite(motion)
        with np.errstate(invalid="ignore", over="ignore"):  # judged where any run is
            last = motion.sample(np.array([rest_time]))
        counts = {kind.label: int(np.sum(events["kind"] == kind)) for kind in COLLISION_KINDS}
        return Result(
            engine=engine,
            settings=settings,
            scene=self._scene,
            status=status,
            final_state=Samples(centres, last.velocities, last.angular_velocities),
            rest_time=rest_time,
            collision_counts=counts,
            work={},
            wall_time=self._number("wall_time", seconds),
            events=events,
            trajectory=motion,
            reason=str(self._answer.get("reason", "")),
        )

    def _status(self, rest_time: float) -> Status:
        end = self._scene.t_max
        reached = end is not None and rest_time >= end * (1.0 - 1e-9)
        said = self._answer.get("status", "t-max" if reached else "rest")
        if said not in STATUSES:
            raise self._wrong("status", f"must be one of {', '.join(STATUSES)}, got {said!r}")
        return STATUSES[said]

    def _events(self) -> NDArray[np.void]:
        rows = [self._event(k, one) for k, one in enumerate(self._listed("events"))]
        events = np.array(rows, dtype=EVENT_DTYPE)
        return events[np.argsort(events["t"], kind="stable")]

    def _event(self, number: int, event: object) -> tuple[float, int, int, int]:
        where = f"events[{number}]"
        if isinstance(event, Mapping):
            values = dict(event)
        elif isinstance(event, Sequence) and not isinstance(event, str) and len(event) in (3, 4):
            values = dict(zip(("t", "kind", "a", "b"), event, strict=False))
        else:
            raise self._wrong(
                where, f'must be (t, kind, a, b), such as (0.25, "ball-ball", 0, 1), got {event!r}'
            )
        if isinstance(values.get("kind"), EventKind):
            values["kind"] = values["kind"].label
        try:
            plain = {
                key: one.item() if hasattr(one, "item") else one for key, one in values.items()
            }
            told = RunEvent.model_validate(plain)
            return event_row(told, self._scene.table, f"answer that {self._what}")
        except ValidationError as error:
            first = error.errors()[0]
            field = ".".join(map(str, first["loc"][:1]))
            raise self._wrong(
                f"{where}.{field}", f"is refused: {first['msg']}, got {first['input']!r:.80}"
            ) from None

    def _motion(self) -> SampledTrajectory:
        samples = self._answer["samples"]
        if isinstance(samples, Mapping):
            given = {key: one for key, one in samples.items() if one is not None}
        else:
            rows = self._listed("samples")
            lengths = {len(row) if isinstance(row, Sequence) else 0 for row in rows}
            if lengths not in ({3}, {4}):
                raise self._wrong(
                    "samples",
                    "must be (t, positions, velocities) each, or with angular velocities too, and "
                    f"at least one, got {_shown(rows[0]) if rows else 'none'}",
                )
            given = dict(zip(("t", *_STATES), zip(*rows, strict=True), strict=False))
        for key in ("t", *_STATES[:2]):
            if key not in given:
                raise self._wrong(f"samples.{key}", "is missing")
        t = self._array("samples.t", given["t"])
        if t.ndim != 1 or not len(t):
            raise self._wrong("samples.t", f"must be instants (k,), got the shape {t.shape}")
        if len(back := np.flatnonzero(~(np.diff(t) >= 0.0))):
            k = int(back[0]) + 1
            raise self._wrong(
                f"samples.t[{k}]",
                f"must be no earlier than the instant before, {float(t[k - 1])!r} s, got "
                f"{float(t[k])!r} s",
            )
        states = {
            key: self._balls(f"samples.{key}", given[key], (len(t),))
            for key in _STATES
            if key in given
        }
        if _STATES[2] not in states:
            if self._scene.physics.motion != "rolling":
                raise self._wrong(
                    "samples.angular_velocities", "is missing, and in this scene balls slide"
                )
            rolls = rolling_angular_velocity(states["velocities"], self._scene.radii)
            states[_STATES[2]] = rolls
        return SampledTrajectory(t, *(states[key] for key in _STATES))

    def _check_finite(self, motion: SampledTrajectory) -> None:
        """Raise where a number of the motion isn't finite: it ends in a place, and came there."""
        for key in _STATES:
            states: FloatArray = getattr(motion, key)
            wrong = np.argwhere(~np.isfinite(states).all(axis=2))
            if len(wrong):
                k, ball = wrong[0].tolist()
                raise self._wrong(
                    f"samples.{key}",
                    f"must be finite, got {states[k, ball].tolist()} at {float(motion.times[k])!r} "
                    f's for ball "{self._scene.balls[ball].id}"',
                )

    def _balls(self, key: str, value: object, before: tuple[int, ...]) -> FloatArray:
        """Return an array (..., n, 3) of what is given so, or without the third number."""
        array, n = self._array(key, value), len(self._scene.balls)
        if key != "samples.angular_velocities" and array.shape == (*before, n, 2):
            third = np.zeros((*before, n, 1))
            if not key.endswith("velocities"):
                third[..., 0] = self._scene.radii
            array = np.concatenate([array, third], axis=-1)
        if array.shape != (*before, n, 3):
            balls = "1 ball" if n == 1 else f"{n} balls"
            raise self._wrong(
                key,
                f"must have the shape {(*before, n, 3)}, of the {balls} of this scene, got "
                f"{array.shape}",
            )
        return array

    def _array(self, key: str, value: object) -> FloatArray:
        try:
            return np.array(value, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise self._wrong(key, f"must be numbers: {error}") from None

    def _listed(self, key: str) -> list[Any]:
        value = self._answer[key]
        if isinstance(value, str | Mapping) or not hasattr(value, "__iter__"):
            raise self._wrong(key, f"must be a list, got {_shown(value)}")
        return list(value)

    def _number(self, key: str, default: float) -> float:
        value = self._answer.get(key, default)
        try:
            return float(value)
        except (TypeError, ValueError):
            raise self._wrong(key, f"must be a number, got {_shown(value)}") from None

    def _wrong(self, key: str, rule: str) -> EngineError:
        return EngineError(f"in what {self._what}, `{key}` {rule}")


def _shown(value: object) -> str:
    return f"{value!r:.80} ({type(value).__name__})"
