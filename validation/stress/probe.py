"""What runs within a mutant: the small trials of the stress suite, on the engine found there.

    python -m validation.stress.probe FOLDER [PATTERN ...]

Not for people: `self_test` starts it, in FOLDER, which holds the mutant's package `engine`. It
prints a line of JSON for each trial when it begins and when it ends, and ends after the last one,
or when its input is closed: so no process outlives who started it.
"""

from __future__ import annotations

import json
import os
import signal
import sys
from collections.abc import Iterator, Sequence
from itertools import chain, zip_longest
from pathlib import Path
from typing import Any

from validation.leash import end_with_input
from validation.mutants import MAX_EVENTS, check_copies
from validation.stress.run import StressTask, run_trial
from validation.stress.selection import chosen_trials
from validation.stress.trial import Suite, Trial

SUITE: Suite = "quick"

LABEL = f"ghostball:max_events={MAX_EVENTS}"
"""Our engine; a bug may make a shot go on for ever."""

PROCESSOR_LIMIT = 10.0
"""Processor time [s] after which a trial is ended: ten times that of the dearest without a bug."""


def small_trials(patterns: Sequence[str] = ()) -> list[tuple[str, Trial]]:
    """Return the small trials of the quick suite, each with its family.

    One of each family, then the next of each, so that whatever a family is about is soon tried.

    Parameters
    ----------
    patterns : sequence of str
        Families, or trials as `FAMILY/TRIAL`; all where it is empty.

    Raises
    ------
    StressError
        Where one of them is the name of nothing.
    """
    families: dict[str, list[tuple[str, Trial]]] = {}
    for family, trial in chosen_trials(SUITE, patterns):
        if trial.small:
            families.setdefault(family.name, []).append((family.name, trial))
    in_turn = chain.from_iterable(zip_longest(*families.values()))
    return [one for one in in_turn if one is not None]


def lines(patterns: Sequence[str]) -> Iterator[dict[str, Any]]:
    """Yield what is printed: what is tried next, and what became of it."""
    for family, trial in small_trials(patterns):
        yield {"tries": f"{family}/{trial.name}"}
        found = run_trial(StressTask(family, trial, LABEL))
        yield {"tried": f"{family}/{trial.name}", "outcome": found.outcome, "faults": found.faults}


def main() -> None:
    """Try everything."""
    folder, *patterns = sys.argv[1:]
    check_copies(Path(folder))
    end_with_input()
    # What a trial or a library prints goes with the messages, not among the lines.
    with os.fdopen(os.dup(1), "w", encoding="utf-8") as out:
        os.dup2(2, 1)
        for line in lines(patterns):
            print(json.dumps(line), file=out, flush=True)
            if hasattr(signal, "setitimer"):  # else the clock of who started this process ends it
                signal.setitimer(signal.ITIMER_PROF, PROCESSOR_LIMIT)


if __name__ == "__main__":
    main()
