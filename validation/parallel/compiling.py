"""Compiles kernels of our engine before many scenes are run: side by side, each variant once."""

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


def compile_kernels(
    scenes: Iterable[Scene],
    jobs: int,
    *,
    labels: Iterable[str] = (),
    compiling: Progress[str] | None = None,
) -> Callable[[], None]:
    """Compile in `jobs` processes what `scenes` need of kernels.

    `labels`: engines that are run, whose adapters may have kernels too.
    `compiling`: called with how many variants are compiled, of how many, and the last one; first
        before the first of them. Left out, a log says it.

    Returns loads the same on another machine, made where it isn't yet; it can be pickled.

    Raises `GhostballError` where one can't be compiled.
    """
    needed = kernels_of(scenes)
    needed += adapter_kernels(labels)
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
    """Say nothing of each kernel that is compiled: the caller has announced all."""
    logger = logging.getLogger("ghostball.engine")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        yield
    finally:
        logger.setLevel(level)
