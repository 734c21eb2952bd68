"""An accepted baseline: the record of a run as JSON with its hash, one file per scene.

Each engine has a folder of its own.

| field | what it holds |
|---|---|
| `schema` | version of the file |
| `engine` | which engine, with its settings: nothing is compared with another one |
| `accepted` | when it was accepted, by which code, where, and why |
| `hash` | of the record and its events: a file that was edited is refused |
| `record` | the run, as `results.records.CaseRecord` |
| `events` | how many there are, the hash of their order, and the first of them |
"""

from __future__ import annotations

import json
import math
import re
from dataclasses import MISSING, fields, replace
from pathlib import Path
from typing import Annotated, Any, Final, Literal, Self

import numpy as np
from pydantic import Field, PlainSerializer, PlainValidator, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from ghostball.model import EVENT_DTYPE, EventKind, Events, GhostballError
from ghostball.model.hashes import bits_hash
from ghostball.model.text_files import read_text
from ghostball.reference_adapters.registry import OURS, engine_name, parse_spec, spec_of
from ghostball.validation.baselines.played import Log, Played
from ghostball.validation.baselines.regression import Model
from ghostball.validation.results.files import describe_validation_error
from ghostball.validation.results.records import CaseRecord
from ghostball.validation.suite.unchanged import hash_of

SCHEMA: Final = 4
"""Version of the files; another one can't be compared with."""

KEPT_EVENTS = 64
"""Events that a baseline holds one by one: what a person reads, and all of most shipped shots.

Of later ones the hashes say that they differ, and `ghostball diff` of two runs says where.
"""

ENDING = ".json"
_RESTORE = "Restore it (git checkout), or remove it and accept anew"
_LINES = 3
"""Levels of a file whose entries have a line each, so that git shows which of them changed."""


class BaselineError(GhostballError, ValueError):
    """A baseline that can't be read, or is nonsense: edited by hand, or cut short."""


class BaselineSchemaError(BaselineError):
    """A baseline of another version of ghostball: nothing can be compared with it."""


_KINDS = {kind.label: kind for kind in EventKind}


def _kind_of(label: Any) -> EventKind:
    if not isinstance(label, str) or label not in _KINDS:
        raise ValueError(f"must be a kind of event: {', '.join(_KINDS)}")
    return _KINDS[label]


Name = Annotated[str, Field(pattern=r"\S")]
Kind = Annotated[
    EventKind, PlainValidator(_kind_of), PlainSerializer(lambda kind: EventKind(kind).label)
]
Ball = Annotated[int, Field(ge=-1, lt=2**31)]
Row = tuple[Annotated[float, Field(allow_inf_nan=False)], Kind, Ball, Ball]
"""An event, as in `EVENT_DTYPE`: time [s], kind, first ball, second ball or obstacle or -1."""


class Accepted(Model):
    """When a baseline was accepted, by which code, where and why."""

    date: str
    revision: str
    platform: str
    reason: Name


class FirstEvents(Model):
    """The events of a shot: how many, the hash of their order, and the first of them."""

    count: int = Field(ge=0)
    sequence: str
    first: tuple[Row, ...] = Field(max_length=KEPT_EVENTS)

    @classmethod
    def of(cls, log: Log) -> FirstEvents:
        """Return what is kept of a log."""
        rows = log.events[:KEPT_EVENTS].tolist()
        first = tuple((t, EventKind(kind).label, a, b) for t, kind, a, b in rows)
        return cls.model_validate({"count": log.count, "sequence": log.sequence, "first": first})

    @property
    def log(self) -> Log:
        """The events, to be compared with."""
        events: Events = np.array([*self.first], dtype=EVENT_DTYPE)
        return Log(events, self.count, self.sequence)


