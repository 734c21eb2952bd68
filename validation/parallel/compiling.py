"""Compile kernels of Ghostball's engine before many scenes are run, each variant once."""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import partial

from ghostball.engine.library.entry import Needed, make_all
from ghostball.engine.needed_kernels import kernels_of
from ghostball.model import Scene
from ghostball.reference_adapters.stepping.kernels import adapter_kernels
from ghostball.validation.parallel.pool import Progress

_LOGGER = logging.getLogger("ghostball.validation")


def needed_kernels(scenes: Iterable[Scene], labels: Iterable[str] = ()) -> list[Needed]:
    """Return the kernels that `scenes` and the adapters of some engines need."""
    return kernels_of(scenes) + adapter_kernels(labels)


def compile_kernels(
    scenes: Iterable[Scene],
    jobs: int,
    *,
    labels: Iterable[str] = (),
    compiling: Progress[str] | None = None,
) -> Callable[[], None]:
    """Compile the kernels that `scenes` need in `jobs` processes.

    `labels`: engines that will run; their adapters may have kernels too.
    `compiling`: called with the number of compiled variants, the number of all, and the last one;
        called once before the first. Default: write to the log.

    Returns a function that loads the same kernels, compiling the missing ones; it can be pickled
    for another machine.

    Raises `GhostballError` if a kernel can't be compiled.
    """
    needed = needed_kernels(scenes, labels)
    missing = [one for one in needed if not one.is_made]
    if missing:
        count = _log if compiling is None else compiling
        done = Counter[str]()
        count(0, len(missing), "")

        def finished(name: str) -> None:
            done[name] += 1
            count(done.total(), len(missing), name)

        make_all(missing, jobs, finished)
    return partial(_load_all, needed)


def _load_all(needed: Iterable[Needed]) -> None:
    with _quiet():
        for one in needed:
            one.load()


def _log(done: int, total: int, last: str) -> None:
    what = f", last {last}" if last else " of the engine's kernels, for this machine, once"
    _LOGGER.warning("compiling: %d of %d are done%s", done, total, what)


@contextmanager
def _quiet() -> Iterator[None]:
    """Suppress the log message of each kernel: the caller has announced them all."""
    logger = logging.getLogger("ghostball.engine")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        yield
    finally:
        logger.setLevel(level)
