"""Runs made elsewhere, by an engine in any language: one documented JSON object, and a `Result`.

A run is an object with these keys, in SI units; balls are in the order of the scene's:

    engine              the engine's name
    scene               the name of a shipped scene, or the scene itself; never a path
    status              "rest" (all balls rest), "t-max" (`t_max` was reached), "step-limit" (a
                        limit of the engine was reached before) or "failed"
    rest_time           when the last ball came to rest, or the run ended [s]
    rest_positions      [[x, y, z], ...], centres then [m]
    events              [{"t", "kind", "a", "b"}, ...] in order of time; kinds "ball-ball",
                        "ball-cushion", "slide-to-roll", "roll-to-rest", "pocketed", "ball-cloth",
                        "leaves-table"; a and b are indices of balls, b is the name of a cushion
                        ("left", "side-1", "post-1") or a pocket ("top-left"), or null where it
                        is none
    samples             {"t": [...], "positions": [...], "velocities": [...],
                        "angular_velocities": [...]}: of each instant, of each ball, three numbers.
                        From t = 0 to `rest_time`; just before and just after each collision is
                        best, since between two samples the motion is interpolated
    settings, wall_time, version, reason, work, collision_counts, resolution, approximate
                        as wanted: how the engine was set; its run time [s]; its version; why it
                        stopped early; counters of its work, such as {"steps": 500}; how many events
                        are "ball-ball" and "ball-cushion", which the events must agree with; how
                        far off a ball may be when it collides [m], 0 by rounding alone, left out
                        where nothing is known of that; and what of the scene it represents only
                        approximately, and how: {"balls that roll and never slide": "in steps"},
                        by the names of `ghostball engines`. The rest it claims to be exact

`ghostball run --format json` prints the same keys, but the samples.
"""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

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
)
from ghostball.model.errors import storable
from ghostball.model.features import EXACT, Capabilities, Capability, Feature
from ghostball.model.text_files import read_text
from ghostball.reference_adapters.base import (
    EngineBase,
    EngineError,
    EngineSettings,
    ReferenceEngine,
)
from ghostball.reference_adapters.returned import partners_of

Triple = tuple[float, float, float]
Plain = str | float | int | bool | None

_KINDS = {kind.label: kind for kind in EventKind}
STATUSES = {
    "rest": Status.REST,
    "t-max": Status.T_MAX,
    "step-limit": Status.STEP_LIMIT,
    "failed": Status.FAILED,
}


_LARGEST = np.iinfo(np.int32).max
"""Of a ball's number, as events keep it."""


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="ignore")


class RunEvent(_Part):
    """One event of a run."""

    t: Annotated[float, Field(ge=0.0)]
    kind: str
    a: Annotated[int, Field(ge=0, le=_LARGEST)]
    b: Annotated[int, Field(ge=-1, le=_LARGEST)] | str | None = None


class RunSamples(_Part):
    """The motion of a run at instants: arrays (k,), (k, n, 3)."""

    t: list[float]
    positions: list[list[Triple]]
    velocities: list[list[Triple]]
    angular_velocities: list[list[Triple]]


class Run(_Part):
    """One run that was made elsewhere; see the module."""

    engine: Annotated[str, Field(min_length=1, pattern=r"^[^:,=]+$")]
    scene: str | dict[str, Any]
    status: Literal["rest", "t-max", "step-limit", "failed"]
    rest_time: float
    rest_positions: list[Triple]
    events: list[RunEvent]
    samples: RunSamples | None = None
    settings: dict[str, Plain] = Field(default_factory=dict)
    wall_time: float = 0.0
    version: str = ""
    reason: str = ""
    work: dict[str, int] = Field(default_factory=dict)
    collision_counts: dict[str, int] | None = None
    resolution: Annotated[float, Field(ge=0.0)] | None = None
    approximate: dict[Feature, str] = Field(default_factory=dict)

    @classmethod
    def load(cls, path: Path) -> tuple[Run, ...]:
        """Read a file: one run, a list of runs, or one run a line.

        Raises `EngineError` where it can't be read, or isn't such an object; the message says what
        is wrong where.
        """
        try:
            text = read_text(path)
        except (OSError, UnicodeDecodeError) as error:
            raise EngineError(f"{path} can't be read: {error}") from None
        try:
            values = _json_of(text, path)
        except ValueError:  # also of what is nested too deeply
            try:
                lines = [line for line in text.splitlines() if line.strip()]
                values = [_json_of(line, path) for line in lines]
            except ValueError as error:
                raise EngineError(
                    f"{path} isn't JSON that can be read: {error}. Write one run, a list of runs, "
                    "or one run a line"
                ) from None
        listed = values if isinstance(values, list) else [values]
        if not listed:
            raise EngineError(f"{path} must hold at least one run, got none")
        return tuple(cls.parse(value, f"{path}, run {k}") for k, value in enumerate(listed, 1))

    @classmethod
    def parse(cls, value: object, where: str) -> Run:
        """Return the run that plain values describe.

        Raises `EngineError`.
        """
        try:
            return cls.model_validate(value)
        except ValidationError as error:
            first = error.errors()[0]
            key = ".".join(map(str, first["loc"])) or "the object"
            raise EngineError(
                f"`{key}` of {where} is refused: {first['msg']}, got {str(first['input'])[:80]!r}"
            ) from None

    def result(self, scene: Scene, *, record: Record = "trajectory") -> Result:
        """Return it as a `Result`, of which everything else is checked where engines are run.

        Raises `EngineError` where a kind or a cushion is none, or arrays have another shape than
        the scene's.
        """
        n, name = len(scene.balls), f'run of `{self.engine}` in scene "{scene.name}"'
        if len(self.rest_positions) != n:
            raise EngineError(
                f"`rest_positions` of the {name} must have {n} balls, got "
                f"{len(self.rest_positions)}"
            )
        events = np.array(
            [event_row(event, scene.table, name) for event in self.events], dtype=EVENT_DTYPE
        )
        counts = self.collision_counts
        if counts is None:
            of = Counter(event.kind for event in self.events)
            counts = {kind.label: of[kind.label] for kind in COLLISION_KINDS}
        centres = np.array(self.rest_positions)[np.newaxis]
        still = np.zeros_like(centres)
        final, trajectory = Samples(centres, still, still), None
        if self.samples is not None:
            trajectory = self._motion(self.samples, n, name)
            # What isn't finite is found where runs are checked and measured, as any engine's.
            with np.errstate(invalid="ignore", over="ignore"):
                last = trajectory.sample(np.array([self.rest_time]))
            final = Samples(centres, last.velocities, last.angular_velocities)
        elif record == "trajectory":
            raise EngineError(f"the {name} has no `samples`, from which its motion is graded")
        return Result(
            engine=self.engine,
            settings=self.settings,
            scene=scene,
            status=STATUSES[self.status],
            final_state=final,
            rest_time=self.rest_time,
            collision_counts=counts,
            work={"events": len(events)} | self.work,
            wall_time=self.wall_time,
            events=None if record == "rest" else events,
            trajectory=trajectory if record == "trajectory" else None,
            reason=self.reason,
        )

    @staticmethod
    def _motion(samples: RunSamples, n: int, name: str) -> SampledTrajectory:
        t, parts = np.array(samples.t), []
        for key in ("positions", "velocities", "angular_velocities"):
            rows: list[list[Triple]] = getattr(samples, key)
            if len(rows) != len(t) or any(len(row) != n for row in rows):
                raise EngineError(
                    f"`samples.{key}` of the {name} must have the shape {(len(t), n, 3)}: for "
                    f"each instant, of each ball, 3 numbers"
                )
            parts.append(np.array(rows, dtype=np.float64))
        if len(t) == 0 or np.any(np.diff(t) < 0.0):
            raise EngineError(f"`samples.t` of the {name} must be instants in order of time")
        return SampledTrajectory(t, *parts)