class Baseline(Model):
    """What was accepted of one scene; see the module."""

    schema_version: Literal[4] = Field(default=SCHEMA, alias="schema")
    engine: Name
    accepted: Accepted
    hash: str
    record: CaseRecord
    events: FirstEvents

    @model_validator(mode="after")
    def _events_are_of_the_record(self) -> Self:
        """Check what a right hash can't say: a program that is wrong writes a right hash too."""
        record, log, balls = self.record, self.events.log, len(self.record.definition["balls"])
        met = log.events["kind"] == EventKind.BALL_BALL
        named = [*log.events["a"].tolist(), *log.events["b"][met].tolist()]
        if wrong := [ball for ball in named if not 0 <= ball < balls]:
            raise PydanticCustomError(
                "balls",
                "`events.first` names ball {ball}, but the scene has {balls}",
                {"ball": wrong[0], "balls": f"{balls} (0 to {balls - 1})"},
            )
        rests = record.rest_positions
        if (
            rests is not None
            and math.isinf(log.until)
            and bits_hash(log.events, rests) != record.bits
        ):
            raise PydanticCustomError(
                "bits", "`record.bits` isn't the hash of its events and rest positions"
            )
        return self

    @classmethod
    def of(cls, played: Played, accepted: Accepted, engine: str = OURS) -> Baseline:
        """Return the baseline that accepts a run.

        `engine`: see `engine_key`.
        """
        record, events = _kept(played.record), FirstEvents.of(played.log())
        made = cls(engine=engine, accepted=accepted, hash="", record=record, events=events)
        return made.model_copy(update={"hash": _hash_in(made.plain)})

    @property
    def played(self) -> Played:
        """What was accepted, to be compared with."""
        return Played(self.record, lambda: self.events.log)

    @property
    def plain(self) -> dict[str, Any]:
        """The file's content as plain values, without fields of the record that say nothing."""
        found = self.model_dump(mode="json", by_alias=True)
        silent: tuple[Any, ...] = (None, "", [], {})
        found["record"] = {
            name: value
            for name, value in found["record"].items()
            if name in _REQUIRED or not (value is False or value in silent)
        }
        return found

    @property
    def text(self) -> str:
        """The file's content; floats read back to the same bits."""
        return _json(self.plain, _LINES) + "\n"


_REQUIRED = {
    one.name
    for one in fields(CaseRecord)
    if one.default is MISSING and one.default_factory is MISSING
}
"""Fields of a record without a default."""


def _kept(record: CaseRecord) -> CaseRecord:
    """Return a record without what is not the engine's doing, or only explains or judges it."""
    metrics = {name: value for name, value in record.metrics.items() if name != "wall_time"}
    return replace(
        record,
        approximations=(),
        notes={},
        checks=(),
        left_out=(),
        excused="",
        not_asked=(),
        printed="",
        wall_time=None,
        measured="",
        reused=False,
        metrics={name: value for name, value in metrics.items() if value is not None},
    )


def _hash_in(plain: dict[str, Any]) -> str:
    return hash_of([plain.get("record"), plain.get("events")])


def engine_key(label: str) -> str:
    """Return what baselines call an engine: its own name, with the settings that it was given.

    So `games.my_engine:simulate:dt=1e-3` is `my_engine:dt=1e-3`, wherever that module may move.
    """
    return spec_of(engine_name(label), parse_spec(label)[1])


def engine_folder(baselines: Path, engine: str) -> Path:
    """Return where the baselines of one engine lie, in the folder of those of all.

    Raises `BaselineError` where that is no folder.
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


def load_baseline(path: Path, engine: str = OURS) -> Baseline:
    """Read a baseline of an engine; see `engine_key`.

    Raises `BaselineSchemaError` where another version of ghostball wrote it; `BaselineError` where
    it can't be read, was edited, or is of another engine.
    """
    try:
        text = read_text(path)
    except (OSError, UnicodeDecodeError) as error:
        raise BaselineError(f"{path}: can't read the baseline: {error}") from None
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise BaselineError(f"{path}: not valid JSON: {error}. {_RESTORE}") from None
    if not isinstance(data, dict) or "schema" not in data:
        raise BaselineError(f"{path}: has no `schema`, so it isn't a baseline. {_RESTORE}")
    if data["schema"] != SCHEMA:
        raise BaselineSchemaError(
            f"{path}: `schema` must be {SCHEMA}, got {data['schema']!r}: another version of "
            "ghostball wrote it. Use that version, or run `ghostball regress` and accept anew"
        )
    try:
        baseline = Baseline.model_validate(data)
    except ValidationError as error:
        raise BaselineError(f"{path}: {describe_validation_error(error)}. {_RESTORE}") from None
    if baseline.hash != _hash_in(data):
        raise BaselineError(
            f"{path}: `hash` isn't that of `record` and `events`: the file was edited. {_RESTORE}"
        )
    if baseline.record.scene != path.name.removesuffix(ENDING):
        raise BaselineError(
            f"{path}: `record.scene` must be the name of its file, got "
            f'"{baseline.record.scene}". {_RESTORE}'
        )
    if baseline.engine != engine:
        raise BaselineError(
            f"{path}: `engine` must be `{engine}`, got `{baseline.engine}`: one engine can't be "
            "compared with another. Give each engine a folder of its own, or remove the file and "
            "accept anew"
        )
    return baseline


def _json(value: Any, levels: int) -> str:
    """Return a value as JSON, with the entries of so many levels on lines of their own."""
    if not levels or not isinstance(value, (dict, list)) or not value:
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, list):
        begin, *entries, end = "[", *(_json(one, levels - 1) for one in value), "]"
    else:
        rows = ((json.dumps(key, ensure_ascii=False), one) for key, one in value.items())
        begin, *entries, end = "{", *(f"{key}: {_json(one, levels - 1)}" for key, one in rows), "}"
    return begin + "\n" + ",\n".join(entries) + "\n" + end
