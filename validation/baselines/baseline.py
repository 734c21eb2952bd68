"""An accepted baseline: one readable TOML file per scene, checked whole when it is read.

    schema = 3
    engine = "ghostball"             # with its settings: of another engine nothing is compared
    scene = "break-16"
    scene_hash = "..."               # of the scene's definition: another scene can't be compared

    [accepted]                       # when, of which revision, where, and why
    [hash]                           # of all bits, and of the order of events alone
    [end]                            # how the run ended, and when
    [end.balls]                      # where each ball lies: x, y, z [m]
    [metrics]                        # a metric's value, low and high; a number alone may not move
    [work]                           # likewise, what the engine counts
    [events]                         # how many, and the first ones, one a line

A band may be edited by hand, also as a table:

    rest_error_max = { value = 1e-12, low = 0.0, high = 1e-9, level = "warn", why = "it is loose" }

`level` is "off", "warn" or "error". The next `ghostball accept` keeps what was edited as long as
the value stays in the band.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Final, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from ghostball.model.hashes import bits_hash, sequence_hash
from ghostball.model.text_files import read_text
from ghostball.reference_adapters.registry import OURS
from ghostball.validation.baselines.bands import Band, Bands, band_of_counter, band_of_metric
from ghostball.validation.baselines.baseline_text import (
    events_of_lines,
    line_of,
    line_of_event,
    toml_lines,
)
from ghostball.validation.baselines.observed import KEPT_EVENTS, Observed
from ghostball.validation.baselines.places import ENDING, BaselineError
from ghostball.validation.baselines.regression import Level, Model
from ghostball.validation.checks.metric_table import METRICS
from ghostball.validation.results.files import describe_validation_error, toml_of

SCHEMA: Final = 3
"""Version of the files; another one can't be compared with."""


class BaselineSchemaError(BaselineError):
    """A baseline of another version of ghostball: nothing can be compared with it."""


Number = (
    Annotated[int, Field(strict=True)] | Annotated[float, Field(strict=True, allow_inf_nan=False)]
)
Hash = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
Coordinate = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Name = Annotated[str, Field(pattern=r"\S")]


class Accepted(Model):
    """When a baseline was accepted, by which code, where and why."""

    date: str
    revision: str
    platform: str
    reason: Name


class Value(Model):
    """A number and its band; `why` is "" where that was made by the rules in `bands`."""

    value: Number
    low: Number | None = None
    high: Number | None = None
    level: Level = "error"
    why: str = ""

    @model_validator(mode="after")
    def _in_its_band(self) -> Self:
        if not Band(self.low, self.high, self.level, self.why).holds(self.value):
            raise PydanticCustomError(
                "band",
                "`value` must lie between `low` and `high`, got {value} for {low} to {high}",
                {"value": self.value, "low": self.low, "high": self.high},
            )
        return self

    def band(self, rule: Band) -> Band:
        """Return what is accepted; `rule` is what the rules would say, for its reason."""
        return Band(self.low, self.high, self.level, self.why or rule.why)

    @property
    def short(self) -> object:
        """The number as the file holds it: alone, with low and high, or as a table."""
        if self.level == "error" and not self.why and None not in (self.low, self.high):
            alone = self.low == self.value == self.high
            return self.value if alone else [self.value, self.low, self.high]
        return self.model_dump(exclude_none=True, exclude_defaults=True)


def _value_of(data: object) -> object:
    """Return the fields of a `Value` as a file may hold it."""
    if isinstance(data, (dict, Value)):
        return data
    if isinstance(data, list):
        if len(data) != 3:
            raise PydanticCustomError(
                "band",
                "must be a number, [value, low, high] or a table, got {data}",
                {"data": data},
            )
        return dict(zip(("value", "low", "high"), data, strict=True))
    return {"value": data, "low": data, "high": data}


Short = Annotated[Value, BeforeValidator(_value_of)]


class Hashes(Model):
    """Hashes of a run; see `Observed`.

    `level` "error": any bit that moves fails, as our engine promises the same ones on every
    machine. "warn": rounding is reported and passes, and results that changed fail. "off": neither.
    """

    bits: Hash
    sequence: Hash
    level: Level = "error"


class End(Model):
    """How a run ended."""

    status: Name
    rest_time: Coordinate
    balls: dict[str, tuple[Coordinate, Coordinate, Coordinate]]

    @property
    def rest_positions(self) -> NDArray[np.float64]:
        """Where the balls lie [m], with shape (n, 3)."""
        return np.array(list(self.balls.values()), dtype=np.float64).reshape(-1, 3)


class Log(Model):
    """The events: how many, and the first of them."""

    count: int = Field(ge=0)
    first: tuple[str, ...]


