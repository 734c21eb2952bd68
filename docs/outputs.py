"""Write the output of each block of a page beneath the block: `python -m docs.outputs [--check]`.

A block is a comment of the page, so a forge and the site show only its output:

    <!-- run python
    from docs import tables

    print(tables.metrics())
    -->

    (the output: Markdown, or with `as=LANGUAGE` behind `python` a code block)

    <!-- end -->

`run shell` runs commands instead, in `build/docs/FOLDER` with `in=FOLDER`, and expects the exit
status of `exit=N`. With `as=console` the commands are shown, too, except lines that end in
`# hide`. An output that differs from the last one only in durations is not rewritten. A picture
that a program draws is written, or checked, with the pages.

A page that has passed is not run again until the page, or a file or package that its blocks may
read, changes. `--rerun` runs all pages.

cog (cogapp) would still need our code for exit statuses, durations, hidden lines and prompts. Each
shell block would become a quoted argument of a Python call, and a page that doesn't exist ends cog
with a traceback.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Sequence
from contextlib import redirect_stdout
from functools import partial
from hashlib import sha256
from importlib.metadata import distributions
from io import StringIO
from pathlib import Path

from docs import drawings

DOCS = Path(__file__).resolve().parent
BUILD = DOCS.parent / "build" / "docs"

PICTURE = DOCS / "side-pocket.svg"
"""Drawn by `docs.drawings`."""

CHECKED = BUILD / "checked.json"
"""For each page that has passed: a hash of everything that its blocks may read."""

READ = ("benchmarks", "docs", "engine", "ghostball", "reference_adapters", "reports", "validation")
"""Folders that blocks may read; other pages excepted."""

_BLOCK = re.compile(
    r"^(?P<head><!-- run (?P<kind>python|shell)(?P<options>[^\n]*)\n(?P<code>.*?)\n-->\n)"
    r"(?P<output>.*?)(?P<end>^<!-- end -->$)",
    re.MULTILINE | re.DOTALL,
)
_DURATION = re.compile(r"\d[\d.]*\s?(?:ns|µs|ms|s|min)\b")
_PROGRESS = re.compile(
    r"^(?:compiling(?: the engine's| \(step|:)|running \(step|certifying scene) .*\n", re.MULTILINE
)
"""Lines that commands print only on a slow machine, or while the engine compiles."""
_SPACE = re.compile(r"[ ─]+")
HIDE = "# hide"


class OutputError(Exception):
    """A block that can't be run, or a page that shows other outputs than its blocks print."""


def write_outputs(pages: Sequence[Path], *, check: bool) -> None:
    """Run the blocks of pages and write their outputs beneath them; or check the outputs."""
    if missing := [str(page) for page in pages if not page.is_file()]:
        raise OutputError(
            f"a page must be a file in {DOCS.name}/, named by its path in that folder; these files "
            f"don't exist: {', '.join(missing)}"
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
            f"blocks print something else than the pages show: {', '.join(stale)}. "
            "`make docs-outputs` writes the new outputs: look at the difference, and commit it"
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
    # Commands print durations, with units that differ from run to run; tables print none.
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
        # In a CI, pytest shortens no line and would print other lines.
        env={name: value for name, value in os.environ.items() if name != "CI"},
    )
    if ran.returncode != status:
        raise OutputError(f"{where}: ended with {ran.returncode}, expected {status}:\n{ran.stdout}")
    return _PROGRESS.sub("", ran.stdout)


def _masked(output: str) -> str:
    return _SPACE.sub(" ", _DURATION.sub("", output))


def _inputs() -> str:
    """Return a hash of all files and packages that blocks may read."""
    root = DOCS.parent
    files = [root / "pyproject.toml", root / "SECURITY.md"]
    for folder in READ:
        files += (
            path
            for path in sorted((root / folder).rglob("*"))
            if path.is_file() and path.suffix not in (".md", ".pyc", ".png")
        )
    found = sha256(f"{sys.version} {os.environ.get('COLUMNS')}".encode())
    for one in sorted(f"{one.name} {one.version}" for one in distributions()):
        found.update(one.encode())
    for path in files:
        found.update(f"{path}\0".encode() + path.read_bytes())
    return found.hexdigest()


def _main(arguments: Sequence[str]) -> None:
    options = {"--check", "--rerun"}.intersection(arguments)
    named = [one for one in arguments if one not in options]
    chosen = [DOCS / name for name in named] or [*sorted(DOCS.rglob("*.md")), PICTURE]
    passed: dict[str, str] = {}
    if CHECKED.is_file() and "--rerun" not in options:
        passed = json.loads(CHECKED.read_text(encoding="utf-8"))
    inputs = _inputs()
    errors: list[str] = []

    def state_of(page: Path) -> str:
        return sha256(inputs.encode() + page.read_bytes()).hexdigest()

    for page in chosen:
        name = str(page.relative_to(DOCS))
        if page.is_file() and passed.get(name) == state_of(page):
            continue
        try:
            write_outputs([page], check="--check" in options)
        except OutputError as error:
            errors.append(f"error: {error}")
        else:
            passed[name] = state_of(page)
            BUILD.mkdir(parents=True, exist_ok=True)
            CHECKED.write_text(json.dumps(passed, indent=1), encoding="utf-8")
    if errors:
        sys.exit("\n".join(errors))


if __name__ == "__main__":
    _main(sys.argv[1:])
