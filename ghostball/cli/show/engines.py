"""`ghostball engines`: list engines, describe them, check the installation, measure time steps."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import typer
from rich.console import Group, RenderableType
from rich.text import Text

from ghostball.cli.measure.steps import measure_steps
from ghostball.cli.shared.calls import refuse_given
from ghostball.cli.shared.tables import facts_table, table_of
from ghostball.cli.shared.terminal import stdout
from ghostball.cli.show.commands import EnginesOptions
from ghostball.cli.show.installation import check_installation
from ghostball.model.features import Capability, Feature, has_feature, scene_features
from ghostball.reference_adapters import EngineError, ReferenceEngine, engine_class, engine_names
from ghostball.reference_adapters.base import EngineSettings
from ghostball.reference_adapters.registry import EngineUnavailableError, known_settings
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.parallel.sources import PACKAGE_OF, version_of, versions
from ghostball.validation.scenes.library import select

ENGINES_KEY = (
    "Main gaps: unsupported features, the most needed first; in brackets, how many of the {count} "
    "shipped scenes need the feature.\n"
    "`ghostball engines NAME` lists all features and settings, and why an engine is unavailable; "
    "with --recipe, it prints the best settings of the engine as a program ({recipes})."
)

GAPS_SHOWN = 2
"""Number of unsupported features in the table of engines, for each engine."""

SETTINGS_KEY = (
    "Settings with their defaults, and other choices in brackets; unset: the engine's own default "
    "applies.\nTo change them: NAME:KEY=VALUE,... as in "
    "`--engine pymunk:contact_steps=exact`.\n"
)


def run(asked: EnginesOptions) -> ExitStatus:
    """List or describe engines, print recipes, check the installation, or measure time steps.

    Raises `typer.BadParameter` if options contradict each other, `EngineError` if no engine has a
    given name.
    """
    context, names = asked.context, asked.names or ()
    if asked.steps:
        refuse_given(context, "`--steps` measures engines", "recipe", "check")
        return measure_steps(names, asked.scene, asked.repeats, asked.out, asked.plot, asked.form)
    why = "only `--steps` runs engines"
    refuse_given(context, why, "scene", "repeats", "out", "plot", "form")
    if asked.check:
        refuse_given(context, "`--check` examines the whole installation", "names", "recipe")
        return check_installation()
    if asked.recipe:
        for name in names:
            typer.echo(recipe_of(name), nl=False)
        if not names:
            raise typer.BadParameter(
                f"needs an engine: {', '.join(recipe_names())}", param_hint="--recipe"
            )
        return ExitStatus.PASSED
    for name in names:
        with suppress(EngineUnavailableError):  # described below with its reason
            engine_class(name)
    for block in engine_blocks(names) if names else [engines_table()]:
        stdout().print(block)
    return ExitStatus.PASSED


def engines_table() -> RenderableType:
    """Return a table with a line for each engine: version, availability and main gaps."""
    scenes = select()
    needed = Counter(feature for scene in scenes for feature in scene_features(scene))
    rows: list[Sequence[RenderableType]] = []
    absent: list[str] = []
    for name in engine_names():
        found = _described(name)
        if found.reason is not None:
            absent.append(name)
        lacks = [one for one in needed if not has_feature(found.capabilities, one)]
        lacks.sort(key=lambda one: -needed[one])
        said = [f"{one.value} ({needed[one]})" for one in lacks[:GAPS_SHOWN]]
        if not found.capabilities:
            said = []
        elif not lacks:
            said = ["nothing"]
        here = Text("yes", style="green") if found.reason is None else Text("no", style="red")
        rows.append((name, found.version, here, Text(", ".join(said))))
    key = ENGINES_KEY.format(count=len(scenes), recipes=", ".join(recipe_names()))
    if absent:
        key = f"Not installed: {', '.join(absent)}.\n{key}"
    heads = ("engine", "version", "installed", "main gaps (scenes)")
    return Group(table_of(heads, rows, whole=heads[:3]), Text(key))


def recipe_names() -> tuple[str, ...]:
    """Return the engines that have a recipe: their best settings as code."""
    return tuple(sorted(path.stem.removesuffix("_recipe") for path in _recipes("*")))


def recipe_of(name: str) -> str:
    """Return the recipe of an engine: its best settings as code.

    Raises `EngineError` if there is none.
    """
    if name not in recipe_names():
        raise EngineError(
            f"engine {name!r} has no recipe. Recipes exist for {', '.join(recipe_names())}; for "
            "other engines, see the settings in reference_adapters/ENGINE/"
        )
    (path,) = _recipes(name)
    return path.read_text(encoding="utf-8")


def _recipes(name: str) -> list[Path]:
    """Return the recipe files of an engine ("*": of all engines), from a wheel or a checkout."""
    package = Path(__file__).resolve().parents[2]
    folders = (package / "recipes", package.parent / "docs" / "recipes")
    return [path for folder in folders for path in folder.glob(f"{name}_recipe.py")]


def engine_blocks(names: Sequence[str]) -> Iterator[RenderableType]:
    """Yield a block for each engine: its availability, settings and features."""
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
class _EngineDescription:
    """Description of an engine.

    `reason`: why the engine can't run here; None if it can.
    `settings`: defaults by name.
    `choices`: the settings with their defaults and other choices, as text.
    """

    reason: str | None
    settings: Mapping[str, Any] = field(default_factory=dict)
    choices: str = ""
    capabilities: Mapping[Feature, Capability] = field(default_factory=dict)
    version: str = ""


def _described(name: str) -> _EngineDescription:
    try:
        engine = engine_class(name)
        make: Any = engine  # see `make_engine`
        return _EngineDescription(
            engine.unavailable(),
            known_settings(engine.Settings),
            _defaults(engine.Settings),
            make().capabilities,
            _version(engine),
        )
    except EngineError as error:
        return _EngineDescription(str(error))
    except Exception as error:  # one broken package must not hide the other engines
        return _EngineDescription(f"the check failed: {type(error).__name__}: {error}")


def _version(engine: type[ReferenceEngine]) -> str:
    """Return the version of the package of an engine, or of its adapter; "" if unknown."""
    top = engine.__module__.partition(".")[0]
    if top == "ghostball":
        return versions().get(PACKAGE_OF.get(engine.name, engine.name)) or ""
    return version_of(engine.name) or version_of(top) or ""


def _capability_rows(capabilities: Mapping[Feature, Capability]) -> dict[str, str]:
    if not capabilities:
        return {}
    # Features with the same explanation share a line.
    grouped: dict[str, dict[str, list[str]]] = {}
    for feature in Feature:
        capability = capabilities.get(feature, Capability("none"))
        by_explanation = grouped.setdefault(capability.support, {})
        by_explanation.setdefault(capability.how, []).append(feature.value)
    titles = {"exact": "exact", "approximate": "approximate", "none": "unsupported"}
    return {
        title: "\n".join(
            ", ".join(features) + (f": {how}" if how else "")
            for how, features in grouped[support].items()
        )
        for support, title in titles.items()
        if support in grouped
    }


def _defaults(settings: type[EngineSettings]) -> str:
    """Return all settings with their defaults and, for a choice, the other values."""
    properties = settings.model_json_schema()["properties"]
    shown = []
    for key, default in known_settings(settings).items():
        others = [choice for choice in properties[key].get("enum", ()) if choice != default]
        text = f"{key} unset" if default is None else f"{key}={default}"
        shown.append(text + (f" ({', '.join(map(str, others))})" if others else ""))
    return ", ".join(shown)
