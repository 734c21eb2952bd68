"""The command line: reads options, calls the packages that do the work, shows what they return."""

from __future__ import annotations

from typing import Annotated, Any

import typer
import typer.core

from ghostball.cli.gate.commands import app as gate
from ghostball.cli.measure.commands import app as measuring
from ghostball.cli.show.commands import app as showing

FIRST = ("run", "validate", "explain", "regress", "accept", "diff")
"""The commands that a user needs first."""


class Commands(typer.core.TyperGroup):
    """The commands in two parts: what a user needs first, and the rest."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write both parts of the help."""
        shown = {
            name: found
            for name in self.list_commands(ctx)
            if (found := self.get_command(ctx, name)) is not None and not found.hidden
        }
        rest = [name for name in shown if name not in FIRST]
        width = formatter.width - 6 - max(map(len, shown))
        for title, names in (("Commands", FIRST), ("More commands", rest)):
            with formatter.section(title):
                formatter.write_dl(
                    [(name, shown[name].get_short_help_str(width)) for name in names]
                )


app = typer.Typer(
    name="ghostball",
    cls=Commands,
    help="Runs the same billiard shots on several physics engines and shows which one is right.",
    epilog=(
        "Exit status: 0 all passed; 1 a check failed, or an engine failed, crashed, hung or did "
        "not finish; 2 bad usage or bad input; 3 ghostball itself failed; 4 nothing was judged, "
        "or there is nothing to compare with; 130 interrupted; 141 its output was closed, as by "
        "`head`, before all of it was written."
    ),
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    # Plain help and one-line errors, also where a CI pretends to be a terminal.
    rich_markup_mode=None,
)


def main() -> None:
    """Run the command line and exit."""
    app()


def _print_version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version  # noqa: PLC0415

        typer.echo(f"ghostball {version('ghostball')}")
        raise typer.Exit


@app.callback()
def _options(
    _version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version and exit."
        ),
    ] = False,
) -> None:
    """Hold the options that come before a command."""


PARTS = (measuring, gate, showing)

for part in PARTS:
    app.add_typer(part)
