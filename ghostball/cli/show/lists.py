"""What `ghostball scenes`, `engines` and `metrics` do: list what is there."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import typer
from rich.console import Group, RenderableType
from rich.markup import escape
from rich.text import Text

from ghostball.cli.measure.elsewhere import export_scenes
from ghostball.cli.shared.options import Plain
from ghostball.cli.shared.tables import facts_table, table_of
from ghostball.cli.shared.terminal import stdout
from ghostball.model.features import Capability, Feature
from ghostball.model.scene import json_schema
from ghostball.model.scene.toml import dumps
from ghostball.reference_adapters import EngineError, engine_class, engine_names
from ghostball.reference_adapters.base import EngineSettings
from ghostball.reference_adapters.registry import known_settings
from ghostball.validation.checks.metric_table import METRICS
from ghostball.validation.scenes.library import select

ENGINES_KEY = (
    "Of the {count} features of a shot, an engine represents so many exactly, nearly, or not; "
    "`ghostball engines NAME`\nsays which, and its settings."
)

SETTINGS_KEY = (
    "Settings with their defaults, and other choices in brackets; a setting that is unset is left "
    "to the engine.\nTo change them: NAME:KEY=VALUE,... as in "
    "`--engine pymunk:contact_steps=exact`.\n"
)


def scenes(
    wanted: Sequence[str] | None, schema: bool, export: Path | None, form: Plain
) -> int | None:
    """List the scenes; of a single one, show its file."""
    if export is not None:
        return export_scenes(export, wanted or ())
    if schema:
        typer.echo(json_schema())
        return None
    found = select(wanted or [])
    if form is Plain.JSON:
        plain = {scene.name: scene.model_dump(mode="json", by_alias=True) for scene in found}
        typer.echo(json.dumps({"scenes": plain}))
    elif wanted and len(found) == 1:
        typer.echo(dumps(found[0]), nl=False)
    else:
        rows = (
            (one.name, str(len(one.balls)), escape(one.title), escape(", ".join(one.tags)))
            for one in found
        )
        stdout().print(table_of(("scene", "balls", "title", "tags"), rows, right=("balls",)))
    return None


def metrics(form: Plain) -> None:
    """List the metrics."""
    if form is Plain.JSON:
        rows = [
            {"name": m.name, "unit": m.unit, "meaning": m.meaning, "compares": m.compares}
            for m in METRICS.values()
        ]
        typer.echo(json.dumps({"metrics": rows}))
        return
    lines = (
        (one.name, escape(one.unit), escape(one.meaning), one.compares or "nothing")
        for one in METRICS.values()
    )
    stdout().print(table_of(("metric", "unit", "meaning", "compared with"), lines))


def engines(names: Sequence[str] | None) -> None:
    """List the engines, or say all of those that are named."""
    for block in engine_blocks(names) if names else [engines_table()]:
        stdout().print(block)


def engines_table() -> RenderableType:
    """Return a line for each engine: whether it runs here, its step, how much it represents."""
    rows: list[Sequence[RenderableType]] = []
    for name in engine_names():
        found = _described(name)
        supports = [found.capabilities.get(one, Capability("none")).support for one in Feature]
        counts = [str(supports.count(kind)) for kind in ("exact", "approximate", "none")]
        step = found.settings.get("dt", "none")
        dt = "its own" if step is None else f"{step} s" if isinstance(step, float) else step
        here = Text("yes", style="green") if found.reason is None else Text(found.reason)
        rows.append((name, dt, *(counts if found.capabilities else ("", "", "")), here))
    heads = ("engine", "step", "exact", "nearly", "not", "runs here")
    return Group(
        table_of(heads, rows, right=heads[2:5]), Text(ENGINES_KEY.format(count=len(Feature)))
    )


def engine_blocks(names: Sequence[str]) -> Iterator[RenderableType]:
    """Yield a block for each of some engines: whether it runs here, its settings, its features."""
    yield Text(SETTINGS_KEY)
    for name in names:
        found = _described(name)
        heading = Text(name, style="bold")
        if found.reason is None:
            heading.append("  available", style="green")
        else:
            heading.append("  unavailable: ", style="bold red").append(
                found.reason, style="default"
            )
        rows = {"settings": found.choices} if found.capabilities else {}
        yield Group(heading, facts_table(rows | _capability_rows(found.capabilities)), "")


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
