"""Changes of a page by MkDocs, before the page is rendered."""

import re
from typing import Any

_HIDDEN = re.compile(r"^<!--\n(:::.*?)\n-->$", re.MULTILINE | re.DOTALL)

WIDE = ("leaderboard.md", "steps.md", "inside.md", "engines/", "findings/")
"""Beginnings of the paths of pages whose tables or programs need the width of the contents."""


def on_page_markdown(markdown: str, *, page: Any, **_: Any) -> str:
    """Uncover instructions for mkdocstrings, and hide the table of contents of wide pages."""
    if page.file.src_uri.startswith(WIDE):
        page.meta["hide"] = ["toc"]
    return _HIDDEN.sub(r"\1", markdown)
