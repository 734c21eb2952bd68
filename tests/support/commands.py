"""What tests ask of a command that is run in their process."""

from __future__ import annotations

from click.testing import Result

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
    said = " ".join(result.stderr.split())
    for part in parts:
        assert part in said
    return True
