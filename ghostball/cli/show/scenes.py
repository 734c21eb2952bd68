"""`ghostball scenes`: list the scenes or the metrics, print a scene, or export scenes."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

import typer
from rich.markup import escape

from ghostball.cli.options import TextOrJson
from ghostball.cli.shared.calls import refuse_given
from ghostball.cli.shared.tables import table_of
from ghostball.cli.shared.terminal import busy, stdout
from ghostball.cli.show.commands import ScenesOptions
from ghostball.model import GhostballError, Scene
from ghostball.model.scene import json_schema
from ghostball.model.scene.toml import dumps
from ghostball.reference_adapters.pooltool_files import pooltool_json
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.golden.format import SCENE_SCHEMA_FILE, SCHEMA_FILES, json_values
from ghostball.validation.results.files import write_files
from ghostball.validation.scenes.library import select

ANOTHER = "Choose another folder"
"""Remedy if files can't be written."""


def run(asked: ScenesOptions) -> ExitStatus:
    """List scenes or metrics, print a single scene, export scenes, or print the schema."""
    if asked.golden is not None:
        why = "`--golden` writes all golden shots"
        refuse_given(asked.context, why, "wanted", "schema", "export", "metrics", "pooltool")
        _write_golden(asked.golden)
    elif asked.metrics:
        why = "`--metrics` lists metrics instead of scenes"
        refuse_given(asked.context, why, "wanted", "schema", "export")
        _list_metrics(asked.form)
    elif asked.export is not None:
        _export(select(asked.wanted or ()), asked.export, for_pooltool=asked.pooltool)
    elif asked.pooltool:
        refuse_given(asked.context, "the option needs `--export`", "pooltool")
    elif asked.schema:
        typer.echo(json_schema())
    else:
        _list_scenes(asked.wanted or (), asked.form)
    return ExitStatus.PASSED


def _list_scenes(wanted: Sequence[str], form: TextOrJson) -> None:
    """List scenes; if a single scene is named, print its file."""
    found = select(wanted)
    if form is TextOrJson.JSON:
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


def _list_metrics(form: TextOrJson) -> None:
    """List the metrics."""
    from ghostball.validation.checks.metrics import METRICS  # noqa: PLC0415 - slow import

    if form is TextOrJson.JSON:
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


def _export(scenes: Sequence[Scene], folder: Path, *, for_pooltool: bool) -> None:
    """Write scenes as JSON: with their schema, for engines in any language, or for pooltool.

    Values from presets and defaults are written out.
    """
    if for_pooltool:
        write_files({folder / f"{one.name}.json": pooltool_json(one) for one in scenes}, ANOTHER)
        stdout().print(f"{len(scenes)} scenes for pooltool written to {folder}", soft_wrap=True)
        return
    files: dict[Path, str | bytes] = {folder / SCENE_SCHEMA_FILE: json_schema() + "\n"}
    for scene in scenes:
        files[folder / f"{scene.name}.json"] = json.dumps(json_values(scene), indent=1) + "\n"
    write_files(files, ANOTHER)
    count = "1 scene" if len(scenes) == 1 else f"{len(scenes)} scenes"
    stdout().print(f"{count} and the schema of scenes written to {folder}", soft_wrap=True)


def _write_golden(folder: Path) -> None:
    """Write the golden shots, their schemas and a README."""
    from ghostball.validation.golden.shots import golden_files  # noqa: PLC0415 - slow import

    if folder.exists() and not (folder.is_dir() and not any(folder.iterdir())):
        raise GhostballError(
            f"`--golden` must name a new or empty folder, got {folder}. Choose another folder"
        )
    with busy("golden shots: computing reference results"):
        files = golden_files()
    write_files({folder / name: text for name, text in files.items()}, ANOTHER)
    shots = len(files) - len(SCHEMA_FILES) - 1
    stdout().print(f"{shots} golden shots and a README written to {folder}", soft_wrap=True)
