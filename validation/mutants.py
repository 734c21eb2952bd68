"""Our code with a bug planted in it, to see that what should catch bugs does.

    >>> with planted(Mutation(...)) as mutant:
    ...     runs = mutant.run([scene])

The package `engine`, and the one that a bug is planted in where that is another, are copied into a
temporary folder, one text of one file is replaced, and shots run there in a process of their own,
with interpreted kernels: the caller's engine, the checkout and the kernels that are kept on the
disk stay as they are.
"""

from __future__ import annotations

import importlib
import os
import pickle
import shutil
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import engine
from engine import GhostballError, Record, Result, Scene

_SOURCES = Path(engine.__file__).parent.parent
"""Where our packages lie, side by side."""

MAX_EVENTS = 20_000
"""Events after which a shot of a mutant is given up: a bug may make it go on for ever."""

START_LIMIT = 120.0
"""How long the process of a mutant may take to start [s]: minutes pass on a busy machine."""

_PROGRAM = """\
import pickle, sys
from pathlib import Path
folder, place = sys.argv[1:]
import engine
from validation.mutants import check_copies
check_copies(Path(folder))
scenes, record, max_events = pickle.loads(Path(place, "asked").read_bytes())
print("ready", flush=True)
for number, text in scenes:
    try:
        scene = engine.Scene.model_validate_json(text)
        run = engine.simulate(scene, record=record, max_events=max_events)
    except Exception as error:
        run = f"{type(error).__name__}: {error}"
    Path(place, str(number)).write_bytes(pickle.dumps(run))
    print(number, flush=True)
"""


class MutantError(GhostballError):
    """A mutation that doesn't fit the engine, or a mutant that can't be imported."""


@dataclass(frozen=True)
class Mutation:
    """One bug.

    Attributes
    ----------
    name : str
    file : str
        Within the package, such as "motion/on_cloth.py" or "impacts/laws/cushion_han2005.py".
    old, new : str
        What is replaced, exactly one occurrence, and by what.
    what : str
        What is wrong then, one sentence.
    package : str
        The package that it is planted in: the engine, or what the engine is judged by.
    """

    name: str
    file: str
    old: str
    new: str
    what: str
    package: str = "engine"

    def apply(self, folder: Path) -> None:
        """Plant the bug in the copy of its package in a folder.

        Raises
        ------
        MutantError
            Where the text isn't there exactly once, or is replaced by itself.
        """
        path = folder / self.package / self.file
        try:
            text = path.read_text(encoding="utf-8")
        except OSError as error:
            raise MutantError(
                f'mutation "{self.name}": `file` must be one of the package `{self.package}`, got '
                f"{self.file!r}: {error.strerror}. Adapt the mutation"
            ) from None
        found = text.count(self.old)
        if found != 1 or self.old == self.new:
            raise MutantError(
                f'mutation "{self.name}": `old` must be in {self.file} exactly once and differ '
                f"from `new`, found {found} times: {self.old!r}. Adapt the mutation"
            )
        path.write_text(text.replace(self.old, self.new), encoding="utf-8")
        # The bytecode of all other modules is copied with them, and saves their compilation.
        for compiled in path.parent.glob(f"__pycache__/{path.stem}.*.pyc"):
            compiled.unlink()


def check_copies(folder: Path) -> None:
    """Make sure that each package in a folder is the one that is imported.

    Raises
    ------
    ImportError
        Where another one is: it would be taken for the mutant.
    """
    for package in folder.glob("*/__init__.py"):
        found = importlib.import_module(package.parent.name).__file__
        if found is None or not Path(found).samefile(package):
            raise ImportError(f"not the mutant: {found}")


@dataclass(frozen=True)
class Crash:
    """A shot of a mutant that raised, hung or killed its process."""

    reason: str


