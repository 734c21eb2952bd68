"""`ghostball engines --check`: check packages, compiled kernels, engines and scenes."""

from __future__ import annotations

import platform
import re
import sys
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, requires, version
from importlib.util import find_spec

from rich import box
from rich.markup import escape
from rich.table import Table

from ghostball.cli.options import processor_count
from ghostball.cli.shared.terminal import say, stdout
from ghostball.engine.library import cache, shipped
from ghostball.engine.library.entry import COMPILED
from ghostball.model import GhostballError
from ghostball.model.cache_folder import cache_folder
from ghostball.reference_adapters import EngineError, engine_class, engine_names
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.results.environment import cpu_name
from ghostball.validation.scenes import library

GOOD, NOTE, BROKEN = "[green]ok[/]", "[yellow]note[/]", "[bold red]broken[/]"
"""States of a checked item, in rich's markup."""

CheckedItem = tuple[str, str, str]
"""One line of the table: subject, state, detail."""


def check_installation() -> ExitStatus:
    """Print a table of all checked items, and return the exit status."""
    found = [*_python(), *_versions(), _kernels(), *_engines(), *_scenes()]
    table = Table(box=box.SIMPLE_HEAD, show_header=False)
    table.add_column("subject", no_wrap=True)
    table.add_column("state", no_wrap=True)
    table.add_column("detail", overflow="fold")
    for subject, state, detail in found:
        table.add_row(escape(subject), state, escape(detail))
    stdout().print(table)
    if any(state is BROKEN for _, state, _ in found):
        say("[bold red]The installation is broken;[/] see above.")
        return ExitStatus.CHECK_FAILED
    return ExitStatus.PASSED


def _python() -> Iterator[CheckedItem]:
    yield "python", GOOD, f"{platform.python_version()} at {sys.executable}"
    yield "machine", GOOD, f"{platform.platform()}, {cpu_name()}, {processor_count()} cores"


def _versions() -> Iterator[CheckedItem]:
    yield "ghostball", GOOD, version("ghostball")
    for needed in requires("ghostball") or ():
        name, marker = re.split(r"[^\w.-]", needed)[0], needed.partition(";")[2].strip()
        if "extra ==" in marker:
            continue
        try:
            yield name, GOOD, version(name)
        except PackageNotFoundError:
            if marker:  # needed on some platforms only; `_engines` shows what is missing
                yield name, NOTE, f"not installed (needed if {marker})"
            else:
                yield name, BROKEN, "not installed. Run `pip install ghostball`"


def _kernels() -> CheckedItem:
    if not COMPILED:
        return "kernels", NOTE, "interpreted: NUMBA_DISABLE_JIT is set; runs are slow"
    if files := shipped.files():  # logs a message if some don't fit
        return "kernels", GOOD, f"{len(files)} compiled kernels came with Ghostball"
    if find_spec("numba") is None:
        detail = (
            "no kernel that came with Ghostball fits this machine, and no compiler is installed. "
            "Run `pip install '.[compiler]'` in a clone of Ghostball"
        )
        return "kernels", BROKEN, detail
    directory = cache.directory()
    if directory is None:
        detail = (
            f"{cache_folder('libraries')}: not writable, so every run compiles again. Set "
            "GHOSTBALL_CACHE_DIR to a writable folder"
        )
        return "kernels", BROKEN, detail
    kept = [path for path in directory.iterdir() if path.suffix in {".so", ".o"}]
    size = sum(path.stat().st_size for path in kept)
    detail = f"compiled when first needed; {len(kept)} files, {size / 1e6:.1f} MB, in {directory}"
    return "kernels", GOOD, detail


def _engines() -> Iterator[CheckedItem]:
    for name in engine_names():
        try:
            reason = engine_class(name).unavailable()
        except EngineError as error:
            yield f"engine {name}", BROKEN, str(error)
        else:
            yield f"engine {name}", GOOD if reason is None else NOTE, reason or "available"


def _scenes() -> Iterator[CheckedItem]:
    names = library.scene_names()
    broken = 0
    for name in names:
        try:
            library.find_scene(name)
        except GhostballError as error:
            broken += 1
            yield f"scene {name}", BROKEN, str(error)
    if not names:
        yield "scenes", BROKEN, f"none in {library.FOLDER}. Install ghostball again"
    elif not broken:
        yield "scenes", GOOD, f"{len(names)} shipped, with those of the board; all readable"
