"""What MkDocs does with a page before it is rendered."""

import re
from typing import Any

_HIDDEN = re.compile(r"^<!--\n(:::.*?)\n-->$", re.MULTILINE | re.DOTALL)


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Show what mkdocstrings is asked for: on a forge, which has no mkdocstrings, it is hidden."""
    return _HIDDEN.sub(r"\1", markdown)
