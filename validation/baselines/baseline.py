"""An accepted baseline: one readable TOML file per scene, checked whole when it is read.

    schema = 2
    engine = "ghostball"             # with its settings: of another engine nothing is compared
    scene = "break-16"
    scene_hash = "..."               # of the scene's definition: another scene can't be compared

    [accepted]                       # when, of which revision, where, and why
    [hash]                           # of all bits, and of the order of events alone
    [end]                            # how the run ended, when, and where the balls lie
    [metrics.quality_factor]         # value, low, high, unit, level = "off" | "warn" | "error", why
    [work.events]                    # likewise
    [events]                         # the first ones, one a line; of all, hashes of each block

A band and a level may be edited by hand: the next `ghostball accept` keeps what was edited as long
as its value stays in the band.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Final, Literal, Self

import numpy as np
import tomli_w
from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from ghostball.engine import CUSHIONS, EventKind, GhostballError
from ghostball.engine.result import EVENT_DTYPE, OBSTACLE_KINDS, Events, event_dict
from ghostball.engine.result.hashes import bits_hash, sequence_hash
from ghostball.reference_adapters.registry import engine_name, parse_spec, spec_of
from ghostball.validation.baselines.bands import Band, band_of_counter, band_of_metric
from ghostball.validation.baselines.fingerprint import BLOCK, Block, blocks_of
from ghostball.validation.baselines.observed import KEPT_EVENTS, Observed
from ghostball.validation.baselines.regression import Level
from ghostball.validation.checks.metric_table import METRICS
from ghostball.validation.results.files import told, toml_of
from ghostball.validation.truth.scene_truth import OUR_NAME

SCHEMA: Final = 2
"""Version of the files; another one can't be compared with."""

ENDING = ".toml"


class BaselineError(GhostballError, ValueError):
    """A baseline that can't be read, or is nonsense: edited by hand, or cut short."""


class BaselineSchemaError(BaselineError):
    """A baseline of another version of ghostball: nothing can be compared with it."""


