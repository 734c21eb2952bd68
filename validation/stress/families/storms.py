"""Storms: random breaks over the whole physics of the cloth, of which none may get stuck."""

from __future__ import annotations

from collections.abc import Iterator

from ghostball.validation.stress.judges import Invariants
from ghostball.validation.stress.random_trials import FOREIGN_T_MAX, random_trials
from ghostball.validation.stress.trial import Family, Suite, Trial

MOST = 100_000
"""Events, and contact steps, of a break."""

LOOKS = 200
"""Instants at which each break is looked at."""


def _trials(suite: Suite) -> Iterator[Trial]:
    yield from random_trials(
        "racks",
        Invariants(most_events=MOST, most_steps=MOST, random=True, looks=LOOKS),
        *((250, 2) if suite == "quick" else (500, 100)),
        layout=("rack", "loose-rack"),
        count="many",
        table=("pool", "small"),
        cloth="slows",
        stop="rest",
        speed=("usual", "fast"),
        flight="no",
        along_rail="no",
    )


FAMILY = Family(
    "storms",
    "Random breaks",
    "Whatever the break, the laws and the frictions: it ends by itself within "
    f"{MOST} events and contact steps, energy never rises, and no ball overlaps another or "
    "a cushion: exact motion by no more than rounding and what a sustained contact may be off by, "
    "that of an engine that steps by no more than the law allows its step. Each break is looked "
    f"at at {LOOKS} instants. Other engines than "
    f"ours play {FOREIGN_T_MAX:g} s of one break of each trial.",
    _trials,
)
