"""Breaks where an option of what lists things has another name, or is not looked at."""

from commands import does_what_its_options_say

from ghostball.cli.show.commands import app


def test_what_a_command_does_takes_its_options():
    assert does_what_its_options_say(app)
