"""Commands, run in the process of a test, and what is asked of them."""

from __future__ import annotations

from typing import Any

from typer.testing import CliRunner

from ghostball.cli import app

Result = Any
"""What the runner of typer returns."""

HEAD = 'schema = 1\nname = "shot"\n[table]\nlength = 2.0\nwidth = 1.0\n'
"""The start of a scene's file; balls follow."""


def ball(name: str = "cue", x: str = "0.5", extra: str = "") -> str:
    """Return a ball of a scene's file, which moves along x."""
    return f'[[balls]]\nid = "{name}"\nposition = [{x}, 0.5]\nvelocity = [1.0, 0.0]\n{extra}'


def cli(*arguments: object) -> Result:
    """Run a command as a user types it."""
    result = CliRunner().invoke(app, [*map(str, arguments)])
    assert "\x1b" not in result.output, "control codes without a terminal"
    return result


def refused(result: Result, *parts: str) -> bool:
    """Assert that the input was refused: one message with every part, no traceback, no result."""
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    assert "Traceback" not in result.stderr
    said = " ".join(result.stderr.split())
    for part in parts:
        assert part in said
    return True
