"""What MkDocs does with a page before it is rendered."""

import re
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))  # of `docs` and `benchmarks`

from docs.engine_pages import coloured
from docs.replay_pages import write_pages

_HIDDEN = re.compile(r"^<!--\n(:::.*?)\n-->$", re.MULTILINE | re.DOTALL)


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Show what mkdocstrings is asked for: on a forge, which has no mkdocstrings, it is hidden."""
    return _HIDDEN.sub(r"\1", markdown)


def on_page_content(html: str, page: Any, **_: Any) -> str:
    """Colour the board, where it is."""
    return coloured(html) if page.file.src_uri == "leaderboard.md" else html


def on_post_build(config: Any) -> None:
    """Write the pages that cells of the board lead to."""
    write_pages(Path(config.site_dir))
