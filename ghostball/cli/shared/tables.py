"""Results, scenes and engines as tables for the eye."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from rich import box
from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from ghostball.model import Result, Scene
from ghostball.model.features import Capability, Feature
from ghostball.model.scene.toml import dumps
from ghostball.reference_adapters import EngineError, engine_class, engine_names
from ghostball.reference_adapters.base import EngineSettings
from ghostball.reference_adapters.registry import known_settings
from ghostball.validation.checks.metric_table import METRICS

ENGINES_KEY = (
    "Of the {count} features of a shot, an engine represents so many exactly, nearly, or not; "
    "`ghostball engines NAME`\nsays which, and its settings."
)

SETTINGS_KEY = (
    "Settings with their defaults, and other choices in brackets; a setting that is unset is left "
    "to the engine.\nTo change them: NAME:KEY=VALUE,... as in "
    "`--engine pymunk:contact_steps=exact`.\n"
)


def result_table(result: Result) -> RenderableType:
    """Return where the balls ended, and what happened and what it cost beneath."""
    scene = result.scene
    flight = scene.physics.airborne
    balls = Table(box=box.SIMPLE_HEAD)
    balls.add_column("ball")
    for quantity in ("x", "y", "z", "moved") if flight else ("x", "y", "moved"):
        balls.add_column(escape(f"{quantity} [m]"), justify="right")
    moved = result.rest_positions - scene.positions
    for ball, position, way in zip(scene.balls, result.rest_positions, moved, strict=True):
        shown = [f"{x:.9f}" for x in position[: 3 if flight else 2]]
        balls.add_row(escape(ball.id), *shown, f"{float(way @ way) ** 0.5:.6f}")
    return Group(_heading(scene), balls, _facts(_outcome(result)))


def scenes_table(scenes: Iterable[Scene]) -> Table:
    """Return a line for each scene: name, balls, tags, title."""
    table = Table(box=box.SIMPLE_HEAD)
    table.add_column("scene", no_wrap=True)
    table.add_column("balls", justify="right")
    table.add_column("title")
    table.add_column("tags")
    for scene in scenes:
        table.add_row(
            scene.name, str(len(scene.balls)), escape(scene.title), escape(", ".join(scene.tags))
        )
    return table


def scenes_json(scenes: Iterable[Scene]) -> str:
    """Return the definitions of scenes as one JSON object, by name."""
    plain = {scene.name: scene.model_dump(mode="json", by_alias=True) for scene in scenes}
    return json.dumps({"scenes": plain})


def scene_text(scene: Scene) -> str:
    """Return the file of a scene."""
    return dumps(scene)


def metrics_table() -> Table:
    """Return a line for each metric: name, unit, meaning."""
    table = Table(box=box.SIMPLE_HEAD)
    table.add_column("metric", no_wrap=True)
    table.add_column("unit")
    table.add_column("meaning")
    table.add_column("compared with")
    for one in METRICS.values():
        table.add_row(one.name, escape(one.unit), escape(one.meaning), one.compares or "nothing")
    return table


def metrics_json() -> str:
    """Return the metrics as one JSON object."""
    rows = [
        {"name": m.name, "unit": m.unit, "meaning": m.meaning, "compares": m.compares}
        for m in METRICS.values()
    ]
    return json.dumps({"metrics": rows})


def engines_table() -> RenderableType:
    """Return a line for each engine: whether it runs here, its step, how much it represents."""
    table = Table(box=box.SIMPLE_HEAD)
    table.add_column("engine", no_wrap=True)
    table.add_column("step")
    for heading in ("exact", "nearly", "not"):
        table.add_column(heading, justify="right")
    table.add_column("runs here")
    for name in engine_names():
        found = _described(name)
        supports = [found.capabilities.get(one, Capability("none")).support for one in Feature]
        counts = [str(supports.count(kind)) for kind in ("exact", "approximate", "none")]
        step = found.settings.get("dt", "none")
        table.add_row(
            name,
            "its own" if step is None else f"{step} s" if isinstance(step, float) else step,
            *(counts if found.capabilities else ("", "", "")),
            Text("yes", style="green") if found.reason is None else Text(found.reason),
        )
    return Group(table, Text(ENGINES_KEY.format(count=len(Feature))))


def engine_blocks(names: Sequence[str]) -> Iterator[RenderableType]:
    """Yield a block for each of some engines: whether it runs here, its settings, its features."""
    if names:
        yield Text(SETTINGS_KEY)
    for name in names:
        found = _described(name)
        rows = {"settings": found.choices} if found.capabilities else {}
        yield _engine_block(name, found.reason, rows | _capability_rows(found.capabilities))


@dataclass(frozen=True)
class _Described:
    """What an engine says of itself; `reason` is why it can't run here, None where it can."""

    reason: str | None
    settings: Mapping[str, Any] = field(default_factory=dict)
    choices: str = ""
    capabilities: Mapping[Feature, Capability] = field(default_factory=dict)