@dataclass(frozen=True)
class Mutant:
    """A copy of our engine in a folder of its own."""

    name: str
    folder: Path

    def run(
        self,
        scenes: Sequence[Scene],
        *,
        record: Record = "trajectory",
        max_events: int = MAX_EVENTS,
        timeout: float = 60.0,
    ) -> list[Result | Crash]:
        """Run shots in a process of their own.

        Parameters
        ----------
        scenes : sequence of Scene
            Small ones: the kernels are interpreted, some milliseconds for an event.
        record : "rest", "events" or "trajectory"
        max_events : int
            Events after which a shot is given up.
        timeout : float [s]
            For each of them; a shot without an answer until then is a `Crash`. The start of a
            process doesn't count.

        Raises
        ------
        MutantError
            Where the engine can't even be imported.
        """
        runs: list[Result | Crash] = []
        texts = list(enumerate(scene.model_dump_json(by_alias=True) for scene in scenes))
        with tempfile.TemporaryDirectory(dir=self.folder) as place:
            while len(runs) < len(scenes):  # again where one shot ended the process
                asked = pickle.dumps((texts[len(runs) :], record, max_events))
                Path(place, "asked").write_bytes(asked)
                end = self._serve(Path(place), timeout)
                while (answer := Path(place, str(len(runs)))).exists():
                    run: Result | str = pickle.loads(answer.read_bytes())
                    runs.append(Crash(run) if isinstance(run, str) else run)
                    answer.unlink()
                if len(runs) < len(scenes):
                    runs.append(Crash(end))
        return runs

    def _serve(self, place: Path, timeout: float) -> str:
        """Run the process until it ends, or a shot takes too long; return how it ended."""
        command = [sys.executable, "-c", _PROGRAM, str(self.folder), str(place)]
        hung = threading.Event()
        answered = False
        limit = START_LIMIT
        with (
            tempfile.TemporaryFile(mode="w+") as messages,
            subprocess.Popen(
                command,
                cwd=self.folder,  # which python looks into first
                env=self.environment,
                stdout=subprocess.PIPE,
                stderr=messages,
                text=True,
            ) as process,
        ):

            def give_up() -> None:
                hung.set()
                process.kill()

            assert process.stdout is not None
            try:
                while True:
                    watch = threading.Timer(limit, give_up)
                    watch.start()
                    try:
                        line = process.stdout.readline()
                    finally:
                        watch.cancel()
                    if not line:
                        break
                    answered, limit = True, timeout
            finally:
                process.kill()
            code = process.wait()
            messages.seek(0)
            said = (messages.read().strip().splitlines() or ["no message"])[-1]
        how = f"no answer in {limit:g} s" if hung.is_set() else f"exit code {code}: {said}"
        if not answered:
            raise MutantError(
                f'mutant "{self.name}" can\'t be imported: {how}. Mend the mutation: it should '
                "play shots wrongly, not break a module"
            )
        return how

    @property
    def environment(self) -> dict[str, str]:
        """What a process needs in its environment, so that `engine` is the mutant there.

        Its working directory must be the mutant's folder, where python looks first.
        """
        paths = [str(self.folder), *filter(None, sys.path)]
        return os.environ | {
            "PYTHONPATH": os.pathsep.join(paths),
            "PYTHONDONTWRITEBYTECODE": "1",
            "NUMBA_DISABLE_JIT": "1",
        }


@contextmanager
def planted(*mutations: Mutation) -> Iterator[Mutant]:
    """Copy our engine, plant bugs in the copy, and remove it at the end; none is a plain copy.

    A package that a bug is planted in is copied beside it.

    Raises
    ------
    MutantError
        Where a mutation doesn't fit.
    """
    with tempfile.TemporaryDirectory(prefix="ghostball-mutant-") as place:
        folder = Path(place).resolve()
        for package in {"engine", *(mutation.package for mutation in mutations)}:
            shutil.copytree(_SOURCES / package, folder / package)
        for mutation in mutations:
            mutation.apply(folder)
        yield Mutant("+".join(mutation.name for mutation in mutations) or "unchanged", folder)