class Baseline(Model):
    """What was accepted of one scene; see the module."""

    schema_version: Literal[3] = Field(default=SCHEMA, alias="schema")
    engine: Name
    scene: Name
    title: str
    scene_hash: Hash
    truth: str | None = None
    accepted: Accepted
    hash: Hashes
    end: End
    metrics: dict[str, Short]
    work: dict[str, Short]
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
        kept = min(self.events.count, KEPT_EVENTS)
        if len(self.events.first) != kept:
            raise PydanticCustomError(
                "events",
                "`events.first` must hold the first {kept} of {count} events, got {got}",
                {"kept": kept, "count": self.events.count, "got": len(self.events.first)},
            )
        events = events_of_lines(self.events.first)
        found = (sequence_hash(events), bits_hash(events, self.end.rest_positions))
        if self.events.count == kept and found != (self.hash.sequence, self.hash.bits):
            raise PydanticCustomError(
                "hash", "`hash` isn't that of the events and rest positions in the file"
            )
        return self

    @property
    def bands(self) -> Bands:
        """What is accepted."""
        values = {name: one.value for name, one in self.metrics.items()}
        return Bands(
            {name: one.band(band_of_metric(name, values)) for name, one in self.metrics.items()},
            {name: one.band(band_of_counter(int(one.value))) for name, one in self.work.items()},
            self.hash.level,
        )

    @classmethod
    def of(
        cls,
        observed: Observed,
        accepted: Accepted,
        earlier: Baseline | None = None,
        engine: str = OURS,
    ) -> Baseline:
        """Return the baseline that accepts what was observed.

        `earlier`: the one that it replaces: its bands and levels stay where they still hold.
        `engine`: which engine it is of: see `engine_key`.
        """
        promised: Level = "error" if engine == OURS else "warn"
        bands = {name: band_of_metric(name, observed.metrics) for name in observed.metrics}
        before = {} if earlier is None else earlier.metrics
        counted = {} if earlier is None else earlier.work
        metrics = {
            name: _value(before.get(name), value, bands[name])
            for name, value in observed.metrics.items()
        }
        work = {
            name: _value(counted.get(name), count, band_of_counter(count))
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
                balls=dict(zip(observed.ids, places, strict=True)),
            ),
            metrics=metrics,
            work=work,
            events=Log(
                count=observed.event_count,
                first=tuple(line_of_event(event) for event in observed.events[:KEPT_EVENTS]),
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
            self.end.rest_positions,
            events_of_lines(self.events.first),
            self.events.count,
            self.hash.bits,
            self.hash.sequence,
            {name: value.value for name, value in self.metrics.items()},
            {name: int(value.value) for name, value in self.work.items()},
            tuple(self.end.balls),
        )

    def text(self) -> str:
        """Return the file's content; floats read back to the same bits."""
        plain = self.model_dump(by_alias=True, exclude_none=True)
        for table in ("metrics", "work"):
            plain[table] = {name: one.short for name, one in getattr(self, table).items()}
        tables = {name: plain.pop(name) for name in ("accepted", "hash", "end")}
        tables["end.balls"] = tables["end"].pop("balls")
        tables |= {name: plain.pop(name) for name in ("metrics", "work", "events")}
        lines = [*toml_lines(plain)]
        for name, fields in tables.items():
            lines += ["", f"[{name}]", *toml_lines(fields)]
        return "\n".join(lines) + "\n"


def load_baseline(path: Path, engine: str = OURS) -> Baseline:
    """Read a baseline of an engine; see `engine_key`.

    Raises `BaselineSchemaError` where another version of ghostball wrote it; `BaselineError` where
    it can't be read, is nonsense, or of another engine.
    """
    try:
        text = read_text(path)
    except (OSError, UnicodeDecodeError) as error:
        raise BaselineError(f"{path}: can't read the baseline: {error}") from None
    return baseline_of(text, path, engine)


def baseline_of(text: str, path: Path, engine: str = OURS) -> Baseline:
    """Read the text of a baseline, as `load_baseline`; `path` is its file, or where it would be."""
    try:
        data = toml_of(text)
    except ValueError as error:
        raise BaselineError(f"{path}: not valid TOML: {error}. {_RESTORE}") from None
    if "schema" not in data:
        raise BaselineError(f"{path}: holds no `schema`: cut short, or no baseline. {_RESTORE}")
    if data["schema"] != SCHEMA:
        raise BaselineSchemaError(
            f"{path}:{line_of(text, 'schema')}: `schema` must be {SCHEMA}, got "
            f"{data['schema']!r}: another version of ghostball wrote it. Use that version, or run "
            "`ghostball regress` and accept anew"
        )
    try:
        baseline = Baseline.model_validate(data)
    except ValidationError as error:
        raise BaselineError(f"{path}: {describe_validation_error(error)}. {_RESTORE}") from None
    if baseline.scene != path.name.removesuffix(ENDING):
        raise BaselineError(
            f"{path}:{line_of(text, 'scene')}: `scene` must be the name of its file, got "
            f'"{baseline.scene}". {_RESTORE}'
        )
    if baseline.engine != engine:
        raise BaselineError(
            f"{path}:{line_of(text, 'engine')}: `engine` must be `{engine}`, got "
            f"`{baseline.engine}`: one engine can't be compared with another. Give each engine a "
            "folder of its own, or remove the file and accept anew"
        )
    return baseline


_RESTORE = "Restore it (git checkout), or remove it and accept anew"


def _value(earlier: Value | None, value: int | float, band: Band) -> Value:
    """Return a number with its band: the earlier one where that holds it.

    So a number that drifts a little with each change leaves its band one day.
    """
    if earlier is not None and earlier.band(band).holds(value):
        return earlier.model_copy(update={"value": value})
    level = band.level if earlier is None else earlier.level
    return Value(value=value, low=band.low, high=band.high, level=level)
