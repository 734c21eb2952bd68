"""The command line: reads options, calls the other packages, and prints their results."""

from __future__ import annotations

from typing import Annotated, Any

import typer
import typer.core

from ghostball.cli.gate.commands import app as gate
from ghostball.cli.measure.commands import app as measuring
from ghostball.cli.show.commands import app as showing

SECTIONS = {
    "Commands": ("run", "validate", "explain", "report"),
    "Guard an engine against changes": ("init", "regress", "accept", "diff"),
    "More commands": ("scenes", "engines", "stress", "grade", "fit"),
}
"""The commands by section of the help; those that a new user needs come first."""


class Commands(typer.core.TyperGroup):
    """Group of commands; the help lists them in sections, with uncut first lines."""

    def list_commands(self, ctx: Any) -> list[str]:  # noqa: ARG002
        """Return the names of the commands in the order of the help."""
        return [name for names in SECTIONS.values() for name in names]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a command with its whole first line as the short help (click cuts it), or None."""
        found = super().get_command(ctx, cmd_name)
        if found is not None:
            found.short_help = (found.help or "").partition("\n")[0]
        return found

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the sections of the help."""
        width = max(map(len, self.list_commands(ctx)))
        for title, names in SECTIONS.items():
            with formatter.section(title):
                formatter.write_dl(
                    [(f"{n:{width}}", self.get_command(ctx, n).short_help) for n in names]
                )


app = typer.Typer(
    name="ghostball",
    cls=Commands,
    help="Simulates the same billiard shots on several physics engines and measures the error of "
    "each.",
    epilog=(
        "Exit status: 0 all checks passed; 1 a check failed, or an engine did not finish "
        "(exception, crash, time limit); 2 bad usage or bad input; 3 a bug in Ghostball; 4 nothing "
        "was judged, or there was nothing to compare with; 130 interrupted; 141 the output was "
        "closed before all of it was written, as `head` does."
    ),
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    # Plain help and one-line errors, even in CI services that report a terminal.
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
    """Declare the options that come before a command."""


PARTS = (measuring, gate, showing)

for part in PARTS:
    app.add_typer(part)
