"""Compiles kernels of our engine before many scenes are run: side by side, each variant once."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable
from contextlib import closing
from functools import partial

from ghostball.engine.compilation import Variants, variants_of
from ghostball.model import GhostballError, Scene
from ghostball.reference_adapters.stepping.kernels import AdapterKernels, adapter_kernels
from ghostball.validation.parallel.pool import Progress, run_tasks

_LOGGER = logging.getLogger("ghostball.validation")

_Kernels = Variants | AdapterKernels


def compile_kernels(
    scenes: Iterable[Scene],
    jobs: int,
    *,
    labels: Iterable[str] = (),
    tangents: bool = False,
    contacts_from: int = 2,
    compiling: Progress[str] | None = None,
) -> Callable[[], None]:
    """Compile in `jobs` processes what `scenes` need of kernels, then load ours into this one.

    Parameters
    ----------
    labels : iterable of str
        Engines that are run, whose adapters may have kernels too.
    tangents, contacts_from
        See `engine.compilation.variants_of`.
    compiling : callable, optional
        Called with how many variants are compiled, of how many, and the last one; first before the
        first of them. Left out, a log says it.

    Returns
    -------
    callable
        Compiles the same on another machine, where it isn't yet; it can be pickled.

    Raises
    ------
    GhostballError
        Where a process that compiles dies.
    """
    ours = variants_of(scenes, tangents=tangents, contacts_from=contacts_from)
    needed: list[_Kernels] = [*ours, *adapter_kernels(labels)]
    # Those with contacts take longest, so they come first.
    missing = sorted(
        (variants for variants in needed if not variants.are_compiled),
        key=lambda variants: not variants.contacts,
    )
    if missing:
        count = _log if compiling is None else compiling
        total, done = sum(len(variants.names) for variants in missing), 0
        count(done, total, "")
        with closing(run_tasks(missing, jobs, _compile)) as finished:
            for one in finished:
                names = one.task.names
                if one.crashed:
                    raise GhostballError(
                        f"the kernels ({', '.join(names)}) could not be compiled: {one.crashed}"
                    )
                done += len(names)
                count(done, total, "; ".join(names))
    for variants in ours:
        variants.compile()
    return partial(_compile_missing, needed)


def _log(done: int, total: int, last: str) -> None:
    what = f", last {last}" if last else " of the engine's kernels, for this machine, once"
    _LOGGER.warning("compiling: %d of %d are done%s", done, total, what)


def _compile_missing(needed: Iterable[_Kernels]) -> None:
    for variants in needed:
        if not variants.are_compiled:
            _compile(variants)


def _compile(variants: _Kernels) -> None:
    logger = logging.getLogger("ghostball.engine")
    level = logger.level
    logger.setLevel(logging.ERROR)  # it was announced by the caller
    try:
        variants.compile()
    finally:
        logger.setLevel(level)
