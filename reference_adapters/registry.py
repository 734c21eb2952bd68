"""Find engines by name, through the entry points of the group `ghostball.engines`.

A spec names an engine and its settings, as on the command line:
`pymunk:dt=1e-3,contact_steps=exact`. An engine that isn't installed is named by the location of its
function or class: `my_module:simulate`, `my_package:MyEngine:dt=1e-3`.
"""

from __future__ import annotations

import logging
import re
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from difflib import get_close_matches
from functools import cache
from importlib import import_module
from importlib.machinery import PathFinder
from importlib.metadata import EntryPoint, EntryPoints, entry_points
from operator import attrgetter
from types import ModuleType
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

from ghostball.model.errors import storable
from ghostball.reference_adapters.base import EngineError, ReferenceEngine
from ghostball.reference_adapters.function import engine_of
from ghostball.reference_adapters.output import Output, captured, harmless

_LOGGER = logging.getLogger("ghostball.reference_adapters")

GROUP = "ghostball.engines"
"""Entry-point group of engines; see `base`."""

OURS = "ghostball"

_NAMES_OF_STEP = "(time|fixed)?_?step_?(size)?|delta_?t|h"
"""Regular expression of names that other programs give the time step, `dt` here."""

# The members that `ReferenceEngine` requires; a protocol with data members has no `issubclass`.
_REQUIRED = ("Settings", "capabilities", "settings", "unavailable", "simulate")


class EngineUnavailableError(EngineError):
    """A known engine that can't run here; the message says why, and how to install it."""


def engine_names() -> tuple[str, ...]:
    """Return the names of all installed engines, Ghostball's first, without importing them."""
    names = {point.name for point in _points(*sys.path)}
    return tuple(sorted(names, key=lambda name: (name != OURS, name)))


def engine_class(name: str) -> type[ReferenceEngine]:
    """Import an engine, given by its `NAME` or its location `MODULE:NAME`, and return its class.

    Raises `EngineError` if no engine has this name, if two packages provide it, or if an engine has
    the name of Ghostball's engine; `EngineUnavailableError` if its module can't be imported, or the
    object isn't an engine.
    """
    if ":" in name:
        return _class_at(name)
    point = _entry_point(name)
    where = f"can't be imported from `{point.value}`"
    with _guarded(name, where, ". Fix or reinstall that package", point):
        loaded = point.load()
    if callable(loaded) and not isinstance(loaded, type):
        loaded = engine_of(loaded, point.value)
    lacks = _lacks(loaded)
    if lacks:
        raise EngineUnavailableError(
            f"engine `{name}`: `{point.value}`{_package(point)} isn't an engine: {lacks}"
        )
    called = getattr(loaded, "name", None)
    if called != name:  # results, colours and limits depend on this name
        raise EngineUnavailableError(
            f"engine `{name}`: `{point.value}`{_package(point)} has the name {called!r}. "
            "Its `name` must equal its entry point"
        )
    engine: type[ReferenceEngine] = loaded
    return engine


def engine_name(spec: str) -> str:
    """Return the `name` of the engine of a spec, or its location if it can't be imported.

    Raises `EngineError` if the spec is invalid.
    """
    name, _ = parse_spec(spec)
    if ":" not in name:
        return name
    try:
        return engine_class(name).name
    except EngineUnavailableError:
        return name


def parse_spec(spec: str) -> tuple[str, dict[str, str]]:
    """Split a spec into `NAME` or `MODULE:NAME` and its settings, as texts.

    Raises `EngineError` if a piece isn't `key=value`, or a key is given twice.
    """
    name, colon, rest = (part.strip() for part in spec.partition(":"))
    if not name:
        raise EngineError(f"an engine's name must be given, got {spec!r}. {_known_engines()}")
    if names_class(spec):
        attribute, colon, rest = (part.strip() for part in rest.partition(":"))
        name = f"{name}:{attribute}"
    settings: dict[str, str] = {}
    for piece in rest.split(",") if colon else ():
        key, equals, value = (part.strip() for part in piece.partition("="))
        if not (key and equals and value):
            importable = all(part.isidentifier() for part in name.split("."))
            if not importable and name not in engine_names():
                raise EngineError(
                    f"{spec!r}: no engine has the name {name!r}, and no Python module can have it. "
                    "Write `MODULE:FUNCTION`; a module's name has letters, digits and underscores"
                )
            raise EngineError(
                f"a setting must be `key=value`, got {piece!r} in {spec!r}. "
                f"Write `{name}:KEY=VALUE,KEY=VALUE`"
            )
        if key in settings:
            raise EngineError(f"`{key}` must be given once, got it twice in {spec!r}")
        settings[key] = value
    return name, settings


