"""`ghostball dev`: what is about our own engine."""

from __future__ import annotations

from typing import Annotated

import typer

from ghostball._options import (
    EngineSpec,
    RecordChoice,
    SceneName,
)
from ghostball._terminal import command, stdout

app = typer.Typer(
    name="dev",
    help="For who works on ghostball itself.",
    no_args_is_help=True,
    rich_markup_mode=None,
)


@app.command()
@command
def skips(
    scene: SceneName,
    engine: EngineSpec = "ghostball",
    record: Annotated[
        RecordChoice, typer.Option(metavar="rest|events|trajectory", help="What a run keeps.")
    ] = RecordChoice.REST,
) -> None:
    """Say what our engine leaves out of a scene, and why.

    To switch some off: --engine ghostball:no_skip=contacts+cushions.
    """
    from ghostball._tables import skips_table  # noqa: PLC0415
    from ghostball.reference_adapters import make_engine  # noqa: PLC0415
    from ghostball.reference_adapters.registry import OURS  # noqa: PLC0415
    from ghostball.validation.scenes.library import find_scene  # noqa: PLC0415

    made = make_engine(engine)
    if made.name != OURS:
        raise typer.BadParameter(f"must be {OURS}, got {engine}", param_hint="--engine")
    settings = made.settings.model_dump(mode="json")
    stdout().print(skips_table(find_scene(scene), settings, record.value))
