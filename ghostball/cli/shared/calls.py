"""How a command is declared: a class of its options, and the module that does what they ask.

Nothing heavy is imported here: `ghostball --help` must not wait for numpy and the engines.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from importlib import import_module
from typing import Any, TypeVar, get_type_hints

import typer

T = TypeVar("T")


def command(app: typer.Typer, module: str) -> Callable[[type[T]], type[T]]:
    """Make a command of a dataclass: its fields are the options, its docstring is the help.

    `module`: of `ghostball.cli`; its last part is the command's name. Its function `run` is called
        with the options, and returns the exit status. It is imported when the command is called.
    """

    def decorate(options: type[T]) -> type[T]:
        def call(**given: Any) -> None:
            from ghostball.cli.shared.terminal import in_a_command  # noqa: PLC0415 - heavy

            with in_a_command():
                does: Any = import_module(f"ghostball.cli.{module}")
                raise typer.Exit(does.run(options(**given)))

        hints = get_type_hints(options, include_extras=True)
        declared = inspect.signature(options).parameters.values()
        fields = [one.replace(annotation=hints[one.name]) for one in declared]
        call.__signature__ = inspect.Signature(fields)  # type: ignore[attr-defined]
        call.__doc__ = inspect.getdoc(options)
        app.command(module.rpartition(".")[2])(call)
        return options

    return decorate


def refuse_given(context: typer.Context, why: str, *names: str) -> None:
    """Refuse options that were given, although they would do nothing.

    `why`: the reason, as the start of a sentence.
    `names`: the fields of the command's class.
    """
    for parameter in context.command.params:
        source = context.get_parameter_source(parameter.name or "")
        if parameter.name in names and source is not None and source.name == "COMMANDLINE":
            what = parameter.opts[0] if parameter.param_type_name == "option" else parameter.metavar
            raise typer.BadParameter(f"{why}. Remove `{what}`")