def _json_of(text: str, path: Path) -> Any:
    """Return what a text in JSON says.

    Raises `ValueError` if it isn't JSON, or nested too deeply; `EngineError` if an object has a
    key twice: readers of JSON don't agree on which of the two values holds.
    """

    def once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        seen: set[str] = set()
        for key, _ in pairs:
            if key in seen:
                said = f"{path}: `{key:.80}` must be given once in an object, got it twice"
                raise EngineError(storable(f"{said}. Remove one"))
            seen.add(key)
        return dict(pairs)

    try:
        values = json.loads(text, object_pairs_hook=once)
        if "\\u" in text:  # it may spell half of a surrogate pair, which no file can hold
            json.dumps(values, ensure_ascii=False).encode()
    except RecursionError:
        raise ValueError("it is nested too deeply") from None
    return values


def event_row(event: RunEvent, table: Table | None, name: str) -> tuple[float, int, int, int]:
    """Return an event as a row of `EVENT_DTYPE`.

    `table`: whose cushions, sides, posts and pockets it may name.
    `name`: what the run is called in messages.

    Raises `EngineError` where its kind, or what it names, is none.
    """
    kind = _KINDS.get(event.kind)
    if kind is None:
        raise EngineError(
            f"`kind` of an event of the {name} must be one of {', '.join(_KINDS)}, got "
            f"{event.kind!r}"
        )
    b = -1 if event.b is None else event.b
    if isinstance(b, str):
        partners = partners_of(table).get(kind)
        named = {partner_name(kind, index): index for index in partners or ()}
        if b not in named:
            rule = (
                f"one of {', '.join(named)}" if named else "the name of what this scene has none of"
            )
            if partners is None:
                rule = "the index of a ball" if kind is EventKind.BALL_BALL else "null"
            raise EngineError(
                f"`b` of an event of the {name} must be {rule} where its kind is {kind.label}, "
                f"got {b!r}"
            )
        b = named[b]
    a = event.a
    if kind is EventKind.BALL_BALL and b < a:
        a, b = b, a
    return event.t, int(kind), a, b


def recorded_engine(run: Run) -> ReferenceEngine:
    """Return an engine whose run was made elsewhere: it hands that out, and has no other."""

    class Recorded(_RecordedEngine):
        name: ClassVar[str] = run.engine

    return Recorded(run)


class _RecordedEngine(EngineBase):
    Settings: ClassVar[type[EngineSettings]] = EngineSettings

    def __init__(self, run: Run) -> None:
        super().__init__()
        self._run = run

    @property
    def capabilities(self) -> Capabilities:
        """What was run is represented, and exactly where the run doesn't say how it isn't."""
        said = {one: Capability("approximate", how) for one, how in self._run.approximate.items()}
        return dict.fromkeys(Feature, EXACT) | said

    def resolution(self, scene: Scene) -> float | None:  # noqa: ARG002
        """Return what the run says of it [m]; None where it says nothing."""
        return self._run.resolution

    def simulate(self, scene: Scene, *, record: Record = "rest") -> Result:
        """Return the run."""
        return self._run.result(scene, record=record)
