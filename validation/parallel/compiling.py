"""Compiles kernels of our engine before many scenes are run: side by side, each variant once."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable
from contextlib import closing
from functools import partial

from ghostball.engine import GhostballError, Scene
from ghostball.engine.compilation import Variants, variants_of
from ghostball.validation.parallel.pool import run_tasks

_LOGGER = logging.getLogger("ghostball.validation")


def compile_kernels(
    scenes: Iterable[Scene], jobs: int, *, tangents: bool = False, contacts_from: int = 2
) -> Callable[[], None]:
    """Compile in `jobs` processes what `scenes` need of the kernels, then load it into this one.

    Parameters
    ----------
    scenes : iterable of Scene
    jobs : int
    tangents, contacts_from
        See `engine.compilation.variants_of`.

    Returns
    -------
    callable
        Compiles the same on another machine, where it isn't yet; it can be pickled.

    Raises
    ------
    GhostballError
        Where a process that compiles dies.
    """
    needed = variants_of(scenes, tangents=tangents, contacts_from=contacts_from)
    # Those with contacts take longest, so they come first.
    missing = sorted(
        (variants for variants in needed if not variants.are_compiled),
        key=lambda variants: not variants.contacts,
    )
    if jobs > 1 and len(missing) > 1:
        _LOGGER.warning(
            "compiling the engine's kernels for this machine, once, in %d processes, 10 to 30 s "
            "each: %s ...",
            min(jobs, len(missing)),
            "; ".join(name for variants in missing for name in variants.names),
        )
        total, done = sum(len(variants.names) for variants in missing), 0
        with closing(run_tasks(missing, jobs, _compile, _died)) as finished:
            for variants, failure in finished:
                if failure:
                    raise GhostballError(failure)
                done += len(variants.names)
                _LOGGER.warning("compiling: %d of %d are done", done, total)
    for variants in needed:
        variants.compile()
    return partial(_compile_missing, needed)


def _compile_missing(needed: Iterable[Variants]) -> None:
    for variants in needed:
        if not variants.are_compiled:
            _compile(variants)


def _compile(variants: Variants) -> tuple[Variants, str]:
    logging.getLogger("ghostball.engine").setLevel(logging.ERROR)  # it was announced by the caller
    variants.compile()
    return variants, ""


def _died(variants: Variants, reason: str) -> tuple[Variants, str]:
    return variants, f"the kernels ({', '.join(variants.names)}) could not be compiled: {reason}"
