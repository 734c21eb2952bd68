"""An accepted baseline: the record of a run as JSON with a hash, one file per scene.

Each engine has its own folder.

| field | content |
|---|---|
| `schema` | version of the file format |
| `engine` | the engine and its settings; a baseline applies to no other engine or settings |
| `accepted` | date, code revision, platform and reason of the acceptance |
| `hash` | hash of the record and its events; an edited file is refused |
| `record` | the run, as `results.records.CaseRecord` |
| `events` | number of events, hash of their order, and the first events |
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
from ghostball.validation.baselines.compared_run import ComparedRun, EventLog
from ghostball.validation.baselines.regression import StrictModel
from ghostball.validation.results.files import describe_validation_error
from ghostball.validation.results.records import CaseRecord
from ghostball.validation.suite.unchanged import hash_of

SCHEMA: Final = 4
"""Version of the files; a file of another version can't be compared."""

KEPT_EVENTS = 64
"""Number of events that a baseline stores one by one; most shipped shots have fewer.

Later differences show only in the hashes. To find the place, compare two runs by `ghostball diff`.
"""

ENDING = ".json"
_RESTORE = "Restore it (git checkout), or remove it and accept again"
_LINES = 3
"""Nesting levels whose entries have a line each, so that git shows which entries changed."""


class BaselineError(GhostballError, ValueError):
    """A baseline that can't be read or is inconsistent, such as a file edited by hand."""


class BaselineSchemaError(BaselineError):
    """A baseline that another version of Ghostball wrote; nothing can be compared with it."""


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


class Accepted(StrictModel):
    """Date, code revision, platform and reason of an acceptance."""

    date: str
    revision: str
    platform: str
    reason: Name


class FirstEvents(StrictModel):
    """The number of events of a shot, the hash of their order, and the first events."""

    count: int = Field(ge=0)
    sequence: str
    first: tuple[Row, ...] = Field(max_length=KEPT_EVENTS)

    @classmethod
    def of(cls, log: EventLog) -> FirstEvents:
        """Return the part of a log that a baseline stores."""
        rows = log.events[:KEPT_EVENTS].tolist()
        first = tuple((t, EventKind(kind).label, a, b) for t, kind, a, b in rows)
        return cls.model_validate({"count": log.count, "sequence": log.sequence, "first": first})

    @property
    def log(self) -> EventLog:
        """The events, in the form that `compare` needs."""
        events: Events = np.array([*self.first], dtype=EVENT_DTYPE)
        return EventLog(events, self.count, self.sequence)


class Baseline(StrictModel):
    """The accepted result of one scene; the module lists the fields."""

    schema_version: Literal[4] = Field(default=SCHEMA, alias="schema")
    engine: Name
    accepted: Accepted
    hash: str
    record: CaseRecord
    events: FirstEvents

    @model_validator(mode="after")
    def _events_are_of_the_record(self) -> Self:
        """Check what a hash can't: a faulty program may hash wrong contents."""
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
    def of(cls, played: ComparedRun, accepted: Accepted, engine: str = OURS) -> Baseline:
        """Return the baseline that accepts a run.

        `engine`: see `engine_key`.
        """
        record, events = _kept(played.record), FirstEvents.of(played.log())
        made = cls(engine=engine, accepted=accepted, hash="", record=record, events=events)
        return made.model_copy(update={"hash": _hash_in(made.plain)})

    @property
    def played(self) -> ComparedRun:
        """The accepted run, in the form that `compare` needs."""
        return ComparedRun(self.record, lambda: self.events.log)

    @property
    def plain(self) -> dict[str, Any]:
        """The content of the file as plain values, without optional fields that are empty."""
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
        """The content of the file; floats read back to the same bits."""
        return _json(self.plain, _LINES) + "\n"


_REQUIRED = {
    one.name
    for one in fields(CaseRecord)
    if one.default is MISSING and one.default_factory is MISSING
}
"""Fields of a record without a default."""


def _kept(record: CaseRecord) -> CaseRecord:
    """Return a record without the fields that judge the run or differ between equal runs."""
    metrics = {name: value for name, value in record.metrics.items() if name != "wall_time"}
    return replace(
        record,
        approximations=(),
        notes={},
        checks=(),
        left_out=(),
        excused="",
        not_asked=(),
        claim="",
        related={},
        printed="",
        wall_time=None,
        engine_time=None,
        measured="",
        reused=False,
        metrics={name: value for name, value in metrics.items() if value is not None},
    )


def _hash_in(plain: dict[str, Any]) -> str:
    return hash_of([plain.get("record"), plain.get("events")])


def engine_key(label: str) -> str:
    """Return the name of an engine in its baselines: its own name, with the given settings.

    For example, `games.my_engine:simulate:dt=1e-3` becomes `my_engine:dt=1e-3`, so moving the
    module doesn't change the key.
    """
    return spec_of(engine_name(label), parse_spec(label)[1])


def engine_folder(baselines: Path, engine: str) -> Path:
    """Return the folder of one engine inside the folder of all baselines.

    Raises `BaselineError` if the path exists and isn't a folder.
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
    """Return the names of the scenes with a baseline in a folder, sorted."""
    return tuple(sorted(path.name.removesuffix(ENDING) for path in folder.glob(f"*{ENDING}")))


def load_baseline(path: Path, engine: str = OURS) -> Baseline:
    """Read a baseline of an engine; see `engine_key`.

    Raises `BaselineSchemaError` if another version of Ghostball wrote it; `BaselineError` if it
    can't be read, was edited, or belongs to another engine.
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
            "ghostball wrote it. Use that version, or run `ghostball regress` and accept again"
        )
    try:
        baseline = Baseline.model_validate(data)
    except ValidationError as error:
        raise BaselineError(f"{path}: {describe_validation_error(error)}. {_RESTORE}") from None
    if baseline.hash != _hash_in(data):
        raise BaselineError(
            f"{path}: `hash` doesn't match `record` and `events`: the file was edited. {_RESTORE}"
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
            "accept again"
        )
    return baseline


def _json(value: Any, levels: int) -> str:
    """Return a value as JSON; the entries of the first `levels` nesting levels have a line each."""
    if not levels or not isinstance(value, (dict, list)) or not value:
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, list):
        begin, *entries, end = "[", *(_json(one, levels - 1) for one in value), "]"
    else:
        rows = ((json.dumps(key, ensure_ascii=False), one) for key, one in value.items())
        begin, *entries, end = "{", *(f"{key}: {_json(one, levels - 1)}" for key, one in rows), "}"
    return begin + "\n" + ",\n".join(entries) + "\n" + end