def _described(name: str) -> _Described:
    try:
        engine = engine_class(name)
        make: Any = engine  # see `make_engine`
        return _Described(
            engine.unavailable(),
            known_settings(engine.Settings),
            _defaults(engine.Settings),
            make().capabilities,
        )
    except EngineError as error:
        return _Described(str(error))
    except Exception as error:  # someone's broken package must not hide the other engines
        return _Described(f"it failed when asked: {type(error).__name__}: {error}")


def _engine_block(name: str, reason: str | None, rows: Mapping[str, str]) -> RenderableType:
    heading = Text(name, style="bold")
    if reason is None:
        heading.append("  available", style="green")
    else:
        heading.append("  unavailable: ", style="bold red").append(reason, style="default")
    return Group(heading, _facts(rows), "")


def _capability_rows(capabilities: Mapping[Feature, Capability]) -> dict[str, str]:
    if not capabilities:
        return {}
    # Features with one and the same explanation share a line.
    grouped: dict[str, dict[str, list[str]]] = {}
    for feature in Feature:
        capability = capabilities.get(feature, Capability("none"))
        by_explanation = grouped.setdefault(capability.support, {})
        by_explanation.setdefault(capability.how, []).append(feature.value)
    titles = {"exact": "exact", "approximate": "approximate", "none": "not represented"}
    return {
        title: "\n".join(
            ", ".join(features) + (f": {how}" if how else "")
            for how, features in grouped[support].items()
        )
        for support, title in titles.items()
        if support in grouped
    }


def _defaults(settings: type[EngineSettings]) -> str:
    """Return all settings with their defaults, and the choices where there are only some."""
    properties = settings.model_json_schema()["properties"]
    shown = []
    for key, default in known_settings(settings).items():
        others = [choice for choice in properties[key].get("enum", ()) if choice != default]
        text = f"{key} unset" if default is None else f"{key}={default}"
        shown.append(text + (f" ({', '.join(map(str, others))})" if others else ""))
    return ", ".join(shown)


def _outcome(result: Result) -> dict[str, str]:
    plain = result.to_dict()
    initial, final = plain["energy"]["initial"], plain["energy"]["final"]
    status = result.status.value + (f": {result.reason}" if result.reason else "")
    rows = {
        "engine": " ".join([result.engine, _settings(result.settings)]).strip(),
        "ended": f"at t = {result.rest_time:.9f} s, {status}",
        "collisions": _pairs(result.collision_counts),
        "energy": f"{initial:.6g} J at the start, {final:.6g} J at the end",
        "work": _pairs(result.work),
        "wall time": f"{result.wall_time * 1e3:.3f} ms",
    }
    if result.events is not None:
        rows["events"] = f"{len(result.events)} recorded; `--format json` prints them"
    return rows


def _heading(scene: Scene) -> Text:
    return Text(scene.name, style="bold").append(f"  {scene.title}", style="not bold")


def _facts(rows: Mapping[str, str]) -> Table:
    table = Table(box=None, show_header=False, padding=(0, 1))
    table.add_column(style="dim", no_wrap=True)
    table.add_column(overflow="fold")
    for key, value in rows.items():
        table.add_row(key, escape(value))
    return table


def _pairs(counts: Mapping[str, Any]) -> str:
    return ", ".join(f"{key} {value}" for key, value in counts.items()) or "none"


def _settings(settings: Mapping[str, Any]) -> str:
    return ", ".join(f"{key}={value}" for key, value in settings.items())
