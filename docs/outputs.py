"""What the blocks of a page print, written beneath them: `python -m docs.outputs [--check]`.

A block is a comment of the page, so that both a forge and the site show its output alone:

    <!-- run python
    from docs import tables

    print(tables.metrics())
    -->

    (the output: Markdown, or with `as=LANGUAGE` behind `python` a code block)

    <!-- end -->

`run shell` runs commands instead, in `build/docs/FOLDER` with `in=FOLDER`, and expects the exit
status of `exit=N`. With `as=console` the commands are shown, too, but for lines that end in
`# hide`. Where what commands print differs from the last output in durations alone, it is left as
it is. The picture that a program draws is written, or checked, with the pages.

cog (cogapp) would still need our code for exit statuses, durations, hidden lines and prompts. Each
shell block would become a quoted argument of a Python call, and a page that doesn't exist ends cog
with a traceback.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Sequence
from contextlib import redirect_stdout
from functools import partial
from io import StringIO
from pathlib import Path

from docs import drawings

DOCS = Path(__file__).resolve().parent
BUILD = DOCS.parent / "build" / "docs"

PICTURE = DOCS / "side-pocket.svg"
"""Drawn by `docs.drawings`."""

_BLOCK = re.compile(
    r"^(?P<head><!-- run (?P<kind>python|shell)(?P<options>[^\n]*)\n(?P<code>.*?)\n-->\n)"
    r"(?P<output>.*?)(?P<end>^<!-- end -->$)",
    re.MULTILINE | re.DOTALL,
)
_DURATION = re.compile(r"\d[\d.]*\s?(?:ns|µs|ms|s|min)\b")
_PROGRESS = re.compile(
    r"^(?:compiling the engine's|running \(step|proving scene) .*\n", re.MULTILINE
)
"""What commands say on a machine that is slow, or that compiles first."""
_SPACE = re.compile(r"[ ─]+")
HIDE = "# hide"


class OutputError(Exception):
    """A block that can't be run, or a page whose outputs aren't those of its blocks."""


def write_outputs(pages: Sequence[Path], *, check: bool) -> None:
    """Run the blocks of pages and write what they print beneath them; or check that it is there."""
    if missing := [str(page) for page in pages if not page.is_file()]:
        raise OutputError(
            f"a page must be a file of {DOCS.name}/, named from there: no {', '.join(missing)}"
        )
    stale = []
    for page in pages:
        old = page.read_text(encoding="utf-8")
        if page == PICTURE:
            new = drawings.side_pocket() + "\n"
        else:
            new = _BLOCK.sub(partial(_with_output, page.name), old)
        if new != old:
            stale.append(page.name)
            if not check:
                page.write_text(new, encoding="utf-8")
    if check and stale:
        raise OutputError(
            f"what blocks print isn't what stands in docs/: {', '.join(stale)}. "
            "`make docs-outputs` writes it anew: look at the difference, and commit it"
        )


def _with_output(page: str, block: re.Match[str]) -> str:
    options = dict(one.split("=", 1) for one in block["options"].split())
    code, shown_as = block["code"], options.get("as", "")
    if block["kind"] == "python":
        text = _printed(code)
    else:
        where = f"{page}, block {code.splitlines()[-1]!r}"
        text = _run(code, options.get("in", ""), int(options.get("exit", 0)), where)
    if shown_as == "console":
        lines = [line for line in code.splitlines() if not line.endswith(HIDE)]
        text = "\n".join(f"$ {line}" for line in lines) + f"\n{text}"
    text = "\n".join(line.rstrip() for line in text.strip("\n").splitlines())
    if shown_as:
        text = f"```{shown_as}\n{text}\n```"
    output = f"\n{text}\n\n" if text else ""
    # What commands print has durations in it, of which the units differ, too; tables have not.
    if block["kind"] == "shell" and _masked(output) == _masked(block["output"]):
        output = block["output"]
    return f"{block['head']}{output}{block['end']}"


def _printed(code: str) -> str:
    printed = StringIO()
    with redirect_stdout(printed):
        exec(code, {"__name__": "docs"})
    return printed.getvalue()


def _run(code: str, folder: str, status: int, where: str) -> str:
    ran = subprocess.run(
        ["bash", "-c", code],
        cwd=BUILD / folder if folder else DOCS.parent,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
        # Where pytest takes this for a CI it shortens no line, and would print other ones.
        env={name: value for name, value in os.environ.items() if name != "CI"},
    )
    if ran.returncode != status:
        raise OutputError(f"{where}: ended with {ran.returncode}, expected {status}:\n{ran.stdout}")
    return _PROGRESS.sub("", ran.stdout)


def _masked(output: str) -> str:
    return _SPACE.sub(" ", _DURATION.sub("", output))


if __name__ == "__main__":
    named = [one for one in sys.argv[1:] if one != "--check"]
    chosen = [DOCS / name for name in named] or [*sorted(DOCS.rglob("*.md")), PICTURE]
    try:
        write_outputs(chosen, check="--check" in sys.argv)
    except OutputError as error:
        sys.exit(f"error: {error}")
