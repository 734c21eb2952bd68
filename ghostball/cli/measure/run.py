"""What `ghostball run` does: run one scene on one engine, show where the balls stop."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import typer
from rich.markup import escape

from ghostball.cli.shared.tables import result_table
from ghostball.cli.shared.terminal import busy, say, say_printed, stdout
from ghostball.model import Record
from ghostball.reference_adapters import make_engine
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.runs.playing import in_other_process, run_engine
from ghostball.validation.scenes.library import find_scene


def run(
    scene: str,
    spec: str,
    *,
    record: Record,
    as_json: bool,
    plot: Path | None,
    time_limit: float,
) -> ExitStatus:
    """Simulate, and return the exit status; see the options of the command.

    Raises
    ------
    GhostballError
        Where scene or engine are wrong, the engine lacks what the scene needs, or it fails.
    """
    engine = make_engine(spec)
    shot = find_scene(scene)
    with (
        busy(f"{shot.name} on {spec}"),
        in_other_process(engine, time_limit, partial(say_printed, engine.name)) as player,
    ):
        result = run_engine(player, shot, record)
    if plot is not None:
        from ghostball.reports import plot_result  # noqa: PLC0415

        with busy(f"drawing {plot}"):
            plot_result(result, plot)
    if as_json:
        typer.echo(result.to_json())
    else:
        stdout().print(result_table(result))
        if plot is not None:
            stdout().print(f"paths drawn in {plot}", soft_wrap=True, markup=False)
    if result.status.complete:
        return ExitStatus.PASSED
    why = f": {result.reason}" if result.reason else ""
    say(
        f"[bold red]engine {escape(engine.name)} did not finish:[/] "
        + escape(f"{result.status.value}{why}")
    )
    return ExitStatus.CHECK_FAILED
