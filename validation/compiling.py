"""Compiles the kernels of our engine before many scenes are run: side by side, each variant once.

Without this each process that runs scenes would compile for itself what another compiles too.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable
from contextlib import closing

from engine import GhostballError, Scene
from engine.kernels import Variants, variants_of
from validation.worker import run_tasks

_LOGGER = logging.getLogger("ghostball.validation")


def compile_kernels(scenes: Iterable[Scene], jobs: int, *, tangents: bool = False) -> None:
    """Compile in `jobs` processes what `scenes` need of the kernels, then load it into this one.

    Parameters
    ----------
    scenes : iterable of Scene
    jobs : int
    tangents : bool
        Whether their tangent maps will be asked for too.

    Raises
    ------
    GhostballError
        Where a process that compiles dies.
    """
    needed = variants_of(scenes, tangents=tangents)
    missing = [variants for variants in needed if not variants.is_compiled]
    if jobs > 1 and len(missing) > 1:
        names = "; ".join(variants.name for variants in missing)
        _LOGGER.warning(
            "compiling the engine's kernels for this machine, once, in %d processes: %s. "
            "This takes about half a minute ...",
            min(jobs, len(missing)),
            names,
        )
        # What is needed by most scenes comes first: it is what takes longest.
        missing.sort(key=lambda variants: -len(variants.scenes))
        with closing(run_tasks(missing, jobs, _compile, _died)) as finished:
            for failure in finished:
                if failure:
                    raise GhostballError(failure)
    for variants in needed:
        variants.compile()


def _compile(variants: Variants) -> str:
    logging.getLogger("ghostball.engine").setLevel(logging.ERROR)  # the parent has announced it
    variants.compile()
    return ""


def _died(variants: Variants, reason: str) -> str:
    return f"the kernels could not be compiled ({variants.name}): {reason}"
