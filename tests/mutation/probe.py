"""What runs within a copy of our packages: trials of the stress suite, on what is found there."""

from __future__ import annotations

import importlib
import signal
import sys
from collections.abc import Sequence
from itertools import chain
from multiprocessing.connection import Connection
from pathlib import Path

# Nothing of ours, which is to come from the copy: see `try_all`.

MAX_EVENTS = 20_000
"""Events after which a shot of a copy is given up: a bug may make it continue for ever."""


def try_all(
    folder: str, trials: Sequence[str], processor_limit: float, answers: Connection
) -> None:
    """Send why the packages in a folder can't be imported, "" where they can; then each's faults.

    A trial that takes more time of the processor than the limit [s] ends this process.

    Nothing but the bug makes the harness fail where it doesn't in a copy without one, so that a
    trial that can't judge has a fault too.
    """
    sys.path.insert(0, folder)
    try:
        check_copies(Path(folder))
        from ghostball.validation.stress.families import FAMILIES
        from ghostball.validation.stress.run import StressTask, run_trial
    except Exception as error:
        answers.send(f"{type(error).__name__}: {error}")
        return
    answers.send("")
    for path in trials:
        family, _, name = path.partition("/")
        suites = chain.from_iterable(map(FAMILIES[family].trials, ("quick", "full")))
        trial = next(one for one in suites if one.name == name)
        signal.setitimer(signal.ITIMER_PROF, processor_limit)
        found = run_trial(StressTask(family, trial, f"ghostball:max_events={MAX_EVENTS}"))
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        answers.send(found.faults if found.outcome in ("broken", "failed") else ())


def check_copies(folder: Path) -> None:
    """Make sure that each package in a folder is the one that is imported.

    Raises
    ------
    ImportError
        Where another one is: it would be taken for the copy.
    """
    for package in folder.glob("ghostball/*/__init__.py"):
        found = importlib.import_module(f"ghostball.{package.parent.name}").__file__
        if found is None or not Path(found).samefile(package):
            raise ImportError(f"not the copy: {found}")