@cache
def _points(*path: str) -> EntryPoints:  # noqa: ARG001 - key of the cache
    """Return the entry points of all packages in the folders of `sys.path`.

    The result is cached, because reading the metadata of all installed packages takes milliseconds,
    as long as a simulation.
    """
    return entry_points(group=GROUP)


def spec_of(name: str, settings: Mapping[str, object]) -> str:
    """Return the spec of an engine, `NAME` or `MODULE:NAME`, with settings; see `parse_spec`."""
    pairs = ",".join(f"{key}={value}" for key, value in settings.items())
    return f"{name}:{pairs}" if pairs else name


def make_engine(spec: str) -> ReferenceEngine:
    """Create the engine named by `spec`, with its settings.

    Parameters
    ----------
    spec : str
        `NAME` or `MODULE:NAME`, optionally followed by `:key=value,...`; each value is converted to
        the type of its setting.

    Raises
    ------
    EngineError
        If the engine is unknown, or a setting is unknown or invalid.
    EngineUnavailableError
        If the engine can't run here.
    """
    name, texts = parse_spec(spec)
    engine = engine_class(name)
    return _create(engine, engine.name, texts)


def names_class(spec: str) -> bool:
    """Return whether a spec gives the location of a function or class, `MODULE:NAME`."""
    module, attribute, *_ = (*(part.strip() for part in spec.split(":")), "")
    parts = (*module.split("."), *attribute.split("."))
    return all(part.isidentifier() for part in parts) and module not in engine_names()


def _class_at(where: str) -> type[ReferenceEngine]:
    module, _, attribute = where.partition(":")
    advice = ". Correct the module, install its package, or put its folder on the path"
    with _guarded(where, "can't be imported", advice):
        there = import_module(module)
    try:
        loaded: Any = attrgetter(attribute)(there)
    except AttributeError:
        engines = _engines_in(there)
        close = get_close_matches(attribute, engines, n=1) or engines[:1]
        hint = (
            f"Did you mean `{module}:{close[0]}`?"
            if close
            else "Name an existing function or class"
        )
        raise EngineUnavailableError(
            f"engine `{where}`: module `{module}` has no {attribute!r}. {hint}"
        ) from None
    if callable(loaded) and not isinstance(loaded, type):
        loaded = engine_of(loaded, where)
    lacks = _lacks(loaded)
    if not lacks and not isinstance(getattr(loaded, "name", None), str):
        lacks = "its `name` must be text"
    if lacks:
        raise EngineUnavailableError(f"`{where}` isn't an engine: {lacks}")
    if loaded.name in engine_names() and loaded is not engine_class(loaded.name):
        raise EngineError(
            f"engine `{where}`: its `name` must not be {loaded.name!r}, the name of an installed "
            "engine, which results, reference results and limits depend on. Rename it"
        )
    engine: type[ReferenceEngine] = loaded
    return engine


def _engines_in(module: ModuleType) -> list[str]:
    """Return the names of possible engines in a module: its own functions, and engine classes."""
    return [
        key
        for key, value in vars(module).items()
        if not key.startswith("_")
        and (
            not _lacks(value)
            if isinstance(value, type)
            else callable(value) and getattr(value, "__module__", "") == module.__name__
        )
    ]


def _lacks(loaded: object) -> str:
    """Return what a loaded object lacks to be an engine; "" if nothing."""
    missing = [member for member in _REQUIRED if not hasattr(loaded, member)]
    if not missing:
        return ""
    named = ", ".join(f"`{member}`" for member in missing)
    return (
        f"it lacks {named}. Start with `class MyEngine(EngineBase)`, from "
        "ghostball.reference_adapters; a plain function of a scene also works"
    )


def _create(engine: type[ReferenceEngine], name: str, texts: Mapping[str, str]) -> ReferenceEngine:
    try:
        settings = engine.Settings.model_validate_strings(_as_decimals(texts, engine.Settings))
    except ValidationError as error:
        raise EngineError(_describe(error, name, engine.Settings)) from None
    with _guarded(name, "failed to report whether it can run here"):
        reason = engine.unavailable()
    if reason is not None:
        raise EngineUnavailableError(f"engine `{name}` is unavailable: {reason}")
    # A protocol can't state the constructor; `base` documents it.
    make: Any = engine
    with _guarded(name, "can't be made"):  # such as an abstract method that it doesn't define
        made: ReferenceEngine = make(settings)
    return made


