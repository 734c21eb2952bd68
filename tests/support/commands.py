"""What tests ask of a command that is run in their process."""

from __future__ import annotations

from importlib import import_module
from inspect import signature

from click.testing import Result
from typer import Typer

HEAD = 'schema = 1\nname = "shot"\n[table]\nlength = 2.0\nwidth = 1.0\n'
"""The start of a scene's file; balls follow."""


def ball(name: str = "cue", x: str = "0.5", extra: str = "") -> str:
    """Return a ball of a scene's file, which moves along x."""
    return f'[[balls]]\nid = "{name}"\nposition = [{x}, 0.5]\nvelocity = [1.0, 0.0]\n{extra}'


def refused(result: Result, *parts: str) -> bool:
    """Assert that the input was refused: one message with every part, no traceback, no result."""
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    assert "Traceback" not in result.stderr
    for part in parts:
        assert part in result.stderr
    return True


def does_what_its_options_say(commands: Typer) -> bool:
    """Assert that what each command does takes its options, by their names, and no others."""
    for one in commands.registered_commands:
        module, function = one.callback.does
        does = getattr(import_module(f"ghostball.cli.{module}"), function)
        assert [*signature(does).parameters] == [*signature(one.callback).parameters]
    return bool(commands.registered_commands)
