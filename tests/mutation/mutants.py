"""Copies of our packages with a bug planted in them, and what shots find there.

    >>> with planted(mutation) as folder:
    ...     faults_on(folder, ["shipped/stop"])

The package `engine`, and the one that a bug is planted in where that is another, are copied into a
temporary folder, and one text of one file is replaced. Shots and tests run there in a process of
their own, with interpreted kernels: the caller's engine, the checkout and the kernels on the disk
stay as they are. That process is forked from one that has imported packages of others, but nothing
of ours.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from multiprocessing import forkserver
from multiprocessing.context import ForkServerContext
from pathlib import Path
from unittest.mock import patch

from copies import copy_packages
from probe import run_tests_into, try_all

START_LIMIT = 120.0
"""How long the process of a copy may take to start [s]: minutes pass on a busy machine."""

TIME_LIMIT = 600.0
"""How long a shot may take [s], where it doesn't use the processor."""

PROCESSOR_LIMIT = 10.0
"""Processor time [s] after which a shot is ended: four times that of the dearest without a bug."""

OF_OTHERS = (
    *("numba", "pydantic", "mpmath", "flint", "filelock", "lazy_loader", "typer.testing"),
    *("pytest", "hypothesis", "hypothesis.strategies", "hypothesis.extra.numpy"),
)
"""What takes longest to import of all that our packages and tests need."""


class MutantError(Exception):
    """A mutation that doesn't fit its package, or a copy that can't be imported."""


@dataclass(frozen=True)
class Mutation:
    """One bug.

    Attributes
    ----------
    name : str
    file : str
        With its package, the engine or what it is judged by: "engine/motion/next_piece.py".
    old, new : str
        What is replaced, exactly one occurrence, and by what.
    what : str
        What is wrong then, one sentence.
    caught_by : str
        The shot, as FAMILY/SHOT for `ghostball stress` or shipped/SCENE, or the fast test that
        sees it.
    """

    name: str
    file: str
    old: str
    new: str
    what: str
    caught_by: str

    @property
    def package(self) -> str:
        """The one that it is planted in."""
        return self.file.partition("/")[0]

    def apply(self, folder: Path) -> None:
        """Plant the bug in the copy of its package in a folder.

        Raises
        ------
        MutantError
            Where the text isn't there exactly once, or is replaced by itself.
        """
        path = folder / "ghostball" / self.file
        try:
            text = path.read_text(encoding="utf-8")
        except OSError as error:
            raise MutantError(
                f'mutation "{self.name}": `file` must be one of our packages, got {self.file!r}: '
                f"{error.strerror}. Adapt the mutation"
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


@contextmanager
def planted(*mutations: Mutation) -> Iterator[Path]:
    """Copy our engine, plant bugs in the copy, and remove it at the end; none is a plain copy.

    A package that a bug is planted in is copied beside it.

    Raises
    ------
    MutantError
        Where a mutation doesn't fit.
    """
    with tempfile.TemporaryDirectory(prefix="ghostball-mutant-") as place:
        folder = Path(place).resolve()
        copy_packages(folder, "engine", *(mutation.package for mutation in mutations))
        for mutation in mutations:
            mutation.apply(folder)
        yield folder


def faults_on(
    folder: Path,
    shots: Sequence[str],
    *,
    time_limit: float = TIME_LIMIT,
    processor_limit: float = PROCESSOR_LIMIT,
) -> dict[str, tuple[str, ...]]:
    """Try the packages in a folder; return what each shot finds wrong, up to one that ends it.

    Parameters
    ----------
    folder : Path
    shots : sequence of str
        As FAMILY/SHOT or shipped/SCENE.
    time_limit, processor_limit : float [s]
        For each of them; the start of the process doesn't count.

    Raises
    ------
    MutantError
        Where the packages can't be imported.
    """
    found: dict[str, tuple[str, ...]] = {}
    context = server()
    answers, theirs = context.Pipe(duplex=False)
    args = (str(folder), shots, processor_limit, theirs)
    process = context.Process(target=try_all, args=args, daemon=True)
    process.start()
    theirs.close()
    try:
        if not answers.poll(START_LIMIT):
            raise MutantError(f"the copy must start in {START_LIMIT:g} s")
        wrong = answers.recv()
        if wrong:
            raise MutantError(
                f"the copy can't be imported: {wrong}. Mend the mutation: it should play shots "
                "wrongly, not break a module"
            )
        for shot in shots:
            if not answers.poll(time_limit):
                return found | {shot: (f"no answer in {time_limit:g} s",)}
            found[shot] = answers.recv()
    except EOFError:
        process.join()
        if process.exitcode == -signal.SIGPROF:
            how = f"no end in {processor_limit:g} s of processor time"
        else:
            how = f"exit code {process.exitcode}"
        return found | {shots[len(found)]: (how,)}
    finally:
        process.kill()
        process.join()
        answers.close()
    return found


def outcome_of_interpreted_tests(
    folder: Path, root: Path, tests: Sequence[str]
) -> tuple[int | None, str]:
    """Run tests of the checkout `root` on the packages in a folder; return status and output."""
    output = folder / "output.txt"
    process = server().Process(
        target=run_tests_into, args=(str(output), str(folder), str(root), tests)
    )
    process.start()
    process.join()
    return process.exitcode, output.read_text("utf-8")


@cache
def server() -> ForkServerContext:
    """Return what starts processes that need not import what others wrote again."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(list(OF_OTHERS))
    # Numpy with one thread: more of them would not live on in a fork.
    with patch.dict(os.environ, NUMBA_DISABLE_JIT="1", OPENBLAS_NUM_THREADS="1"):
        forkserver.ensure_running()
    return context