def _as_decimals(texts: Mapping[str, str], settings: type[BaseModel]) -> dict[str, str]:
    """Return settings as texts, by key; fractions become decimals for float settings."""
    fields = settings.model_fields
    return {
        key: _as_decimal(text) if key in fields and _is_float(fields[key].annotation) else text
        for key, text in texts.items()
    }


def _as_decimal(text: str) -> str:
    """Return a fraction such as 1/60 as a decimal, and any other text unchanged."""
    number = number_of(text) if "/" in text else None
    return text if number is None else repr(number)


def _is_float(annotation: object) -> bool:
    """Return True if an annotation is `float`, or a union that contains it."""
    return annotation is float or any(map(_is_float, get_args(annotation)))


def number_of(text: str) -> float | None:
    """Return the value of a decimal or a fraction; None for any other text.

    A fraction is two decimals, such as 1/60, and its value is the quotient of two doubles.
    """
    above, slash, below = text.partition("/")
    try:
        return float(above) / float(below) if slash else float(above)
    except (ValueError, ZeroDivisionError):
        return None


@contextmanager
def _guarded(
    name: str, cannot: str, advice: str = "", point: EntryPoint | None = None
) -> Iterator[None]:
    """Run code of an engine; log what it prints; if it raises, name the engine and its package.

    Foreign code may raise any exception, and may even exit.
    """
    output = Output()  # defined even if Ctrl-C comes before the block starts
    # Ghostball's engine prints nothing, but may compile kernels, which is logged.
    capturing = nullcontext(output) if name == OURS else captured(errors=True)
    try:
        with capturing as output:
            yield
    except (Exception, SystemExit) as error:
        what = f"{cannot}{_package(point)}: {type(error).__name__}: {error}{advice}"
        raise EngineUnavailableError(storable(f"engine `{name}` {what}")) from error
    finally:
        if output.text:
            _LOGGER.warning("engine %s printed: %s", name, harmless(output.text))


def known_settings(settings: type[BaseModel]) -> dict[str, Any]:
    """Return the default of each setting, by name."""
    return {
        name: field.get_default(call_default_factory=True, validated_data={})
        for name, field in settings.model_fields.items()
    }


def _entry_point(name: str) -> EntryPoint:
    """Return the entry point with a name, which must be unique."""
    points = {point.value: point for point in _points(*sys.path).select(name=name)}
    if not points:
        close = get_close_matches(name, engine_names(), n=1)
        hint = f"Did you mean `{close[0]}`? " if close else ""
        module = name.removesuffix(".py").replace("/", ".")
        if name.endswith(".py") or (name.isidentifier() and PathFinder.find_spec(name)):
            hint = f"Name the function or class in that file, such as `{module}:simulate`. "
        raise EngineError(f"unknown engine {name!r}. {hint}{_known_engines()}")
    if len(points) > 1:
        raise EngineError(
            f"engine `{name}` is provided by two packages: {', '.join(sorted(points))}. "
            "Uninstall one of them"
        )
    return next(iter(points.values()))


def _package(point: EntryPoint | None) -> str:
    """Return the package of an entry point, for a message; this reads the metadata."""
    return f" of package `{point.dist.name}`" if point is not None and point.dist else ""


def _known_engines() -> str:
    return f"Known engines: {', '.join(engine_names())}"


def _describe(error: ValidationError, name: str, settings: type[BaseModel]) -> str:
    defaults = known_settings(settings)
    lines = [_sentence(problem, name, defaults) for problem in error.errors()]
    listed = ", ".join(
        f"{key} unset" if value is None else f"{key}={value}" for key, value in defaults.items()
    )
    return "\n".join(
        [*lines, f"Settings of engine `{name}` and their defaults: {listed or 'none'}"]
    )


def _sentence(problem: Mapping[str, Any], name: str, defaults: Mapping[str, Any]) -> str:
    field = ".".join(str(part) for part in problem["loc"][:1])
    if problem["type"] == "extra_forbidden":
        is_step = "dt" in defaults and re.fullmatch(_NAMES_OF_STEP, field, re.IGNORECASE)
        if is_step:
            hint = ". The time step is `dt` [s]"
        else:
            close = get_close_matches(field, defaults, n=1)
            hint = f". Did you mean `{close[0]}`?" if close else ""
        return f"`{field}` is not a setting of engine `{name}`, got {problem['input']!r}{hint}"
    message = str(problem["msg"]).removeprefix("Value error, ")
    rule = message.replace("Input should", "must", 1)
    if not field:  # a rule about several settings names them itself
        return f"engine `{name}`: {rule}"
    return f"`{field}` of engine `{name}` {rule}, got {problem['input']!r}"
