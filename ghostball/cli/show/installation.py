"""What `ghostball engines --check` looks at: packages, compiled kernels, engines and scenes."""

from __future__ import annotations

import enum
import platform
import re
import sys
from collections.abc import Callable, Iterator
from importlib.metadata import PackageNotFoundError, requires, version
from importlib.util import find_spec
from typing import NamedTuple

from rich import box
from rich.markup import escape
from rich.table import Table

from ghostball.cli.shared.options import processor_count
from ghostball.cli.shared.terminal import say, stdout
from ghostball.engine.library import cache, shipped
from ghostball.engine.library.entry import COMPILED
from ghostball.model import GhostballError
from ghostball.model.cache_folder import cache_folder
from ghostball.reference_adapters import EngineError, engine_class, engine_names
from ghostball.validation.exit_status import ExitStatus
from ghostball.validation.results.environment import cpu_name
from ghostball.validation.scenes import library

DISTRIBUTION = "ghostball"


class State(enum.Enum):
    """What a finding means; the value is how it is shown."""

    GOOD = "[green]ok[/]"
    NOTE = "[yellow]note[/]"
    BROKEN = "[bold red]broken[/]"


class Finding(NamedTuple):
    """One line of the examination."""

    subject: str
    state: State
    detail: str


def check_installation() -> ExitStatus:
    """Print a table of all findings, and return whether none is broken."""
    findings = [finding for check in CHECKS for finding in check()]
    table = Table(box=box.SIMPLE_HEAD, show_header=False)
    table.add_column("subject", no_wrap=True)
    table.add_column("state", no_wrap=True)
    table.add_column("detail", overflow="fold")
    for finding in findings:
        table.add_row(escape(finding.subject), finding.state.value, escape(finding.detail))
    stdout().print(table)
    if any(finding.state is State.BROKEN for finding in findings):
        say("[bold red]The installation is broken;[/] see above.")
        return ExitStatus.CHECK_FAILED
    return ExitStatus.PASSED


def _python() -> Iterator[Finding]:
    yield Finding("python", State.GOOD, f"{platform.python_version()} at {sys.executable}")
    machine = f"{platform.platform()}, {cpu_name()}, {processor_count()} cores"
    yield Finding("machine", State.GOOD, machine)


def _versions() -> Iterator[Finding]:
    yield Finding(DISTRIBUTION, State.GOOD, version(DISTRIBUTION))
    for requirement in requires(DISTRIBUTION) or ():
        name = re.match(r"[\w.-]+", requirement)
        if name is None or "extra ==" in requirement:
            continue
        try:
            yield Finding(name[0], State.GOOD, version(name[0]))
        except PackageNotFoundError:
            marker = requirement.partition(";")[2].strip()
            if marker:  # asked for on some machines only; `_engines` says what lacks without it
                yield Finding(name[0], State.NOTE, f"not installed (needed if {marker})")
            else:
                yield Finding(name[0], State.BROKEN, "not installed. Run `pip install ghostball`")


def _kernels() -> Iterator[Finding]:
    if not COMPILED:
        yield Finding("kernels", State.NOTE, "interpreted: NUMBA_DISABLE_JIT is set; runs are slow")
        return
    files = shipped.files()  # where it sets some aside, a message says why
    if files:
        yield Finding("kernels", State.GOOD, f"{len(files)} compiled kernels came with Ghostball")
        return
    if find_spec("numba") is None:
        detail = (
            "none that came with Ghostball fits here, and no compiler is installed. Run `pip "
            "install '.[compiler]'` in a clone of Ghostball"
        )
        yield Finding("kernels", State.BROKEN, detail)
        return
    directory = cache.directory()
    if directory is None:
        yield Finding(
            "kernels",
            State.BROKEN,
            f"{cache_folder('libraries')}: not writable, so every run compiles again. Set "
            "GHOSTBALL_CACHE_DIR to a writable folder",
        )
        return
    kept = [path for path in directory.iterdir() if path.suffix in {".so", ".o"}]
    size = sum(path.stat().st_size for path in kept)
    detail = (
        f"compiled when they are first needed; {len(kept)}, {size / 1e6:.1f} MB, in {directory}"
    )
    yield Finding("kernels", State.GOOD, detail)


def _engines() -> Iterator[Finding]:
    for name in engine_names():
        try:
            reason = engine_class(name).unavailable()
        except EngineError as error:
            yield Finding(f"engine {name}", State.BROKEN, str(error))
        else:
            state = State.GOOD if reason is None else State.NOTE
            yield Finding(f"engine {name}", state, reason or "available")


def _scenes() -> Iterator[Finding]:
    names = library.scene_names()
    broken = list(_broken_scenes(names))
    yield from broken
    if not names:
        yield Finding("scenes", State.BROKEN, f"none in {library.FOLDER}. Install ghostball again")
    elif not broken:
        yield Finding("scenes", State.GOOD, f"{len(names)} shipped, all readable")


def _broken_scenes(names: tuple[str, ...]) -> Iterator[Finding]:
    for name in names:
        try:
            library.find_scene(name)
        except GhostballError as error:
            yield Finding(f"scene {name}", State.BROKEN, str(error))


CHECKS: tuple[Callable[[], Iterator[Finding]], ...] = (
    _python,
    _versions,
    _kernels,
    _engines,
    _scenes,
)
