"""Load templates from the folder `templates/` of a package; a missing value is an error."""

from __future__ import annotations

from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined


@cache
def templates_of(package: str, *, escaped: bool = True) -> Environment:
    """Return the templates of a package; `escaped`: whether values are escaped for HTML."""
    return Environment(
        loader=PackageLoader(package),
        autoescape=escaped,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
