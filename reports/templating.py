"""Templates beside a package: its `templates/`, in which a value that is missing is an error."""

from __future__ import annotations

from functools import cache

from jinja2 import Environment, PackageLoader, StrictUndefined


@cache
def templates_of(package: str, *, escaped: bool = True) -> Environment:
    """Return the templates of a package; `escaped`: no value becomes markup."""
    return Environment(
        loader=PackageLoader(package),
        autoescape=escaped,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
