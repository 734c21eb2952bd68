"""Declare commands: a dataclass of options becomes a command that calls a module.

This module imports nothing slow, because `ghostball --help` must not wait for numpy and the
engines.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from importlib import import_module
from typing import Any, TypeVar, get_type_hints

import typer
import typer.core

from ghostball.cli.options import ALL_RELATIONS, RELATION_NAMES

T = TypeVar("T")


def command(app: typer.Typer, module: str) -> Callable[[type[T]], type[T]]:
    """Return a decorator that turns a dataclass into a command of `app`.

    The fields are the options, and the docstring is the help text.

    `module`: module below `ghostball.cli`, imported when the command is called. The last part of
        its name is the name of the command. Its function `run` takes the options and returns the
        exit status.
    """

    def decorate(options: type[T]) -> type[T]:
        def call(**given: Any) -> None:
            from ghostball.cli.shared.terminal import in_a_command  # noqa: PLC0415 - slow import

            with in_a_command():
                implementation: Any = import_module(f"ghostball.cli.{module}")
                raise typer.Exit(implementation.run(options(**given)))

        hints = get_type_hints(options, include_extras=True)
        declared = inspect.signature(options).parameters.values()
        fields = [one.replace(annotation=hints[one.name]) for one in declared]
        call.__signature__ = inspect.Signature(fields)  # type: ignore[attr-defined]
        call.__doc__ = inspect.getdoc(options)
        app.command(module.rpartition(".")[2], cls=_Command)(call)
        return options

    return decorate


class _Command(typer.core.TyperCommand):
    """A command whose option `--relations` may have no value, which typer doesn't support."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Read the arguments, with the value "all" after a bare `--relations`."""
        given = list(args)
        for place, one in enumerate(args):
            named = {*args[place + 1].split(",")} if place + 1 < len(args) else set()
            if one == "--relations" and not named & {ALL_RELATIONS, *RELATION_NAMES}:
                given.insert(place + 1, ALL_RELATIONS)
        parsed: list[str] = super().parse_args(ctx, given)
        return parsed


def refuse_given(context: typer.Context, why: str, *names: str) -> None:
    """Raise `typer.BadParameter` if the user gave an option that would have no effect.

    `why`: the reason, as the start of a sentence.
    `names`: fields of the command's class that have no effect.
    """
    for parameter in context.command.params:
        source = context.get_parameter_source(parameter.name or "")
        if parameter.name in names and source is not None and source.name == "COMMANDLINE":
            what = parameter.opts[0] if parameter.param_type_name == "option" else parameter.metavar
            raise typer.BadParameter(f"{why}. Remove `{what}`")