class _Model(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", populate_by_name=True)


Number = (
    Annotated[int, Field(strict=True)] | Annotated[float, Field(strict=True, allow_inf_nan=False)]
)
Hash = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
Coordinate = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Name = Annotated[str, Field(pattern=r"\S")]


class Accepted(_Model):
    """When a baseline was accepted, by which code, where and why."""

    date: str
    revision: str
    platform: str
    reason: Name


class Value(_Model):
    """A number and its band."""

    value: Number
    low: Number | None = None
    high: Number | None = None
    unit: str
    level: Level
    why: Name

    @model_validator(mode="after")
    def _in_its_band(self) -> Self:
        if not self.band.holds(self.value):
            raise PydanticCustomError(
                "band",
                "`value` must lie between `low` and `high`, got {value} for {low} to {high}",
                {"value": self.value, "low": self.low, "high": self.high},
            )
        return self

    @property
    def band(self) -> Band:
        """What is accepted."""
        return Band(self.low, self.high, self.level, self.why)


class Hashes(_Model):
    """Hashes of a run; see `fingerprint`.

    `level` "error": any bit that moves fails, as our engine promises the same ones on every
    machine. "warn": rounding is told and passes, and results that changed fail. "off": neither.
    """

    bits: Hash
    sequence: Hash
    level: Level = "error"


class End(_Model):
    """How a run ended."""

    status: Name
    rest_time: Coordinate
    balls: tuple[str, ...]
    rest_positions: tuple[tuple[Coordinate, Coordinate, Coordinate], ...]


class Log(_Model):
    """The events: how many, the first of them, and all of them as a `Block` each `BLOCK` events."""

    count: int = Field(ge=0)
    first: tuple[str, ...]
    blocks: tuple[tuple[str, str, Coordinate], ...]


class Baseline(_Model):
    """What was accepted of one scene; see the module."""

    schema_version: Literal[2] = Field(default=SCHEMA, alias="schema")
    engine: Name
    scene: Name
    title: str
    scene_hash: Hash
    truth: str | None = None
    accepted: Accepted
    hash: Hashes
    end: End
    metrics: dict[str, Value]
    work: dict[str, Value]
    events: Log

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        unknown = [name for name in self.metrics if name not in METRICS]
        if unknown:
            raise PydanticCustomError(
                "metric", "`metrics` holds `{name}`, which is no metric", {"name": unknown[0]}
            )
        broken = [name for name, one in self.work.items() if isinstance(one.value, float)]
        if broken:
            raise PydanticCustomError(
                "count",
                "`work.{name}.value` must be an integer, got {value}",
                {"name": broken[0], "value": self.work[broken[0]].value},
            )
        if len(self.end.balls) != len(self.end.rest_positions):
            raise PydanticCustomError(
                "balls",
                "`end` must hold a rest position for each ball, got {places} for {balls} balls",
                {"places": len(self.end.rest_positions), "balls": len(self.end.balls)},
            )
        log, kept = self.events, min(self.events.count, KEPT_EVENTS)
        if len(log.first) != kept or len(log.blocks) != math.ceil(log.count / BLOCK):
            raise PydanticCustomError(
                "events",
                "`events` must hold the first {kept} of {count} events and {blocks} blocks, got "
                "{got} and {got_blocks}",
                {
                    "kept": kept,
                    "count": log.count,
                    "blocks": math.ceil(log.count / BLOCK),
                    "got": len(log.first),
                    "got_blocks": len(log.blocks),
                },
            )
        events = _events(log.first)
        whole = len(events) // BLOCK if log.count > kept else len(log.blocks)
        if [tuple(block) for block in blocks_of(events)[:whole]] != list(log.blocks[:whole]):
            raise PydanticCustomError(
                "events", "`events.first` doesn't have the hashes of `blocks`"
            )
        if log.count == kept and (sequence_hash(events), self._bits(events)) != (
            self.hash.sequence,
            self.hash.bits,
        ):
            raise PydanticCustomError(
                "hash", "`hash` isn't that of the events and rest positions in the file"
            )
        return self

    def _bits(self, events: Events) -> str:
        return bits_hash(events, np.array(self.end.rest_positions).reshape(-1, 3))

    @classmethod
    def of(
        cls,
        observed: Observed,
        accepted: Accepted,
        earlier: Baseline | None = None,
        engine: str = OUR_NAME,
    ) -> Baseline:
        """Return the baseline that accepts what was observed.

        Parameters
        ----------
        observed : Observed
        accepted : Accepted
        earlier : Baseline, optional
            The one that it replaces: its bands and levels stay where they still hold.
        engine : str
            Which engine it is of: see `engine_key`.
        """
        promised: Level = "error" if engine == OUR_NAME else "warn"
        before = earlier or _NOTHING
        metrics = {
            name: _value(
                before.metrics.get(name),
                value,
                band_of_metric(name, observed.metrics),
                METRICS[name].unit,
            )
            for name, value in observed.metrics.items()
        }
        work = {
            name: _value(before.work.get(name), count, band_of_counter(count), "1")
            for name, count in observed.work.items()
        }
        places = [(float(x), float(y), float(z)) for x, y, z in observed.rest_positions]
        return cls(
            engine=engine,
            scene=observed.scene,
            title=observed.title,
            scene_hash=observed.scene_hash,
            truth=observed.truth,
            accepted=accepted,
            hash=Hashes(
                bits=observed.bits,
                sequence=observed.sequence,
                level=promised if earlier is None else earlier.hash.level,
            ),
            end=End(
                status=observed.status,
                rest_time=observed.rest_time,
                balls=observed.ids,
                rest_positions=tuple(places),
            ),
            metrics=metrics,
            work=work,
            events=Log(
                count=observed.event_count,
                first=tuple(_line(event) for event in observed.events[:KEPT_EVENTS]),
                blocks=tuple(tuple(block) for block in observed.blocks),
            ),
        )

    @property
    def observed(self) -> Observed:
        """What was accepted, to be compared with."""
        return Observed(
            self.scene,
            self.title,
            self.scene_hash,
            self.truth,
            self.end.status,
            self.end.rest_time,
            np.array(self.end.rest_positions).reshape(-1, 3),
            _events(self.events.first),
            self.events.count,
            tuple(Block(*block) for block in self.events.blocks),
            self.hash.bits,
            self.hash.sequence,
            {name: value.value for name, value in self.metrics.items()},
            {name: int(value.value) for name, value in self.work.items()},
            self.end.balls,
        )

    def text(self) -> str:
        """Return the file's content; floats read back to the same bits."""
        plain = self.model_dump(by_alias=True, exclude_none=True)
        return tomli_w.dumps(_plain(plain))


def load_baseline(path: Path, engine: str = OUR_NAME) -> Baseline:
    """Read a baseline of an engine; see `engine_key`.

    Raises
    ------
    BaselineSchemaError
        Where another version of ghostball wrote it.
    BaselineError
        Where it can't be read, is nonsense, or of another engine.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise BaselineError(f"{path}: can't read the baseline: {error}") from None
    return baseline_of(text, path, engine)


def baseline_of(text: str, path: Path, engine: str = OUR_NAME) -> Baseline:
    """Read the text of a baseline; `path` is its file, or the one that it would be written to.

    Raises
    ------
    BaselineError
        As of `load_baseline`.
    """
    try:
        data = toml_of(text)
    except ValueError as error:
        raise BaselineError(f"{path}: not valid TOML: {error}. {_RESTORE}") from None
    if "schema" not in data:
        raise BaselineError(f"{path}: holds no `schema`: cut short, or no baseline. {_RESTORE}")
    if data["schema"] != SCHEMA:
        raise BaselineSchemaError(
            f"{path}: `schema` must be {SCHEMA}, got {data['schema']!r}: another version of "
            "ghostball wrote it. Use that version, or accept anew"
        )
    try:
        baseline = Baseline.model_validate(data)
    except ValidationError as error:
        raise BaselineError(f"{path}: {told(error)}. {_RESTORE}") from None
    if baseline.scene != path.name.removesuffix(ENDING):
        raise BaselineError(
            f'{path}: `scene` must be the name of its file, got "{baseline.scene}". {_RESTORE}'
        )
    if baseline.engine != engine:
        raise BaselineError(
            f"{path}: is of engine `{baseline.engine}`, and can't be compared with `{engine}`. "
            "Give each engine a folder of its own, or remove it and accept anew"
        )
    return baseline


def engine_key(label: str) -> str:
    """Return what baselines call an engine: its own name, with the settings that it was given.

    So `my_package:MyEngine:dt=1e-3` stays `my-engine:dt=1e-3` wherever its class may move.
    """
    return spec_of(engine_name(label), parse_spec(label)[1])


def engine_folder(baselines: Path, engine: str) -> Path:
    """Return where the baselines of one engine lie, in the folder of those of all.

    Raises
    ------
    BaselineError
        Where that is no folder.
    """
    folder = baselines / re.sub(r"[^\w.,=+-]+", "_", engine)
    for place in (baselines, folder):
        if place.exists() and not place.is_dir():
            raise BaselineError(f"{place}: not a folder. Choose another `--baselines`")
    return folder


def baseline_path(folder: Path, scene: str) -> Path:
    """Return the file of a scene's baseline."""
    return folder / f"{scene}{ENDING}"


def baseline_names(folder: Path) -> tuple[str, ...]:
    """Return the scenes that have a baseline in a folder, in order; none where it isn't there."""
    return tuple(sorted(path.name.removesuffix(ENDING) for path in folder.glob(f"*{ENDING}")))


_RESTORE = "Restore it (git checkout), or remove it and accept anew"


class _Nothing:
    """Stands for a baseline that isn't there."""

    metrics: Mapping[str, Value] = {}
    work: Mapping[str, Value] = {}


_NOTHING = _Nothing()


def _value(earlier: Value | None, value: int | float, band: Band, unit: str) -> Value:
    """Return a number with its band: the earlier one where that holds it.

    So a number that drifts a little with each change leaves its band one day.
    """
    if earlier is not None and earlier.band.holds(value):
        return earlier.model_copy(update={"value": value})
    if earlier is not None and earlier.level != band.level:
        band = band._replace(level=earlier.level)
    return Value(value=value, unit=unit, **band._asdict())


def _line(event: Any) -> str:
    """Return an event as a person reads it: instant, kind, ball, other ball or cushion."""
    plain = event_dict(event)
    other = "" if plain["b"] is None else f" {plain['b']}"
    return f"{plain['t']!r} {plain['kind']} {plain['a']}{other}"


_KINDS = {kind.label: kind for kind in EventKind}


def _events(lines: tuple[str, ...]) -> Events:
    """Read events back."""
    events = np.empty(len(lines), dtype=EVENT_DTYPE)
    for i, line in enumerate(lines):
        try:
            t, label, a, *rest = line.split()
            kind = _KINDS[label]
            if len(rest) != (kind is EventKind.BALL_BALL or kind in OBSTACLE_KINDS):
                raise ValueError
            b = -1
            if kind is EventKind.BALL_BALL:
                b = int(rest[0])
            elif kind in OBSTACLE_KINDS:
                b = CUSHIONS.index(rest[0])
            events[i] = (float(t), int(kind), int(a), b)
        except (ValueError, KeyError, OverflowError):
            raise PydanticCustomError(
                "event",
                "`events.first[{i}]` must be an event such as '0.5 ball-ball 0 1', got {line}",
                {"i": i, "line": repr(line)},
            ) from None
    return events


def _plain(value: Any) -> Any:
    """Return a value with lists for tuples, which TOML has no word for."""
    return json.loads(json.dumps(value))
