"""Read the capabilities of engines from the file `capabilities.toml` next to their modules.

    [pymunk.tuned]
    ROLLING = "exact"
    SLIDING = "approximate: the adapter applies the cloth friction between Pymunk's time steps"
    AIR_DRAG = "none: Pymunk damps in proportion to speed, not to its square"

    [pymunk.naive]
    OPEN_SIDES = "approximate: cushions end at the table's corners"

The first configuration of an engine, here "tuned", must list every member of `Feature`, so that
nothing is exact by default. Any other configuration lists the features that it supports
differently. The text after the colon describes the support, or says why there is none; "exact"
needs no text.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Any, get_args, get_type_hints

from ghostball.model.features import Capabilities, Capability, Feature
from ghostball.reference_adapters.base import EngineError

FILE = "capabilities.toml"

ByConfiguration = Mapping[str, Capabilities]
"""Capabilities of an engine, by the name of a configuration."""

_SUPPORTS: tuple[Any, ...] = get_args(get_type_hints(Capability)["support"])
_NAMES = [feature.name for feature in Feature]


def capabilities_beside(module: str, engine: str) -> ByConfiguration:
    """Return the capabilities of an engine, by configuration; each lists all features in order.

    `module`: path of the engine's module, `__file__`; the file is read from its folder.
    `engine`: name of the engine in the file.

    Raises `EngineError` if the file can't be read or breaks a rule of this module; the message
    names the file, the configuration, the rule, the value and the remedy.
    """
    path = Path(module).with_name(FILE)
    try:
        said = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise EngineError(f"{path} can't be read: {error}") from None
    configurations = said.get(engine)
    if not isinstance(configurations, Mapping) or not configurations:
        raise EngineError(
            f"{path} must have a table `[{engine}.CONFIGURATION]`, got "
            f"{', '.join(said) or 'an empty file'}"
        )
    found: dict[str, Capabilities] = {}
    first: Capabilities = {}
    for name, features in configurations.items():
        where = f"{path}, [{engine}.{name}]"
        if not isinstance(features, Mapping):
            raise EngineError(f"{where} must be a table of features, got {features!r:.80}")
        known = {**first, **dict(_read(key, text, where) for key, text in features.items())}
        if lacks := [feature.name for feature in Feature if feature not in known]:
            raise EngineError(
                f"{where} must have every feature, but lacks {', '.join(lacks)}. Describe how each "
                'is supported, or write "none: " and the reason'
            )
        found[name] = {feature: known[feature] for feature in Feature}
        first = first or found[name]
    return found


def _read(key: str, text: object, where: str) -> tuple[Feature, Capability]:
    """Return a feature and its capability; messages call the location `where`."""
    if key not in _NAMES:
        close = get_close_matches(key.upper(), _NAMES, n=1)
        hint = f"Did you mean `{close[0]}`?" if close else f"There are {', '.join(_NAMES)}"
        raise EngineError(f"{where}: `{key}` is not a member of `Feature`. {hint}")
    support: Any  # one of the texts of a `Literal`, once it is checked
    support, _, how = (part.strip() for part in str(text).partition(":"))
    if not isinstance(text, str) or support not in _SUPPORTS:
        raise EngineError(
            f'{where}: `{key}` must be "exact", or start with "approximate: " or "none: ", got '
            f"{text!r:.80}"
        )
    if support != "exact" and not how:
        raise EngineError(
            f"{where}: `{key}` must say {'why not' if support == 'none' else 'how'} after "
            f'"{support}: ", got {text!r}'
        )
    return Feature[key], Capability(support, how)
