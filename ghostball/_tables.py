"""Results, scenes and engines as tables for the eye."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from rich import box
from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from ghostball.engine import Record, Result, Scene
from ghostball.engine.running.skips import explain_skips
from ghostball.engine.scene.features import Capability, Feature
from ghostball.engine.scene.toml import dumps
from ghostball.reference_adapters import EngineError, engine_class, engine_names
from ghostball.reference_adapters.base import EngineSettings
from ghostball.reference_adapters.registry import known_settings
from ghostball.validation.checks.metric_table import METRICS

SETTINGS_KEY = (
    "Settings with their defaults, and other choices in brackets; a setting that is unset is left "
    "to the engine.\nTo change them: NAME:KEY=VALUE,... as in `--engine pymunk:mode=landed`.\n"
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


def skips_table(scene: Scene, settings: Mapping[str, Any], record: Record) -> Table:
    """Return a line for each skip of our engine: whether a run uses it, why, what it saves."""
    table = Table(box=box.SIMPLE_HEAD)
    table.add_column("skip", no_wrap=True)
    table.add_column("used")
    table.add_column("because")
    table.add_column("it leaves out")
    off = settings.get("no_skip")
    for use in explain_skips(scene, record, off.split("+") if off else ()):
        used = "[green]yes[/]" if use.used else "no"
        table.add_row(use.skip, used, escape(use.why), escape(use.skip.leaves_out))
    return table


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


def engines_list(names: Sequence[str] = ()) -> Iterator[RenderableType]:
    """Yield a block for each of some engines, or of all that are installed.

    It says whether the engine can run, its settings and its capabilities.
    """
    yield Text(SETTINGS_KEY)
    for name in names or engine_names():
        try:
            engine = engine_class(name)
            reason = engine.unavailable()
            make: Any = engine  # see `make_engine`
            rows = {"settings": _defaults(engine.Settings)}
            rows |= _capability_rows(make().capabilities)
        except EngineError as error:
            reason, rows = str(error), {}
        except Exception as error:  # someone's broken package must not hide the other engines
            reason, rows = f"it failed when asked: {type(error).__name__}: {error}", {}
        yield _engine_block(name, reason, rows)


def _engine_block(name: str, reason: str | None, rows: Mapping[str, str]) -> RenderableType:
    heading = Text(name, style="bold")
    if reason is None:
        heading.append("  available", style="green")
    else:
        heading.append("  unavailable: ", style="bold red").append(reason, style="default")
    return Group(heading, _facts(rows), "")


def _capability_rows(capabilities: Mapping[Feature, Capability]) -> dict[str, str]:
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
