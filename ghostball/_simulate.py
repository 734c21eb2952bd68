"""What `ghostball simulate` does: run one scene on one engine, show where the balls stop."""

from __future__ import annotations

import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import typer
from rich.markup import escape

from engine import GhostballError, Record, Status
from ghostball._tables import result_table, skips_table
from ghostball._terminal import ExitStatus, busy, say, stdout
from reference_adapters import make_engine
from reference_adapters.registry import OURS
from validation.library import find_scene
from validation.returned import ResultRefusedError, check_result


def run(
    scene: str,
    spec: str,
    *,
    record: Record,
    as_json: bool,
    plot: Path | None,
    explain_skips: bool,
) -> ExitStatus:
    """Simulate, and return the exit status; see the options of the command.

    Raises
    ------
    GhostballError
        Where scene or engine are wrong, or the engine lacks what the scene needs.
    """
    engine = make_engine(spec)
    if explain_skips and engine.name != OURS:
        raise typer.BadParameter(
            f"is about engine {OURS}, got {spec}", param_hint="--explain-skips"
        )
    shot = find_scene(scene)
    with busy(f"{shot.name} on {spec}"), _blamed_on(engine.name):
        result = engine.simulate(shot, record=record)
        if engine.name != OURS:  # ours may say itself that its run failed, and with which numbers
            check_result(result, shot, engine.name)
    if plot is not None:
        from reports import plot_result  # noqa: PLC0415

        with busy(f"drawing {plot}"):
            plot_result(result, plot)
    if as_json:
        typer.echo(result.to_json())
    else:
        stdout().print(result_table(result))
        if explain_skips:
            stdout().print(skips_table(result, record))
        if plot is not None:
            stdout().print(f"paths drawn in {plot}", soft_wrap=True, markup=False)
    if result.status.complete:
        return ExitStatus.PASSED
    say(f"[bold red]not complete:[/] {result.status.value}")
    special = {
        Status.INTERRUPTED: ExitStatus.INTERRUPTED,
        Status.FAILED: ExitStatus.HARNESS_FAILED,
    }
    return special.get(result.status, ExitStatus.CHECK_FAILED)


@contextmanager
def _blamed_on(name: str) -> Iterator[None]:
    """Name the engine where it fails, if it isn't ours: that is no bug of ghostball's.

    It may raise anything, and even exit.
    """
    try:
        yield
    except ResultRefusedError as error:
        say(f"[bold red]error:[/] {escape(str(error))}")
        raise typer.Exit(ExitStatus.HARNESS_FAILED) from None
    except GhostballError:
        raise
    except (Exception, SystemExit) as error:
        if name == OURS:
            raise
        say(escape("".join(traceback.format_exception(error)).rstrip()))
        say(
            f"[bold red]engine {escape(name)} failed:[/] "
            + escape(f"{type(error).__name__}: {error}. ")
            + "Please report it to who maintains that engine, with the lines above"
        )
        raise typer.Exit(ExitStatus.HARNESS_FAILED) from None
