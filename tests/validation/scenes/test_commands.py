"""Fails where a command that a report shows isn't one that can be given."""

import shlex

import pytest
from typer.main import get_command

from ghostball.cli import app
from ghostball.validation.scenes import commands

ODD = "newcomer:name=a b;rm,dt=1e-3"


@pytest.mark.parametrize(
    ("command", "words"),
    [
        (commands.simulate("stop"), ["run", "stop"]),
        (
            commands.simulate("my shot", ODD, recorded=True),
            [
                *("run", "./my shot.toml", "--engine", ODD),
                *("--record", "events", "--format", "json"),
            ],
        ),
        (commands.explain("stop", ODD), ["explain", "stop", "--engine", ODD]),
        (
            commands.validate("mine", "pymunk", "out/again"),
            ["validate", "./mine.toml", "--engine", "pymunk", "--out", "out/again"],
        ),
        (commands.regress(), ["regress"]),
        (
            commands.regress("stop", ODD),
            ["regress", "stop", "--engine", ODD],
        ),
        (commands.regress("mine"), ["regress", "./mine.toml"]),
    ],
)
def test_a_shell_reads_a_command_as_it_was_meant(command, words):
    program, *arguments = shlex.split(command)
    assert program == "ghostball"
    assert arguments == words
    # And the command line knows the command and its options.
    subcommand = get_command(app).commands[words[0]]
    subcommand.make_context(words[0], words[1:])
