"""A family of trials: one question, asked over a range."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from ghostball.validation.stress.trial import Suite, Trial


@dataclass(frozen=True)
class Family:
    """A sweep of trials.

    Attributes
    ----------
    name : str
        As on the command line, such as "grazing".
    title : str
        A few words, for tables.
    asks : str
        What an engine must do to survive, a sentence or two.
    trials : callable
        Given the suite, yields the trials; those of "quick" are among those of "full", or are
        smaller ones of the same kind. Made anew at each call, always the same.
    ours_alone : bool
        Whether it is about our engine, and so is tried for our engine alone.
    """

    name: str
    title: str
    asks: str
    trials: Callable[[Suite], Iterable[Trial]]
    ours_alone: bool = False
